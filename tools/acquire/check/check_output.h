#pragma once

#include <string>
#include <vector>

#include "tools/acquire/check/check_findings.h"
#include "tools/acquire/check/check_list.h"
#include "trial/trial_format.h"

namespace haptometer::tools {

/// The list for people: "  ok   distance   ..." a line, below a FIX its remedy; the last line says
/// whether the sensor is ready.
[[nodiscard]] std::string CheckText(const std::vector<CheckItem>& items);

/// The JSON document of `acquire --check --json` (docs/commands.md), with a line's end.
[[nodiscard]] std::string CheckJson(const trial::TrialHeader& header, const CheckFindings& findings,
                                    const CheckQuestion& question,
                                    const std::vector<CheckItem>& items);

}  // namespace haptometer::tools
