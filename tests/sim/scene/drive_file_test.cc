#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "sim/scene/scene_file.h"

namespace haptometer::sim {
namespace {

namespace fs = std::filesystem;

const std::string kBodies =
    "[actuator]\nmodel = 'thesis-c10-100'\n"
    "[skin]\nstiffness_n_per_m = 600\ndamping_n_s_per_m = 0.75\n";

Scene Read(const std::string& drive) {
  const auto scene = ReadSceneText(kBodies + drive, "scene.toml");
  EXPECT_TRUE(scene) << scene.error().Text();
  return scene.value_or(Scene{});
}

// lines count from the whole scene's: [drive] is the sixth
std::string ErrorOf(const std::string& drive) {
  const auto scene = ReadSceneText(kBodies + drive, "scene.toml");
  if (scene) return "none";
  EXPECT_EQ(scene.error().cause, Cause::kUsage);
  return scene.error().Text();
}

TEST(DriveFile, ReadsASine) {
  const Drive drive = Read(
                          "[drive]\nkind = 'sine'\namplitude_v = 5\nfrequency_hz = '0.2kHz'\n"
                          "source_resistance_ohm = 3\n")
                          .drive;
  EXPECT_EQ(drive.kind, DriveKind::kSine);
  EXPECT_EQ(drive.amplitude_v, 5);
  EXPECT_EQ(drive.frequency_hz, 200);
  EXPECT_EQ(drive.source_resistance_ohm, 3);
}

TEST(DriveFile, ReadsTones) {
  const Drive drive =
      Read(
          "[drive]\nkind = 'tones'\n[[drive.tone]]\namplitude_v = 1\nfrequency_hz = 40\n"
          "[[drive.tone]]\namplitude_v = '500mV'\nfrequency_hz = 225\nphase_rad = -1.5\n")
          .drive;
  EXPECT_EQ(drive.kind, DriveKind::kTones);
  ASSERT_EQ(drive.tones.size(), 2U);
  EXPECT_EQ(drive.tones[0].amplitude, 1);
  EXPECT_EQ(drive.tones[0].phase_rad, 0);
  EXPECT_EQ(drive.tones[1].amplitude, 0.5);
  EXPECT_EQ(drive.tones[1].frequency_hz, 225);
  EXPECT_EQ(drive.tones[1].phase_rad, -1.5);
  EXPECT_EQ(HighestFrequencyHz(drive), 225);
  EXPECT_EQ(LargestVoltageV(drive), 1.5);
  EXPECT_TRUE(IsLasting(drive));
}

TEST(DriveFile, ReadsABurst) {
  const Drive drive =
      Read(
          "[drive]\nkind = 'burst'\namplitude_v = 5\nfrequency_hz = 175\nstart_s = '5ms'\n"
          "rise_s = '10ms'\nhold_s = 0.1\nfall_s = 0.02\n")
          .drive;
  EXPECT_EQ(drive.kind, DriveKind::kBurst);
  EXPECT_EQ(drive.start_s, 0.005);
  EXPECT_EQ(drive.rise_s, 0.01);
  EXPECT_EQ(drive.hold_s, 0.1);
  EXPECT_EQ(drive.fall_s, 0.02);
  EXPECT_DOUBLE_EQ(EndOfDriveS(drive), 0.135);
  EXPECT_FALSE(IsLasting(drive));
}

// any of its three parts alone makes a burst
TEST(DriveFile, ReadsABurstOfOnePart) {
  for (const std::string part : {"rise_s", "hold_s", "fall_s"}) {
    const Scene scene =
        Read("[drive]\nkind = 'burst'\namplitude_v = 5\nfrequency_hz = 175\n" + part + " = 0.25\n");
    EXPECT_EQ(EndOfDriveS(scene.drive), 0.25) << part;
  }
}

TEST(DriveFile, ReadsAChirpUpAndDown) {
  const Drive drive =
      Read(
          "[drive]\nkind = 'chirp'\namplitude_v = 2\nfrequency_hz = 400\nend_frequency_hz = 50\n"
          "duration_s = 0.5\nhold_tolerance = 1e-6\nstart_s = 1e-3\n")
          .drive;
  EXPECT_EQ(drive.kind, DriveKind::kChirp);
  EXPECT_EQ(drive.end_frequency_hz, 50);
  EXPECT_EQ(drive.duration_s, 0.5);
  EXPECT_EQ(drive.hold_tolerance, 1e-6);
  EXPECT_EQ(HighestFrequencyHz(drive), 400);
  EXPECT_EQ(EndOfDriveS(drive), 0.501);
}

TEST(DriveFile, ReadsAPulseOfEitherSign) {
  const Drive drive = Read("[drive]\nkind = 'pulse'\namplitude_v = -3\nhold_s = '2ms'\n").drive;
  EXPECT_EQ(drive.kind, DriveKind::kPulse);
  EXPECT_EQ(drive.amplitude_v, -3);
  EXPECT_EQ(drive.hold_s, 0.002);
  EXPECT_EQ(HighestFrequencyHz(drive), 0);
  EXPECT_EQ(LargestVoltageV(drive), 3);
}

// each fault with its line, its key and what is allowed
TEST(DriveFile, TellsEachFault) {
  const std::string sine = "[drive]\nkind = 'sine'\namplitude_v = 5\nfrequency_hz = 225\n";
  const std::string burst = "[drive]\nkind = 'burst'\namplitude_v = 5\nfrequency_hz = 225\n";
  const std::string chirp = "[drive]\nkind = 'chirp'\namplitude_v = 5\nfrequency_hz = 50\n";
  const std::string tones = "[drive]\nkind = 'tones'\n[[drive.tone]]\n";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"[drive]\nkind = 'square'\n",
       "scene.toml:7: [drive]: kind: \"square\" is not known; use one of sine, tones, burst, "
       "chirp, "
       "pulse, samples"},
      {"[drive]\nfrequency_hz = 3\n",
       "scene.toml:6: [drive]: kind: is missing; write kind = \"sine\""},
      {"[drive]\nkind = 3\n", "scene.toml:7: [drive]: kind: is not a text; put it in quotes"},
      {sine + "hold_s = 1\n",
       "scene.toml:10: [drive]: hold_s: belongs to kind = \"burst\" or \"pulse\", and kind is "
       "\"sine\"; remove it, or change kind"},
      {sine + "phase_rad = 1\n", "scene.toml:10: [drive]: phase_rad: belongs to kind = \"tones\""},
      {sine + "source_resistance_ohm = -1\n",
       "scene.toml:10: [drive]: source_resistance_ohm: must not be negative; check its sign"},
      {"[drive]\nkind = 'sine'\namplitude_v = -5\nfrequency_hz = 225\n",
       "scene.toml:8: [drive]: amplitude_v: must not be negative; check its sign"},
      {"[drive]\nkind = 'tones'\n[drive.tone]\namplitude_v = 1\n",
       "scene.toml:8: [drive]: tone: is not a list of tables; write [[drive.tone]]"},
      {sine + "end_frequency_hz = 400\n",
       "scene.toml:10: [drive]: end_frequency_hz: belongs to kind = \"chirp\""},
      {sine + "[mounting]\nkind = 'free'\nstiffness_n_per_m = 100\n",
       "scene.toml:12: [mounting]: stiffness_n_per_m: belongs to kind = \"grip\""},
      {"[drive]\nkind = 'tones'\n",
       "scene.toml:6: [drive]: tone: is missing; give one or more [[drive.tone]]"},
      {"[drive]\nkind = 'tones'\nfrequency_hz = 5\n[[drive.tone]]\namplitude_v = 1\n"
       "frequency_hz = 4\n",
       "scene.toml:8: [drive]: frequency_hz: belongs to kind = \"sine\""},
      {tones + "amplitude_v = 1\nfrequency_hz = 0\n",
       "scene.toml:10: [drive]: [[tone]] 1: frequency_hz: must be greater than 0; check its sign"},
      {tones + "frequency_hz = 3\n",
       "scene.toml:8: [drive]: [[tone]] 1: amplitude_v: is missing; add it, in V or with a unit"},
      {burst,
       "scene.toml:6: [drive]: hold_s: leaves a burst of no length; give rise_s, hold_s or "
       "fall_s"},
      {burst + "hold_s = -1\n",
       "scene.toml:10: [drive]: hold_s: must not be negative; check its sign"},
      {burst + "hold_s = 1\nduration_s = 1\n",
       "scene.toml:11: [drive]: duration_s: belongs to kind = \"chirp\""},
      {chirp + "duration_s = 1\n",
       "scene.toml:6: [drive]: end_frequency_hz: is missing; add it, in Hz or with a unit"},
      {chirp + "end_frequency_hz = 60\n",
       "scene.toml:6: [drive]: duration_s: is missing; add it, in s or with a unit"},
      {chirp + "end_frequency_hz = 60\nduration_s = 1\nhold_tolerance = 1\n",
       "scene.toml:12: [drive]: hold_tolerance: is not 1e-13 to 0.1; it is relative to "
       "amplitude_v"},
      {chirp + "end_frequency_hz = 1e6\nduration_s = 1000\n",
       "scene.toml:11: [drive]: duration_s: takes 1.4e+11 cubics at this hold_tolerance; shorten "
       "it to 0.0705 s, or increase hold_tolerance"},
      {"[drive]\nkind = 'pulse'\namplitude_v = 3\n",
       "scene.toml:6: [drive]: hold_s: is missing; add it, in s or with a unit"},
      {"[drive]\nkind = 'pulse'\namplitude_v = 3\nhold_s = 0\n",
       "scene.toml:9: [drive]: hold_s: must be greater than 0; check its sign"},
      {"[drive]\nkind = 'pulse'\nhold_s = 1\n",
       "scene.toml:6: [drive]: amplitude_v: is missing; add it, in V"},
      {chirp + "end_frequency_hz = 60\nduration_s = 0\n",
       "scene.toml:11: [drive]: duration_s: must be greater than 0; check its sign"},
      {chirp + "end_frequency_hz = -60\nduration_s = 1\n",
       "scene.toml:10: [drive]: end_frequency_hz: must be greater than 0; check its sign"},
      {"[drive]\nkind = 'samples'\nrate_hz = 1000\n",
       "scene.toml:6: [drive]: file: is missing; a file of voltages, one a line under voltage_v"},
      {"[drive]\nkind = 'samples'\nfile = 'v.csv'\n",
       "scene.toml:8: [drive]: file: v.csv: no such file; check the path"},
      {burst + "hold_s = 1\n[run]\nstart = 'steady'\n",
       "scene.toml:12: [run]: start: \"steady\" applies to continuous drives, and kind = \"burst\" "
       "ends; write start = \"rest\""}};
  for (const auto& [text, message] : cases) {
    EXPECT_EQ(ErrorOf(text).substr(0, message.size()), message) << text;
  }
}

