#pragma once

#include <limits>
#include <vector>

#include "fit/drop_test/prepared_record.h"

namespace haptometer::fit {

/// By how much the drops of one actuator differ beyond what their noise explains: temperature,
/// mounting, the mover's path.
struct DropScatter {
  /// The Birge ratio sqrt(sum ((x - mean)/u)^2/degrees), Birge, Physical Review 40, 1932, p. 207.
  /// 1 where one drop stands alone, or where the scatter is within what 1 of 100 sets without
  /// further causes reaches.
  double birge_ratio = 1;
  /// Of the scatter: the drops that are compared less their groups. Infinite: none.
  double degrees = std::numeric_limits<double>::infinity();
  /// Standard deviation between drops, relative; Paule and Mandel's (fit/consensus_mean.h) where
  /// the Birge ratio is above 1, else 0.
  double deviation = 0;
  /// The same for a normal distribution's interval, with Student's factor of so few drops in it
  /// (StudentSquares), where the Birge ratio of Kv or of Bv is above 1: drops that differ in one
  /// may in the other, and few drops cannot exclude it. Not below the other; else 0.
  double student_deviation = 0;
};

/// What a drop's own constants are above those of the start values, and whether it belongs here.
struct OwnConstants {
  double stiffness = 0;  ///< of ln Kv
  double damping = 0;    ///< of ln Bv; 0 where no other drop is alike
  bool is_of_another = false;
  // of its own fit, as of one sample, if it were white; 0: it has none
  double noise_v = 0;
  double amplitude_v = 0;  ///< of the ringing at its begin
  double blocks = 0;       ///< that were fitted
};

/// How the drops of one actuator agree with each other and each with itself.
struct Consistency {
  DropScatter frequency;  ///< of Kv
  DropScatter decay;      ///< of Bv
  std::vector<OwnConstants> drops;
  /// By which the uncertainties of the fit of all drops together are too small: as much as dry
  /// friction that is fitted along, or what a later begin of a drop says, leaves open. At least 1.
  double frequency_widening = 1;
  double decay_widening = 1;
  Findings findings;  ///< doubts, and, as refusals, what makes the constants useless
};

/// One drop and what it must have in common with others to be compared.
struct ComparedDrop {
  const PreparedRecord* prepared = nullptr;
  double load_ohm = 0;
  double mass_ratio = 1;     ///< ringing mass over that of the others
  double added_mass_kg = 0;  ///< where the mover's mass follows from it, else 0
  // what the start values make of it, in the record's own seconds
  PolePair expected;
  double damping_share = 1;  ///< of Bv in the decay; the rest is the coil's
  double coil_share = 0;     ///< by which the coil's current raises ln q
};

/// How far apart drops of one actuator may ring, as shares of the natural frequency and the decay
/// rate. Springs of metal change Kv by 2e-4 to 5e-4 a kelvin and copper its ohms by 4e-3, so that
/// 20 K are 0.5 % and 8 %, and a fixture of 50 times the mover's mass is 1 %.
inline constexpr double kMostFrequencyShare = 0.02;
inline constexpr double kMostDecayShare = 0.2;

/// Fits each drop's pole pair by itself (ring_fit.h), from the begin of its part and once more from
/// one decay time later.
///
/// Drops are compared by what their frequencies are above the model's at the start values, and
/// those with equal load and mass by their decays too. One that is beyond kMostFrequencyShare or
/// kMostDecayShare from the others' mean, and beyond 4 standard deviations by noise and 3 of the
/// others' scatter, is refused as another actuator's, the farthest first; it does not count for the
/// scatter. Two cannot tell which one it is.
///
/// A drop whose resonance or decay from the later start differs from the whole's by more than 4
/// standard deviations of that difference (Hausman, Econometrica 46, 1978, p. 1251: the square is
/// that of the later fit less that of the whole) rings otherwise when it is small: a spring that
/// stiffens or softens with travel, friction, air. Records damped beyond 0.3 of critical are not
/// compared. Cost: two one-record fits a drop, some ms.
[[nodiscard]] Consistency CheckConsistency(const std::vector<ComparedDrop>& drops);

/// Refuses drops that their own ring-down explains much better than the fit of all together, in
/// which each may differ as the drops scatter: what is stated of them is wrong.
///
/// @param drops        as CheckConsistency took them
/// @param noises_v     that the fit of all takes for each drop
/// @param consistency  of CheckConsistency; the refusals go into its findings
void DoubtStatements(const std::vector<ComparedDrop>& drops, const std::vector<double>& noises_v,
                     Consistency& consistency);

}  // namespace haptometer::fit
