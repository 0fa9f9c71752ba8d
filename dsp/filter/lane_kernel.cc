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
void RunLanes(const DeltaSection* given, Direction direction, const double* rows, double* out,
              LaneStates& states, std::size_t first_lane) {
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

  const bool forward = direction == Direction::kForward;
  const std::ptrdiff_t stride = forward ? kLanes : -static_cast<std::ptrdiff_t>(kLanes);
  std::ptrdiff_t at =
      static_cast<std::ptrdiff_t>(first_lane + (forward ? 0 : kTileSamples - kLanes));
  for (std::size_t n = 0; n < kLaneSamples; ++n) {
    const Lanes result = step.Advance(sections, Load(rows + at));
    if constexpr (kKeepsOutput) result.copy_to(out + at, vector_aligned);
    at += stride;
  }

  for (std::size_t k = 0; k < Step::kCount; ++k) {
    step.output[k].copy_to(&states.output[k][first_lane], vector_aligned);
    step.step[k].copy_to(&states.step[k][first_lane], vector_aligned);
  }
}

using RunFunction = void (*)(const DeltaSection*, Direction, const double*, double*, LaneStates&,
                             std::size_t);

template <FilterKind kKind, bool kKeepsOutput>
RunFunction RunOfOrder(int order) {
  return [&]<int... kIndex>(std::integer_sequence<int, kIndex...>) {
    constexpr RunFunction kByOrder[] = {RunLanes<kKind, kIndex + 1, kKeepsOutput>...};
    return kByOrder[order - 1];
  }(std::make_integer_sequence<int, kHighestOrder>());
}

template <bool kKeepsOutput>
void Run(const FilterDesign& design, Direction direction, const double* rows, double* out,
         LaneStates& states) {
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
  for (std::size_t lane = 0; lane < kLanes; lane += Lanes::size()) {
    run(&design.sections.front(), direction, rows, out, states, lane);
  }
}

void Filter(const FilterDesign& design, Direction direction, const double* rows, double* out,
            LaneStates& states) {
  Run<true>(design, direction, rows, out, states);
}

void Advance(const FilterDesign& design, Direction direction, const double* rows,
             LaneStates& states) {
  Run<false>(design, direction, rows, nullptr, states);
}

// Two samples of two lanes are turned at once: wider squares are slower (g++ 12).
using Two [[gnu::vector_size(2 * sizeof(double))]] = double;

Two LoadTwo(const double* from) {
  Two two;
  __builtin_memcpy(&two, from, sizeof(two));
  return two;
}

// the square of a, b at `from`, c, d `from_stride` further, becomes a, c at `to` and b, d
void TurnSquare(const double* from, std::size_t from_stride, double* to, std::size_t to_stride) {
  const Two upper = LoadTwo(from);
  const Two lower = LoadTwo(from + from_stride);
  const Two firsts = __builtin_shufflevector(upper, lower, 0, 2);
  const Two seconds = __builtin_shufflevector(upper, lower, 1, 3);
  __builtin_memcpy(to, &firsts, sizeof(Two));
  __builtin_memcpy(to + to_stride, &seconds, sizeof(Two));
}

void Gather(const double* tile, double* rows) {
  for (std::size_t n = 0; n < kLaneSamples; n += 2) {
    for (std::size_t lane = 0; lane < kLanes; lane += 2) {
      TurnSquare(tile + lane * kLaneSamples + n, kLaneSamples, rows + n * kLanes + lane, kLanes);
    }
  }
}

void Scatter(const double* rows, double* tile) {
  for (std::size_t n = 0; n < kLaneSamples; n += 2) {
    for (std::size_t lane = 0; lane < kLanes; lane += 2) {
      TurnSquare(rows + n * kLanes + lane, kLanes, tile + lane * kLaneSamples + n, kLaneSamples);
    }
  }
}

}  // namespace

const LaneKernel HAPTOMETER_LANE_KERNEL = {Gather, Scatter, Filter, Advance};

}  // namespace haptometer::dsp
