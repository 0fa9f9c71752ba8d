#include "sim/sweep/varied_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "sim/linear/steady_state.h"
#include "sim/scene/scene_file.h"
#include "tests/temporary_files.h"

namespace haptometer::sim {
namespace {

using ::testing::HasSubstr;

const std::string kAdapter = HAPTOMETER_FIXTURES "/lra_adapter.toml";

class VariedSceneFile : public tests::TemporaryFiles {
 protected:
  [[nodiscard]] static VariedScene Opened(const std::string& path,
                                          const std::vector<std::string>& keys) {
    auto scene = VariedScene::ReadFile(path, keys);
    EXPECT_TRUE(scene) << scene.error().Text();
    return *std::move(scene);
  }
};

// every bit: the same scene written by hand
TEST_F(VariedSceneFile, GivesTheSceneThatItsValuesMake) {
  const VariedScene varied =
      Opened(kAdapter, {"drive.frequency_hz", "run.duration_s", "skin.stiffness_n_per_m"});
  const auto scene =
      varied.Read(std::vector{NumberValue(225), NumberValue(0.25), NumberValue(600)});
  ASSERT_TRUE(scene) << scene.error().Text();
  const auto plain = ReadSceneFile(kAdapter);
  ASSERT_TRUE(plain);
  EXPECT_EQ(SolveSteadyState(*scene).skin_rms_m, SolveSteadyState(*plain).skin_rms_m);
  EXPECT_EQ(SolveSteadyState(*scene).phase_rad, SolveSteadyState(*plain).phase_rad);
  EXPECT_EQ(scene->duration_s, 0.25);
  const auto other =
      varied.Read(std::vector{NumberValue(175), NumberValue(0.25), NumberValue(1234.5)});
  ASSERT_TRUE(other);
  EXPECT_EQ(other->drive.frequency_hz, 175);
  EXPECT_EQ(other->skin.stiffness_n_per_m, 1234.5);
}

TEST_F(VariedSceneFile, RefusesAsTheStrictReaderDoesWithoutALine) {
  const VariedScene varied = Opened(kAdapter, {"drive.frequency_hz"});
  const auto scene = varied.Read(std::vector{NumberValue(-1)});
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().where, kAdapter + ": [drive]: frequency_hz");
  EXPECT_EQ(WithoutPath(scene.error(), kAdapter),
            "[drive]: frequency_hz: must be greater than 0; check its sign");
  const auto unknown =
      Opened(kAdapter, {"skin.stifness_n_per_m"}).Read(std::vector{NumberValue(1)});
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().Text(), HasSubstr("did you mean stiffness_n_per_m?"));
}

// a line's number of any length goes with the path, what is no number stays
TEST(WithoutPath, IsWithoutTheLine) {
  const auto text = [](const std::string& where) {
    return WithoutPath({.where = where, .what = "x", .remedy = "y"}, "a.toml");
  };
  EXPECT_EQ(text("a.toml:7: [drive]"), "[drive]: x; y");
  EXPECT_EQ(text("a.toml:123: [drive]"), "[drive]: x; y");
  EXPECT_EQ(text("a.toml: [drive]"), "[drive]: x; y");
  EXPECT_EQ(text("a.toml:b"), ":b: x; y");
  EXPECT_EQ(text("b.toml:7: [drive]"), "b.toml:7: [drive]: x; y");
}

// up to 1 MiB
TEST_F(VariedSceneFile, IsOfFilesUpToItsLimit) {
  const std::string text = "[skin]\na = 1\n#";
  const std::size_t limit = std::size_t{1} << 20U;
  const auto reads = [&](std::size_t bytes) {
    const std::string path =
        File("scene.toml", text + std::string(bytes - text.size() - 1, 'x') + '\n');
    return VariedScene::ReadFile(path, {"skin.a"}).has_value();
  };
  EXPECT_TRUE(reads(limit));
  EXPECT_FALSE(reads(limit + 1));
}

TEST_F(VariedSceneFile, LooksForFilesBesideTheScene) {
  (void)File("soft.toml",
             "moving_mass_kg = 1.4e-3\ncase_mass_kg = 0.6e-3\nstiffness_n_per_m = 1000\n"
             "damping_n_s_per_m = 0.03\nforce_constant_n_per_a = 1\nresistance_ohm = 27\n"
             "inductance_h = 1e-4\n");
  const std::string path =
      File("scene.toml",
           "[skin]\nstiffness_n_per_m = 600\ndamping_n_s_per_m = 0.75\n[drive]\nkind = 'sine'\n"
           "amplitude_v = 5\nfrequency_hz = 225\n");
  const VariedScene varied = Opened(path, {"actuator.file"});
  const auto scene = varied.Read(std::vector{TextValue("soft.toml")});
  ASSERT_TRUE(scene) << scene.error().Text();
  EXPECT_EQ(scene->actuator.stiffness_n_per_m, 1000);
}

TEST_F(VariedSceneFile, HasADigestOfItsContents) {
  const auto digest = [&](const std::string& text, const std::vector<std::string>& further = {}) {
    return Opened(File("scene.toml", text), {"drive.frequency_hz"}).Digest(further);
  };
  const auto plain = digest("[skin]\na = 1\nb = 0.5\n[drive]\nfrequency_hz = 1\n");
  EXPECT_EQ(digest("# said\n[drive]\nfrequency_hz = 2\n[skin]\nb = 5e-1\na = 1\n"), plain);
  EXPECT_NE(digest("[skin]\na = 2\nb = 0.5\n[drive]\nfrequency_hz = 1\n"), plain);
  EXPECT_NE(digest("[skin]\nb = 0.5\n[drive]\nfrequency_hz = 1\n"), plain);
  // files count with their contents
  (void)File("named", "one");
  const std::string naming = "[actuator]\nfile = 'named'\n";
  const auto one = digest(naming);
  const auto further = digest("a = 1\n", {"named"});
  (void)File("named", "two");
  EXPECT_NE(digest(naming), one);
  EXPECT_NE(digest("a = 1\n", {"named"}), further);
}

}  // namespace
}  // namespace haptometer::sim
