#include "fit/least_squares.h"

#include <ceres/cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <glog/logging.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"

namespace haptometer::fit {
namespace {

using Position = Eigen::Index;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// rows that one QR takes in
constexpr Position kStretch = 128;

// The triangle R of a QR decomposition of [J r], taken in by blocks of rows: R'R = [J r]'[J r].
// Columns in which a block is 0 do not take part, so that records cost only their own columns.
class Reduction {
 public:
  Reduction(const LinearRows& rows, const std::vector<std::size_t>& used)
      : whole_(rows.derivatives.data(), std::ssize(rows.residuals),
               static_cast<Position>(rows.columns)),
        residuals_(rows.residuals.data(), std::ssize(rows.residuals)),
        // in reverse: each record's own columns first, so that they do not mix with the others'
        columns_(used.rbegin(), used.rend()),
        triangle_(Eigen::MatrixXd::Zero(count() + 1, count() + 1)) {
    for (Position row = 0; row < residuals_.size(); row += kStretch) {
      TakeIn(row, std::min(kStretch, residuals_.size() - row));
    }
  }

  [[nodiscard]] std::vector<double> reduced() const {
    RowMajor reduced(count() + 1, count() + 1);
    // back in the order of `used`
    reduced.leftCols(count()) = triangle_.leftCols(count()).rowwise().reverse();
    reduced.col(count()) = triangle_.col(count());
    return {reduced.data(), reduced.data() + reduced.size()};
  }

 private:
  [[nodiscard]] Position count() const { return std::ssize(columns_); }

  // of the triangle's column `k`, over some rows
  [[nodiscard]] auto Rows(Position k, Position row, Position taken) const {
    return whole_.col(static_cast<Position>(columns_[static_cast<std::size_t>(k)]))
        .segment(row, taken);
  }

  // columns that a block of rows changes: those in which it is not 0, and those that its
  // elimination fills because the triangle's rows are not 0 there
  [[nodiscard]] std::vector<Position> Touched(Position row, Position taken) const {
    std::vector<Position> touched;
    std::vector<bool> meets(columns_.size(), false);
    for (Position k = 0; k < count(); ++k) {
      const auto at = static_cast<std::size_t>(k);
      if (!meets[at] && (Rows(k, row, taken).array() == 0).all()) continue;
      touched.push_back(k);
      for (Position further = k + 1; further < count(); ++further) {
        if (triangle_(k, further) != 0) meets[static_cast<std::size_t>(further)] = true;
      }
    }
    touched.push_back(count());
    return touched;
  }

  // QR of the triangle's rows of the touched columns with the new rows below: R replaces these rows
  void TakeIn(Position row, Position taken) {
    const auto touched = Touched(row, taken);
    const Position width = std::ssize(touched);
    Eigen::MatrixXd work(width + taken, width);
    Position kept = 0;
    for (const Position k : touched) {
      if ((triangle_.row(k).array() == 0).all()) continue;
      work.row(kept++) = triangle_(k, touched);
    }
    for (Position k = 0; k + 1 < width; ++k) {
      work.col(k).segment(kept, taken) = Rows(touched[static_cast<std::size_t>(k)], row, taken);
    }
    work.col(width - 1).segment(kept, taken) = residuals_.segment(row, taken);
    Eigen::Ref<Eigen::MatrixXd> filled = work.topRows(kept + taken);
    const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(filled);
    for (Position k = 0; k < width; ++k) {
      const Position to = touched[static_cast<std::size_t>(k)];
      triangle_.row(to).setZero();
      // as yet fewer rows than columns: the rest of the triangle stays 0
      if (k >= kept + taken) continue;
      for (Position further = k; further < width; ++further) {
        triangle_(to, touched[static_cast<std::size_t>(further)]) = work(k, further);
      }
    }
  }

