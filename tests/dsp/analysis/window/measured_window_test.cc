// Which rows a window has and what is kept of them; the oracle is counting.
#include "dsp/analysis/window/measured_window.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <vector>

#include "tests/dsp/analysis/window/made_window.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

TEST(MeasuredWindow, HoldsWholePeriodsOfItsTone) {
  MadeWindow made(TwoSeconds());
  made.chosen.begin = 500;
  made.chosen.end = 1500;
  const auto rows = [&](double frequency_hz) {
    return WholePeriods(made.window, SineFit{.frequency_hz = frequency_hz});
  };
  EXPECT_EQ(WholePeriods(made.window, {}), 1000U) << "no tone";
  EXPECT_EQ(rows(95), 947U) << "9 periods of 105.26 rows";
  EXPECT_EQ(rows(94), 957U) << "9 periods of 106.38 rows";
  EXPECT_EQ(rows(100.9), 991U) << "10 periods of 99.11 rows";
  EXPECT_EQ(rows(10.05), 995U) << "one period of 995.02 rows";
  EXPECT_EQ(rows(9.95), 1000U) << "less than one";
  EXPECT_EQ(rows(100), 1000U);
}

// The segment begins at 3 s, and the record has 40 rows before it.
TEST(MeasuredWindow, IsDescribedInTheRecordsTimeAndRows) {
  MadeWindow made(TwoSeconds());
  made.segments.parts[0].start_s = 3;
  made.segments.parts[0].first_row = 40;
  made.chosen.begin = 500;
  made.chosen.end = 1500;
  made.chosen.excluded = {{600, 700}, {1350, 1490}, {1400, 1450}};
  made.chosen.hum = {{50, 3, 4}};
  made.window.rows = 900;
  DescribePart(made.window);
  const BandNumbers& numbers = made.window.numbers;
  EXPECT_EQ(numbers.part.first_row, 540U);
  EXPECT_EQ(numbers.part.rows, 900U);
  EXPECT_REL(numbers.part.window.begin_s, 3.05, 1e-14, "rounding");
  EXPECT_REL(numbers.part.window.end_s, 3.14, 1e-14, "rounding");
  // what lies behind the whole periods is not the window's
  ASSERT_EQ(numbers.excluded.size(), 2U);
  EXPECT_REL(numbers.excluded[0].begin_s, 3.06, 1e-14, "rounding");
  EXPECT_REL(numbers.excluded[0].end_s, 3.07, 1e-14, "rounding");
  EXPECT_REL(numbers.excluded[1].begin_s, 3.135, 1e-14, "rounding");
  EXPECT_REL(numbers.excluded[1].end_s, 3.14, 1e-14, "cut to the window");
  ASSERT_EQ(numbers.hum.size(), 1U);
}

// sum of squares of samples [begin, end)
double SquareSumOf(const BandSignal& signal, std::size_t begin, std::size_t end) {
  std::vector<double> samples(end - begin);
  EXPECT_TRUE(signal.Read(begin, samples));
  double sum = 0;
  for (const double x : samples) sum += x * x;
  return sum;
}

