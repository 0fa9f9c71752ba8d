#pragma once

#include <memory>
#include <string>

#include "base/error.h"
#include "trial/import/import_options.h"
#include "trial/row_source.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {

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
