#include "dsp/readings/interpolation.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

namespace haptometer::dsp {
namespace {

// samples that a coefficient of the model is fitted to, at least
constexpr std::size_t kSamplesPerCoefficient = 3;
// of the samples' variance: what is added to it, as white noise would be, so that a model of tones
// without noise has a solution; 1e-5 of the RMS is the least error that is stated
constexpr double kAddedVariance = 1e-10;

// samples about their mean; missing ones are 0
struct Centred {
  Eigen::VectorXd values;
  std::vector<bool> missing;
};

// [begin, end) of samples without a missing one
using Run = std::pair<std::size_t, std::size_t>;

// the mean first of deviations from one sample, so that the distance costs no digits
std::optional<Centred> Centre(std::span<const double> samples) {
  Centred centred{.values = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(samples.size())),
                  .missing = std::vector<bool>(samples.size())};
  double sum = 0;
  double count = 0;
  const auto first = std::ranges::find_if(samples, [](double x) { return !std::isnan(x); });
  if (first == samples.end()) return std::nullopt;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    centred.missing[k] = std::isnan(samples[k]);
    if (centred.missing[k]) continue;
    centred.values[static_cast<Eigen::Index>(k)] = samples[k] - *first;
    sum += samples[k] - *first;
    ++count;
  }
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (!centred.missing[k]) centred.values[static_cast<Eigen::Index>(k)] -= sum / count;
  }
  return centred;
}

std::vector<Run> RunsOf(const std::vector<bool>& missing) {
  std::vector<Run> runs;
  for (std::size_t k = 0; k < missing.size();) {
    const std::size_t begin = k;
    while (k < missing.size() && !missing[k]) ++k;
    if (k > begin) runs.emplace_back(begin, k);
    while (k < missing.size() && missing[k]) ++k;
  }
  return runs;
}

// innovations e[n] = x[n] + a[1] x[n-1] + ... + a[p] x[n-p]
struct Model {
  Eigen::VectorXd coefficients;  // a[0] = 1 ... a[p]
  double variance = 0;           // of innovations
};

// innovations that `runs` give a model of this order
std::size_t CountOf(const std::vector<Run>& runs, std::size_t order) {
  std::size_t count = 0;
  for (const auto& [begin, end] : runs) count += end - begin > order ? end - begin - order : 0;
  return count;
}

// products[i, j] = sum of x[n - i] x[n - j] over all n with p samples before it in the same run;
// each diagonal from its first product, by what enters and what leaves the sum
Eigen::MatrixXd ProductsOf(const Eigen::VectorXd& x, const std::vector<Run>& runs,
                           std::size_t order) {
  const auto p = static_cast<Eigen::Index>(order);
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(p + 1, p + 1);
  for (const auto& [run_begin, run_end] : runs) {
    if (run_end - run_begin <= order) continue;
    const auto begin = static_cast<Eigen::Index>(run_begin) + p;
    const auto end = static_cast<Eigen::Index>(run_end);
    const Eigen::Index count = end - begin;
    for (Eigen::Index lag = 0; lag <= p; ++lag) {
      double product = x.segment(begin, count).dot(x.segment(begin - lag, count));
      products(0, lag) += product;
      for (Eigen::Index i = 1; i + lag <= p; ++i) {
        product += x[begin - i] * x[begin - i - lag] - x[end - i] * x[end - i - lag];
        products(i, i + lag) += product;
      }
    }
  }
  return products.selfadjointView<Eigen::Upper>();
}

std::optional<Model> FitModel(const Centred& centred) {
  const std::vector<Run> runs = RunsOf(centred.missing);
  std::size_t order = kModelOrder;
  while (order >= 2 && CountOf(runs, order) < kSamplesPerCoefficient * order) order /= 2;
  if (order < 2) return std::nullopt;
  const auto p = static_cast<Eigen::Index>(order);
  const auto count = static_cast<double>(CountOf(runs, order));
  Eigen::MatrixXd products = ProductsOf(centred.values, runs, order);
  const double added = kAddedVariance * products.diagonal().mean();
  products.diagonal().array() += added;
  // the normal equations of x[n] = -a[1] x[n-1] - ...
  const Eigen::LLT<Eigen::MatrixXd> factors(products.bottomRightCorner(p, p));
  if (factors.info() != Eigen::Success) return std::nullopt;
  Model model{.coefficients = Eigen::VectorXd::Ones(p + 1)};
  model.coefficients.tail(p) = -factors.solve(products.col(0).tail(p));
  // a' P a is what is left of the squares
  const double rest = model.coefficients.dot(products * model.coefficients);
  model.variance = std::max(rest, added) / (count - static_cast<double>(order));
  return model;
}

