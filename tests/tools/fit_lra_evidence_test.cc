// fit-lra on records that hold no ring-down, on parts of records, and on long ones.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "tests/repetitions.h"
#include "tests/residual.h"
#include "tests/temporary_files.h"
#include "tests/tools/captured.h"
#include "tests/tools/found.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

constexpr double kTwoPi = 2 * std::numbers::pi;

Outcome FitLra(const std::vector<std::string>& words) {
  return Captured(RunFitLra, "fit-lra", words);
}

class FitLraEvidence : public tests::TemporaryFiles {
 protected:
  // `rows` of a function of time, in white noise
  [[nodiscard]] std::string Write(const std::string& name, double step_s, int rows, double noise,
                                  const std::function<double(double)>& signal) const {
    std::mt19937_64 engine(8);
    std::normal_distribution<double> white;
    std::string text = "time_s,voltage_v\n";
    for (int n = 0; n < rows; ++n) {
      const double t = n * step_s;
      text += fmt::format("{:.9g},{:.9g}\n", t, signal(t) + noise * white(engine));
    }
    return File(name, text);
  }

  // status 3 with a reason, and a document in which nothing is determined
  static void ExpectNothingDetermined(const std::string& path, const std::string& reason) {
    const Outcome outcome = FitLra({path, "--moving-mass", "1.4g", "--held", "--json"});
    EXPECT_EQ(outcome.status, 3) << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr(reason));
    ASSERT_TRUE(json::accept(outcome.out)) << "one document on standard output: " << outcome.out;
    const json document = json::parse(outcome.out);
    for (const char* name : {"Kv", "Bv", "Km"}) {
      EXPECT_FALSE(document.at("parameters").at(name).at("determined").get<bool>()) << name;
      EXPECT_TRUE(document.at("parameters").at(name).at("value").is_null()) << name;
    }
    EXPECT_TRUE(document.at("natural_frequency_hz").is_null());
    EXPECT_TRUE(document.at("records").empty());
    EXPECT_THAT(SaidIn(document, "refusal"), HasSubstr(reason));
    EXPECT_EQ(std::ranges::count(KindsOf(document), "left-out"), 1);
  }
};

// a ramp for 1.2 s, let go into 23.3 Hz that decays by 1.7/s
double PulledAndReleased(double t) {
  if (t < 1.2) return -0.5 * t / 1.2;
  return 0.37 * std::exp(-1.7 * (t - 1.2)) * std::cos(kTwoPi * 23.3 * (t - 1.2));
}

TEST_F(FitLraEvidence, WhatIsNoRingDownIsRefusedWithADocument) {
  ExpectNothingDetermined(Write("two.csv", 2e-4, 3000, 2e-3,
                                [](double t) {
                                  return std::exp(-8 * t) * (std::cos(kTwoPi * 80 * t) +
                                                             0.7 * std::sin(kTwoPi * 149 * t));
                                }),
                          "is not a single decaying oscillation");
  ExpectNothingDetermined(Write("decay.csv", 2e-4, 3000, 2e-3,
                                [](double t) { return t < 0.1 ? 0 : std::exp(-20 * (t - 0.1)); }),
                          "decay.csv");
  ExpectNothingDetermined(
      Write("hum.csv", 2e-4, 3000, 2e-3, [](double t) { return std::cos(kTwoPi * 71 * t); }),
      "does not decay");
}

