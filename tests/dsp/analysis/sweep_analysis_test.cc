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

}  // namespace
}  // namespace haptometer::dsp
