// Compiled once for each instruction set (dsp/CMakeLists.txt), which names the kernel it makes.
// Here nothing may be shared with other files: everything is in unnamed namespaces or inlined
// always.
#include "dsp/filter/lane_kernel.h"

#include <algorithm>
#include <experimental/simd>
#include <utility>

#include "dsp/filter/cascade_step.h"

namespace haptometer::dsp {
namespace {

// as many lanes as one register holds: a row of several registers is copied through memory, which
// costs up to ten times as much (g++ 12)
using Lanes = std::experimental::native_simd<double>;
static_assert(kLanes % (2 * Lanes::size()) == 0);
using std::experimental::vector_aligned;
constexpr std::size_t kCacheLine = 64;

// values at a multiple of 64 bytes
Lanes Load(const double* values) {
  Lanes lanes;
  lanes.copy_from(values, vector_aligned);
  return lanes;
}

// offset of the first row in the direction of the run, and from each row to the next, in values
struct Way {
  std::ptrdiff_t first = 0;
  std::ptrdiff_t stride = kLanes;
};

Way WayOf(Direction direction) {
  constexpr auto kStride = static_cast<std::ptrdiff_t>(kLanes);
  if (direction == Direction::kForward) return {0, kStride};
  return {static_cast<std::ptrdiff_t>(kTileSamples) - kStride, -kStride};
}

// the cascade in Lanes::size() lanes from `first_lane` on
template <int kOrder>
CascadeStep<kOrder, Lanes> LoadStep(const LaneStates& states, std::size_t first_lane) {
  CascadeStep<kOrder, Lanes> step;
  for (std::size_t k = 0; k < kOrder; ++k) {
    step.output[k] = Load(&states.output[k][first_lane]);
    step.step[k] = Load(&states.step[k][first_lane]);
    // differences of inputs are those of the outputs of the section before; the first is stored
    if (k == 0) {
      step.input_before[k] = Load(&states.input_before[first_lane]);
    } else if (KindAt(kOrder, k) == SectionKind::kLowPass) {
      // y[n-1] + y[n-2] of the section before
      step.input_before[k] = step.output[k - 1] + (step.output[k - 1] - step.step[k - 1]);
    } else {
      step.input_before[k] = step.step[k - 1];
    }
  }
  step.last_input = Load(&states.last_input[first_lane]);
  return step;
}

template <int kOrder>
void StoreStep(const CascadeStep<kOrder, Lanes>& step, LaneStates& states, std::size_t first_lane) {
  for (std::size_t k = 0; k < kOrder; ++k) {
    step.output[k].copy_to(&states.output[k][first_lane], vector_aligned);
    step.step[k].copy_to(&states.step[k][first_lane], vector_aligned);
  }
}

void FetchTwoRegisters(const double* samples) {
  __builtin_prefetch(samples);
  if constexpr (2 * Lanes::size() * sizeof(double) > kCacheLine) {
    __builtin_prefetch(samples + kCacheLine / sizeof(double));
  }
}

// Runs 2 Lanes::size() lanes from `first_lane` on: in two registers, because each alone would wait
// for its own last sample.
template <int kOrder>
void RunLanes(const DeltaSection* given, Direction direction, const double* rows, double* out,
              const TilesAhead& ahead, LaneStates& states, std::size_t first_lane) {
  DeltaSection sections[kOrder];
  for (std::size_t k = 0; k < kOrder; ++k) sections[k] = given[k];
  const std::size_t second_lane = first_lane + Lanes::size();
  auto first = LoadStep<kOrder>(states, first_lane);
  auto second = LoadStep<kOrder>(states, second_lane);
  const Way way = WayOf(direction);
  std::ptrdiff_t at = way.first + static_cast<std::ptrdiff_t>(first_lane);
  for (std::size_t n = 0; n < kLaneSamples; ++n) {
    const double* row = rows + at;
    FetchTwoRegisters(ahead.read + at);
    FetchTwoRegisters(ahead.written + at);
    first.Advance(sections, Load(row)).copy_to(out + at, vector_aligned);
    second.Advance(sections, Load(row + Lanes::size()))
        .copy_to(out + at + Lanes::size(), vector_aligned);
    at += way.stride;
  }
  StoreStep<kOrder>(first, states, first_lane);
  StoreStep<kOrder>(second, states, second_lane);
}

// the weighted sums of Lanes::size() lanes from `first_lane` on
template <int kOrder>
void WeighLanes(Direction direction, const double* rows, const double* weights, LaneStates& states,
                std::size_t first_lane) {
  constexpr std::size_t kCount = kOrder;
  using Step = CascadeStep<kOrder, Lanes>;
  // a state from rest is the sum over n of weights[n] m[n]: y of each section, then d of each
  Lanes sums[2 * kCount] = {};
  Lanes last_input = Load(&states.last_input[first_lane]);
  Lanes input_before = Load(&states.input_before[first_lane]);
  const Way way = WayOf(direction);
  const double* row = rows + way.first + first_lane;
  for (std::size_t n = 0; n < kLaneSamples; ++n) {
    // m[n] of the first section, its numerator applied to the input
    const Lanes combined = Step::FirstCombined(Load(row), last_input, input_before);
#pragma GCC unroll 16  // all of them: so that the sums stay in registers
    for (std::size_t k = 0; k < 2 * kCount; ++k) sums[k] += weights[k] * combined;
    weights += 2 * kCount;
    row += way.stride;
  }
  for (std::size_t k = 0; k < kCount; ++k) {
    sums[k].copy_to(&states.output[k][first_lane], vector_aligned);
    sums[kCount + k].copy_to(&states.step[k][first_lane], vector_aligned);
  }
}

// A section's two states, of one lane, in `state` as LaneKernel::hand_over has them, exchanged.
template <std::size_t kCount>
void ExchangeStates(LaneStates& states, std::size_t lane, double* state) {
  for (std::size_t k = 0; k < kCount; ++k) {
    std::swap(states.output[k][lane], state[k]);
    std::swap(states.step[k][lane], state[kCount + k]);
  }
}

// s -> A^M s + z from lane to lane, in the order of time of the run
template <std::size_t kCount>
void HandOverLanes(Direction direction, const double* handover, double* state, LaneStates& states) {
  constexpr std::size_t kRegisters = (2 * kCount + Lanes::size() - 1) / Lanes::size();
  for (std::size_t n = 0; n < kLanes; ++n) {
    const std::size_t lane = direction == Direction::kForward ? n : kLanes - 1 - n;
    alignas(64) double before[kMostStates];
    std::copy_n(state, kMostStates, before);
    // the lane receives its begin state s; `state` becomes the lane's z, states from rest
    ExchangeStates<kCount>(states, lane, state);
    Lanes sums[kRegisters];
    for (std::size_t k = 0; k < kRegisters; ++k) sums[k] = Load(state + k * Lanes::size());
    // z + A^M s, column by column
    for (std::size_t column = 0; column < 2 * kCount; ++column) {
      for (std::size_t k = 0; k < kRegisters; ++k) {
        sums[k] += Load(handover + column * kMostStates + k * Lanes::size()) * before[column];
      }
    }
    for (std::size_t k = 0; k < kRegisters; ++k) {
      sums[k].copy_to(state + k * Lanes::size(), vector_aligned);
    }
  }
}

// calls `run` with the order of `design` as a constant
template <typename Run>
void WithOrder(const FilterDesign& design, const Run& run) {
  [&]<int... kIndex>(std::integer_sequence<int, kIndex...>) {
    (void)((design.order == kIndex + 1 && (run.template operator()<kIndex + 1>(), true)) || ...);
  }(std::make_integer_sequence<int, kHighestOrder>());
}

void Filter(const FilterDesign& design, Direction direction, const double* rows, double* out,
            const TilesAhead& ahead, LaneStates& states) {
  WithOrder(design, [&]<int kOrder>() {
    for (std::size_t lane = 0; lane < kLanes; lane += 2 * Lanes::size()) {
      RunLanes<kOrder>(&design.sections.front(), direction, rows, out, ahead, states, lane);
    }
  });
}

void Weigh(const FilterDesign& design, Direction direction, const double* rows,
           const double* weights, LaneStates& states) {
  WithOrder(design, [&]<int kOrder>() {
    for (std::size_t lane = 0; lane < kLanes; lane += Lanes::size()) {
      WeighLanes<kOrder>(direction, rows, weights, states, lane);
    }
  });
}

void HandOver(const FilterDesign& design, Direction direction, const double* handover,
              double* state, LaneStates& states) {
  WithOrder(design,
            [&]<int kOrder>() { HandOverLanes<kOrder>(direction, handover, state, states); });
}

// Two samples of two lanes are transposed at once: wider squares are slower (g++ 12).
using Two [[gnu::vector_size(2 * sizeof(double))]] = double;

Two LoadTwo(const double* from) {
  Two two;
  __builtin_memcpy(&two, from, sizeof(two));
  return two;
}

// transposes a square: a, b at `from` and c, d `from_stride` further become a, c and b, d at `to`
void TurnSquare(const double* from, std::size_t from_stride, double* to, std::size_t to_stride) {
  const Two upper = LoadTwo(from);
  const Two lower = LoadTwo(from + from_stride);
  const Two firsts = __builtin_shufflevector(upper, lower, 0, 2);
  const Two seconds = __builtin_shufflevector(upper, lower, 1, 3);
  __builtin_memcpy(to, &firsts, sizeof(Two));
  __builtin_memcpy(to + to_stride, &seconds, sizeof(Two));
}

// a tile of kLanes successive segments becomes rows with one sample of each lane
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

const LaneKernel HAPTOMETER_KERNEL = {Gather, Scatter, Filter, Weigh, HandOver};

}  // namespace haptometer::dsp
