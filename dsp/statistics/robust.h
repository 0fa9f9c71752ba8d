#pragma once

#include <optional>
#include <span>
#include <vector>

#include "dsp/statistics/complete_table.h"

namespace haptometer::dsp {

/// The middle value, or the mean of the middle two. At least 1 value.
[[nodiscard]] double Median(std::vector<double> values);

/// The spread of repeats about their cell, unmoved by outliers in up to half of the cells: the
/// median over the cells of sd / sqrt(chi2_.5(df) / df), df = repeats - 1, which is the standard
/// deviation for normal values (chi2_.5: the median of chi-square). Cells with one repeat do not
/// count. Nothing without a cell of 2, or where the median is 0.
[[nodiscard]] std::optional<double> RobustWithinDeviation(
    std::span<const std::vector<double>> cells);

/// What is left of a table when condition and subject effects are taken out by median polish (20
/// sweeps; J. W. Tukey, Exploratory Data Analysis, 1977, 11).
[[nodiscard]] CompleteTable MedianPolish(const CompleteTable& table);

/// The standard deviation of the cells that MedianPolish left `left` of, unmoved by outliers:
///   median(|left|) / (mean of the same of standard normal tables of this size)
/// The divisor is measured, on tables drawn with a fixed seed (known to 2 %): a median that is one
/// of the values leaves a 0, so of three conditions a third of all is 0, and sqrt((n - 1)(k - 1) /
/// (n k)), which holds for means, would be twice too large. 2 subjects and 2 conditions at least.
/// Cost: as of 6000 cells, 20 tables at least, 20 ms.
[[nodiscard]] double DeviationOfPolished(const CompleteTable& left);

}  // namespace haptometer::dsp
