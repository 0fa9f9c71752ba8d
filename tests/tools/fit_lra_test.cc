#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "sim/scene/actuator.h"
#include "tests/residual.h"
#include "tests/tools/captured.h"
#include "tests/tools/found.h"
#include "tools/fit/drop_records.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::string kOpenFile = std::string(HAPTOMETER_FIXTURES) + "/impulse.csv";
const std::string kLoadedFile = std::string(HAPTOMETER_FIXTURES) + "/impulse_33ohm.csv";

Outcome FitLra(const std::vector<std::string>& words) {
  return Captured(RunFitLra, "fit-lra", words);
}

json FitLraJson(std::vector<std::string> words) {
  words.emplace_back("--json");
  const auto outcome = FitLra(words);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  return json::parse(outcome.out);
}

// the truth lies in the 95 % interval, and the value within `bound`
void ExpectParameter(const json& document, const std::string& name, double truth, double bound) {
  const json& parameter = document.at("parameters").at(name);
  ASSERT_TRUE(parameter.at("determined").get<bool>());
  EXPECT_REL(parameter.at("value").get<double>(), truth, bound, "the stated bound");
  EXPECT_LE(std::abs(parameter.at("value").get<double>() - truth),
            1.96 * parameter.at("combined_standard_uncertainty").get<double>());
  EXPECT_GT(parameter.at("standard_uncertainty").get<double>(), 0);
}

class FitLraFiles : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(directory_); }
  void TearDown() override { fs::remove_all(directory_); }
  // the fixture without the header lines whose key is one of `without`, and with `lines` before it
  std::string Fixture(const std::string& source, const std::string& name,
                      const std::vector<std::string>& without,
                      const std::string& lines = {}) const {
    std::ifstream in(source);
    std::ofstream out(directory_ / name);
    out << lines;
    for (std::string line; std::getline(in, line);) {
      const bool dropped = std::ranges::any_of(
          without, [&](const std::string& key) { return line.starts_with("# " + key + " ="); });
      if (!dropped) out << line << '\n';
    }
    return directory_ / name;
  }
  const fs::path directory_ =
      fs::path(::testing::TempDir()) / ("fit_lra_test_" + std::to_string(::getpid()));
};

TEST(FitLra, TheGeneratedPairGivesTheTruth) {
  const json document = FitLraJson({"--open", kOpenFile, "--load", "33ohm", kLoadedFile});
  ExpectParameter(document, "Kv", 2800, 1e-3);
  ExpectParameter(document, "Bv", 0.0322, 0.01);
  ExpectParameter(document, "Km", 1.0, 0.02);
  EXPECT_REL(document.at("natural_frequency_hz").get<double>(), 225.0790790, 1e-5, "noise");
  EXPECT_REL(document.at("quality_factor").get<double>(), 61.4875, 2e-3, "noise");
  EXPECT_REL(document.at("kv_over_mass").get<double>(), 2e6, 4e-5, "noise");
  EXPECT_REL(document.at("bv_over_mass").get<double>(), 23.0, 2e-3, "noise");
  EXPECT_TRUE(document.at("converged").get<bool>());
  EXPECT_EQ(document.at("parameters").at("Kv").at("unit"), "N/m");
  EXPECT_EQ(document.at("records").size(), 2U);
}

TEST(FitLra, OneRecordWithItsHeaderAnswersInFull) {
  const json document = FitLraJson({kOpenFile});
  ExpectParameter(document, "Kv", 2800, 1e-3);
  ExpectParameter(document, "Bv", 0.0322, 0.01);
  ExpectParameter(document, "Km", 1.0, 0.02);
}

TEST_F(FitLraFiles, ThePairWithoutHeightsGivesTheTruthByItsLoads) {
  const std::vector<std::string> heights{"drop_height_m", "rebound"};
  const json document = FitLraJson(
      {Fixture(kOpenFile, "open.csv", heights), Fixture(kLoadedFile, "loaded.csv", heights)});
  ExpectParameter(document, "Kv", 2800, 1e-3);
  ExpectParameter(document, "Bv", 0.0322, 0.01);
  ExpectParameter(document, "Km", 1.0, 0.02);
}

