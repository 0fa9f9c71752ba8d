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

/// 1.4826 median(|x|), the standard deviation of normal values about 0.
[[nodiscard]] double DeviationFromMedianAbsolute(std::span<const double> values);

}  // namespace haptometer::dsp
