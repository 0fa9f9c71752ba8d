// Blocks of known tones, and the error rates of the states found in them.
#include "dsp/analysis/drive_states.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "dsp/readings/segments.h"
#include "tests/dsp/records.h"
#include "tests/dsp/repetitions.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 10e3;
constexpr double kBlockS = 0.05;
constexpr double kLowerHz = 20;

BlockCourse CourseOf(const std::vector<double>& values, double rate_hz = kRateHz) {
  const trial::Record record = RecordOf(values, rate_hz);
  const trial::RecordRows rows(record);
  const Segments segments = SplitAtHoles(rows, 0, {}).value();
  const Segment& segment = segments.parts.at(0);
  const BandSignal signal =
      BandSignal::Filter({rows, 0, segment}, Designed({}, rate_hz), 1).value();
  auto course = MeasureBlocks(signal, {}, kBlockS, {});
  EXPECT_TRUE(course);
  return course ? *std::move(course) : BlockCourse{};
}

// value(t) over `duration_s`
std::vector<double> SampledOver(double duration_s, const std::function<double(double)>& value,
                                double rate_hz = kRateHz) {
  std::vector<double> values(static_cast<std::size_t>(duration_s * rate_hz));
  for (std::size_t k = 0; k < values.size(); ++k) {
    values[k] = value(static_cast<double>(k) / rate_hz);
  }
  return values;
}

// blocks that no transient of the filter reaches: half a second from the ends
template <typename Visit>
void ForEachSettled(const BlockCourse& course, double duration_s, const Visit& visit) {
  int seen = 0;
  for (std::size_t k = 0; k < course.blocks.size(); ++k) {
    const TimeWindow time = course.Window(k, k + 1);
    if (time.begin_s < 0.5 || time.end_s > duration_s - 0.5) continue;
    visit(course.blocks[k], (time.begin_s + time.end_s) / 2);
    ++seen;
  }
  EXPECT_GT(seen, 10);
}

TEST(DriveBlocks, OfAToneAreItsAmplitudeFrequencyAndPhase) {
  for (const double tone_hz : {40.3, 100.0, 225.37, 411.0}) {
    const double passed = 1e-6 * std::norm(Response(Designed({}, kRateHz), tone_hz));
    const BlockCourse course = CourseOf(Samples(kRateHz, 30'000, 0.03, {{1e-6, tone_hz, 0.7}}));
    EXPECT_GE(course.block_s, std::max(kBlockS, 4 / tone_hz) * (1 - 1e-3));
    ForEachSettled(course, 3, [&](const DriveBlock& block, double middle_s) {
      EXPECT_REL(block.level_m(), passed, 1e-5, "transients of the filter");
      EXPECT_ABS(block.frequency_hz, tone_hz, 1e-3, "transients of the filter");
      EXPECT_LT(block.residual, 1e-9 * passed * passed / 2);
      // sin(2 pi f t + 0.7) in the middle of every third sample, a sample and a half before the
      // block's: a cosine with this phase
      const double phase =
          2 * std::numbers::pi * tone_hz * (middle_s - 1.5 / kRateHz) + 0.7 - std::numbers::pi / 2;
      const std::complex<double> expected = std::polar(passed, phase);
      EXPECT_LT(std::abs(block.amplitude_m - expected) / passed, 1e-3);
    });
  }
}

// What moves within a block leaves less than 1e-4 of the power: a frequency by 8 Hz/s, an
// amplitude by all of itself in 2 s.
TEST(DriveBlocks, AChirpAndARampLeaveNoResidual) {
  const auto chirp = SampledOver(3, [](double t_s) {
    return 1e-6 * std::sin(2 * std::numbers::pi * (200 * t_s + 4 * t_s * t_s));
  });
  ForEachSettled(CourseOf(chirp), 3, [](const DriveBlock& block, double middle_s) {
    EXPECT_LT(block.residual, 1e-4 * block.mean_square);
    EXPECT_ABS(block.frequency_hz, 200 + 8 * middle_s, 0.05, "curvature of the phase");
  });
  const auto ramp = SampledOver(3, [](double t_s) {
    return 0.5e-6 * (1 + t_s) * std::sin(2 * std::numbers::pi * 225 * t_s);
  });
  ForEachSettled(CourseOf(ramp), 3, [](const DriveBlock& block, double middle_s) {
    EXPECT_LT(block.residual, 1e-4 * block.mean_square);
    EXPECT_REL(block.level_m(), 0.5e-6 * (1 + middle_s), 1e-3, "a sample's time");
  });
}

// The mean square beside the tone is that of the noise.
TEST(DriveBlocks, TheResidualIsTheNoise) {
  const FilterDesign design = Designed({}, kRateHz);
  double share = 0;
  for (int k = 0; k < 4000; ++k) share += std::pow(Magnitude(design, (k + 0.5) * 1.25), 4) / 4000;
  Noise noise(1);
  const auto values = SampledOver(20, [&](double t_s) {
    return 1e-6 * std::sin(2 * std::numbers::pi * 225 * t_s) + 0.1e-6 * noise();
  });
  double sum = 0;
  int count = 0;
  ForEachSettled(CourseOf(values), 20, [&](const DriveBlock& block, double) {
    sum += block.residual;
    ++count;
  });
  EXPECT_REL(sum / count, 1e-14 * share, 0.05, "18000 independent values, the borders of blocks");
}

// ---- Courses made without a record: 50 samples a block at 1 kHz, all of the band.

constexpr std::size_t kBlockSize = 50;

// Least squares of (a + a' t) cos + (b + b' t) sin at 220 Hz, 11 periods a block, so that the same
// four orthonormal vectors (Gram and Schmidt) serve every block.
class BlockFit {
 public:
  BlockFit() {
    for (std::size_t k = 0; k < kBlockSize; ++k) {
      const double t = (static_cast<double>(k) - 24.5) / kBlockSize;
      const double phase = 2 * std::numbers::pi * 11 * t;
      basis_[0][k] = std::cos(phase);
      basis_[1][k] = std::sin(phase);
      basis_[2][k] = t * std::cos(phase);
      basis_[3][k] = t * std::sin(phase);
    }
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < i; ++j) Take(basis_[j], Dot(basis_[i], basis_[j]), &basis_[i]);
      const double norm = std::sqrt(Dot(basis_[i], basis_[i]));
      for (double& value : basis_[i]) value /= norm;
    }
  }

  // Of level cos(phase) + what is in `noise`.
  [[nodiscard]] DriveBlock Of(double level, std::array<double, kBlockSize> values) const {
    DriveBlock block;
    const double scale = std::sqrt(2.0 / kBlockSize);
    values = WithTone(level / scale, values);
    block.mean_square = Dot(values, values) / kBlockSize;
    std::array<double, 4> parts{};
    for (std::size_t i = 0; i < 4; ++i) {
      parts[i] = Dot(values, basis_[i]);
      Take(basis_[i], parts[i], &values);
    }
    block.amplitude_m = {parts[0] * scale, -parts[1] * scale};
    // d/dt of a - i b: the slopes' vectors are t cos and t sin, of norm about sqrt(50 / 24)
    const std::complex<double> slope(parts[2] / std::sqrt(kBlockSize / 24.0),
                                     -parts[3] / std::sqrt(kBlockSize / 24.0));
    block.frequency_hz =
        220 + (slope / block.amplitude_m).imag() / kBlockS / (2 * std::numbers::pi);
    block.residual = Dot(values, values) / (kBlockSize - 4);
    return block;
  }

 private:
  using Vector = std::array<double, kBlockSize>;
  static double Dot(const Vector& a, const Vector& b) {
    double sum = 0;
    for (std::size_t k = 0; k < kBlockSize; ++k) sum += a[k] * b[k];
    return sum;
  }
  static void Take(const Vector& a, double factor, Vector* from) {
    for (std::size_t k = 0; k < kBlockSize; ++k) (*from)[k] -= factor * a[k];
  }
  [[nodiscard]] Vector WithTone(double size, Vector values) const {
    Take(basis_[0], -size, &values);
    return values;
  }
  std::array<Vector, 4> basis_{};
};

