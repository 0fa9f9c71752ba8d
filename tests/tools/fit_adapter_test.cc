#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

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

Outcome FitAdapter(const std::vector<std::string>& words) {
  return Captured(RunFitAdapter, "fit-adapter", words);
}

class FitAdapterFiles : public tests::TemporaryFiles {
 protected:
  // a tap of 8200 N/m, 0.01 N s/m and 4.6 g in noise of 0.3 um, the readings times `scale`
  std::string Tap(const std::string& name, double scale = 1, int rows = 3000,
                  unsigned seed = 1) const {
    std::ofstream out(directory_ / name);
    out << "time_s,displacement_m\n";
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> noise(0, 3e-7);
    const double decay = 0.01 / (2 * 4.6e-3);
    const double angular = std::sqrt(8200 / 4.6e-3 - decay * decay);
    for (int n = 0; n < rows; ++n) {
      const double t = -0.02 + n * 4e-4;
      const double ringing =
          t > 0 ? 0.05 / angular * std::exp(-decay * t) * std::sin(angular * t) : 0;
      out << fmt::format("{:.4f},{:.9g}\n", t, scale * (1e-3 + ringing + noise(engine)));
    }
    return directory_ / name;
  }
};

TEST_F(FitAdapterFiles, OneTapGivesKaAndBaWithinTheirIntervals) {
  const Outcome outcome = FitAdapter({Tap("tap.csv"), "--mass", "4.60(2)g", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json document = json::parse(outcome.out);
  const json& stiffness = document.at("parameters").at("Ka");
  const json& damping = document.at("parameters").at("Ba");
  EXPECT_ABS(stiffness.at("value").get<double>(), 8200.0,
             2 * stiffness.at("combined_standard_uncertainty").get<double>(), "2 deviations");
  EXPECT_ABS(damping.at("value").get<double>(), 0.01,
             2 * damping.at("combined_standard_uncertainty").get<double>(), "2 deviations");
  // 0.02 g of 4.6 g
  EXPECT_REL(stiffness.at("combined_standard_uncertainty").get<double>(), 8200 * 0.02 / 4.6, 0.01,
             "statistics adds less");
  EXPECT_EQ(SaidIn(document, "doubt"), "");
  EXPECT_TRUE(damping.at("at_most_95").is_null());
  EXPECT_LT(damping.at("lower_95").get<double>(), 0.01);
  EXPECT_TRUE(document.at("birge_ratio").at("Ka").is_null()) << "one tap";
}

TEST_F(FitAdapterFiles, SeveralTapsAreAveragedAndBadOnesLeftOut) {
  const Outcome outcome = FitAdapter(
      {Tap("a.csv"), Tap("b.csv", 1, 3000, 2), Tap("short.csv", 1, 2), "--mass", "4.6g", "--json"});
  EXPECT_EQ(outcome.status, 3) << "one of the files cannot be fitted";
  EXPECT_THAT(outcome.err, HasSubstr("short.csv"));
  const json document = json::parse(outcome.out);
  EXPECT_EQ(document.at("taps").size(), 2U);
  EXPECT_EQ(std::ranges::count(KindsOf(document), "left-out"), 1);
  EXPECT_GT(document.at("birge_ratio").at("Ka").get<double>(), 0);
}

TEST_F(FitAdapterFiles, MistakesAreNamed) {
  const std::string tap = Tap("tap.csv");
  const Outcome no_mass = FitAdapter({tap});
  EXPECT_EQ(no_mass.status, 2);
  EXPECT_THAT(no_mass.err, HasSubstr("--mass 4.6g"));
  EXPECT_EQ(FitAdapter({tap, "--mass", "4.6"}).status, 2) << "grams or kilograms?";
  EXPECT_EQ(FitAdapter({tap, "--mass", "-4.6g"}).status, 2);
  EXPECT_EQ(FitAdapter({"--mass", "4.6g"}).status, 2);
  EXPECT_THAT(FitAdapter({tap, tap, "--mass", "4.6g"}).err, HasSubstr("given twice"));
  EXPECT_EQ(FitAdapter({Tap("two.csv", 1, 2), "--mass", "4.6g"}).status, 3);
  EXPECT_EQ(FitAdapter({"absent.csv", "--mass", "4.6g"}).status, 3);
  EXPECT_THAT(FitAdapter({tap, "--mass", "4.6kg"}).out, HasSubstr("g or mg?"));
  EXPECT_THAT(FitAdapter({Tap("um.csv", 1e6), "--mass", "4.6g"}).out,
              HasSubstr("is the column in mm or um?"));
}

TEST_F(FitAdapterFiles, ACopyOfATapIsNoOtherTap) {
  const std::string tap = Tap("tap.csv");
  const std::string copy = File("copy.csv", Content("tap.csv"));
  const Outcome outcome = FitAdapter({tap, copy, "--mass", "4.6g"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr(copy + ": has the same content as " + tap));
  // of as many bytes, but one other digit
  std::string text = Content("tap.csv");
  text[text.size() - 2] = text[text.size() - 2] == '1' ? '2' : '1';
  EXPECT_EQ(FitAdapter({tap, File("other.csv", text), "--mass", "4.6g"}).status, 0);
}

TEST_F(FitAdapterFiles, AVoltageIsDoubtedAsADisplacement) {
  std::string text = Content(Tap("tap.csv").substr(directory_.string().size() + 1));
  text.replace(0, text.find('\n'), "time_s,voltage_v");
  const Outcome outcome = FitAdapter({File("volt.csv", text), "--mass", "4.6g"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("volt.csv: the channel is in V and no displacement"));
  EXPECT_THAT(FitAdapter({Tap("tap.csv"), "--mass", "4.6g"}).out,
              ::testing::Not(HasSubstr("no displacement")));
}

TEST_F(FitAdapterFiles, FitLraStillAnswersWithTheVerbsDocument) {
  const std::string tap = Tap("tap.csv");
  const json own = json::parse(FitAdapter({tap, "--mass", "4.6g", "--json"}).out);
  const json other = json::parse(
      Captured(RunFitLra, "fit-lra", {"--adapter", tap, "--mass", "4.6g", "--json"}).out);
  EXPECT_EQ(own.at("parameters"), other.at("parameters"));
}

}  // namespace
}  // namespace haptometer::tools
