#include "base/typeset.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace haptometer {
namespace {

constexpr const char* kBlank = "\u00a0";

TEST(Typeset, UnitsHaveTheirSignsAndStayWithTheirNumbers) {
  const std::string blank = kBlank;
  for (const auto& [plain, set] :
       {std::pair<std::string, std::string>{"12.3(4) um", "12.3(4)" + blank + "µm"},
        {"RMS / um", "RMS / µm"},
        {"10 um/V; 95 %: 9 to 11 um/V",
         "10" + blank + "µm/V; 95" + blank + "%: 9 to 11" + blank + "µm/V"},
        {"density / (um^2/Hz)", "density / (µm²/Hz)"},
        {"area / mm2", "area / mm²"},
        {"acceleration / m/s^2", "acceleration / m/s²"},
        {"R^2", "R²"},
        {"Km^2 over mass", "Km² over mass"},
        {"23.0 1/s^2; 95 %: 22 to 24 1/s^2", "23.0 1/s²; 95" + blank + "%: 22 to 24 1/s²"},
        {"It is 12 um. Then 3 s. A rest of 5 mm.",
         "It is 12" + blank + "µm. Then 3" + blank + "s. A rest of 5" + blank + "mm."},
        {"R^3 of x^2.", "R³ of x²."},
        {"(4) um/(2 s)", "(4)" + blank + "µm/(2" + blank + "s)"},
        {"130 uH, 27 ohm", "130" + blank + "µH, 27" + blank + "Ω"},
        {"225 Hz +- 1 Hz", "225" + blank + "Hz ± 1" + blank + "Hz"}}) {
    EXPECT_EQ(Typeset(plain), set);
    EXPECT_EQ(Typeset(set), set) << "once is enough";
  }
}

TEST(Typeset, EveryUnitStaysWithItsNumber) {
  const std::string three = std::string("3") + kBlank;
  for (const char* unit : {"mm", "ms", "mV", "mA", "mW", "mH", "Hz", "kHz", "kg", "rad", "dB",
                           "VA", "m",  "s",  "g",  "V",  "A",  "N",  "W",   "H",  "K",   "%"}) {
    EXPECT_EQ(Typeset(std::string("3 ") + unit), three + unit);
  }
  EXPECT_EQ(Typeset("3 us"), three + "µs");
  EXPECT_EQ(Typeset("3 uH"), three + "µH");
  EXPECT_EQ(Typeset("3 mm^3"), three + "mm³");
  EXPECT_EQ(Typeset("3 m3"), three + "m³");
}

TEST(Typeset, OtherWordsStayAsTheyAre) {
  for (const char* text : {"",           "um",          "12 um.csv",   "4 subjects",
                           "16 trials",  "um umbrella", "3 umbrellas", "a um",
                           "day1/m.csv", "/home/um/x",  "x/y",         "5 gaps",
                           "2 Hz_x",     "2^4 choices", "run^2.csv",   "a^25",
                           "a^2b",       "2^2 choices", "R^4",         "R^",
                           "^2",         "x (um)",      "12 um.5",     "12 mm4"}) {
    EXPECT_EQ(Typeset(text), text);
  }
}

}  // namespace
}  // namespace haptometer
