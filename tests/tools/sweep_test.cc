#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/temporary_files.h"
#include "tests/tools/captured.h"
#include "tools/sweep/answer_columns.h"
#include "tools/sweep/sweep_table.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

const std::string kAdapter = HAPTOMETER_FIXTURES "/lra_adapter.toml";
const std::string kCone = HAPTOMETER_FIXTURES "/lra_cone.toml";
const std::vector<std::string> kGrid{kAdapter, "--vary", "drive.frequency_hz=200Hz:250Hz:11",
                                     "--vary", "skin.stiffness_n_per_m=600,1200,2000"};
const std::vector<std::string> kSampled{kAdapter,
                                        "--vary",
                                        "drive.frequency_hz=100Hz:400Hz",
                                        "--vary",
                                        "skin.damping_n_s_per_m=log:0.75:2.38",
                                        "--samples",
                                        "40",
                                        "--seed",
                                        "7"};

using Row = std::map<std::string, std::string>;

class SweepVerb : public tests::TemporaryFiles {
 protected:
  [[nodiscard]] std::string Path(const std::string& name) const { return directory_ / name; }

  [[nodiscard]] Outcome Sweep(std::vector<std::string> words, const std::string& table,
                              const std::vector<std::string>& more = {}) const {
    words.insert(words.end(), {"-o", Path(table)});
    words.insert(words.end(), more.begin(), more.end());
    return Captured(RunSweep, "sweep", words);
  }

  // what a sweep writes that must succeed
  [[nodiscard]] std::string Table(const std::vector<std::string>& words, const std::string& name,
                                  const std::vector<std::string>& more = {}) const {
    const Outcome outcome = Sweep(words, name, more);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return Content(name);
  }

  [[nodiscard]] static std::vector<Row> RowsOf(const std::string& table) {
    std::istringstream lines(table);
    std::vector<std::string> columns;
    std::vector<Row> rows;
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with('#')) continue;
      const std::vector<std::string> cells = CellsOf(line);
      if (columns.empty()) {
        columns = cells;
        continue;
      }
      EXPECT_EQ(cells.size(), columns.size()) << line;
      Row row;
      for (std::size_t k = 0; k < cells.size(); ++k) row[columns[k]] = cells[k];
      rows.push_back(std::move(row));
    }
    return rows;
  }
};

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
    const std::string name(column.name);
    if (name.starts_with("run_") || name == "window_rms_m") {
      EXPECT_EQ(row.at(name), "") << name;
    } else {
      EXPECT_EQ(std::stod(row.at(name)), answer.at(name).get<double>()) << name;
    }
  }
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
  EXPECT_THAT(rows[0].at("remark"), HasSubstr("stops or lost contact limit the motion"));
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
    const std::string name(column.name);
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
  EXPECT_THAT(outcome.err, HasSubstr("1 of 4 points are not answered, the first: point 2: "));
  const std::vector<Row> rows = RowsOf(Content("t.csv"));
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_THAT(rows[1].at("remark"), HasSubstr("[sensor]: rate_hz: is not 1/sampling_s"));
  for (const AnswerColumn& column : AnswerColumns()) {
    EXPECT_EQ(rows[1].at(std::string(column.name)), "");
  }
  EXPECT_NE(rows[2].at("skin_rms_m"), "");
}

TEST_F(SweepVerb, WritesTheSameBytesWithAnyThreads) {
  for (const auto& words : {kGrid, kSampled}) {
    const std::string one = Table(words, "one.csv", {"--threads", "1", "--overwrite"});
    for (const char* threads : {"2", "7"}) {
      EXPECT_EQ(Table(words, "more.csv", {"--threads", threads, "--overwrite"}), one);
    }
  }
}

TEST_F(SweepVerb, MergesShardsToTheBytesOfOneRun) {
  for (const auto& words : {kGrid, kSampled}) {
    const std::string whole = Table(words, "whole.csv", {"--overwrite"});
    for (const std::size_t shards : {1U, 2U, 3U, 4U, 5U, 6U, 7U, 41U}) {
      std::vector<std::string> merge{"--merge"};
      for (std::size_t k = shards; k > 0; --k) {  // in whatever order
        const std::string name = "s" + std::to_string(k) + ".csv";
        const std::string shard = std::to_string(k) + "/" + std::to_string(shards);
        const std::string table = Table(words, name, {"--shard", shard, "--overwrite"});
        EXPECT_EQ(RowsOf(table).size(), (RowsOf(whole).size() + shards - k) / shards);
        merge.push_back(Path(name));
      }
      EXPECT_EQ(Table(merge, "merged.csv", {"--overwrite"}), whole) << shards << " shards";
    }
  }
}

