#include "sim/ring_down.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "sim/linear/linear_model.h"
#include "sim/linear/time_response.h"
#include "tests/residual.h"
#include "tests/sim/ring_ratios.h"

namespace haptometer::sim {
namespace {

constexpr double kOpen = std::numeric_limits<double>::infinity();
constexpr double kMover = 1.4e-3;
constexpr double kReduced = 1.4e-3 * 0.6e-3 / 2.0e-3;

// Lindsay 2013, Table 2.1
RingDownParameters<double> Thesis(double mass_kg, double load_ohm, double inductance_h = 130e-6) {
  return {.stiffness_n_per_m = 2800,
          .damping_n_s_per_m = 0.0322,
          .force_constant_squared_n2_per_a2 = 1.0,
          .mass_kg = mass_kg,
          .coil_resistance_ohm = 27,
          .inductance_h = inductance_h,
          .load_ohm = load_ohm};
}

double DampedFrequency(const RingDown<double>& circuit) {
  return std::sqrt(circuit.stiffness_per_s2() - circuit.decay_per_s() * circuit.decay_per_s()) /
         (2 * std::numbers::pi);
}

TEST(RingDown, PolesAreThoseOfTheClosedFormsWithoutInductance) {
  struct Row {
    double mass_kg, load_ohm, decay_per_s, damped_hz;
  };
  // sigma = (Bv + Km^2/(R+RL))/(2M), to the digits printed
  const std::array rows{
      Row{kMover, kOpen, 11.5000, 225.0716},   Row{kMover, 1e7, 11.50004, 225.0716},
      Row{kMover, 1e6, 11.5004, 225.0716},     Row{kMover, 1e3, 11.8478, 225.0712},
      Row{kMover, 100, 14.3121, 225.0676},     Row{kMover, 50, 16.1382, 225.0644},
      Row{kMover, 27, 18.1138, 225.0606},      Row{kMover, 0, 24.7275, 225.0447},
      Row{kReduced, kOpen, 38.3333, 410.8910}, Row{kReduced, 0, 82.4250, 410.7269}};
  for (const Row& row : rows) {
    SCOPED_TRACE(row.load_ohm);
    const RingDown<double> circuit(Thesis(row.mass_kg, row.load_ohm, 0));
    EXPECT_ABS(circuit.decay_per_s(), row.decay_per_s, 6e-5, "printed digits");
    EXPECT_ABS(DampedFrequency(circuit), row.damped_hz, 6e-5, "printed digits");
  }
}

TEST(RingDown, InductanceShiftsTheTwoLoadFormula) {
  // Km^2 = 2 M (d1 - d0)(R + RL) holds for L = 0; the coil's 130 uH moves Km by these parts
  for (const auto& [mass_kg, shift] : {std::pair{kMover, 38e-6}, std::pair{kReduced, 126e-6}}) {
    const RingDown<double> open(Thesis(mass_kg, kOpen));
    const RingDown<double> loaded(Thesis(mass_kg, 27));
    const double square = 2 * mass_kg * (loaded.decay_per_s() - open.decay_per_s()) * 54;
    EXPECT_ABS(std::sqrt(square) - 1, shift, 5e-7, "to the millionth");
    const RingDown<double> ideal(Thesis(mass_kg, 27, 0));
    EXPECT_REL(2 * mass_kg * (ideal.decay_per_s() - open.decay_per_s()) * 54, 1.0, 1e-14,
               "exact without inductance");
  }
}

// u(t) by the five-state exponential: the coil closed over R + RL, the case of any mass free in the
// air
void ExpectExponential(double case_mass_kg, double load_ohm, double tolerance) {
  const double reduced_kg = kMover * case_mass_kg / (kMover + case_mass_kg);
  const Actuator actuator{.moving_mass_kg = kMover,
                          .case_mass_kg = case_mass_kg,
                          .stiffness_n_per_m = 2800,
                          .damping_n_s_per_m = 0.0322,
                          .force_constant_n_per_a = 1.0,
                          .resistance_ohm = 27 + load_ohm,
                          .inductance_h = 130e-6};
  const LinearModel model = AssembleModel(actuator, std::nullopt, Skin{});
  Eigen::VectorXd blow = Eigen::VectorXd::Zero(model.states());
  // zero momentum, unit relative velocity
  blow[LinearModel::kMoverVelocity] = case_mass_kg / (kMover + case_mass_kg);
  blow[LinearModel::kCaseVelocity] = -kMover / (kMover + case_mass_kg);
  const TimeResponse exact(model, {.amplitude_v = 0, .frequency_hz = 1}, blow);
  const RingDown<double> circuit(Thesis(reduced_kg, load_ohm));
  const double peak = load_ohm / (27 + load_ohm);
  double worst = 0;
  for (const double t : {0.0, 1e-6, 5e-6, 3e-5, 1e-3, 1.1e-3, 0.01, 0.05, 0.1, 0.25}) {
    const double expected = -load_ohm * model.current_row.dot(exact.StateAt(t));
    worst = std::max(worst, std::abs(VoltageRatio(circuit, t) - expected) / peak);
  }
  EXPECT_ABS(worst, 0.0, tolerance, "rounding of the exponential's squarings");
}

TEST(RingDown, EqualsTheMatrixExponentialOfTheWholeCircuit) {
  // above 100 ohm the exponential itself loses the twelfth digit: its fast pole is 1e7 1/s
  for (const double load_ohm : {5.0, 27.0, 33.0, 100.0}) {
    SCOPED_TRACE(load_ohm);
    ExpectExponential(0.6e-3, load_ohm, 1e-12);
    ExpectExponential(1.0, load_ohm, 1e-12);  // as good as held: 0.14 percent off
  }
}

// exp(A t) by Taylor series and squaring in extended precision: an oracle of its own
// of the state current, displacement, speed
using Matrix = std::array<std::array<long double, 3>, 3>;
Matrix Extended(const RingDownParameters<double>& p, double t) {
  const auto times = [](const Matrix& a, const Matrix& b) {
    Matrix c{};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t k = 0; k < 3; ++k) c[i][j] += a[i][k] * b[k][j];
      }
    }
    return c;
  };
  const long double step = std::ldexp(static_cast<long double>(t), -24);
  const auto m = static_cast<long double>(p.mass_kg);
  const auto l = static_cast<long double>(p.inductance_h);
  const auto r = static_cast<long double>(p.coil_resistance_ohm);
  const auto rl = static_cast<long double>(p.load_ohm);
  const auto km = std::sqrt(static_cast<long double>(p.force_constant_squared_n2_per_a2));
  const auto kv = static_cast<long double>(p.stiffness_n_per_m);
  const auto bv = static_cast<long double>(p.damping_n_s_per_m);
  const Matrix a{{{-(r + rl) / l * step, 0, km / l * step},
                  {0, 0, step},
                  {-km / m * step, -kv / m * step, -bv / m * step}}};
  // exp - 1 is squared as (1 + E)^2 - 1 = 2 E + E^2, which keeps the small digits
  Matrix excess{};
  Matrix term{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (int k = 1; k <= 22; ++k) {
    term = times(term, a);
    for (auto& row : term) {
      for (auto& entry : row) entry /= k;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) excess[i][j] += term[i][j];
    }
  }
  for (int k = 0; k < 24; ++k) {
    const Matrix square = times(excess, excess);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) excess[i][j] = 2 * excess[i][j] + square[i][j];
    }
  }
  for (std::size_t i = 0; i < 3; ++i) excess[i][i] += 1;
  return excess;
}

