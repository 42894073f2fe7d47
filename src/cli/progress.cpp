// progress.cpp — the progress line and the signals.
// SPDX-License-Identifier: Apache-2.0
#include "cli/progress.h"

#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <ctime>

namespace malus::cli {
namespace {

// Signal handlers can only reach what is global; nothing else in malus is.
std::atomic<bool> stop_wanted{false};
std::atomic<std::time_t> stop_wanted_at{0};
static_assert(std::atomic<bool>::is_always_lock_free);
static_assert(std::atomic<std::time_t>::is_always_lock_free);

// The first signal asks for an end in good order; one more, some two seconds later, ends the
// process. (Programs like timeout send one signal twice in a row.)
void on_signal(int signal) {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    if (!stop_wanted.exchange(true)) {
        stop_wanted_at = now.tv_sec;
    } else if (now.tv_sec - stop_wanted_at > 1) {
        std::signal(signal, SIG_DFL);
        std::raise(signal);
    }
}

}  // namespace

Progress::Progress(std::string what, bool quiet)
    : what_(std::move(what)), shown_(!quiet && ::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
    if (shown_) std::fputs("\r\033[K", stderr);
}

void Progress::update(double done) {
    const auto now = Clock::now();
    if (!shown_ || now - last_ < std::chrono::milliseconds(200)) return;
    last_ = now;
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    const double left = done > 0 ? elapsed * (1 - done) / done : 0;
    const bool minutes = left >= 90;
    std::fprintf(stderr, "\r%s %3.0f %%  %.0f %s left\033[K", what_.c_str(), 100 * done,
                 minutes ? left / 60 : left, minutes ? "min" : "s");
    std::fflush(stderr);
}

const std::atomic<bool>& interrupted() {
    return stop_wanted;
}

void catch_interrupts() {
    struct sigaction action = {};
    action.sa_handler = on_signal;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

}  // namespace malus::cli
