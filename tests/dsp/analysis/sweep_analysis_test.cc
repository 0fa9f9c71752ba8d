#include "dsp/analysis/sweep_analysis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "tests/dsp/findings.h"
#include "tests/dsp/records.h"
#include "tests/dsp/repetitions.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

using ::testing::ElementsAre;

constexpr double kPi = std::numbers::pi;
constexpr double kRateHz = 2000;
constexpr double kResonanceHz = 175;
constexpr double kQuality = 12;
constexpr double kGain = 2e-6;  // m/V at rest
constexpr double kVolts = 2;

std::complex<double> ClosedForm(double frequency_hz) {
  const double u = frequency_hz / kResonanceHz;
  return kGain / std::complex<double>(1 - u * u, u / kQuality);
}

// The motion of an oscillator under a chirp of 2 V from 60 to 450 Hz, exactly but for the drive's
// straight line between sub-samples: x'' + w/Q x' + w^2 x = w^2 gain v(t) by the step of its
// complex mode, z' = s z + v, x = Im(z) w^2 gain / Im(s).
trial::Record Chirp(double duration_s, double noise_m, std::uint64_t seed, bool with_drive,
                    double quality = kQuality) {
  constexpr int kSteps = 16;  // the line is wrong by (2 pi 450 / 32000)^2 / 12 = 7e-4 at most
  const double h = 1 / kRateHz / kSteps;
  const double w = 2 * kPi * kResonanceHz;
  const std::complex<double> s(-w / (2 * quality), w * std::sqrt(1 - 1 / (4 * quality * quality)));
  const std::complex<double> e = std::exp(s * h);
  const std::complex<double> from_end = (e - 1.0 - s * h) / (s * s * h);
  const std::complex<double> from_begin = (e - 1.0) / s - from_end;
  const auto drive_at = [&](double t_s) {
    return kVolts * std::sin(2 * kPi * (60 + 0.5 * (450 - 60) * t_s / duration_s) * t_s);
  };
  Noise noise(seed);
  std::vector<double> drive_v;
  std::vector<double> displacement_m;
  std::complex<double> z;
  const auto samples = static_cast<int>(duration_s * kRateHz);
  for (int n = 0; n < samples; ++n) {
    drive_v.push_back(drive_at(n / kRateHz));
    displacement_m.push_back(1e-3 + w * w * kGain * z.imag() / s.imag() + noise_m * noise());
    for (int step = 0; step < kSteps; ++step) {
      const double t_s = n / kRateHz + step * h;
      z = e * z + from_begin * drive_at(t_s) + from_end * drive_at(t_s + h);
    }
  }
  trial::Record record = RecordOf(std::move(displacement_m), kRateHz);
  record.metadata.averages = 1;
  if (!with_drive) return record;
  trial::Channel drive = record.channels.front();
  drive.name = "coil";
  drive.role = trial::ChannelRole::kVoltage;
  drive.unit = "V";
  drive.values = std::move(drive_v);
  record.channels.push_back(std::move(drive));
  return record;
}

SweepAnswer Analyzed(const trial::Record& record, const SweepQuestion& question = {}) {
  return AnalyzeSweep(trial::RecordRows(record), question).value();
}

bool Holds(const Interval& interval, double truth) {
  return interval.lower <= truth && truth <= interval.upper;
}

