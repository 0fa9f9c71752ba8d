// Drops of random actuators: the circuit's matrix exponential in long double gives the ring-down,
// and the fit's constants hold the true ones, or it is refused.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/prepared_record.h"
#include "tests/search/draws.h"

namespace haptometer::search {
namespace {

using Vector = std::array<Real, 3>;  // displacement, its speed, current
using Matrix = std::array<Vector, 3>;

// Seven standard uncertainties: chance reaches six in two of 1e9 numbers; the seventh is for the
// uncertainty of the noise, which is itself from some hundred samples.
constexpr double kFactor = 7;
constexpr double kOpen = std::numeric_limits<double>::infinity();

struct Motor {
  double stiffness_n_per_m = 0;
  double damping_n_s_per_m = 0;
  double force_constant_n_per_a = 0;
  double moving_mass_kg = 0;
  double case_mass_kg = 0;
  double ringing_mass_kg = 0;
  double resistance_ohm = 0;
  double inductance_h = 0;
};

Matrix Product(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t j = 0; j < 3; ++j) c[i][j] += a[i][k] * b[k][j];
    }
  }
  return c;
}

Vector Moved(const Matrix& a, const Vector& x) {
  Vector y{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) y[i] += a[i][k] * x[k];
  }
  return y;
}

// exp(a h): Taylor's series over h / 2^halvings, squared again
Matrix Exponential(const Matrix& a, Real h) {
  Real largest = 0;
  for (const Vector& row : a) {
    for (const Real value : row) largest = std::max(largest, std::abs(value * h));
  }
  const int halvings = 4 + std::max(0, static_cast<int>(std::ceil(std::log2(largest + 1))));
  Matrix sum{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Matrix term = sum;
  for (int n = 1; n <= 24; ++n) {
    term = Product(term, a);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        term[i][j] *= std::ldexp(h, -halvings) / n;
        sum[i][j] += term[i][j];
      }
    }
  }
  for (int k = 0; k < halvings; ++k) sum = Product(sum, sum);
  return sum;
}

// M x'' + Bv x' + Kv x = -Km i, L i' + (R + RL) i = Km x'; an open circuit has no current
Matrix CircuitOf(const Motor& motor, double load_ohm) {
  const Real mass = Long(motor.ringing_mass_kg);
  const Real km = Long(motor.force_constant_n_per_a);
  const Real spring = Long(motor.stiffness_n_per_m);
  const Real damper = Long(motor.damping_n_s_per_m);
  if (load_ohm == kOpen) return {{{0, 1, 0}, {-spring / mass, -damper / mass, 0}, {0, 0, 0}}};
  const Real inductance = Long(motor.inductance_h);
  const Real ohms = Long(motor.resistance_ohm) + Long(load_ohm);
  return {{{0, 1, 0},
           {-spring / mass, -damper / mass, -km / mass},
           {0, km / inductance, -ohms / inductance}}};
}

// what is the same in both records of an actuator
struct Recording {
  fit::ImpulseRecord head;  ///< without samples
  double speed_m_per_s = 0;
  double length_s = 0;
  double impact_s = 0;  ///< from a sample on
  double noise_v = 0;
  double step_v = 0;
  double offset_v = 0;
};

fit::ImpulseRecord Dropped(const Motor& motor, const Recording& recording, double load_ohm,
                           Noise& noise) {
  fit::ImpulseRecord record = recording.head;
  record.load_ohm = Quantity{load_ohm, 0};
  const Matrix circuit = CircuitOf(motor, load_ohm);
  const Matrix step = Exponential(circuit, Long(record.step_s));
  Vector state{};
  const auto samples = static_cast<int>(recording.length_s / record.step_s);
  for (int n = 0; n < samples; ++n) {
    const double t_s = record.start_s + n * record.step_s - recording.impact_s;
    if (t_s > 0 && t_s <= record.step_s) {
      state = Moved(Exponential(circuit, Long(t_s)), {0, Long(recording.speed_m_per_s), 0});
    } else {
      state = Moved(step, state);
    }
    const Real volts = load_ohm == kOpen ? Long(motor.force_constant_n_per_a) * state[1]
                                         : Long(load_ohm) * state[2];
    const double value =
        recording.offset_v + static_cast<double>(volts) + recording.noise_v * noise();
    record.voltage_v.push_back(Stepped(value, recording.step_v));
  }
  return record;
}

