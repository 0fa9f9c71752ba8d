#include "base/quantity.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "tests/residual.h"

namespace haptometer {
namespace {

struct Case {
  const char* text;
  Dimension dimension;
  double value;
  double standard_uncertainty;
};

class Quantities : public ::testing::TestWithParam<Case> {};

TEST_P(Quantities, AreReadAsSi) {
  const Case& c = GetParam();
  const auto quantity = ParseQuantity(c.text, c.dimension, "--x");
  ASSERT_TRUE(quantity) << quantity.error().Text();
  EXPECT_REL(quantity->value, c.value, 4e-16, "one rounding of the unit's factor");
  EXPECT_ABS(quantity->standard_uncertainty, c.standard_uncertainty, 1e-15 * c.value,
             "rounding of the factors");
}

INSTANTIATE_TEST_SUITE_P(Forms, Quantities,
                         ::testing::Values(Case{"1.4g", Dimension::kMass, 1.4e-3, 0},
                                           Case{" 10 mm ", Dimension::kLength, 1e-2, 0},
                                           Case{"1.40(3)g", Dimension::kMass, 1.4e-3, 3e-5},
                                           Case{"2800(58)", Dimension::kStiffness, 2800, 58},
                                           Case{"1.40(0.03) g", Dimension::kMass, 1.4e-3, 3e-5},
                                           Case{"1.40g+-0.03g", Dimension::kMass, 1.4e-3, 3e-5},
                                           Case{"1.40 ± 0.03 g", Dimension::kMass, 1.4e-3, 3e-5},
                                           Case{"1.40g+/-30mg", Dimension::kMass, 1.4e-3, 3e-5},
                                           Case{"130µH", Dimension::kInductance, 130e-6, 0},
                                           Case{"130μH", Dimension::kInductance, 130e-6, 0},
                                           Case{"27Ω", Dimension::kResistance, 27, 0},
                                           Case{"27", Dimension::kResistance, 27, 0},
                                           Case{"33Ohm", Dimension::kResistance, 33, 0},
                                           Case{"1.5 kOhms", Dimension::kResistance, 1500, 0},
                                           Case{"56OHM", Dimension::kResistance, 56, 0},
                                           Case{"1.25GHz", Dimension::kFrequency, 1.25e9, 0},
                                           Case{"40ns", Dimension::kTime, 4e-8, 0},
                                           Case{"250uA", Dimension::kCurrent, 2.5e-4, 0},
                                           Case{"0.0322 N s/m", Dimension::kDamping, 0.0322, 0},
                                           Case{"+225Hz", Dimension::kFrequency, 225, 0},
                                           Case{"1e3", Dimension::kFrequency, 1000, 0},
                                           Case{"2min", Dimension::kTime, 120, 0}));

// the same double as the SI number written out: what is printed from it is what was typed
TEST(Quantity, UnitsMoveTheDecimalPoint) {
  const auto expect = [](const std::string& text, Dimension dimension, double value) {
    const auto quantity = ParseQuantity(text, dimension, "--x");
    ASSERT_TRUE(quantity) << text;
    EXPECT_EQ(quantity->value, value) << text;
  };
  expect("0.4mm", Dimension::kLength, 0.0004);
  expect("4.35g", Dimension::kMass, 0.00435);
  expect("-0.3 um", Dimension::kLength, -3e-7);
  expect("+1.7e+1mm", Dimension::kLength, 0.017);
  expect("2.3E-1kHz", Dimension::kFrequency, 230);
  expect("0.1(2)mm", Dimension::kLength, 1e-4);
  expect("0.7min", Dimension::kTime, 42);
  for (int k = 1; k < 2000; ++k) {
    const std::string digits = std::to_string(k);
    expect(digits + "e-2mm", Dimension::kLength, std::stod(digits + "e-5"));
    expect(digits + "um", Dimension::kLength, std::stod(digits + "e-6"));
  }
}

TEST(Quantity, OpenCircuitIsInfinite) {
  for (const char* text : {"inf", "open"}) {
    const auto quantity = ParseQuantity(text, Dimension::kResistance, "--load");
    ASSERT_TRUE(quantity);
    EXPECT_EQ(quantity->value, std::numeric_limits<double>::infinity());
  }
}

TEST(Quantity, BareLengthMassAndInductanceAreRefusedWithAProposal) {
  const auto length = ParseQuantity("10", Dimension::kLength, "--drop-height");
  ASSERT_FALSE(length);
  EXPECT_EQ(length.error().Text(),
            "--drop-height: '10' has no unit, and a length needs one; did you mean 10mm?");
  EXPECT_EQ(length.error().cause, Cause::kUsage);
  EXPECT_EQ(ParseQuantity("1.4", Dimension::kMass, "m").error().remedy, "did you mean 1.4g?");
  EXPECT_EQ(ParseQuantity("130", Dimension::kInductance, "l").error().remedy,
            "did you mean 130uH?");
}

class BadQuantities : public ::testing::TestWithParam<std::pair<const char*, Dimension>> {};

TEST_P(BadQuantities, AreUsageErrors) {
  const auto quantity = ParseQuantity(GetParam().first, GetParam().second, "--x");
  ASSERT_FALSE(quantity);
  EXPECT_EQ(quantity.error().cause, Cause::kUsage);
  EXPECT_FALSE(quantity.error().remedy.empty());
}

INSTANTIATE_TEST_SUITE_P(
    Forms, BadQuantities,
    ::testing::Values(std::pair{"", Dimension::kTime}, std::pair{"abc", Dimension::kTime},
                      std::pair{"3kg", Dimension::kTime}, std::pair{"nan", Dimension::kTime},
                      std::pair{"inf", Dimension::kTime}, std::pair{"1e999", Dimension::kTime},
                      std::pair{"1.4(3g", Dimension::kMass}, std::pair{"1.4()g", Dimension::kMass},
                      std::pair{"1.4(3", Dimension::kMass}, std::pair{"1.4(3]g", Dimension::kMass},
                      std::pair{"1.4g+-", Dimension::kMass},
                      std::pair{"1.4g+--0.1g", Dimension::kMass},
                      std::pair{"1.4(3)g+-0.1g", Dimension::kMass},
                      std::pair{"1.4g+-0.1mm", Dimension::kMass},
                      std::pair{"1.4(-3)g", Dimension::kMass}, std::pair{"1,4g", Dimension::kMass},
                      std::pair{"5 V", Dimension::kNone}));

constexpr Dimension kAll[]{Dimension::kNone,       Dimension::kLength,  Dimension::kMass,
                           Dimension::kInductance, Dimension::kTime,    Dimension::kFrequency,
                           Dimension::kVoltage,    Dimension::kCurrent, Dimension::kResistance,
                           Dimension::kStiffness,  Dimension::kDamping, Dimension::kForceConstant};

TEST(Quantity, MagnitudesAreBoundedInEveryDimension) {
  for (const Dimension dimension : kAll) {
    const auto read = [&](double si) {
      return ParseQuantity(fmt::format("{}{}", si, SiUnit(dimension)), dimension, "--x");
    };
    const PossibleMagnitudes possible = PossibleMagnitudesOf(dimension);
    for (const double sign : {1.0, -1.0}) {
      EXPECT_TRUE(read(sign * possible.least)) << SiUnit(dimension);
      EXPECT_TRUE(read(sign * possible.largest)) << SiUnit(dimension);
      EXPECT_FALSE(read(sign * possible.least * 0.99)) << SiUnit(dimension);
      EXPECT_FALSE(read(sign * possible.largest * 1.01)) << SiUnit(dimension);
      EXPECT_FALSE(read(sign * 3e-322)) << "a denormal number in " << SiUnit(dimension);
    }
    EXPECT_TRUE(read(0)) << SiUnit(dimension);
    // the cube of each and its inverse are far from overflow and underflow
    EXPECT_LT(std::pow(possible.largest, 3), 1e100);
    EXPECT_GT(std::pow(possible.least, 3), 1e-100);
  }
}

// the limits that the header states, which are those of docs/reference
TEST(Quantity, EveryDimensionHasItsStatedLimitsAndItsUnit) {
  struct Stated {
    Dimension dimension;
    const char* unit;
    double least;
    double largest;
  };
  constexpr Stated kStated[]{
      {Dimension::kNone, "", 1e-30, 1e30},         {Dimension::kLength, "m", 1e-15, 1e6},
      {Dimension::kMass, "kg", 1e-12, 1e6},        {Dimension::kInductance, "H", 1e-12, 1e6},
      {Dimension::kTime, "s", 1e-12, 1e12},        {Dimension::kFrequency, "Hz", 1e-9, 1e12},
      {Dimension::kVoltage, "V", 1e-15, 1e9},      {Dimension::kCurrent, "A", 1e-15, 1e9},
      {Dimension::kResistance, "ohm", 1e-9, 1e15}, {Dimension::kStiffness, "N/m", 1e-9, 1e15},
      {Dimension::kDamping, "N s/m", 1e-12, 1e12}, {Dimension::kForceConstant, "N/A", 1e-9, 1e9}};
  for (const Stated& stated : kStated) {
    EXPECT_EQ(SiUnit(stated.dimension), stated.unit);
    EXPECT_EQ(PossibleMagnitudesOf(stated.dimension).least, stated.least) << stated.unit;
    EXPECT_EQ(PossibleMagnitudesOf(stated.dimension).largest, stated.largest) << stated.unit;
  }
}

struct UnitCase {
  const char* symbol;
  Dimension dimension;
  double si;
};

class Units : public ::testing::TestWithParam<UnitCase> {};

TEST_P(Units, CountForTheValueAndForItsUncertainty) {
  const UnitCase& unit = GetParam();
  for (const char* form : {"24(3){}", "24{} +- 3{}", "24 {0} ± 3", "24 ± 3 {0}"}) {
    const std::string text = fmt::format(fmt::runtime(form), unit.symbol, unit.symbol);
    const auto quantity = ParseQuantity(text, unit.dimension, "--x");
    ASSERT_TRUE(quantity) << text;
    EXPECT_REL(quantity->value, 24 * unit.si, 4e-16, "rounding of the unit's factor");
    EXPECT_REL(quantity->standard_uncertainty, 3 * unit.si, 4e-16, "the same");
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, Units,
    ::testing::Values(
        UnitCase{"m", Dimension::kLength, 1}, UnitCase{"cm", Dimension::kLength, 1e-2},
        UnitCase{"mm", Dimension::kLength, 1e-3}, UnitCase{"um", Dimension::kLength, 1e-6},
        UnitCase{"nm", Dimension::kLength, 1e-9}, UnitCase{"kg", Dimension::kMass, 1},
        UnitCase{"g", Dimension::kMass, 1e-3}, UnitCase{"mg", Dimension::kMass, 1e-6},
        UnitCase{"H", Dimension::kInductance, 1}, UnitCase{"mH", Dimension::kInductance, 1e-3},
        UnitCase{"uH", Dimension::kInductance, 1e-6}, UnitCase{"nH", Dimension::kInductance, 1e-9},
        UnitCase{"s", Dimension::kTime, 1}, UnitCase{"ms", Dimension::kTime, 1e-3},
        UnitCase{"us", Dimension::kTime, 1e-6}, UnitCase{"ns", Dimension::kTime, 1e-9},
        UnitCase{"min", Dimension::kTime, 60}, UnitCase{"h", Dimension::kTime, 3600},
        UnitCase{"Hz", Dimension::kFrequency, 1}, UnitCase{"kHz", Dimension::kFrequency, 1e3},
        UnitCase{"MHz", Dimension::kFrequency, 1e6}, UnitCase{"GHz", Dimension::kFrequency, 1e9},
        UnitCase{"V", Dimension::kVoltage, 1}, UnitCase{"mV", Dimension::kVoltage, 1e-3},
        UnitCase{"uV", Dimension::kVoltage, 1e-6}, UnitCase{"kV", Dimension::kVoltage, 1e3},
        UnitCase{"A", Dimension::kCurrent, 1}, UnitCase{"mA", Dimension::kCurrent, 1e-3},
        UnitCase{"uA", Dimension::kCurrent, 1e-6}, UnitCase{"ohm", Dimension::kResistance, 1},
        UnitCase{"mohm", Dimension::kResistance, 1e-3},
        UnitCase{"kohm", Dimension::kResistance, 1e3},
        UnitCase{"Mohm", Dimension::kResistance, 1e6}, UnitCase{"N/m", Dimension::kStiffness, 1},
        UnitCase{"N/mm", Dimension::kStiffness, 1e3}, UnitCase{"N s/m", Dimension::kDamping, 1},
        UnitCase{"Ns/m", Dimension::kDamping, 1}, UnitCase{"N*s/m", Dimension::kDamping, 1},
        UnitCase{"N/A", Dimension::kForceConstant, 1}));

// the example of a refusal is one that is read
TEST(Quantity, ARefusalGivesAnExampleOfItsDimension) {
  const std::string begin = "write it like ";
  for (const Dimension dimension : kAll) {
    const std::string remedy = ParseQuantity("x", dimension, "--x").error().remedy;
    ASSERT_TRUE(remedy.starts_with(begin)) << remedy;
    EXPECT_TRUE(ParseQuantity(remedy.substr(begin.size()), dimension, "--x")) << remedy;
  }
}

TEST(Quantity, AnUncertaintyHasTheLimitsOfItsDimension) {
  for (const char* text : {"31+-1e-9", "31+-1e15", "31(1e-9)"}) {
    EXPECT_TRUE(ParseQuantity(text, Dimension::kResistance, "--x")) << text;
  }
  for (const char* text : {"31+-0.99e-9", "31+-1.01e15", "31(0.99e-9)"}) {
    EXPECT_FALSE(ParseQuantity(text, Dimension::kResistance, "--x")) << text;
  }
}

TEST(Quantity, AnUncertaintyIsBoundedAsItsValueIs) {
  EXPECT_FALSE(ParseQuantity("2.7g+-5e-319g", Dimension::kMass, "--x"));
  EXPECT_FALSE(ParseQuantity("2.7(5e-319)g", Dimension::kMass, "--x"));
  EXPECT_FALSE(ParseQuantity("31+-1e40", Dimension::kResistance, "--x"));
  EXPECT_FALSE(PossibleQuantity({31, 1e-200}, Dimension::kResistance, "--x"));
  EXPECT_TRUE(PossibleQuantity({31, 0}, Dimension::kResistance, "--x"));
}

TEST(Quantity, AnImpossibleMagnitudeIsRefusedWithTheLimits) {
  EXPECT_EQ(ParseQuantity("4e-310mm", Dimension::kLength, "--gap").error().Text(),
            "--gap: '4e-310mm' is outside the possible range of a length; its size is 0, or from "
            "1e-15 to 1000000 m");
}

// what the unit moves out of the range of doubles, below or above
TEST(Quantity, AMagnitudeThatItsUnitMovesBeyondDoublesIsRefused) {
  for (const auto& [text, dimension] :
       {std::pair{"3e-323mm", Dimension::kLength}, std::pair{"-3e-323mm", Dimension::kLength},
        std::pair{"1e306kHz", Dimension::kFrequency}, std::pair{"-1e306kHz", Dimension::kFrequency},
        std::pair{"1e308h", Dimension::kTime}, std::pair{"1g+-3e-323g", Dimension::kMass}}) {
    const auto refused = ParseQuantity(text, dimension, "--x");
    ASSERT_FALSE(refused) << text;
    EXPECT_TRUE(refused.error().what.starts_with(
        fmt::format("'{}' is outside the possible range of ", text)))
        << refused.error().what;
  }
  EXPECT_EQ(ParseQuantity("0mm", Dimension::kLength, "--x").value(), (Quantity{0, 0}));
}

// a comma between two digits, and no other in the text
TEST(Quantity, ADecimalCommaIsNamedAndNoOther) {
  const auto error = [](const char* text) {
    return ParseQuantity(text, Dimension::kTime, "--x").error().Text();
  };
  EXPECT_EQ(error("1,0s"), "--x: '1,0s' has a decimal comma; write a point: 1.0s");
  EXPECT_EQ(error("0,9"), "--x: '0,9' has a decimal comma; write a point: 0.9");
  for (const char* text : {"1,", "1,s", "1,/5", "1,:5", "1;5", "1,5,6", "1.5s,"}) {
    EXPECT_EQ(error(text).find("decimal comma"), std::string::npos) << text;
  }
}

// the bracket counts in units of the last digit, which the exponent moves as it moves the others
TEST(Quantity, ABracketBehindAnExponentCountsInItsLastDigit) {
  const auto expect = [](const char* text, double value, double uncertainty) {
    const auto quantity = ParseQuantity(text, Dimension::kStiffness, "--x");
    ASSERT_TRUE(quantity) << text;
    EXPECT_REL(quantity->value, value, 4e-16, "one rounding");
    EXPECT_REL(quantity->standard_uncertainty, uncertainty, 1e-15, "a power of ten and a product");
  };
  expect("2.75e3(4)", 2750, 40);
  expect("3e2(2)", 300, 200);
  expect("1.25E-2(3)", 0.0125, 3e-4);
}

}  // namespace
}  // namespace haptometer
