#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "dsp/filter/butterworth.h"
#include "dsp/filter/flush_subnormals.h"

namespace haptometer::dsp {

/// A causal run of a cascade of delta-form sections, with its state between calls.
///
/// The output depends only on the samples fed so far, never on how they were split: chunks of 1, 7,
/// 4096 or all samples give the same bytes. Samples are finite (checked by who reads them: a NaN
/// would stay for ever); magnitudes below 2.2e-308 count as 0, so that silence after a signal costs
/// no more than the signal did. Not for two threads at once. No allocation.
class Cascade {
 public:
  /// Begins at rest: as if the input had been 0 for ever.
  explicit Cascade(const FilterDesign& design);

  /// Sets the state as if the input had been `input` for ever. Exact: a constant leaves the filter
  /// as exactly 0.
  void StartFrom(double input);

  /// Filters in.size() samples; `out` has the same size and may be `in` itself.
  void Process(std::span<const double> in, std::span<double> out);

  /// y[n-1] of each section, then d[n-1] of each: 2 values a section.
  void CopyState(std::span<double> state) const;

 private:
  struct State {
    double output = 0;        // y[n-1]
    double step = 0;          // d[n-1] = y[n-1] - y[n-2]
    double input_before = 0;  // x[n-1] - x[n-2], or the sum of a low-pass section
  };
  using RunFunction = void (Cascade::*)(std::span<const double>, std::span<double>);

  template <int kOrder>
  void Run(std::span<const double> in, std::span<double> out);
  static RunFunction RunOf(int order);

  std::array<DeltaSection, kHighestOrder> sections_{};
  std::array<State, kHighestOrder> states_{};
  std::size_t count_ = 0;
  RunFunction run_ = nullptr;
  double last_input_ = 0;  // x[n-1]
};

/// Aborts unless `design` has the sections that its order says.
void CheckSections(const FilterDesign& design);

}  // namespace haptometer::dsp
