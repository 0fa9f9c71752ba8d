#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "dsp/filter/butterworth.h"

namespace haptometer::dsp {

/// A causal run of a cascade of delta-form sections, with its state between calls.
///
/// The output depends only on the samples fed so far, never on how they were split: chunks of 1, 7,
/// 4096 or all samples give the same bytes. Not for two threads at once. No allocation.
class Cascade {
 public:
  /// Begins at rest: as if the input had been 0 for ever.
  explicit Cascade(const FilterDesign& design);

  /// Sets the state as if the input had been `input` for ever. Exact for a filter whose first
  /// section blocks a constant: every output was 0.
  void StartFrom(double input);

  /// Filters in.size() samples; `out` has the same size and may be `in` itself.
  void Process(std::span<const double> in, std::span<double> out);

 private:
  struct State {
    double output = 0;        // y[n-1]
    double step = 0;          // d[n-1] = y[n-1] - y[n-2]
    double input_before = 0;  // of high-pass and band-pass: x[n-1] - x[n-2]; low-pass: the sum
  };

  template <std::size_t kPairs, std::size_t kMiddle>
  void Run(std::span<const double> in, std::span<double> out);

  std::array<DeltaSection, kHighestOrder> sections_{};
  std::array<State, kHighestOrder> states_{};
  std::size_t count_ = 0;
  double last_input_ = 0;  // x[n-1]
};

}  // namespace haptometer::dsp
