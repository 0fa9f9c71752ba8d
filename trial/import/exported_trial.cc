#include "trial/import/exported_trial.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "trial/export/object_names.h"
#include "trial/import/table/csv_header.h"
#include "trial/trial_format.h"

namespace haptometer::trial {
namespace {

using Json = nlohmann::ordered_json;

// the lines of a text, without empty ones
std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    if (end > at) lines.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

// whether the segments cover `rows` rows in order
bool Covers(const std::vector<Stretch>& stretches, std::size_t rows) {
  std::size_t row = 0;
  for (const Stretch& stretch : stretches) {
    if (stretch.first_row != row || stretch.rows == 0 || stretch.rows > rows - row) return false;
    if (!std::isfinite(stretch.start_s) || !(stretch.rate_hz > 0)) return false;
    row += stretch.rows;
  }
  return row == rows;
}

Result<std::vector<Stretch>> ReadStretches(ExportedObjects& objects, std::size_t rows) {
  // five numbers per segment: first_row, rows, start_s, rate_hz, time_uncertainty_s
  HAPTOMETER_LET(const auto numbers,
                 objects.Doubles(objects::kStretches, objects::kStretchNumbers));
  std::vector<Stretch> stretches;
  constexpr double kMostRows = kMostNumbers;
  for (std::size_t i = 0; i < numbers.size(); i += objects::kStretchNumbers) {
    const double* n = numbers.data() + i;
    // counts are stored as doubles: checked before they are converted
    const bool is_count = n[0] >= 0 && n[0] <= kMostRows && n[1] >= 0 && n[1] <= kMostRows;
    if (!is_count) return objects.Wrong(objects::kStretches, "do not describe its rows");
    stretches.push_back({.first_row = static_cast<std::size_t>(n[0]),
                         .rows = static_cast<std::size_t>(n[1]),
                         .start_s = n[2],
                         .rate_hz = n[3],
                         .time_uncertainty_s = n[4]});
  }
  if (!Covers(stretches, rows))
    return objects.Wrong(objects::kStretches, "do not describe its rows");
  return stretches;
}

// `times_s`: the exported times, which are the readings' own where these are known
Result<void> ReadTimes(ExportedObjects& objects, std::vector<double> times_s, Record* record) {
  HAPTOMETER_LET(record->stretches, ReadStretches(objects, record->rows));
  record->times_are_known = objects.Flag(objects::kTimesAreKnown);
  if (record->times_are_known) {
    const bool is_sound = std::ranges::all_of(times_s, [](double t) { return std::isfinite(t); }) &&
                          std::ranges::is_sorted(times_s);
    if (!is_sound) return objects.Wrong(objects::kTimes, "do not grow");
    record->raw_times_s = std::move(times_s);
    return {};
  }
  // arrival times only where the source's times lie on no grid
  const char* name =
      objects.Has(objects::kArrivalTimes) ? objects::kArrivalTimes : objects::kFormerArrivalTimes;
  if (!objects.Has(name)) return {};
  HAPTOMETER_LET(auto raw, objects.Doubles(name, 1));
  if (raw.size() != record->rows) return objects.Wrong(name, "has another length");
  record->raw_times_s = std::move(raw);
  return {};
}

// values and statuses of one channel, of equal length, without numbers that are no measurements
Result<void> ReadChannel(ExportedObjects& objects, const std::string& column, std::size_t rows,
                         Channel* channel) {
  HAPTOMETER_LET(auto values, objects.Doubles(column, 1));
  const std::string status_name = objects::StatusName(column);
  HAPTOMETER_LET(const auto statuses, objects.Bytes(status_name));
  if (values.size() != rows) return objects.Wrong(column, "has another length");
  if (statuses.size() != rows) return objects.Wrong(status_name, "has another length");
  channel->statuses.reserve(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    if (statuses[row] >= kSampleStatusCount) return objects.Wrong(status_name, "is none");
    const auto status = static_cast<SampleStatus>(statuses[row]);
    channel->statuses.push_back(status);
    // a number beside a status that is none is not kept, as everywhere
    if (!IsMeasurement(status)) values[row] = std::numeric_limits<double>::quiet_NaN();
  }
  channel->values = std::move(values);
  return {};
}

// the header comes first: it names the channels, whose columns have the names of a CSV
Result<Record> ReadRecordOf(ExportedObjects& objects) {
  HAPTOMETER_LET(const auto json, objects.Text(objects::kHeader));
  const auto header = HeaderFromJson(json);
  if (!header) return objects.Wrong(objects::kHeader, "is not a trial's header");
  // the times give the number of rows; they are computed again from the segments
  HAPTOMETER_LET(auto times_s, objects.Doubles(objects::kTimes, 1));
  Record record;
  record.rows = times_s.size();
  record.timing = header->timing;
  record.metadata = header->metadata;
  HAPTOMETER_TRY(ReadTimes(objects, std::move(times_s), &record));
  for (const ChannelFormat& format : header->channels) record.channels.push_back(ChannelOf(format));
  const std::vector<std::string> columns = CsvColumnNames(record.channels);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    HAPTOMETER_TRY(ReadChannel(objects, columns[c], record.rows, &record.channels[c]));
  }
  return record;
}

}  // namespace

