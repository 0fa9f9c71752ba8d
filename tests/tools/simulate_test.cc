#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/residual.h"
#include "tests/tools/captured.h"
#include "tools/verbs.h"
#include "trial/trial_reader.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

const std::string kFixtures = HAPTOMETER_FIXTURES;

Outcome Simulate(const std::vector<std::string>& words) {
  return Captured(RunSimulate, "simulate", words);
}

// the finding of a kind; null where there is none
json FindingOfKind(const json& answer, const std::string& kind) {
  for (const json& finding : answer.at("findings")) {
    if (finding.at("kind") == kind) return finding;
  }
  return nullptr;
}

class SimulateVerb : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(directory_); }
  void TearDown() override { fs::remove_all(directory_); }
  std::string Path(const std::string& name) const { return directory_ / name; }
  // the cone scene with something appended
  std::string Scene(const std::string& more) const {
    std::ifstream base(kFixtures + "/lra_cone.toml");
    std::ofstream scene(Path("scene.toml"));
    scene << base.rdbuf() << more;
    return Path("scene.toml");
  }
  const fs::path directory_ =
      fs::path(::testing::TempDir()) / ("simulate_test_" + std::to_string(::getpid()));
};

TEST_F(SimulateVerb, DoubtsNumbersThatAreMostlyAnErrorOfUnit) {
  std::ifstream base(kFixtures + "/lra_adapter.toml");
  std::string text{std::istreambuf_iterator<char>(base), {}};
  const auto replace = [&](const std::string& old, const std::string& with) {
    const auto at = text.find(old);
    ASSERT_NE(at, std::string::npos) << old;
    text.replace(at, old.size(), with);
  };
  replace("skin_side_mass_kg = 4.35e-3", "skin_side_mass_kg = 4.35");
  replace("frequency_hz = 225", "frequency_hz = \"225kHz\"");
  std::ofstream(Path("units.toml")) << text;
  const Outcome doubted = Simulate({Path("units.toml")});
  EXPECT_EQ(doubted.status, 0);
  EXPECT_THAT(doubted.out,
              AllOf(HasSubstr("doubt: adapter.skin_side_mass_kg = 4.35 is unusual, usual are "
                              "1e-05 to 0.1: was another unit meant?"),
                    HasSubstr("doubt: the drive's frequency in Hz = 225000 is unusual")));
  for (const char* name : {"adapter", "cone", "direct", "stops", "burst"}) {
    const json usual = json::parse(Simulate({kFixtures + "/lra_" + name + ".toml", "--json"}).out);
    EXPECT_EQ(FindingOfKind(usual, "unusual-number"), nullptr) << name;
  }
}

