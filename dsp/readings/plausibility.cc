#include "dsp/readings/plausibility.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "dsp/readings/row_block.h"
#include "trial/calibration.h"

namespace haptometer::dsp {
namespace {

constexpr std::size_t kLeastToBeStuck = 16;
// rate of new readings over the sensor's own sampling rate above which they contradict each other
constexpr double kRateTolerance = 1.05;
constexpr double kFastestTableHz = 1e6;  // what a table of another program holds at most
constexpr double kShortestTrialS = 0.1;
constexpr double kStatedTolerance = 0.01;
constexpr double kUnitSlip = 100;  // so many times a range is no motion, but another unit

// a time column's unit that would make the rate a usable one; `factor`: printed seconds in it
struct OtherUnit {
  const char* column = "";
  double factor = 1;
};
constexpr std::array<OtherUnit, 3> kOtherUnits{
    {{"time_ms", 1e-3}, {"time_us", 1e-6}, {"time_s", 1e3}}};

// readings farther than any target that is plausible
void RemarkFar(const RawSummary& summary, Findings* findings) {
  const double farthest_m = std::max({-summary.least, summary.most, summary.most - summary.least});
  if (!(farthest_m > kFarthestReadingM)) return;
  findings->Doubt(FindingKind::kFarReadings, {{"farthest_m", farthest_m}});
}

// new readings faster than the sensor samples contradict its metadata
void RemarkSampling(const trial::Metadata& metadata, double fresh_rate_hz, Findings* findings) {
  if (!metadata.sampling_s || !(*metadata.sampling_s > 0)) return;
  if (!(fresh_rate_hz * *metadata.sampling_s > kRateTolerance)) return;
  findings->Doubt(FindingKind::kSamplingContradicted, {{"sampling_s", *metadata.sampling_s},
                                                       {"samples_per_s", 1 / *metadata.sampling_s},
                                                       {"new_readings_per_s", fresh_rate_hz}});
}

// a table without a sensor's name may hold times in another unit than its column states
void RemarkTimes(const trial::Record& head, const ReadingRate& rate, Findings* findings) {
  const bool is_table = head.metadata.source.starts_with("imported") &&
                        head.metadata.sensor.empty() && head.timing == trial::Timing::kUniform;
  // a rate that is stated and agrees with the times is no error of units
  const auto stated_hz = head.metadata.nominal_rate_hz;
  const bool is_stated = stated_hz && std::abs(rate.rate_hz / *stated_hz - 1) < kStatedTolerance;
  const auto is_usable = [&](double rate_hz) {
    return rate_hz >= rate.needed_hz && rate_hz <= kFastestTableHz;
  };
  if (!is_table || is_stated || is_usable(rate.rate_hz)) return;
  // the first unit that makes the rate usable and the trial long enough
  for (const OtherUnit& unit : kOtherUnits) {
    const double rate_hz = rate.rate_hz / unit.factor;
    const double duration_s = rate.duration_s * unit.factor;
    if (!is_usable(rate_hz) || duration_s < kShortestTrialS) continue;
    findings->Doubt(FindingKind::kTimesInOtherUnit, {{"column", std::string(unit.column)},
                                                     {"readings_per_s", rate_hz},
                                                     {"duration_s", duration_s}});
    return;
  }
}

}  // namespace

void RemarkPlausibility(const trial::Record& head, const RawSummary& summary,
                        const ReadingRate& rate, Findings* findings) {
  RemarkFar(summary, findings);
  RemarkSampling(head.metadata, rate.fresh_rate_hz, findings);
  RemarkTimes(head, rate, findings);
}

Result<void> CheckCalibratedRange(const trial::RowSource& source, std::size_t channel,
                                  const RawSummary& summary, Findings* findings) {
  const trial::Record& head = source.head();
  const auto range = trial::CalibratedRangeOf(head.metadata, head.channels[channel].name);
  if (!range) return {};
  const double width = range->most - range->least;
  const double tolerance = kStatedTolerance * width;
  const auto beyond = [&](double value) {
    return std::max(range->least - value, value - range->most);
  };
  const double farthest = std::max(beyond(summary.least), beyond(summary.most));
  if (!(farthest > tolerance)) return {};
  // the whole record is read again only where there is something to count
  std::size_t samples = 0;
  HAPTOMETER_TRY(ForEachValue(source, channel, 0, head.rows,
                              [&](std::size_t, double value, trial::SampleStatus status) {
                                const bool is_beyond = beyond(value) > tolerance;
                                samples += is_beyond && IsMeasured(value, status) ? 1 : 0;
                              }));
  Finding finding{.severity = Severity::kDoubt,
                  .kind = FindingKind::kBeyondCalibrated,
                  .numbers = {{"samples", samples},
                              {"readings", summary.measured},
                              {"beyond_m", farthest},
                              {"least_m", range->least},
                              {"most_m", range->most}}};
  if (farthest > kUnitSlip * width) {
    finding.numbers.emplace_back("widths", std::round(farthest / width));
  }
  findings->Add(std::move(finding));
  return {};
}

void RemarkImplausibleRms(double rms_m, double farthest_m, Findings* findings) {
  if (rms_m > kLargestBandRmsM && farthest_m <= kFarthestReadingM) {
    findings->Doubt(FindingKind::kRmsTooLarge, {{"rms_m", rms_m}});
  } else if (rms_m > 0 && rms_m < kSmallestBandRmsM) {
    findings->Doubt(FindingKind::kRmsTooSmall, {{"rms_m", rms_m}});
  }
}

std::optional<Finding> WhyStuck(const RawSummary& summary) {
  if (summary.measured < kLeastToBeStuck || summary.least != summary.most) return std::nullopt;
  return Finding{.severity = Severity::kRefusal,
                 .kind = FindingKind::kStuck,
                 .numbers = {{"readings", summary.measured}}};
}

}  // namespace haptometer::dsp
