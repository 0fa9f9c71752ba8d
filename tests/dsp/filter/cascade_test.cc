#include "dsp/filter/cascade.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "tests/dsp/filter/exact_filter.h"
#include "tests/dsp/filter/scipy_reference.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

std::vector<double> Filtered(const FilterDesign& design, const std::vector<double>& in,
                             double constant) {
  std::vector<double> out(in.size());
  Cascade cascade(design);
  cascade.StartFrom(constant);
  cascade.Process(in, out);
  return out;
}

TEST(Cascade, LosesNothingToAnOffsetAndTremor) {
  for (const double rate_hz : {10e3, 50e3}) {
    const std::vector<double> in = HandHeld(rate_hz, 1.5);
    for (int order = 1; order <= kHighestOrder; ++order) {
      SCOPED_TRACE(testing::Message() << "order " << order << " at " << rate_hz << " Hz");
      const FilterDesign design = Designed({order, 20, 500, Corners::kWhole}, rate_hz);
      const double error =
          RelativeRmsError(Filtered(design, in, in[0]), QuadFiltered(design, in, in[0]),
                           static_cast<std::size_t>(rate_hz));
      EXPECT_ABS(error, 0, 1e-13, "double's rounding of the state, against 113 bits");
    }
  }
}

TEST(Cascade, LosesNothingAt392kHz) {
  const std::vector<double> in = HandHeld(392e3, 1.2);
  for (const int order : {4, 6}) {
    const FilterDesign design = Designed({order, 20, 500, Corners::kWhole}, 392e3);
    const double error =
        RelativeRmsError(Filtered(design, in, in[0]), QuadFiltered(design, in, in[0]), 320'000);
    EXPECT_ABS(error, 0, 1e-13, "double's rounding of the state, against 113 bits");
  }
}

TEST(Cascade, IsTheFilterOfScipy) {
  const std::vector<double> in = ScipyInput(kScipySamples);
  for (const FilteredSample& sample : kScipyFiltered) {
    const FilterDesign design = Designed({sample.order, 20, 500, Corners::kEach}, 1e4);
    EXPECT_ABS(Filtered(design, in, in[0])[sample.index], sample.causal_m, 2e-19,
               "SciPy's rounding: 1e-12 of 0.1 um");
  }
}

TEST(Cascade, AnySplitGivesTheSameBytes) {
  const std::vector<double> in = HandHeld(10e3, 1.0);
  for (int order = 1; order <= kHighestOrder; ++order) {
    const FilterDesign design = Designed({order, 20, 500}, 10e3);
    const std::vector<double> whole = Filtered(design, in, in[0]);
    for (const std::size_t chunk : {std::size_t{1}, std::size_t{7}, std::size_t{4096}}) {
      std::vector<double> out = in;  // in place
      Cascade cascade(design);
      cascade.StartFrom(in[0]);
      for (std::size_t k = 0; k < out.size(); k += chunk) {
        const std::span<double> part = std::span(out).subspan(k, std::min(chunk, out.size() - k));
        cascade.Process(part, part);
      }
      EXPECT_EQ(std::memcmp(out.data(), whole.data(), whole.size() * sizeof(double)), 0);
    }
  }
}

TEST(Cascade, AConstantGivesExactlyNothing) {
  const std::vector<double> in(1000, 0.0301234567);
  for (int order = 1; order <= kHighestOrder; ++order) {
    const FilterDesign design = Designed({order, 20, 500}, 10e3);
    for (const double y : Filtered(design, in, in[0])) EXPECT_EQ(y, 0);
  }
}

TEST(Cascade, AToneComesOutAsTheResponseSays) {
  constexpr double kRateHz = 10e3;
  const FilterDesign design = Designed({5, 20, 500}, kRateHz);
  const std::vector<double> out = Filtered(design, Samples(kRateHz, 20'000, 0, {{1, 330, 0.4}}), 0);
  const std::complex<double> response = Response(design, 330);
  double worst = 0;
  for (std::size_t k = 19'900; k < 20'000; ++k) {
    const double phase = 2 * std::numbers::pi * 330 * static_cast<double>(k) / kRateHz + 0.4;
    const double expected = std::abs(response) * std::sin(phase + std::arg(response));
    worst = std::max(worst, std::abs(out[k] - expected));
  }
  EXPECT_ABS(worst, 0, 3e-12, "rounding of the input's phases, 4e3 rad, and of these");
}

TEST(Cascade, IsLinearAndKnowsNoTime) {
  const FilterDesign design = Designed({6, 20, 500}, 10e3);
  const std::vector<double> a = Samples(10e3, 5000, 0, {{1, 90}});
  const std::vector<double> b = Samples(10e3, 5000, 0, {{1, 400, 1}});
  std::vector<double> sum(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) sum[k] = 2 * a[k] - 3 * b[k];
  const std::vector<double> ya = Filtered(design, a, 0);
  const std::vector<double> yb = Filtered(design, b, 0);
  const std::vector<double> ysum = Filtered(design, sum, 0);
  // a delayed input gives the same bytes, delayed
  std::vector<double> late(a.size() + 37, 0.0);
  std::ranges::copy(a, late.begin() + 37);
  const std::vector<double> ylate = Filtered(design, late, 0);
  double worst = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    worst = std::max(worst, std::abs(ysum[k] - (2 * ya[k] - 3 * yb[k])));
  }
  EXPECT_ABS(worst, 0, 1e-12, "rounding of three runs of amplitude 5");
  EXPECT_TRUE(std::equal(ya.begin(), ya.end(), ylate.begin() + 37));
}

TEST(CascadeDeathTest, SizesAndSectionsAreChecked) {
  FilterDesign design = Designed({3, 20, 500}, 10e3);
  Cascade cascade(design);
  std::vector<double> values(7);
  const std::span<double> all(values);
  EXPECT_DEATH(cascade.CopyState(all), "check failed");
  EXPECT_DEATH(cascade.CopyState(all.first(5)), "check failed");
  cascade.CopyState(all.first(6));
  EXPECT_DEATH(cascade.Process(all, all.first(6)), "check failed");
  std::swap(design.sections.front(), design.sections.back());
  EXPECT_DEATH(CheckSections(design), "check failed");
  design.sections.pop_back();
  EXPECT_DEATH(CheckSections(design), "check failed");
  design.order = 0;
  EXPECT_DEATH(CheckSections(design), "check failed");
  design.order = kHighestOrder + 1;
  EXPECT_DEATH(CheckSections(design), "check failed");
}

}  // namespace
}  // namespace haptometer::dsp
