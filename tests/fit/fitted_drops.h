#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "fit/drop_test/drop_test_fit.h"
#include "tests/fit/synthetic_drop.h"
#include "tests/fit/unprepared_drops.h"

namespace haptometer::tests {

/// The fit of records that must be fitted and converge.
inline fit::DropTestFit Fit(const std::vector<fit::ImpulseRecord>& records,
                            const fit::ActuatorKnowns& knowns = ThesisKnowns()) {
  auto fit = fit::FitDropTest(records, knowns);
  EXPECT_TRUE(fit) << (fit ? "" : fit.error().Text());
  if (!fit) return {};
  EXPECT_TRUE(fit->converged) << fit->termination;
  return *fit;
}

}  // namespace haptometer::tests
