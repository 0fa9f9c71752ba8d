#include <fmt/core.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "sim/linear/linear_model.h"
#include "tools/compare/compare.h"
#include "tools/document/keys.h"
#include "tools/simulate/scene_answer.h"
#include "tools/sweep/sweep.h"

namespace haptometer::tools {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// a number of the steady motion, or of what the scene settles to, or of its run
double NumberOf(const SceneAnswer& answer, const document::Key& key) {
  for (const auto numbers : {SteadyNumbers(), RunNumbers()}) {
    for (const AnswerNumber& number : numbers) {
      if (number.key.name != key.name) continue;
      if (const auto value = number.of(answer)) return *value;
    }
  }
  return kNan;
}

// of the motion without its constant part, which the band does not hold
double RmsOf(const SceneAnswer& answer, sim::SensorTarget target) {
  if (answer.steady) {
    const sim::LinearModel model = sim::AssembleModel(EffectiveOf(answer).scene);
    return std::abs(answer.steady->phasors(sim::StateOf(model, target))) / std::numbers::sqrt2;
  }
  return answer.scene.drive.offset_v != 0 ? kNan : NumberOf(answer, KeyOf(Compared::kRms, target));
}

// current, power and phase at the tone: without what an offset of the drive adds
double AtTheTone(const SceneAnswer& answer, Compared quantity, sim::SensorTarget target) {
  const double whole = NumberOf(answer, KeyOf(quantity, target));
  const double offset_v = answer.scene.drive.offset_v;
  if (offset_v == 0 || quantity == Compared::kPhase) return whole;
  if (!answer.steady) return kNan;
  if (quantity == Compared::kCurrent)
    return std::abs(answer.steady->current_a) / std::numbers::sqrt2;
  return whole - offset_v * answer.steady->mean_current_a;
}

// of the skin, which is the body whose rise is known
dsp::Estimate RiseOf(const SceneAnswer& answer) {
  const auto played = PlayedMotion(answer);
  const MotionNumbers numbers = NumbersOf(answer, played ? &*played : nullptr);
  if (!numbers.rise || !numbers.rise->rise_s) return {kNan, 0};
  return {*numbers.rise->rise_s, numbers.rise->uncertainty_s};
}

bool HasFrequency(const sim::Drive& drive) {
  return drive.kind == sim::DriveKind::kSine || drive.kind == sim::DriveKind::kBurst;
}

// a drive outside of the band leaves nothing in it
Result<void> CheckBand(const sim::Drive& drive, const MeasuredNumbers& measured,
                       const std::string& path) {
  const double f = drive.frequency_hz;
  if (!HasFrequency(drive) || (f >= measured.lower_hz && f <= measured.upper_hz)) return {};
  return CannotAnswer(path,
                      fmt::format("drives at {:g} Hz, outside of the {:g} to {:g} Hz that the "
                                  "measured RMS is of",
                                  f, measured.lower_hz, measured.upper_hz),
                      std::string(measured.other_band));
}

// --- how far the quantities spread ---

// a second-order term beyond this share of u(d) is not enough
constexpr double kSecondOrder = 0.05;

// a value of an input, in its standard uncertainties from the stated one, and its weight
struct Node {
  double z = 0;
  double weight = 1;
};

// the middle rule over a normal distribution, up to four standard deviations, or over a range
std::vector<Node> NodesOf(bool is_range) {
  constexpr int kNodes = 41;
  const double reach = is_range ? std::numbers::sqrt3 : 4;
  std::vector<Node> nodes;
  for (int k = 0; k < kNodes; ++k) {
    const double z = reach * ((2. * k + 1) / kNodes - 1);
    nodes.push_back({z, is_range ? 1 : std::exp(-z * z / 2)});
  }
  return nodes;
}

// what the quantities are at `steps` less what they are as stated
using ChangeAt = std::function<Result<Eigen::VectorXd>(const Eigen::VectorXd& steps)>;

// second moments of the changes along a column of the factor; a value that the scene does not
// take, or without one of the quantities, has no weight
Eigen::MatrixXd DenseSpread(const ChangeAt& change_at, const Eigen::VectorXd& column, bool is_range,
                            const Eigen::VectorXd& known) {
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(known.size(), known.size());
  double weights = 0;
  for (const Node& node : NodesOf(is_range)) {
    const auto change = change_at(node.z * column);
    if (!change || (known.array().isFinite() && !change->array().isFinite()).any()) continue;
    spread += node.weight * *change * change->transpose();
    weights += node.weight;
  }
  return spread / weights;
}

// whether a measured quantity has a second-order term beyond a share of its first-order
// uncertainty, from which on it is more than 1 % of the variance
bool IsCurved(const Propagation& propagation, Eigen::Index k, const MeasuredNumbers& measured) {
  for (std::size_t i = 0; i < kComparedCount; ++i) {
    if (!measured.numbers[i]) continue;
    const auto row = static_cast<Eigen::Index>(i);
    const double u =
        std::hypot(propagation.changes.row(row).norm(), measured.numbers[i]->uncertainty);
    if (std::abs(propagation.curvature(row, k)) > kSecondOrder * u) return true;
  }
  return false;
}

// E of z^4 of a distribution of standard deviation 1
double KurtosisOf(const ComparedInput& input) { return input.is_range ? 1.8 : 3; }

void AddSpread(const ComparedScene& scene, const ChangeAt& change_at,
               const MeasuredNumbers& measured, Propagation& propagation) {
  for (Eigen::Index k = 0; k < propagation.changes.cols(); ++k) {
    const ComparedInput& input = scene.inputs()[scene.InputOf(k)];
    const Eigen::VectorXd t = propagation.changes.col(k);
    const Eigen::VectorXd c = propagation.curvature.col(k);
    propagation.spread +=
        IsCurved(propagation, k, measured)
            ? DenseSpread(change_at, scene.factor().col(k), input.is_range, t)
            : Eigen::MatrixXd(t * t.transpose() + KurtosisOf(input) * c * c.transpose());
  }
}

}  // namespace

