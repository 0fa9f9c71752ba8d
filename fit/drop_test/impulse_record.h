#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/quantity.h"
#include "fit/findings.h"
#include "trial/record.h"

namespace haptometer::fit {

/// What the motor's case does while the mover rings.
enum class CaseCondition : std::uint8_t {
  kHeld,  ///< fixed to something heavy: the mover's own mass rings
  kFree,  ///< in the air: the reduced mass Mv Mc/(Mv+Mc) rings
};

/// "held", "free".
[[nodiscard]] std::string_view Name(CaseCondition condition);

/// What a record holds.
enum class RecordedSignal : std::uint8_t {
  kVoltage,       ///< at the terminals
  kDisplacement,  ///< a laser's, of the case that hangs free or of the mover: of either, a fixed
                  ///< share of the motion of mover against case
};

/// One ring-down of an actuator over time, after a blow or after a current is interrupted, and what
/// is known of it.
struct ImpulseRecord {
  std::string name;    ///< the file, for messages
  double start_s = 0;  ///< time of the first sample
  double step_s = 0;   ///< between samples, > 0
  RecordedSignal signal = RecordedSignal::kVoltage;
  std::vector<double> voltage_v;     ///< NaN where there is no measurement; a displacement in m
  std::optional<Quantity> load_ohm;  ///< across the terminals; infinite: open; absent: not stated
  std::optional<CaseCondition> condition;  ///< absent: not stated
  std::optional<Quantity> drop_height_m;   ///< of the free fall before the impact
  std::optional<Quantity> rebound;  ///< e: the case leaves the stop with e times its speed; 0-1
  /// The current I0 whose interruption lets the mover go, which it held out of its place by Km
  /// I0/Kv; absent: the motion begins with a blow.
  std::optional<Quantity> release_current_a;
  std::optional<Quantity> added_mass_kg;  ///< fixed to the mover, with a held case; absent: none
  std::optional<Quantity> voltage_scale;  ///< shown over true volts; absent: 1, exactly
  std::optional<Quantity> time_scale;     ///< shown over true seconds; absent: 1, exactly
  bool is_cut_before = false;             ///< the record began earlier: its blow may be missing
  std::string unit = "V";                 ///< of the values, for sentences; "m" of a tapped adapter
};

/// What a time base leaves open of its own scale: 1, with the relative standard uncertainty of its
/// rate, sqrt(2) u_t rate/rows; nothing below 1e-7.
[[nodiscard]] std::optional<Quantity> TimeScaleOf(const trial::Stretch& stretch);

/// What is known of the actuator apart from its ring-downs. Absent: unknown.
struct ActuatorKnowns {
  std::optional<Quantity> moving_mass_kg;  ///< Mv
  std::optional<Quantity> case_mass_kg;    ///< Mc
  std::optional<Quantity> resistance_ohm;  ///< R
  std::optional<Quantity> inductance_h;    ///< L
};

/// A drop as its file tells it: the voltage channel, and the header's statements.
struct ImpulseFile {
  ImpulseRecord record;
  ActuatorKnowns knowns;
  Findings findings{};  ///< header keys that look like a known one
};

/// Takes a drop out of a recording (trial/import/readers.h reads `impulse.csv`).
///
/// The signal is the channel with the voltage role, else the only one with the displacement role,
/// else the only channel where no name says what it measures, as a voltage. Header keys, each an SI
/// number or a text with unit and uncertainty ("1.40(3)g"): case (held | free), load_ohm (inf:
/// open), drop_height_m, rebound, release_current_a, added_mass_kg, voltage_scale, time_scale,
/// moving_mass_kg, case_mass_kg, resistance_ohm, inductance_h.
/// Errors (Cause::kCannotAnswer), named by `name`: neither voltage nor displacement, or several of
/// one, gaps or an uneven time base, a key's value that does not parse or that is out of its
/// range.
[[nodiscard]] Result<ImpulseFile> ImpulseFromRecord(const trial::Record& record,
                                                    const std::string& name);

/// Makes samples that stand at a rail of the converter NaN, and returns how many there were.
///
/// A rail is the largest or the smallest value of the record when it occurs more often than a whole
/// peak can explain. The top of a swing of amplitude A, rounded to the converter's step s, is flat
/// for 2 acos(1 - s/A) of a radian: more samples than that and 2 within half a period are a rail.
/// Values that are not rounded do not repeat at all: 3 equal extremes are a rail there. What lies
/// at a rail says no more than "at least this".
///
/// @param values_v NaN where there is no measurement
/// @param period_samples of the oscillation
[[nodiscard]] std::size_t MaskRails(std::vector<double>& values_v, double period_samples);

/// The converter's step: the smallest distance between values that occur, when all are whole steps
/// apart and there are at most 4096 of them; 0 for a record that shows none.
[[nodiscard]] double ConverterStep(const std::vector<double>& values_v);

}  // namespace haptometer::fit