TEST_F(FitLraFiles, ARequiredConstantThatIsNotDeterminedIsStatusThree) {
  const auto path = Fixture(kOpenFile, "open.csv", {"drop_height_m", "rebound"});
  EXPECT_EQ(FitLra({path}).status, 0) << "Kv and Bv are given";
  EXPECT_EQ(FitLra({path, "--require", "Kv", "--require", "Bv"}).status, 0);
  const Outcome lacking = FitLra({path, "--require", "Km"});
  EXPECT_EQ(lacking.status, 3);
  EXPECT_THAT(lacking.out, HasSubstr("not answered: Km is required and not determined"));
  EXPECT_THAT(lacking.out, HasSubstr("27 to 50 ohm"));
  EXPECT_THAT(lacking.out, HasSubstr("stiffness Kv")) << "the rest is answered";
  EXPECT_EQ(FitLra({path, "--require", "km2"}).status, 2);
}

TEST_F(FitLraFiles, GramsAsKilogramsAreDoubted) {
  const json document = FitLraJson({kOpenFile, "--moving-mass", "1.4kg"});
  EXPECT_THAT(SaidIn(document, "doubt"), HasSubstr("moving mass of 1400 g"));
  EXPECT_THAT(FitLra({kOpenFile, "--moving-mass", "1.4kg"}).out, HasSubstr("doubt: "));
  EXPECT_EQ(SaidIn(FitLraJson({kOpenFile}), "doubt"), "");
}

TEST_F(FitLraFiles, AnOscilloscopesChannelIsChosenByNameAndScaled) {
  // the fixture as a PicoScope writes it, in mV, with a trigger as the first voltage
  const fs::path path = directory_ / "pico.csv";
  std::ofstream out(path);
  out << "Time,Channel A,Channel B\n(ms),(V),(mV)\n\n";
  std::ifstream in(kOpenFile);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with('#') || line.starts_with("time")) continue;
    const std::size_t comma = line.find(',');
    out << fmt::format("{:.4f},0.5,{:.3f}\n", 1e3 * std::stod(line.substr(0, comma)),
                       1e3 * std::stod(line.substr(comma + 1)));
  }
  out.close();
  const std::vector<std::string> words{path, "--held", "--moving-mass", "1.4g"};
  EXPECT_THAT(FitLra(words).err, HasSubstr("has several voltages: Channel A, Channel B"));
  auto chosen = words;
  chosen.insert(chosen.end(), {"--channel", "Channel B", "--scale", "1mV"});
  ExpectParameter(FitLraJson(chosen), "Kv", 2800, 1e-3);
}

TEST_F(FitLraFiles, WithoutAHeightKmIsNullAndTheMessageHelps) {
  const auto path = Fixture(kOpenFile, "open.csv", {"drop_height_m", "rebound"});
  const json document = FitLraJson({path});
  EXPECT_TRUE(document.at("parameters").at("Kv").at("determined").get<bool>());
  const json& km = document.at("parameters").at("Km");
  EXPECT_FALSE(km.at("determined").get<bool>());
  EXPECT_TRUE(km.at("value").is_null());
  EXPECT_TRUE(km.at("standard_uncertainty").is_null());
  EXPECT_TRUE(km.at("combined_standard_uncertainty").is_null());
  const auto text = FitLra({path});
  EXPECT_EQ(text.status, 0);
  EXPECT_THAT(text.out, HasSubstr("Km: an open circuit shows only Km x impact speed"));
  EXPECT_THAT(text.out, HasSubstr("state the drop height"));
}

