#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>

namespace haptometer::sim {

/// A system that is linear except for a few functions of a few of its numbers,
///
///   y' = A y + B u(t) + P g(u, R y),     q' = p(u, y),
///
/// u and g without jumps; what jumps is a new beginning. A spring that stiffens is one function of
/// one number, the force beyond the linear spring's of the travel.
class SemilinearProblem {
 public:
  using Vector = Eigen::Ref<Eigen::VectorXd>;
  using ConstVector = Eigen::Ref<const Eigen::VectorXd>;

  struct Linear {
    Eigen::MatrixXd a;         ///< A (n, n)
    Eigen::MatrixXd inputs;    ///< B (n, m)
    Eigen::MatrixXd feedback;  ///< P (n, k)
    Eigen::MatrixXd readings;  ///< R (r, n)
  };

  SemilinearProblem() = default;
  SemilinearProblem(const SemilinearProblem&) = delete;
  SemilinearProblem& operator=(const SemilinearProblem&) = delete;
  virtual ~SemilinearProblem() = default;

  [[nodiscard]] virtual const Linear& linear() const = 0;
  /// Chooses from a few linear parts, numbered, the one for which g is small near y; linear() and
  /// Feedback() are then of that one. Depends on y alone.
  [[nodiscard]] virtual int Linearise(const ConstVector& y) = 0;
  /// u (m).
  virtual void Inputs(double t_s, Vector u) const = 0;
  /// g (k) of u and R y (r).
  virtual void Feedback(const ConstVector& u, const ConstVector& readings, Vector g) const = 0;
  [[nodiscard]] virtual Eigen::Index integrals() const = 0;  ///< may be 0
  /// p.
  virtual void IntegralRate(const ConstVector& u, const ConstVector& y, Vector rate) const = 0;
};

/// What a solution cost.
struct SolverWork {
  std::int64_t steps = 0;
  std::int64_t evaluations = 0;  ///< of g
  std::int64_t rejected_steps = 0;
  std::int64_t restarts = 0;
  std::int64_t operators = 0;  ///< matrices of a length of step that were set up

  SolverWork& operator+=(const SolverWork& other);
};

/// Exponential collocation: the linear part exactly, g as a polynomial over each step.
///
///   y(t + s) = exp(A s) y(t) + integral from 0 to s of exp(A (s - r)) (B u + P g)(t + r) dr
///
/// with u and g as polynomials of degree 10 through Chebyshev's extreme points, whose integrals are
/// matrices that depend on A and on the length of the step alone. g at the points follows from R y
/// there by fixed-point iteration, which needs P and R only, a few numbers. So a coil's R/L or a
/// stiff stop limits no step, and where g = 0 the solution is exact to rounding. (M. Hochbruck and
/// A. Ostermann, "Exponential integrators", Acta Numerica 19, 209-286 (2010), section 2, with one
/// method of high degree in place of a family.)
///
/// **Steps** are 2^-k s, so that their matrices are few and kept: built once by series for the
/// length at which |A| h is about 1, then doubled,
///
///   Z(2h)[q] = exp(A h) Z(h)[first half of q] + Z(h)[second half of q].
///
/// A step is halved where the last two Chebyshev coefficients of a state exceed `relative` times
/// its largest value so far, of an integral's rate likewise, where those of g could move a state at
/// the step's end by as much, or where the iteration does not converge in 20 sweeps; of the first
/// step after a beginning where they exceed a 32nd of that, as a transient that a step does not
/// resolve has small last coefficients. It is doubled where all are 2^-12 of what is allowed, and
/// tried doubled after eight steps where they are rounding. What a step leaves out of a function
/// that it resolves is less than its last coefficient, as they fall geometrically.
///
/// Cost: some 10 us a step with eight states, some 50 us a length of step.
class SemilinearSolver {
 public:
  SemilinearSolver(SemilinearProblem& problem, double relative);
  SemilinearSolver(const SemilinearSolver&) = delete;
  SemilinearSolver& operator=(const SemilinearSolver&) = delete;
  ~SemilinearSolver();

  struct Beginning {
    double t_s = 0;
    Eigen::VectorXd y;
    Eigen::VectorXd scale;           ///< of each state, >= 0
    Eigen::VectorXd integral_scale;  ///< of each integral, >= 0; its own value counts where larger
    double longest_step_s = 0;       ///< > 0, finite
  };
  /// Begins anew; the integrals begin at 0.
  void Begin(const Beginning& beginning);
  /// Forgets all but the matrices of steps, so that what follows does not depend on what was
  /// before.
  void Reset();

  /// Takes one step. False: it cannot go on (a step too short to move the time, a state that is not
  /// finite).
  [[nodiscard]] bool Step();

  /// Where the last step began and ended; both the beginning's time before the first.
  [[nodiscard]] double begin_s() const;
  [[nodiscard]] double end_s() const;
  /// At a time within the last step.
  [[nodiscard]] Eigen::VectorXd At(double t_s) const;
  /// (n, 11): the last step's polynomials in u, t = begin_s + u (end_s - begin_s).
  [[nodiscard]] const Eigen::MatrixXd& StepTerms() const;
  [[nodiscard]] Eigen::VectorXd IntegralsAt(double t_s) const;
  /// Each state's largest value so far, or its scale.
  [[nodiscard]] const Eigen::VectorXd& scale() const;
  [[nodiscard]] SolverWork work() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace haptometer::sim
