#include "tools/cli/uncertain_number.h"

#include <gtest/gtest.h>

#include <limits>

namespace haptometer::cli {
namespace {

TEST(WithUncertainty, ShowsTwoDigitsOfIt) {
  EXPECT_EQ(WithUncertainty(70.7106, 0.1234), "70.71(12)");
  EXPECT_EQ(WithUncertainty(0.00123456, 0.00045), "0.00123(45)");
  EXPECT_EQ(WithUncertainty(-3.14159, 0.00020), "-3.14159(20)");
}

TEST(WithUncertainty, CarriesWhenRoundingGivesAThirdDigit) {
  EXPECT_EQ(WithUncertainty(1.23456, 0.0996), "1.23(10)");
  EXPECT_EQ(WithUncertainty(1.23456, 0.00994), "1.2346(99)");
}

TEST(WithUncertainty, RoundsBothBeforeThePoint) {
  EXPECT_EQ(WithUncertainty(12346.7, 670), "12350(670)");
  EXPECT_EQ(WithUncertainty(98.7, 23.4), "99(23)");
  EXPECT_EQ(WithUncertainty(98.7, 2.34), "98.7(23)");
}

TEST(WithUncertainty, WithoutOneGivesSixDigits) {
  EXPECT_EQ(WithUncertainty(1.23456789, 0), "1.23457");
  EXPECT_EQ(WithUncertainty(1.23456789, std::numeric_limits<double>::quiet_NaN()), "1.23457");
}

TEST(WithUncertainty, KeepsZerosAndShowsNoSignOfZero) {
  EXPECT_EQ(WithUncertainty(12.3, 0.1), "12.30(10)");
  EXPECT_EQ(WithUncertainty(-0.0004, 0.1), "0.00(10)");
  EXPECT_EQ(WithUncertainty(-0.0, 0), "0");
  EXPECT_EQ(WithUncertainty(-3, 670), "0(670)");
}

TEST(ToThePlaceOf, ShowsAnIntervalsEndsAsItsMiddle) {
  EXPECT_EQ(ToThePlaceOf(0.0021, 14.14), "14.1400");
  EXPECT_EQ(ToThePlaceOf(0.1, 12.0), "12.00");
  EXPECT_EQ(ToThePlaceOf(670, 13690), "13690");
  EXPECT_EQ(ToThePlaceOf(0.1, -0.001), "0.00");
  EXPECT_EQ(ToThePlaceOf(0, 1.23456789), "1.23457");
}

TEST(DigitsOf, ShowTwoDigitsOfTheWidth) {
  EXPECT_EQ(DigitsOf(225.1, 227.3, 1), 4);
  EXPECT_EQ(DigitsOf(225.1, 227.3, 6), 6);
  EXPECT_EQ(DigitsOf(2.00001, 2.00002, 4), 7);
  EXPECT_EQ(DigitsOf(-2.00002, -2.00001, 4), 7);
  EXPECT_EQ(DigitsOf(-3e-9, 4e-9, 4), 4);
  EXPECT_EQ(DigitsOf(2, 2, 4), 4) << "no width";
  EXPECT_EQ(DigitsOf(2, std::numeric_limits<double>::infinity(), 4), 4);
  EXPECT_EQ(DigitsOf(1, 1 + 1e-15, 4), 12) << "round-off";
}

TEST(DecimalsOf, ShowTwoDigitsOfTheWidth) {
  EXPECT_EQ(DecimalsOf(0.1234, 0.1312, 1), 4);
  EXPECT_EQ(DecimalsOf(32.1, 37.8, 1), 1);
  EXPECT_EQ(DecimalsOf(32, 82, 1), 1);
  EXPECT_EQ(DecimalsOf(0.5, 0.5, 3), 3);
}

}  // namespace
}  // namespace haptometer::cli