BlockCourse NoBlocks() {
  BlockCourse course;
  course.block_s = kBlockS;
  course.bandwidth_hz = 500;
  return course;
}

// Blocks of a tone of amplitude level(k) in noise of standard deviation 0.1, made red by
// x[n] = red x[n-1] + e[n].
BlockCourse NoisyCourse(std::size_t blocks, double red, std::uint64_t seed,
                        const std::function<double(std::size_t)>& level) {
  static const BlockFit fit;
  Noise noise(seed);
  BlockCourse course = NoBlocks();
  double last = noise();
  for (std::size_t k = 0; k < blocks; ++k) {
    std::array<double, kBlockSize> values{};
    for (double& value : values) {
      last = red * last + std::sqrt(1 - red * red) * noise();
      value = 0.1 * last;
    }
    course.blocks.push_back(fit.Of(level(k), values));
  }
  return course;
}

double Always(std::size_t /*block*/) { return 1; }

// how many of `repetitions` courses of 3 s fall into more than one state
int CountSplit(double red, int repetitions, const std::function<double(std::size_t)>& level) {
  int split = 0;
  for (int seed = 1; seed <= repetitions; ++seed) {
    const auto course = NoisyCourse(60, red, static_cast<std::uint64_t>(seed), level);
    split += FindStates(course, kLowerHz).size() > 1 ? 1 : 0;
  }
  return split;
}

double Rate(const char* name, int count, int repetitions) {
  std::printf("[rate] %s: %d of %d\n", name, count, repetitions);
  return static_cast<double>(count) / repetitions;
}

// The rate aimed at is 1e-3. Of 4000 courses at most 10 are split with 99.7 % confidence
// if that is the rate. Measured: none.
TEST(DriveStates, AConstantDriveInWhiteNoiseIsSplitLessThanOnceInAThousand) {
  const int repetitions = Repetitions(tests::kIsSanitized ? 200 : 4000);
  const double rate =
      Rate("constant drive split, white noise", CountSplit(0, repetitions, Always), repetitions);
  EXPECT_LE(rate, 2.5e-3);
}

// x[n] = 0.9 x[n-1] + e[n] at 10 kHz has a density at 500 Hz a tenth of that at 20 Hz, as 0.52 has
// at 1 kHz. Measured: none of 4000.
TEST(DriveStates, AConstantDriveInRedNoiseIsSplitLessThanOnceInAThousand) {
  const int repetitions = Repetitions(tests::kIsSanitized ? 200 : 4000);
  const double rate = Rate("constant drive split, AR(1) 0.9 at 10 kHz",
                           CountSplit(0.52, repetitions, Always), repetitions);
  EXPECT_LE(rate, 2.5e-3);
}

