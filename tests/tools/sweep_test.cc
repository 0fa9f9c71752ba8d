#include "tools/sweep/sweep.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "tests/tools/sweep_verb.h"

namespace haptometer::tools {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(SweepVerb, HasARowForEveryPointWithTheAnswersOfSimulate) {
  const std::vector<Row> rows = RowsOf(Table(kGrid, "t.csv"));
  ASSERT_EQ(rows.size(), 33U);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    EXPECT_EQ(rows[k].at("point"), std::to_string(k + 1));
    EXPECT_EQ(rows[k].at("drive.frequency_hz"), std::to_string(200 + 5 * (k / 3)));
    EXPECT_EQ(rows[k].at("remark"), "");
    EXPECT_EQ(rows[k].at("window_rms_m"), "");
  }
  // 225 Hz on 600 N/m is the scene itself: every bit of what simulate prints
  const Row& row = rows[15];
  EXPECT_EQ(row.at("skin.stiffness_n_per_m"), "600");
  const json answer = json::parse(Captured(RunSimulate, "simulate", {kAdapter, "--json"}).out);
  for (const AnswerColumn& column : AnswerColumns()) {
    const std::string& name = column.name;
    if (name.starts_with("run_") || name == "window_rms_m") {
      EXPECT_EQ(row.at(name), "") << name;
    } else {
      EXPECT_EQ(std::stod(row.at(name)), answer.at(name).get<double>()) << name;
    }
  }
}

// at either end of what is varied, each key once
TEST_F(SweepVerb, DoubtsUnusualNumbersOfItsEnds) {
  const auto said = [&](const std::string& masses) {
    return Sweep({kAdapter, "--vary", "adapter.skin_side_mass_kg=" + masses}, "m.csv",
                 {"--overwrite"})
        .out;
  };
  EXPECT_THAT(said("1g:5g:3"), Not(HasSubstr("is unusual")));
  EXPECT_THAT(said("5g:5kg:3"), HasSubstr("doubt: adapter.skin_side_mass_kg = 5 is unusual"));
  const std::string both = said("1kg:5kg:3");
  EXPECT_THAT(both, HasSubstr("doubt: adapter.skin_side_mass_kg = 1 is unusual"));
  EXPECT_THAT(both, Not(HasSubstr("= 5 is unusual")));
  // of many values those beside the ends: no mass at all is usual, and one of 8 mg is not
  EXPECT_THAT(Sweep({kAdapter, "--vary", "adapter.motor_side_mass_kg=0:0.0008:102"}, "m.csv",
                    {"--overwrite"})
                  .out,
              HasSubstr("doubt: adapter.motor_side_mass_kg = 7.92"));
}

// every value of a list, and both ends of what is sampled; a number without a unit is in the key's
TEST_F(SweepVerb, DoubtsUnusualNumbersAnywhereInAListAndAtTheEndsOfSamples) {
  const auto said = [&](const std::string& masses, const std::vector<std::string>& more) {
    std::vector<std::string> further{"--overwrite"};
    further.insert(further.end(), more.begin(), more.end());
    return Sweep({kAdapter, "--vary", "actuator.moving_mass_kg=" + masses}, "m.csv", further).out;
  };
  const std::string doubt = "doubt: actuator.moving_mass_kg = 1.4 is unusual";
  EXPECT_THAT(said("1g,1400g,2g", {}), HasSubstr(doubt));
  EXPECT_THAT(said("1e-3,1.4,2e-3", {}), HasSubstr(doubt));
  EXPECT_THAT(said("log:1g:1.4kg", {"--samples", "5", "--seed", "2"}), HasSubstr(doubt));
  EXPECT_THAT(said("1e-3:2e-3:3", {}), Not(HasSubstr("actuator.moving_mass_kg = ")));
}

