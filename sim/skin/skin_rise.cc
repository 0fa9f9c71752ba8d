#include "sim/skin/skin_rise.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "base/error.h"
#include "dsp/spectrum/envelope.h"

namespace haptometer::sim {
namespace {
constexpr double kQuietPeriods = 6;  // of rest put before the motion
// last periods of the motion that give the steady amplitude
constexpr double kSteadyPeriods = 10;
}  // namespace

bool LastsForARise(const SteadyPart& part, double tone_hz) {
  return (part.end_s - part.begin_s) * tone_hz >= kLeastRisePeriods * (1 - 1e-9);
}

std::optional<SkinRise> RiseOf(std::span<const double> skin_m, double rate_hz, double tone_hz,
                               const SteadyPart& part) {
  HAPTOMETER_CHECK(LastsForARise(part, tone_hz), "a steady part of {} s at {} Hz",
                   part.end_s - part.begin_s, tone_hz);
  // rest before the motion, so that the envelope's support lies in it
  const auto quiet = static_cast<std::size_t>(std::ceil(kQuietPeriods / tone_hz * rate_hz));
  const double quiet_s = static_cast<double>(quiet) / rate_hz;
  std::vector<double> padded_m(quiet, 0.0);
  padded_m.insert(padded_m.end(), skin_m.begin(), skin_m.end());
  const dsp::Envelope envelope = dsp::DemodulateTone(padded_m, {rate_hz, tone_hz});
  const double last_s = envelope.start_s +
                        static_cast<double>(envelope.amplitude.size()) * envelope.step_s -
                        envelope.step_s;
  const double end_s = std::min(last_s, quiet_s + part.end_s - envelope.support_s / 2);
  const auto edge =
      // windows end half a support before the drive and before the end of the steady part
      dsp::FindOnset(envelope, {.quiet_begin_s = envelope.start_s,
                                .quiet_end_s = quiet_s + part.drive_s - envelope.support_s / 2,
                                .steady_begin_s = end_s - kSteadyPeriods / tone_hz,
                                .steady_end_s = end_s});
  if (!edge) return std::nullopt;
  return SkinRise{.rise_s = edge->rise_s,
                  .rise_at_most_s = edge->rise_at_most_s,
                  .latency_s = std::max(0.0, edge->time_s - quiet_s - part.drive_s),
                  .uncertainty_s = std::max(edge->time_uncertainty_s, edge->rise_uncertainty_s)};
}

FindingKind VerdictOf(const SkinRise& rise) {
  // from 25 ms on a latency causes errors, from 50 ms on it is perceived (reference/simulate.md)
  constexpr double kCostsErrorsS = 0.025;
  constexpr double kPerceivedS = 0.050;
  const auto of = [](double latency_s) {
    if (latency_s < kCostsErrorsS) return FindingKind::kLatencyUnnoticed;
    return latency_s < kPerceivedS ? FindingKind::kLatencyCostsErrors
                                   : FindingKind::kLatencyPerceived;
  };
  // a verdict only where both ends of the uncertainty have the same
  const FindingKind most = of(rise.LatencyAtMostS());
  return most == of(rise.latency_s - rise.uncertainty_s) ? most : FindingKind::kLatencyUndecided;
}

}  // namespace haptometer::sim
