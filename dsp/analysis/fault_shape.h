#pragma once

#include <array>
#include <cstddef>
#include <span>

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

/// Whether motion begins or ends at `center`, so that what looks like a fault of `height` is a
/// drive that was switched: the changes from row to row over 32 rows on one side (three rows away)
/// are four times those on the other, and the height is at most three times the largest of them.
/// False within 35 rows of either end of `values`, and where any of these rows is NaN.
[[nodiscard]] bool IsEdgeOfMotion(std::span<const double> values, std::size_t center,
                                  double height);

}  // namespace haptometer::dsp
