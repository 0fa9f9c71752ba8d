#include "fit/residuals.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <ranges>
#include <utility>

#include "base/error.h"
#include "base/median.h"
#include "dsp/spectrum/fft.h"

namespace haptometer::fit {
namespace {

constexpr std::size_t kLeastLines = 8;
constexpr double kOneInAHundred = 2.33;  // deviations of a Gaussian

// up to so many terms, single lines cost less than the plan of a transform
constexpr double kMostTerms = 3e5;

// |X[k]|^2 of one line, by Horner's rule
double PowerOfLine(std::span<const double> values, std::size_t line) {
  const double angle =
      2 * std::numbers::pi * static_cast<double>(line) / static_cast<double>(values.size());
  const double cosine = std::cos(angle);
  const double sine = std::sin(angle);
  double real = 0;
  double imaginary = 0;
  // X[k] = sum of x[n] e^(-j angle n): turn the sum by -angle, add the next value
  for (const double value : std::views::reverse(values)) {
    const double turned = real * cosine + imaginary * sine + value;
    imaginary = imaginary * cosine - real * sine;
    real = turned;
  }
  return real * real + imaginary * imaginary;
}

// mean |X[k]|^2 of the lines from `first` to before `end`, and of all but the line at 0
struct MeanPowers {
  double band = 0;
  double whole = 0;
};

MeanPowers PowersByTransform(const std::vector<double>& values, std::size_t first,
                             std::size_t end) {
  const auto lines = dsp::RealSpectrum(values);
  const auto mean = [](std::span<const std::complex<double>> some) {
    double sum = 0;
    for (const auto& line : some) sum += std::norm(line);
    return sum / static_cast<double>(some.size());
  };
  const std::span all(lines);
  return {mean(all.subspan(first, end - first)), mean(all.subspan(1))};
}

// the band line by line, the whole by Parseval's theorem
MeanPowers PowersByLine(const std::vector<double>& values, std::size_t first, std::size_t end) {
  MeanPowers powers;
  for (std::size_t line = first; line < end; ++line) powers.band += PowerOfLine(values, line);
  powers.band /= static_cast<double>(end - first);
  double squares = 0;
  double sum = 0;
  double alternating = 0;
  double sign = 1;
  for (const double value : values) {
    squares += value * value;
    sum += value;
    alternating += sign * value;
    sign = -sign;
  }
  const auto count = static_cast<double>(values.size());
  const bool is_even = values.size() % 2 == 0;
  const double highest = is_even ? alternating * alternating : 0;  // has no mirror image
  // sum of abs(X[k])^2 for 0 < k <= N/2: (N sum x^2 - X[0]^2 + X[N/2]^2)/2, X[N/2] for even N
  powers.whole = (count * squares - sum * sum + highest) / 2 / std::floor(count / 2);
  return powers;
}

}  // namespace

ResidualDensity DensityAt(const std::vector<double>& residuals, double step_s,
                          double resonance_hz) {
  if (residuals.size() < 2 * kLeastLines) return {};
  // lines are 1/(N dt) apart; the band is 0.5 to 1.5 times the resonance
  const double lines_per_hz = static_cast<double>(residuals.size()) * step_s;
  const auto first = static_cast<std::size_t>(std::ceil(0.5 * resonance_hz * lines_per_hz));
  const auto end = static_cast<std::size_t>(1.5 * resonance_hz * lines_per_hz) + 1;
  // the offset takes the line at 0
  if (first < 1 || end > residuals.size() / 2 + 1 || end < first + kLeastLines) return {};
  const double terms = static_cast<double>(end - first) * static_cast<double>(residuals.size());
  const MeanPowers powers = terms < kMostTerms ? PowersByLine(residuals, first, end)
                                               : PowersByTransform(residuals, first, end);
  if (!(powers.whole > 0)) return {};
  ResidualDensity density;
  density.ratio = powers.band / powers.whole;
  // of a mean of exponentially distributed line powers
  const double deviation = 1 / std::sqrt(static_cast<double>(end - first));
  density.is_coloured = density.ratio > 1 + kOneInAHundred * deviation;
  return density;
}

std::vector<double> OnGrid(std::span<const double> residuals, std::span<const double> times_s,
                           double step_s) {
  const auto place = [&](double time_s) {
    return static_cast<std::size_t>(std::lround((time_s - times_s.front()) / step_s));
  };
  std::vector<double> grid(place(times_s.back()) + 1, 0.0);
  for (std::size_t n = 0; n < residuals.size(); ++n) grid[place(times_s[n])] = residuals[n];
  return grid;
}

ResidualLook LookAtResiduals(const std::vector<double>& residuals, std::size_t points) {
  ResidualLook look;
  std::vector<double> magnitudes;
  magnitudes.reserve(residuals.size());
  double product = 0;
  double square = 0;
  std::size_t farthest = 0;
  for (std::size_t n = 0; n < residuals.size(); ++n) {
    magnitudes.push_back(std::abs(residuals[n]));
    square += residuals[n] * residuals[n];
    if (magnitudes[n] > magnitudes[farthest]) farthest = n;
    // the last of one kind is not followed by the first of the next
    const bool has_next = (n + 1) % points != 0;
    if (has_next) product += residuals[n] * residuals[n + 1];
  }
  if (!(square > 0)) return look;
  // r1 sqrt(n), r1 the correlation of neighbours: 1 standard deviation for white residuals
  look.serial_correlation = product / square * std::sqrt(static_cast<double>(residuals.size()));
  look.farthest = farthest % points;
  const double largest = magnitudes[farthest];
  const double median = UpperMedian(std::move(magnitudes));
  look.farthest_spread = median > 0 ? largest / (kDeviationsPerMedian * median) : 0;
  return look;
}

void DoubtResiduals(const ResidualLook& look, double noise, double farthest_hz,
                    Findings& findings) {
  // limits: see residuals.h
  constexpr double kRounding = 1e-9;
  constexpr double kSurely = 3.5;
  constexpr double kFar = 8;
  if (noise < kRounding) return;
  if (look.serial_correlation > kSurely) findings.Doubt(FindingKind::kResidualsCorrelated);
  if (look.farthest_spread > kFar) {
    findings.Doubt(FindingKind::kOutlyingPoint,
                   {{"frequency_hz", farthest_hz}, {"spread", std::lround(look.farthest_spread)}});
  }
}

namespace {

// Huber's weight min(1, c/abs(t))
double Weight(double t) {
  const double size = std::abs(t);
  return size > kHuberBend ? kHuberBend / size : 1;
}

}  // namespace

double RobustScale(std::span<const double> residuals) {
  std::vector<double> sizes(residuals.size());
  std::ranges::transform(residuals, sizes.begin(), [](double r) { return std::abs(r); });
  return kDeviationsPerMedian * Median(std::move(sizes));
}

std::vector<double> HuberRootWeights(std::span<const double> residuals, double scale) {
  std::vector<double> roots(residuals.size());
  std::ranges::transform(residuals, roots.begin(), [scale](double r) {
    return scale > 0 ? std::sqrt(Weight(r / scale)) : 1;
  });
  return roots;
}

double HuberVariance(std::span<const double> scaled_residuals, std::size_t parameters) {
  double weights = 0;
  double pull_squares = 0;
  double within = 0;
  for (const double t : scaled_residuals) {
    const double weight = Weight(t);
    weights += weight;
    pull_squares += weight * t * weight * t;
    within += std::abs(t) <= kHuberBend ? 1 : 0;
  }
  const auto count = static_cast<double>(scaled_residuals.size());
  const double degrees = std::max(count - static_cast<double>(parameters), 1.0);
  // mean of psi': the share of the residuals within the bend
  const double share = std::max(within, 1.0) / count;
  return weights / count * pull_squares / degrees / (share * share);
}

namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr int kMostRounds = 50;
constexpr double kSettled = 1e-6;
// relative residuals of a record without noise are rounding; below this nothing is weighed
constexpr double kSmallestNoise = 1e-13;
constexpr double kLeastDegrees = 0.5;

// residuals and slopes over their group's noise
LeastSquares Weighted(const LeastSquares& problem, const NoiseGroups& groups,
                      const std::vector<double>& noise) {
  return {problem.residuals, problem.parameters,
          [&](std::span<const double> at, std::span<double> residuals, std::span<double> jacobian) {
            if (!problem.evaluate(at, residuals, jacobian)) return false;
            for (std::size_t n = 0; n < residuals.size(); ++n) {
              const double weight = 1 / noise[groups.group_of[n]];
              residuals[n] *= weight;
              if (jacobian.empty()) continue;
              for (double& slope : jacobian.subspan(n * at.size(), at.size())) slope *= weight;
            }
            return true;
          }};
}

// leverages: diagonal of J (J'J)^+ J', the degrees of freedom that a residual loses
Eigen::VectorXd Leverages(const Jacobian& jacobian, const Identifiability& seen) {
  const auto columns = static_cast<Eigen::Index>(jacobian.columns);
  const Eigen::Map<const RowMajor> slopes(jacobian.values.data(),
                                          static_cast<Eigen::Index>(jacobian.rows), columns);
  const Eigen::Map<const RowMajor> covariance(seen.covariance.data(), columns, columns);
  return (slopes * covariance).cwiseProduct(slopes).rowwise().sum();
}

// RMS of all residuals: the noise that every group begins with
double CommonNoise(const LeastSquares& problem, const std::vector<double>& point) {
  std::vector<double> residuals(problem.residuals);
  HAPTOMETER_CHECK(problem.evaluate(point, residuals, {}), "no residuals at the start of {}",
                   problem.parameters);
  double square = 0;
  for (const double residual : residuals) square += residual * residual;
  return std::sqrt(square / static_cast<double>(residuals.size()));
}

// the groups' noise by the residuals, which are in units of the present one; whether it converged
bool Update(const NoiseGroups& groups, GroupedSolution* solution) {
  const Eigen::VectorXd leverages = Leverages(solution->jacobian, solution->seen);
  std::vector<double> squares(groups.least_noise.size(), 0.0);
  solution->degrees.assign(groups.least_noise.size(), 0.0);
  for (std::size_t n = 0; n < groups.group_of.size(); ++n) {
    const double residual = solution->jacobian.residuals[n];
    squares[groups.group_of[n]] += residual * residual;
    solution->degrees[groups.group_of[n]] += 1 - leverages[static_cast<Eigen::Index>(n)];
  }
  bool settled = true;
  for (std::size_t g = 0; g < squares.size(); ++g) {
    if (solution->degrees[g] < kLeastDegrees) continue;
    // s_g^2 = sum r^2/(n_g - sum h)
    const double factor = std::sqrt(squares[g] / solution->degrees[g]);
    const double next =
        std::max({solution->noise[g] * factor, groups.least_noise[g], kSmallestNoise});
    settled = settled && std::abs(next - solution->noise[g]) <= kSettled * next;
    solution->noise[g] = next;
  }
  return settled;
}

}  // namespace

GroupedSolution SolveGroups(const LeastSquares& problem, const NoiseGroups& groups,
                            const std::vector<bool>& is_free, const std::vector<bool>& is_logarithm,
                            std::vector<double>* point) {
  HAPTOMETER_CHECK(groups.group_of.size() == problem.residuals, "{} residuals, {} groups",
                   problem.residuals, groups.group_of.size());
  GroupedSolution solution;
  const double common = std::max(CommonNoise(problem, *point), kSmallestNoise);
  solution.noise.assign(groups.least_noise.size(), common);
  for (int round = 0; round < kMostRounds; ++round) {
    const LeastSquares weighted = Weighted(problem, groups, solution.noise);
    solution.solver = Minimise(weighted, is_free, point);
    solution.jacobian = Linearise(weighted, *point);
    solution.seen = FindIdentifiability(solution.jacobian, is_free, is_logarithm);
    if (Update(groups, &solution)) break;
  }
  return solution;
}

}  // namespace haptometer::fit
