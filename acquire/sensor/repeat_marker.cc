#include "acquire/sensor/repeat_marker.h"

#include <algorithm>

namespace haptometer::acquire {
namespace {

bool SameContent(const std::vector<trial::Sample>& a, const std::vector<trial::Sample>& b) {
  return std::ranges::equal(a, b, [](const trial::Sample& x, const trial::Sample& y) {
    return x.raw.bits() == y.raw.bits() && x.status == y.status;
  });
}

}  // namespace

void RepeatMarker::Mark(Reading& reading) {
  const bool is_equal = SameContent(content_, reading.samples);
  if (!is_equal || reading.time_ns - first_seen_ns_ >= refresh_ns_) {
    content_ = reading.samples;
    first_seen_ns_ = reading.time_ns;
    return;
  }
  for (trial::Sample& sample : reading.samples) {
    if (sample.status == trial::SampleStatus::kOk) sample.status = trial::SampleStatus::kRepeated;
  }
}

}  // namespace haptometer::acquire
