#include "dsp/filter/zero_phase.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/dsp/filter/scipy_reference.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 10e3;

TEST(ZeroPhase, AToneKeepsItsPhaseAndHasTheSquaredGain) {
  for (int order = 1; order <= kHighestOrder; ++order) {
    const FilterDesign design = Designed({order, 20, 500}, kRateHz);
    const std::vector<double> in = Samples(kRateHz, 60'000, 0.03, {{1e-6, 450, 0.3}});
    const std::vector<double> out = FilterZeroPhase(design, in);
    const double gain = std::norm(Response(design, 450));
    double worst_m = 0;
    for (std::size_t k = 29'000; k < 31'000; ++k) {
      const double phase = 2 * std::numbers::pi * 450 * static_cast<double>(k) / kRateHz + 0.3;
      worst_m = std::max(worst_m, std::abs(out[k] - gain * 1e-6 * std::sin(phase)));
    }
    EXPECT_ABS(worst_m, 0, 2e-17, "the input's own rounding at 30 mm, 3.5e-18 m");
  }
}

TEST(ZeroPhase, IsTheFilterOfScipyWhereThePaddingAgrees) {
  const std::vector<double> in = ScipyInput(kScipySamples);
  for (const FilteredSample& sample : kScipyFiltered) {
    const FilterDesign design = Designed({sample.order, 20, 500, Corners::kEach}, kRateHz);
    EXPECT_ABS(FilterZeroPhase(design, in)[sample.index], sample.zero_phase_m, 1e-12,
               "what 0.3 s of SciPy's padding leave at order 5, exp(-0.3 s x 38/s) of 0.1 um");
  }
}

TEST(ZeroPhase, ATurnedSignalGivesTheTurnedResult) {
  const FilterDesign design = Designed({6, 20, 500}, kRateHz);
  std::vector<double> in = Samples(kRateHz, 20'000, 0.03, {{1e-6, 100}, {3e-7, 333, 1}});
  const std::vector<double> out = FilterZeroPhase(design, in);
  std::ranges::reverse(in);
  const std::vector<double> turned = FilterZeroPhase(design, in);
  double worst_m = 0;
  for (std::size_t k = 0; k < in.size(); ++k) {
    worst_m = std::max(worst_m, std::abs(turned[in.size() - 1 - k] - out[k]));
  }
  EXPECT_ABS(worst_m, 0, 1e-16, "what the padding leaves");
}

TEST(ZeroPhase, ShortSignalsAreContinuedAsFarAsTheyReach) {
  const FilterDesign design = Designed({6, 20, 500}, kRateHz);
  EXPECT_TRUE(FilterZeroPhase(design, {}).empty());
  EXPECT_EQ(FilterZeroPhase(design, std::vector{0.03}), std::vector{0.0});
  for (const double y : FilterZeroPhase(design, std::vector{0.03, 0.03, 0.03})) EXPECT_EQ(y, 0);
  // two samples: a step, odd about each
  const std::vector<double> step = FilterZeroPhase(design, std::vector{0.0, 1e-6});
  EXPECT_NEAR(step[0], -step[1], 1e-20);
}

TEST(ZeroPhase, RingingIsTheSlowestPoles) {
  const FilterDesign design = Designed({6, 20, 500}, kRateHz);
  const auto samples = static_cast<double>(RingingSamples(design, 1e-6));
  EXPECT_NEAR(samples / kRateHz, std::log(1e6) / SlowestDecayPerS(design), 1 / kRateHz);
}

}  // namespace
}  // namespace haptometer::dsp
