#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/statistics/distributions.h"

namespace haptometer::tools {

struct ThesisModel;

/// The unit that a number is printed in: 1 `name` = `si` `si_name`.
struct ThesisUnit {
  std::string_view name;
  std::string_view si_name;
  double si = 1;
};

/// What the thesis says of a quantity.
enum class Relation : std::uint8_t {
  kEquals,      ///< a value, true to half a unit of its last digit
  kBelow,       ///< "less than 2 percent", "no later"
  kAbove,       ///< "much longer": more than this
  kNotPrinted,  ///< nothing: ours stands alone
};

/// "equals", "below", "above", "not printed".
[[nodiscard]] std::string_view Name(Relation relation);

/// A quantity of J. Lindsay, "A Mechanical Amplifier for Haptic Feedback", University of
/// Washington, 2013, with what that thesis prints of it.
struct ThesisNumber {
  std::string_view key;    ///< stays: scripts rely on it
  std::string_view group;  ///< of quantities that belong together
  std::string_view where;  ///< "Table 2.3, p. 12"
  std::string_view what;
  ThesisUnit unit;
  double value = 0;      ///< in `unit`; of kNotPrinted nothing
  double half_step = 0;  ///< half a unit of the last printed digit, in `unit`; of a bound nothing
  Relation relation = Relation::kEquals;
};

/// All of them, in the order of the thesis. Nothing but what is printed stands here; what we get
/// is computed (tools/reproduce/reproduce.h).
[[nodiscard]] std::span<const ThesisNumber> ThesisNumbers();

/// The one of that key, which must exist.
[[nodiscard]] const ThesisNumber& ThesisNumberOf(std::string_view key);

/// Its value in the SI unit.
[[nodiscard]] double SiValue(const ThesisNumber& number);

/// What kind of cause it is: how freely it was chosen says how much its hit is worth.
enum class CauseKind : std::uint8_t {
  kReading,   ///< nothing in it was chosen by what is printed
  kTuned,     ///< a number in it was chosen so that it comes near to what is printed
  kRounding,  ///< inputs that round to the printed ones, sought so that it comes near
};

/// "reading", "tuned", "rounding".
[[nodiscard]] std::string_view Name(CauseKind kind);

/// A reading of the thesis, or a fault in its simulation, under which our model gives another
/// number.
struct CandidateCause {
  std::string text;
  double gives = 0;  ///< SI
  /// What it gives where it is worked out from printed numbers, whose last digits are rounded;
  /// nothing: `gives` alone.
  std::optional<dsp::Interval> from_rounded{};
  CauseKind kind = CauseKind::kReading;
};

/// How printed and computed number stand to each other.
enum class RowVerdict : std::uint8_t {
  kReproduced,  ///< ours is within half a unit of the last printed digit, or the relation holds
  kExplained,   ///< ours is not, but what a named cause gives is; "candidate": it is not proved
  kDisagrees,   ///< neither
  kNotPrinted,  ///< the thesis says nothing of it
};

/// "reproduced", "explained", "disagrees", "not printed".
[[nodiscard]] std::string_view Name(RowVerdict verdict);

/// One quantity: printed, computed, compared.
struct ThesisRow {
  std::string_view key;          ///< of its ThesisNumber
  std::optional<double> ours{};  ///< SI, computed in this run; nothing: not determined
  /// 95 % interval of `ours`, where it was measured on generated trials: reproduced means then that
  /// the printed value lies within.
  std::optional<dsp::Interval> interval{};
  std::vector<CandidateCause> candidates{};  ///< causes; none is proved
  std::string remark{};
  /// `ours` as a function of the model, SI; nothing where it does not follow from the printed
  /// inputs.
  std::function<double(const ThesisModel&)> measure{};
  /// `ours` is of trials that this run generated with the printed number as their truth: that it
  /// comes out again is no finding about the thesis.
  bool generated = false;

  [[nodiscard]] const ThesisNumber& number() const { return ThesisNumberOf(key); }
};

/// Whether a number in SI is what the thesis prints: for kEquals to half a unit of its last digit,
/// with 1e-9 of that for the conversion of units.
[[nodiscard]] bool IsAsPrinted(const ThesisNumber& number, double value);

/// Whether what the cause gives, or some of it, is what the thesis prints.
[[nodiscard]] bool Hits(const ThesisNumber& number, const CandidateCause& cause);

[[nodiscard]] RowVerdict VerdictOf(const ThesisRow& row);

/// Of a row that is explained, the kind of the cause that was chosen least freely.
[[nodiscard]] std::optional<CauseKind> ExplainedBy(const ThesisRow& row);

/// ours / printed - 1; nothing where no value is printed, or only a bound.
[[nodiscard]] std::optional<double> DeviationOf(const ThesisRow& row);

}  // namespace haptometer::tools
