#include "dsp/filter/cascade.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <vector>

#include "tests/dsp/filter/scipy_reference.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

__extension__ typedef __float128 Quad;

std::vector<double> Filtered(const FilterDesign& design, const std::vector<double>& in,
                             double constant) {
  std::vector<double> out(in.size());
  Cascade cascade(design);
  cascade.StartFrom(constant);
  cascade.Process(in, out);
  return out;
}

// the same coefficients in direct form I and 113-bit arithmetic: another recursion, the same filter
std::vector<double> QuadFiltered(const FilterDesign& design, const std::vector<double>& in,
                                 double constant) {
  std::vector<Quad> signal(in.begin(), in.end());
  auto before = static_cast<Quad>(constant);
  for (const DeltaSection& section : design.sections) {
    const auto e = static_cast<Quad>(section.e);
    const auto f = static_cast<Quad>(section.f);
    const auto b = static_cast<Quad>(section.b);
    const Quad one = section.kind == SectionKind::kHighPass   ? -2
                     : section.kind == SectionKind::kBandPass ? 0
                                                              : 2;
    const Quad two = section.kind == SectionKind::kBandPass ? -1 : 1;
    Quad x1 = before;
    Quad x2 = before;
    Quad y1 = 0;
    Quad y2 = 0;
    for (Quad& value : signal) {
      const Quad x = value;
      const Quad y = b * (x + one * x1 + two * x2) - (e + f - 2) * y1 - (1 - f) * y2;
      x2 = x1;
      x1 = x;
      y2 = y1;
      y1 = y;
      value = y;
    }
    before = 0;
  }
  std::vector<double> out(in.size());
  for (std::size_t k = 0; k < in.size(); ++k) out[k] = static_cast<double>(signal[k]);
  return out;
}

double RelativeRmsError(const std::vector<double>& actual, const std::vector<double>& expected,
                        std::size_t from) {
  double error = 0;
  double power = 0;
  for (std::size_t k = from; k < actual.size(); ++k) {
    error += (actual[k] - expected[k]) * (actual[k] - expected[k]);
    power += expected[k] * expected[k];
  }
  return std::sqrt(error / power);
}

// 30 mm of distance, 0.5 mm of tremor, 1 um of vibration
std::vector<double> HandHeld(double rate_hz, double duration_s) {
  return Samples(rate_hz, static_cast<std::size_t>(rate_hz * duration_s), 30e-3,
                 {{0.5e-3, 8.3}, {1e-6, 100}});
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
  std::vector<double> in(kScipySamples);
  std::uint32_t x = 1;
  for (double& value : in) {
    x = (1103515245U * x + 12345U) & 0x7fffffffU;
    value = 1e-3 + 1e-6 * (x / 2147483648.0 - 0.5);
  }
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

}  // namespace
}  // namespace haptometer::dsp