TEST_F(SimulateVerb, AnswersTheThreeScenes) {
  const std::vector<std::pair<std::string, double>> bars = {
      {kFixtures + "/lra_adapter.toml", 0.2001762058e-3},
      {kFixtures + "/lra_cone.toml", 0.0461001664e-3},
      {kFixtures + "/lra_direct.toml", 0.04499108754e-3}};
  for (const auto& [path, rms_m] : bars) {
    const Outcome outcome = Simulate({path, "--json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json answer = json::parse(outcome.out);
    EXPECT_REL(answer.at("skin_rms_m").get<double>(), rms_m, 1e-9, "the bar");
    EXPECT_LT(answer.at("error_estimate").get<double>(), 1e-12);
    EXPECT_TRUE(answer.at("window_rms_m").is_null());
    EXPECT_TRUE(answer.at("trial").is_null());
  }
}

TEST_F(SimulateVerb, HasTheKeysThatScriptsRelyOn) {
  const Outcome outcome =
      Simulate({kFixtures + "/lra_adapter.toml", "--duration", "0.1s", "--json"});
  const json answer = json::parse(outcome.out);
  for (const char* key : {"skin_rms_m", "mover_peak_m", "case_rms_m", "current_rms_a", "power_w",
                          "phase_rad", "error_estimate", "window_rms_m"}) {
    EXPECT_TRUE(answer.at(key).is_number()) << key;
  }
  EXPECT_TRUE(answer.at("method").is_string());
  for (const char* kind : {"linear", "contact-kept", "source-holds-voltage"}) {
    EXPECT_EQ(FindingOfKind(answer, kind).at("severity"), "note") << kind;
  }
  EXPECT_EQ(answer.at("provenance").at("inputs").at(0).at("path"), kFixtures + "/lra_adapter.toml");
  EXPECT_ABS(answer.at("window_rms_m").get<double>(), 0.1912e-3, 0.00005e-3, "the bar, 3 digits");
  EXPECT_REL(answer.at("window_s").at(0).get<double>(), 0.1 - 10 / 225.0, 1e-12, "last 10 periods");
}

TEST_F(SimulateVerb, PrintsTravelForceAndAssumptionsForPeople) {
  const Outcome outcome = Simulate({kFixtures + "/lra_adapter.toml"});
  EXPECT_EQ(outcome.status, 0);
  for (const char* line : {"  skin displacement (RMS)   ", " 200.176 um\n", " 826.268 um\n",
                           " -0.869513 degrees\n", " a preload of at least 0.3449 N"}) {
    EXPECT_THAT(outcome.out, HasSubstr(line));
  }
  EXPECT_EQ(outcome.err, "");
}

TEST_F(SimulateVerb, OfLessThanTenPeriodsHasNoWindow) {
  const Outcome outcome = Simulate({kFixtures + "/lra_cone.toml", "--duration", "44ms", "--json"});
  EXPECT_EQ(outcome.status, 0);
  const json answer = json::parse(outcome.out);
  EXPECT_TRUE(answer.at("window_rms_m").is_null());
  EXPECT_REL(FindingOfKind(answer, "no-window").at("numbers").at("run_s").get<double>(), 0.044,
             1e-12, "as stated");
}

// from rest at 0.1 s the start is still heard; from the steady state it is not
TEST_F(SimulateVerb, StartsAsTheSceneSays) {
  const std::string steady = Scene("[run]\nduration_s = 0.1\nstart = 'steady'\n");
  const json answer = json::parse(Simulate({steady, "--json"}).out);
  EXPECT_REL(answer.at("window_rms_m").get<double>(), answer.at("skin_rms_m").get<double>(), 1e-12,
             "ten whole periods of the steady state");
}

TEST_F(SimulateVerb, WritesWhatAnIdealSensorSees) {
  const Outcome outcome =
      Simulate({kFixtures + "/lra_adapter.toml", "-o", Path("t.bin"), "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json answer = json::parse(outcome.out);
  EXPECT_EQ(FindingOfKind(answer, "ideal-sensor").at("numbers").at("rate_hz"), 1e4);
  EXPECT_EQ(FindingOfKind(answer, "duration-assumed").at("numbers").at("duration_s"), 1);
  EXPECT_EQ(answer.at("trial"), Path("t.bin"));
  const auto recording = trial::ReadRecord(Path("t.bin"));
  ASSERT_TRUE(recording) << recording.error().Text();
  const trial::Record& record = recording->record;
  EXPECT_EQ(record.rows, 10000U);
  EXPECT_EQ(record.stretches.at(0).rate_hz, 1e4);
  EXPECT_EQ(record.metadata.laser_spot, "skin");
  EXPECT_THAT(record.metadata.source, HasSubstr("simulated"));
  // 225 whole periods
  double sum = 0;
  for (const double value : record.channels.at(0).values) sum += value * value;
  EXPECT_REL(std::sqrt(sum / 1e4), 0.2001762058e-3, 1e-9, "the bar, sampled over whole periods");
}

TEST_F(SimulateVerb, WritesAQuantisedSensorInWholeSteps) {
  const std::string scene = Scene("[sensor]\nkind = 'stream'\nrange_m = '50um'\n");
  ASSERT_EQ(Simulate({scene, "--duration", "0.1s", "-o", Path("t.bin")}).status, 0);
  const auto recording = trial::ReadRecord(Path("t.bin"));
  ASSERT_TRUE(recording) << recording.error().Text();
  const trial::Channel& channel = recording->record.channels.at(0);
  EXPECT_EQ(channel.resolution, 1e-7);
  std::size_t beyond = 0;
  for (std::size_t row = 0; row < recording->record.rows; ++row) {
    if (!trial::IsMeasurement(channel.statuses[row])) {
      ++beyond;
      EXPECT_TRUE(std::isnan(channel.values[row]));
      continue;
    }
    const double steps = channel.values[row] / 1e-7;
    EXPECT_ABS(steps, std::round(steps), 1e-9, "whole steps");
    EXPECT_LE(std::abs(channel.values[row]), 50e-6 * (1 + 1e-12));
  }
  // 46 um RMS peaks at 65 um
  EXPECT_GT(beyond, 200U);
}

TEST_F(SimulateVerb, GivesTheSameTrialTwiceButForItsProvenance) {
  const std::string scene = Scene("[sensor]\nkind = 'il-030'\nseed = 3\n");
  std::vector<std::string> exported;
  for (const char* name : {"a.bin", "b.bin"}) {
    ASSERT_EQ(Simulate({scene, "--duration", "0.2s", "-o", Path(name)}).status, 0);
    auto recording = trial::ReadRecord(Path(name));
    ASSERT_TRUE(recording) << recording.error().Text();
    trial::Metadata& metadata = recording->record.metadata;
    EXPECT_THAT(metadata.command_line, AllOf(HasSubstr("haptometer simulate "), HasSubstr(name)));
    EXPECT_THAT(metadata.fields.at("version"), HasSubstr("haptometer "));
    EXPECT_THAT(metadata.fields.at("input_1"), HasSubstr("scene.toml, "));
    EXPECT_THAT(metadata.fields.at("input_1"), HasSubstr("SHA-256 "));
    metadata.command_line.clear();
    EXPECT_EQ(metadata.fields.erase("simulated_utc"), 1U);
    const trial::Channel& channel = recording->record.channels.at(0);
    std::string& bytes = exported.emplace_back();
    bytes.append(reinterpret_cast<const char*>(channel.values.data()),
                 channel.values.size() * sizeof(double));
    bytes.append(reinterpret_cast<const char*>(channel.statuses.data()), channel.statuses.size());
    for (const auto& [key, value] : metadata.fields) bytes += key + "=" + value + "\n";
  }
  EXPECT_GT(exported[0].size(), 1000U);
  EXPECT_EQ(exported[0], exported[1]);
}

// frequencies of their own: over a long time their powers add
TEST_F(SimulateVerb, TremorAddsToASteadyMotion) {
  const std::string tremor =
      "[tremor]\namplitude_m = 1e-4\nfrequency_hz = 8.3\n[effects]\ntremor = true\n";
  const auto answer = [&](const std::string& scene) {
    return json::parse(Simulate({scene, "--json"}).out);
  };
  const auto number = [](const json& of, const char* key) { return of.at(key).get<double>(); };
  const json both = answer(Scene(tremor));
  EXPECT_THAT(both.at("method").get<std::string>(), HasSubstr("linear model, superposed"));
  EXPECT_TRUE(both.at("run").at("window_s").is_null()) << "its numbers are over all time";
  const json drive = answer(Scene(""));
  std::ifstream written(Scene(tremor));
  std::string text(std::istreambuf_iterator<char>(written), {});
  const std::size_t at = text.find("amplitude_v");
  text.replace(at, text.find('\n', at) - at, "amplitude_v = 1e-9");
  std::ofstream(Path("still.toml")) << text;
  const json still = answer(Path("still.toml"));
  const double tremor_m = number(still, "skin_rms_m");
  EXPECT_GT(tremor_m, 5e-5);
  EXPECT_REL(number(both, "skin_rms_m"), std::hypot(number(drive, "skin_rms_m"), tremor_m), 1e-12,
             "superposition");
  // once in a while both forces are least together; 1e-9 V adds 2e-10 of the drive's
  EXPECT_REL(number(both, "contact_force_least_n"),
             number(drive, "contact_force_least_n") + number(still, "contact_force_least_n"), 1e-9,
             "superposition");
  // powers of two frequencies add: those of skin and source
  const auto skin_w = [&](const json& of) {
    return number(of, "efficiency") * number(of, "power_w");
  };
  EXPECT_REL(skin_w(both), skin_w(drive) + skin_w(still), 1e-9, "superposition");
}

TEST_F(SimulateVerb, TellsInOneLineWhatItCannotDo) {
  const std::string cone = kFixtures + "/lra_cone.toml";
  const auto expect = [](const Outcome& outcome, int status, const std::string& text) {
    EXPECT_EQ(outcome.status, status);
    EXPECT_EQ(outcome.out, "");
    EXPECT_THAT(outcome.err, HasSubstr(text));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  };
  expect(Simulate({"/no/such.toml"}), 3, "haptometer simulate: /no/such.toml: no such file");
  expect(Simulate({cone, "--duration", "-1s"}), 2,
         "--duration: '-1s' is not above 0 and at most 1000000 s");
  expect(Simulate({cone, "--duraton", "1s"}), 2, "did you mean --duration?");
  expect(Simulate({Scene("[effects]\ntremor = true\n")}), 2, "tremor: needs [tremor]");
  // options of another option that is not there
  expect(Simulate({cone, "--quantity", "mover_peak_m"}), 2,
         "--quantity: applies to --explain only");
  expect(Simulate({cone, "--overwrite"}), 2, "--overwrite: applies to files that are written");
  expect(
      Simulate({Scene("[sensor]\nkind = 'ideal'\n"), "--duration", "100000s", "-o", Path("t.bin")}),
      2, "100000 s at 10000 Hz are 1e+09 readings");
  // a kept file stays, unless told otherwise
  std::ofstream(Path("kept.bin")) << "the only copy";
  const std::string sensed = Scene("[sensor]\nkind = 'ideal'\n[run]\nduration_s = 0.05\n");
  expect(Simulate({sensed, "-o", Path("kept.bin")}), 2, "kept.bin: already exists");
  EXPECT_EQ(fs::file_size(Path("kept.bin")), 13U);
  // and a file that is no trial stays even then
  expect(Simulate({sensed, "-o", Path("kept.bin"), "--overwrite"}), 2, "is not a trial.bin");
  EXPECT_EQ(fs::file_size(Path("kept.bin")), 13U);
  EXPECT_EQ(Simulate({sensed, "-o", Path("own.bin")}).status, 0);
  const auto bytes = fs::file_size(Path("own.bin"));
  EXPECT_GT(bytes, 1000U);
  EXPECT_EQ(Simulate({sensed, "--duration", "0.1s", "-o", Path("own.bin"), "--overwrite"}).status,
            0);
  EXPECT_GT(fs::file_size(Path("own.bin")), bytes);
}

TEST_F(SimulateVerb, PlaysASceneWithStops) {
  const std::string stops = kFixtures + "/lra_stops.toml";
  const Outcome outcome = Simulate({stops, "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json answer = json::parse(outcome.out);
  EXPECT_TRUE(answer.at("skin_rms_m").is_null()) << "the linear steady motion is not reached";
  EXPECT_TRUE(answer.at("mover_peak_m").is_null());
  EXPECT_EQ(answer.at("window_rms_m"), answer.at("run").at("skin_rms_m"));
  // gravity moves the mover by Mv g / Kv = 4.9 um towards one stop
  EXPECT_REL(answer.at("run").at("mover_peak_m").get<double>(), 0.4e-3 + 1.4e-3 * 9.80665 / 2800,
             1e-12, "it meets the farther stop");
  EXPECT_EQ(answer.at("run").at("events").at(0).at("name"), "impact up");
  EXPECT_LT(answer.at("run").at("energy_imbalance").get<double>(), 1e-9);
  const json& effects = answer.at("effects");
  EXPECT_TRUE(effects.at("travel_stops").at("on").get<bool>());
  EXPECT_FALSE(effects.at("contact_loss").at("on").get<bool>());
  EXPECT_EQ(effects.at("contact_loss").at("change"), 0);
  EXPECT_TRUE(effects.at("gravity").at("change").is_null()) << "kept, and not compared";
  const json exact = json::parse(Simulate({stops, "--accuracy", "1e-6", "--json"}).out);
  // six digits are a millionth
  const json by_digits = json::parse(Simulate({stops, "--digits", "6", "--json"}).out);
  EXPECT_EQ(by_digits.at("run"), exact.at("run"));
  EXPECT_EQ(by_digits.at("effects"), exact.at("effects"));
}

TEST_F(SimulateVerb, ExplainsEachEffect) {
  const Outcome outcome = Simulate({kFixtures + "/lra_stops.toml", "--explain"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("effects, for an accuracy of 0.001"));
  EXPECT_THAT(outcome.out, HasSubstr("no, never reached, proved between samples too"));
  EXPECT_THAT(outcome.out, HasSubstr("yes, without it skin_rms_m changes by 0.0055"));
  EXPECT_THAT(outcome.out, HasSubstr("changes by 0.00017, less than the tolerance"));
  const json stops =
      json::parse(Simulate({kFixtures + "/lra_stops.toml", "--explain", "--json"}).out);
  EXPECT_EQ(stops.at("effects").at("contact_loss").at("ground"), "never reached");
  EXPECT_EQ(stops.at("explained").at(0).at("effect"), "inductance");
  EXPECT_GT(stops.at("explained").at(0).at("with_s").get<double>(), 0);
  // of a scene that names no effect as well
  const json linear =
      json::parse(Simulate({kFixtures + "/lra_adapter.toml", "--explain", "--json"}).out);
  EXPECT_THAT(FindingOfKind(linear, "linear").at("text").get<std::string>(),
              HasSubstr("compare the mover's travel with its stops"));
  EXPECT_EQ(linear.at("effects").at("inductance").at("ground"), "named");
  EXPECT_ABS(linear.at("explained").at(0).at("change").get<double>(), 6.6e-5, 0.05e-5,
             "two digits of what was shown before");
}

// each accuracy is kept, and a scene that the solver plays takes more steps for more digits
TEST_F(SimulateVerb, ExplainsWhatAnAccuracyCosts) {
  const std::string scene =
      Scene("[effects]\nstiffening = true\n[stiffening]\ncubic_n_per_m3 = 3e9\n");
  const json answer =
      json::parse(Simulate({scene, "--duration", "50ms", "--explain", "--json"}).out);
  const json& accuracies = answer.at("accuracies");
  ASSERT_EQ(accuracies.size(), 5U);
  for (const json& row : accuracies) {
    EXPECT_LE(row.at("error_estimate"), row.at("accuracy"));
    EXPECT_GT(row.at("answer_s"), 0);
  }
  EXPECT_GT(accuracies.back().at("solver_steps"), accuracies.front().at("solver_steps"));
  const Outcome linear = Simulate({kFixtures + "/lra_adapter.toml", "--explain"});
  EXPECT_THAT(linear.out, HasSubstr("what an accuracy costs, best time of three answers"));
}

// without a duration: what the scene settles to
TEST_F(SimulateVerb, FindsThePeriodicMotionUnderStops) {
  const std::string scene =
      Scene("[effects]\ntravel_stops = true\n[travel_stops]\ngap_m = '50um'\nrestitution = 0.5\n");
  const Outcome outcome = Simulate({scene, "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json answer = json::parse(outcome.out);
  EXPECT_REL(answer.at("mover_peak_m").get<double>(), 50e-6, 1e-15, "one rounding of the unit");
  EXPECT_TRUE(answer.at("phase_rad").is_null());
  EXPECT_EQ(answer.at("skin_rms_m"), answer.at("run").at("skin_rms_m"));
  EXPECT_GE(answer.at("periodic").at("drive_periods").get<int>(), 1);
  EXPECT_THAT(Simulate({scene}).out, HasSubstr("drive periods per repetition"));
}

// windows of the motion with stops and without are of different length
TEST_F(SimulateVerb, AWaveformThatAStopMayChangeIsCompared) {
  std::ifstream base(kFixtures + "/lra_adapter.toml");
  std::ofstream scene(Path("auto.toml"));
  scene << base.rdbuf()
        << "[effects]\ntravel_stops = 'auto'\n[travel_stops]\ngap_m = '0.4mm'\n"
           "stiffness_n_per_m = 1e6\ndamping_n_s_per_m = 0\n"
           "[run]\nquantity = 'skin_waveform_m'\n";
  scene.close();
  const Outcome outcome = Simulate({Path("auto.toml"), "--json", "--accuracy", "1e-6"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(json::parse(outcome.out).at("periodic").at("drive_periods"), 6);
}

// undamped compliant stops, between which the adapter scene repeats itself every six periods
TEST_F(SimulateVerb, NumbersAreOfWholePeriodsOfTheMotion) {
  std::ifstream base(kFixtures + "/lra_adapter.toml");
  std::ofstream scene(Path("six.toml"));
  scene << base.rdbuf()
        << "[effects]\ntravel_stops = true\n[travel_stops]\ngap_m = '0.4mm'\n"
           "stiffness_n_per_m = 1e6\ndamping_n_s_per_m = 0\n";
  scene.close();
  const Outcome settled = Simulate({Path("six.toml"), "--json"});
  ASSERT_EQ(settled.status, 0) << settled.err;
  const json steady = json::parse(settled.out);
  EXPECT_EQ(steady.at("periodic").at("drive_periods"), 6);
  // by tests/sim/reference/scene_reference.cc
  EXPECT_REL(steady.at("skin_rms_m").get<double>(), 7.536454150263104e-05, 1e-12,
             "another integrator in long double");
  EXPECT_LT(steady.at("error_estimate").get<double>(), 1e-9);

  // a run that ends there: its numbers are of twelve periods, the window stays ten of the drive
  const Outcome played = Simulate({Path("six.toml"), "--json", "--duration", "3s"});
  ASSERT_EQ(played.status, 0) << played.err;
  const json answer = json::parse(played.out);
  const json& run = answer.at("run");
  EXPECT_EQ(run.at("drive_periods"), 6);
  EXPECT_TRUE(run.at("window_relative_uncertainty").is_null());
  EXPECT_REL(run.at("skin_rms_m").get<double>(), steady.at("skin_rms_m").get<double>(), 1e-10,
             "3 s of transient");
  EXPECT_ABS(run.at("window_s").at(0).get<double>(), 3 - 12 / 225.0, 1e-12, "rounding of times");
  EXPECT_ABS(answer.at("window_s").at(0).get<double>(), 3 - 10 / 225.0, 1e-12, "rounding of times");
  // which ten periods of the drive miss
  const double of_ten = answer.at("window_rms_m").get<double>();
  EXPECT_GT(std::abs(of_ten / run.at("skin_rms_m").get<double>() - 1), 0.01);
  EXPECT_THAT(Simulate({Path("six.toml"), "--duration", "3s"}).out,
              HasSubstr("drive periods per repetition     6\n"));
}

// contact that breaks under little preload never repeats itself
TEST_F(SimulateVerb, AChaoticMotionIsAnsweredByAverages) {
  std::ifstream base(kFixtures + "/lra_direct.toml");
  std::ofstream scene(Path("chaotic.toml"));
  std::string text(std::istreambuf_iterator<char>(base), {});
  const std::string skin = "[skin]\n";
  text.insert(text.find(skin) + skin.size(), "preload_n = 0.07\n");
  scene << text << "[effects]\ncontact_loss = true\n";
  scene.close();
  const Outcome outcome = Simulate({Path("chaotic.toml"), "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json answer = json::parse(outcome.out);
  EXPECT_TRUE(answer.at("periodic").is_null());
  const json& average = answer.at("average");
  EXPECT_GT(average.at("lyapunov_exponent_per_period").get<double>(),
            4 * average.at("lyapunov_exponent_standard_uncertainty").get<double>());
  const double rms_m = answer.at("skin_rms_m").get<double>();
  const double uncertainty_m = average.at("skin_rms_standard_uncertainty_m").get<double>();
  EXPECT_GT(uncertainty_m, 1e-6 * rms_m);
  EXPECT_GE(answer.at("error_estimate").get<double>(), uncertainty_m / rms_m * (1 - 1e-9));
  EXPECT_EQ(FindingOfKind(answer, "chaotic").at("numbers").at("periods"),
            average.at("drive_periods"));
  // all that stands under `run` is of these periods too
  const json& run_of = answer.at("run");
  const double span_s = average.at("drive_periods").get<double>() / 225;
  EXPECT_EQ(run_of.at("window_s").at(0), 0);
  EXPECT_REL(run_of.at("window_s").at(1).get<double>(), span_s, 1e-14, "a quotient");
  EXPECT_EQ(run_of.at("skin_rms_m"), answer.at("skin_rms_m"));
  const json& event = run_of.at("events").at(0);
  EXPECT_GT(event.at("count").get<double>(), 100 * span_s) << "contact breaks once in two periods";
  // a long run of it has lost its digits
  const Outcome run = Simulate({Path("chaotic.toml"), "--duration", "2s"});
  EXPECT_EQ(run.status, 3);
  EXPECT_THAT(run.err, HasSubstr("beyond prediction"));
}

TEST_F(SimulateVerb, WritesAPage) {
  const Outcome outcome = Simulate(
      {kFixtures + "/lra_adapter.toml", "--duration", "0.1s", "--report", Path("page.html")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  std::ifstream file(Path("page.html"));
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  for (const char* part :
       {"skin displacement (RMS)", "<svg", "SHA-256", "contact is assumed to be kept"}) {
    EXPECT_THAT(page, HasSubstr(part));
  }
}

// a sensor over the scene sees what the run has
TEST_F(SimulateVerb, RecordsAMotionWithImpacts) {
  const std::string scene = Scene(
      "[sensor]\nkind = 'ideal'\ntarget = 'mover'\n[run]\nduration_s = 0.1\n[effects]\n"
      "travel_stops = true\n[travel_stops]\ngap_m = '50um'\nrestitution = 0.5\n");
  ASSERT_EQ(Simulate({scene, "-o", Path("t.bin")}).status, 0);
  auto reader = trial::TrialReader::Open(Path("t.bin"));
  ASSERT_TRUE(reader);
  EXPECT_THAT(reader->header().metadata.source, HasSubstr("scene with effects"));
}

// a skin without stiffness, which a constant voltage moves away: no steady state
TEST_F(SimulateVerb, ARunFromRestWithEffectsNeedsNoSteadyState) {
  std::ofstream(Path("drifts.toml"))
      << "[actuator]\nmoving_mass_kg = 1.4e-3\ncase_mass_kg = 0.6e-3\nstiffness_n_per_m = 2800\n"
         "damping_n_s_per_m = 0.0322\nforce_constant_n_per_a = 1\nresistance_ohm = 27\n"
         "inductance_h = 130e-6\n[skin]\nstiffness_n_per_m = 0\ndamping_n_s_per_m = 0.75\n"
         "[drive]\nkind = 'sine'\namplitude_v = 5\nfrequency_hz = 225\noffset_v = 0.1\n"
         "[effects]\ntravel_stops = true\n[travel_stops]\ngap_m = '5mm'\nrestitution = 0\n"
         "[run]\nduration_s = 0.1\nstart = 'rest'\n";
  const Outcome outcome = Simulate({Path("drifts.toml"), "--json"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(json::parse(outcome.out).at("window_rms_m").is_number()) << "22 periods";
}

// an error that is not within what was asked for is a doubt, whatever makes it
TEST_F(SimulateVerb, DoubtsAnAnswerThatIsNotKnownAsAsked) {
  std::ifstream base(kFixtures + "/lra_cone.toml");
  std::string text{std::istreambuf_iterator<char>(base), {}};
  const std::size_t at = text.find("frequency_hz = 225");
  ASSERT_NE(at, std::string::npos);
  std::ofstream(Path("slow.toml")) << text.replace(at, 18, "frequency_hz = 0.01");
  const auto doubt = [&](const char* accuracy) {
    const Outcome outcome = Simulate({Path("slow.toml"), "--accuracy", accuracy, "--json"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return FindingOfKind(json::parse(outcome.out), "error-above-asked");
  };
  EXPECT_FALSE(doubt("1e-10").is_null()) << "4e-7 of a motion of 1e-13 m";
  EXPECT_TRUE(doubt("1e-4").is_null());
}

TEST_F(SimulateVerb, SaysWhatItCannotDoWithEffects) {
  const std::string limited =
      Scene("[effects]\ntravel_stops = true\n[travel_stops]\ngap_m = '50um'\nrestitution = 0\n");
  EXPECT_EQ(Simulate({limited, "--accuracy", "2"}).status, 2);
  EXPECT_EQ(Simulate({limited, "--accuracy", "200%"}).status, 2);
  EXPECT_NE(Simulate({limited, "--accuracy", "5%"}).status, 2);
  EXPECT_EQ(Simulate({limited, "--accuracy", "1e-12"}).status, 2);
  EXPECT_EQ(Simulate({limited, "--digits", "12"}).status, 2);
  EXPECT_EQ(Simulate({limited, "--digits", "6", "--accuracy", "1e-6"}).status, 2);
  const Outcome idle =
      Simulate({Scene("[travel_stops]\ngap_m = '50um'\nrestitution = 0\n"), "--json"});
  EXPECT_EQ(idle.status, 0);
  EXPECT_FALSE(FindingOfKind(json::parse(idle.out), "effect-off").is_null());
  for (const char* unused :
       {"[gravity]\nacceleration_m_per_s2 = 9.8\n", "[stiffening]\ncubic_n_per_m3 = 3e9\n",
        "[coil_heating]\nheat_capacity_j_per_k = 0.02\n",
        "[tremor]\namplitude_m = 1e-4\nfrequency_hz = 9\n"}) {
    const json stated = json::parse(Simulate({Scene(unused), "--json"}).out);
    EXPECT_FALSE(FindingOfKind(stated, "effect-off").is_null()) << unused;
  }
  const std::string start = Scene("[start]\nmover_m = 1e-4\n");
  EXPECT_FALSE(
      FindingOfKind(json::parse(Simulate({start, "--json"}).out), "start-unused").is_null());
  EXPECT_THAT(Simulate({kFixtures + "/lra_adapter.toml", "--duration", "1e6s"}).out,
              HasSubstr("999999.95556 to 1000000 s, from rest"));
  // what the scene does not call for is not forced on where it is impossible
  const Outcome impossible =
      Simulate({Scene("[effects]\ngravity = true\n[travel_stops]\ngap_m = '4um'\n"
                      "restitution = 0\n"),
                "--explain"});
  EXPECT_EQ(impossible.status, 0) << impossible.err;
  EXPECT_EQ(Simulate({kFixtures + "/lra_adapter.toml", "--duration", "1e6s", "--explain"}).status,
            3);
  EXPECT_EQ(Simulate({limited, "--duration", "20ms"}).status, 0);
  const Outcome endless = Simulate({limited, "--duration", "1e6s"});
  EXPECT_EQ(endless.status, 3);
  EXPECT_THAT(endless.err, HasSubstr("shorten duration_s to 6.94e+03 s or less"));
}

}  // namespace
}  // namespace haptometer::tools
