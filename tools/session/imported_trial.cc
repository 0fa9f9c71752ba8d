#include "tools/session/imported_trial.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "base/text.h"
#include "tools/document/document.h"
#include "trial/import/read_recording.h"
#include "trial/trial_reader.h"
#include "trial/trial_writer.h"

namespace haptometer::tools {
namespace {

// of the rate and of a place on the grid; printed times have some six digits
constexpr double kSameRate = 1e-6;
constexpr double kOnPlace = 0.01;

// the time of place 0 of the grid: that of the file where a grid from there holds its first row,
// else the first row's
double OriginOf(const trial::Stretch& first) {
  const double place = first.start_s * first.rate_hz;
  return place >= 0 && std::abs(place - std::round(place)) < kOnPlace ? 0 : first.start_s;
}

// the place of each segment's first row on one grid; nothing where the rows are not clocked, or do
// not lie on one grid
std::optional<std::vector<std::int64_t>> PlacesOn(const trial::Record& record) {
  if (record.timing != trial::Timing::kUniform || record.times_are_known) return std::nullopt;
  const trial::Stretch& first = record.stretches.front();
  std::vector<std::int64_t> places;
  places.reserve(record.stretches.size());
  std::int64_t next = 0;
  for (const trial::Stretch& stretch : record.stretches) {
    const double place = (stretch.start_s - OriginOf(first)) * first.rate_hz;
    const bool is_on_grid = std::abs(stretch.rate_hz / first.rate_hz - 1) < kSameRate &&
                            std::abs(place - std::round(place)) < kOnPlace &&
                            std::round(place) >= static_cast<double>(next);
    if (!is_on_grid) return std::nullopt;
    places.push_back(std::llround(place));
    next = places.back() + static_cast<std::int64_t>(stretch.rows);
  }
  return places;
}

// the time base of the importer
Result<void> WriteTimeBase(const trial::Record& record, trial::TrialWriter& writer) {
  for (const trial::Stretch& stretch : record.stretches) {
    HAPTOMETER_TRY(writer.AddEvent({.kind = trial::EventKind::kTimeBase, .stretch = stretch}));
  }
  return {};
}

// rows without a grid carry their own times
Result<void> WriteTimed(const trial::Record& record, trial::TrialWriter& writer,
                        const std::function<Result<void>(std::size_t, trial::Row)>& append) {
  for (std::size_t row = 0; row < record.rows; ++row) {
    const double time_s =
        record.raw_times_s.empty() ? trial::TimeOf(record, row) : record.raw_times_s[row];
    const std::int64_t time_ns = NsFromSeconds(time_s);
    HAPTOMETER_TRY(append(row, {.time_ns = time_ns, .reply_ns = time_ns}));
  }
  return WriteTimeBase(record, writer);
}

Result<void> WriteRows(const trial::Record& record, trial::TrialWriter& writer) {
  std::vector<trial::Sample> samples(record.channels.size());
  const auto append = [&](std::size_t row, trial::Row next) {
    for (std::size_t c = 0; c < samples.size(); ++c) {
      const trial::Channel& channel = record.channels[c];
      samples[c] = {trial::RawValue::F64(channel.values[row]), channel.statuses[row]};
    }
    next.samples = samples;
    return writer.Append(next);
  };
  const auto places = PlacesOn(record);
  if (!places) return WriteTimed(record, writer, append);
  for (std::size_t s = 0; s < places->size(); ++s) {
    const trial::Stretch& stretch = record.stretches[s];
    for (std::size_t i = 0; i < stretch.rows; ++i) {
      const std::int64_t place = (*places)[s] + static_cast<std::int64_t>(i);
      HAPTOMETER_TRY(append(stretch.first_row + i, {.index = place}));
    }
  }
  // a place on the grid has no uncertainty: that of printed times is in the time base
  const bool is_exact = std::ranges::all_of(
      record.stretches, [](const auto& stretch) { return stretch.time_uncertainty_s == 0; });
  return is_exact ? Result<void>{} : WriteTimeBase(record, writer);
}

// what a trial can hold of it
Result<trial::Recording> ReadFile(const std::string& path, const trial::ImportOptions& import) {
  HAPTOMETER_LET(auto recording, trial::ReadRecording(path, import));
  if (recording.record.stretches.empty()) return CannotAnswer(path, "holds no rows");
  if (recording.record.times_are_known) {
    return CannotAnswer(path, "has times on no grid, which a trial cannot hold",
                        "let the other program write rows at a fixed rate");
  }
  return recording;
}

void AddOrigin(const FolderFile& file, trial::Metadata& metadata) {
  const std::string name = Printable(file.name);
  if (metadata.source.empty() || metadata.source.starts_with("imported")) {
    metadata.source = "imported from " + name;
  }
  metadata.fields["import.file"] = name;
  metadata.fields["import.bytes"] = std::to_string(file.bytes);
  metadata.fields["import.sha256"] = file.sha256;
  metadata.fields["import.modified_ns"] = std::to_string(file.modified_ns);
}

trial::TrialHeader HeaderOfImport(const trial::Record& record) {
  trial::TrialHeader header = trial::HeaderOf(record);
  header.timing = PlacesOn(record)                           ? trial::Timing::kUniform
                  : record.timing == trial::Timing::kUniform ? trial::Timing::kArrival
                                                             : record.timing;
  return header;
}

// notes of the importer become notes of the trial, doubts a field that the verdict is by
void AddFindings(const trial::Recording& recording, trial::Metadata& metadata) {
  std::vector<std::string> doubts;
  for (const trial::Finding& found : recording.report.AllFindings().list()) {
    auto& words = found.severity == Severity::kNote ? metadata.notes : doubts;
    words.push_back(document::WordsOf(found));
  }
  if (doubts.empty()) return;
  metadata.fields[std::string(kImportDoubts)] = fmt::format("{}", fmt::join(doubts, "; "));
}

}  // namespace

AttemptSource ImportOf(const FolderSource& source, const FolderFile& file, Clock& clock,
                       std::string command_line) {
  const std::string path = std::filesystem::path(source.folder) / file.name;
  AttemptSource made{.header = {}, .write = {}, .origin = TextOf(file)};
  auto read = ReadFile(path, source.import);
  if (!read) {
    made.write = [error = read.error()](
                     const std::string& /*path*/,
                     const trial::TrialHeader& /*header*/) -> Result<acquire::RecordingSummary> {
      return std::unexpected(error);
    };
    return made;
  }
  const auto recording = std::make_shared<const trial::Recording>(*std::move(read));
  made.header = HeaderOfImport(recording->record);
  made.header.metadata.command_line = std::move(command_line);
  AddOrigin(file, made.header.metadata);
  AddFindings(*recording, made.header.metadata);
  made.write = [recording, &clock](
                   const std::string& trial,
                   const trial::TrialHeader& header) -> Result<acquire::RecordingSummary> {
    HAPTOMETER_LET(auto writer, CreateTrial(trial, header, clock));
    HAPTOMETER_TRY(WriteRows(recording->record, writer));
    HAPTOMETER_TRY(writer.Finish());
    acquire::RecordingSummary summary;
    summary.readings = recording->record.rows;
    return summary;
  };
  return made;
}

Result<AttemptOutcome> ImportAttempt(SessionFolder& session, const SessionCell& cell,
                                     const FolderSource& source, const FolderWait& wait,
                                     std::string command_line) {
  SystemClock clock;
  WatchedFolder folder(source, session.plan());
  const MonotonicNs deadline_ns = clock.Now() + NsFromSeconds(wait.longest_s);
  while (!wait.stop.load()) {
    HAPTOMETER_LET(const auto found, folder.Examine(session.state(), clock.Now()));
    if (found) {
      const SessionCell& its = found->continued.value_or(cell);
      wait.found(fmt::format("{}{}: {}", Printable(found->file.name),
                             found->continued ? ", which continues one of before" : "",
                             NameOf(its)));
      return MakeAttempt(session, its,
                         ImportOf(source, found->file, clock, std::move(command_line)));
    }
    if (clock.Now() >= deadline_ns) break;
    clock.SleepUntil(std::min(deadline_ns, clock.Now() + kExamineEveryNs));
  }
  const std::string what =
      wait.stop.load() ? "waiting for a file was interrupted"
      : folder.pending().empty()
          ? fmt::format("no new file {} came within {:g} s", source.pattern, wait.longest_s)
          : fmt::format("{} after {:g} s", folder.pending(), wait.longest_s);
  return CannotAnswer(source.folder, what,
                      "see that the other program writes there, or give --wait longer");
}

}  // namespace haptometer::tools
