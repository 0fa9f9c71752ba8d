#include "tools/latency_verdict.h"

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

}  // namespace haptometer::tools
