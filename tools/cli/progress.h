#pragma once

#include <array>
#include <condition_variable>
#include <csignal>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "base/clock.h"

namespace haptometer::cli {

/// A bar on stderr for work that takes its time: nothing where stderr is no terminal, nothing
/// before the work has taken a second, one line that is written over ten times a second and wiped
/// at the end.
class Progress {
 public:
  /// `what` is said before the bar: "trial.bin".
  explicit Progress(std::string_view what);
  /// Wipes the line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `share` of the work is done, 0 to 1. Cost: a look at the clock.
  void Update(double share);

 private:
  std::string what_;
  SystemClock clock_;
  MonotonicNs begun_ns_;
  MonotonicNs shown_ns_ = 0;
  bool on_terminal_;
  bool shown_ = false;
};

/// "trial.bin  [##########----------]  50 %, 12 s left": `elapsed_s` tells what is left.
[[nodiscard]] std::string ProgressBar(std::string_view what, double share, double elapsed_s);

/// Seconds that an item of long work takes, by a first, a middle and a last one of those from
/// `first` to `items`, or fewer where these take a second together; 0 of none. `make` computes an
/// item and forgets it.
[[nodiscard]] double SecondsPerItem(std::uint64_t first, std::uint64_t items,
                                    const std::function<void(std::uint64_t)>& make);

/// What long work says on stderr, from two seconds after its begin on: what is being done, how much
/// of the most work that is tried is done, for how long it has gone on and will, how to end it. On
/// a terminal one line that is written over and wiped at the end, else a line every ten seconds.
///
/// While this object lives Ctrl-C ends the program with status 130 at once, SIGTERM with 143.
/// Within another program (tools/cli/terminal.h) it says nothing and takes no signal.
class WorkProgress {
 public:
  /// `verb` and `advice` are said with it: "simulate", "a shorter --duration takes less".
  WorkProgress(std::string_view verb, std::string advice);
  ~WorkProgress();
  WorkProgress(const WorkProgress&) = delete;
  WorkProgress& operator=(const WorkProgress&) = delete;

  /// Cost: a lock that is hardly ever waited for. Throws Interruption where the verb runs within
  /// another program and is interrupted.
  void Update(std::string_view what, double share);

 private:
  void Say(double elapsed_s);

  std::string_view verb_;
  std::string advice_;
  SystemClock clock_;
  MonotonicNs begun_ns_;
  bool on_terminal_;
  std::array<struct sigaction, 2> before_{};  // what SIGINT and SIGTERM did
  bool shown_ = false;
  std::mutex mutex_;
  std::string what_ = "working";
  double share_ = 0;
  std::condition_variable changed_;
  bool done_ = false;
  std::thread telling_;
};

/// "simulate: playing the run: 37 % of the most work that is tried, 12 s, 21 s left; Ctrl-C ends
/// it"; what is left at the rate so far, from a hundredth of the work on.
[[nodiscard]] std::string WorkLine(std::string_view verb, std::string_view what, double share,
                                   double elapsed_s);

}  // namespace haptometer::cli
