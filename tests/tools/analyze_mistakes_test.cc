// What `analyze` says to the mistakes that are made on a first day.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "tests/tools/captured.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

double Sine(double frequency_hz, double t_s) {
  return std::sin(2 * std::numbers::pi * frequency_hz * t_s);
}

class AnalyzeMistakes : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(directory_); }
  void TearDown() override { fs::remove_all(directory_); }

  // 3 s of x(t) in um about 30 mm, in steps of 10 nm
  std::string Write(const std::string& name, double rate_hz,
                    const std::function<double(double)>& x_um,
                    const std::string& header = "time_s,displacement_m") const {
    std::string text = header + "\n";
    for (int k = 0; k < 3 * rate_hz; ++k) {
      fmt::format_to(std::back_inserter(text), "{:.6f},{:.8f}\n", k / rate_hz,
                     0.03 + 1e-6 * x_um(k / rate_hz));
    }
    std::ofstream(directory_ / name) << text;
    return directory_ / name;
  }

  [[nodiscard]] std::string Burst() const {
    return Write("burst.csv", 4000,
                 [](double t_s) { return t_s > 1 && t_s < 2 ? 20 * Sine(225, t_s) : 0; });
  }

  // 10 um at 225 Hz throughout
  [[nodiscard]] std::string Steady() const {
    return Write("steady.csv", 4000, [](double t_s) { return 10 * Sine(225, t_s); });
  }

  static Outcome Analyze(const std::vector<std::string>& words) {
    return Captured(RunAnalyze, "analyze", words);
  }

  const fs::path directory_ =
      fs::path(::testing::TempDir()) / ("analyze_mistakes_test_" + std::to_string(::getpid()));
};

TEST_F(AnalyzeMistakes, TheTransientsOfADriveOutsideOfTheBandAreNoDrive) {
  const Outcome outcome = Analyze({"--band", "300-500Hz", Burst()});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.out, Not(HasSubstr("vibration (RMS)")));
  EXPECT_THAT(outcome.out, HasSubstr("estimate (RMS), no answer"));
}

TEST_F(AnalyzeMistakes, AWindowAcrossAnOnsetMixes) {
  const std::string burst = Burst();
  EXPECT_THAT(
      Analyze({"--window", "0.5s:1.5s", burst}).out,
      ContainsRegex("in (0.5|4|5)[0-9.]* m?s of the window's .* the drive is off or changes"));
  EXPECT_THAT(Analyze({"--window", "1.1s:1.9s", burst}).out,
              Not(HasSubstr("the drive is off or changes")));
  EXPECT_THAT(Analyze({"--window", "0.3s:0.7s", burst}).out,
              HasSubstr("the drive is off in the whole window"));
}

TEST_F(AnalyzeMistakes, AFloorOfAnotherRateOrWithAToneIsNamed) {
  const auto tone = [](double t_s) { return 20 * Sine(225, t_s); };
  const std::string trial = Write("trial.csv", 4000, tone);
  const auto hum = [](double t_s) { return 3 * Sine(100, t_s); };
  EXPECT_THAT(Analyze({"--floor", Write("hum.csv", 4000, hum), trial}).out,
              HasSubstr("holds a tone, 2.998 um at 100 Hz: it is subtracted as noise"));
  EXPECT_THAT(Analyze({"--floor", Write("other.csv", 2000, hum), trial}).out,
              HasSubstr("the floor has 2000 readings/s and this trial 4000"));
  const Outcome slow = Analyze({"--floor", Write("slow.csv", 1000, hum), trial});
  EXPECT_EQ(slow.status, 3);
  EXPECT_THAT(slow.err, HasSubstr("as long and as fast as the trials"));
  const Outcome on = Analyze({"--floor", Write("on.csv", 4000, tone), trial});
  EXPECT_THAT(on.out, HasSubstr("20 um at 225 Hz, as this trial does"));
}

