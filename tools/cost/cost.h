#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "fit/experiment_plan.h"
#include "sim/scene/scene.h"
#include "tools/acquire/advise.h"
#include "tools/cost/ladder.h"
#include "tools/document/document.h"

/// What an accuracy costs: of a measured vibration, of an actuator's constants, of a simulation.
///
/// An accuracy of what is measured is half the width of the 95 % interval over the value, as
/// `analyze` and `plan-drop-test --want` have it; of what is simulated the largest relative error,
/// as `simulate --accuracy` has it.
namespace haptometer::tools {

/// The actuator where none is named: that of the thesis, its mass and coil as a lab measures them.
inline constexpr std::string_view kDefaultActuator = "thesis-c10-100";

/// The question of a vibration's RMS.
inline constexpr std::string_view kBandRms = "band-rms";

/// A way to an answer, and its price.
struct CostedMethod {
  std::string method;      ///< "exponential collocation"
  std::string settings{};  ///< "--accuracy 1e-06"
  /// Of computing, on this machine; absent where that is nothing beside the recording.
  std::optional<double> predicted_s{};
  std::optional<double> measured_s{};   ///< the same, of the best of three runs here
  std::optional<double> recording_s{};  ///< of what is recorded for it, all records together
  /// Relative: a bound of a simulation's, else the accuracy that is reached; absent: not known.
  std::optional<double> predicted_error{};
  std::optional<double> measured_error{};  ///< that the answer states
  std::string error_of{};    ///< the scene that the error is of, "this scene"; empty: of no scene
  std::string limited_by{};  ///< "rounding", "moving mass", "wire"
  bool answers = false;      ///< within the accuracy: the measured error, where there is one
  bool is_peer = false;      ///< none of this program's
};

/// An answered question: its methods, those that answer first, then the cheapest.
struct CostAnswer {
  std::string question;  ///< "skin-rms"
  std::string subject;   ///< "fixtures/lra_adapter.toml"
  double accuracy = 0;
  std::vector<CostedMethod> methods{};
  document::Section notes{};  ///< findings: what is assumed, what the prices rest on
};

/// Sorts as CostAnswer has them: by recording where there are recordings, else by computing.
void SortMethods(std::vector<CostedMethod>& methods);

/// What `simulate` would take for the scene at its tolerance, without solving it whole.
///
/// A run of T is timed over T/16 and T/8, twelve periods at least, and continued as a straight
/// line; ten times what the second states of its error, in proportion to the length, is the bound
/// that is predicted. A linear steady state is solved: it takes microseconds. A steady motion under
/// effects is priced by the periods that its search takes (sim/steady_run.h), its error by a
/// hundred times that of a run. What is shorter than these is answered itself, and its error is the
/// prediction. Under smooth effects no more is predicted than is asked for, which the solver keeps
/// or refuses, unless its least tolerance does not reach that.
///
/// @param where names the scene in errors
/// Errors (Cause::kCannotAnswer): as AnswerScene, of the part that is played.
[[nodiscard]] Result<CostedMethod> PriceOf(const sim::Scene& scene, const std::string& where);

/// The methods for a simulated RMS or waveform: this program's, measured where `measure`, then each
/// other method of the ladders by its cheapest rung that is good enough in the ladders' scene of
/// the class, its time scaled by the number of periods and by this machine.
[[nodiscard]] Result<CostAnswer> CostOfSimulation(const sim::Scene& scene, Simulated what,
                                                  const std::string& where, bool measure);

/// The methods for an actuator's constant, by drop tests with 8, 12 and 16 bits and the load that
/// is best for it.
///
/// @param actuator as `plan-drop-test --actuator` has it, NAME or FILE
/// @param accuracy above 0, at most 0.25
/// Errors: as MakeTestCard.
[[nodiscard]] Result<CostAnswer> CostOfConstant(fit::Constant constant, const std::string& actuator,
                                                double accuracy);

/// The methods for a vibration's RMS: the routes of `acquire --advise`; of them those whose name
/// holds `sensor`, in any case of letters. Errors (Cause::kUsage): none holds it.
[[nodiscard]] Result<CostAnswer> CostOfRecording(const RouteQuestion& question,
                                                 const std::string& sensor);

/// What a skin's RMS changes by, relative, with what is not known of its scene.
struct KnowledgeLimit {
  std::string_view input;  ///< "moving mass"
  std::string_view by;     ///< "1 %", "600 to 2000 N/m"
  double change = 0;
};

/// Of the thesis's adapter scene.
[[nodiscard]] std::vector<KnowledgeLimit> KnowledgeLimits();

/// What so many digits of a simulation take: seconds of this program's cheapest method, by what is
/// simulated, and of the cheapest other one for a smooth waveform; absent where none reaches them.
struct DigitPrice {
  int digits = 0;
  std::optional<double> steady_rms_s{};
  std::array<std::optional<double>, kSceneClasses> waveform_s{};
  std::optional<double> others_smooth_s{};
  std::string others_method{};
};

/// The whole chain, from a recording to a waveform.
struct CostChain {
  MachineRatios ratios{};
  std::vector<KnowledgeLimit> knowledge{};
  std::vector<CostAnswer> recordings{};  ///< 10 um at 225 Hz to 10 %, 1 % and 0.1 %
  std::vector<CostAnswer> constants{};   ///< Kv, Bv, Km to 10 %, 1 % and 0.1 %
  std::vector<DigitPrice> simulations{};
  std::vector<Rung> measured{};  ///< here; empty: the shipped ladders, scaled
};

/// Answers it from the ladders, or from rungs that were measured here and those of other programs.
/// Cost: a probe of each class, nine plans: 1.2 s.
[[nodiscard]] Result<CostChain> CostOfChain(std::vector<Rung> measured = {});

/// The chain as a document.
[[nodiscard]] document::Document ChainDocument(const CostChain& chain);

/// The answer to one question as a document (docs/reference/cost.md).
[[nodiscard]] document::Document CostDocument(const CostAnswer& answer);

}  // namespace haptometer::tools
