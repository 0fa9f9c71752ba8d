#include "dsp/spectrum/harmonics.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "dsp/spectrum/phasor_blocks.h"
#include "dsp/statistics/distributions.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr std::size_t kBlock = PhasorBlocks::kBlock;
constexpr double kStandsOut = 0.99;
constexpr double kOneSided95 = 1.6448536269514722;  // standard deviations
constexpr double kLeastCondition = 1e-10;

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The question in samples; parameters are a_1, b_1, a_2, b_2 .. and the drift, t from the middle.
struct Question {
  std::vector<double> values;  // without their mean
  double rad_per_sample = 0;
  int count = 0;  // of harmonics
  int drift_degree = 0;

  [[nodiscard]] Index parameters() const { return 2 * count + 1 + drift_degree; }
  [[nodiscard]] double half() const { return 0.5 * static_cast<double>(values.size() - 1); }
};

// cosines and sines of all harmonics in one block of rows, time counted from its first: by turning
void FillTurns(const Question& question, MatrixXd& turns) {
  PhasorBlocks(question.rad_per_sample)
      .Fill(0, {turns.col(0).data(), kBlock}, {turns.col(1).data(), kBlock});
  const auto c = turns.col(0).array();
  const auto s = turns.col(1).array();
  for (Index h = 1; h < question.count; ++h) {
    const auto c_before = turns.col(2 * h - 2).array();
    const auto s_before = turns.col(2 * h - 1).array();
    turns.col(2 * h) = c * c_before - s * s_before;
    turns.col(2 * h + 1) = s * c_before + c * s_before;
  }
}

// The first pairs of rows, the parts of each harmonic's cosine and sine, in a time that begins
// `later`: parts of a sum turn by that, sums of products with them by -`later`.
void Turn(const Question& question, double later, MatrixXd& pairs) {
  for (int h = 1; h <= question.count; ++h) {
    const double angle = h * question.rad_per_sample * later;
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    const Index row = 2 * Index{h - 1};
    for (Index column = 0; column < pairs.cols(); ++column) {
      const double of_cosine = pairs(row, column);
      const double of_sine = pairs(row + 1, column);
      pairs(row, column) = c * of_cosine + s * of_sine;
      pairs(row + 1, column) = c * of_sine - s * of_cosine;
    }
  }
}

// Legendre's polynomials at `tau`, by their recurrence
void FillLegendre(const Eigen::Ref<const VectorXd>& tau, MatrixXd& legendre) {
  legendre.col(0).setOnes();
  if (legendre.cols() > 1) legendre.col(1) = tau;
  for (Index k = 2; k < legendre.cols(); ++k) {
    const auto degree = static_cast<double>(k);
    legendre.col(k) = ((2 * degree - 1) * tau.cwiseProduct(legendre.col(k - 1)) -
                       (degree - 1) * legendre.col(k - 2)) /
                      degree;
  }
}

// sum over the samples of cos(multiple w t): Dirichlet's kernel. Their sines sum to 0, t being from
// the middle.
double CosineSum(const Question& question, int multiple) {
  const double half_turn = 0.5 * multiple * question.rad_per_sample;
  const double turns = std::round(half_turn / std::numbers::pi);
  const double rest = std::fma(-turns, std::numbers::pi, half_turn);
  const auto n = static_cast<double>(question.values.size());
  const bool odd = std::fmod(turns * (n - 1), 2) != 0;
  return (odd ? -1 : 1) * (rest == 0 ? n : std::sin(n * rest) / std::sin(rest));
}

// what all blocks of rows have in common, in their own time
struct BlockBasis {
  MatrixXd columns;   // cosine and sine of each harmonic, Legendre's polynomials over the block
  VectorXd nodes;     // rows, as many as there are polynomials,
  MatrixXd by_nodes;  // and any polynomial in terms of those over the block, by its values there

  explicit BlockBasis(const Question& question) : columns(kBlock, question.parameters()) {
    FillTurns(question, columns);
    const Index drifting = 1 + Index{question.drift_degree};
    constexpr double kLast = kBlock - 1;
    MatrixXd legendre(kBlock, drifting);
    FillLegendre(VectorXd::LinSpaced(kBlock, -1, 1), legendre);
    columns.rightCols(drifting) = legendre;
    nodes = VectorXd::LinSpaced(drifting, 0, kLast);
    MatrixXd at_nodes(drifting, drifting);
    FillLegendre((nodes * (2 / kLast)).array() - 1, at_nodes);
    by_nodes = at_nodes.inverse();
  }