TEST(AnalyzeSweep, OfADrivenOscillatorIsTheClosedForm) {
  const SweepAnswer answer = Analyzed(Chirp(16, 0, 1, true));
  ASSERT_TRUE(answer.answered);
  EXPECT_TRUE(std::ranges::all_of(answer.findings.list(), [](const Finding& finding) {
    return finding.severity == Severity::kNote || finding.kind == FindingKind::kAveragingUnknown;
  })) << "all is determined";
  EXPECT_EQ(answer.drive, "coil");
  EXPECT_EQ(answer.amplitude_unit, "m/V");
  EXPECT_EQ(answer.resolution_hz, 0.25);
  EXPECT_TRUE(answer.amplitude_verified);
  double worst = 0;
  double worst_phase_rad = 0;
  for (const SweepPoint& point : answer.points) {
    if (point.frequency_hz < 80 || point.frequency_hz > 420) continue;
    const std::complex<double> truth = ClosedForm(point.frequency_hz);
    worst = std::max(worst, std::abs(point.amplitude / std::abs(truth) - 1));
    worst_phase_rad =
        std::max(worst_phase_rad, std::abs(std::arg(std::polar(1.0, *point.phase_rad) / truth)));
    EXPECT_GT(*point.coherence, 0.99) << point.frequency_hz;
  }
  EXPECT_ABS(worst, 0, 0.02, "a window of 58 Q / f0: measured 0.012");
  EXPECT_ABS(worst_phase_rad, 0, 0.02, "the same");
  ASSERT_TRUE(answer.resonance);
  EXPECT_PRED2(Holds, answer.resonance->frequency_hz, kResonanceHz);
  EXPECT_PRED2(Holds, answer.resonance->quality_factor, kQuality);
  EXPECT_REL(answer.resonance->fit.frequency_hz, kResonanceHz, 1e-3, "the window: measured");
}

struct Case {
  const char* name;
  double duration_s;
  double noise_m;
  bool with_drive;
};

class SweepIntervals : public ::testing::TestWithParam<Case> {};

// Beside some 50 um at resonance. The intervals contain what the method may change, a bound.
TEST_P(SweepIntervals, HoldTheTruthUnderNoise) {
  const auto& [name, duration_s, noise_m, with_drive] = GetParam();
  const int repetitions = Repetitions(with_drive ? 40 : 10);
  int frequency = 0;
  int quality = 0;
  for (int seed = 1; seed <= repetitions; ++seed) {
    const auto answer =
        Analyzed(Chirp(duration_s, noise_m, static_cast<std::uint64_t>(seed), with_drive));
    ASSERT_TRUE(answer.resonance) << seed;
    const SweepResonance& found = *answer.resonance;
    frequency += Holds(found.frequency_hz, kResonanceHz) ? 1 : 0;
    quality += Holds(found.quality_factor, kQuality) ? 1 : 0;
    EXPECT_LT(found.frequency_hz.upper - found.frequency_hz.lower, 2.0);
    EXPECT_LT(found.quality_factor.upper - found.quality_factor.lower, 4.0);
  }
  ExpectCoverage("f0", frequency, repetitions, 100);
  ExpectCoverage("Q", quality, repetitions, 100);
}
INSTANTIATE_TEST_SUITE_P(Each, SweepIntervals,
                         ::testing::Values(Case{"Of8sIn1um", 8, 1e-6, true},
                                           Case{"Of4sIn1um", 4, 1e-6, true},
                                           Case{"Of8sIn5um", 8, 5e-6, true},
                                           Case{"WithoutDriveOf40sIn2um", 40, 2e-6, false}),
                         [](const auto& test) { return std::string(test.param.name); });

// Of seed 12 of the first case: at 30 Hz, below the drive's lowest frequency, the half as long
// segments are coherent by chance, and noise over next to no drive reads 11 mm/V.
TEST(AnalyzeSweep, ANoisyFrequencyThatTheDriveDoesNotReachHidesNoResonance) {
  const SweepAnswer answer = Analyzed(Chirp(8, 1e-6, 12, true));
  ASSERT_TRUE(answer.resonance);
  EXPECT_PRED2(Holds, answer.resonance->frequency_hz, kResonanceHz);
  EXPECT_PRED2(Holds, answer.resonance->quality_factor, kQuality);
}

