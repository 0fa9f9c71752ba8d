#include "tools/fit/fit_skin.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "sim/linear/steady_state.h"
#include "sim/skin/skin.h"
#include "tests/residual.h"
#include "tests/temporary_files.h"
#include "tests/tools/captured.h"
#include "tests/tools/found.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

Outcome FitSkin(const std::vector<std::string>& words) {
  return Captured(RunFitSkin, "fit-skin", words);
}

const std::vector<std::string> kActuator{"--actuator", "thesis-c10-100"};

class FitSkinFiles : public tests::TemporaryFiles {
 protected:
  // 25 frequencies under a skin, by sim's five states, in noise of 1 %
  static std::string Rows(const sim::Skin& skin, const std::string& prefix, unsigned seed) {
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> noise;
    auto actuator = sim::ThesisC10100();
    actuator.case_mass_kg += 5e-4;
    const auto model = sim::AssembleModel(actuator, {}, skin);
    std::string rows;
    for (int k = 0; k < 25; ++k) {
      const double hz = 40 * std::pow(12.5, k / 24.0);
      const auto steady =
          sim::SolveSteadyState(model, {.amplitude_v = 3, .frequency_hz = hz}, skin);
      const auto per_ampere = steady.phasors(model.skin()) / steady.current_a;
      rows += fmt::format("{}{:.3f},{:.6f},100\n", prefix, hz,
                          1e5 * std::abs(per_ampere) * std::exp(0.01 * noise(engine)));
    }
    return rows;
  }

  // areas with Ks and Bs as `law` gives them
  template <typename Law>
  std::string Areas(const std::string& name, Law law) const {
    std::string text =
        "contact_area_mm2,frequency_hz,displacement_amplitude_um,current_amplitude_ma\n";
    unsigned seed = 11;
    for (const double mm2 : {1.0, 5.0, 20.0, 80.0}) {
      text += Rows(law(mm2), fmt::format("{:g},", mm2), ++seed);
    }
    return File(name, text);
  }

  static std::vector<std::string> With(std::vector<std::string> words) {
    words.insert(words.end(), kActuator.begin(), kActuator.end());
    return words;
  }
};

constexpr auto kHeader = "frequency_hz,displacement_amplitude_um,current_amplitude_ma\n";

TEST_F(FitSkinFiles, AnAreaInSquareMetresIsThatInSquareMillimetres) {
  std::string in_m2 = "contact_area_m2," + std::string(kHeader);
  std::string in_mm2 = "contact_area_mm2," + std::string(kHeader);
  unsigned seed = 11;
  for (const double mm2 : {1.0, 80.0}) {
    const sim::Skin law{600 + 10 * mm2, 0.75};
    in_m2 += Rows(law, fmt::format("{:g},", 1e-6 * mm2), ++seed);
    in_mm2 += Rows(law, fmt::format("{:g},", mm2), seed);
  }
  const auto contacts = [&](const std::string& text) {
    const Outcome outcome = FitSkin(With({File("areas.csv", text), "--json"}));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return json::parse(outcome.out).at("contacts");
  };
  const std::string in_cm2 = "contact_area_cm2" + in_m2.substr(in_m2.find(','));
  EXPECT_THAT(FitSkin(With({File("areas.csv", in_cm2)})).err,
              HasSubstr("has a column contact_area_cm2, whose unit is not known"));
  const json read = contacts(in_m2);
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read, contacts(in_mm2));
}

TEST_F(FitSkinFiles, OneSweepGivesTheSkinWithinItsIntervals) {
  const auto path = File("skin.csv", kHeader + Rows({1200, 1.5}, "", 1));
  const Outcome outcome = FitSkin(With({path, "--json"}));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json document = json::parse(outcome.out);
  const json& contact = document.at("contacts").at(0);
  const std::pair<const char*, double> kTruths[]{{"Ks", 1200}, {"Bs", 1.5}, {"m", 5e-4}};
  for (const auto& [name, truth] : kTruths) {
    const json& value = contact.at("parameters").at(name);
    EXPECT_ABS(value.at("value").get<double>(), truth,
               2.5 * value.at("combined_standard_uncertainty").get<double>(), "2.5 deviations");
  }
  EXPECT_TRUE(contact.at("contact_area_m2").is_null());
  EXPECT_EQ(SaidIn(document, "doubt"), "");
  EXPECT_TRUE(document.at("area_law").at("Ks").is_null());
  EXPECT_THAT(SaidIn(document, "note"), HasSubstr("thesis-c10-100"));
}

