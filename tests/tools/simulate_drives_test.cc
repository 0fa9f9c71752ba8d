// simulate under every drive, and what it writes of the motion.
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
#include <sstream>
#include <string>
#include <vector>

#include "tests/residual.h"
#include "tests/tools/captured.h"
#include "tools/verbs.h"
#include "trial/import/read_recording.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

const std::string kFixtures = HAPTOMETER_FIXTURES;
const std::string kAdapter = kFixtures + "/lra_adapter.toml";
const std::string kSine = "[drive]\nkind = 'sine'\namplitude_v = 5\nfrequency_hz = 225\n";
const std::string kBurst =
    "[drive]\nkind = 'burst'\namplitude_v = 5\nfrequency_hz = 225\nstart_s = 0.01\nrise_s = 0.01\n"
    "hold_s = 0.2\nfall_s = 0.02\n";
const std::string kChirp =
    "[drive]\nkind = 'chirp'\namplitude_v = 2\nfrequency_hz = 50\nend_frequency_hz = 400\n"
    "duration_s = 0.05\nhold_tolerance = 1e-6\n";
const std::string kPulse = "[drive]\nkind = 'pulse'\namplitude_v = 3\nhold_s = '4ms'\n";
const std::string kTones =
    "[drive]\nkind = 'tones'\n[[drive.tone]]\namplitude_v = 3\nfrequency_hz = 225\n"
    "[[drive.tone]]\namplitude_v = 2\nfrequency_hz = 175\nphase_rad = 1\n";
const std::string kSamples = "[drive]\nkind = 'samples'\nrate_hz = 8000\nfile = 'v.csv'\n";

Outcome Simulate(const std::vector<std::string>& words) {
  return Captured(RunSimulate, "simulate", words);
}

class SimulateDrives : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(directory_);
    std::ofstream voltages(Path("v.csv"));
    voltages << "voltage_v\n";
    for (int k = 0; k <= 400; ++k) voltages << 2 * std::sin(0.2 * k) << '\n';
  }
  void TearDown() override { fs::remove_all(directory_); }
  std::string Path(const std::string& name) const { return directory_ / name; }
  std::string Scene(const std::string& drive, const std::string& more = "") const {
    std::ofstream(Path("scene.toml"))
        << "[actuator]\nmodel = 'thesis-c10-100'\n[skin]\nstiffness_n_per_m = 600\n"
           "damping_n_s_per_m = 0.75\npreload_n = 0.07\n"
        << drive << more;
    return Path("scene.toml");
  }
  json Answer(const std::vector<std::string>& words) const {
    std::vector<std::string> with_json = words;
    with_json.emplace_back("--json");
    const Outcome outcome = Simulate(with_json);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.status == 0 ? json::parse(outcome.out) : json();
  }
  const fs::path directory_ =
      fs::path(::testing::TempDir()) / ("simulate_drives_test_" + std::to_string(::getpid()));
};

TEST_F(SimulateDrives, PlaysEachKindWithADuration) {
  for (const std::string& drive : {kBurst, kChirp, kPulse, kTones, kSamples}) {
    const json answer = Answer({Scene(drive), "--duration", "60ms"});
    EXPECT_TRUE(answer.at("skin_rms_m").is_null()) << "no steady state is asked for";
    EXPECT_TRUE(answer.at("window_rms_m").is_null());
    const json& run = answer.at("run");
    EXPECT_EQ(run.at("window_s"), json({0.0, 0.06})) << "all of it";
    EXPECT_GT(run.at("skin_rms_m").get<double>(), 1e-6);
    EXPECT_LT(run.at("energy_imbalance").get<double>(), 1e-9);
    EXPECT_TRUE(answer.at("contact_force_least_n").is_number());
    const double efficiency = answer.at("efficiency").get<double>();
    EXPECT_GT(efficiency, 0);
    EXPECT_LT(efficiency, 1);
    EXPECT_THAT(Simulate({Scene(drive), "--duration", "60ms"}).out, HasSubstr("  run\n    window"));
  }
}

