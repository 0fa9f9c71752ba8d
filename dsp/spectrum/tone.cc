#include "dsp/spectrum/tone.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "base/error.h"
#include "base/median.h"
#include "dsp/spectrum/fft.h"
#include "dsp/statistics/distributions.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

constexpr std::size_t kMainLobeBins = 3;  // bins on either side that a Hann peak itself fills
constexpr std::size_t kNeighbours = 64;   // bins on one side for the noise there
// with fewer on a side, the residual of the fit decides instead
constexpr std::size_t kLeastNeighbours = 16;
// independent values behind the median of n neighbours: n / 2.08 for exponential ones. Hann's
// correlation would halve that, the noisier of two sides more than makes up for it (tests).
constexpr double kNeighboursPerValue = 2;

// squared magnitudes of the transform of `signal`, without its mean and under a Hann window
std::vector<double> HannPower(std::span<const double> signal) {
  const std::size_t n = signal.size();
  const double mean = Mean(signal);
  // the window 0.5 - 0.5 cos(2 pi k / n), times the signal
  std::vector<double> windowed(n, 0.5);
  SubtractSine(2 * std::numbers::pi / static_cast<double>(n), 0.5, 0, 0, windowed);
  for (std::size_t k = 0; k < n; ++k) windowed[k] *= signal[k] - mean;
  // the transform of the windowed signal; power in squared units of the signal, not scaled
  const std::vector<std::complex<double>> bins = RealSpectrum(windowed);
  std::vector<double> power(bins.size());
  for (std::size_t k = 0; k < bins.size(); ++k) power[k] = std::norm(bins[k]);
  return power;
}

// the highest local maximum whose bin lies within half a bin of the band; a shoulder of something
// outside is none
std::optional<std::size_t> HighestPeak(const std::vector<double>& power, double lower_bin,
                                       double upper_bin) {
  std::optional<std::size_t> highest;
  // bin 0 has no neighbour below, so the search begins at 1
  const auto first = static_cast<std::size_t>(std::max(1.0, std::round(lower_bin)));
  for (std::size_t k = first;
       k + 1 < power.size() && static_cast<double>(k) <= std::round(upper_bin); ++k) {
    const bool peak = power[k] > 0 && power[k] >= power[k - 1] && power[k] >= power[k + 1];
    if (peak && (!highest || power[k] > power[*highest])) highest = k;
  }
  return highest;
}

// where between the bins a Hann peak at bin `k` lies: with r the ratio of the larger neighbour to
// the peak, the distance is (2 r - 1) / (r + 1)
double PeakBin(const std::vector<double>& power, std::size_t k) {
  const double before = power[k - 1];
  const double after = power[k + 1];
  const double ratio = std::sqrt(std::max(before, after) / power[k]);
  const double distance = std::clamp((2 * ratio - 1) / (ratio + 1), 0.0, 0.5);
  return static_cast<double>(k) + (after > before ? distance : -distance);
}

// noise level on one side of a peak from the median of power[begin, end): for exponentially
// distributed powers the median is ln 2 of the mean
struct NoiseLevel {
  double mean = 0;
  double values = 0;  // independent ones behind it; 0: too few neighbours
};

NoiseLevel LevelOf(const std::vector<double>& power, std::size_t begin, std::size_t end) {
  if (end < begin + kLeastNeighbours) return {};
  std::vector<double> side(power.begin() + static_cast<std::ptrdiff_t>(begin),
                           power.begin() + static_cast<std::ptrdiff_t>(end));
  const double values = static_cast<double>(side.size()) / kNeighboursPerValue;
  return {UpperMedian(std::move(side)) / std::numbers::ln2, values};
}

// the noisier of the two sides of bin `k`, its main lobe excluded; bin 0, without mean, is not used
NoiseLevel LevelAround(const std::vector<double>& power, std::size_t k) {
  const std::size_t left_end = k > kMainLobeBins ? k - kMainLobeBins : 1;
  const std::size_t left_begin = left_end > kNeighbours ? left_end - kNeighbours : 1;
  const std::size_t right_begin = std::min(power.size(), k + kMainLobeBins + 1);
  const std::size_t right_end = std::min(power.size(), right_begin + kNeighbours);
  const NoiseLevel left = LevelOf(power, left_begin, left_end);
  const NoiseLevel right = LevelOf(power, right_begin, right_end);
  return left.mean >= right.mean ? left : right;
}

// independent places in which noise may give a peak: bins of 1 / duration within the band
double BinsIn(const ToneSearch& search, double duration_s) {
  return std::max(1.0, (search.upper_hz - search.lower_hz) * duration_s);
}

// whether noise rarely gives such a peak in the band, by the spectrum beside it: that one of m
// exponential values, in units of a mean estimated from v values, exceeds x has the probability
// m (1 + x/v)^-v
bool StandsOutOfNeighbours(double peak_power, const NoiseLevel& level, double bins,
                           double false_alarm) {
  const double v = level.values;
  return peak_power > level.mean * v * (std::pow(bins / false_alarm, 1 / v) - 1);
}

// the same by the residual of the fit, where there are too few neighbours
bool StandsOutOfResidual(const SineFit& fit, double bins, double false_alarm) {
  const double u = fit.amplitude_uncertainty;
  return fit.amplitude * fit.amplitude > 2 * u * u * std::log(bins / false_alarm);
}

}  // namespace