TEST(RingDown, EqualsAnExtendedPrecisionExponential) {
  for (const double load_ohm : {5.0, 33.0, 1000.0}) {
    for (const double inductance_h : {1e-6, 130e-6, 2e-3}) {
      const auto parameters = Thesis(kMover, load_ohm, inductance_h);
      const RingDown<double> circuit(parameters);
      double worst = 0;
      for (const double t : {1e-6, 5e-6, 3e-5, 1e-3, 1.1e-3, 0.01, 0.05, 0.1, 0.25}) {
        const auto expected = -load_ohm * static_cast<double>(Extended(parameters, t)[0][2]);
        worst = std::max(worst, std::abs(VoltageRatio(circuit, t) - expected));
      }
      EXPECT_ABS(worst, 0.0, 1e-14 * load_ohm / (27 + load_ohm), "argument rounding, 56 cycles");
    }
  }
}

TEST(RingDown, DisplacementAndReleaseEqualTheExtendedPrecisionExponential) {
  const double w = std::sqrt(2800 / kMover);
  for (const double load_ohm : {5.0, 33.0, 1000.0}) {
    for (const double inductance_h : {1e-6, 130e-6, 2e-3}) {
      const auto parameters = Thesis(kMover, load_ohm, inductance_h);
      const RingDown<double> circuit(parameters);
      double worst_displacement = 0;
      double worst_release = 0;
      for (const double t : {0.0, 1e-6, 5e-6, 3e-5, 1e-3, 1.1e-3, 0.01, 0.05, 0.1, 0.25}) {
        const auto exact = Extended(parameters, t);
        const auto x = static_cast<double>(exact[1][2]);
        worst_displacement =
            std::max(worst_displacement, w * std::abs(DisplacementRatio(circuit, t) - x));
        // the current that follows from a displacement of Km I0/Kv, per Km^2 I0/M
        const double u = -load_ohm * static_cast<double>(exact[0][1]) / (w * w);
        worst_release = std::max(worst_release, w * std::abs(-ReleaseRatio(circuit, t) - u));
      }
      EXPECT_ABS(worst_displacement, 0.0, 1e-14, "argument rounding, 56 cycles");
      EXPECT_ABS(worst_release, 0.0, 1e-14 * load_ohm / (27 + load_ohm), "the same");
    }
  }
}

