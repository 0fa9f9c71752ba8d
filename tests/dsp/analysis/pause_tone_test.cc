// Pauses with a tone of their own (an amplifier at rest, a fan, hum beside the drive), bursts at
// the band's foot, and amplitudes that go up and down: the numbers are the drive's.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tests/dsp/analysis/answered.h"
#include "tests/dsp/findings.h"
#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 5e3;
constexpr double kAmplitudeM = 20e-6;
constexpr double kRmsM = kAmplitudeM / std::numbers::sqrt2;

// what both passes of the filter leave
double PassedRms(double frequency_hz) {
  return kRmsM * std::norm(Response(Designed({}, kRateHz), frequency_hz));
}

double Sinus(double frequency_hz, double t_s, double phase_rad = 0) {
  return std::sin(2 * std::numbers::pi * frequency_hz * t_s + phase_rad);
}

// value(t) of `duration_s` in units of the drive's amplitude, with noise of 0.1 um
BandAnalysis Analysed(double duration_s, const std::function<double(double)>& value,
                      std::uint64_t seed = 1, double noise_m = 1e-7) {
  std::vector<double> values(static_cast<std::size_t>(duration_s * kRateHz));
  Noise noise(seed);
  for (std::size_t k = 0; k < values.size(); ++k) {
    values[k] = kAmplitudeM * value(static_cast<double>(k) / kRateHz) + noise_m * noise();
  }
  return Answer(RecordOf(std::move(values), kRateHz));
}

bool Holds(const BandAnalysis& analysis, double rms_m) {
  return analysis.answered && analysis.numbers->rms.lower_m <= rms_m &&
         rms_m <= analysis.numbers->rms.upper_m;
}

void ExpectDrive(const BandAnalysis& analysis, double begin_s, double end_s,
                 const std::string& what) {
  ASSERT_TRUE(analysis.answered) << what;
  const BandNumbers& numbers = *analysis.numbers;
  EXPECT_TRUE(Holds(analysis, kRmsM)) << what << ": " << numbers.rms.rms_m;
  EXPECT_GE(numbers.part.window.begin_s, begin_s) << what;
  EXPECT_LE(numbers.part.window.end_s, end_s) << what;
}

// The pause is longer than the drive, and a tone that never stops makes it steady: of the drive's
// frequency as an amplifier at rest leaves it, or another.
TEST(ToneOfAPause, IsNoDriveWhereItIsWeak) {
  for (const double share : {0.002, 0.02, 0.1, 0.25, 0.45}) {
    for (const double tone_hz : {200.0, 87.0}) {
      const auto value = [&](double t_s) {
        const bool is_on = t_s >= 5 && t_s < 7;
        const double drive = is_on ? Sinus(200, t_s) : 0;
        // an amplifier at rest drives no more while it is on
        return drive + (is_on && tone_hz == 200 ? 0 : share * Sinus(tone_hz, t_s, 1));
      };
      ExpectDrive(Analysed(8, value), 5, 7, std::to_string(share) + " " + std::to_string(tone_hz));
    }
  }
}

// A level of half of the other is a drive too: the longer one is answered.
TEST(ToneOfAPause, IsADriveFromHalfOfTheOtherOn) {
  const auto value = [](double t_s) { return (t_s < 5 ? 0.55 : 1) * Sinus(200, t_s); };
  const BandAnalysis analysis = Analysed(8, value);
  ASSERT_TRUE(analysis.answered);
  EXPECT_REL(analysis.numbers->rms.rms_m, 0.55 * kRmsM, 1e-3, "noise");
}

// A drive that is never steady: the tone of the pause is not answered in its place, but for a short
// drive with a doubt.
TEST(ToneOfAPause, IsNotAnsweredForAnUnsteadyDrive) {
  Noise noise(5);
  const std::vector<std::function<double(double)>> drives = {
      [](double t_s) { return t_s * Sinus(180, t_s); },
      [](double t_s) { return (0.3 + 0.7 * t_s) * Sinus(180, t_s); },
      [](double t_s) { return std::fmod(t_s, 0.05) < 0.03 ? Sinus(180, t_s) : 0; },
      [](double t_s) { return std::fmod(t_s, 0.1) < 0.04 ? Sinus(180, t_s) : 0; },
      [&](double) { return 2 * noise(); },
  };
  for (std::size_t k = 0; k < drives.size(); ++k) {
    for (const double share : {0.02, 0.1, 0.3}) {
      for (const double drive_s : {5.0, 1.5}) {
        const auto value = [&](double t_s) {
          const bool is_on = t_s >= 6 && t_s < 6 + drive_s;
          return share * Sinus(87, t_s) + (is_on ? drives[k]((t_s - 6) / drive_s) : 0);
        };
        const BandAnalysis analysis = Analysed(12, value);
        if (!analysis.answered) continue;
        EXPECT_TRUE(analysis.numbers->rms.rms_m > 0.5 * kRmsM ||
                    analysis.findings.Has(FindingKind::kOtherVibration))
            << k << " " << share << " " << drive_s << ": " << analysis.numbers->rms.rms_m;
      }
    }
  }
}