// Far redder than any that passes the band: 0.9 at 1 kHz is 300 times denser at 20 Hz than at 500.
// Measured: none of 1000.
TEST(DriveStates, AConstantDriveInVeryRedNoise) {
  const int repetitions = Repetitions(tests::kIsSanitized ? 100 : 1000);
  const double rate = Rate("constant drive split, AR(1) 0.9 at 1 kHz",
                           CountSplit(0.9, repetitions, Always), repetitions);
  EXPECT_LE(rate, 0.003);
}

// A block's level scatters by 2 % (signal to noise of 17 dB): a line over the step explains three
// quarters of its square, and what is left, 60 ln 1.39 = 20, is below the penalty of 5 c ln 60
// = 31. Measured: 83 % of these steps are missed; the state's drift, 1.5 x 5 % by that line, says
// so. Of a scatter of 1 % what is left is 60 ln 2.56 = 56: all are found.
TEST(DriveStates, AStepOfFivePercentIsFoundOrADrift) {
  const int repetitions = Repetitions(tests::kIsSanitized ? 100 : 500);
  for (const double size : {1.0, 2.0}) {
    int split = 0;
    int said = 0;
    for (int seed = 1; seed <= repetitions; ++seed) {
      const auto course = NoisyCourse(60, 0, static_cast<std::uint64_t>(seed),
                                      [&](std::size_t k) { return size * (k < 30 ? 1.0 : 1.05); });
      const auto states = FindStates(course, kLowerHz);
      split += states.size() > 1 ? 1 : 0;
      said += states.size() > 1 || states[0].drift > 0.04 ? 1 : 0;
    }
    const double rate = Rate("step of 5 % split", split, repetitions);
    EXPECT_GE(rate, size == 1 ? 0.1 : 0.99) << size;
    EXPECT_GE(Rate("step of 5 % split or in the drift", said, repetitions), 0.99) << size;
  }
}

TEST(DriveStates, AStepOfTwentyPercentIsFoundWhereItIs) {
  const int repetitions = Repetitions(tests::kIsSanitized ? 100 : 1000);
  int found = 0;
  for (int seed = 1; seed <= repetitions; ++seed) {
    const auto course = NoisyCourse(60, 0, static_cast<std::uint64_t>(seed),
                                    [](std::size_t k) { return k < 30 ? 1.0 : 1.2; });
    const auto states = FindStates(course, kLowerHz);
    found += states.size() == 2 && states[0].end >= 29 && states[0].end <= 31 ? 1 : 0;
  }
  EXPECT_GE(Rate("step of 20 % found within a block", found, repetitions), 0.995);
}

// Through the filter and the ridge, which picks the strongest line of noise. x[n] = red x[n-1] +
// e[n] at 2.6 kHz. Measured: none of 60 records of 2 s each is on (below 5 % with 95 % confidence).
TEST(DriveStates, NoiseAloneIsOff) {
  const int repetitions = Repetitions(tests::kIsSanitized ? 10 : 60);
  for (const double red : {0.0, 0.67, 0.9}) {
    int on = 0;
    int steady = 0;
    for (int seed = 1; seed <= repetitions; ++seed) {
      Noise noise(static_cast<std::uint64_t>(seed));
      double last = 0;
      const BlockCourse course =
          CourseOf(SampledOver(
                       2, [&](double) { return 1e-6 * (last = red * last + noise()); }, 2.6e3),
                   2.6e3);
      const auto states = FindStates(course, kLowerHz);
      const auto is_on = [](const StateInterval& s) { return s.state == DriveState::kOn; };
      on += std::ranges::any_of(states, is_on) ? 1 : 0;
      steady += std::ranges::any_of(states,
                                    [&](const StateInterval& s) { return is_on(s) && s.is_steady; })
                    ? 1
                    : 0;
    }
    std::printf("[rate] AR(1) %g:\n", red);
    EXPECT_LE(Rate("noise alone called on", on, repetitions), 0.02);
    EXPECT_LE(Rate("noise alone called on and steady", steady, repetitions), 0.001);
  }
}

TEST(DriveStates, OfAGatedDriveLieWithinABlockOfTheTruth) {
  for (const double noise_m : {0.0, 10e-9, 100e-9}) {
    Noise noise(4);
    const BlockCourse course = CourseOf(SampledOver(6, [&](double t_s) {
      const bool on = (t_s > 1.013 && t_s < 2.521) || (t_s > 3.507 && t_s < 4.992);
      return (on ? 1e-6 * std::sin(2 * std::numbers::pi * 225 * t_s) : 0) + noise_m * noise();
    }));
    std::vector<TimeWindow> on;
    for (const StateInterval& state : FindStates(course, kLowerHz)) {
      if (state.state != DriveState::kOn) continue;
      if (state.time.duration_s() < 3 * course.block_s) continue;
      on.push_back(state.time);
      EXPECT_TRUE(state.is_steady) << state.time.begin_s;
      EXPECT_REL(state.level_m, 1e-6, 0.05, "a block at each end");
      EXPECT_REL(state.rms_m, 1e-6 / std::numbers::sqrt2, 0.05, "the same");
    }
    ASSERT_EQ(on.size(), 2U) << noise_m;
    const double block_s = course.block_s * 1.5;
    EXPECT_ABS(on[0].begin_s, 1.013, block_s,
               "the block that holds the change, and the filter's ringing");
    EXPECT_ABS(on[0].end_s, 2.521, block_s,
               "the block that holds the change, and the filter's ringing");
    EXPECT_ABS(on[1].begin_s, 3.507, block_s,
               "the block that holds the change, and the filter's ringing");
    EXPECT_ABS(on[1].end_s, 4.992, block_s,
               "the block that holds the change, and the filter's ringing");
  }
}

