// progress.cpp — the progress line and the signals.
// SPDX-License-Identifier: Apache-2.0
#include "cli/progress.h"

#include <unistd.h>

#include <csignal>
#include <cstdio>

namespace malus::cli {
namespace {

// Signal handlers can only reach what is global; nothing else in malus is.
std::atomic<bool> stop_wanted{false};
static_assert(std::atomic<bool>::is_always_lock_free);

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
    action.sa_handler = [](int) { stop_wanted = true; };
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

}  // namespace malus::cli