// A short strong drive is answered for a long weaker one, which is told.
TEST(ToneOfAPause, IsToldWhereItIsLongerThanTheDrive) {
  const auto value = [](double t_s) {
    return t_s >= 7 && t_s < 7.4 ? 3 * Sinus(250, t_s) : Sinus(120, t_s);
  };
  const BandAnalysis analysis = Analysed(9, value);
  ASSERT_TRUE(analysis.answered);
  EXPECT_REL(analysis.numbers->rms.rms_m, 3 * kRmsM, 0.01, "edges of a short window");
  const Finding other = FirstOf(analysis.findings, FindingKind::kOtherVibration);
  EXPECT_EQ(other.severity, Severity::kNote);
  EXPECT_ABS(NumberOf(other, "other_s"), 6.9, 0.3, "a block, and the filter's transients");
  EXPECT_REL(NumberOf(other, "rms_m"), kRmsM, 0.01, "noise");
}

// hum of a quarter of the drive, 3 Hz beside it, which the pause shows alone
TEST(ToneOfAPause, IsSubtractedWhereItIsHumBesideTheDrive) {
  for (const double drive_hz : {53.0, 103.0, 184.0}) {
    const double mains_hz = drive_hz == 184 ? 60 : 50;
    const double hum_hz = mains_hz * std::round(drive_hz / mains_hz);
    const auto value = [&](double t_s) {
      const double drive = t_s >= 1 && t_s < 5 ? Sinus(drive_hz, t_s) : 0;
      return drive + 0.25 * Sinus(hum_hz, t_s, 0.7);
    };
    ExpectDrive(Analysed(6, value), 1, 5, std::to_string(drive_hz));
  }
}

// Bursts are answered without their pauses, or refused where a window has no room in them.
TEST(BurstsAtTheFoot, AreNotAveragedWithTheirPauses) {
  for (const double drive_hz : {26.0, 30.0, 34.0, 38.0, 42.0}) {
    for (const double on_s : {0.5, 1.0}) {
      const auto value = [&](double t_s) {
        return std::fmod(t_s, 2 * on_s) < on_s ? Sinus(drive_hz, t_s) : 0;
      };
      const BandAnalysis analysis = Analysed(10, value);
      EXPECT_TRUE(analysis.answered || on_s < 1 || drive_hz < 30) << drive_hz;
      if (!analysis.answered) continue;
      EXPECT_TRUE(Holds(analysis, PassedRms(drive_hz)))
          << drive_hz << " " << on_s << ": " << analysis.numbers->rms.rms_m;
    }
  }
}

// Shorter ones than blocks resolve are averaged with their pauses, with a doubt.
TEST(BurstsAtTheFoot, ShorterThanABlockAreDoubted) {
  int answered = 0;
  for (const double drive_hz : {22.0, 25.0, 30.0, 38.0}) {
    for (const double on_s : {0.15, 0.2, 0.3, 0.4}) {
      for (const double off_s : {0.2, 0.5}) {
        const auto value = [&](double t_s) {
          return std::fmod(t_s, on_s + off_s) < on_s ? Sinus(drive_hz, t_s) : 0;
        };
        const BandAnalysis analysis = Analysed(10, value);
        answered += analysis.answered ? 1 : 0;
        EXPECT_TRUE(!analysis.answered || Holds(analysis, PassedRms(drive_hz)) ||
                    analysis.findings.Has(FindingKind::kDriveUnsteady))
            << drive_hz << " " << on_s << " " << off_s << ": " << analysis.numbers->rms.rms_m;
      }
    }
  }
  EXPECT_GT(answered, 5);
}

// no doubt on what is steady, or beats
TEST(BurstsAtTheFoot, AreNoSteadyDriveAndNoBeat) {
  for (const double drive_hz : {22.0, 30.0, 38.0}) {
    for (const double second : {0.0, 0.5}) {
      const auto value = [&](double t_s) {
        return Sinus(drive_hz, t_s) + second * Sinus(drive_hz + 1.5, t_s);
      };
      EXPECT_FALSE(Analysed(10, value).findings.Has(FindingKind::kDriveUnsteady))
          << drive_hz << " " << second;
    }
  }
}

