#include "dsp/spectrum/frequency_response.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "base/mapped.h"
#include "base/median.h"
#include "dsp/spectrum/envelope.h"

namespace haptometer::dsp {
namespace {

constexpr double kLeastDrive = 1e-10;    // of the greatest density
constexpr std::size_t kIndependent = 3;  // bins of a Hann window that share no noise
constexpr double kOverlapping = 0.94;    // independent ones in Hann segments that overlap by half

// A phase over a block: mean + slope tau + bend (tau^2 - mean_square), tau from -1 to 1 and
// mean_square the mean of its squares: three terms that are orthogonal over the samples.
struct BlockPhase {
  double mean = 0;
  double slope = 0;
  double bend = 0;
  double mean_square = 0;

  [[nodiscard]] double At(double tau) const {
    return mean + slope * tau + bend * (tau * tau - mean_square);
  }
};

// least-squares phase of a block, in rad, unwrapped from sample to sample
BlockPhase FitPhase(std::span<const std::complex<double>> block, double half) {
  const auto size = static_cast<double>(block.size());
  BlockPhase fit;
  // mean of tau^2 over `size` equal steps from -1 to 1
  fit.mean_square = (size + 1) / (3 * (size - 1));
  double slope_square = 0;
  double bend_square = 0;
  double phase = std::arg(block[0]);
  for (std::size_t k = 0; k < block.size(); ++k) {
    // unwrapped by the phase difference of neighbours, which is below pi in magnitude
    if (k > 0) phase += std::arg(block[k] * std::conj(block[k - 1]));
    const double tau = static_cast<double>(k) / half - 1;
    const double square = tau * tau - fit.mean_square;
    fit.mean += phase;
    fit.slope += phase * tau;
    fit.bend += phase * square;
    slope_square += tau * tau;
    bend_square += square * square;
  }
  fit.mean /= size;
  fit.slope /= slope_square;
  // two samples have no bend
  fit.bend = block.size() > 2 ? fit.bend / bend_square : 0;
  return fit;
}

// Amplitude and mean frequency of a block of the analytic signal: the part with its phase. Noise,
// whose phase is another one, averages out.
SweptPoint PointOf(std::span<const std::complex<double>> block, double rate_hz) {
  const double half = 0.5 * static_cast<double>(block.size() - 1);
  const BlockPhase phase = FitPhase(block, half);
  std::complex<double> sum;
  for (std::size_t k = 0; k < block.size(); ++k) {
    // demodulated with the fitted phase: mean of z exp(-j phase)
    sum += block[k] * std::polar(1.0, -phase.At(static_cast<double>(k) / half - 1));
  }
  SweptPoint point;
  point.amplitude = std::abs(sum) / static_cast<double>(block.size());
  // slope is in rad per half block; f = dphase/dt / (2 pi)
  point.frequency_hz = phase.slope / half * rate_hz / (2 * std::numbers::pi);
  return point;
}

}  // namespace

Result<std::vector<ResponsePoint>> MeasureResponse(std::span<const double> drive,
                                                   std::span<const double> displacement,
                                                   const WelchOptions& options, double lower_hz,
                                                   double upper_hz) {
  HAPTOMETER_LET(auto cross, WelchCrossSpectrum(drive, displacement, options));
  if (cross.grid.segments < 2) {
    return Usage("sweep", "holds one segment, which gives no coherence",
                 "choose shorter segments, or record longer");
  }
  const std::vector<double> coherence = Coherence(cross);
  // bins nearly without drive have a ratio of noise to noise
  const double least = kLeastDrive * std::ranges::max(cross.from_density);
  std::vector<ResponsePoint> points;
  points.reserve(cross.cross.size());
  for (std::size_t k = 0; k < cross.cross.size(); ++k) {
    const double frequency_hz = static_cast<double>(k) * cross.grid.resolution_hz;
    if (frequency_hz < lower_hz || frequency_hz > upper_hz) continue;
    if (!(cross.from_density[k] > least) || !(coherence[k] > 0)) continue;
    const double c = std::min(1.0, coherence[k]);
    // H1 = cross / drive; u^2 = (1 - c) / (c degrees of freedom)
    points.push_back({frequency_hz, cross.cross[k] / cross.from_density[k], c,
                      std::sqrt((1 - c) / (c * cross.grid.degrees_of_freedom))});
  }
  return points;
}

std::vector<SweptPoint> SweptAmplitude(std::span<const double> displacement, double rate_hz,
                                       double lower_hz, double upper_hz, double periods) {
  HAPTOMETER_CHECK(rate_hz > 0 && lower_hz > 0 && periods > 0, "rate_hz = {}, lower_hz = {}",
                   rate_hz, lower_hz);
  const double samples = std::round(periods * rate_hz / lower_hz);
  // at least three blocks, because the first and the last one are not used
  if (!(samples >= 2 && 3 * samples <= static_cast<double>(displacement.size()))) return {};
  const auto size = static_cast<std::size_t>(samples);
  const std::vector<std::complex<double>> analytic = AnalyticSignal(displacement);
  std::vector<SweptPoint> points;
  points.reserve(analytic.size() / size);
  // the first and the last block hold what the transform's ends disturb
  for (std::size_t begin = size; begin + 2 * size <= analytic.size(); begin += size) {
    SweptPoint point = PointOf(std::span(analytic).subspan(begin, size), rate_hz);
    point.time_s = (static_cast<double>(begin) + 0.5 * (samples - 1)) / rate_hz;
    if (point.frequency_hz >= lower_hz && point.frequency_hz <= upper_hz) points.push_back(point);
  }
  return points;
}

void KeepSignificant(std::vector<ResponsePoint>& points, double segments) {
  const double chance = 0.05 / static_cast<double>(std::max<std::size_t>(1, points.size()));
  const double level = 1 - std::pow(chance, 1 / std::max(1.0, kOverlapping * segments - 1));
  std::erase_if(points, [&](const ResponsePoint& point) { return point.coherence <= level; });
}

std::vector<ResponsePoint> IndependentPoints(std::span<const ResponsePoint> points,
                                             double resolution_hz) {
  std::vector<ResponsePoint> kept;
  kept.reserve(points.size() / kIndependent + 1);
  for (const ResponsePoint& point : points) {
    const auto bin = static_cast<std::size_t>(std::round(point.frequency_hz / resolution_hz));
    if (bin % kIndependent == 0) kept.push_back(point);
  }
  return kept;
}

std::vector<SweptPoint> LongestSweep(const std::vector<SweptPoint>& points, double block_s) {
  std::size_t best = 0;
  std::size_t best_size = 0;
  std::size_t begin = 0;
  for (std::size_t k = 1; k <= points.size(); ++k) {
    const bool goes_on =
        // neighbours in time: blocks outside of the band are missing from `points`
        k < points.size() &&
        std::abs(points[k].frequency_hz - points[k - 1].frequency_hz) < 1 / block_s &&
        points[k].time_s - points[k - 1].time_s < 1.5 * block_s;
    if (goes_on) continue;
    if (k - begin > best_size) {
      best = begin;
      best_size = k - begin;
    }
    begin = k;
  }
  const auto first = points.begin() + static_cast<std::ptrdiff_t>(best);
  return {first, first + static_cast<std::ptrdiff_t>(best_size)};
}

double SweepRate(std::span<const SweptPoint> points) {
  std::vector<double> rates;
  rates.reserve(points.size());
  for (std::size_t k = 1; k < points.size(); ++k) {
    rates.push_back(std::abs((points[k].frequency_hz - points[k - 1].frequency_hz) /
                             (points[k].time_s - points[k - 1].time_s)));
  }
  return Median(rates);
}

namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kLeastRelativeUncertainty = 1e-3;
constexpr int kMostSteps = 200;
constexpr double kAtRest = 1e-9;  // relative change of f0 and of Q
// damping beyond which no step improves: the minimum up to rounding
constexpr double kLargestDamping = 1e12;
constexpr std::size_t kMostTops = 32;
constexpr std::size_t kNeighbours = 4;  // on either side, whose deviations are alike
// ratio of deviations above which a point keeps its own
constexpr double kUnlike = 10;

// A point to fit: its value (a magnitude where only that is known) and one over its deviation.
struct Point {
  double frequency_hz = 0;
  Complex value;
  double weight = 1;
};

// The last two parameters are always f0 and ln Q; before them the gain: real and imaginary part, or
// its magnitude.
struct Problem {
  std::vector<Point> points;
  bool magnitudes = false;

