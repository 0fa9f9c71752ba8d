#include "dsp/analysis/fault_shape.h"

#include <algorithm>
#include <limits>

namespace haptometer::dsp {
namespace {

// e of a spike of `rows` rows (0: a step) of height 1 that begins at `at`, counted from the first
// row
CubicErrors ErrorOf(std::size_t at, std::size_t rows) {
  std::array<double, kShapeRows + 4> x{};
  for (std::size_t k = at + 2; k < x.size(); ++k) x[k] = rows == 0 || k < at + 2 + rows ? 1 : 0;
  CubicErrors error{};
  for (std::size_t k = 0; k < kShapeRows; ++k) error[k] = CubicError(x, k + 2);
  return error;
}

struct Fit {
  double height = 0;
  double rest = 0;  // squares that are left
};

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

}  // namespace haptometer::dsp