TEST(AnalyzeSweep, WithoutDriveAnswersAmplitudeOnlyAndSaysSo) {
  const SweepAnswer answer = Analyzed(Chirp(40, 0.2e-6, 3, false));
  ASSERT_TRUE(answer.answered);
  EXPECT_EQ(answer.amplitude_unit, "m");
  EXPECT_EQ(answer.drive, "");
  EXPECT_TRUE(answer.findings.Has(FindingKind::kNoDriveChannel));
  EXPECT_TRUE(answer.findings.Has(FindingKind::kConstantDriveAssumed));
  double worst = 0;
  for (const SweepPoint& point : answer.points) {
    EXPECT_FALSE(point.phase_rad || point.coherence);
    if (point.frequency_hz < 80 || point.frequency_hz > 250) continue;
    const double truth = kVolts * std::abs(ClosedForm(point.frequency_hz));
    worst = std::max(worst, std::abs(point.amplitude / truth - 1));
  }
  EXPECT_ABS(worst, 0, 0.1, "0.2 um of noise beside 4 um, and the sweep's lateness: measured");
  ASSERT_TRUE(answer.resonance);
  EXPECT_PRED2(Holds, answer.resonance->frequency_hz, kResonanceHz);
  EXPECT_PRED2(Holds, answer.resonance->quality_factor, kQuality);
}

// 390 Hz in some seconds, past resonances of every width: what is stated holds the truth, and a
// sweep too fast for that is said to be.
TEST(AnalyzeSweep, WithoutDriveNoIntervalIsTooNarrow) {
  const SweepQuestion swept{.lower_hz = 60, .upper_hz = 450};
  int determined = 0;
  for (const double quality : {5.0, 12.0, 20.0, 50.0, 300.0}) {
    for (const double duration_s : {4.0, 10.0, 30.0}) {
      const SweepAnswer answer = Analyzed(Chirp(duration_s, 0, 1, false, quality), swept);
      const double fast =
          2 * (390 / duration_s) * quality * quality / (kPi * kResonanceHz * kResonanceHz);
      if (!answer.resonance) {
        EXPECT_GT(fast, 0.1) << quality << " in " << duration_s << " s";
        continue;
      }
      ++determined;
      EXPECT_LT(fast, 0.25) << quality << " in " << duration_s << " s";
      EXPECT_PRED2(Holds, answer.resonance->frequency_hz, kResonanceHz)
          << quality << " in " << duration_s << " s";
      EXPECT_PRED2(Holds, answer.resonance->quality_factor, quality) << duration_s;
    }
  }
  EXPECT_GE(determined, 6);
  EXPECT_TRUE(Analyzed(Chirp(10, 0, 1, false, 50), swept).findings.Has(FindingKind::kSweepTooFast));
}

TEST(AnalyzeSweep, DividesTheSensorsGainOutOrSaysThatItIsUnknown) {
  trial::Record record = Chirp(8, 0, 1, true);
  const SweepAnswer plain = Analyzed(record);
  record.metadata.averages = 4;
  record.metadata.sampling_s = 0.5e-3;
  const SweepAnswer divided = Analyzed(record);
  EXPECT_TRUE(divided.findings.Has(FindingKind::kSweepSensorLimit));
  ASSERT_GT(plain.points.size(), divided.points.size());
  const SweepPoint& point = divided.points[100];
  // a mean of four samples 0.5 ms apart: sin(4 x) / (4 sin(x)), x = pi f 0.5 ms
  const double x = kPi * point.frequency_hz * 0.5e-3;
  const double gain = std::sin(4 * x) / (4 * std::sin(x));
  const auto same = std::ranges::find(plain.points, point.frequency_hz, &SweepPoint::frequency_hz);
  ASSERT_NE(same, plain.points.end());
  EXPECT_REL(point.amplitude * gain, same->amplitude, 1e-12, "rounding");
  record.metadata.averages.reset();
  const SweepAnswer unknown = Analyzed(record);
  EXPECT_FALSE(unknown.amplitude_verified);
  EXPECT_TRUE(unknown.findings.Has(FindingKind::kAveragingUnknown));
}

