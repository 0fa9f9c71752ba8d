#pragma once

#include <cstddef>
#include <optional>

#include "sim/skin/skin_rise.h"
#include "sim/tuning/tuning_problem.h"

namespace haptometer::sim {

/// How long a latency's run lasts, in whole ms: 0.5 s or 40 periods, whichever is longer.
[[nodiscard]] double LatencyRunS(const TuningProblem& problem);

/// The rise of the skin that `simulate` tells of the adapter: from rest under the problem's drive
/// for LatencyRunS(), all states and looks as PlayWaveforms() has them. Nothing where the amplitude
/// does not pass from 10 % to 90 %, or the run would take more than 1e6 outputs (drives below some
/// 0.2 Hz, and bodies that are far faster than their drive). Cost: a run, some 0.5 ms.
[[nodiscard]] std::optional<SkinRise> RiseWith(const TuningProblem& problem,
                                               const AdapterPoint& point);

/// Whether RiseWith() has nothing to tell of the adapter for its run's too many outputs.
[[nodiscard]] bool RunIsTooLong(const TuningProblem& problem, const AdapterPoint& point);

/// The largest skin RMS that was found among adapters of no more than a latency.
struct PromptBest {
  AdapterPoint point{};
  double value = 0;      ///< skin RMS, m; 0: no adapter found that is prompt enough
  SkinRise rise{};       ///< of it
  std::size_t runs = 0;  ///< of different adapters, that the search took
  /// The least uncertainty of the latencies of those runs: no limit below it can be kept. 0: none
  /// of them tells a latency.
  double least_limit_s = 0;
  /// Whether it is the best without the limit, and so no less proved; else it was only searched.
  bool is_unlimited = false;
};

/// The best adapter whose latency with its standard uncertainty, SkinRise::LatencyAtMostS(), is no
/// more than `limit_s`; `unlimited` is the best without the limit and the answer, to the bit, where
/// it keeps to it. A limit below the uncertainty is not searched: nothing could be told to keep it.
///
/// The latency is a number of a whole run, without slopes and with jumps: of the rate at which the
/// run is looked at, of which crossing of a beating envelope is the first. So it is searched, not
/// proved: runs over an even lattice of Ma1, Ka and the ends of Ba and the area, with Ma2 where it
/// serves the RMS best and to either side, the largest RMS first, give prompt adapters to start
/// from. From each, and from `unlimited`, the latency is taken as its straight line (differences
/// over a hundredth of the ranges, of small numbers a part of themselves, in the end over 1/2500)
/// within a trust region, where ClimbWithinBounds() finds the largest RMS exactly; what the line
/// missed is taken off, and a step counts only if its own run keeps to the limit and the RMS grows.
/// A climb that comes to a summit that is known ends there.
/// That the adapter keeps to the limit is certain; that no other does and moves the skin more is
/// not: an upper bound is that without the limit. The same numbers each time.
///
/// Against differential evolution with 4000 runs of its own (tests/sim/tuning/
/// latency_reference.py) it found 1.9e-5 to 3.4e-4 more at four limits. Worked: the thesis's
/// problem within 2.654 ms, of which 0.654 ms are the uncertainty, gives 187.56 um, where the best
/// without the limit takes 2.935 ms for 201.89 um.
///
/// The problem: no Fault(), skin_variation or mover_limit_m; limit_s > 0. Cost: some 130 to 450
/// runs.
[[nodiscard]] PromptBest BestWithinLatency(const TuningProblem& problem, double limit_s,
                                           const AdapterPoint& unlimited);

}  // namespace haptometer::sim
