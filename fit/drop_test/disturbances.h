#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "fit/drop_test/impulse_record.h"
#include "fit/drop_test/ring_evidence.h"
#include "fit/drop_test/ring_fit.h"
#include "fit/drop_test/ring_start.h"

namespace haptometer::fit {

/// What a record holds beside one clean ring-down, and the part of it that the fit should use.
struct Disturbances {
  std::size_t first_sample = 0;  ///< of the part to fit
  std::size_t end_sample = 0;    ///< one behind it
  RingBackground background;     ///< to be fitted along
  bool follows_a_later_blow =
      false;       ///< the part is not the first ring-down: no height holds for it
  PolePair poles;  ///< of the last fit
  /// (part's samples, missing ones too) to be added, where dry friction was found: what makes them
  /// those of a motion without it (fit/drop_test/ring_fit.h). Else empty.
  std::vector<double> linear_less_friction_v;
  double friction_share = 0;  ///< of the spring's force at the part's begin; 0: none found
  RingEvidence evidence;
  std::string no_ring_down;  ///< why it is none (ring_evidence.h); empty: it is one
  Findings found;            ///< what else was found, how large, and what is done
};

/// Looks for a later blow, mains hum, drift and a tail below the converter's step.
///
/// The record is fitted by one free pole pair (ring_fit.h). Each disturbance that is still missing
/// is then tried on the residual: a line; a sine of 50 or of 60 Hz, then those of up to three of
/// its 2nd to 5th harmonics (but where what changes with the ringing's own amplitude explains more
/// than a harmonic, which lies within the resonance's width then); a free jump of the motion at one
/// of the times half a period apart, against a ringing that changes with its own amplitude and is
/// not an impact (consistency.h). The one that reduces the residual's power most, by more than 30
/// times the mean share of a degree of freedom (one false alarm in 10^5 records of white noise; dry
/// friction, of one column with a known sign, 12 times: 1 in 4000), is included, and the fit
/// repeated until none is left. Friction is judged by the swings above the converter's step: below
/// it a record shows rest, as friction leaves behind. A tail of one code and its neighbours, below
/// the converter's step, is cut off before anything is tried: its sudden end resembles an impact.
///
/// - a line or a hum becomes further columns of the fit;
/// - at a blow the record is cut. The part kept is the one that tells more of the decay, by its
///   Cramer-Rao bound; where a drop height is stated, the first one as long as it holds three
///   periods.
///
/// The part that is left is no ring-down (`no_ring_down`) for the reasons of ring_evidence.h; where
/// what precedes it holds another motion: beyond noise, a decaying oscillation leaves more than
/// 15 % of the part's first power there; where a hum of a fifth of the ringing or more does not
/// precede it; and where less than two periods leave both ten times the noise before them and 1 %
/// of their first amplitude, because a wrong oscillation with a drift fits so short a part.
///
/// What is slow and no line (a coupling capacitor, a mount that creeps) is a doubt: means over two
/// periods five times as far from 0 as noise gives, from 0.05 % of the first amplitude on.
///
/// A blow below 0.5 % of the ringing's first amplitude, hum and drift below 0.05 %, are let pass.
/// Cost: some 5 ms; the record is averaged to 16 samples a period first.
[[nodiscard]] Disturbances FindDisturbances(const ImpulseRecord& record, const RingStart& start);

}  // namespace haptometer::fit