TEST_F(AnalyzeMistakes, AClippedRecordHasALowerLimitAndNoInterval) {
  const std::string path = Write("clipped.csv", 4000, [](double t_s) {
    return std::min(15.0, std::max(-15.0, 20 * Sine(223.7, t_s)));
  });
  const Outcome outcome = Analyze({path});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.out, HasSubstr("vibration (RMS) at least"));
  EXPECT_THAT(outcome.out, ContainsRegex("RMS\\) at least +12\\."));
  EXPECT_THAT(outcome.out, ContainsRegex("amplitude of the tone at least +17\\."));
  EXPECT_THAT(outcome.out, Not(HasSubstr("95 %")));
  EXPECT_THAT(Analyze({"--all", path}).out, Not(HasSubstr("95 %")));
  const Json trial = Json::parse(Analyze({"--json", path}).out)["trials"][0];
  EXPECT_TRUE(trial["band_rms_interval_95_m"].is_null());
  EXPECT_TRUE(trial["tone_amplitude_interval_95_m"].is_null());
  EXPECT_NEAR(trial["band_rms_at_least_m"].get<double>(), 12.1e-6, 0.1e-6);
}

TEST_F(AnalyzeMistakes, SwappedAndRenamedColumnsAreNamed) {
  const auto tone = [](double t_s) { return 20 * Sine(225, t_s); };
  const std::string swapped = Write("swapped.csv", 4000, tone, "displacement_m,time_s");
  const Outcome outcome = Analyze({swapped});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.err, HasSubstr("column 1 grows in even steps as times do"));
  EXPECT_EQ(Analyze({"--columns", "time_s,displacement_m", swapped}).status, 0);
  EXPECT_EQ(Analyze({"--columns", " time_s , displacement_m ", swapped}).status, 0);
  EXPECT_THAT(Analyze({"--columns", "time_s, ,-", swapped}).err, HasSubstr("has an empty name"));
  const std::string path = Write("a.csv", 4000, tone);
  const char* const overridden = "column 2 is in units of 1 m by the file and of 0.001 m by";
  EXPECT_THAT(Analyze({"--columns", "time_s,displacement_mm", path}).out, HasSubstr(overridden));
  EXPECT_THAT(Analyze({"--scale", "1mm", path}).out,
              HasSubstr(std::string("doubt: ") + overridden));
  EXPECT_THAT(Analyze({"--columns", "time_s,displacement_m", path}).out,
              Not(HasSubstr("by the file")));
}

TEST_F(AnalyzeMistakes, OptionsForTablesAreRefusedWhereThereIsNone) {
  const std::string trial = std::string(HAPTOMETER_FIXTURES) + "/recorded_trial.bin";
  const std::string calibration = (directory_ / "c.toml").string();
  std::ofstream(calibration) << "[displacement]\nscale_m_per_v = 1e-3\n";
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"--calibration", calibration},
        {"--columns", "time_s,displacement_mm"},
        {"--scale", "1mm"},
        {"--rate", "1kHz"},
        {"--format", "plain"},
        {"--channel", "CH1"},
        {"--segment", "1"}}) {
    const auto of = [&](std::vector<std::string> more) {
      more.insert(more.end(), words.begin(), words.end());
      return Analyze(more);
    };
    const Outcome outcome = of({trial});
    EXPECT_EQ(outcome.status, 2) << words[0];
    EXPECT_THAT(outcome.err, HasSubstr(words[0] + ": is for tables, and " + trial +
                                       " is a recording that states its columns and units"));
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    EXPECT_EQ(of({trial, trial}).status, 2) << words[0];
  }
  // they are of the tables, where a floor or another trial is a recording, and the other way round
  const std::string table = Steady();
  const std::vector<std::string> columns{"--columns", "time_s,displacement_m"};
  for (const auto& files :
       {std::vector{table, std::string("--floor"), trial},
        std::vector{trial, std::string("--floor"), table}, std::vector{table, trial}}) {
    std::vector<std::string> words = files;
    words.insert(words.end(), columns.begin(), columns.end());
    EXPECT_NE(Analyze(words).status, 2) << files[0];
  }
}

