#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "dsp/findings.h"
#include "tools/document/document.h"
#include "tools/plot/gnuplot.h"
#include "trial/import/import_options.h"
#include "trial/record.h"
#include "trial/trial_reader.h"

namespace haptometer::tools {

/// `channel` of `record` over time: its measurements about their mean (a length in um, the mean in
/// the title), broken at gaps and bad samples, and a mark at the lower edge for each bad sample.
///
/// Programmer's errors: a record without rows. Cost: one pass; memory: four doubles a row.
[[nodiscard]] plot::Panel PanelOf(const trial::Record& record, const trial::Channel& channel);

/// More panels than this in one picture are too flat to be read.
inline constexpr std::size_t kMostPanels = 8;

/// Panels of the first channels of `record`, kMostPanels at most.
[[nodiscard]] std::vector<plot::Panel> PanelsOf(const trial::Record& record);

/// A recording as it is shown.
struct ShownRecording {
  trial::Recording recording;
  dsp::Findings findings{};  ///< values that stand for no reading
};

/// `recording`, of whose displacements each value that stands for no reading, as -99.998 mm does
/// (dsp/readings/clean_rows.h), has its status and no value, as for analyze. Errors: as dsp::Clean.
[[nodiscard]] Result<ShownRecording> WithoutCodes(trial::Recording recording);

/// What a recording holds: header, channels, rows, times, gaps, labels, losses. `verb` answers with
/// it; `shown` must outlive it. `has_figures`: with the figure of PanelsOf().
[[nodiscard]] document::Document TrialDocument(std::string_view verb, const std::string& path,
                                               const ShownRecording& shown, bool has_figures);

/// Reads the recording at `path` whole and says on stderr, as remarks of `verb`, what is lost of it
/// and what was assumed. Errors: as trial::ReadRecording.
[[nodiscard]] Result<trial::Recording> ReadAndTell(std::string_view verb, const std::string& path,
                                                   const trial::ImportOptions& import);

/// What `haptometer trial` can do, a word each; argv[0] is the word. The return value is the
/// program's exit status.
int RunTrialInfo(int argc, const char* const* argv);
int RunTrialLabel(int argc, const char* const* argv);
int RunTrialExclude(int argc, const char* const* argv);
int RunTrialInclude(int argc, const char* const* argv);
int RunTrialExport(int argc, const char* const* argv);
int RunTrialPlot(int argc, const char* const* argv);

}  // namespace haptometer::tools