  [[nodiscard]] Index parameters() const { return magnitudes ? 3 : 4; }
  [[nodiscard]] Index rows() const {
    return static_cast<Index>(points.size()) * (magnitudes ? 1 : 2);
  }
};

// weighted residuals (value - model) and the model's derivatives by the parameters
struct Linear {
  VectorXd residuals;
  MatrixXd jacobian;
};

// H of gain 1 and its derivatives by f0 (1/Hz) and ln Q
struct Curve {
  Complex value;
  Complex by_frequency;
  Complex by_log_quality;
};

// u = f/f0, H = 1 / (1 - u^2 + j u/Q); dH/df0 = -H^2 (2 u^2 - j u/Q) / f0, dH/dlnQ = H^2 j u/Q
Curve CurveAt(double frequency_hz, double f0_hz, double quality) {
  const double u = frequency_hz / f0_hz;
  const Complex damping(0, u / quality);
  const Complex inverse = 1.0 / (1 - u * u + damping);
  return {inverse, -inverse * inverse * (2 * u * u - damping) / f0_hz, inverse * inverse * damping};
}

// two rows, real and imaginary part; parameters: gain real, gain imaginary, f0, ln Q
void FillComplex(const Point& point, const VectorXd& at, Index row, Linear& linear) {
  const Curve curve = CurveAt(point.frequency_hz, at[2], std::exp(at[3]));
  const Complex gain(at[0], at[1]);
  const Complex residual = point.weight * (point.value - gain * curve.value);
  linear.residuals[row] = residual.real();
  linear.residuals[row + 1] = residual.imag();
  const Complex columns[] = {curve.value, Complex(0, 1) * curve.value, gain * curve.by_frequency,
                             gain * curve.by_log_quality};
  for (Index k = 0; k < 4; ++k) {
    linear.jacobian(row, k) = point.weight * columns[k].real();
    linear.jacobian(row + 1, k) = point.weight * columns[k].imag();
  }
}

// one row; parameters: gain, f0, ln Q; d|H| = Re(conj(H) dH) / |H|
void FillMagnitude(const Point& point, const VectorXd& at, Index row, Linear& linear) {
  const Curve curve = CurveAt(point.frequency_hz, at[1], std::exp(at[2]));
  const double magnitude = std::abs(curve.value);
  const Complex direction = std::conj(curve.value) / magnitude;
  linear.residuals[row] = point.weight * (point.value.real() - at[0] * magnitude);
  linear.jacobian(row, 0) = point.weight * magnitude;
  linear.jacobian(row, 1) = point.weight * at[0] * (direction * curve.by_frequency).real();
  linear.jacobian(row, 2) = point.weight * at[0] * (direction * curve.by_log_quality).real();
}

Linear Linearise(const Problem& problem, const VectorXd& at) {
  Linear linear{VectorXd(problem.rows()), MatrixXd(problem.rows(), problem.parameters())};
  Index row = 0;
  for (const Point& point : problem.points) {
    if (problem.magnitudes) {
      FillMagnitude(point, at, row, linear);
      row += 1;
    } else {
      FillComplex(point, at, row, linear);
      row += 2;
    }
  }
  return linear;
}

// start: f0 at `top`, Q from the half-power width (multiplied by `widening`), the gain from both
VectorXd StartAt(const Problem& problem, const Point& top, double widening) {
  const double half_power = std::abs(top.value) / std::numbers::sqrt2;
  double nearest_hz = top.frequency_hz;  // distance to a point below half the power
  for (const Point& point : problem.points) {
    if (std::abs(point.value) > half_power) continue;
    nearest_hz = std::min(nearest_hz, std::abs(point.frequency_hz - top.frequency_hz));
  }
  // Q = f0 / bandwidth, the bandwidth taken as twice the distance to the nearest half-power point
  const double quality = top.frequency_hz / std::max(2 * nearest_hz, 1e-6) / widening;
  VectorXd start(problem.parameters());
  // at resonance H = gain Q / j
  const Complex gain = top.value * Complex(0, 1) / quality;
  if (problem.magnitudes) {
    start << std::abs(gain), top.frequency_hz, std::log(quality);
  } else {
    start << gain.real(), gain.imag(), top.frequency_hz, std::log(quality);
  }
  return start;
}

// weighted square sum of the residual
double SquareSum(const Problem& problem, const VectorXd& at) {
  const Index f0 = at.size() - 2;
  double sum = 0;
  for (const Point& point : problem.points) {
    const Complex curve = CurveAt(point.frequency_hz, at[f0], std::exp(at[f0 + 1])).value;
    const Complex left = problem.magnitudes ? point.value - at[0] * std::abs(curve)
                                            : point.value - Complex(at[0], at[1]) * curve;
    sum += point.weight * point.weight * std::norm(left);
  }
  return sum;
}

// the highest points first, kMostTops of them
std::vector<Point> Highest(std::vector<Point> points) {
  std::ranges::sort(points, std::ranges::greater{},
                    [](const Point& point) { return std::abs(point.value); });
  points.resize(std::min(points.size(), kMostTops));
  return points;
}

// The start with the least residual, of one at each of the highest points: outside of the drive's
// frequencies a ratio of noise to almost no drive may exceed the resonance, but has little weight.
// Nothing where no start gives a finite residual.
std::optional<VectorXd> BestStart(const Problem& problem, std::span<const Point> highest,
                                  double widening) {
  std::optional<VectorXd> best;
  double least = std::numeric_limits<double>::infinity();
  for (const Point& top : highest) {
    VectorXd start = StartAt(problem, top, widening);
    const double left = SquareSum(problem, start);
    if (!start.allFinite() || !(left < least)) continue;
    least = left;
    best = std::move(start);
  }
  return best;
}

// Levenberg-Marquardt steps, damped by the columns' own lengths; whether they converged
bool Minimise(const Problem& problem, VectorXd& at, Linear& linear) {
  double damping = 1e-3;
  linear = Linearise(problem, at);
  for (int step = 0; step < kMostSteps && damping < kLargestDamping; ++step) {
    MatrixXd normal = linear.jacobian.transpose() * linear.jacobian;
    const VectorXd right = linear.jacobian.transpose() * linear.residuals;
    normal.diagonal() *= 1 + damping;
    const VectorXd change = normal.ldlt().solve(right);
    const VectorXd moved = at + change;
    // a step to a negative frequency, or one that is not finite, is repeated with more damping
    const Index f0 = at.size() - 2;
    if (!moved.allFinite() || !(moved[f0] > 0)) {
      damping *= 10;
      continue;
    }
    Linear next = Linearise(problem, moved);
    const bool better = next.residuals.squaredNorm() <= linear.residuals.squaredNorm();
    // converged where neither f0 nor ln Q moves, also if the step itself is not better
    const bool rests =
        std::abs(change[f0]) <= kAtRest * at[f0] && std::abs(change[f0 + 1]) <= kAtRest;
    if (better) {
      at = moved;
      linear = std::move(next);
    }
    if (rests) return true;
    damping = better ? damping / 10 : damping * 10;
  }
  return damping >= kLargestDamping;  // no step improves: rounding's minimum
}

struct Minimum {
  VectorXd at;
  Linear linear;
};

// the lowest of the minima from three widths: a noisy point beside the peak makes it look narrow
std::optional<Minimum> LowestMinimum(const Problem& problem) {
  std::optional<Minimum> lowest;
  const std::vector<Point> highest = Highest(problem.points);
  for (const double widening : {1.0, 4.0, 16.0}) {
    auto start = BestStart(problem, highest, widening);
    if (!start) continue;
    Minimum found{std::move(*start), {}};
    if (!Minimise(problem, found.at, found.linear)) continue;
    if (lowest && lowest->linear.residuals.squaredNorm() <= found.linear.residuals.squaredNorm()) {
      continue;
    }
    lowest = std::move(found);
  }
  return lowest;
}

// the state of a fit without a result: uncertainties NaN, converged false
Resonance NotDetermined() {
  Resonance none;
  none.frequency_uncertainty_hz = kNotANumber;
  none.quality_factor_uncertainty = kNotANumber;
  return none;
}

Resonance Fit(const Problem& problem) {
  const auto freedom = static_cast<double>(problem.rows() - problem.parameters());
  if (freedom < 1) return NotDetermined();
  const auto lowest = LowestMinimum(problem);
  if (!lowest) return NotDetermined();
  const auto& [at, linear] = *lowest;

  // a resonance outside of the measured frequencies would be extrapolated
  const Index f0 = at.size() - 2;
  const auto [first, last] = std::ranges::minmax_element(
      problem.points, {}, [](const Point& point) { return point.frequency_hz; });
  if (at[f0] < first->frequency_hz || at[f0] > last->frequency_hz) return NotDetermined();
  const double square_sum = linear.residuals.squaredNorm();
  // covariance = (J'J)^-1 residual variance
  const MatrixXd covariance = (linear.jacobian.transpose() * linear.jacobian)
                                  .ldlt()
                                  .solve(MatrixXd::Identity(at.size(), at.size())) *
                              (square_sum / freedom);
  // the residual's share is taken of the equally weighted power of the points
  double weighted_power = 0;
  for (const Point& point : problem.points) weighted_power += std::norm(point.weight * point.value);
  Resonance found;
  found.frequency_hz = at[f0];
  found.frequency_uncertainty_hz = std::sqrt(covariance(f0, f0));
  found.quality_factor = std::exp(at[f0 + 1]);
  // u(Q) = Q u(ln Q)
  found.quality_factor_uncertainty = found.quality_factor * std::sqrt(covariance(f0 + 1, f0 + 1));
  found.gain = problem.magnitudes ? std::abs(at[0]) : std::hypot(at[0], at[1]);
  found.residual_share = std::sqrt(square_sum / weighted_power);
  found.degrees_of_freedom = freedom;
  found.converged = std::isfinite(found.quality_factor_uncertainty);
  return found;
}

double DeviationOf(const ResponsePoint& point) {
  return point.relative_uncertainty * std::abs(point.response);
}

// Each point's deviation: the median of its own and its neighbours', because one from few segments
// is itself an estimate, and a fit weighted by the least of them is biased by its errors. Its
// own where that is far larger: there the drive differs from that beside it.
std::vector<double> Deviations(std::span<const ResponsePoint> points) {
  std::vector<double> deviations;
  deviations.reserve(points.size());
  for (std::size_t k = 0; k < points.size(); ++k) {
    const std::size_t begin = k - std::min(k, kNeighbours);
    const auto near = points.subspan(begin, std::min(k + kNeighbours + 1, points.size()) - begin);
    auto all = Mapped<double>(near, DeviationOf);
    const double own = DeviationOf(points[k]);
    const double median = Median(std::move(all));
    deviations.push_back(own > kUnlike * median ? own : median);
  }
  return deviations;
}

}  // namespace

Resonance FitResonance(std::span<const ResponsePoint> points) {
  const std::vector<double> deviations = Deviations(points);
  Problem problem;
  problem.points.reserve(points.size());
  for (std::size_t k = 0; k < points.size(); ++k) {
    // no point counts as better known than 1e-3 of its value
    const double least = kLeastRelativeUncertainty * std::abs(points[k].response);
    problem.points.push_back(
        {points[k].frequency_hz, points[k].response, 1 / std::max(least, deviations[k])});
  }
  return Fit(problem);
}

Resonance FitResonance(std::span<const SweptPoint> points) {
  Problem problem;
  problem.magnitudes = true;
  problem.points.reserve(points.size());
  for (const SweptPoint& point : points) {
    problem.points.push_back({point.frequency_hz, point.amplitude, 1});
  }
  return Fit(problem);
}

}  // namespace haptometer::dsp
