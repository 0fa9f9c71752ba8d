#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/effective_scene.h"

/// What simulations of four classes cost to a given error, measured once (docs/sim_cost.csv, which
/// is part of the program), and how fast this machine is beside that one.
namespace haptometer::tools {

/// The thesis's adapter scene from rest, 5 V at 225 Hz, 0.1 s with 1000 outputs, and what limits or
/// bends its motion.
enum class SceneClass : std::uint8_t {
  kLinear,
  kStops,    ///< rigid stops at 0.3 mm, restitution 0.5: 41 impacts
  kContact,  ///< a preload of 0.07 N: contact breaks 21 times
  kSmooth,   ///< a stiffening spring of 3e9 N/m^3, a coil of 1 mJ/K at 100 K/W
};
inline constexpr std::size_t kSceneClasses = 4;
inline constexpr double kLadderDurationS = 0.1;  ///< of each class's run
inline constexpr double kLadderRateHz = 1e4;     ///< of its outputs

/// "linear", "stops", "contact", "smooth", as the ladders have it.
[[nodiscard]] std::string_view NameOf(SceneClass scene_class);

/// The scene of a class.
[[nodiscard]] sim::EffectiveScene LadderScene(SceneClass scene_class);

/// A method at one of its settings. Errors are relative: of the skin's RMS over the second half,
/// and the largest at any output of any state over that state's largest value.
struct Rung {
  SceneClass scene_class = SceneClass::kLinear;
  std::string method{};   ///< "CVODE Adams"
  std::string setting{};  ///< "1e-6"
  double seconds = 0;     ///< of the run, set-up included
  double rms_error = 0;
  double worst_error = 0;  ///< infinite where it is not known, as of a steady state
};

/// The shipped rungs that have an error, in the order of the table.
[[nodiscard]] const std::vector<Rung>& ShippedRungs();

/// Whether a method is this program's own, and not one that the ladders compare it with.
[[nodiscard]] bool IsOwn(std::string_view method);

/// What is asked of a simulation.
enum class Simulated : std::uint8_t { kSkinRms, kWaveform };

/// The error of a rung by what is asked.
[[nodiscard]] double ErrorOf(const Rung& rung, Simulated what);

/// The cheapest of `rungs` for a class whose error is within `accuracy`; of own methods, or of
/// others alone. Null where none is.
[[nodiscard]] const Rung* CheapestRung(std::span<const Rung> rungs, SceneClass scene_class,
                                       Simulated what, double accuracy, bool own);

/// Seconds here over seconds of the shipped ladders, by class.
using MachineRatios = std::array<double, kSceneClasses>;

/// Measures that of a class by this program's run of it. Cost: 0.2 s, of which the best run counts.
[[nodiscard]] double ProbeMachine(SceneClass scene_class);

/// The shipped rungs with their times scaled to this machine.
[[nodiscard]] std::vector<Rung> RungsHere(const MachineRatios& ratios);

/// Measures rungs on this machine: of this program as `simulate --waveforms` plays them, and of
/// SciPy's DOP853 and LSODA where `python3` has SciPy.
///
/// Errors are those of the skin's displacement, against exponential collocation at 1e-12 in steps
/// half as long; of the RMS over the second half. Reports its progress (base/jobs.h). Cost: 2 to 5
/// minutes with SciPy, 3 s without.
[[nodiscard]] std::vector<Rung> MeasureRungs();

}  // namespace haptometer::tools
