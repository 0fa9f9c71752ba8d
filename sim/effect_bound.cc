#include "sim/effect_bound.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <optional>

#include "base/circular_functions.h"
#include "base/elementary_functions.h"
#include "sim/effective_scene.h"
#include "sim/linear/complex_equations.h"
#include "sim/linear/driven_step.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/steady_state.h"
#include "sim/piecewise/piecewise_scene.h"
#include "sim/smooth/smooth_system.h"

namespace haptometer::sim {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::infinity();
// sums of modes are rounded by their condition's digits
constexpr double kLeastReciprocalCondition = 1e-10;
constexpr double kRounding = 1 + 1e-5;
// alpha theta from which a coil's heat is bounded no more
constexpr double kMostHeating = 0.2;
// of E(I) by a change of I: theta i changes by theta (1 + 2 (1 + alpha theta)) at most, for the
// coil's temperature follows i^2; 3.5 where alpha theta is a quarter
constexpr double kHeatingSlope = 4;

// What an output may be changed by.
struct Changes {
  double travel_m = 0, current_a = 0, skin_m = 0, case_m = 0, force_n = 0;

  Changes& operator+=(const Changes& other) {
    travel_m += other.travel_m;
    current_a += other.current_a;
    skin_m += other.skin_m;
    case_m += other.case_m;
    force_n += other.force_n;
    return *this;
  }
  friend Changes operator*(double factor, Changes one) {
    for (double* change : {&one.travel_m, &one.current_a, &one.skin_m, &one.case_m, &one.force_n}) {
      *change *= factor;
    }
    return one;
  }
};

// The modes of a linear scene as bounds of what comes in at one place and out at others.
class ModalBounds {
 public:
  ModalBounds(const LinearModel& model, const Scene& scene, double length_s)
      : model_(model), length_s_(length_s), case_moves_(!scene.grip.holds) {
    // a case that is held stays where it is: two modes of its own, which nothing excites
    Eigen::MatrixXd a = model.a;
    if (!case_moves_) {
      const double apart_per_s = a.norm();
      a(LinearModel::kCase, LinearModel::kCase) = -apart_per_s;
      a(LinearModel::kCaseVelocity, LinearModel::kCaseVelocity) = -2 * apart_per_s;
    }
    // in balanced units, x = D y
    const BalancedMatrix balanced = Balance(a);
    const Eigen::EigenSolver<Eigen::MatrixXd> solver(balanced.matrix);
    poles_ = solver.eigenvalues();
    modes_ = balanced.scale.asDiagonal() * solver.eigenvectors();
    scale_ = balanced.scale;
    equations_.emplace(solver.eigenvectors());
    const Eigen::Index n = model.states();
    const auto unit = [n](Eigen::Index place) { return Eigen::RowVectorXd::Unit(n, place); };
    travel_ = unit(LinearModel::kMover) - unit(LinearModel::kCase);
    force_ = scene.skin.stiffness_n_per_m * unit(model.skin()) +
             scene.skin.damping_n_s_per_m * unit(model.skin_velocity());
  }

  bool IsKnown() const { return equations_->ReciprocalCondition() > kLeastReciprocalCondition; }

  // under an input through `column` of magnitude 1 at most
  Changes UnderInput(const Eigen::VectorXd& column) const {
    return Through(column, [&](const auto& pole) { return Length(pole); });
  }
  // at any time, of a motion that begins at x and is not driven
  Changes OfFreeMotion(const Eigen::VectorXd& x) const {
    return Through(x, [](const auto& /*pole*/) { return 1.0; });
  }

 private:
  // the integral of |exp(s t) cos(w t + phase)| over the run, p = s + j w, at any phase
  double Length(const std::complex<double>& pole) const {
    const double growth_per_s = pole.real(), w = std::abs(pole.imag());
    if (growth_per_s > 0) return length_s_ * Exp(growth_per_s * length_s_);
    if (growth_per_s == 0) return length_s_;
    const double length_s = Expm1(growth_per_s * length_s_) / growth_per_s;
    if (w == 0) return length_s;
    // in each half period the cosine's magnitude has the integral 2 / w
    const double half_s = std::numbers::pi / w;
    const double halves = std::ceil(length_s_ / half_s);
    return std::min(length_s,
                    2 / w * Expm1(growth_per_s * half_s * halves) / Expm1(growth_per_s * half_s));
  }