// what sweep has written is no measurement
TEST_F(FitSkinFiles, TheTableOfASweepIsSimulated) {
  const std::string rows = kHeader + Rows({1200, 1.5}, "", 1);
  const auto sources = [&](const std::string& name, const std::string& text) {
    const json document = json::parse(FitSkin(With({File(name, text), "--json"})).out);
    return document.at("contacts").at(0).at("data_source");
  };
  EXPECT_EQ(sources("mine.csv", "# of the lab\n" + rows), json::array({"imported"}));
  EXPECT_EQ(sources("table.csv", "# haptometer sweep 1\n" + rows), json::array({"simulated"}));
}

TEST_F(FitSkinFiles, ACubeRootOverAreasIsFound) {
  const auto path = Areas("areas.csv", [](double mm2) {
    return sim::Skin{600 * std::cbrt(mm2), 0.75 * std::cbrt(mm2)};
  });
  const json document = json::parse(FitSkin(With({path, "--json"})).out);
  EXPECT_EQ(document.at("contacts").size(), 4U);
  const json& law = document.at("area_law").at("Ks");
  EXPECT_TRUE(law.at("one_third_inside").get<bool>());
  EXPECT_ABS(law.at("exponent").get<double>(), 1.0 / 3,
             2.5 * law.at("combined_standard_uncertainty").get<double>(), "2.5 deviations");
  EXPECT_THAT(FitSkin(With({path})).out,
              ::testing::ContainsRegex("a cube root.s +0.333, inside the interval"));
}

TEST_F(FitSkinFiles, TheThesissOwnFormulaIsToldFromACubeRoot) {
  const auto path = Areas("thesis.csv", [](double mm2) {
    return sim::SkinUnderArea(1e-6 * mm2, sim::SkinRange::kText);
  });
  const Outcome outcome = FitSkin(With({path}));
  EXPECT_THAT(outcome.out,
              ::testing::ContainsRegex("a cube root.s +0.333, outside of the interval"));
  const json law = json::parse(FitSkin(With({path, "--json"})).out).at("area_law").at("Ks");
  const double thesis = law.at("thesis_exponent_600_2000").get<double>();
  EXPECT_ABS(law.at("exponent").get<double>(), thesis, 0.01, "noise of 1 %");
}

TEST_F(FitSkinFiles, ThePlotHoldsSweepsFitsAndResiduals) {
  auto words = kActuator;
  words.push_back(Areas("areas.csv", [](double mm2) {
    return sim::Skin{600 * std::cbrt(mm2), 0.5 * std::cbrt(mm2)};
  }));
  words.insert(words.end(), {"--plot", directory_ / "skin.svg"});
  EXPECT_EQ(FitSkin(words).status, 0);
  const std::string svg = Content("skin.svg");
  for (const char* word :
       {"areas.csv (20\u00a0mm²)", "amplitude / µm", "residual / %", "Ks / N/m"}) {
    EXPECT_THAT(svg, HasSubstr(word));
  }
}

TEST_F(FitSkinFiles, RmsAndAmplitudeColumnsSayTheSame) {
  const std::string rows = Rows({1200, 1.5}, "", 1);
  const auto amplitude = ReadSkinSweeps(File("a.csv", kHeader + rows));
  const auto rms =
      ReadSkinSweeps(File("r.csv", "frequency_hz,displacement_rms_um,current_rms_ma\n" + rows));
  ASSERT_TRUE(amplitude && rms);
  const auto& first = amplitude->at(0).points.at(3);
  const auto& second = rms->at(0).points.at(3);
  EXPECT_REL(second.displacement_m, std::numbers::sqrt2 * first.displacement_m, 1e-14, "a factor");
  EXPECT_REL(second.displacement_m / second.drive, first.displacement_m / first.drive, 1e-14,
             "a ratio");
}

