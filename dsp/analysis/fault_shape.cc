#include "dsp/analysis/fault_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace haptometer::dsp {
namespace {

// e of a spike of `rows` rows (0: a step) of height 1 that begins at `at`, counted from the first
// row
CubicErrors ErrorOf(std::size_t at, std::size_t rows) {
  // two rows more on either side, which the cubic reads
  std::array<double, kShapeRows + 4> x{};
  for (std::size_t k = at + 2; k < x.size(); ++k) x[k] = rows == 0 || k < at + 2 + rows ? 1 : 0;
  CubicErrors error{};
  for (std::size_t k = 0; k < kShapeRows; ++k) error[k] = CubicError(x, k + 2);
  return error;
}

// projection of errors on a shape: height and squares that remain
struct Fit {
  double height = 0;
  double rest = 0;  // squares that are left
};

// height = (e, s) / (s, s), remainder = (e, e) - (e, s)^2 / (s, s)
Fit Project(const CubicErrors& error, const CubicErrors& shape) {
  double product = 0;
  double norm = 0;
  double square = 0;
  for (std::size_t k = 0; k < kShapeRows; ++k) {
    product += error[k] * shape[k];
    norm += shape[k] * shape[k];
    square += error[k] * error[k];
  }
  return {product / norm, square - product * product / norm};
}

}  // namespace

Fault BestFault(const CubicErrors& error) {
  Fault best;
  double least = std::numeric_limits<double>::infinity();
  // 0 rows: a step; else a spike of that many rows
  for (std::size_t rows = 0; rows <= 3; ++rows) {
    for (std::size_t at = kShapeReach - 2; at <= kShapeReach + 2; ++at) {
      const Fit fit = Project(error, ErrorOf(at, rows));
      if (!(fit.rest < least)) continue;
      least = fit.rest;
      best = {rows == 0 ? FaultKind::kStep : FaultKind::kSpike, at, std::max<std::size_t>(rows, 1),
              fit.height};
    }
  }
  return best;
}

// a drive that begins is quiet on one side and moves on the other
bool IsEdgeOfMotion(std::span<const double> values, std::size_t center, double height) {
  constexpr std::size_t kReach = 32;
  constexpr std::size_t kNear = 3;   // rows of the fault itself
  constexpr double kEdgeRatio = 4;   // of the mean changes
  constexpr double kEdgeHeight = 3;  // of the largest change, at most
  if (center < kReach + kNear || center + kReach + kNear >= values.size()) return false;
  const auto changes = [&](std::size_t first) {
    double sum = 0;
    double most = 0;
    for (std::size_t k = first; k + 1 < first + kReach; ++k) {
      const double change = std::abs(values[k + 1] - values[k]);
      sum += change;
      most = std::max(most, change);
    }
    return std::pair(sum, most);
  };
  const auto before = changes(center - kNear - kReach + 1);
  const auto after = changes(center + kNear);
  const auto& [quiet, moving] = std::minmax(before, after);
  return moving.first > kEdgeRatio * quiet.first && std::abs(height) <= kEdgeHeight * moving.second;
}

}  // namespace haptometer::dsp
