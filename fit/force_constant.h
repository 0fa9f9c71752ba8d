#pragma once

#include "fit/drop_test_fit.h"
#include "fit/drop_test_model.h"
#include "fit/drop_test_road.h"

namespace haptometer::fit {

/// |Km| at the end of a road.
///
/// By the heights its interval is that of its logarithm. By the loads, which show Km^2 in
/// proportion, it is that of Km^2: Km is determined where this excludes 0 (statistically, 97.5 % on
/// that side); else it has an upper limit, where the records see Km at all. Beyond 5 % of
/// uncertainty the interval is the profile likelihood's (ProfileWidth), the given numbers' share
/// added in squares on either side.
[[nodiscard]] FittedValue EvaluateForceConstant(const DropTestRoad& road,
                                                const DropTestModel& model);

/// How far from its best value Km^2 is carried, upwards (`side` 1) or downwards (-1), by the chi^2,
/// everything else fitted, growing by `coverage`^2 of the residuals' variance: `coverage` standard
/// deviations where Km^2 is Gaussian. In N^2/A^2, to 1 %. Cost: some ten fits.
[[nodiscard]] double ProfileWidth(const DropTestRoad& road, const DropTestModel& model, int side,
                                  double coverage);

}  // namespace haptometer::fit
