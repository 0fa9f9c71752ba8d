#include "fit/poles.h"

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>

#include "base/error.h"
#include "dsp/spectrum/fft.h"

namespace haptometer::fit {
namespace {

constexpr std::size_t kLeastSamples = 16;
// block means that the pencil uses; their Hankel matrix has a third as many columns
constexpr std::size_t kMostPencilSamples = 240;
constexpr double kSamplesPerPeriod = 8;
// Q of the start values where the pencil fails
constexpr double kFallbackQuality = 30;

// means of consecutive blocks, the first kMostPencilSamples of them
Eigen::VectorXd BlockMeans(const std::vector<double>& values, std::size_t block) {
  const std::size_t count = std::min(values.size() / block, kMostPencilSamples);
  Eigen::VectorXd means(static_cast<Eigen::Index>(count));
  for (std::size_t n = 0; n < count; ++n) {
    double sum = 0;
    for (std::size_t k = 0; k < block; ++k) sum += values[n * block + k];
    means[static_cast<Eigen::Index>(n)] = sum / static_cast<double>(block);
  }
  return means;
}

// The two leading right singular vectors, by iterating a subspace of six; by the whole
// decomposition where noise is nearly as large as the signal, so that this takes long.
Eigen::MatrixX2d LeadingVectors(const Eigen::MatrixXd& matrix) {
  constexpr Eigen::Index kWidth = 6;
  constexpr int kMostRounds = 12;
  constexpr double kSettled = 1e-12;
  Eigen::MatrixXd basis = matrix.topRows(kWidth).transpose();
  Eigen::MatrixX2d before = Eigen::MatrixX2d::Zero(matrix.cols(), 2);
  for (int round = 0; matrix.cols() > kWidth && round < kMostRounds; ++round) {
    basis = Eigen::HouseholderQR<Eigen::MatrixXd>(basis).householderQ() *
            Eigen::MatrixXd::Identity(matrix.cols(), kWidth);
    const Eigen::MatrixXd image = matrix * basis;
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(image, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const Eigen::MatrixX2d leading = basis * svd.matrixV().leftCols(2);
    // converged: the new vectors lie in the span of the previous two
    if ((leading - before * (before.transpose() * leading)).norm() < kSettled) return leading;
    before = leading;
    basis = matrix.transpose() * image;
  }
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(matrix, Eigen::ComputeThinV);
  return svd.matrixV().leftCols(2);
}

// the 2 x 2 matrix whose eigenvalues advance the two poles by one sample
Eigen::Matrix2d Advance(const Eigen::VectorXd& samples) {
  // pencil parameter L = N/3: (N - L) x (L + 1) Hankel matrix
  const Eigen::Index pencil = samples.size() / 3;
  Eigen::MatrixXd hankel(samples.size() - pencil, pencil + 1);
  for (Eigen::Index column = 0; column <= pencil; ++column) {
    hankel.col(column) = samples.segment(column, hankel.rows());
  }
  // shift invariance: rows 2 to L + 1 of the signal's vectors are rows 1 to L times the matrix
  const Eigen::MatrixX2d signal = LeadingVectors(hankel);
  return signal.topRows(pencil).colPivHouseholderQr().solve(signal.bottomRows(pencil));
}

// from the powers' polynomial z^2 - trace z + determinant to that of the poles
std::optional<PolePair> PolesOf(double trace, double determinant, double step_s) {
  if (!(determinant > 0 && determinant < 1)) return std::nullopt;
  // z1 z2 = e^(-2 d dt), z1 + z2 = 2 e^(-d dt) cos(w dt)
  const double decay = -0.5 * std::log(determinant) / step_s;
  const double cosine = 0.5 * trace / std::sqrt(determinant);
  if (cosine <= -1) return std::nullopt;
  if (cosine <= 1) {
    const double angular = std::acos(cosine) / step_s;
    return PolePair{decay, decay * decay + angular * angular};
  }
  // two real poles: decay -+ rate, both falling
  const double rate = std::acosh(cosine) / step_s;
  if (rate >= decay) return std::nullopt;
  return PolePair{decay, (decay - rate) * (decay + rate)};
}

// whether the pencil followed something else than the strongest line
bool Strayed(const PolePair& poles, double frequency_hz) {
  const double natural_hz = std::sqrt(poles.stiffness_per_s2) / (2 * std::numbers::pi);
  const double quality = std::sqrt(poles.stiffness_per_s2) / (2 * poles.decay_per_s);
  return quality > 2 && std::abs(natural_hz - frequency_hz) > 0.3 * frequency_hz;
}

}  // namespace

std::optional<double> StrongestFrequency(const std::vector<double>& values, double step_s) {
  if (values.size() < kLeastSamples) return std::nullopt;
  // zero-padded to at least twice its length
  const std::size_t length = std::bit_ceil(2 * values.size());
  std::vector<double> padded(length);
  std::ranges::copy(values, padded.begin());
  const std::vector<std::complex<double>> lines = dsp::RealSpectrum(padded);
  // two periods a record are two record lengths' worth of padded lines
  const std::size_t lowest = 2 * length / values.size();
  const auto power = [](const std::complex<double>& line) { return std::norm(line); };
  const auto peak = std::ranges::max_element(lines.begin() + static_cast<std::ptrdiff_t>(lowest),
                                             lines.end(), {}, power);
  if (!(power(*peak) > 0)) return std::nullopt;
  return static_cast<double>(peak - lines.begin()) / (static_cast<double>(length) * step_s);
}

std::optional<PolePair> EstimatePoles(const std::vector<double>& values, double step_s) {
  const auto frequency_hz = StrongestFrequency(values, step_s);
  if (!frequency_hz) return std::nullopt;
  // blocks of an eighth of a period, at least 100 in the record
  const double period_samples = 1 / (*frequency_hz * step_s);
  const auto wanted = static_cast<std::size_t>(period_samples / kSamplesPerPeriod);
  const std::size_t block =
      std::clamp<std::size_t>(wanted, 1, std::max<std::size_t>(values.size() / 100, 1));
  const Eigen::Matrix2d advance = Advance(BlockMeans(values, block));
  const auto poles =
      PolesOf(advance.trace(), advance.determinant(), static_cast<double>(block) * step_s);
  if (poles && !Strayed(*poles, *frequency_hz)) return poles;
  // the strongest line with a usual Q
  const double angular = 2 * std::numbers::pi * *frequency_hz;
  return PolePair{angular / (2 * kFallbackQuality), angular * angular};
}

std::vector<PolePlace> EllipseOf(const UncertainPole& pole, std::size_t points) {
  HAPTOMETER_CHECK(pole.determined && points >= 3, "{} points of a pole", points);
  // 95 % of two Gaussian variables together: r^2 = -2 ln(0.05)
  const double radius = std::sqrt(-2 * std::log(0.05));
  // Cholesky's factor of the covariance; rounding may leave it a hair indefinite
  const auto& [along, across] = pole.covariance;
  const double first = std::sqrt(along[0]);
  const double mixed = first > 0 ? across[0] / first : 0;
  const double second = std::sqrt(std::max(across[1] - mixed * mixed, 0.0));
  std::vector<PolePlace> ellipse;
  ellipse.reserve(points + 1);
  for (std::size_t k = 0; k <= points; ++k) {
    const double turn = static_cast<double>(k % points) / static_cast<double>(points);
    const double x = radius * std::cos(2 * std::numbers::pi * turn);
    const double y = radius * std::sin(2 * std::numbers::pi * turn);
    ellipse.push_back({pole.frequency_hz + first * x, pole.decay_per_s + mixed * x + second * y});
  }
  return ellipse;
}

}  // namespace haptometer::fit
