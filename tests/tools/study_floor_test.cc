#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "tests/residual.h"
#include "tests/tools/captured.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

constexpr double kTreatedM = 8e-6;
constexpr double kPi = std::numbers::pi;

Outcome Study(const std::vector<std::string>& words) { return Captured(RunStudy, "study", words); }

// trials of 4 um, and 8 or 16 um, at 225 Hz with 1 um of "noise", a tone at 110 Hz, under each of
// them
class StudyFloor : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(trials_);
    for (int subject = 1; subject <= 2; ++subject) {
      Write(trials_ / fmt::format("s{}_a.csv", subject), 1e-6, kTreatedM / 2);
      Write(trials_ / fmt::format("s{}_b.csv", subject), 1e-6, subject * kTreatedM);
    }
  }
  void TearDown() override { fs::remove_all(directory_); }

  static std::string Write(const fs::path& path, double quiet_m, double drive_m,
                           int rate_hz = 5000) {
    std::ofstream file(path);
    file.precision(12);
    file << "# sampling_s = 0.0002\n# averages = 1\ntime_s,displacement_m\n";
    for (int k = 0; k < 2 * rate_hz; ++k) {
      const double t_s = static_cast<double>(k) / rate_hz;
      file << t_s << ','
           << 1e-3 + quiet_m * std::sin(2 * kPi * 110 * t_s) +
                  drive_m * std::sin(2 * kPi * 225 * t_s)
           << '\n';
    }
    return path;
  }

  // one second with the drive off, and two with it on
  static void WriteWithSilence(const fs::path& path) {
    std::ofstream file(path);
    file.precision(12);
    file << "# sampling_s = 0.0002\n# averages = 1\ntime_s,displacement_m\n";
    for (int k = 0; k < 15'000; ++k) {
      const double t_s = k / 5e3;
      const double drive_m = t_s < 1 ? 0 : kTreatedM;
      file << t_s << ',' << 1e-3 + 1e-8 * (k * 7919 % 101) + drive_m * std::sin(2 * kPi * 225 * t_s)
           << '\n';
    }
  }

  [[nodiscard]] std::vector<std::string> Words(const std::vector<std::string>& more) const {
    std::vector<std::string> words{trials_, "--pattern", "s{subject}_{condition}"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }

  const fs::path directory_ =
      fs::path(::testing::TempDir()) / ("study_floor_test_" + std::to_string(::getpid()));
  const fs::path trials_ = directory_ / "trials";
};

TEST_F(StudyFloor, IsTakenOffEveryTrialAndIsNone) {
  const std::string floor = Write(trials_ / "off.csv", 1e-6, 0);
  const Outcome outcome = Study(Words({"--floor", floor, "--json"}));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Json study = Json::parse(outcome.out);
  EXPECT_EQ(study["floor"]["file"], floor);
  EXPECT_REL(study["floor"]["rms_m"].get<double>(), 1e-6 / std::numbers::sqrt2, 1e-3,
             "settled ends, not whole periods of 110 Hz");
  ASSERT_EQ(study["trials"].size(), 4U) << "the floor lies in the folder and is no trial";
  for (const Json& trial : study["trials"]) {
    const double times = trial["condition"] == "a" ? 0.5 : trial["subject"] == "1" ? 1 : 2;
    EXPECT_REL(trial["band_rms_m"].get<double>(), times * kTreatedM / std::numbers::sqrt2, 2e-3,
               "the same");
  }
}

TEST_F(StudyFloor, IsSaidInTextAndMethodsWithWhatIsDoubtful) {
  const std::string floor = Write(directory_ / "off.csv", 1e-6, 0);
  const fs::path methods = directory_ / "methods.md";
  const Outcome outcome = Study(Words({"--floor", floor, "--methods", methods}));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("noise correction +0.71[(0-9.)]* um, RMS of " + floor +
                                         ", subtracted in mean square"));
  EXPECT_THAT(outcome.out, HasSubstr("holds a tone, 1 um at 110 Hz"));
  EXPECT_THAT(outcome.out, Not(HasSubstr("not corrected for noise")));
  std::ifstream file(methods);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_THAT(text, HasSubstr("was the noise of a drive-off trial (0.707 um RMS in the band"));
  EXPECT_THAT(text, HasSubstr("Uncertainties exclude the sensor's calibration and linearity"));
}

TEST_F(StudyFloor, OfEachTrialIsNamedByItsSource) {
  const fs::path methods = directory_ / "methods.md";
  const auto said = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"--methods", methods, "--overwrite"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = Study(Words(words));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    std::ifstream file(methods);
    return std::string{std::istreambuf_iterator<char>(file), {}};
  };
  // the drive is on throughout: no trial has a quiet part
  EXPECT_THAT(said({}), HasSubstr("Subtracted in mean square was the noise in the spectrum beside "
                                  "the drive in 4 trials. "));
  // one with a second of silence
  WriteWithSilence(trials_ / "s2_b.csv");
  EXPECT_THAT(said({}), HasSubstr("was the noise of the trial's own quiet part in 1 trial, and the "
                                  "noise in the spectrum beside the drive in 3 trials. "));
  const std::string floor = Write(directory_ / "off.csv", 1e-6, 0);
  EXPECT_THAT(said({"--floor", floor}), HasSubstr(floor + ") in 4 trials. "));
}

TEST_F(StudyFloor, MayStandInTheManifestAndTheOptionBeatsIt) {
  Write(directory_ / "off.csv", 1e-6, 0);
  const fs::path manifest = directory_ / "study.toml";
  std::ofstream(manifest) << "floor = \"off.csv\"\npattern = \"s{subject}_{condition}\"\n"
                             "[[trials]]\nfiles = \"trials/*.csv\"\n";
  const Json study = Json::parse(Study({manifest, "--json"}).out);
  EXPECT_EQ(study["floor"]["file"], (directory_ / "off.csv").string());
  const std::string smaller = Write(directory_ / "smaller.csv", 0.5e-6, 0);
  const Json other = Json::parse(Study({manifest, "--json", "--floor", smaller}).out);
  EXPECT_EQ(other["floor"]["file"], smaller);
  EXPECT_GT(other["trials"][0]["band_rms_m"].get<double>(),
            study["trials"][0]["band_rms_m"].get<double>());
}

TEST_F(StudyFloor, ThatCannotServeIsRefused) {
  const Outcome missing = Study(Words({"--floor", directory_ / "none.csv"}));
  EXPECT_EQ(missing.status, 3);
  EXPECT_THAT(missing.err, HasSubstr("none.csv: no such file"));
  const Outcome slow = Study(Words({"--floor", Write(directory_ / "slow.csv", 1e-6, 0, 400)}));
  EXPECT_EQ(slow.status, 3);
  EXPECT_THAT(slow.err, HasSubstr("slow.csv: "));
  fs::remove_all(trials_);
  fs::create_directories(trials_);
  const Outcome alone = Study(Words({"--floor", Write(trials_ / "off.csv", 1e-6, 0)}));
  EXPECT_EQ(alone.status, 3);
  EXPECT_THAT(alone.err, HasSubstr("holds no recording but the floor"));
}

}  // namespace
}  // namespace haptometer::tools
