#pragma once

// One step of a cascade of delta-form sections, for one signal or for several side by side: the one
// definition of the recursion. Internal to dsp/filter.

#include <cstddef>

#include "dsp/filter/butterworth.h"

namespace haptometer::dsp {
// Unnamed on purpose: a file compiled for one instruction set must never hand its copy of a
// function to a file compiled for another.
namespace {

/// The kind of a section of a cascade of `order` sections.
constexpr SectionKind KindAt(int order, std::size_t section) {
  const auto pairs = static_cast<std::size_t>(order / 2);
  if (section < pairs) return SectionKind::kHighPass;
  return order % 2 == 1 && section == pairs ? SectionKind::kBandPass : SectionKind::kLowPass;
}

/// Whether `Value` is a number or a row of them: the same operations in the same order. Sections
/// are DeltaSections, or have e, f and b in another type of number.
template <int kOrder, typename Value>
struct CascadeStep {
  static constexpr std::size_t kCount = kOrder;

  Value output[kCount];        // y[n-1]
  Value step[kCount];          // d[n-1] = y[n-1] - y[n-2]
  Value input_before[kCount];  // x[n-1] - x[n-2], or the sum of a low-pass section
  Value last_input;            // x[n-1] of the first section

  // One sample runs through all sections before the next: the processor overlaps the sections of
  // neighbouring samples.
  [[gnu::always_inline]] inline Value Advance(const auto* sections, const Value& input) {
    const Value input_step = input - last_input;  // exact within a factor of two (Sterbenz)
    const Value before = last_input;
    last_input = input;
    return From<0>(sections, input, before, input_step);
  }

  /// What Advance feeds to the first section's recursion, and what it remembers of the input.
  [[gnu::always_inline]] static inline Value FirstCombined(const Value& input, Value& last_input,
                                                           Value& input_before) {
    const Value now = input - last_input;
    const Value combined = Combined<KindAt(kOrder, 0)>(now, input_before);
    last_input = input;
    input_before = now;
    return combined;
  }

 private:
  // section k with its input x[n], x[n-1] and x[n] - x[n-1], and all that follow
  template <std::size_t k>
  [[gnu::always_inline]] inline Value From(const auto* sections, const Value& x,
                                           const Value& x_before, const Value& x_step) {
    if constexpr (k == kCount) {
      return x;
    } else {
      // the numerator's combination of inputs, and what it needs next time
      constexpr SectionKind kKind = KindAt(kOrder, k);
      const Value now = kKind == SectionKind::kLowPass ? x + x_before : x_step;
      const Value combined = Combined<kKind>(now, input_before[k]);
      input_before[k] = now;
      const Value y_before = output[k];
      step[k] =
          step[k] - sections[k].f * step[k] - sections[k].e * y_before + sections[k].b * combined;
      output[k] = y_before + step[k];
      // a section's own step is the next one's difference of inputs, exactly
      return From<k + 1>(sections, output[k], y_before, step[k]);
    }
  }

  template <SectionKind kKind>
  [[gnu::always_inline]] static inline Value Combined(const Value& now, const Value& before) {
    if constexpr (kKind == SectionKind::kHighPass) {
      return now - before;
    } else {
      return now + before;
    }
  }
};

}  // namespace
}  // namespace haptometer::dsp
