#include "sim/smooth/semilinear_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

#include "tests/residual.h"

namespace haptometer::sim {
namespace {

// y' = A y + B u(t) + P g(R y), q' = p of the first state, or that state itself
class Problem final : public SemilinearProblem {
 public:
  explicit Problem(Linear linear, std::function<double(double)> g = {},
                   std::function<double(double)> u = {}, std::function<double(double)> p = {})
      : linear_(std::move(linear)), g_(std::move(g)), u_(std::move(u)), p_(std::move(p)) {}

  const Linear& linear() const override { return linear_; }
  int Linearise(const ConstVector& /*y*/) override { return 0; }
  void Inputs(double t_s, Vector u) const override {
    if (u.size() > 0) u[0] = u_(t_s);
  }
  void Feedback(const ConstVector& /*u*/, const ConstVector& readings, Vector g) const override {
    if (g.size() > 0) g[0] = g_(readings[0]);
  }
  Eigen::Index integrals() const override { return 1; }
  void IntegralRate(const ConstVector& /*u*/, const ConstVector& y, Vector rate) const override {
    rate[0] = p_ ? p_(y[0]) : y[0];
  }

 private:
  Linear linear_;
  std::function<double(double)> g_, u_, p_;
};

SemilinearProblem::Linear LinearOf(const Eigen::MatrixXd& a) {
  const Eigen::MatrixXd none(a.rows(), 0);
  return {.a = a, .inputs = none, .feedback = none, .readings = none.transpose()};
}

// one state, y' = a y + p g(y)
SemilinearProblem::Linear OneState(double a, double p) {
  SemilinearProblem::Linear linear = LinearOf(Eigen::MatrixXd::Constant(1, 1, a));
  linear.feedback = Eigen::MatrixXd::Constant(1, 1, p);
  linear.readings = Eigen::MatrixXd::Ones(1, 1);
  return linear;
}

SemilinearSolver::Beginning From(const Eigen::VectorXd& y, double longest_step_s) {
  return {.t_s = 0,
          .y = y,
          .scale = y.cwiseAbs(),
          .integral_scale = Eigen::VectorXd::Ones(1),
          .longest_step_s = longest_step_s};
}

// y' = y - y^2, y(0) = 0.01: y = 1 / (1 + 99 exp(-t)), its integral log((exp(t) + 99) / 100)
TEST(SemilinearSolver, FollowsTheLogisticCurveAsCloselyAsAsked) {
  double error_before = 1;
  for (const double relative : {1e-3, 1e-6, 1e-9, 1e-12}) {
    Problem problem(OneState(1, -1), [](double y) { return y * y; });
    SemilinearSolver solver(problem, relative);
    solver.Begin(From(Eigen::VectorXd::Constant(1, 0.01), 1));
    double worst = 0;
    while (solver.end_s() < 10) {
      ASSERT_TRUE(solver.Step());
      // at the end and within the step, by value and by the polynomial in powers
      for (const double u : {0.3, 1.0}) {
        const double t_s = solver.begin_s() + u * (solver.end_s() - solver.begin_s());
        const double expected = 1 / (1 + 99 * std::exp(-t_s));
        worst = std::max(worst, std::abs(solver.At(t_s)[0] - expected));
        double of_powers = 0;
        const Eigen::MatrixXd& terms = solver.StepTerms();
        for (Eigen::Index k = terms.cols(); k-- > 0;) of_powers = of_powers * u + terms(0, k);
        worst = std::max(worst, std::abs(of_powers - expected));
        const double area = std::log((std::exp(t_s) + 99) / 100);
        worst = std::max(worst, std::abs(solver.IntegralsAt(t_s)[0] - area) / 10);
      }
    }
    EXPECT_ABS(worst, 0, relative, "what a step may leave out, of 1");
    EXPECT_LT(worst, error_before);
    error_before = worst;
  }
}

// rates of 1e9/s and 1/s: y2 = exp(-t), y1 = y2 k / (k - 1) and a transient of 1 ns
TEST(SemilinearSolver, AStiffLinearPartIsExactAtAnyStep) {
  constexpr double k = 1e9;
  Eigen::Matrix2d a;
  a << -k, k, 0, -1;
  Problem problem(LinearOf(a));
  SemilinearSolver solver(problem, 1e-12);
  solver.Begin(From(Eigen::Vector2d(0, 1), 0.5));
  while (solver.end_s() < 10) {
    ASSERT_TRUE(solver.Step());
    const double slow = std::exp(-solver.end_s());
    EXPECT_REL(solver.At(solver.end_s())[1], slow, 1e-14, "rounding of 50 steps, eps each");
    EXPECT_REL(solver.At(solver.end_s())[0], k / (k - 1) * (slow - std::exp(-k * solver.end_s())),
               1e-14, "the same");
  }
  EXPECT_LT(solver.work().steps, 200) << "30 lengths of step from 1 ns to 0.5 s, some taken twice";
}

// y' = -y + sin(w t): y = (exp(-t) w + sin(w t) - w cos(w t)) / (1 + w^2)
TEST(SemilinearSolver, InputsActThroughTheLinearPart) {
  const double w = 2 * std::numbers::pi;
  SemilinearProblem::Linear linear = LinearOf(Eigen::MatrixXd::Constant(1, 1, -1));
  linear.inputs = Eigen::MatrixXd::Ones(1, 1);
  Problem problem(linear, {}, [&](double t_s) { return std::sin(w * t_s); });
  SemilinearSolver solver(problem, 1e-12);
  SemilinearSolver::Beginning start = From(Eigen::VectorXd::Zero(1), 0.25);
  start.scale[0] = 0.2;
  solver.Begin(start);
  while (solver.end_s() < 20) {
    ASSERT_TRUE(solver.Step());
    const double t_s = solver.end_s();
    const double expected =
        (w * std::exp(-t_s) + std::sin(w * t_s) - w * std::cos(w * t_s)) / (1 + w * w);
    EXPECT_ABS(solver.At(t_s)[0], expected, 1e-13, "what is asked of 0.2, halved");
  }
}

// y' = cos w (t - 1/2 - shift) over [0, 1], a step of which may be odd or even about its middle, so
// that one of the last two coefficients is zero and the other one alone shows what is missing
TEST(SemilinearSolver, EitherOfTheLastTwoCoefficientsKeepsAStepShort) {
  constexpr double w = 20;
  for (const double shift : {0.0, std::numbers::pi / 2 / w}) {
    SemilinearProblem::Linear linear = LinearOf(Eigen::MatrixXd::Zero(1, 1));
    linear.inputs = Eigen::MatrixXd::Ones(1, 1);
    Problem problem(linear, {}, [&](double t_s) { return std::cos(w * (t_s - 0.5 - shift)); });
    SemilinearSolver solver(problem, 1e-6);
    SemilinearSolver::Beginning start = From(Eigen::VectorXd::Zero(1), 1);
    start.scale[0] = 1 / w;
    solver.Begin(start);
    while (solver.end_s() < 1) {
      ASSERT_TRUE(solver.Step());
      for (const double u : {0.2, 0.6, 1.0}) {
        const double t_s = solver.begin_s() + u * (solver.end_s() - solver.begin_s());
        const double y = (std::sin(w * (t_s - 0.5 - shift)) + std::sin(w * (0.5 + shift))) / w;
        EXPECT_ABS(solver.At(t_s)[0] * w, y * w, 4e-6, "what four steps may leave out");
      }
    }
    EXPECT_GE(solver.work().steps, 4) << "half a period each";
  }
}

// y = t is exact at any step; q' = 1 / (1 + (5 (t - 1/2))^2)
TEST(SemilinearSolver, AnIntegralKeepsStepsShortByItself) {
  SemilinearProblem::Linear linear = LinearOf(Eigen::MatrixXd::Zero(1, 1));
  linear.inputs = Eigen::MatrixXd::Ones(1, 1);
  for (const double relative : {1e-4, 1e-8}) {
    Problem problem(
        linear, {}, [](double) { return 1.0; },
        [](double y) { return 1 / (1 + 25 * (y - 0.5) * (y - 0.5)); });
    SemilinearSolver solver(problem, relative);
    SemilinearSolver::Beginning start = From(Eigen::VectorXd::Zero(1), 1);
    start.scale[0] = 1;
    solver.Begin(start);
    while (solver.end_s() < 1) {
      ASSERT_TRUE(solver.Step());
      const double t_s = (solver.begin_s() + solver.end_s()) / 2;
      const double area = (std::atan(5 * (t_s - 0.5)) + std::atan(2.5)) / 5;
      EXPECT_ABS(solver.IntegralsAt(t_s)[0], area, relative, "what a few steps leave out, of 1");
    }
    EXPECT_REL(solver.IntegralsAt(solver.end_s())[0], 2 * std::atan(2.5) / 5, relative, "the same");
    EXPECT_GT(solver.work().steps, 1);
  }
}

// a step is 2^-k s, never longer than asked for
TEST(SemilinearSolver, NoStepIsLongerThanTheLongest) {
  for (const auto& [longest_s, step_s] :
       {std::pair{0.2501, 0.25}, {0.2499, 0.125}, {4.0, 4.0}, {3.99, 2.0}}) {
    Problem problem(LinearOf(Eigen::MatrixXd::Constant(1, 1, -1e-3)));
    SemilinearSolver solver(problem, 1e-6);
    solver.Begin(From(Eigen::VectorXd::Ones(1), longest_s));
    double longest_taken_s = 0;
    for (int step = 0; step < 20; ++step) {
      ASSERT_TRUE(solver.Step());
      longest_taken_s = std::max(longest_taken_s, solver.end_s() - solver.begin_s());
    }
    EXPECT_EQ(longest_taken_s, step_s);
  }
  Problem problem(LinearOf(Eigen::MatrixXd::Ones(1, 1)));
  SemilinearSolver solver(problem, 1e-6);
  EXPECT_DEATH(solver.Begin(From(Eigen::VectorXd::Ones(1), 0)), "check failed");
  EXPECT_DEATH(solver.Begin(From(Eigen::VectorXd::Ones(1), HUGE_VAL)), "check failed");
}

TEST(SolverWork, AddsUp) {
  SolverWork work{.steps = 1, .evaluations = 2, .rejected_steps = 3, .restarts = 4, .operators = 5};
  work += SolverWork{
      .steps = 10, .evaluations = 20, .rejected_steps = 30, .restarts = 40, .operators = 50};
  EXPECT_EQ(work.steps, 11);
  EXPECT_EQ(work.evaluations, 22);
  EXPECT_EQ(work.rejected_steps, 33);
  EXPECT_EQ(work.restarts, 44);
  EXPECT_EQ(work.operators, 55);
}

// y' = y^2 from 1 is infinite at t = 1
TEST(SemilinearSolver, StopsBeforeAPole) {
  Problem problem(OneState(0, 1), [](double y) { return y * y; });
  SemilinearSolver solver(problem, 1e-6);
  solver.Begin(From(Eigen::VectorXd::Ones(1), 0.25));
  int steps = 0;
  while (solver.Step()) ASSERT_LT(++steps, 100'000);
  // y = 1 / (1 - t) has its integral up to where it ended, and the attempts beyond leave no trace
  EXPECT_EQ(solver.begin_s(), solver.end_s());
  EXPECT_REL(solver.IntegralsAt(solver.end_s())[0], std::log(solver.At(solver.end_s())[0]), 1e-6,
             "what is asked for");
  EXPECT_GT(solver.end_s(), 0.999) << "where y is 1000";
  EXPECT_LE(solver.end_s(), 1 + 1e-6) << "what is asked";
}

TEST(SemilinearSolver, StopsWhereAStateIsNoNumber) {
  Problem problem(OneState(-1, 1), [](double) { return std::numeric_limits<double>::quiet_NaN(); });
  SemilinearSolver solver(problem, 1e-6);
  solver.Begin(From(Eigen::VectorXd::Ones(1), 0.25));
  EXPECT_FALSE(solver.Step());
  solver.Begin(From(Eigen::VectorXd::Constant(1, std::nan("")), 0.25));
  EXPECT_FALSE(solver.Step());
}

TEST(SemilinearSolver, ResetLeavesNoTrace) {
  const auto g = [](double y) { return y * y * y; };
  Problem problem(OneState(-1, -1), g), fresh_problem(OneState(-1, -1), g);
  SemilinearSolver used(problem, 1e-8), fresh(fresh_problem, 1e-8);
  used.Begin(From(Eigen::VectorXd::Constant(1, 5.0), 0.25));
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(used.Step());
  used.Reset();
  for (SemilinearSolver* solver : {&used, &fresh}) {
    solver->Begin(From(Eigen::VectorXd::Ones(1), 0.25));
    for (int i = 0; i < 10; ++i) ASSERT_TRUE(solver->Step());
  }
  EXPECT_EQ(used.end_s(), fresh.end_s());
  EXPECT_EQ(used.At(used.end_s()), fresh.At(fresh.end_s()));
}

}  // namespace
}  // namespace haptometer::sim
