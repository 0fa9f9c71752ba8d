#pragma once

#include <cstddef>
#include <string>

#include "fit/drop_test/ring_fit.h"

namespace haptometer::fit {

/// Later blows that a record may have.
inline constexpr std::size_t kMostCuts = 2;

/// What a fitted ring-down leaves that its record's noise does not explain.
///
/// The noise is estimated without the model: from third differences of the residuals of blocks of a
/// sixteenth of a period (their power over 20; an oscillation up to three times the ringing's
/// frequency leaves less than a tenth of its own there), at least the converter's rounding and,
/// where something quiet precedes the blow, that. All powers are weighted by the square of the
/// ringing's envelope, so that what matters is what is there while it rings; a spark counts as much
/// in the noise as in the residuals' power:
///
///     misfit_share = (sum g r^2 - s^2 sum g) / sum g m^2,    g = e^(-2 d t),
///
/// r the residuals, m the ringing, s the noise. White noise of any strength gives 0 within
/// `misfit_share_deviation`. With g = 1 and over half of the squared first amplitude the same is
/// `lasting_share`: what stays when the ringing is gone.
struct RingEvidence {
  double misfit_share = 0;
  double misfit_share_deviation = 0;
  double lasting_share = 0;
  double lasting_share_deviation = 0;
  double decays = 0;            ///< d T: decay times that the fitted part holds
  double decays_deviation = 0;  ///< its standard uncertainty, for white noise
  double damping_ratio = 0;     ///< of critical
  std::size_t cuts = 0;         ///< later blows at which the record was cut
  bool begins = false;          ///< something quiet precedes the oscillation

  /// Part of all power that is not the ringing's, m / (1 + m) with m = `misfit_share`: 0 to 1.
  [[nodiscard]] double UnexplainedShare() const {
    return misfit_share > 0 ? misfit_share / (1 + misfit_share) : 0;
  }
};

/// `floor_v`: of the noise of one of the samples, where something is known of it.
[[nodiscard]] RingEvidence EvidenceOf(const RingSamples& samples, const RingFit& fit,
                                      double floor_v);

/// Why a fitted part is no ring-down, as the end of a sentence on its record; empty: it is one, as
/// far as can be told.
///
/// - "does not oscillate": a damping beyond 0.7 of critical. Not asked where `is_stated_drop`: a
///   drop height or a released current says what began the motion.
/// - "does not decay": d T surely (by two deviations) below 0.1, and the oscillation does not
///   `begin` in the record: one that does has been struck, however little of its decay is seen. Of
///   true ring-downs of one decay time none is so refused.
/// - its frequency changes behind its begin, surely (by six deviations) and by more than 5 %.
/// - the misfit is above 1.5 % of the ringing's power (12 % of its amplitude) and beyond five of
///   its deviations (one record of white noise in 10^6). What is left is said, if it can be told.
/// - what lasts is above 1 % of the first power (an oscillation of 10 % of the first amplitude over
///   the whole part) and beyond five deviations: a chirp's later course, or another source.
/// - more than two later blows.
[[nodiscard]] std::string NoRingDown(const RingEvidence& evidence, const RingSamples& samples,
                                     const RingFit& fit, bool is_stated_drop);

}  // namespace haptometer::fit
