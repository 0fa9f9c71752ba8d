#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "sim/linear/steady_state.h"
#include "sim/skin/skin.h"
#include "sim/skin/skin_rise.h"
#include "sim/tuning/adapter_grid.h"
#include "sim/tuning/adapter_objective.h"
#include "sim/tuning/adapter_optimum.h"
#include "sim/tuning/tuning_problem.h"
#include "tools/document/document.h"

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
  std::optional<sim::Skin> scene_skin{};    ///< of the scene
};

/// How the adapter was found where its latency is limited.
struct LatencySearch {
  std::size_t runs = 0;  ///< of simulated adapters
  /// Whether the best without the limit keeps to it, so that its proof is the answer's too.
  bool proved = true;
  sim::RidgePoint unlimited;  ///< the best that was found without the limit
  double least_limit_s = 0;   ///< as of sim::PromptBest
};

/// A spring that is off.
struct WrongSpring {
  sim::SpringCost cost;
  double mover_peak_m = 0;  ///< travel with nothing else changed, which may be beyond its limit
};

/// Everything that tune answers.
struct TuneAnswer {
  TuneQuestion question;
  sim::AdapterOptimum optimum;
  std::optional<LatencySearch> latency;  ///< absent without a limited latency
  sim::SteadyState steady;               ///< of the best adapter
  double skin_power_w = 0;               ///< mean power into the skin
  std::optional<sim::SkinRise> rise;     ///< of its skin from rest; absent where none is known
  std::optional<double> stimulus_m;      ///< S; absent for a skin without area
  double matched_load_bound = 0;         ///< of the objective
  std::optional<sim::GridBest> grid;     ///< absent for rms-per-watt, listed springs and any limit
  std::vector<sim::RidgePoint> ridge;    ///< over the motor side's mass; empty where that is fixed,
                                         ///< springs listed or latency limited
  std::vector<sim::RidgePoint> listed;   ///< the best with each listed spring, in their order
  std::vector<WrongSpring> springs;  ///< 5 % too soft and 5 % too stiff; none of a limited latency
};

/// Why the latency of the adapter is not known.
[[nodiscard]] std::string NoLatencyText(const sim::TuningProblem& problem,
                                        const sim::AdapterPoint& point);

/// The answer as a document.
///
/// Its figures, where they are asked for, are the objective and the mover's travel around the
/// optimum, each of the adapter's numbers from 0.7 to 1.3 of itself with the others held (and the
/// spring with the skin side's mass chosen anew), and the ridge where there is one; they cost some
/// 800 values of the objective.
[[nodiscard]] document::Document TuneDocument(const TuneAnswer& answer, bool has_figures);

}  // namespace haptometer::tools
