// CVODES and ARKODE (sim_cost_peers.h).
#include <arkode/arkode_arkstep.h>
#include <cvodes/cvodes.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <cmath>

#include "bench/sim_cost_peers.h"

namespace haptometer::sim {
namespace {

constexpr long kMostSteps = 10'000'000;  // between two outputs
constexpr std::size_t kMostEvents = 100'000;

// the question as SUNDIALS calls it
struct Asked {
  const Question* question;
  double omega_rad_per_s;
  bool contact = true;
  Eigen::MatrixXd linear;

  explicit Asked(const Question& that)
      : question(&that),
        omega_rad_per_s(AngularFrequency(that)),
        linear(LinearPart(that, contact)) {}
};

int Rate(realtype t_s, N_Vector y, N_Vector rate, void* data) {
  const Asked& asked = *static_cast<const Asked*>(data);
  const double volt = asked.question->bodies.volt * std::sin(asked.omega_rad_per_s * t_s);
  RateOf(*asked.question, asked.contact, volt, N_VGetArrayPointer(y), N_VGetArrayPointer(rate));
  return 0;
}

int Jacobian(realtype /*t_s*/, N_Vector y, N_Vector /*rate*/, SUNMatrix jacobian, void* data,
             N_Vector /*work1*/, N_Vector /*work2*/, N_Vector /*work3*/) {
  const Asked& asked = *static_cast<const Asked*>(data);
  JacobianAt(*asked.question, asked.linear, N_VGetArrayPointer(y), SUNDenseMatrix_Data(jacobian));
  return 0;
}

int Guards(realtype /*t_s*/, N_Vector y, realtype* guards, void* data) {
  const Asked& asked = *static_cast<const Asked*>(data);
  const auto values = GuardsOf(*asked.question, asked.contact, N_VGetArrayPointer(y));
  for (std::size_t k = 0; k < values.size(); ++k) guards[k] = values[k];
  return 0;
}

void BeSilent(int /*code*/, const char* /*module*/, const char* /*function*/, char* /*message*/,
              void* /*data*/) {}

// what both solvers need, freed together
class Parts {
 public:
  Parts(const Question& question, const Tolerance& tolerance) {
    const auto n = static_cast<sunindextype>(question.states());
    SUNContext_Create(nullptr, &context);
    y = N_VNew_Serial(n, context);
    absolute = N_VNew_Serial(n, context);
    matrix = SUNDenseMatrix(n, n, context);
    linear = SUNLinSol_Dense(y, matrix, context);
    double* const tolerances = N_VGetArrayPointer(absolute);
    for (sunindextype k = 0; k < n; ++k) {
      N_VGetArrayPointer(y)[k] = 0;
      // the skin's own position, which is not compared, is as large as the skin's
      const Eigen::Index like = k < tolerance.largest.size() ? k : Eigen::Index{kXs};
      tolerances[k] = 0.1 * tolerance.relative * tolerance.largest(like);
    }
  }
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;
  ~Parts() {
    SUNLinSolFree(linear);
    SUNMatDestroy(matrix);
    N_VDestroy(y);
    N_VDestroy(absolute);
    SUNContext_Free(&context);
  }

  void Keep(Eigen::Index output, Answer* answer) const {
    const Eigen::Index rows = answer->samples.rows();
    answer->samples.col(output) = Eigen::Map<const Eigen::VectorXd>(N_VGetArrayPointer(y), rows);
  }

  SUNContext context = nullptr;
  N_Vector y = nullptr;
  N_Vector absolute = nullptr;
  SUNMatrix matrix = nullptr;
  SUNLinearSolver linear = nullptr;
};

class CvodeRun {
 public:
  CvodeRun(const Question& question, Multistep method, const Tolerance& tolerance)
      : asked_(question), parts_(question, tolerance) {
    solver_ = CVodeCreate(method == Multistep::kBdf ? CV_BDF : CV_ADAMS, parts_.context);
    CVodeInit(solver_, Rate, 0, parts_.y);
    CVodeSetErrHandlerFn(solver_, BeSilent, nullptr);
    CVodeSetUserData(solver_, &asked_);
    CVodeSVtolerances(solver_, tolerance.relative, parts_.absolute);
    CVodeSetLinearSolver(solver_, parts_.linear, parts_.matrix);
    CVodeSetJacFn(solver_, Jacobian);
    CVodeSetMaxNumSteps(solver_, kMostSteps);
    if (!(question.gap_m > 0) && !(question.preload_n > 0)) return;
    CVodeRootInit(solver_, 3, Guards);
    std::array<int, 3> falling{-1, -1, -1};
    CVodeSetRootDirection(solver_, falling.data());
    CVodeSetNoInactiveRootWarn(solver_);
  }
  CvodeRun(const CvodeRun&) = delete;
  CvodeRun& operator=(const CvodeRun&) = delete;
  ~CvodeRun() { CVodeFree(&solver_); }

