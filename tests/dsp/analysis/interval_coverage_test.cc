// How often the stated 95 % intervals of tone and RMS hold the truth, through AnalyzeBand.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tests/dsp/records.h"
#include "tests/dsp/repetitions.h"
#include "tests/dsp/signals.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 2e3;
constexpr double kToneHz = 150.37;
constexpr double kNoiseM = 1e-6;

bool Holds(double lower, double value, double upper) { return lower <= value && value <= upper; }

TEST(IntervalCoverage, OfAToneInNoise) {
  const FilterDesign design = Designed({}, kRateHz);
  const int repetitions = Repetitions(tests::kIsSanitized ? 15 : 40);
  for (const double amplitude_m : {0.5e-6, 4e-6}) {
    const double passed = amplitude_m * std::norm(Response(design, kToneHz));
    const double rms_m = passed / std::numbers::sqrt2;
    int answered = 0;
    int amplitudes = 0;
    int frequencies = 0;
    int sizes = 0;
    for (int seed = 1; seed <= repetitions; ++seed) {
      Noise noise(static_cast<std::uint64_t>(seed));
      std::vector<double> values =
          Samples(kRateHz, 3000, 0.03, {{amplitude_m, kToneHz, 0.37 * seed}});
      for (double& value : values) value += kNoiseM * noise();
      BandQuestion question;
      question.keep_filtered = false;
      const auto analysis = AnalyzeBand(RecordOf(values, kRateHz), question);
      if (!analysis || !analysis->answered || !analysis->numbers->tone) continue;
      ++answered;
      const ToneNumbers& tone = *analysis->numbers->tone;
      const RmsEstimate& rms = analysis->numbers->rms;
      amplitudes += Holds(tone.amplitude_lower_m, amplitude_m, tone.amplitude_upper_m) ? 1 : 0;
      frequencies += Holds(tone.frequency_lower_hz, kToneHz, tone.frequency_upper_hz) ? 1 : 0;
      sizes += Holds(rms.lower_m, rms_m, rms.upper_m) ? 1 : 0;
    }
    // of the weak ones, 0.3 of the noise in the band, 2 of 1000 are refused
    EXPECT_GE(answered, 0.95 * repetitions);
    ExpectCoverage("amplitude", amplitudes, answered);
    ExpectCoverage("frequency", frequencies, answered);
    ExpectCoverage("band RMS", sizes, answered);
  }
}

}  // namespace
}  // namespace haptometer::dsp
