// What stops and breaking contact cost, for 1000 outputs (0.1 s at 10 kHz) of the adapter scene,
// set-up included: off, on but never reached, reached. And the same stops by SUNDIALS CVODE (BDF,
// its root finding), over the 1/32 s for which 50-digit references exist. Counters: events;
// error_s, the largest error of an event's time; error_state, of the worst state at the end over
// its largest value.
#include <benchmark/benchmark.h>
#include <cvodes/cvodes.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim/linear/linear_model.h"
#include "sim/linear/time_response.h"
#include "sim/piecewise/piecewise_scene.h"
#include "sim/piecewise/stop_modes.h"
#include "tests/sim/reference/events_reference.h"
#include "tests/sim/thesis_scenes.h"
#include "tests/sim/uniform_motion.h"

namespace haptometer::sim {
namespace {

constexpr double kGapM = 0.3e-3;
constexpr double kRestitution = 0.5;
constexpr double kReferenceS = 1.0 / 32;

Scene FromRest() {
  Scene scene = tests::AdapterScene();
  scene.start = Start::kRest;
  return scene;
}

TravelStops Rigid(double gap_m) {
  return {.gap_up_m = gap_m, .gap_down_m = gap_m, .restitution = kRestitution};
}

TravelStops Compliant(double stiffness_n_per_m) {
  TravelStops stops = Rigid(kGapM);
  stops.stiffness_n_per_m = stiffness_n_per_m;
  stops.damping_n_s_per_m = 1;
  return stops;
}

void Run(benchmark::State& state, const PiecewiseEffects& effects, bool with_energy = false) {
  const Scene scene = FromRest();
  double events = 0;
  for (auto _ : state) {
    PiecewiseMotion motion(AssemblePiecewise(scene, effects), scene.drive, PiecewiseStartOf(scene),
                           1e4, with_energy);
    for (int i = 0; i < 1000; ++i) {
      motion.Next();
      benchmark::DoNotOptimize(motion.x().data());
    }
    events = static_cast<double>(motion.events().size());
  }
  state.counters["events"] = events;
}

const PiecewiseEffects kNeverReached{.stops = Rigid(1), .contact_loss = ContactLoss{100}};
const PiecewiseEffects kLift{.contact_loss = ContactLoss{0.07}};
const PiecewiseEffects kStops{.stops = Rigid(kGapM)};
const PiecewiseEffects kAll{.stops = Rigid(kGapM), .contact_loss = ContactLoss{0.07}};

BENCHMARK_CAPTURE(Run, off, PiecewiseEffects{})->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Run, off_with_ledger, PiecewiseEffects{}, true)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Run, stops_never_reached, PiecewiseEffects{.stops = Rigid(1)})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Run, all_never_reached, kNeverReached)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Run, stops_missed_by_8_percent, PiecewiseEffects{.stops = Rigid(0.9e-3)})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Run, rigid_stops, kStops)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Run, stops_of_1e6, PiecewiseEffects{.stops = Compliant(1e6)})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Run, stops_of_1e10, PiecewiseEffects{.stops = Compliant(1e10)})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Run, breaking_contact, kLift)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Run, rigid_stops_and_contact, kAll)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Run, rigid_stops_and_contact_with_ledger, kAll, true)
    ->Unit(benchmark::kMicrosecond);

void LinearAlone(benchmark::State& state) {
  const Scene scene = FromRest();
  for (auto _ : state) {
    const LinearModel model = AssembleModel(scene);
    benchmark::DoNotOptimize(
        UniformMotion(model, scene.drive, Eigen::VectorXd::Zero(7), 0, 1e4, 1001));
  }
}
BENCHMARK(LinearAlone)->Unit(benchmark::kMicrosecond);

// the peaks that errors of states are measured against
Eigen::VectorXd LargestStates() {
  const Scene scene = FromRest();
  return UniformMotion(AssembleModel(scene), scene.drive, Eigen::VectorXd::Zero(7), 0, 1e4, 313)
      .cwiseAbs()
      .rowwise()
      .maxCoeff();
}

void CountErrors(benchmark::State& state, const std::vector<double>& events_s,
                 const Eigen::VectorXd& end) {
  state.counters["events"] = static_cast<double>(events_s.size());
  if (events_s.size() != std::size(tests::kStopsEventsS)) return;
  double worst_s = 0;
  for (std::size_t k = 0; k < events_s.size(); ++k) {
    worst_s = std::max(worst_s, std::abs(events_s[k] - tests::kStopsEventsS[k]));
  }
  const Eigen::VectorXd expected = Eigen::Map<const Eigen::VectorXd>(tests::kStopsState, 7);
  state.counters["error_s"] = worst_s;
  state.counters["error_state"] =
      (end - expected).cwiseAbs().cwiseQuotient(LargestStates()).maxCoeff();
}

void LadderExact(benchmark::State& state) {
  const Scene scene = FromRest();
  std::vector<double> events_s;
  Eigen::VectorXd end;
  for (auto _ : state) {
    PiecewiseMotion motion(AssemblePiecewise(scene, kStops), scene.drive, PiecewiseStartOf(scene),
                           9600);
    for (int i = 0; i < 300; ++i) motion.Next();
    events_s.clear();
    for (const Event& event : motion.events()) events_s.push_back(event.time_s);
    end = motion.Positions();
  }
  CountErrors(state, events_s, end);
}
BENCHMARK(LadderExact)->Unit(benchmark::kMicrosecond);

