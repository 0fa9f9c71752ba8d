#include "dsp/filter/butterworth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "tests/dsp/filter/scipy_reference.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

// |H| by the analog prototype, in long double: shares nothing with the sections
double ClosedForm(const BandPass& band, double rate_hz, double frequency_hz) {
  const auto warp = [&](double f_hz) {
    return std::tan(std::numbers::pi_v<long double> * static_cast<long double>(f_hz) /
                    static_cast<long double>(rate_hz));
  };
  const long double lower = warp(band.lower_hz);
  const long double upper = warp(band.upper_hz);
  long double width = upper - lower;
  if (band.corners == Corners::kWhole) {
    width /= std::pow(std::sqrt(2.0L) - 1, 1.0L / (2 * band.order));
  }
  const long double s = warp(frequency_hz);
  const long double x = (lower * upper - s * s) / (width * s);
  return static_cast<double>(1 / std::sqrt(1 + std::pow(x * x, band.order)));
}

// a design's error: relative over 15-600 Hz in 400 steps of equal ratio, absolute from 1e-3 Hz to
// nearly half the rate
template <typename Expected>
double WorstError(const FilterDesign& design, const Expected& expected) {
  double worst = 0;
  const auto compare = [&](double f_hz, bool relative) {
    if (f_hz >= design.rate_hz / 2) return;
    const double closed = expected(f_hz);
    worst = std::max(worst, std::abs(Magnitude(design, f_hz) - closed) / (relative ? closed : 1));
  };
  for (int k = 0; k <= 400; ++k) compare(15 * std::pow(40.0, k / 400.0), true);
  for (const double f_hz : {15.0, 20.0, 100.0, 225.0, 500.0, 600.0}) compare(f_hz, true);
  for (int k = 0; k <= 200; ++k) {
    compare(1e-3 * std::pow(0.4999 * design.rate_hz / 1e-3, k / 200.0), false);
  }
  return worst;
}

// every order, corner convention and rate of 2 kHz to 10 MHz
template <typename Visit>
void ForEachDesign(const Visit& visit) {
  for (const Corners corners : {Corners::kEach, Corners::kWhole}) {
    for (int order = 1; order <= kHighestOrder; ++order) {
      for (const double rate_hz :
           {2e3, 2.5e3, 5e3, 1e4, 44.1e3, 5e4, 1e5, 2e5, 392e3, 1e6, 2.5e6, 1e7}) {
        SCOPED_TRACE(testing::Message() << "order " << order << " at " << rate_hz << " Hz");
        visit(corners, order, rate_hz);
      }
    }
  }
}

TEST(Butterworth, MagnitudeOfTheBandPassIsTheClosedForm) {
  ForEachDesign([](Corners corners, int order, double rate_hz) {
    const BandPass band{order, 20, 500, corners};
    EXPECT_ABS(WorstError(Designed(band, rate_hz),
                          [&](double f_hz) { return ClosedForm(band, rate_hz, f_hz); }),
               0, 1e-14, "rounding of tan, sqrt and two factors a section");
  });
}

TEST(Butterworth, TwoPassesOfTheWholeDesignHaveMinusThreeDecibelsAtTheCorners) {
  for (int order = 1; order <= kHighestOrder; ++order) {
    for (const double rate_hz : {2e3, 1e4, 5e4, 4e5, 1e7}) {
      const FilterDesign design = Designed({order, 20, 500, Corners::kWhole}, rate_hz);
      for (const double corner_hz : {20.0, 500.0}) {
        const double gain = std::norm(Response(design, corner_hz));
        EXPECT_REL(gain, 1 / std::numbers::sqrt2, 5e-15, "rounding, doubled by the second pass");
      }
    }
  }
}

TEST(Butterworth, OnePassOfTheEachDesignHasMinusThreeDecibelsAtTheCorners) {
  const FilterDesign design = Designed({4, 20, 500, Corners::kEach}, 1e4);
  EXPECT_REL(Magnitude(design, 20), 1 / std::numbers::sqrt2, 1e-14, "rounding");
  EXPECT_REL(Magnitude(design, 500), 1 / std::numbers::sqrt2, 1e-14, "rounding");
  EXPECT_ABS(Magnitude(design, 0), 0, 0, "a zero at 0 Hz");
}

