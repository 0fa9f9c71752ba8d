#include "dsp/filter/transient.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
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

// `signal` between `count` samples of each end's value, filtered; its own samples
std::vector<double> FilteredBetweenConstants(const FilterDesign& design,
                                             const std::vector<double>& signal, std::size_t count) {
  std::vector<double> padded(count, signal.front());
  padded.insert(padded.end(), signal.begin(), signal.end());
  padded.insert(padded.end(), count, signal.back());
  const std::vector<double> filtered = FilterZeroPhase(design, padded);
  const auto begin = filtered.begin() + static_cast<std::ptrdiff_t>(count);
  return {begin, begin + std::ssize(signal)};
}

EndDependence DependenceOf(const FilterDesign& design, const std::vector<double>& signal) {
  ZeroPhaseBlocks::Scratch scratch;
  return MeasureEndDependence(ZeroPhaseBlocks(design, signal.size()), ReadFrom(signal), scratch)
      .value();
}

// The largest difference of `dependence` from |other less odd continuation| / `tolerance`, over the
// largest of these: of the samples from `first` on.
double WorstDifference(std::span<const double> dependence, std::span<const double> other,
                       std::span<const double> odd, std::size_t first, double tolerance) {
  double worst = 0;
  double most = 0;
  for (std::size_t k = 0; k < dependence.size(); ++k) {
    const double expected = std::abs(other[first + k] - odd[first + k]) / tolerance;
    worst = std::max(worst, std::abs(dependence[k] - expected));
    most = std::max(most, expected);
  }
  return worst / most;
}

// the oracle is the filter over the signal between constants, less that over the signal alone,
// which continues it oddly
TEST(EndDependence, OfAShortSignalIsTheFilteredDifferenceOfItsContinuations) {
  const FilterDesign design = Designed({3, 20, 500}, 2e3);
  for (const std::size_t size : {2UZ, 100UZ, 127UZ}) {
    const std::vector<double> in = Samples(2e3, size, 0.03, {{1e-4, 61, 0.4}, {1e-5, 170, 1}});
    const EndDependence dependence = DependenceOf(design, in);
    ASSERT_EQ(dependence.first.size(), size) << "fewer than 128 samples: the constant one only";
    EXPECT_TRUE(dependence.last.empty());
    const std::vector<double> constant = FilteredBetweenConstants(design, in, 10 * kTileSamples);
    EXPECT_ABS(WorstDifference(dependence.first, constant, FilterZeroPhase(design, in), 0, 2.5e-5),
               0, 1e-9, "rounding of 30 mm over that of the difference");
  }
}

// eight time constants of this filter are fewer than 128 samples
TEST(EndDependence, OfALongSignalIsThatOfEitherEnd) {
  const FilterDesign design = Designed({1, 300, 500, Corners::kEach}, 2e3);
  ASSERT_LT(2 * LeastRmsSamples(design), kLeastExpectedMotionSamples);
  const std::vector<double> in = Samples(2e3, 9000, 0.03, {{1e-4, 361, 0.4}, {1e-5, 170, 1}});
  const std::size_t lead_in = ZeroPhaseBlocks(design, in.size()).lead_in();
  ASSERT_GT(in.size(), 2 * lead_in);
  const EndDependence dependence = DependenceOf(design, in);
  ASSERT_EQ(dependence.first.size(), lead_in);
  ASSERT_EQ(dependence.last.size(), lead_in);
  const std::vector<double> constant = FilteredBetweenConstants(design, in, 5 * kTileSamples);
  const std::vector<double> odd = FilterZeroPhase(design, in);
  EXPECT_ABS(WorstDifference(dependence.first, constant, odd, 0, 2.5e-5), 0, 1e-9,
             "rounding of 30 mm over that of the difference");
  EXPECT_ABS(WorstDifference(dependence.last, constant, odd, in.size() - lead_in, 2.5e-5), 0, 1e-9,
             "the same");
}

