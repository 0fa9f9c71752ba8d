#pragma once

#include <optional>
#include <string>

#include "dsp/analysis/band_analysis.h"
#include "tools/document/document.h"

namespace haptometer::tools {

/// What would halve the interval of a band RMS; nothing that would: both empty.
struct Halving {
  std::optional<double> window_s{};  ///< of the steady drive, all else being equal
  std::optional<double> floor_s{};   ///< of a floor file's record, all else being equal
  dsp::RmsCause largest{};           ///< of what no length changes
};

/// With u the standard uncertainty of the RMS, u_T its part from the window's own noise, u_F that
/// of the floor and u_0 the rest, which no length changes:
///
///   T' = T u_T^2 / (u^2/4 - u_F^2 - u_0^2),   F' = F u_F^2 / (u^2/4 - u_T^2 - u_0^2)
///
/// because variances of means fall as 1 / length; empty where a denominator is not above 0. The
/// floor of an interval without drive grows with the record: u_F counts with u_T then. T and F in
/// s.
[[nodiscard]] Halving HowToHalve(const dsp::BandNumbers& numbers);

/// The note that says it, added to `section` where the interval's half is above 1 % of an answered
/// RMS; `subject` is its trial, where there are several.
void AddHalving(const dsp::BandAnalysis& analysis, const std::string& subject,
                document::Section& section);

}  // namespace haptometer::tools
