#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "base/jobs.h"
#include "sim/linear/steady_state.h"
#include "sim/smooth/smooth_motion.h"
#include "sim/waveforms.h"
#include "tools/cost/ladder.h"
#include "tools/plot/script.h"

namespace haptometer::tools {

extern const std::string_view kScipyLadders;  // tools/cost/scipy_ladders.py

namespace {

constexpr std::array kSmoothTolerances{1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-11};
constexpr std::array kScipyTolerances{1e-3, 1e-5, 1e-7, 1e-9, 1e-11};
constexpr std::array<std::string_view, 2> kScipyMethods{"DOP853", "LSODA"};
constexpr MonotonicNs kLongestScipyNs = 60'000'000'000;
constexpr double kTimedS = 0.3;  // spent on the best time of an own rung

// skin displacement at the outputs, m
using Waveform = std::vector<double>;

Waveform Reference(const sim::EffectiveScene& ladder) {
  sim::SmoothMotion motion(sim::AssembleSmooth(ladder.scene, ladder.piecewise, ladder.smooth),
                           ladder.scene.drive, sim::PiecewiseStartOf(ladder.scene),
                           {.rate_hz = kLadderRateHz},
                           {.tolerance = 1e-12, .longest_step_periods = 0.125});
  constexpr auto kOutputs = static_cast<int>(kLadderDurationS * kLadderRateHz);
  constexpr Eigen::Index kSkin = 4;  // behind positions and speeds of mover and case
  Waveform skin_m{0};
  for (int k = 0; k < kOutputs; ++k) {
    motion.Next();
    skin_m.push_back(motion.Positions()(kSkin));
  }
  return skin_m;
}

double RmsOfSecondHalf(const Waveform& skin_m) {
  double sum = 0;
  for (std::size_t k = skin_m.size() / 2; k < skin_m.size(); ++k) sum += skin_m[k] * skin_m[k];
  return std::sqrt(sum);
}

// errors of a waveform against the reference, into the rung; infinite where it is none
void Compare(const Waveform& skin_m, const Waveform& reference_m, Rung& rung) {
  rung.rms_error = rung.worst_error = HUGE_VAL;
  if (skin_m.size() != reference_m.size()) return;
  double peak_m = 0, worst_m = 0;
  for (std::size_t k = 0; k < skin_m.size(); ++k) {
    peak_m = std::max(peak_m, std::abs(reference_m[k]));
    worst_m = std::max(worst_m, std::abs(skin_m[k] - reference_m[k]));
  }
  rung.worst_error = worst_m / peak_m;
  rung.rms_error = std::abs(RmsOfSecondHalf(skin_m) / RmsOfSecondHalf(reference_m) - 1);
}

// seconds of the best of the runs that 0.3 s have room for
double BestTime(const std::function<void()>& run) {
  double best_s = HUGE_VAL;
  for (double spent_s = 0; spent_s < kTimedS;) {
    const auto begin = std::chrono::steady_clock::now();
    run();
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
    spent_s += taken.count();
    best_s = std::min(best_s, taken.count());
  }
  return best_s;
}

Rung OwnRung(SceneClass scene_class, double tolerance, const Waveform& reference_m) {
  sim::EffectiveScene ladder = LadderScene(scene_class);
  ladder.scene.tolerance = tolerance;
  const bool smooth = scene_class == SceneClass::kSmooth;
  Rung rung{.scene_class = scene_class,
            .method = smooth ? "SmoothMotion" : "exact with events",
            .setting = smooth ? fmt::format("{:g}", tolerance) : ""};
  sim::Waveforms waves;
  rung.seconds = BestTime([&] {
    waves = sim::PlayWaveforms(ladder, sim::BeginningOf(ladder), kLadderDurationS, kLadderRateHz);
  });
  Compare({waves.skin_m.begin(), waves.skin_m.end()}, reference_m, rung);
  return rung;
}

// the steady state by phasors; of a run's waveform it is none
Rung PhasorRung() {
  const sim::EffectiveScene ladder = LadderScene(SceneClass::kLinear);
  Rung rung{.scene_class = SceneClass::kLinear, .method = "phasor", .worst_error = HUGE_VAL};
  rung.seconds =
      BestTime([&] { rung.rms_error = sim::SolveSteadyState(ladder.scene).error_estimate; });
  return rung;
}

// a Python that has SciPy: that of the PATH, else the system's
std::optional<std::string> PythonWithScipy() {
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    const auto ended = plot::RunWithin({python, "-"}, "import scipy.integrate\n", kLongestScipyNs);
    if (ended && *ended) return python;
  }
  return std::nullopt;
}

// a run by SciPy; nothing where it fails or takes more than a minute
std::optional<Rung> ScipyRung(const std::string& python, SceneClass scene_class,
                              std::string_view method, double tolerance,
                              const Waveform& reference_m) {
  const plot::MemoryFile out;
  const auto ended = plot::RunWithin({python, "-", out.path(), std::string(NameOf(scene_class)),
                                      std::string(method), fmt::format("{:g}", tolerance)},
                                     std::string(kScipyLadders), kLongestScipyNs);
  if (!ended || !*ended) return std::nullopt;
  // seconds, then the skin's displacement at each output
  std::istringstream content(out.Content());
  Rung rung{.scene_class = scene_class,
            .method = fmt::format("SciPy {}", method),
            .setting = fmt::format("{:g}", tolerance)};
  content >> rung.seconds;
  Waveform skin_m;
  for (double value_m = 0; content >> value_m;) skin_m.push_back(value_m);
  Compare(skin_m, reference_m, rung);
  return std::isfinite(rung.worst_error) ? std::optional(rung) : std::nullopt;
}

}  // namespace

std::vector<Rung> MeasureRungs() {
  std::vector<Rung> rungs{PhasorRung()};
  constexpr double kShare = 1.0 / (kSceneClasses * kScipyMethods.size() * kScipyTolerances.size());
  const auto python = PythonWithScipy();
  int done = 0;
  for (std::size_t k = 0; k < kSceneClasses; ++k) {
    const auto scene_class = static_cast<SceneClass>(k);
    const std::string name(NameOf(scene_class));
    ReportWork("this program, " + name, kShare * done);
    const Waveform reference_m = Reference(LadderScene(scene_class));
    for (const double tolerance : kSmoothTolerances) {
      rungs.push_back(OwnRung(scene_class, tolerance, reference_m));
      // exact methods have no tolerance
      if (scene_class != SceneClass::kSmooth) break;
    }
    if (!python) continue;
    for (const std::string_view method : kScipyMethods) {
      for (const double tolerance : kScipyTolerances) {
        ReportWork(fmt::format("SciPy {}, {}, {:g}", method, name, tolerance), kShare * done++);
        auto rung = ScipyRung(*python, scene_class, method, tolerance, reference_m);
        if (rung) rungs.push_back(*std::move(rung));
      }
    }
  }
  return rungs;
}

}  // namespace haptometer::tools
