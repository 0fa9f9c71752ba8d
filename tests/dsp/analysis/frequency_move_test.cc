#include "dsp/analysis/frequency_move.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 4000;

// `amplitude_m(f)` at a frequency that goes linearly from one to another, in 0.05 um of noise
BandAnalysis Swept(double from_hz, double to_hz, double duration_s,
                   const std::function<double(double)>& amplitude_m) {
  std::vector<double> values(static_cast<std::size_t>(duration_s * kRateHz));
  Noise noise(7);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    const double rate = (to_hz - from_hz) / duration_s;
    const double turns = from_hz * t_s + rate * t_s * t_s / 2;
    values[k] = 0.03 + amplitude_m(from_hz + rate * t_s) * std::sin(2 * std::numbers::pi * turns) +
                0.05e-6 * noise();
  }
  return AnalyzeBand(RecordOf(values, kRateHz), {}).value();
}

// 1 um below its resonance at 180 Hz, Q 20
double Resonant(double frequency_hz) {
  const double u = frequency_hz / 180;
  return 1e-6 / std::hypot(1 - u * u, u / 20);
}

void ExpectSweep(const BandAnalysis& analysis, double from_hz, double to_hz) {
  ASSERT_TRUE(analysis.frequency_move);
  EXPECT_ABS(analysis.frequency_move->from_hz, from_hz, 80, "settling, and blocks of 0.1 s");
  EXPECT_ABS(analysis.frequency_move->to_hz, to_hz, 80, "settling, and blocks of 0.1 s");
  EXPECT_TRUE(analysis.findings.Has(FindingKind::kFrequencyMoves));
  EXPECT_FALSE(analysis.numbers->tone);
  EXPECT_FALSE(analysis.numbers->floor) << "off resonance is not off";
}

TEST(FrequencyMove, ASweepIsNoSteadyDriveThoughItsResonanceStandsOut) {
  ExpectSweep(Swept(20, 480, 10, Resonant), 20, 480);
  ExpectSweep(Swept(480, 20, 5, Resonant), 480, 20);
  ExpectSweep(Swept(50, 450, 4, [](double) { return 5e-6; }), 50, 450);
  ExpectSweep(Swept(150, 200, 3, Resonant), 150, 200);
}

TEST(FrequencyMove, ASweepThatLeavesTheBandIsOneToo) {
  ExpectSweep(Swept(300, 900, 10, [](double) { return 3e-6; }), 300, 500);
}

TEST(FrequencyMove, OneToneNoiseBurstsAndAHopDoNotMove) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Noise noise(seed);
    // a tone on for the middle third, in noise that an average makes stronger at low frequencies
    std::vector<double> gated = Samples(kRateHz, 12'000, 0.03, {{10e-6, 60}});
    std::vector<double> hop = Samples(kRateHz, 12'000, 0.03, {{10e-6, 100}});
    const std::vector<double> after = Samples(kRateHz, 12'000, 0.03, {{10e-6, 250}});
    double slow = 0;
    for (std::size_t k = 0; k < gated.size(); ++k) {
      slow += 0.1 * (noise() - slow);
      if (k < 4000 || k >= 8000) gated[k] = 0.03;
      if (k >= 6000) hop[k] = after[k];
      gated[k] += 5e-6 * slow;
      hop[k] += 5e-6 * slow;
    }
    EXPECT_FALSE(AnalyzeBand(RecordOf(gated, kRateHz), {})->frequency_move) << seed;
    EXPECT_FALSE(AnalyzeBand(RecordOf(hop, kRateHz), {})->frequency_move) << seed;
  }
}

}  // namespace
}  // namespace haptometer::dsp
