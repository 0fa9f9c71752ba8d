#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/quantity.h"
#include "dsp/spectrum/electrical.h"
#include "sim/scene/scene.h"
#include "sim/sweep/varied_scene.h"
#include "tools/document/document.h"

/// Whether a measurement and a scene agree within what is known of both.
///
/// q quantities y = f(x) of the scene depend on n inputs x of covariance C. With a factor F of
/// C = F F^T (rows: inputs) and central differences along its columns, each one standard deviation
/// long,
///
///   T_k  = (f(x + F_k) - f(x - F_k)) / 2            so that S C S^T = T T^T,  S C = T F^T
///   V    = T T^T + diag(u_measured^2 + u_method^2)  covariance of
///   d    = measured - simulated
///   zeta = d_i / sqrt(V_ii)                         zeta score
///   E_n  = d_i / (2 sqrt(V_ii))                     normalised error; |E_n| > 1: they differ
///   2 sqrt(V_ii)                                    smallest deviation that could have been seen
///
/// What the measurement says of the inputs is, to first order and for normal distributions, their
/// mean given d, an adjustment by least squares:
///
///   a    = F T^T V^-1 d                             change of the inputs
///   P    = F T^T V^-1 T F^T                         covariance of a where all is as stated
///   p_j  = a_j / sqrt(P_jj)                         pull, of mean 0 and standard deviation 1 then
///
/// p_j^2 is what chi^2 = d^T V^-1 d falls by where a wrong input j alone is the reason. Of
/// independent inputs with one wrong the largest |p| is that one's (Cauchy and Schwarz), and the
/// correlation of p_j and p_k, from P, says how well j and k can be told apart.
///
/// Where a quantity is not linear over the whole difference (a resonance), a pull is found by
/// search:
///
///   p_j^2 = chi^2 - min over z of chi^2 of d - (f(x + z C e_j / u_j) - f(x)),  sign of z
///
/// with V as above. Of a linear scene it is the pull above.
///
/// Sources: JCGM 100:2008, 5.2.2 and 5.1.3 note 2 (propagation, numerical); JCGM 101:2008, 6.4.2
/// (a range is a rectangular distribution: u = width / sqrt(12)); ISO 13528:2022, 9.6 and 9.7 (zeta
/// and E_n, k = 2); A. Gelb (ed.), Applied Optimal Estimation, 1974, 4.2 (the adjustment is the
/// update of a linear filter). Columns of F in place of single inputs: of strongly correlated
/// inputs (Kv and Mv of a drop test) a step of one alone leaves the range in which y is linear.
namespace haptometer::tools {

// --- quantities ---

/// What is compared, where both sides have it.
enum class Compared : std::uint8_t { kRms, kTone, kRise, kCurrent, kPower, kPhase };
inline constexpr std::size_t kComparedCount = 6;
/// One value a quantity, by Compared, SI.
template <typename T>
using OfCompared = std::array<std::optional<T>, kComparedCount>;

/// The key of a quantity; the RMS is that of the sensor's target.
[[nodiscard]] document::Key KeyOf(Compared quantity, sim::SensorTarget target);

/// What trials say of the quantities.
struct MeasuredNumbers {
  /// Means over those trials that have the quantity, with
  ///   u^2 = s^2 / n + mean of u_i^2,
  /// s their standard deviation: calibration and other causes that are common to all do not average
  /// out, and what is statistical in u_i counts twice, which is to the safe side.
  OfCompared<dsp::Estimate> numbers{};
  std::vector<std::string> files{};             ///< of the trials
  std::vector<document::DataSource> sources{};  ///< of their data
  std::vector<std::string> doubts{};            ///< of their analyses, in words
  /// Narrowest band that the RMS are of.
  double lower_hz = 0, upper_hz = std::numeric_limits<double>::infinity();
  bool is_calibrated = true;         ///< each u holds the laser's calibration
  bool has_electrical_gain = false;  ///< gain or skew of voltage and current is stated
};

/// Reads trials, which are analysed as `analyze` does without options, and documents of
/// `analyze --json`.
///
/// Errors: as trial::OpenRows and dsp::AnalyzeBand; Cause::kCannotAnswer for a trial whose analysis
/// is no answer, with its first reason, and for a document of another kind.
[[nodiscard]] Result<MeasuredNumbers> ReadMeasured(std::span<const std::string> paths);

/// The trials of a document of `analyze --json`, which `path` names. Errors: as ReadMeasured.
[[nodiscard]] Result<MeasuredNumbers> MeasuredIn(const std::string& text, const std::string& path);

/// Adds to the measured uncertainties, as root of the sum of squares, what `--uncertainty` words
/// state: "current_rms_a=1%" of the value, "phase_rad=0.01" in SI. Errors (Cause::kUsage), naming
/// --uncertainty: no '=', a key that is not compared, no number above 0; Cause::kCannotAnswer for a
/// quantity that was not measured.
[[nodiscard]] Result<void> AddUncertainties(const std::vector<std::string>& words,
                                            sim::SensorTarget target, MeasuredNumbers& measured);

// --- inputs and the scene ---

/// An input of the scene whose uncertainty is stated.
struct ComparedInput {
  std::string key;  ///< "skin.stiffness_n_per_m"
  Quantity value;   ///< SI; of a range its middle, u = width / sqrt(12)
  /// Of the actuator: the place of its symbol in sim::kActuatorSymbols; it is varied by factors.
  std::optional<std::size_t> symbol{};
};

/// Reads `--input` words: "KEY=600+-50", "KEY=600(50)", "KEY=600:1200", with the unit of the key's
/// name. Errors (Cause::kUsage), naming --input and the key: no '=', another unit, no uncertainty,
/// a range whose ends are not in order.
[[nodiscard]] Result<std::vector<ComparedInput>> ReadInputs(const std::vector<std::string>& words);

/// A scene as a function of its inputs.
class ComparedScene {
 public:
  /// Reads the scene with `inputs` at their values; the inputs that its actuator's file states
  /// follow them. Errors: the scene's; those of an input name --input; Cause::kCannotAnswer where
  /// the actuator's correlations contradict each other.
  [[nodiscard]] static Result<ComparedScene> Read(const std::string& path,
                                                  std::vector<ComparedInput> inputs);