class SamplesFile : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(directory_); }
  void TearDown() override { fs::remove_all(directory_); }
  // a scene beside a file of voltages with this content
  Result<Scene> With(const std::string& content) const {
    std::ofstream(directory_ / "v.csv") << content;
    std::ofstream(directory_ / "scene.toml")
        << kBodies << "[drive]\nkind = 'samples'\nrate_hz = 8000\nfile = 'v.csv'\n";
    return ReadSceneFile(directory_ / "scene.toml");
  }
  const fs::path directory_ =
      fs::path(::testing::TempDir()) / ("drive_file_test_" + std::to_string(::getpid()));
};

TEST_F(SamplesFile, IsReadFromBesideTheScene) {
  for (const char* content :
       {"voltage_v\n0\n1.5\n-2e-1\n+0.25\n", "voltage_v\r\n0\r\n1.5\r\n-2e-1 \r\n0.25",
        "\xef\xbb\xbfvoltage_v\n0\n 1.5\n\t-0.2\n0.25\n\n",
        " voltage_v \n \t0 \n\t1.5\t\r\n  -0.2 \n +0.25 \n"}) {
    const auto scene = With(content);
    ASSERT_TRUE(scene) << scene.error().Text();
    ASSERT_TRUE(scene->drive.samples);
    EXPECT_EQ(scene->drive.samples->rate_hz, 8000);
    EXPECT_EQ(scene->drive.samples->voltages_v, (std::vector<double>{0, 1.5, -0.2, 0.25}));
    EXPECT_EQ(EndOfDriveS(scene->drive), 3.0 / 8000);
    EXPECT_EQ(LargestVoltageV(scene->drive), 1.5);
  }
}