TEST(AnalyzeSweep, SaysWhatIsNotDetermined) {
  const SweepAnswer tone =
      Analyzed(RecordOf(Samples(kRateHz, 8000, 1e-3, {{5e-6, 100, 0}}), kRateHz));
  EXPECT_FALSE(tone.answered);
  EXPECT_THAT(RefusalsIn(tone.findings), ElementsAre(FindingKind::kNoSweep));

  trial::Record record = Chirp(4, 0, 1, true);
  const SweepAnswer fine = Analyzed(record, {.resolution_hz = 0.3});
  EXPECT_FALSE(fine.answered);
  EXPECT_THAT(RefusalsIn(fine.findings), ElementsAre(FindingKind::kSweepTooShort));
  const SweepAnswer above = Analyzed(record, {.lower_hz = 250, .upper_hz = 440});
  EXPECT_TRUE(above.answered);
  EXPECT_FALSE(above.resonance) << "the resonance lies below";
  EXPECT_THAT(RefusalsIn(above.findings), ElementsAre()) << "there are points";
  const auto is_resonance = [](const Finding& finding) {
    return finding.kind >= FindingKind::kResonanceAbove &&
           finding.kind <= FindingKind::kNoResonance;
  };
  EXPECT_EQ(std::ranges::count_if(above.findings.list(), is_resonance), 1);
  EXPECT_EQ(NumberOf(Analyzed(record, {.upper_hz = 900}).findings, FindingKind::kSweepRateLimit,
                     "upper_hz"),
            2000 / 2.56);

  const SweepAnswer none = Analyzed(record, {.lower_hz = 800, .upper_hz = 900});
  EXPECT_FALSE(none.answered);
  EXPECT_THAT(RefusalsIn(none.findings), ElementsAre(FindingKind::kSweepRateLimit));

  record.channels[1].statuses[1000] = trial::SampleStatus::kOver;
  EXPECT_EQ(Analyzed(record).window.begin_s, 1001 / kRateHz);
  record.channels[1].values.assign(record.rows, 1.0);
  EXPECT_EQ(TextOf(FirstOf(Analyzed(record).findings, FindingKind::kDriveConstant), "channel"),
            "coil");
  record.timing = trial::Timing::kPolled;
  EXPECT_THAT(RefusalsIn(Analyzed(record).findings), ElementsAre(FindingKind::kSweepPolled));
  EXPECT_FALSE(AnalyzeSweep(trial::RecordRows(record), {.lower_hz = 500, .upper_hz = 20}));
}

// ---- Pieces, limits and intervals.

// A hole before the longer run, and behind it.
TEST(AnalyzeSweep, TheDriveIsTakenWhereItIsMeasuredLongest) {
  for (const std::size_t hole : {3000U, 5000U}) {
    trial::Record record = Chirp(4, 0, 1, true);
    record.channels[1].statuses[hole] = trial::SampleStatus::kOver;
    const SweepAnswer answer = Analyzed(record);
    EXPECT_EQ(TextOf(FirstOf(answer.findings, FindingKind::kDriveGaps), "channel"), "coil");
    EXPECT_EQ(answer.window.begin_s, hole < 4000 ? 3001 / kRateHz : 0) << hole;
    EXPECT_EQ(answer.window.end_s, hole < 4000 ? 4 : 5000 / kRateHz) << hole;
  }
  EXPECT_FALSE(Analyzed(Chirp(4, 0, 1, true)).findings.Has(FindingKind::kDriveGaps));
}

TEST(AnalyzeSweep, TheLongestSegmentIsTaken) {
  trial::Record record = Chirp(4, 0, 1, true);
  for (std::size_t k = 3000; k < 3600; ++k) {
    record.channels[0].statuses[k] = trial::SampleStatus::kLate;
  }
  const SweepAnswer answer = Analyzed(record);
  EXPECT_EQ(NumberOf(answer.findings, FindingKind::kLongestSegment, "segments"), 2);
  EXPECT_EQ(answer.window.begin_s, 1.8);
  EXPECT_EQ(answer.window.end_s, 4);
  EXPECT_EQ(answer.rate_hz, kRateHz);
}

