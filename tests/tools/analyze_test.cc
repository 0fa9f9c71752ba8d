#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
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
using ::testing::HasSubstr;
using Json = nlohmann::json;

Outcome Analyze(const std::vector<std::string>& words) {
  return Captured(RunAnalyze, "analyze", words);
}

class AnalyzeVerb : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(directory_); }
  void TearDown() override { fs::remove_all(directory_); }

  // 100 um at 225 Hz on 1 mm, in steps of 0.1 um
  std::string Trial(const std::string& name, int rate_hz, double duration_s) const {
    const std::string path = directory_ / name;
    std::ofstream file(path);
    file.precision(9);
    file << "# sampling_s = 0.001\n# averages = 2\ntime_s,displacement_m\n";
    for (int k = 0; k < duration_s * rate_hz; ++k) {
      const double t_s = static_cast<double>(k) / rate_hz;
      const double x_m = 1e-3 + 1e-4 * std::sin(2 * std::numbers::pi * 225 * t_s);
      file << t_s << ',' << std::round(x_m * 1e7) / 1e7 << '\n';
    }
    return path;
  }

  const fs::path directory_ =
      fs::path(::testing::TempDir()) / ("analyze_test_" + std::to_string(::getpid()));
};

TEST_F(AnalyzeVerb, AnswersInMicrometres) {
  const Outcome outcome = Analyze({Trial("a.csv", 10'000, 2)});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("offset          1000 um"));
  EXPECT_THAT(outcome.out, HasSubstr("20-500 Hz, Butterworth of order 6, forward and backward"));
  EXPECT_THAT(outcome.out, HasSubstr("RMS in band     92.99"));
  EXPECT_THAT(outcome.out, HasSubstr("strongest tone  225 Hz"));
  EXPECT_THAT(outcome.out, HasSubstr("131.51 um amplitude"));
  // |cos(pi 225 Hz 1 ms)| for two averages
  EXPECT_THAT(outcome.out,
              HasSubstr("the sensor (2 averages at 1 ms) passes 0.7604 of the tone; divided out"));
  EXPECT_EQ(outcome.err, "");
}

TEST_F(AnalyzeVerb, JsonKeepsItsNames) {
  const Outcome outcome = Analyze({Trial("a.csv", 10'000, 2), "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Json document = Json::parse(outcome.out);
  const Json& trial = document["trials"].at(0);
  EXPECT_EQ(trial["file"], (directory_ / "a.csv").string());
  EXPECT_EQ(trial["answered"], true);
  EXPECT_EQ(trial["reasons"], Json::array());
  EXPECT_REL(trial["sample_rate_hz"].get<double>(), 1e4, 1e-7, "nine printed digits");
  EXPECT_REL(trial["offset_m"].get<double>(), 1e-3, 1e-6, "steps of 0.1 um, 450 periods");
  const double gain = std::cos(std::numbers::pi * 0.225);  // of two averages
  EXPECT_REL(trial["band_rms_m"].get<double>(), 1e-4 / std::numbers::sqrt2 / gain, 2e-5,
             "0.1 um steps");
  EXPECT_REL(trial["band_rms_as_measured_m"].get<double>(), 1e-4 / std::numbers::sqrt2, 2e-5,
             "0.1 um steps");
  EXPECT_REL(trial["band_rms_whole_m"].get<double>(), 1e-4 / std::numbers::sqrt2, 0.02, "ends");
  EXPECT_GT(trial["band_rms_standard_uncertainty_m"].get<double>(), 0);
  EXPECT_REL(trial["tone_frequency_hz"].get<double>(), 225.0, 1e-7, "0.1 um steps");
  EXPECT_REL(trial["tone_amplitude_m"].get<double>(), 1e-4 / gain, 2e-5, "0.1 um steps");
  EXPECT_REL(trial["sensor_gain_at_tone"].get<double>(), std::cos(std::numbers::pi * 0.225), 1e-6,
             "the tone's frequency");
  EXPECT_TRUE(trial.contains("noise_rms_m") && trial["noise_rms_m"].is_null());
  EXPECT_LT(trial["window_s"].at(0).get<double>(), trial["window_s"].at(1).get<double>());
}

TEST_F(AnalyzeVerb, OfSeveralFilesTheOthersAreAnswered) {
  const std::string missing = directory_ / "missing.csv";
  const Outcome outcome =
      Analyze({missing, Trial("slow.csv", 48, 3), Trial("good.csv", 10'000, 2), "--json"});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.err, HasSubstr(missing));
  const Json trials = Json::parse(outcome.out)["trials"];
  ASSERT_EQ(trials.size(), 3U);
  EXPECT_EQ(trials[0]["answered"], false);
  EXPECT_THAT(trials[0]["reasons"].at(0).get<std::string>(), HasSubstr("check the path"));
  // the slow one: what can be known, and nothing that looks like the band
  EXPECT_EQ(trials[1]["answered"], false);
  EXPECT_REL(trials[1]["sample_rate_hz"].get<double>(), 48.0, 1e-6, "nine printed digits");
  EXPECT_GT(trials[1]["peak_to_peak_m"].get<double>(), 0);
  for (const char* key : {"band_rms_m", "band_rms_whole_m", "residual_rms_m", "window_s",
                          "tone_frequency_hz", "tone_amplitude_m"}) {
    EXPECT_TRUE(trials[1][key].is_null()) << key;
  }
  EXPECT_EQ(trials[2]["answered"], true);
  // every trial has the same keys
  for (const auto& [key, value] : trials[2].items()) {
    EXPECT_TRUE(trials[0].contains(key) && trials[1].contains(key)) << key;
  }
}

TEST_F(AnalyzeVerb, TooSlowIsSaidInWords) {
  const Outcome outcome = Analyze({Trial("slow.csv", 48, 3)});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.out, HasSubstr("not answered    48 new readings/s show vibration up to"));
  EXPECT_THAT(outcome.out, HasSubstr("observable      up to 18.75 Hz"));
  EXPECT_THAT(outcome.out, ::testing::Not(HasSubstr("RMS")));
}

TEST_F(AnalyzeVerb, TheBandMayBeChosen) {
  const std::string path = Trial("a.csv", 10'000, 2);
  for (const char* band : {"100-400Hz", "0.1-0.4kHz", "100Hz-0.4kHz", "100-400"}) {
    const Outcome outcome =
        Analyze({path, "--band", band, "--order", "3", "--corner", "each", "--json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const Json used = Json::parse(outcome.out)["trials"].at(0)["band"];
    EXPECT_REL(used["lower_hz"].get<double>(), 100.0, 2e-16, "one rounding");
    EXPECT_REL(used["upper_hz"].get<double>(), 400.0, 2e-16, "one rounding");
    EXPECT_EQ(used["order"], 3);
    EXPECT_EQ(used["corner"], "each");
  }
}

TEST_F(AnalyzeVerb, WrongOptionsAreRefused) {
  const std::string path = Trial("a.csv", 10'000, 0.01);
  EXPECT_THAT(Analyze({path, "--band", "20Hz"}).err,
              HasSubstr("--band: '20Hz' is not a band; write it as 20-500Hz"));
  EXPECT_THAT(Analyze({path, "--band", "500-20Hz"}).err, HasSubstr("500-20 Hz is not a band"));
  for (const char* band : {"20Hz", "500-20Hz", "20mm-500mm", "-20-500Hz", ""}) {
    EXPECT_EQ(Analyze({path, "--band", band}).status, 2) << band;
  }
  EXPECT_EQ(Analyze({path, "--order", "9"}).status, 2);
  EXPECT_EQ(Analyze({path, "--corner", "both"}).status, 2);
  EXPECT_EQ(Analyze({path, "--plot", "a.gif"}).status, 2);
  EXPECT_THAT(Analyze({path, path, "--plot", "a.svg"}).err, HasSubstr("draws one trial, not 2"));
}

TEST_F(AnalyzeVerb, DrawsAnsweredAndUnansweredTrials) {
  const std::string picture = directory_ / "a.svg";
  EXPECT_EQ(Analyze({Trial("a.csv", 10'000, 2), "--plot", picture}).status, 0);
  const auto size = fs::file_size(picture);
  EXPECT_EQ(Analyze({Trial("slow.csv", 48, 3), "--plot", picture}).status, 3);
  EXPECT_LT(fs::file_size(picture), size) << "one panel instead of three";
}

}  // namespace
}  // namespace haptometer::tools
