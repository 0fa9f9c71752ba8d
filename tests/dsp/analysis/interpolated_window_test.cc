// What interpolated readings change of the RMS, against the same record without holes: the bound
// that is stated for it holds, and is no larger than the noise that is there anyway.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tests/dsp/analysis/answered.h"
#include "tests/dsp/records.h"
#include "tests/dsp/repetitions.h"
#include "tests/dsp/signals.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 2e3;

// half width of the bound, by its standard uncertainty
double BridgedBound(const RmsEstimate& rms) {
  for (const UncertaintyLine& line : rms.budget) {
    if (line.cause == RmsCause::kBridged) {
      return std::numbers::sqrt3 * line.standard_uncertainty_m;
    }
  }
  return 0;
}

// what is missing of 3 s, and the noise beside a tone of 20 um
struct Missing {
  std::size_t rows = 0;  // of a hole
  std::size_t holes = 0;
  double noise_m = 0;
  double most = 0;  // of half the interval without holes: what they may add
};

class InterpolatedWindow : public testing::TestWithParam<Missing> {};

TEST_P(InterpolatedWindow, IsBoundedAndHardlyWider) {
  const Missing& missing = GetParam();
  const int repetitions = Repetitions(tests::kIsSanitized ? 10 : 30);
  BandQuestion question;
  question.keep_filtered = false;
  int held = 0;
  double width = 0;
  double width_of_whole = 0;
  for (int seed = 1; seed <= repetitions; ++seed) {
    Noise noise(static_cast<std::uint64_t>(seed));
    std::vector<double> values =
        Samples(kRateHz, 6000, 0.03, {{20e-6, 97.3 + 3 * seed, 0.37 * seed}});
    for (double& value : values) value += missing.noise_m * noise();
    const BandAnalysis whole = Answer(RecordOf(values, kRateHz), question);
    for (std::size_t hole = 0; hole < missing.holes; ++hole) {
      const std::size_t first = 150 + hole * (5700 / missing.holes) + (hole * 7919) % 31;
      for (std::size_t k = first; k < first + missing.rows; ++k) {
        values[k] = std::numeric_limits<double>::quiet_NaN();
      }
    }
    const BandAnalysis left = Answer(RecordOf(values, kRateHz), question);
    ASSERT_TRUE(whole.numbers && left.numbers);
    ASSERT_EQ(left.record.bridged, missing.rows * missing.holes);
    const RmsEstimate& rms = left.numbers->rms;
    const double error = std::abs(rms.rms_m - whole.numbers->rms.rms_m);
    held += error <= BridgedBound(rms) ? 1 : 0;
    width += (rms.upper_m - rms.lower_m) / repetitions;
    width_of_whole += (whole.numbers->rms.upper_m - whole.numbers->rms.lower_m) / repetitions;
  }
  ExpectCoverage("what interpolation changes", held, repetitions, 100);
  EXPECT_LT(width, missing.most * width_of_whole);
}

// 0.5 % of the rows, holes of 5 rows, and of 20 ms, each in little and in strong noise. A linear
// sum of the errors made the intervals of these 6 to 18 times as wide.
INSTANTIATE_TEST_SUITE_P(Holes, InterpolatedWindow,
                         testing::Values(Missing{1, 30, 1e-6, 1.02}, Missing{1, 30, 10e-6, 1.05},
                                         Missing{5, 12, 1e-6, 1.05}, Missing{5, 12, 10e-6, 1.1},
                                         Missing{40, 6, 1e-6, 1.3}, Missing{40, 6, 10e-6, 1.6}));

}  // namespace
}  // namespace haptometer::dsp