// A fourth of the record, or 4 s; of what is asked for, an even number of samples, of which the
// record holds one and a half times as many.
TEST(AnalyzeSweep, SegmentsAreAFourthOfTheRecord) {
  EXPECT_EQ(Analyzed(Chirp(8, 0, 1, true)).resolution_hz, 0.5);
  EXPECT_EQ(Analyzed(Chirp(20, 0, 1, true)).resolution_hz, 0.25) << "4 s at most";
  const trial::Record record = Chirp(4, 0, 1, true);
  EXPECT_EQ(Analyzed(record, {.resolution_hz = 0.7}).resolution_hz, 2000 / 2856.0);
  // 8000 samples: segments of 5332 overlap by half, of 5334 they do not
  EXPECT_TRUE(Analyzed(record, {.resolution_hz = 2000 / 5333.0}).answered);
  const SweepAnswer fine = Analyzed(record, {.resolution_hz = 2000 / 5335.0});
  EXPECT_FALSE(fine.answered);
  EXPECT_EQ(NumberOf(fine.findings, FindingKind::kSweepTooShort, "length_s"), 4);
  EXPECT_EQ(NumberOf(fine.findings, FindingKind::kSweepTooShort, "resolution_hz"), 0.5);
}

// Below a half nothing is answered: to the frequency at which a mean of four has that.
TEST(AnalyzeSweep, EndsWhereTheSensorsGainIsAHalf) {
  trial::Record record = Chirp(8, 0, 1, true);
  record.metadata.averages = 4;
  record.metadata.sampling_s = 1e-3;
  const Findings found = Analyzed(record).findings;
  const double x = kPi * NumberOf(found, FindingKind::kSweepSensorLimit, "upper_hz") * 1e-3;
  EXPECT_REL(std::sin(4 * x) / (4 * std::sin(x)), 0.5, 1e-9, "60 halvings");
  EXPECT_EQ(FirstOf(found, FindingKind::kSweepSensorLimit).severity, Severity::kDoubt);
  // up to a frequency at which more is left, and with nothing left above the lower one
  EXPECT_FALSE(Analyzed(record, {.upper_hz = 0.99 * x / kPi * 1e3})
                   .findings.Has(FindingKind::kSweepSensorLimit));
  const SweepAnswer none = Analyzed(record, {.lower_hz = 1.01 * x / kPi * 1e3});
  EXPECT_FALSE(none.answered);
  EXPECT_THAT(RefusalsIn(none.findings), ElementsAre(FindingKind::kSweepSensorLimit));
}

// A fourth of the readings is handed out twice: 1600 of 2000 a second are new.
TEST(AnalyzeSweep, EndsWhereNewReadingsAreTooFew) {
  trial::Record record = Chirp(8, 0, 1, true);
  for (std::size_t k = 4; k < record.rows; k += 5) {
    record.channels[0].statuses[k] = trial::SampleStatus::kRepeated;
  }
  const auto limits = [&](double upper_hz) {
    return Analyzed(record, {.upper_hz = upper_hz}).findings;
  };
  EXPECT_FALSE(limits(624.9).Has(FindingKind::kSweepRateLimit));
  const Findings found = limits(640);
  EXPECT_REL(NumberOf(found, FindingKind::kSweepRateLimit, "upper_hz"), 625.0, 1e-12,
             "1600 / 2.56");
  EXPECT_REL(NumberOf(found, FindingKind::kSweepRateLimit, "new_readings_per_s"), 1600.0, 1e-12,
             "rounding");
  EXPECT_REL(NumberOf(found, FindingKind::kSweepRateLimit, "needed_per_s"), 640 * 2.56, 1e-12,
             "rounding");
}

// The largest amplitude is at the end that is nearer to the resonance at 175 Hz.
TEST(AnalyzeSweep, SaysOnWhichSideAResonanceLies) {
  const trial::Record record = Chirp(8, 0, 1, true);
  const Finding above = FirstOf(Analyzed(record, {.lower_hz = 70, .upper_hz = 130}).findings,
                                FindingKind::kResonanceAbove);
  EXPECT_EQ(above.severity, Severity::kDoubt);
  EXPECT_ABS(NumberOf(above, "highest_hz"), 130, 1, "two bins of 0.5 Hz");
  EXPECT_EQ(NumberOf(above, "from_hz"), 70);
  EXPECT_EQ(NumberOf(above, "to_hz"), 130);
  const Finding below = FirstOf(Analyzed(record, {.lower_hz = 250, .upper_hz = 440}).findings,
                                FindingKind::kResonanceBelow);
  EXPECT_ABS(NumberOf(below, "highest_hz"), 250, 1, "two bins of 0.5 Hz");
}

