#include "dsp/filter/lane_cascade.h"

#include <algorithm>
#include <array>
#include <utility>

#include "base/error.h"
#include "dsp/filter/cascade.h"
#include "dsp/filter/cascade_step.h"

namespace haptometer::dsp {

namespace {

const LaneKernel& KernelOf(InstructionSet set) {
  HAPTOMETER_CHECK(IsSupported(set), "this processor has no {}", Name(set));
  constexpr std::array kKernels{&kLaneKernelBaseline, &kLaneKernelAvx2, &kLaneKernelAvx512};
  return *kKernels.at(static_cast<std::size_t>(set));
}

// for each sample of a lane the states at its end if the first section's combination of
// inputs is 1 at that sample, 0 at all others
std::vector<double> WeightsOf(const FilterDesign& design) {
  const std::size_t states = 2 * design.sections.size();
  std::vector<double> weights(kLaneSamples * states);
  // the inputs that combine to 1, 0, 0, ... by a numerator 1 - one/z - two/z^2: small whole
  // numbers, so exact
  const bool is_high_pass = design.sections.front().kind == SectionKind::kHighPass;
  const double one = is_high_pass ? 2 : 0;
  const double two = is_high_pass ? -1 : 1;
  double last = 0;
  double before_last = 0;
  // states after m = 1, 0, 0, ...: after n further samples they are the weights of sample last - n
  Cascade cascade(design);
  for (std::size_t n = 0; n < kLaneSamples; ++n) {
    const double input = (n == 0 ? 1 : 0) + one * last + two * before_last;
    before_last = std::exchange(last, input);
    double output = 0;
    cascade.Process({&input, 1}, {&output, 1});
    cascade.CopyState(std::span(weights).subspan((kLaneSamples - 1 - n) * states, states));
  }
  return weights;
}

}  // namespace

LanePlan::LanePlan(const FilterDesign& design, InstructionSet set)
    : design_(design), kernel_(&KernelOf(set)), sections_(design.sections.size()) {
  CheckSections(design);
  weights_ = WeightsOf(design);
  const FlushSubnormals flush;
  // A^M: column j is the state that a lane reaches from unit state j with zero input
  alignas(64) const std::array<double, kTileSamples> silence{};
  alignas(64) std::array<double, kTileSamples> ringing;
  for (std::size_t first = 0; first < 2 * sections_; first += kLanes) {
    // lane j begins from the unit state first + j
    LaneStates lanes{};
    for (std::size_t lane = 0; lane < kLanes && first + lane < 2 * sections_; ++lane) {
      const std::size_t state = first + lane;
      (state < sections_ ? lanes.output[state] : lanes.step[state - sections_])[lane] = 1;
    }
    kernel_->filter(design_, Direction::kForward, silence.data(), ringing.data(),
                    {silence.data(), ringing.data()}, lanes);
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
  state_.last_input_ = input;
  state_.input_before_last_ = input;
}

// the inputs before each lane, and each lane's state at its end if it started from rest
void LaneCascade::TakeRows(const double* rows, Direction direction) {
  const bool forward = direction == Direction::kForward;
  const double* last_row = rows + (forward ? kTileSamples - kLanes : 0);
  const double* row_before = forward ? last_row - kLanes : last_row + kLanes;
  // a lane's inputs before are the last two of the lane ahead of it in the direction of the run
  lanes_ = {};
  double last = state_.last_input_;
  double before = state_.input_before_last_;
  for (std::size_t k = 0; k < kLanes; ++k) {
    const std::size_t lane = forward ? k : kLanes - 1 - k;
    lanes_.last_input[lane] = last;
    lanes_.input_before[lane] = last - before;
    last = last_row[lane];
    before = row_before[lane];
  }
  state_.last_input_ = last;
  state_.input_before_last_ = before;
  plan_->kernel_->weigh(plan_->design_, direction, rows, plan_->weights_.data(), lanes_);
}

// from lanes_ of runs from rest: the state at each lane's begin, and at the tile's end
void LaneCascade::HandOver(Direction direction) {
  plan_->kernel_->hand_over(plan_->design_, direction, plan_->handover_.front().data(),
                            state_.sections_.data(), lanes_);
}

void LaneCascade::AdvanceForward(std::span<const double> tiles) {
  HAPTOMETER_CHECK(tiles.size() % kTileSamples == 0, "{} samples", tiles.size());
  const FlushSubnormals flush;
  for (std::size_t tile = 0; tile < tiles.size(); tile += kTileSamples) {
    // inputs only: the outputs of this tile are not required
    plan_->kernel_->gather(&tiles[tile], rows_.data());
    TakeRows(rows_.data(), Direction::kForward);
    HandOver(Direction::kForward);
  }
}

void LaneCascade::ProcessForward(std::span<const double> tiles, std::span<double> rows) {
  HAPTOMETER_CHECK(tiles.size() % kTileSamples == 0 && rows.size() == tiles.size(),
                   "{} samples to {}", tiles.size(), rows.size());
  const FlushSubnormals flush;
  for (std::size_t tile = 0; tile < tiles.size(); tile += kTileSamples) {
    plan_->kernel_->gather(&tiles[tile], rows_.data());
    TakeRows(rows_.data(), Direction::kForward);
    HandOver(Direction::kForward);
    // the next tile is fetched meanwhile; behind the last one, the last one again
    const std::size_t next = std::min(tile + kTileSamples, rows.size() - kTileSamples);
    plan_->kernel_->filter(plan_->design_, Direction::kForward, rows_.data(), &rows[tile],
                           {&tiles[next], &rows[next]}, lanes_);
  }
}

void LaneCascade::AdvanceBackward(std::span<const double> rows) {
  HAPTOMETER_CHECK(rows.size() % kTileSamples == 0, "{} samples", rows.size());
  const FlushSubnormals flush;
  for (std::size_t end = rows.size(); end > 0; end -= kTileSamples) {
    TakeRows(&rows[end - kTileSamples], Direction::kBackward);
    HandOver(Direction::kBackward);
  }
}

void LaneCascade::ProcessBackward(std::span<const double> rows, std::span<double> out) {
  HAPTOMETER_CHECK(rows.size() % kTileSamples == 0 && out.size() <= rows.size() &&
                       rows.size() < out.size() + kTileSamples,
                   "{} samples to {}", rows.size(), out.size());
  const FlushSubnormals flush;
  for (std::size_t end = rows.size(); end > 0; end -= kTileSamples) {
    const std::size_t begin = end - kTileSamples;
    TakeRows(&rows[begin], Direction::kBackward);
    HandOver(Direction::kBackward);
    const std::size_t next = begin - std::min(begin, kTileSamples);
    plan_->kernel_->filter(plan_->design_, Direction::kBackward, &rows[begin], rows_.data(),
                           {&rows[next], &out[next]}, lanes_);
    // by way of the cache: a stream for each lane into memory would cost twice as much as one
    plan_->kernel_->scatter(rows_.data(), tile_.data());
    std::copy_n(tile_.begin(), std::min(kTileSamples, out.size() - begin), &out[begin]);
  }
}

}  // namespace haptometer::dsp
