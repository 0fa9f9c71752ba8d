#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <sstream>
#include <tuple>

#include "sim/scene/actuator.h"
#include "tests/residual.h"
#include "tests/temporary_files.h"
#include "tests/tools/captured.h"
#include "tests/tools/found.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using nlohmann::json;
using ::testing::Contains;
using ::testing::HasSubstr;

Outcome FitImpedance(const std::vector<std::string>& words) {
  return Captured(RunFitImpedance, "fit-impedance", words);
}

class FitImpedanceFiles : public tests::TemporaryFiles {
 protected:
  // the thesis's actuator, held, by an instrument of 0.1 % and 0.1 degrees; a cell in line `line`
  // is replaced by `cell`
  std::string Sweep(const std::string& name,
                    const std::string& header = "frequency_hz,impedance_ohm,phase_deg",
                    int line = -1, const std::string& cell = {}) const {
    std::string text = header + "\n";
    std::mt19937_64 engine(7);
    std::normal_distribution<double> noise;
    for (int k = 0; k < 61; ++k) {
      const double hz = k < 31 ? 210 + k : 100 * std::pow(5, (k - 31) / 29.0);
      const std::complex<double> s(0, 2 * std::numbers::pi * hz);
      const auto z = 27.0 + s * 130e-6 + 1.0 / (1.4e-3 * s + 0.0322 + 2800.0 / s);
      const std::string ohm = fmt::format("{:.4f}", std::abs(z) * (1 + 1e-3 * noise(engine)));
      text += fmt::format("{:.3f},{},{:.3f}\n", hz, k == line ? cell : ohm,
                          std::arg(z) * 180 / std::numbers::pi + 0.1 * noise(engine));
    }
    return File(name, text);
  }
};