TEST(DriveStates, CoverEveryBlockOnce) {
  const auto course =
      NoisyCourse(500, 0, 3, [](std::size_t k) { return k % 100 < 50 ? 1.0 : 0.0; });
  std::size_t next = 0;
  for (const StateInterval& state : FindStates(course, kLowerHz)) {
    EXPECT_EQ(state.first, next);
    EXPECT_GT(state.end, state.first);
    EXPECT_EQ(state.time.begin_s, course.Window(state.first, state.end).begin_s);
    EXPECT_EQ(state.time.end_s, course.Window(state.first, state.end).end_s);
    next = state.end;
  }
  EXPECT_EQ(next, course.blocks.size());
  EXPECT_TRUE(FindStates(NoBlocks(), kLowerHz).empty());
}

void ExpectSameStates(const std::vector<StateInterval>& a, const std::vector<StateInterval>& b,
                      double scale, std::size_t shift) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].state, b[k].state);
    EXPECT_EQ(a[k].first + shift, b[k].first);
    EXPECT_EQ(a[k].end + shift, b[k].end);
    EXPECT_EQ(a[k].is_steady, b[k].is_steady);
    EXPECT_EQ(scale * a[k].level_m, b[k].level_m);
    EXPECT_EQ(scale * scale * a[k].residual, b[k].residual);
  }
}

// Pieces of 2048 blocks: a long course has the states of its switching, whether they meet a border
// or not, and those of the same course begun elsewhere.
TEST(DriveStates, BordersOfPiecesLeaveNoTrace) {
  const auto level = [](std::size_t k) { return (k / 310) % 2 == 0 ? 1.0 : 0.3; };
  const BlockCourse course = NoisyCourse(5000, 0, 6, level);
  const auto states = FindStates(course, kLowerHz);
  ASSERT_EQ(states.size(), 17U);  // ceil(5000 / 310)
  for (std::size_t k = 0; k < states.size(); ++k) EXPECT_EQ(states[k].first, 310 * k);
  BlockCourse later = course;
  later.blocks.erase(later.blocks.begin(), later.blocks.begin() + 930);
  auto rest = states;
  rest.erase(rest.begin(), rest.begin() + 3);
  ExpectSameStates(FindStates(later, kLowerHz), rest, 1, 930);
  EXPECT_EQ(FindStates(NoisyCourse(5000, 0, 7, Always), kLowerHz).size(), 1U);
}

// Eight blocks before a border the level rises above noise; that the two parts of the state differ
// by more than the 3 % of neighbours that are one must not keep the border.
TEST(DriveStates, AStateThatBeginsBesideABorderIsOne) {
  for (int seed = 1; seed <= 20; ++seed) {
    const auto states = FindStates(NoisyCourse(2600, 0, static_cast<std::uint64_t>(seed),
                                               [](std::size_t k) { return k < 2040 ? 0.0 : 0.2; }),
                                   kLowerHz);
    ASSERT_EQ(states.size(), 2U) << seed;
    EXPECT_EQ(states[1].first, 2040U);
    EXPECT_EQ(states[0].state, DriveState::kOff);
    EXPECT_EQ(states[1].state, DriveState::kOn);
  }
}

// A change of the noise alone: the level goes on, and so does the state.
TEST(DriveStates, NeighboursOfOneLevelAreOne) {
  BlockCourse course = NoisyCourse(30, 0, 1, [](std::size_t) { return 10.0; });
  for (DriveBlock block : NoisyCourse(30, 0, 2, [](std::size_t) { return 10.0 / 3; }).blocks) {
    block.amplitude_m *= 3;
    block.residual *= 9;
    block.mean_square *= 9;
    course.blocks.push_back(block);
  }
  const auto states = FindStates(course, kLowerHz);
  ASSERT_EQ(states.size(), 1U);
  EXPECT_EQ(states[0].end, 60U);
  EXPECT_REL(states[0].level_m, 10, 0.005, "a scatter of 0.2 and 0.6 % a block");
  EXPECT_REL(states[0].residual, (0.01 + 0.09) / 2, 0.1, "2 / sqrt(50 x 30)");
}

// A line of noise may be as high as a tone; its phase does not go on from block to block.
TEST(DriveStates, ASteadyLevelOfLoosePhaseIsNoSteadyState) {
  BlockCourse course = NoisyCourse(60, 0, 1, Always);
  const auto tone = FindStates(course, kLowerHz);
  ASSERT_EQ(tone.size(), 1U);
  EXPECT_TRUE(tone[0].is_steady);
  EXPECT_GT(tone[0].coherence, 0.9);
  EXPECT_REL(tone[0].level_m, 1, 0.01, "a scatter of 2 % a block");
  for (std::size_t k = 0; k < course.blocks.size(); ++k) {
    // angles that are spread evenly: multiples of the golden section's
    course.blocks[k].amplitude_m *= std::polar(1.0, 2.39996 * static_cast<double>(k));
  }
  const auto loose = FindStates(course, kLowerHz);
  ASSERT_EQ(loose.size(), 1U);
  EXPECT_EQ(loose[0].state, DriveState::kOn);
  EXPECT_FALSE(loose[0].is_steady);
}