TEST_F(FitLraFiles, WhatHasNoAnswerGivesStatus3AndSaysWhatWould) {
  // one load alone tells the frequency and the sum of two dampings
  const auto loaded = FitLra({Fixture(kLoadedFile, "loaded.csv", {"drop_height_m", "rebound"})});
  EXPECT_EQ(loaded.status, 3);
  EXPECT_THAT(loaded.out, HasSubstr("record an open circuit too"));
  EXPECT_THAT(loaded.out, HasSubstr("natural frequency f0  225.07"));
  // an oscillation that grows has no damping
  std::ofstream growing(directory_ / "growing.csv");
  growing << "time_s,voltage_v\n";
  for (int n = 0; n < 2000; ++n) {
    const double t = 1e-4 * n;
    growing << fmt::format("{:.4f},{:.5f}\n", t, 0.01 * std::exp(20 * t) * std::cos(1257 * t));
  }
  growing.close();
  const auto outcome = FitLra({directory_ / "growing.csv", "--moving-mass", "1.4g"});
  EXPECT_EQ(outcome.status, 3);
  // it is no ring-down, so not even its frequency is said to be an actuator's
  EXPECT_THAT(outcome.err, HasSubstr("is not a single decaying oscillation"));
  EXPECT_THAT(outcome.out, testing::Not(HasSubstr("natural frequency")));
}

TEST_F(FitLraFiles, WithoutMassesOnlyRatiosAreGiven) {
  const auto path = Fixture(kOpenFile, "open.csv", {"moving_mass_kg", "case_mass_kg"});
  json document = FitLraJson({path});
  EXPECT_TRUE(document.at("parameters").at("Kv").at("value").is_null());
  EXPECT_REL(document.at("kv_over_mass").get<double>(), 2e6, 4e-5, "noise");
  // the actuator supplies the masses, but not the answer
  document = FitLraJson({path, "--actuator", "thesis-c10-100"});
  ExpectParameter(document, "Kv", 2800, 1e-3);
}

TEST_F(FitLraFiles, AnOptionBeatsTheHeaderAndSaysSo) {
  const auto outcome = FitLra(
      {kOpenFile, "--moving-mass", "1.5g+-0.05g", "--free", "--case-mass", "0.6g", "--json"});
  EXPECT_EQ(outcome.status, 0);
  const json document = json::parse(outcome.out);
  const std::string notes = SaidIn(document, "note");
  EXPECT_THAT(notes, HasSubstr("--moving-mass replaces moving_mass_kg = 0.0014 of the header"));
  EXPECT_THAT(notes, HasSubstr("--free replaces case = held of the header"));
  EXPECT_THAT(notes, testing::Not(HasSubstr("--case-mass")));  // it says the same
  EXPECT_EQ(document.at("mass"), "Mv Mc/(Mv+Mc)");
  EXPECT_EQ(std::ranges::count(KindsOf(document), "statement-replaced"), 2);
  // the reduced mass of 1.5 g and 0.6 g, uncertain by 1/3.5 of 3.3 %
  const json& kv = document.at("parameters").at("Kv");
  EXPECT_REL(kv.at("value").get<double>(), 2e6 * 1.5e-3 * 0.6 / 2.1, 4e-5, "noise");
  EXPECT_REL(kv.at("combined_standard_uncertainty").get<double>() / kv.at("value").get<double>(),
             0.05 / 1.5 * 0.6 / 2.1, 1e-3, "statistics add 1e-5");
}

TEST(FitLra, StatementsOfADropAreReplacedToo) {
  // a height of 40 mm instead of 10 mm doubles the speed, a rebound of 0.5 makes it 1.5 times more
  const auto outcome =
      FitLra({"--open", kOpenFile, "--drop-height", "40mm", "--rebound", "0.5", "--json"});
  EXPECT_THAT(outcome.out, HasSubstr("--drop-height replaces drop_height_m = 0.01 of the header"));
  EXPECT_THAT(outcome.out, HasSubstr("--rebound replaces rebound = 0 of the header"));
  ExpectParameter(json::parse(outcome.out), "Km", 1.0 / 3, 2e-3);
  // twice the load divides the voltage differently: 33/60 against 66/93
  const json document = FitLraJson({"--load", "66ohm", kLoadedFile});
  EXPECT_EQ(std::ranges::count(KindsOf(document), "statement-replaced"), 1);
  ExpectParameter(document, "Km", 33.0 / 60 * 93 / 66, 2e-3);
}

TEST_F(FitLraFiles, HeadersThatContradictEachOtherNeedAWord) {
  const auto other =
      Fixture(kLoadedFile, "other.csv", {"moving_mass_kg"}, "# moving_mass_kg = 1.5e-3\n");
  const auto refused = FitLra({kOpenFile, other});
  EXPECT_EQ(refused.status, 3);
  EXPECT_THAT(refused.err, HasSubstr("other.csv: moving_mass_kg = 0.0015 contradicts 0.0014"));
  EXPECT_EQ(FitLra({kOpenFile, other, "--moving-mass", "1.4g"}).status, 0);
}