// `dependence` of `count` samples that have settled within [begin, end)
EndDependence SettledWithin(std::size_t count, std::size_t begin, std::size_t end) {
  EndDependence dependence;
  dependence.first.assign(count, 2);
  std::fill(dependence.first.begin() + static_cast<std::ptrdiff_t>(begin),
            dependence.first.begin() + static_cast<std::ptrdiff_t>(end), 0.5);
  return dependence;
}

// The ranges over which the RMS is asked for: all samples first, then what has settled, at least
// 100 samples about its middle, moved inwards at the ends.
TEST(SettledRange, AsksForTheRmsOfEnoughSamplesAboutWhatHasSettled) {
  struct Case {
    SampleRange settled;
    SampleRange asked;
  };
  for (const Case& one : {Case{{400, 40}, {370, 100}}, Case{{700, 101}, {700, 101}},
                          Case{{980, 20}, {900, 100}}, Case{{0, 20}, {0, 100}}}) {
    std::vector<SampleRange> asked;
    const auto rms = [&](const SampleRange& range) {
      asked.push_back(range);
      return 1.0;
    };
    const SampleRange settled =
        SettledRange(1000, SettledWithin(1000, one.settled.first, one.settled.end()), rms, 100);
    EXPECT_EQ(settled.first, one.settled.first);
    EXPECT_EQ(settled.count, one.settled.count);
    ASSERT_EQ(asked.size(), 2U) << "until it holds";
    EXPECT_EQ(asked[0].first, 0U);
    EXPECT_EQ(asked[0].count, 1000U);
    EXPECT_EQ(asked[1].first, one.asked.first);
    EXPECT_EQ(asked[1].count, one.asked.count);
  }
}

TEST(SettledRange, IsTheLongestStretchUpToTheRms) {
  EndDependence dependence;
  dependence.first = {3, 1, 0, 3};
  dependence.last = {1, 1 + 1e-9, 0};
  const auto one = [](const SampleRange&) { return 1.0; };
  // of 20 samples: what lies between both ends has settled, and 1 is not above an RMS of 1
  const SampleRange settled = SettledRange(20, dependence, one, 1);
  EXPECT_EQ(settled.first, 4U);
  EXPECT_EQ(settled.end(), 18U);
  dependence.first.assign(20, 2.0);
  dependence.last.clear();
  EXPECT_EQ(SettledRange(20, dependence, one, 1).count, 0U) << "nothing";
}

TEST(LeastRmsSamples, AreFourTimeConstantsOfTheSlowestPole) {
  const FilterDesign design = Designed({6, 20, 500}, kRateHz);
  const double samples = 4 * kRateHz / SlowestDecayPerS(design);
  EXPECT_EQ(LeastRmsSamples(design), static_cast<std::size_t>(samples));
  EXPECT_ABS(samples * 20 / kRateHz, 2.8, 0.05, "periods of the lower corner: printed digits");
  // ln(1e6) = 13.8 time constants to a millionth
  const double ringing = std::log(1e6) * kRateHz / SlowestDecayPerS(design);
  EXPECT_EQ(RingingSamples(design, 1e-6), static_cast<std::size_t>(std::ceil(ringing)));
}

// the values that are made sample by sample and those that are turned are the same motion
TEST(ExpectedMotion, IsItsClosedFormAtEveryIndex) {
  const ExpectedMotion motion{
      .offset = 0.5, .slope = 0.01, .sines = {{0.1, 2, -1}, {0.03, 0.25, 3}}, .middle = 40.5};
  const std::vector<double> values = motion.From(-100, 300);
  double worst = 0;
  double of_turned = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double index = static_cast<double>(k) - 100;
    const double t = index - 40.5;
    const double expected = 0.5 + 0.01 * t + 2 * std::cos(0.1 * t) - std::sin(0.1 * t) +
                            0.25 * std::cos(0.03 * t) + 3 * std::sin(0.03 * t);
    worst = std::max(worst, std::abs(motion.At(index) - expected));
    of_turned = std::max(of_turned, std::abs(values[k] - expected));
  }
  EXPECT_ABS(worst, 0, 1e-14, "rounding of phases of 30 rad");
  EXPECT_ABS(of_turned, 0, 1e-14, "the same");
}

