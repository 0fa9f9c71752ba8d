#include "tools/reproduce/reproduction.h"

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "tools/reproduce/row_groups.h"

namespace haptometer::tools {
namespace {

// in the thesis's order, each once
std::vector<ThesisRow> InOrder(std::vector<ThesisRow> rows) {
  const auto numbers = ThesisNumbers();
  HAPTOMETER_CHECK(rows.size() == numbers.size(), "{} rows, {} numbers", rows.size(),
                   numbers.size());
  std::vector<ThesisRow> ordered;
  ordered.reserve(rows.size());
  for (const ThesisNumber& number : numbers) {
    const auto found = std::ranges::find(rows, number.key, &ThesisRow::key);
    HAPTOMETER_CHECK(found != rows.end(), "no row {}", number.key);
    ordered.push_back(std::move(*found));
  }
  return ordered;
}

}  // namespace

Result<Reproduction> Reproduce(const ThesisModel& model, bool with_chain) {
  auto study = RunGeneratedStudy(model);
  if (!study) return std::unexpected(study.error());
  std::vector<ThesisRow> rows = StudyRows(*study);
  for (auto* group : {DisplacementRows, ElectricalRows, OptimumRows, FrequencyRows, RiseRows,
                      ReceptorRows, PrototypeRows}) {
    for (ThesisRow& row : group(model)) rows.push_back(std::move(row));
  }
  Reproduction reproduction{model, *std::move(study), InOrder(std::move(rows)), std::nullopt};
  if (!with_chain) return reproduction;
  auto chain = RunChain(model);
  if (!chain) return std::unexpected(chain.error());
  reproduction.chain = *std::move(chain);
  return reproduction;
}

std::size_t CountOf(const Reproduction& reproduction, RowVerdict verdict) {
  return static_cast<std::size_t>(std::ranges::count_if(
      reproduction.rows,
      [&](const ThesisRow& row) { return !row.generated && VerdictOf(row) == verdict; }));
}

std::size_t CountOf(const Reproduction& reproduction, CauseKind kind) {
  return static_cast<std::size_t>(std::ranges::count_if(
      reproduction.rows,
      [&](const ThesisRow& row) { return !row.generated && ExplainedBy(row) == kind; }));
}

std::size_t CircularRows(const Reproduction& reproduction) {
  return static_cast<std::size_t>(
      std::ranges::count(reproduction.rows, true, &ThesisRow::generated));
}

std::vector<std::string> ReproductionAssumptions() {
  const std::string generated =
      "rows marked * are of trials generated with the printed number, not of the thesis's "
      "recordings: they test the analysis alone";
  return {"printed values are true to half their last digit; 8200 N/m to 50 N/m, 220 Hz to 5 Hz",
          "equation 2.3 with the coil's reaction on the case, as matrix 2.5 has it",
          "the skin's stiffness up to 2000 N/m (text of 2.1.1); Table 2.1 has 1200 N/m",
          "no cause is proved: each is a candidate whose number was computed",
          "a tuned candidate's number was chosen by what is printed",
          "rounding is sought as the set of inputs that comes nearest",
          generated};
}

}  // namespace haptometer::tools