std::optional<SineFit> StrongestTone(std::span<const double> signal, const ToneSearch& search) {
  HAPTOMETER_CHECK(search.rate_hz > 0 && search.lower_hz > 0, "rate_hz = {}, lower_hz = {}",
                   search.rate_hz, search.lower_hz);
  // a transform of small primes may leave some samples out; the fit below uses all of them
  const auto seen = signal.first(FastTransformSize(signal.size()));
  const double duration_s = static_cast<double>(seen.size()) / search.rate_hz;
  const double whole_s = static_cast<double>(signal.size()) / search.rate_hz;
  // 2 / whole_s, as a caller computes it, may be two periods less a rounding
  constexpr double kTwoPeriods = 2 * (1 - 1e-12);
  if (whole_s * search.lower_hz < kTwoPeriods || signal.size() > kLongestTransform) {
    return std::nullopt;
  }

  const std::vector<double> power = HannPower(seen);
  const std::optional<std::size_t> peak =
      HighestPeak(power, search.lower_hz * duration_s, search.upper_hz * duration_s);
  if (!peak) return std::nullopt;

  // between the bins by interpolation, then exactly by least squares
  const double start_hz = PeakBin(power, *peak) / duration_s;
  // noise is excluded before the fit
  const NoiseLevel level = LevelAround(power, *peak);
  const double bins = BinsIn(search, duration_s);
  if (level.values > 0 && !StandsOutOfNeighbours(power[*peak], level, bins, search.false_alarm)) {
    return std::nullopt;
  }
  const SineFit fit = FitSine(signal, {search.rate_hz, search.noise_bandwidth_hz}, start_hz);
  const double slack_hz = 0.5 / duration_s;  // a tone on a corner may fall to either side
  const bool inside = fit.frequency_hz > search.lower_hz - slack_hz &&
                      fit.frequency_hz < search.upper_hz + slack_hz;
  if (!fit.converged || !inside) return std::nullopt;
  if (level.values == 0 && !StandsOutOfResidual(fit, bins, search.false_alarm)) return std::nullopt;
  return fit;
}

namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr std::size_t kBlock = PhasorBlocks::kBlock;
// share of noise alone that stays below the threshold of a harmonic
constexpr double kStandsOut = 0.99;
constexpr double kOneSided95 = 1.6448536269514722;  // standard deviations
// reciprocal condition of the normal equations below which the harmonics are not separable
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
  // the fundamental from a table, order h from order h - 1 by the addition theorems
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

// The first pairs of rows are the parts of each harmonic's cosine and sine. They are converted to a
// time that begins `later`: parts of a sum turn by that, sums of products with them by -`later`.
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

// Legendre's polynomials at `tau`: k P_k = (2k - 1) tau P_{k-1} - (k - 1) P_{k-2}
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
  // sin(n h) / sin(h) with h = multiple w / 2, reduced by whole multiples of pi to keep its digits
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
    // a polynomial is determined by its values at as many nodes as it has coefficients
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
    // 2 cos a cos b = cos(a - b) + cos(a + b), 2 sin a sin b = cos(a - b) - cos(a + b)
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

// A d = r for the step d of the parameters
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
  // model of this block: parameters at `at`, in the block's own time and polynomials
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
    // X' residual, brought back from the block's time to that of the signal
    MatrixXd products = columns.transpose() * residual;
    Turn(question, -first, products);
    total.right.head(turning) += products.col(0).head(turning);
    total.right.tail(drifting) += drift.transpose() * products.col(0).tail(drifting);
    total.square_sum += residual.squaredNorm();
    if (with_matrix == WithMatrix::kNo) continue;
    // X' X of a full block is the same for all of them; only the last one may be shorter
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
    // products of cosines and sines over all samples are known in closed form
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
  // covariance along (a, b) is that of the amplitude, across it that of amplitude times phase
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
    // Var(amplitude^2) = 4 u^2 a^2 + 4 u^4 with a^2 = amplitude^2 - 2 u^2, at least 4 u^4
    variance += 4 * u_square * std::max(u_square, a_square - u_square);
    in_noises += u_square > 0 ? a_square / u_square : 0;
  }
  const Harmonic& first = found.harmonics.front();
  const double u_first = first.amplitude_uncertainty;
  const double fundamental_power = first.amplitude * first.amplitude - 2 * u_first * u_first;
  if (!first.stands_out || !(fundamental_power > 0)) return;
  const double fundamental = std::sqrt(fundamental_power);
  // bound from the sum of powers plus 1.645 of its standard deviations
  found.thd_at_most =
      std::sqrt(std::max(0.0, power) + kOneSided95 * std::sqrt(variance)) / fundamental;
  // sum of amplitude^2 / u^2 over the harmonics is chi-squared for noise alone, two per harmonic
  const auto freedom = static_cast<double>(2 * (found.harmonics.size() - 1));
  if (!(in_noises > ChiSquareQuantile(kStandsOut, freedom)) || !(power > 0)) return;
  const double thd = std::sqrt(power) / fundamental;
  found.thd = thd;
  found.thd_uncertainty =
      std::hypot(std::sqrt(variance / power) / (2 * fundamental), thd * u_first / fundamental);
}

// how many multiples lie up to `upper_hz` and below rate/2
int CountBelow(double fundamental_hz, double upper_hz, double rate_hz) {
  // the margin of 1e-12 accepts a harmonic that lies on the limit up to rounding
  const double most = std::min(upper_hz / fundamental_hz * (1 + 1e-12),
                               std::nextafter(0.5 * rate_hz, 0) / fundamental_hz);
  return static_cast<int>(std::clamp(std::floor(most), 0.0, static_cast<double>(kMostHarmonics)));
}

// the mean is subtracted for the digits of the sums; the drift contains an offset anyway
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
  // fewer than one period does not determine the fundamental
  if (count < 1 || n / options.rate_hz * fundamental_hz < 1) return found;
  const Question question = Ask(signal, options, fundamental_hz, count);
  // noise confined to a band leaves 2 B / rate of the samples independent
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

  // covariance = A^-1 residual variance
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
