#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "dsp/statistics/repeated_measures.h"
#include "tools/study/study_trial.h"

namespace haptometer::tools {

/// The repeats of one subject in one condition.
struct Cell {
  std::vector<std::size_t> trials;  ///< rows of StudyTable::trials that are answered
  std::vector<double> rms_m;        ///< theirs
  std::size_t not_answered = 0;     ///< trials of this cell without a number

  /// Arithmetic mean and mean of ln(RMS); nothing where no trial is answered.
  [[nodiscard]] std::optional<double> mean_m() const;
  [[nodiscard]] std::optional<double> mean_log() const;
};

/// Trials x subjects x conditions. The unit of analysis is the subject: a cell counts as one value.
struct StudyTable {
  std::vector<StudyTrial> trials;
  std::vector<std::string> subjects;     ///< 2 before 10
  std::vector<std::string> conditions;   ///< as asked, then the others, 2 before 10
  std::vector<std::vector<Cell>> cells;  ///< [subject][condition]
  std::size_t repeats = 0;               ///< most answered trials of any cell

  /// Place of a condition; nothing where no trial has it.
  [[nodiscard]] std::optional<std::size_t> Condition(const std::string& name) const;
  /// The logarithms of all answered trials of a cell.
  [[nodiscard]] std::vector<double> Logs(std::size_t subject, std::size_t condition) const;
  /// Cell means, `mean` of each, of the subjects that have all conditions; `whole` tells which
  /// they are.
  [[nodiscard]] dsp::CompleteTable Complete(std::optional<double> (Cell::*mean)() const,
                                            std::vector<std::size_t>* whole) const;
};

/// Sorts trials into cells. Trials without subject or condition get an error, those with a repeat
/// that their cell already has as well; both stay in `trials`. `first` are the conditions in the
/// order in which they are to be shown.
[[nodiscard]] StudyTable MakeStudyTable(std::vector<StudyTrial> trials,
                                        const std::vector<std::string>& first);

}  // namespace haptometer::tools