TEST(BurstsAtTheFoot, OfASecondOrARecordOfOneAreAnswered) {
  const auto whole = [](double t_s) { return Sinus(30, t_s); };
  const auto once = [](double t_s) { return t_s >= 0.8 && t_s < 1.8 ? Sinus(36, t_s) : 0; };
  EXPECT_TRUE(Holds(Analysed(1.6, whole), PassedRms(30)));
  EXPECT_TRUE(Holds(Analysed(2.8, once), PassedRms(36)));
}

// An amplitude that goes up and down within the drive: the window is most of it, not a crest.
TEST(ModulatedDrive, IsAnsweredAsAWhole) {
  int held = 0;
  for (const double modulation_hz : {0.6, 0.9, 1.3}) {
    for (const double phase_rad : {0.0, 2.0, 4.0}) {
      double squares = 0;
      int count = 0;
      const auto level = [&](double t_s) { return 1 + 0.3 * Sinus(modulation_hz, t_s, phase_rad); };
      for (int k = 0; k < 2500; ++k, ++count) squares += std::pow(level(2 + k * 1e-3), 2);
      const auto value = [&](double t_s) {
        return t_s >= 2 && t_s < 4.5 ? level(t_s) * Sinus(200, t_s) : 0;
      };
      const BandAnalysis analysis = Analysed(6, value, 1, 1e-8);
      ASSERT_TRUE(analysis.answered) << modulation_hz << " " << phase_rad;
      EXPECT_GT(analysis.numbers->part.window.duration_s(), 1.25)
          << modulation_hz << " " << phase_rad;
      EXPECT_REL(analysis.numbers->rms.rms_m, kRmsM * std::sqrt(squares / count), 0.06,
                 "up to half a second of a trough is cut at the ends");
      held += Holds(analysis, kRmsM * std::sqrt(squares / count)) ? 1 : 0;
    }
  }
  EXPECT_GE(held, 8) << "95 % of 9";
}

// Deeper than half only the crests are steady: what goes up and down beside them is a doubt. A
// drive of two levels with ramps between them, which comes down once, is none.
TEST(ModulatedDrive, ThatIsAnsweredAtACrestIsDoubted) {
  for (const double depth : {0.6, 0.8}) {
    const auto value = [&](double t_s) {
      const double level = t_s >= 1 && t_s < 11 ? 1 + depth * Sinus(0.5, t_s, 1) : 0;
      return level * Sinus(150, t_s);
    };
    const BandAnalysis analysis = Analysed(12, value);
    ASSERT_TRUE(analysis.answered) << depth;
    EXPECT_EQ(FirstOf(analysis.findings, FindingKind::kOtherVibration).severity, Severity::kDoubt)
        << depth;
  }
  const auto ramped = [](double t_s) {
    const double up = std::clamp(t_s - 1, 0.0, 2.0);
    const double down = std::clamp(t_s - 4.5, 0.0, 2.0);
    return (up - down) / 2 * Sinus(150, t_s);
  };
  const BandAnalysis analysis = Analysed(8, ramped);
  EXPECT_TRUE(Holds(analysis, kRmsM));
  EXPECT_FALSE(analysis.findings.Has(FindingKind::kOtherVibration));
}

// Blocks of four times the length average it; a pause that is shorter than the last one is no part
// of the window.
TEST(ModulatedDrive, OfLongBlocksEndsBeforeThePauseBehindIt) {
  for (const double phase_rad : {1.5, 2.5, 3.0}) {
    const auto value = [&](double t_s) {
      const double level = t_s >= 1 && t_s < 11 ? 1 + 0.8 * Sinus(1.4, t_s, phase_rad) : 0;
      return level * Sinus(150, t_s);
    };
    const BandAnalysis analysis = Analysed(12, value);
    ASSERT_TRUE(analysis.answered) << phase_rad;
    EXPECT_LT(analysis.numbers->part.window.end_s, 11.3) << phase_rad;
    EXPECT_REL(analysis.numbers->rms.rms_m, kRmsM * std::sqrt(1 + 0.8 * 0.8 / 2), 0.03,
               "a third of a second without drive, of ten, and part of an up and down");
  }
}

// A modulation has a sideband on either side of the drive; both beat with it.
TEST(ModulatedDrive, LiesInItsIntervalAtAnyPhase) {
  for (const double depth : {0.1, 0.3}) {
    int held = 0;
    for (int k = 0; k < 24; ++k) {
      const auto value = [&](double t_s) {
        return (1 + depth * Sinus(3, t_s, k * 2 * std::numbers::pi / 24)) * Sinus(185, t_s);
      };
      held += Holds(Analysed(4, value, static_cast<std::uint64_t>(k) + 1, 3e-8),
                    kRmsM * std::sqrt(1 + depth * depth / 2))
                  ? 1
                  : 0;
    }
    EXPECT_GE(held, 21) << depth << ": 95 % of 24 phases, less 1.6 standard deviations";
  }
}

}  // namespace
}  // namespace haptometer::dsp