// the least-squares problem of the missing samples that innovations [begin, end) hold
struct Problem {
  std::vector<std::size_t> unknown;  // samples
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
  double squares = 0;     // of the innovations with 0 for all unknown samples
  std::size_t count = 0;  // of innovations
};

Problem ProblemOf(const Centred& centred, const Model& model, std::size_t begin, std::size_t end) {
  const auto order = static_cast<std::size_t>(model.coefficients.size()) - 1;
  Problem problem;
  for (std::size_t k = begin - order; k < end; ++k) {
    if (centred.missing[k]) problem.unknown.push_back(k);
  }
  const auto size = static_cast<Eigen::Index>(problem.unknown.size());
  problem.matrix = Eigen::MatrixXd::Zero(size, size);
  problem.right = Eigen::VectorXd::Zero(size);
  for (std::size_t n = begin, first = 0; n < end; ++n) {
    // unknown samples n - order ... n take part, with a[n - k]
    while (first < problem.unknown.size() && problem.unknown[first] + order < n) ++first;
    std::size_t last = first;
    while (last < problem.unknown.size() && problem.unknown[last] <= n) ++last;
    if (first == last) continue;
    double known = 0;
    for (std::size_t i = 0; i <= order; ++i) {
      known += model.coefficients[static_cast<Eigen::Index>(i)] *
               centred.values[static_cast<Eigen::Index>(n - i)];
    }
    const auto weight = [&](std::size_t k) {
      return model.coefficients[static_cast<Eigen::Index>(n - problem.unknown[k])];
    };
    for (std::size_t i = first; i < last; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      problem.right[row] -= weight(i) * known;
      for (std::size_t j = first; j <= i; ++j) {
        problem.matrix(row, static_cast<Eigen::Index>(j)) += weight(i) * weight(j);
      }
    }
    problem.squares += known * known;
    ++problem.count;
  }
  return problem;
}

}  // namespace

std::optional<std::vector<Interpolated>> Interpolate(std::span<const double> samples,
                                                     std::size_t begin, std::size_t end) {
  const auto centred = Centre(samples);
  if (!centred) return std::nullopt;
  const auto model = FitModel(*centred);
  if (!model) return std::nullopt;
  const auto order = static_cast<std::size_t>(model->coefficients.size()) - 1;
  // every innovation that a missing sample of the range takes part in
  Problem problem = ProblemOf(*centred, *model, std::clamp(begin, order, samples.size()),
                              std::clamp(end + order, order, samples.size()));
  const auto size = static_cast<Eigen::Index>(problem.unknown.size());
  problem.matrix.diagonal().array() += kAddedVariance;
  const Eigen::LLT<Eigen::MatrixXd> factors(problem.matrix);
  if (factors.info() != Eigen::Success) return std::nullopt;
  const Eigen::VectorXd filled = factors.solve(problem.right);
  const Eigen::MatrixXd inverse = factors.solve(Eigen::MatrixXd::Identity(size, size));
  // innovations beside the hole may be larger than those of the model, as where a drive begins
  double variance = model->variance;
  if (problem.count > problem.unknown.size()) {
    const double rest = problem.squares - filled.dot(problem.right);
    variance =
        std::max(variance, rest / static_cast<double>(problem.count - problem.unknown.size()));
  }
  // the mean that was taken off is known from any measured sample
  const auto known = std::ranges::find_if(samples, [](double x) { return !std::isnan(x); });
  const double mean = *known - centred->values[known - samples.begin()];
  std::vector<Interpolated> found;
  for (Eigen::Index i = 0; i < size; ++i) {
    const std::size_t sample = problem.unknown[static_cast<std::size_t>(i)];
    if (sample < begin || sample >= end) continue;
    found.push_back(
        {mean + filled[i], variance * inverse(i, i), variance * inverse.row(i).cwiseAbs().sum()});
    if (!std::isfinite(found.back().value) || !std::isfinite(found.back().covariance_sum)) {
      return std::nullopt;
    }
  }
  return found;
}

}  // namespace haptometer::dsp