TEST_F(FitLraFiles, OfSeveralFilesTheOthersAreStillAnswered) {
  const auto outcome = FitLra({kOpenFile, "/no/such/drop.csv", "--json"});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.err, HasSubstr("/no/such/drop.csv"));
  const json document = json::parse(outcome.out);
  ExpectParameter(document, "Kv", 2800, 1e-3);
  EXPECT_EQ(std::ranges::count(KindsOf(document), "left-out"), 1);
}

TEST(FitLra, WrongCommandLinesSaySo) {
  struct Row {
    std::vector<std::string> words;
    std::string message;
  };
  const std::vector<Row> rows{
      {{}, "no file is given"},
      {{kOpenFile, "--drop-height", "10"}, "did you mean 10mm?"},
      {{kOpenFile, "--moving-mass", "1.4"}, "did you mean 1.4g?"},
      {{kOpenFile, "--inductance", "130"}, "did you mean 130uH?"},
      {{kOpenFile, "--held", "--free"}, "cannot be combined with --free"},
      {{kOpenFile, "--rebound", "2"}, "'2' is not from 0 to 1"},
      {{kOpenFile, "--resistance", "0"}, "'0' is not from 0.001 ohm"},
      {{"--load", kOpenFile}, "--load"},
      {{"--load", "33ohm"}, "no file follows"},
      {{"--load", "0", kOpenFile}, "short circuit"},
      {{kOpenFile, "--plot", "fit.jpg"}, "use .svg, .png or .pdf"},
      {{kOpenFile, "--report", "fit.svg"}, "give it the ending .html"},
      {{"--impedance", "z.csv", "--robust"}, "--robust"},
      {{"--adapter", "tap.bin", "--mass", "4g", "--plot", "fit.svg"}, "--plot"},
      {{"--adapter", "tap.bin", "--mass", "4g", "--save", "a.toml"}, "--save"},
      {{"--plan", "--resistance", "27ohm", "--f0", "225Hz", "--mass", "4g"}, "--mass"},
      {{"--plan", "--resistance", "27ohm", "--f0", "225Hz", "--case-mass", "1g"}, "--case-mass"},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.message);
    const auto outcome = FitLra(row.words);
    EXPECT_EQ(outcome.status, 2);
    EXPECT_THAT(outcome.err, HasSubstr(row.message));
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    EXPECT_THAT(outcome.out, IsEmpty());
  }
}

TEST(FitLra, ActuatorsThatCannotBeReadAreReported) {
  const auto outcome = FitLra({kOpenFile, "--actuator", "/no/such/actuator.toml"});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.err, HasSubstr("/no/such/actuator.toml"));
}

TEST_F(FitLraFiles, WhatIsSavedIsReadBackAndMakesABandOfTheSkin) {
  const std::string saved = directory_ / "actuator.toml";
  const auto words = [&](const std::string& mass) {
    return std::vector<std::string>{kOpenFile, kLoadedFile, "--moving-mass", mass, "--save", saved};
  };
  ASSERT_EQ(FitLra(words("1.40(3)g")).status, 0);
  const auto actuator = sim::FindActuator(saved);
  ASSERT_TRUE(actuator) << actuator.error().Text();
  EXPECT_REL(actuator->stiffness_n_per_m->value, 2800.0, 1e-4, "noise");
  EXPECT_REL(actuator->stiffness_n_per_m->standard_uncertainty, 60.0, 1e-3, "that of the mass");
  EXPECT_REL(actuator->correlations.at("Mv_Kv"), 1.0, 1e-5, "all of it");
  const std::string scene = directory_ / "scene.toml";
  std::ofstream(scene) << "[actuator]\nfile = 'actuator.toml'\n[drive]\nkind = 'sine'\n"
                          "amplitude_v = 5\nfrequency_hz = 225\n[skin]\n"
                          "stiffness_n_per_m = 610\ndamping_n_s_per_m = 0.62\n";
  const auto simulated = Captured(RunSimulate, "simulate", {scene, "--json"});
  ASSERT_EQ(simulated.status, 0) << simulated.err;
  const json document = json::parse(simulated.out);
  EXPECT_GT(document.at("skin_rms_standard_uncertainty_m"), 0);
  EXPECT_LT(document.at("skin_rms_standard_uncertainty_m"),
            0.1 * document.at("skin_rms_m").get<double>());
  EXPECT_THAT(Captured(RunSimulate, "simulate", {scene}).out,
              HasSubstr("from the actuator's constants"));
}