TEST_F(AnalyzeMistakes, ATrialNamesTheCalibrationThatItHolds) {
  const std::string calibration = (directory_ / "c.toml").string();
  std::ofstream(calibration) << "name = 'rig 2'\ndate = '2026-03-01'\n"
                                "[displacement]\nscale_m_per_v = 1e-3\n";
  std::ofstream samples(directory_ / "v.txt");
  for (int k = 0; k < 4000; ++k) samples << fmt::format("{:.6f}\n", Sine(225, k / 4000.));
  samples.close();
  const std::string trial = (directory_ / "t.bin").string();
  ASSERT_EQ(Captured(RunAcquire, "acquire",
                     {"--sensor", "pipe", "--port", (directory_ / "v.txt").string(), "--format",
                      "text", "--rate", "4kHz", "--channels", "displacement:V", "--calibration",
                      calibration, "-o", trial})
                .status,
            0);
  const Outcome outcome = Analyze({trial, "--calibration", calibration});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr("by the calibration rig 2 of 2026-03-01"));
  EXPECT_THAT(outcome.err, HasSubstr("record again by acquire --calibration"));
}

TEST_F(AnalyzeMistakes, ATrialOfVoltsIsCalibratedAsATable) {
  const std::string calibration = (directory_ / "c.toml").string();
  std::ofstream(calibration) << "[displacement]\nscale_m_per_v = 1e-5\n";
  std::ofstream samples(directory_ / "v.txt");
  for (int k = 0; k < 8000; ++k) samples << fmt::format("{:.6f}\n", Sine(225, k / 4000.));
  samples.close();
  const std::string trial = (directory_ / "t.bin").string();
  ASSERT_EQ(Captured(RunAcquire, "acquire",
                     {"--sensor", "pipe", "--port", (directory_ / "v.txt").string(), "--format",
                      "text", "--rate", "4kHz", "--channels", "voltage:V", "-o", trial})
                .status,
            0);
  const Outcome refused = Analyze({trial, "--calibration", calibration});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, HasSubstr("t.bin -o t.csv, and give t.csv with it"));
  const std::string table = (directory_ / "t.csv").string();
  ASSERT_EQ(Captured(RunTrial, "trial", {"export", trial, "-o", table}).status, 0);
  EXPECT_THAT(Analyze({table, "--calibration", calibration, "--window", "all"}).out,
              HasSubstr("amplitude of the tone  10 um"));
}

TEST_F(AnalyzeMistakes, AColumnNamedSensorKeepsTheUnitOfTheFile) {
  const std::string calibration = (directory_ / "c.toml").string();
  std::ofstream(calibration) << "[displacement]\nscale_m_per_v = 1e-3\ncalibrated_min_v = -5\n"
                                "calibrated_max_v = 5\n";
  const auto offset_m = [&](const std::string& header, const std::string& columns, double volts) {
    const std::string path = (directory_ / "daq.csv").string();
    std::ofstream table(path);
    table << header << "\n";
    for (int k = 0; k < 8000; ++k) {
      table << fmt::format("{:.6f},{:.6f}\n", k / 4000., volts * (2 + 0.01 * Sine(225, k / 4000.)));
    }
    table.close();
    return Json::parse(Analyze({path, "--columns", columns, "--calibration", calibration, "--json"})
                           .out)["trials"][0]["offset_m"]
        .get<double>();
  };
  EXPECT_NEAR(offset_m("Time (s),Laser (V)", "time_s,sensor", 1), 2e-3, 1e-6);
  EXPECT_NEAR(offset_m("Time (s),Laser (mV)", "time_s,sensor", 1e3), 2e-3, 1e-6);
  EXPECT_NEAR(offset_m("Time (s),Laser (mV)", "time_s,voltage_mv", 1e3), 2e-3, 1e-6);
  // without a unit mV are taken for V: doubted by the volts and by the range
  EXPECT_NEAR(offset_m("a,b", "time_s,sensor", 1e3), 2, 1e-3);
  const std::string said = Analyze({(directory_ / "daq.csv").string(), "--columns", "time_s,sensor",
                                    "--calibration", calibration})
                               .out;
  EXPECT_THAT(said, HasSubstr("doubt: the input of the calibration reaches 2010 V"));
  EXPECT_THAT(said, ContainsRegex("8000 of 8000 samples lie beyond the calibrated range, -5 mm to "
                                  "5 mm, by 2.005 m at most, 20[01] times its width: is the input "
                                  "in mV"));
  // a file that knows its error level takes all of them for no reading
  std::ofstream(calibration, std::ios::app) << "bad_above_v = 5.25\n";
  const auto refused = Analyze({(directory_ / "daq.csv").string(), "--columns", "time_s,sensor",
                                "--calibration", calibration});
  EXPECT_EQ(refused.status, 3);
  EXPECT_THAT(refused.err, HasSubstr("reaches 2010 V, and has no reading by the calibration"));
}

