// Straight lines between the readings of a slower source, drawn by the definition of a line.
#include "dsp/readings/straight_lines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kSourceHz = 1200;
constexpr double kToneHz = 300.3;

std::vector<double> Rounded(std::vector<double> values, double step) {
  for (double& x : values) x = step > 0 ? std::round(x / step) * step : x;
  return values;
}

// as a file holds it
double Printed(double x, const char* format) {
  char text[32];
  std::snprintf(text, sizeof text, format, x);
  return std::strtod(text, nullptr);
}

// readings at 1200/s with noise, joined by lines `rows` times as dense, the first row `late` rows
// behind a reading
std::vector<double> Lines(double rows, double late, double noise_m, std::size_t count = 6000) {
  std::vector<double> fresh =
      Samples(kSourceHz, static_cast<std::size_t>(static_cast<double>(count) / rows) + 3, 3e-3,
              {{20e-6, kToneHz}, {1e-5, 7}});
  Noise noise(1);
  for (double& x : fresh) x += noise_m * noise();
  std::vector<double> values(count);
  for (std::size_t k = 0; k < count; ++k) {
    const double place = (static_cast<double>(k) + late) / rows;
    const auto at = static_cast<std::size_t>(place);
    values[k] = std::lerp(fresh[at], fresh[at + 1], place - static_cast<double>(at));
  }
  return values;
}

// with digits as an export prints them, and with 32-bit numbers
TEST(StraightLines, GiveTheSourcesRate) {
  for (const double rows : {2.0, 2.5, 2.83, 3.0, 5.0, 20.0 / 3, 10.0, 12.34, 50.0}) {
    for (const double noise_m : {0.0, 2e-8, 5e-7}) {
      for (const double step : {0.0, 1e-10, 1e-8}) {
        const std::vector<double> values = Rounded(Lines(rows, 0, noise_m), step);
        EXPECT_REL(RowsBetweenReadings(values, kToneHz / (kSourceHz * rows)), rows, 1e-4,
                   "a sine fit to 8192 rows at most")
            << rows << ' ' << noise_m << ' ' << step;
      }
    }
    std::vector<double> single = Lines(rows, 0, 2e-8);
    for (double& x : single) x = static_cast<double>(static_cast<float>(x - 3e-3));
    EXPECT_REL(RowsBetweenReadings(single, kToneHz / (kSourceHz * rows)), rows, 1e-4, "the same")
        << rows;
  }
  // numbers of four to seven digits about 0
  for (const char* format : {"%.4g", "%.5g", "%.6g", "%.7g"}) {
    std::vector<double> printed = Lines(10, 0, 2e-8);
    for (double& x : printed) x = Printed(x - 3e-3, format);
    EXPECT_REL(RowsBetweenReadings(printed, kToneHz / (10 * kSourceHz)), 10, 1e-4, "the same")
        << format;
  }
  // rows that never meet a reading, and some that are missing
  std::vector<double> values = Lines(5, 0.4, 2e-8);
  for (std::size_t k = 100; k < values.size(); k += 97) values[k] = std::nan("");
  EXPECT_REL(RowsBetweenReadings(values, kToneHz / (5 * kSourceHz)), 5, 1e-4, "the same");
}

TEST(StraightLines, AreNotInOtherWaves) {
  constexpr double kRateHz = 10e3;
  const double cycles = 175.3 / kRateHz;
  for (const double noise_m : {0.0, 1e-9, 2e-7}) {
    // as it is, of few steps, ended at a limit, and as triangles of equal and of unequal flanks
    std::vector<double> sine = Samples(kRateHz, 9000, 0, {{20e-6, 175.3}});
    std::vector<std::vector<double>> waves(4, sine);
    for (double& x : waves[0]) x = std::min(x, 12e-6);
    for (std::size_t k = 0; k < sine.size(); ++k) {
      const double turns = std::fmod(cycles * static_cast<double>(k), 1);
      waves[1][k] = 40e-6 * std::abs(turns - 0.5);
      waves[2][k] = 20e-6 * (turns < 0.2 ? turns / 0.2 : (1 - turns) / 0.8);
      waves[3][k] = sine[k / 5 * 5];  // held, which RepeatedShare finds
    }
    waves.push_back(sine);
    Noise noise(2);
    for (std::vector<double>& wave : waves) {
      for (double& x : wave) x += noise_m * noise();
      for (const double step : {0.0, 1e-9, 1e-7, 1e-6, 5e-6}) {
        EXPECT_EQ(RowsBetweenReadings(Rounded(wave, step), cycles), 0)
            << &wave - waves.data() << ' ' << noise_m << ' ' << step;
      }
      for (const char* format : {"%.2g", "%.3g", "%.4g", "%.6g"}) {
        std::vector<double> printed = wave;
        for (double& x : printed) x = Printed(x, format);
        EXPECT_EQ(RowsBetweenReadings(printed, cycles), 0)
            << &wave - waves.data() << ' ' << noise_m << ' ' << format;
      }
    }
  }
  // 6.5 samples a period, of which an alias of the corners' second harmonic is half as fast
  std::vector<double> triangle = Samples(2000, 4000, 0, {{1, 309.3}});
  for (double& x : triangle) x = 2e-6 * std::asin(x);
  EXPECT_EQ(RowsBetweenReadings(triangle, 309.3 / 2000), 0);
  // few phases, one or two of which are the tone's mean
  for (const double phases : {5.0, 16.0 / 3, 6.0, 7.0, 8.0, 9.0, 10.0, 12.0, 16.0}) {
    EXPECT_EQ(RowsBetweenReadings(Samples(phases, 5000, 0.03, {{1e-5, 1}}), 1 / phases), 0)
        << phases;
  }
  EXPECT_EQ(RowsBetweenReadings({}, cycles), 0);
  EXPECT_EQ(RowsBetweenReadings(std::vector<double>(500, 1.0), cycles), 0);
}

}  // namespace
}  // namespace haptometer::dsp
