#pragma once

#include <cstddef>

namespace haptometer::fit {

/// Prints rows of docs/fit_cost.csv: FitDropTest's errors by what the experiment was, one thing
/// changed at a time, beside the bound and what experiment_plan.h expects.
void MeasureExperiments(std::size_t seeds);

}  // namespace haptometer::fit