// Motion of one sine below the band is expected as it goes on, for eight time constants; later it
// stays where it is. The oracle is the filter over the signal between these samples.
// Motion that was another one between 18 and 12 time constants of the end: what two sines fitted to
// all of that expect differs from what one fitted to the last 12 does, and the difference is added.
TEST(EndDependence, WhatALongerViewExpectsIsADoubt) {
  const FilterDesign design = Designed({3, 20, 500}, 2e3);
  constexpr std::size_t kSize = 1500;
  constexpr std::size_t kBeyond = 10 * kTileSamples;
  const auto samples_of = [&](double time_constants) {
    return static_cast<std::size_t>(time_constants * design.rate_hz / SlowestDecayPerS(design));
  };
  std::vector<double> in = Samples(2e3, kSize, 0.03, {{5e-4, 4.7, 0.4}});
  const EndDependence without = DependenceOf(design, in);
  for (std::size_t k = kSize - samples_of(18); k < kSize - samples_of(12); ++k) in[k] += 5e-3;
  const EndDependence with = DependenceOf(design, in);
  // change since the last sample
  const auto add = [&](std::size_t size, int sines, double sign, std::vector<double>& beyond) {
    const ExpectedMotion motion = FitExpectedMotion(std::span(in).last(size), sines);
    const auto last = static_cast<double>(size - 1);
    for (std::size_t k = 0; k < samples_of(8); ++k) {
      beyond[kBeyond + kSize + k] +=
          sign * (motion.At(last + 1 + static_cast<double>(k)) - motion.At(last));
    }
  };
  std::vector<double> beyond(kSize + 2 * kBeyond, 0.0);
  add(samples_of(18), 2, 1, beyond);
  add(samples_of(12), 1, -1, beyond);
  const std::vector<double> doubt = FilterZeroPhase(design, beyond);
  double below = 0;
  double above = 0;
  double most = 0;
  for (std::size_t k = 0; k < kSize; ++k) {
    const double added = std::abs(doubt[kBeyond + k]) / 9.4e-5;
    below = std::max(below, added - with.first[k]);
    above = std::max(above, with.first[k] - without.first[k] - added);
    most = std::max(most, added - without.first[k]);
  }
  EXPECT_GT(most, 0.1 * std::ranges::max(with.first)) << "the case that is meant";
  EXPECT_ABS(below / most, 0, 1e-6, "the greatest of all criteria: no less than the doubt");
  EXPECT_ABS(above / most, 0, 1e-3, "nor more than it and the greatest without it");
}

TEST(EndDependence, OfASlowSineIsThatOfItsOwnContinuation) {
  constexpr double kSlowRateHz = 2e3;
  const FilterDesign design = Designed({3, 20, 500}, kSlowRateHz);
  constexpr std::size_t kSize = 1500;
  constexpr std::size_t kBeyond = 10 * kTileSamples;
  const std::size_t ahead = 2 * LeastRmsSamples(design);
  ASSERT_LT(ahead, kSize);
  const std::vector<Sine> sine{{5e-4, 4.7, 0.4}};
  const std::vector<double> in = Samples(kSlowRateHz, kSize, 0.03, sine);
  const double first = -static_cast<double>(ahead);
  std::vector<double> padded(kBeyond, in.front());
  const std::vector<double> goes_on = Samples(kSlowRateHz, kSize + 2 * ahead, 0.03, sine, first);
  padded.insert(padded.end(), goes_on.begin(), goes_on.end());
  padded.insert(padded.end(), kBeyond, in.back());
  const std::vector<double> expected = FilterZeroPhase(design, padded);
  const std::vector<double> constant = FilteredBetweenConstants(design, in, kBeyond);
  const std::vector<double> odd = FilterZeroPhase(design, in);
  const EndDependence dependence = DependenceOf(design, in);
  ASSERT_EQ(dependence.first.size(), kSize);
  double worst = 0;
  double most = 0;
  for (std::size_t k = 0; k < kSize; ++k) {
    const double of_expected = std::abs(expected[kBeyond + ahead + k] - odd[k]) / 9.4e-5;
    const double wanted = std::max(of_expected, std::abs(constant[k] - odd[k]) / 5e-4);
    worst = std::max(worst, std::abs(dependence.first[k] - wanted));
    most = std::max(most, wanted);
  }
  EXPECT_ABS(worst / most, 0, 2e-5, "the frequency is found to 1e-5 rad");
}

