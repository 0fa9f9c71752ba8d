#pragma once

// The adapter scene of the thesis for those who solve it without sim/: the equations of motion of
// its bodies, written once more. Number: double, or one of 113 bits.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

namespace haptometer::sim {

// the states, as LinearModel has them, and an eighth: the coil's rise, or the skin's own position
inline constexpr std::size_t kXv = 0, kVv = 1, kXa = 2, kVa = 3, kXs = 4, kVs = 5, kCurrent = 6;
inline constexpr std::size_t kEighth = 7;
inline constexpr std::size_t kMostBodyStates = 8;

/// Lindsay 2013, Tables 2.1 and 2.4; 5 V at 225 Hz.
struct Bodies {
  double Mv = 1.4e-3, Mc = 0.6e-3, Kv = 2800, Bv = 0.0322, Km = 1, R = 27, L = 130e-6;
  double Ma1 = 0.25e-3, Ma2 = 4.35e-3, Ka = 8200, Ba = 0.01, Ks = 600, Bs = 0.75;
  double volt = 5, frequency_hz = 225;
};

/// A class of scenes: what is asked of every method, from rest, at equal outputs.
struct Question {
  std::string name;
  double gap_m = 0;  ///< of rigid stops on both sides; 0: none
  double restitution = 0;
  double preload_n = 0;              ///< of a contact that breaks; 0: the skin also pulls
  double cubic_n_per_m3 = 0;         ///< of the mover's spring
  double sag_m = 0;                  ///< where that spring rests (sim/scene/effects.h)
  double heat_capacity_j_per_k = 0;  ///< of the coil; 0: it does not heat
  double thermal_resistance_k_per_w = 0;
  double rate_hz = 1e4;
  std::size_t outputs = 1000;
  Bodies bodies{};

  [[nodiscard]] std::size_t states() const {
    return heat_capacity_j_per_k > 0 || preload_n > 0 ? kMostBodyStates : kMostBodyStates - 1;
  }
  /// Those that are compared: the skin's own position means something in flight only.
  [[nodiscard]] std::size_t compared() const { return preload_n > 0 ? 7 : states(); }
  [[nodiscard]] double TimeOf(std::size_t output) const {
    return static_cast<double>(output) / rate_hz;
  }
};

/// Of copper, per K, as sim/scene/effects.h has it.
inline constexpr double kRisePerK = 3.93e-3;

/// y' at a terminal voltage. In flight the skin follows by itself.
inline void RateOf(const Question& question, bool contact, double volt, const double* y,
                   double* rate) {
  const Bodies& b = question.bodies;
  const double d = y[kXv] - y[kXa];
  const double hardening =
      question.cubic_n_per_m3 * (d * d + 3 * question.sag_m * (d + question.sag_m));
  const double spring = d * (b.Kv + hardening) + b.Bv * (y[kVv] - y[kVa]);
  const double joint = b.Ka * (y[kXa] - y[kXs]) + b.Ba * (y[kVa] - y[kVs]);
  const double skin = contact ? b.Ks * y[kXs] + b.Bs * y[kVs] : -question.preload_n;
  const bool heats = question.heat_capacity_j_per_k > 0;
  const double i = y[kCurrent];
  const double drop = heats ? b.R * (1 + kRisePerK * y[kEighth]) * i : b.R * i;
  rate[kXv] = y[kVv];
  rate[kVv] = -(b.Km * i + spring) / b.Mv;
  rate[kXa] = y[kVa];
  rate[kVa] = (b.Km * i + spring - joint) / (b.Mc + b.Ma1);
  rate[kXs] = y[kVs];
  rate[kVs] = (joint - skin) / b.Ma2;
  rate[kCurrent] = (volt - drop + b.Km * (y[kVv] - y[kVa])) / b.L;
  if (heats) {
    rate[kEighth] = (drop * i - y[kEighth] / question.thermal_resistance_k_per_w) /
                    question.heat_capacity_j_per_k;
  } else if (question.preload_n > 0) {
    rate[kEighth] = contact ? 0 : -(question.preload_n + b.Ks * y[kEighth]) / b.Bs;
  }
}

/// What must not fall below zero: the gaps up and down, then the contact's force or, in flight, its
/// gap. In the units of force and length; those that the question lacks stay positive.
template <typename Number>
std::array<Number, 3> GuardsOf(const Question& question, bool contact, const Number* y) {
  std::array<Number, 3> guards{Number(1), Number(1), Number(1)};
  if (question.gap_m > 0) {
    guards[0] = Number(question.gap_m) - (y[kXv] - y[kXa]);
    guards[1] = Number(question.gap_m) + (y[kXv] - y[kXa]);
  }
  if (question.preload_n > 0) {
    const Bodies& b = question.bodies;
    guards[2] = contact ? Number(question.preload_n) + Number(b.Ks) * y[kXs] + Number(b.Bs) * y[kVs]
                        : y[kEighth] - y[kXs];
  }
  return guards;
}

/// What happens when a guard has fallen.
template <typename Number>
void Cross(const Question& question, std::size_t guard, bool* contact, Number* y) {
  const Bodies& b = question.bodies;
  if (guard == 2) {
    *contact = !*contact;
    if (!*contact) y[kEighth] = y[kXs];
    return;
  }
  const Number Mc1 = Number(b.Mc) + Number(b.Ma1);
  const Number impulse =
      (1 + Number(question.restitution)) * (y[kVv] - y[kVa]) / (1 / Number(b.Mv) + 1 / Mc1);
  y[kVv] -= impulse / Number(b.Mv);
  y[kVa] += impulse / Mc1;
}

inline double AngularFrequency(const Question& question) {
  return 2 * std::numbers::pi * question.bodies.frequency_hz;
}

/// d rate / d y, column by column, from the linear part that LinearPart() has made.
void JacobianAt(const Question& question, const Eigen::MatrixXd& linear, const double* y,
                double* jacobian);

/// RateOf without the cubic and the coil's rise, as a matrix.
[[nodiscard]] Eigen::MatrixXd LinearPart(const Question& question, bool contact);

}  // namespace haptometer::sim
