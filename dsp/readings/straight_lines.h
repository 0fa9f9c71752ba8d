#pragma once

#include <span>

/// Records that an export drew at a higher rate than their source gave readings.
namespace haptometer::dsp {

/// How many samples there are for each reading of a slower source, where these are joined by
/// straight lines, as an export at another rate joins them; 0 where they are not. A whole number is
/// exact, another one known to 1e-4.
///
/// `cycles_per_sample` is the tone's. Looked at are 8192 samples from the middle, of a fast record
/// every n-th, 40 in a period of the tone at least. Proof: a tenth of them and more lie within
/// rounding (2 steps, StepOf, or 2 of the last of a count of digits, as of %.6g) on steep lines
/// through their neighbours, and these span a fifth of what all do; where the others are has a line
/// in its spectrum that chance gives once in 10^6 times; and at its rate, or a part of it,
/// above 2.05 a period of the tone (a triangle has two corners), 98 % of the samples between
/// corners lie on lines, and 30 % at most of those beside one. Found are exactly two samples for
/// each reading, and 2.2 and more. Not found: lines to which noise was added, or whose corners
/// rounding hides. Cost: a sort and a transform of them.
[[nodiscard]] double RowsBetweenReadings(std::span<const double> samples, double cycles_per_sample);

}  // namespace haptometer::dsp