// what simulate doubts of one answer, counted
TEST_F(SweepVerb, CountsRowsWhoseErrorIsAboveWhatIsAsked) {
  const std::string scene = File("quiet.toml", R"([actuator]
moving_mass_kg = 0.0001881058761176032
case_mass_kg = 0.07284245596182272
stiffness_n_per_m = 36618.04214753033
damping_n_s_per_m = 0.0009252610398112664
force_constant_n_per_a = 0.10564182083636273
resistance_ohm = 368.9283237375497
inductance_h = 2.1562662030306633e-06
[adapter]
motor_side_mass_kg = 0.001284821362697009
skin_side_mass_kg = 3.422241342828208e-05
stiffness_n_per_m = 883570.1826532123
damping_n_s_per_m = 0.006557865068108078
[skin]
stiffness_n_per_m = 281.3942479367663
damping_n_s_per_m = 0.14645658955994217
[drive]
kind = 'sine'
frequency_hz = 1.617146667982698
amplitude_v = 0.3
)");
  const std::vector<std::string> words{scene, "--vary", "drive.amplitude_v=1,2"};
  const Outcome above = Sweep(words, "q.csv", {"--accuracy", "1e-10"});
  EXPECT_THAT(above.out,
              HasSubstr("doubt: 2 of 2 answered rows are known to less than the required "
                        "accuracy, the first at point 1; the largest error is "
                        "2.001e-09"));
  const std::vector<Row> rows = RowsOf(Table(words, "r.csv"));
  EXPECT_EQ(rows[1].at("remark"), "the error is above the required accuracy of 1e-10");
  const Outcome within = Sweep(words, "s.csv", {"--accuracy", "1e-8"});
  EXPECT_THAT(within.out, Not(HasSubstr("known to less than")));
}

// the accuracy is that of simulate, in both spellings, and a part of the question
TEST_F(SweepVerb, KeepsTheAccuracyThatIsAsked) {
  std::ifstream adapter(kAdapter);
  const std::string linear{std::istreambuf_iterator<char>(adapter), {}};
  const std::string scene = File("scene.toml", linear +
                                                   "[run]\nduration_s = 0.05\ntolerance = 1e-9\n"
                                                   "[effects]\nstiffening = true\n"
                                                   "[stiffening]\ncubic_n_per_m3 = 1e9\n");
  const std::vector<std::string> words{scene, "--vary", "drive.amplitude_v=5"};
  const auto rms = [&](const std::string& name, const std::vector<std::string>& asked) {
    std::vector<std::string> all = words;
    all.insert(all.end(), asked.begin(), asked.end());
    return RowsOf(Table(all, name)).at(0).at("window_rms_m");
  };
  const std::string loose = rms("loose.csv", {"--digits", "3"});
  EXPECT_NE(loose, rms("plain.csv", {}));
  EXPECT_EQ(loose, rms("number.csv", {"--accuracy", "1e-3"}));
  EXPECT_EQ(rms("plain.csv", {"--overwrite"}), rms("same.csv", {"--accuracy", "1e-9"}));
  // every bit of what simulate prints
  const Outcome one = Captured(RunSimulate, "simulate", {scene, "--digits", "3", "--json"});
  EXPECT_EQ(std::stod(loose), json::parse(one.out).at("window_rms_m").get<double>());
  // another accuracy is another question
  EXPECT_THAT(Content("loose.csv"), HasSubstr("# accuracy = 0.001\n"));
  EXPECT_THAT(Content("plain.csv"), Not(HasSubstr("# accuracy")));
  EXPECT_EQ(Sweep(words, "loose.csv", {"--resume", "--digits", "4"}).status, 2);
  EXPECT_EQ(Sweep(words, "loose.csv", {"--resume", "--digits", "3"}).status, 0);
}

TEST_F(SweepVerb, RefusesTwoAccuracies) {
  const Outcome varied =
      Sweep({kAdapter, "--vary", "run.tolerance=1e-3,1e-6"}, "t.csv", {"--accuracy", "1e-4"});
  EXPECT_EQ(varied.status, 2);
  EXPECT_THAT(varied.err, HasSubstr("--vary run.tolerance"));
  EXPECT_EQ(Sweep(kGrid, "t.csv", {"--accuracy", "1e-4", "--digits", "4"}).status, 2);
}

