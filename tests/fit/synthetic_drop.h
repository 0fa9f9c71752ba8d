#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "fit/drop_test/impulse_record.h"
#include "sim/ring_down.h"
#include "tests/sim/ring_ratios.h"

namespace haptometer::tests {

inline constexpr double kOpen = std::numeric_limits<double>::infinity();

/// A drop of the thesis's actuator (Lindsay 2013, Table 2.1) by the closed form, which
/// tests/sim/ring_down_test.cc ties to the exponential of the circuit.
struct SyntheticDrop {
  double stiffness_n_per_m = 2800;
  double damping_n_s_per_m = 0.0322;
  double force_constant_n_per_a = 1.0;
  double moving_mass_kg = 1.4e-3;
  double case_mass_kg = 0.6e-3;
  double resistance_ohm = 27;
  double inductance_h = 130e-6;
  double load_ohm = kOpen;
  fit::CaseCondition condition = fit::CaseCondition::kHeld;
  double height_m = 0.01;
  double release_current_a = 0;   ///< above 0: the motion begins with its end, not with a blow
  double added_mass_kg = 0;       ///< on the mover
  double displacement_share = 0;  ///< above 0: of the motion of mover against case, seen in metres
  double rebound = 0;
  double step_s = 2e-4;
  double quiet_s = 0.01;   ///< before the impact; negative: the record begins behind it
  double length_s = 0.25;  ///< from the impact on
  double impact_s = 0.37e-4;
  double offset_v = 0.01;
  double polarity = 1;
  double noise_v = 0;
  double step_v = 0;  ///< of the converter; 0: not quantised
  unsigned seed = 1;
};

inline double EffectiveMass(const SyntheticDrop& drop) {
  if (drop.condition == fit::CaseCondition::kHeld) return drop.moving_mass_kg + drop.added_mass_kg;
  return drop.moving_mass_kg * drop.case_mass_kg / (drop.moving_mass_kg + drop.case_mass_kg);
}

inline double ImpactSpeed(const SyntheticDrop& drop) {
  return (1 + drop.rebound) * std::sqrt(2 * 9.80665 * drop.height_m);
}

/// Km v0, the open terminals' first voltage.
inline double SpeedVoltage(const SyntheticDrop& drop) {
  return drop.force_constant_n_per_a * ImpactSpeed(drop);
}

/// Of so many periods at 40 Hz with so many samples each; the quality factor is 3.25.
inline SyntheticDrop HeavilyDampedDrop(double periods, double samples_a_period) {
  SyntheticDrop drop;
  const double own_rad_per_s = 2 * M_PI * 40;
  drop.stiffness_n_per_m = drop.moving_mass_kg * own_rad_per_s * own_rad_per_s;
  drop.damping_n_s_per_m = drop.moving_mass_kg * own_rad_per_s / 3.25;
  drop.step_s = 1 / (40 * samples_a_period);
  drop.quiet_s = 40 * drop.step_s;
  drop.impact_s = 0.1 * drop.step_s;
  drop.length_s = periods / 40;
  drop.noise_v = 1e-5 * SpeedVoltage(drop);
  drop.offset_v = 0;
  return drop;
}

/// What follows the instant of the blow or release at `t` seconds, first negative.
inline double RingingOf(const SyntheticDrop& drop, const sim::RingDown<double>& circuit, double t) {
  if (drop.displacement_share > 0) {
    return -drop.displacement_share * ImpactSpeed(drop) * DisplacementRatio(circuit, t);
  }
  if (drop.release_current_a > 0) {
    return drop.force_constant_n_per_a * drop.force_constant_n_per_a * drop.release_current_a /
           EffectiveMass(drop) * ReleaseRatio(circuit, t);
  }
  return SpeedVoltage(drop) * VoltageRatio(circuit, t);
}

/// The record; load, condition, current and added mass are stated, height and rebound are not.
inline fit::ImpulseRecord MakeRecord(const SyntheticDrop& drop) {
  const sim::RingDown<double> circuit(
      {.stiffness_n_per_m = drop.stiffness_n_per_m,
       .damping_n_s_per_m = drop.damping_n_s_per_m,
       .force_constant_squared_n2_per_a2 =
           drop.force_constant_n_per_a * drop.force_constant_n_per_a,
       .mass_kg = EffectiveMass(drop),
       .coil_resistance_ohm = drop.resistance_ohm,
       .inductance_h = drop.inductance_h,
       .load_ohm = drop.load_ohm});
  fit::ImpulseRecord record;
  record.name = "drop.csv";
  record.step_s = drop.step_s;
  record.start_s = -std::round(drop.quiet_s / drop.step_s) * drop.step_s;
  record.load_ohm = Quantity{drop.load_ohm, 0};
  record.condition = drop.condition;
  if (drop.release_current_a > 0) record.release_current_a = Quantity{drop.release_current_a, 0};
  if (drop.added_mass_kg > 0) record.added_mass_kg = Quantity{drop.added_mass_kg, 0};
  if (drop.displacement_share > 0) {
    record.signal = fit::RecordedSignal::kDisplacement;
    record.unit = "m";
  }
  std::mt19937_64 engine(drop.seed);
  std::normal_distribution<double> noise;
  for (int n = 0;; ++n) {
    const double t = record.start_s + n * drop.step_s - drop.impact_s;
    if (t >= drop.length_s) break;
    double v = drop.offset_v;
    if (t > 0) v -= drop.polarity * RingingOf(drop, circuit, t);
    if (drop.noise_v > 0) v += drop.noise_v * noise(engine);
    if (drop.step_v > 0) v = std::round(v / drop.step_v) * drop.step_v;
    record.voltage_v.push_back(v);
  }
  return record;
}

/// The same with height and rebound stated as exact.
inline fit::ImpulseRecord MakeRecordWithHeight(const SyntheticDrop& drop) {
  auto record = MakeRecord(drop);
  record.drop_height_m = Quantity{drop.height_m, 0};
  record.rebound = Quantity{drop.rebound, 0};
  return record;
}

inline fit::ActuatorKnowns ThesisKnowns() {
  return {Quantity{1.4e-3, 0}, Quantity{0.6e-3, 0}, Quantity{27, 0}, Quantity{130e-6, 0}};
}

}  // namespace haptometer::tests
