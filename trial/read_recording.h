#pragma once

#include <string>

#include "base/error.h"
#include "trial/import/import_options.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {

/// A measurement from a file of any kind that is known, told apart by its first bytes: trial.bin,
/// HDF5 of this program (`FILE.h5/NAME` where it holds several), LabVIEW measurement, CSV.
///
/// What was assumed on the way stands in report.remarks; show it. `options` are about foreign
/// tables only.
/// Errors (Cause::kCannotAnswer): as TrialReader::Open, ReadHdf5, ReadLvm and ReadCsv; bytes that
/// are none of them give one message that names the kinds, and those of a kind that is known and
/// not read (WAV, NPY, MAT, TDMS, archives ...) one that names it. Cause::kUsage: `options` and the
/// file contradict each other.
[[nodiscard]] Result<Recording> ReadRecording(const std::string& path,
                                              const ImportOptions& options = {});

}  // namespace haptometer::trial
