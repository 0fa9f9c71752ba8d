#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/residual.h"
#include "tests/temporary_files.h"
#include "tests/tools/captured.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

const std::string kOpenFile = std::string(HAPTOMETER_FIXTURES) + "/impulse.csv";
const std::string kLoadedFile = std::string(HAPTOMETER_FIXTURES) + "/impulse_33ohm.csv";

Outcome FitLra(const std::vector<std::string>& words) {
  return Captured(RunFitLra, "fit-lra", words);
}

json Document(std::vector<std::string> words) {
  words.emplace_back("--json");
  return json::parse(FitLra(words).out);
}

using FitLraJson = tests::TemporaryFiles;

const std::vector<std::string> kWords{kOpenFile,  kLoadedFile,    "--moving-mass",
                                      "1.40(3)g", "--resistance", "26.8(3)ohm"};

TEST_F(FitLraJson, HoldsTheBudgetThatTheTextPrints) {
  const json document = Document(kWords);
  const std::string text = FitLra(kWords).out;
  const json& budget = document.at("budget");
  // the drop heights bring a blow each, whose length is not exactly known
  ASSERT_EQ(budget.size(), 6U) << "noise, two given numbers, two contacts, combined";
  for (const json& row : budget) {
    EXPECT_THAT(text, HasSubstr(row.at("cause").get<std::string>()));
  }
  // two digits of the combined uncertainty
  EXPECT_THAT(text,
              HasSubstr(fmt::format(" {:.1f} ", budget.back().at("kv_percent").get<double>())));
  EXPECT_EQ(budget[0].at("type"), "A");
  EXPECT_EQ(budget[1].at("type"), "B");
  const json& combined = budget.back();
  EXPECT_TRUE(combined.at("type").is_null());
  double square = 0;
  for (std::size_t k = 0; k + 1 < budget.size(); ++k)
    square += std::pow(budget[k].at("kv_percent").get<double>(), 2);
  EXPECT_REL(std::sqrt(square), combined.at("kv_percent").get<double>(), 1e-9,
             "parts add in squares");
  const json& kv = document.at("parameters").at("Kv");
  EXPECT_REL(combined.at("kv_percent").get<double>() / 100,
             kv.at("combined_standard_uncertainty").get<double>() / kv.at("value").get<double>(),
             1e-12, "the same");
}

TEST_F(FitLraJson, HoldsIntervalsCorrelationsPolesAndStarts) {
  const json document = Document(kWords);
  for (const auto& [name, unit] : {std::pair("kv_over_mass", ""),
                                   {"bv_over_mass", ""},
                                   {"natural_frequency", "_hz"},
                                   {"quality_factor", ""}}) {
    const auto of = [&](const char* what) {
      return document.at(fmt::format("{}{}{}", name, what, unit));
    };
    EXPECT_LT(of("_interval_95").at(0), of("")) << name;
    EXPECT_GT(of("_interval_95").at(1), of("")) << name;
    EXPECT_LE(of("_statistical_standard_uncertainty"), of("_standard_uncertainty")) << name;
  }
  const json& correlation = document.at("correlation_kv_bv_km");
  EXPECT_EQ(correlation[0][0], 1.0);
  auto all = kWords;
  all.emplace_back("--all");
  EXPECT_THAT(FitLra(all).out,
              HasSubstr(fmt::format("Kv and Bv  {:.3f}", correlation[0][1].get<double>())));
  for (const json& record : document.at("records")) {
    const json& pole = record.at("pole");
    EXPECT_EQ(pole.at("decay_per_s"), record.at("decay_per_s"));
    EXPECT_GT(pole.at("decay_standard_uncertainty_per_s"), 0);
    EXPECT_GT(pole.at("frequency_standard_uncertainty_hz"), 0);
    EXPECT_LT(std::abs(pole.at("correlation").get<double>()), 1);
    EXPECT_REL(record.at("start").at("decay_per_s").get<double>(),
               pole.at("decay_per_s").get<double>(), 0.05, "a start");
    EXPECT_FALSE(record.at("residual_is_coloured").get<bool>());
    EXPECT_GT(record.at("peak_v"), 0.1);
    EXPECT_GT(record.at("first_sample"), 100);
  }
}

TEST_F(FitLraJson, WhatIsNotDeterminedIsNullAndNeverAbsent) {
  std::string text = "time_s,voltage_v\n";
  for (int n = 0; n < 1500; ++n) {
    const double t = 2e-4 * n;
    text += fmt::format("{:.4f},{:.6f}\n", t, 0.4 * std::exp(-11.5 * t) * std::cos(1414 * t));
  }
  const json document = Document({File("plain.csv", text)});
  EXPECT_TRUE(document.at("parameters").at("Kv").at("value").is_null());
  EXPECT_EQ(document.at("budget").size(), 0U) << "none of the three is determined";
  for (const json& row : document.at("correlation_kv_bv_km")) {
    for (const json& cell : row) EXPECT_TRUE(cell.is_null());
  }
  EXPECT_TRUE(document.at("records")[0].at("quiet_noise_rms_v").is_null());
  EXPECT_FALSE(document.at("natural_frequency_hz").is_null());
  const json full = Document(kWords);
  EXPECT_EQ(document.size(), full.size()) << "the same keys, whatever is known";
  for (const auto& [key, value] : full.items()) EXPECT_TRUE(document.contains(key)) << key;
}

}  // namespace
}  // namespace haptometer::tools
