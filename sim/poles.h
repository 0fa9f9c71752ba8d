#pragma once

#include <complex>
#include <vector>

#include "sim/linear_model.h"

namespace haptometer::sim {

/// The natural motions exp(p t) of the undriven model: eigenvalues of A in rad/s, by rising |p|. A
/// pair p, p* rings at |p| / 2 pi Hz (undamped) and decays as exp(Re p t).
///
/// Balanced first (sim/matrix_exponential.h): good to about 1e-13 of |p| for the thesis's scenes.
/// Cost: some 20 us; allocates.
[[nodiscard]] std::vector<std::complex<double>> Poles(const LinearModel& model);

}  // namespace haptometer::sim
