#include "sim/smooth/ode_solver.h"

#include <cvodes/cvodes.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <cmath>

#include "base/error.h"

namespace haptometer::sim {
namespace {

// below this a state counts as never moved; its weight stays a number
constexpr double kLeastScale = 1e-150;

OdeProblem::Vector VectorOf(N_Vector vector) {
  return {N_VGetArrayPointer(vector), static_cast<Eigen::Index>(N_VGetLength(vector))};
}
OdeProblem::ConstVector ConstVectorOf(N_Vector vector) {
  return {N_VGetArrayPointer(vector), static_cast<Eigen::Index>(N_VGetLength(vector))};
}

// errors are returned as flags; nothing is printed
void BeSilent(int /*code*/, const char* /*module*/, const char* /*function*/, char* /*message*/,
              void* /*data*/) {}

void Check(int flag) { HAPTOMETER_CHECK(flag == CV_SUCCESS, "CVODES returned {}", flag); }

}  // namespace

OdeWork& OdeWork::operator+=(const OdeWork& other) {
  steps += other.steps;
  evaluations += other.evaluations;
  jacobians += other.jacobians;
  rejected_steps += other.rejected_steps;
  restarts += other.restarts;
  return *this;
}

// what SUNDIALS holds, freed together
struct OdeSolver::Parts {
  const OdeProblem* problem;
  double relative;
  Eigen::VectorXd scale{};
  double longest_step_s = 0;
  double begin_s = 0;
  double end_s = 0;
  int order = 0;  // 0: no step since the beginning
  bool initialised = false;
  OdeWork earlier{};  // before the last beginning
  SUNContext context = nullptr;
  N_Vector y = nullptr;
  N_Vector out = nullptr;
  N_Vector integrals = nullptr;  // null without any
  N_Vector integral_tolerance = nullptr;
  void* solver = nullptr;
  SUNMatrix matrix = nullptr;
  SUNLinearSolver linear = nullptr;

  Parts(const OdeProblem& that_problem, OdeMethod method, double that_relative)
      : problem(&that_problem), relative(that_relative) {
    HAPTOMETER_CHECK(relative > 0, "relative tolerance {}", relative);
    HAPTOMETER_CHECK(SUNContext_Create(nullptr, &context) == 0, "no SUNDIALS context");
    const auto n = static_cast<sunindextype>(problem->states());
    const auto integral_count = static_cast<sunindextype>(problem->integrals());
    y = N_VNew_Serial(n, context);
    out = N_VNew_Serial(n, context);
    if (integral_count > 0) {
      integrals = N_VNew_Serial(integral_count, context);
      integral_tolerance = N_VNew_Serial(integral_count, context);
    }
    solver = CVodeCreate(method == OdeMethod::kBdf ? CV_BDF : CV_ADAMS, context);
    matrix = SUNDenseMatrix(n, n, context);
    HAPTOMETER_CHECK(y && out && solver && matrix, "no memory for {} states", n);
    linear = SUNLinSol_Dense(y, matrix, context);
  }
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;
  ~Parts() {
    CVodeFree(&solver);
    SUNLinSolFree(linear);
    SUNMatDestroy(matrix);
    N_VDestroy(y);
    N_VDestroy(out);
    if (integrals != nullptr) {
      N_VDestroy(integrals);
      N_VDestroy(integral_tolerance);
    }
    SUNContext_Free(&context);
  }

  static const Parts& Of(void* data) { return *static_cast<const Parts*>(data); }

  static int Rate(realtype t_s, N_Vector y, N_Vector rate, void* data) {
    Of(data).problem->Rate(t_s, ConstVectorOf(y), VectorOf(rate));
    // positive: try a shorter step
    return VectorOf(rate).allFinite() ? 0 : 1;
  }
  static int Jacobian(realtype t_s, N_Vector y, N_Vector /*rate*/, SUNMatrix jacobian, void* data,
                      N_Vector /*work1*/, N_Vector /*work2*/, N_Vector /*work3*/) {
    const Eigen::Index n = Of(data).problem->states();
    Of(data).problem->Jacobian(t_s, ConstVectorOf(y), {SUNDenseMatrix_Data(jacobian), n, n});
    return 0;
  }
  static int IntegralRate(realtype t_s, N_Vector y, N_Vector rate, void* data) {
    Of(data).problem->IntegralRate(t_s, ConstVectorOf(y), VectorOf(rate));
    return VectorOf(rate).allFinite() ? 0 : 1;
  }
  // one over the error allowed: relative times the largest value of each state so far
  static int Weights(N_Vector y, N_Vector weights, void* data) {
    const Parts& parts = Of(data);
    VectorOf(weights) =
        (parts.relative * parts.scale.cwiseMax(VectorOf(y).cwiseAbs())).cwiseInverse();
    return VectorOf(weights).allFinite() ? 0 : -1;
  }

