#include "dsp/spectrum/below_band_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "dsp/filter/transient.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/statistics/moments.h"
#include "tests/dsp/filter/settled_signal.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 10e3;
constexpr std::size_t kBefore = 20'000;
constexpr std::size_t kRows = 10'000;

// one second cut from the middle of `values`, filtered beside its model
struct Cut {
  SettledSignal signal;
  double worst = 0;  // difference from the filtered whole within what has settled, per band RMS
};

Cut CutOut(const std::vector<double>& values) {
  const FilterDesign design = Designed({}, kRateHz);
  const std::vector<double> whole = FilterZeroPhase(design, values);
  std::vector<double> samples(values.begin() + kBefore, values.begin() + kBefore + kRows);
  const auto model = BelowBandModel::Fit(samples, kRateHz, 20, 500);
  EXPECT_TRUE(model);
  if (model) model->Subtract(0, samples);
  Cut cut{FilterSettled(design, samples), 0};
  if (model) model->AddFiltered(design, 0, cut.signal.filtered);
  const std::size_t size = cut.signal.end - cut.signal.begin;
  if (size == 0) return cut;
  const double rms = Rms(std::span(cut.signal.filtered).subspan(cut.signal.begin, size));
  for (std::size_t k = cut.signal.begin; k < cut.signal.end; ++k) {
    cut.worst = std::max(cut.worst, std::abs(cut.signal.filtered[k] - whole[kBefore + k]) / rms);
  }
  return cut;
}

double SettledSeconds(const Cut& cut) {
  return static_cast<double>(cut.signal.end - cut.signal.begin) / kRateHz;
}

