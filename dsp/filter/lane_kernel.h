#pragma once

// What lane_kernel.cc, compiled once for each instruction set, gives to lane_cascade.cc.

#include <cstddef>
#include <cstdint>

#include "dsp/filter/butterworth.h"

namespace haptometer::dsp {

inline constexpr std::size_t kLanes = 16;
/// Samples of one lane. Not a power of two: lanes 4096 bytes apart would share one set of the
/// cache.
inline constexpr std::size_t kLaneSamples = 252;
/// Samples that the lanes hold together: 31.5 KiB.
inline constexpr std::size_t kTileSamples = kLanes * kLaneSamples;

inline constexpr std::size_t kMostStates = 2UZ * kHighestOrder;

/// Which way a filter goes through a signal in time.
enum class Direction : std::uint8_t { kForward, kBackward };

/// The states of one cascade in each lane: y[n-1] and d[n-1] of each section, and of the first
/// section's input the last value and what the section needs of the one before.
struct alignas(64) LaneStates {
  double output[kHighestOrder][kLanes];
  double step[kHighestOrder][kLanes];
  double last_input[kLanes];
  double input_before[kLanes];
};

/// The tiles that are needed next: what is read and what is written then.
struct TilesAhead {
  const double* read;
  const double* written;
};

/// The functions of one instruction set. `rows` are kLaneSamples rows of kLanes values, aligned to
/// 64 bytes: row n holds sample n of each lane, lane j the j-th part of the tile.
struct LaneKernel {
  void (*gather)(const double* tile, double* rows);
  /// The same, back in order of time.
  void (*scatter)(const double* rows, double* tile);
  /// Runs the cascade through all lanes, each from its first sample to its last or the other way,
  /// and leaves the states. `out` may be `rows`. The tiles ahead are fetched into the cache
  /// meanwhile.
  void (*filter)(const FilterDesign& design, Direction direction, const double* rows, double* out,
                 const TilesAhead& ahead, LaneStates& states);
  /// The states that it would leave, all outputs and steps being 0 before, at a third of the cost:
  ///   state = sum over n of weights[n] m[n]
  /// with m the first section's combination of inputs and weights[n] (a value for each state,
  /// y of each section, then d of each) what is left at the end of m = 1 at sample n of the way.
  void (*weigh)(const FilterDesign& design, Direction direction, const double* rows,
                const double* weights, LaneStates& states);
  /// From the states that each lane would leave if it began from rest (z) to those that it begins
  /// from: the first lane on the way from `state`, each next one from A^M s + z of the one before;
  /// the last one's goes to `state`. `handover` is A^M, by columns; it and `state` (y of each
  /// section, then d of each, then zeros) have kMostStates rows, aligned to 64 bytes.
  void (*hand_over)(const FilterDesign& design, Direction direction, const double* handover,
                    double* state, LaneStates& states);
};

extern const LaneKernel kLaneKernelBaseline;
#ifdef __x86_64__
extern const LaneKernel kLaneKernelAvx2;
extern const LaneKernel kLaneKernelAvx512;
#else
// no processor has these sets
inline constexpr const LaneKernel& kLaneKernelAvx2 = kLaneKernelBaseline;
inline constexpr const LaneKernel& kLaneKernelAvx512 = kLaneKernelBaseline;
#endif

}  // namespace haptometer::dsp
