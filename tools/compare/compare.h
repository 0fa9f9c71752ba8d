#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/quantity.h"
#include "dsp/spectrum/electrical.h"
#include "sim/findings.h"
#include "sim/scene/scene.h"
#include "sim/sweep/varied_scene.h"
#include "tools/compare/measured.h"
#include "tools/document/document.h"

/// Whether a measurement and a scene agree within what is known of both.
///
/// q quantities y = f(x) of the scene depend on n inputs x of covariance C. With a factor F of
/// C = F F^T (rows: inputs) and central differences along its columns, each one standard deviation
/// long,
///
///   T_k  = (f(x + F_k) - f(x - F_k)) / 2            so that S C S^T = T T^T,  S C = T F^T
///   c_k  = (f(x + F_k) + f(x - F_k)) / 2 - f(x)     second order
///   M    = sum over k of E (f(x + z F_k) - f(x)) (f(x + z F_k) - f(x))^T
///        = sum over k of T_k T_k^T + E z^4 c_k c_k^T   to second order
///   d    = measured - simulated, where simulated = f(x)
///   u(d) = sqrt(M_ii + u_measured^2 + u_method^2)
///   zeta = d_i / u(d)                               zeta score
///   E_n  = d_i / (2 u(d))                           normalised error; |E_n| > 1: they differ
///   2 u(d)                                          smallest deviation that could have been seen
///
/// M holds the square of the mean change too, for which f(x) is not corrected. z is of mean 0 and
/// standard deviation 1, normal (E z^4 = 3) or of a range rectangular (1.8). Where c_k of a
/// measured quantity is beyond a twentieth of its first-order uncertainty (a resonance), E is taken
/// at 41 places of z; those that the scene does not take have no weight.
///
/// What the measurement says of the inputs is, to first order and for normal distributions, their
/// mean given d, an adjustment by least squares:
///
///   V    = T T^T + diag(u_measured^2 + u_method^2)
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
/// with V as above. Of a linear scene it is the pull above. z is at most 1000, and as much as 1e6
/// where the pull's tangent points there.
///
/// Sources: JCGM 100:2008, 5.2.2 and 5.1.3 note 2 (propagation, numerical); JCGM 101:2008, 6.4.2
/// (a range is a rectangular distribution: u = width / sqrt(12)); ISO 13528:2022, 9.6 and 9.7 (zeta
/// and E_n, k = 2); A. Gelb (ed.), Applied Optimal Estimation, 1974, 4.2 (the adjustment is the
/// update of a linear filter). Columns of F in place of single inputs: of strongly correlated
/// inputs (Kv and Mv of a drop test) a step of one alone leaves the range in which y is linear.
namespace haptometer::tools {

// --- inputs and the scene ---

/// An input of the scene whose uncertainty is stated.
struct ComparedInput {
  std::string key;        ///< "skin.stiffness_n_per_m"
  Quantity value;         ///< SI; of a range its middle, u = width / sqrt(12)
  bool is_range = false;  ///< distributed rectangularly; else normally
  /// Of an actuator that stands in another file: the place of its symbol in sim::kActuatorSymbols;
  /// it is varied by factors.
  std::optional<std::size_t> symbol{};
};

/// Reads `--input` words: "KEY=600+-50", "KEY=600(50)", "KEY=600:1200", with the unit of the key's
/// name. Errors (Cause::kUsage), naming --input and the key: no '=', another unit, no uncertainty,
/// a range whose ends are not in order.
[[nodiscard]] Result<std::vector<ComparedInput>> ReadInputs(const std::vector<std::string>& words);

/// The body that a scene's sensor is on; the skin without one.
[[nodiscard]] sim::SensorTarget TargetOf(const sim::Scene& scene);

/// A scene as a function of its inputs.
class ComparedScene {
 public:
  /// Reads the scene with `inputs` at their values; the uncertain numbers of its actuator follow
  /// them, but for those among `inputs`. Errors: the scene's; those of an input name --input;
  /// Cause::kCannotAnswer where the actuator's correlations contradict each other.
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
  /// Unusual numbers of the scene, with its inputs at their values.
  [[nodiscard]] const sim::Findings& unusual() const { return unusual_; }

