#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "tools/analyze/expectation.h"
#include "tools/study/manifest.h"

namespace haptometer::tools {

/// In which order a subject meets the conditions.
enum class SessionOrder : std::uint8_t {
  kBalanced,  ///< rows of a Williams design: each condition in each place, after each other, alike
  kRandom,    ///< each block shuffled
  kGiven,     ///< as they are listed
};

/// "balanced", "random", "given".
[[nodiscard]] std::string_view Name(SessionOrder order);
/// The order of that name; nothing where none has it.
[[nodiscard]] std::optional<SessionOrder> OrderNamed(std::string_view name);

/// A place in the plan: one trial of a subject, or its floor.
struct SessionCell {
  std::string subject;
  std::string condition;    ///< empty: the subject's floor, a trial with the drive off
  std::int64_t repeat = 1;  ///< from 1
  [[nodiscard]] bool is_floor() const { return condition.empty(); }
  friend bool operator==(const SessionCell&, const SessionCell&) = default;
};

/// "subject 3, cone, repeat 2"; "subject 3, floor".
[[nodiscard]] std::string NameOf(const SessionCell& cell);

/// What a session is to record: session.toml (docs/reference/session.md).
struct SessionPlan {
  std::vector<std::string> subjects;
  std::vector<std::string> conditions;
  std::int64_t repeats = 1;
  SessionOrder order = SessionOrder::kBalanced;
  std::int64_t seed = 0;    ///< of kBalanced which condition has which place in the design, of
                            ///< kRandom every block
  bool has_floors = false;  ///< one a subject, before its trials
  double duration_s = 0;    ///< of a trial and of a floor
  std::string expect;       ///< acceptance limits, as analyze --expect; empty: none
  std::optional<double> drive_frequency_hz = {};  ///< written into the trials, with the next one
  std::optional<double> drive_amplitude_v = {};
  std::vector<PlannedContrast> contrasts = {};  ///< what `study` compares; empty: as it does
  std::vector<std::string> source;  ///< the sensor and its options, as acquire has them; a folder
  /// Of a folder the files that were there when the session was made (watched_folder.h).
  std::vector<std::string> files_before{};
};

inline constexpr std::size_t kMostSubjects = 1000;
inline constexpr std::size_t kMostConditions = 100;
inline constexpr std::int64_t kMostRepeats = 1000;
inline constexpr std::size_t kMostCells = 100'000;

/// "8" is the names 1 to 8, "ann,ben" are two names. Errors (Cause::kUsage): a number that is not
/// whole, or not from 1 to kMostSubjects.
[[nodiscard]] Result<std::vector<std::string>> ReadSubjects(const std::string& text);

/// "a,b" is two names; none of an empty text.
[[nodiscard]] std::vector<std::string> NamesIn(const std::string& text);

/// Errors (Cause::kUsage), naming `where`: a name that is empty, is not printable or has blanks at
/// its ends; two names that differ by case, blanks or not at all; too many cells; a duration that
/// is not above 0 or beyond 30 years; a contrast of no two conditions, or one of before, also
/// turned round; limits that are none.
[[nodiscard]] Result<void> CheckPlan(const SessionPlan& plan, const std::string& where);

/// What a trial of the plan has to keep to: SessionPlan::expect, and the tone within 1 % of the
/// drive's frequency where only that is planned.
[[nodiscard]] Expectation ExpectationOf(const SessionPlan& plan);

/// How many contrasts a study of the plan tests: those planned, or all conditions against the
/// first.
[[nodiscard]] std::size_t ContrastsOf(const SessionPlan& plan);

/// How many rows the Williams design of the plan's conditions has: n, or 2n where n is odd.
[[nodiscard]] std::size_t DesignRows(const SessionPlan& plan);

/// The mean difference, in standard deviations of the subjects' differences, that the paired t
/// tests of the study show with 80 % power at 5 %, two-sided; of several contrasts by the level of
/// Holm's first step, 5 % over their number. Nothing of one subject or one condition, or where it
/// cannot be computed (dsp::NoncentralityForPower).
[[nodiscard]] std::optional<double> DetectableEffect(const SessionPlan& plan);

/// The plan as session.toml, which ParsePlan() reads as the same.
[[nodiscard]] std::string TomlOf(const SessionPlan& plan);

/// Reads session.toml strictly. Errors: as TomlTable and CheckPlan.
[[nodiscard]] Result<SessionPlan> ParsePlan(std::string_view text, const std::string& where);

/// All cells in the order in which they are to be recorded: subject by subject, each with its floor
/// first, then a block of all conditions for each repeat.
///
/// kBalanced: of n conditions a Williams design has n rows, 2n where n is odd; block r of subject s
/// has row (s + r) modulo their number (E. J. Williams, Aust. J. Sci. Res. A 2, 149, 1949), so the
/// design is complete where the subjects are a multiple of its rows. The same plan gives the same
/// order on every machine. Cost: one pass.
[[nodiscard]] std::vector<SessionCell> CellsOf(const SessionPlan& plan);

}  // namespace haptometer::tools
