#include "tools/trial/trial.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "dsp/readings/clean_rows.h"
#include "tools/cli/options.h"
#include "tools/cli/shared_options.h"
#include "tools/cli/terminal.h"
#include "tools/cli/verb_words.h"
#include "tools/document/present.h"
#include "tools/session/session_folder.h"
#include "tools/study/alike_names.h"
#include "tools/verbs.h"
#include "trial/import/read_recording.h"
#include "trial/row_source.h"
#include "trial/trial_writer.h"

// trial: what can be done with recordings, a word each (tools/trial/).

namespace haptometer::tools {
namespace {

constexpr auto kWords = std::to_array<cli::VerbWord>(
    {{"info", RunTrialInfo, "Show what a recording holds: channels, times, gaps, labels, losses.",
      "haptometer trial info trial.bin"},
     {"label", RunTrialLabel, "Add labels to a trial.",
      "haptometer trial label trial.bin subject=3 condition=stock"},
     {"exclude", RunTrialExclude, "Exclude a trial from studies.",
      "haptometer trial exclude trial.bin --reason 'finger slipped'"},
     {"include", RunTrialInclude, "Include an excluded trial again.",
      "haptometer trial include trial.bin"},
     {"plot", RunTrialPlot, "Draw a recording.", "haptometer trial plot trial.bin -o trial.svg"},
     {"export", RunTrialExport, "Write recordings as CSV, HDF5, NumPy, WAV or MATLAB files.",
      "haptometer trial export trial.bin -o trial.h5"}});

}  // namespace

int RunTrial(int argc, const char* const* argv) {
  return cli::RunVerbWord("trial", "Show, label, draw and export recordings.", kWords, argc, argv);
}

// trial label: labels given after the recording.
namespace {

constexpr cli::VerbText kLabelText{
    .name = "trial label",
    .summary = "Add labels to a trial; the latest value of a label is used, older ones are kept.",
    .examples = {"haptometer trial label trial.bin subject=3",
                 "haptometer trial label trial.bin subject=4 --reason 'wrong subject noted'",
                 "haptometer trial label trial.bin 'condition=with adapter'"}};

// where files of other kinds than trial.bin have what a trial gets by an event
struct Elsewhere {
  std::string in_csv;
  std::string in_others;
};

// the error of a file of another kind gets its remedy
Error Explained(Error error, const std::string& path, const Elsewhere& elsewhere) {
  if (error.what != "is not a trial") return error;
  const auto other = trial::ReadRecording(path);
  if (!other || other->report.kind == trial::FileKind::kTrial) return error;
  error.what = fmt::format("is a {}", Name(other->report.kind));
  error.remedy =
      other->report.kind == trial::FileKind::kCsv ? elsewhere.in_csv : elsewhere.in_others;
  return error;
}

// an event is appended: the recorded bytes do not change
Result<void> Append(const std::string& path, const trial::Event& event,
                    const Elsewhere& elsewhere) {
  auto done = trial::AppendEvent(path, event);
  if (!done) return std::unexpected(Explained(done.error(), path, elsewhere));
  return {};
}

// the answer to a change: with --json what the trial holds now
int ShowChanged(const cli::VerbText& text, const std::string& path, bool is_json, int argc,
                const char* const* argv) {
  if (!is_json) return 0;
  auto recording = trial::ReadRecording(path);
  if (!recording) return cli::ReportError(text.name, recording.error());
  const auto shown = WithoutCodes(*std::move(recording));
  if (!shown) return cli::ReportError(text.name, shown.error());
  document::Outputs outputs;
  outputs.json = true;
  return document::Present(TrialDocument(text.name, path, *shown, false), outputs, argc, argv);
}

Result<void> Label(const std::string& path, const std::vector<std::string>& words,
                   const std::string& reason) {
  if (words.empty()) {
    return Usage("labels", "are missing", "write them behind the file, for example subject=3");
  }
  HAPTOMETER_LET(auto labels, cli::ReadKeyValues(words, "label", "subject=3"));
  RemarkOnLabels(kLabelText.name, labels);
  const trial::Event event{
      .kind = trial::EventKind::kLabels, .text = reason, .labels = std::move(labels)};
  return Append(path, event,
                {"write the label into it, as a line '# label.subject = 3' above the columns",
                 "label the trial itself and export it again"});
}

}  // namespace

int RunTrialLabel(int argc, const char* const* argv) {
  std::string path;
  std::string reason;
  std::vector<std::string> words;
  std::vector<std::string> more;
  cli::Options options(kLabelText);
  options.Positional("file", &path, "trial.bin");
  options.Positionals("labels", &words, "key=value ...", 0);
  // accepted as in acquire
  options.Repeated("--label", &more, "KEY=VALUE", "The same as the positional key=value",
                   cli::Shown::kHelpAll);
  options.Text("--reason", &reason, "TEXT", "Reason, stored with the labels");
  if (const auto status = options.Parse(argc, argv)) return *status;
  words.insert(words.end(), more.begin(), more.end());
  if (auto done = Label(path, words, reason); !done) {
    return cli::ReportError(kLabelText.name, done.error());
  }
  return ShowChanged(kLabelText, path, options.json(), argc, argv);
}

// trial exclude and trial include: whether studies use the trial.
namespace {

constexpr cli::VerbText kExcludeText{
    .name = "trial exclude",
    .summary =
        "Exclude a trial from studies, with the reason; nothing that was recorded is changed.",
    .examples = {"haptometer trial exclude trial.bin --reason 'finger slipped'",
                 "haptometer trial exclude trial.bin --reason 'drive was off' --json",
                 "haptometer trial include trial.bin"}};

constexpr cli::VerbText kIncludeText{
    .name = "trial include",
    .summary = "Include an excluded trial in studies again; the exclusion stays in its history.",
    .examples = {"haptometer trial include trial.bin",
                 "haptometer trial include trial.bin --reason 'the other trial was meant'",
                 "haptometer trial exclude trial.bin --reason 'finger slipped'"}};

// the event that `kind` asks for; nothing is appended to a trial that is not excluded
Result<void> SetExclusion(const std::string& path, trial::EventKind kind, std::string reason) {
  const bool excludes = kind == trial::EventKind::kExcluded;
  if (excludes && reason.find_first_not_of(' ') == std::string::npos) {
    return Usage("--reason", "is missing", "state why, for example --reason 'finger slipped'");
  }
  if (excludes && reason.starts_with(kSessionReason)) {
    return Usage("--reason",
                 fmt::format("begins with '{}', as those of a session do", kSessionReason),
                 "write it in other words");
  }
  if (!excludes) {
    HAPTOMETER_LET(const auto recording, trial::ReadRecording(path));
    const auto present = trial::ExclusionOf(recording.record.metadata);
    if (!present) {
      cli::Remark(kIncludeText.name, fmt::format("{}: is not excluded; unchanged", path));
      return {};
    }
    const std::string by_session = ExclusionBySession(path);
    if (!by_session.empty() && present->starts_with(kSessionReason)) {
      return Usage(path, "is excluded by the log of its " + by_session,
                   "haptometer session accept lets an attempt count");
    }
    // the user's exclusion ends, and that of the session holds again
    if (!by_session.empty()) {
      cli::Remark(kIncludeText.name, fmt::format("{}: is excluded by its session again", path));
      kind = trial::EventKind::kExcluded;
      reason = by_session;
    }
  }
  return Append(
      path, {.kind = kind, .text = reason.empty() ? "in studies again" : reason},
      {excludes ? "write the reason into it, as a line '# excluded = finger slipped' above "
                  "the columns"
                : "remove its line '# excluded = ...'",
       fmt::format("{} the trial itself and export it again", excludes ? "exclude" : "include")});
}

int RunExclusion(const cli::VerbText& text, trial::EventKind kind, int argc,
                 const char* const* argv) {
  std::string path;
  std::string reason;
  cli::Options options(text);
  options.Positional("file", &path, "trial.bin");
  options.Text("--reason", &reason, "TEXT", "Reason, stored in the trial");
  if (const auto status = options.Parse(argc, argv)) return *status;
  if (auto done = SetExclusion(path, kind, reason); !done) {
    return cli::ReportError(text.name, done.error());
  }
  return ShowChanged(text, path, options.json(), argc, argv);
}

}  // namespace

int RunTrialExclude(int argc, const char* const* argv) {
  return RunExclusion(kExcludeText, trial::EventKind::kExcluded, argc, argv);
}

int RunTrialInclude(int argc, const char* const* argv) {
  return RunExclusion(kIncludeText, trial::EventKind::kIncluded, argc, argv);
}

// trial plot: a recording over time.
namespace {

constexpr cli::VerbText kPlotText{
    .name = "trial plot",
    .summary =
        "Draw a recording over time; gaps stay open, bad samples are marked, peaks are kept.",
    .examples = {"haptometer trial plot trial.bin -o trial.svg",
                 "haptometer trial plot trial.bin --plot trial.png",
                 "haptometer trial plot s.csv --columns time_s,displacement_mm -o scope.pdf"}};

Result<void> Draw(const std::string& input, const std::string& output,
                  const cli::ImportWords& words) {
  if (output.empty()) return Usage("-o", "is missing", "name the plot, e.g. -o trial.svg");
  HAPTOMETER_TRY(plot::CheckPlotPath(output));
  HAPTOMETER_LET(const auto import, cli::ImportOf(words, {&input, 1}));
  HAPTOMETER_LET(auto recording, ReadAndTell(kPlotText.name, input, import));
  HAPTOMETER_LET(const auto shown, WithoutCodes(std::move(recording)));
  for (const dsp::Finding& found : shown.findings.list()) {
    cli::Remark(kPlotText.name, fmt::format("{}: {}", input, document::WordsOf(found)));
  }
  // at most kMostPanels channels are drawn; a remark states the others
  const trial::Record& record = shown.recording.record;
  if (record.rows == 0) return CannotAnswer(input, "holds no rows", "record again");
  if (record.channels.size() > kMostPanels) {
    cli::Remark(kPlotText.name, fmt::format("the first {} of {} channels are drawn", kMostPanels,
                                            record.channels.size()));
  }
  return plot::DrawPanels(output, PanelsOf(record));
}

}  // namespace

int RunTrialPlot(int argc, const char* const* argv) {
  std::string input;
  std::string output;
  cli::ImportWords import;
  cli::Options options(kPlotText);
  options.Positional("file", &input,
                     "trial.bin, CSV with time_s, LabVIEW .lvm, HDF5, NPY, MAT, WAV");
  options.Output("-o,--output,--plot", &output, "FILE.svg|png|pdf",
                 "Plot to write; an older plot of haptometer is replaced");
  cli::DeclareImport(&options, &import);
  if (const auto status = options.Parse(argc, argv)) return *status;
  const auto done = Draw(input, output, import);
  return done ? 0 : cli::ReportError(kPlotText.name, done.error());
}

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kPartOfMotion = 1e-6;

// a measurement (status ok or repeated) with a finite value
bool IsGood(const trial::Channel& channel, std::size_t row) {
  return IsMeasurement(channel.statuses[row]) && std::isfinite(channel.values[row]);
}

// of the measurements; 0 where there is none
double MeanOf(const trial::Channel& channel) {
  // differences from the first value, so that a large offset costs no digits
  double sum = 0;
  double count = 0;
  double first = 0;
  for (std::size_t row = 0; row < channel.values.size(); ++row) {
    if (!IsGood(channel, row)) continue;
    if (count == 0) first = channel.values[row];
    sum += channel.values[row] - first;
    count += 1;
  }
  return count == 0 ? 0 : first + sum / count;
}

// "displacement about 30012.3 um", to the resolution of the channel; what rounding leaves of a mean
// of 0 is below a millionth of the motion
std::string Title(const trial::Channel& channel, double mean, double largest) {
  const double factor = channel.unit == "m" ? 1e6 : 1;
  const double resolution = std::max(channel.resolution * factor, kPartOfMotion * largest);
  return fmt::format("{} about {} {}", channel.name,
                     document::NumberText(mean * factor, 0, resolution, 6),
                     factor == 1 ? channel.unit : "um");
}

}  // namespace

