#pragma once

#include <vector>

#include "trial/record.h"

namespace haptometer::trial {

/// Puts the times of a file's segments one behind the other.
class SegmentedTimes {
 public:
  /// Takes the next segment: `part` with stretches and raw times (or none) of its own rows from 0,
  /// all later by `shift_s`. False, and nothing is taken: it does not begin behind the one before.
  [[nodiscard]] bool Append(const Record& part, double shift_s);

  /// Whether a segment that begins at `start_s` lies behind what was taken.
  [[nodiscard]] bool IsBehind(double start_s) const;

  /// Sets the stretches of `record`; its raw times and timing too where a segment had raw times.
  void Complete(Record* record) &&;

 private:
  std::vector<Stretch> stretches_{};
  std::vector<double> raw_times_s_{};
  bool has_raw_ = false;
};

}  // namespace haptometer::trial
