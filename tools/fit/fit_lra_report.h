#pragma once

#include <string>
#include <vector>

#include "base/error.h"
#include "fit/drop_test/drop_test_fit.h"
#include "tools/fit/fit_lra_panels.h"
#include "tools/report/html_page.h"

namespace haptometer::tools {

/// What the page of `fit-lra --report` is made of.
struct ReportedFit {
  fit::DropTestFit fit;
  std::vector<std::string> doubts;
  std::vector<std::string> remarks;
  std::vector<Error> left_out;
  std::vector<FitFigure> figures;
  std::string command;  ///< how it was called
};

/// The page of `fit-lra --report`: the constants, what is not determined and what is doubtful, the
/// figures, the uncertainty budget with correlations, every record, the given numbers and what they
/// do, assumptions, remarks and how the solver ended. Errors: as HtmlPage::Figure.
[[nodiscard]] Result<report::HtmlPage> FitLraReport(const ReportedFit& reported);

}  // namespace haptometer::tools
