#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "base/instruction_set.h"
#include "dsp/filter/butterworth.h"
#include "dsp/filter/lane_kernel.h"

namespace haptometer::dsp {

/// What the lanes of a cascade need of its design; made once, shared by any number of threads.
///
/// A signal is cut into tiles of kTileSamples, a tile into kLanes stretches that run side by side.
/// A stretch of M samples takes a state s to A^M s + z, z being where it would come from rest: a
/// weighted sum of the inputs gives z in all lanes, the states are handed over from lane to lane,
/// one run gives the outputs. A^M is made by the kernel itself, from unit states, the weights by
/// Cascade.
class LanePlan {
  // y of each section, then d of each
  struct alignas(64) StateVector : std::array<double, kMostStates> {};

 public:
  explicit LanePlan(const FilterDesign& design, InstructionSet set = UsableInstructionSet());

  [[nodiscard]] const FilterDesign& design() const { return design_; }

 private:
  friend class LaneCascade;

  FilterDesign design_;
  const LaneKernel* kernel_;
  std::size_t sections_;
  std::array<StateVector, kMostStates> handover_{};  // A^M, by columns
  std::vector<double> weights_;                      // as LaneKernel::weigh takes them
};

/// A causal run over whole tiles, forward or backward in time: Cascade's filter, faster.
///
/// Tiles are in order of time before the forward run, and after it as the kernel's rows, which the
/// backward run takes: so they are turned once each way. Differs from Cascade by rounding only
/// (1e-14 of the output). The bytes depend neither on the instruction set nor on how many tiles a
/// call has. Finite samples only; no subnormal numbers. Not for two threads at once.
class LaneCascade {
 public:
  /// All that a run remembers of the samples behind it.
  class State {
    friend class LaneCascade;
    LanePlan::StateVector sections_{};
    double last_input_ = 0;         // x[n-1]
    double input_before_last_ = 0;  // x[n-2]
  };

  /// `plan` outlives this.
  explicit LaneCascade(const LanePlan& plan) : plan_(&plan) {}

  /// As Cascade::StartFrom.
  void StartFrom(double input);

  /// The state between two tiles, and back to it: the tile that follows gives the same bytes.
  [[nodiscard]] const State& state() const { return state_; }
  void GoOnFrom(const State& state) { state_ = state; }

  /// Takes in tiles, in order of time, without giving their output: a third of the work.
  void AdvanceForward(std::span<const double> tiles);
  /// Filters tiles in order of time to as many `rows` (aligned to 64 bytes).
  void ProcessForward(std::span<const double> tiles, std::span<double> rows);

  /// Takes in tiles of rows, the last one first.
  void AdvanceBackward(std::span<const double> rows);
  /// Filters tiles of rows, the last one first, to `out`, in order of time: as many samples, or
  /// fewer, the last tile's rest is then left out.
  void ProcessBackward(std::span<const double> rows, std::span<double> out);

 private:
  void TakeRows(const double* rows, Direction direction);
  void HandOver(Direction direction);

  const LanePlan* plan_;
  State state_{};
  LaneStates lanes_{};
  alignas(64) std::array<double, kTileSamples> rows_;
  alignas(64) std::array<double, kTileSamples> tile_;
};

}  // namespace haptometer::dsp
