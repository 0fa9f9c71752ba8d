#include "fit/drop_test/condensed_record.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "fit/drop_test/ring_down_problem.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

constexpr double kOpen = std::numeric_limits<double>::infinity();
constexpr double kStepS = 6e-5;

// [J r]'[J r] of a linearised problem, each column in units of `lengths`
std::vector<double> Products(const Jacobian& at, const std::vector<double>& lengths) {
  const std::size_t width = at.columns + 1;
  std::vector<double> products(width * width);
  for (std::size_t n = 0; n < at.rows; ++n) {
    std::vector<double> row(at.values.begin() + static_cast<std::ptrdiff_t>(n * at.columns),
                            at.values.begin() + static_cast<std::ptrdiff_t>((n + 1) * at.columns));
    row.push_back(at.residuals[n]);
    for (std::size_t i = 0; i < width; ++i) {
      for (std::size_t j = 0; j < width; ++j) {
        products[i * width + j] += row[i] / lengths[i] * row[j] / lengths[j];
      }
    }
  }
  return products;
}

std::vector<double> Lengths(const Jacobian& at) {
  const std::size_t width = at.columns + 1;
  const auto squares = Products(at, std::vector<double>(width, 1.0));
  std::vector<double> lengths;
  for (std::size_t k = 0; k < width; ++k) {
    const double square = squares[k * width + k];
    lengths.push_back(square > 0 ? std::sqrt(square) : 1);
  }
  return lengths;
}

struct Case {
  std::string name;
  RingDownSamples record;
  double damping = 0.0322;
};

RingDownSamples Samples() {
  RingDownSamples record;
  for (int n = 0; n < 900; ++n) {
    record.times_s.push_back(1e-3 + kStepS * n);
    record.voltages_v.push_back(0.3 * std::sin(0.09 * n) * std::exp(-0.001 * n) +
                                0.01 * std::sin(0.001 * n * n));
  }
  record.step_s = kStepS;
  record.noise_v = 0.02;
  record.load_ohm = 33;
  record.polarity = -1;
  return record;
}

void Erase(RingDownSamples& record, std::ptrdiff_t first, std::ptrdiff_t count) {
  for (auto* values : {&record.times_s, &record.voltages_v}) {
    values->erase(values->begin() + first, values->begin() + first + count);
  }
}

std::vector<Case> Cases() {
  std::vector<Case> cases{{"whole", Samples()}, {"open", Samples()}, {"holes", Samples()}};
  cases[1].record.load_ohm = kOpen;
  Erase(cases[2].record, 700, 3);
  Erase(cases[2].record, 130, 1);
  cases.push_back({"off the grid", Samples()});
  for (std::size_t n = 300; n < 900; ++n) cases.back().record.times_s[n] += 0.3 * kStepS;
  cases.push_back({"drift and hum", Samples()});
  cases.back().record.drifts = true;
  cases.back().record.hum_hz = {50};
  cases.push_back({"hum and harmonics", Samples()});
  cases.back().record.hum_hz = {50, 100, 150, 250};
  cases.push_back({"drift", Samples()});
  cases.back().record.drifts = true;
  cases.push_back({"from before the blow", Samples()});
  for (double& time_s : cases.back().record.times_s) time_s -= 2e-3;
  // 2 us behind the blow: the current's own decay takes as long
  cases.push_back({"within the coil's current", Samples()});
  for (double& time_s : cases.back().record.times_s) time_s -= 1e-3 - 2.2e-5;
  cases.push_back({"weights", Samples()});
  for (int n = 0; n < 900; ++n) {
    cases.back().record.root_weights.push_back(n % 7 == 0 ? 0.3 : 1.0);
  }
  cases.push_back({"clock", Samples()});
  cases.back().record.time_scale = 1.01;
  cases.push_back({"given speed", Samples()});
  cases.back().record.speed_m_per_s = 0.44;
  cases.push_back({"displacement", Samples()});
  cases.back().record.signal = RingingSignal::kBlowDisplacement;
  cases.push_back({"release", Samples()});
  cases.back().record.signal = RingingSignal::kReleaseVoltage;
  cases.back().record.release_current_a = 0.1;
  const double critical = 2 * std::sqrt(2800 * 1.4e-3);
  cases.push_back({"strong damping", Samples(), 0.8 * critical});
  cases.push_back({"critical damping", Samples(), critical});
  cases.push_back({"beyond it", Samples(), 2 * critical});
  return cases;
}