TEST(MeanSquareKept, IsOfWhatIsKeptAwayFromItsEnds) {
  MadeWindow made(Samples(10e3, 20'000, 0, {{1e-6, 100}, {1e-6, 37.3}}));
  made.chosen.begin = 5000;
  made.window.rows = 8000;
  const auto sum = [&](std::size_t begin, std::size_t end) {
    return SquareSumOf(made.signal, begin, end);
  };
  const auto kept = [&](const SampleRanges& excluded, std::size_t inset) {
    return MeanSquareKept(made.window, excluded, inset).value();
  };
  constexpr double kSums = 1e-13;  // order of the sums
  EXPECT_REL(kept({}, 0), sum(5000, 13'000) / 8000, kSums, "all");
  EXPECT_REL(kept({}, 100), sum(5100, 12'900) / 7800, kSums, "all but the ends");
  // 1000 rows at the begin, 2000 within, and 1500 rows beyond the end, of which 500 are the
  // window's
  const SampleRanges excluded{{4900, 6000}, {7000, 9000}, {12'500, 14'000}};
  EXPECT_REL(kept(excluded, 0), (sum(6000, 7000) + sum(9000, 12'500)) / 4500, kSums, "two pieces");
  EXPECT_REL(kept(excluded, 499), (sum(6499, 6501) + sum(9499, 12'001)) / 2504, kSums,
             "2 rows are left of the first");
  EXPECT_REL(kept(excluded, 500), sum(9500, 12'000) / 2500, kSums, "none is left of the first");
  EXPECT_EQ(kept(excluded, 1750), 0) << "nothing is left";
  EXPECT_EQ(kept({{0, 20'000}}, 0), 0);
}

// Hum of 3 um beside a tone of 1 um: whole periods of both, so that their squares add.
TEST(WithoutHum, LeavesTheDriveAndStatesThePowerTaken) {
  MadeWindow made(Samples(10e3, 20'000, 0, {{1e-6, 100, 0.4}, {3e-6, 50, 1.1}}));
  double hum_square = -1;
  // without lines in it nothing is taken or stated
  ASSERT_TRUE(WithoutHum(made.window, 6000, 14'000, &hum_square));
  EXPECT_EQ(hum_square, -1);
  const double gain = std::norm(Response(made.signal.design(), 50));
  // 3 um sin(w t + 1.1) behind the filter
  made.chosen.hum = {{50, 3e-6 * gain * std::sin(1.1), 3e-6 * gain * std::cos(1.1)}};
  // the line turns from the segment's first sample on, wherever the part begins
  for (const std::size_t begin : {6000U, 6037U, 5111U}) {
    const auto samples = WithoutHum(made.window, begin, begin + 8000, &hum_square).value();
    EXPECT_REL(hum_square, std::pow(3e-6 * gain, 2) / 2, 1e-5, "transients of the filter");
    ASSERT_EQ(samples.size(), 8000U);
    double worst = 0;
    const std::vector<double> tone =
        Samples(10e3, 8000, 0, {{1e-6, 100, 0.4}}, static_cast<double>(begin));
    for (std::size_t k = 0; k < samples.size(); ++k) {
      worst = std::max(worst, std::abs(samples[k] - tone[k]));
    }
    EXPECT_ABS(worst / 1e-6, 0, 2e-4, "the filter at 100 Hz, and its transients");
  }
}

// Of more than 2^21 samples the middle 2^19 are read; the line is subtracted where they lie.
TEST(WithoutHum, OfALongPartIsOfItsMiddle) {
  constexpr double kRateHz = 1300;
  constexpr std::size_t kSize = (std::size_t{1} << 21U) + 1001;
  std::vector<double> values(kSize);
  for (std::size_t k = 0; k < kSize; ++k) {  // 50 Hz: 26 rows a period
    values[k] = 1e-6 * std::sin(2 * std::numbers::pi * static_cast<double>(k % 26) / 26);
  }
  MadeWindow made(std::move(values), kRateHz);
  const double gain = std::norm(Response(made.signal.design(), 50));
  made.chosen.hum = {{50, 0, 1e-6 * gain}};
  double hum_square = 0;
  const auto samples = WithoutHum(made.window, 0, kSize, &hum_square).value();
  ASSERT_EQ(samples.size(), std::size_t{1} << 19U);
  double worst = 0;
  for (const double x : samples) worst = std::max(worst, std::abs(x));
  EXPECT_ABS(worst / 1e-6, 0, 1e-8, "phase of 50 Hz after 1600 s: 5e5 rad in double");
  EXPECT_REL(hum_square, std::pow(1e-6 * gain, 2) / 2, 1e-4, "a part of a period of 2e4");
}

TEST(SamplesOf, AreTheLongestPieceKept) {
  MadeWindow made(Samples(10e3, 20'000, 0, {{1e-6, 100}}));
  made.chosen.begin = 4000;
  made.chosen.end = 16'000;
  made.chosen.excluded = {{6000, 6100}, {9000, 9100}, {15'000, 15'100}};
  const auto samples = SamplesOf(made.window).value();
  EXPECT_EQ(samples.rate_hz, 10e3) << "half of 5900 samples would be less than 2^12";
  std::vector<double> piece(samples.values_m.size());
  ASSERT_TRUE(made.signal.Read(9100, piece));
  EXPECT_EQ(samples.values_m, piece);
  EXPECT_GT(piece.size(), 5700U) << "all but what does not transform fast";
}

}  // namespace
}  // namespace haptometer::dsp