TEST(DriveStates, NeitherScaleNorTimeChangesThem) {
  const BlockCourse course = NoisyCourse(300, 0.5, 8, [](std::size_t k) {
    return k < 70 ? 0.0 : k < 200 ? 1.0 : 1.3;
  });
  const auto states = FindStates(course, kLowerHz);
  EXPECT_EQ(states.size(), 3U);
  BlockCourse scaled = course;
  for (DriveBlock& block : scaled.blocks) {
    block.amplitude_m *= 0x1p-20;
    block.residual *= 0x1p-40;
    block.mean_square *= 0x1p-40;
  }
  ExpectSameStates(states, FindStates(scaled, kLowerHz), 0x1p-20, 0);
  BlockCourse later = course;
  later.start_s += 64;
  ExpectSameStates(states, FindStates(later, kLowerHz), 1, 0);
}

// A drive that comes up below the noise, then is on: what lies before it is not quiet.
TEST(DriveStates, WhatRisesBelowTheNoiseIsATransition) {
  BlockCourse course{.start_s = 0, .block_s = 0.05, .bandwidth_hz = 480, .blocks = {}};
  for (int k = 0; k < 24; ++k) {
    const double level = k < 12 ? 0.08 * k : 20;
    course.blocks.push_back({level, 225, 1 + level * level / 2, 1});
  }
  const auto states = FindStates(course, kLowerHz);
  ASSERT_EQ(states.size(), 2U);
  EXPECT_EQ(states[0].state, DriveState::kTransition);
  EXPECT_EQ(states[1].state, DriveState::kOn);
  // of a level that stays it is off
  for (std::size_t k = 0; k < 12; ++k) course.blocks[k].amplitude_m = 0.44;
  EXPECT_EQ(FindStates(course, kLowerHz)[0].state, DriveState::kOff);
}

// ---- Records of which only a frame in each block is looked at: 51 minutes at 2.6 kHz, in blocks
// of 0.76 s of which 0.1 s are.

constexpr double kLongRateHz = 2600;
constexpr std::size_t kLongRows = 8'000'000;
constexpr std::size_t kLongBlock = 1985;  // ceil(8e6 / floor(2^20 / 260))

// rows made up as they are read: amplitude(row) of a tone of 100 Hz, in noise of 20 nm
class MadeRows final : public trial::RowSource {
 public:
  explicit MadeRows(std::function<double(std::size_t)> amplitude)
      : amplitude_(std::move(amplitude)) {
    head_.rows = kLongRows;
    head_.times_are_known = false;
    head_.stretches = {{0, kLongRows, 0, kLongRateHz, 0}};
    head_.channels.emplace_back();
    head_.channels[0].role = trial::ChannelRole::kDisplacement;
    head_.channels[0].unit = "m";
    for (std::size_t k = 0; k < period_.size(); ++k) {
      period_[k] = std::sin(2 * std::numbers::pi * static_cast<double>(k) / 26);
    }
  }
  [[nodiscard]] const trial::Record& head() const override { return head_; }
  [[nodiscard]] Result<void> Read(std::size_t /*channel*/, std::size_t first,
                                  std::span<double> values,
                                  std::span<trial::SampleStatus> statuses) const override {
    ++reads;
    for (std::size_t k = 0; k < values.size(); ++k) {
      const std::size_t row = first + k;
      values[k] = amplitude_(row) * period_[row % period_.size()] + 20e-9 * Uniform(row);
      statuses[k] = trial::SampleStatus::kOk;
    }
    return {};
  }
  mutable std::size_t reads = 0;

 private:
  // -sqrt(3) to sqrt(3), by splitmix64
  static double Uniform(std::size_t row) {
    std::uint64_t z = (row + 1) * 0x9E3779B97F4A7C15U;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    z ^= z >> 31U;
    return std::numbers::sqrt3 * (2 * std::ldexp(static_cast<double>(z >> 11U), -53) - 1);
  }
  std::function<double(std::size_t)> amplitude_;
  std::array<double, 26> period_{};
  trial::Record head_;
};

BlockCourse LongCourse(const MadeRows& rows, const KeptFrames& frames, double block_s = kBlockS) {
  Segment segment;
  segment.size = kLongRows;
  segment.rate_hz = kLongRateHz;
  const BandSignal signal =
      BandSignal::Filter({rows, 0, segment}, Designed({}, kLongRateHz), 1, frames).value();
  const std::size_t reads = rows.reads;
  auto course = MeasureBlocks(signal, {}, block_s, {}).value();
  // what was kept is not filtered again
  EXPECT_TRUE(frames.frame == 0 || rows.reads == reads);
  return course;
}

KeptFrames LongFrames() { return FramesToKeep(kLongRows, kLongRateHz, {}); }

TEST(DriveStatesOfLongRecords, OfAConstantDriveAreOneSteadyState) {
  EXPECT_EQ(LongFrames().period, kLongBlock);
  EXPECT_EQ(LongFrames().frame, 260U);
  const MadeRows rows([](std::size_t) { return 1e-6; });
  const BlockCourse course = LongCourse(rows, LongFrames());
  EXPECT_ABS(course.block_s, kLongBlock / kLongRateHz, 1e-15, "round-off");
  EXPECT_LE(course.blocks.size(), kLongRows / kLongBlock);
  EXPECT_GE(course.blocks.size(), kLongRows / kLongBlock - 2);
  const auto states = FindStates(course, kLowerHz);
  ASSERT_EQ(states.size(), 1U);
  EXPECT_TRUE(states[0].is_steady);
  EXPECT_GT(states[0].coherence, 0.999);
  EXPECT_REL(states[0].level_m, 1e-6, 1e-3, "passband, noise of 0.3 % in 4000 blocks");
  EXPECT_ABS(states[0].from_hz, 100, 0.02, "noise");
  // frames that were not kept are filtered again: the same samples
  const BlockCourse again = LongCourse(rows, {});
  ASSERT_EQ(again.blocks.size(), course.blocks.size());
  for (std::size_t k = 0; k < course.blocks.size(); ++k) {
    ASSERT_EQ(again.blocks[k].amplitude_m, course.blocks[k].amplitude_m);
    ASSERT_EQ(again.blocks[k].residual, course.blocks[k].residual);
  }
}

