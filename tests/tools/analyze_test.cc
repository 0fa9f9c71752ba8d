#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "tests/residual.h"
#include "tests/tools/captured.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::ContainsRegex;
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
  // 100 um / sqrt(2) / 0.7604, |cos(pi 225 Hz 1 ms)| for two averages
  EXPECT_THAT(outcome.out, ContainsRegex("vibration \\(RMS\\) +92.99"));
  EXPECT_THAT(outcome.out, ContainsRegex(" um; 95 %: .* um, in 20-500 Hz\n"));
  EXPECT_THAT(
      outcome.out,
      ContainsRegex("as measured +70.71.* um, noise floor of .*; corrected for the sensor's gain "
                    "of 0.7604"));
  EXPECT_THAT(outcome.out, HasSubstr("the drive is on throughout"));
  EXPECT_THAT(outcome.out, ContainsRegex("amplitude of the tone +131.51"));
  EXPECT_THAT(outcome.out, HasSubstr("the sensor's gain at the tone is 0.7604; corrected for"));
  EXPECT_THAT(outcome.out, HasSubstr("data: imported"));
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
  EXPECT_LT(trial["noise_rms_m"].get<double>(), 1e-7 / std::sqrt(12)) << "steps of 0.1 um";
  EXPECT_EQ(trial["noise_from"], "the spectrum beside the drive");
  EXPECT_EQ(trial["excluded_s"], Json::array());
  EXPECT_EQ(trial["hum"], Json::array());
  const Json& state = trial["drive"]["states"].at(0);
  EXPECT_EQ(state["state"], "on");
  EXPECT_LT(state["from_s"].get<double>(), trial["window_s"].at(0).get<double>() + 0.05);
  EXPECT_REL(state["rms_m"].get<double>(), 1e-4 / std::numbers::sqrt2, 1e-3, "blocks of 50 ms");
  EXPECT_ABS(state["drift"].get<double>(), 0, 1e-3, "a steady tone");
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
  EXPECT_THAT(trials[1]["reasons"].at(0).get<std::string>(), HasSubstr("48 new readings/s"));
  // every trial has the same keys
  for (const auto& [key, value] : trials[2].items()) {
    EXPECT_TRUE(trials[0].contains(key) && trials[1].contains(key)) << key;
  }
}

