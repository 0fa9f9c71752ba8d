#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/quantity.h"
#include "fit/drop_test/impulse_record.h"
#include "fit/experiment_plan.h"
#include "tools/document/document.h"
#include "tools/fit/actuator.h"

namespace haptometer::tools {

/// "Kv", "Bv", "Km".
[[nodiscard]] std::string_view SymbolOf(fit::Constant constant);

/// Reads "Km 2%", half a 95 % interval, as a standard uncertainty. Errors (Cause::kUsage): another
/// symbol, no percentage, not above 0 and at most 25 %.
[[nodiscard]] Result<fit::AccuracyWish> ParseWish(const std::string& word);

/// What is supposed of an actuator's constants, in SI units.
struct ConstantGuesses {
  std::optional<double> quality_factor;
  std::optional<double> damping_n_s_per_m;
  std::optional<double> force_constant_n_per_a;
};

/// Reads "Q 60", "Bv 0.03", "Km 1N/A". Errors (Cause::kUsage): another symbol, no number
/// from 1e-6 to 1e6.
[[nodiscard]] Result<ConstantGuesses> ParseGuesses(const std::vector<std::string>& words);

/// A wish of --want and how it fares.
struct AnsweredWish {
  fit::AccuracyWish wish;   ///< of the standard uncertainty; --want is the half 95 % interval
  fit::DropCount count;     ///< that it takes, 50 of each kind at most
  bool is_reached = false;  ///< by the card's drops
};

/// What is stated of a test; what is empty is taken from the actuator, else from what is assumed.
struct PlanWords {
  ActuatorWords actuator;
  std::vector<std::string> wishes;   ///< "Km 2%"
  std::vector<std::string> guesses;  ///< "Q 60", "Km 1N/A", "Bv 0.03"
  std::optional<double> natural_frequency_hz;
  std::optional<double> noise_v;
  std::optional<double> range_v;
  std::optional<double> length_s;
  std::optional<double> rate_hz;
  std::optional<Quantity> load_ohm;
  fit::ImpulseRecord drop;  ///< height, rebound and time scale; without samples
  std::optional<std::int64_t> bits;
  std::optional<std::int64_t> taps;
};

/// A test of an actuator, worked out.
struct TestCard {
  fit::PlannedDrops drops;
  fit::ExpectedUncertainties expected;
  fit::ExpectedRinging ringing;
  std::optional<fit::LoadChoice> load;  ///< absent: the load is stated
  double height_m = 0;                  ///< of a fall that gives the blow
  double range_v = 0;                   ///< of the converter, from end to end
  std::int64_t bits = 0;
  double pre_trigger_s = 0;  ///< recorded before the blow, beside drops.length_s
  double trigger_v = 0;
  std::vector<AnsweredWish> wishes;
  document::Section notes;  ///< its findings: how the test is made, and what is assumed
  std::string command;      ///< that fits the records
};

/// Works a test out. Errors (Cause::kUsage): no resistance, no frequency, a quality factor, rate,
/// length or range that no test has; as FindActuator, ParseWish and ParseGuesses.
[[nodiscard]] Result<TestCard> MakeTestCard(const PlanWords& words);

/// What keeps a wish from being reached: "moving mass", "converter steps"; "" of kNone.
[[nodiscard]] std::string_view NameOf(fit::PlanLimit limit);

/// The largest cause of an uncertainty: "noise and converter", "coil resistance".
[[nodiscard]] std::string_view LargestCause(const fit::ExpectedUncertainty& uncertainty);

/// The card as a document (docs/reference/plan-drop-test.md), to be printed and taken to the bench.
[[nodiscard]] document::Document PlanDocument(const TestCard& card);

}  // namespace haptometer::tools
