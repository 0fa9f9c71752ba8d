#pragma once

#include <string>

#include "tools/fit/drop_records.h"

namespace haptometer::tools {

/// A sweep, and the files that are asked for beside the answer; empty: none.
struct ImpedanceFiles {
  std::string sweep;
  std::string plot;
  std::string save;        ///< see tools/fit/saved_actuator.h
  bool overwrite = false;  ///< of `save`
};

/// Answers `fit-lra --impedance z.csv`: reads the sweep, fits (fit/impedance/impedance_fit.h),
/// prints the constants as text or JSON, draws and saves them. Returns the program's exit status.
///
/// The table has the columns frequency_hz (or frequency), impedance_ohm (or ohm) and phase_deg (or
/// degrees), voltage against current; RFC 4180, '#' begins a comment. Of `options` the masses, R,
/// L, --held, --free, --actuator and --require count; drops beside it are refused.
[[nodiscard]] int AnswerImpedance(const ImpedanceFiles& files, const FitLraOptions& options,
                                  bool json);

}  // namespace haptometer::tools
