#pragma once

#include <string>
#include <vector>

#include "base/error.h"
#include "tools/document/document.h"

/// The thin face of every verb: what is shown where.
namespace haptometer::document {

/// What of an answer is asked for; a verb declares the options that it has.
struct Outputs {
  bool json = false;   ///< --json: JSON in the place of text on standard output
  bool all = false;    ///< --all: text with all details
  std::string plot;    ///< --plot: all figures in one picture; empty: none
  std::string report;  ///< --report: a page; empty: none

  /// Whether figures are drawn, which cost time to compute.
  [[nodiscard]] bool HasFigures() const { return !plot.empty() || !report.empty(); }
};

/// Whether the picture and the page can be written; to be asked before long work. Errors: as
/// plot::CheckPlotPath and report::CheckReportPath.
[[nodiscard]] Result<void> CheckOutputs(const Outputs& outputs);

/// Prints the document and writes picture and page. Returns the exit status: 3 where a refusal is
/// among the findings, that of an error where one occurs, or else 0. `argv` is the verb's own:
/// its first word is not looked at. The provenance is collected where it is shown, so the
/// document's own is overwritten.
[[nodiscard]] int Present(Document document, const Outputs& outputs, int argc,
                          const char* const* argv);

}  // namespace haptometer::document