  [[nodiscard]] const std::string& path() const { return scene_.path(); }
  [[nodiscard]] const std::vector<ComparedInput>& inputs() const { return inputs_; }
  /// (n, n): F of the correlations, in standard uncertainties of the inputs.
  [[nodiscard]] const Eigen::MatrixXd& factor() const { return factor_; }
  /// The input that column `k` of the factor changes most.
  [[nodiscard]] std::size_t InputOf(Eigen::Index k) const;

  /// The scene with its inputs changed by `steps` (n) standard uncertainties; the actuator's by
  /// factors exp(step u / value). Errors: the scene's, with what was changed.
  [[nodiscard]] Result<sim::Scene> At(const Eigen::VectorXd& steps) const;
  /// The body that the scene's sensor is on; the skin without one.
  [[nodiscard]] sim::SensorTarget target() const { return target_; }

 private:
  ComparedScene(sim::VariedScene scene, std::vector<ComparedInput> inputs)
      : scene_(std::move(scene)), inputs_(std::move(inputs)) {}
  [[nodiscard]] Result<void> TakeActuator(const sim::ActuatorCovariance& covariance,
                                          const sim::Actuator& actuator);

  sim::VariedScene scene_;
  std::vector<ComparedInput> inputs_;
  Eigen::MatrixXd factor_;
  sim::SensorTarget target_{};
};

/// What a scene says of the quantities, NaN where it says nothing; the uncertainty is that of the
/// way in which a number is found (0 of all but the rise).
using SimulatedNumbers = std::array<dsp::Estimate, kComparedCount>;
/// `with_rise`: the rise is asked for, which takes a run. Errors: as AnswerScene.
[[nodiscard]] Result<SimulatedNumbers> SimulatedOf(const sim::Scene& scene,
                                                   const std::string& where, bool with_rise);

/// The scene and its first-order dependence on the inputs.
struct Propagation {
  SimulatedNumbers at{};
  Eigen::MatrixXd changes;    ///< T (kComparedCount, n); NaN where a quantity is not known
  Eigen::MatrixXd curvature;  ///< the same of (f(x + F_k) + f(x - F_k)) / 2 - f(x)
};
/// Cost: 2 n + 1 answers of the scene. Errors: as ComparedScene::At and SimulatedOf;
/// Cause::kCannotAnswer where the scene drives outside of the band that `measured` is of.
[[nodiscard]] Result<Propagation> Propagate(const ComparedScene& scene,
                                            const MeasuredNumbers& measured);

// --- the comparison ---

/// The numbers of the equations above, inputs in units of their standard uncertainties.
struct Agreement {
  Eigen::VectorXd variance;     ///< V_ii (q)
  Eigen::VectorXd adjustment;   ///< a (n)
  Eigen::VectorXd pull;         ///< p (n); NaN of an input on which no quantity depends
  Eigen::VectorXd explained;    ///< P_jj (n): 1 where the measurement determines the input
  Eigen::MatrixXd correlation;  ///< of the pulls (n, n)
  Eigen::MatrixXd weight;       ///< V^-1 (q, q)
  double chi_squared = 0;
};
/// `own` (q): variances besides the inputs'. V is inverted in the scale of its diagonal, without
/// directions below 1e-12 of its largest; all V_ii must be above 0. Cost: q^3 + q n^2.
[[nodiscard]] Agreement Agree(const Eigen::VectorXd& deviation, const Eigen::VectorXd& own,
                              const Eigen::MatrixXd& changes, const Eigen::MatrixXd& factor);

/// A quantity of both sides.
struct ComparedQuantity {
  Compared quantity{};
  dsp::Estimate measured, simulated;  ///< the latter's uncertainty by inputs and method
  double deviation = 0;               ///< measured - simulated; of a phase within +-pi
  double deviation_uncertainty = 0;   ///< sqrt(V_ii)
  [[nodiscard]] double Zeta() const { return deviation / deviation_uncertainty; }
  [[nodiscard]] double NormalizedError() const { return Zeta() / 2; }
};

/// Two pulls of a larger correlation cannot be told apart.
inline constexpr double kToldApart = 0.95;
/// |p| from which on an input may be a cause, as |E_n| = 1.
inline constexpr double kPullOfCause = 2;
/// Share of measurements that agree whose chi^2 is below the one from which on they do not.
inline constexpr double kTogether = 0.99;
/// A second-order term beyond this share of sqrt(V_ii), which holds the first-order one, is a
/// doubt.
inline constexpr double kMostCurvature = 0.2;

struct ComparisonResult {
  sim::SensorTarget target{};
  std::vector<ComparedQuantity> quantities{};
  Agreement agreement{};
  /// Inputs in sets that cannot be told apart: each begins with its largest |pull|, of which the
  /// others' correlation is above kToldApart; sets by falling |pull|, inputs without influence left
  /// out.
  std::vector<std::vector<std::size_t>> sets{};
  /// Of each input, in its standard uncertainties, the change z at which it alone explains most;
  /// empty without a search.
  std::vector<double> explaining{};
  std::vector<Compared> only_measured{}, only_simulated{};
  std::vector<std::size_t> curved{};  ///< inputs of which a quantity is not linear

  /// Whether some |E_n| is above 1.
  [[nodiscard]] bool Differs() const;
  /// Whether chi^2 is beyond its quantile kTogether: quantities that each agree may differ
  /// together.
  [[nodiscard]] bool DiffersTogether() const;
};
/// Compares what both sides have.
[[nodiscard]] ComparisonResult Compare(const OfCompared<dsp::Estimate>& measured,
                                       const ComparedScene& scene, const Propagation& propagation);

/// Finds pulls and sets by search where there is something to explain: some |E_n| is above 1 or
/// some |p| above kPullOfCause. Cost: some 100 answers of the scene an input.
void FindCauses(const ComparedScene& scene, const Propagation& propagation,
                ComparisonResult& result);

/// The answer as a document, with a figure where `has_figures` says.
[[nodiscard]] document::Document CompareDocument(const MeasuredNumbers& measured,
                                                 const ComparedScene& scene,
                                                 const ComparisonResult& result, bool has_figures);

}  // namespace haptometer::tools