  // to an output, through the events before it; false when it fails
  bool To(double until_s, Answer* answer) {
    double now_s = 0;
    for (;;) {
      const int flag = CVode(solver_, until_s, parts_.y, &now_s, CV_NORMAL);
      if (flag == CV_SUCCESS) return true;
      if (flag != CV_ROOT_RETURN || answer->events_s.size() == kMostEvents) return false;
      Count(answer);
      std::array<int, 3> fell{};
      CVodeGetRootInfo(solver_, fell.data());
      for (std::size_t guard = 0; guard < fell.size(); ++guard) {
        if (fell[guard] == 0) continue;
        answer->events_s.push_back(now_s);
        Cross(*asked_.question, guard, &asked_.contact, N_VGetArrayPointer(parts_.y));
        if (guard == 2) asked_.linear = LinearPart(*asked_.question, asked_.contact);
      }
      CVodeReInit(solver_, now_s, parts_.y);
    }
  }
  // since the last beginning
  void Count(Answer* answer) const {
    long steps = 0, evaluations = 0;
    CVodeGetNumSteps(solver_, &steps);
    CVodeGetNumRhsEvals(solver_, &evaluations);
    answer->steps += steps;
    answer->evaluations += evaluations;
  }
  [[nodiscard]] const Parts& parts() const { return parts_; }

 private:
  Asked asked_;
  Parts parts_;
  void* solver_ = nullptr;
};

}  // namespace

Answer ByCvode(const Question& question, std::size_t outputs, Multistep method,
               const Tolerance& tolerance) {
  Answer answer = EmptyAnswer(question, outputs);
  CvodeRun run(question, method, tolerance);
  for (std::size_t i = 0; i < outputs; ++i) {
    if (!run.To(question.TimeOf(i + 1), &answer)) {
      answer.failure = "gave up";
      break;
    }
    run.parts().Keep(static_cast<Eigen::Index>(i) + 1, &answer);
  }
  run.Count(&answer);
  return answer;
}

Answer ByArkode(const Question& question, std::size_t outputs, Stages stages,
                const Tolerance& tolerance) {
  Answer answer = EmptyAnswer(question, outputs);
  Asked asked(question);
  const Parts parts(question, tolerance);
  const bool implicit = stages == Stages::kImplicit;
  void* solver = ARKStepCreate(implicit ? nullptr : Rate, implicit ? Rate : nullptr, 0, parts.y,
                               parts.context);
  ARKStepSetErrHandlerFn(solver, BeSilent, nullptr);
  ARKStepSetUserData(solver, &asked);
  ARKStepSetOrder(solver, 5);
  ARKStepSVtolerances(solver, tolerance.relative, parts.absolute);
  ARKStepSetMaxNumSteps(solver, kMostSteps);
  if (implicit) {
    ARKStepSetLinearSolver(solver, parts.linear, parts.matrix);
    ARKStepSetJacFn(solver, Jacobian);
  }
  for (std::size_t i = 0; i < outputs; ++i) {
    double now_s = 0;
    if (ARKStepEvolve(solver, question.TimeOf(i + 1), parts.y, &now_s, ARK_NORMAL) < 0) {
      answer.failure = "gave up";
      break;
    }
    parts.Keep(static_cast<Eigen::Index>(i) + 1, &answer);
  }
  long explicit_count = 0, implicit_count = 0, steps = 0;
  ARKStepGetNumSteps(solver, &steps);
  ARKStepGetNumRhsEvals(solver, &explicit_count, &implicit_count);
  answer.steps = steps;
  answer.evaluations = explicit_count + implicit_count;
  ARKStepFree(&solver);
  return answer;
}

}  // namespace haptometer::sim