// what stands beside `signal` if it stays less what its odd continuation has there, for `count`
// samples, filtered to the signal's own places
std::vector<double> FilteredStaysLessOdd(const FilterDesign& design,
                                         const std::vector<double>& signal, std::size_t count) {
  constexpr std::size_t kBeyond = 10 * kTileSamples;
  const std::size_t size = signal.size();
  std::vector<double> beside(size + 2 * kBeyond, 0.0);
  for (std::size_t k = 0; k < count; ++k) {
    beside[kBeyond - 1 - k] = signal[k + 1] - signal.front();
    beside[kBeyond + size + k] = signal[size - 2 - k] - signal.back();
  }
  const std::vector<double> filtered = FilterZeroPhase(design, beside);
  const auto begin = filtered.begin() + static_cast<std::ptrdiff_t>(kBeyond);
  return {begin, begin + std::ssize(signal)};
}

// samples of that many time constants of the slowest pole
std::size_t TimeConstants(const FilterDesign& design, double count) {
  return static_cast<std::size_t>(count * design.rate_hz / SlowestDecayPerS(design));
}

struct SlowAndTone {
  Sine slow;
  Sine tone;
};
constexpr std::size_t kSlowAndTone = 1500;  // samples

// `motion` between what is expected beside it for eight time constants, and later: the slow sine
// goes on, and so does the tone, or it stays where it is
std::vector<double> BetweenExpectations(const FilterDesign& design, const SlowAndTone& motion,
                                        bool tone_goes_on) {
  constexpr std::size_t kBeyond = 10 * kTileSamples;
  const std::size_t ahead = TimeConstants(design, 8);
  const std::size_t size = kSlowAndTone + 2 * ahead;
  const auto first = -static_cast<double>(ahead);
  std::vector<double> expected = Samples(design.rate_hz, size, 0.03, {motion.slow}, first);
  const std::vector<double> tone = Samples(design.rate_hz, size, 0, {motion.tone}, first);
  for (std::size_t k = 0; k < size; ++k) {
    expected[k] += tone[tone_goes_on ? k : std::clamp(k, ahead, size - 1 - ahead)];
  }
  std::vector<double> padded(kBeyond - ahead, expected[ahead]);
  padded.insert(padded.end(), expected.begin(), expected.end());
  padded.insert(padded.end(), kBeyond - ahead, expected[size - 1 - ahead]);
  const std::vector<double> filtered = FilterZeroPhase(design, padded);
  const auto begin = filtered.begin() + static_cast<std::ptrdiff_t>(kBeyond);
  return {begin, begin + static_cast<std::ptrdiff_t>(kSlowAndTone)};
}

// how far the dependence is from that of the expectation, over its largest value; what is not slow,
// the tone alone, has the strictest tolerance
double OffExpectation(const FilterDesign& design, const SlowAndTone& motion, bool tone_goes_on) {
  const std::vector<double> in =
      Samples(design.rate_hz, kSlowAndTone, 0.03, {motion.slow, motion.tone});
  const std::vector<double> expected = BetweenExpectations(design, motion, tone_goes_on);
  const std::vector<double> constant = FilteredBetweenConstants(design, in, 10 * kTileSamples);
  const std::vector<double> odd = FilterZeroPhase(design, in);
  const std::vector<double> fast = FilteredStaysLessOdd(
      design, Samples(design.rate_hz, kSlowAndTone, 0, {motion.tone}), TimeConstants(design, 8));
  const EndDependence dependence = DependenceOf(design, in);
  EXPECT_EQ(dependence.first.size(), kSlowAndTone);
  double worst = 0;
  double most = 0;
  std::size_t by_expected = 0;
  for (std::size_t k = 0; k < dependence.first.size(); ++k) {
    const double of_expected = std::abs(expected[k] - odd[k]) / 9.4e-5;
    const double of_others =
        std::max(std::abs(fast[k]) / 2.5e-5, std::abs(constant[k] - odd[k]) / 5e-4);
    by_expected += of_expected > of_others ? 1 : 0;
    const double wanted = std::max(of_expected, of_others);
    worst = std::max(worst, std::abs(dependence.first[k] - wanted));
    most = std::max(most, wanted);
  }
  EXPECT_GT(by_expected, kSlowAndTone / 10) << "the case that is meant";
  return worst / most;
}

