#pragma once

#include <memory>
#include <string>

#include "base/error.h"
#include "trial/import/import_options.h"
#include "trial/row_source.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {

/// A measurement from a file of any kind that is known, told apart by its first bytes: trial.bin,
/// HDF5, NPY, MAT and WAV of this program or another, LabVIEW measurement, CSV. One trial, or one
/// table, of several in an HDF5 or MAT is `FILE.h5/NAME`; NAME may be a path.
///
/// What was assumed on the way stands in report.findings; show it. `options` are about foreign
/// tables only.
/// Errors (Cause::kCannotAnswer): as TrialReader::Open and trial/import/readers.h; bytes that are
/// none of them give one message that names the kinds, and those of a kind that is known and not
/// read (TDMS, archives ...) one that names it. Cause::kUsage: `options` and the
/// file contradict each other.
[[nodiscard]] Result<Recording> ReadRecording(const std::string& path,
                                              const ImportOptions& options = {});

/// Whether ReadRecording takes `path` for a table, to which ImportOptions apply, by its first
/// bytes; an HDF5, NPY, MAT or WAV is read for that, to tell an export of this program. What is no
/// regular file or cannot be read counts as one: the reader has the message.
[[nodiscard]] bool IsTable(const std::string& path);

/// A recording to be read by range and how well it could be read.
struct OpenedRows {
  std::unique_ptr<RowSource> rows;
  ReadReport report{};
};

/// The rows of a recording of any kind that ReadRecording knows, the same as it gives.
///
/// A trial.bin of uniform timing stays in its file (trial/trial_rows.h), however long it is;
/// everything else is read into memory. `threads` check it and change nothing. Errors: as
/// ReadRecording.
[[nodiscard]] Result<OpenedRows> OpenRows(const std::string& path,
                                          const ImportOptions& options = {}, int threads = 1);

}  // namespace haptometer::trial