  Eigen::Map<const RowMajor> whole_;
  Eigen::Map<const Eigen::VectorXd> residuals_;
  std::vector<std::size_t> columns_;  // in the triangle's order
  Eigen::MatrixXd triangle_;
};

}  // namespace

std::vector<double> ReduceRows(const LinearRows& rows, const std::vector<std::size_t>& used) {
  return Reduction(rows, used).reduced();
}

namespace {

std::vector<std::size_t> FreeColumns(const std::vector<bool>& is_free) {
  std::vector<std::size_t> columns;
  for (std::size_t k = 0; k < is_free.size(); ++k) {
    if (is_free[k]) columns.push_back(k);
  }
  return columns;
}

// The problem over its free parameters, in memory that is kept from one evaluation to the next.
class FreeProblem {
 public:
  FreeProblem(const LeastSquares& problem, const std::vector<bool>& is_free,
              std::vector<double> point)
      : problem_(problem),
        columns_(FreeColumns(is_free)),
        point_(std::move(point)),
        residuals_(problem.residuals) {}

  [[nodiscard]] Position count() const { return std::ssize(columns_); }
  [[nodiscard]] const std::vector<double>& point() const { return point_; }
  [[nodiscard]] Eigen::VectorXd free_point() const {
    return Eigen::Map<const Eigen::VectorXd>(point_.data(), std::ssize(point_))(columns_);
  }
  void MoveTo(const Eigen::Ref<const Eigen::VectorXd>& free_point) {
    Eigen::Map<Eigen::VectorXd>(point_.data(), std::ssize(point_))(columns_) = free_point;
  }

  // |r|; infinite where the problem is not defined
  double Length() {
    if (!problem_.evaluate(point_, residuals_, {})) return kInfinite;
    return Residuals().norm();
  }

  // [J r] in as many rows as it has columns (ReduceRows); false where it is not defined
  bool Reduce(Eigen::MatrixXd* reduced) {
    jacobian_.resize(problem_.residuals * problem_.parameters);
    if (!problem_.evaluate(point_, residuals_, jacobian_)) return false;
    const auto values = ReduceRows({jacobian_, problem_.parameters, residuals_}, columns_);
    *reduced = Eigen::Map<const RowMajor>(values.data(), count() + 1, count() + 1);
    return true;
  }

 private:
  static constexpr double kInfinite = std::numeric_limits<double>::infinity();

  [[nodiscard]] Eigen::Map<const Eigen::VectorXd> Residuals() const {
    return {residuals_.data(), std::ssize(residuals_)};
  }

  const LeastSquares& problem_;
  std::vector<std::size_t> columns_;
  std::vector<double> point_;
  std::vector<double> residuals_;
  std::vector<double> jacobian_;
};

// the reduced problem as one block of residuals over one block of parameters
class Block : public ceres::CostFunction {
 public:
  explicit Block(FreeProblem& problem) : problem_(problem) {
    set_num_residuals(static_cast<int>(problem.count() + 1));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(problem.count()));
  }

  bool Evaluate(double const* const* points, double* residuals, double** jacobians) const override {
    const Position size = problem_.count() + 1;
    problem_.MoveTo(Eigen::Map<const Eigen::VectorXd>(points[0], problem_.count()));
    Eigen::Map<Eigen::VectorXd> out(residuals, size);
    // without slopes only the cost counts: abs(r) in one residual
    if (jacobians == nullptr || jacobians[0] == nullptr) {
      out.setZero();
      out[size - 1] = problem_.Length();
      return std::isfinite(out[size - 1]);
    }
    Eigen::MatrixXd reduced;
    if (!problem_.Reduce(&reduced)) return false;
    out = reduced.col(size - 1);
    Eigen::Map<RowMajor>(jacobians[0], size, size - 1) = reduced.leftCols(size - 1);
    return true;
  }

