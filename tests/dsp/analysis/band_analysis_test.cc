#include "dsp/analysis/band_analysis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "dsp/filter/butterworth.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/readings/segments.h"
#include "dsp/statistics/moments.h"
#include "tests/dsp/analysis/answered.h"
#include "tests/dsp/findings.h"
#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"
#include "tests/repetitions.h"
#include "tests/residual.h"
#include "trial/row_source.h"
#include "trial/sensor_head.h"

namespace haptometer::dsp {
namespace {

using trial::SampleStatus;

constexpr double kRateHz = 10e3;
constexpr double kRootTwo = std::numbers::sqrt2;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// 3 s of a 10 kHz head with 0.5 um of noise and 0.1 um steps
trial::Record Streamed(const trial::Displacement& displacement, std::uint64_t seed) {
  const trial::SensorHead head = trial::Stream10kHz();
  std::vector<double> values;
  values.reserve(30'000);
  for (std::int64_t k = 0; k < 30'000; ++k) {
    values.push_back(ReadingAt(head, displacement, k, seed).value_m);
  }
  return RecordOf(std::move(values), kRateHz);
}

TEST(BandAnalysis, AStreamedRecordIsWithinOnePercentAndATwentiethOfAHertz) {
  const auto tone = [](double t_s) {
    return 0.2e-3 * kRootTwo * std::sin(2 * std::numbers::pi * 225 * t_s);
  };
  const auto tremor = [](double t_s) {
    return 0.5e-3 * std::sin(2 * std::numbers::pi * 8.3 * t_s + 1);
  };
  const auto settling = [&](double t_s) { return tone(t_s) + tremor(t_s) * std::exp(-t_s / 0.1); };
  const auto held = [&](double t_s) { return tone(t_s) + tremor(t_s); };
  for (const trial::Displacement& displacement : {trial::Displacement(settling), {held}}) {
    const BandAnalysis analysis = Answer(Streamed(displacement, 4));
    ASSERT_TRUE(analysis.answered);
    EXPECT_REL(analysis.numbers->rms.rms_m, 0.2e-3, 5e-5, "|H|^2 at 225 Hz and 0.16 um of noise");
    EXPECT_ABS(analysis.numbers->tone->fit.frequency_hz, 225, 1e-4, "noise, 4 uncertainties");
    EXPECT_REL(analysis.numbers->tone->fit.amplitude, 0.2e-3 * kRootTwo, 1e-4,
               "noise, 4 uncertainties");
    EXPECT_LT(std::abs(analysis.numbers->tone->fit.frequency_hz - 225),
              4 * analysis.numbers->tone->fit.frequency_uncertainty_hz);
    EXPECT_LT(std::abs(analysis.numbers->tone->fit.amplitude - 0.2e-3 * kRootTwo),
              4 * analysis.numbers->tone->fit.amplitude_uncertainty);
    EXPECT_GT(analysis.numbers->part.window.end_s - analysis.numbers->part.window.begin_s, 1.8);
    EXPECT_EQ(analysis.band.order, 6);
  }
}

TEST(BandAnalysis, AToneAloneIsExact) {
  const trial::Record record = RecordOf(Samples(kRateHz, 30'000, 0.03, {{1e-6, 100, 1}}), kRateHz);
  const BandAnalysis analysis = Answer(record);
  ASSERT_TRUE(analysis.answered);
  EXPECT_REL(analysis.numbers->rms.rms_m, 1e-6 / kRootTwo, 2e-8,
             "whole periods; settled to 2.5e-5");
  EXPECT_REL(analysis.numbers->tone->fit.amplitude, 1e-6, 2e-7, "settled to 2.5e-5 at the ends");
  EXPECT_REL(analysis.numbers->tone->fit.frequency_hz, 100, 5e-10, "settled to 2.5e-5 at the ends");
  EXPECT_REL(analysis.numbers->peak_to_peak_m, 2e-6, 1e-4, "100 samples a period");
  EXPECT_ABS(analysis.record.offset_m, 0.03, 1e-9, "300 whole periods");
  EXPECT_REL(analysis.record.peak_to_peak_m, 2e-6, 5e-4, "100 samples a period");
  EXPECT_EQ(analysis.record.rate_hz, kRateHz);
  // the window: settled, whole periods, and where the filtered rows say
  EXPECT_EQ(analysis.numbers->part.rows % 100, 0U);
  EXPECT_EQ(analysis.numbers->part.window.begin_s,
            static_cast<double>(analysis.numbers->part.first_row) / kRateHz);
  const auto window = std::span(analysis.filtered_m)
                          .subspan(analysis.numbers->part.first_row, analysis.numbers->part.rows);
  EXPECT_REL(Rms(window), analysis.numbers->rms.as_measured_m, 4e-16, "order of the sums");
}

TEST(BandAnalysis, AToneAtACornerHasItsAmplitudeRestored) {
  const BandAnalysis analysis =
      Answer(RecordOf(Samples(kRateHz, 40'000, 0.03, {{1e-6, 20, 1}}), kRateHz));
  ASSERT_TRUE(analysis.answered);
  EXPECT_REL(analysis.numbers->rms.rms_m, 1e-6 / 2, 3e-6, "1/sqrt(2) of the RMS");
  EXPECT_REL(analysis.numbers->tone->fit.amplitude, 1e-6, 3e-6, "divided by |H|^2");
}

TEST(BandAnalysis, StatedUncertaintyIsTheScatterOfTheRms) {
  // records of a tone in noise
  constexpr std::uint64_t kRecords = tests::kIsSanitized ? 12 : 200;
  std::vector<double> rms_m;
  double stated_m = 0;
  for (std::uint64_t seed = 1; seed <= kRecords; ++seed) {
    Noise noise(seed);
    std::vector<double> values = Samples(2e3, 3000, 0.03, {{2e-6, 150, 0.4}});
    for (double& value : values) value += 1e-6 * noise();
    const BandAnalysis analysis = Answer(RecordOf(values, 2e3));
    ASSERT_TRUE(analysis.answered);
    rms_m.push_back(analysis.numbers->rms.rms_m);
    stated_m += analysis.numbers->rms.standard_uncertainty_m / kRecords;
  }
  EXPECT_REL(stated_m, StandardDeviation(rms_m), 4 / std::sqrt(2.0 * kRecords),
             "what so many values know it to, four times");
}

// Vibration of 80 to 200 Hz in noise, without a pause: it was subtracted as its own noise.
TEST(BandAnalysis, BroadbandVibrationIsNotItsOwnNoise) {
  constexpr std::uint64_t kRecords = 12;
  const FilterDesign of_drive = Designed({.lower_hz = 80, .upper_hz = 200}, 4e3);
  const FilterDesign of_band = Designed({}, 4e3);
  unsigned held = 0;
  for (std::uint64_t seed = 1; seed <= kRecords; ++seed) {
    Noise noise(seed);
    std::vector<double> drive(10'000);
    for (double& value : drive) value = 20e-6 * noise();
    drive = FilterZeroPhase(of_drive, drive);
    std::vector<double> values = drive;
    for (double& value : values) value += 0.3e-6 * noise();
    BandQuestion question;
    question.choice = WindowChoice::kAll;
    const BandAnalysis analysis = Answer(RecordOf(values, 4e3), question);
    ASSERT_TRUE(analysis.answered);
    const BandNumbers& numbers = *analysis.numbers;
    const std::vector<double> filtered = FilterZeroPhase(of_band, drive);
    const double truth_m =
        Rms(std::span(filtered).subspan(numbers.part.first_row, numbers.part.rows));
    EXPECT_REL(numbers.rms.rms_m, truth_m, 0.01, "what the noise adds");
    EXPECT_FALSE(numbers.floor);
    EXPECT_TRUE(analysis.findings.Has(FindingKind::kNoFloor));
    held += numbers.rms.lower_m <= truth_m && truth_m <= numbers.rms.upper_m ? 1 : 0;
  }
  EXPECT_GE(held, kRecords - 2) << "fewer once in 50 times at 95 %";
}

TEST(BandAnalysis, TooSlowARecordIsNotAnswered) {
  trial::Record record = RecordOf(Samples(48, 144, 0.03, {{44e-6, 175}, {5e-4, 8.3}}), 48);
  record.stretches[0].time_uncertainty_s = 8e-3;
  record.timing = trial::Timing::kPolled;
  const BandAnalysis analysis = Answer(record);
  EXPECT_FALSE(analysis.answered);
  ASSERT_THAT(RefusalsIn(analysis.findings),
              ::testing::ElementsAre(FindingKind::kTooFewReadings, FindingKind::kTimesUncertain));
  const Finding rate = FirstOf(analysis.findings, FindingKind::kTooFewReadings);
  EXPECT_EQ(NumberOf(rate, "new_readings_per_s"), 48);
  EXPECT_EQ(NumberOf(rate, "observable_hz"), 18.75);
  EXPECT_EQ(NumberOf(rate, "lower_hz"), 20);
  EXPECT_EQ(NumberOf(rate, "upper_hz"), 500);
  EXPECT_EQ(NumberOf(rate, "needed_per_s"), 1280);
  const Finding times = FirstOf(analysis.findings, FindingKind::kTimesUncertain);
  EXPECT_EQ(NumberOf(times, "time_uncertainty_s"), 8e-3);
  EXPECT_EQ(NumberOf(times, "limit_s"), 0.1 / 500);
  EXPECT_FALSE(analysis.numbers);
  EXPECT_ABS(analysis.record.offset_m, 0.03, 1e-5, "tremor's part period");
  EXPECT_GT(analysis.record.peak_to_peak_m, 0.9e-3);
  EXPECT_ABS(analysis.record.observable_upper_hz, 18.75, 0, "48/2.56");
}

TEST(BandAnalysis, ReadingsHandedOutTwiceDoNotCountAsRate) {
  trial::Record record = RecordOf(Samples(2e3, 6000, 0.03, {{1e-6, 100}}), 2e3);
  for (std::size_t k = 1; k < record.rows; k += 2) {
    record.channels[0].statuses[k] = SampleStatus::kRepeated;
  }
  const BandAnalysis analysis = Answer(record);
  EXPECT_FALSE(analysis.answered);
  EXPECT_EQ(analysis.record.rate_hz, 2e3);
  EXPECT_EQ(analysis.record.fresh_rate_hz, 1e3);
  EXPECT_EQ(NumberOf(analysis.findings, FindingKind::kRepeated, "repeated"), 3000);
  EXPECT_EQ(NumberOf(analysis.findings, FindingKind::kRepeated, "readings"), 6000);
}

TEST(BandAnalysis, TimesOfUnknownAgeGiveNoBandEither) {
  // a polled sensor at 122/s, asked for a band that its rate would allow
  trial::Record record = RecordOf(Samples(122, 1220, 0.03, {{1e-6, 30}}), 122);
  BandQuestion question;
  question.band = {6, 5, 45, Corners::kWhole};
  EXPECT_TRUE(Answer(record, question).answered);
  record.stretches[0].time_uncertainty_s = 2.3e-3;
  record.timing = trial::Timing::kPolled;
  EXPECT_FALSE(Answer(record, question).answered);
  // arrivals may scatter as they like: a free-running source has a clock of its own
  trial::Record stream = RecordOf(Samples(kRateHz, 30'000, 0.03, {{1e-6, 100}}), kRateHz);
  stream.timing = trial::Timing::kArrival;
  stream.stretches[0].time_uncertainty_s = 2e-3;
  EXPECT_TRUE(Answer(stream).answered);
}

TEST(BandAnalysis, StrongTremorOnAFifthOfASecondIsNotAnswered) {
  // fewer than two periods of it: no model of the tremor either
  const std::vector<double> in = Samples(kRateHz, 2'000, 0.03, {{1e-6, 100}, {5e-4, 8.3, 0.7}});
  const BandAnalysis analysis = Answer(RecordOf(in, kRateHz));
  EXPECT_FALSE(analysis.answered);
  ASSERT_THAT(RefusalsIn(analysis.findings), ::testing::ElementsAre(FindingKind::kTooShort));
  const Finding refusal = FirstOf(analysis.findings, FindingKind::kTooShort);
  EXPECT_ABS(NumberOf(refusal, "settled_s"), 0, 5e-4, "the third decimal");
  EXPECT_EQ(NumberOf(refusal, "needed_s"), 0.1);
  EXPECT_ABS(NumberOf(refusal, "record_s"), 2.0, 0.05, "the first decimal");
  EXPECT_FALSE(analysis.numbers);
  EXPECT_EQ(analysis.band.order, 6);
}

TEST(BandAnalysis, HolesAreLeftOutBridgedOrSplitAt) {
  const std::vector<double> truth = Samples(kRateHz, 40'000, 0.03, {{1e-6, 100}, {1e-4, 8.3}});
  trial::Record record = RecordOf(truth, kRateHz);
  trial::Channel& channel = record.channels[0];
  for (std::size_t row = 5000; row < 35'000; row += 1000) {
    channel.values[row] = 99.999e-3;  // what the sensor hands out beyond its range
    channel.statuses[row] = SampleStatus::kOver;
  }
  for (std::size_t row = 30'500; row < 30'800; ++row) {
    channel.values[row] = kNaN;
    channel.statuses[row] = SampleStatus::kLate;
  }
  const BandAnalysis analysis = Answer(record);
  ASSERT_TRUE(analysis.answered);
  EXPECT_EQ(analysis.record.segments, 2U);
  EXPECT_EQ(analysis.record.bridged, 30U);
  const Finding excluded = FirstOf(analysis.findings, FindingKind::kExcluded);
  EXPECT_EQ(NumberOf(excluded, "excluded"), 330);
  EXPECT_EQ(NumberOf(excluded, "readings"), 40'000);
  EXPECT_EQ(TextOf(excluded, "statuses"), "over 30, late 300");
  EXPECT_LT(analysis.numbers->part.window.end_s, 3.05);
  EXPECT_REL(analysis.numbers->rms.rms_m, 1e-6 / kRootTwo, 3e-5, "settled window, bridged samples");
  EXPECT_GT(analysis.numbers->bridged_rms_m, 0);
  EXPECT_LT(analysis.numbers->bridged_rms_m, 1e-9);
  EXPECT_TRUE(std::isnan(analysis.filtered_m[30'550]));
  EXPECT_LT(analysis.record.peak_to_peak_m, 2.1e-4) << "no status other than ok enters";
}

TEST(BandAnalysis, SaysWhatTheSensorsAveragingPasses) {
  trial::Record record = RecordOf(Samples(kRateHz, 30'000, 0.03, {{1e-6, 90}}), kRateHz);
  EXPECT_FALSE(Answer(record).numbers->sensor.gain_at_tone);
  record.metadata.sampling_s = 1e-3;
  record.metadata.averages = 7;
  const BandAnalysis averaged = Answer(record);
  EXPECT_REL(*averaged.numbers->sensor.gain_at_tone, trial::AveragingGain(90, 1e-3, 7), 1e-9,
             "tone's fit");
  EXPECT_FALSE(averaged.answered);
  const Finding refusal = FirstOf(averaged.findings, FindingKind::kGainTooLow);
  EXPECT_EQ(NumberOf(refusal, "gain"), *averaged.numbers->sensor.gain_at_tone);
  EXPECT_EQ(NumberOf(refusal, "averages"), 6);
  EXPECT_REL(averaged.numbers->tone->amplitude_m, 1e-6 / trial::AveragingGain(90, 1e-3, 7), 1e-6,
             "an estimate beside the reason");
  record.metadata.averages = 6;
  const BandAnalysis divided = Answer(record);
  EXPECT_TRUE(divided.answered && divided.numbers->sensor.amplitude_verified);
  EXPECT_REL(divided.numbers->rms.rms_m, 1e-6 / kRootTwo / trial::AveragingGain(90, 1e-3, 6), 5e-6,
             "divided out; part of a row");
  EXPECT_REL(divided.numbers->rms.as_measured_m, 1e-6 / kRootTwo, 5e-6, "part of a row");
}

TEST(BandAnalysis, AnUncertainRateMakesTheFrequencyUncertain) {
  trial::Record record = RecordOf(Samples(kRateHz, 30'000, 0.03, {{1e-6, 225}}), kRateHz);
  record.stretches[0].time_uncertainty_s = 4e-5;
  EXPECT_REL(Answer(record).numbers->tone->fit.frequency_uncertainty_hz, 225 * kRootTwo * 4e-5 / 3,
             1e-3, "noise's share");
}

TEST(BandAnalysis, HarmonicsDriftAndTremorStandBesideTheNumber) {
  std::vector<double> values =
      Samples(kRateHz, 40'000, 0.03, {{1e-5, 225, 0.3}, {2e-7, 450, 1}, {1e-4, 8.3, 0.7}});
  Noise noise(3);
  for (std::size_t k = 0; k < values.size(); ++k) {
    values[k] += 1e-8 * noise() + 1e-5 * static_cast<double>(k) / kRateHz;
  }
  const BandAnalysis analysis = Answer(RecordOf(values, kRateHz));
  ASSERT_TRUE(analysis.answered && analysis.numbers->harmonics && analysis.slow_motion);
  ASSERT_TRUE(analysis.numbers->harmonics->thd) << "ten times its size of tremor is taken off";
  EXPECT_ABS(*analysis.numbers->harmonics->thd, 0.02, 1e-4, "noise: sqrt(2/N) of 0.1 %");
  EXPECT_REL(*analysis.slow_motion->tremor_rms, 1e-4 / kRootTwo, 0.05, "4 s of Hann segments");
  EXPECT_ABS(analysis.slow_motion->drift_per_s, 1e-5, 4e-6, "part periods of tremor");
  const std::vector<double> still = Samples(kRateHz, 40'000, 0.03, {{1e-5, 225}, {2e-7, 450, 1}});
  EXPECT_ABS(*Answer(RecordOf(still, kRateHz)).numbers->harmonics->thd, 0.02, 1e-6, "no noise");
}

TEST(BandAnalysis, KnownUnevenTimesArePutOnAGrid) {
  // 0.5 us of jitter in 100 us, which ignored would add 7e-4 of the tone; three readings missing
  Noise noise(9);
  std::vector<double> values;
  std::vector<double> times_s;
  for (int k = 0; k < 30'000; ++k) {
    if (k == 11'111 || k == 22'222 || k == 22'223) continue;
    times_s.push_back((k + 0.005 * std::clamp(noise(), -3.0, 3.0)) / kRateHz);
    values.push_back(0.03 + 1e-6 * std::sin(2 * std::numbers::pi * 225 * times_s.back()));
  }
  trial::Record record = RecordOf(values, kRateHz);
  record.timing = trial::Timing::kPolled;
  record.stretches[0].time_uncertainty_s = 5e-7;
  record.raw_times_s = times_s;
  record.times_are_known = true;
  const BandAnalysis analysis = Answer(record);
  ASSERT_TRUE(analysis.answered);
  EXPECT_REL(analysis.numbers->rms.rms_m, 1e-6 / kRootTwo, 1e-4, "settled; the grid's bound");
  EXPECT_ABS(analysis.numbers->tone->fit.frequency_hz, 225, 1e-4, "the grid's slope");
  const Finding grid = analysis.findings.list().back();
  EXPECT_EQ(grid.kind, FindingKind::kRegularGrid);
  EXPECT_ABS(NumberOf(grid, "jitter_s"), 5.5e-7, 0.5e-7, "0.0005 ms to 0.0006 ms");
  EXPECT_EQ(NumberOf(grid, "readings"), 29'997);
  EXPECT_EQ(NumberOf(grid, "missing"), 3);
  // rows are the record's
  EXPECT_EQ(analysis.record.rows, record.rows);
  EXPECT_EQ(analysis.filtered_m.size(), record.rows);
  for (const std::size_t row : {11'110U, 11'111U, 22'221U, 25'000U}) {
    EXPECT_ABS(analysis.filtered_m[row], 1e-6 * std::sin(2 * std::numbers::pi * 225 * times_s[row]),
               3e-9, "3 times the jitter: the grid's place is not the reading's");
  }
}

TEST(BandAnalysis, KnownTimesTooUnevenAreAReason) {
  trial::Record record = RecordOf(Samples(kRateHz, 10'000, 0.03, {{1e-6, 100}}), kRateHz);
  Noise noise(10);
  for (int k = 0; k < 10'000; ++k) record.raw_times_s.push_back((k + 0.3 * noise()) / kRateHz);
  record.times_are_known = true;
  const BandAnalysis analysis = Answer(record);
  EXPECT_FALSE(analysis.answered);
  EXPECT_TRUE(analysis.findings.Has(FindingKind::kTimesTooUneven));
}

TEST(BandAnalysis, NoiseHasNoDriveAndNoTone) {
  Noise noise(11);
  std::vector<double> values(30'000, 0.03);
  for (double& value : values) value += 1e-6 * noise();
  const BandAnalysis refused = Answer(RecordOf(values, kRateHz));
  EXPECT_FALSE(refused.answered);
  EXPECT_THAT(RefusalsIn(refused.findings), ::testing::ElementsAre(FindingKind::kNoDrive));
  // of all samples there is an answer for whatever is there
  BandQuestion all;
  all.choice = WindowChoice::kAll;
  const BandAnalysis analysis = Answer(RecordOf(values, kRateHz), all);
  ASSERT_TRUE(analysis.answered);
  EXPECT_FALSE(analysis.numbers->tone);
  EXPECT_FALSE(analysis.numbers->sensor.gain_at_tone);
  EXPECT_REL(analysis.numbers->residual_rms_m, analysis.numbers->rms.rms_m, 1e-3,
             "every n-th sample stands for the window");
  // white noise of 1 um over 5 kHz: the band's share is the integral of |H|^4
  const FilterDesign design = Designed({}, kRateHz);
  double share = 0;
  for (int k = 0; k < 5000; ++k) share += std::pow(Magnitude(design, k + 0.5), 4) / 5000;
  EXPECT_REL(analysis.numbers->rms.rms_m, 1e-6 * std::sqrt(share), 0.05,
             "2 B T = 2000 free samples");
}

TEST(BandAnalysis, RecordsThatCannotBeReadAreErrors) {
  const auto error = [](const trial::Record& record, const BandQuestion& question = {}) {
    const auto analysis = AnalyzeBand(record, question);
    EXPECT_FALSE(analysis);
    return analysis.error();
  };
  trial::Record record = RecordOf(Samples(kRateHz, 100, 0.03, {}), kRateHz);
  BandQuestion backwards;
  backwards.band = {6, 500, 20, Corners::kWhole};
  EXPECT_EQ(error(record, backwards).cause, Cause::kUsage);
  record.channels[0].unit = "V";
  EXPECT_EQ(error(record).Text(), "its displacement has the unit 'V'; convert it to metres");
  EXPECT_EQ(error(record).cause, Cause::kCannotAnswer);
  record.channels[0].unit = "m";
  record.channels[0].statuses.assign(100, SampleStatus::kOver);
  EXPECT_EQ(
      error(record).Text(),
      "none of its 100 readings is a measurement (over 100); check the target and the sensor's "
      "range");
  record.channels.clear();
  EXPECT_EQ(error(record).Text(), "holds no displacement channel; name one displacement_m");
}

// the samples that the window is of, and of a limited number those about its middle
TEST(ReadWindow, GivesTheSamplesOfTheWindow) {
  std::vector<double> values(30'000);
  for (std::size_t k = 0; k < values.size(); ++k) {
    // on from 1 s to 2 s, and each reading its own: 1 pm a row
    const double on = k >= 10'000 && k < 20'000 ? 1 : 0;
    values[k] =
        1e-12 * static_cast<double>(k) + on * 20e-6 * std::sin(0.14 * static_cast<double>(k));
  }
  const trial::Record record = RecordOf(values, kRateHz);
  const BandAnalysis analysis = Answer(record);
  ASSERT_TRUE(analysis.answered);
  const TimeWindow& window = analysis.numbers->part.window;
  const auto first = static_cast<std::size_t>(std::lround(window.begin_s * kRateHz));
  const auto rows = static_cast<std::size_t>(std::lround(window.duration_s() * kRateHz));
  ASSERT_LT(first + rows, 20'000U) << "the record goes on behind the window";
  for (const std::size_t most : {std::size_t{1} << 20U, std::size_t{1000}}) {
    const auto samples = ReadWindow(trial::RecordRows(record), analysis, most);
    ASSERT_TRUE(samples.has_value());
    const std::size_t count = std::min(rows, most);
    const std::size_t begin = first + (rows - count) / 2;
    EXPECT_EQ(samples->values_m,
              std::vector<double>(values.begin() + static_cast<std::ptrdiff_t>(begin),
                                  values.begin() + static_cast<std::ptrdiff_t>(begin + count)));
    EXPECT_REL(samples->start_s, static_cast<double>(begin) / kRateHz, 1e-12, "rounding");
    EXPECT_EQ(samples->rate_hz, kRateHz);
  }
}

// A drive from 3 s to 5 s behind rows that were never recorded: the window lies in the second
// segment, and the middle between 0 and its begin in the first.
TEST(ReadWindow, IsOfTheSegmentThatHoldsTheWindow) {
  std::vector<double> values(50'000);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double on = k >= 30'000 ? 1 : 0;
    values[k] =
        1e-12 * static_cast<double>(k) + on * 20e-6 * std::sin(0.14 * static_cast<double>(k));
  }
  trial::Record record = RecordOf(values, kRateHz);
  record.stretches = {{0, 25'000, 0, kRateHz, 0}, {25'000, 25'000, 3.5, kRateHz, 0}};
  const BandAnalysis analysis = Answer(record);
  ASSERT_TRUE(analysis.answered);
  const TimeWindow& window = analysis.numbers->part.window;
  ASSERT_GT(window.begin_s, 4);
  const auto samples = ReadWindow(trial::RecordRows(record), analysis, 1000);
  ASSERT_TRUE(samples.has_value());
  ASSERT_EQ(samples->values_m.size(), 1000U);
  // row 25 000 is at 3.5 s
  const auto first = static_cast<std::size_t>(std::lround((samples->start_s - 1) * kRateHz));
  EXPECT_EQ(samples->values_m,
            std::vector<double>(values.begin() + static_cast<std::ptrdiff_t>(first),
                                values.begin() + static_cast<std::ptrdiff_t>(first + 1000)));
  EXPECT_ABS(samples->start_s + 500 / kRateHz, (window.begin_s + window.end_s) / 2, 0.51 / kRateHz,
             "the middle, half a row");
  // rows count as the record's, without those that were never recorded
  const UsedPart& part = analysis.numbers->part;
  EXPECT_EQ(part.first_row, static_cast<std::size_t>(std::lround((window.begin_s - 1) * kRateHz)));
  EXPECT_EQ(part.rows, static_cast<std::size_t>(std::lround(window.duration_s() * kRateHz)));
  ASSERT_TRUE(analysis.numbers->kinematics);
  EXPECT_GE(analysis.numbers->kinematics->begin, part.first_row);
  EXPECT_LE(analysis.numbers->kinematics->end, part.first_row + part.rows);
  ASSERT_EQ(analysis.filtered_m.size(), values.size());
  const auto rows = std::span(analysis.filtered_m).subspan(part.first_row, part.rows);
  EXPECT_REL(Rms(rows), analysis.numbers->rms.as_measured_m, 1e-12, "order of the sums");
}

// the readings' rail: 1e30 m
TEST(BandAnalysis, ReadingsOfNoDisplacementAreErrors) {
  for (const double sign : {1.0, -1.0}) {
    std::vector<double> values = Samples(kRateHz, 3000, 0, {{1, 100}});
    const auto answer = [&](double scale) {
      std::vector<double> scaled = values;
      for (double& value : scaled) value *= sign * scale;
      // one end alone is that far
      for (double& value : scaled) value += sign * 0.5 * scale;
      return AnalyzeBand(RecordOf(scaled, kRateHz), {});
    };
    // the crest of 100 rows a period is 1
    EXPECT_TRUE(answer(0.995e30 / 1.5)) << sign;
    const auto error = answer(1.005e30 / 1.5);
    ASSERT_FALSE(error) << sign;
    EXPECT_EQ(error.error().cause, Cause::kCannotAnswer);
  }
}

// ---- The sensor's averaging: 16 samples of 0.33 ms have a gain of a half at the frequency that
// bisection finds.

double FrequencyOfGain(double gain) {
  double below_hz = 10;
  double above_hz = 189;  // it is 0 at 189.4 Hz
  for (int step = 0; step < 60; ++step) {
    const double middle_hz = 0.5 * (below_hz + above_hz);
    (trial::AveragingGain(middle_hz, 0.33e-3, 16) > gain ? below_hz : above_hz) = middle_hz;
  }
  return below_hz;
}

BandAnalysis Averaged(double tone_hz, double amplitude_m, int averages) {
  std::vector<double> values = Samples(5e3, 15'000, 0.03, {{amplitude_m, tone_hz}});
  Noise noise(1);
  for (double& value : values) value += 1e-9 * noise();
  trial::Record record = RecordOf(values, 5e3);
  record.metadata.sampling_s = 0.33e-3;
  record.metadata.averages = averages;
  return Answer(record);
}

TEST(BandAnalysis, BelowHalfTheGainOfTheSensorThereIsNoAnswer) {
  for (const double gain : {0.505, 0.495}) {
    const BandAnalysis analysis = Averaged(FrequencyOfGain(gain), 1e-6, 16);
    EXPECT_EQ(analysis.answered, gain > 0.5) << gain;
    EXPECT_EQ(analysis.findings.Has(FindingKind::kGainCorrected), gain > 0.5) << gain;
    EXPECT_EQ(analysis.findings.Has(FindingKind::kGainTooLow), gain < 0.5) << gain;
    EXPECT_EQ(analysis.numbers->sensor.amplitude_verified, gain > 0.5) << gain;
    const FindingKind kind = gain > 0.5 ? FindingKind::kGainCorrected : FindingKind::kGainTooLow;
    EXPECT_REL(NumberOf(analysis.findings, kind, "gain"), gain, 1e-6, "the tone's fit");
  }
  const BandAnalysis plain = Averaged(FrequencyOfGain(0.505), 1e-6, 1);
  EXPECT_FALSE(plain.findings.Has(FindingKind::kGainCorrected)) << "nothing is averaged";
  EXPECT_FALSE(plain.numbers->sensor.divided_out);
}

// Below 2 % nothing is divided out: a gain of 0.02 would make fifty of one.
TEST(BandAnalysis, AGainNextToNothingIsNotDividedOut) {
  for (const double gain : {0.0202, 0.0198}) {
    const BandAnalysis analysis = Averaged(FrequencyOfGain(gain), 1e-6, 16);
    ASSERT_TRUE(analysis.numbers && analysis.numbers->tone) << gain;
    EXPECT_EQ(analysis.numbers->sensor.divided_out, gain > 0.02) << gain;
    const double divided = gain > 0.02 ? gain : 1;
    EXPECT_REL(analysis.numbers->tone->amplitude_m, 1e-6 / divided, 1e-3,
               "noise, and the fit of the frequency beside the gain's zero");
  }
}

// Without a drive the least and the greatest gain of the band stand beside the noise.
TEST(BandAnalysis, WithoutADriveTheGainsOfTheBandAreNoted) {
  const BandAnalysis none = Averaged(100, 0, 2);
  const Finding note = FirstOf(none.findings, FindingKind::kGainInBand);
  EXPECT_EQ(note.severity, Severity::kNote);
  EXPECT_REL(NumberOf(note, "least"), trial::AveragingGain(500, 0.33e-3, 2), 1e-12, "rounding");
  EXPECT_REL(NumberOf(note, "greatest"), trial::AveragingGain(20, 0.33e-3, 2), 1e-12, "rounding");
  EXPECT_FALSE(Averaged(100, 0, 1).findings.Has(FindingKind::kGainInBand));
}

// Every length scales with the sensor's gain: u^2 + (length u_gain)^2.
TEST(BandAnalysis, TheGainIsInTheUncertaintyOfEveryLength) {
  std::vector<double> values =
      Samples(2e3, 8000, 0.03, {{1e-5, 110, 0.3}, {1e-6, 220, 1}, {5e-5, 8.3, 0.7}});
  Noise noise(3);
  for (std::size_t k = 0; k < values.size(); ++k) {
    values[k] += 1e-7 * noise() + 1e-4 * static_cast<double>(k) / 2e3;
  }
  const trial::Record record = RecordOf(values, 2e3);
  constexpr double kGain = 0.03;
  BandQuestion question;
  question.gain_uncertainty = kGain;
  const BandAnalysis without = Answer(record);
  const BandAnalysis with = Answer(record, question);
  ASSERT_TRUE(with.answered && with.numbers->tone && with.numbers->harmonics && with.slow_motion);
  EXPECT_EQ(NumberOf(with.findings, FindingKind::kCalibrationIncluded, "share"), kGain);
  const auto expect = [](double after, double before, double length) {
    EXPECT_REL(after, std::hypot(before, kGain * length), 1e-13, "rounding");
  };
  const ToneNumbers& tone = *with.numbers->tone;
  const ToneNumbers& plain = *without.numbers->tone;
  expect(tone.amplitude_uncertainty_m, plain.amplitude_uncertainty_m, tone.amplitude_m);
  const Interval limits =
      WithGain(plain.amplitude_m, {plain.amplitude_lower_m, plain.amplitude_upper_m}, kGain);
  EXPECT_EQ(tone.amplitude_lower_m, limits.lower);
  EXPECT_EQ(tone.amplitude_upper_m, limits.upper);
  for (std::size_t k = 0; k < with.numbers->harmonics->harmonics.size(); ++k) {
    const Harmonic& harmonic = with.numbers->harmonics->harmonics[k];
    expect(harmonic.amplitude_uncertainty,
           without.numbers->harmonics->harmonics[k].amplitude_uncertainty, harmonic.amplitude);
  }
  expect(with.slow_motion->drift_uncertainty_per_s, without.slow_motion->drift_uncertainty_per_s,
         with.slow_motion->drift_per_s);
  expect(with.slow_motion->tremor_rms_uncertainty, without.slow_motion->tremor_rms_uncertainty,
         *with.slow_motion->tremor_rms);
  EXPECT_EQ(tone.frequency_upper_hz, plain.frequency_upper_hz) << "a frequency is no length";
}

TEST(BandAnalysis, TheGainIsInTheUncertaintyOfAKnownTone) {
  std::vector<double> values = Samples(400, 1200, 0.03, {{1e-5, 90, 0.4}});
  Noise noise(2);
  for (double& value : values) value += 2e-7 * noise();
  const trial::Record record = RecordOf(values, 400);
  BandQuestion question;
  question.drive_frequency_hz = 90;
  const BandAnalysis without = Answer(record, question);
  question.gain_uncertainty = 0.03;
  const BandAnalysis with = Answer(record, question);
  ASSERT_TRUE(with.known_tone && without.known_tone);
  const SineFit& fit = without.known_tone->fit;
  EXPECT_REL(with.known_tone->fit.amplitude_uncertainty,
             std::hypot(fit.amplitude_uncertainty, 0.03 * fit.amplitude), 1e-13, "rounding");
}

// The root of the squared errors (k = 2) of what was interpolated in the window, over its rows.
TEST(BandAnalysis, WhatWasInterpolatedIsSpreadOverTheWindow) {
  trial::Record record = RecordOf(Samples(kRateHz, 30'000, 0.03, {{1e-6, 100}}), kRateHz);
  Noise noise(3);
  for (double& value : record.channels[0].values) value += 3e-8 * noise();
  std::vector<RowRange> holes;
  for (std::size_t row = 6000; row < 24'000; row += 3000) {
    record.channels[0].statuses[row] = SampleStatus::kLate;
    holes.push_back({row, row + 1});
  }
  const BandAnalysis analysis = Answer(record);
  ASSERT_TRUE(analysis.answered);
  const trial::RecordRows rows(record);
  const Segments segments = SplitAtHoles(rows, 0, holes).value();
  ASSERT_EQ(segments.bridged, 6U);
  const UsedPart& part = analysis.numbers->part;
  double square = 0;
  std::size_t within = 0;
  for (const Bridge& bridge : segments.parts.at(0).bridges) {
    if (bridge.sample < part.first_row || bridge.sample >= part.first_row + part.rows) continue;
    square += 4 * bridge.error_square / static_cast<double>(part.rows);
    ++within;
  }
  EXPECT_GT(within, 0U);
  EXPECT_REL(analysis.numbers->bridged_rms_m, std::sqrt(square), 1e-12, "rounding");
  EXPECT_EQ(NumberOf(analysis.findings, FindingKind::kInterpolated, "interpolated"), 6);
}

// Of a drive that moves the gain is that in the middle of where it does.
TEST(BandAnalysis, OfADriveThatMovesTheGainIsThatOfItsMiddle) {
  std::vector<double> values(20'000);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double t_s = static_cast<double>(k) / 5e3;
    values[k] = 0.03 + 1e-5 * std::sin(2 * std::numbers::pi * (100 + 2 * t_s) * t_s);
  }
  trial::Record record = RecordOf(values, 5e3);
  record.metadata.averages = 8;
  record.metadata.sampling_s = 0.5e-3;
  const BandAnalysis analysis = Answer(record);
  ASSERT_TRUE(analysis.answered);
  ASSERT_FALSE(analysis.numbers->tone) << "no sine holds half of a drive that moves by 16 Hz";
  const StateInterval& state = analysis.numbers->part.state;
  const double middle_hz = 0.5 * (state.from_hz + state.to_hz);
  EXPECT_ABS(middle_hz, 108, 0.2, "what has settled lies about 2 s");
  EXPECT_REL(*analysis.numbers->sensor.gain_at_tone, trial::AveragingGain(middle_hz, 0.5e-3, 8),
             1e-12, "rounding");
}

}  // namespace
}  // namespace haptometer::dsp