TEST_F(FitLraFiles, AnActuatorWithoutItsCaseIsNotSaved) {
  const auto bare = Fixture(kOpenFile, "bare.csv", {"case_mass_kg"});
  const auto outcome = FitLra({bare, "--save", directory_ / "actuator.toml"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr("--case-mass"));
  EXPECT_FALSE(fs::exists(directory_ / "actuator.toml"));
}

TEST_F(FitLraFiles, AMistypedHeaderKeyIsNamed) {
  const auto mistyped =
      Fixture(kOpenFile, "mistyped.csv", {"moving_mass_kg"}, "# moving_mas_kg = 1.4e-3\n");
  const auto outcome = FitLra({mistyped});
  EXPECT_THAT(outcome.out, HasSubstr("moving_mas_kg is not known; did you mean moving_mass_kg?"));
  EXPECT_THAT(FitLra({kOpenFile}).err, IsEmpty());
}

TEST_F(FitLraFiles, WhereTheCausesOfTheUncertaintyStand) {
  const auto outcome = FitLra({kOpenFile, "--moving-mass", "1.40(3)g", "--time-scale", "1+-0.001"});
  for (const char* line :
       {"moving mass 1.400\\(30\\) g +B +2.1 +2.1", "time scale 1.0000\\(10\\) +B +0.2 +0.1"}) {
    EXPECT_THAT(outcome.out, ::testing::ContainsRegex(line));
  }
  EXPECT_THAT(FitLra({kOpenFile, "--moving-mass", "1.40(3)g", "--all"}).out,
              HasSubstr("Kv and Bv  0.999"));
  EXPECT_EQ(FitLra({kOpenFile, "--time-scale", "1ms"}).status, 2);
  EXPECT_EQ(FitLra({kOpenFile, "--voltage-scale", "1e-3"}).status, 2);
}

TEST_F(FitLraFiles, ThePlotHoldsRecordAndFit) {
  const auto path = directory_ / "fit.svg";
  EXPECT_EQ(FitLra({kOpenFile, "--plot", path}).status, 0);
  std::ifstream in(path);
  const std::string svg{std::istreambuf_iterator<char>(in), {}};
  for (const char* word : {"impulse.csv (open)", "voltage / V", "residual / noise", "time / ms"}) {
    EXPECT_THAT(svg, HasSubstr(word));
  }
}

TEST_F(FitLraFiles, ADropWithoutARingDownIsDrawnWithTheReason) {
  const std::string silent = directory_ / "silent.csv";
  std::ofstream out(silent);
  out << "time_s,voltage_v\n";
  for (int n = 0; n < 400; ++n) out << fmt::format("{:.4f},{:.3f}\n", 1e-4 * n, 0.001 * (n % 3));
  out.close();
  const auto plot = directory_ / "fit.svg";
  const auto drawn = [&plot] {
    std::ifstream in(plot);
    return std::string{std::istreambuf_iterator<char>(in), {}};
  };
  EXPECT_EQ(FitLra({silent, "--plot", plot}).status, 3);
  EXPECT_THAT(drawn(), HasSubstr("silent.csv: not fitted: "));
  EXPECT_EQ(FitLra({silent, kOpenFile, "--plot", plot}).status, 3);
  EXPECT_THAT(drawn(), HasSubstr("silent.csv: not fitted: "));
  EXPECT_THAT(drawn(), HasSubstr("pole of "));
  // of two statuses the one that counts more, which is not the larger one
  EXPECT_EQ(FitLra({silent, kOpenFile, "--save", directory_ / "no" / "a.toml"}).status, 2);
}

}  // namespace
}  // namespace haptometer::tools
