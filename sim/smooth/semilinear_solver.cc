#include "sim/smooth/semilinear_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "base/circular_functions.h"
#include "base/elementary_functions.h"
#include "base/error.h"
#include "sim/linear/driven_step.h"

namespace haptometer::sim {
namespace {

constexpr Eigen::Index kDegree = 10;
constexpr Eigen::Index kNodes = kDegree + 1;
// terms of the exponential's series for |A| h <= 1: 1/20! is 4e-19
constexpr int kSeriesTerms = 20;
// sweeps of the fixed-point iteration, each of which should gain at least half a digit
constexpr int kMostSweeps = 20;
// the iteration ends where a sweep changes a reading by less than this part of what is allowed, or
// by rounding
constexpr double kSweepPart = 0.1;
constexpr double kSweepRounding = 4 * std::numeric_limits<double>::epsilon();
// the last two coefficients grow by 2^9 and 2^10 where a step is doubled, and some more for safety
constexpr double kDoublingPart = 0.25 / (std::int64_t{1} << kDegree);
// what rounding leaves in the last coefficients, over the largest value: a step is tried doubled
// below it too, but after a rejection not before so many steps
constexpr double kCoefficientRounding = 0x1p-48;
constexpr int kStepsAfterRejection = 8;
// The first step after a beginning may leave out this part of what others may: a transient that
// it does not resolve looks like small last coefficients.
constexpr double kFirstPart = 1.0 / 32;
// a step this many times shorter than the longest is too short
constexpr int kMostHalvings = 60;
// below this a state counts as never moved; its weight stays a number
constexpr double kLeastScale = 1e-150;

using NodeMatrix = Eigen::Matrix<double, kNodes, kNodes>;
using NodeVector = Eigen::Matrix<double, kNodes, 1>;
using Values = Eigen::Matrix<double, kNodes, Eigen::Dynamic>;  // at the nodes, column by column
using Linear = SemilinearProblem::Linear;

// T_k(2 u - 1), k = 0 ... 10, by their recurrence
NodeVector ChebyshevAt(double u) {
  NodeVector values;
  const double x = 2 * u - 1;
  values[0] = 1;
  values[1] = x;
  for (Eigen::Index k = 2; k < kNodes; ++k) values[k] = 2 * x * values[k - 1] - values[k - 2];
  return values;
}

// Polynomials on [0, 1] that are known by their values at Chebyshev's extreme points, ascending.
struct Nodes {
  NodeVector u;
  NodeMatrix to_chebyshev;  // values to coefficients of T_k(2 u - 1)
  NodeMatrix to_powers;     // these to coefficients of u^k
  // values to those of the same polynomial over [0, 1/2], over [1/2, 1] and over [0, u_j]
  NodeMatrix first_half, second_half;
  std::array<NodeMatrix, kNodes> up_to;
  // (m, i): integral of (1 - r)^m / m! times the polynomial that is 1 at the i-th node only
  Eigen::Matrix<double, kSeriesTerms, kNodes> moments;
  NodeVector integral;  // the same for m = 0: Clenshaw and Curtis's weights

  Nodes() {
    for (Eigen::Index j = 0; j < kNodes; ++j) {
      u[j] = (1 - Cos(static_cast<double>(j) * std::numbers::pi / kDegree)) / 2;
    }
    u[kDegree] = 1;
    SetChebyshev();
    SetPowers();
    first_half = ValuesOver(0, 0.5);
    second_half = ValuesOver(0.5, 1);
    for (std::size_t j = 0; j < kNodes; ++j) {
      up_to[j] = ValuesOver(0, u[static_cast<Eigen::Index>(j)]);
    }
    SetMoments();
  }

  // values at u from values at the nodes
  [[nodiscard]] Eigen::Matrix<double, 1, kNodes> At(double u_there) const {
    return ChebyshevAt(u_there).transpose() * to_chebyshev;
  }

