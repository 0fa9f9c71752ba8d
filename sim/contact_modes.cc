#include "sim/contact_modes.h"

#include "base/error.h"
#include "sim/linear_model.h"
#include "sim/scene_mode.h"

namespace haptometer::sim {

namespace {

// the bodies without a skin, pushed by the preload
Mode LooseBodies(const Scene& scene, const LinearModel& model, double preload_n) {
  Scene loose = scene;
  loose.skin = {};
  Mode flight = SceneMode(loose);
  // the place for the skin's own motion
  if (scene.skin.damping_n_s_per_m > 0) flight = WithConstant(flight);
  flight = WithConstant(flight);
  flight.name = "flight";
  const Eigen::Index one = flight.a.rows() - 1;
  flight.a(model.skin_velocity(), one) += preload_n / ContactMass(scene);
  // without a skin only the preload is left of what the finger would feel
  if (flight.finger.size() > 0) {
    flight.finger.setZero();
    flight.finger_force_row = -preload_n * Eigen::RowVectorXd::Unit(one + 1 + kInputs, one);
  }
  // the preload's work
  flight.stored_j(model.skin(), one) -= preload_n / 2;
  flight.stored_j(one, model.skin()) -= preload_n / 2;
  return flight;
}

// the skin springs back by itself, from where the finger is; its state stands before the last
void AddLooseSkin(const Scene& scene, double preload_n, Mode& flight) {
  const double Ks = scene.skin.stiffness_n_per_m, Bs = scene.skin.damping_n_s_per_m;
  const Eigen::Index n = flight.a.rows(), xp = n - 2, one = n - 1;
  const Eigen::Index m = flight.stored_j.rows();
  flight.a(xp, xp) = -Ks / Bs;
  flight.a(xp, one) = -preload_n / Bs;
  Eigen::RowVectorXd sprung = Eigen::RowVectorXd::Unit(m, xp);
  if (m > n) {
    sprung(n + kFinger) = -1;
    flight.finger.row(xp) << Ks / Bs, 1;
  }
  flight.stored_j += Ks / 2 * sprung.transpose() * sprung;
  flight.stored_j(xp, one) += preload_n / 2;
  flight.stored_j(one, xp) += preload_n / 2;
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

// what the finger does to the guards: the skin's foot moves with it
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
  modes.force_row = F0 * Eigen::RowVectorXd::Unit(n + 1, n);
  modes.force_row(model.skin()) = Ks;
  modes.force_row(model.skin_velocity()) = Bs;
  modes.take_off = Eigen::MatrixXd::Zero(m, n + 1);
  modes.take_off.topLeftCorner(n, n).setIdentity();
  modes.take_off(m - 1, n) = 1;
  modes.landing = modes.take_off.transpose();
  modes.gap_row = -Eigen::RowVectorXd::Unit(m, model.skin());
  if (Bs > 0) {
    AddLooseSkin(scene, F0, modes.flight);
    modes.take_off(m - 2, model.skin()) = 1;
    modes.gap_row(m - 2) = 1;
  } else {
    AddSkinAtOnce(scene, F0, modes.flight);
    modes.gap_row(m - 1) = -F0 / Ks;
    modes.gap_order = 1;
    modes.force_at_landing = false;
  }
  if (!scene.finger.tones.empty()) FeedGuards(scene.skin, modes);
  return modes;
}

}  // namespace haptometer::sim
