#include "sim/piecewise/piecewise_scene.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/scene_mode.h"
#include "sim/linear/steady_state.h"
#include "sim/piecewise/stop_modes.h"

namespace haptometer::sim {
namespace {

// bounces below this part of the travel are over: some hundred times the rounding of a position
constexpr double kRestPart = 1e-13;

// Builds the modes and transitions of one scene.
class Assembly {
 public:
  Assembly(const Scene& scene, const PiecewiseEffects& effects) : scene_(scene), effects_(effects) {
    system_.dissipating_elements.assign(kSceneElements.begin(), kSceneElements.end());
    if (effects.contact_loss) contact_ = AssembleContact(scene, *effects.contact_loss);
    AddBase(contact_ ? contact_->contact : WithConstant(SceneMode(scene)));
    UseLinearSceneWhereFree();
    if (contact_) AddBase(contact_->flight);
    for (std::size_t base = 0; base < modes_.size(); ++base) {
      for (std::size_t k = 0; k < modes_[base].size(); ++k) AddGuards(base, k);
    }
  }

  PiecewiseLinearSystem Take() {
    for (std::vector<StopMode>& base : modes_) {
      for (StopMode& stop : base) system_.modes.push_back(std::move(stop.mode));
    }
    return std::move(system_);
  }

 private:
  struct Place {
    std::size_t base;
    std::size_t stop;
  };

  void AddBase(const Mode& base) {
    modes_.push_back(AssembleStopModes(scene_, effects_.stops.value_or(TravelStops{}), base));
  }

  // mode 0 is the linear scene itself, without the state that is always 1
  void UseLinearSceneWhereFree() {
    StopMode& free = modes_[0][0];
    const Eigen::Index n = free.mode.a.rows() - 1;
    free.mode = SceneMode(scene_);
    free.to = Eigen::MatrixXd::Identity(n, n + 1);
    free.from = Eigen::MatrixXd::Identity(n + 1, n);
    free.shift = Eigen::VectorXd::Unit(n + 1, n);
  }

  StopMode& At(Place place) { return modes_[place.base][place.stop]; }
  [[nodiscard]] std::size_t IndexOf(Place place) const {
    return place.base * modes_[0].size() + place.stop;
  }
  Eigen::Index BaseStates(std::size_t base) { return modes_[base][0].from.rows(); }

  // a transition between two places; `map` takes the base's states of one to those of the other
  std::size_t Link(std::string_view name, Place from, Place to, const Eigen::MatrixXd& map,
                   std::optional<Departure> departure) {
    // map and shift in the coordinates of both stop modes: to (map (from y + shift))
    system_.transitions.push_back({.name = name,
                                   .mode = IndexOf(to),
                                   .map = At(to).to * map * At(from).from,
                                   .shift = At(to).to * map * At(from).shift,
                                   .departure = departure});
    return system_.transitions.size() - 1;
  }

  // `row` is of states whose last is 1; the mode itself may lack that one
  void AddGuard(Place place, Eigen::RowVectorXd row, std::size_t transition,
                const Eigen::RowVectorXd& feed = {}) {
    const Eigen::Index last = row.size() - 1;
    const double offset = row(last);
    row(last) = 0;
    row.conservativeResize(At(place).mode.a.rows());
    At(place).mode.guards.push_back(
        {.row = row, .offset = offset, .transition = transition, .feed = feed});
  }

  // the guards of the free mode: its gaps, up first
  std::size_t GapGuard(int side) const {
    return side < 0 && std::isfinite(effects_.stops->gap_up_m) ? 1 : 0;
  }
  std::size_t StopOf(StopState state, int side) const {
    const auto found = std::ranges::find_if(
        modes_[0], [&](const StopMode& stop) { return stop.state == state && stop.side == side; });
    return static_cast<std::size_t>(found - modes_[0].begin());
  }

  void AddGuards(std::size_t base, std::size_t k) {
    const Place here{base, k};
    switch (At(here).state) {
      case StopState::kFree:
        for (const int side : {1, -1}) AddGapGuard(base, side);
        break;
      case StopState::kResting:
        // at release gap, speed and relative acceleration are zero: the third derivative decides
        AddGuard(here, At(here).guards[0], LinkToFree("release", here, 3), At(here).feed);
        break;
      case StopState::kPressed:
        AddGuard(here, At(here).guards[0], LinkFromPressed(here));
        break;
      case StopState::kLeaving:
        // ends where the pad has recovered, or where it would push again
        AddGuard(here, At(here).guards[0], LinkToFree("stop left", here, 1));
        AddGuard(here, At(here).guards[1],
                 LinkWithin("pressed again", here, StopState::kPressed, 0));
        break;
    }
    if (contact_) AddContactGuard(here);
  }

  std::size_t LinkToFree(std::string_view name, Place here, std::size_t order) {
    return Link(name, here, {here.base, 0}, Same(here.base),
                Departure{.guard = GapGuard(At(here).side), .order = order});
  }
  // to another state of the same stop, one of whose guards begins at zero
  std::size_t LinkWithin(std::string_view name, Place here, StopState state, std::size_t guard) {
    return Link(name, here, {here.base, StopOf(state, At(here).side)}, Same(here.base),
                Departure{.guard = guard, .order = 1});
  }
  // a damped pad stops pushing while still pressed in; an undamped one at its free surface
  std::size_t LinkFromPressed(Place here) {
    if (effects_.stops->damping_n_s_per_m > 0) {
      return LinkWithin("force gone", here, StopState::kLeaving, 1);
    }
    return LinkToFree("stop left", here, 1);
  }
  Eigen::MatrixXd Same(std::size_t base) {
    return Eigen::MatrixXd::Identity(BaseStates(base), BaseStates(base));
  }