std::unexpected<Error> ExportedObjects::Wrong(const std::string& object,
                                              const std::string& what) const {
  return CannotAnswer(where_, fmt::format("its {} {}", object, what),
                      "export the trial again with haptometer trial export");
}

Result<Recording> ReadExportedTrial(ExportedObjects& objects, FileKind kind) {
  HAPTOMETER_LET(auto record, ReadRecordOf(objects));
  Recording recording{.record = std::move(record), .report = {}};
  ReadReport& report = recording.report;
  report.kind = kind;
  report.is_export = true;
  report.closed = objects.Flag(objects::kClosed);
  // an export is complete: no rows beyond those that it holds
  report.rows = report.next_row = recording.record.rows;
  if (objects.Has(objects::kEvents)) {
    HAPTOMETER_LET(const auto events, objects.Text(objects::kEvents));
    for (const std::string& line : Lines(events)) {
      const auto event = EventFromJson(line);
      if (!event) return objects.Wrong(objects::kEvents, "hold a line that is none");
      report.events.push_back(*event);
    }
  }
  if (objects.Has(objects::kRemarks)) {
    HAPTOMETER_LET(const auto remarks, objects.Text(objects::kRemarks));
    for (std::string& line : Lines(remarks)) {
      report.findings.Note(FindingKind::kNotedAtExport, {{"text", std::move(line)}});
    }
  }
  return recording;
}

bool ObjectsInMemory::Has(const std::string& object) {
  return numbers.contains(object) || bytes.contains(object) || texts.contains(object);
}

Result<std::vector<double>> ObjectsInMemory::Doubles(const std::string& object, std::size_t width) {
  const auto found = numbers.find(object);
  if (found == numbers.end()) return Wrong(object, "is missing, or is of another type");
  if (found->second.size() % width != 0) return Wrong(object, "has another shape");
  return std::move(found->second);
}

Result<std::vector<std::uint8_t>> ObjectsInMemory::Bytes(const std::string& object) {
  const auto found = bytes.find(object);
  if (found == bytes.end()) return Wrong(object, "is missing, or is of another type");
  return std::move(found->second);
}

Result<std::string> ObjectsInMemory::Text(const std::string& object) {
  const auto found = texts.find(object);
  if (found == texts.end()) return Wrong(object, "is missing, or is of another type");
  return std::move(found->second);
}

bool ObjectsInMemory::Flag(const std::string& object) {
  const auto found = bytes.find(object);
  return found != bytes.end() && found->second.size() == 1 && found->second[0] != 0;
}

namespace {

void AddAll(const Json& json, ObjectsInMemory* objects) {
  objects->texts[objects::kHeader] = json.at("header").dump();
  // a line for each event and remark
  for (const Json& event : json.at("events"))
    objects->texts[objects::kEvents] += event.dump() + "\n";
  for (const Json& line : json.at("remarks")) {
    objects->texts[objects::kRemarks] += line.get<std::string>() + "\n";
  }
  auto& stretches = objects->numbers[objects::kStretches];
  for (const Json& stretch : json.at("stretches")) {
    // JSON has no infinity: the rate of rows that all have one time
    for (const Json& number : stretch) {
      stretches.push_back(number.is_null() ? std::numeric_limits<double>::infinity()
                                           : number.get<double>());
    }
  }
  for (const char* flag : {objects::kClosed, objects::kTimesAreKnown}) {
    objects->bytes[flag] = {static_cast<std::uint8_t>(json.at(flag).get<bool>() ? 1 : 0)};
  }
  objects->numbers[kSampleOffsets] = json.value(kSampleOffsets, std::vector<double>());
}

}  // namespace

Result<void> AddDescription(std::string_view json, ObjectsInMemory* objects) {
  // what lies deeper is left out: writing it as text again takes a level of the stack each
  constexpr int kDeepest = 16;
  const auto is_shallow = [](int depth, Json::parse_event_t, const Json&) {
    return depth <= kDeepest;
  };
  // any error in the text, including a wrong type, is one
  try {
    AddAll(Json::parse(json, is_shallow), objects);
  } catch (const Json::exception&) {
    return objects->Wrong("description", "is damaged");
  }
  return {};
}

}  // namespace haptometer::trial
