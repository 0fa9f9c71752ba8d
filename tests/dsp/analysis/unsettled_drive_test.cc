// Drives that lie where the filter has not settled, or that are short: the numbers are those of the
// drive, or there are none; never those of the pause beside it. And records in which nothing but a
// filter's edges moves: they are answered as if nobody had looked for such a drive.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tests/dsp/analysis/answered.h"
#include "tests/dsp/records.h"
#include "tests/dsp/repetitions.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 5e3;
constexpr double kRmsM = 10e-6;

enum class Place { kStart, kMiddle, kEnd };

// a record of a tone of 10 um RMS that is on for a part of it
struct Case {
  Place place = Place::kMiddle;
  double drive_s = 0;  // 0: never on
  double record_s = 0;
  bool has_channel = false;
  double tremor_m = 0;  // amplitude
  double noise_m = 0;   // RMS, white up to half the rate
};

// when the drive of `c` is on
TimeWindow OnOf(const Case& c) {
  const double rest_s = c.record_s - c.drive_s;
  const double begin_s = c.place == Place::kStart ? 0
                         : c.place == Place::kEnd ? rest_s
                                                  : rest_s / 2;
  return {begin_s, begin_s + c.drive_s};
}

// numbers in [0, 1) that a seed decides
double Uniform(std::uint64_t seed, std::uint64_t which) {
  std::uint64_t z = seed * 0x9e3779b97f4a7c15ULL + which * 0xd1b54a32d192ed03ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

std::vector<double> Sine01(double frequency_hz, double phase, std::size_t rows) {
  return Samples(kRateHz, rows, 0, {{1, frequency_hz, phase}});
}

trial::Record CaseRecord(const Case& c, std::uint64_t seed) {
  const auto rows = static_cast<std::size_t>(std::lround(c.record_s * kRateHz));
  const auto random = [&](std::uint64_t which) { return Uniform(seed, which); };
  // fewer than four periods are a bump, one more may be lost at its ends
  const double tone_hz = std::max(60 + 240 * random(1), c.drive_s > 0 ? 5 / c.drive_s : 0);
  std::vector<double> voltage = Sine01(tone_hz, 6.28 * random(2), rows);
  const TimeWindow on = OnOf(c);
  std::vector<double> values =
      Samples(kRateHz, rows, 0.03, {{c.tremor_m, 4 + 8 * random(3), 6.28 * random(4)}});
  Noise noise(seed);
  for (std::size_t k = 0; k < rows; ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    if (t_s < on.begin_s || t_s >= on.end_s) voltage[k] = 0;
    values[k] += kRmsM * std::numbers::sqrt2 * voltage[k] + c.noise_m * noise() +
                 c.tremor_m * (random(5) - 0.5) * t_s / c.record_s;
  }
  trial::Record record = RecordOf(std::move(values), kRateHz);
  if (!c.has_channel) return record;
  trial::Channel channel = record.channels[0];
  channel.role = trial::ChannelRole::kVoltage;
  channel.unit = "V";
  channel.values = std::move(voltage);
  record.channels.push_back(std::move(channel));
  return record;
}

// a drive that is on for 1.5 s, and after a pause for 4 s
TEST(SteadyWindow, IsTheLongestWhereverItLies) {
  constexpr std::size_t kRows = 70'000;  // 14 s
  std::vector<double> values = Samples(kRateHz, kRows, 0, {{14e-6, 225}});
  Noise noise(3);
  for (std::size_t k = 0; k < kRows; ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    const bool is_on = (t_s >= 5 && t_s < 6.5) || (t_s >= 8 && t_s < 12);
    values[k] = 0.03 + (is_on ? values[k] : 0) + 5e-8 * noise();
  }
  const BandAnalysis analysis = Answer(RecordOf(std::move(values), kRateHz));
  ASSERT_TRUE(analysis.answered);
  const TimeWindow window = analysis.numbers->part.window;
  EXPECT_GE(window.begin_s, 8);
  EXPECT_LE(window.end_s, 12);
  EXPECT_GT(window.end_s - window.begin_s, 3);
}

struct Tally {
  int answered = 0;  // with the drive's RMS
  int refused = 0;
  int wrong = 0;    // with another
  int covered = 0;  // the interval holds it
  double worst = 0;
};

void Count(const Case& c, std::uint64_t seed, Tally& tally) {
  const BandAnalysis analysis = Answer(CaseRecord(c, seed));
  if (!analysis.answered) {
    ++tally.refused;
    return;
  }
  const double off = std::abs(analysis.numbers->rms.rms_m / kRmsM - 1);
  tally.worst = std::max(tally.worst, off);
  const RmsEstimate& rms = analysis.numbers->rms;
  if (rms.lower_m <= kRmsM && kRmsM <= rms.upper_m) ++tally.covered;
  ++(off < 0.1 ? tally.answered : tally.wrong);
  if (off >= 0.1) {
    std::printf("seed %d, channel %d, tremor %g m, noise %g m: %.3g m, kind %d\n",
                static_cast<int>(seed), static_cast<int>(c.has_channel), c.tremor_m, c.noise_m,
                analysis.numbers->rms.rms_m, static_cast<int>(analysis.numbers->part.why.kind));
  }
}

const char* Name(Place place) {
  return place == Place::kStart ? "start" : place == Place::kMiddle ? "middle" : "end";
}

// the transient of an order of 6 always lasts less than half a second at either end (0.484 s)
double SettledDriveSeconds(const Case& c) {
  const TimeWindow on = OnOf(c);
  return std::min(on.end_s, c.record_s - 0.5) - std::max(on.begin_s, 0.5);
}

constexpr std::array kDrives_s{0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 1.0, 3.0};
constexpr std::array kRecords_s{0.3, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0};

class UnsettledDrive : public ::testing::TestWithParam<Place> {};

// one of the eight kinds of channel, tremor and noise
Case KindOf(int kind, Place place, double drive_s, double record_s) {
  return {place,
          drive_s,
          record_s,
          (kind & 1) != 0,
          (kind & 2) != 0 ? 5e-4 : 0,
          (kind & 4) != 0 ? 2e-6 : 5e-8};
}

// each of the eight kinds in turn; all of them in the long run
TEST_P(UnsettledDrive, IsAnsweredWithItsOwnNumbersOrNotAtAll) {
  const int repetitions = Repetitions(0);
  int turn = 0;
  for (const double record_s : kRecords_s) {
    for (const double drive_s : kDrives_s) {
      if (drive_s > record_s - 0.1) continue;
      const bool must = SettledDriveSeconds(KindOf(0, GetParam(), drive_s, record_s)) >= 0.4;
      Tally tally;
      for (int k = 0; k < std::max(1, 8 * repetitions); ++k) {
        const int kind = repetitions == 0 ? 3 * ++turn % 8 : k % 8;
        const auto seed = static_cast<std::uint64_t>(1000 * (k / 8) + kind + 1);
        Count(KindOf(kind, GetParam(), drive_s, record_s), seed, tally);
      }
      std::printf(
          "%-6s %5.2f s of %.1f s: answered %3d, refused %3d, wrong %3d, worst %.2g, in their "
          "intervals %d%s\n",
          Name(GetParam()), drive_s, record_s, tally.answered, tally.refused, tally.wrong,
          tally.worst, tally.covered, must ? " (must)" : "");
      EXPECT_EQ(tally.wrong, 0) << drive_s << " s of " << record_s;
      if (must) {
        EXPECT_EQ(tally.refused, 0) << drive_s << " s of " << record_s;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(At, UnsettledDrive,
                         ::testing::Values(Place::kStart, Place::kMiddle, Place::kEnd),
                         [](const auto& place) { return std::string(Name(place.param)); });

// whether a vibration is reported where there is no tone, or only a part of one that never pauses
bool SeesDrive(const BandAnalysis& analysis, bool has_tone) {
  if (!has_tone) return analysis.answered;
  return std::ranges::any_of(
      analysis.states, [](const StateInterval& state) { return state.state == DriveState::kOff; });
}

using Motion = double (*)(double t_s, double record_s, std::uint64_t seed);

// what else a record holds than a drive that is on for a part of it
struct Undriven {
  const char* name;
  double tremor_m = 0;
  double noise_m = 0;
  Motion motion = nullptr;
  std::size_t averages = 1;  // readings that one is the mean of
  bool has_tone = false;     // that never pauses
  // How many may be taken for a drive, or a tone for one that pauses: twice in 1000. More where
  // something moves in the band indeed: only its shape shows that a bump is no tone.
  double most = 0.002;
};

double StepAt(double t_s, double record_s, std::uint64_t seed) {
  return t_s < Uniform(seed, 9) * record_s ? 0 : 5e-5;
}

// 10 ms to go from one level to the other
double SoftStep(double t_s, double record_s, std::uint64_t seed) {
  const double x = std::clamp((t_s - Uniform(seed, 9) * record_s) / 0.01, 0.0, 1.0);
  return 1e-5 * (1 - std::cos(std::numbers::pi * x));
}

// half a sine of 15 ms
double Bump(double t_s, double record_s, std::uint64_t seed) {
  const double x = (t_s - Uniform(seed, 9) * record_s) / 0.015;
  return x < 0 || x > 1 ? 0 : 1e-5 * std::sin(std::numbers::pi * x);
}

double Turns(double t_s, double frequency_hz) {
  return std::sin(2 * std::numbers::pi * frequency_hz * t_s + 0.4);
}

double Tone(double t_s, double /*record_s*/, std::uint64_t seed) {
  return 1e-6 * Turns(t_s, 60 + 240 * Uniform(seed, 9));
}

// its amplitude changes by half, three times a second
double Modulated(double t_s, double record_s, std::uint64_t seed) {
  return Tone(t_s, record_s, seed) * (1 + 0.5 * Turns(t_s, 3));
}

// its frequency changes by 2 %, twice a second
double Wandering(double t_s, double /*record_s*/, std::uint64_t seed) {
  const double frequency_hz = 60 + 240 * Uniform(seed, 9);
  return 1e-6 * std::sin(2 * std::numbers::pi * frequency_hz * t_s +
                         0.02 * frequency_hz / 2 * Turns(t_s, 2));
}

double TwoTones(double t_s, double record_s, std::uint64_t seed) {
  return Tone(t_s, record_s, seed) + 1e-6 * Turns(t_s, 1.37 * (60 + 240 * Uniform(seed, 9)));
}

class NoPartIsDriven : public ::testing::TestWithParam<Undriven> {};

trial::Record UndrivenRecord(const Undriven& undriven, double record_s, std::uint64_t seed) {
  const Case c{Place::kMiddle, 0, record_s, false, undriven.tremor_m, undriven.noise_m};
  trial::Record record = CaseRecord(c, seed);
  std::vector<double>& values = record.channels[0].values;
  if (undriven.motion != nullptr) {
    for (std::size_t k = 0; k < values.size(); ++k) {
      values[k] += undriven.motion(static_cast<double>(k) / kRateHz, record_s, seed);
    }
  }
  std::vector<double> means = values;
  for (std::size_t k = undriven.averages; k < values.size(); ++k) {
    means[k] = 0;
    for (std::size_t i = 0; i < undriven.averages; ++i) {
      means[k] += values[k - i] / static_cast<double>(undriven.averages);
    }
  }
  values = std::move(means);
  return record;
}

TEST_P(NoPartIsDriven, AndNoneIsSeen) {
  const int repetitions = Repetitions(tests::kIsSanitized ? 1 : 4);
  int seen = 0;
  int answered = 0;
  int all = 0;
  for (const double record_s : kRecords_s) {
    for (int k = 0; k < repetitions; ++k) {
      const BandAnalysis analysis =
          Answer(UndrivenRecord(GetParam(), record_s, static_cast<std::uint64_t>(7000 + k)));
      answered += analysis.answered ? 1 : 0;
      ++all;
      if (!SeesDrive(analysis, GetParam().has_tone)) continue;
      ++seen;
      std::printf("%s, %g s, seed %d: %s\n", GetParam().name, record_s, k,
                  analysis.numbers ? "numbers" : "none");
    }
  }
  std::printf("%s: %d of %d taken for a drive, %d answered\n", GetParam().name, seen, all,
              answered);
  EXPECT_LE(seen, GetParam().most * all);
}

// beside 0.5 mm of tremor, in records of 1 s and less, a block in which what the filter leaves of
// the tremor exceeds the tone counts as off; no number is of it
constexpr double kShortTremor = 0.15;

INSTANTIATE_TEST_SUITE_P(
    In, NoPartIsDriven,
    ::testing::Values(Undriven{"Noise", 0, 2e-6}, Undriven{"FaintNoise", 0, 1e-9},
                      Undriven{"AveragedNoise", 0, 2e-5, nullptr, 25},
                      Undriven{"Tremor", 8e-4, 5e-8}, Undriven{"TremorAndNoise", 5e-4, 2e-6},
                      Undriven{"TremorAlmostAlone", 8e-4, 1e-9}, Undriven{"Step", 0, 5e-8, StepAt},
                      Undriven{"StepAndTremor", 5e-4, 5e-7, StepAt},
                      Undriven{"AveragedStep", 0, 1e-7, StepAt, 25, false, 0.1},
                      Undriven{"SoftStep", 0, 5e-8, SoftStep},
                      Undriven{"Bump", 0, 5e-8, Bump, 1, false, 0.1},
                      Undriven{"Tone", 0, 5e-8, Tone, 1, true},
                      Undriven{"WeakTone", 5e-4, 2e-6, Tone, 1, true, kShortTremor},
                      Undriven{"ToneInNoise", 0, 1e-6, Tone, 1, true},
                      Undriven{"Modulated", 5e-4, 2e-7, Modulated, 1, true, kShortTremor},
                      Undriven{"Wandering", 5e-4, 2e-7, Wandering, 1, true, kShortTremor},
                      Undriven{"TwoTones", 5e-4, 2e-7, TwoTones, 1, true, kShortTremor}),
    [](const auto& undriven) { return std::string(undriven.param.name); });

// a tone that goes on, in as many values as a narrow band leaves of a tile
TEST(NarrowBand, IsAnsweredAtEveryRate) {
  for (const double rate_hz : {1e3, 2e3, 5e3, 1e5}) {
    Noise noise(3);
    std::vector<double> values =
        Samples(rate_hz, static_cast<std::size_t>(3 * rate_hz), 0, {{14.14e-6, 385, 0}});
    for (double& value : values) value += 1e-7 * noise();
    BandQuestion question;
    question.band.lower_hz = 380;
    question.band.upper_hz = 390;
    const BandAnalysis analysis = Answer(RecordOf(std::move(values), rate_hz), question);
    ASSERT_TRUE(analysis.answered) << rate_hz;
    EXPECT_REL(analysis.numbers->rms.rms_m, 10e-6, 1e-3, "a steady tone well within the band");
  }
}

// 1 mV here and there on a channel that is 0 else is no drive: the tone is on all the time
TEST(DriveChannel, ThatFlickersIsNone) {
  trial::Record record =
      CaseRecord({Place::kStart, /*drive_s=*/3, /*record_s=*/3, /*has_channel=*/true, 0, 5e-8}, 5);
  std::vector<double>& voltage = record.channels[1].values;
  for (std::size_t k = 0; k < voltage.size(); ++k) {
    voltage[k] = Uniform(k, 1) < 0.013 ? 1e-3 : 0;
  }
  const BandAnalysis analysis = Answer(record);
  ASSERT_TRUE(analysis.answered);
  EXPECT_REL(analysis.numbers->rms.rms_m, kRmsM, 1e-3, "a steady tone well within the band")
      << static_cast<int>(analysis.numbers->part.why.kind);
}

// The drive is on for 0.25 s of each 0.6 s: what is settled begins 12 ms before the end of a burst.
TEST(UnsettledDrive, EndOfADriveAtTheBeginningIsNoNoise) {
  constexpr double kFastHz = 10e3;
  std::vector<double> in = Samples(kFastHz, 40'000, 0, {{std::numbers::sqrt2 * kRmsM, 225}});
  Noise noise(1);
  for (std::size_t n = 0; n < in.size(); ++n) {
    in[n] = (n % 6000 < 2500 ? in[n] : 0) + 0.2e-6 * noise();
  }
  const BandAnalysis analysis = Answer(RecordOf(in, kFastHz));
  ASSERT_TRUE(analysis.numbers && analysis.numbers->floor);
  // of 0.2 um up to 5 kHz a tenth of the power lies in the band
  EXPECT_LT(std::sqrt(analysis.numbers->floor->power.mean_square), 0.1e-6) << "0.063e-6 of noise";
  EXPECT_REL(analysis.numbers->rms.rms_m, kRmsM, 2e-3, "noise over 0.1 s, the bursts' edges");
}

}  // namespace
}  // namespace haptometer::dsp