TEST(BelowBandModel, OneSecondOfStrongTremorIsTheFilteredLongRecord) {
  for (const double phase : {0.0, 0.7, 1.9, 3.3, 4.8}) {
    const Cut cut = CutOut(Samples(kRateHz, 50'000, 0.03, {{1e-6, 100, 0.2}, {5e-4, 8.3, phase}}));
    EXPECT_ABS(cut.worst, 0, 1e-4, "the bar of what has settled");
    EXPECT_GT(SettledSeconds(cut), 0.45);
  }
}

TEST(BelowBandModel, TremorWithAHarmonicAndDriftToo) {
  std::vector<double> values = Samples(
      kRateHz, 50'000, 0.03, {{1e-6, 100, 0.2}, {5e-4, 8.3, 0.4}, {3e-5, 16.6, 1}, {2e-4, 0.11}});
  const Cut cut = CutOut(values);
  EXPECT_ABS(cut.worst, 0, 1e-4, "the bar");
  EXPECT_GT(SettledSeconds(cut), 0.3);
}

TEST(BelowBandModel, ItsParametersAreTheTruth) {
  const std::vector<double> values =
      Samples(kRateHz, kRows, 0.03, {{1e-6, 100, 0.2}, {5e-4, 8.3, 0.4}});
  const auto model = BelowBandModel::Fit(values, kRateHz, 20, 500);
  ASSERT_TRUE(model);
  ASSERT_EQ(model->sines().size(), 1U);
  EXPECT_REL(model->sines()[0].frequency_hz, 8.3, 1e-11, "least squares without noise");
  EXPECT_REL(model->sines()[0].amplitude(), 5e-4, 1e-11, "least squares without noise");
}

// tremor as it is: a band of noise 1.5 Hz wide, and drift that wanders
TEST(BelowBandModel, WanderingTremorIsNeverBelievedTooFar) {
  double worst = 0;
  int kept = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Noise noise(seed);
    std::vector<Sine> sines{{1e-6, 100, 0.2}};
    for (int k = 0; k < 15; ++k) {
      sines.push_back({1.3e-4 * std::abs(noise()), 8.3 + 0.7 * noise(), 3 * noise()});
    }
    for (int k = 0; k < 5; ++k) sines.push_back({2e-4 * noise(), 0.1 + 0.3 * k, 3 * noise()});
    const Cut cut = CutOut(Samples(kRateHz, 50'000, 0.03, sines));
    worst = std::max(worst, cut.worst);
    if (SettledSeconds(cut) > 0.1) ++kept;
  }
  EXPECT_ABS(worst, 0, 1e-4, "the bar of what has settled");
  EXPECT_GE(kept, 4) << "cuts that keep 0.1 s";
}

TEST(BelowBandModel, NothingBelowTheBandIsNothing) {
  EXPECT_FALSE(
      BelowBandModel::Fit(Samples(kRateHz, kRows, 0.03, {{1e-6, 100, 0.2}}), kRateHz, 20, 500));
  EXPECT_FALSE(BelowBandModel::Fit(std::vector<double>(kRows, 0.03), kRateHz, 20, 500));
  EXPECT_FALSE(BelowBandModel::Fit(Samples(kRateHz, 600, 0.03, {{5e-4, 8.3}}), kRateHz, 20, 500))
      << "half a period";
}

// A record that is fitted at a lower rate: oracle is the motion it was made of.
TEST(BelowBandModel, OfAFastRecordIsTheMotionItself) {
  constexpr double kFastHz = 392e3;
  constexpr std::size_t kSize = std::size_t{1} << 19U;
  const std::vector<double> motion = Samples(kFastHz, kSize, 0.03, {{5e-4, 8.3, 1}});
  std::vector<double> samples = Samples(kFastHz, kSize, 0.03, {{5e-4, 8.3, 1}, {1e-6, 100, 0.3}});
  const auto model = BelowBandModel::Fit(samples, kFastHz, 20, 500);
  ASSERT_TRUE(model);
  ASSERT_EQ(model->sines().size(), 1U);
  EXPECT_ABS(model->sines()[0].frequency_hz, 8.3, 1e-9, "the tone in the band is fitted, too");
  EXPECT_ABS(model->sines()[0].amplitude(), 5e-4, 1e-12, "the low-pass is divided out");
  std::vector<double> rest = motion;
  model->Subtract(0, rest);
  EXPECT_ABS(Rms(rest), 0, 1e-13, "of 0.5 mm, at all samples and both ends");
}

// a cubic of 1 mm and tremor about it, `count` samples
std::vector<double> DriftAndTremor(double rate_hz, std::size_t count) {
  std::vector<double> motion = Samples(rate_hz, count, 0.03, {{5e-4, 8.3, 0.4}});
  const double middle = 0.5 * static_cast<double>(count - 1);
  for (std::size_t k = 0; k < count; ++k) {
    const double tau = static_cast<double>(k) / middle - 1;
    motion[k] += 1e-3 * (tau - 0.5 * tau * tau + 2 * tau * tau * tau);
  }
  return motion;
}

// Every second sample is fitted. The low-pass of variance v adds v to t^2 and 3 v t to t^3: of taps
// of 1.2 samples and 5000 to either end 6e-8 of 0.5 mm and 1.8e-7 of 2 mm.
TEST(BelowBandModel, SubtractsDriftAndTremorWhereverAPartBegins) {
  std::vector<double> rest = DriftAndTremor(kRateHz, kRows);
  const auto model = BelowBandModel::Fit(rest, kRateHz, 20, 500);
  ASSERT_TRUE(model);
  // parts of one sample, of a whole block and of a block and one
  std::size_t first = 0;
  for (const std::size_t size : {1UZ, 256UZ, 257UZ, 1000UZ, kRows - 1514UZ}) {
    model->Subtract(first, std::span(rest).subspan(first, size));
    first += size;
  }
  ASSERT_EQ(first, kRows);
  double worst = 0;
  for (const double x : rest) worst = std::max(worst, std::abs(x));
  EXPECT_ABS(worst, 0, 4e-10, "the low-pass of the cubic");
}

// the filter's output of the tremor alone, sample by sample: |H|^2 of it, no drift, no phase
TEST(BelowBandModel, AddsTheTremorAsBothPassesLeaveIt) {
  const std::vector<double> motion = DriftAndTremor(kRateHz, kRows);
  const auto model = BelowBandModel::Fit(motion, kRateHz, 20, 500);
  ASSERT_TRUE(model);
  const FilterDesign design = Designed({2, 10, 500}, kRateHz);
  const double gain = std::norm(Response(design, 8.3));
  constexpr std::size_t kFirst = 777;
  std::vector<double> filtered(3000, 1.0);
  model->AddFiltered(design, kFirst, filtered);
  const std::vector<double> tremor = Samples(kRateHz, kRows, 0, {{5e-4, 8.3, 0.4}});
  double worst = 0;
  for (std::size_t k = 0; k < filtered.size(); ++k) {
    worst = std::max(worst, std::abs(filtered[k] - 1 - gain * tremor[kFirst + k]));
  }
  EXPECT_GT(gain, 0.1);
  EXPECT_ABS(worst, 0, 1e-14, "rounding of 1, and of a fit to 1e-11 of 0.5 mm");
}

// At 100 kHz every 32nd sample is fitted. The low-pass of variance v adds v to t^2 and 3 v t to
// t^3: of taps of 22.6 samples and 65 536 to either end 3.6e-7 of 2 mm.
TEST(BelowBandModel, OfAFastRecordHasItsDrift) {
  constexpr double kFastHz = 100e3;
  const std::vector<double> motion = DriftAndTremor(kFastHz, std::size_t{1} << 17U);
  const auto model = BelowBandModel::Fit(motion, kFastHz, 20, 500);
  ASSERT_TRUE(model);
  std::vector<double> rest = motion;
  model->Subtract(0, rest);
  double worst = 0;
  for (const double x : rest) worst = std::max(worst, std::abs(x));
  EXPECT_ABS(worst, 0, 2e-9, "the low-pass of the cubic, and what the sine makes of it");
}

TEST(BelowBandModelDeathTest, KnowsNothingBehindItsLastSample) {
  const std::vector<double> motion = Samples(kRateHz, kRows, 0.03, {{5e-4, 8.3, 0.4}});
  const auto model = BelowBandModel::Fit(motion, kRateHz, 20, 500);
  ASSERT_TRUE(model);
  std::vector<double> two(2);
  model->Subtract(kRows - 2, two);
  EXPECT_DEATH(model->Subtract(kRows - 1, two), "check failed");
  EXPECT_DEATH(model->AddFiltered(Designed({}, kRateHz), kRows - 1, two), "check failed");
}

}  // namespace
}  // namespace haptometer::dsp
