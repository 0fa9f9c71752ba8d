// fit-lra on files of every kind of record, and on files that somebody got wrong.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/fit/synthetic_drop.h"
#include "tests/residual.h"
#include "tests/temporary_files.h"
#include "tests/tools/captured.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using nlohmann::json;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using tests::SyntheticDrop;

Outcome FitLra(const std::vector<std::string>& words) {
  return Captured(RunFitLra, "fit-lra", words);
}

// how a file is written: the two columns as a person or an oscilloscope would name them
struct Written {
  std::string header = "time_s,voltage_v";
  double time_factor = 1;
  double value_factor = 1;
  bool swapped = false;
  std::string statements{};
};

class FitLraRecords : public tests::TemporaryFiles {
 protected:
  [[nodiscard]] std::string Write(const std::string& name, const SyntheticDrop& drop,
                                  const Written& as = {}) const {
    const auto record = tests::MakeRecord(drop);
    std::string text = as.statements + as.header + '\n';
    for (std::size_t n = 0; n < record.voltage_v.size(); ++n) {
      const double time =
          as.time_factor * (record.start_s + static_cast<double>(n) * record.step_s);
      const double value = as.value_factor * record.voltage_v[n];
      text += as.swapped ? fmt::format("{:.9g},{:.17g}\n", value, time)
                         : fmt::format("{:.9g},{:.17g}\n", time, value);
    }
    return File(name, text);
  }
  // exit status 3, and one line that says what is wrong and what to do
  static void ExpectRefused(const std::string& path, const std::string& what) {
    const Outcome outcome = FitLra({path, "--moving-mass", "1.4g"});
    EXPECT_EQ(outcome.status, 3) << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr(what));
    EXPECT_THAT(outcome.err, HasSubstr("; ")) << "no remedy";
  }
};

SyntheticDrop Noisy() {
  SyntheticDrop drop;
  drop.noise_v = 1e-3;
  return drop;
}

TEST_F(FitLraRecords, AReleasedCurrentTellsKmFromOneOpenRecord) {
  auto drop = Noisy();
  drop.release_current_a = 0.05;
  drop.noise_v = 1e-5;
  const auto path = Write("release.csv", drop);
  const std::vector<std::string> words{path, "--held", "--moving-mass", "1.4g", "--json"};
  auto with = words;
  with.insert(with.end(), {"--release-current", "50mA"});
  const Outcome outcome = FitLra(with);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json km = json::parse(outcome.out).at("parameters").at("Km");
  EXPECT_REL(km.at("value").get<double>(), 1.0, 1e-3, "noise of 4e-4");
  EXPECT_FALSE(
      json::parse(FitLra(words).out).at("parameters").at("Km").at("determined").get<bool>());
}