TEST_F(SamplesFile, TellsItsOwnLines) {
  const std::string file = (directory_ / "v.csv").string();
  const std::string head = (directory_ / "scene.toml").string() + ":9: [drive]: file: " + file;
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"0\n1\n", ":1: is not the column's name voltage_v; begin the file with it"},
      {"voltage\n0\n", ":1: is not the column's name voltage_v; begin the file with it"},
      {"voltage_v_rms\n0\n1\n", ":1: is not the column's name voltage_v; begin the file with it"},
      {"voltage_v\n0\nx\n", ":3: \"x\" is not a voltage; write a number of volts, up to 1e+09"},
      {"voltage_v\n0\n\n1\n", ":3: \"\" is not a voltage; write a number of volts, up to 1e+09"},
      {"voltage_v\n0\n1,5\n", ":3: \"1,5\" is not a voltage; write a number of volts, up to 1e+09"},
      {"voltage_v\n0\n1e10\n",
       ":3: \"1e10\" is not a voltage; write a number of volts, up to 1e+09"},
      {"voltage_v\n0\nnan\n", ":3: \"nan\" is not a voltage; write a number of volts, up to 1e+09"},
      {"voltage_v\n0\n+-5\n", ":3: \"+-5\" is not a voltage; write a number of volts, up to 1e+09"},
      {"voltage_v\n0\n5V\n", ":3: \"5V\" is not a voltage; write a number of volts, up to 1e+09"},
      {"voltage_v\n1\n", ": has fewer than two voltages; give one a line"}};
  for (const auto& [content, message] : cases) {
    const auto scene = With(content);
    ASSERT_FALSE(scene) << content;
    EXPECT_EQ(scene.error().Text(), head + message) << content;
    EXPECT_EQ(scene.error().cause, Cause::kUsage);
  }
}