 private:
  FreeProblem& problem_;
};

// Ceres writes on stderr by glog, regardless of its options, where a problem is not defined or a
// step fails. That is reported as SolverReport; what ends the process is still written.
void SilenceSolver() {
  static const bool silenced = [] {
    FLAGS_minloglevel = google::GLOG_FATAL;
    return true;
  }();
  static_cast<void>(silenced);
}

ceres::Solver::Options SolverOptions() {
  constexpr double kRounding = 1e-15;
  constexpr double kFlat = 1e-14;  // of the cost: below, rounding decides about steps
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 1000;
  options.function_tolerance = kFlat;
  options.parameter_tolerance = kRounding;
  options.gradient_tolerance = kRounding;
  options.max_num_consecutive_invalid_steps = 20;
  options.logging_type = ceres::SILENT;
  return options;
}

// the full Gauss-Newton step
struct NewtonStep {
  Eigen::VectorXd change;
  double length = 0;  // of the change of the residuals
};

// -J^+ r with columns of unit length
NewtonStep StepFrom(const Eigen::MatrixXd& reduced) {
  const Position count = reduced.cols() - 1;
  Eigen::MatrixXd scaled = reduced.leftCols(count);
  Eigen::VectorXd lengths = scaled.colwise().norm();
  lengths = (lengths.array() > 0).select(lengths, 1.0);
  scaled *= lengths.cwiseInverse().asDiagonal();
  const Eigen::VectorXd step = -scaled.colPivHouseholderQr().solve(reduced.col(count));
  return {step.cwiseQuotient(lengths), (scaled * step).norm()};
}

// A cost that no longer changes leaves the point uncertain to the root of rounding; steps that
// solve J'r = 0 reach rounding itself. Taken while each is shorter than the one before: where
// residuals are large the way is slow.
void Polish(FreeProblem& problem) {
  constexpr int kMostSteps = 50;
  constexpr double kFlat = 1e-9;       // what the cost may rise by and still be flat
  constexpr double kNoChange = 3e-11;  // of the residuals, by the last step
  double previous = std::numeric_limits<double>::infinity();
  Eigen::VectorXd best = problem.free_point();
  Eigen::VectorXd tried = best;
  const double length = problem.Length();
  Eigen::MatrixXd reduced;
  for (int k = 0; k < kMostSteps && problem.Reduce(&reduced); ++k) {
    const NewtonStep step = StepFrom(reduced);
    // no longer shorter by a tenth: rounding, or slow convergence
    if (!(step.length < 0.9 * previous) || step.length == 0) break;
    best = tried;
    previous = step.length;
    tried += step.change;
    problem.MoveTo(tried);
    // a step that increases the cost is not kept
    if (!(problem.Length() <= length * std::sqrt(1 + kFlat))) break;
    if (step.length > kNoChange * length) continue;
    best = tried;
    break;
  }
  problem.MoveTo(best);
}

}  // namespace

SolverReport Minimise(const LeastSquares& problem, const std::vector<bool>& is_free,
                      std::vector<double>* point) {
  HAPTOMETER_CHECK(point->size() == problem.parameters && is_free.size() == problem.parameters,
                   "{} parameters, {} values, {} flags", problem.parameters, point->size(),
                   is_free.size());
  FreeProblem free_problem(problem, is_free, *point);
  if (free_problem.count() == 0) return {true, "nothing is free", 0};

  SilenceSolver();
  Eigen::VectorXd free_point = free_problem.free_point();
  ceres::Problem whole;
  whole.AddResidualBlock(new Block(free_problem), nullptr, free_point.data());
  ceres::Solver::Summary summary;
  ceres::Solve(SolverOptions(), &whole, &summary);
  free_problem.MoveTo(free_point);
  if (summary.termination_type == ceres::CONVERGENCE) Polish(free_problem);
  *point = free_problem.point();
  return {.converged = summary.termination_type == ceres::CONVERGENCE,
          .termination = summary.message,
          .iterations = static_cast<int>(summary.iterations.size())};
}

Jacobian Linearise(const LeastSquares& problem, const std::vector<double>& point) {
  Jacobian jacobian{problem.residuals, problem.parameters, {}, {}};
  jacobian.values.resize(problem.residuals * problem.parameters);
  jacobian.residuals.resize(problem.residuals);
  const bool defined = problem.evaluate(point, jacobian.residuals, jacobian.values);
  HAPTOMETER_CHECK(defined, "{} residuals are not defined here", problem.residuals);
  return jacobian;
}

}  // namespace haptometer::fit