  // the polynomials over the samples in terms of those over the block that begins at `first`
  [[nodiscard]] MatrixXd DriftFrom(double first, double half) const {
    MatrixXd values(nodes.size(), nodes.size());
    FillLegendre((nodes.array() + first) / half, values);
    return by_nodes * values;
  }
};

// products of the cosines and sines with each other, summed over the samples
void FillProducts(const Question& question, MatrixXd& matrix) {
  for (int h = 1; h <= question.count; ++h) {
    for (int k = 1; k <= question.count; ++k) {
      const double apart = CosineSum(question, h - k);
      const double together = CosineSum(question, h + k);
      const Index row = 2 * Index{h - 1};
      const Index column = 2 * Index{k - 1};
      matrix(row, column) = 0.5 * (apart + together);
      matrix(row + 1, column + 1) = 0.5 * (apart - together);
    }
  }
}

struct Normal {
  MatrixXd matrix;
  VectorXd right;
  double square_sum = 0;  // of the residuals
};

// Normal equations about `at`, block by block; the matrix is the same about every `at`.
enum class WithMatrix : bool { kNo, kYes };

Normal Linearise(const Question& question, const VectorXd& at, WithMatrix with_matrix) {
  const Index p = question.parameters();
  const Index turning = 2 * Index{question.count};
  const Index drifting = p - turning;
  const BlockBasis basis(question);
  Normal total{MatrixXd::Zero(p, p), VectorXd::Zero(p), 0};
  MatrixXd with_drift;  // of a block's columns, products with its polynomials
  for (std::size_t begin = 0; begin < question.values.size(); begin += kBlock) {
    const auto rows = static_cast<Index>(std::min(kBlock, question.values.size() - begin));
    const double first = static_cast<double>(begin) - question.half();
    const auto columns = basis.columns.topRows(rows);
    const MatrixXd drift = basis.DriftFrom(first, question.half());
    MatrixXd parts = at;
    Turn(question, first, parts);
    parts.bottomRows(drifting) = drift * at.tail(drifting);
    const Eigen::Map<const VectorXd> values(question.values.data() + begin, rows);
    const VectorXd residual = values - columns * parts.col(0);
    MatrixXd products = columns.transpose() * residual;
    Turn(question, -first, products);
    total.right.head(turning) += products.col(0).head(turning);
    total.right.tail(drifting) += drift.transpose() * products.col(0).tail(drifting);
    total.square_sum += residual.squaredNorm();
    if (with_matrix == WithMatrix::kNo) continue;
    if (begin == 0 || rows < basis.columns.rows()) {
      with_drift = columns.transpose() * columns.rightCols(drifting);
    }
    MatrixXd shared = with_drift * drift;
    Turn(question, -first, shared);
    total.matrix.topRightCorner(turning, drifting) += shared.topRows(turning);
    total.matrix.bottomRightCorner(drifting, drifting) +=
        drift.transpose() * shared.bottomRows(drifting);
  }
  if (with_matrix == WithMatrix::kYes) {
    FillProducts(question, total.matrix);
    total.matrix.bottomLeftCorner(drifting, turning) =
        total.matrix.topRightCorner(turning, drifting).transpose();
  }
  return total;
}

// a and b of order h: amplitude and phase, with their uncertainties
Harmonic Describe(const Question& question, const VectorXd& at, const MatrixXd& covariance,
                  int order) {
  const Index column = 2 * Index{order - 1};
  const double a = at[column];
  const double b = at[column + 1];
  Harmonic harmonic;
  harmonic.order = order;
  harmonic.amplitude = std::hypot(a, b);
  // the first sample lies `half` before the middle, where the phase is -atan2(b, a)
  harmonic.phase_rad =
      std::remainder(-std::atan2(b, a) - order * question.rad_per_sample * question.half(), kTwoPi);
  const Eigen::Matrix2d block = covariance.block<2, 2>(column, column);
  const Eigen::Vector2d along = Eigen::Vector2d(a, b).stableNormalized();
  const Eigen::Vector2d across(-along[1], along[0]);
  harmonic.amplitude_uncertainty = std::sqrt(along.dot(block * along));
  harmonic.phase_uncertainty_rad = std::sqrt(across.dot(block * across)) / harmonic.amplitude;
  // two normal values of variance u^2 each: amplitude^2 / u^2 is chi-squared with 2
  const double u_square = 0.5 * block.trace();
  harmonic.stands_out =
      harmonic.amplitude * harmonic.amplitude > u_square * ChiSquareQuantile(kStandsOut, 2);
  return harmonic;
}

