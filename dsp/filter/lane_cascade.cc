#include "dsp/filter/lane_cascade.h"

#include "base/check.h"
#include "dsp/filter/cascade.h"
#include "dsp/filter/cascade_step.h"
#include "dsp/filter/flush_subnormals.h"

namespace haptometer::dsp {
namespace {

const LaneKernel& KernelOf(InstructionSet set) {
  HAPTOMETER_CHECK(IsSupported(set), "this processor has no {}", Name(set));
  switch (set) {
    case InstructionSet::kBaseline:
      return kLaneKernelBaseline;
    case InstructionSet::kAvx2:
      return kLaneKernelAvx2;
    case InstructionSet::kAvx512:
      return kLaneKernelAvx512;
  }
  HAPTOMETER_CHECK(false, "instruction set {}", static_cast<int>(set));
}

}  // namespace

LanePlan::LanePlan(const FilterDesign& design, InstructionSet set)
    : design_(design), kernel_(&KernelOf(set)), sections_(design.sections.size()) {
  CheckSections(design);
  const FlushSubnormals flush;
  alignas(64) std::array<double, kTileSamples> silence{};
  for (std::size_t first = 0; first < 2 * sections_; first += kLanes) {
    // lane j begins from the unit state first + j
    LaneStates lanes{};
    for (std::size_t lane = 0; lane < kLanes && first + lane < 2 * sections_; ++lane) {
      const std::size_t state = first + lane;
      (state < sections_ ? lanes.output[state] : lanes.step[state - sections_])[lane] = 1;
    }
    kernel_->advance(design_, silence.data(), lanes);
    for (std::size_t lane = 0; lane < kLanes && first + lane < 2 * sections_; ++lane) {
      for (std::size_t k = 0; k < sections_; ++k) {
        handover_[first + lane][k] = lanes.output[k][lane];
        handover_[first + lane][sections_ + k] = lanes.step[k][lane];
      }
    }
  }
}

void LaneCascade::StartFrom(double input) {
  state_ = {};
  last_input_ = input;
  input_before_last_ = input;
  for (std::size_t k = 0; k < plan_->sections_; ++k) {
    input *= ConstantGain(plan_->design_.sections[k]);
    state_[k] = input;
  }
}

// lanes with the inputs that came before them, and at rest
void LaneCascade::TakeTile(const double* tile, Direction direction) {
  plan_->kernel_->gather(tile, direction, rows_.data());
  lanes_ = {};
  const double* last_row = &rows_[kTileSamples - kLanes];
  const double* row_before = last_row - kLanes;
  const bool sums = TakesSums(plan_->design_.sections.front().kind);
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const double last = lane == 0 ? last_input_ : last_row[lane - 1];
    const double before = lane == 0 ? input_before_last_ : row_before[lane - 1];
    lanes_.last_input[lane] = last;
    lanes_.input_before[lane] = sums ? last + before : last - before;
  }
  last_input_ = last_row[kLanes - 1];
  input_before_last_ = row_before[kLanes - 1];
}

// from lanes_, run from rest, the true state at each lane's begin (starts_) and at the tile's end
void LaneCascade::HandOver() {
  const std::size_t sections = plan_->sections_;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    starts_[lane] = state_;
    LanePlan::StateVector next{};
    for (std::size_t k = 0; k < sections; ++k) {
      next[k] = lanes_.output[k][lane];
      next[sections + k] = lanes_.step[k][lane];
    }
    for (std::size_t column = 0; column < 2 * sections; ++column) {
      for (std::size_t k = 0; k < LanePlan::kMostStates; ++k) {
        next[k] += plan_->handover_[column][k] * state_[column];
      }
    }
    state_ = next;
  }
}

void LaneCascade::Advance(std::span<const double> samples, Direction direction) {
  HAPTOMETER_CHECK(samples.size() % kTileSamples == 0, "{} samples", samples.size());
  const FlushSubnormals flush;
  for (std::size_t k = 0; k < samples.size(); k += kTileSamples) {
    const std::size_t tile =
        direction == Direction::kForward ? k : samples.size() - kTileSamples - k;
    TakeTile(&samples[tile], direction);
    plan_->kernel_->advance(plan_->design_, rows_.data(), lanes_);
    HandOver();
  }
}

void LaneCascade::Process(std::span<double> samples, Direction direction) {
  HAPTOMETER_CHECK(samples.size() % kTileSamples == 0, "{} samples", samples.size());
  const FlushSubnormals flush;
  const std::size_t sections = plan_->sections_;
  for (std::size_t k = 0; k < samples.size(); k += kTileSamples) {
    const std::size_t tile =
        direction == Direction::kForward ? k : samples.size() - kTileSamples - k;
    TakeTile(&samples[tile], direction);
    plan_->kernel_->advance(plan_->design_, rows_.data(), lanes_);
    HandOver();
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      for (std::size_t section = 0; section < sections; ++section) {
        lanes_.output[section][lane] = starts_[lane][section];
        lanes_.step[section][lane] = starts_[lane][sections + section];
      }
    }
    plan_->kernel_->filter(plan_->design_, rows_.data(), lanes_);
    plan_->kernel_->scatter(rows_.data(), direction, &samples[tile]);
  }
}

}  // namespace haptometer::dsp