  void Initialise(double t_s, OdeMethod method) {
    Check(CVodeInit(solver, Rate, t_s, y));
    Check(CVodeSetErrHandlerFn(solver, BeSilent, nullptr));
    Check(CVodeSetUserData(solver, this));
    Check(CVodeWFtolerances(solver, Weights));
    Check(CVodeSetLinearSolver(solver, linear, matrix));
    Check(CVodeSetJacFn(solver, Jacobian));
    Check(CVodeSetMaxHnilWarns(solver, -1));
    // orders above 2 of BDF are unstable near the imaginary axis: the order is then reduced
    if (method == OdeMethod::kBdf) Check(CVodeSetStabLimDet(solver, SUNTRUE));
    if (integrals == nullptr) return;
    Check(CVodeQuadInit(solver, IntegralRate, integrals));
    // the integrals take part in the control of steps
    Check(CVodeSetQuadErrCon(solver, SUNTRUE));
  }

  [[nodiscard]] OdeWork SinceBeginning() const {
    long steps = 0, evaluations = 0, jacobians = 0, rejected = 0, failed = 0;
    CVodeGetNumSteps(solver, &steps);
    CVodeGetNumRhsEvals(solver, &evaluations);
    CVodeGetNumJacEvals(solver, &jacobians);
    CVodeGetNumErrTestFails(solver, &rejected);
    CVodeGetNumStepSolveFails(solver, &failed);
    return {.steps = steps,
            .evaluations = evaluations,
            .jacobians = jacobians,
            .rejected_steps = rejected + failed,
            .restarts = 1};
  }
};

OdeSolver::OdeSolver(const OdeProblem& problem, OdeMethod method, double relative)
    : parts_(std::make_unique<Parts>(problem, method, relative)) {
  VectorOf(parts_->y).setZero();
  if (parts_->integrals != nullptr) VectorOf(parts_->integrals).setZero();
  parts_->Initialise(0, method);
}

OdeSolver::~OdeSolver() = default;

void OdeSolver::Begin(const Beginning& beginning) {
  Parts& parts = *parts_;
  // CVodeReInit resets the counters, so they are summed up here
  if (parts.initialised) parts.earlier += parts.SinceBeginning();
  parts.initialised = true;
  parts.scale = beginning.scale.cwiseMax(beginning.y.cwiseAbs()).cwiseMax(kLeastScale);
  parts.longest_step_s = beginning.longest_step_s;
  parts.begin_s = parts.end_s = beginning.t_s;
  // before the first step there is no polynomial
  parts.order = 0;
  VectorOf(parts.y) = beginning.y;
  Check(CVodeReInit(parts.solver, beginning.t_s, parts.y));
  Check(CVodeSetMaxStep(parts.solver, beginning.longest_step_s));
  if (parts.integrals == nullptr) return;
  VectorOf(parts.integrals).setZero();
  Check(CVodeQuadReInit(parts.solver, parts.integrals));
  VectorOf(parts.integral_tolerance) =
      parts.relative * beginning.integral_scale.cwiseMax(kLeastScale);
  Check(CVodeQuadSVtolerances(parts.solver, parts.relative, parts.integral_tolerance));
}

bool OdeSolver::Step() {
  Parts& parts = *parts_;
  double end_s = parts.end_s;
  // the target gives the direction and bounds the first step
  const int flag =
      CVode(parts.solver, parts.end_s + parts.longest_step_s, parts.y, &end_s, CV_ONE_STEP);
  if (flag < 0 || !(end_s > parts.end_s) || !VectorOf(parts.y).allFinite()) return false;
  parts.begin_s = parts.end_s;
  parts.end_s = end_s;
  CVodeGetLastOrder(parts.solver, &parts.order);
  parts.scale = parts.scale.cwiseMax(VectorOf(parts.y).cwiseAbs());
  return true;
}

double OdeSolver::begin_s() const { return parts_->begin_s; }
double OdeSolver::end_s() const { return parts_->end_s; }
int OdeSolver::order() const { return parts_->order; }
const Eigen::VectorXd& OdeSolver::scale() const { return parts_->scale; }

Eigen::VectorXd OdeSolver::At(double t_s, int derivative) const {
  if (parts_->order == 0) {
    HAPTOMETER_CHECK(derivative == 0, "derivative {} before the first step", derivative);
    return VectorOf(parts_->y);
  }
  // from the polynomial of the last step
  Check(CVodeGetDky(parts_->solver, t_s, derivative, parts_->out));
  return VectorOf(parts_->out);
}

Eigen::VectorXd OdeSolver::IntegralsAt(double t_s) const {
  if (parts_->integrals == nullptr) return {};
  if (parts_->order == 0) return Eigen::VectorXd::Zero(parts_->problem->integrals());
  Check(CVodeGetQuadDky(parts_->solver, t_s, 0, parts_->integrals));
  return VectorOf(parts_->integrals);
}

OdeWork OdeSolver::work() const {
  OdeWork work = parts_->earlier;
  if (parts_->initialised) work += parts_->SinceBeginning();
  return work;
}

}  // namespace haptometer::sim
