#include "dsp/analysis/tone_in_values.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "tests/dsp/signals.h"

namespace haptometer::dsp {
namespace {

TEST(ToneInValues, IsTakenOutWhateverItsPhase) {
  for (const double phase : {0.0, 0.9, 2.5}) {
    std::vector<double> values = Samples(1000, 137, 0, {{3, 41.3, phase}});
    TakeOutNearest(TurnsOf(41.3, 1000, values.size()), values);
    for (const double value : values) EXPECT_NEAR(value, 0, 1e-12);
  }
}

TEST(ToneInValues, IsLeftWhereItIsMoreThanTheMost) {
  const std::vector<double> values = Samples(1000, 137, 0, {{3, 41.3, 0.9}});
  std::vector<double> left = values;
  TakeOutNearest(TurnsOf(41.3, 1000, left.size()), left, 2.9);
  EXPECT_EQ(left, values);
}

TEST(ToneInValues, HasItsAmplitudeOverWholePeriods) {
  EXPECT_NEAR(SquaredAmplitude(Samples(1000, 200, 0, {{3, 40, 0.9}}), 1000, 40), 9, 1e-12);
}

TEST(ToneInValues, RunningSumsAreTheStretchesOwn) {
  const std::vector<double> values = Samples(1000, 300, 0, {{3, 41.3, 0.9}, {1, 90, 0}});
  const ToneSums sums(values, 1000, 41.3);
  for (const std::size_t begin : {0U, 7U, 251U}) {
    const auto stretch = std::span(values).subspan(begin, 49);
    EXPECT_NEAR(sums.SquaredAmplitudeOf(begin, 49), SquaredAmplitude(stretch, 1000, 41.3), 1e-12);
  }
}

}  // namespace
}  // namespace haptometer::dsp
