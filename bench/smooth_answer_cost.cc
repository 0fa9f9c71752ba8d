// What an answer that knows its error costs over the cheapest run that would have been right:
//
//   smooth_answer_cost SCENE.toml...
//
// of scenes with smooth effects, each with a duration. The answer is RunScene() at five accuracies:
// it plays looser and finer runs until their difference shows the error. The rungs are single runs
// of eight tolerances with longest steps of a period to an eighth; of those within the accuracy, by
// a run at 4e-12, the fastest is the best one. Prints a line for each scene and accuracy: accuracy,
// seconds of the answer and of the best rung, error estimate and error of the answer. Counted by
// tests/long/answer_cost.py.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "sim/effect_choice.h"
#include "sim/effective_scene.h"
#include "sim/scene/scene_file.h"
#include "sim/scene_run.h"

namespace haptometer::sim {
namespace {

constexpr std::array kAccuracies{1e-2, 1e-4, 1e-6, 1e-8, 1e-10};

double BestSeconds(int repetitions, const std::function<void()>& run) {
  double best_s = HUGE_VAL;
  for (int k = 0; k < repetitions; ++k) {
    const auto begin = std::chrono::steady_clock::now();
    run();
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
    best_s = std::min(best_s, taken.count());
  }
  return best_s;
}

struct Rung {
  double seconds = 0;
  double error = 0;
};

// single runs, their errors against `truth`
std::vector<Rung> RungsOf(const EffectiveScene& scene, double duration_s, const SceneRun& truth) {
  constexpr int kRepetitions = 2;
  std::vector<Rung> rungs;
  for (const double longest : {1.0, 0.5, 0.25, 0.125}) {
    for (double tolerance = 1e-2; tolerance >= 3e-12; tolerance /= 16) {
      SceneRun run;
      const double seconds = BestSeconds(kRepetitions, [&] {
        run = RunSmoothly(scene, duration_s, StartIn(scene), 0,
                          {.tolerance = tolerance, .longest_step_periods = longest});
      });
      rungs.push_back({seconds, LargestDeviation(run, truth)});
    }
  }
  return rungs;
}

void Compare(const Scene& read) {
  constexpr int kRepetitions = 3;
  EffectSet on{};
  for (std::size_t k = 0; k < on.size(); ++k) on[k] = read.effects.wishes[k] != Wish::kOff;
  EffectiveScene scene = WithEffects(read, on);
  const SceneRun truth = RunSmoothly(scene, *read.duration_s, StartIn(scene), 0,
                                     {.tolerance = 4e-12, .longest_step_periods = 0.0625});
  const std::vector<Rung> rungs = RungsOf(scene, *read.duration_s, truth);
  for (const double accuracy : kAccuracies) {
    scene.scene.tolerance = accuracy;
    SceneRun run;
    const double seconds =
        BestSeconds(kRepetitions, [&] { run = RunScene(scene, *read.duration_s, StartIn(scene)); });
    double best_s = HUGE_VAL;
    for (const Rung& rung : rungs) {
      if (rung.error <= accuracy) best_s = std::min(best_s, rung.seconds);
    }
    fmt::print("{:g} {:.6g} {:.6g} {:.3g} {:.3g}\n", accuracy, seconds, best_s, run.error_estimate,
               LargestDeviation(run, truth));
  }
}

}  // namespace
}  // namespace haptometer::sim

int main(int argc, char** argv) {
  using namespace haptometer;
  for (const char* path : std::span(argv, static_cast<std::size_t>(argc)).subspan(1)) {
    const auto scene = sim::ReadSceneFile(path);
    if (!scene || !scene->duration_s) {
      fmt::print(stderr, "{}: {}\n", path, scene ? "no duration" : scene.error().Text());
      return 1;
    }
    sim::Compare(*scene);
  }
  return 0;
}
