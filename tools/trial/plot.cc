// trial plot: a recording over time.
#include <fmt/core.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tools/cli/import_words.h"
#include "tools/cli/options.h"
#include "tools/cli/report.h"
#include "tools/plot/gnuplot.h"
#include "tools/trial/told_recording.h"
#include "tools/trial/trial_panel.h"
#include "tools/trial/words.h"

namespace haptometer::tools {
namespace {

constexpr cli::VerbText kPlotText{
    .name = "trial plot",
    .summary = "Draw a recording over time: gaps are gaps, bad samples are marked, peaks stay.",
    .examples = {"haptometer trial plot trial.bin -o trial.svg",
                 "haptometer trial plot trial.bin --plot trial.png",
                 "haptometer trial plot s.csv --columns time_s,displacement_mm -o scope.pdf"}};

// more panels than this are too flat to be read
constexpr std::size_t kMostPanels = 8;

Result<void> Draw(const std::string& input, const std::string& output,
                  const cli::ImportWords& words) {
  if (output.empty()) return Usage("-o", "is missing", "name the plot, e.g. -o trial.svg");
  if (auto drawable = plot::CheckPlotPath(output); !drawable) return drawable;
  const auto import = cli::ImportOf(words);
  if (!import) return std::unexpected(import.error());
  const auto recording = ReadAndTell(kPlotText.name, input, *import);
  if (!recording) return std::unexpected(recording.error());
  const trial::Record& record = recording->record;
  if (record.rows == 0) return CannotAnswer(input, "holds no rows", "record again");
  std::vector<plot::Panel> panels;
  for (std::size_t c = 0; c < std::min(record.channels.size(), kMostPanels); ++c) {
    panels.push_back(PanelOf(record, record.channels[c]));
  }
  if (record.channels.size() > kMostPanels) {
    cli::Remark(kPlotText.name, fmt::format("the first {} of {} channels are drawn", kMostPanels,
                                        record.channels.size()));
  }
  return plot::DrawPanels(output, panels);
}

}  // namespace

int RunTrialPlot(int argc, const char* const* argv) {
  std::string input;
  std::string output;
  cli::ImportWords import;
  cli::Options options(kPlotText);
  options.Positional("file", &input, "trial.bin, CSV with time_s, LabVIEW .lvm, HDF5");
  options.Output("-o,--output,--plot", &output, "FILE.svg|png|pdf",
                 "The plot to write; an older one of ours is replaced");
  cli::DeclareImport(&options, &import);
  if (const auto status = options.Parse(argc, argv)) return *status;
  const auto done = Draw(input, output, import);
  return done ? 0 : cli::ReportError(kPlotText.name, done.error());
}

}  // namespace haptometer::tools
