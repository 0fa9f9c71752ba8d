#pragma once

#include <string>
#include <vector>

#include "base/error.h"
#include "tools/analyze/analyzed_file.h"
#include "tools/report/html_page.h"

namespace haptometer::tools {

/// What a file's part of the report shows.
struct ReportedFile {
  AnalyzedFile file;
  std::vector<std::vector<plot::Panel>> figures;  ///< each one drawing
  std::vector<std::string> captions;              ///< one a figure
};

/// The page of `analyze --report`: per file its answer, its figures, everything that --all prints,
/// and the settings that the numbers rest on. `command` is how it was called.
/// Errors: as HtmlPage::Figure.
[[nodiscard]] Result<report::HtmlPage> AnalysisReport(const std::vector<ReportedFile>& files,
                                                      const std::string& command);

}  // namespace haptometer::tools
