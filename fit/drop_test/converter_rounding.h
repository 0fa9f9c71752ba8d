#pragma once

#include <cstddef>
#include <vector>

#include "fit/drop_test/ring_down_problem.h"
#include "fit/identifiability.h"

namespace haptometer::fit {

/// Mean error of a converter's code for the value `x` with Gaussian noise of standard deviation
/// `noise` before it, everything in steps:
///
///     e(x) = sum over codes m of Phi((x - m + 1/2)/noise) - x,   noise from 0 to 1/2;
///
/// without noise the rounding error itself, with it (1/pi) exp(-2 pi^2 noise^2) sin(2 pi x) at most
/// (Widrow and Kollar, Quantization Noise, 2008, 5.3).
[[nodiscard]] double MeanRoundingError(double x, double noise);

/// What the rounding of a record to its converter's codes may move the solution by: changes of the
/// parameters, independent of each other (CovarianceBy of fit/residuals.h).
///
/// A rounding error follows the motion, and is white noise only where many codes are passed or
/// noise goes before it. What a ringing of few codes makes of it is therefore computed: e(x) along
/// the fitted motion, in 16 cases over which the offset takes all places between two codes and the
/// ringing all peaks within a step, each evenly (van der Corput). The noise before the converter is
/// the residuals' without step/sqrt(12). Type A contains the white part already, which then counts
/// twice: at most sqrt(2) too wide where nothing but rounding is left.
/// @param seen at the solution `point`
/// @param step_v the converter's; 0: none
/// @param residual_v standard deviation of the record's residuals; empty where half a step of noise
///        or more goes before the converter
/// Cost: 16 times 6 error functions a sample.
[[nodiscard]] std::vector<std::vector<double>> RoundingChanges(const RingDownProblem& problem,
                                                               const RingDownPoint& point,
                                                               const Identifiability& seen,
                                                               std::size_t record, double step_v,
                                                               double residual_v);

}  // namespace haptometer::fit
