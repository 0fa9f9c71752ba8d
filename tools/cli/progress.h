#pragma once

#include <cstdint>
#include <string>
#include <string_view>

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

}  // namespace haptometer::cli