TEST(CondensedRecord, HasTheSquaresAndProductsOfAllSamples) {
  for (const auto& [name, record, damping] : Cases()) {
    SCOPED_TRACE(name);
    const RingDownProblem problem({Samples(), record}, 130e-6);
    RingDownPoint point;
    point.shared = {std::log(2800), std::log(damping), 1.21, std::log(1.4e-3), std::log(27)};
    point.own.assign(2, {std::log(0.4), 2e-5, 0.01, 0, 0, 0});
    const Jacobian whole = problem.Linearise(point);
    const Jacobian condensed = problem.Condense(point);
    EXPECT_EQ(condensed.rows, 2 * (kSharedCount + kOwnCount + 1));
    // what a record has no hum or drift for is a column that no fit frees
    const auto lengths = Lengths(whole);
    const auto expected = Products(whole, lengths);
    const auto found = Products(condensed, lengths);
    const std::size_t width = whole.columns + 1;
    double worst = 0;
    for (std::size_t i = 0; i < width; ++i) {
      for (std::size_t j = 0; j < width; ++j) {
        if (found[i * width + i] == 0 || found[j * width + j] == 0) continue;
        worst = std::max(worst, std::abs(found[i * width + j] - expected[i * width + j]));
      }
    }
    EXPECT_ABS(worst, 0, 2e-14, "rounding of 900 samples' sums");
    const std::size_t columns = whole.columns;
    for (std::size_t k = 0; k < columns; ++k) {
      const bool is_disturbance =
          k >= kSharedCount && (k - kSharedCount) % kOwnCount >= Index(Own::kDrift);
      if (is_disturbance) continue;
      EXPECT_EQ(found[k * width + k] > 0, expected[k * width + k] > 0) << "column " << k;
    }
  }
}

TEST(CondensedRecord, ChangesInProductWithTheDerivativesAreTheRowsOwn) {
  const RingDownProblem problem({Samples(), Samples()}, 130e-6);
  RingDownPoint point;
  point.shared = {std::log(2800), std::log(0.0322), 1.21, std::log(1.4e-3), std::log(27)};
  point.own = {{std::log(0.4), 2e-5, 0.01, 0, 0, 0}, {std::log(0.3), -2e-5, 0.02, 0, 0, 0}};
  const Jacobian whole = problem.Linearise(point);
  std::vector<double> change(whole.rows);
  for (std::size_t n = 0; n < change.size(); ++n)
    change[n] = std::cos(0.1 * static_cast<double>(n));
  const auto products = problem.Products(point, change);
  for (std::size_t k = 0; k < whole.columns; ++k) {
    double sum = 0;
    double sizes = 0;
    for (std::size_t n = 0; n < whole.rows; ++n) {
      const double term = whole.values[n * whole.columns + k] * change[n];
      sum += term;
      sizes += std::abs(term);
    }
    EXPECT_ABS((products[k] - sum) / std::max(sizes, 1e-300), 0, 1e-14, "rounding of 1800 terms");
  }
}

TEST(CondensedRecord, OneThatSwingsIsCondensedAndOneThatCreepsIsNot) {
  const RingDownSamples record = Samples();
  EXPECT_TRUE(CanBeCondensed(record, {.decay_per_s = 12, .stiffness_per_s2 = 2e6}));
  EXPECT_FALSE(CanBeCondensed(record, {.decay_per_s = 1414, .stiffness_per_s2 = 2e6}));
  EXPECT_FALSE(CanBeCondensed(record, {.decay_per_s = 3000, .stiffness_per_s2 = 2e6}));
  EXPECT_FALSE(CanBeCondensed(record, {.decay_per_s = 12, .stiffness_per_s2 = 2e6, .impact_s = 1}))
      << "nothing follows the blow";
}

}  // namespace
}  // namespace haptometer::fit
