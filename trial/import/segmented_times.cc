#include "trial/import/segmented_times.h"

#include <utility>

namespace haptometer::trial {

bool SegmentedTimes::IsBehind(double start_s) const {
  if (stretches_.empty()) return true;
  const Stretch& last = stretches_.back();
  return start_s > last.start_s + static_cast<double>(last.rows - 1) / last.rate_hz;
}

bool SegmentedTimes::Append(const Record& part, double shift_s) {
  if (!IsBehind(part.stretches.front().start_s + shift_s)) return false;
  const std::size_t before =
      stretches_.empty() ? 0 : stretches_.back().first_row + stretches_.back().rows;
  // raw times for all rows or for none: a grid's rows are where the grid says
  if (!part.raw_times_s.empty() && !has_raw_) {
    has_raw_ = true;
    Record taken;
    taken.rows = before;
    taken.stretches = stretches_;
    raw_times_s_.reserve(before + part.rows);
    for (std::size_t row = 0; row < before; ++row) raw_times_s_.push_back(TimeOf(taken, row));
  }
  if (has_raw_) {
    raw_times_s_.reserve(before + part.rows);
    for (std::size_t row = 0; row < part.rows; ++row) {
      raw_times_s_.push_back(
          shift_s + (part.raw_times_s.empty() ? TimeOf(part, row) : part.raw_times_s[row]));
    }
  }
  stretches_.reserve(stretches_.size() + part.stretches.size());
  for (Stretch stretch : part.stretches) {
    stretch.first_row += before;
    stretch.start_s += shift_s;
    stretches_.push_back(stretch);
  }
  return true;
}

void SegmentedTimes::Complete(Record* record) && {
  record->stretches = std::move(stretches_);
  if (!has_raw_) return;
  record->timing = Timing::kPolled;
  record->times_are_known = true;
  record->raw_times_s = std::move(raw_times_s_);
}

}  // namespace haptometer::trial
