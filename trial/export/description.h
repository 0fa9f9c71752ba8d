#pragma once

#include <span>
#include <string>

#include "trial/export/export.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {

/// A line of JSON for each event of `report`, as docs/reference/formats.md gives their keys; where
/// labels were given later, ahead of them one with those as recorded.
[[nodiscard]] std::string EventLinesOf(const ReadReport& report);

/// A line by `say` for each loss and finding of `report`; empty where `say` is.
[[nodiscard]] std::string RemarksOf(const ReadReport& report, const FindingSayer& say);

/// What the columns of an NPY or a WAV do not hold of `recording`, as one JSON document in ASCII:
/// header, stretches, events, remarks, and whether it was closed and its times are known
/// (docs/reference/formats.md). trial/import/exported_trial.h reads it.
///
/// `sample_offsets`: what was subtracted from each channel, in its unit; empty: nothing.
[[nodiscard]] std::string DescriptionOf(const Recording& recording, const FindingSayer& say,
                                        std::span<const double> sample_offsets = {});

}  // namespace haptometer::trial
