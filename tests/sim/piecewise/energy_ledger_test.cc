#include "sim/piecewise/energy_ledger.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

#include "sim/linear/driven_step.h"
#include "sim/linear/excitation.h"
#include "sim/piecewise/piecewise_motion.h"
#include "tests/residual.h"

namespace haptometer::sim {
namespace {

TEST(EnergyLedger, ImbalanceIsOverTheLargerOfBeginningAndThroughput) {
  // 3 + 2 - 1 - (1 + 2 + 0.5) = 0.5 is missing, 3.5 went out
  EnergyLedger ledger{
      .initial_j = 2, .stored_j = 1, .input_j = 3, .impact_j = 0.5, .dissipated_j = {1, 2}};
  EXPECT_REL(ledger.Imbalance(), 0.5 / 3.5, 1e-15, "rounding");
  ledger.initial_j = 5;
  EXPECT_REL(ledger.Imbalance(), 3.5 / 5, 1e-15, "rounding");
  ledger.input_j = -8;
  EXPECT_REL(ledger.Imbalance(), 7.5 / 8, 1e-15, "a source that takes energy");
  EXPECT_EQ(EnergyLedger{}.Imbalance(), 0);
  EXPECT_EQ((EnergyLedger{.initial_j = 2, .stored_j = 1, .dissipated_j = {1}}).Imbalance(), 0);
}

// by Simpson's rule in 2000 intervals
double IntegralOf(const std::function<double(double)>& f, double end) {
  constexpr int kIntervals = 2000;
  double sum = f(0) + f(end);
  for (int k = 1; k < kIntervals; ++k) sum += (k % 2 == 1 ? 4 : 2) * f(end * k / kIntervals);
  return sum * end / (3 * kIntervals);
}

// x = x0 exp(-a t) and y = y0 exp(-c t), which neither voltage nor finger reach; under a voltage
// and a finger's position, both sines
class Decay {
 public:
  static constexpr double kA = 7, kC = 0.5, kX0 = 1.5, kY0 = -0.8, kW = 11, kVolt = 3, kMove = 0.2;

  Decay()
      : mode_{.name = "decay",
              .a = Eigen::Vector2d(-kA, -kC).asDiagonal(),
              .b = Eigen::VectorXd::Zero(2),
              .positions = Eigen::MatrixXd::Zero(3, 2),
              .stored_j = {},
              .current_row = Eigen::RowVector2d(2, -1)} {
    mode_.current_per_volt = 0.3;
    mode_.positions << 1, 0, 0, 1, 2, 2;
    mode_.finger = Eigen::MatrixXd::Zero(2, 2);
    mode_.finger_force_row = Eigen::RowVectorXd::Zero(5);
    mode_.finger_force_row << 4, 1, 0, -6, 0.5;
  }

  [[nodiscard]] static double X(double t) { return kX0 * std::exp(-kA * t); }
  [[nodiscard]] static double Y(double t) { return kY0 * std::exp(-kC * t); }
  [[nodiscard]] static double Volt(double t) { return kVolt * std::sin(kW * t); }
  [[nodiscard]] static double Finger(double t) { return kMove * std::sin(kW * t); }
  [[nodiscard]] static double FingerRate(double t) { return kMove * kW * std::cos(kW * t); }

  [[nodiscard]] Mode& mode() { return mode_; }
  // forms of z = [x, y, sin, cos] over h
  [[nodiscard]] StepEnergy Over(double h_s) const {
    ExcitationShape shape{.generator = Eigen::MatrixXd::Zero(2, 2),
                          .rows = Eigen::MatrixXd::Zero(kInputs, 2),
                          .pairs = {0}};
    shape.generator << 0, kW, -kW, 0;
    shape.rows(kVoltage, 0) = kVolt;
    shape.rows(kFinger, 0) = kMove;
    shape.rows(kFingerRate, 1) = kMove * kW;
    return EnergyOver(mode_, {Eigen::RowVector3d(1, 0, 0), Eigen::RowVector3d(0, 3, 1)},
                      DrivenGenerator(mode_.a, mode_.Inputs(), shape), shape.rows, h_s);
  }
  // of a form from t = 0 on
  [[nodiscard]] static double Of(const Eigen::MatrixXd& form) {
    const Eigen::Vector4d z(kX0, kY0, 0, 1);
    return z.dot(form * z);
  }

