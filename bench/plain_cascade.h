#pragma once

// The sections of a band-pass one sample after the other, in any type of number and in two forms:
// what dsp/filter does not offer, because the ladder of filter_cost.cc says what it would cost.

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "dsp/filter/cascade.h"
#include "dsp/filter/cascade_step.h"

namespace haptometer::dsp {

/// Our own recursion (dsp/filter/cascade_step.h) in `Number`, coefficients included.
template <typename Number, int kOrder>
class DeltaForm {
 public:
  /// As if the input had been `constant` for ever; it leaves the high-pass sections as 0.
  DeltaForm(const FilterDesign& design, Number constant) {
    for (std::size_t k = 0; k < kSections; ++k) {
      const DeltaSection& section = design.sections[k];
      sections_[k] = {static_cast<Number>(section.e), static_cast<Number>(section.f),
                      static_cast<Number>(section.b)};
    }
    step_.last_input = constant;
  }

  Number Advance(Number input) { return step_.Advance(sections_.data(), input); }

 private:
  static constexpr std::size_t kSections = kOrder;
  struct Section {
    Number e;
    Number f;
    Number b;
  };
  std::array<Section, kSections> sections_{};
  CascadeStep<kOrder, Number> step_{};
};

/// The transposed direct form II, which SciPy's sosfilt runs:
///   y = b0 x + s1,   s1 = b1 x - a1 y + s2,   s2 = b2 x - a2 y
template <typename Number, int kOrder>
class DirectForm {
 public:
  /// As if the input had been `constant` for ever.
  DirectForm(const FilterDesign& design, Number constant) {
    for (std::size_t k = 0; k < kSections; ++k) {
      const DeltaSection& section = design.sections[k];
      const auto [one, two] = kNumerators[static_cast<std::size_t>(section.kind)];
      sections_[k] = {static_cast<Number>(section.b), static_cast<Number>(one * section.b),
                      static_cast<Number>(two * section.b),
                      static_cast<Number>(section.e + section.f - 2),
                      static_cast<Number>(1 - section.f)};
    }
    // the first section gives 0 for a constant
    states_[0] = {-sections_[0].b0 * constant, sections_[0].b2 * constant};
  }

  Number Advance(Number x) {
    for (std::size_t k = 0; k < kSections; ++k) {
      const Section& section = sections_[k];
      State& state = states_[k];
      const Number y = section.b0 * x + state.first;
      state.first = section.b1 * x - section.a1 * y + state.second;
      state.second = section.b2 * x - section.a2 * y;
      x = y;
    }
    return x;
  }

 private:
  static constexpr std::size_t kSections = kOrder;
  // of 1/z and 1/z^2, by SectionKind
  static constexpr std::array<std::array<int, 2>, 3> kNumerators{{{-2, 1}, {0, -1}, {2, 1}}};
  struct Section {
    Number b0;
    Number b1;
    Number b2;
    Number a1;
    Number a2;
  };
  struct State {
    Number first;
    Number second;
  };
  std::array<Section, kSections> sections_{};
  std::array<State, kSections> states_{};
};

/// One pass over all of `in`.
template <typename Form, typename Number>
std::vector<Number> OnePass(const FilterDesign& design, std::span<const Number> in) {
  Form form(design, in.front());
  std::vector<Number> out(in.size());
  std::ranges::transform(in, out.begin(), [&](Number x) { return form.Advance(x); });
  return out;
}

/// Forward, then backward; the ends do not settle.
template <typename Form, typename Number>
std::vector<Number> TwoPasses(const FilterDesign& design, std::span<const Number> in) {
  std::vector<Number> turned = OnePass<Form>(design, in);
  std::ranges::reverse(turned);
  std::vector<Number> out = OnePass<Form>(design, std::span<const Number>(turned));
  std::ranges::reverse(out);
  return out;
}

}  // namespace haptometer::dsp