// fills in thd, its uncertainty and its bound
void DescribeDistortion(Harmonics& found) {
  if (found.harmonics.size() < 2) return;
  double power = 0;     // sum of amplitude^2 - 2 u^2
  double variance = 0;  // of that sum
  double in_noises = 0;
  for (const Harmonic& h : std::span(found.harmonics).subspan(1)) {
    const double a_square = h.amplitude * h.amplitude;
    const double u_square = h.amplitude_uncertainty * h.amplitude_uncertainty;
    power += a_square - 2 * u_square;
    variance += 4 * u_square * std::max(u_square, a_square - u_square);
    in_noises += u_square > 0 ? a_square / u_square : 0;
  }
  const Harmonic& first = found.harmonics.front();
  const double u_first = first.amplitude_uncertainty;
  const double fundamental_power = first.amplitude * first.amplitude - 2 * u_first * u_first;
  if (!first.stands_out || !(fundamental_power > 0)) return;
  const double fundamental = std::sqrt(fundamental_power);
  found.thd_at_most =
      std::sqrt(std::max(0.0, power) + kOneSided95 * std::sqrt(variance)) / fundamental;
  const auto freedom = static_cast<double>(2 * (found.harmonics.size() - 1));
  if (!(in_noises > ChiSquareQuantile(kStandsOut, freedom)) || !(power > 0)) return;
  const double thd = std::sqrt(power) / fundamental;
  found.thd = thd;
  found.thd_uncertainty =
      std::hypot(std::sqrt(variance / power) / (2 * fundamental), thd * u_first / fundamental);
}

// how many multiples lie up to `upper_hz` and below rate/2
int CountBelow(double fundamental_hz, double upper_hz, double rate_hz) {
  const double most = std::min(upper_hz / fundamental_hz * (1 + 1e-12),
                               std::nextafter(0.5 * rate_hz, 0) / fundamental_hz);
  return static_cast<int>(std::clamp(std::floor(most), 0.0, static_cast<double>(kMostHarmonics)));
}

Question Ask(std::span<const double> signal, const SineFitOptions& options, double fundamental_hz,
             int count) {
  Question question;
  const double mean = Mean(signal);
  question.values.assign(signal.begin(), signal.end());
  for (double& x : question.values) x -= mean;
  question.rad_per_sample = kTwoPi * fundamental_hz / options.rate_hz;
  question.count = count;
  question.drift_degree = options.drift_degree;
  return question;
}

}  // namespace

Harmonics FitHarmonics(std::span<const double> signal, const SineFitOptions& options,
                       double fundamental_hz, double upper_hz) {
  HAPTOMETER_CHECK(options.rate_hz > 0 && options.drift_degree >= 0 &&
                       options.drift_degree <= kHighestDriftDegree,
                   "rate_hz = {}, drift_degree = {}", options.rate_hz, options.drift_degree);
  Harmonics found;
  if (!(fundamental_hz > 0) || signal.size() < 4) return found;
  const int count = CountBelow(fundamental_hz, upper_hz, options.rate_hz);
  const auto n = static_cast<double>(signal.size());
  if (count < 1 || n / options.rate_hz * fundamental_hz < 1) return found;
  const Question question = Ask(signal, options, fundamental_hz, count);
  const double share =
      options.noise_bandwidth_hz > 0 ? 2 * options.noise_bandwidth_hz / options.rate_hz : 1;
  const double freedom = n * share - static_cast<double>(question.parameters());
  if (!(freedom > 0)) return found;

  // one step solves it, the second removes its rounding; what a step takes from the squares is its
  // product with the right side
  VectorXd at = VectorXd::Zero(question.parameters());
  Normal normal = Linearise(question, at, WithMatrix::kYes);
  const Eigen::LDLT<MatrixXd> solver(normal.matrix);
  if (solver.info() != Eigen::Success || !(solver.rcond() > kLeastCondition)) return found;
  at = solver.solve(normal.right);
  normal = Linearise(question, at, WithMatrix::kNo);
  const VectorXd last = solver.solve(normal.right);
  at += last;
  if (!at.allFinite()) return found;
  const double square_sum = std::max(0.0, normal.square_sum - last.dot(normal.right));

  const MatrixXd covariance =
      solver.solve(MatrixXd::Identity(at.size(), at.size())) * (square_sum / freedom);
  found.harmonics.reserve(static_cast<std::size_t>(count));
  for (int order = 1; order <= count; ++order) {
    found.harmonics.push_back(Describe(question, at, covariance, order));
    found.harmonics.back().frequency_hz = order * fundamental_hz;
  }
  found.residual_rms = std::sqrt(square_sum / n);
  found.degrees_of_freedom = freedom;
  found.converged = true;
  DescribeDistortion(found);
  return found;
}

}  // namespace haptometer::dsp