 private:
  // the discrete cosine transform: c_k = 2/10 sum'' f_j T_k(x_j), first and last halved
  void SetChebyshev() {
    for (Eigen::Index j = 0; j < kNodes; ++j) {
      const bool is_end = j == 0 || j == kDegree;
      for (Eigen::Index k = 0; k < kNodes; ++k) {
        const double angle = static_cast<double>(k * (kDegree - j)) * std::numbers::pi / kDegree;
        const bool is_outer = k == 0 || k == kDegree;
        to_chebyshev(k, j) = 2.0 / kDegree * Cos(angle) * (is_end ? 0.5 : 1) * (is_outer ? 0.5 : 1);
      }
    }
  }
  // T_(k+1) = 2 (2 u - 1) T_k - T_(k-1), coefficient by coefficient; whole numbers, exact
  void SetPowers() {
    to_powers.setZero();
    to_powers(0, 0) = 1;
    to_powers(0, 1) = -1;
    to_powers(1, 1) = 2;
    for (Eigen::Index k = 1; k < kDegree; ++k) {
      to_powers.col(k + 1) = -2 * to_powers.col(k) - to_powers.col(k - 1);
      to_powers.col(k + 1).tail(kDegree) += 4 * to_powers.col(k).head(kDegree);
    }
  }
  [[nodiscard]] NodeMatrix ValuesOver(double from, double to) const {
    NodeMatrix values;
    for (Eigen::Index j = 0; j < kNodes; ++j) values.row(j) = At(from + (to - from) * u[j]);
    return values;
  }
  // by Clenshaw and Curtis's rule of 33 points, exact up to degree 32: the integral of T_k over
  // [-1, 1] is 2 / (1 - k^2) for even k
  void SetMoments() {
    constexpr int kPoints = 32;
    moments.setZero();
    for (int p = 0; p <= kPoints; ++p) {
      const double angle = p * std::numbers::pi / kPoints;
      double weight = 0;
      for (int k = 0; k <= kPoints; k += 2) {
        const double half = k == 0 || k == kPoints ? 0.5 : 1;
        weight += half * 2 / (1 - static_cast<double>(k) * k) * Cos(k * angle);
      }
      weight *= (p == 0 || p == kPoints ? 0.5 : 1.0) / kPoints;
      const double r = (1 - Cos(angle)) / 2;
      double term = weight;  // weight (1 - r)^m / m!
      for (int m = 0; m < kSeriesTerms; ++m, term *= (1 - r) / m) moments.row(m) += term * At(r);
    }
    integral = moments.row(0).transpose();
  }
};

const Nodes& TheNodes() {
  static const Nodes nodes;
  return nodes;
}

// What a step of one length does to the nodes behind its beginning, stacked node by node.
struct Operators {
  double step_s = 0;
  Eigen::MatrixXd states;             // (10 n, n): exp(A u_j h) - 1
  Eigen::MatrixXd inputs;             // (10 n, 11 m): of B u, by the values of u at the nodes
  Eigen::MatrixXd feedback;           // (10 n, 11 k): of P g
  Eigen::MatrixXd feedback_readings;  // (10 r, 11 k): of these in R y
  Eigen::MatrixXd influence;          // (n, k): bounds of what 1 of g moves y by until the end
};

// The operators of steps of 2^-level s for one linear system.
//
// Behind each stand the propagators over [0, u_j h], balanced: F_j = exp(A u_j h) - 1, whose
// entries keep their digits where a slow state stands beside fast ones, and Z_j, of each source's
// polynomial over [0, u_j h], given by its values at the nodes of that interval, the response at
// the end. Z is kept transposed, a column for each node, source and state.
class OperatorSet {
 public:
  explicit OperatorSet(const Linear& linear) : linear_(linear), n_(linear.a.rows()) {
    const BalancedMatrix balanced = Balance(linear.a);
    a_ = balanced.matrix;
    scale_ = balanced.scale;
    sources_.resize(n_, linear.inputs.cols() + linear.feedback.cols());
    sources_ << linear.inputs, linear.feedback;
    sources_ = scale_.cwiseInverse().asDiagonal() * sources_;
    const double norm = a_.cwiseAbs().rowwise().sum().maxCoeff();
    base_level_ = norm > 0 ? std::ilogb(norm) + 1 : std::numeric_limits<int>::min();
  }

  // the level at which the series is short; INT_MIN: at any
  [[nodiscard]] int base_level() const { return base_level_; }
  [[nodiscard]] std::int64_t built() const { return static_cast<std::int64_t>(built_.size()); }

