// What accuracy costs in a simulation: prints docs/sim_cost.csv (fixtures/generate/sim_cost.py runs
// and draws it). The thesis's adapter scene from rest, 0.1 s, 1000 outputs asked of every method:
// linear, with stops, with breaking contact, with a stiffening spring and a coil that heats. Errors
// are the largest at any output, state by state, over the state's largest value, against the same
// motion in 113 bits. Then what each effect is worth (sim_cost_effects.h).
#include <fmt/core.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "bench/sim_cost_effects.h"
#include "bench/sim_cost_ours.h"
#include "bench/sim_cost_peers.h"
#include "bench/sim_cost_rung.h"
#include "bench/sim_cost_truth.h"
#include "sim/linear/steady_state.h"
#include "tests/sim/reference/linear_reference.h"

namespace haptometer::sim {
namespace {

// how a class of scenes is answered
class Ladder {
 public:
  Ladder(const Question& question, int runs)
      : question_(question), runs_(runs), truth_(TruthOf(question)) {}

  template <typename Run>
  void Climb(const std::string& method, const std::string& setting, const Run& run) const {
    Measure({.scene = question_.name,
             .method = method,
             .setting = setting,
             .run = [&](std::size_t outputs) { return run(question_, outputs); },
             .runs = runs_},
            truth_);
  }

  void Ours(std::initializer_list<int> digits) const {
    for (const int digit : digits) {
      Climb("SmoothMotion", Power(digit), [&](const Question& question, std::size_t outputs) {
        return BySmoothMotion(question, outputs, std::pow(10.0, -digit));
      });
    }
  }

  void Cvode(std::initializer_list<int> digits) const {
    for (const auto& [name, method] :
         {std::pair{"CVODE BDF", Multistep::kBdf}, std::pair{"CVODE Adams", Multistep::kAdams}}) {
      for (const int digit : digits) {
        Climb(name, Power(digit), [&](const Question& question, std::size_t outputs) {
          return ByCvode(question, outputs, method, ToleranceOf(digit));
        });
      }
    }
  }

  void OneStepMethods(std::initializer_list<int> digits) const {
    for (const auto& [name, stages] : {std::pair{"ARKODE explicit", Stages::kExplicit},
                                       std::pair{"ARKODE implicit", Stages::kImplicit}}) {
      for (const int digit : digits) {
        Climb(name, Power(digit), [&](const Question& question, std::size_t outputs) {
          return ByArkode(question, outputs, stages, ToleranceOf(digit));
        });
      }
    }
    for (const int digit : digits) {
      Climb("odeint dopri5", Power(digit), [&](const Question& question, std::size_t outputs) {
        return ByDopri5(question, outputs, ToleranceOf(digit));
      });
    }
  }

  void FixedSteps(std::initializer_list<int> inners) const {
    for (const auto& [name, method] :
         {std::pair{"Runge-Kutta 4", FixedStep::kRungeKutta4},
          std::pair{"semi-implicit Euler", FixedStep::kSemiImplicitEuler}}) {
      for (const int inner : inners) {
        Climb(name, StepOf(inner), [&](const Question& question, std::size_t outputs) {
          return ByFixedSteps(question, outputs, method, inner);
        });
      }
    }
  }

  [[nodiscard]] std::string StepOf(int inner) const {
    return fmt::format("{:.3g} us", 1e6 / (question_.rate_hz * inner));
  }

 private:
  static std::string Power(int digits) { return fmt::format("1e-{}", digits); }
  [[nodiscard]] Tolerance ToleranceOf(int digits) const {
    return {.relative = std::pow(10.0, -digits), .largest = truth_.largest};
  }

  Question question_;
  int runs_;
  Truth truth_;
};

// the steady state alone, which is another question: its RMS against 50 digits
void Phasor(int runs) {
  const Scene scene = SceneOf({});
  SteadyState steady;
  const double time_us = BestMicroseconds(runs, [&] { steady = SolveSteadyState(scene); });
  fmt::print("linear,phasor,,{:.3g},,,,,,{:.3g},,,,,,,,,\n", time_us,
             std::abs(steady.skin_rms_m / tests::kAdapterSkinRmsM - 1));
}

void Linear(std::size_t outputs, int runs) {
  Phasor(runs);
  const Question question{.name = "linear", .outputs = outputs};
  const Ladder ladder(question, runs);
  ladder.Climb("exact steps", "", ByExactSteps);
  ladder.Climb("exact one by one", "", ByQuestions);
  ladder.Climb("exact with events", "", ByPieces);
  for (const auto& [name, hold] : {std::pair{"input held", Hold::kZeroOrder},
                                   std::pair{"input joined by lines", Hold::kFirstOrder}}) {
    for (const int inner : {1, 4, 16, 64}) {
      ladder.Climb(name, ladder.StepOf(inner), [&](const Question& that, std::size_t count) {
        return ByHolding(that, count, hold, inner);
      });
    }
  }
  ladder.Ours({2, 4, 6, 8, 10, 12});
  ladder.Cvode({3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  ladder.OneStepMethods({3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  ladder.FixedSteps({4, 7, 8, 16, 32, 64, 128});
  // the same 0.1 s at other rates
  for (const int outputs_of : {10, 100, 10000}) {
    Question other = question;
    other.rate_hz = 10.0 * outputs_of;
    other.outputs = outputs * static_cast<std::size_t>(outputs_of) / 1000;
    if (other.outputs == 0) continue;
    Ladder(other, runs)
        .Climb("exact steps", fmt::format("{} outputs", other.outputs), ByExactSteps);
  }
}

void WithEvents(const Question& question, int runs) {
  const Ladder ladder(question, runs);
  ladder.Climb("exact with events", "", ByPieces);
  ladder.Ours({2, 4, 6, 8, 10, 12});
  ladder.Cvode({3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  ladder.FixedSteps({4, 8, 16, 32, 64, 128, 256});
}

void Smooth(const Question& question, int runs) {
  const Ladder ladder(question, runs);
  ladder.Ours({2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  ladder.Cvode({3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  ladder.OneStepMethods({3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  ladder.FixedSteps({4, 8, 16, 32, 64, 128});
}

int Run(std::size_t outputs, int runs) {
  const ReferenceDifferences apart = DifferencesToReferences();
  if (!(apart.fifty_digits < 1e-14) || !(apart.scipy < 1e-10)) {
    fmt::print(stderr, "the reference is wrong: {:.2g} and {:.2g} off its own references\n",
               apart.fifty_digits, apart.scipy);
    return 1;
  }
  Linear(outputs, runs);
  WithEvents({.name = "stops", .gap_m = 0.3e-3, .restitution = 0.5, .outputs = outputs}, runs);
  WithEvents({.name = "contact", .preload_n = 0.07, .outputs = outputs}, runs);
  Smooth({.name = "smooth",
          .cubic_n_per_m3 = 3e9,
          .heat_capacity_j_per_k = 1e-3,
          .thermal_resistance_k_per_w = 100,
          .outputs = outputs},
         runs);
  MeasureEffects(outputs, runs);
  return 0;
}

}  // namespace
}  // namespace haptometer::sim

// sim_cost [OUTPUTS RUNS]
int main(int argc, char** argv) {
  const int outputs = argc > 2 ? std::atoi(argv[1]) : 1000;
  const int runs = argc > 2 ? std::atoi(argv[2]) : 20;
  return haptometer::sim::Run(static_cast<std::size_t>(outputs), runs);
}
