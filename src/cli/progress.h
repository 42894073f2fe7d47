// progress.h — a line of progress on a terminal, and Ctrl-C as a wish to stop.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <string>

namespace malus::cli {

/// "rendering  43 %  12 s left" on stderr, redrawn a few times a second; silent when stderr is no
/// terminal or `quiet` is set. The line is wiped at the end.
class Progress {
  public:
    Progress(std::string what, bool quiet);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    void update(double done);

  private:
    using Clock = std::chrono::steady_clock;
    std::string what_;
    bool shown_;
    Clock::time_point start_ = Clock::now(), last_;
};

/// Set by SIGINT and SIGTERM after catch_interrupts(); one more, some two seconds later, ends
/// the process.
const std::atomic<bool>& interrupted();
void catch_interrupts();

}  // namespace malus::cli