// With a drive channel: Student's t, and what segments of half the length change, found here by
// asking for these.
TEST(AnalyzeSweep, IntervalsByADriveHoldTheChangeBySegmentsOfHalfTheLength) {
  const trial::Record record = Chirp(16, 1e-6, 5, true);
  const SweepResonance whole = *Analyzed(record, {.resolution_hz = 0.25}).resonance;
  const SweepResonance half = *Analyzed(record, {.resolution_hz = 0.5}).resonance;
  const double student = StudentCritical(whole.fit.degrees_of_freedom);
  const double change_hz = std::abs(whole.fit.frequency_hz - half.fit.frequency_hz);
  const double reach_hz = student * whole.fit.frequency_uncertainty_hz + change_hz;
  EXPECT_GT(change_hz, 1e-6) << "else nothing is shown";
  EXPECT_REL(whole.frequency_hz.upper, whole.fit.frequency_hz + reach_hz, 1e-13, "rounding");
  EXPECT_REL(whole.frequency_hz.lower, whole.fit.frequency_hz - reach_hz, 1e-13, "rounding");
  const double reach = student * whole.fit.quality_factor_uncertainty +
                       std::abs(whole.fit.quality_factor - half.fit.quality_factor);
  EXPECT_REL(whole.quality_factor.upper, whole.fit.quality_factor + reach, 1e-13, "rounding");
  EXPECT_REL(whole.quality_factor.lower, whole.fit.quality_factor - reach, 1e-13, "rounding");
}

// Without one: blocks of twice the length, the sweep's lateness and its widening. 390 Hz in 30 s.
TEST(AnalyzeSweep, IntervalsWithoutADriveHoldTheSweepsLateness) {
  const trial::Record record = Chirp(30, 0, 1, false);
  const auto found = [&](double resolution_hz) {
    return *Analyzed(record, {.lower_hz = 60, .upper_hz = 450, .resolution_hz = resolution_hz})
                .resonance;
  };
  const SweepResonance whole = found(30);
  const SweepResonance longer = found(15);
  const double width_hz = whole.fit.frequency_hz / whole.fit.quality_factor;
  const double rate_hz_per_s = 390 / 30.0;
  const double late_hz = rate_hz_per_s / (kPi * width_hz);
  const double student = StudentCritical(whole.fit.degrees_of_freedom);
  EXPECT_REL(whole.frequency_hz.upper - whole.fit.frequency_hz,
             student * whole.fit.frequency_uncertainty_hz +
                 std::abs(whole.fit.frequency_hz - longer.fit.frequency_hz) + late_hz,
             0.01, "the rate is a median over the points");
  const double fast = 2 * rate_hz_per_s / (kPi * width_hz * width_hz);
  EXPECT_REL(whole.quality_factor.upper - whole.fit.quality_factor -
                 std::abs(whole.fit.quality_factor - longer.fit.quality_factor) -
                 student * whole.fit.quality_factor_uncertainty,
             fast * fast * whole.fit.quality_factor, 0.02, "twice that of the rate");
}

// The rate at which k is 1/5: of the apparent width it is 0.2 pi width^2 / 2.
TEST(AnalyzeSweep, ATooFastOneSaysTheRateThatIsNot) {
  const SweepQuestion swept{.lower_hz = 60, .upper_hz = 450};
  const Finding fast =
      FirstOf(Analyzed(Chirp(6, 0, 1, false, 30), swept).findings, FindingKind::kSweepTooFast);
  EXPECT_EQ(fast.severity, Severity::kDoubt);
  EXPECT_REL(NumberOf(fast, "rate_hz_per_s"), 65.0, 0.02, "390 Hz in 6 s");
  EXPECT_REL(NumberOf(fast, "frequency_hz"), kResonanceHz, 0.05, "late");
  // the apparent Q is below the true one of 30, above a third of it
  const double most = 0.1 * kPi * std::pow(kResonanceHz / 30, 2);
  EXPECT_GT(NumberOf(fast, "most_hz_per_s"), 0.9 * most);
  EXPECT_LT(NumberOf(fast, "most_hz_per_s"), 9 * most);
}

