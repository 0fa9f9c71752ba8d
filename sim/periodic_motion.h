#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>

#include "sim/period_map.h"

namespace haptometer::sim {

/// A motion that repeats itself after 1, 2 or 4 periods of the drive.
struct PeriodicMotion {
  int drive_periods = 1;  ///< 1, 2 or 4
  PeriodPoint point;      ///< where it is at phase 0 of the drive
  /// Floquet multipliers: by how much each deviation grows over the whole period, largest first.
  Eigen::VectorXcd multipliers;
  /// All multipliers within the unit circle, by more than their error.
  bool stable = false;
  double residual =
      0;  ///< how far the point returns beside itself, over each state's largest value
  /// How far the end of the transient was from it, over each state's largest value.
  double from_transient = 0;
  PeriodMeans means;
};

/// What a search came to.
struct PeriodicSearch {
  std::optional<PeriodicMotion> found;  ///< stable where there is one, else the shortest found
  std::string tried;                    ///< in words, for the answer "none found"
  std::int64_t periods_played = 0;      ///< periods of the drive that were computed
  std::int64_t steps = 0;               ///< what that took (PeriodStep::steps)
};

/// How a periodic motion is searched for.
struct PeriodicSettings {
  int transient_periods = 200;  ///< before the first shot; doubled twice if nothing is found
  int newton_steps = 20;        ///< at most, for each shot
  std::int64_t most_steps = 10'000'000;  ///< in all, then nothing more is tried: half a minute
};

/// The periodic steady state that a motion settles to.
///
/// First the transient from `start`, which chooses between attractors. Then, for k = 1, 2, 4, the
/// fixed points of P^k near it by Newton's method (shooting), P the map over one period:
///
///   x <- x + (I - M)^-1 (P^k(x) - x),   M = dP^k/dx by central differences, columns of d = the
///   cube root of the map's error times each state's largest value.
///
/// A step is halved until the next one by the same M is smaller (Deuflhard's natural test). M's
/// eigenvalues at the solution are the Floquet multipliers; for a linear scene exp(lambda k T).
/// A fixed point of P^2 that is one of P is not counted again. The shortest stable one is the
/// answer; an unstable one (a motion that doubled its period leaves one behind) only where no
/// stable one was found. Newton needs no decay: a resonance that rings, or a coil that warms, for
/// 1e6 periods costs the same. It does need the same mode at phase 0 before and after; a mode that
/// has fewer coordinates (bodies at rest against each other) is as good.
///
/// Cost: (2 n + 1) k periods for each Newton step.
[[nodiscard]] PeriodicSearch FindPeriodicMotion(const PeriodMap& map, const PeriodPoint& start,
                                                const PeriodicSettings& settings = {});

}  // namespace haptometer::sim
