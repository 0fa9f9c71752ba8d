#include "dsp/filter/transient.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "dsp/filter/zero_phase.h"
#include "dsp/statistics/moments.h"
#include "tests/dsp/filter/settled_signal.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 10e3;

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
  EXPECT_ABS(tone.worst, 0, 1e-4, "settled tolerance, what no continuation knows");
  const CutOut drifting = Compare(design, 10'000, {{1e-6, 100}, {1e-3, 0.2, 0.4}});
  EXPECT_GT(drifting.settled, 1000U);
  EXPECT_ABS(drifting.worst, 0, 1e-4, "as above");
  const CutOut tremor = Compare(design, 20'000, {{1e-6, 100}, {0.5e-3, 8.3, 0.7}});
  EXPECT_GT(tremor.settled, 5000U);
  EXPECT_ABS(tremor.worst, 0, 1e-4, "as above");
}

TEST(Settled, StrongTremorLeavesLittleOfOneSecond) {
  const FilterDesign design = Designed({6, 20, 500}, kRateHz);
  const CutOut tremor = Compare(design, 10'000, {{1e-6, 100}, {0.5e-3, 8.3, 0.7}});
  EXPECT_LT(tremor.settled, 1500U);
  EXPECT_ABS(tremor.worst, 0, 1e-4, "what the expected continuation is wrong by");
}

TEST(Settled, AConstantHasSettledEverywhere) {
  const FilterDesign design = Designed({6, 20, 500}, kRateHz);
  const SettledSignal settled = FilterSettled(design, std::vector<double>(100, 0.03));
  EXPECT_EQ(settled.begin, 0U);
  EXPECT_EQ(settled.end, 100U);
}

// uniform in [from, to), the same on every platform
class Uniform {
 public:
  explicit Uniform(std::uint32_t seed) : engine_(seed) {}
  double operator()(double from, double to) {
    return from + (to - from) * (static_cast<double>(engine_()) * 0x1p-32);
  }

 private:
  std::mt19937 engine_;
};

// tremor of 4-12 Hz and 0.05-0.8 mm, drift of up to 1 mm/s, a 1 um tone of 60-300 Hz
// and, where asked for, a second tremor of 0.3 times the first
std::vector<double> RandomMotion(Uniform& uniform, std::size_t count, bool second = false) {
  const double turn = 2 * std::numbers::pi;
  const Sine tremor{uniform(0.05e-3, 0.8e-3), uniform(4, 12), uniform(0, turn)};
  const Sine tone{1e-6, uniform(60, 300), uniform(0, turn)};
  const double drift_m_per_s = uniform(-1e-3, 1e-3);
  std::vector<Sine> sines{tremor, tone};
  if (second) sines.push_back({0.3 * tremor.amplitude, uniform(4, 12), uniform(0, turn)});
  std::vector<double> values = Samples(kRateHz, count, 0.03, sines);
  for (std::size_t k = 0; k < count; ++k) {
    values[k] += drift_m_per_s * static_cast<double>(k) / kRateHz;
  }
  return values;
}

// the longest stretch of errors within 1e-4
std::size_t LongestGood(const std::vector<double>& errors) {
  std::size_t longest = 0;
  std::size_t stretch = 0;
  for (const double error : errors) {
    stretch = error <= 1e-4 ? stretch + 1 : 0;
    longest = std::max(longest, stretch);
  }
  return longest;
}

// 1 s in the middle of 5 s, against the filter over all of it
struct RandomCut {
  std::size_t kept = 0;
  std::size_t good = 0;  // the longest stretch within 1e-4
  double worst = 0;      // where it is kept, in band RMS
};

RandomCut CutFrom(const FilterDesign& design, const std::vector<double>& record) {
  constexpr std::size_t kCut = 10'000;
  const std::size_t around = (record.size() - kCut) / 2;
  const std::vector<double> truth = FilterZeroPhase(design, record);
  const double rms = Rms(std::span(truth).subspan(around, kCut));
  const SettledSignal settled = FilterSettled(design, std::span(record).subspan(around, kCut));
  RandomCut cut{settled.end - settled.begin, 0, 0};
  std::vector<double> errors(kCut);
  for (std::size_t k = 0; k < kCut; ++k) {
    errors[k] = std::abs(settled.filtered[k] - truth[around + k]) / rms;
    if (k >= settled.begin && k < settled.end) cut.worst = std::max(cut.worst, errors[k]);
  }
  cut.good = LongestGood(errors);
  return cut;
}

// Of what is good half is kept of every cut, and nine tenths of all cuts together.
TEST(Settled, EightyRandomCutsAreRightWhereTheyAreKept) {
  const FilterDesign design = Designed({6, 20, 500}, kRateHz);
  Uniform uniform(1);
  std::size_t kept = 0;
  std::size_t good = 0;
  double worst = 0;
  for (int k = 0; k < 80; ++k) {
    const RandomCut cut = CutFrom(design, RandomMotion(uniform, 50'000));
    EXPECT_GE(2 * cut.kept, cut.good) << k;
    worst = std::max(worst, cut.worst);
    kept += cut.kept;
    good += cut.good;
  }
  EXPECT_ABS(worst, 0, 1e-4, "9.4e-5, and what the expectation is wrong by");
  EXPECT_GT(10 * kept, 9 * good);
}

// where the expectation is one sine: what others see says how far to believe it
TEST(Settled, TwoTremorsAtOnceAreNotBelievedToBeOne) {
  const FilterDesign design = Designed({6, 20, 500}, kRateHz);
  Uniform uniform(2);
  double worst = 0;
  for (int k = 0; k < 40; ++k) {
    worst = std::max(worst, CutFrom(design, RandomMotion(uniform, 50'000, true)).worst);
  }
  EXPECT_ABS(worst, 0, 1e-4, "the bar");
}

TEST(Settled, TheEndsOfALongSignalAreThoseOfAShortOne) {
  // beyond two lead-ins only the ends are looked at
  const FilterDesign design = Designed({2, 20, 500}, 2e3);
  const std::vector<double> in =
      Samples(2e3, 40'000, 0.03, {{1e-6, 100}, {0.5e-3, 8.3, 0.7}, {1e-6, 170.3, 1}});
  const auto end_of = [&](std::size_t from, std::size_t count) {
    const SettledSignal settled = FilterSettled(design, std::span(in).subspan(from, count));
    return std::pair{settled.begin, count - settled.end};
  };
  EXPECT_GT(in.size(), 2 * ZeroPhaseBlocks(design, in.size()).lead_in());
  const auto whole = end_of(0, 40'000);
  // the RMS of the two is not the same: some samples
  EXPECT_NEAR(static_cast<double>(whole.first), static_cast<double>(end_of(0, 8000).first), 8);
  EXPECT_NEAR(static_cast<double>(whole.second), static_cast<double>(end_of(32'000, 8000).second),
              8);
}

TEST(Settled, TheExpectedMotionIsThatOfTheSignal) {
  // a hand's: 0.4 s of drift and tremor under a tone
  std::vector<double> in = Samples(kRateHz, 5000, 0.03, {{0.4e-3, 7.3, 0.2}, {1e-6, 151}});
  for (std::size_t k = 0; k < in.size(); ++k) in[k] += 1e-3 * static_cast<double>(k) / kRateHz;
  const ExpectedMotion motion = FitExpectedMotion(std::span(in).first(4000), 1);
  EXPECT_REL(motion.sines[0].rad_per_sample, 2 * std::numbers::pi * 7.3 / kRateHz, 1e-3,
             "the tone in the means of 6 ms, 1e-4 of the tremor");
  double worst_m = 0;
  for (std::size_t k = 3999; k < 5000; ++k) {
    worst_m = std::max(worst_m, std::abs(motion.At(static_cast<double>(k)) - in[k]));
  }
  EXPECT_ABS(worst_m, 0, 3e-6, "the tone, 1 um, and 0.1 s ahead");
}

TEST(Settled, TwoTremorsAreExpectedAsTheyAre) {
  const std::vector<double> in =
      Samples(kRateHz, 7000, 0.03, {{0.4e-3, 6.3, 0.2}, {0.1e-3, 10.1, 1.3}});
  const ExpectedMotion motion = FitExpectedMotion(std::span(in).first(6000), 2);
  ASSERT_EQ(motion.sines.size(), 2U);
  double worst_m = 0;
  for (std::size_t k = 5999; k < 7000; ++k) {
    worst_m = std::max(worst_m, std::abs(motion.At(static_cast<double>(k)) - in[k]));
  }
  EXPECT_ABS(worst_m, 0, 1e-6, "of 0.5 mm: four rounds of one sine after the other");
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