  const Operators& At(int level) {
    const auto found = built_.find(level);
    if (found != built_.end()) return found->second;
    if (level >= base_level_) return Keep(level, SeriesAt(level));
    // doubled from the base, each length kept on the way
    if (doubled_.states.size() == 0) {
      doubled_ = SeriesAt(base_level_);
      doubled_level_ = base_level_;
    }
    while (doubled_level_ > level) {
      Double(doubled_);
      Keep(--doubled_level_, doubled_);
    }
    return built_.at(level);
  }

 private:
  struct Propagators {
    Eigen::MatrixXd states;  // (n, 10 n)
    Values responses;        // (11, 10 s n)
  };

  [[nodiscard]] Eigen::Index SourceCount() const { return sources_.cols(); }
  [[nodiscard]] Eigen::Index Columns() const { return n_ * SourceCount(); }  // of a node

  // sums of (A t)^m / m! from m = 1 on, and of (A t)^m times the m-th moment times t
  [[nodiscard]] Propagators SeriesAt(int level) const {
    const double h_s = std::ldexp(1.0, -level);
    Propagators at{Eigen::MatrixXd::Zero(n_, kDegree * n_), Values(kNodes, kDegree * Columns())};
    Eigen::MatrixXd power = Eigen::MatrixXd::Identity(n_, n_);  // (A h)^m
    Eigen::MatrixXd moved(kSeriesTerms, Columns());             // (A h)^m of each source
    NodeVector factor = NodeVector::Ones();                     // u_j^m / m!
    for (Eigen::Index m = 0; m < kSeriesTerms; ++m) {
      for (Eigen::Index j = 0; m > 0 && j < kDegree; ++j) {
        at.states.middleCols(n_ * j, n_) += factor[j + 1] * power;
      }
      if (Columns() > 0) {
        const Eigen::MatrixXd of_sources = power * sources_;
        moved.row(m) = Eigen::Map<const Eigen::RowVectorXd>(of_sources.data(), Columns());
      }
      factor = factor.cwiseProduct(TheNodes().u) / static_cast<double>(m + 1);
      power = (h_s * a_ * power).eval();
    }
    // none of these without sources: an empty matrix has no blocks
    for (Eigen::Index j = 0; Columns() > 0 && j < kDegree; ++j) {
      const double u = TheNodes().u[j + 1];
      Eigen::Matrix<double, kNodes, kSeriesTerms> moments = TheNodes().moments.transpose();
      for (Eigen::Index m = 0; m < kSeriesTerms; ++m) {
        moments.col(m) *= Pow(u, static_cast<double>(m + 1)) * h_s;
      }
      at.responses.middleCols(Columns() * j, Columns()).noalias() = moments * moved;
    }
    return at;
  }

  // F <- 2 F + F F, Z <- (Z + F Z) of the first half + Z of the second
  void Double(Propagators& all) {
    first_.resize(kNodes, all.responses.cols());
    for (Eigen::Index j = 0; j < kDegree; ++j) {
      auto state = all.states.middleCols(n_ * j, n_);
      for (Eigen::Index s = 0; s < SourceCount(); ++s) {
        const Eigen::Index place = Columns() * j + n_ * s;
        const auto response = all.responses.middleCols(place, n_);
        first_.middleCols(place, n_) = response + response.lazyProduct(state.transpose());
      }
      state = (2 * state + state * state).eval();
    }
    const Values second = all.responses;
    all.responses.noalias() = TheNodes().first_half.transpose() * first_;
    all.responses.noalias() += TheNodes().second_half.transpose() * second;
  }

