// Each row's own number against an independent one: thesis_reference.py (NumPy, written from the
// equations), mpmath's optima, a brute force over the whole grid.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "tests/reproduce/thesis_reference.h"
#include "tests/residual.h"
#include "tests/sim/reference/linear_reference.h"
#include "tests/sim/tuning/adapter_reference.h"
#include "tools/reproduce/reproduce.h"
#include "tools/reproduce/thesis_model.h"

namespace haptometer::tools {
namespace {

using ::testing::HasSubstr;

// all that need no trials
std::vector<ThesisRow> ModelRows(const ThesisModel& model) {
  std::vector<ThesisRow> rows;
  for (auto* group : {DisplacementRows, ElectricalRows, OptimumRows, FrequencyRows, RiseRows,
                      ReceptorRows, PrototypeRows}) {
    for (ThesisRow& row : group(model)) rows.push_back(row);
  }
  return rows;
}

const std::vector<ThesisRow>& Rows() {
  static const std::vector<ThesisRow> rows = ModelRows({});
  return rows;
}

const ThesisRow& RowOf(const std::vector<ThesisRow>& rows, std::string_view key) {
  const auto found = std::ranges::find(rows, key, &ThesisRow::key);
  EXPECT_NE(found, rows.end()) << key;
  return *found;
}

double Ours(std::string_view key) { return RowOf(Rows(), key).ours.value_or(0); }

const CandidateCause& CauseOf(std::string_view key, std::string_view words) {
  const auto& causes = RowOf(Rows(), key).candidates;
  const auto found = std::ranges::find_if(causes, [&](const CandidateCause& cause) {
    return cause.text.find(words) != std::string::npos;
  });
  EXPECT_NE(found, causes.end()) << key << ": " << words;
  return *found;
}

bool IsRow(std::string_view key) {
  return std::ranges::find(Rows(), key, &ThesisRow::key) != Rows().end();
}

double Reference(std::string_view key) {
  return std::ranges::find(tests::kThesisReference, key, &tests::ReferenceNumber::key)->value;
}

TEST(ThesisRows, AreTheNumbersOfAnIndependentSolution) {
  for (const auto& [key, value] : tests::kThesisReference) {
    if (!IsRow(key)) continue;  // a cause, below
    SCOPED_TRACE(key);
    EXPECT_REL(Ours(key), value, 1e-9, "phasors to 1e-13, roots to 1e-10");
  }
}

TEST(ThesisRows, OfTheOptimumAreThoseOfBruteForceAndMpmath) {
  EXPECT_REL(Ours("grid-rms"), tests::kGridRmsM, 1e-11, "NumPy, all 3.2 million points");
  const auto step = [](double low, double high, int place) {
    return low + (high - low) * tests::kGridPlaces[place] / 19;
  };
  EXPECT_REL(Ours("grid-motor-side-mass"), step(0.25e-3, 10e-3, 0), 1e-12, "a grid point");
  EXPECT_REL(Ours("grid-skin-side-mass"), step(0.25e-3, 10e-3, 1), 1e-12, "a grid point");
  EXPECT_REL(Ours("grid-stiffness"), step(2000, 12000, 2), 1e-12, "a grid point");
  EXPECT_REL(Ours("optimum-skin-side-mass"), tests::kRmsBestMa2, 1e-6, "flat");
  EXPECT_REL(Ours("optimum-stiffness"), tests::kRmsBestKa, 1e-6, "flat");
  EXPECT_REL(Ours("optimum-rms"), tests::kRmsBest, 1e-12, "mpmath");
  EXPECT_GE(Ours("optimum-upper-bound"), Ours("optimum-rms"));
  EXPECT_LT(Ours("optimum-upper-bound"), Ours("optimum-rms") * (1 + 1e-5));
  EXPECT_REL(Ours("most-skin-power"), tests::kPowerBest, 1e-9, "mpmath");
}

TEST(ThesisRows, CausesGiveWhatTheySay) {
  EXPECT_REL(CauseOf("rms-adapter", "last 10 periods").gives, tests::kAdapterWindowRmsM, 1e-10,
             "a 50-digit exponential");
  EXPECT_REL(CauseOf("phase", "without the coil's reaction").gives,
             Reference("phase-without-reaction"), 1e-8, "NumPy");
  EXPECT_ABS(CauseOf("current-reduction", "0.085 s").gives, 0.15, 0.005, "as printed");
  EXPECT_ABS(CauseOf("stimulus-direct", "printed RMS").gives, 49 * 0.0438e-3, 1e-15, "a product");
}

// beside a simulation with the input in straight lines between its samples
TEST(ThesisRows, OneRunAndStepBringTheTableWithinAPercent) {
  for (const std::string contact : {"direct", "cone", "adapter"}) {
    const std::string key = "rms-" + contact;
    const CandidateCause& cause = CauseOf(key, "interpolated");
    EXPECT_THAT(cause.text, HasSubstr("whole run of 0.7 s"));
    EXPECT_THAT(cause.text, HasSubstr("0.34 ms apart"));
    EXPECT_REL(cause.gives, Reference("interpolated-" + contact), 2e-3,
               "the step is said to two digits, the run ends within a step");
    EXPECT_REL(cause.gives, SiValue(ThesisNumberOf(key)), 0.007, "what is claimed of it");
  }
}

TEST(ThesisRows, EveryDisagreementSaysWhy) {
  for (const ThesisRow& row : Rows()) {
    if (VerdictOf(row) != RowVerdict::kDisagrees) continue;
    EXPECT_TRUE(!row.remark.empty() || !row.candidates.empty()) << row.key;
  }
}

TEST(ThesisRows, HaveTheVerdictsThatTheModelGives) {
  for (const std::string_view key :
       {"ratio-adapter-direct", "grid-damping", "grid-contact-area", "optimum-motor-side-mass",
        "rise-ratio", "impedance-match", "sensitivity-Ma1", "sensitivity-Ks", "receptors",
        "built-ia2"}) {
    EXPECT_EQ(VerdictOf(RowOf(Rows(), key)), RowVerdict::kReproduced) << key;
  }
  for (const std::string_view key :
       {"rms-direct", "rms-cone", "rms-adapter", "current", "power", "phase", "current-reduction",
        "resonant-frequency", "latency-adapter", "stimulus-direct", "stimulus-ratio"}) {
    EXPECT_EQ(VerdictOf(RowOf(Rows(), key)), RowVerdict::kExplained) << key;
  }
  for (const std::string_view key :
       {"grid-motor-side-mass", "optimum-stiffness", "start-ratio", "stimulus-adapter", "sag",
        "built-ia1", "gain-at-175hz", "power-saving", "contact-force"}) {
    EXPECT_EQ(VerdictOf(RowOf(Rows(), key)), RowVerdict::kDisagrees) << key;
  }
}

const CandidateCause& RoundingOf(std::string_view key) {
  const auto& causes = RowOf(Rows(), key).candidates;
  const auto found = std::ranges::find(causes, CauseKind::kRounding, &CandidateCause::kind);
  EXPECT_NE(found, causes.end()) << key;
  return *found;
}

// one set of inputs, each of which rounds to what Tables 2.1 and 2.4 print, gives all of Table 2.3
TEST(ThesisRows, OfTheTableAreWhatRoundedInputsGive) {
  for (const char* key : {"rms-direct", "rms-cone", "rms-adapter"}) {
    EXPECT_EQ(RoundingOf(key).text, RoundingOf("rms-direct").text) << "the same set";
    EXPECT_TRUE(Hits(ThesisNumberOf(key), RoundingOf(key))) << key << RoundingOf(key).gives;
    EXPECT_EQ(ExplainedBy(RowOf(Rows(), key)), CauseKind::kRounding) << key;
  }
  EXPECT_THAT(RoundingOf("rms-direct").text, HasSubstr("one set for 3 rows"));
  EXPECT_EQ(ExplainedBy(RowOf(Rows(), "power")), CauseKind::kRounding);
  EXPECT_FALSE(Hits(ThesisNumberOf("gain-at-175hz"), RoundingOf("gain-at-175hz")))
      << "no rounding makes a gain of 0.585 one above 1";
}

TEST(ThesisRows, TunedCausesAreMarkedAsTuned) {
  EXPECT_EQ(CauseOf("rms-direct", "interpolated").kind, CauseKind::kTuned);
  EXPECT_EQ(CauseOf("current-reduction", "0.085 s").kind, CauseKind::kTuned);
  EXPECT_EQ(CauseOf("current-reduction", "0.1 s").kind, CauseKind::kReading);
  EXPECT_EQ(CauseOf("phase", "without the coil's reaction").kind, CauseKind::kReading);
  EXPECT_EQ(ExplainedBy(RowOf(Rows(), "phase")), CauseKind::kReading);
}

// R i^2 of the cone, without the coil's reaction: NumPy
TEST(ThesisRows, ThePowerOfTheConeWithoutReaction) {
  EXPECT_ABS(CauseOf("power", "R i^2 of the cone").gives, 456.4e-3, 0.05e-3, "as it is printed");
}

// the rows hang on the model: another adapter, actuator or drive no longer agrees
TEST(ThesisRows, OfASpoiledModelDisagree) {
  ThesisModel stiff;
  stiff.adapter.stiffness_n_per_m *= 1.3;
  const auto disagrees = [](const std::vector<ThesisRow>& rows, std::string_view key) {
    EXPECT_EQ(VerdictOf(RowOf(rows, key)), RowVerdict::kDisagrees) << key;
  };
  disagrees(DisplacementRows(stiff), "ratio-adapter-direct");
  disagrees(FrequencyRows(stiff), "impedance-match");
  disagrees(PrototypeRows(stiff), "built-ia2");
  ThesisModel resistive;
  resistive.actuator.resistance_ohm *= 2;
  for (const std::string_view key : {"current", "power", "current-reduction"}) {
    disagrees(ElectricalRows(resistive), key);
  }
  ThesisModel slow;
  slow.drive.frequency_hz = 175;
  disagrees(DisplacementRows(slow), "ratio-adapter-direct");
}

TEST(StudyRows, FindTheTruthsThatTheTrialsWereMadeWith) {
  const auto study = RunGeneratedStudy({});
  ASSERT_TRUE(study) << study.error().Text();
  EXPECT_EQ(study->trials.table.trials.size(), 96U);
  EXPECT_EQ(study->matching.settings, 320U);
  EXPECT_EQ(study->linearity.lines.size(), 2U);
  const auto rows = StudyRows(*study);
  EXPECT_EQ(rows.size(), 10U);
  for (const ThesisRow& row : rows) {
    EXPECT_TRUE(row.generated) << row.key;
    EXPECT_EQ(VerdictOf(row), RowVerdict::kReproduced) << row.key;
  }
  // 48 trials with 5 % of scatter; eight settings a level with 3 %
  EXPECT_REL(*RowOf(rows, "factor-ia1").ours, 3.26, 0.03, "3 standard errors of the trials");
  EXPECT_REL(*RowOf(rows, "factor-ia2").ours, 4.25, 0.03, "3 standard errors of the trials");
  EXPECT_REL(*RowOf(rows, "matching-ia1").ours, 0.35, 0.03, "3 standard errors of the settings");
  EXPECT_REL(*RowOf(rows, "matching-ia2").ours, 0.32, 0.03, "3 standard errors of the settings");
}

}  // namespace
}  // namespace haptometer::tools