// displacement in um about its mean; samples without measurement are marked at the lowest value
plot::Panel PanelOf(const trial::Record& record, const trial::Channel& channel) {
  HAPTOMETER_CHECK(record.rows > 0, "no rows to draw");
  const double factor = channel.unit == "m" ? 1e6 : 1;
  const double mean = MeanOf(channel);
  plot::Series line{.title = "", .style = plot::Lines(plot::kBlue)};
  plot::Series bad{
      .title = "",
      .style = {.mark = plot::Mark::kPoints, .colour = plot::kOrange, .size = 0.6, .point = 2}};
  double lowest = 0, largest = 0;  // of the deviations; in size
  for (const trial::Stretch& stretch : record.stretches) {
    // a point without value interrupts the line between two segments
    if (!line.x.empty()) {
      line.x.push_back(stretch.start_s);
      line.y.push_back(kNan);
    }
    for (std::size_t i = 0; i < stretch.rows; ++i) {
      const std::size_t row = stretch.first_row + i;
      // time of row i in s: begin of the segment plus i / rate
      const double time_s = stretch.start_s + static_cast<double>(i) / stretch.rate_hz;
      const bool is_good = IsGood(channel, row);
      const double y = is_good ? (channel.values[row] - mean) * factor : kNan;
      line.x.push_back(time_s);
      line.y.push_back(y);
      if (is_good) lowest = std::min(lowest, y);
      if (is_good) largest = std::max(largest, std::abs(y));
      if (!is_good) bad.x.push_back(time_s);
    }
  }
  bad.y.assign(bad.x.size(), lowest);
  plot::Panel panel{.title = Title(channel, mean, largest),
                    .x_label = "time / s",
                    .y_label = fmt::format("{} / {}", Name(channel.role),
                                           channel.unit == "m" ? "um" : channel.unit),
                    .series = {std::move(line)}};
  if (!bad.x.empty()) {
    bad.title = fmt::format("{} bad", bad.x.size());
    panel.series.push_back(std::move(bad));
  }
  return panel;
}

