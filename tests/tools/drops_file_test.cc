#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tools/fit/drop_records.h"

namespace haptometer::tools {
namespace {

using ::testing::HasSubstr;

const std::string kText = R"toml(
moving_mass_kg = "1.420(10)g"
case_mass_kg = 0.6e-3
resistance_ohm = "26.8ohm+-0.1ohm"
inductance_h = "130uH"

[[drop]]
files = ["open1.csv", "late/open2.csv"]
load_ohm = "open"
case = "held"

[[drop]]
file = "/far/loaded.csv"
load_ohm = "33.0(1)ohm"
case = "free"
drop_height_m = "10mm+-1mm"
rebound = "0.10(5)"
release_current_a = "50.0(5)mA"
added_mass_kg = "0.50(1)g"
voltage_scale = "1.00(2)"
time_scale = "1+-5e-5"
)toml";

TEST(DropsFile, SaysEverythingOfEveryDrop) {
  const auto file = ReadDropsText(kText, "shelf/drops.toml");
  ASSERT_TRUE(file) << file.error().Text();
  EXPECT_DOUBLE_EQ(file->knowns.moving_mass_kg->value, 1.42e-3);
  EXPECT_DOUBLE_EQ(file->knowns.moving_mass_kg->standard_uncertainty, 1e-5);
  EXPECT_TRUE(file->knowns.case_mass_kg->exact());
  EXPECT_DOUBLE_EQ(file->knowns.resistance_ohm->standard_uncertainty, 0.1);
  EXPECT_DOUBLE_EQ(file->knowns.inductance_h->value, 130e-6);
  ASSERT_EQ(file->drops.size(), 3U);
  EXPECT_EQ(file->drops[0].name, "shelf/open1.csv") << "beside the file";
  EXPECT_EQ(file->drops[1].name, "shelf/late/open2.csv");
  EXPECT_EQ(file->drops[2].name, "/far/loaded.csv");
  EXPECT_TRUE(std::isinf(file->drops[1].load_ohm->value));
  EXPECT_EQ(file->drops[1].condition, fit::CaseCondition::kHeld);
  EXPECT_FALSE(file->drops[1].drop_height_m);
  const fit::ImpulseRecord& last = file->drops[2];
  EXPECT_DOUBLE_EQ(last.load_ohm->standard_uncertainty, 0.1);
  EXPECT_EQ(last.condition, fit::CaseCondition::kFree);
  EXPECT_DOUBLE_EQ(last.drop_height_m->standard_uncertainty, 1e-3);
  EXPECT_DOUBLE_EQ(last.rebound->value, 0.1);
  EXPECT_DOUBLE_EQ(last.release_current_a->standard_uncertainty, 5e-4);
  EXPECT_DOUBLE_EQ(last.added_mass_kg->value, 5e-4);
  EXPECT_DOUBLE_EQ(last.voltage_scale->standard_uncertainty, 0.02);
  EXPECT_DOUBLE_EQ(last.time_scale->standard_uncertainty, 5e-5);
}

TEST(DropsFile, AFileInThisDirectoryNamesPlainPaths) {
  const auto file = ReadDropsText("[[drop]]\nfile = 'a.csv'\n", "drops.toml");
  ASSERT_TRUE(file) << file.error().Text();
  EXPECT_EQ(file->drops[0].name, "a.csv") << "as the command line would name it";
}

TEST(DropsFile, MistakesAreNamed) {
  const auto refused = [](const std::string& text, const std::string& what) {
    const auto file = ReadDropsText(text, "d.toml");
    ASSERT_FALSE(file) << text;
    EXPECT_THAT(file.error().Text(), HasSubstr(what));
    EXPECT_NE(file.error().Text().find("; "), std::string::npos) << "no remedy";
  };
  const std::string drop = "[[drop]]\nfile = 'a.csv'\n";
  refused("", "d.toml: names no drop");
  refused("stiffness_n_per_m = 2800\n" + drop, "key stiffness_n_per_m is not known");
  refused("mass_kg = 1.4e-3\n" + drop,
          "key mass_kg is not known; did you mean case_mass_kg or moving_mass_kg?");
  refused("[[drops]]\nfile = 'a.csv'\n", "key drops is not known; did you mean drop?");
  refused(drop + "load = 33\n", "[[drop]] 1: key load is not known; did you mean load_ohm?");
  refused(drop + "moving_mass_kg = 1.4e-3\n", "key moving_mass_kg is not known");
  refused(drop + "load_ohm = 0\n", "load_ohm: '0' is not above 0");
  refused(drop + "load_ohm = '33'\ncase = 'hold'\n", "case");
  refused(drop + "files = ['b.csv']\n", "files: cannot be combined with file");
  refused("[[drop]]\nload_ohm = 33\n", "file: is missing");
  refused("[[drop]]\nfiles = []\n", "file: is missing");
  refused("[[drop]]\nfiles = ['']\n", "files: holds an empty name");
  refused("[[drop]]\nfile = 3\n", "file: is not a text");
  refused(drop + "rebound = 1.5\n", "rebound: '1.5' is not from 0 to 1");
  refused(drop + "time_scale = 1000\n", "time_scale: '1000' is not from 0.5 to 2");
  refused(drop + "drop_height_m = '10g'\n", "'g' is not a unit of a length");
  refused("moving_mass_kg = -1\n" + drop, "moving_mass_kg: '-1' is not from 1e-09 kg to 1000 kg");
  refused("resistance_ohm = 'inf'\n" + drop, "resistance_ohm: 'inf' is not from 0.001 ohm to");
}

TEST(DropsFile, IsKnownByItsName) {
  EXPECT_TRUE(IsDropsFile("shelf/drops.toml"));
  EXPECT_FALSE(IsDropsFile("toml.csv"));
}

}  // namespace
}  // namespace haptometer::tools
