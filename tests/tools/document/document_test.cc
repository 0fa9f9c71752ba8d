#include "tools/document/document.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace haptometer::document {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::vector<std::string> NamesIn(const Item& item) {
  std::vector<std::string> names;
  for (const auto& [name, value] : FieldsOf(item)) names.push_back(name);
  return names;
}

TEST(Value, IsNotKnownWhereThereIsNoFiniteNumber) {
  EXPECT_FALSE(Value().IsKnown());
  EXPECT_FALSE(Value(kNan).IsKnown());
  EXPECT_FALSE(Value(std::numeric_limits<double>::infinity()).IsKnown());
  EXPECT_FALSE(Value(std::optional<double>()).IsKnown());
  EXPECT_FALSE(Value(std::optional<double>(kNan)).IsKnown());
  EXPECT_FALSE(Value(Range{kNan, kNan}).IsKnown());
  EXPECT_TRUE(Value(Range{1, kNan}).IsKnown()) << "one end is";
  EXPECT_TRUE(Value(0.0).IsKnown());
  EXPECT_TRUE(Value(false).IsKnown());
}

TEST(Value, TakesCountsAndTextsOfAnyType) {
  EXPECT_EQ(std::get<std::int64_t>(Value(std::size_t{7})), 7);
  EXPECT_EQ(std::get<std::int64_t>(Value(7)), 7);
  EXPECT_EQ(std::get<std::string>(Value("seven")), "seven");
  EXPECT_EQ(std::get<std::string>(Value(std::string_view("seven"))), "seven");
  EXPECT_TRUE(std::get<bool>(Value(true)));
}

TEST(FieldsOf, AnItemHaveCompanionsBeforeTheEndingOfTheUnit) {
  const auto companion = [](std::string name, const Unit& unit) {
    return NamesIn({.name = std::move(name), .label = "", .unit = unit, .form = Form::kUncertain})
        .back();
  };
  EXPECT_EQ(companion("band_rms_m", kMetre), "band_rms_standard_uncertainty_m");
  EXPECT_EQ(companion("drift_m_per_s", kMetrePerSecond), "drift_standard_uncertainty_m_per_s");
  EXPECT_EQ(companion("thd", kNone), "thd_standard_uncertainty");
  EXPECT_EQ(companion("kv_over_mass", kPerSecondSquared), "kv_over_mass_standard_uncertainty");
}

TEST(FieldsOf, AnItemAreThoseOfItsForm) {
  using Names = std::vector<std::string>;
  Item item{.name = "rise_s", .label = "rise", .unit = kSecond, .value = 2.0};
  EXPECT_EQ(NamesIn(item), Names({"rise_s"}));
  item.form = Form::kUncertain;
  EXPECT_EQ(NamesIn(item), Names({"rise_s", "rise_standard_uncertainty_s"}));
  item.form = Form::kInterval;
  EXPECT_EQ(NamesIn(item), Names({"rise_s", "rise_standard_uncertainty_s", "rise_interval_95_s"}));
  EXPECT_FALSE(FieldsOf(item)[2].second.IsKnown()) << "there, and not known";
}

TEST(FieldsOf, AnEstimateThatIsNotDeterminedKeepItsLimitAlone) {
  Item item{.name = "Bv",
            .label = "",
            .unit = kNewtonSecondPerMetre,
            .form = Form::kEstimate,
            .value = kNan,
            .standard_uncertainty = 0.1,
            .statistical = 0.05,
            .interval = Range{0, 1},
            .at_most = 0.3};
  const auto fields = FieldsOf(item);
  ASSERT_EQ(fields.size(), 8U);
  for (std::size_t k = 0; k < 5; ++k) EXPECT_FALSE(fields[k].second.IsKnown()) << fields[k].first;
  EXPECT_EQ(std::get<double>(fields[5].second), 0.3);
  EXPECT_EQ(std::get<std::string>(fields[6].second), "N s/m");
  EXPECT_FALSE(std::get<bool>(fields[7].second));
}

// --- findings ---

enum class Kind : std::uint8_t { kShort, kLeak };

Sentence SentenceOf(Kind kind) {
  if (kind == Kind::kShort) {
    return {"short-record", "the record of {length_s} holds {drops} drop{drops s}"};
  }
  return {"leak", "{leak %} of {channel} leak[ at {tone_hz}]"};
}