std::vector<plot::Panel> PanelsOf(const trial::Record& record) {
  std::vector<plot::Panel> panels;
  for (std::size_t c = 0; c < std::min(record.channels.size(), kMostPanels); ++c) {
    panels.push_back(PanelOf(record, record.channels[c]));
  }
  return panels;
}

Result<ShownRecording> WithoutCodes(trial::Recording recording) {
  ShownRecording shown;
  trial::Record& record = recording.record;
  for (std::size_t c = 0; record.rows > 0 && c < record.channels.size(); ++c) {
    trial::Channel& channel = record.channels[c];
    if (channel.role != trial::ChannelRole::kDisplacement || channel.unit != "m") continue;
    HAPTOMETER_LET(const auto clean, dsp::Clean(trial::RecordRows(record), c));
    for (const dsp::NoReadingCode& code : clean.codes) {
      shown.findings.Add({.kind = dsp::FindingKind::kNoReadingCodes,
                          .numbers = {{"value_m", code.value}, {"readings", code.rows}},
                          .subject = channel.name});
      for (std::size_t row = 0; row < record.rows; ++row) {
        if (channel.values[row] != code.value) continue;
        channel.values[row] = kNan;
        channel.statuses[row] = code.status;
      }
    }
  }
  shown.recording = std::move(recording);
  return shown;
}

Result<trial::Recording> ReadAndTell(std::string_view verb, const std::string& path,
                                     const trial::ImportOptions& import) {
  HAPTOMETER_LET(auto recording, trial::ReadRecording(path, import));
  for (const trial::Finding& found : recording.report.AllFindings().list()) {
    cli::Remark(verb, fmt::format("{}: {}", path, document::WordsOf(found)));
  }
  return recording;
}

}  // namespace haptometer::tools