  template <typename Weight>
  Changes Through(const Eigen::VectorXd& x, Weight weight) const {
    // how much of each mode x excites, and for how long
    Eigen::VectorXd parts = Magnitudes(equations_->Solve(x.cwiseQuotient(scale_)));
    for (Eigen::Index k = 0; k < parts.size(); ++k) {
      // a mode that is not excited lasts for no time
      if (parts(k) != 0) parts(k) *= kRounding * weight(poles_(k));
    }
    const auto bound = [&](const Eigen::RowVectorXd& row) {
      return Magnitudes(row * modes_).row(0).dot(parts);
    };
    if (!case_moves_) return {.travel_m = bound(travel_), .current_a = bound(model_.current_row)};
    const Eigen::Index n = model_.states();
    return {.travel_m = bound(travel_),
            .current_a = bound(model_.current_row),
            .skin_m = bound(Eigen::RowVectorXd::Unit(n, model_.skin())),
            .case_m = bound(Eigen::RowVectorXd::Unit(n, LinearModel::kCase)),
            .force_n = bound(force_)};
  }

  const LinearModel& model_;
  double length_s_;
  bool case_moves_;  // else there is no adapter, and it is the skin's contact too
  Eigen::VectorXcd poles_;
  Eigen::MatrixXcd modes_;
  Eigen::VectorXd scale_;
  std::optional<ComplexEquations> equations_;  // of the modes, in balanced units
  Eigen::RowVectorXd travel_, force_;
};

// Bounds for one scene and the run of its base.
class Bounding {
 public:
  Bounding(const Scene& scene, EffectSet on, const SceneRun& base)
      : all_(WithEffects(scene, on)),
        base_scene_(WithEffects(scene, WithoutDisturbances(on))),
        base_(base),
        model_(AssembleModel(base_scene_.scene)),
        // in its steady motion an effect has acted for ever
        length_s_(StartOf(scene) == Start::kSteady ? kUnknown
                                                   : scene.duration_s.value_or(kUnknown)),
        modes_(model_, scene, length_s_) {}

  EffectBounds Find() {
    EffectBounds bounds;
    bounds.fill(kUnknown);
    if (RestsOnStop(all_) || RestsOnStop(base_scene_) || !modes_.IsKnown()) return bounds;
    AddDisturbances();
    // the whole motion first, transient included: it exists, contracts and reaches no limit
    const Changes transient = TransientOfBase();
    const Amplitudes whole = Disturbed(
        {base_.mover_peak_of_run_m + transient.travel_m, LargestCurrent() + transient.current_a});
    if (!(GainOf(whole).determinant > 0) || !IsFree(whole, transient)) return bounds;
    // then what the numbers are of
    const Amplitudes settled = Disturbed({base_.mover_peak_of_run_m, LargestCurrent()});
    const Changes all = ChangeOf(settled);
    for (const Effect effect : kDisturbances) {
      bounds[PlaceOf(effect)] = Relative(effect, LeavingOut(effect, settled), all);
    }
    return bounds;
  }

 private:
  // largest travel and current of a motion
  struct Amplitudes {
    double travel_m = 0;
    double current_a = 0;
  };
  // of travel and current by themselves: 1 - gain as a matrix, by its entries
  struct Gain {
    double travel_by_travel = 0, travel_by_current = 0;
    double current_by_travel = 0, current_by_current = 0;
    double determinant = -1;  // of 1 - gain; above 0 only where the disturbance contracts
  };

  void AddDisturbances() {
    if (all_.smooth.spring) {
      // harder to the side of its sag
      spring_ = all_.smooth.spring;
      spring_->sag_m = std::abs(spring_->sag_m);
      const SmoothSystem system = AssembleSmooth(all_.scene, {}, all_.smooth);
      by_force_ = modes_.UnderInput(system.spring_terms.front().push);
    }
    if (all_.smooth.heating) {
      by_voltage_ = modes_.UnderInput(model_.b);
      by_voltage_.current_a += model_.current_per_volt;
    }
    if (!all_.scene.finger.tones.empty()) by_tremor_ = OfTremor();
  }

