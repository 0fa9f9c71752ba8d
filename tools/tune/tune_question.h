#pragma once

#include <cstddef>

#include "base/error.h"
#include "sim/skin/skin.h"
#include "sim/tuning/adapter_objective.h"
#include "sim/tuning/tuning_problem.h"
#include "tools/cli/options.h"
#include "tools/document/present.h"

namespace haptometer::tools {

/// The command line of tune as it was typed.
struct TuneWords {
  std::vector<std::string> scenes;
  std::string objective = "skin-rms";
  std::string skin = "text";
  std::string motor_side_mass, skin_side_mass, stiffness, damping, contact_area, springs, latency;
  std::string receptor_grid = "cell";
  std::optional<Quantity> voltage, frequency, receptor_density, field_radius, pad_side, skin_varies,
      mover_travel;
  std::optional<std::int64_t> grid;
  document::Outputs outputs;
};

/// What tune is asked.
struct TuneQuestion {
  std::string name;  ///< of the scene, or "thesis"
  sim::TuningProblem problem;
  sim::Objective objective = sim::Objective::kSkinRms;
  sim::ReceptorField receptors;
  std::size_t grid_values = 20;
  std::optional<double> latency_limit_s{};  ///< only of skin-rms without other limits
  std::vector<double> springs_n_per_m;      ///< to choose from; empty: any within the bounds
  std::vector<std::string> left_out;        ///< effects that the scene names and tune does not know
  bool has_stops = false;                   ///< among them
};

void Declare(cli::Options& options, TuneWords& words);

/// Reads the scene, if there is one, and the bounds. Errors (Cause::kUsage): more than one scene, a
/// bound that is no "LOW:HIGH" or number with its unit, bounds that Fault() refuses, a drive of 0
/// or a number outside what scenes can have, a latency without a unit, an objective that is not
/// answered for what else is asked.
[[nodiscard]] Result<TuneQuestion> ReadQuestion(const TuneWords& words);

}  // namespace haptometer::tools
