#pragma once

namespace haptometer::dsp {

/// From `begin_s` up to and without `end_s`, on the record's time base.
struct TimeWindow {
  double begin_s = 0;
  double end_s = 0;

  [[nodiscard]] double duration_s() const { return end_s - begin_s; }
};

}  // namespace haptometer::dsp