  // the tremor's steady motion, and from rest its transient
  Changes OfTremor() const {
    Scene shaken = all_.scene;
    shaken.drive = {.amplitude_v = 0, .frequency_hz = 1};
    const SteadyTones steady = Superpose(shaken);
    if (!(steady.error_estimate < 1)) return {.travel_m = kUnknown};
    // n amplitudes add up to sqrt(n) times the root of their squares' sum at most
    const double largest_over_rms = std::sqrt(2 * static_cast<double>(shaken.finger.tones.size()));
    Changes changes{.travel_m = steady.mover_peak_m,
                    .current_a = largest_over_rms * steady.current_rms_a,
                    .skin_m = largest_over_rms * steady.skin_rms_m,
                    .case_m = largest_over_rms * steady.case_rms_m,
                    .force_n = steady.skin_force_peak_n};
    if (std::isfinite(length_s_)) changes += modes_.OfFreeMotion(steady.start);
    return changes;
  }

  // of a scene that settles, without a duration or in its steady motion: what leads from its start
  // to the steady motion of the base
  Changes TransientOfBase() const {
    if (std::isfinite(length_s_)) return {};
    Scene from = base_scene_.scene;
    from.start = Start::kRest;
    const Eigen::VectorXd begin = PiecewiseStartOf(from).x;
    from.start = Start::kSteady;
    return modes_.OfFreeMotion(begin - PiecewiseStartOf(from).x);
  }

  // of the base: the steady current under a sine and what dies away, or by the largest voltage
  double LargestCurrent() const {
    const Scene& scene = base_scene_.scene;
    const Eigen::VectorXd begin = PiecewiseStartOf(scene).x;
    double steady_a = kUnknown;
    if (scene.drive.kind == DriveKind::kSine) {
      const SteadyState steady = SolveSteadyState(scene);
      // an undamped resonance has no steady motion
      if (!(steady.error_estimate < 1)) return kUnknown;
      Scene from = scene;
      from.start = Start::kSteady;
      steady_a = Abs(steady.current_a) + std::abs(steady.mean_current_a) +
                 modes_.OfFreeMotion(begin - PiecewiseStartOf(from).x).current_a;
    }
    if (!std::isfinite(length_s_)) return steady_a;
    const double driven_a = modes_.UnderInput(model_.b).current_a + model_.current_per_volt;
    return std::min(steady_a,
                    driven_a * LargestVoltageV(scene.drive) + modes_.OfFreeMotion(begin).current_a);
  }

  // the spring's force and its slope at most, up to a travel either way
  double ForceN(double travel_m) const { return spring_ ? spring_->Force(travel_m) : 0; }
  double ForceSlope(double travel_m) const { return spring_ ? spring_->Stiffness(travel_m) : 0; }

  // R0 alpha theta in ohm, theta from theta0 = R0 I^2 min(Rth, T/C), theta = theta0 / (1 - alpha
  // theta0)
  double AddedResistance(double current_a) const {
    if (!all_.smooth.heating) return 0;
    const CoilHeating& heating = *all_.smooth.heating;
    const double R0 = all_.scene.actuator.resistance_ohm, alpha = heating.resistance_per_k;
    const bool begins_cold = StartOf(all_.scene) == Start::kRest && std::isfinite(length_s_);
    const double k_per_w = begins_cold ? std::min(heating.thermal_resistance_k_per_w,
                                                  length_s_ / heating.heat_capacity_j_per_k)
                                       : heating.thermal_resistance_k_per_w;
    const double heated = alpha * R0 * current_a * current_a * k_per_w;
    return heated < kMostHeating ? R0 * heated / (1 - heated) : kUnknown;
  }

  // the least amplitudes that the disturbances do not lift above themselves, by iteration from
  // those without; infinite where there are none
  Amplitudes Disturbed(const Amplitudes& base) const {
    constexpr int kMostSteps = 200;
    constexpr double kSettled = 1e-9;
    Amplitudes disturbed = base;
    for (int k = 0; k < kMostSteps; ++k) {
      const Changes changes = ChangeOf(disturbed);
      const Amplitudes next{base.travel_m + changes.travel_m, base.current_a + changes.current_a};
      const double growth = std::max(next.travel_m - disturbed.travel_m * (1 + kSettled),
                                     next.current_a - disturbed.current_a * (1 + kSettled));
      if (growth <= 0) return {next.travel_m * kRounding, next.current_a * kRounding};
      disturbed = next;
    }
    return {kUnknown, kUnknown};
  }

  // by all disturbances of a motion of these amplitudes
  Changes ChangeOf(const Amplitudes& largest) const {
    Changes changes = by_tremor_;
    changes += ForceN(largest.travel_m) * by_force_;
    changes += AddedResistance(largest.current_a) * largest.current_a * by_voltage_;
    return changes;
  }

