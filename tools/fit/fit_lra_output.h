#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "fit/drop_test_fit.h"
#include "fit/impulse_record.h"

namespace haptometer::tools {

/// The answer of fit-lra for people: constants with 95 % intervals, what is doubtful, records,
/// inputs, assumptions.
[[nodiscard]] std::string FitLraText(const fit::DropTestFit& fit,
                                     const std::vector<std::string>& doubts);

/// The same as one JSON document (docs/commands.md); what is not determined is null.
[[nodiscard]] std::string FitLraJson(const fit::DropTestFit& fit,
                                     const std::vector<std::string>& doubts,
                                     const std::vector<std::string>& remarks,
                                     const std::vector<Error>& left_out);

/// Two panels a record: samples with the fit, and the residual. Errors: see plot::DrawPanels.
[[nodiscard]] Result<void> PlotFitLra(const std::string& path, const fit::DropTestFit& fit,
                                      const std::vector<fit::ImpulseRecord>& records);

}  // namespace haptometer::tools