// wherever a number of a recording is shown
TEST_F(AnalyzeVerb, SaysWhereTheDataComeFrom) {
  const std::string plain = Trial("plain.csv", 10'000, 2);
  const auto stated = [&](const std::string& source) {
    const std::string path = directory_ / "stated.csv";
    std::ofstream(path) << "# source = " << source << "\n" << std::ifstream(plain).rdbuf();
    return path;
  };
  const auto sources = [](const std::string& path) {
    return Json::parse(Analyze({path, "--json"}).out)["trials"][0]["data_source"];
  };
  EXPECT_EQ(sources(plain), Json({"imported"}));
  EXPECT_EQ(sources(stated("simulated: a scene")), Json({"simulated"}));
  EXPECT_EQ(sources(stated("emulated device: port")), Json({"emulated"}));
  EXPECT_EQ(sources(stated("device: port")), Json({"device"}));
  EXPECT_EQ(sources(stated("TCP connection a:1 (what is behind it is not known)")), Json());
  const std::string emulated = stated("emulated device: port");
  EXPECT_THAT(Analyze({emulated}).out, HasSubstr("data: emulated\n"));
  const std::string page = directory_ / "page.html";
  EXPECT_EQ(Analyze({emulated, "--report", page}).status, 0);
  std::ifstream written(page);
  EXPECT_THAT(std::string(std::istreambuf_iterator<char>(written), {}), HasSubstr("emulated"));
  // an end that is missing
  const std::string cut = directory_ / "cut.bin";
  std::ifstream whole(std::string(HAPTOMETER_FIXTURES) + "/recorded_trial.bin", std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(whole), {});
  std::ofstream(cut, std::ios::binary) << bytes.substr(0, 100'000);
  EXPECT_EQ(sources(cut).back(), "interrupted");
  EXPECT_THAT(Analyze({cut}).out, HasSubstr(", interrupted\n"));
}

TEST_F(AnalyzeVerb, RefusesACalibrationThatIsNotThereForATrialToo) {
  const std::string trial = std::string(HAPTOMETER_FIXTURES) + "/recorded_trial.bin";
  const auto outcome = Analyze({trial, "--calibration", directory_ / "none.toml"});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.err, HasSubstr("none.toml"));
}

TEST_F(AnalyzeVerb, FindingsNameTheTrialOfSeveral) {
  const std::string path = Trial("a.csv", 10'000, 2);
  const auto findings = [](const std::vector<std::string>& words) {
    return Json::parse(Analyze(words).out)["findings"];
  };
  for (const Json& finding : findings({path, path, "--json"})) EXPECT_EQ(finding["subject"], path);
  const Json alone = findings({path, "--json"});
  ASSERT_FALSE(alone.empty());
  EXPECT_TRUE(alone[0]["subject"].is_null());
  const auto gain = std::find_if(alone.begin(), alone.end(),
                                 [](const Json& one) { return one["kind"] == "gain-corrected"; });
  ASSERT_NE(gain, alone.end());
  EXPECT_REL((*gain)["numbers"]["gain"].get<double>(), std::cos(std::numbers::pi * 0.225), 1e-6,
             "the tone's frequency");
  const std::string text = Analyze({path, path}).out;
  EXPECT_THAT(text, HasSubstr("vibration of 2 trials\n  " + path + "\n    data: imported\n"));
  EXPECT_THAT(text, HasSubstr("\n    note: filter transients excluded: "))
      << "the heading has the name";
}

TEST_F(AnalyzeVerb, AllNamesFilterBudgetAndSensor) {
  const Outcome outcome = Analyze({"--all", Trial("a.csv", 10'000, 2)});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  for (const char* words :
       {"20-500 Hz, Butterworth of order 6, forward and backward", "uncertainty of the RMS",
        "standard uncertainty", "2 averages at 1 ms", "velocity", "acceleration",
        "command: haptometer analyze --all", "SHA-256"}) {
    EXPECT_THAT(outcome.out, HasSubstr(words));
  }
  EXPECT_THAT(outcome.out, ContainsRegex("\n +noise +A "));
  EXPECT_THAT(outcome.out, ContainsRegex("\n +filter's ends +B "));
  EXPECT_THAT(outcome.out, ContainsRegex("offset +(1 mm|1000 um)\n"));
}

TEST_F(AnalyzeVerb, TheWindowMayBeChosen) {
  const std::string path = Trial("a.csv", 10'000, 2);
  const Outcome outcome = Analyze({"--json", "--window", "0.5s:1500ms", path});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Json trial = Json::parse(outcome.out)["trials"][0];
  EXPECT_ABS(trial["window_s"][0].get<double>(), 0.5, 1e-4, "a row");
  EXPECT_ABS(trial["window_s"][1].get<double>(), 1.5, 1.0 / 225, "whole periods");
  for (const char* window : {"3s:1s", "1s", "1s:1s", "some", "1s:2kg"}) {
    EXPECT_EQ(Analyze({"--window", window, path}).status, 2) << window;
  }
}

TEST_F(AnalyzeVerb, AFloorIsTakenOffInPower) {
  // a tone of 5 um as "noise" beside one of 12 um: 13 um together
  const auto tones = [&](const std::string& name, double quiet_m, double drive_m) {
    std::ofstream file(directory_ / name);
    file.precision(12);
    file << "# sampling_s = 0.0001\n# averages = 1\ntime_s,displacement_m\n";
    for (int k = 0; k < 20'000; ++k) {
      const double t_s = k / 1e4;
      file << t_s << ','
           << 1e-3 + quiet_m * std::sin(2 * std::numbers::pi * 110 * t_s) +
                  drive_m * std::sin(2 * std::numbers::pi * 225 * t_s)
           << '\n';
    }
    return (directory_ / name).string();
  };
  const std::string off = tones("off.csv", 5e-6, 0);
  const std::string on = tones("on.csv", 5e-6, 12e-6);
  const Json trial = Json::parse(Analyze({"--json", "--floor", off, on}).out)["trials"][0];
  EXPECT_REL(trial["band_rms_as_measured_m"].get<double>(), 13e-6 / std::numbers::sqrt2, 1e-3,
             "settled ends, not whole periods of 110 Hz");
  EXPECT_REL(trial["noise_rms_m"].get<double>(), 5e-6 / std::numbers::sqrt2, 1e-3, "the same");
  EXPECT_REL(trial["band_rms_m"].get<double>(), 12e-6 / std::numbers::sqrt2, 2e-3, "the same");
  EXPECT_EQ(trial["noise_from"], off);
  // what may be noise alone has an upper limit and no value
  const std::string weak = tones("weak.csv", 5e-6, 4e-6);
  const Json limited = Json::parse(Analyze({"--json", "--floor", off, weak}).out)["trials"][0];
  EXPECT_TRUE(limited["band_rms_m"].is_null());
  EXPECT_EQ(limited["band_rms_interval_95_m"][0], 0);
  EXPECT_EQ(limited["band_rms_interval_95_m"][1], limited["band_rms_at_most_m"]);
  const Outcome missing = Analyze({"--floor", directory_ / "none.csv", on});
  EXPECT_EQ(missing.status, 3);
  EXPECT_THAT(missing.err, HasSubstr("none.csv: no such file"));
}

TEST_F(AnalyzeVerb, JsonNamesOptionsAsTheTerminalDoes) {
  std::ofstream(directory_ / "bare.csv") << "0,1\n1,2\n2,3\n";
  const Outcome bare = Analyze({"--json", directory_ / "bare.csv"});
  EXPECT_EQ(bare.status, 3);
  EXPECT_THAT(bare.out, HasSubstr("give --columns time_s,voltage_v"));
  EXPECT_THAT(bare.out, ::testing::Not(HasSubstr("<columns>")));
}

// the mean of a sine about 0 is what rounding leaves
TEST_F(AnalyzeVerb, AnOffsetOfNothingIsZero) {
  std::ofstream file(directory_ / "sine.csv");
  file.precision(17);
  file << "time_s,displacement_m\n";
  for (int k = 0; k < 20'000; ++k) {
    file << k / 1e4 << ',' << 2e-4 * std::sin(2 * std::numbers::pi * 225 * k / 1e4) << '\n';
  }
  file.close();
  EXPECT_THAT(Analyze({"--all", directory_ / "sine.csv"}).out, ContainsRegex("offset +0 um\n"));
}

TEST_F(AnalyzeVerb, SpectraSayTheirNoiseBandwidth) {
  const std::string path = Trial("a.csv", 10'000, 2);
  const std::string csv = directory_ / "spectrum.csv";
  EXPECT_EQ(Analyze({path, "--spectrum", csv, "--resolution", "10Hz", "--scaling", "amplitude",
                     "--spectrum-window", "flat-top"})
                .status,
            0);
  std::ifstream file(csv);
  std::string text(std::istreambuf_iterator<char>(file), {});
  EXPECT_THAT(text, HasSubstr("# window = flat-top\n# overlap = 0.5\n"));
  EXPECT_THAT(text, HasSubstr("# noise_bandwidth_hz = 38.8"));  // HFT90D: 3.8832 bins of 10 Hz
  const auto at = text.find("\n220,");
  ASSERT_NE(at, std::string::npos) << text.substr(0, 400);
  EXPECT_REL(std::stod(text.substr(at + 5)), 1e-4, 5e-3, "half a bin off a flat top: 0.04 %");
  EXPECT_THAT(Analyze({path, "--spectrum", csv}).err, HasSubstr("spectrum.csv: already exists"));
  EXPECT_EQ(Analyze({path, "--spectrum", csv, "--overwrite", "--resolution", "0.1Hz"}).status, 3);
  EXPECT_EQ(Analyze({path, "--spectrum", csv, "--overwrite", "--overlap", "1"}).status, 2);
}

TEST_F(AnalyzeVerb, ASpectrogramIsDrawnOrWritten) {
  const std::string path = Trial("a.csv", 10'000, 2);
  const std::string csv = directory_ / "time.csv";
  const std::string svg = directory_ / "time.svg";
  EXPECT_EQ(Analyze({path, "--spectrogram", csv, "--resolution", "50Hz"}).status, 0);
  EXPECT_EQ(Analyze({path, "--spectrogram", svg, "--resolution", "50Hz"}).status, 0);
  std::ifstream file(csv);
  std::string text(std::istreambuf_iterator<char>(file), {});
  EXPECT_THAT(text, HasSubstr("time_s,frequency_hz,density_m2_per_hz\n"));
  EXPECT_GT(fs::file_size(svg), 1000U);
}

// a folder stands for its recordings, by name; each is a row whatever became of it
TEST_F(AnalyzeVerb, ATableHasARowForEachTrialOfAFolder) {
  static_cast<void>(Trial("b.csv", 10'000, 2));
  static_cast<void>(Trial("a.csv", 48, 3));
  std::ofstream(directory_ / "c.csv") << "time_s,displacement_m\n";
  const std::string table = directory_ / "table.csv";
  const std::vector<std::string> words{directory_, "--table", table};
  EXPECT_EQ(Analyze(words).status, 3) << "two of three are not answered";
  std::ifstream file(table);
  std::vector<std::string> rows;
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with('#')) rows.push_back(line);
  }
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_THAT(rows[0], ::testing::StartsWith("file,answered,band_rms_m,"));
  EXPECT_THAT(rows[0], ::testing::EndsWith(",data_source,finding_kinds"));
  EXPECT_THAT(rows[1], ContainsRegex("a.csv,0,,.*too-few-readings"));
  EXPECT_THAT(rows[2], ContainsRegex("b.csv,1,9.29.*e-05.*gain-corrected"));
  EXPECT_THAT(rows[3], ContainsRegex("c.csv,0,,.*error"));
  // a table of results is no trial
  EXPECT_THAT(Analyze(words).err, HasSubstr("table.csv: already exists"));
  const Json again = Json::parse(Analyze({directory_, "--json"}).out);
  EXPECT_EQ(again["trials"].size(), 3U);
  const fs::path empty = directory_ / "empty";
  fs::create_directories(empty);
  EXPECT_THAT(Analyze({empty}).err, HasSubstr("holds no recording"));
}

// Times since 1970 are 1.7e9 s: six digits of both ends of a window would be the same.
TEST_F(AnalyzeVerb, TimesSinceAnEpochAreToldApart) {
  const std::string path = directory_ / "epoch.csv";
  std::ofstream file(path);
  file << "time_s,displacement_um\n";
  for (int k = 0; k < 10'000; ++k) {
    file << 1'700'000'000 + k / 5000 << '.' << std::to_string(10'000 + 2 * (k % 5000)).substr(1)
         << ',' << 30 * std::sin(2 * std::numbers::pi * 225 * k / 5000) << '\n';
  }
  file.close();
  const Outcome outcome = Analyze({path, "--all"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("window +1700000000\\.[0-9]{4} to 1700000001\\.[0-9]{4} "
                                         "s, the drive is on throughout\n"));
  EXPECT_THAT(outcome.out, ContainsRegex("1700000000\\.[0-9]{4} s +1700000001\\.[0-9]{4} s +on"));
  EXPECT_THAT(outcome.out, ::testing::Not(HasSubstr("e+09 to")));
  const Json trial = Json::parse(Analyze({path, "--json"}).out)["trials"].at(0);
  const double length_s =
      trial["window_s"].at(1).get<double>() - trial["window_s"].at(0).get<double>();
  EXPECT_GT(length_s, 1);
  EXPECT_LT(length_s, 2);
  const Outcome asked = Analyze({path, "--window", "1700000000.5:1700000001.5"});
  EXPECT_THAT(asked.out, ContainsRegex("window +1700000000\\.5000 to 1700000001\\.[0-9]{4} s, "
                                       "requested\n"));
}

// What makes the interval wide is named, as in the note of what would halve it: the drive is
// strong.
TEST_F(AnalyzeVerb, AWideIntervalStatesItsCause) {
  const std::string path = directory_ / "falls.csv";
  std::ofstream file(path);
  file << "time_s,displacement_um\n";
  for (int k = 0; k < 6000; ++k) {
    const double t_s = k * 5e-4;
    file << t_s << ',' << 30 * (1 - 0.1 * t_s) * std::sin(2 * std::numbers::pi * 225 * t_s) << '\n';
  }
  file.close();
  const Outcome outcome = Analyze({path});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("doubt: the RMS is known to .* % of the variance is due "
                                         "to the change of the amplitude: drive at a constant"));
  EXPECT_THAT(outcome.out, HasSubstr("what none changes is due to change of the amplitude most"));
  EXPECT_THAT(outcome.out, ::testing::Not(HasSubstr("drive harder")));
}

TEST_F(AnalyzeVerb, AViolatedExpectationIsADoubtAndStatus3) {
  const std::string path = Trial("a.csv", 10'000, 2);
  EXPECT_EQ(Analyze({path, "--expect", "tone=225Hz+-1Hz, change<5%, source=imported"}).status, 0);
  const Outcome outcome = Analyze({path, "--expect", "tone=230Hz+-1Hz"});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.out, HasSubstr("doubt: the tone is at 225 Hz; 230 Hz +- 1 Hz is expected"));
  // each kind of expectation ends so
  for (const auto& [expected, kind] :
       {std::pair("tone=230Hz+-1Hz", "other-tone-than-expected"),
        std::pair("amplitude=90um+-1um", "other-amplitude-than-expected"),
        std::pair("rms=60um+-1um", "other-rms-than-expected"),
        std::pair("change<0.0000001%", "larger-change-than-expected"),
        std::pair("source=device", "other-source-than-expected")}) {
    const Outcome other = Analyze({path, "--json", "--expect", expected});
    EXPECT_EQ(other.status, 3) << expected;
    EXPECT_THAT(other.out, HasSubstr(kind)) << expected;
    EXPECT_THAT(other.out, HasSubstr("\"answered\": true")) << expected;
  }
  const Outcome slow = Analyze({Trial("slow.csv", 48, 3), "--json", "--expect", "rms=1um+-1um"});
  EXPECT_EQ(slow.status, 3);
  EXPECT_THAT(slow.out, HasSubstr("expected-quantity-not-determined"));
  EXPECT_EQ(Analyze({path, "--expect", "tone=230Hz"}).status, 2);
  // repeats are of a session, as the list of the error says
  const Outcome repeats = Analyze({path, "--expect", "repeats<10%"});
  EXPECT_EQ(repeats.status, 2);
  EXPECT_THAT(repeats.err, HasSubstr("for a session"));
  EXPECT_THAT(Analyze({path, "--expect", "moon"}).err, HasSubstr("of a session, repeats<10%"));
}

TEST_F(AnalyzeVerb, TooSlowIsSaidInWords) {
  const Outcome outcome = Analyze({Trial("slow.csv", 48, 3)});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.out, HasSubstr("not answered: 48 new readings/s show vibration up to"));
  EXPECT_THAT(outcome.out, ContainsRegex("observable to +18.75 Hz"));
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
  std::ifstream drawn(picture);
  EXPECT_THAT(std::string(std::istreambuf_iterator<char>(drawn), {}),
              ::testing::AllOf(HasSubstr("spectrum of the unfiltered window"),
                               HasSubstr("filter transient (excluded)"),
                               HasSubstr("states of the drive"), HasSubstr("corners of the band"),
                               HasSubstr("strongest tone"), HasSubstr("noise")));
  EXPECT_EQ(Analyze({Trial("slow.csv", 48, 3), "--plot", picture}).status, 3);
  EXPECT_LT(fs::file_size(picture), size) << "one panel instead of four";
}

}  // namespace
}  // namespace haptometer::tools