TEST(Findings, AreKeptInTheirOrderWithTheirNumbers) {
  Findings<Kind> findings;
  findings.Doubt(Kind::kLeak, {{"leak", 0.02}});
  findings.Refuse(Kind::kShort, {{"drops", 3}});
  EXPECT_TRUE(findings.Has(Kind::kShort));
  ASSERT_EQ(findings.list().size(), 2U);
  EXPECT_EQ(findings.list()[1].severity, Severity::kRefusal);
  EXPECT_EQ(std::get<std::int64_t>(findings.list()[1].numbers[0].value), 3);
  EXPECT_FALSE(Findings<Kind>().Has(Kind::kShort));
}

TEST(AddFindings, SaysThemInWords) {
  Findings<Kind> findings;
  findings.Note(Kind::kShort, {{"length_s", 0.25}, {"drops", 1}});
  findings.Add({.severity = Severity::kDoubt,
                .kind = Kind::kLeak,
                .numbers = {{"leak", 0.021}, {"channel", std::string("CH2")}},
                .subject = "drop2.csv"});
  Section section;
  AddFindings(section, findings);
  ASSERT_EQ(section.findings.size(), 2U);
  EXPECT_EQ(section.findings[0].kind, "short-record");
  EXPECT_EQ(section.findings[0].text, "the record of 250 ms holds 1 drop");
  EXPECT_EQ(section.findings[1].text, "2.1 % of CH2 leak");
  EXPECT_EQ(section.findings[1].subject, "drop2.csv");
  EXPECT_EQ(section.findings[1].numbers.size(), 2U);
}

TEST(Fill, PutsNumbersInTheUnitOfTheirNames) {
  EXPECT_EQ(Fill("{rms_m}", {{"rms_m", 12.3456e-6}}), "12.35 um");
  EXPECT_EQ(Fill("{mass_kg}", {{"mass_kg", 1.4e-3}}), "1.4 g");
  EXPECT_EQ(Fill("{ratio}", {{"ratio", 2.0}}), "2");
  EXPECT_EQ(Fill("{runs} runs", {{"runs", 1234567}}), "1234567 runs");
}

TEST(Fill, PutsThePluralsEnding) {
  EXPECT_EQ(Fill("{n} run{n s}", {{"n", 1}}), "1 run");
  EXPECT_EQ(Fill("{n} run{n s}", {{"n", 0}}), "0 runs");
  EXPECT_EQ(Fill("{n} run{n s}", {{"n", 2}}), "2 runs");
}

TEST(Fill, PutsTheSiNumberAlone) {
  EXPECT_EQ(Fill("{from_s SI}s:{to_s SI}s", {{"from_s", 0.25}, {"to_s", 12.34567}}),
            "0.25s:12.3457s");
}

TEST(Fill, PutsPercent) {
  EXPECT_EQ(Fill("{part %} of it", {{"part", 0.25}}), "25 % of it");
  EXPECT_EQ(Fill("{rate_hz +-u_hz}", {{"rate_hz", 10'002.2999}, {"u_hz", 0.31}}),
            "10002.30(31) Hz");
  EXPECT_EQ(Fill("{rate_hz +-u_hz}", {{"rate_hz", 10'002.2999}, {"u_hz", 3e-4}}), "10002.3 Hz");
  EXPECT_EQ(Fill("{rate_hz +-u_hz}", {{"rate_hz", 10'002.2999}}), "10000 Hz");
  EXPECT_EQ(Fill("{part %} of it", {{"part", 1}}), "100 % of it");
}

TEST(Fill, LeavesOutAPartOfWhichANumberIsNotThere) {
  const std::string_view text = "late[ by {late_s}][, {n} time{n s}], at last";
  EXPECT_EQ(Fill(text, {}), "late, at last");
  EXPECT_EQ(Fill(text, {{"late_s", 2e-3}}), "late by 2 ms, at last");
  EXPECT_EQ(Fill(text, {{"n", 2}}), "late, 2 times, at last");
  EXPECT_EQ(Fill(text, {{"n", 2}, {"late_s", kNan}}), "late, 2 times, at last");
}

TEST(Fill, SaysElsewhereThatANumberIsNotKnown) {
  EXPECT_EQ(Fill("late by {late_s}", {}), "late by (not known)");
  EXPECT_EQ(Fill("late by {late_s}", {{"late_s", kNan}}), "late by (not known)");
}

TEST(FillDeathTest, StopsAtAPlaceWithoutAnEnd) {
  EXPECT_DEATH(static_cast<void>(Fill("late by {late_s", {})), "without an end");
}

}  // namespace
}  // namespace haptometer::document