// A pause of a third of a block, a quarter of a second before the frame, and its like with ten
// times the amplitude: the block is no part of the drive's state, and the window does not hold it.
TEST(DriveStatesOfLongRecords, WhatLiesBetweenFramesIsSeen) {
  constexpr std::size_t kBlock = 1500;
  for (const double amplitude_m : {0.0, 10e-6}) {
    const MadeRows rows([=](std::size_t row) {
      const bool is_there = row >= kBlock * kLongBlock && row < kBlock * kLongBlock + 650;
      return is_there ? amplitude_m : 1e-6;
    });
    const BlockCourse course = LongCourse(rows, LongFrames());
    const double block_s = kLongBlock / kLongRateHz;
    const double pause_s = kBlock * block_s;
    const auto k = static_cast<std::size_t>(std::lround((pause_s - course.start_s) / block_s));
    EXPECT_GT(course.blocks[k].residual, 0.1e-12);
    EXPECT_LT(course.blocks[k - 2].residual, 1e-15);
    EXPECT_LT(course.blocks[k + 2].residual, 1e-15);
    const auto states = FindStates(course, kLowerHz);
    EXPECT_TRUE(std::ranges::none_of(states, [&](const StateInterval& state) {
      return state.is_steady && state.first <= k && state.end > k;
    }));
    const auto analysis = AnalyzeBand(rows, {}, 1).value();
    ASSERT_TRUE(analysis.answered);
    EXPECT_GT(analysis.numbers->part.window.begin_s, pause_s);
    EXPECT_REL(analysis.numbers->rms.rms_m, 1e-6 / std::numbers::sqrt2, 1e-3, "the passband");
  }
}

TEST(DriveStatesOfLongRecords, ADriftIsNoChangeOfState) {
  const MadeRows rows([](std::size_t row) {
    return 1e-6 * (0.9 + 0.2 * static_cast<double>(row) / static_cast<double>(kLongRows));
  });
  const auto states = FindStates(LongCourse(rows, LongFrames()), kLowerHz);
  ASSERT_EQ(states.size(), 1U);
  EXPECT_TRUE(states[0].is_steady);
  EXPECT_ABS(states[0].drift, 0.2, 2e-3, "noise");
}

// 20 s on, 20 s off: what changes is measured block by block, each change within a block of its
// time
TEST(DriveStatesOfLongRecords, OfAGatedDriveLieWithinABlockOfTheTruth) {
  constexpr std::size_t kHalf = 52'000;
  const MadeRows rows([](std::size_t row) { return row / kHalf % 2 == 0 ? 1e-6 : 0; });
  const BlockCourse course = LongCourse(rows, {});
  EXPECT_ABS(course.block_s, kBlockS, 1e-12, "round-off");
  const auto states = FindStates(course, kLowerHz);
  for (const StateInterval& state : states) {
    // changes, and what a border of 2048 blocks cuts off at 2560.27 s
    if (state.blocks() < 10) continue;
    const double middle_s = 0.5 * (state.time.begin_s + state.time.end_s);
    const bool is_on = static_cast<std::size_t>(middle_s / 20) % 2 == 0;
    EXPECT_EQ(state.state, is_on ? DriveState::kOn : DriveState::kOff) << middle_s;
    EXPECT_EQ(state.is_steady, is_on) << middle_s;
  }
  for (int change_s = 20; change_s < 3077; change_s += 20) {
    const auto is_near = [&](const StateInterval& state) {
      return std::abs(state.time.begin_s - change_s) <= 1.5 * course.block_s;
    };
    EXPECT_TRUE(std::ranges::any_of(states, is_near)) << change_s;
  }
  const auto analysis = AnalyzeBand(rows, {}, 1).value();
  ASSERT_TRUE(analysis.answered);
  EXPECT_GT(analysis.numbers->part.window.duration_s(), 19);
  EXPECT_LT(analysis.numbers->part.window.duration_s(), 20);
  EXPECT_REL(analysis.numbers->rms.rms_m, 1e-6 / std::numbers::sqrt2, 1e-3, "the passband");
}

// Longer blocks, of which the frames are filtered again, for a tone that is lower.
TEST(DriveStatesOfLongRecords, ALowToneHasLongerFrames) {
  const MadeRows rows([](std::size_t) { return 1e-6; });
  const BlockCourse course = LongCourse(rows, {}, 0.2);
  EXPECT_ABS(course.fitted * course.block_s, 0.2, 1e-12, "round-off");
  const auto states = FindStates(course, kLowerHz);
  ASSERT_EQ(states.size(), 1U);
  EXPECT_TRUE(states[0].is_steady);
}

// ---- Blocks made by hand, of 220 Hz with phases that continue; a first state of `count` blocks
// level(k), and one of 0.

BlockCourse CourseBefore0(int count, const std::function<double(int)>& level) {
  BlockCourse course{.start_s = 0, .block_s = 0.05, .bandwidth_hz = 480, .blocks = {}};
  for (int k = 0; k < count + 20; ++k) {
    const double size = k < count ? level(k) : 0;
    // some noise, so that off is off
    course.blocks.push_back({size, 220 + 0.1 * k, 1e-6 + size * size / 2, 1e-6});
  }
  return course;
}

