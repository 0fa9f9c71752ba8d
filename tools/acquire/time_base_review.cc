#include "tools/acquire/time_base_review.h"

#include <fmt/core.h>

#include <algorithm>

#include "acquire/sensor/stream_sensor.h"
#include "trial/trial_reader.h"

namespace haptometer::tools {
namespace {

constexpr std::uint64_t kMostRows = 1'000'000;

}  // namespace

std::optional<TimeBaseReview> ReviewTimeBase(const std::string& file, trial::Timing timing,
                                             const acquire::RecordingSummary& summary) {
  if (file.empty() || timing != trial::Timing::kArrival) return std::nullopt;
  if (summary.readings == 0 || summary.readings > kMostRows) return std::nullopt;
  const auto recording = trial::ReadRecord(file);
  if (!recording || recording->record.stretches.empty()) return std::nullopt;
  TimeBaseReview review;
  review.gaps = recording->record.stretches.size() - 1;
  for (const trial::Stretch& stretch : recording->record.stretches) {
    review.uncertainty_s = std::max(review.uncertainty_s, stretch.time_uncertainty_s);
  }
  return review;
}

std::string TimeBaseRemark(const TimeBaseReview& review, const trial::Metadata& metadata) {
  std::string remark =
      fmt::format("times are straightened, true to {:.2g} ms", review.uncertainty_s * 1e3);
  const auto latency = metadata.fields.find(std::string(acquire::kLatencyField));
  if (latency != metadata.fields.end()) {
    remark +=
        fmt::format("; all are late by one unknown latency of at least {} s", latency->second);
  }
  return remark;
}

}  // namespace haptometer::tools