// stops within the mover's travel: no steady motion, but the numbers of the run
TEST_F(SweepVerb, AnswersScenesWithEffects) {
  std::ifstream adapter(kAdapter);
  const std::string linear{std::istreambuf_iterator<char>(adapter), {}};
  const std::string scene = File("scene.toml", linear +
                                                   "[run]\nduration_s = 0.1\n"
                                                   "[effects]\ntravel_stops = true\n"
                                                   "[travel_stops]\nrestitution = 0.5\n");
  const std::vector<Row> rows =
      RowsOf(Table({scene, "--vary", "travel_stops.gap_m=0.3mm,2mm"}, "t.csv"));
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].at("skin_rms_m"), "");
  EXPECT_THAT(rows[0].at("remark"), HasSubstr("no linear steady motion holds"));
  EXPECT_EQ(rows[1].at("remark"), "");
  EXPECT_NE(rows[1].at("skin_rms_m"), "");
  EXPECT_EQ(rows[1].at("run_events"), "0");
  EXPECT_GT(std::stod(rows[0].at("run_events")), 10);

  const std::string tight = File("tight.toml", Content("scene.toml") + "gap_m = 0.3e-3\n");
  const json answer = json::parse(Captured(RunSimulate, "simulate", {tight, "--json"}).out);
  EXPECT_EQ(std::stod(rows[0].at("window_rms_m")), answer.at("window_rms_m").get<double>());
  double events = 0;
  for (const json& event : answer.at("run").at("events")) events += event.at("count").get<double>();
  for (const AnswerColumn& column : AnswerColumns()) {
    const std::string& name = column.name;
    if (!name.starts_with("run_")) continue;
    EXPECT_EQ(std::stod(rows[0].at(name)),
              name == "run_events" ? events : answer.at("run").at(name.substr(4)).get<double>())
        << name;
  }
}

TEST_F(SweepVerb, AnswersRunsWithTheirWindow) {
  const std::vector<Row> rows = RowsOf(
      Table({kAdapter, "--vary", "run.duration_s=10ms,0.1s", "--vary", "run.start=rest,steady"},
            "t.csv"));
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0].at("window_rms_m"), "");
  EXPECT_THAT(rows[0].at("remark"), HasSubstr("shorter than ten periods"));
  const json answer = json::parse(
      Captured(RunSimulate, "simulate", {kAdapter, "--duration", "0.1s", "--json"}).out);
  EXPECT_EQ(rows[2].at("run.start"), "rest");
  EXPECT_EQ(std::stod(rows[2].at("window_rms_m")), answer.at("window_rms_m").get<double>());
  EXPECT_NE(rows[3].at("window_rms_m"), rows[2].at("window_rms_m"));
}

TEST_F(SweepVerb, NamesItsQuestion) {
  const std::string table = Table(kSampled, "t.csv");
  for (const char* line : {"# haptometer sweep ", "\n# scene = lra_adapter.toml\n",
                           "\n# scene_digest = ", "\n# vary = drive.frequency_hz=100:400\n",
                           "\n# vary = skin.damping_n_s_per_m=log:0.75:2.38\n",
                           "\n# sampling = latin hypercube, 40 samples, seed 7\n",
                           "\n# points = 40\n", "\npoint,drive.freq"}) {
    EXPECT_THAT(table, HasSubstr(line));
  }
}

TEST_F(SweepVerb, HasItsProvenanceInTheTable) {
  (void)Table(kGrid, "t.csv");
  const std::string table = TemporaryFiles::Content("t.csv");
  for (const std::string& line :
       {std::string("\n# provenance: haptometer "),
        "\n# provenance: command: haptometer sweep " + kAdapter + " --vary ",
        "\n# provenance: input: " + kAdapter + ", "}) {
    EXPECT_THAT(table, HasSubstr(line));
  }
  // of the command that merges, with the tables of the shards as its inputs
  (void)Table(kGrid, "1.csv", {"--shard", "1/2"});
  (void)Table(kGrid, "2.csv", {"--shard", "2/2"});
  (void)Table({"--merge", Path("1.csv"), Path("2.csv")}, "whole.csv");
  const std::string merged = TemporaryFiles::Content("whole.csv");
  EXPECT_THAT(merged, HasSubstr("command: haptometer sweep --merge "));
  EXPECT_THAT(merged, HasSubstr("\n# provenance: input: " + Path("2.csv")));
  EXPECT_THAT(merged, Not(HasSubstr(" --vary ")));
}

TEST_F(SweepVerb, SamplesEachPartOfAKeyOnce) {
  const std::vector<Row> rows = RowsOf(Table(kSampled, "t.csv"));
  std::set<int> parts;
  for (const Row& row : rows) {
    parts.insert(static_cast<int>((std::stod(row.at("drive.frequency_hz")) - 100) / 7.5));
    EXPECT_GE(std::stod(row.at("skin.damping_n_s_per_m")), 0.75);
    EXPECT_LE(std::stod(row.at("skin.damping_n_s_per_m")), 2.38);
  }
  EXPECT_EQ(parts.size(), 40U);
  EXPECT_EQ(*parts.rbegin(), 39);
}

