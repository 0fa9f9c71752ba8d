#include "fit/thinned_record.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "fit/clipping.h"

namespace haptometer::fit {
namespace {

constexpr std::size_t kMostSamples = 100'000;
constexpr double kBlocksPerPeriod = 1000;

}  // namespace

std::optional<ThinnedRecord> Thinned(const ImpulseRecord& record, const PolePair& poles) {
  const double period = 2 * std::numbers::pi / (std::sqrt(poles.stiffness_per_s2) * record.step_s);
  const auto block = static_cast<std::size_t>(period / kBlocksPerPeriod);
  if (record.voltage_v.size() <= kMostSamples || block < 2) return std::nullopt;
  auto values = record.voltage_v;
  ThinnedRecord thinned{record, block, MaskRails(values, period)};
  thinned.record.start_s += 0.5 * static_cast<double>(block - 1) * record.step_s;
  thinned.record.step_s *= static_cast<double>(block);
  thinned.record.voltage_v.clear();
  thinned.record.voltage_v.reserve(values.size() / block);
  for (std::size_t first = 0; first + block <= values.size(); first += block) {
    double sum = 0;
    for (std::size_t n = first; n < first + block; ++n) sum += values[n];
    thinned.record.voltage_v.push_back(sum / static_cast<double>(block));
  }
  return thinned;
}

}  // namespace haptometer::fit