TEST(Butterworth, NarrowBandKeepsItsDigits) {
  // 1 part in 1e4 at 392 kHz: the difference of two tangents would lose 4 digits; the response
  // itself is that much more sensitive to its poles
  const BandPass band{3, 225, 225.0225, Corners::kEach};
  const FilterDesign design = Designed(band, 392e3);
  EXPECT_REL(Magnitude(design, 225.0225), 1 / std::numbers::sqrt2, 1e-11,
             "1e-15 times centre over width, 1e4");
}

TEST(Butterworth, PhaseAndMagnitudeAreThoseOfScipy) {
  for (const ResponsePoint& point : kScipyResponses) {
    const FilterDesign design =
        Designed({point.order, 20, 500, Corners::kEach}, kScipyResponseRateHz);
    const std::complex<double> response = Response(design, point.frequency_hz);
    const std::complex<double> expected(point.real, point.imaginary);
    EXPECT_ABS(std::abs(response - expected) / std::abs(expected), 0, 1e-12,
               "SciPy's poles and zeros in double");
  }
}

// a wide band that ends near half the rate has real poles z = (1 + s)/(1 - s) below 0, s by the
// quadratic formula
TEST(Butterworth, DecaysOfPolesBelowZero) {
  const double rate_hz = 796200;
  const BandPass band{
      .order = 1, .lower_hz = 205200, .upper_hz = 390138, .corners = Corners::kEach};
  const auto corner = [&](double hz) { return std::tan(std::numbers::pi * hz / rate_hz); };
  const double width = corner(band.upper_hz) - corner(band.lower_hz);
  const double square = corner(band.upper_hz) * corner(band.lower_hz);
  const double far = -(width + std::sqrt(width * width - 4 * square)) / 2;
  const double near = square / far;
  const auto radius = [](double s) { return std::abs((1 + s) / (1 - s)); };
  ASSERT_LT((1 + far) / (1 - far), 0);
  const double expected = -std::log(std::max(radius(far), radius(near))) * rate_hz;
  EXPECT_REL(SlowestDecayPerS(*DesignBandPass(band, rate_hz)), expected, 1e-13,
             "rounding of some 20 operations");
}

TEST(Butterworth, SlowestDecayIsThatOfThePoleNearestTheCircle) {
  // 1 - |z| = 6.06e-4 for order 6 at 50 kHz by SciPy's poles
  const FilterDesign design = Designed({6, 20, 500, Corners::kEach}, 5e4);
  EXPECT_REL(1 - std::exp(-SlowestDecayPerS(design) / 5e4), kScipySlowestPoleDistance, 5e-12,
             "SciPy's poles lose their distance from 1");
  // a real pair: order 1, wide band; poles of the analog filter at about the corners
  const FilterDesign wide = Designed({1, 1, 100, Corners::kEach}, 1e6);
  const double pi = std::numbers::pi;
  EXPECT_REL(SlowestDecayPerS(wide), pi * (99 - std::sqrt(99.0 * 99 - 400)), 5e-9,
             "warping at 1 MHz, (pi f/rate)^2");
}

TEST(Butterworth, ImpossibleBandsAreRefused) {
  const auto text = [](const BandPass& band, double rate_hz) {
    const auto design = DesignBandPass(band, rate_hz);
    EXPECT_FALSE(design);
    EXPECT_EQ(design.error().cause, Cause::kUsage);
    return design.error().Text();
  };
  EXPECT_EQ(
      text({6, 20, 500}, 900),
      "band: its upper corner of 500 Hz is not below half the rate of 900 Hz; lower the corner "
      "below 450 Hz");
  EXPECT_EQ(text({0, 20, 500}, 1e4), "order: 0 is not possible; choose 1 to 8");
  EXPECT_EQ(text({9, 20, 500}, 1e4), "order: 9 is not possible; choose 1 to 8");
  const std::string no_band =
      "is not a band; give a lower corner above 0 and an upper corner above it, as 20-500Hz";
  EXPECT_EQ(text({6, 500, 500}, 1e4), "band: 500-500 Hz " + no_band);
  EXPECT_EQ(text({6, 500, 20}, 1e4), "band: 500-20 Hz " + no_band);
  EXPECT_EQ(text({6, 0, 20}, 1e4), "band: 0-20 Hz " + no_band);
  EXPECT_EQ(text({6, std::nan(""), 20}, 1e4), "band: nan-20 Hz " + no_band);
  EXPECT_EQ(text({6, 20, 500}, 0), "sample rate: is 0 Hz; give a positive rate");
}

}  // namespace
}  // namespace haptometer::dsp