 private:
  ComparedScene(sim::VariedScene scene, std::vector<ComparedInput> inputs)
      : scene_(std::move(scene)), inputs_(std::move(inputs)) {}
  [[nodiscard]] Result<void> TakeActuator(sim::ActuatorCovariance covariance,
                                          const sim::Actuator& actuator);

  sim::VariedScene scene_;
  std::vector<ComparedInput> inputs_;
  Eigen::MatrixXd factor_;
  sim::SensorTarget target_{};
  sim::Findings unusual_{};
};

/// What a scene says of the quantities, NaN where it says nothing; the uncertainty is that of the
/// way in which a number is found (0 of all but the rise).
using SimulatedNumbers = std::array<dsp::Estimate, kComparedCount>;
/// `with_rise`: the rise is asked for, which takes a run. Errors: as AnswerScene.
[[nodiscard]] Result<SimulatedNumbers> SimulatedOf(const sim::Scene& scene,
                                                   const std::string& where, bool with_rise);

/// one - other; of a phase within +-pi.
[[nodiscard]] double DeviationOf(Compared quantity, double one, double other);

/// The scene and its dependence on the inputs.
struct Propagation {
  SimulatedNumbers at{};
  Eigen::MatrixXd changes;    ///< T (kComparedCount, n); NaN where a quantity is not known
  Eigen::MatrixXd curvature;  ///< c, of the same shape
  Eigen::MatrixXd spread;     ///< M (kComparedCount, kComparedCount)
};
/// Cost: 2 n + 1 answers of the scene, 41 more of each input of which a quantity that is measured
/// is not linear. Errors: as ComparedScene::At and SimulatedOf; Cause::kCannotAnswer where the
/// scene drives outside of the band that `measured` is of.
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
  double deviation_uncertainty = 0;   ///< u(d)
  [[nodiscard]] double Zeta() const { return deviation / deviation_uncertainty; }
  [[nodiscard]] double NormalizedError() const { return Zeta() / 2; }
  [[nodiscard]] bool Differs() const { return std::abs(NormalizedError()) > 1; }
};

/// Two pulls of a larger correlation cannot be told apart.
inline constexpr double kToldApart = 0.95;
/// |p| from which on an input may be a cause, as |E_n| = 1.
inline constexpr double kPullOfCause = 2;
/// Share of measurements that agree whose chi^2 is below the one from which on they do not.
inline constexpr double kTogether = 0.99;
/// A second-order term beyond this share of u(d), which holds both, is a doubt.
inline constexpr double kMostCurvature = 0.2;

struct ComparisonResult {
  sim::SensorTarget target{};
  std::vector<ComparedQuantity> quantities{};
  double chi_squared = 0;  ///< d^T (M + diag(u_measured^2 + u_method^2))^-1 d
  Agreement agreement{};   ///< to first order
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

// --- the answer ---

/// A quantity as a row: both sides, deviation and scores.
[[nodiscard]] document::Section QuantityRow(const ComparedQuantity& one, sim::SensorTarget target);
/// The inputs that would each explain the difference, in words, with those that cannot be told
/// apart; empty where none does.
[[nodiscard]] std::vector<std::string> CausesOf(const ComparedScene& scene,
                                                const ComparisonResult& result);
/// Adds to `section` whether both agree, quantities, inputs, and what explains a difference.
void AddComparison(const MeasuredNumbers& measured, const ComparedScene& scene,
                   const ComparisonResult& result, document::Section& section);
/// What is compared with one scene: results that stand beside each other in a figure.
struct ComparedGroup {
  std::string name{};
  std::vector<ComparisonResult> results{};

  /// The quantity in those that have it.
  [[nodiscard]] std::vector<ComparedQuantity> Of(Compared quantity) const;
};
/// A panel a quantity, in its unit: what is simulated beside what is measured, by group. Some group
/// has a result.
[[nodiscard]] std::vector<plot::Panel> ComparisonPanels(std::span<const ComparedGroup> groups);
inline constexpr std::string_view kFigureCaption =
    "What is measured beside what is simulated, with expanded uncertainties (k = 2).";
/// The answer as a document, with a figure where `has_figures` says.
[[nodiscard]] document::Document CompareDocument(const MeasuredNumbers& measured,
                                                 const ComparedScene& scene,
                                                 const ComparisonResult& result, bool has_figures);

}  // namespace haptometer::tools