sim::SensorTarget TargetOf(const sim::Scene& scene) {
  return scene.sensor ? scene.sensor->target : sim::SensorTarget::kSkin;
}

Result<SimulatedNumbers> SimulatedOf(const sim::Scene& scene, const std::string& where,
                                     bool with_rise) {
  HAPTOMETER_LET(const auto answer, AnswerScene(scene, where));
  const sim::SensorTarget target = TargetOf(scene);
  SimulatedNumbers numbers{};
  const auto set = [&](Compared quantity, dsp::Estimate number) {
    numbers[static_cast<std::size_t>(quantity)] = number;
  };
  set(Compared::kRms, {RmsOf(answer, target), 0});
  set(Compared::kTone, {HasFrequency(scene.drive) ? scene.drive.frequency_hz : kNan, 0});
  const bool has_rise = with_rise && target == sim::SensorTarget::kSkin;
  set(Compared::kRise, has_rise ? RiseOf(answer) : dsp::Estimate{kNan, 0});
  for (const Compared quantity : {Compared::kCurrent, Compared::kPower, Compared::kPhase}) {
    set(quantity, {AtTheTone(answer, quantity, target), 0});
  }
  return numbers;
}

double DeviationOf(Compared quantity, double one, double other) {
  const double apart = one - other;
  return quantity == Compared::kPhase ? std::remainder(apart, 2 * std::numbers::pi) : apart;
}

Result<Propagation> Propagate(const ComparedScene& scene, const MeasuredNumbers& measured) {
  const bool with_rise = measured.numbers[static_cast<std::size_t>(Compared::kRise)].has_value();
  const auto count = static_cast<Eigen::Index>(scene.inputs().size());
  HAPTOMETER_LET(const auto stated, scene.At(Eigen::VectorXd::Zero(count)));
  HAPTOMETER_TRY(CheckBand(stated.drive, measured, scene.path()));
  Propagation propagation{.changes = Eigen::MatrixXd(kComparedCount, count),
                          .curvature = Eigen::MatrixXd(kComparedCount, count),
                          .spread = Eigen::MatrixXd::Zero(kComparedCount, kComparedCount)};
  HAPTOMETER_LET(propagation.at, SimulatedOf(stated, scene.path(), with_rise));
  const auto change_at = [&](const Eigen::VectorXd& steps) -> Result<Eigen::VectorXd> {
    HAPTOMETER_LET(const auto at, scene.At(steps));
    HAPTOMETER_LET(const auto numbers, SimulatedOf(at, scene.path(), with_rise));
    Eigen::VectorXd change(kComparedCount);
    for (std::size_t i = 0; i < kComparedCount; ++i) {
      change(static_cast<Eigen::Index>(i)) =
          DeviationOf(static_cast<Compared>(i), numbers[i].value, propagation.at[i].value);
    }
    return change;
  };
  for (Eigen::Index k = 0; k < count; ++k) {
    HAPTOMETER_LET(const auto above, change_at(scene.factor().col(k)));
    HAPTOMETER_LET(const auto below, change_at(-scene.factor().col(k)));
    propagation.changes.col(k) = (above - below) / 2;
    propagation.curvature.col(k) = (above + below) / 2;
  }
  AddSpread(scene, change_at, measured, propagation);
  return propagation;
}

}  // namespace haptometer::tools
