// Numbers that no device has, and tables that are none, through every way in: one line, no crash.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/temporary_files.h"
#include "tests/tools/captured.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const std::string kImpulse = HAPTOMETER_FIXTURES "/impulse.csv";
const std::string kAdapter = HAPTOMETER_FIXTURES "/lra_adapter.toml";

using Words = std::vector<std::string>;

class ImpossibleInputs : public tests::TemporaryFiles {
 protected:
  // refused in one line that says so
  static void Refused(int (*run)(int, const char* const*), const std::string& verb,
                      const Words& words, const std::string& said = "outside the possible range") {
    const Outcome outcome = Captured(run, verb, words);
    EXPECT_THAT(outcome.status, ::testing::AnyOf(2, 3)) << verb << ' ' << words.back();
    EXPECT_THAT(outcome.err, HasSubstr(said)) << verb << ' ' << words.back();
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_THAT(outcome.err, Not(HasSubstr("check failed")));
  }
};

TEST_F(ImpossibleInputs, InOptions) {
  for (const auto& [option, value] :
       {std::pair("--drop-height", "3e-319mm"), std::pair("--drop-height", "1e-20mm"),
        std::pair("--moving-mass", "2e-310g"), std::pair("--moving-mass", "1e250kg"),
        std::pair("--case-mass", "1e-200kg"), std::pair("--resistance", "5e-200ohm"),
        std::pair("--inductance", "7e-321uH"), std::pair("--moving-mass", "1.4g+-1e-318g")}) {
    Refused(RunFitLra, "fit-lra", {kImpulse, option, value});
  }
  Refused(RunFitLra, "fit-lra", {"--load", "4e-312ohm", kImpulse});
  Refused(RunFitLra, "fit-lra",
          {"--plan", "--moving-mass", "1.4g", "--resistance", "27ohm", "--f0", "225Hz", "--want",
           "Km 1e-310%"});
  Refused(RunSweep, "sweep",
          {kAdapter, "--vary", "drive.frequency_hz=1e-310:1:3", "-o", directory_ / "t.csv"});
  Refused(RunTune, "tune", {kAdapter, "--springs", "1e-300"});
  Refused(RunTune, "tune", {kAdapter, "--springs", ""}, "names no spring");
}

TEST_F(ImpossibleInputs, BeyondTheRangesOfOptions) {
  for (const auto& [option, value] :
       {std::pair("--duration", "0s"), std::pair("--duration", "-1s"),
        std::pair("--duration", "1e10s"), std::pair("--hold-off", "0s"),
        std::pair("--smallest-rms", "-1um"), std::pair("--resolution", "0um")}) {
    Refused(RunAcquire, "acquire", {"--port", "p", std::string(option) + "=" + value},
            "is not above 0");
  }
  Refused(RunAcquire, "acquire", {"--port", "p", "--sensor", "keyence-il", "--refresh", "1e12s"},
          "--refresh: must be above 0, and an hour at most");
  Refused(RunAnalyze, "analyze", {kImpulse, "--drive-frequency", "0Hz"}, "is not above 0");
  Refused(RunAnalyze, "analyze", {kImpulse, "--overlap", "0.96"}, "is not from 0 to 0.95");
}

TEST_F(ImpossibleInputs, UncertaintiesThatNothingUses) {
  const std::string unused = "has an uncertainty, which is not used here";
  Refused(RunAcquire, "acquire", {"--port", "p", "--duration", "1s+-0.1s"}, unused);
  Refused(RunAnalyze, "analyze", {kImpulse, "--drive-frequency", "225Hz+-1Hz"}, unused);
  Refused(RunEmulate, "emulate", {"--scene", kAdapter, "--duration", "1s+-0.1s"}, unused);
  Refused(RunSimulate, "simulate", {kAdapter, "--duration", "1s+-0.1s"}, unused);
  Refused(RunTune, "tune", {kAdapter, "--stiffness", "5e3N/m+-1N/m:9e3N/m"}, unused);
}

