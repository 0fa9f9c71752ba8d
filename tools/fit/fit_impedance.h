#pragma once

#include <string>

#include "tools/fit/fit_lra_input.h"

namespace haptometer::tools {

/// Answers `fit-lra --impedance z.csv`: reads the sweep, fits (fit/impedance_fit.h), prints the
/// constants as text or JSON, draws them where `plot` names a file. Returns the program's exit
/// status.
///
/// The table has the columns frequency_hz (or frequency), impedance_ohm (or ohm) and phase_deg (or
/// degrees), voltage against current; RFC 4180, '#' begins a comment. Of `options` the masses, R,
/// L, --held, --free, --actuator and --require count; drops beside it are refused.
[[nodiscard]] int AnswerImpedance(const std::string& path, const FitLraOptions& options,
                                  const std::string& plot, bool json);

}  // namespace haptometer::tools