TEST_F(FitSkinFiles, MistakesAreNamed) {
  const std::string rows = Rows({1200, 1.5}, "", 1);
  const auto error = [this](const std::string& name, const std::string& text) {
    const Outcome outcome = FitSkin(With({File(name, text)}));
    EXPECT_EQ(outcome.status, 3) << outcome.out;
    return outcome.err;
  };
  EXPECT_THAT(error("bare.csv", "frequency_hz,amplitude,current\n" + rows),
              HasSubstr("no displacement with its unit"));
  EXPECT_THAT(error("drive.csv", "frequency_hz,displacement_amplitude_um,current\n" + rows),
              HasSubstr("no drive with its unit"));
  EXPECT_THAT(error("nan.csv", kHeader + rows + "510,nan,100\n"), HasSubstr("nan.csv:27"));
  EXPECT_THAT(error("zero.csv", kHeader + rows + "510,0,100\n"), HasSubstr("are positive"));
  EXPECT_THAT(error("cells.csv", kHeader + rows + "510,3\n"), HasSubstr("cells.csv:27"));
  EXPECT_THAT(error("two.csv", std::string(kHeader) + "100,3,100\n200,4,100\n"),
              HasSubstr("only 2 points"));
  EXPECT_THAT(
      error("both.csv",
            "frequency_hz,displacement_rms_um,displacement_rms_mm,current_rms_a\n1,1,1,1\n"),
      HasSubstr("has both"));
  EXPECT_THAT(error("area.csv", "contact_area_mm2," + std::string(kHeader) + "0,100,3,100\n"),
              HasSubstr("contact area that is not positive"));
  const auto path = File("skin.csv", kHeader + rows);
  EXPECT_EQ(FitSkin({path}).status, 2) << "no actuator";
  EXPECT_THAT(FitSkin(With({path, path})).err, HasSubstr("given twice"));
  // micrometres that were metres, amperes that were milliamperes
  const auto wrong =
      File("m.csv", "frequency_hz,displacement_amplitude_m,current_amplitude_ma\n" + rows);
  const Outcome outcome = FitSkin(With({wrong}));
  EXPECT_TRUE(outcome.status == 3 || outcome.out.contains("doubt: "));
  const auto amperes =
      File("a.csv", "frequency_hz,displacement_amplitude_um,current_amplitude_a\n" + rows);
  EXPECT_THAT(FitSkin(With({amperes})).out + FitSkin(With({amperes})).err,
              ::testing::AnyOf(HasSubstr("doubt: "), HasSubstr("check the units")));
}

TEST_F(FitSkinFiles, AnActuatorWithoutItsConstantsIsRefused) {
  const auto path = File("skin.csv", kHeader + Rows({1200, 1.5}, "", 1));
  const auto actuator = File("actuator.toml",
                             "moving_mass_kg = '1.4g'\ncase_mass_kg = '0.6g'\n"
                             "resistance_ohm = 27\ninductance_h = '130uH'\n");
  const Outcome outcome = FitSkin({path, "--actuator", actuator});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.err, HasSubstr("stiffness_n_per_m"));
}

// any cell, comma or line end may be anything: refused, or answered with finite numbers
TEST_F(FitSkinFiles, DamagedTablesNeverGiveNoNumbers) {
  const std::string good = kHeader + Rows({1200, 1.5}, "", 1);
  const std::string bytes = "0123456789.,-e\n#\"x \xff";
  std::mt19937_64 engine(2);
  for (int k = 0; k < 150; ++k) {
    std::string text = good;
    for (int changes = 0; changes < 3; ++changes) {
      text[engine() % text.size()] = bytes[engine() % bytes.size()];
    }
    const Outcome outcome = FitSkin(With({File("damaged.csv", text), "--json"}));
    ASSERT_TRUE(outcome.status == 0 || outcome.status == 3) << text;
    if (outcome.out.empty()) continue;
    const json document = json::parse(outcome.out);
    // a table that is refused leaves a document without contacts, which says why
    EXPECT_EQ(document.at("contacts").empty(),
              std::ranges::count(KindsOf(document), "left-out") > 0)
        << text;
    if (document.at("contacts").empty()) continue;
    const json contact = document.at("contacts").at(0);
    EXPECT_TRUE(contact.at("parameters").at("Ks").contains("value"));
  }
}

