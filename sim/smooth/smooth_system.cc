#include "sim/smooth/smooth_system.h"

#include "base/error.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/scene_mode.h"

namespace haptometer::sim {
namespace {

// added to Kv to find where the spring acts; large, so that differences keep their digits
constexpr double kProbe = 0x1p40;  // N/m

Eigen::RowVectorXd DeflectionOf(const Mode& mode) {
  if (mode.positions.size() > 0) {
    return mode.positions.row(LinearModel::kMover) - mode.positions.row(LinearModel::kCase);
  }
  const Eigen::Index n = mode.a.rows();
  return Eigen::RowVectorXd::Unit(n, LinearModel::kMover) -
         Eigen::RowVectorXd::Unit(n, LinearModel::kCase);
}

// out of `after` - `before` = -push row, both affine in Kv
SpringTerms TermsOf(const Mode& before, const Mode& after) {
  SpringTerms terms{.deflection = DeflectionOf(before), .push = {}};
  // the row's pseudo-inverse: the deflection of 1 m
  const Eigen::VectorXd row = terms.deflection.transpose() / terms.deflection.squaredNorm();
  terms.push = (before.a - after.a) / kProbe * row;
  terms.guard_pulls.reserve(before.guards.size());
  for (std::size_t k = 0; k < before.guards.size(); ++k) {
    const Guard &guard = before.guards[k], &stiffer = after.guards[k];
    Eigen::RowVectorXd pull = (guard.row - stiffer.row) / kProbe;
    // where d rests, the spring's share is a constant, that of the last state, which is 1
    pull(pull.size() - 1) += (guard.offset - stiffer.offset) / kProbe;
    terms.guard_pulls.push_back(pull.dot(row.transpose()));
    // only where d does not change may a guard depend on the spring
    const bool rests = (terms.deflection * before.a).isZero(0);
    HAPTOMETER_CHECK(rests || terms.guard_pulls.back() == 0, "guard {} feels the spring", k);
  }
  return terms;
}

}  // namespace

SmoothSystem AssembleSmooth(const Scene& scene, const PiecewiseEffects& piecewise,
                            const SmoothEffects& smooth) {
  SmoothSystem system{.linear = AssemblePiecewise(scene, piecewise),
                      .spring = smooth.spring,
                      .heating = smooth.heating,
                      .resistance_ohm = scene.actuator.resistance_ohm,
                      .coil_element = static_cast<std::size_t>(SceneElement::kCoil),
                      .source_element = static_cast<std::size_t>(SceneElement::kSource)};
  if (!smooth.spring) return system;
  Scene stiffer = scene;
  stiffer.actuator.stiffness_n_per_m += kProbe;
  const PiecewiseLinearSystem probed = AssemblePiecewise(stiffer, piecewise);
  system.spring_terms.reserve(probed.modes.size());
  for (std::size_t k = 0; k < probed.modes.size(); ++k) {
    system.spring_terms.push_back(TermsOf(system.linear.modes[k], probed.modes[k]));
  }
  return system;
}

}  // namespace haptometer::sim
