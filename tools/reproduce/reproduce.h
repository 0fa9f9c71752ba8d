#pragma once

#include <optional>
#include <vector>

#include "base/error.h"
#include "tools/reproduce/sensor_chain.h"
#include "tools/reproduce/study_rows.h"
#include "tools/reproduce/thesis_model.h"
#include "tools/reproduce/thesis_numbers.h"

namespace haptometer::tools {

/// The thesis, computed anew.
struct Reproduction {
  ThesisModel model;
  GeneratedStudy study;
  std::vector<ThesisRow> rows;                 ///< one for each of ThesisNumbers(), in their order
  std::optional<std::vector<ChainRow>> chain;  ///< where it was asked for
};

/// Computes every row of ThesisNumbers() with the rooms as they are: nothing of it is stored.
///
/// Cost: some 2 s, most of it the analysis of 96 generated trials. Errors: as RunGeneratedStudy and
/// RunChain.
[[nodiscard]] Result<Reproduction> Reproduce(const ThesisModel& model, bool with_chain);

/// How many rows have that verdict, those of generated trials not counted.
[[nodiscard]] std::size_t CountOf(const Reproduction& reproduction, RowVerdict verdict);
/// How many rows are explained by a cause of that kind and by none that was chosen less freely.
[[nodiscard]] std::size_t CountOf(const Reproduction& reproduction, CauseKind kind);
/// How many rows are of trials that were generated with the printed number as their truth.
[[nodiscard]] std::size_t CircularRows(const Reproduction& reproduction);

/// What the numbers rest on, one sentence each.
[[nodiscard]] std::vector<std::string> ReproductionAssumptions();

}  // namespace haptometer::tools
