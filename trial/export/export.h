#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "trial/hdf5_id.h"
#include "trial/record.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {

/// Takes the next piece of an export, text or bytes; an error ends the export.
using PieceSink = std::function<Result<void>(std::string_view)>;

/// What a finding says, in one line.
using FindingSayer = std::function<std::string(const Finding&)>;

/// Hands `bytes` and what `append` adds to them for each of `rows` rows to `sink`, in pieces.
[[nodiscard]] Result<void> WriteInPieces(
    std::string bytes, std::size_t rows,
    const std::function<void(std::size_t row, std::string* bytes)>& append, const PieceSink& sink);

/// What every export calls `time_s`: when row `row` of `record` was measured, in seconds, as well
/// as that is known. On the clean time base, but for readings whose own times are known and lie on
/// no grid: there it is theirs. Times at which somebody asked or heard stand in a column beside it.
[[nodiscard]] inline double ExportedTimeOf(const Record& record, std::size_t row) {
  return record.times_are_known ? record.raw_times_s[row] : TimeOf(record, row);
}

/// Whether raw_times_s hold anything that ExportedTimeOf does not give.
[[nodiscard]] inline bool HasArrivalTimes(const Record& record) {
  return !record.raw_times_s.empty() && !record.times_are_known;
}

/// Writes `record` as the CSV that trial/import/readers.h reads: metadata as `# key = value`, then
/// `time_s` (trial/export/export.h), `arrival_s` where raw times stand beside it, a column
/// a channel in SI units, and a status column where any value is not ok.
///
/// Numbers are printed with the fewest digits that give the same double back. Values without a
/// measurement are empty cells, their status says why. `names`: of the channels' columns; empty:
/// CsvColumnNames.
[[nodiscard]] Result<void> WriteCsv(const Record& record, const PieceSink& sink,
                                    std::vector<std::string> names = {});

/// Writes `record` as one NumPy array with named fields: `numpy.load(f)["displacement_m"]`.
///
/// Fields: `time_s` (f8, the clean time base), `arrival_s` where raw times stand beside it, then
/// for each channel its column (f8, SI, NaN where there is no measurement) and `COLUMN_status` (u1,
/// the number of its SampleStatus). Columns are named as in a CSV
/// (trial/import/table/csv_header.h). Values, statuses and times keep their bits. A second array
/// behind the first, one text of bytes, holds the rest (trial/export/description.h): `numpy.load`
/// of a path passes over it. Form: NumPy format 1.0, or 2.0 where the head of fields needs it.
/// Errors: those of `sink`; Cause::kCannotAnswer where the record holds no channel. Cost: one pass.
[[nodiscard]] Result<void> WriteNpy(const Recording& recording, const PieceSink& sink,
                                    const FindingSayer& say = {});

/// Writes `recording` as a WAV of 64-bit floats (WAVE_FORMAT_IEEE_FLOAT) in SI units, one track a
/// channel, and returns in words what the numbers leave out; the same words stand in the file as
/// its comment (LIST INFO ICMT).
///
/// A channel's mean is taken off where each value comes back from it bit for bit (sample + offset):
/// a standing distance of 30 mm would bury micrometres of vibration in any player. Where it does
/// not, as where the channel swings about 0, the offset is 0. A list of chunks of its own (LIST
/// hapt), which players pass over, holds the metadata (`desc`, trial/export/description.h) and,
/// where one is not ok, the statuses (`stat`, a byte a value). Not kept: times of arrival.
///
/// Errors (Cause::kCannotAnswer), because a WAV has no place for what is missing and nothing is
/// invented: gaps; times of the readings' own, off any grid; values that are no measurement; a rate
/// that is no whole number of hertz to within 100 ppm (what is within is stated); more than 7281
/// channels or 4 GiB. Those of `sink`. Cost: three passes.
[[nodiscard]] Result<std::string> WriteWav(const Recording& recording, const PieceSink& sink,
                                           const FindingSayer& say = {});

/// A MATLAB file (version 5, no compression) that takes trials, a struct each: columns `time_s`,
/// one a channel (double, SI, NaN where there is no measurement) and `COLUMN_status` (uint8), named
/// as in a CSV; `arrival_s` where raw times stand beside them; `stretches`; the texts
/// `header_json`, `events_json` (a line an event) and `remarks`; `closed` and, where they are,
/// `times_are_known`. Values, statuses and times keep their bits and the metadata is whole; what
/// the source sent in counts is not kept.
class MatWriter {
 public:
  /// Makes the file at `path`, replacing one that is there. Errors (Cause::kFailed): it cannot be
  /// made.
  [[nodiscard]] static Result<MatWriter> Create(const std::string& path);

  MatWriter(MatWriter&&) noexcept;
  MatWriter& operator=(MatWriter&&) noexcept;
  ~MatWriter();

  /// Adds `recording` as the variable `name`, a MATLAB identifier of at most 63 characters that is
  /// new; `say` as for Hdf5Writer. Errors: Cause::kCannotAnswer for more than 2 GiB; Cause::kFailed
  /// when it is not written.
  [[nodiscard]] Result<void> Add(const std::string& name, const Recording& recording,
                                 const FindingSayer& say = {});

  /// Closes the file and checks by the lengths in it that all of it was written: libmatio looks at
  /// no write's outcome. Errors (Cause::kFailed): the disk is full.
  [[nodiscard]] Result<void> Close();

 private:
  struct State;
  explicit MatWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// An HDF5 file that takes trials, a group each. Lossless: times, values and statuses keep their
/// bits, header and events stay as JSON, and of a trial.bin also what the source sent (group
/// `raw`). trial/import/readers.h reads it back. docs/reference/formats.md names the objects.
///
/// One thread at a time in the whole program: libhdf5 has a global state.
class Hdf5Writer {
 public:
  /// Makes the file at `path`, replacing one that is there. Errors (Cause::kFailed): it cannot be
  /// made.
  [[nodiscard]] static Result<Hdf5Writer> Create(const std::string& path);

  /// Adds `recording` as the group `name`, which may hold no '/' and must be new. `raw`: a reader
  /// at the beginning of the trial.bin that it comes from, or nullptr. `say`: a line for each of
  /// its losses and findings; empty: without them.
  /// Errors (Cause::kFailed): the disk is full; (Cause::kCannotAnswer): `raw` cannot be read, or
  /// has fewer rows than `recording`. Memory: one column of `recording`, or of `raw` one chunk.
  [[nodiscard]] Result<void> Add(const std::string& name, const Recording& recording,
                                 TrialReader* raw, const FindingSayer& say = {});

  /// Writes what waits and closes the file. Errors (Cause::kFailed): the disk is full.
  [[nodiscard]] Result<void> Close();

 private:
  explicit Hdf5Writer(Hdf5Id file) : file_(std::move(file)) {}

  Hdf5Id file_;
};

}  // namespace haptometer::trial