TEST_F(FitLraEvidence, AReleaseBehindASlowPullContradictsNothing) {
  // no height or current is stated: where the motion began says nothing
  const auto path = Write("pull.csv", 5e-4, 8000, 1e-3, PulledAndReleased);
  const Outcome outcome = FitLra({path, "--moving-mass", "30g", "--held", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json document = json::parse(outcome.out);
  EXPECT_REL(document.at("natural_frequency_hz").get<double>(), 23.3, 1e-3, "noise; d/w of 7e-5");
  EXPECT_REL(document.at("quality_factor").get<double>(), std::numbers::pi * 23.3 / 1.7, 0.02,
             "noise");
}

TEST_F(FitLraEvidence, AWindowIsFittedAlone) {
  // a ring-down of 40 Hz, and from 1 s on one of 70 Hz
  const auto path = Write("two_rings.csv", 5e-4, 4000, 1e-3, [](double t) {
    if (t < 1) return std::exp(-6 * t) * std::cos(kTwoPi * 40 * t);
    return 0.5 * std::exp(-7 * (t - 1)) * std::cos(kTwoPi * 70 * (t - 1));
  });
  const auto hertz = [&](const std::string& window) {
    const Outcome outcome =
        FitLra({path, "--moving-mass", "5g", "--held", "--json", "--window", window});
    EXPECT_EQ(outcome.status, 0) << window << ": " << outcome.err;
    return outcome.status == 0 ? json::parse(outcome.out).at("natural_frequency_hz").get<double>()
                               : 0;
  };
  EXPECT_REL(hertz(":0.9"), 40.0, 2e-3, "noise, and d/w of 3e-4");
  EXPECT_REL(hertz("1.001s:"), 70.0, 2e-3, "noise, and d/w of 1e-4");
  EXPECT_REL(hertz("1001ms:1.6"), 70.0, 2e-3, "noise, and d/w of 1e-4");
}

// a fall from 12 mm without rebound strikes the case at 20 ms; closed case, Km = 1
double Struck(double t) {
  const double since = t - 0.02;
  return since < 0 ? 0 : 0.485 * std::exp(-11.5 * since) * std::cos(kTwoPi * 225 * since);
}

TEST_F(FitLraEvidence, AWindowBehindTheBlowHasNoHeight) {
  const auto path = Write("drop.csv", 5e-5, 10'000, 1e-3, Struck);
  const auto fitted = [&](const std::string& window) {
    return FitLra({path, "--moving-mass", "1.4g", "--held", "--drop-height", "12mm", "--rebound",
                   "0", "--json", "--window", window});
  };
  const Outcome whole = fitted("0.001:");
  ASSERT_EQ(whole.status, 0) << whole.err;
  EXPECT_TRUE(json::parse(whole.out).at("parameters").at("Km").at("determined").get<bool>());
  const Outcome behind = fitted("0.053:");
  ASSERT_EQ(behind.status, 0) << behind.err;
  EXPECT_FALSE(json::parse(behind.out).at("parameters").at("Km").at("determined").get<bool>());
  EXPECT_THAT(behind.out, HasSubstr("the drop height is not used"));
}

// another mode of 2 % of the amplitude, or an offset that fades, is no series of blows
TEST_F(FitLraEvidence, SomethingSmallBesideARingIsFittedAndNamed) {
  for (const auto& beside : std::vector<std::function<double(double)>>{
           [](double t) { return 0.02 * std::exp(-20 * t) * std::sin(kTwoPi * 291 * t); },
           [](double t) { return 0.03 * std::exp(-45 * t); }}) {
    const auto path = Write("ring.csv", 5e-5, 10'000, 1e-3, [&](double t) {
      const double since = t - 0.02;
      return since < 0 ? 0 : 2 * Struck(t) + beside(since);
    });
    const Outcome outcome = FitLra({path, "--moving-mass", "1.4g", "--held", "--json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json document = json::parse(outcome.out);
    EXPECT_THAT(outcome.out, HasSubstr("a single decaying oscillation does not explain"));
    EXPECT_REL(document.at("natural_frequency_hz").get<double>(), 225.0, 1e-4,
               "2 % of the amplitude elsewhere, and d/w of 3e-5");
    EXPECT_REL(document.at("quality_factor").get<double>(), std::numbers::pi * 225 / 11.5, 0.01,
               "2 % of the amplitude elsewhere");
  }
}

// Coulomb: each half swing loses twice the same, here 0.16 of the first: at rest after six
TEST_F(FitLraEvidence, FrictionThatStopsTheMotionAtOnceIsRefused) {
  const auto path = Write("rub.csv", 5e-5, 10'000, 1e-3, [](double t) {
    const double since = t - 0.02;
    if (since < 0) return 0.0;
    const double amplitude = 1 - 0.16 * std::floor(2 * 225 * since);
    return amplitude > 0 ? amplitude * std::sin(kTwoPi * 225 * since) : 0.0;
  });
  const Outcome outcome = FitLra({path, "--moving-mass", "1.4g", "--held"});
  EXPECT_EQ(outcome.status, 3) << outcome.out;
}

TEST_F(FitLraEvidence, AWindowThatIsNoneIsAWrongCommand) {
  const auto path = Write("ring.csv", 5e-4, 2000, 1e-3,
                          [](double t) { return std::exp(-6 * t) * std::cos(kTwoPi * 40 * t); });
  for (const char* window : {"0.2", "0.5:0.2", "0.2:0.2", "a:b", "0.1:2kg"}) {
    const Outcome outcome = FitLra({path, "--moving-mass", "5g", "--window", window});
    EXPECT_EQ(outcome.status, 2) << window << ": " << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr("--window")) << window;
  }
  const Outcome outside = FitLra({path, "--moving-mass", "5g", "--window", "7:8", "--json"});
  EXPECT_EQ(outside.status, 3);
  EXPECT_THAT(outside.err, HasSubstr("no sample in the window"));
}

TEST_F(FitLraEvidence, ALongRecordOfHighQualityIsFitted) {
  // 300 000 rows; a tenth of them where code runs slowly
  const int rows = tests::kIsSanitized ? 30'000 : 300'000;
  const auto path = Write("fork.csv", 1e-4, rows, 2e-3, [](double t) {
    return 0.8 * std::exp(-t / 5.3) * std::cos(kTwoPi * 431.7 * t);
  });
  const Outcome outcome = FitLra({path, "--moving-mass", "1.4g", "--held", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json document = json::parse(outcome.out);
  EXPECT_REL(document.at("natural_frequency_hz").get<double>(), 431.7, 1e-5, "noise");
  EXPECT_ABS(document.at("quality_factor").get<double>(), std::numbers::pi * 431.7 * 5.3,
             4 * document.at("quality_factor_standard_uncertainty").get<double>(), "4 deviations");
}

}  // namespace
}  // namespace haptometer::tools
