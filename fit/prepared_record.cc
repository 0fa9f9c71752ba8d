#include "fit/prepared_record.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "fit/clipping.h"

namespace haptometer::fit {
namespace {

constexpr std::ptrdiff_t kLeastSamples = 32;

double PeriodSamples(const ImpulseRecord& record, const RingStart& start) {
  return 2 * std::numbers::pi / (std::sqrt(start.poles.stiffness_per_s2) * record.step_s);
}

// start values on the part alone, which begins with a blow of its own
Result<RingStart> StartOfPart(const ImpulseRecord& record, const Disturbances& part) {
  ImpulseRecord alone = record;
  const auto begin = record.voltage_v.begin();
  alone.voltage_v.assign(begin + static_cast<std::ptrdiff_t>(part.first_sample),
                         begin + static_cast<std::ptrdiff_t>(part.end_sample));
  alone.start_s = record.start_s + static_cast<double>(part.first_sample) * record.step_s;
  auto start = FindRingStart(alone);
  if (start) start->first_sample += part.first_sample;
  return start;
}

}  // namespace

Result<PreparedRecord> PrepareRecord(const ImpulseRecord& record) {
  auto start = FindRingStart(record);
  if (!start) return std::unexpected(start.error());
  PreparedRecord prepared{record, *start, {}};
  const std::size_t clipped = MaskRails(prepared.record.voltage_v, PeriodSamples(record, *start));
  if (clipped > 0) {
    start = FindRingStart(prepared.record);
    if (!start) return std::unexpected(start.error());
    prepared.start = *start;
  }
  prepared.part = FindDisturbances(prepared.record, prepared.start);
  if (clipped > 0) {
    prepared.part.found.insert(
        prepared.part.found.begin(),
        fmt::format("clipped: {} samples at the recorder's limits are left out", clipped));
  }
  const auto begin = prepared.record.voltage_v.begin();
  const auto measured =
      std::count_if(begin + static_cast<std::ptrdiff_t>(prepared.part.first_sample),
                    begin + static_cast<std::ptrdiff_t>(prepared.part.end_sample),
                    [](double v) { return std::isfinite(v); });
  if (measured < kLeastSamples) {
    return CannotAnswer(record.name,
                        fmt::format("holds only {} samples that a fit can use", measured),
                        "record three decay times of one free ring-down");
  }
  if (!prepared.part.follows_a_later_blow) return prepared;

  start = StartOfPart(prepared.record, prepared.part);
  if (!start) return std::unexpected(start.error());
  start->quiet_noise_v = prepared.start.quiet_noise_v;
  start->quiet_samples = prepared.start.quiet_samples;
  prepared.start = *start;
  prepared.part.first_sample = start->first_sample;
  if (prepared.record.drop_height_m) {
    prepared.record.drop_height_m.reset();
    prepared.part.found.emplace_back("the drop height is that of the first blow: not used");
  }
  return prepared;
}

}  // namespace haptometer::fit