TEST_F(AnalyzeMistakes, AWrongQuestionIsWorseThanAMissingTrial) {
  const std::string trial = Steady();
  for (const std::vector<std::string>& files :
       {std::vector{trial, (directory_ / "none.csv").string()},
        std::vector{(directory_ / "none.csv").string(), trial}}) {
    for (const char* kind : {"--all", "--sweep"}) {
      EXPECT_EQ(Analyze({files[0], files[1], kind, "--columns", "time_s,displacement_m,-"}).status,
                2)
          << kind;
    }
  }
}

TEST_F(AnalyzeMistakes, AnAveragingIsMadeKnownAsTheRemarkSays) {
  const std::string trial = Steady();
  const Outcome unknown = Analyze({trial});
  EXPECT_THAT(unknown.out, HasSubstr("amplitude not verified: sensor averaging unknown"));
  EXPECT_THAT(unknown.out, HasSubstr("'# averages = 16' and '# sampling_s = 0.00033'"));
  const std::string head = "# averages = 16\n# sampling_s = 0.0001\n";
  const std::string told = (directory_ / "told.csv").string();
  std::ofstream(told) << head << std::ifstream(trial).rdbuf();
  EXPECT_THAT(Analyze({told}).out, Not(HasSubstr("not verified")));
}

TEST_F(AnalyzeMistakes, EachRowOfAllHasAText) {
  const std::string trial = Steady();
  for (const char* window : {"auto", "all", "0.4s:1.2s"}) {
    std::istringstream lines(Analyze({"--all", "--window", window, trial}).out);
    for (std::string line; std::getline(lines, line);) {
      EXPECT_FALSE(line.ends_with(' ')) << "'" << line << "' with --window " << window;
    }
  }
}

TEST_F(AnalyzeMistakes, WhatNoBudgetHoldsIsSaidOnce) {
  const std::string trial = Steady();
  const std::string words = "the sensor's calibration and linearity";
  const std::string out = Analyze({trial, trial}).out;
  ASSERT_THAT(out, HasSubstr(words));
  EXPECT_EQ(out.find(words), out.rfind(words));
  EXPECT_THAT(Analyze({"--all", trial}).out, HasSubstr("uncertainty excludes  " + words));
  EXPECT_EQ(Json::parse(Analyze({"--json", trial}).out)["uncertainty_excludes"], words);
}

