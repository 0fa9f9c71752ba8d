#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tools/study/study_table.h"

namespace haptometer::tools {

/// A cell with fewer answered trials than the fullest one.
struct MissingTrials {
  std::string subject;
  std::string condition;
  std::size_t answered = 0;
  std::size_t expected = 0;  ///< answered trials of the fullest cell
};

/// A trial, or a whole cell, that stands apart. It is named and counts all the same.
struct Outlying {
  std::string subject;
  std::string condition;
  std::string file;  ///< empty: the whole cell
  double times = 0;  ///< RMS over what its place lets expect
  double score = 0;  ///< distance in robust standard deviations, of logarithms
};

/// Robust standard deviations beyond which a trial or cell is named.
inline constexpr double kOutlyingScore = 5;
/// The least standard deviation of ln(RMS) that a trial or cell is judged by: where repeats agree
/// to less, what differs by less than kOutlyingScore times this is no news to anybody.
inline constexpr double kLeastScatter = 0.01;

/// A way in which the analysis of some trials differs from what was asked.
struct Deviation {
  std::string what;
  std::vector<std::string> files;  ///< in the table's order
  bool all = false;                ///< of all answered trials
};

/// Each deviation of answered trials once, in the order of its first trial.
[[nodiscard]] std::vector<Deviation> FindDeviations(const StudyTable& table);

/// "no noise floor taken off: a.bin, b.bin", or "all 96 trials".
[[nodiscard]] std::string Describe(const Deviation& deviation);

[[nodiscard]] std::vector<MissingTrials> FindMissing(const StudyTable& table);

/// Outlying trials and cells, by logarithms of the RMS and with medians, so that they do not hide
/// themselves:
/// - a trial's distance from its cell's median, against the median within-cell standard deviation
///   (dsp/statistics/repeated_measures.h), in cells of 3 trials or more;
/// - a cell's median less its condition's and its subject's effect (median polish, subjects that
///   have all conditions), against the standard deviation that these residuals tell
///   (dsp::DeviationOfPolished), with 4 subjects and 3 conditions or more.
/// Neither scale counts below kLeastScatter, nor below the relative standard uncertainty that the
/// trial states (a cell: the median of its trials').
[[nodiscard]] std::vector<Outlying> FindOutlying(const StudyTable& table);

}  // namespace haptometer::tools