  const Operators& Keep(int level, const Propagators& all) {
    const Eigen::Index m = linear_.inputs.cols(), k = linear_.feedback.cols();
    const Eigen::Index r = linear_.readings.rows();
    Operators operators{.step_s = std::ldexp(1.0, -level),
                        .states = Eigen::MatrixXd(kDegree * n_, n_),
                        .inputs = Eigen::MatrixXd(kDegree * n_, kNodes * m),
                        .feedback = Eigen::MatrixXd(kDegree * n_, kNodes * k),
                        .feedback_readings = Eigen::MatrixXd(kDegree * r, kNodes * k),
                        .influence = Eigen::MatrixXd::Zero(n_, k)};
    for (Eigen::Index j = 0; j < kDegree; ++j) {
      // back to the caller's units, and from polynomials over [0, u_j h] to those over the step
      operators.states.middleRows(n_ * j, n_) = scale_.asDiagonal() *
                                                all.states.middleCols(n_ * j, n_) *
                                                scale_.cwiseInverse().asDiagonal();
      if (Columns() == 0) continue;
      const Values responses = TheNodes().up_to[static_cast<std::size_t>(j) + 1].transpose() *
                               all.responses.middleCols(Columns() * j, Columns());
      for (Eigen::Index s = 0; s < m + k; ++s) {
        auto& whole = s < m ? operators.inputs : operators.feedback;
        whole.block(n_ * j, kNodes * (s < m ? s : s - m), n_, kNodes) =
            scale_.asDiagonal() * responses.middleCols(n_ * s, n_).transpose();
      }
      if (k == 0) continue;
      operators.feedback_readings.middleRows(r * j, r) =
          linear_.readings * operators.feedback.middleRows(n_ * j, n_);
    }
    for (Eigen::Index s = 0; s < k; ++s) {
      const auto at_end = operators.feedback.block(n_ * (kDegree - 1), kNodes * s, n_, kNodes);
      operators.influence.col(s) = at_end.cwiseAbs().rowwise().sum();
    }
    return built_[level] = std::move(operators);
  }

  Linear linear_;
  Eigen::Index n_;
  Eigen::MatrixXd a_;        // balanced
  Eigen::VectorXd scale_;    // of the balance
  Eigen::MatrixXd sources_;  // (n, s): B and P, balanced
  int base_level_;
  Propagators doubled_;
  int doubled_level_ = 0;
  Values first_;  // work space
  std::map<int, Operators> built_;
};

// the larger of the last two Chebyshev coefficients of each row's polynomial
Eigen::VectorXd LastCoefficients(const Eigen::MatrixXd& values) {
  const NodeMatrix& to = TheNodes().to_chebyshev;
  return (values * to.row(kDegree).transpose())
      .cwiseAbs()
      .cwiseMax((values * to.row(kDegree - 1).transpose()).cwiseAbs());
}

}  // namespace

SolverWork& SolverWork::operator+=(const SolverWork& other) {
  steps += other.steps;
  evaluations += other.evaluations;
  rejected_steps += other.rejected_steps;
  restarts += other.restarts;
  operators += other.operators;
  return *this;
}

struct SemilinearSolver::Parts {
  SemilinearProblem* problem;
  double relative;
  std::map<int, OperatorSet> operator_sets{};  // by the number of the linear part
  OperatorSet* operators = nullptr;            // of the present one
  Eigen::VectorXd scale{};
  Eigen::VectorXd integral_scale{};
  int coarsest = 0;  // level of the longest step
  int level = 0;     // of the next attempt
  int steps_to_wait = 0;
  std::optional<int> first_level{};  // of the first step after the last beginning
  bool is_first = true;
  double begin_s = 0;
  double end_s = 0;
  Eigen::VectorXd y{};  // at the end
  // of the last step, at its nodes: states (n, 11), inputs (11, m), rates of the integrals (q, 11)
  Eigen::MatrixXd states{}, inputs{}, rates{};
  Eigen::MatrixXd readings{}, feedback{};  // (r, 11), (11, k)
  Eigen::VectorXd sums{};                  // integrals up to the step's beginning
  Eigen::VectorXd sums_at_end{};
  Eigen::MatrixXd terms{};  // empty: not asked for yet
  SolverWork work{};

  Parts(SemilinearProblem& that_problem, double that_relative)
      : problem(&that_problem), relative(that_relative) {
    HAPTOMETER_CHECK(relative > 0, "relative tolerance {}", relative);
  }

  void Linearise() {
    const int number = problem->Linearise(y);
    operators = &operator_sets.try_emplace(number, problem->linear()).first->second;
  }

  // at a node; empty without inputs
  [[nodiscard]] Eigen::VectorXd InputsAt(Eigen::Index node) const {
    if (inputs.cols() == 0) return {};
    return inputs.row(node).transpose();
  }