// Levels 10 + 0.02 k, and 0.1 more and less in turn: of m blocks the line rises by m times its
// slope, and what is left has the standard deviation sqrt(m 0.01 / (m - 2)), but for what the turns
// have of a slope.
TEST(DriveStates, AStatesDriftAndScatterAreThoseOfItsLine) {
  constexpr int kBlocks = 40;
  const auto states = FindStates(
      CourseBefore0(kBlocks, [](int k) { return 10 + 0.02 * k + (k % 2 == 0 ? 0.1 : -0.1); }),
      kLowerHz);
  ASSERT_EQ(states.size(), 2U);
  const StateInterval& on = states[0];
  ASSERT_EQ(on.blocks(), 40U);
  // sum of (k - 19.5)(-1)^k is -20, that of squares 40 (1600 - 1) / 12
  const double turns = -0.1 * 20 / 5330;
  const double left = (40 * 0.01 - turns * turns * 5330) / 38;
  EXPECT_REL(on.level_m, 10 + 0.02 * 19.5, 1e-13, "the mean");
  EXPECT_REL(on.drift, (0.02 + turns) * 40 / on.level_m, 1e-12, "from begin to end");
  EXPECT_REL(on.scatter, std::sqrt(left) / on.level_m, 1e-12, "about the line");
  EXPECT_REL(on.drift_uncertainty, on.scatter * std::sqrt(12.0 / 40), 1e-13, "of a slope");
  EXPECT_REL(on.residual, 1e-6, 1e-13, "a mean");
  EXPECT_REL(on.from_hz, 220 - 0.05, 1e-13, "half a block before the first block's middle");
  EXPECT_REL(on.to_hz, 220 + 3.95, 1e-13, "half a block after the last one's");
  double square = 0;
  for (int k = 0; k < kBlocks; ++k) {
    square += std::pow(10 + 0.02 * k + (k % 2 == 0 ? 0.1 : -0.1), 2) / 2 / kBlocks;
  }
  EXPECT_REL(on.rms_m, std::sqrt(square + 1e-6), 1e-13, "the mean square");
}

// Phases that lag from block to block by the same angle add up in its direction; those of the tone
// turn by its frequency.
TEST(DriveStates, CoherenceIsThePartThatContinues) {
  for (const double lag : {0.0, 0.5, 1.2}) {
    BlockCourse course{.start_s = 0, .block_s = 0.05, .bandwidth_hz = 480, .blocks = {}};
    double phase = 0;
    for (int k = 0; k < 40; ++k) {
      course.blocks.push_back({std::polar(10.0, phase), 223, 50, 1e-6});
      phase += 2 * std::numbers::pi * 223 * 0.05 + lag;
    }
    const auto states = FindStates(course, kLowerHz);
    ASSERT_EQ(states.size(), 1U);
    EXPECT_ABS(states[0].coherence, std::cos(lag), 1e-12, "phases of 3e3 rad");
    EXPECT_EQ(states[0].is_steady, std::cos(lag) > 0.5) << lag;
  }
}

// Of m blocks a state is on beyond sqrt(2 ln(B t)) sqrt(2 r / (2 B t)) (1.25 + 2 / sqrt(m)); t is
// 50 ms, B 480 Hz.
TEST(DriveStates, AStateIsOnBeyondWhatNoisePutsOnTheRidge) {
  for (const int blocks : {9, 100}) {
    for (const double share : {0.995, 1.005}) {
      BlockCourse course{.start_s = 0, .block_s = 0.05, .bandwidth_hz = 480, .blocks = {}};
      const double ridge = std::sqrt(2 * std::log(24.0)) * std::sqrt(2 * 3.0 / 48);
      const double limit = ridge * (1.25 + 2 / std::sqrt(static_cast<double>(blocks)));
      for (int k = 0; k < blocks; ++k) {
        course.blocks.push_back({share * limit, 220, 3 + share * share * limit * limit / 2, 3});
      }
      const auto states = FindStates(course, kLowerHz);
      ASSERT_EQ(states.size(), 1U);
      EXPECT_EQ(states[0].state, share > 1 ? DriveState::kOn : DriveState::kOff)
          << blocks << ' ' << share;
    }
  }
}

// Up to 40 Hz, twice the lower corner, eight blocks and a scatter below 15 % are needed, or three
// and one below 2 %; above, neither, and a scatter of half is too much.
TEST(DriveStates, AtTheFootADriveIsSteadierAndLonger) {
  const auto state_of = [](double frequency_hz, int blocks, double scatter) {
    BlockCourse course{.start_s = 0, .block_s = 0.1, .bandwidth_hz = 480, .blocks = {}};
    double phase = 0;
    // pairs of blocks above and below the mean: the scatter of m is sqrt(m / (m - 2)) of that
    const double part = scatter * std::sqrt(1 - 2.0 / blocks);
    for (int k = 0; k < blocks; ++k) {
      const double level = 10 * (1 + (k % 4 == 0 || k % 4 == 3 ? part : -part));
      course.blocks.push_back({std::polar(level, phase), frequency_hz, level * level / 2, 1e-3});
      phase += 2 * std::numbers::pi * frequency_hz * 0.1;
    }
    const auto states = FindStates(course, kLowerHz);
    EXPECT_EQ(states.size(), 1U) << frequency_hz << ' ' << blocks << ' ' << scatter;
    return states.at(0);
  };
  const auto is_on = [](const StateInterval& state) { return state.state == DriveState::kOn; };
  EXPECT_TRUE(is_on(state_of(39.9, 8, 0.01)));
  EXPECT_FALSE(is_on(state_of(39.9, 7, 0.025)));
  EXPECT_TRUE(state_of(39.9, 7, 0.025).is_short_at_foot);
  EXPECT_TRUE(state_of(39.9, 7, 0.015).is_steady);
  EXPECT_TRUE(is_on(state_of(39.9, 3, 0.001)));
  EXPECT_FALSE(is_on(state_of(39.9, 2, 0)));
  EXPECT_TRUE(is_on(state_of(40.1, 7, 0.01)));
  EXPECT_TRUE(is_on(state_of(39.9, 40, 0.148)));
  EXPECT_FALSE(is_on(state_of(39.9, 40, 0.152)));
  EXPECT_TRUE(state_of(40.1, 40, 0.152).is_steady);
  EXPECT_TRUE(state_of(100, 40, 0.495).is_steady);
  EXPECT_FALSE(state_of(100, 40, 0.505).is_steady);
  EXPECT_TRUE(is_on(state_of(100, 40, 0.505)));
}

