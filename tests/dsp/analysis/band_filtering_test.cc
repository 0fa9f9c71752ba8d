// Which segments are filtered and how, and tones beside the band; the oracle is the closed form.
#include "dsp/analysis/band_filtering.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "dsp/filter/zero_phase.h"
#include "tests/dsp/findings.h"
#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

// a record of one segment, filtered
struct Filtered {
  Filtered(std::vector<double> values, double rate_hz, const BandPass& band = {})
      : record(RecordOf(std::move(values), rate_hz)),
        rows(record),
        segments(SplitAtHoles(rows, 0, {}).value()),
        signal(BandSignal::Filter({rows, 0, segments.parts.at(0)}, Designed(band, rate_hz), 1)
                   .value()) {}
  trial::Record record;
  trial::RecordRows rows;
  Segments segments;
  BandSignal signal;
};

// Whether the rate is a few or some thousand times the band's lower corner: decimation leaves no
// trace.
TEST(FindBelowBand, IsTheTremorAndWhatTheFilterLeavesOfIt) {
  for (const double rate_hz : {2e3, 100e3}) {
    const auto count = static_cast<std::size_t>((rate_hz > 2e3 ? 3 : 1) * rate_hz);
    const Filtered made(Samples(rate_hz, count, 0.03, {{5e-4, 9, 0.7}, {1e-6, 100}}), rate_hz);
    const auto below = FindBelowBand(made.signal, 20).value();
    ASSERT_TRUE(below) << rate_hz;
    EXPECT_REL(below->frequency_hz, 9.0, 1e-4, "the tone in the band: a 500th of it, 91 bins away");
    EXPECT_REL(below->amplitude_m, 5e-4, 1e-4, "the same");
    const double leaked_m = below->amplitude_m / std::numbers::sqrt2 *
                            std::norm(Response(made.signal.design(), below->frequency_hz));
    EXPECT_REL(below->leaked_rms_m, leaked_m, 1e-12, "rounding");
    EXPECT_FALSE(below->modelled);
  }
}

// Two periods of the lower corner, 0.1 s, are needed to look for a tone below it.
TEST(FindBelowBand, NeedsTwoPeriodsOfTheCorner) {
  const auto values = Samples(10e3, 4000, 0, {{5e-4, 12, 0.3}});
  EXPECT_FALSE(
      FindBelowBand(Filtered({values.begin(), values.begin() + 1000}, 10e3).signal, 20).value());
  EXPECT_TRUE(FindBelowBand(Filtered(values, 10e3).signal, 20).value());
}

// A bin of 1 s is 1 Hz: a tone within half of it from the corner is found in the band as well.
TEST(FindBelowBand, IsFartherThanHalfABinFromTheCorner) {
  for (const double frequency_hz : {19.3, 19.45, 19.55, 19.9, 20.0, 20.3}) {
    const Filtered made(Samples(2e3, 2000, 0.03, {{3e-5, frequency_hz, 0.7}}), 2e3);
    EXPECT_EQ(FindBelowBand(made.signal, 20).value().has_value(), frequency_hz < 19.5)
        << frequency_hz;
  }
}

