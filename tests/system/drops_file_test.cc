// A drops file at the real program: the same answers as the same statements by options.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/system/process.h"

namespace haptometer::tests {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class DropsFileRun : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(directory_);
    CopyWithoutHeader("/impulse.csv", "open.csv");
    CopyWithoutHeader("/impulse_33ohm.csv", "loaded.csv");
  }
  void TearDown() override { fs::remove_all(directory_); }

  void CopyWithoutHeader(const std::string& fixture, const std::string& name) const {
    std::ifstream in(HAPTOMETER_FIXTURES + fixture);
    std::ofstream out(directory_ / name);
    for (std::string line; std::getline(in, line);) {
      if (!line.starts_with('#')) out << line << '\n';
    }
  }
  std::string Write(const std::string& text) const {
    std::ofstream(directory_ / "drops.toml") << text;
    return directory_ / "drops.toml";
  }
  static Outcome FitLra(std::vector<std::string> words) {
    words.insert(words.begin(), "fit-lra");
    return RunProgram(words);
  }

  const fs::path directory_ =
      fs::path(::testing::TempDir()) / ("drops_file_test_" + std::to_string(::getpid()));
};

// what is answered: without the provenance of JSON, and the notes of what replaces what
std::string Answered(const std::string& out) {
  std::istringstream lines(out.substr(0, out.find("\"provenance\"")));
  std::string kept;
  for (std::string line; std::getline(lines, line);) {
    if (!line.contains(" replaces ")) kept += line + "\n";
  }
  return kept;
}

const std::string kActuator = R"toml(
moving_mass_kg = "1.40(1)g"
case_mass_kg = "0.60(1)g"
resistance_ohm = "27.0(1)ohm"
inductance_h = "130uH"
)toml";

TEST_F(DropsFileRun, AnswersAreThoseOfTheSameOptions) {
  const std::string toml = Write(kActuator + R"toml(
[[drop]]
file = "open.csv"
load_ohm = "open"
case = "held"
drop_height_m = "10.0(5)mm"
rebound = "0.02(1)"
voltage_scale = "1.00(2)"
time_scale = "1+-5e-5"
[[drop]]
files = ["loaded.csv"]
load_ohm = "33.0(2)ohm"
case = "held"
drop_height_m = "10.0(5)mm"
rebound = "0.02(1)"
voltage_scale = "1.00(2)"
time_scale = "1+-5e-5"
)toml");
  const std::string open = directory_ / "open.csv";
  const std::string loaded = directory_ / "loaded.csv";
  const std::vector<std::string> options{
      "--open",          open,       "--load",        "33.0(2)ohm", loaded,         "--held",
      "--moving-mass",   "1.40(1)g", "--case-mass",   "0.60(1)g",   "--resistance", "27.0(1)ohm",
      "--inductance",    "130uH",    "--drop-height", "10.0(5)mm",  "--rebound",    "0.02(1)",
      "--voltage-scale", "1.00(2)",  "--time-scale",  "1+-5e-5"};
  for (const bool json : {false, true}) {
    auto words = options;
    std::vector<std::string> file{toml};
    if (json) {
      words.emplace_back("--json");
      file.emplace_back("--json");
    }
    const Outcome by_options = FitLra(words);
    const Outcome by_file = FitLra(file);
    ASSERT_EQ(by_options.status, 0) << by_options.err;
    EXPECT_EQ(by_file.status, 0) << by_file.err;
    EXPECT_EQ(Answered(by_file.out), Answered(by_options.out));
    EXPECT_EQ(by_file.err, by_options.err);
    EXPECT_THAT(by_file.out, HasSubstr("Km"));
  }
}

TEST_F(DropsFileRun, AnOptionBeatsTheFileAndSaysSo) {
  const std::string toml = Write(kActuator + R"toml(
[[drop]]
file = "open.csv"
load_ohm = "open"
case = "free"
drop_height_m = "20mm"
)toml");
  const Outcome beaten = FitLra({toml, "--held", "--drop-height", "10mm", "--rebound", "0",
                                 "--moving-mass", "1.4g", "--case-mass", "0.60(1)g"});
  ASSERT_EQ(beaten.status, 0) << beaten.err;
  EXPECT_THAT(beaten.out, HasSubstr("--drop-height replaces drop_height_m = 0.02 of " + toml));
  EXPECT_THAT(beaten.out, HasSubstr("--held replaces case = free of " + toml));
  EXPECT_THAT(beaten.out, HasSubstr("--moving-mass replaces moving_mass_kg = 0.0014"));
  EXPECT_THAT(beaten.out, ::testing::Not(HasSubstr("case_mass_kg"))) << "says the same";
  const Outcome plain = FitLra({"--open", directory_ / "open.csv", "--held", "--drop-height",
                                "10mm", "--rebound", "0", "--moving-mass", "1.4g", "--case-mass",
                                "0.60(1)g", "--resistance", "27.0(1)ohm", "--inductance", "130uH"});
  EXPECT_EQ(Answered(beaten.out), Answered(plain.out));
}

TEST_F(DropsFileRun, MistakesAreNamedInOneLine) {
  const auto refused = [&](const std::vector<std::string>& words, int status,
                           const std::string& what) {
    const Outcome outcome = FitLra(words);
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(what));
    EXPECT_EQ(outcome.out, "");
  };
  const std::string open = directory_ / "open.csv";
  refused({directory_ / "nothing.toml"}, 3, "nothing.toml");
  refused({Write("[[drop]]\nfile = 'open.csv'\n"), open}, 2, "cannot be combined with other files");
  refused({Write("[[drop]]\nfile = 'open.csv'\n"), "--open", open}, 2,
          "cannot be combined with other files");
  refused({Write("[[drop]]\nfiles = ['open.csv', 'open.csv']\n")}, 2, "is given twice");
  refused({Write("[[drop]]\nfile = 'open.cvs'\n")}, 3, (directory_ / "open.cvs").string());
  refused({Write("[[drop]\nfile = 'open.csv'\n")}, 3, "drops.toml");
  refused({Write(kActuator)}, 2, "names no drop");
}

}  // namespace
}  // namespace haptometer::tests