// a scene's steady state at 25 frequencies, as a row each by `row`
template <typename RowOf>
std::string TableOf(const sim::Skin& skin, RowOf row) {
  auto actuator = sim::ThesisC10100();
  actuator.case_mass_kg += 5e-4;
  const auto model = sim::AssembleModel(actuator, {}, skin);
  std::string text;
  for (int k = 0; k < 25; ++k) {
    const double hz = 40 * std::pow(12.5, k / 24.0);
    const auto steady = sim::SolveSteadyState(model, {.amplitude_v = 3, .frequency_hz = hz}, skin);
    text += row(k, hz, steady, steady.phasors(model.skin()));
  }
  return text;
}

void ExpectSkin(const Outcome& outcome, const sim::Skin& skin) {
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json contact = json::parse(outcome.out).at("contacts").at(0);
  const json& values = contact.at("parameters");
  EXPECT_REL(values.at("Ks").at("value").get<double>(), skin.stiffness_n_per_m, 1e-5,
             "nine digits, of which the resonance loses a few");
  EXPECT_REL(values.at("Bs").at("value").get<double>(), skin.damping_n_s_per_m, 1e-5, "the same");
}

TEST_F(FitSkinFiles, TheTableOfASweepOfScenesIsRead) {
  // its phase_rad is the current's against the voltage and none of the displacement
  const sim::Skin skin{900, 1.1};
  const auto text = [&](const char* key, const char* value) {
    return fmt::format(
               "# haptometer sweep 0.1.0\n# scene = s.toml\npoint,drive.frequency_hz{},skin_rms_m,"
               "mover_peak_m,case_rms_m,current_rms_a,power_w,phase_rad,remark\n",
               key) +
           TableOf(skin, [&](int k, double hz, const auto& steady, std::complex<double> phasor) {
             const double rms = std::abs(phasor) / std::numbers::sqrt2;
             return fmt::format("{},{:.9g}{},{:.9g},1e-4,{:.9g},{:.9g},0.01,-0.2,\n", k + 1, hz,
                                value, rms, rms, std::abs(steady.current_a) / std::numbers::sqrt2);
           });
  };
  ExpectSkin(FitSkin(With({File("sweep.csv", text("", "")), "--json"})), skin);
  const auto area = json::parse(
      FitSkin(With({File("area.csv", text(",skin.contact_area_m2", ",2e-05")), "--json"})).out);
  EXPECT_REL(area.at("contacts").at(0).at("contact_area_m2").get<double>(), 2e-5, 1e-12,
             "through mm2 and back");
  const Outcome other =
      FitSkin(With({File("other.csv", text(",actuator.damping_n_s_per_m", ",1"))}));
  EXPECT_EQ(other.status, 3);
  EXPECT_THAT(other.err, HasSubstr("varies actuator.damping_n_s_per_m besides the frequency"));
}

TEST_F(FitSkinFiles, TheResponseOfARecordedSweepIsRead) {
  const sim::Skin skin{1500, 0.9};
  const auto text = [&](const char* unit, bool per_volt) {
    return fmt::format("# resolution_hz = 1\nfrequency_hz,{},phase_rad,coherence\n", unit) +
           TableOf(skin, [&](int, double hz, const auto& steady, std::complex<double> phasor) {
             const auto ratio = per_volt ? phasor / 3.0 : phasor / steady.current_a;
             return fmt::format("{:.9g},{:.9g},{:.9g},0.999\n", hz, std::abs(ratio),
                                std::arg(ratio));
           });
  };
  ExpectSkin(FitSkin(With({File("v.csv", text("amplitude_m_per_v", true)), "--json"})), skin);
  ExpectSkin(FitSkin(With({File("a.csv", text("amplitude_m_per_a", false)), "--json"})), skin);
  const Outcome none = FitSkin(With({File("m.csv", text("amplitude_m", true))}));
  EXPECT_EQ(none.status, 3);
  EXPECT_THAT(none.err, HasSubstr("whose drive was not recorded in A or V"));
}

}  // namespace
}  // namespace haptometer::tools