TEST_F(FitImpedanceFiles, ASweepGivesTheConstantsWithinTheirIntervals) {
  const Outcome outcome = FitImpedance(
      {Sweep("z.csv"), "--resistance", "27ohm", "--moving-mass", "1.40(1)g", "--held", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json document = json::parse(outcome.out);
  const std::pair<const char*, double> kTruths[]{{"Kv", 2800}, {"Bv", 0.0322}, {"Km", 1.0}};
  for (const auto& [name, truth] : kTruths) {
    const json& value = document.at("parameters").at(name);
    EXPECT_ABS(value.at("value").get<double>(), truth,
               2 * value.at("combined_standard_uncertainty").get<double>(), "2 deviations");
  }
  EXPECT_REL(document.at("resistance").at("value").get<double>(), 27.0, 1e-3, "noise of 0.1 %");
  EXPECT_EQ(SaidIn(document, "doubt"), "");
  EXPECT_THAT(KindsOf(document), ::testing::Not(Contains("held-assumed"))) << "it is stated";
  EXPECT_EQ(document.at("correlation").at("matrix").size(), 5U);
}

TEST_F(FitImpedanceFiles, TheIssuesColumnNamesAreRead) {
  const auto path = Sweep("z.csv", "frequency,ohm,degrees");
  const Outcome outcome = FitImpedance({path});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ::testing::Not(HasSubstr("stiffness Kv")));
  EXPECT_THAT(outcome.out, HasSubstr("--moving-mass 1.4g"));
  EXPECT_THAT(outcome.out, HasSubstr("the case was held"));
  const Outcome required = FitImpedance({path, "--require", "Km"});
  EXPECT_EQ(required.status, 3);
  EXPECT_THAT(required.out, HasSubstr("not answered: Km is required"));
}

// of an instrument's numbers over SI and degrees
struct Factors {
  double hertz = 1;
  double ohm = 1;
  double angle = 1;
};

// what an instrument writes: names in its words, numbers in its units
class FitImpedanceColumns : public FitImpedanceFiles {
 protected:
  // the sweep of Sweep() with its numbers times `factors`, as magnitude and phase or as R and X
  std::string Written(const std::string& header, const Factors& factors = {},
                      bool is_polar = true) const {
    std::ignore = Sweep("plain.csv");
    std::istringstream lines(Content("plain.csv"));
    std::string line;
    std::getline(lines, line);
    std::string text = header + "\n";
    while (std::getline(lines, line)) {
      double hertz = 0;
      double ohm = 0;
      double degrees = 0;
      std::sscanf(line.c_str(), "%lf,%lf,%lf", &hertz, &ohm, &degrees);
      const auto z = std::polar(ohm, degrees * std::numbers::pi / 180);
      text += fmt::format("{:.12g},{:.12g},{:.12g}\n", hertz * factors.hertz,
                          factors.ohm * (is_polar ? ohm : z.real()),
                          is_polar ? degrees * factors.angle : factors.ohm * z.imag());
    }
    return File("z.csv", text);
  }

  static json Answer(const std::string& path) {
    const Outcome outcome = FitImpedance({path, "--moving-mass", "1.40(1)g", "--held", "--json"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return json::parse(outcome.out);
  }
};

TEST_F(FitImpedanceColumns, WhatAnalysersWriteIsReadInItsUnits) {
  const json plain = Answer(Sweep("z0.csv"));
  EXPECT_THAT(KindsOf(plain), ::testing::Not(Contains("columns-taken")));
  const double radian = std::numbers::pi / 180;
  struct Case {
    const char* header;
    Factors factors{};
    bool is_polar = true;
  };
  const Case kCases[]{
      {"Frequency(Hz),|Z|(ohm),Theta(deg)"},
      {"Frequency,|Z| (Ohm),Theta (deg)"},
      {"Freq [kHz],Zabs [kOhm],Phase [rad]", {1e-3, 1e-3, radian}},
      {"f/Hz,Z/mΩ,angle/°", {1, 1e3, 1}},
      {"FREQUENCY,IMPEDANCE_KOHM,PHASE_DEG", {1, 1e-3, 1}},
      {"f in MHz,abs(Z) in Mohm,Phase Angle in rad", {1e-6, 1e-6, radian}},
      {"frequency_hz,resistance_ohm,reactance_ohm", {}, false},
      {"Frequency (Hz),R (ohm),X (ohm)", {}, false},
      {"Freq,Rs (kohm),Xs (kohm)", {1, 1e-3, 1}, false},
      {"f (Hz),Re(Z) (mohm),Im(Z) (mohm)", {1, 1e3, 1}, false},
  };
  for (const auto& [header, factors, is_polar] : kCases) {
    const json answer = Answer(Written(header, factors, is_polar));
    for (const char* name : {"Kv", "Bv", "Km"}) {
      for (const char* key : {"value", "combined_standard_uncertainty"}) {
        EXPECT_REL(answer.at("parameters").at(name).at(key).get<double>(),
                   plain.at("parameters").at(name).at(key).get<double>(), 1e-6,
                   "12 digits of the numbers; the search's end");
      }
    }
    EXPECT_THAT(KindsOf(answer), Contains("columns-taken")) << header;
  }
  EXPECT_THAT(
      FitImpedance({Written("Freq [kHz],|Z| [kOhm],Phase [rad]", {1e-3, 1e-3, radian})}).out,
      HasSubstr("its columns are read: 'Freq [kHz]' as the frequency in kHz, '|Z| [kOhm]' "
                "as the magnitude in kohm, 'Phase [rad]' as the phase in rad"));
}

TEST_F(FitImpedanceColumns, ColumnsThatMayMeanSeveralThingsAreRefusedWithTheirNames) {
  const auto error = [&](const std::string& header) {
    const Outcome outcome = FitImpedance({Written(header), "--moving-mass", "1.4g"});
    EXPECT_EQ(outcome.status, 3) << outcome.out;
    return outcome.err;
  };
  EXPECT_THAT(
      error("Frequency,|Z|,Theta (deg)"),
      HasSubstr("its column '|Z|' does not state its unit (columns: Frequency, Theta (deg), "
                "|Z|)"));
  EXPECT_THAT(error("Frequency,|Z| (ohm),Theta"), HasSubstr("'Theta' does not state its unit"));
  EXPECT_THAT(error("frequency_hz,impedance_db,phase_deg"),
              HasSubstr("its column 'impedance_db' is in dB"));
  EXPECT_THAT(error("Frequency (Hz),|Z| (V),Theta (deg)"), HasSubstr("has the unit 'v'"));
  EXPECT_THAT(error("Frequency (1/s),|Z| (ohm),Theta (deg)"), HasSubstr("has the unit '1/s'"));
  EXPECT_THAT(error("f (Hz),R (ohm),|Z| (ohm)"), HasSubstr("has no column reactance_ohm among"));
  EXPECT_THAT(error("f (Hz),Z (ohm),Impedance (ohm)"), HasSubstr("has no column phase_deg among"));
  EXPECT_THAT(error("f (Hz),Y (S),Theta (deg)"), HasSubstr("has no column impedance_ohm among"));
  EXPECT_THAT(error("time_s,|Z| (ohm),Theta (deg)"), HasSubstr("has no column frequency_hz among"));
  const auto wide = [&](const std::string& header) {
    const std::string path =
        File("wide.csv", header + "\n100,27,0,27,0\n200,27,0,27,0\n300,27,0,27,0\n");
    return FitImpedance({path}).err;
  };
  EXPECT_THAT(wide("f,|Z| (ohm),theta (deg),R (ohm),X (ohm)"),
              HasSubstr("has magnitude and phase, and real and imaginary parts too"));
  EXPECT_THAT(wide("f,|Z| (ohm),theta (deg),Z (ohm),D"),
              HasSubstr("its columns 'Z (ohm)' and '|Z| (ohm)' may both be the magnitude"));
  // what is beside a whole pair is passed over: here the answer is about the points
  EXPECT_THAT(wide("f,|Z| (ohm),theta (deg),R (ohm),D"), HasSubstr("only 3 impedances"));
}

TEST_F(FitImpedanceFiles, RowsThatWereWrittenTwiceCountOnce) {
  const std::string path = Sweep("z.csv");
  std::istringstream lines(Content("z.csv"));
  std::string line;
  std::getline(lines, line);
  std::string text = line + "\n";
  while (std::getline(lines, line)) text += line + "\n" + line + "\n";
  const Outcome outcome = FitImpedance({File("twice.csv", text), "--plot", directory_ / "z.svg"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("61 of 122 points repeat another one to all digits"));
  const json once = json::parse(FitImpedance({path, "--json"}).out);
  const json twice = json::parse(FitImpedance({directory_ / "twice.csv", "--json"}).out);
  EXPECT_EQ(once.at("natural_frequency"), twice.at("natural_frequency"));
}

TEST_F(FitImpedanceFiles, AnActuatorFileGivesTheMasses) {
  const Outcome outcome =
      FitImpedance({Sweep("z.csv"), "--actuator", "thesis-c10-100", "--held", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(json::parse(outcome.out).at("parameters").at("Km").at("determined").get<bool>());
}

TEST_F(FitImpedanceFiles, MistakesAreNamed) {
  const std::string names = "frequency_hz,impedance_ohm,phase_deg";
  const auto error = [](const std::string& path) {
    const Outcome outcome = FitImpedance({path, "--moving-mass", "1.4g"});
    EXPECT_EQ(outcome.status, 3) << outcome.out;
    return outcome.err;
  };
  EXPECT_THAT(error(Sweep("nan.csv", names, 12, "nan")), HasSubstr("nan.csv:14"));
  EXPECT_THAT(error(Sweep("empty.csv", names, 12, "")), HasSubstr("is not a number"));
  EXPECT_THAT(error(Sweep("zero.csv", names, 12, "0")), HasSubstr("not positive"));
  EXPECT_THAT(error(Sweep("names.csv", "f,z,p")),
              HasSubstr("its column 'z' does not state its unit (columns: f, p, z)"));
  EXPECT_THAT(error(Sweep("swapped.csv", "impedance_ohm,frequency_hz,phase_deg")),
              HasSubstr("no resonance"));
  EXPECT_THAT(error(File("two.csv", names + "\n224,50,10\n226,50,-10\n")), HasSubstr("only 2"));
  EXPECT_THAT(error(File("none.csv", "224,50,10\n226,50,-10\n")), HasSubstr("no column"));
  EXPECT_THAT(error("absent.csv"), HasSubstr("no such file"));
  const std::string sweep = Sweep("z.csv");
  EXPECT_EQ(FitImpedance({sweep, "--moving-mass", "1.4"}).status, 2);
  EXPECT_EQ(FitImpedance({sweep, "--held", "--free"}).status, 2);
  EXPECT_EQ(FitImpedance({"drop.csv", sweep}).status, 2);
  EXPECT_THAT(FitImpedance({sweep, "--moving-mass", "1.4kg"}).out, HasSubstr("g or mg"));
}

TEST_F(FitImpedanceFiles, ThePlotHoldsSweepFitAndResiduals) {
  EXPECT_EQ(FitImpedance({Sweep("z.csv"), "--plot", directory_ / "z.svg"}).status, 0);
  const std::string svg = Content("z.svg");
  for (const char* word : {"|Z| / Ω", "phase / deg", "residual / noise", "units of a point's noise",
                           "magnitude", "frequency / Hz", ">200<"}) {
    EXPECT_THAT(svg, HasSubstr(word));
  }
}

TEST_F(FitImpedanceFiles, WhatASweepTellsIsSavedForScenes) {
  const std::string sweep = Sweep("z.csv");
  const std::string saved = directory_ / "actuator.toml";
  const std::vector<std::string> words{sweep,      "--held", "--moving-mass",
                                       "1.40(3)g", "--save", saved};
  const Outcome lacking = FitImpedance(words);
  EXPECT_EQ(lacking.status, 2);
  EXPECT_THAT(lacking.err, HasSubstr("state it with --case-mass"));
  EXPECT_THAT(lacking.out, HasSubstr("Kv")) << "the rest is answered";
  EXPECT_FALSE(std::filesystem::exists(saved));
  auto all = words;
  all.insert(all.end(), {"--case-mass", "0.6g"});
  const json document = [&] {
    auto with = all;
    with.emplace_back("--json");
    return json::parse(FitImpedance(with).out);
  }();
  const auto actuator = sim::FindActuator(saved);
  ASSERT_TRUE(actuator) << actuator.error().Text();
  const json& km = document.at("parameters").at("Km");
  EXPECT_REL(actuator->force_constant_n_per_a->value, km.at("value").get<double>(), 1e-11,
             "digits");
  EXPECT_REL(actuator->force_constant_n_per_a->standard_uncertainty,
             km.at("combined_standard_uncertainty").get<double>(), 1e-3, "four digits");
  // R and L are the sweep's own
  EXPECT_REL(actuator->resistance_ohm.value, document.at("resistance").at("value").get<double>(),
             1e-11, "digits");
  EXPECT_GT(actuator->resistance_ohm.standard_uncertainty, 0);
  EXPECT_GT(actuator->inductance_h.standard_uncertainty, 0);
  EXPECT_REL(actuator->correlations.at("Mv_Kv"), 1.0, 1e-3, "nearly all of it");
  EXPECT_REL(actuator->correlations.at("Kv_Km"), 1.0, 0.1, "the mass moves both");
  EXPECT_TRUE(actuator->correlations.contains("Km_R"));
  EXPECT_TRUE(actuator->correlations.contains("R_L"));
  EXPECT_TRUE(sim::Complete(*actuator));
  // an ohmmeter's R stands for itself
  auto stated = all;
  stated.insert(stated.end(), {"--resistance", "27.0(3)ohm", "--overwrite"});
  EXPECT_EQ(FitImpedance(stated).status, 0);
  const auto measured = sim::FindActuator(saved);
  ASSERT_TRUE(measured);
  EXPECT_EQ(measured->resistance_ohm.value, 27);
  EXPECT_FALSE(measured->correlations.contains("Km_R"));
}

TEST_F(FitImpedanceFiles, FitLraStillAnswersWithTheVerbsDocument) {
  const std::string sweep = Sweep("z.csv");
  const json own = json::parse(FitImpedance({sweep, "--json"}).out);
  const Outcome other = Captured(RunFitLra, "fit-lra", {"--impedance", sweep, "--json"});
  EXPECT_EQ(own.at("natural_frequency"), json::parse(other.out).at("natural_frequency"));
  EXPECT_EQ(Captured(RunFitLra, "fit-lra", {"drop.csv", "--impedance", sweep}).status, 2);
}

}  // namespace
}  // namespace haptometer::tools