TEST_F(SimulateDrives, PlaysADriveThatEndsUntilItHasRungDown) {
  for (const std::string& drive : {kBurst, kChirp, kPulse, kSamples}) {
    const Outcome outcome = Simulate({Scene(drive), "--json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json answer = json::parse(outcome.out);
    EXPECT_TRUE(std::ranges::any_of(answer.at("findings"), [](const json& finding) {
      return finding.at("kind") == "duration-of-drive";
    })) << drive;
    EXPECT_GT(answer.at("run").at("window_s").at(1).get<double>(), 0.04);
  }
}

TEST_F(SimulateDrives, ABurstThatIsLongIsASineInTheEnd) {
  // the burst of 0.2 s at full amplitude, window by hand: its last rows against the sine's RMS
  const json sine = Answer({Scene(kSine)});
  ASSERT_EQ(Simulate({Scene(kBurst), "--duration", "0.22s", "--waveforms", Path("w.csv"), "--rate",
                      "22500Hz"})
                .status,
            0);
  const auto recording = trial::ReadRecording(Path("w.csv"));
  ASSERT_TRUE(recording) << recording.error().Text();
  const std::vector<double>& skin_m = recording->record.channels[0].values;
  double sum = 0;
  for (auto value = skin_m.end() - 1000; value != skin_m.end(); ++value) sum += *value * *value;
  EXPECT_REL(std::sqrt(sum / 1000), sine.at("skin_rms_m").get<double>(), 2e-3,
             "what is left of the ramp after 0.16 s");
}

TEST_F(SimulateDrives, TonesHaveASteadyState) {
  const json answer = Answer({Scene(kTones)});
  EXPECT_REL(answer.at("period_s").get<double>(), 0.04, 1e-15, "25 Hz in common");
  EXPECT_TRUE(answer.at("run").is_null());
  EXPECT_TRUE(answer.at("phase_rad").is_null());
  // the same as a run over a whole period from there, by another solver
  const json played =
      Answer({Scene(kTones, "[run]\nstart = 'steady'\n"), "--duration", "0.04s"}).at("run");
  for (const char* key : {"skin_rms_m", "case_rms_m", "current_rms_a", "power_w"}) {
    EXPECT_REL(answer.at(key).get<double>(), played.at(key).get<double>(), 1e-11, "rounding");
  }
  EXPECT_REL(answer.at("mover_peak_m").get<double>(),
             played.at("mover_peak_of_run_m").get<double>(), 1e-9, "quintics of either");
  const Outcome text = Simulate({Scene(kTones)});
  EXPECT_THAT(text.out, HasSubstr("tones of 3 V at 225 Hz and 2 V at 175 Hz"));
  EXPECT_THAT(text.out, HasSubstr("  repeats itself every"));
  EXPECT_THAT(text.out, HasSubstr(" 40 ms\n"));
}

TEST_F(SimulateDrives, SaysWhatItNeeds) {
  const auto expect = [](const Outcome& outcome, const std::string& text) {
    EXPECT_EQ(outcome.status, 3);
    EXPECT_EQ(outcome.out, "");
    EXPECT_THAT(outcome.err, HasSubstr(text));
  };
  const std::string stops =
      "[effects]\ntravel_stops = true\n[travel_stops]\ngap_m = '50um'\nrestitution = 0.5\n";
  expect(Simulate({Scene(kTones, stops)}), "drives with tones and has no duration");
  expect(Simulate({Scene(kTones, stops + "[run]\nstart = 'steady'\nduration_s = 0.1\n")}),
         "begins with effects in the steady motion of tones");
  expect(Simulate({Scene(kTones), "--explain"}), "drives with tones and has no duration");
  expect(Simulate({Scene(kPulse), "--duration", "1000s"}), "shorten duration_s to 376 s or less");
  expect(Simulate({Scene("[drive]\nkind = 'sine'\namplitude_v = 5\nfrequency_hz = 1e-9\n")}),
         "at 1e-09 Hz the skin moves so little that rounding exceeds it; raise frequency_hz");
}

TEST_F(SimulateDrives, ChoosesEffectsUnderABurst) {
  const std::string stops =
      "[effects]\ntravel_stops = 'auto'\ncontact_loss = 'auto'\ninductance = 'auto'\n"
      "[travel_stops]\ngap_m = '50um'\nrestitution = 0.5\n[run]\nduration_s = 0.1\n"
      "tolerance = 1e-3\n";
  const json answer = Answer({Scene(kBurst, stops)});
  EXPECT_TRUE(answer.at("effects").at("travel_stops").at("on").get<bool>());
  EXPECT_EQ(answer.at("run").at("mover_peak_of_run_m"), 5e-5) << "as it was written";
  EXPECT_GE(answer.at("contact_force_least_n").get<double>(), 0);
  EXPECT_THAT(Simulate({Scene(kBurst, stops), "--explain"}).out,
              HasSubstr("each effect forced on and forced off"));
  EXPECT_THAT(Simulate({Scene(kBurst, stops)}).out, HasSubstr("    travel_stops  yes, no bound"));
}

TEST_F(SimulateDrives, TellsRiseAndLatency) {
  // the adapter reaches 90 % after 54 ms (facts of the thesis's model), the cone much sooner
  const json adapter = Answer({kAdapter, "--duration", "0.3s"}).at("rise");
  EXPECT_GT(adapter.at("rise_s").get<double>(), 0.030);
  EXPECT_LT(adapter.at("rise_s").get<double>(), 0.054);
  EXPECT_LT(adapter.at("latency_s").get<double>(), 0.010);
  const json cone = Answer({kFixtures + "/lra_cone.toml", "--duration", "0.3s"}).at("rise");
  EXPECT_LT(cone.at("latency_s").get<double>(), adapter.at("latency_s").get<double>());
  EXPECT_EQ(cone.at("verdict"), "latency-unnoticed");
  // a later burst has the same latency, counted from its begin
  const std::string at_once =
      "[drive]\nkind = 'burst'\namplitude_v = 5\nfrequency_hz = 225\n"
      "hold_s = 0.2\n";
  const double first_s = Answer({Scene(at_once)}).at("rise").at("latency_s").get<double>();
  const double later_s =
      Answer({Scene(at_once + "start_s = 0.0504\n")}).at("rise").at("latency_s").get<double>();
  EXPECT_ABS(later_s, first_s, 2e-4, "the envelope's steps, a tenth of a period");
  // a straight ramp of 40 ms takes 32 ms from 10 % to 90 %, as long as the motion follows it
  const double ramp_s =
      Answer({Scene(at_once + "rise_s = 0.04\n")}).at("rise").at("rise_s").get<double>();
  EXPECT_ABS(ramp_s, 0.032, 0.002, "the motion's own 5 ms, squared");
  EXPECT_TRUE(Answer({Scene(kChirp)}).at("rise").is_null());
  EXPECT_THAT(Simulate({Scene(kSine), "--duration", "50ms"}).out,
              HasSubstr("note: rise and latency are not known: the drive is on for less than 20 "));
}

// the window of three periods reads 2.34 ms before the drive
TEST_F(SimulateDrives, TellsNoLatencyBeforeTheDrive) {
  std::ifstream fixture(kFixtures + "/lra_direct.toml");
  std::string text{std::istreambuf_iterator<char>(fixture), {}};
  const std::string at_225 = "frequency_hz = 225";
  text.replace(text.find(at_225), at_225.size(), "frequency_hz = 60");
  std::ofstream(Path("slow.toml")) << text;
  const json rise = Answer({Path("slow.toml"), "--duration", "1s"}).at("rise");
  EXPECT_EQ(rise.at("latency_s").get<double>(), 0);
  EXPECT_EQ(rise.at("latency_below_s"), rise.at("standard_uncertainty_s"));
  EXPECT_THAT(Simulate({Path("slow.toml"), "--duration", "1s"}).out, HasSubstr(" 2.45 ms\n"));
}

TEST_F(SimulateDrives, TellsTheLeastContactForceAndTheEfficiency) {
  // steady: preload less the force's amplitude; Bs (w x)^2 over the power
  const json steady = Answer({Scene(kSine)});
  EXPECT_REL(steady.at("contact_force_least_n").get<double>(),
             0.07 - steady.at("skin_force_peak_n").get<double>(), 1e-12, "rounding");
  const double speed = 2 * std::numbers::pi * 225 * steady.at("skin_rms_m").get<double>();
  EXPECT_REL(steady.at("efficiency").get<double>(),
             0.75 * speed * speed / steady.at("power_w").get<double>(), 1e-12, "rounding");
  // contact that breaks: nothing presses in flight
  const json broken = Answer({Scene(kSine,
                                    "[effects]\ncontact_loss = true\n[run]\n"
                                    "duration_s = 0.1\n")});
  EXPECT_ABS(broken.at("contact_force_least_n").get<double>(), 0, 1e-12, "rounding of 0.3 N");
  EXPECT_THAT(Simulate({Scene(kSine, "[effects]\ncontact_loss = true\n")}).out,
              HasSubstr("least force on the skin"));
}

TEST_F(SimulateDrives, SaysThatPowerIncludesTheSource) {
  const Outcome outcome = Simulate({Scene(kSine + "source_resistance_ohm = 10\n")});
  EXPECT_THAT(outcome.out, HasSubstr("5 V at 225 Hz through 10 ohm"));
  EXPECT_THAT(outcome.out, HasSubstr("ahead of its 10 ohm, which power and phase include"));
}

TEST_F(SimulateDrives, WritesWaveformsOfEveryKind) {
  const std::string scene = Scene(kBurst, "[sensor]\nkind = 'stream'\ntarget = 'mover'\n");
  std::vector<double> first;
  for (const char* name : {"w.csv", "w.h5", "w.bin"}) {
    const json answer =
        Answer({scene, "--duration", "50ms", "--rate", "20kHz", "--waveforms", Path(name)});
    EXPECT_EQ(answer.at("waveforms"), Path(name));
    const auto recording = trial::ReadRecording(Path(name));
    ASSERT_TRUE(recording) << recording.error().Text();
    const trial::Record& record = recording->record;
    EXPECT_EQ(record.rows, 1001U);
    EXPECT_EQ(record.stretches.at(0).rate_hz, 20000);
    ASSERT_EQ(record.channels.size(), 11U);
    EXPECT_EQ(record.channels[0].role, trial::ChannelRole::kDisplacement);
    EXPECT_EQ(record.channels[1].role, trial::ChannelRole::kVoltage);
    EXPECT_EQ(record.channels[2].role, trial::ChannelRole::kCurrent);
    EXPECT_EQ(record.channels[3].name, "mover_m");
    EXPECT_EQ(record.channels[3].unit, "m");
    EXPECT_EQ(record.channels[9].name, "force_n");
    EXPECT_EQ(record.channels[9].unit, "N");
    EXPECT_EQ(record.channels[0].values, record.channels[3].values) << "the sensor's target";
    EXPECT_EQ(record.metadata.laser_spot, "mover");
    EXPECT_EQ(record.channels[1].values[199], 0) << "the burst begins at row 200";
    if (first.empty()) first = record.channels[7].values;
    EXPECT_EQ(record.channels[7].values, first) << name;
  }
  std::ifstream csv(Path("w.csv"));
  std::stringstream text;
  text << csv.rdbuf();
  EXPECT_THAT(text.str(),
              HasSubstr("\ntime_s,displacement_m,voltage_v,current_a,mover_m,mover_m_per_s,case_m,"
                        "case_m_per_s,skin_m,skin_m_per_s,force_n,events\n0,0,0,0,"));
}

// read by analyze as a recording with its drive
TEST_F(SimulateDrives, WaveformsAreATrialForAnalyze) {
  const std::string scene = Scene(kSine);
  ASSERT_EQ(Simulate({scene, "--waveforms", Path("w.bin"), "--duration", "1s"}).status, 0);
  const Outcome analyzed = Captured(RunAnalyze, "analyze", {Path("w.bin"), "--json"});
  ASSERT_EQ(analyzed.status, 0) << analyzed.err;
  const json trial = json::parse(analyzed.out).at("trials").at(0);
  EXPECT_TRUE(trial.at("answered").get<bool>());
  EXPECT_REL(trial.at("band_rms_m").get<double>(),
             Answer({Scene(kSine)}).at("skin_rms_m").get<double>(), 2e-3,
             "what is left of the beginning");
}

TEST_F(SimulateDrives, DrawsWaveformsAndSpectrum) {
  const Outcome outcome =
      Simulate({Scene(kTones), "--duration", "0.3s", "--plot", Path("w.svg"), "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(json::parse(outcome.out).at("plot"), Path("w.svg"));
  std::ifstream svg(Path("w.svg"));
  std::stringstream text;
  text << svg.rdbuf();
  for (const char* title : {"the run", "its end", "at the coil", "spectrum of the skin"}) {
    EXPECT_THAT(text.str(), HasSubstr(title));
  }
}

TEST_F(SimulateDrives, DrawsASkinThatDoesNotVibrate) {
  const std::string silent = "[drive]\nkind = 'sine'\nfrequency_hz = 225\namplitude_v = 0\n";
  const Outcome outcome = Simulate({Scene(silent), "--duration", "0.1s", "--plot", Path("0.svg")});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_GT(fs::file_size(Path("0.svg")), 1000U);
}

TEST_F(SimulateDrives, RefusesFilesBeforeTheWork) {
  const auto expect = [](const Outcome& outcome, const std::string& text) {
    EXPECT_EQ(outcome.status, 2);
    EXPECT_THAT(outcome.err, HasSubstr(text));
  };
  const std::string scene = Scene(kSine);
  expect(Simulate({scene, "--waveforms", Path("w.txt")}), "use .csv, .h5 or .bin");
  expect(Simulate({scene, "--plot", Path("w.txt")}), "w.txt");
  expect(Simulate({scene, "--rate", "1kHz"}), "add --waveforms FILE");
  expect(Simulate({scene, "--rate", "0Hz", "--waveforms", Path("w.csv")}),
         "--rate: '0Hz' is not above 0");
  expect(Simulate({scene, "--rate", "1MHz", "--duration", "10s", "--waveforms", Path("w.csv")}),
         "10 s at 1e+06 Hz are 1e+07 rows; give a --duration or --rate for 1 to 2e+06");
  std::ofstream(Path("kept.csv")) << "the only copy";
  expect(Simulate({scene, "--waveforms", Path("kept.csv")}), "kept.csv");
  EXPECT_EQ(fs::file_size(Path("kept.csv")), 13U);
  expect(Simulate({scene, "--waveforms", Path("kept.csv"), "--overwrite"}), "is not a table");
  EXPECT_EQ(fs::file_size(Path("kept.csv")), 13U);
  std::ofstream(Path("kept.csv")) << "time_s,displacement_m\n";
  EXPECT_EQ(Simulate({scene, "--waveforms", Path("kept.csv"), "--overwrite"}).status, 0);
}

TEST_F(SimulateDrives, OthersNameWhatTheyCannotTake) {
  const Outcome tuned = Captured(RunTune, "tune", {Scene(kBurst)});
  EXPECT_EQ(tuned.status, 3);
  EXPECT_THAT(tuned.err, HasSubstr("drives with a burst, and tune takes a sine alone"));
}

TEST_F(SimulateDrives, ASweepHasTheRunUnderABurst) {
  const std::string scene = Scene(kBurst, "[run]\nduration_s = 0.1\n");
  const Outcome swept = Captured(RunSweep, "sweep",
                                 {scene, "--vary", "drive.amplitude_v=1,2", "-o", Path("s.csv"),
                                  "--best", "run_skin_rms_m", "--json"});
  ASSERT_EQ(swept.status, 0) << swept.err;
  EXPECT_EQ(json::parse(swept.out).at("answered"), 2);
  const double rms_m = Answer({scene}).at("run").at("skin_rms_m").get<double>();
  std::ifstream table(Path("s.csv"));
  std::stringstream text;
  text << table.rdbuf();
  EXPECT_THAT(text.str(), HasSubstr("the drive is not a sine: its numbers are those of run_"));
  EXPECT_REL(json::parse(swept.out).at("best").at("value").get<double>(), rms_m * 2 / 5, 1e-12,
             "linear");
}

TEST_F(SimulateDrives, ASensorRecordsABurst) {
  const Outcome outcome = Simulate({Scene(kBurst), "-o", Path("t.bin"), "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto recording = trial::ReadRecording(Path("t.bin"));
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->record.metadata.drive_frequency_hz, 225);
  EXPECT_EQ(recording->record.metadata.drive_amplitude_v, 5);
  const std::vector<double>& seen_m = recording->record.channels[0].values;
  EXPECT_EQ(std::count(seen_m.begin(), seen_m.begin() + 100, 0.0), 100) << "rest before 0.01 s";
  EXPECT_GT(*std::max_element(seen_m.begin(), seen_m.end()), 50e-6);
}

}  // namespace
}  // namespace haptometer::tools
