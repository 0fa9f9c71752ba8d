#include "tools/reproduce/reproduce.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "base/error.h"
#include "tools/cli/options.h"
#include "tools/cli/terminal.h"
#include "tools/plot/gnuplot.h"
#include "tools/report/html_page.h"
#include "tools/reproduce/reproduction_document.h"
#include "tools/reproduce/reproduction_figures.h"
#include "tools/reproduce/thesis_model.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kVerb = "reproduce";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Compute every number of the thesis anew and compare.",
    .examples = {"haptometer reproduce", "haptometer reproduce --figures figures/ --chain",
                 "haptometer reproduce --report thesis.html --json"}};

struct Wanted {
  std::string figures;
  std::string report;
  bool chain = false;
};

// before the work: folder and page can be written
Result<void> CheckPlaces(const Wanted& wanted) {
  if (!wanted.report.empty()) {
    if (auto writable = report::CheckReportPath(wanted.report); !writable) return writable;
  }
  if (wanted.figures.empty()) return {};
  std::error_code failure;
  fs::create_directories(wanted.figures, failure);
  if (failure || !fs::is_directory(wanted.figures)) {
    return Usage(wanted.figures, "is no folder and none can be made there", "name another");
  }
  return {};
}

Result<void> WriteFiles(const Wanted& wanted, const Reproduction& reproduction,
                        const std::string& command, std::vector<std::string>& written) {
  if (wanted.figures.empty() && wanted.report.empty()) return {};
  const std::vector<ThesisFigure> figures = FiguresOf(reproduction);
  if (!wanted.figures.empty()) {
    written.reserve(figures.size() + 1);
    for (const ThesisFigure& figure : figures) {
      const std::string path = fs::path(wanted.figures) / (figure.name + ".svg");
      if (auto drawn = plot::DrawPanels(path, figure.panels); !drawn) return drawn;
      written.push_back(path);
    }
  }
  if (wanted.report.empty()) return {};
  const auto page = ReproductionReport(reproduction, figures, command);
  if (!page) return std::unexpected(page.error());
  if (auto done = report::WriteReport(wanted.report, *page); !done) return done;
  written.push_back(wanted.report);
  return {};
}

}  // namespace

int RunReproduce(int argc, const char* const* argv) {
  cli::Options options(kText);
  Wanted wanted;
  options.Output("--figures", &wanted.figures, "DIR",
                 "Draw Figures 2.2-2.7 and 3.3-3.5 into DIR, as SVG; older ones are replaced");
  options.Output("--report", &wanted.report, "FILE.html",
                 "Write rows and figures as one self-contained page");
  options.Flag("--chain", &wanted.chain,
               "Also run scene, sensor, record and analysis, and compare with the simulated truth; "
               "status 1 where an interval misses it");
  if (const auto status = options.Parse(argc, argv)) return *status;
  if (auto places = CheckPlaces(wanted); !places) return cli::ReportError(kVerb, places.error());
  const auto reproduction = Reproduce({}, wanted.chain);
  if (!reproduction) return cli::ReportError(kVerb, reproduction.error());
  const std::vector<std::string> typed(argv, argv + argc);
  std::vector<std::string> written;
  if (auto done = WriteFiles(wanted, *reproduction, cli::CommandLine(typed), written); !done) {
    return cli::ReportError(kVerb, done.error());
  }
  cli::Print(options.json() ? ReproductionJson(*reproduction, written)
                            : ReproductionText(*reproduction));
  if (!reproduction->chain) return 0;
  return std::ranges::all_of(*reproduction->chain, &ChainRow::holds) ? 0 : 1;
}

namespace {

// in the thesis's order, each once
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
  auto study = RunGeneratedStudy(model);
  if (!study) return std::unexpected(study.error());
  std::vector<ThesisRow> rows = StudyRows(*study);
  for (auto* group : {DisplacementRows, ElectricalRows, OptimumRows, FrequencyRows, RiseRows,
                      ReceptorRows, PrototypeRows}) {
    for (ThesisRow& row : group(model)) rows.push_back(std::move(row));
  }
  Reproduction reproduction{model, *std::move(study), InOrder(std::move(rows)), std::nullopt};
  if (!with_chain) return reproduction;
  auto chain = RunChain(model);
  if (!chain) return std::unexpected(chain.error());
  reproduction.chain = *std::move(chain);
  return reproduction;
}

std::size_t CountOf(const Reproduction& reproduction, RowVerdict verdict) {
  return static_cast<std::size_t>(std::ranges::count_if(
      reproduction.rows,
      [&](const ThesisRow& row) { return !row.generated && VerdictOf(row) == verdict; }));
}

std::size_t CountOf(const Reproduction& reproduction, CauseKind kind) {
  return static_cast<std::size_t>(std::ranges::count_if(
      reproduction.rows,
      [&](const ThesisRow& row) { return !row.generated && ExplainedBy(row) == kind; }));
}

std::size_t CircularRows(const Reproduction& reproduction) {
  return static_cast<std::size_t>(
      std::ranges::count(reproduction.rows, true, &ThesisRow::generated));
}

std::vector<std::string> ReproductionAssumptions() {
  const std::string generated =
      "rows marked * are of trials generated with the printed number, not of the thesis's "
      "recordings: they test the analysis alone";
  return {"printed values are true to half their last digit; 8200 N/m to 50 N/m, 220 Hz to 5 Hz",
          "equation 2.3 with the coil's reaction on the case, as matrix 2.5 has it",
          "the skin's stiffness up to 2000 N/m (text of 2.1.1); Table 2.1 has 1200 N/m",
          "no cause is proved: each is a candidate whose number was computed",
          "a tuned candidate's number was chosen by what is printed",
          "rounding is sought as the set of inputs that comes nearest",
          generated};
}

}  // namespace haptometer::tools
