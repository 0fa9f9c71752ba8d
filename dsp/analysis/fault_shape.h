#pragma once

#include <array>
#include <cstddef>

#include "dsp/analysis/faults.h"

/// What spikes and steps leave in the errors of a cubic through a sample's neighbours.
namespace haptometer::dsp {

/// A shape is tried on rows center - kShapeReach .. center + kShapeReach.
inline constexpr std::size_t kShapeReach = 6;
inline constexpr std::size_t kShapeRows = 2 * kShapeReach + 1;
using CubicErrors = std::array<double, kShapeRows>;

/// What the cubic through the four neighbours leaves of `x` at `k`.
template <typename Values>
[[nodiscard]] double CubicError(const Values& x, std::size_t k) {
  return x[k] - (4 * (x[k - 1] + x[k + 1]) - (x[k - 2] + x[k + 2])) / 6;
}

/// The spike of one to three rows, or the step, whose own errors fit `error` best; its rows count
/// from the shape's first. Each is tried at five places about the middle.
[[nodiscard]] Fault BestFault(const CubicErrors& error);

}  // namespace haptometer::dsp
