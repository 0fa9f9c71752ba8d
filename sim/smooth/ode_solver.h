#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <memory>

namespace haptometer::sim {

/// The tolerances of SmoothMotion that a scene with smooth effects is played with, one after the
/// other: a hundred times a tenth of scene.tolerance (4e-12 to 1e-4), that tenth, and where the
/// answer is not good enough ever a hundred times less, down to 4e-12: below that rounding rules
/// each step, and SmoothMotion takes no less.
class SolverLadder {
 public:
  explicit SolverLadder(double scene_tolerance)
      : asked_(scene_tolerance),
        tolerance_(std::clamp(kPart * scene_tolerance, kLeast, kMost)),
        before_(kFiner * tolerance_) {}

  [[nodiscard]] double tolerance() const { return tolerance_; }
  /// Of the run before.
  [[nodiscard]] double before() const { return before_; }
  /// Whether an error is a quarter of what is asked for, or no less tolerance is left.
  [[nodiscard]] bool EndsWith(double error) const {
    return error <= kErrorPart * asked_ || tolerance_ <= kLeast;
  }
  void Refine() {
    before_ = tolerance_;
    tolerance_ = std::max(tolerance_ / kFiner, kLeast);
  }

 private:
  static constexpr double kPart = 0.1;
  static constexpr double kErrorPart = 0.25;
  static constexpr double kLeast = 4e-12;
  static constexpr double kMost = 1e-4;
  static constexpr double kFiner = 100;

  double asked_;
  double tolerance_;
  double before_;
};

/// y' = f(t, y) and the integrals q' = p(t, y) that ride along. Smooth all over: what jumps is a
/// new beginning.
class OdeProblem {
 public:
  using Vector = Eigen::Map<Eigen::VectorXd>;
  using ConstVector = Eigen::Map<const Eigen::VectorXd>;
  using Matrix = Eigen::Map<Eigen::MatrixXd>;

  OdeProblem() = default;
  OdeProblem(const OdeProblem&) = delete;
  OdeProblem& operator=(const OdeProblem&) = delete;
  virtual ~OdeProblem() = default;

  [[nodiscard]] virtual Eigen::Index states() const = 0;
  [[nodiscard]] virtual Eigen::Index integrals() const = 0;  ///< may be 0
  virtual void Rate(double t_s, const ConstVector& y, Vector rate) const = 0;
  virtual void Jacobian(double t_s, const ConstVector& y, Matrix jacobian) const = 0;
  virtual void IntegralRate(double t_s, const ConstVector& y, Vector rate) const = 0;
};

/// Multistep formulas of varying order.
enum class OdeMethod : std::uint8_t {
  kBdf,    ///< orders 1-5, for stiff problems; with a watch on its stability limit
  kAdams,  ///< orders 1-12
};

/// What a solution cost.
struct OdeWork {
  std::int64_t steps = 0;
  std::int64_t evaluations = 0;  ///< of the rate
  std::int64_t jacobians = 0;
  std::int64_t rejected_steps = 0;
  std::int64_t restarts = 0;

  OdeWork& operator+=(const OdeWork& other);
};

/// SUNDIALS CVODES, one step at a time, with the polynomial that each step leaves behind.
///
/// Dense Newton with the problem's Jacobian. A step's local error is kept below `relative` times
/// each state's largest value so far (or its scale at the beginning), the integrals' below
/// `relative` times their scale. SUNDIALS' own root finding is not used: it sees a change of sign
/// between steps only, and in 6.4.1 it may loop for ever (NaN, underflow); the polynomial of the
/// step is at hand and decides (sim/piecewise/guard.h).
class OdeSolver {
 public:
  OdeSolver(const OdeProblem& problem, OdeMethod method, double relative);
  OdeSolver(const OdeSolver&) = delete;
  OdeSolver& operator=(const OdeSolver&) = delete;
  ~OdeSolver();

  struct Beginning {
    double t_s = 0;
    Eigen::VectorXd y;
    Eigen::VectorXd scale;           ///< of each state, >= 0
    Eigen::VectorXd integral_scale;  ///< of each integral, >= 0
    double longest_step_s = 0;       ///< > 0
  };
  /// Begins anew, at order 1; the integrals begin at 0.
  void Begin(const Beginning& beginning);

  /// Takes one step. False: it cannot go on (corrections that do not converge, a step too short to
  /// move the time, a state that is not finite).
  [[nodiscard]] bool Step();

  /// Where the last step began and ended; both the beginning's time before the first.
  [[nodiscard]] double begin_s() const;
  [[nodiscard]] double end_s() const;
  /// The k-th derivative of the step's polynomial at a time within it, k up to order().
  [[nodiscard]] Eigen::VectorXd At(double t_s, int derivative = 0) const;
  [[nodiscard]] int order() const;
  [[nodiscard]] Eigen::VectorXd IntegralsAt(double t_s) const;
  /// Each state's largest value so far, or its scale.
  [[nodiscard]] const Eigen::VectorXd& scale() const;
  [[nodiscard]] OdeWork work() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace haptometer::sim