  void AddGapGuard(std::size_t base, int side) {
    if (!effects_.stops || std::isinf(GapOn(*effects_.stops, side))) return;
    const std::size_t transition =
        effects_.stops->rigid() ? LinkImpact(base, side) : LinkPress(base, side);
    AddGuard({base, 0}, StopGapRow(*effects_.stops, side, BaseStates(base)), transition);
  }

  std::size_t LinkImpact(std::size_t base, int side) {
    const double e = effects_.stops->restitution;
    const Place free{base, 0};
    // the end of bounces, to which the impact refers
    const std::size_t rest = Link(side > 0 ? "rest up" : "rest down", free,
                                  {base, StopOf(StopState::kResting, side)}, Same(base), {});
    const std::size_t impact =
        Link(side > 0 ? "impact up" : "impact down", free, free,
             ImpactMap(scene_, *effects_.stops, side, BaseStates(base)),
             // after an impact the gap is zero, with e = 0 its rate also
             Departure{.guard = GapGuard(side), .order = e > 0 ? std::size_t{1} : 2});
    system_.transitions[impact].bounce =
        Bounce{.restitution = e,
               .rest_height = kRestPart * RoomFor(*effects_.stops, side),
               .rest_via = rest};
    return impact;
  }

  // m, the size of the travel: half the room between the stops, or the gap to the only one
  static double RoomFor(const TravelStops& stops, int side) {
    const double room_m = stops.gap_up_m + stops.gap_down_m;
    return std::isfinite(room_m) ? room_m / 2 : std::abs(GapOn(stops, side));
  }

  std::size_t LinkPress(std::size_t base, int side) {
    // without damping the force begins at zero
    std::optional<Departure> departure;
    if (!(effects_.stops->damping_n_s_per_m > 0)) departure = Departure{.guard = 0, .order = 1};
    const std::size_t press =
        Link(side > 0 ? "stop up" : "stop down", {base, 0},
             {base, StopOf(StopState::kPressed, side)}, Same(base), departure);
    // the penetration is zero by definition
    system_.transitions[press].map.row(LinearModel::kMover).setZero();
    system_.transitions[press].shift(LinearModel::kMover) = 0;
    return press;
  }

  // the last guard in each mode, at the same place in contact and in flight
  void AddContactGuard(Place here) {
    const std::size_t place = At(here).mode.guards.size();
    const Place there{1 - here.base, here.stop};
    const bool in_contact = here.base == 0;
    std::optional<Departure> departure;
    if (in_contact) departure = Departure{.guard = place, .order = contact_->gap_order};
    if (!in_contact && !contact_->force_at_landing) {
      departure = Departure{.guard = place, .order = 1};
    }
    const std::size_t transition =
        Link(in_contact ? "take-off" : "landing", here, there,
             in_contact ? contact_->take_off : contact_->landing, departure);
    const Eigen::RowVectorXd row = in_contact ? contact_->force_row : contact_->gap_row;
    // the free scene in contact lacks the last state: its guard keeps the base's row
    const bool linear = in_contact && here.stop == 0;
    AddGuard(here, linear ? row : (row * At(here).from).eval(), transition,
             in_contact ? contact_->force_feed : contact_->gap_feed);
  }

  const Scene& scene_;
  const PiecewiseEffects& effects_;
  std::optional<ContactModes> contact_;
  std::vector<std::vector<StopMode>> modes_;  // by base and stop
  PiecewiseLinearSystem system_;
};

}  // namespace

PiecewiseLinearSystem AssemblePiecewise(const Scene& scene, const PiecewiseEffects& effects) {
  return Assembly(scene, effects).Take();
}

void WatchTravelAndForce(const Scene& scene, const PiecewiseEffects& effects,
                         PiecewiseLinearSystem& system) {
  const LinearModel model = AssembleModel(scene);
  const double Ks = scene.skin.stiffness_n_per_m, Bs = scene.skin.damping_n_s_per_m;
  for (std::size_t k = 0; k < system.modes.size(); ++k) {
    Mode& mode = system.modes[k];
    const Eigen::Index n = mode.a.rows();
    const Eigen::MatrixXd positions =
        mode.positions.size() > 0 ? mode.positions : Eigen::MatrixXd::Identity(n, n);
    // the skin's force beyond that at rest, N: Ks (xs - xg) + Bs (vs - vg)
    WatchedNumber force{.row = Eigen::RowVectorXd::Zero(n)};
    // the second half of the modes is in flight: no force, -F0 relative to rest
    if (effects.contact_loss && 2 * k >= system.modes.size()) {
      force.offset = -effects.contact_loss->preload_n;
    } else {
      force.row = Ks * positions.row(model.skin()) + Bs * positions.row(model.skin_velocity());
      if (!scene.finger.tones.empty()) {
        force.feed = -Ks * Eigen::RowVectorXd::Unit(kInputs, kFinger) -
                     Bs * Eigen::RowVectorXd::Unit(kInputs, kFingerRate);
      }
    }
    mode.watched = {{.row = positions.row(LinearModel::kMover) - positions.row(LinearModel::kCase)},
                    std::move(force)};
  }
}

PiecewiseStart PiecewiseStartOf(const Scene& scene) {
  const LinearModel model = AssembleModel(scene);
  if (StartOf(scene) == Start::kRest) return {.x = StatedStart(scene.initial, model)};
  if (scene.drive.kind == DriveKind::kTones) return {.x = SolveSteadyTones(scene).start};
  // the state at phase 0 of the drive, mean + Im(X)
  const SteadyState steady = SolveSteadyState(model, scene.drive, Skin{});
  return {.x = steady.mean + steady.phasors.imag()};
}

}  // namespace haptometer::sim