TEST(FindAboveBand, IsTheToneBetweenTheBandAndTheLimit) {
  const Filtered made(Samples(10e3, 10'000, 0.03, {{5e-6, 800.3, 0.7}, {9e-6, 100}}), 10e3);
  const auto tone = FindAboveBand(made.signal, 500, 3900).value();
  ASSERT_TRUE(tone);
  EXPECT_REL(tone->frequency_hz, 800.3, 1e-5, "leakage of the tone in the band");
  EXPECT_REL(tone->amplitude, 5e-6, 1e-3, "leakage of the tone in the band");
  EXPECT_FALSE(FindAboveBand(made.signal, 500, 790).value()) << "it lies above";
  EXPECT_FALSE(FindAboveBand(made.signal, 500, 500).value()) << "there is nothing between";
}

// what FilterSettledEnough finds of a record
struct Settled {
  explicit Settled(trial::Record held, const BandQuestion& question = {})
      : record(std::move(held)) {
    analysis.band = question.band;
    analysis.record.rate_hz = record.stretches.at(0).rate_hz;
    all = FilterSettledEnough({rows, 0}, segments, question, &analysis).value();
  }
  trial::Record record;
  trial::RecordRows rows{record};
  Segments segments{SplitAtHoles(rows, 0, {}).value()};
  BandAnalysis analysis;
  std::vector<BandSignal> all;
};

// 2.56 samples a period of 500 Hz; two periods of 20 Hz.
TEST(FilterSettledEnough, SegmentsAreFastAndLongEnough) {
  EXPECT_EQ(Settled(RecordOf(Samples(1281, 4000, 0, {{1e-6, 100}}), 1281)).all.size(), 1U);
  EXPECT_TRUE(Settled(RecordOf(Samples(1279, 4000, 0, {{1e-6, 100}}), 1279)).all.empty());
  // times that are printed to 0.1 us give 1280 Hz this rate: within what a clock may be off
  constexpr double kPrinted = 1279.99993599;
  EXPECT_EQ(Settled(RecordOf(Samples(kPrinted, 4000, 0, {{1e-6, 100}}), kPrinted)).all.size(), 1U);
  for (const std::size_t rows : {200U, 199U}) {
    trial::Record record = RecordOf(Samples(2e3, 8000 + rows, 0, {{1e-6, 100}}), 2e3);
    record.stretches = {{0, 8000, 0, 2e3, 0}, {8000, rows, 9, 2e3, 0}};
    EXPECT_EQ(Settled(record).all.size(), rows == 200 ? 2U : 1U) << rows;
  }
}

// What would be long enough: both transients as the filter rings to 1e-12, and two periods.
TEST(FilterSettledEnough, TooShortARecordIsToldHowLongItMustBe) {
  for (const int order : {4, 6}) {
    BandQuestion question;
    question.band.order = order;
    question.may_lower_order = false;
    // tremor of which no two periods are there is not modelled
    const Settled made(RecordOf(Samples(10e3, 2000, 0.03, {{1e-6, 100}, {5e-4, 8.3, 0.7}}), 10e3),
                       question);
    EXPECT_TRUE(made.all.empty());
    const Finding refusal = FirstOf(made.analysis.findings, FindingKind::kTooShort);
    const double ringing_s =
        static_cast<double>(RingingSamples(Designed(question.band, 10e3), 1e-12)) / 10e3;
    EXPECT_REL(NumberOf(refusal, "record_s"), 2 * ringing_s + 0.1, 1e-12, "rounding");
    EXPECT_EQ(NumberOf(refusal, "needed_s"), 0.1);
    EXPECT_EQ(NumberOf(refusal, "order"), order);
    EXPECT_EQ(made.analysis.band.order, order);
  }
}

// the part of the power of what has settled that leaks from below the band
double LeakedPart(const std::vector<BandSignal>& all) {
  const BandSignal& signal = LongestSettled(all);
  const auto below = FindBelowBand(signal, 20).value();
  const auto count = static_cast<double>(signal.settled_end() - signal.settled_begin());
  const double square =
      signal.SquareSum(signal.settled_begin(), signal.settled_end()).value() / count;
  return below ? below->leaked_rms_m * below->leaked_rms_m / square : 0;
}

// A lower order is taken as long as what leaks from below changes the RMS by at most 1 %, as 2 % of
// the power do. 0.4 s with a motion at 10 Hz, of which order 6 leaves too little.
TEST(FilterSettledEnough, ALowerOrderMayLeakTwoPercentOfThePower) {
  const auto made_of = [](double slow_m) {
    return Settled(RecordOf(Samples(5e3, 2000, 0.03, {{1e-6, 100}, {slow_m, 10, 0.7}}), 5e3));
  };
  double less_m = 3e-6;
  double more_m = 7e-6;
  while (more_m > 1.005 * less_m) {
    const double middle_m = 0.5 * (less_m + more_m);
    (made_of(middle_m).all.empty() ? more_m : less_m) = middle_m;
  }
  const Settled lowered = made_of(less_m);
  ASSERT_FALSE(lowered.all.empty());
  EXPECT_REL(LeakedPart(lowered.all), 0.02, 0.015, "0.5 % of the motion: 1 % of its power");
  const Finding note = FirstOf(lowered.analysis.findings, FindingKind::kOrderLowered);
  EXPECT_EQ(NumberOf(note, "asked_order"), 6);
  EXPECT_EQ(NumberOf(note, "order"), lowered.analysis.band.order);
  EXPECT_LT(lowered.analysis.band.order, 6);
  EXPECT_LT(NumberOf(note, "settled_s"), 0.1) << "of order 6";
  EXPECT_GE(SettledSeconds(LongestSettled(lowered.all)), 0.1);
  // what leaks is why it is refused, and the order is the one that was asked for
  const Settled leaking = made_of(more_m);
  const Finding refusal = FirstOf(leaking.analysis.findings, FindingKind::kTooShort);
  EXPECT_EQ(NumberOf(refusal, "lower_hz"), 20);
  EXPECT_EQ(leaking.analysis.band.order, 6);
}

TEST(SettledSeconds, OfTheLongestSignal) {
  std::vector<BandSignal> all;
  const Filtered small(Samples(2e3, 4000, 0, {{1e-6, 100}}), 2e3);
  const Filtered fast(Samples(8e3, 8000, 0, {{1e-6, 100}}), 8e3);
  all.push_back(fast.signal);
  all.push_back(small.signal);
  EXPECT_EQ(LongestSettled(all).rate_hz(), 2e3) << "more seconds in fewer samples";
  EXPECT_REL(SettledSeconds(small.signal),
             static_cast<double>(small.signal.settled_end() - small.signal.settled_begin()) / 2e3,
             1e-15, "rounding");
}

}  // namespace
}  // namespace haptometer::dsp
