#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "sim/linear/steady_state.h"
#include "sim/skin/skin_rise.h"
#include "sim/tuning/adapter_grid.h"
#include "sim/tuning/adapter_optimum.h"
#include "tools/tune/tune_question.h"

namespace haptometer::tools {

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
  std::optional<sim::SkinRise> rise;     ///< of its skin from rest; absent where none is told
  std::optional<double> stimulus_m;      ///< S; absent for a skin without area
  double matched_load_bound = 0;         ///< of the objective
  std::optional<sim::GridBest> grid;     ///< absent for rms-per-watt, listed springs and any limit
  std::vector<sim::RidgePoint> ridge;    ///< over the motor side's mass; empty where that is fixed,
                                         ///< springs listed or latency limited
  std::vector<sim::RidgePoint> listed;   ///< the best with each listed spring, in their order
  std::vector<WrongSpring> springs;  ///< 5 % too soft and 5 % too stiff; none of a limited latency
};

/// The unit in which people say an objective, and how many of it one SI unit is.
struct SpokenUnit {
  double factor;
  const char* unit;
};
[[nodiscard]] SpokenUnit SpokenUnitOf(sim::Objective objective);

/// Why no latency is told of the adapter.
[[nodiscard]] std::string NoLatencyText(const sim::TuningProblem& problem,
                                        const sim::AdapterPoint& point);

/// What the numbers rest on, one sentence each.
[[nodiscard]] std::vector<std::string> TuneAssumptions(const TuneAnswer& answer);

/// The answer for people, in um, g and mm2.
[[nodiscard]] std::string TuneText(const TuneAnswer& answer);

/// The answer as one JSON document in SI units; what is not known is null.
[[nodiscard]] std::string TuneJson(const TuneAnswer& answer);

/// Draws the objective and the mover's travel around the optimum, each of the adapter's numbers
/// from 0.7 to 1.3 of itself with the others held (and the spring with the skin side's mass chosen
/// anew), and the ridge where there is one. Errors: as plot::DrawPanels.
[[nodiscard]] Result<void> DrawTune(const std::string& path, const TuneAnswer& answer);

}  // namespace haptometer::tools