// 14 minutes of noise, of which a frame of 0.1 s in each 0.2 s is fitted: what the whole blocks
// have beside it is within what noise gives, and adds nothing to the residual of its first half.
// That of the second half is as large.
TEST(DriveStatesOfLongRecords, NoiseBetweenFramesAddsNothing) {
  std::vector<double> values((std::size_t{1} << 21U) + 2600);
  Noise noise(3);
  for (double& value : values) value = 1e-8 * noise();
  const BlockCourse course = CourseOf(values, kLongRateHz);
  ASSERT_LT(course.fitted, 0.5);
  ASSERT_EQ(course.following.size(), course.blocks.size());
  double first = 0;
  double second = 0;
  for (std::size_t k = 0; k < course.blocks.size(); ++k) {
    first += course.blocks[k].residual;
    second += course.following[k].residual;
  }
  EXPECT_REL(first, second, 0.013,
             "of 4000 blocks of 92 degrees: 0.33 %, four times; a tenth of scatter would add 5 %");
}

// ---- Limits of what is the same, and sizes of long records.

// 40 blocks of level 10, then 40 of another one whose noise is a hundred times as strong, so that
// there is a border; up to 2 % of the larger level they are one state.
TEST(DriveStates, LevelsWithinTwoPercentAreOne) {
  for (const double level : {10 / 0.9801, 10 / 0.9799, 9.801, 9.799}) {
    BlockCourse course{.start_s = 0, .block_s = 0.05, .bandwidth_hz = 480, .blocks = {}};
    for (int k = 0; k < 80; ++k) {
      const double size = k < 40 ? 10 : level;
      course.blocks.push_back({size, 220, size * size / 2, k < 40 ? 0.01 : 1});
    }
    const bool is_same = std::abs(level - 10) <= 0.02 * std::max(level, 10.0);
    EXPECT_EQ(FindStates(course, kLowerHz).size(), is_same ? 1U : 2U) << level;
  }
}

// Below the noise: off, but for a level that changes by more than half of itself and 3.29 of its
// uncertainty over the state.
TEST(DriveStates, ADriveThatComesBelowTheNoiseIsNoPause) {
  for (const double change : {0.495, 0.505}) {
    BlockCourse course{.start_s = 0, .block_s = 0.05, .bandwidth_hz = 480, .blocks = {}};
    for (int k = 0; k < 20; ++k) {
      // from begin to end of 20 blocks
      const double level = 0.4 * (1 + change * (k - 9.5) / 20);
      course.blocks.push_back({level, 220, 1 + level * level / 2, 1});
    }
    const auto states = FindStates(course, kLowerHz);
    ASSERT_EQ(states.size(), 1U);
    EXPECT_REL(states[0].drift, change, 1e-12, "a line");
    EXPECT_EQ(states[0].state, change > 0.5 ? DriveState::kTransition : DriveState::kOff);
  }
}

// 5.2 samples a period of 500 Hz and more; 2^21 of them are kept.
TEST(FramesToKeep, AreAllOrTwoBlocksInEachPeriod) {
  EXPECT_EQ(FramesToKeep(1000, 5199, {}).stride, 1U);
  EXPECT_EQ(FramesToKeep(1000, 5201, {}).stride, 2U);
  EXPECT_EQ(FramesToKeep(1000, 1500, {}).stride, 1U);
  constexpr std::size_t kMost = std::size_t{1} << 21U;
  for (const std::size_t stride : {1U, 3U}) {
    const double rate_hz = kLongRateHz * static_cast<double>(stride);
    const KeptFrames all = FramesToKeep(stride * kMost, rate_hz, {});
    EXPECT_EQ(all.stride, stride);
    EXPECT_EQ(all.period, kMost);
    EXPECT_EQ(all.frame, kMost);
    EXPECT_EQ(all.offset, 0U);
    const KeptFrames some = FramesToKeep(stride * kMost + 1, rate_hz, {});
    EXPECT_EQ(some.stride, stride);
    EXPECT_EQ(some.frame, 260U) << "two blocks of 50 ms";
    // 4032 frames of 260 are 2^20, and one every 521 thinned samples is 2^21
    EXPECT_EQ(some.period, 521U);
    EXPECT_EQ(some.offset, 130U) << "in the middle";
  }
  // a lower corner of 5 Hz has blocks of 0.2 s
  EXPECT_EQ(FramesToKeep(2 * kMost, kLongRateHz, {.lower_hz = 5}).frame, 1040U);
}

}  // namespace
}  // namespace haptometer::dsp
