#include "dsp/filter/expected_motion.h"

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "base/error.h"
#include "dsp/spectrum/phasor_blocks.h"

namespace haptometer::dsp {
namespace {

constexpr std::size_t kPieces = 64;
static_assert(kLeastExpectedMotionSamples >= 2 * kPieces);
constexpr int kLeastRad = 2;
constexpr int kMostSines = 2;
constexpr int kColumns = 2 + 2 * kMostSines;
constexpr double kLeastApartRad = 0.5;
constexpr int kNarrowings = 25;
constexpr int kRounds = 4;  // two sines push each other

// the means of a signal's last kPieces equal pieces, less `offset`
struct Means {
  double piece = 0;  // samples of each
  double half = 0;   // half the signal's length
  double offset = 0;
  std::array<double, kPieces> values{};
  std::array<double, kPieces> times{};  // from the signal's middle
};

Means MeansOf(std::span<const double> signal) {
  const std::size_t size = signal.size() / kPieces;
  Means means;
  means.piece = static_cast<double>(size);
  means.half = 0.5 * static_cast<double>(signal.size() - 1);
  means.offset = signal.back();
  const std::span<const double> used = signal.last(size * kPieces);
  const auto skipped = static_cast<double>(signal.size() - used.size());
  for (std::size_t k = 0; k < kPieces; ++k) {
    double sum = 0;
    for (const double value : used.subspan(k * size, size)) sum += value - means.offset;
    means.values[k] = sum / means.piece;
    means.times[k] =
        skipped + static_cast<double>(k) * means.piece + 0.5 * (means.piece - 1) - means.half;
  }
  return means;
}

struct Fit {
  ExpectedMotion motion;
  double residual = std::numeric_limits<double>::infinity();  // sum of squares
};

Fit FitAt(const Means& means, std::span<const double> rad_per_sample) {
  const auto columns = static_cast<Eigen::Index>(2 + 2 * rad_per_sample.size());
  Eigen::Matrix<double, kPieces, Eigen::Dynamic, 0, kPieces, kColumns> matrix(kPieces, columns);
  Eigen::Vector<double, kPieces> values;
  for (std::size_t k = 0; k < kPieces; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    matrix(row, 0) = 1;
    matrix(row, 1) = means.times[k] / means.half;
    values[row] = means.values[k];
  }
  Eigen::Index column = 2;
  for (const double w : rad_per_sample) {
    // a mean over a piece takes this much of a sine
    const double gain = std::sin(0.5 * w * means.piece) / (means.piece * std::sin(0.5 * w));
    for (std::size_t k = 0; k < kPieces; ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      matrix(row, column) = gain * std::cos(w * means.times[k]);
      matrix(row, column + 1) = gain * std::sin(w * means.times[k]);
    }
    column += 2;
  }
  // two sines may come close to one: a decomposition that bears it
  const Eigen::Vector<double, Eigen::Dynamic> found = matrix.colPivHouseholderQr().solve(values);
  Fit fit;
  fit.residual = (matrix * found - values).squaredNorm();
  fit.motion = {found[0] + means.offset, found[1] / means.half, {}, means.half};
  fit.motion.sines.reserve(rad_per_sample.size());
  column = 2;
  for (const double w : rad_per_sample) {
    fit.motion.sines.push_back({w, found[column], found[column + 1]});
    column += 2;
  }
  return fit;
}

bool LiesApart(double rad, std::span<const double> others, double size) {
  for (const double other : others) {
    if (std::abs(rad - other * size) < kLeastApartRad) return false;
  }
  return true;
}

// a grid finds the valley of one more sine
double CoarseRad(const Means& means, std::vector<double> rad_per_sample, double size) {
  double best = kLeastRad / size;
  double least = std::numeric_limits<double>::infinity();
  rad_per_sample.push_back(0);
  for (int rad = kLeastRad; rad < kFastestExpectedRad; ++rad) {
    if (!LiesApart(rad, std::span(rad_per_sample).first(rad_per_sample.size() - 1), size)) continue;
    rad_per_sample.back() = rad / size;
    const double residual = FitAt(means, rad_per_sample).residual;
    if (residual >= least) continue;
    least = residual;
    best = rad_per_sample.back();
  }
  return best;
}

// golden sections find the valley's floor along sine `k`
void Narrow(const Means& means, std::vector<double>& rad_per_sample, std::size_t k, double size) {
  constexpr double kGolden = 0.381966011250105;
  const auto residual_at = [&](double w) {
    rad_per_sample[k] = w;
    return FitAt(means, rad_per_sample).residual;
  };
  double lower = rad_per_sample[k] - 1 / size;
  double upper = rad_per_sample[k] + 1 / size;
  double left = lower + kGolden * (upper - lower);
  double right = upper - kGolden * (upper - lower);
  double at_left = residual_at(left);
  double at_right = residual_at(right);
  for (int step = 0; step < kNarrowings; ++step) {
    if (at_left < at_right) {
      upper = std::exchange(right, left);
      at_right = at_left;
      left = lower + kGolden * (upper - lower);
      at_left = residual_at(left);
    } else {
      lower = std::exchange(left, right);
      at_left = at_right;
      right = upper - kGolden * (upper - lower);
      at_right = residual_at(right);
    }
  }
  rad_per_sample[k] = 0.5 * (lower + upper);
}

}  // namespace

double ExpectedMotion::At(double k) const {
  const double t = k - middle;
  double value = offset + slope * t;
  for (const Sine& s : sines) {
    value += s.cosine * std::cos(s.rad_per_sample * t) + s.sine * std::sin(s.rad_per_sample * t);
  }
  return value;
}

std::vector<double> ExpectedMotion::From(double first, std::size_t count) const {
  std::vector<double> values(count);
  for (std::size_t k = 0; k < count; ++k) {
    values[k] = offset + slope * (first + static_cast<double>(k) - middle);
  }
  std::array<double, PhasorBlocks::kBlock> c;
  std::array<double, PhasorBlocks::kBlock> s;
  for (const Sine& sine_of : sines) {
    const PhasorBlocks phasors(sine_of.rad_per_sample);
    for (std::size_t begin = 0; begin < count; begin += PhasorBlocks::kBlock) {
      const std::size_t size = std::min(PhasorBlocks::kBlock, count - begin);
      phasors.Fill(first + static_cast<double>(begin) - middle, std::span(c).first(size),
                   std::span(s).first(size));
      for (std::size_t k = 0; k < size; ++k) {
        values[begin + k] += sine_of.cosine * c[k] + sine_of.sine * s[k];
      }
    }
  }
  return values;
}

ExpectedMotion FitExpectedMotion(std::span<const double> signal, int sines) {
  HAPTOMETER_CHECK(signal.size() >= kLeastExpectedMotionSamples, "{} samples", signal.size());
  HAPTOMETER_CHECK(sines >= 1 && sines <= kMostSines, "{} sines", sines);
  const Means means = MeansOf(signal);
  const auto size = static_cast<double>(signal.size());
  std::vector<double> rad_per_sample;
  rad_per_sample.reserve(kMostSines);
  for (int sine = 0; sine < sines; ++sine) {
    rad_per_sample.push_back(CoarseRad(means, rad_per_sample, size));
    for (int round = 0; round < (sine == 0 ? 1 : kRounds); ++round) {
      for (std::size_t k = 0; k < rad_per_sample.size(); ++k) {
        Narrow(means, rad_per_sample, k, size);
      }
    }
  }
  return FitAt(means, rad_per_sample).motion;
}

}  // namespace haptometer::dsp
