#pragma once

// What lane_kernel.cc, compiled once for each instruction set, gives to lane_cascade.cc.

#include <cstddef>
#include <cstdint>

#include "dsp/filter/butterworth.h"

namespace haptometer::dsp {

inline constexpr std::size_t kLanes = 8;
/// Samples of one lane. Not a power of two: lanes 4096 bytes apart would share one set of the
/// cache.
inline constexpr std::size_t kLaneSamples = 504;
/// Samples that the lanes hold together: 31.5 KiB.
inline constexpr std::size_t kTileSamples = kLanes * kLaneSamples;

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

/// The functions of one instruction set. `rows` are kLaneSamples rows of kLanes values, aligned to
/// 64 bytes.
struct LaneKernel {
  /// Lane j becomes the j-th eighth of the tile, in the order in which the filter meets it.
  void (*gather)(const double* tile, Direction direction, double* rows);
  /// The same, back.
  void (*scatter)(const double* rows, Direction direction, double* tile);
  /// Runs the cascade down all lanes and leaves its states; the outputs take the inputs' place.
  void (*filter)(const FilterDesign& design, double* rows, LaneStates& states);
  /// The states only; `rows` stay.
  void (*advance)(const FilterDesign& design, double* rows, LaneStates& states);
};

extern const LaneKernel kLaneKernelBaseline;
extern const LaneKernel kLaneKernelAvx2;
extern const LaneKernel kLaneKernelAvx512;

}  // namespace haptometer::dsp
