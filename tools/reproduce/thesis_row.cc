#include "tools/reproduce/thesis_row.h"

#include <algorithm>
#include <cmath>

namespace haptometer::tools {
namespace {

// whether some number of the interval is what is printed
bool Overlaps(const ThesisNumber& number, const dsp::Interval& interval) {
  const double nearest = std::clamp(SiValue(number), interval.lower, interval.upper);
  return IsAsPrinted(number, nearest);
}

}  // namespace

std::string_view Name(RowVerdict verdict) {
  switch (verdict) {
    case RowVerdict::kReproduced:
      return "reproduced";
    case RowVerdict::kExplained:
      return "explained";
    case RowVerdict::kDisagrees:
      return "disagrees";
    case RowVerdict::kNotPrinted:
      return "not printed";
  }
  return "disagrees";
}

std::string_view Name(CauseKind kind) {
  switch (kind) {
    case CauseKind::kReading:
      return "candidate cause";
    case CauseKind::kTuned:
      return "tuned candidate";
    case CauseKind::kRounding:
      return "within rounding";
  }
  return "candidate cause";
}

bool IsAsPrinted(const ThesisNumber& number, double value) {
  const double printed = SiValue(number);
  switch (number.relation) {
    case Relation::kEquals:
      return std::abs(value - printed) <= number.half_step * number.unit.si * (1 + 1e-9);
    case Relation::kBelow:
      return value < printed;
    case Relation::kAbove:
      return value > printed;
    case Relation::kNotPrinted:
      return false;
  }
  return false;
}

bool Hits(const ThesisNumber& number, const CandidateCause& cause) {
  return cause.from_rounded ? Overlaps(number, *cause.from_rounded)
                            : IsAsPrinted(number, cause.gives);
}

RowVerdict VerdictOf(const ThesisRow& row) {
  const ThesisNumber& number = row.number();
  if (number.relation == Relation::kNotPrinted) return RowVerdict::kNotPrinted;
  if (row.ours && std::isfinite(*row.ours)) {
    const bool holds =
        row.interval ? Overlaps(number, *row.interval) : IsAsPrinted(number, *row.ours);
    if (holds) return RowVerdict::kReproduced;
  }
  const bool explained = std::ranges::any_of(
      row.candidates, [&](const CandidateCause& cause) { return Hits(number, cause); });
  return explained ? RowVerdict::kExplained : RowVerdict::kDisagrees;
}

std::optional<CauseKind> ExplainedBy(const ThesisRow& row) {
  if (VerdictOf(row) != RowVerdict::kExplained) return std::nullopt;
  for (const CauseKind kind : {CauseKind::kReading, CauseKind::kRounding}) {
    const bool hits = std::ranges::any_of(row.candidates, [&](const CandidateCause& cause) {
      return cause.kind == kind && Hits(row.number(), cause);
    });
    if (hits) return kind;
  }
  return CauseKind::kTuned;
}

std::optional<double> DeviationOf(const ThesisRow& row) {
  const ThesisNumber& number = row.number();
  if (number.relation != Relation::kEquals || !row.ours) return std::nullopt;
  return *row.ours / SiValue(number) - 1;
}

}  // namespace haptometer::tools