TEST(RingDown, OfAnOpenCircuitReleaseIsTheDisplacementOfABlow) {
  const RingDown<double> circuit(Thesis(kMover, kOpen));
  const double d = 11.5;
  const double w = std::sqrt(2e6 - d * d);
  for (const double t : {0.0, 1e-4, 1e-3, 0.0123, 0.2}) {
    const double swing_s = std::exp(-d * t) * std::sin(w * t) / w;
    EXPECT_ABS(w * DisplacementRatio(circuit, t), w * swing_s, 2e-15, "argument rounding");
    EXPECT_ABS(w * ReleaseRatio(circuit, t), -w * swing_s, 2e-15, "argument rounding");
  }
}

TEST(RingDown, OpenCircuitIsTheVelocity) {
  const RingDown<double> circuit(Thesis(kMover, kOpen));
  const double d = 11.5;
  const double w = std::sqrt(2e6 - d * d);
  for (const double t : {0.0, 1e-4, 1e-3, 0.0123, 0.2}) {
    const double velocity = std::exp(-d * t) * (std::cos(w * t) - d / w * std::sin(w * t));
    EXPECT_ABS(VoltageRatio(circuit, t), -velocity, 2e-15,
               "argument rounding at the decayed amplitude");
  }
}

TEST(RingDown, LimitsAreContinuous) {
  // a load of 1e15 ohm is an open circuit, and 1e-18 H is no inductance
  const RingDown<double> open(Thesis(kMover, kOpen));
  const RingDown<double> nearly_open(Thesis(kMover, 1e15));
  const RingDown<double> without(Thesis(kMover, 33, 0));
  const RingDown<double> nearly_without(Thesis(kMover, 33, 1e-18));
  for (const double t : {1e-4, 1.7e-3, 0.09}) {
    EXPECT_ABS(VoltageRatio(nearly_open, t), VoltageRatio(open, t), 1e-13, "27e-15 of divider");
    EXPECT_ABS(VoltageRatio(nearly_without, t), VoltageRatio(without, t), 1e-13, "tau 2e-20 s");
  }
  // with inductance the current and so the loaded voltage begin at zero
  EXPECT_EQ(VoltageRatio(RingDown<double>(Thesis(kMover, 33)), 0.0), 0.0);
}

