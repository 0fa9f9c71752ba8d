#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "tools/cli/options.h"
#include "tools/cli/shared_options.h"
#include "tools/cli/terminal.h"
#include "tools/document/keys.h"
#include "tools/document/present.h"
#include "tools/plot/gnuplot.h"
#include "tools/trial/trial.h"
#include "trial/import/read_recording.h"

// trial info: what a recording holds.

namespace haptometer::tools {
namespace {

using document::Detail;
using document::Item;
using document::Key;
using document::Section;
using document::TextOrNotKnown;
using trial::Channel;
using trial::Event;
using trial::EventKind;
using trial::kSampleStatusCount;
using trial::Metadata;
using trial::Record;
using trial::Recording;
using trial::SampleStatus;
using trial::Stretch;

using StatusCounts = std::array<std::uint64_t, kSampleStatusCount>;

StatusCounts CountStatuses(const Channel& channel) {
  StatusCounts counts{};
  for (const SampleStatus status : channel.statuses) ++counts[static_cast<std::size_t>(status)];
  return counts;
}

// rows per second within the segments; nothing where no segment has two rows
std::optional<double> MeanRate(const Record& record) {
  double intervals = 0;
  double duration_s = 0;
  for (const Stretch& stretch : record.stretches) {
    if (stretch.rows < 2 || !std::isfinite(stretch.rate_hz)) continue;
    // n rows enclose n - 1 intervals, and a segment of one row has no rate
    intervals += static_cast<double>(stretch.rows - 1);
    duration_s += static_cast<double>(stretch.rows - 1) / stretch.rate_hz;
  }
  if (duration_s == 0) return std::nullopt;
  return intervals / duration_s;
}

// from the first row to the last
std::optional<double> Duration(const Record& record) {
  if (record.rows == 0) return std::nullopt;
  return TimeOf(record, record.rows - 1) - TimeOf(record, 0);
}

// --- sections ---

// keys of more than one place
constexpr Key kLabels{"labels", "label"};
constexpr Key kRow{"row", "before row"};

// names from the file become keys of the document
Section TextsSection(const Key& list, const std::map<std::string, std::string>& texts) {
  Section section{.name = list.name};
  for (const auto& [key, text] : texts) {
    section.Add({key}, text).label = fmt::format("{} {}", list.label, key);
  }
  return section;
}

Section HeaderSection(const Metadata& metadata) {
  Section section;
  section.Add(document::kSource, TextOrNotKnown(metadata.source));
  section.Add(document::kSensor, TextOrNotKnown(metadata.sensor));
  section.Add({"head", "head"}, TextOrNotKnown(metadata.head));
  section.Add({"averages", "samples averaged in a reading"}, metadata.averages);
  section.Add({"sampling_s", "sampled every", document::kSecond}, metadata.sampling_s);
  section.Add({"hold", "hold"}, TextOrNotKnown(metadata.hold));
  section.Add({"nominal_rate_hz", "nominal rate", document::kHertz}, metadata.nominal_rate_hz);
  section.Add({"utc_start", "recorded"}, TextOrNotKnown(metadata.utc_start));
  section.Add({"laser_spot", "laser spot"}, TextOrNotKnown(metadata.laser_spot));
  section.Add({"drive_frequency_hz", "drive", document::kHertz}, metadata.drive_frequency_hz);
  section.Add({"drive_amplitude_v", "drive amplitude", document::kVolt},
              metadata.drive_amplitude_v);
  // a tare of 0 is given in JSON only
  Item& tare = section.Add({"tare_m", "tare", document::kMetre}, metadata.tare_m);
  if (metadata.tare_m == 0) tare.label.clear();
  section.Add({document::kNotes.name, metadata.notes.empty() ? "" : document::kNotes.label},
              metadata.notes);
  section.sections = {TextsSection(kLabels, metadata.labels),
                      TextsSection({"fields", "field"}, metadata.fields)};
  return section;
}

// where and how it was recorded
Section OriginSection(const Metadata& metadata) {
  Section section{.detail = Detail::kAll};
  section.Add({"host", "host"}, TextOrNotKnown(metadata.host));
  section.Add({"command_line", "command"}, TextOrNotKnown(metadata.command_line));
  return section;
}

// counts of all statuses for JSON
Section StatusSection(const StatusCounts& counts) {
  Section section{.name = "statuses"};
  for (std::size_t i = 0; i < counts.size(); ++i) {
    section.Add({Name(static_cast<SampleStatus>(i))}, counts[i]);
  }
  return section;
}

// those that occur: "90 ok, 10 over"
std::string StatusText(const StatusCounts& counts) {
  std::string words;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    words += fmt::format("{}{} {}", words.empty() ? "" : ", ", counts[i],
                         Name(static_cast<SampleStatus>(i)));
  }
  return words;
}

Section ChannelSection(const Channel& channel, StatusCounts& all) {
  const StatusCounts counts = CountStatuses(channel);
  // sum over all channels
  for (std::size_t i = 0; i < counts.size(); ++i) all[i] += counts[i];
  const std::string_view role = Name(channel.role);
  Section section{.heading =
                      fmt::format("channel {}{}{}", channel.name, channel.name == role ? "" : ", ",
                                  channel.name == role ? "" : role)};
  section.sections = {StatusSection(counts)};
  // the unit of the file; metres are shown with a prefix
  const document::Unit unit =
      channel.unit == document::kMetre.symbol
          ? document::kMetre
          : document::Unit{.symbol = channel.unit, .spoken = {{{1, channel.unit}}}};
  using Number = std::optional<double>;
  section.Add(document::kName, channel.name);
  section.Add({"role"}, role);
  section.Add(document::kUnit, channel.unit);
  section.Add({"range_min"}, channel.range_min);
  section.Add({"range_max"}, channel.range_max);
  // resolution of the document: a picometre, below which no sensor resolves
  section
      .Add({"resolution", "resolution", unit},
           channel.resolution > 0 ? Number(channel.resolution) : Number())
      .resolution = channel.unit == "m" ? 1e-12 : 0;
  const bool has_range = std::isfinite(channel.range_min) && std::isfinite(channel.range_max);
  if (has_range) {
    section.Add({"", "range", unit}, document::Range{channel.range_min, channel.range_max});
  }
  section.Add({"", "samples"}, StatusText(counts));
  return section;
}

// row after the gap, its begin and length in s; a segment ends one sample interval after its last
// row
Section GapsSection(const Record& record) {
  Section list{.name = document::kGaps.name, .heading = "gaps", .shape = Section::Shape::kTable};
  for (std::size_t i = 1; i < record.stretches.size(); ++i) {
    const Stretch &before = record.stretches[i - 1], &after = record.stretches[i];
    const double end_s = before.start_s + static_cast<double>(before.rows) / before.rate_hz;
    // a segment may begin within the last interval of the one before
    if (after.start_s <= end_s) continue;
    Section& row = list.sections.emplace_back();
    row.Add(kRow, after.first_row);
    row.Add({"at_s", "at", document::kSecond}, end_s);
    row.Add({document::kLength.name, "length", document::kSecond}, after.start_s - end_s);
  }
  return list;
}

Section StretchesSection(const Record& record) {
  Section list{.name = "stretches",
               .heading = "segments",
               .shape = Section::Shape::kTable,
               .detail = Detail::kAll};
  for (const Stretch& stretch : record.stretches) {
    Section& row = list.sections.emplace_back();
    row.Add(document::kFirstRow, stretch.first_row);
    row.Add(document::kRows, stretch.rows);
    row.Add({"start_s", "start", document::kSecond}, stretch.start_s);
    row.Add(document::kRate, stretch.rate_hz);
    row.Add(document::kTimeUncertainty, stretch.time_uncertainty_s).resolution =
        stretch.time_uncertainty_s / 10;
  }
  return list;
}

// "subject: 1 -> 4 (wrong subject noted), 2026-03-01T12:00:00Z"; `labels` are those before
void AddLabels(const Event& event, std::map<std::string, std::string>& labels, Section& section) {
  Section given{.name = kLabels.name};
  for (const auto& [key, value] : event.labels) {
    given.Add({key}, value);
    const auto before = labels.find(key);
    std::string change = before == labels.end() || before->second == value
                             ? fmt::format("{}: {}", key, value)
                             : fmt::format("{}: {} -> {}", key, before->second, value);
    if (!event.text.empty()) change += fmt::format(" ({})", event.text);
    if (!event.utc.empty()) change += ", " + event.utc;
    section.Add({"", "label"}, std::move(change));
    labels[key] = value;
  }
  section.sections = {std::move(given)};
}

// events in the order of the file; the header has the latest value of each label
Section EventsSection(const trial::ReadReport& report) {
  Section list{.name = document::kEvents.name, .shape = Section::Shape::kArray};
  std::map<std::string, std::string> known = report.first_labels;
  for (const Event& event : report.events) {
    Section& section = list.sections.emplace_back();
    // time of the event in s; not every event has one
    std::optional<double> time_s;
    if (event.time_ns) time_s = 1e-9 * static_cast<double>(*event.time_ns);
    section.Add({"event"}, Name(event.kind));
    section.Add({kRow.name}, event.row);
    section.Add(document::kTime, time_s);
    Item& text = section.Add(document::kText, event.text);
    // in the text those with a text; a time base has none, labels have a line each, and what was
    // doubted is a finding
    const bool has_line = event.kind != EventKind::kTimeBase && event.kind != EventKind::kLabels &&
                          !event.text.starts_with(trial::kDoubtMark);
    if (has_line && !event.text.empty()) {
      text.label = Name(event.kind);
      text.note = event.utc.empty() ? fmt::format("before row {}", event.row) : event.utc;
    }
    section.Add({document::kUtc.name}, document::TextOrNotKnown(event.utc));
    AddLabels(event, known, section);
  }
  return list;
}

// parts of the file that could not be read, with the rows that they contained
Section LossesSection(const std::vector<trial::Loss>& losses) {
  Section list{.name = "losses", .shape = Section::Shape::kArray};
  for (const trial::Loss& loss : losses) {
    Section& section = list.sections.emplace_back();
    section.Add(document::kWhat, document::SentenceOf(loss.kind).kind);
    section.Add({"offset"}, loss.offset);
    section.Add(document::kBytes, loss.bytes);
    section.Add({document::kFirstRow.name}, loss.first_row);
    section.Add({document::kRows.name}, loss.rows);
  }
  return list;
}

// end of the file: finished, cut short, or unknown for imported files
std::string FileText(const trial::ReadReport& report) {
  const char* end =
      report.closed ? "finished by its recorder" : "cut short, or still being recorded";
  if (report.kind == trial::FileKind::kTrial) return end;
  if (report.is_export) return fmt::format("exported to {}; {}", Name(report.kind), end);
  return fmt::format("imported from {}", Name(report.kind));
}

Section RowsSection(const std::string& path, const Recording& recording) {
  const Record& record = recording.record;
  const trial::ReadReport& report = recording.report;
  // a table (CSV, LVM) has no end mark
  const bool is_end_known = report.kind == trial::FileKind::kTrial || report.is_export;
  Section section;
  section.Add(document::kFile, path);
  section.Add(document::kKind, Name(report.kind));
  section.Add({"closed"}, is_end_known ? std::optional(report.closed) : std::optional<bool>());
  section.Add(document::kRows, record.rows);
  section.Add(document::kDuration, Duration(record));
  section.Add(document::kRate, MeanRate(record));
  section.Add({"timing"}, Name(record.timing));
  // the largest of the segments; a uniform record has one clock and none of single times
  double worst_s = 0;
  for (const Stretch& of : record.stretches) worst_s = std::max(worst_s, of.time_uncertainty_s);
  Item& uncertainty = section.Add(document::kTimeUncertainty, worst_s);
  uncertainty.resolution = worst_s / 10;
  if (record.timing == trial::Timing::kUniform) uncertainty.label.clear();
  section.Add({"", "file"}, FileText(report));
  section.Add({"rows_lost"}, report.RowsLost());
  section.Add({"file_bytes"}, report.file_bytes);
  return section;
}

// the displacement, or the first channel, drawn in characters; empty without gnuplot
std::string Thumbnail(const Record& record) {
  constexpr int kColumns = 79;
  constexpr int kLines = 14;
  if (record.rows < 2 || record.channels.empty()) return {};
  const Channel* shown = record.Find(trial::ChannelRole::kDisplacement);
  const auto panel = PanelOf(record, shown != nullptr ? *shown : record.channels.front());
  const auto text = plot::DrawText(panel, kColumns, kLines);
  if (!text) return {};
  // empty lines above the title are removed
  const std::size_t first = std::min(text->find_first_not_of(" \n"), text->size());
  const std::size_t line_end = text->rfind('\n', first);
  return text->substr(line_end == std::string::npos ? 0 : line_end + 1);
}

}  // namespace

