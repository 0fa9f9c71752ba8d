#include "tools/analyze/analysis_report.h"

#include <fmt/core.h>

#include "base/clock.h"
#include "base/error.h"
#include "tools/analyze/analysis_lines.h"

namespace haptometer::tools {
namespace {

std::vector<std::vector<std::string>> TableRows(const std::vector<AnalysisLine>& lines) {
  std::vector<std::vector<std::string>> rows;
  rows.reserve(lines.size());
  for (const AnalysisLine& line : lines) rows.push_back({line.label, line.text});
  return rows;
}

Result<void> AddFile(const ReportedFile& reported, report::HtmlPage& page) {
  page.Section(reported.file.path);
  if (reported.file.error) {
    page.Warning(reported.file.error->Text());
    return {};
  }
  const dsp::BandAnalysis& analysis = *reported.file.analysis;
  for (const std::string& reason : analysis.reasons) page.Warning("not answered: " + reason);
  page.Table({}, TableRows(ShortLines(reported.file)));
  for (std::size_t k = 0; k < reported.figures.size(); ++k) {
    if (auto drawn = page.Figure(reported.captions[k], reported.figures[k]); !drawn) return drawn;
  }
  for (const AnalysisSection& section : AllSections(reported.file)) {
    if (section.heading == "Remarks") continue;  // stand in the first table
    page.Subsection(section.heading);
    page.Table({}, TableRows(section.lines));
  }
  return {};
}

}  // namespace

Result<report::HtmlPage> AnalysisReport(const std::vector<ReportedFile>& files,
                                        const std::string& command) {
  HAPTOMETER_CHECK(!files.empty(), "a report of no file");
  const std::string title = files.size() == 1 ? fmt::format("Vibration of {}", files[0].file.path)
                                              : fmt::format("Vibration of {} trials", files.size());
  report::HtmlPage page(
      title, fmt::format("haptometer {}, {}: {}", HAPTOMETER_VERSION, UtcNow(), command));
  for (const ReportedFile& file : files) {
    if (auto added = AddFile(file, page); !added) return std::unexpected(added.error());
  }
  return page;
}

}  // namespace haptometer::tools
