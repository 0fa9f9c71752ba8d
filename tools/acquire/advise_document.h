#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/error.h"
#include "tools/acquire/advise.h"
#include "tools/cli/options.h"
#include "tools/document/document.h"

namespace haptometer::tools {

/// "the wire", "the sensor's noise".
[[nodiscard]] std::string_view NameOf(RouteLimit limit);

/// The route's options of `acquire`: "--sensor keyence-il --baud 38400".
[[nodiscard]] std::string OptionsOf(const Route& route);

/// What `acquire --advise` is asked, beside --band.
struct AdviseWords {
  bool advise = false;
  std::optional<double> drive_hz;
  std::optional<double> rms_m;
  std::string accuracy;
  std::optional<double> noise_rms_m;
  std::optional<double> daq_rate_hz;
  std::string calibration_uncertainty;
};

/// Declares --advise and the options that belong to it.
void DeclareAdvise(cli::Options& options, AdviseWords& words);

/// What is wrong with them without --advise. Errors (Cause::kUsage).
[[nodiscard]] Result<void> CheckNotAdvised(const AdviseWords& words);

/// The question, with `band` as --band has it. Errors (Cause::kUsage): a band, drive, RMS, accuracy
/// or rate that is missing or lies outside of its range.
[[nodiscard]] Result<RouteQuestion> ReadRouteQuestion(const AdviseWords& words,
                                                      const std::string& band);

/// Why the route answers, or why not, in a sentence without a full stop.
[[nodiscard]] std::string ReasonOf(const Route& route);

/// The routes in their order, what is supposed, and the command of the best one. Refused where none
/// answers.
[[nodiscard]] document::Document RoutesDocument(const RouteQuestion& question);

}  // namespace haptometer::tools
