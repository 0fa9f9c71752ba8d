#include "tools/document/number_text.h"

#include <gtest/gtest.h>

#include <limits>

namespace haptometer::document {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(NumberText, ShowsTwoDigitsOfTheUncertainty) {
  EXPECT_EQ(NumberText(70.7106, 0.1234, 0), "70.71(12)");
  EXPECT_EQ(NumberText(0.00123456, 0.00045, 0), "0.00123(45)");
  EXPECT_EQ(NumberText(-3.14159, 0.00020, 0), "-3.14159(20)");
  EXPECT_EQ(NumberText(12346.7, 670, 0), "12350(670)");
  EXPECT_EQ(NumberText(98.7, 23.4, 0), "99(23)");
  EXPECT_EQ(NumberText(98.7, 2.34, 0), "98.7(23)");
  EXPECT_EQ(NumberText(12.3, 0.1, 0), "12.30(10)");
}

TEST(NumberText, CarriesWhereRoundingGivesAThirdDigit) {
  EXPECT_EQ(NumberText(1.23456, 0.0996, 0), "1.23(10)");
  EXPECT_EQ(NumberText(1.23456, 0.00994, 0), "1.2346(99)");
}

TEST(NumberText, TakesAPowerOfTenBeyondNinePlaces) {
  EXPECT_EQ(NumberText(1.2341e12, 1.2e10, 0), "1.234(12)e+12");
  EXPECT_EQ(NumberText(1.2341e-12, 1.2e-14, 0), "1.234(12)e-12");
  EXPECT_EQ(NumberText(-4, 3.1e11, 0), "0.0(31)e+11") << "it is less than a digit";
}

TEST(NumberText, ShowsSixDigitsWithoutAnUncertainty) {
  for (const double unknown : {0.0, -1.0, kNan, std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(NumberText(1.23456789, unknown, 0), "1.23457");
  }
  EXPECT_EQ(NumberText(9300, 0, 0), "9300");
  EXPECT_EQ(NumberText(0.25, 0, 0, 4), "0.25");
  EXPECT_EQ(NumberText(2.2564e-14, 0, 2.2564e-15), "2.3e-14");
  EXPECT_EQ(NumberText(201.88526, 0, 0, 4), "201.9");
  EXPECT_EQ(NumberText(10240, 0, 0, 4), "10240") << "no power of ten";
  EXPECT_EQ(NumberText(-123456.7, 0, 0, 4), "-123500");
  EXPECT_EQ(NumberText(99.97, 0, 0, 2), "100") << "rounding gives a third digit";
  EXPECT_EQ(NumberText(999.97, 0, 0, 2), "1000");
}

// 224.9999999872(15) was printed of a noiseless record: no clock is known to 1e-11
TEST(NumberText, ShowsNoUncertaintyBelow1e7OfTheValue) {
  EXPECT_EQ(NumberText(224.9999999872, 1.5e-9, 0), "225");
  EXPECT_EQ(NumberText(224.97123456, 1.5e-9, 0), "224.971");
  EXPECT_EQ(NumberText(100, 1.01e-5, 0), "100.000000(10)");
  EXPECT_EQ(NumberText(100, 0.99e-5, 0), "100");
}

TEST(NumberText, ShowsNothingBelowTheResolution) {
  EXPECT_EQ(NumberText(12.345678, 0, 0.01), "12.35");
  EXPECT_EQ(NumberText(12.345678, 0, 0.005), "12.346") << "the place of its first digit";
  EXPECT_EQ(NumberText(12.345678, 0, 10), "10");
  EXPECT_EQ(NumberText(12.345678, 0.0034, 0.01), "12.35(1)") << "not less than one step";
  EXPECT_EQ(NumberText(12.345678, 0.034, 0.01), "12.35(3)");
  EXPECT_EQ(NumberText(12.345678, 0.34, 0.01), "12.35(34)");
  EXPECT_EQ(NumberText(12.345678, 3.4, 0.01), "12.3(34)") << "two digits are enough";
  EXPECT_EQ(NumberText(1234.5678, 0, 1e-4), "1234.57") << "six digits are enough";
  // 1e-8 m in um is a little below 0.01
  EXPECT_EQ(NumberText(12.345678, 0, 1e-8 * 1e6), "12.35");
}

TEST(NumberText, ShowsZeroWithoutDecimalsAndWithoutASign) {
  EXPECT_EQ(NumberText(0, 0, 0), "0");
  EXPECT_EQ(NumberText(-0.0, 0, 0.01), "0");
  EXPECT_EQ(NumberText(1e-4, 0, 0.01), "0");
  EXPECT_EQ(NumberText(-1e-4, 0, 0.01), "0");
  EXPECT_EQ(NumberText(-0.0004, 0.1, 0), "0.00(10)");
  EXPECT_EQ(NumberText(-3, 670, 0), "0(670)");
}

TEST(RangeText, ShowsBothEndsToTheLastDigitOfTheValueBetween) {
  EXPECT_EQ(RangeText(14.1234, 14.5678, 0.1, 0), "14.12 to 14.57");
  EXPECT_EQ(RangeText(12344, 13687, 670, 0), "12340 to 13690");
  EXPECT_EQ(RangeText(-0.001, 12, 0.1, 0), "0.00 to 12.00");
  EXPECT_EQ(RangeText(0.5, 2.25, 0, 0), "0.5 to 2.25");
  EXPECT_EQ(RangeText(0.123456, 2.25, 0, 0.01), "0.12 to 2.25");
  EXPECT_EQ(RangeText(1e12, 2e12, 1e11, 0), "1e+12 to 2e+12");
}

TEST(Unit, IsSaidInTheLargestOfWhichAValueHasOne) {
  EXPECT_EQ(kMetre.For(0).symbol, "um");
  EXPECT_EQ(kMetre.For(999e-6).symbol, "um");
  EXPECT_EQ(kMetre.For(1e-3).symbol, "mm");
  EXPECT_EQ(kMetre.For(2).symbol, "m");
  EXPECT_EQ(kKilogram.For(5).symbol, "g");
  EXPECT_EQ(kNone.For(5).symbol, "");
  EXPECT_EQ(QuantityText(2.5e-3, kMetre, 4), "2.5 mm");
  EXPECT_EQ(QuantityText(-0.0123, kShare, 4), "-1.23 %");
  EXPECT_EQ(QuantityText(3.141592653589793 / 2, kRadian, 4), "90 degrees");
}

TEST(Unit, IsThatOfTheLongestEndingOfAName) {
  EXPECT_EQ(UnitOfName("rise_s").symbol, "s");
  EXPECT_EQ(UnitOfName("drift_m_per_s").symbol, "m/s");
  EXPECT_EQ(UnitOfName("damping_n_s_per_m").symbol, "N s/m");
  EXPECT_EQ(UnitOfName("readings_per_s").symbol, "1/s");
  EXPECT_EQ(UnitOfName("acceleration_m_per_s2").symbol, "m/s^2");
  EXPECT_EQ(UnitOfName("drops").symbol, "");
}

}  // namespace
}  // namespace haptometer::document