// Each of the 64 means holds one period of the tone, so that the slow sine is found without it.
TEST(EndDependence, OfASlowSineAndAToneIsThatOfBothGoingOn) {
  const FilterDesign design = Designed({3, 20, 500}, 2e3);
  const double tone_hz =
      design.rate_hz / std::floor(static_cast<double>(TimeConstants(design, 12)) / 64);
  const SlowAndTone motion{{5e-4, 4.7, 0.4}, {3e-6, tone_hz, 0.4}};
  EXPECT_ABS(OffExpectation(design, motion, true), 0, 1e-4,
             "the frequencies are found to 1e-5 rad");
  EXPECT_GT(OffExpectation(design, motion, false), 1e-3);
}

// The means share something with these tones, by which the slow sine is wrong: the expectation is
// the nearer one of two.
TEST(EndDependence, AToneAbove04OfTheRateIsNotExpectedToGoOn) {
  const FilterDesign design = Designed({3, 20, 500}, 1100);
  for (const double share : {0.39, 0.41}) {
    const SlowAndTone motion{{5e-4, 4.7, 0.4}, {3e-6, share * design.rate_hz, 0.4}};
    const double goes_on = OffExpectation(design, motion, true);
    const double stays = OffExpectation(design, motion, false);
    SCOPED_TRACE(testing::Message() << goes_on << " or " << stays);
    EXPECT_LT(share < 0.4 ? goes_on : stays, 0.5 * std::max(goes_on, stays)) << share;
  }
}

// Offset, slope and one sine of the slowest and the fastest that are looked for. Of 6437 samples 64
// pieces of 100 are seen, the first 37 are not.
TEST(Settled, AnExpectedSineIsExactFromTwoToSixtyRadians) {
  for (const std::size_t size : {128UZ, 6400UZ, 6437UZ}) {
    const auto n = static_cast<double>(size);
    for (const double rad : {2.4, 11.3, 37.7, 58.6}) {
      SCOPED_TRACE(testing::Message() << rad << " rad over " << size);
      std::vector<double> in =
          Samples(kRateHz, size, 0.03, {{0.4e-3, rad / n * kRateHz / (2 * std::numbers::pi), 0.2}});
      for (std::size_t k = 0; k < size; ++k) in[k] += 1e-3 * static_cast<double>(k) / n;
      const ExpectedMotion motion = FitExpectedMotion(in, 1);
      ASSERT_EQ(motion.sines.size(), 1U);
      EXPECT_ABS(motion.sines[0].rad_per_sample * n, rad, 1e-4, "2 rad narrowed by 0.618^25");
      double worst_m = 0;
      for (std::size_t k = 0; k < size; ++k) {
        worst_m = std::max(worst_m, std::abs(motion.At(static_cast<double>(k)) - in[k]));
      }
      EXPECT_ABS(worst_m, 0, 0.4e-3 * 5e-6, "1e-5 rad of the sine, at either end half of it");
    }
  }
}

TEST(ExpectedMotionDeathTest, TakesOneOrTwoSinesOf128Samples) {
  const std::vector<double> in(128, 0.03);
  EXPECT_DEATH(static_cast<void>(FitExpectedMotion(std::span(in).first(127), 1)), "check failed");
  EXPECT_DEATH(static_cast<void>(FitExpectedMotion(in, 0)), "check failed");
  EXPECT_DEATH(static_cast<void>(FitExpectedMotion(in, 3)), "check failed");
}

}  // namespace
}  // namespace haptometer::dsp
