#include "tools/trial/info.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "base/text.h"
#include "tools/cli/json.h"
#include "tools/cli/options.h"
#include "tools/cli/shared_options.h"
#include "tools/cli/terminal.h"
#include "tools/plot/gnuplot.h"
#include "tools/trial/trial.h"
#include "trial/import/read_recording.h"

// trial info: what a recording holds.

namespace haptometer::tools {
namespace {

constexpr cli::VerbText kText{
    .name = "trial info",
    .summary = "What a recording holds: channels, rows, times, gaps, labels, losses.",
    .examples = {"haptometer trial info trial.bin", "haptometer trial info trial.bin --json",
                 "haptometer trial info scope.csv --columns time_s,displacement_mm"}};

}  // namespace

int RunTrialInfo(int argc, const char* const* argv) {
  std::string path;
  cli::ImportWords import;
  cli::Options options(kText);
  options.Positional("file", &path, "trial.bin, CSV with time_s, LabVIEW .lvm, HDF5");
  cli::DeclareImport(&options, &import);
  if (const auto status = options.Parse(argc, argv)) return *status;
  const auto wanted = cli::ImportOf(import);
  if (!wanted) return cli::ReportError(kText.name, wanted.error());
  const auto recording = trial::ReadRecording(path, *wanted);
  if (!recording) return cli::ReportError(kText.name, recording.error());
  if (options.json()) {
    PrintTrialInfoJson(path, *recording);
  } else {
    PrintTrialInfo(path, *recording);
  }
  return 0;
}

namespace {

using Json = nlohmann::ordered_json;
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

// a hole between two stretches
struct Gap {
  std::size_t row = 0;  // the first after it
  double at_s = 0;      // when the row before it ended
  double length_s = 0;
};

double EndOf(const Stretch& stretch) {
  return stretch.start_s + static_cast<double>(stretch.rows) / stretch.rate_hz;
}

std::vector<Gap> GapsOf(const Record& record) {
  std::vector<Gap> gaps;
  for (std::size_t i = 1; i < record.stretches.size(); ++i) {
    const double end_s = EndOf(record.stretches[i - 1]);
    gaps.push_back({record.stretches[i].first_row, end_s, record.stretches[i].start_s - end_s});
  }
  return gaps;
}

// rows a second within the stretches; nothing where no stretch has two rows
std::optional<double> MeanRate(const Record& record) {
  double intervals = 0;
  double duration_s = 0;
  for (const Stretch& stretch : record.stretches) {
    if (stretch.rows < 2 || !std::isfinite(stretch.rate_hz)) continue;
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

double WorstUncertainty(const Record& record) {
  double worst_s = 0;
  for (const Stretch& stretch : record.stretches) {
    worst_s = std::max(worst_s, stretch.time_uncertainty_s);
  }
  return worst_s;
}

// "  label           text"; nothing where there is no text
void Line(std::string_view label, std::string_view text) {
  if (!text.empty()) cli::Print(fmt::format("  {:<16}{}\n", label, Printable(text)));
}

// a number in six digits and without an exponent where it has any meaning
std::string Plain(double value) {
  if (value == 0 || !std::isfinite(value)) return fmt::format("{}", value);
  const double place = std::pow(10, 5 - std::floor(std::log10(std::abs(value))));
  return fmt::format("{}", std::round(value * place) / place);
}

// a value of a channel in the unit people say; nothing measures below a picometre
std::string InPeoplesUnit(double value, const std::string& unit) {
  if (unit != "m") return fmt::format("{} {}", Plain(value), unit);
  constexpr double kPicometre = 1e-12;
  return Plain(std::abs(value) < kPicometre ? 0 : value * 1e6) + " um";
}

void PrintChannel(const Channel& channel) {
  std::string text(Name(channel.role));
  if (channel.name != text) text = channel.name + ", " + text;
  if (channel.resolution > 0)
    text += ", steps of " + InPeoplesUnit(channel.resolution, channel.unit);
  if (std::isfinite(channel.range_min) && std::isfinite(channel.range_max)) {
    text += fmt::format(", range {} to {}", InPeoplesUnit(channel.range_min, channel.unit),
                        InPeoplesUnit(channel.range_max, channel.unit));
  }
  Line("channel", text);
  std::string counts;
  const StatusCounts statuses = CountStatuses(channel);
  for (std::size_t i = 0; i < statuses.size(); ++i) {
    if (statuses[i] == 0) continue;
    if (!counts.empty()) counts += ", ";
    counts += fmt::format("{} {}", statuses[i], Name(static_cast<SampleStatus>(i)));
  }
  Line("", counts);
}

void PrintMetadata(const Metadata& metadata) {
  Line("source", metadata.source);
  Line("sensor", metadata.sensor + (metadata.head.empty() ? "" : ", head " + metadata.head));
  if (metadata.averages) {
    const std::string period =
        metadata.sampling_s ? " sampled every " + Plain(*metadata.sampling_s * 1e3) + " ms" : "";
    Line("averaging", fmt::format("{} average{}{}", *metadata.averages,
                                  *metadata.averages == 1 ? "" : "s", period));
  }
  Line("recorded", metadata.utc_start);
  Line("laser spot", metadata.laser_spot);
  if (metadata.drive_frequency_hz) {
    Line("drive", Plain(*metadata.drive_frequency_hz) + " Hz");
  }
  for (const auto& [key, value] : metadata.labels)
    Line("label", fmt::format("{} = {}", key, value));
  for (const auto& [key, value] : metadata.fields)
    Line("field", fmt::format("{} = {}", key, value));
  for (const std::string& note : metadata.notes) Line("note", note);
}

void PrintTimes(const Recording& recording) {
  const Record& record = recording.record;
  std::string rows = fmt::format("{}", record.rows);
  if (const auto duration_s = Duration(record)) rows += fmt::format(" in {:.6g} s", *duration_s);
  if (const auto rate_hz = MeanRate(record)) rows += fmt::format(", {:.8g} a second", *rate_hz);
  Line("rows", rows);
  if (recording.record.timing != trial::Timing::kUniform) {
    Line("times", fmt::format("{}, straightened; true to {:.3g} ms (one standard deviation)",
                              Name(recording.record.timing), WorstUncertainty(record) * 1e3));
  }
  // many gaps are told by their number
  constexpr std::size_t kShown = 10;
  const std::vector<Gap> gaps = GapsOf(record);
  for (std::size_t i = 0; i < std::min(gaps.size(), kShown); ++i) {
    Line("gap", fmt::format("before row {}: {:.4g} ms at {:.6g} s", gaps[i].row,
                            gaps[i].length_s * 1e3, gaps[i].at_s));
  }
  if (gaps.size() > kShown) Line("", fmt::format("and {} more gaps", gaps.size() - kShown));
}

void PrintEvent(const Event& event) {
  if (event.kind == EventKind::kTimeBase) return;
  if (event.kind != EventKind::kLabels) {
    Line(Name(event.kind), fmt::format("before row {}: {}", event.row, event.text));
    return;
  }
  // the labels themselves stand above, as last given
  std::string keys;
  for (const auto& [key, value] : event.labels) keys += (keys.empty() ? "" : ", ") + key;
  if (!event.text.empty()) Line("labelled", fmt::format("{}: {}", keys, event.text));
}

// what the file says of its own end
std::string FileText(const trial::ReadReport& report) {
  const char* end =
      report.closed ? "finished by its recorder" : "cut short, or still being recorded";
  if (report.kind == trial::FileKind::kTrial) return end;
  if (report.kind == trial::FileKind::kHdf5) return fmt::format("exported to HDF5; {}", end);
  return fmt::format("imported from {}", Name(report.kind));
}

// the displacement, or what there is first, in characters; nothing where gnuplot is not there
void PrintThumbnail(const Record& record) {
  constexpr int kColumns = 79;
  constexpr int kLines = 14;
  if (record.rows < 2 || record.channels.empty()) return;
  const Channel* shown = record.Find(trial::ChannelRole::kDisplacement);
  const auto panel = PanelOf(record, shown != nullptr ? *shown : record.channels.front());
  const auto text = plot::DrawText(panel, kColumns, kLines);
  if (!text) return;
  // gnuplot leaves room above the title
  const std::size_t first = std::min(text->find_first_not_of(" \n"), text->size());
  const std::size_t line_end = text->rfind('\n', first);
  cli::Print(text->substr(line_end == std::string::npos ? 0 : line_end + 1));
}

// whether the recorder finished; null where the file cannot tell
Json ClosedOrNull(const trial::ReadReport& report) {
  const bool can_tell =
      report.kind == trial::FileKind::kTrial || report.kind == trial::FileKind::kHdf5;
  return can_tell ? Json(report.closed) : Json(nullptr);
}

Json ToJson(const StatusCounts& counts) {
  Json json = Json::object();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    json[std::string(Name(static_cast<SampleStatus>(i)))] = counts[i];
  }
  return json;
}

Json ToJson(const Channel& channel) {
  return {{"name", channel.name},
          {"role", Name(channel.role)},
          {"unit", channel.unit},
          {"range_min", cli::NumberOrNull(channel.range_min)},
          {"range_max", cli::NumberOrNull(channel.range_max)},
          {"resolution", channel.resolution > 0 ? Json(channel.resolution) : Json(nullptr)},
          {"statuses", ToJson(CountStatuses(channel))}};
}

Json ToJson(const Stretch& stretch) {
  return {{"first_row", stretch.first_row},
          {"rows", stretch.rows},
          {"start_s", stretch.start_s},
          {"rate_hz", cli::NumberOrNull(stretch.rate_hz)},
          {"time_uncertainty_s", stretch.time_uncertainty_s}};
}

Json ToJson(const Event& event) {
  return {{"event", Name(event.kind)},
          {"row", event.row},
          {"time_s", event.time_ns ? Json(1e-9 * static_cast<double>(*event.time_ns)) : Json()},
          {"text", event.text},
          {"labels", event.labels}};
}

Json ToJson(const trial::Loss& loss) {
  return {{"what", loss.what},
          {"offset", loss.offset},
          {"bytes", loss.bytes},
          {"first_row", loss.first_row},
          {"rows", cli::CountOrNull(loss.rows)}};
}

Json ToJson(const Metadata& metadata) {
  return {{"source", cli::TextOrNull(metadata.source)},
          {"sensor", cli::TextOrNull(metadata.sensor)},
          {"head", cli::TextOrNull(metadata.head)},
          {"sampling_s", cli::NumberOrNull(metadata.sampling_s)},
          {"averages", metadata.averages ? Json(*metadata.averages) : Json(nullptr)},
          {"hold", cli::TextOrNull(metadata.hold)},
          {"nominal_rate_hz", cli::NumberOrNull(metadata.nominal_rate_hz)},
          {"laser_spot", cli::TextOrNull(metadata.laser_spot)},
          {"drive_frequency_hz", cli::NumberOrNull(metadata.drive_frequency_hz)},
          {"drive_amplitude_v", cli::NumberOrNull(metadata.drive_amplitude_v)},
          {"tare_m", metadata.tare_m},
          {"utc_start", cli::TextOrNull(metadata.utc_start)},
          {"host", cli::TextOrNull(metadata.host)},
          {"command_line", cli::TextOrNull(metadata.command_line)},
          {"labels", metadata.labels},
          {"fields", metadata.fields},
          {"notes", metadata.notes}};
}

template <typename T>
Json ListOf(const std::vector<T>& items) {
  Json list = Json::array();
  for (const T& item : items) list.push_back(ToJson(item));
  return list;
}

}  // namespace

void PrintTrialInfo(const std::string& path, const Recording& recording) {
  cli::Print(Printable(path) + "\n");
  PrintMetadata(recording.record.metadata);
  for (const Channel& channel : recording.record.channels) PrintChannel(channel);
  PrintTimes(recording);
  for (const Event& event : recording.report.events) PrintEvent(event);
  Line("file", FileText(recording.report));
  for (const trial::Loss& loss : recording.report.losses) Line("loss", Describe(loss));
  for (const std::string& remark : recording.report.remarks) Line("remark", remark);
  PrintThumbnail(recording.record);
}

void PrintTrialInfoJson(const std::string& path, const Recording& recording) {
  const Record& record = recording.record;
  Json gaps = Json::array();
  for (const Gap& gap : GapsOf(record)) {
    gaps.push_back({{"row", gap.row},
                    {"at_s", cli::NumberOrNull(gap.at_s)},
                    {"length_s", cli::NumberOrNull(gap.length_s)}});
  }
  StatusCounts statuses{};
  for (const Channel& channel : record.channels) {
    const StatusCounts own = CountStatuses(channel);
    for (std::size_t i = 0; i < own.size(); ++i) statuses[i] += own[i];
  }
  Json json{{"file", path},
            {"kind", Name(recording.report.kind)},
            {"closed", ClosedOrNull(recording.report)},
            {"rows", record.rows},
            {"duration_s", cli::NumberOrNull(Duration(record))},
            {"rate_hz", cli::NumberOrNull(MeanRate(record))},
            {"timing", Name(recording.record.timing)},
            {"time_uncertainty_s", WorstUncertainty(record)},
            {"channels", ListOf(record.channels)},
            {"statuses", ToJson(statuses)},
            {"gaps", gaps},
            {"stretches", ListOf(record.stretches)},
            {"events", ListOf(recording.report.events)},
            {"losses", ListOf(recording.report.losses)},
            {"rows_lost", cli::CountOrNull(recording.report.RowsLost())},
            {"remarks", recording.report.remarks},
            {"file_bytes", recording.report.file_bytes}};
  json.update(ToJson(record.metadata));
  cli::Print(cli::JsonText(json));
}

}  // namespace haptometer::tools
