#include "tools/reproduce/reproduce.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/input_file.h"
#include "tools/cli/options.h"
#include "tools/cli/terminal.h"
#include "tools/document/present.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kVerb = "reproduce";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Recompute every number of the thesis and compare.",
    .examples = {"haptometer reproduce", "haptometer reproduce --figures figures/ --chain",
                 "haptometer reproduce --report thesis.html --json"}};

struct Wanted {
  std::string figures;  // a folder; empty: none
  bool chain = false;
  document::Outputs outputs;
};

// folder and page are checked before the computation
Result<void> CheckPlaces(const Wanted& wanted) {
  HAPTOMETER_TRY(document::CheckOutputs(wanted.outputs));
  if (wanted.figures.empty()) return {};
  std::error_code failure;
  fs::create_directories(wanted.figures, failure);
  if (failure || !fs::is_directory(wanted.figures)) {
    return Usage(wanted.figures, "is not a folder, and none can be made there", "name another");
  }
  return {};
}

// draws the figures; returns the paths of the files
Result<std::vector<std::string>> DrawFigures(const std::string& folder,
                                             const std::vector<ThesisFigure>& figures) {
  std::vector<std::string> written;
  if (folder.empty()) return written;
  for (const ThesisFigure& figure : figures) {
    written.push_back(fs::path(folder) / (figure.name + ".svg"));
    HAPTOMETER_TRY(plot::DrawPanels(written.back(), figure.panels));
  }
  return written;
}

Result<document::Document> Answer(const Wanted& wanted, const Reproduction& reproduction) {
  std::vector<ThesisFigure> figures;
  // figures are computed only where they are drawn
  if (!wanted.figures.empty() || wanted.outputs.HasFigures()) figures = FiguresOf(reproduction);
  HAPTOMETER_LET(auto files, DrawFigures(wanted.figures, figures));
  if (!wanted.outputs.report.empty()) files.push_back(wanted.outputs.report);
  return ReproductionDocument(reproduction, figures, files);
}

// rows in the order of the thesis; each number has exactly one row
std::vector<ThesisRow> InOrder(std::vector<ThesisRow> rows) {
  const auto numbers = ThesisNumbers();
  HAPTOMETER_CHECK(rows.size() == numbers.size(), "{} rows, {} numbers", rows.size(),
                   numbers.size());
  std::vector<ThesisRow> ordered;
  ordered.reserve(rows.size());
  for (const ThesisNumber& number : numbers) {
    const auto found = std::ranges::find(rows, number.key, &ThesisRow::key);
    HAPTOMETER_CHECK(found != rows.end(), "no row {}", number.key);
    ordered.push_back(std::move(*found));
  }
  return ordered;
}

}  // namespace

Result<Reproduction> Reproduce(const ThesisModel& model, bool with_chain) {
  HAPTOMETER_LET(auto study, RunGeneratedStudy(model));
  std::vector<ThesisRow> rows = StudyRows(study);
  for (auto* group : {DisplacementRows, ElectricalRows, OptimumRows, FrequencyRows, RiseRows,
                      ReceptorRows, PrototypeRows}) {
    for (ThesisRow& row : group(model)) rows.push_back(std::move(row));
  }
  Reproduction reproduction{model, std::move(study), InOrder(std::move(rows)), std::nullopt};
  // scene, sensor, record, analysis: only with --chain
  if (!with_chain) return reproduction;
  HAPTOMETER_LET(reproduction.chain, RunChain(model));
  return reproduction;
}

int RunReproduce(int argc, const char* const* argv) {
  cli::Options options(kText);
  Wanted wanted;
  options.Flag("--all", &wanted.outputs.all, "Show the candidate causes of each row too");
  options.Output("--figures", &wanted.figures, "DIR",
                 "Draw Figures 2.2-2.7 and 3.3-3.5 into DIR, as SVG; older ones are replaced");
  options.Output("--report", &wanted.outputs.report, "FILE.html",
                 "Write rows and figures as one self-contained page");
  options.Flag("--chain", &wanted.chain,
               "Also run scene, sensor, record and analysis, and compare with the simulated truth; "
               "status 1 where an interval misses it");
  if (const auto status = options.Parse(argc, argv)) return *status;
  wanted.outputs.json = options.json();
  if (auto places = CheckPlaces(wanted); !places) return cli::ReportError(kVerb, places.error());
  const auto reproduction = Reproduce({}, wanted.chain);
  if (!reproduction) return cli::ReportError(kVerb, reproduction.error());
  // the generated trials are no inputs of the user
  ForgetInputs();
  const auto document = Answer(wanted, *reproduction);
  if (!document) return cli::ReportError(kVerb, document.error());
  const int status = document::Present(*document, wanted.outputs, argc, argv);
  // status 1 where an interval of the chain misses the truth
  const bool holds =
      !reproduction->chain || std::ranges::all_of(*reproduction->chain, &ChainRow::holds);
  return cli::WorseStatus(status, holds ? 0 : 1);
}

}  // namespace haptometer::tools
