#include "sim/sweep/sweep_points.h"

#include <limits>
#include <utility>

#include "base/error.h"

namespace haptometer::sim {

SweepPoints::SweepPoints(std::vector<SweepAxis> axes, const std::optional<LatinHypercube>& sampling)
    : axes_(std::move(axes)), sampling_(sampling) {
  HAPTOMETER_CHECK(!axes_.empty(), "a sweep without axes");
  for (const SweepAxis& axis : axes_) {
    const bool is_range = std::holds_alternative<SweepRange>(axis.values);
    const std::size_t count = CountOf(axis);
    HAPTOMETER_CHECK(is_range && sampling ? count == 0 : count > 0, "{}: {} values", axis.key,
                     count);
    if (sampling) continue;
    constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
    size_ = size_ > kMost / count ? kMost : size_ * count;
  }
  if (sampling) size_ = sampling->samples;
}

SweepValue SweepPoints::SampledValue(std::size_t axis, std::uint64_t point) const {
  const auto number = static_cast<std::uint32_t>(axis);
  const std::uint64_t part = sampling_->PartOf(number, point);
  const auto* range = std::get_if<SweepRange>(&axes_[axis].values);
  if (range == nullptr) {
    return ValueOf(axes_[axis], part * CountOf(axes_[axis]) / sampling_->samples);
  }
  const double place = static_cast<double>(part) + sampling_->PlaceInPart(number, point);
  return NumberValue(ValueAt(*range, place, static_cast<double>(sampling_->samples)));
}

std::vector<SweepValue> SweepPoints::At(std::uint64_t point) const {
  HAPTOMETER_CHECK(point < size_, "point {} of {}", point, size_);
  std::vector<SweepValue> values(axes_.size());
  std::uint64_t rest = point;
  for (std::size_t axis = axes_.size(); axis-- > 0;) {
    if (sampling_) {
      values[axis] = SampledValue(axis, point);
      continue;
    }
    const std::uint64_t count = CountOf(axes_[axis]);
    values[axis] = ValueOf(axes_[axis], rest % count);
    rest /= count;
  }
  return values;
}

}  // namespace haptometer::sim
