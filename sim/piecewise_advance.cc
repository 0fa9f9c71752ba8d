// Many outputs of a piecewise motion at once.
#include <algorithm>

#include "sim/linear_model.h"
#include "sim/piecewise_motion.h"
#include "sim/uniform_motion.h"

namespace haptometer::sim {

Eigen::MatrixXd PiecewiseMotion::Advance(std::size_t count) {
  Eigen::MatrixXd samples(Positions().size(), static_cast<Eigen::Index>(count));
  Eigen::Index done = 0;
  while (done < samples.cols() && !stalled_at_s_) {
    const Eigen::Index unwatched = std::min(OutputsUnwatched(), samples.cols() - done);
    if (unwatched > 0) {
      StepUnwatched(samples.middleCols(done, unwatched));
      done += unwatched;
      continue;
    }
    Next();
    if (!stalled_at_s_) samples.col(done++) = Positions();
  }
  samples.conservativeResize(Eigen::NoChange, done);
  return samples;
}

// how many outputs come in which nothing can happen, up to the next anchor
Eigen::Index PiecewiseMotion::OutputsUnwatched() {
  const Mode& mode = Stepper().mode();
  const Eigen::Index n = now_.x.size();
  const bool watched =
      !mode.guards.empty() || with_energy_ || departure_ || now_.tick > 0 || PieceEndsWithin();
  if (watched || mode.positions.size() > 0 || n < 4 || n > LinearModel::kMostStates) return 0;
  if (!PlainSine()) return 0;
  const std::uint64_t since = (index_ - anchor_index_) % kOutputsBetweenAnchors;
  return static_cast<Eigen::Index>(
      std::min(kOutputsBetweenAnchors - since, piece_end_index_ - index_));
}

void PiecewiseMotion::StepUnwatched(Eigen::Ref<Eigen::MatrixXd> samples) {
  StepUniformly(Stepper().Step(0), sequences_[0], index_, now_.x, samples);
  index_ += static_cast<std::uint64_t>(samples.cols());
  now_.x = samples.rightCols(1);
  SignalsAtOutput(index_, now_.drive);
  Reanchor();
  samples.rightCols(1) = now_.x;
}

}  // namespace haptometer::sim
