#include "dsp/filter/cascade.h"

#include <algorithm>

#include "base/check.h"

namespace haptometer::dsp {

Cascade::Cascade(const FilterDesign& design) : count_(design.sections.size()) {
  HAPTOMETER_CHECK(count_ >= 1 && count_ <= sections_.size(), "{} sections", count_);
  std::ranges::copy(design.sections, sections_.begin());
  // Run() relies on the order that every design has: pairs outside, the odd one in the middle
  for (std::size_t k = 0; k < count_; ++k) {
    const SectionKind expected = k < count_ / 2            ? SectionKind::kHighPass
                                 : k < count_ - count_ / 2 ? SectionKind::kBandPass
                                                           : SectionKind::kLowPass;
    HAPTOMETER_CHECK(sections_[k].kind == expected, "section {} of {}", k, count_);
  }
}

void Cascade::StartFrom(double input) {
  states_ = {};
  last_input_ = input;
}

// One sample runs through all sections before the next: the processor overlaps the sections of
// neighbouring samples. A section's own step is the next section's difference of inputs, exactly.
template <std::size_t kPairs, std::size_t kMiddle>
void Cascade::Run(std::span<const double> in, std::span<double> out) {
  constexpr std::size_t kCount = 2 * kPairs + kMiddle;
  std::array<DeltaSection, kCount> sections;
  std::array<State, kCount> states;
  std::copy_n(sections_.begin(), kCount, sections.begin());
  std::copy_n(states_.begin(), kCount, states.begin());
  double last_input = last_input_;

  for (std::size_t n = 0; n < in.size(); ++n) {
    double x_before = last_input;  // x[n-1] of the section at hand
    double x = in[n];              // x[n]
    double x_step = x - x_before;  // exact for values within a factor of two (Sterbenz)
    last_input = x;
// unrolled, the sections stay in registers: 1.4 to 3 times the speed at -O2
#pragma GCC unroll 8
    for (std::size_t k = 0; k < kCount; ++k) {
      const DeltaSection& section = sections[k];
      State& state = states[k];
      // the numerator's combination of inputs, and what it needs next time
      const double now = k < kPairs + kMiddle ? x_step : x + x_before;
      const double combined = k < kPairs ? now - state.input_before : now + state.input_before;
      state.input_before = now;
      const double y_before = state.output;
      state.step =
          state.step - section.f * state.step - section.e * y_before + section.b * combined;
      state.output = y_before + state.step;
      x = state.output;
      x_before = y_before;
      x_step = state.step;
    }
    out[n] = x;
  }

  std::copy_n(states.begin(), kCount, states_.begin());
  last_input_ = last_input;
}

void Cascade::Process(std::span<const double> in, std::span<double> out) {
  HAPTOMETER_CHECK(in.size() == out.size(), "{} in, {} out", in.size(), out.size());
  switch (count_) {
    case 1:
      return Run<0, 1>(in, out);
    case 2:
      return Run<1, 0>(in, out);
    case 3:
      return Run<1, 1>(in, out);
    case 4:
      return Run<2, 0>(in, out);
    case 5:
      return Run<2, 1>(in, out);
    case 6:
      return Run<3, 0>(in, out);
    case 7:
      return Run<3, 1>(in, out);
    default:
      return Run<4, 0>(in, out);
  }
}

}  // namespace haptometer::dsp