// the adapter scene for CVODE
struct Peer {
  LinearModel model = AssembleModel(FromRest());
  SineDrive drive = FromRest().drive;
};

Eigen::Map<Eigen::VectorXd> VectorOf(N_Vector vector) {
  return {N_VGetArrayPointer(vector), N_VGetLength(vector)};
}

int Rate(realtype t_s, N_Vector x, N_Vector rate, void* data) {
  const Peer& peer = *static_cast<const Peer*>(data);
  const double volt =
      peer.drive.amplitude_v * std::sin(2 * std::numbers::pi * peer.drive.frequency_hz * t_s);
  VectorOf(rate).noalias() = peer.model.a * VectorOf(x);
  VectorOf(rate) += volt * peer.model.b;
  return 0;
}

int Jacobian(realtype /*t_s*/, N_Vector /*x*/, N_Vector /*rate*/, SUNMatrix jacobian, void* data,
             N_Vector /*work1*/, N_Vector /*work2*/, N_Vector /*work3*/) {
  const Peer& peer = *static_cast<const Peer*>(data);
  Eigen::Map<Eigen::MatrixXd>(SUNDenseMatrix_Data(jacobian), 7, 7) = peer.model.a;
  return 0;
}

int Gaps(realtype /*t_s*/, N_Vector x, realtype* gaps, void* /*data*/) {
  const double travel_m = VectorOf(x)(LinearModel::kMover) - VectorOf(x)(LinearModel::kCase);
  gaps[0] = kGapM - travel_m;
  gaps[1] = kGapM + travel_m;
  return 0;
}

// a run of CVODE with its parts, freed together
class CvodeRun {
 public:
  CvodeRun(Peer& peer, double relative, const Eigen::VectorXd& largest) {
    SUNContext_Create(nullptr, &context_);
    x_ = N_VNew_Serial(7, context_);
    absolute_ = N_VNew_Serial(7, context_);
    VectorOf(x_).setZero();
    VectorOf(absolute_) = 0.1 * relative * largest;
    solver_ = CVodeCreate(CV_BDF, context_);
    matrix_ = SUNDenseMatrix(7, 7, context_);
    linear_ = SUNLinSol_Dense(x_, matrix_, context_);
    CVodeInit(solver_, Rate, 0, x_);
    CVodeSetUserData(solver_, &peer);
    CVodeSVtolerances(solver_, relative, absolute_);
    CVodeSetLinearSolver(solver_, linear_, matrix_);
    CVodeSetJacFn(solver_, Jacobian);
    CVodeSetMaxNumSteps(solver_, 100000);
    CVodeRootInit(solver_, 2, Gaps);
    std::array<int, 2> falling{-1, -1};
    CVodeSetRootDirection(solver_, falling.data());
  }
  CvodeRun(const CvodeRun&) = delete;
  CvodeRun& operator=(const CvodeRun&) = delete;
  ~CvodeRun() {
    CVodeFree(&solver_);
    SUNLinSolFree(linear_);
    SUNMatDestroy(matrix_);
    N_VDestroy(x_);
    N_VDestroy(absolute_);
    SUNContext_Free(&context_);
  }

  // to an output, through the impacts before it; false when it fails
  bool To(double until_s, const Eigen::MatrixXd& up, const Eigen::MatrixXd& down,
          std::vector<double>& events_s) {
    double now_s = 0;
    for (;;) {
      const int flag = CVode(solver_, until_s, x_, &now_s, CV_NORMAL);
      if (flag == CV_SUCCESS) return true;
      if (flag != CV_ROOT_RETURN) return false;
      std::array<int, 2> fell{};
      CVodeGetRootInfo(solver_, fell.data());
      VectorOf(x_) = ((fell[0] != 0 ? up : down) * VectorOf(x_)).eval();
      events_s.push_back(now_s);
      CVodeReInit(solver_, now_s, x_);
    }
  }
  [[nodiscard]] Eigen::VectorXd x() const { return VectorOf(x_); }

 private:
  SUNContext context_ = nullptr;
  N_Vector x_ = nullptr;
  N_Vector absolute_ = nullptr;
  void* solver_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  SUNLinearSolver linear_ = nullptr;
};

// range(0): digits of the relative tolerance; absolute a tenth of it of each state's largest value
void LadderCvode(benchmark::State& state) {
  Peer peer;
  const Scene scene = FromRest();
  const Eigen::MatrixXd up = ImpactMap(scene, Rigid(kGapM), 1, 8).topLeftCorner(7, 7);
  const Eigen::MatrixXd down = ImpactMap(scene, Rigid(kGapM), -1, 8).topLeftCorner(7, 7);
  const Eigen::VectorXd largest = LargestStates();
  const double relative = std::pow(10.0, -static_cast<double>(state.range(0)));
  std::vector<double> events_s;
  Eigen::VectorXd end;
  for (auto _ : state) {
    events_s.clear();
    CvodeRun run(peer, relative, largest);
    for (int i = 1; i <= 300; ++i) {
      if (!run.To(i * kReferenceS / 300, up, down, events_s)) {
        state.SkipWithError("CVODE gave up");
        return;
      }
    }
    end = run.x();
  }
  CountErrors(state, events_s, end);
}
BENCHMARK(LadderCvode)->Arg(3)->Arg(6)->Arg(9)->Arg(12)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace haptometer::sim
