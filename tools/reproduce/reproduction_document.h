#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "tools/report/html_page.h"
#include "tools/reproduce/reproduce.h"
#include "tools/reproduce/reproduction_figures.h"

namespace haptometer::tools {

/// A row in the words of the thesis: numbers in its units.
struct RowWords {
  std::string printed;    ///< "0.0438 mm", "< 2 %"; "-" for nothing
  std::string ours;       ///< "0.04499 mm", "3.21 [3.12, 3.3]"; "not determined"
  std::string deviation;  ///< "+2.72 %"; empty where there is none
  std::string verdict;    ///< "reproduced", "disagrees"; with "*" where trials were generated
  std::vector<std::string> why;  ///< remark and candidate causes, each with what it gives
};

[[nodiscard]] RowWords WordsOf(const ThesisRow& row);
/// The same of the chain: truth, answer with its interval, deviation, "holds" or "misses".
[[nodiscard]] RowWords WordsOf(const ChainRow& row);

/// "12 reproduced, 9 explained, 20 disagree; 13 not printed"
[[nodiscard]] std::string CountsText(const Reproduction& reproduction);

/// All rows for people.
[[nodiscard]] std::string ReproductionText(const Reproduction& reproduction);

/// One JSON document in SI units (docs/reference/reproduce.md); what is not known is null.
/// `written` are the files that were drawn.
[[nodiscard]] std::string ReproductionJson(const Reproduction& reproduction,
                                           const std::vector<std::string>& written);

/// All rows and figures as one page. Errors: as plot::DrawSvg.
[[nodiscard]] Result<report::HtmlPage> ReproductionReport(const Reproduction& reproduction,
                                                          const std::vector<ThesisFigure>& figures,
                                                          const std::string& command);

}  // namespace haptometer::tools