  // by a change of travel and current, through the effects that stay
  Gain GainOf(const Amplitudes& largest) const {
    const double n_per_m = ForceSlope(largest.travel_m);
    const double ohm = kHeatingSlope * AddedResistance(largest.current_a);
    Gain gain{.travel_by_travel = by_force_.travel_m * n_per_m,
              .travel_by_current = by_voltage_.travel_m * ohm,
              .current_by_travel = by_force_.current_a * n_per_m,
              .current_by_current = by_voltage_.current_a * ohm};
    const double travel = 1 - gain.travel_by_travel, current = 1 - gain.current_by_current;
    if (travel > 0 && current > 0) {
      gain.determinant = travel * current - gain.travel_by_current * gain.current_by_travel;
    }
    return gain;
  }

  // what leaving one effect out changes while the others stay
  Changes LeavingOut(Effect effect, const Amplitudes& largest) const {
    Changes own = by_tremor_;
    const double added_ohm = AddedResistance(largest.current_a);
    if (effect == Effect::kStiffening) own = ForceN(largest.travel_m) * by_force_;
    if (effect == Effect::kCoilHeating) own = added_ohm * largest.current_a * by_voltage_;
    // (1 - gain)^-1 of travel and current, which act back on all
    const Gain gain = GainOf(largest);
    const double travel_m =
        ((1 - gain.current_by_current) * own.travel_m + gain.travel_by_current * own.current_a) /
        gain.determinant;
    const double current_a =
        (gain.current_by_travel * own.travel_m + (1 - gain.travel_by_travel) * own.current_a) /
        gain.determinant;
    own += ForceSlope(largest.travel_m) * travel_m * by_force_;
    own += kHeatingSlope * added_ohm * current_a * by_voltage_;
    return own;
  }

  // whether the disturbed motion stays clear of stops and keeps contact
  bool IsFree(const Amplitudes& whole, const Changes& transient) const {
    for (const EffectiveScene* scene : {&all_, &base_scene_}) {
      const auto& [stops, loss] = scene->piecewise;
      if (stops && !(whole.travel_m < std::min(stops->gap_up_m, stops->gap_down_m))) return false;
      const double least_n = base_.skin_force_least_n - transient.force_n - ChangeOf(whole).force_n;
      if (loss && !(loss->preload_n + least_n > 0)) return false;
    }
    return std::isfinite(whole.travel_m) && std::isfinite(whole.current_a);
  }

  // speed of a finger that moves, at most
  double FingerSpeed() const {
    double m_per_s = 0;
    for (const Tone& tone : all_.scene.finger.tones) {
      m_per_s += 2 * std::numbers::pi * tone.frequency_hz * std::abs(tone.amplitude);
    }
    return m_per_s;
  }

  // of the power: |v| di of the source, and of a finger what its force changes by; of the finger
  // itself all of its force
  double PowerChange(Effect effect, const Changes& change) const {
    const double volt = LargestVoltageV(base_scene_.scene.drive);
    const double driven_n = modes_.UnderInput(model_.b).force_n * volt;
    const double force_n = change.force_n + (effect == Effect::kTremor ? driven_n : 0);
    return volt * change.current_a + FingerSpeed() * force_n;
  }

  // of one effect, over the numbers of the base less what all effects together may take from them
  double Relative(Effect effect, const Changes& change, const Changes& all) const {
    const auto part = [](double changed, double by_all, double value) {
      if (changed == 0) return 0.0;
      return value > by_all ? changed / (value - by_all) : kUnknown;
    };
    return std::max({part(change.skin_m, all.skin_m, base_.skin_rms_m),
                     part(change.case_m, all.case_m, base_.case_rms_m),
                     part(change.travel_m, all.travel_m, base_.mover_peak_m),
                     part(change.current_a, all.current_a, base_.current_rms_a),
                     part(PowerChange(effect, change), PowerChange(Effect::kTremor, all),
                          std::abs(base_.power_w))});
  }

  EffectiveScene all_, base_scene_;
  const SceneRun& base_;
  LinearModel model_;
  double length_s_;
  ModalBounds modes_;
  std::optional<StiffeningSpring> spring_;
  Changes by_force_, by_voltage_, by_tremor_;
};

}  // namespace

EffectSet WithoutDisturbances(EffectSet on) {
  for (const Effect effect : kDisturbances) on.reset(PlaceOf(effect));
  return on;
}

EffectBounds BoundEffects(const Scene& scene, EffectSet on, const SceneRun& base) {
  return Bounding(scene, on, base).Find();
}

}  // namespace haptometer::sim