TEST_F(AnalyzeMistakes, AStatedCalibrationIsInTheBudget) {
  const std::string trial = Steady();
  const std::string stated = (directory_ / "stated.csv").string();
  std::ofstream(stated) << "# calibration.displacement.relative_standard_uncertainty = 0.2%\n"
                        << std::ifstream(trial).rdbuf();
  const auto relative = [&](const std::vector<std::string>& words) {
    const Json document = Json::parse(Analyze(words).out);
    const Json& of = document["trials"][0];
    const double u_m = of["band_rms_standard_uncertainty_m"];
    return u_m / of["band_rms_m"].get<double>();
  };
  EXPECT_NEAR(relative({"--json", stated}), 0.002, 1e-4);
  EXPECT_NEAR(relative({"--json", "--calibration-uncertainty", "1%", stated}), 0.01, 1e-4);
  EXPECT_NEAR(relative({"--json", "--calibration-uncertainty", "0.01", trial}), 0.01, 1e-4);
  EXPECT_TRUE(Json::parse(Analyze({"--json", stated}).out)["uncertainty_excludes"].is_null());
  const std::string out = Analyze({"--all", "--calibration-uncertainty", "1%", stated}).out;
  EXPECT_THAT(out, Not(HasSubstr("uncertainty excludes")));
  EXPECT_THAT(out, HasSubstr("in place of the 0.2 %"));
  EXPECT_THAT(out, HasSubstr("calibration"));
  // of two trials one states it: the other one's exclusion is still shown
  EXPECT_THAT(Analyze({stated, trial}).out, HasSubstr("uncertainty excludes"));
  EXPECT_EQ(Analyze({"--calibration-uncertainty", "2", trial}).status, 2);
  // a forgotten %
  const auto forgotten = Analyze({"--calibration-uncertainty", "0.5", trial});
  EXPECT_EQ(forgotten.status, 2);
  EXPECT_THAT(forgotten.err, HasSubstr("at most 20 %, as 0.5%"));
}

TEST_F(AnalyzeMistakes, AResolutionIsUsedOrRefused) {
  // 100 Hz to 400 Hz in 3 s: 10 Hz a block of 0.1 s
  const std::string sweep =
      Write("sweep.csv", 4000, [](double t_s) { return 5 * Sine(100 + 50 * t_s, t_s); });
  EXPECT_THAT(Analyze({"--sweep", sweep}).out,
              HasSubstr("try another --band, a --resolution above"));
  EXPECT_THAT(Analyze({"--sweep", "--resolution", "20Hz", sweep}).out,
              ContainsRegex("resolution +20 Hz"));
  const Outcome alone = Analyze({"--resolution", "5Hz", sweep});
  EXPECT_EQ(alone.status, 2);
  EXPECT_THAT(alone.err, HasSubstr("--resolution: applies to a spectrum or a sweep only"));
}

// they were ignored without a word
TEST_F(AnalyzeMistakes, WordsOfACampaignThatIsNotAskedForAreRefused) {
  const std::string trial = Steady();
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"--job-time", "60s"}, {"--campaign", "elsewhere"}}) {
    const Outcome refused = Analyze({words[0], words[1], trial});
    EXPECT_EQ(refused.status, 2) << words[0];
    EXPECT_THAT(refused.err, HasSubstr("apply to --slurm only, which is not given"));
  }
  const Outcome mixed = Analyze({"--allow-mixed", trial});
  EXPECT_EQ(mixed.status, 2);
  EXPECT_THAT(mixed.err, HasSubstr("--allow-mixed: applies to --shard, --merge and --slurm only"));
}

TEST_F(AnalyzeMistakes, AResonanceBeyondTheBandIsLookedForFurther) {
  const std::string sweep = Write("high.csv", 4000, [](double t_s) {
    const double u = (400 + 40 * t_s) / 600;  // resonant at 600 Hz, swept to 520 Hz
    return 5 / std::hypot(1 - u * u, u / 10) * Sine(400 + 20 * t_s, t_s);
  });
  EXPECT_THAT(Analyze({"--sweep", sweep}).out,
              HasSubstr("the resonance may be above it; sweep further, with a wider --band"));
}

}  // namespace
}  // namespace haptometer::tools
