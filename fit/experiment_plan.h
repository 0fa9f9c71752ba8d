#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "base/quantity.h"

namespace haptometer::fit {

/// Drops that are still to be made: a held case, some with open terminals and some with one load.
/// Actuator and recording are guesses; only their uncertainties are believed.
struct PlannedDrops {
  Quantity moving_mass_kg;            ///< Mv > 0
  Quantity resistance_ohm;            ///< R > 0
  Quantity load_ohm;                  ///< RL of the loaded drops, above 0 and finite
  double inductance_h = 0;            ///< L >= 0
  double natural_frequency_hz = 0;    ///< sqrt(Kv/Mv)/2pi > 0
  double quality_factor = 0;          ///< sqrt(Kv Mv)/Bv > 1/2, with open terminals
  double force_constant_n_per_a = 0;  ///< Km > 0
  double speed_m_per_s = 0;           ///< of mover against case at the blow, > 0
  double rate_hz = 0;                 ///< of the recorder: at least 5 samples a period
  double length_s = 0;                ///< recorded behind the blow: at least 2 periods
  double noise_v = 0;                 ///< standard deviation, white; not 0 together with `step_v`
  double step_v = 0;                  ///< of the converter; 0: none
  double time_scale_uncertainty = 0;  ///< standard uncertainty of shown over true seconds
  std::size_t open_drops = 1;         ///< at least 1
  std::size_t loaded_drops = 1;       ///< at least 1
};

/// The constants that a drop test with two loads gives.
enum class Constant : std::uint8_t { kStiffness, kDamping, kForceConstant };
inline constexpr std::size_t kConstantCount = 3;

/// The relative standard uncertainty to expect of a constant, and where it comes from.
struct ExpectedUncertainty {
  double statistical = 0;      ///< noise and converter: the Cramer-Rao bound of all drops together
  double from_mass = 0;        ///< of the moving mass
  double from_resistance = 0;  ///< of the coil's resistance
  double from_load = 0;
  double from_time_scale = 0;
  [[nodiscard]] double given() const;     ///< all but the statistical one
  [[nodiscard]] double combined() const;  ///< root of the sum of squares
};

/// What the planned drops will tell, by Constant.
using ExpectedUncertainties = std::array<ExpectedUncertainty, kConstantCount>;

/// Predicts what FitDropTest will state.
///
/// Statistical: the Cramer-Rao bound of the drop-test model (ring_down_problem.h), every drop with
/// an amplitude, an impact time and an offset of its own, in white noise of variance noise^2 +
/// step^2/12, fitted from an eighth of a period behind the blow (ring_start.h) to the end. The
/// Fisher information J'J of each kind of drop, less what its own parameters take (Schur's
/// complement), counts once a drop; the inverse of the sum is the covariance of Kv, Bv and Km^2.
/// Where the noise is below a quarter of a step, rounding repeats itself and the scatter may be up
/// to 1.6 times as large. Above 5 % for Km the interval will not be symmetrical.
///
/// From the given numbers: (M, Kv, Bv, Km^2) -> c (M, Kv, Bv, Km^2) leaves every record as it is,
/// and Km^2 is proportional to R + RL, so that per percent Mv moves Kv, Bv, Km by 1, 1, 1/2 percent
/// and R moves Km by R/(R+RL)/2; a time scale moves them by 2, 1, 1/2.
///
/// Cost: about 1 ms at Q 60, in proportion to Q; records finer than 24 samples a period are
/// computed at that rate, longer than 12 decay times as being so long.
[[nodiscard]] ExpectedUncertainties ExpectUncertainties(const PlannedDrops& drops);

/// How the drops will ring, whatever records them: amplitudes fall as e^(-decay t) from their first
/// value.
struct ExpectedRinging {
  double open_decay_per_s = 0;
  double loaded_decay_per_s = 0;
  double open_amplitude_v = 0;    ///< Km v0
  double loaded_amplitude_v = 0;  ///< Km v0 RL/(R+RL)
};
[[nodiscard]] ExpectedRinging ExpectRinging(const PlannedDrops& drops);

/// A load for the loaded drops.
struct LoadChoice {
  double best_ohm = 0;      ///< where the combined uncertainty of Km is least
  double resistor_ohm = 0;  ///< the E12 value where it is least
  double least_ohm = 0;     ///< between this E12 value and `most_ohm` it is within 10 % of that
  double most_ohm = 0;
};

/// The load that tells Km best with these counts of drops; a load's uncertainty is taken in
/// proportion to `drops.load_ohm`. Searched from a tenth of R to ten times R, where there is one
/// minimum: too small a load leaves no voltage, too large a one no damping. Cost: 40 predictions.
[[nodiscard]] LoadChoice ChooseLoad(const PlannedDrops& drops);

/// A relative combined standard uncertainty that is wished for.
struct AccuracyWish {
  Constant constant = Constant::kForceConstant;
  double relative_uncertainty = 0;  ///< > 0
};

/// What keeps a wish from being reached.
enum class PlanLimit : std::uint8_t {
  kNone,
  kMass,
  kResistance,
  kLoad,
  kTimeScale,
  kNoise,      ///< of the recorder, with its steps
  kConverter,  ///< its steps, where finer ones alone would do
};

/// How many drops a wish takes.
struct DropCount {
  std::size_t open = 0;  ///< meaningless where there is a limit
  std::size_t loaded = 0;
  PlanLimit limit = PlanLimit::kNone;
  /// With a limit: the uncertainty that this input (noise and steps, or steps) may have at most, as
  /// a share of what it has now; 0 where the others alone are too much.
  double tolerable_share = 0;
};

/// The fewest drops, open and loaded together, that reach `wish`; at most `most` of each kind. The
/// given numbers' uncertainties do not shrink with the count. The limit is what contributes most
/// when all `most` are made.
[[nodiscard]] DropCount CountDrops(const PlannedDrops& drops, const AccuracyWish& wish,
                                   std::size_t most);

}  // namespace haptometer::fit