TEST_F(SamplesFile, ThatIsNotThereIsTold) {
  With("voltage_v\n0\n1\n").value();
  fs::remove(directory_ / "v.csv");
  const auto scene = ReadSceneFile(directory_ / "scene.toml");
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().Text().find("v.csv: no such file"), std::string::npos)
      << scene.error().Text();
}

// a sine as a chirp: error h^4 / 384 w^4 of cubics h apart, so w T (384 tolerance)^(-1/4) of them
TEST(DriveFile, RefusesAChirpOfMoreThanTenMillionCubics) {
  constexpr double kTolerance = 1e-12, kDurationS = 0.5;
  const auto error_of = [&](double cubics) {
    const double w = cubics * std::pow(384 * kTolerance, 0.25) / kDurationS;
    const std::string hertz = fmt::format("{:.17g}", w / (2 * std::numbers::pi));
    return ErrorOf("[drive]\nkind = 'chirp'\namplitude_v = 5\nfrequency_hz = " + hertz +
                   "\nend_frequency_hz = " + hertz +
                   "\nduration_s = 0.5\nhold_tolerance = 1e-12\n");
  };
  EXPECT_EQ(error_of(0.999e7), "none");
  EXPECT_NE(error_of(1.001e7).find("duration_s: takes 1e+07 cubics"), std::string::npos);
  EXPECT_NE(error_of(2e7).find("shorten it to 0.25 s"), std::string::npos) << error_of(2e7);
}

TEST(DriveFile, TakesHoldTolerancesUpToTheirEnds) {
  const auto reads = [](const std::string& tolerance) {
    return ErrorOf(
               "[drive]\nkind = 'chirp'\namplitude_v = 5\nfrequency_hz = 50\n"
               "end_frequency_hz = 60\nduration_s = 0.1\nhold_tolerance = " +
               tolerance + "\n") == "none";
  };
  EXPECT_TRUE(reads("1e-13") && reads("0.1"));
  EXPECT_FALSE(reads("0.99e-13"));
  EXPECT_FALSE(reads("0.101"));
}

// a case that falls from h comes down with sqrt(2 g h)
TEST(DriveFile, ReadsWhatHoldsTheCase) {
  const std::string sine = "[drive]\nkind = 'sine'\namplitude_v = 5\nfrequency_hz = 225\n";
  const Scene drop = Read(sine + "[mounting]\nkind = 'drop'\nheight_m = '50mm'\n");
  EXPECT_TRUE(drop.grip.holds);
  EXPECT_DOUBLE_EQ(drop.initial.mover_m_per_s, std::sqrt(2 * 9.80665 * 0.05));
  const Scene started =
      Read(sine + "[mounting]\nkind = 'drop'\nheight_m = '50mm'\n[start]\nmover_m_per_s = 0.25\n");
  EXPECT_DOUBLE_EQ(started.initial.mover_m_per_s, std::sqrt(2 * 9.80665 * 0.05) + 0.25);
  const Scene held = Read(sine + "[mounting]\nkind = 'held'\n");
  EXPECT_TRUE(held.grip.holds);
  EXPECT_EQ(held.initial.mover_m_per_s, 0);
  const Scene gripped =
      Read(sine + "[mounting]\nkind = 'grip'\nstiffness_n_per_m = 300\ndamping_n_s_per_m = 0.2\n");
  EXPECT_FALSE(gripped.grip.holds);
  EXPECT_EQ(gripped.grip.stiffness_n_per_m, 300);
  EXPECT_EQ(gripped.grip.damping_n_s_per_m, 0.2);
  EXPECT_FALSE(Read(sine + "[mounting]\nkind = 'free'\n").grip.holds);
}

TEST_F(SamplesFile, TakesVoltagesUpToTheirEnds) {
  const auto scene = With("voltage_v\n1e9\n-1e9\n");
  ASSERT_TRUE(scene) << scene.error().Text();
  EXPECT_EQ(scene->drive.samples->voltages_v, (std::vector<double>{1e9, -1e9}));
  EXPECT_FALSE(With("voltage_v\n0\n1.001e9\n"));
  EXPECT_FALSE(With("voltage_v\n0\n-1.001e9\n"));
}

}  // namespace
}  // namespace haptometer::sim
