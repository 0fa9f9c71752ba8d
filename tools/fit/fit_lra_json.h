#pragma once

#include <string>
#include <vector>

#include "base/error.h"
#include "fit/drop_test/drop_test_fit.h"

namespace haptometer::tools {

/// The answer of fit-lra as one JSON document (docs/commands.md): everything that FitLraText says;
/// what is not determined is null.
[[nodiscard]] std::string FitLraJson(const fit::DropTestFit& fit,
                                     const std::vector<std::string>& doubts,
                                     const std::vector<std::string>& remarks,
                                     const std::vector<Error>& left_out);

/// What stands in a document where no record could be fitted: nothing determined.
[[nodiscard]] fit::DropTestFit NothingDetermined();

}  // namespace haptometer::tools
