#pragma once

#include <memory>
#include <string>

#include "trial/byte_io.h"

namespace haptometer::tools {

/// A new file at `path` that is not worth waiting for the disk: Sync() hands the bytes to the
/// system only. For trials that go with the run that made them; a hundred syncs cost seconds.
[[nodiscard]] std::unique_ptr<trial::ByteSink> MakePassingFile(const std::string& path);

}  // namespace haptometer::tools