document::Document TrialDocument(std::string_view verb, const std::string& path,
                                 const ShownRecording& shown, bool has_figures) {
  const Recording& recording = shown.recording;
  const Record& record = recording.record;
  document::Document document{.verb = std::string(verb), .title = path};
  Section& root = document.root;
  root.sources = trial::SourcesOf(record.metadata, recording.report);
  StatusCounts all{};
  Section channels{.name = "channels", .shape = Section::Shape::kArray};
  for (const Channel& channel : record.channels) {
    channels.sections.push_back(ChannelSection(channel, all));
  }
  root.sections = {HeaderSection(record.metadata),
                   OriginSection(record.metadata),
                   RowsSection(path, recording),
                   std::move(channels),
                   {.detail = Detail::kAll, .sections = {StatusSection(all)}},
                   GapsSection(record),
                   StretchesSection(record),
                   EventsSection(recording.report),
                   LossesSection(recording.report.losses)};
  if (has_figures && record.rows > 0) {
    root.figures = {{.caption = "the recording", .panels = PanelsOf(record)}};
  }
  document::AddFindings(root, recording.report.AllFindings());
  document::AddFindings(root, shown.findings);
  return document;
}

namespace {

constexpr cli::VerbText kText{
    .name = "trial info",
    .summary = "Show what a recording holds: channels, rows, times, gaps, labels, losses.",
    .examples = {"haptometer trial info trial.bin", "haptometer trial info trial.bin --json",
                 "haptometer trial info scope.csv --columns time_s,displacement_mm"}};

}  // namespace

int RunTrialInfo(int argc, const char* const* argv) {
  std::string path;
  cli::ImportWords import;
  document::Outputs outputs;
  cli::Options options(kText);
  options.Positional("file", &path,
                     "trial.bin, CSV with time_s, LabVIEW .lvm, HDF5, NPY, MAT, WAV");
  options.Flag("--all", &outputs.all, "Print host, command and segments of the time base too");
  options.Output("--report", &outputs.report, "FILE.html",
                 "Write a page with all of it and a plot of the recording", cli::Shown::kHelpAll);
  cli::DeclareImport(&options, &import);
  return document::RunVerb(kText.name, options, outputs, argc, argv, [&]() -> Result<int> {
    HAPTOMETER_LET(const auto wanted, cli::ImportOf(import, {&path, 1}));
    HAPTOMETER_LET(auto recording, trial::ReadRecording(path, wanted));
    HAPTOMETER_LET(const auto shown, WithoutCodes(std::move(recording)));
    const int status = document::Present(
        TrialDocument(kText.name, path, shown, outputs.HasFigures()), outputs, argc, argv);
    // the drawing in characters is for the text only
    if (!outputs.json) cli::Print(Thumbnail(shown.recording.record));
    return status;
  });
}

}  // namespace haptometer::tools
