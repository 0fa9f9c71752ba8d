#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "tests/residual.h"

namespace haptometer::tests {

/// Errors of one constant over seeded repetitions, against their bound and their own statement.
class Pulls {
 public:
  /// An estimate with the standard uncertainty that is stated for it.
  void Add(double value, double truth, double standard_uncertainty) {
    const double error = value - truth;
    const double pull = error / standard_uncertainty;
    squares_ += error * error;
    errors_ += error;
    pulls_ += pull;
    pull_squares_ += pull * pull;
    ++count_;
  }
  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] double rms() const { return std::sqrt(squares_ / count_); }
  [[nodiscard]] double bias() const { return errors_ / count_; }
  [[nodiscard]] double mean() const { return pulls_ / count_; }
  [[nodiscard]] double deviation() const {
    return std::sqrt(pull_squares_ / count_ - mean() * mean());
  }

 private:
  double squares_ = 0;
  double errors_ = 0;
  double pulls_ = 0;
  double pull_squares_ = 0;
  int count_ = 0;
};

/// The bars of an efficient estimate: RMSE at most 1.05 of the Cramer-Rao bound, pulls of mean
/// within 0.15 and of deviation 0.9-1.1, each widened by 2.5 deviations of what so many repetitions
/// can tell (1 in 80 runs fails by chance; the seeds are fixed).
inline void ExpectEfficient(const Pulls& pulls, double bound, const std::string& name) {
  SCOPED_TRACE(name);
  const double slack = 2.5 / std::sqrt(2.0 * pulls.count());
  std::printf("  %s: RMSE / bound %.3f, bias %.3f sd, pulls %.3f +- %.3f of %d\n", name.c_str(),
              pulls.rms() / bound, pulls.bias() / bound, pulls.mean(), pulls.deviation(),
              pulls.count());
  EXPECT_LE(pulls.rms() / bound, 1.05 + slack);
  EXPECT_ABS(pulls.mean(), 0.0, 0.15 + std::sqrt(2.0) * slack, "of the pulls");
  EXPECT_GE(pulls.deviation(), 0.9 - slack);
  EXPECT_LE(pulls.deviation(), 1.1 + slack);
}

}  // namespace haptometer::tests
