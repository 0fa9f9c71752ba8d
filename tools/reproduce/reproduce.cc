#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "tools/cli/command_line.h"
#include "tools/cli/options.h"
#include "tools/cli/report.h"
#include "tools/plot/gnuplot.h"
#include "tools/report/html_page.h"
#include "tools/reproduce/reproduction.h"
#include "tools/reproduce/reproduction_figures.h"
#include "tools/reproduce/reproduction_output.h"
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

}  // namespace haptometer::tools
