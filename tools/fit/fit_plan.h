#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "fit/drop_test/experiment_plan.h"
#include "tools/fit/fit_lra_input.h"
#include "tools/fit/fit_plan_options.h"

namespace haptometer::tools {

/// A wish of --want and how it fares.
struct AnsweredWish {
  fit::AccuracyWish wish;   ///< of the standard uncertainty; --want is the half 95 % interval
  fit::DropCount count;     ///< that it takes, 50 of each kind at most
  bool is_reached = false;  ///< by the card's drops
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
  std::vector<std::string> assumptions;  ///< sentences
  std::string command;                   ///< that fits the records
};

/// Works out the test card. Masses, resistance, inductance, drop height, rebound, time scale and
/// load are those of fit-lra's options; --rate is the recorder's. What is not stated is taken from
/// --actuator, else assumed, and said so; only resistance and natural frequency must be stated.
///
/// Errors (Cause::kUsage): a plan option without --plan, files, a word of --want or --guess that
/// says nothing, a free case, a value out of range.
[[nodiscard]] Result<TestCard> MakeTestCard(const PlanWords& words, const FitLraOptions& stated);

/// Prints the test card. Status 0, 2 after an error, 3 where a wish is not reached.
[[nodiscard]] int RunFitPlan(const PlanWords& words, const FitLraOptions& stated, bool json);

}  // namespace haptometer::tools