// each value is fine beside another one: only the row of the two together says what is wrong
TEST_F(SweepVerb, KeepsTheRowOfAPointWithoutAnAnswer) {
  const std::vector<std::string> words{kAdapter,
                                       "--vary",
                                       "sensor.kind=ideal",
                                       "--vary",
                                       "sensor.rate_hz=10000Hz,5000Hz",
                                       "--vary",
                                       "sensor.sampling_s=100us,200us"};
  const Outcome outcome = Sweep(words, "t.csv");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              HasSubstr("doubt: 1 of 4 points are not answered, the first: point 2: "));
  const std::vector<Row> rows = RowsOf(Content("t.csv"));
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_THAT(rows[1].at("remark"), HasSubstr("[sensor]: rate_hz: is not 1/sampling_s"));
  for (const AnswerColumn& column : AnswerColumns()) {
    EXPECT_EQ(rows[1].at(column.name), "");
  }
  EXPECT_NE(rows[2].at("skin_rms_m"), "");
}

TEST_F(SweepVerb, TellsTheBestRow) {
  const Outcome outcome = Sweep(kGrid, "t.csv", {"--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json answer = json::parse(outcome.out);
  EXPECT_EQ(answer.at("points"), 33);
  EXPECT_EQ(answer.at("rows"), 33);
  EXPECT_EQ(answer.at("answered"), 33);
  EXPECT_TRUE(answer.at("shard").is_null());
  EXPECT_TRUE(answer.at("plot").is_null());
  EXPECT_EQ(answer.at("varied").size(), 2U);
  EXPECT_EQ(answer.at("best").at("values").at("drive.frequency_hz"), 225);
  const std::vector<Row> rows = RowsOf(Content("t.csv"));
  double least = 1;
  for (const Row& row : rows) least = std::min(least, std::stod(row.at("power_w")));
  const json lowest =
      json::parse(Sweep(kGrid, "t.csv", {"--resume", "--json", "--best", "power_w:least"}).out);
  EXPECT_EQ(lowest.at("best").at("value").get<double>(), least);
  EXPECT_EQ(lowest.at("best").at("direction"), "least");
  const json none =
      json::parse(Sweep(kGrid, "t.csv", {"--resume", "--json", "--best", "window_rms_m"}).out);
  EXPECT_TRUE(none.at("best").is_null());
  EXPECT_THAT(Sweep(kGrid, "t.csv", {"--resume", "--best", "window_rms_m"}).out,
              HasSubstr("note: no row has a number in the column window_rms_m"));
  const std::string text = Sweep(kGrid, "t.csv", {"--resume"}).out;
  for (const char* line :
       {"  largest skin_rms_m      200.176 um\n", "  at point                16\n",
        "  drive.frequency_hz      225 Hz\n", "  skin.stiffness_n_per_m  600 N/m\n"}) {
    EXPECT_THAT(text, HasSubstr(line));
  }
}

TEST_F(SweepVerb, SaysWhichRowsTheBestWasComparedWith) {
  const Outcome outcome =
      Sweep({kAdapter, "--vary", "run.duration_s=10ms,0.1s"}, "t.csv", {"--best", "window_rms_m"});
  EXPECT_THAT(outcome.out, HasSubstr("note: 1 of 2 rows have a number in the column window_rms_m"));
}

TEST_F(SweepVerb, DrawsOneOrTwoKeys) {
  const auto drawn = [&](std::vector<std::string> words, const std::string& said) {
    words.insert(words.end(), {"--plot", Path("p.svg"), "--overwrite"});
    EXPECT_EQ(Sweep(words, "t.csv").status, 0);
    EXPECT_THAT(Content("p.svg"), HasSubstr(said));
  };
  const std::string hertz = "drive.frequency_hz=100:400:31";
  drawn({kCone, "--vary", hertz}, "drive frequency / Hz");
  drawn({kCone, "--vary", hertz}, "skin RMS / µm");
  drawn(kGrid, "skin stiffness 1200\u00a0N/m");
  drawn({kCone, "--vary", hertz, "--vary", "skin.stiffness_n_per_m=600:2000:15"}, "<image");
  drawn({kCone, "--vary", hertz, "--vary", "skin.stiffness_n_per_m=log:600:2000:15"},
        "skin stiffness 2000\u00a0N/m");
  drawn(kSampled, "skin damping / N s/m");
  drawn({kCone, "--vary", "run.start=rest,steady"}, "steady");
  Outcome outcome = Sweep(kGrid, "s.csv", {"--plot", Path("p.svg"), "--shard", "1/2"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr("draws whole sweeps, not a shard"));
  outcome = Sweep(kGrid, "s.csv", {"--plot", Path("p.gif")});
  EXPECT_THAT(outcome.err, HasSubstr("ending"));
  outcome = Sweep(kGrid, "s.csv", {"--plot", Path("p.svg"), "--vary", "drive.amplitude_v=1,2"});
  EXPECT_THAT(outcome.err, HasSubstr("draws one or two varied keys, not 3"));
  EXPECT_FALSE(std::filesystem::exists(Path("s.csv")));
}

TEST_F(SweepVerb, TakesAllKindsOfValues) {
  const std::vector<Row> rows =
      RowsOf(Table({kCone, "--vary", "drive.frequency_hz=0.2kHz,225", "--vary",
                    "effects.inductance=true", "--vary", "sensor.kind=ideal", "--vary",
                    "sensor.averages=1:4:4", "--vary", "sensor.latency_s=log:1us:1ms:4"},
                   "t.csv"));
  ASSERT_EQ(rows.size(), 32U);
  EXPECT_EQ(rows[0].at("drive.frequency_hz"), "200");
  EXPECT_EQ(rows[31].at("sensor.averages"), "4");
  EXPECT_EQ(rows[31].at("sensor.latency_s"), "0.001");
  EXPECT_EQ(rows[0].at("effects.inductance"), "true");
}

TEST_F(SweepVerb, RefusesBeforeAnyWork) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> faults{
      {{}, "has no scene"},
      {{kCone}, "--vary: is missing"},
      {{kCone, kAdapter, "--vary", "drive.frequency_hz=1,2"}, "is a second scene"},
      {{kCone, "--vary", "frequency_hz=1,2"},
       "--vary frequency_hz: is no key of a scene; name its table too, as drive.frequency_hz"},
      {{kCone, "--vary", "drive.frequency_hz"}, "'drive.frequency_hz' is not KEY=VALUES"},
      {{kCone, "--vary", "drive.frequency_hz="}, "is not KEY=VALUES"},
      {{kCone, "--vary", "drive.frequenzy_hz=1,2"}, "did you mean frequency_hz?"},
      {{kCone, "--vary", "driv.frequency_hz=1,2"}, "key driv is not known; did you mean drive?"},
      {{kCone, "--vary", "drive.frequency_hz=100,200", "--vary", "skin.stifness_n_per_m=1,2"},
       "--vary skin.stifness_n_per_m = 1: [skin]: key stifness_n_per_m is not known"},
      {{kCone, "--vary", "drive.frequency_hz=0:400:5"},
       "--vary drive.frequency_hz = 0: [drive]: frequency_hz: must be greater than 0"},
      {{kCone, "--vary", "drive.frequency_hz=400:0:5"}, "--vary drive.frequency_hz = 0: "},
      {{kCone, "--vary", "drive.frequency_hz=100,200,-1,300"}, "--vary drive.frequency_hz = -1: "},
      {{kCone, "--vary", "drive.frequency_hz=-1:400", "--samples", "9"}, "greater than 0"},
      {{kCone, "--vary", "sensor.kind=ideal", "--vary", "sensor.averages=1:3:4"},
       "is not a whole number"},
      {{kCone, "--vary", "drive.kind=sine,square"}, "--vary drive.kind = square: "},
      {{kCone, "--vary", "effects.tremor=false,true"}, "--vary effects.tremor = true: "},
      {{kCone, "--vary", "drive.frequency_hz=100V,200V"}, "'V' is not a unit of a frequency"},
      {{kCone, "--vary", "drive.frequency_hz=low,high"}, "'low' is not a frequency"},
      {{kCone, "--vary", "drive.amplitude_v=5.0(1),6"}, "has an uncertainty"},
      {{kCone, "--vary", "drive.amplitude_v=1,,2"}, "empty or not printable"},
      {{kCone, "--vary", "drive.amplitude_v=1:2"}, "is not BEGIN:END:COUNT"},
      {{kCone, "--vary", "drive.amplitude_v=1:2:3:4"}, "is not BEGIN:END:COUNT"},
      {{kCone, "--vary", "drive.amplitude_v=1:2:1"}, "'1' is not a count of values"},
      {{kCone, "--vary", "drive.amplitude_v=1:2:x"}, "'x' is not a count of values"},
      {{kCone, "--vary", "drive.amplitude_v=2:2:3"}, "ends between which there is nothing"},
      {{kCone, "--vary", "drive.amplitude_v=log:0:2:3"}, "reaches to 0 or below"},
      {{kCone, "--vary", "drive.amplitude_v=1:2:3", "--samples", "5"}, "is to be sampled"},
      {{kCone, "--vary", "drive.amplitude_v=1,2", "--seed", "5"}, "--seed: needs --samples"},
      {{kCone, "--vary", "drive.amplitude_v=1:2", "--samples", "0"}, "'0' is not a whole number"},
      {{kCone, "--vary", "drive.amplitude_v=1,2", "--vary", "drive.amplitude_v=3"},
       "--vary drive.amplitude_v: is given twice"},
      {{kCone, "--vary", "drive.kind.of=1"}, "leads through kind, which is not a table"},
      {{kCone, "--vary", "drive.amplitude_v=1:2:100000", "--vary", "drive.frequency_hz=1:2:100000"},
       "more than 1e+09 points"},
      {{kCone, "--vary", "drive.amplitude_v=1,2", "--shard", "0/3"}, "--shard: '0/3' is not I/N"},
      {{kCone, "--vary", "drive.amplitude_v=1,2", "--shard", "4/3"}, "'4/3' is not I/N"},
      {{kCone, "--vary", "drive.amplitude_v=1,2", "--shard", "2"}, "'2' is not I/N"},
      {{kCone, "--vary", "drive.amplitude_v=1,2", "--shard", "1/"}, "'1/' is not I/N"},
      {{kCone, "--vary", "drive.amplitude_v=1,2", "--best", "skin_rms"},
       "did you mean skin_rms_m?"},
      {{kCone, "--vary", "drive.amplitude_v=1,2", "--resume", "--overwrite"},
       "cannot be combined with --resume"},
      {{kCone, "--vary", "drive.amplitude_v=1,2", "--allow-mixed"},
       "--allow-mixed: applies to --resume, --merge and --slurm only"},
      {{kCone, "--vary", "drive.amplitude_v=1,2", "--campaign", Path("folder")},
       "--job-time, --campaign: apply to --slurm only"},
      {{kCone, "--vary", "drive.amplitude_v=1,2", "--job-time", "60s"},
       "--job-time, --campaign: apply to --slurm only"},
      {{"--merge", kCone, "--job-time", "60s"}, "joins tables and computes nothing"},
      {{"--merge", kCone, "--threads", "2"}, "joins tables and computes nothing"}};
  for (const auto& [words, said] : faults) {
    const Outcome outcome = Sweep(words, "t.csv");
    EXPECT_EQ(outcome.status, 2) << said << ": " << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(said));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_FALSE(std::filesystem::exists(Path("t.csv"))) << said;
  }
  EXPECT_THAT(Captured(RunSweep, "sweep", {kCone, "--vary", "drive.amplitude_v=1,2"}).err,
              HasSubstr("-o: is missing"));
  EXPECT_EQ(Sweep({"/no/such.toml", "--vary", "drive.amplitude_v=1,2"}, "t.csv").status, 3);
  EXPECT_EQ(Sweep({kCone, "--vary", "drive.amplitude_v=1,2"}, "no/such/t.csv").status, 2);
}

// a fault of the file itself is told with its line
TEST_F(SweepVerb, TellsAFaultOfTheSceneWithItsLine) {
  const std::string scene =
      File("scene.toml", "[actuator]\nmodel = 'thesis-c10-100'\n[skn]\na = 1\n");
  const Outcome outcome = Sweep({scene, "--vary", "drive.frequency_hz=1,2"}, "t.csv");
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr("scene.toml:3: key skn is not known; did you mean skin?"));
}

}  // namespace
}  // namespace haptometer::tools
