// Compiled once for each instruction set (dsp/CMakeLists.txt), which names the kernel it makes.
// Here nothing may be shared with other files: everything is in unnamed namespaces or inlined
// always.
#include "dsp/filter/lane_kernel.h"

#include <experimental/simd>
#include <utility>

#include "dsp/filter/cascade_step.h"

namespace haptometer::dsp {
namespace {

// as many lanes as one register holds: a row of several registers is copied through memory, which
// costs up to ten times as much (g++ 12)
using Lanes = std::experimental::native_simd<double>;
static_assert(kLanes % Lanes::size() == 0);
using std::experimental::vector_aligned;

Lanes Load(const double* values) {
  Lanes lanes;
  lanes.copy_from(values, vector_aligned);
  return lanes;
}

// runs Lanes::size() lanes from `first_lane` on
template <FilterKind kKind, int kOrder, bool kKeepsOutput>
void RunLanes(const DeltaSection* given, double* rows, LaneStates& states, std::size_t first_lane) {
  constexpr CascadeShape kShape = ShapeOf(kKind, kOrder);
  using Step = CascadeStep<kShape, Lanes>;
  Step step;
  DeltaSection sections[Step::kCount];
  for (std::size_t k = 0; k < Step::kCount; ++k) {
    sections[k] = given[k];
    step.output[k] = Load(&states.output[k][first_lane]);
    step.step[k] = Load(&states.step[k][first_lane]);
    if (k == 0) {
      step.input_before[k] = Load(&states.input_before[first_lane]);
    } else if (TakesSums(KindAt(kShape, k))) {
      // y[n-1] + y[n-2] of the section before
      step.input_before[k] = step.output[k - 1] + (step.output[k - 1] - step.step[k - 1]);
    } else {
      step.input_before[k] = step.step[k - 1];
    }
  }
  step.last_input = Load(&states.last_input[first_lane]);

  for (std::size_t n = 0; n < kLaneSamples; ++n) {
    double* row = rows + kLanes * n + first_lane;
    const Lanes out = step.Advance(sections, Load(row));
    if constexpr (kKeepsOutput) out.copy_to(row, vector_aligned);
  }

  for (std::size_t k = 0; k < Step::kCount; ++k) {
    step.output[k].copy_to(&states.output[k][first_lane], vector_aligned);
    step.step[k].copy_to(&states.step[k][first_lane], vector_aligned);
  }
}

template <FilterKind kKind, int kOrder, bool kKeepsOutput>
void Run(const DeltaSection* sections, double* rows, LaneStates& states) {
  for (std::size_t lane = 0; lane < kLanes; lane += Lanes::size()) {
    RunLanes<kKind, kOrder, kKeepsOutput>(sections, rows, states, lane);
  }
}

using RunFunction = void (*)(const DeltaSection*, double*, LaneStates&);

template <FilterKind kKind, bool kKeepsOutput>
RunFunction RunOfOrder(int order) {
  return [&]<int... kIndex>(std::integer_sequence<int, kIndex...>) {
    constexpr RunFunction kByOrder[] = {Run<kKind, kIndex + 1, kKeepsOutput>...};
    return kByOrder[order - 1];
  }(std::make_integer_sequence<int, kHighestOrder>());
}

template <bool kKeepsOutput>
void RunDesign(const FilterDesign& design, double* rows, LaneStates& states) {
  RunFunction run = nullptr;
  switch (design.kind) {
    case FilterKind::kBandPass:
      run = RunOfOrder<FilterKind::kBandPass, kKeepsOutput>(design.order);
      break;
    case FilterKind::kHighPass:
      run = RunOfOrder<FilterKind::kHighPass, kKeepsOutput>(design.order);
      break;
    case FilterKind::kLowPass:
      run = RunOfOrder<FilterKind::kLowPass, kKeepsOutput>(design.order);
      break;
  }
  run(&design.sections.front(), rows, states);
}

void Gather(const double* tile, Direction direction, double* rows) {
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    for (std::size_t n = 0; n < kLaneSamples; ++n) {
      const std::size_t k = lane * kLaneSamples + n;
      rows[kLanes * n + lane] = tile[direction == Direction::kForward ? k : kTileSamples - 1 - k];
    }
  }
}

void Scatter(const double* rows, Direction direction, double* tile) {
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    for (std::size_t n = 0; n < kLaneSamples; ++n) {
      const std::size_t k = lane * kLaneSamples + n;
      tile[direction == Direction::kForward ? k : kTileSamples - 1 - k] = rows[kLanes * n + lane];
    }
  }
}

}  // namespace

const LaneKernel HAPTOMETER_LANE_KERNEL = {Gather, Scatter, RunDesign<true>, RunDesign<false>};

}  // namespace haptometer::dsp
