#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/quantity.h"
#include "fit/drop_test/experiment_plan.h"
#include "tools/cli/options.h"
#include "tools/fit/fit_lra_input.h"

namespace haptometer::tools {

/// What fit-lra's command line says of drops that are still to be made.
struct PlanWords {
  bool asked = false;                ///< --plan
  std::vector<std::string> wishes;   ///< "Km 2%"
  std::vector<std::string> guesses;  ///< "Q 60", "Km 1N/A", "Bv 0.03"
  std::optional<Quantity> natural_frequency_hz;
  std::optional<Quantity> noise_v;
  std::optional<Quantity> range_v;
  std::optional<Quantity> length_s;
  std::optional<std::int64_t> bits;
  std::optional<std::int64_t> taps;
};

/// Declares --plan and what belongs to it.
void DeclarePlan(cli::Options& options, PlanWords& words);

/// Refuses an option of the plan that stands without --plan. Error: Cause::kUsage, naming it.
[[nodiscard]] Result<void> CheckNotPlanned(const PlanWords& words);

/// Refuses what no plan can take: files, a free case, several loads, values out of range.
/// Errors: Cause::kUsage.
[[nodiscard]] Result<void> CheckPlanWords(const PlanWords& words, const FitLraOptions& stated);

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

}  // namespace haptometer::tools