TEST_F(FitLraRecords, AnAddedMassWeighsTheMover) {
  auto weighted = Noisy();
  weighted.added_mass_kg = 0.5e-3;
  weighted.seed = 7;
  const Outcome outcome =
      FitLra({Write("bare.csv", Noisy(), {.statements = "# case = held\n"}),
              Write("weighted.csv", weighted,
                    {.statements = "# case = held\n# added_mass_kg = 0.500(1)g\n"}),
              "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json document = json::parse(outcome.out);
  EXPECT_REL(document.at("moving_mass_kg").at("value").get<double>(), 1.4e-3, 1e-3, "noise");
  EXPECT_REL(document.at("parameters").at("Kv").at("value").get<double>(), 2800.0, 1e-3, "noise");
}

TEST_F(FitLraRecords, ALasersRecordTellsSpringAndDamping) {
  SyntheticDrop drop;
  drop.condition = fit::CaseCondition::kFree;
  drop.displacement_share = 0.7;
  drop.step_s = 1e-4;
  drop.noise_v = 1e-7;
  drop.offset_v = 0.03;
  const auto path =
      Write("laser.csv", drop, {.header = "time_s,displacement_mm", .value_factor = 1e3});
  const Outcome outcome = FitLra({path, "--free", "--moving-mass", "1.4g", "--case-mass", "0.6g"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ContainsRegex("Kv +(2799|2800)\\."));
  EXPECT_THAT(FitLra({path, "--free", "--moving-mass", "1.4g", "--case-mass", "0.6g", "--all"}).out,
              ContainsRegex("residual .RMS. +0\\.(1|09|10)[0-9]* um"));
  EXPECT_THAT(outcome.out, HasSubstr("record the voltage"));
}

// the records do not belong together: all is said, and the status is 3
void ExpectContradiction(const std::vector<std::string>& words, const std::string& what) {
  auto with = words;
  with.insert(with.end(), {"--held", "--moving-mass", "1.4g", "--resistance", "27ohm"});
  const Outcome outcome = FitLra(with);
  EXPECT_EQ(outcome.status, 3) << outcome.out;
  EXPECT_THAT(outcome.out, ContainsRegex("not answered: .*" + what));
  // above the constants too, and nothing is saved
  EXPECT_THAT(outcome.out, ContainsRegex("^Constants of an actuator .*: not answered"));
  const std::string saved = std::filesystem::path(words[1]).parent_path() / "refused.toml";
  with.insert(with.end(), {"--save", saved});
  const Outcome unsaved = FitLra(with);
  EXPECT_EQ(unsaved.status, 3);
  EXPECT_THAT(unsaved.err, HasSubstr("refused.toml: is not written"));
  EXPECT_FALSE(std::filesystem::exists(saved));
}

TEST_F(FitLraRecords, ExchangedFilesAreNoticed) {
  auto loaded = Noisy();
  loaded.load_ohm = 33;
  loaded.seed = 9;
  ExpectContradiction(
      {"--open", Write("loaded.csv", loaded), "--load", "33ohm", Write("open.csv", Noisy())},
      "exchanged");
}

TEST_F(FitLraRecords, ACopyOfARecordIsNoOtherDrop) {
  const std::string open = Write("open.csv", Noisy());
  const std::string copy = Write("copy.csv", Noisy());
  for (const auto& words : {std::vector<std::string>{"--open", open, copy},
                            {"--open", open, "--load", "33ohm", copy}}) {
    auto all = words;
    all.insert(all.end(), {"--moving-mass", "1.4g", "--resistance", "27ohm", "--held"});
    const Outcome outcome = FitLra(all);
    EXPECT_EQ(outcome.status, 2) << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr(copy + ": has the same content as " + open));
  }
}

TEST_F(FitLraRecords, DropsOfTwoActuatorsAreNoticed) {
  auto other = Noisy();
  other.load_ohm = 33;
  other.stiffness_n_per_m *= 1.05;
  ExpectContradiction(
      {"--open", Write("open.csv", Noisy()), "--load", "33ohm", Write("other.csv", other)},
      "of another actuator");
}

// 0.25 % in frequency are of one actuator, warmer by some ten kelvin
TEST_F(FitLraRecords, DropsOfOneActuatorThatScatterAreADoubt) {
  auto warmer = Noisy();
  warmer.stiffness_n_per_m *= 1.005;
  warmer.seed = 9;
  const Outcome outcome = FitLra({"--open", Write("open.csv", Noisy()), Write("warm.csv", warmer),
                                  "--held", "--moving-mass", "1.4g", "--resistance", "27ohm"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("doubt: the drops' stiffnesses scatter by 0.35"));
}

TEST_F(FitLraRecords, ExchangedLoadsAreNoticed) {
  auto small = Noisy();
  small.load_ohm = 33;
  auto large = Noisy();
  large.load_ohm = 100;
  large.seed = 4;
  ExpectContradiction({"--open", Write("open.csv", Noisy()), "--load", "100ohm",
                       Write("33.csv", small), "--load", "33ohm", Write("100.csv", large)},
                      "load, case or mass is not as stated");
}

TEST_F(FitLraRecords, ABlowIsNoReleasedCurrent) {
  ExpectContradiction({Write("blow.csv", Noisy()), "--release-current", "20mA"},
                      "an impact stated as a released current");
}

TEST_F(FitLraRecords, RobustLeavesSparksOut) {
  const auto record = tests::MakeRecord(Noisy());
  std::string text = "time_s,voltage_v\n";
  for (std::size_t n = 0; n < record.voltage_v.size(); ++n) {
    const double time = record.start_s + static_cast<double>(n) * record.step_s;
    const double spark = n % 37 == 5 ? 0.2 : 0;
    text += fmt::format("{:.9g},{:.17g}\n", time, record.voltage_v[n] + spark);
  }
  const std::string path = File("sparks.csv", text);
  const Outcome outcome = FitLra({path, "--moving-mass", "1.4g", "--robust", "--all"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("are outlying"));
  EXPECT_THAT(outcome.out, HasSubstr("(Huber loss)"));
}

TEST_F(FitLraRecords, EveryOscilloscopesFixtureIsAnsweredOrRefused) {
  int files = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(HAPTOMETER_FIXTURES) + "/scope_csv")) {
    const Outcome outcome = FitLra({entry.path(), "--moving-mass", "1.4g"});
    EXPECT_LE(outcome.status, 3) << entry.path();
    // a refusal says what would help
    EXPECT_TRUE(outcome.status == 0 || (outcome.err + outcome.out).contains("; "))
        << outcome.err << outcome.out;
    ++files;
  }
  EXPECT_GT(files, 30);
  std::string square = "time_s,voltage_v\n";
  for (int n = 0; n < 2000; ++n) square += fmt::format("{:.4f},{}\n", n * 1e-4, n / 10 % 2);
  EXPECT_LE(FitLra({File("square.csv", square)}).status, 3);
}

TEST_F(FitLraRecords, MillisecondsUnderSecondsAreDoubted) {
  const auto path = Write("ms.csv", Noisy(), {.time_factor = 1e3});
  EXPECT_THAT(FitLra({path, "--moving-mass", "1.4g"}).out, HasSubstr("are the times in ms"));
}

TEST_F(FitLraRecords, MillivoltsUnderVoltsAreDoubted) {
  const auto path = Write("mv.csv", Noisy(), {.value_factor = 1e3});
  EXPECT_THAT(FitLra({path, "--moving-mass", "1.4g"}).out, HasSubstr("is the column in mV"));
}

TEST_F(FitLraRecords, SwappedColumnsAreRefused) {
  ExpectRefused(Write("swapped.csv", Noisy(), {.swapped = true}), "swapped.csv");
}

TEST_F(FitLraRecords, WhatHoldsNoRingDownIsRefused) {
  ExpectRefused(File("two.csv", "time_s,voltage_v\n0,0.1\n1e-4,0.2\n"), "two.csv");
  std::string constant = "time_s,voltage_v\n";
  std::string noise = constant;
  std::mt19937_64 engine(3);
  std::normal_distribution<double> normal;
  for (int n = 0; n < 2000; ++n) {
    constant += fmt::format("{:.6f},0.25\n", n * 1e-4);
    noise += fmt::format("{:.6f},{:.6f}\n", n * 1e-4, 0.01 * normal(engine));
  }
  ExpectRefused(File("constant.csv", constant), "ring-down");
  ExpectRefused(File("noise.csv", noise), "noise");
}

TEST_F(FitLraRecords, NotANumberIsNoMeasurement) {
  // every ninth value lost: the rest is fitted
  const auto record = tests::MakeRecord(Noisy());
  std::string text = "time_s,voltage_v\n";
  for (std::size_t n = 0; n < record.voltage_v.size(); ++n) {
    const double time = record.start_s + static_cast<double>(n) * record.step_s;
    text += n % 9 == 4 ? fmt::format("{:.9g},nan\n", time)
                       : fmt::format("{:.9g},{:.17g}\n", time, record.voltage_v[n]);
  }
  const Outcome outcome = FitLra({File("nan.csv", text), "--moving-mass", "1.4g", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json kv = json::parse(outcome.out).at("parameters").at("Kv");
  EXPECT_LE(std::abs(kv.at("value").get<double>() - 2800),
            3 * kv.at("combined_standard_uncertainty").get<double>());
}

}  // namespace
}  // namespace haptometer::tools
