#pragma once

#include <cstddef>

#include "base/error.h"
#include "sim/skin/skin.h"
#include "sim/tuning/adapter_objective.h"
#include "sim/tuning/tuning_problem.h"
#include "tools/cli/options.h"
#include "tools/document/present.h"

namespace haptometer::tools {

/// What tune is asked.
struct TuneQuestion {
  std::string name;  ///< of the scene, or "thesis"
  sim::TuningProblem problem;
  sim::Objective objective = sim::Objective::kSkinRms;
  sim::ReceptorField receptors{};
  std::size_t grid_values = 20;
  std::optional<double> latency_limit_s{};  ///< only of skin-rms without other limits
  std::vector<double> springs_n_per_m{};    ///< to choose from; empty: any within the bounds
  std::vector<std::string> left_out{};      ///< effects of the scene that tune leaves out
  bool has_stops = false;                   ///< among them travel stops
};

/// The command line of tune: what is asked without the scene, and what is put to the scene.
struct TuneWords {
  TuneQuestion asked{.name = "thesis", .problem = sim::ThesisProblem()};
  std::vector<std::string> scenes;
  std::string objective = "skin-rms";
  std::string skin = "text";
  std::string receptor_grid = "cell";
  std::optional<double> voltage_v, frequency_hz, receptors_per_mm2;
  std::optional<std::int64_t> grid;
  document::Outputs outputs;
};

void Declare(cli::Options& options, TuneWords& words);

/// Reads the scene, if there is one. Errors (Cause::kUsage): more than one scene, bounds that
/// Fault() refuses, a drive of 0, an objective that is not answered for what else is asked.
[[nodiscard]] Result<TuneQuestion> ReadQuestion(const TuneWords& words);

}  // namespace haptometer::tools
