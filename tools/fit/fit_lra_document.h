#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fit/drop_test/drop_test_fit.h"
#include "tools/document/document.h"
#include "tools/fit/drop_records.h"

namespace haptometer::tools {

/// Everything that fit-lra answers.
struct FitLraAnswer {
  FitLraInput input;
  std::optional<fit::DropTestFit> fit{};  ///< absent: no record could be fitted
  fit::Findings doubts{};                 ///< what is unlike an actuator
  std::vector<std::string> required{};    ///< "Km": constants without which there is no answer
};

/// What the findings of statements say.
[[nodiscard]] document::Sentence SentenceOf(StatementFinding kind);

/// The answer as a document (docs/reference/fit-lra.md): the constants, the budget of their
/// uncertainties, records, given numbers, and what was found; where nothing could be fitted, the
/// same keys without values. Its figures, where they are asked for, are those of FitLraFigures.
[[nodiscard]] document::Document FitLraDocument(const FitLraAnswer& answer, bool has_figures);

}  // namespace haptometer::tools
