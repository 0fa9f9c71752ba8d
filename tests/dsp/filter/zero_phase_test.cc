#include "dsp/filter/zero_phase.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "dsp/filter/settled.h"
#include "dsp/statistics/moments.h"
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
  std::vector<double> in(kScipySamples);
  std::uint32_t x = 1;
  for (double& value : in) {
    x = (1103515245U * x + 12345U) & 0x7fffffffU;
    value = 1e-3 + 1e-6 * (x / 2147483648.0 - 0.5);
  }
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

// what a record of 1 s cut out of a long one says, against the long one
struct CutOut {
  std::size_t settled = 0;
  double worst = 0;  // within the settled window, in band RMS
};

CutOut Compare(const FilterDesign& design, std::size_t cut, const std::vector<Sine>& sines) {
  const std::vector<double> record = Samples(kRateHz, 120'000, 0.03, sines);
  const std::vector<double> truth = FilterZeroPhase(design, record);
  constexpr std::size_t kFrom = 51'234;
  const SettledSignal settled = FilterSettled(design, std::span(record).subspan(kFrom, cut));
  const double rms = Rms(std::span(truth).subspan(kFrom, cut));
  CutOut result{settled.end - settled.begin, 0};
  for (std::size_t k = settled.begin; k < settled.end; ++k) {
    result.worst = std::max(result.worst, std::abs(settled.filtered[k] - truth[kFrom + k]) / rms);
  }
  return result;
}

TEST(Settled, ACutOutAgreesWithTheLongRecord) {
  const FilterDesign design = Designed({6, 20, 500}, kRateHz);
  const CutOut tone = Compare(design, 10'000, {{1e-6, 100}});
  EXPECT_GT(tone.settled, 2500U);
  EXPECT_ABS(tone.worst, 0, 1e-4, "settled tolerance, times 2 for what neither continuation knows");
  const CutOut drifting = Compare(design, 10'000, {{1e-6, 100}, {1e-3, 0.2, 0.4}});
  EXPECT_GT(drifting.settled, 1000U);
  EXPECT_ABS(drifting.worst, 0, 1e-4, "as above");
  const CutOut tremor = Compare(design, 20'000, {{1e-6, 100}, {0.5e-3, 8.3, 0.7}});
  EXPECT_GT(tremor.settled, 5000U);
  EXPECT_ABS(tremor.worst, 0, 1e-4, "as above");
}

TEST(Settled, StrongTremorLeavesNothingOfOneSecond) {
  const FilterDesign design = Designed({6, 20, 500}, kRateHz);
  const CutOut tremor = Compare(design, 10'000, {{1e-6, 100}, {0.5e-3, 8.3, 0.7}});
  EXPECT_LT(tremor.settled, 1000U);
}

TEST(Settled, AConstantHasSettledEverywhere) {
  const FilterDesign design = Designed({6, 20, 500}, kRateHz);
  const SettledSignal settled = FilterSettled(design, std::vector<double>(100, 0.03));
  EXPECT_EQ(settled.begin, 0U);
  EXPECT_EQ(settled.end, 100U);
}

// RMS of 1 um of vibration at 100 Hz on 0.5 mm of tremor at 8.3 Hz, against the vibration's own
double TremorRatio(const BandPass& band) {
  const FilterDesign design = Designed(band, kRateHz);
  const std::vector<double> in = Samples(kRateHz, 120'000, 0.03, {{1e-6, 100}, {0.5e-3, 8.3}});
  const std::vector<double> out = FilterZeroPhase(design, in);
  return Rms(std::span(out).subspan(10'000, 100'000)) / (1e-6 / std::numbers::sqrt2);
}

TEST(Settled, TremorLeaksAsTheClosedFormSays) {
  struct Case {
    BandPass band;
    double published;
  };
  for (const Case& c :
       {Case{{4, 20, 500, Corners::kEach}, 1.055}, Case{{4, 20, 500, Corners::kWhole}, 1.287},
        Case{{6, 20, 500, Corners::kWhole}, 1.0002}}) {
    const FilterDesign design = Designed(c.band, kRateHz);
    const double tone = std::norm(Response(design, 100));
    const double leaked = 500 * std::norm(Response(design, 8.3));
    const double ratio = TremorRatio(c.band);
    EXPECT_REL(ratio, std::hypot(tone, leaked), 1e-9, "both signals hold whole periods of 10 s");
    EXPECT_REL(ratio, c.published, 5e-4, "the figure's digits");
  }
}

}  // namespace
}  // namespace haptometer::dsp
