#pragma once

// One row of the ladder of fit_cost.cc: errors over its seeds, times, and the bound beside them.

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/fit_rungs.h"
#include "tests/fit/synthetic_drop.h"

namespace haptometer::fit {

/// Of Kv, Bv, Km, relative.
using Errors = std::array<double, 3>;

struct Row {
  std::string ladder;
  std::string what;
  std::string setting;
  double least_wrong = 0;  ///< error of Kv from which on a fit has failed: another oscillation's
};

/// Of the processor, so that what else runs does not count.
[[nodiscard]] double MillisecondsOf(const std::function<void()>& work);

/// What all seeds of one row say.
class FitTally {
 public:
  explicit FitTally(Row row) : row_(std::move(row)) {}

  /// `solver_ms` is a part of `milliseconds`. Nothing found: a failure.
  void Add(const std::optional<Constants>& found, double milliseconds, double solver_ms);

  /// As a line of docs/fit_cost.csv; what is 0 is left empty.
  void Print(const Errors& bounds, const Errors& planned) const;

 private:
  void Take(std::size_t k, double error);

  Row row_;
  std::vector<double> times_;
  std::vector<double> solver_times_;
  Errors squares_{};
  std::array<int, 3> counts_{};
  int seeds_ = 0;
  int failures_ = 0;
};

/// The thesis's actuator at 5 kHz for 0.25 s, noise of 0.5 % of the first peak.
[[nodiscard]] tests::SyntheticDrop BaseDrop();

/// The drop with a load.
[[nodiscard]] tests::SyntheticDrop Loaded(tests::SyntheticDrop drop, double load_ohm);

/// Cramer-Rao bounds of `drops` open records and as many with the load, from an eighth of a period
/// behind the blow; written without fit/.
[[nodiscard]] Errors BoundsOf(const tests::SyntheticDrop& drop, double load_ohm, std::size_t drops);

/// FitDropTest, where it determines Kv and Bv.
[[nodiscard]] std::optional<Constants> FitWhole(const std::vector<ImpulseRecord>& records,
                                                const ActuatorKnowns& knowns);

}  // namespace haptometer::fit
