#include "fit/residuals.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <ranges>
#include <utility>

#include "base/error.h"
#include "base/median.h"
#include "dsp/readings/digitisation.h"
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
// third order of the noises' uncertainty, see SolveGroups
constexpr double kThirdOrder = 6;

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

// C A_g of each group: the shares of the parameters that it decides
std::vector<Eigen::MatrixXd> SharesOf(const NoiseGroups& groups, const GroupedSolution& solution) {
  const auto columns = static_cast<Eigen::Index>(solution.jacobian.columns);
  const Eigen::Map<const RowMajor> slopes(
      solution.jacobian.values.data(), static_cast<Eigen::Index>(solution.jacobian.rows), columns);
  const Eigen::Map<const RowMajor> covariance(solution.seen.covariance.data(), columns, columns);
  std::vector<Eigen::MatrixXd> shares(groups.least_noise.size(),
                                      Eigen::MatrixXd::Zero(columns, columns));
  for (std::size_t n = 0; n < groups.group_of.size(); ++n) {
    const auto row = slopes.row(static_cast<Eigen::Index>(n));
    shares[groups.group_of[n]] += row.transpose() * row;
  }
  for (auto& share : shares) share = covariance * share;
  return shares;
}

// W; a group without degrees of freedom has no estimate that could be uncertain
Eigen::MatrixXd NoiseCovariance(const NoiseGroups& groups, const GroupedSolution& solution,
                                const std::vector<Eigen::MatrixXd>& shares) {
  const auto size = std::ssize(shares);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t n = 0; n < groups.group_of.size(); ++n) {
    const auto g = static_cast<Eigen::Index>(groups.group_of[n]);
    information(g, g) += 0.5;
  }
  std::vector<Eigen::Index> estimated;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (solution.degrees[i] >= kLeastDegrees) estimated.push_back(row);
    information(row, row) -= shares[i].trace();
    for (std::size_t j = 0; j < shares.size(); ++j) {
      information(row, static_cast<Eigen::Index>(j)) += (shares[i] * shares[j]).trace() / 2;
    }
  }
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(size, size);
  const Eigen::MatrixXd known = information(estimated, estimated);
  const Eigen::MatrixXd inverse = known.inverse();
  covariance(estimated, estimated) = inverse;
  return covariance;
}

// what the noises' uncertainty adds to the covariance, and what the degrees of freedom follow from
void AddNoiseUncertainty(const NoiseGroups& groups, GroupedSolution* solution) {
  const auto shares = SharesOf(groups, *solution);
  const Eigen::MatrixXd noise_covariance = NoiseCovariance(groups, *solution, shares);
  solution->noise_covariance.assign(noise_covariance.data(),
                                    noise_covariance.data() + noise_covariance.size());
  solution->type_a = solution->seen;
  const auto columns = static_cast<Eigen::Index>(solution->seen.columns);
  const Eigen::Map<const RowMajor> covariance(solution->seen.covariance.data(), columns, columns);
  Eigen::Map<RowMajor> type_a(solution->type_a.covariance.data(), columns, columns);
  const auto scale = [&](std::size_t g) {
    return std::sqrt(1 + kThirdOrder / std::max(solution->degrees[g], kLeastDegrees));
  };
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const RowMajor part = shares[i] * covariance;
    solution->parts.emplace_back(part.data(), part.data() + part.size());
    for (std::size_t j = 0; j < shares.size(); ++j) {
      // 2 L; one group decides all by itself: 0
      const Eigen::MatrixXd both =
          (i == j ? part : RowMajor::Zero(columns, columns)) - shares[i] * shares[j] * covariance;
      const double weight =
          noise_covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      if (shares.size() > 1) type_a += 2 * weight * scale(i) * scale(j) * both;
    }
  }
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
  AddNoiseUncertainty(groups, &solution);
  return solution;
}

double DegreesOf(const GroupedSolution& solution, const std::vector<double>& weights) {
  const auto columns = static_cast<Eigen::Index>(solution.seen.columns);
  const auto groups = std::ssize(solution.parts);
  const Eigen::Map<const Eigen::VectorXd> of(weights.data(), columns);
  Eigen::VectorXd parts(groups);
  for (Eigen::Index g = 0; g < groups; ++g) {
    const auto& part = solution.parts[static_cast<std::size_t>(g)];
    parts[g] = of.dot(Eigen::Map<const RowMajor>(part.data(), columns, columns) * of);
  }
  const Eigen::Map<const RowMajor> covariance(solution.noise_covariance.data(), groups, groups);
  const double all = std::accumulate(solution.degrees.begin(), solution.degrees.end(), 0.0);
  const double effective = 2 * std::pow(parts.sum(), 2) / parts.dot(covariance * parts);
  // not a number where nothing is fitted
  return effective < all ? std::max(effective, 1.0) : std::max(all, 1.0);
}

std::vector<std::vector<double>> RoundingResponses(const GroupedSolution& solution,
                                                   const NoiseGroups& groups,
                                                   const TabulatedValues& tabulated) {
  const auto& [values, slopes, first] = tabulated;
  const double step = dsp::StepOf(values);
  std::vector<std::vector<double>> responses;
  if (step == 0) return responses;
  std::vector<std::size_t> places(values.size());
  std::iota(places.begin(), places.end(), std::size_t{0});
  std::ranges::sort(places, {}, [&values](std::size_t n) { return values[n]; });
  const auto differs = [&](std::size_t a, std::size_t b) {
    return std::abs(values[b] - values[a]) > step / 2;
  };
  for (auto begin = places.begin(); begin != places.end();) {
    auto end = std::next(begin);
    while (end != places.end() && !differs(*std::prev(end), *end)) ++end;
    const double common = step * std::sqrt((1 - 1 / static_cast<double>(end - begin)) / 12);
    if (common == 0) {
      begin = end;
      continue;
    }
    std::vector<double> change(solution.jacobian.rows, 0.0);
    for (; begin != end; ++begin) {
      // noise in the values' unit ahead of the rounding, which is part of the residuals
      const double noise = solution.noise[groups.group_of[first + *begin]];
      const double before = std::max(std::pow(noise / slopes[*begin] / step, 2) - 1.0 / 12, 0.0);
      const double remains = std::exp(-2 * std::numbers::pi * std::numbers::pi * before);
      change[first + *begin] = common * remains * slopes[*begin] / noise;
    }
    responses.push_back(Response(solution.seen, solution.jacobian, change));
  }
  return responses;
}

double CovarianceBy(const std::vector<std::vector<double>>& responses,
                    const std::vector<double>& first, const std::vector<double>& second) {
  double sum = 0;
  for (const auto& response : responses) {
    const auto along = [&response](const std::vector<double>& weights) {
      return std::inner_product(weights.begin(), weights.end(), response.begin(), 0.0);
    };
    sum += along(first) * along(second);
  }
  return sum;
}

}  // namespace haptometer::fit