  // readings and feedback at the nodes by fixed-point iteration; false: it does not converge
  bool Sweep(const Operators& step) {
    const Linear& linear = problem->linear();
    const Eigen::Index r = linear.readings.rows(), k = linear.feedback.cols();
    feedback.resize(kNodes, k);
    if (k == 0) return true;
    const Eigen::VectorXd size = (linear.readings.cwiseAbs() * scale).cwiseMax(kLeastScale);
    const Eigen::MatrixXd without = linear.readings * states;
    readings = without;
    const double enough = std::max(kSweepPart * relative, kSweepRounding);
    Eigen::VectorXd g(k);
    for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
      for (Eigen::Index j = 0; j < kNodes; ++j) {
        problem->Feedback(InputsAt(j), readings.col(j), g);
        feedback.row(j) = g.transpose();
      }
      work.evaluations += kNodes;
      const Eigen::VectorXd moved =
          step.feedback_readings * Eigen::Map<const Eigen::VectorXd>(feedback.data(), kNodes * k);
      const Eigen::MatrixXd next =
          without.rightCols(kDegree) + Eigen::Map<const Eigen::MatrixXd>(moved.data(), r, kDegree);
      const double change =
          ((next - readings.rightCols(kDegree)).cwiseAbs().rowwise().maxCoeff().array() /
           size.array())
              .maxCoeff();
      readings.rightCols(kDegree) = next;
      if (!std::isfinite(change)) return false;
      // after one sweep alone the remainder falls as h^4, after two as h^6
      if (change <= (sweep == 0 ? kSweepRounding : enough)) return true;
    }
    return false;
  }

  // the step's largest error over what is allowed; infinite where it cannot be computed
  double Attempt(const Operators& step) {
    constexpr double kFailed = std::numeric_limits<double>::infinity();
    const Eigen::Index n = y.size();
    inputs.resize(kNodes, problem->linear().inputs.cols());
    Eigen::VectorXd u(inputs.cols());
    for (Eigen::Index j = 0; u.size() > 0 && j < kNodes; ++j) {
      problem->Inputs(end_s + TheNodes().u[j] * step.step_s, u);
      inputs.row(j) = u.transpose();
    }
    states.resize(n, kNodes);
    states.col(0) = y;
    Eigen::Map<Eigen::VectorXd> behind(states.data() + n, kDegree * n);
    behind.noalias() = step.states * y;
    behind.noalias() +=
        step.inputs * Eigen::Map<const Eigen::VectorXd>(inputs.data(), inputs.size());
    states.rightCols(kDegree).colwise() += y;
    if (!Sweep(step)) return kFailed;
    behind.noalias() +=
        step.feedback * Eigen::Map<const Eigen::VectorXd>(feedback.data(), feedback.size());
    if (!states.allFinite()) return kFailed;
    return ErrorOver(step);
  }

  double ErrorOver(const Operators& step) {
    const double part =
        is_first ? std::min(relative, std::max(kFirstPart * relative, 4 * kCoefficientRounding))
                 : relative;
    const Eigen::VectorXd allowed = part * scale.cwiseMax(states.cwiseAbs().rowwise().maxCoeff());
    Eigen::VectorXd left = LastCoefficients(states);
    if (feedback.cols() > 0) {
      left = left.cwiseMax(step.influence * LastCoefficients(feedback.transpose()));
    }
    const double largest = left.cwiseQuotient(allowed).maxCoeff();
    rates.resize(problem->integrals(), kNodes);
    if (rates.rows() == 0) return largest;
    for (Eigen::Index j = 0; j < kNodes; ++j) {
      problem->IntegralRate(InputsAt(j), states.col(j), rates.col(j));
    }
    if (!rates.allFinite()) return std::numeric_limits<double>::infinity();
    const double of_integrals =
        (step.step_s * LastCoefficients(rates))
            .cwiseQuotient(part * integral_scale.cwiseMax(sums_at_end.cwiseAbs()))
            .maxCoeff();
    return std::max(largest, of_integrals);
  }

  bool Step() {
    if (!y.allFinite()) return Stay();
    Linearise();
    for (;; Halve()) {
      if (level > coarsest + kMostHalvings) return Stay();
      const Operators& step = operators->At(level);
      if (!(end_s + step.step_s > end_s)) return Stay();
      const double error = Attempt(step);
      if (!(error <= 1)) continue;
      Accept(step);
      Double(error);
      return true;
    }
  }

  // no step: what was tried is no part of the solution
  bool Stay() {
    begin_s = end_s;
    sums = sums_at_end;
    terms.resize(0, 0);
    return false;
  }

  void Halve() {
    ++level;
    ++work.rejected_steps;
    steps_to_wait = kStepsAfterRejection;
  }

