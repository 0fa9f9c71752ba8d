#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "sim/findings.h"
#include "sim/period_map.h"

namespace haptometer::sim {

/// A motion that repeats itself after 1 to 32 periods of the drive, and to which the transient
/// from the start leads.
struct PeriodicMotion {
  int drive_periods = 1;  ///< 1 to kMostDrivePeriods, the smallest
  PeriodPoint point;      ///< where it is at phase 0 of the drive
  /// Floquet multipliers: by how much each deviation grows over the whole period, largest first.
  /// Empty where the map has no derivative there (a graze, a change of mode at phase 0): that the
  /// transient came to repeat itself is then all that shows the motion stable.
  Eigen::VectorXcd multipliers{};
  /// All multipliers within the unit circle, by more than their error.
  bool stable = false;
  /// How far the point returns beside itself, over each state's largest value.
  double residual = 0;
  /// How far from the motion the point may be, |(I - M)^-1| |residual|, likewise over each state's
  /// largest value.
  double error = 0;
  PeriodMeans means{};
};

/// A motion that was not seen to repeat itself and in which deviations grow: only its averages are
/// known. Standard uncertainties are those of the means of batches of periods (G. S. Fishman,
/// "Discrete-Event Simulation", Springer 2001, chapter 6), which are far longer than the motion
/// remembers.
struct ChaoticMotion {
  PeriodPoint point;    ///< in it, at phase 0
  double exponent = 0;  ///< largest Lyapunov exponent, per period of the drive
  double exponent_standard_uncertainty = 0;
  int periods = 0;  ///< that the averages are of
  PeriodMeans means;
  PeriodMeans standard_uncertainties;  ///< of the means; `largest` and `events` are not used
};

inline constexpr int kMostDrivePeriods = 32;

/// What a search came to.
struct PeriodicSearch {
  std::optional<PeriodicMotion> found;   ///< stable
  std::optional<ChaoticMotion> chaotic;  ///< where none was found and the exponent is positive
  std::optional<Finding> refusal;        ///< why there is neither
  std::int64_t periods_played = 0;       ///< periods of the drive that were computed
  std::int64_t steps = 0;                ///< what that took (PeriodStep::steps)
};

/// How a periodic motion is searched for.
struct PeriodicSettings {
  int transient_periods = 64;  ///< before the first look; doubled until something is found
  int most_periods = 4096;     ///< of the transient
  int newton_steps = 20;       ///< at most, for each shot
  std::int64_t most_steps = 10'000'000;  ///< in all, then nothing more is tried: half a minute
};

/// The steady motion that the transient from `start` leads to.
///
/// **The transient** is played, P being the map over one period, and chooses between attractors.
/// After 64, 128, 256 ... periods the state is compared with the 32 before it: the smallest k whose
/// |P^n - P^(n-k)| is no more than three times the least is where the motion seems to repeat
/// itself.
///
/// **Newton** then refines it, from where the transient is:
///
///   x <- x + (I - M)^-1 (P^k(x) - x),   M = dP^k/dx = product of dP/dx along the k periods,
///
/// each by central differences with the cube root of the map's error times each state's largest
/// value, through all events (M so has their saltation in it). A step is halved until the next one
/// by the same M is smaller (Deuflhard's natural test). A fixed point that is also one of a divisor
/// of k is that one's. M's eigenvalues there are the Floquet multipliers.
///
/// **The transient must come to it**: it is played on until it is within 1e-7, or, where what is
/// left dies out slowly, until M foretells what the next k periods leave of the deviation. A motion
/// that exists beside the transient, stable or not, is no answer, and the search goes on. The
/// coil's temperature, which may take 1e6 periods, is the one exception: it is led to its value in
/// eight steps, and the rest of the state must then come to the motion from where that leads.
///
/// **Chaos**: where nothing repeats itself, the largest Lyapunov exponent is estimated over 1024
/// periods more from a pair of motions (G. Benettin et al., Meccanica 15, 9-30 (1980)), with its
/// uncertainty from 32 batches. If it is positive by four of these, averages over 4096 periods
/// more are the answer, unless one of their 32 batches holds more than half of the variance: it
/// then saw something rare, as a long flight, that the others did not. Else (quasi-periodic motion,
/// a longer period, no end of the transient in the bounded work) there is none, and `refusal` has
/// what was seen and what it cost.
///
/// Cost: the transient, and 2 n k periods for each Newton step.
[[nodiscard]] PeriodicSearch FindPeriodicMotion(const PeriodMap& map, const PeriodPoint& start,
                                                const PeriodicSettings& settings = {});

/// The same motion under a map that differs a little, a smaller tolerance's; nothing where it is
/// not there. Adds its work to `search`.
[[nodiscard]] std::optional<PeriodicMotion> RefinePeriodicMotion(const PeriodMap& map,
                                                                 const PeriodicMotion& motion,
                                                                 const PeriodicSettings& settings,
                                                                 PeriodicSearch& search);

}  // namespace haptometer::sim