TEST(RingDown, AFaintForceConstantDampsInProportionToItsSquare) {
  // without inductance 2 d M = Bv + Km^2/(R+RL), through 0 and below it
  for (const double square : {1.0, 1e-3, 0.0, -1e-3}) {
    auto parameters = Thesis(kMover, 33, 0);
    parameters.force_constant_squared_n2_per_a2 = square;
    EXPECT_REL(RingDown<double>(parameters).decay_per_s(), (0.0322 + square / 60) / (2 * kMover),
               1e-15, "rounding");
  }
}

TEST(DampedFundamentals, CriticalDampingIsOrdinary) {
  const double w = 1414.0;
  for (const double zeta : {0.9, 0.999999, 1 - 1e-12, 1.0, 1 + 1e-12, 1.000001, 1.1}) {
    for (const double time_s : {0.0, 1e-5, 3.5e-4, 1e-3, 5e-3}) {
      SCOPED_TRACE(testing::Message() << zeta << " at " << time_s);
      const auto pair = DampedFundamentals(zeta * w, w * w, time_s);
      // in extended precision, by exponentials away from and by their limit at the double pole
      const auto t = static_cast<long double>(time_s);
      const auto s = static_cast<long double>(zeta * w);
      const long double square = s * s - static_cast<long double>(w * w);
      const long double z = square * t * t;
      const long double r = std::sqrt(std::abs(square));
      long double even = std::exp(-s * t);
      long double odd = even * t;
      if (std::abs(z) < 1e-5L) {
        even *= 1 + z / 2 + z * z / 24;
        odd *= 1 + z / 6 + z * z / 120;
      } else {
        even *= square < 0 ? std::cos(r * t) : std::cosh(r * t);
        odd = std::exp(-s * t) * (square < 0 ? std::sin(r * t) : std::sinh(r * t)) / r;
      }
      const double scale = std::exp(-zeta * w * time_s);
      EXPECT_ABS(pair.even / scale, static_cast<double>(even) / scale, 1e-14, "rounding of w t");
      EXPECT_ABS(w * pair.odd / scale, w * static_cast<double>(odd) / scale, 1e-14,
                 "rounding of w t");
    }
  }
}

TEST(DampedFundamentals, TheThreeFormsMeet) {
  // r t = 1/2 is where series and elementary functions meet, on both sides
  const double t = 1.0;
  for (const double sign : {-1.0, 1.0}) {
    const double q = 1.0 - sign * 0.25;
    const auto below = DampedFundamentals(1.0, q + sign * 1e-15, t);
    const auto above = DampedFundamentals(1.0, q - sign * 1e-15, t);
    EXPECT_REL(below.even, above.even, 2e-15, "a step of 2e-15 in q");
    EXPECT_REL(below.odd, above.odd, 2e-15, "a step of 2e-15 in q");
  }
}

TEST(DampedFundamentals, HeavyDampingNeitherOverflowsNorLosesTheSlowRoot) {
  // roots 1e8 and 2e-2 per second
  const auto pair = DampedFundamentals(0.5e8, 2e6, 10.0);
  EXPECT_REL(pair.odd, std::exp(-0.2) / 1e8, 1e-9, "2e-2 * (1 + 2e-10) for the slow root");
  EXPECT_REL(pair.even, 0.5 * std::exp(-0.2), 1e-9, "2e-2 * (1 + 2e-10) for the slow root");
}

}  // namespace
}  // namespace haptometer::sim