Motor DrawMotor() {
  Motor motor;
  const double own = 2 * std::numbers::pi * Decades("own_hz", 40, 500);
  motor.moving_mass_kg = Decades("moving_kg", 1e-4, 1e-2);
  motor.case_mass_kg = motor.moving_mass_kg * Decades("case_over_moving", 0.2, 5);
  motor.resistance_ohm = Decades("resistance_ohm", 5, 100);
  motor.inductance_h = motor.resistance_ohm / own * Decades("inductive", 1e-4, 3e-2);
  motor.ringing_mass_kg = motor.moving_mass_kg;
  if (Flag("is_free")) {
    motor.ringing_mass_kg /= 1 + motor.moving_mass_kg / motor.case_mass_kg;
  }
  motor.stiffness_n_per_m = motor.ringing_mass_kg * own * own;
  motor.damping_n_s_per_m = motor.ringing_mass_kg * own / Decades("quality", 3, 200);
  motor.force_constant_n_per_a = std::sqrt(2 * motor.ringing_mass_kg * own * motor.resistance_ohm *
                                           Decades("coil_damping_ratio", 1e-3, 0.3));
  return motor;
}

Recording DrawRecording(const Motor& motor) {
  Recording recording;
  fit::ImpulseRecord& head = recording.head;
  const double own = std::sqrt(motor.stiffness_n_per_m / motor.ringing_mass_kg);
  const bool is_held = motor.ringing_mass_kg == motor.moving_mass_kg;
  head.name = "drop.csv";
  head.condition = is_held ? fit::CaseCondition::kHeld : fit::CaseCondition::kFree;
  head.step_s = 2 * std::numbers::pi / own / Decades("samples_a_period", 8, 100);
  const double quiet_s = 40 * head.step_s;
  head.start_s = -quiet_s;
  const double height_m = Decades("height_m", 1e-3, 0.1);
  recording.speed_m_per_s = std::sqrt(2 * 9.80665 * height_m);
  if (Flag("height_is_stated")) {
    head.drop_height_m = Quantity{height_m, 0};
    head.rebound = Quantity{0, 0};
  }
  const double decay_s = 2 * motor.ringing_mass_kg / motor.damping_n_s_per_m;
  recording.length_s = std::min(quiet_s + decay_s * Decades("decays", 1, 8), 20'000 * head.step_s);
  recording.impact_s = head.step_s * Even("impact_in_step", 0.01, 0.99);
  const double first_v = motor.force_constant_n_per_a * recording.speed_m_per_s;
  recording.noise_v = first_v * Decades("noise_over_first", 1e-5, 0.05);
  if (Flag("has_steps")) recording.step_v = recording.noise_v * Decades("step_over_noise", 0.1, 3);
  if (Flag("has_offset")) recording.offset_v = first_v * Decades("offset_over_first", 0.01, 1);
  return recording;
}

void HoldTruth(const char* name, const fit::FittedValue& fitted, double truth) {
  if (!fitted.determined) return;
  Hold(name, (fitted.value - truth) / fitted.combined_standard_uncertainty, kFactor);
  Require("a value lies in its interval",
          fitted.lower <= fitted.value && fitted.value <= fitted.upper);
}

}  // namespace

bool DropCase() {
  const Motor motor = DrawMotor();
  const Recording recording = DrawRecording(motor);
  Noise noise(Whole("noise_seed", 0, 1'000'000));
  std::vector<double> loads_ohm{kOpen};
  if (Flag("has_loaded")) {
    loads_ohm.push_back(motor.resistance_ohm * Decades("load_over_coil", 0.1, 10));
  }
  std::vector<fit::PreparedRecord> records;
  for (const double load_ohm : loads_ohm) {
    auto prepared = fit::PrepareRecord(Dropped(motor, recording, load_ohm, noise));
    if (!prepared) return false;
    records.push_back(*std::move(prepared));
  }
  const auto fit = fit::FitDropTest(
      std::move(records), {Quantity{motor.moving_mass_kg, 0}, Quantity{motor.case_mass_kg, 0},
                           Quantity{motor.resistance_ohm, 0}, Quantity{motor.inductance_h, 0}});
  if (!fit || fit->findings.Refused() || !fit->converged) return false;
  HoldTruth("Kv, in standard uncertainties", fit->stiffness, motor.stiffness_n_per_m);
  HoldTruth("Bv, in standard uncertainties", fit->damping, motor.damping_n_s_per_m);
  HoldTruth("Km, in standard uncertainties", fit->force_constant, motor.force_constant_n_per_a);
  return true;
}

}  // namespace haptometer::search