 private:
  Mode mode_;
};

constexpr const char* kSimpson = "Simpson's rule, (w h/2000)^4 / 180, and rounding";

TEST(EnergyOver, IntegratesWhatVoltageAndFingerPutIn) {
  using D = Decay;
  for (const double h_s : {0.01, 0.3, 2.0}) {
    const double input_j = IntegralOf(
        [](double t) {
          const double current = 2 * D::X(t) - D::Y(t) + 0.3 * D::Volt(t);
          const double force = 4 * D::X(t) + D::Y(t) - 6 * D::Finger(t) + 0.5 * D::FingerRate(t);
          return D::Volt(t) * current - D::FingerRate(t) * force;
        },
        h_s);
    EXPECT_REL(D::Of(Decay().Over(h_s).input_j), input_j, 1e-9, kSimpson);
  }
}

// a form of the states, one of states and inputs, and an element that rests
TEST(EnergyOver, IntegratesEachElementByItself) {
  using D = Decay;
  Decay decay;
  Eigen::MatrixXd of_states(2, 2);
  of_states << 3, 1, 1, 2;
  Eigen::RowVectorXd damper(5);
  damper << 1, 0, 0.5, 0, -1;
  decay.mode().dissipating = {of_states, {}, damper.transpose() * damper};
  for (const double h_s : {0.01, 0.3, 2.0}) {
    const StepEnergy energy = decay.Over(h_s);
    ASSERT_EQ(energy.dissipated_j.size(), 3U);
    // 3 x^2 + 2 x y + 2 y^2
    const auto part = [&](double rate) { return -std::expm1(-rate * h_s) / rate; };
    const double closed = 3 * D::kX0 * D::kX0 * part(2 * D::kA) +
                          2 * D::kX0 * D::kY0 * part(D::kA + D::kC) +
                          2 * D::kY0 * D::kY0 * part(2 * D::kC);
    EXPECT_REL(D::Of(energy.dissipated_j[0]), closed, 1e-13, "rounding of doublings");
    EXPECT_EQ(energy.dissipated_j[1].size(), 0);
    const double damped_j = IntegralOf(
        [](double t) {
          const double speed = D::X(t) + 0.5 * D::Volt(t) - D::FingerRate(t);
          return speed * speed;
        },
        h_s);
    EXPECT_REL(D::Of(energy.dissipated_j[2]), damped_j, 1e-9, kSimpson);
  }
}

// rows over the positions, of which the third is 2 x + 2 y
TEST(EnergyOver, IntegratesSquaresOfRows) {
  using D = Decay;
  for (const double h_s : {0.01, 0.3, 2.0}) {
    const StepEnergy energy = Decay().Over(h_s);
    ASSERT_EQ(energy.squares.size(), 2U);
    const auto part = [&](double rate) { return -std::expm1(-rate * h_s) / rate; };
    EXPECT_REL(D::Of(energy.squares[0]), D::kX0 * D::kX0 * part(2 * D::kA), 1e-13,
               "rounding of doublings");
    const double square = 4 * D::kX0 * D::kX0 * part(2 * D::kA) +
                          20 * D::kX0 * D::kY0 * part(D::kA + D::kC) +
                          25 * D::kY0 * D::kY0 * part(2 * D::kC);
    EXPECT_REL(D::Of(energy.squares[1]), square, 1e-12, "rounding of doublings");
  }
}

// x = exp(s t) sin(w t + phase), whose peaks grow by 5e-8 a period and lie in the middle of output
// steps: each is above the last by far less than the chord's bulge, 7.5e-5
TEST(Ranges, HoldAPeakThatHardlyExceedsTheLast) {
  constexpr double kPi = std::numbers::pi, kOmega = 20, kGrowth = kOmega * 5e-8 / (2 * kPi);
  Mode mode{.name = "swing",
            .a = Eigen::MatrixXd::Zero(2, 2),
            .b = Eigen::VectorXd::Zero(2),
            .positions = {},
            .stored_j = Eigen::MatrixXd::Identity(2, 2) / 2,
            .current_row = Eigen::RowVectorXd::Zero(2)};
  mode.a << kGrowth, kOmega, -kOmega, kGrowth;
  for (const double sign : {1.0, -1.0}) {
    mode.watched = {{.row = Eigen::RowVector2d(sign, 0), .offset = 0}};
    const double phase = kPi / 256, rate_hz = 256 * kOmega / (2 * kPi);
    PiecewiseMotion motion({.modes = {mode}, .transitions = {}, .dissipating_elements = {}},
                           Excitation(Drive{.amplitude_v = 0, .frequency_hz = 1}),
                           {.x = Eigen::Vector2d(std::sin(phase), std::cos(phase))},
                           OutputGrid{.rate_hz = rate_hz});
    for (int periods = 1; periods <= 3; ++periods) {
      while (motion.index() < 256 * static_cast<std::uint64_t>(periods)) motion.Next();
      const double peak_s = (kPi * (2 * periods - 1.5) - phase) / kOmega;
      const double trough_s = (kPi * (2 * periods - 0.5) - phase) / kOmega;
      const double peak = std::exp(kGrowth * peak_s), trough = std::exp(kGrowth * trough_s);
      const ValueRange& range = motion.Ranges()[0];
      EXPECT_ABS(range.largest, sign > 0 ? peak : trough, 1e-13, "rounding of 700 steps");
      EXPECT_ABS(range.least, sign > 0 ? -trough : -peak, 1e-13, "rounding of 700 steps");
    }
  }
}

}  // namespace
}  // namespace haptometer::sim
