#pragma once

#include <string>

#include "base/error.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {

/// A trial from an HDF5 file that trial/export/hdf5.h wrote, bit for bit as it was exported:
/// record, events, whether it was closed; the losses stated at the export come as remarks.
///
/// `name`: the trial's group; empty where the file holds one trial. Objects of the file that are
/// not known here are passed over. libhdf5 is not made for hostile files, so an HDF5 file is
/// trusted not to be one; types, shapes and sizes are checked all the same.
/// Errors (Cause::kCannotAnswer): no HDF5 file, no trial in it, several and no name (they are
/// named), an object missing or of another shape or type. Memory: the record.
[[nodiscard]] Result<Recording> ReadHdf5(const std::string& path, const std::string& name);

}  // namespace haptometer::trial