// in the rows every other byte and both sides of each line end, in the header every 31st: each run
// waits for the disk
TEST_F(SweepVerb, GoesOnFromAnyByteToTheSameBytes) {
  const std::vector<std::string> words{kCone, "--vary", "drive.frequency_hz=200:210:3"};
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--overwrite"}, {"--overwrite", "--shard", "2/2"}}) {
    const std::string whole = Table(words, "whole.csv", more);
    std::vector<std::string> resumed = more;
    resumed.front() = "--resume";
    const std::size_t rows = whole.find("remark\n");
    for (std::size_t length = 0; length <= whole.size(); ++length) {
      const bool is_at_line_end = whole[std::min(length, whole.size() - 1)] == '\n' ||
                                  (length > 0 && whole[length - 1] == '\n');
      if (!is_at_line_end && length % (length < rows ? 31 : 2) != 0) continue;
      (void)File("cut.csv", whole.substr(0, length));
      ASSERT_EQ(Table(words, "cut.csv", resumed), whole) << "cut behind " << length << " bytes";
    }
  }
  EXPECT_EQ(Table(words, "new.csv", {"--resume"}), Table(words, "whole.csv", {"--overwrite"}));
}

TEST_F(SweepVerb, GoesOnOnlyWithItsOwnTable) {
  const std::string whole = Table(kGrid, "t.csv");
  const auto refused = [&](std::vector<std::string> words, const std::vector<std::string>& more,
                           const std::string& said) {
    std::vector<std::string> resumed{"--resume"};
    resumed.insert(resumed.end(), more.begin(), more.end());
    const Outcome outcome = Sweep(std::move(words), "t.csv", resumed);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("t.csv: "));
    EXPECT_THAT(outcome.err, HasSubstr(said));
  };
  std::vector<std::string> finer = kGrid;
  finer[2] = "drive.frequency_hz=200Hz:250Hz:21";
  refused(finer, {},
          "was begun with 'vary = drive.frequency_hz=200:250:11', not 'vary = "
          "drive.frequency_hz=200:250:21'");
  std::vector<std::string> other_scene = kGrid;
  other_scene[0] = File("lra_adapter.toml", [] {
    std::ifstream file(kAdapter);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    return text + "[run]\nstart = 'rest'\n";
  }());
  refused(other_scene, {}, "was begun with 'scene_digest = ");
  refused(kSampled, {}, "was begun with 'vary = ");
  refused(kGrid, {"--shard", "1/2"}, "was begun with no --shard, not 1/2");
  EXPECT_EQ(Content("t.csv"), whole);

  // rows that it would not write: another value, a cell too few, one row too many
  const std::string value = std::string(whole).replace(whole.find("\n5,205,"), 7, "\n5,206,");
  const std::string last = whole.substr(whole.rfind('\n', whole.size() - 2) + 1);
  for (const auto& [edited, row] :
       {std::pair(value, "row 5"), std::pair(whole + last, "row 34"),
        std::pair(whole.substr(0, whole.size() - last.size()) + "33,250,2000,1\n", "row 33")}) {
    (void)File("t.csv", edited);
    refused(kGrid, {}, std::string(row) + " is not what this sweep makes");
    EXPECT_EQ(Content("t.csv"), edited);
  }
  (void)File("t.csv", "time_s,voltage_v\n1,2\n");
  const Outcome foreign = Sweep(kGrid, "t.csv", {"--resume"});
  EXPECT_EQ(foreign.status, 3);
  EXPECT_THAT(foreign.err, HasSubstr("t.csv: is no table of haptometer sweep"));
}

TEST_F(SweepVerb, ReplacesATableOnlyWhereItIsToldTo) {
  (void)File("t.csv", "the only copy\n");
  const Outcome outcome = Sweep(kGrid, "t.csv");
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr("already exists; go on with it by --resume"));
  EXPECT_EQ(Content("t.csv"), "the only copy\n");
  EXPECT_EQ(RowsOf(Table(kGrid, "t.csv", {"--overwrite"})).size(), 33U);
}

