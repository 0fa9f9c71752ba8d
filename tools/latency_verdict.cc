#include "tools/latency_verdict.h"

#include <fmt/core.h>

#include <cmath>

namespace haptometer::tools {
namespace {

constexpr double kLatencyCostsS = 0.025;
constexpr double kLatencyPerceivedS = 0.050;

}  // namespace

std::string_view LatencyVerdict(double latency_s) {
  if (latency_s < kLatencyCostsS) return "below 25 ms, where it begins to cost errors";
  if (latency_s < kLatencyPerceivedS) return "above 25 ms, where it costs errors; below 50 ms";
  return "above 50 ms, where it is perceived";
}

std::string_view LatencyVerdict(const sim::SkinRise& rise) {
  const std::string_view verdict = LatencyVerdict(rise.LatencyAtMostS());
  if (verdict == LatencyVerdict(rise.latency_s - rise.uncertainty_s)) return verdict;
  return "too uncertain to be held against 25 and 50 ms";
}

std::optional<double> LatencyBelowS(const sim::SkinRise& rise) {
  return rise.TellsLatency() ? std::nullopt : std::optional(rise.LatencyAtMostS());
}

std::string LatencyText(const sim::SkinRise& rise) {
  if (const auto below_s = LatencyBelowS(rise)) {
    return fmt::format("below {:.3f} ms", std::ceil(*below_s * 1e6) / 1e3);
  }
  return fmt::format("{:.3f} ms, to {:.2g} ms", rise.latency_s * 1e3, rise.uncertainty_s * 1e3);
}

}  // namespace haptometer::tools