TEST(AnalyzeSweep, UnevenTimesAndAShortBandAreRefused) {
  trial::Record record = Chirp(4, 0, 1, true);
  record.times_are_known = true;
  for (std::size_t k = 0; k < record.rows; ++k) {
    record.raw_times_s.push_back(static_cast<double>(k) / kRateHz);
  }
  EXPECT_THAT(RefusalsIn(Analyzed(record).findings), ElementsAre(FindingKind::kSweepUneven));
  record.times_are_known = false;
  EXPECT_FALSE(AnalyzeSweep(trial::RecordRows(record), {.lower_hz = 20, .upper_hz = 20}));
  EXPECT_FALSE(AnalyzeSweep(trial::RecordRows(record), {.resolution_hz = 0}));
  EXPECT_TRUE(AnalyzeSweep(trial::RecordRows(record), {.lower_hz = 20, .upper_hz = 20.1}));
}

// A drive that moves by more than a tenth of its lowest frequency is a sweep, in 8 blocks or more.
TEST(AnalyzeSweep, ATenthOfAFrequencyIsASweep) {
  const auto refusals = [](double change) {
    std::vector<double> values(16'000);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double t_s = static_cast<double>(k) / kRateHz;
      values[k] = 1e-5 * std::sin(2 * kPi * 200 * t_s * (1 + change * t_s / 16));
    }
    return RefusalsIn(Analyzed(RecordOf(values, kRateHz), {.lower_hz = 40}).findings);
  };
  // blocks of 50 ms of 8 s, of which the first and the last are left out: 0.98 of it
  EXPECT_THAT(refusals(0.1), ElementsAre(FindingKind::kNoSweep));
  EXPECT_THAT(refusals(0.104), ElementsAre());
}

// An echo of 1 ms beside the displacement is no resonance: what the curve leaves grows with it, and
// is a doubt beyond a tenth.
TEST(AnalyzeSweep, ATenthOfTheResponseThatNoCurveHoldsIsADoubt) {
  const trial::Record plain = Chirp(4, 0, 1, true);
  int just_below = 0;
  int just_above = 0;
  for (int percent = 0; percent < 100; percent += 2) {
    trial::Record record = plain;
    std::vector<double>& values = record.channels[0].values;
    for (std::size_t k = values.size() - 1; k >= 2; --k)
      values[k] += percent * 0.01 * values[k - 2];
    const SweepAnswer answer = Analyzed(record);
    if (!answer.resonance) break;
    const double share = answer.resonance->fit.residual_share;
    ASSERT_EQ(answer.findings.Has(FindingKind::kSeveralResonances), share > 0.1) << share;
    just_below += share > 0.09 && share <= 0.1 ? 1 : 0;
    just_above += share > 0.1 && share < 0.11 ? 1 : 0;
    if (share > 0.1) {
      EXPECT_EQ(NumberOf(answer.findings, FindingKind::kSeveralResonances, "left"), share);
    }
    if (share > 0.12) break;
  }
  EXPECT_GT(just_below, 0);
  EXPECT_GT(just_above, 0);
}

// Every half hertz from 70 Hz to 440 Hz is a point, or is left out for its noise.
TEST(AnalyzeSweep, CountsTheFrequenciesThatAreLeftOut) {
  const SweepAnswer answer = Analyzed(Chirp(8, 3e-5, 3, true), {.lower_hz = 70, .upper_hz = 440});
  const Finding note = FirstOf(answer.findings, FindingKind::kFrequenciesExcluded);
  EXPECT_EQ(note.severity, Severity::kNote);
  EXPECT_EQ(NumberOf(note, "frequencies"), 741);
  EXPECT_EQ(NumberOf(note, "excluded") + static_cast<double>(answer.points.size()), 741);
  EXPECT_FALSE(answer.points.empty());
}

}  // namespace
}  // namespace haptometer::dsp