TEST_F(SweepVerb, RefusesWhatMakesNoWhole) {
  const auto shard = [&](const std::string& name, const std::string& part,
                         const std::string& seed) {
    std::vector<std::string> words = kSampled;
    words.back() = seed;
    return Table(words, name, {"--shard", part});
  };
  const std::string second = shard("2.csv", "2/3", "7");
  (void)shard("1.csv", "1/3", "7");
  (void)shard("3.csv", "3/3", "7");
  (void)shard("other.csv", "3/3", "8");
  (void)shard("half.csv", "1/2", "7");
  (void)File("cut.csv", second.substr(0, second.size() - 5));
  (void)File("short.csv", second.substr(0, second.rfind('\n', second.size() - 2) + 1));
  (void)File("header.csv", second.substr(0, 80));
  const auto refused = [&](const std::vector<std::string>& names, int status,
                           const std::string& said) {
    std::vector<std::string> words{"--merge"};
    for (const std::string& name : names) words.push_back(Path(name));
    const Outcome outcome = Sweep(words, "whole.csv");
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(said));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1);
    EXPECT_FALSE(std::filesystem::exists(Path("whole.csv")));
  };
  refused({"1.csv", "3.csv"}, 3, "point 2 of 40 is in none of the tables");
  refused({"2.csv", "3.csv"}, 3, "point 1 of 40 is in none");
  refused({"1.csv", "short.csv", "3.csv"}, 3, "point 38 of 40 is in none");
  refused({"1.csv", "2.csv", "3.csv", "2.csv"}, 2, "holds point 2, which ");
  refused({"half.csv", "2.csv", "3.csv", "1.csv"}, 2, "holds point 1, which ");
  refused({"1.csv", "2.csv", "other.csv"}, 2,
          "'sampling = latin hypercube, 40 samples, seed 8', not 'sampling");
  refused({"1.csv", "cut.csv", "3.csv"}, 3, "cut.csv: ends amid a row; go on with it by --resume");
  refused({"1.csv", "header.csv"}, 3, "header.csv: is no table of haptometer sweep");
  refused({"1.csv", "none.csv"}, 3, "none.csv: no such file");
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
  EXPECT_THAT(Sweep(kGrid, "t.csv", {"--resume"}).out,
              HasSubstr("largest skin_rms_m: 0.000200176 at point 16, drive.frequency_hz = 225, "
                        "skin.stiffness_n_per_m = 600"));
}

TEST_F(SweepVerb, DrawsOneOrTwoKeys) {
  const auto drawn = [&](std::vector<std::string> words, const std::string& said) {
    words.insert(words.end(), {"--plot", Path("p.svg"), "--overwrite"});
    EXPECT_EQ(Sweep(words, "t.csv").status, 0);
    EXPECT_THAT(Content("p.svg"), HasSubstr(said));
  };
  const std::string hertz = "drive.frequency_hz=100:400:31";
  drawn({kCone, "--vary", hertz}, "drive.frequency_hz");
  drawn(kGrid, "skin.stiffness_n_per_m = 1200");
  drawn({kCone, "--vary", hertz, "--vary", "skin.stiffness_n_per_m=600:2000:15"}, "<image");
  drawn({kCone, "--vary", hertz, "--vary", "skin.stiffness_n_per_m=log:600:2000:15"},
        "skin.stiffness_n_per_m = 2000");
  drawn(kSampled, "skin.damping_n_s_per_m");
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
      {{kCone, "--vary", "actuator.moving_mass_kg=1.4,1.5"}, "did you mean 1.4g?"},
      {{kCone, "--vary", "drive.amplitude_v=5.0(1),6"}, "has an uncertainty"},
      {{kCone, "--vary", "drive.amplitude_v=1,,2"}, "empty or not printable"},
      {{kCone, "--vary", "drive.amplitude_v=1:2"}, "is not BEGIN:END:COUNT"},
      {{kCone, "--vary", "drive.amplitude_v=1:2:3:4"}, "is not BEGIN:END:COUNT"},
      {{kCone, "--vary", "drive.amplitude_v=1:2:1"}, "'1' is no count of values"},
      {{kCone, "--vary", "drive.amplitude_v=1:2:x"}, "'x' is no count of values"},
      {{kCone, "--vary", "drive.amplitude_v=2:2:3"}, "ends between which there is nothing"},
      {{kCone, "--vary", "drive.amplitude_v=log:0:2:3"}, "reaches to 0 or below"},
      {{kCone, "--vary", "drive.amplitude_v=1:2:3", "--samples", "5"}, "is to be sampled"},
      {{kCone, "--vary", "drive.amplitude_v=1,2", "--seed", "5"}, "--seed: stands without"},
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
      {{kCone, "--vary", "drive.amplitude_v=1,2", "--resume", "--overwrite"}, "beside --resume"},
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
