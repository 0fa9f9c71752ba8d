#include "sim/piecewise/stop_modes.h"

#include <cmath>
#include <utility>

#include "base/error.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/scene_mode.h"

namespace haptometer::sim {
namespace {

constexpr Eigen::Index kMover = LinearModel::kMover;
constexpr Eigen::Index kMoverVelocity = LinearModel::kMoverVelocity;
constexpr Eigen::Index kCase = LinearModel::kCase;
constexpr Eigen::Index kCaseVelocity = LinearModel::kCaseVelocity;
// where penetration and its rate stand in place of xv and vv
constexpr Eigen::Index kDepth = kMover;
constexpr Eigen::Index kDepthRate = kMoverVelocity;

// 1/m of the relative motion, 1/kg
double InverseMass(const Scene& scene) {
  return 1 / scene.actuator.moving_mass_kg + 1 / CaseSideMass(scene);
}

// y = to z: d = side (xv - xa) - gap in place of xv
Eigen::MatrixXd ToDepth(Eigen::Index n, int side, double gap_m) {
  Eigen::MatrixXd to = Eigen::MatrixXd::Identity(n, n);
  to.row(kDepth).setZero();
  to(kDepth, kMover) = side;
  to(kDepth, kCase) = -side;
  // the last state is the constant 1
  to(kDepth, n - 1) = -gap_m;
  to.row(kDepthRate).setZero();
  to(kDepthRate, kMoverVelocity) = side;
  to(kDepthRate, kCaseVelocity) = -side;
  return to;
}

// inverse of ToDepth: xv = side (d + gap) + xa
Eigen::MatrixXd FromDepth(Eigen::Index n, int side, double gap_m) {
  Eigen::MatrixXd from = Eigen::MatrixXd::Identity(n, n);
  from(kMover, kDepth) = side;
  from(kMover, kCase) = 1;
  from(kMover, n - 1) = side * gap_m;
  from(kMoverVelocity, kDepthRate) = side;
  from(kMoverVelocity, kCaseVelocity) = 1;
  return from;
}

// the base in y, without its guards
Mode InCoordinates(const Mode& base, const Eigen::MatrixXd& to, const Eigen::MatrixXd& from) {
  Mode mode{.name = base.name,
            .a = to * base.a * from,
            .b = to * base.b,
            .positions = base.positions * from,
            .stored_j = FormIn(base.stored_j, from),
            .current_row = base.current_row * from,
            .current_per_volt = base.current_per_volt,
            .finger = base.finger.size() > 0 ? (to * base.finger).eval() : base.finger,
            .finger_force_row = RowIn(base.finger_force_row, from)};
  mode.dissipating.reserve(base.dissipating.size());
  for (const Eigen::MatrixXd& power : base.dissipating) {
    mode.dissipating.push_back(FormIn(power, from));
  }
  return mode;
}

StopMode FreeMode(const Mode& base) {
  const Eigen::Index n = base.a.rows();
  const Eigen::MatrixXd same = Eigen::MatrixXd::Identity(n, n);
  return {.mode = base, .to = same, .from = same, .shift = Eigen::VectorXd::Zero(n)};
}

StopMode DepthMode(const Mode& base, StopState state, int side, double gap_m) {
  const Eigen::Index n = base.a.rows();
  StopMode stop{.mode = {},
                .state = state,
                .side = side,
                .to = ToDepth(n, side, gap_m),
                .from = FromDepth(n, side, gap_m),
                .shift = Eigen::VectorXd::Zero(n)};
  stop.mode = InCoordinates(base, stop.to, stop.from);
  return stop;
}

// F = k d + c d', N
Eigen::RowVectorXd PadForceRow(const TravelStops& stops, Eigen::Index n) {
  return stops.stiffness_n_per_m * Eigen::RowVectorXd::Unit(n, kDepth) +
         stops.damping_n_s_per_m * Eigen::RowVectorXd::Unit(n, kDepthRate);
}

// accelerations per newton of the pad: d'' of the relative motion, xa'' of the case
Eigen::VectorXd PushColumn(const Scene& scene, Eigen::Index n, int side) {
  Eigen::VectorXd push = -InverseMass(scene) * Eigen::VectorXd::Unit(n, kDepthRate);
  push(kCaseVelocity) = side / CaseSideMass(scene);
  return push;
}

StopMode PressedMode(const Scene& scene, const TravelStops& stops, const Mode& base, int side) {
  StopMode stop = DepthMode(base, StopState::kPressed, side, GapOn(stops, side));
  const Eigen::Index n = base.a.rows();
  const Eigen::RowVectorXd force = PadForceRow(stops, n);
  stop.mode.name = side > 0 ? "pressed up" : "pressed down";
  // the pad's force acts on both bodies, stores k d^2 / 2 and dissipates c d'^2
  stop.mode.a += PushColumn(scene, n, side) * force;
  stop.mode.stored_j(kDepth, kDepth) += stops.stiffness_n_per_m / 2;
  Eigen::MatrixXd damper = Eigen::MatrixXd::Zero(n, n);
  damper(kDepthRate, kDepthRate) = stops.damping_n_s_per_m;
  stop.mode.dissipating[static_cast<std::size_t>(SceneElement::kStop)] = damper;
  stop.guards = {force};
  return stop;
}

// the pad does not push: its energy k d^2 / 2 is dissipated at the rate -k d d'
StopMode LeavingMode(const TravelStops& stops, const Mode& base, int side) {
  StopMode stop = DepthMode(base, StopState::kLeaving, side, GapOn(stops, side));
  const Eigen::Index n = base.a.rows();
  stop.mode.name = side > 0 ? "leaving up" : "leaving down";
  stop.mode.stored_j(kDepth, kDepth) += stops.stiffness_n_per_m / 2;
  Eigen::MatrixXd pad = Eigen::MatrixXd::Zero(n, n);
  pad(kDepth, kDepthRate) = pad(kDepthRate, kDepth) = -stops.stiffness_n_per_m / 2;
  stop.mode.dissipating[static_cast<std::size_t>(SceneElement::kStop)] = pad;
  // ends where d falls below 0, or where the pad would push again
  stop.guards = {Eigen::RowVectorXd::Unit(n, kDepth), -PadForceRow(stops, n)};
  return stop;
}

// Both as one body: removing d and d' leaves the centre of gravity and the momentum unchanged.
Eigen::MatrixXd ToOneBody(const Scene& scene, Eigen::Index n, int side, double gap_m) {
  const double Mv = scene.actuator.moving_mass_kg;
  const double part = side * Mv / (Mv + CaseSideMass(scene));
  Eigen::MatrixXd together = Eigen::MatrixXd::Identity(n, n);
  together(kCase, kDepth) = part;
  together(kCaseVelocity, kDepthRate) = part;
  return together * ToDepth(n, side, gap_m);
}

StopMode RestingMode(const Scene& scene, const TravelStops& stops, const Mode& base, int side) {
  StopMode stop = DepthMode(base, StopState::kResting, side, GapOn(stops, side));
  const Eigen::Index n = base.a.rows();
  // the force that keeps d'' = 0, to which a coil without inductance and a finger under the case
  // add at once
  const Eigen::RowVectorXd force = stop.mode.a.row(kDepthRate) / InverseMass(scene);
  const Eigen::RowVectorXd feed = stop.mode.Inputs().row(kDepthRate) / InverseMass(scene);

  // d and d' are zero and are removed; what acts on both moves their centre of gravity
  std::vector<Eigen::Index> kept;
  kept.reserve(static_cast<std::size_t>(n));
  for (Eigen::Index k = kCase; k < n; ++k) kept.push_back(k);
  stop.to = ToOneBody(scene, n, side, GapOn(stops, side))(kept, Eigen::all);
  stop.from = stop.from(Eigen::all, kept).eval();
  stop.mode = InCoordinates(base, stop.to, stop.from);
  stop.mode.name = side > 0 ? "resting up" : "resting down";
  stop.guards = {force(kept).eval()};
  if (!feed.isZero(0)) stop.feed = feed;
  return stop;
}

}  // namespace

double GapOn(const TravelStops& stops, int side) {
  return side > 0 ? stops.gap_up_m : stops.gap_down_m;
}

std::vector<StopMode> AssembleStopModes(const Scene& scene, const TravelStops& stops,
                                        const Mode& base) {
  HAPTOMETER_CHECK(stops.stiffness_n_per_m > 0 && stops.damping_n_s_per_m >= 0, "{} N/m, {} N s/m",
                   stops.stiffness_n_per_m, stops.damping_n_s_per_m);
  HAPTOMETER_CHECK(stops.restitution >= 0 && stops.restitution <= 1, "e = {}", stops.restitution);
  std::vector<StopMode> modes;
  modes.reserve(5);
  modes.push_back(FreeMode(base));
  // one gap may be negative: a preload may hold the mover at a stop before static equilibrium
  HAPTOMETER_CHECK(stops.gap_up_m + stops.gap_down_m > 0, "gaps {}, {} m", stops.gap_up_m,
                   stops.gap_down_m);
  for (const int side : {1, -1}) {
    if (std::isinf(GapOn(stops, side))) continue;
    // a rigid stop has a mode of rest; a compliant one pushes, and a damped one also recovers
    if (stops.rigid()) {
      modes.push_back(RestingMode(scene, stops, base, side));
      continue;
    }
    modes.push_back(PressedMode(scene, stops, base, side));
    if (stops.damping_n_s_per_m > 0) modes.push_back(LeavingMode(stops, base, side));
  }
  return modes;
}

// gap - side (xv - xa), m
Eigen::RowVectorXd StopGapRow(const TravelStops& stops, int side, Eigen::Index states) {
  Eigen::RowVectorXd row = GapOn(stops, side) * Eigen::RowVectorXd::Unit(states, states - 1);
  row(kMover) = -side;
  row(kCase) = side;
  return row;
}

Eigen::MatrixXd ImpactMap(const Scene& scene, const TravelStops& stops, int side,
                          Eigen::Index states) {
  // an impulse (1 + e) m d' between the bodies, m their reduced mass
  Eigen::VectorXd push = Eigen::VectorXd::Zero(states);
  push(kMoverVelocity) = -side / scene.actuator.moving_mass_kg;
  push(kCaseVelocity) = side / CaseSideMass(scene);
  Eigen::RowVectorXd rate = Eigen::RowVectorXd::Zero(states);
  rate(kMoverVelocity) = side;
  rate(kCaseVelocity) = -side;
  return Eigen::MatrixXd::Identity(states, states) +
         (1 + stops.restitution) / InverseMass(scene) * push * rate;
}

namespace {

// the bodies without a skin, under the preload
Mode LooseBodies(const Scene& scene, const LinearModel& model, double preload_n) {
  Scene loose = scene;
  loose.skin = {};
  Mode flight = SceneMode(loose);
  // one more state for the surface of the skin, xp
  if (scene.skin.damping_n_s_per_m > 0) flight = WithConstant(flight);
  flight = WithConstant(flight);
  flight.name = "flight";
  const Eigen::Index one = flight.a.rows() - 1;
  // the preload is a constant force on the contact, F0 / mass in m/s^2
  flight.a(model.skin_velocity(), one) += preload_n / ContactMass(scene);
  // without a skin only the preload remains of the force on the finger
  if (flight.finger.size() > 0) {
    flight.finger.setZero();
    flight.finger_force_row = -preload_n * Eigen::RowVectorXd::Unit(one + 1 + kInputs, one);
  }
  // potential energy of the preload, -F0 xs
  flight.stored_j(model.skin(), one) -= preload_n / 2;
  flight.stored_j(one, model.skin()) -= preload_n / 2;
  return flight;
}

// the skin recovers freely, Bs xp' = -(F0 + Ks xp) from where the finger is; xp is the last state
// but one
void AddLooseSkin(const Scene& scene, double preload_n, Mode& flight) {
  const double Ks = scene.skin.stiffness_n_per_m, Bs = scene.skin.damping_n_s_per_m;
  const Eigen::Index n = flight.a.rows(), xp = n - 2, one = n - 1;
  const Eigen::Index m = flight.stored_j.rows();
  flight.a(xp, xp) = -Ks / Bs;
  flight.a(xp, one) = -preload_n / Bs;
  // the skin's strain is xp - xg: a finger that moves carries the skin along
  Eigen::RowVectorXd sprung = Eigen::RowVectorXd::Unit(m, xp);
  if (m > n) {
    sprung(n + kFinger) = -1;
    flight.finger.row(xp) << Ks / Bs, 1;
  }
  flight.stored_j += Ks / 2 * sprung.transpose() * sprung;
  flight.stored_j(xp, one) += preload_n / 2;
  flight.stored_j(one, xp) += preload_n / 2;
  // its damper dissipates (F0 + Ks (xp - xg))^2 / Bs, W
  const Eigen::RowVectorXd force = Ks * sprung + preload_n * Eigen::RowVectorXd::Unit(m, one);
  flight.dissipating[static_cast<std::size_t>(SceneElement::kSkin)] =
      force.transpose() * force / Bs;
}

// a skin without damping is where the finger is, less F0/Ks; its energy is Ks (F0/Ks)^2/2 - F0^2/Ks
void AddSkinAtOnce(const Scene& scene, double preload_n, Mode& flight) {
  const Eigen::Index n = flight.a.rows(), one = n - 1;
  flight.stored_j(one, one) -= preload_n * preload_n / scene.skin.stiffness_n_per_m / 2;
  if (flight.stored_j.rows() == n) return;
  flight.stored_j(one, n + kFinger) += preload_n / 2;
  flight.stored_j(n + kFinger, one) += preload_n / 2;
}

// the finger's part of the guards: the skin's foot moves with it
void FeedGuards(const Skin& skin, ContactModes& modes) {
  modes.force_feed = Eigen::RowVectorXd::Zero(kInputs);
  modes.force_feed(kFinger) = -skin.stiffness_n_per_m;
  modes.force_feed(kFingerRate) = -skin.damping_n_s_per_m;
  if (skin.damping_n_s_per_m > 0) return;
  modes.gap_feed = Eigen::RowVectorXd::Unit(kInputs, kFinger);
}

}  // namespace

ContactModes AssembleContact(const Scene& scene, const ContactLoss& loss) {
  const double Ks = scene.skin.stiffness_n_per_m, Bs = scene.skin.damping_n_s_per_m;
  const double F0 = loss.preload_n;
  HAPTOMETER_CHECK(F0 > 0 && (Ks > 0 || Bs > 0), "{} N on {} N/m, {} N s/m", F0, Ks, Bs);
  const LinearModel model = AssembleModel(scene);
  const Eigen::Index n = model.states();
  ContactModes modes;
  modes.contact = WithConstant(SceneMode(scene));
  modes.flight = LooseBodies(scene, model, F0);
  modes.contact.name = "contact";
  const Eigen::Index m = modes.flight.a.rows();
  // contact holds while F0 + Ks xs + Bs vs >= 0
  modes.force_row = F0 * Eigen::RowVectorXd::Unit(n + 1, n);
  modes.force_row(model.skin()) = Ks;
  modes.force_row(model.skin_velocity()) = Bs;
  // take-off keeps the bodies' states; landing is its transpose
  modes.take_off = Eigen::MatrixXd::Zero(m, n + 1);
  modes.take_off.topLeftCorner(n, n).setIdentity();
  modes.take_off(m - 1, n) = 1;
  modes.landing = modes.take_off.transpose();
  // flight holds while the gap xp - xs >= 0
  modes.gap_row = -Eigen::RowVectorXd::Unit(m, model.skin());
  if (Bs > 0) {
    // at take-off the surface is where the body is
    AddLooseSkin(scene, F0, modes.flight);
    modes.take_off(m - 2, model.skin()) = 1;
    modes.gap_row(m - 2) = 1;
  } else {
    AddSkinAtOnce(scene, F0, modes.flight);
    // without damping the surface is at -F0 / Ks at once
    modes.gap_row(m - 1) = -F0 / Ks;
    modes.gap_order = 1;
    modes.force_at_landing = false;
  }
  if (!scene.finger.tones.empty()) FeedGuards(scene.skin, modes);
  return modes;
}

}  // namespace haptometer::sim
