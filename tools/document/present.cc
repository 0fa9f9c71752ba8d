#include "tools/document/present.h"

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <utility>
#include <vector>

#include "base/text.h"
#include "tools/cli/output_file.h"
#include "tools/cli/terminal.h"
#include "tools/document/render.h"

namespace haptometer::document {
namespace {

Receiver* receiver = nullptr;

// the figures of all sections in one picture
Result<void> DrawFigures(const std::string& path, const Document& document) {
  std::vector<plot::Panel> panels;
  for (const Section* section : AllSections(document.root)) {
    for (const Figure& figure : section->figures) {
      panels.insert(panels.end(), figure.panels.begin(), figure.panels.end());
    }
  }
  // a refused document may have no figures
  return panels.empty() ? Result<void>{} : plot::DrawPanels(path, panels);
}

Result<void> WritePage(const std::string& path, const Document& document) {
  HAPTOMETER_LET(const auto html, HtmlOf(document));
  return cli::WriteOutput(path, cli::kPageOutput, false, cli::Marked(html));
}

// 3 where any section holds a refusal, else 0
int StatusOf(const Document& document) {
  const auto is_refused = [](const Section* section) {
    return std::ranges::count(section->findings, Severity::kRefusal, &Finding::severity) > 0;
  };
  return std::ranges::any_of(AllSections(document.root), is_refused)
             ? ExitStatus(Cause::kCannotAnswer)
             : 0;
}

// collected only where it is shown, since each input is read again for its checksum
void AddProvenance(Document& document, const Outputs& outputs, int argc, const char* const* argv) {
  if (!outputs.json && !outputs.all && outputs.report.empty()) return;
  document.provenance = ProvenanceOf(document.verb, argc, argv);
}

// keeps the document, writes picture and page; the exit status, the worse one of findings and files
int Deliver(const Document& document, const Outputs& outputs) {
  if (receiver != nullptr) receiver->Take(document);
  int status = StatusOf(document);
  const auto note = [&](const Result<void>& done) {
    if (!done) status = cli::WorseStatus(status, cli::ReportError(document.verb, done.error()));
  };
  if (!outputs.plot.empty()) note(DrawFigures(outputs.plot, document));
  if (!outputs.report.empty()) note(WritePage(outputs.report, document));
  return status;
}

Detail DetailOf(const Outputs& outputs) { return outputs.all ? Detail::kAll : Detail::kShort; }

}  // namespace

bool Outputs::HasFigures() const {
  return !plot.empty() || !report.empty() || (receiver != nullptr && receiver->has_figures());
}

Receiver::Receiver(bool has_figures) : has_figures_(has_figures) { receiver = this; }

Receiver::~Receiver() { receiver = nullptr; }

void DeclareOutputs(cli::Options& options, Outputs& outputs, const OutputHelp& help) {
  if (!help.all.empty()) options.Flag("--all", &outputs.all, help.all);
  if (!help.plot.empty()) options.Output("--plot", &outputs.plot, "FILE.svg|png|pdf", help.plot);
  if (!help.report.empty()) options.Output("--report", &outputs.report, "FILE.html", help.report);
}

// checked before the work: a wrong path must not cost a computed result
Result<void> CheckOutputs(const Outputs& outputs) {
  if (!outputs.plot.empty()) HAPTOMETER_TRY(plot::CheckPlotPath(outputs.plot));
  if (outputs.report.empty()) return {};
  if (std::filesystem::path(outputs.report).extension() != ".html") {
    return Usage(outputs.report, "is to be a report, which is a page", "give it the ending .html");
  }
  return cli::CheckOutput(outputs.report, cli::kPageOutput, false);
}

Provenance ProvenanceOf(std::string_view verb, int argc, const char* const* argv) {
  // a verb may have two words ("trial info")
  std::vector<std::string> words{"haptometer"};
  std::istringstream of_verb{std::string(verb)};
  for (std::string word; of_verb >> word;) words.push_back(word);
  for (int k = 1; k < argc; ++k) words.emplace_back(argv[k]);
  return CollectProvenance(words);
}

int Present(Document document, const Outputs& outputs, int argc, const char* const* argv) {
  AddProvenance(document, outputs, argc, argv);
  cli::Print(outputs.json ? JsonOf(document) : TextOf(document, DetailOf(outputs)));
  return Deliver(document, outputs);
}

int RunVerb(std::string_view verb, cli::Options& options, Outputs& outputs, int argc,
            const char* const* argv, const std::function<Result<int>()>& answer) {
  if (const auto status = options.Parse(argc, argv)) return *status;
  outputs.json = options.json();
  if (const auto good = CheckOutputs(outputs); !good) return cli::ReportError(verb, good.error());
  const auto status = answer();
  return status ? *status : cli::ReportError(verb, status.error());
}

Presenter::Presenter(Document document, Outputs outputs, int argc, const char* const* argv)
    : document_(std::move(document)), outputs_(std::move(outputs)), argc_(argc), argv_(argv) {
  // Add() appends to the last section
  HAPTOMETER_CHECK(!document_.root.sections.empty(), "{} has no section for its parts",
                   document_.verb);
}

// text appears part by part, as each is complete; JSON is one document at the end
void Presenter::PrintText(const Section& section) {
  if (outputs_.json) return;
  const std::string text = TextOf(section, DetailOf(outputs_));
  if (text.empty()) return;
  if (!has_title_) cli::Print(Printable(document_.title) + "\n");
  has_title_ = true;
  cli::Print(text);
}

void Presenter::Add(Section part) {
  PrintText(part);
  document_.root.sections.back().sections.push_back(std::move(part));
}

int Presenter::Finish(Section last) {
  PrintText(last);
  document_.root.sections.push_back(std::move(last));
  AddProvenance(document_, outputs_, argc_, argv_);
  if (outputs_.json) cli::Print(JsonOf(document_));
  // text was printed already, so only the provenance is added
  if (outputs_.all && !outputs_.json) cli::Print(CommentOf(document_.provenance, "  "));
  return Deliver(document_, outputs_);
}

}  // namespace haptometer::document
