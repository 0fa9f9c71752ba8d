#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "dsp/statistics/distributions.h"
#include "tools/compare/compare.h"

namespace haptometer::tools {
namespace {

// directions of V below this share of its largest are not determined
constexpr double kLeastDirection = 1e-12;
// how far an input is changed in a search, in its standard uncertainties: near, and where the
// tangent points farther, so far
constexpr double kLeastReach = 10, kNearReach = 1000, kMostReach = 1e6;
// share of an input's variance that the measurement explains at least, where it depends on it
constexpr double kLeastInfluence = 1e-12;

// the inverse of a symmetric matrix in the scale of its diagonal
Eigen::MatrixXd InverseOf(const Eigen::MatrixXd& v) {
  const Eigen::VectorXd scale = v.diagonal().cwiseSqrt().cwiseInverse();
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
  solver.setThreshold(kLeastDirection);
  solver.compute(scale.asDiagonal() * v * scale.asDiagonal());
  return scale.asDiagonal() * solver.pseudoInverse() * scale.asDiagonal();
}

// inputs by falling |pull|, each with those that cannot be told apart from it
std::vector<std::vector<std::size_t>> SetsOf(const Agreement& agreement) {
  std::vector<std::size_t> left;
  for (Eigen::Index j = 0; j < agreement.pull.size(); ++j) {
    if (std::isfinite(agreement.pull(j))) left.push_back(static_cast<std::size_t>(j));
  }
  // pulls that differ by rounding alone leave the inputs in their order
  const auto order = [&](std::size_t j) {
    const double pull = std::abs(agreement.pull(static_cast<Eigen::Index>(j)));
    return std::pair(-std::round(pull * 1e6), j);
  };
  std::ranges::sort(left, {}, order);
  std::vector<std::vector<std::size_t>> sets;
  for (const std::size_t j : left) {
    const auto is_like = [&](const std::vector<std::size_t>& set) {
      const auto first = static_cast<Eigen::Index>(set.front());
      return std::abs(agreement.correlation(first, static_cast<Eigen::Index>(j))) > kToldApart;
    };
    const auto own = std::ranges::find_if(sets, is_like);
    (own == sets.end() ? sets.emplace_back() : *own).push_back(j);
  }
  return sets;
}

// columns of the factor along which a compared quantity is not linear, as inputs
std::vector<std::size_t> CurvedInputs(const ComparedScene& scene, const Propagation& propagation,
                                      const std::vector<ComparedQuantity>& quantities) {
  std::vector<std::size_t> curved;
  for (Eigen::Index k = 0; k < propagation.changes.cols(); ++k) {
    const bool is_curved = std::ranges::any_of(quantities, [&](const ComparedQuantity& one) {
      const double second_order = propagation.curvature(static_cast<Eigen::Index>(one.quantity), k);
      return std::abs(second_order) > kMostCurvature * one.deviation_uncertainty;
    });
    if (is_curved) curved.push_back(scene.InputOf(k));
  }
  return curved;
}

// of a function with perhaps several minima: where it is least between -reach and reach, of the
// places that were tried
double LeastOf(const std::function<double(double z)>& f, double reach) {
  constexpr double kGolden = 0.6180339887498949;
  constexpr int kSteps = 20;
  constexpr double kPrecision = 1e-5;  // of a standard uncertainty
  const double step = reach / kSteps;
  double best = 0, least = f(0);
  const auto at = [&](double z) {
    const double value = f(z);
    if (value < least) {
      least = value;
      best = z;
    }
    return value;
  };
  for (int k = -kSteps; k <= kSteps; ++k) at(k * step);
  double low = best - step, high = best + step;
  while (high - low > kPrecision) {
    const double one = high - kGolden * (high - low), other = low + kGolden * (high - low);
    if (at(one) < at(other)) {
      high = other;
    } else {
      low = one;
    }
  }
  return best;
}

// where f is least, near or as far as the tangent's minimum
double LeastNearAndFar(const std::function<double(double z)>& f, double tangent) {
  const double reach = std::max(1.5 * std::abs(tangent), kLeastReach);
  const double near = LeastOf(f, std::min(reach, kNearReach));
  if (reach <= kNearReach) return near;
  const double far = LeastOf(f, std::min(reach, kMostReach));
  return f(far) < f(near) ? far : near;
}

}  // namespace

Agreement Agree(const Eigen::VectorXd& deviation, const Eigen::VectorXd& own,
                const Eigen::MatrixXd& changes, const Eigen::MatrixXd& factor) {
  // V = T T^T + diag(own), S C = T F^T
  Eigen::MatrixXd v = changes * changes.transpose();
  v.diagonal() += own;
  const Eigen::MatrixXd inverse = InverseOf(v);
  const Eigen::MatrixXd sc = changes * factor.transpose();
  const Eigen::MatrixXd p = sc.transpose() * inverse * sc;
  Agreement agreement{.variance = v.diagonal(),
                      .adjustment = sc.transpose() * inverse * deviation,
                      .pull = {},
                      .explained = p.diagonal(),
                      .correlation = {},
                      .weight = inverse,
                      .chi_squared = deviation.dot(inverse * deviation)};
  // 1 / sqrt(P_jj); NaN where the measurement does not depend on the input
  const Eigen::VectorXd scale = p.diagonal().unaryExpr([](double variance) {
    return variance > kLeastInfluence ? 1 / std::sqrt(variance)
                                      : std::numeric_limits<double>::quiet_NaN();
  });
  agreement.pull = agreement.adjustment.cwiseProduct(scale);
  agreement.correlation = scale.asDiagonal() * p * scale.asDiagonal();
  return agreement;
}

bool ComparisonResult::Differs() const {
  return std::ranges::any_of(quantities, &ComparedQuantity::Differs);
}

bool ComparisonResult::DiffersTogether() const {
  return !quantities.empty() &&
         chi_squared > dsp::ChiSquareQuantile(kTogether, static_cast<double>(quantities.size()));
}

std::vector<ComparedQuantity> ComparedGroup::Of(Compared quantity) const {
  std::vector<ComparedQuantity> found;
  for (const ComparisonResult& result : results) {
    const auto one = std::ranges::find(result.quantities, quantity, &ComparedQuantity::quantity);
    if (one != result.quantities.end()) found.push_back(*one);
  }
  return found;
}

ComparisonResult Compare(const OfCompared<dsp::Estimate>& measured, const ComparedScene& scene,
                         const Propagation& propagation) {
  ComparisonResult result{.target = scene.target()};
  std::vector<Eigen::Index> rows;
  std::vector<double> deviations, own;  // d, and the variances besides the inputs'
  for (std::size_t k = 0; k < kComparedCount; ++k) {
    const auto quantity = static_cast<Compared>(k);
    const auto row = static_cast<Eigen::Index>(k);
    const auto& [simulated, method] = propagation.at[k];
    // a matrix without inputs has no rows to point at
    const Eigen::VectorXd changes =
        scene.inputs().empty() ? Eigen::VectorXd() : propagation.changes.row(row);
    const bool is_simulated = std::isfinite(simulated) && changes.allFinite();
    if (!measured[k] || !is_simulated) {
      if (measured[k]) result.only_measured.push_back(quantity);
      if (is_simulated) result.only_simulated.push_back(quantity);
      continue;
    }
    const double u = std::hypot(std::sqrt(propagation.spread(row, row)), method);
    rows.push_back(row);
    deviations.push_back(DeviationOf(quantity, measured[k]->value, simulated));
    own.push_back(measured[k]->uncertainty * measured[k]->uncertainty + method * method);
    result.quantities.push_back({.quantity = quantity,
                                 .measured = *measured[k],
                                 .simulated = {simulated, u},
                                 .deviation = deviations.back(),
                                 .deviation_uncertainty = std::hypot(u, measured[k]->uncertainty)});
  }
  if (rows.empty()) return result;
  const auto count = static_cast<Eigen::Index>(rows.size());
  const auto d = Eigen::VectorXd::Map(deviations.data(), count);
  const auto variances = Eigen::VectorXd::Map(own.data(), count);
  Eigen::MatrixXd spread = propagation.spread(rows, rows);
  spread.diagonal() += variances;
  result.chi_squared = d.dot(InverseOf(spread) * d);
  result.agreement = Agree(d, variances, propagation.changes(rows, Eigen::all), scene.factor());
  result.sets = SetsOf(result.agreement);
  result.curved = CurvedInputs(scene, propagation, result.quantities);
  return result;
}

void FindCauses(const ComparedScene& scene, const Propagation& propagation,
                ComparisonResult& result) {
  Agreement& agreement = result.agreement;
  // nothing to explain: no score and no finite pull beyond what chance gives
  const bool has_pull = (agreement.pull.array().abs() > kPullOfCause).any();
  if (!result.Differs() && !has_pull) return;
  const Eigen::MatrixXd correlation = scene.factor() * scene.factor().transpose();
  const bool with_rise =
      std::ranges::count(result.quantities, Compared::kRise, &ComparedQuantity::quantity) > 0;
  result.explaining.assign(scene.inputs().size(), std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index j = 0; j < agreement.pull.size(); ++j) {
    if (!std::isfinite(agreement.pull(j))) continue;
    // chi^2 that is left with input j changed by z, and what is correlated with it
    const auto left = [&](double z) {
      const auto changed = scene.At(z * correlation.col(j));
      if (!changed) return HUGE_VAL;
      const auto numbers = SimulatedOf(*changed, scene.path(), with_rise);
      if (!numbers) return HUGE_VAL;
      Eigen::VectorXd d(std::ssize(result.quantities));
      for (Eigen::Index i = 0; i < d.size(); ++i) {
        const ComparedQuantity& one = result.quantities[static_cast<std::size_t>(i)];
        const auto k = static_cast<std::size_t>(one.quantity);
        const double change =
            DeviationOf(one.quantity, (*numbers)[k].value, propagation.at[k].value);
        d(i) = DeviationOf(one.quantity, one.deviation, change);
      }
      const double chi_squared = d.dot(agreement.weight * d);
      return std::isfinite(chi_squared) ? chi_squared : HUGE_VAL;
    };
    // the tangent's change of this input alone lies at pull / sqrt(P_jj)
    const double tangent = agreement.pull(j) / std::sqrt(agreement.explained(j));
    const double z = LeastNearAndFar(left, tangent);
    const auto place = static_cast<std::size_t>(j);
    const bool is_curved = std::abs(z - tangent) > kMostCurvature * std::max(1.0, std::abs(z));
    if (is_curved && !std::ranges::count(result.curved, place)) result.curved.push_back(place);
    const double explained = std::max(0.0, agreement.chi_squared - left(z));
    agreement.pull(j) = std::copysign(std::sqrt(explained), z);
    result.explaining[place] = z;
  }
  result.sets = SetsOf(agreement);
}

}  // namespace haptometer::tools
