#include "dsp/filter/cascade.h"

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "dsp/filter/cascade_step.h"

namespace haptometer::dsp {

void CheckSections(const FilterDesign& design) {
  HAPTOMETER_CHECK(design.order >= 1 && design.order <= kHighestOrder, "order {}", design.order);
  const auto count = static_cast<std::size_t>(design.order);
  HAPTOMETER_CHECK(design.sections.size() == count, "{} sections", design.sections.size());
  for (std::size_t k = 0; k < count; ++k) {
    HAPTOMETER_CHECK(design.sections[k].kind == KindAt(design.order, k), "section {} of {}", k,
                     count);
  }
}

Cascade::Cascade(const FilterDesign& design) : count_(design.sections.size()) {
  CheckSections(design);
  run_ = RunOf(design.order);
  std::ranges::copy(design.sections, sections_.begin());
}

// all sections have output 0 for a constant input: the first one takes differences of it
void Cascade::StartFrom(double input) {
  states_ = {};
  last_input_ = input;
}

template <int kOrder>
[[gnu::noinline]] void Cascade::Run(std::span<const double> in, std::span<double> out) {
  using Step = CascadeStep<kOrder, double>;
  Step step;
  std::array<DeltaSection, Step::kCount> sections;
  for (std::size_t k = 0; k < Step::kCount; ++k) {
    sections[k] = sections_[k];
    step.output[k] = states_[k].output;
    step.step[k] = states_[k].step;
    step.input_before[k] = states_[k].input_before;
  }
  step.last_input = last_input_;

  for (std::size_t n = 0; n < in.size(); ++n) out[n] = step.Advance(sections.data(), in[n]);

  for (std::size_t k = 0; k < Step::kCount; ++k) {
    states_[k] = {step.output[k], step.step[k], step.input_before[k]};
  }
  last_input_ = step.last_input;
}

// the run whose loops over sections are unrolled for this order
Cascade::RunFunction Cascade::RunOf(int order) {
  return [&]<int... kIndex>(std::integer_sequence<int, kIndex...>) {
    constexpr std::array<RunFunction, kHighestOrder> kByOrder{&Cascade::Run<kIndex + 1>...};
    return kByOrder.at(static_cast<std::size_t>(order - 1));
  }(std::make_integer_sequence<int, kHighestOrder>());
}

void Cascade::Process(std::span<const double> in, std::span<double> out) {
  HAPTOMETER_CHECK(in.size() == out.size(), "{} in, {} out", in.size(), out.size());
  const FlushSubnormals flush;
  (this->*run_)(in, out);
}

void Cascade::CopyState(std::span<double> state) const {
  HAPTOMETER_CHECK(state.size() == 2 * count_, "{} for {} sections", state.size(), count_);
  for (std::size_t k = 0; k < count_; ++k) {
    state[k] = states_[k].output;
    state[count_ + k] = states_[k].step;
  }
}

}  // namespace haptometer::dsp
