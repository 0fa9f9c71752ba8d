#pragma once

#include <optional>
#include <span>

#include "sim/findings.h"

namespace haptometer::sim {

/// How the skin's vibration comes up, as `analyze` tells it (dsp/spectrum/envelope.h).
struct SkinRise {
  std::optional<double> rise_s;          ///< 10 % to 90 % of the steady amplitude
  std::optional<double> rise_at_most_s;  ///< in its place where the rise is too sudden to be told
  /// From the drive's begin to 10 %. No motion begins before its drive: a reading before it, which
  /// the envelope's window can give, is 0.
  double latency_s = 0;
  double uncertainty_s = 0;  ///< standard, of both: what the envelope's window may hide

  /// What the latency is at most, its standard uncertainty added: what a limit is held against.
  [[nodiscard]] double LatencyAtMostS() const { return latency_s + uncertainty_s; }
  /// Whether the latency stands out of its uncertainty; else only what it is at most is known.
  [[nodiscard]] bool TellsLatency() const { return latency_s > uncertainty_s; }
};

/// What a latency means, its standard uncertainty added and subtracted: kLatencyUnnoticed below
/// 25 ms, from which on it costs errors; kLatencyCostsErrors; kLatencyPerceived from 50 ms on;
/// kLatencyUndecided where the uncertainty holds one of the two.
[[nodiscard]] FindingKind VerdictOf(const SkinRise& rise);

/// The part of a drive in which its amplitude stands still.
struct SteadyPart {
  double drive_s = 0;  ///< when the drive begins
  double begin_s = 0;  ///< when it has come to its full amplitude
  double end_s = 0;
};

/// Periods that a steady part must last for a rise to be told.
inline constexpr double kLeastRisePeriods = 20;
[[nodiscard]] bool LastsForARise(const SteadyPart& part, double tone_hz);

/// The rise of a skin whose positions at i / rate_hz, from rest, are `skin_m`: six periods of rest
/// are put before it, the tone is demodulated in windows of three periods
/// (dsp/spectrum/envelope.h), and the last ten periods of the steady part are what 10 % and 90 %
/// are of. A latency is told to some 0.15 periods (1.5 ms at 100 Hz). Nothing where the amplitude
/// does not pass both. The part must be one that LastsForARise(). Cost: some 0.1 us a position;
/// allocates copies.
[[nodiscard]] std::optional<SkinRise> RiseOf(std::span<const double> skin_m, double rate_hz,
                                             double tone_hz, const SteadyPart& part);

}  // namespace haptometer::sim