TEST_F(ImpossibleInputs, InFiles) {
  const std::string actuator =
      File("a.toml",
           "moving_mass_kg = 1.4e-3\ncase_mass_kg = 0.6e-3\nresistance_ohm = '3e-200 ohm'\n"
           "inductance_h = 130e-6\nstiffness_n_per_m = 2800\ndamping_n_s_per_m = 0.03\n"
           "force_constant_n_per_a = 1.0\n");
  Refused(RunFitLra, "fit-lra", {"--plan", "--want", "Km 2%", "--actuator", actuator});
  const std::string scene =
      "[actuator]\nmodel = 'thesis-c10-100'\n[skin]\nstiffness_n_per_m = 2e-310\n"
      "damping_n_s_per_m = 0.75\n[drive]\nkind = 'sine'\namplitude_v = 5\nfrequency_hz = 225\n";
  Refused(RunSimulate, "simulate", {File("s.toml", scene)});
  const std::string drops =
      "moving_mass_kg = 3e-318\n[[drop]]\nfile = '" + kImpulse + "'\nload_ohm = 'open'\n";
  Refused(RunFitLra, "fit-lra", {File("d.toml", drops)});
  Refused(RunFitLra, "fit-lra",
          {"--impedance",
           File("z.csv", "frequency_hz,impedance_ohm,phase_deg\n1e-320,27,1\n200,28,2\n"),
           "--moving-mass", "1.4g", "--held"},
          "beyond any measurement");
}

TEST_F(ImpossibleInputs, InTheHeaderOfAnImpulse) {
  Refused(RunFitLra, "fit-lra",
          {File("h.csv",
                "# case = held\n# load_ohm = inf\n# drop_height_m = 6e-320\ntime_s,voltage_v\n"
                "0,0\n1e-4,1\n2e-4,0.5\n3e-4,-0.5\n")});
}

// what is just possible is answered or refused, whatever it comes to
TEST_F(ImpossibleInputs, TheLimitsThemselvesCrashNothing) {
  for (const auto& [option, least, largest] :
       std::vector<std::tuple<std::string, std::string, std::string>>{
           {"--drop-height", "1e-15m", "1e6m"},
           {"--moving-mass", "1e-12kg", "1e6kg"},
           {"--case-mass", "1e-12kg", "1e6kg"},
           {"--resistance", "1e-9ohm", "1e15ohm"},
           {"--inductance", "1e-12H", "1e6H"}}) {
    for (const std::string& value : {least, largest}) {
      const Outcome outcome = Captured(RunFitLra, "fit-lra", {kImpulse, option, value, "--json"});
      EXPECT_LE(outcome.status, 3) << option << value;
      EXPECT_THAT(outcome.err, Not(HasSubstr("check failed"))) << option << value;
    }
  }
}

TEST_F(ImpossibleInputs, DeepTomlThroughEveryVerbThatReadsIt) {
  std::string deep;
  for (int k = 0; k < 60000; ++k) deep += "k.";
  const std::string file = File("deep.toml", "# deep\n" + deep + "k = 1\n");
  const std::string said = "deep.toml:2: names a key of more than 16 parts";
  Refused(RunSimulate, "simulate", {file}, said);
  Refused(RunSweep, "sweep", {file, "--vary", "a.b=1:2:3", "-o", directory_ / "t.csv"}, said);
  Refused(RunStudy, "study", {file}, said);
  Refused(RunFitLra, "fit-lra", {file}, said);
  Refused(RunFitLra, "fit-lra", {"--plan", "--want", "Km 2%", "--actuator", file}, said);
  Refused(RunTune, "tune", {file}, said);
}

TEST_F(ImpossibleInputs, RowsOfCommasAreNoTable) {
  const std::string commas(3 << 20, ',');
  Refused(RunTrial, "trial", {"info", File("c.csv", commas)}, "is longer than 1 MiB");
  Refused(RunAnalyze, "analyze", {File("w.csv", "time_s" + commas.substr(0, 9000) + "\n0,1\n")},
          "has more than 4096 columns");
  Refused(RunStudy, "study",
          {"matching", File("m.csv", "reference_v" + commas.substr(0, 9000) + "\n1,2\n")},
          "columns");
}

}  // namespace
}  // namespace haptometer::tools
