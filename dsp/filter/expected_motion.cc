#include "dsp/filter/expected_motion.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <limits>

#include "base/check.h"

namespace haptometer::dsp {
namespace {

constexpr std::size_t kPieces = 64;
static_assert(kLeastExpectedMotionSamples >= 2 * kPieces);
constexpr int kLeastRad = 2;
constexpr int kMostRad = 60;
constexpr int kNarrowings = 25;

// the means of a signal's last kPieces equal pieces, less `offset`
struct Means {
  std::size_t piece = 0;  // samples of each
  double half = 0;        // half the signal's length
  double offset = 0;
  std::array<double, kPieces> values{};
  std::array<double, kPieces> times{};  // from the signal's middle
};

Means MeansOf(std::span<const double> signal) {
  Means means;
  means.piece = signal.size() / kPieces;
  means.half = 0.5 * static_cast<double>(signal.size() - 1);
  means.offset = signal.back();
  const std::span<const double> used = signal.last(means.piece * kPieces);
  const auto skipped = static_cast<double>(signal.size() - used.size());
  for (std::size_t k = 0; k < kPieces; ++k) {
    double sum = 0;
    for (const double value : used.subspan(k * means.piece, means.piece)) {
      sum += value - means.offset;
    }
    const auto piece = static_cast<double>(means.piece);
    means.values[k] = sum / piece;
    means.times[k] = skipped + static_cast<double>(k) * piece + 0.5 * (piece - 1) - means.half;
  }
  return means;
}

struct Fit {
  ExpectedMotion motion;
  double residual = std::numeric_limits<double>::infinity();  // sum of squares
};

Fit FitAt(const Means& means, double rad_per_sample) {
  // a mean over a piece takes this much of a sine
  const auto piece = static_cast<double>(means.piece);
  const double gain =
      std::sin(0.5 * rad_per_sample * piece) / (piece * std::sin(0.5 * rad_per_sample));
  Eigen::Matrix<double, kPieces, 4> columns;
  Eigen::Vector<double, kPieces> values;
  for (std::size_t k = 0; k < kPieces; ++k) {
    const double t = means.times[k];
    const auto row = static_cast<Eigen::Index>(k);
    columns.row(row) << 1, t / means.half, gain * std::cos(rad_per_sample * t),
        gain * std::sin(rad_per_sample * t);
    values[row] = means.values[k];
  }
  const Eigen::Matrix4d normal = columns.transpose() * columns;
  const Eigen::Vector4d right = columns.transpose() * values;
  const Eigen::Vector4d found = normal.ldlt().solve(right);
  return {{rad_per_sample, found[0] + means.offset, found[1] / means.half, found[2], found[3],
           means.half},
          (columns * found - values).squaredNorm()};
}

}  // namespace

double ExpectedMotion::At(double k) const {
  const double t = k - middle;
  return offset + slope * t + cosine * std::cos(rad_per_sample * t) +
         sine * std::sin(rad_per_sample * t);
}

ExpectedMotion FitExpectedMotion(std::span<const double> signal) {
  HAPTOMETER_CHECK(signal.size() >= kLeastExpectedMotionSamples, "{} samples", signal.size());
  const Means means = MeansOf(signal);
  const auto size = static_cast<double>(signal.size());
  // a grid finds the valley, bisection into golden parts its floor
  Fit best;
  for (int rad = kLeastRad; rad < kMostRad; ++rad) {
    const Fit fit = FitAt(means, rad / size);
    if (fit.residual < best.residual) best = fit;
  }
  constexpr double kGolden = 0.381966011250105;
  double lower = best.motion.rad_per_sample - 1 / size;
  double upper = best.motion.rad_per_sample + 1 / size;
  for (int k = 0; k < kNarrowings; ++k) {
    const double left = lower + kGolden * (upper - lower);
    const double right = upper - kGolden * (upper - lower);
    if (FitAt(means, left).residual < FitAt(means, right).residual) {
      upper = right;
    } else {
      lower = left;
    }
  }
  return FitAt(means, 0.5 * (lower + upper)).motion;
}

}  // namespace haptometer::dsp