  void Double(double error) {
    if (steps_to_wait > 0) --steps_to_wait;
    const bool may = steps_to_wait == 0 && error <= kCoefficientRounding / relative;
    if (level > coarsest && (error <= kDoublingPart || may)) --level;
  }

  void Accept(const Operators& step) {
    if (is_first) first_level = level;
    is_first = false;
    ++work.steps;
    begin_s = end_s;
    end_s += step.step_s;
    y = states.col(kDegree);
    scale = scale.cwiseMax(states.cwiseAbs().rowwise().maxCoeff());
    sums = sums_at_end;
    if (rates.rows() > 0) sums_at_end += step.step_s * (rates * TheNodes().integral);
    terms.resize(0, 0);
  }

  [[nodiscard]] double PlaceOf(double t_s) const { return (t_s - begin_s) / (end_s - begin_s); }
};

SemilinearSolver::SemilinearSolver(SemilinearProblem& problem, double relative)
    : parts_(std::make_unique<Parts>(problem, relative)) {}

SemilinearSolver::~SemilinearSolver() = default;

void SemilinearSolver::Begin(const Beginning& beginning) {
  Parts& parts = *parts_;
  HAPTOMETER_CHECK(beginning.longest_step_s > 0 && std::isfinite(beginning.longest_step_s), "{} s",
                   beginning.longest_step_s);
  parts.y = beginning.y;
  parts.scale = beginning.scale.cwiseMax(beginning.y.cwiseAbs()).cwiseMax(kLeastScale);
  parts.integral_scale = beginning.integral_scale.cwiseMax(kLeastScale);
  parts.begin_s = parts.end_s = beginning.t_s;
  parts.sums = parts.sums_at_end = Eigen::VectorXd::Zero(parts.problem->integrals());
  parts.terms.resize(0, 0);
  // the longest step that is a power of two; the first one where the series is short, or as after
  // the last beginning
  parts.coarsest = -std::ilogb(beginning.longest_step_s);
  parts.Linearise();
  parts.level = std::max(
      parts.coarsest, parts.first_level ? *parts.first_level - 1 : parts.operators->base_level());
  parts.is_first = true;
  parts.steps_to_wait = 0;
  ++parts.work.restarts;
}

void SemilinearSolver::Reset() {
  parts_->first_level.reset();
  parts_->scale.setZero();
}

bool SemilinearSolver::Step() { return parts_->Step(); }

double SemilinearSolver::begin_s() const { return parts_->begin_s; }
double SemilinearSolver::end_s() const { return parts_->end_s; }
const Eigen::VectorXd& SemilinearSolver::scale() const { return parts_->scale; }
SolverWork SemilinearSolver::work() const {
  SolverWork work = parts_->work;
  for (const auto& [number, set] : parts_->operator_sets) work.operators += set.built();
  return work;
}

Eigen::VectorXd SemilinearSolver::At(double t_s) const {
  const Parts& parts = *parts_;
  if (t_s == parts.end_s) return parts.y;
  return parts.states * TheNodes().At(parts.PlaceOf(t_s)).transpose();
}

const Eigen::MatrixXd& SemilinearSolver::StepTerms() const {
  Parts& parts = *parts_;
  if (parts.terms.size() > 0) return parts.terms;
  // first to Chebyshev's coefficients, which fall, then to powers: nothing cancels
  const Eigen::MatrixXd chebyshev = parts.states * TheNodes().to_chebyshev.transpose();
  parts.terms = chebyshev * TheNodes().to_powers.transpose();
  return parts.terms;
}

Eigen::VectorXd SemilinearSolver::IntegralsAt(double t_s) const {
  const Parts& parts = *parts_;
  if (parts.begin_s == parts.end_s || parts.rates.rows() == 0) return parts.sums;
  if (t_s == parts.end_s) return parts.sums_at_end;
  // the polynomial's integral over [0, u], by its values over that interval
  const double u = parts.PlaceOf(t_s);
  NodeMatrix there;
  for (Eigen::Index j = 0; j < kNodes; ++j) there.row(j) = TheNodes().At(u * TheNodes().u[j]);
  const NodeVector weights = there.transpose() * TheNodes().integral;
  return parts.sums + (t_s - parts.begin_s) * (parts.rates * weights);
}

}  // namespace haptometer::sim
