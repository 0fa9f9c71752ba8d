#include "tools/document/present.h"

#include <algorithm>
#include <sstream>

#include "tools/cli/output_file.h"
#include "tools/cli/terminal.h"
#include "tools/document/render.h"
#include "tools/report/html_page.h"

namespace haptometer::document {
namespace {

std::vector<std::string> CommandOf(const Document& document, int argc, const char* const* argv) {
  // "trial info" is two words
  std::vector<std::string> words{"haptometer"};
  std::istringstream verb(document.verb);
  for (std::string word; verb >> word;) words.push_back(word);
  for (int k = 1; k < argc; ++k) words.emplace_back(argv[k]);
  return words;
}

Result<void> DrawFigures(const std::string& path, const Document& document) {
  std::vector<plot::Panel> panels;
  for (const Section* section : AllSections(document.root)) {
    for (const Figure& figure : section->figures) {
      panels.insert(panels.end(), figure.panels.begin(), figure.panels.end());
    }
  }
  return plot::DrawPanels(path, panels);
}

Result<void> WritePage(const std::string& path, const Document& document) {
  const auto html = HtmlOf(document);
  if (!html) return std::unexpected(html.error());
  return cli::WriteOutput(path, cli::kPageOutput, false, cli::Marked(*html));
}

int StatusOf(const Document& document) {
  const auto is_refused = [](const Section* section) {
    return std::ranges::count(section->findings, Severity::kRefusal, &Finding::severity) > 0;
  };
  return std::ranges::any_of(AllSections(document.root), is_refused)
             ? ExitStatus(Cause::kCannotAnswer)
             : 0;
}

}  // namespace

Result<void> CheckOutputs(const Outputs& outputs) {
  if (!outputs.plot.empty()) {
    if (auto good = plot::CheckPlotPath(outputs.plot); !good) return good;
  }
  return outputs.report.empty() ? Result<void>{} : report::CheckReportPath(outputs.report);
}

int Present(Document document, const Outputs& outputs, int argc, const char* const* argv) {
  if (outputs.json || outputs.all || !outputs.report.empty()) {
    document.provenance = CollectProvenance(CommandOf(document, argc, argv));
  }
  cli::Print(outputs.json ? JsonOf(document)
                          : TextOf(document, outputs.all ? Detail::kAll : Detail::kShort));
  int status = StatusOf(document);
  const auto note = [&](const Result<void>& done) {
    if (!done) status = cli::WorseStatus(status, cli::ReportError(document.verb, done.error()));
  };
  if (!outputs.plot.empty()) note(DrawFigures(outputs.plot, document));
  if (!outputs.report.empty()) note(WritePage(outputs.report, document));
  return status;
}

}  // namespace haptometer::document
