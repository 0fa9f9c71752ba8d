#pragma once

#include <string>
#include <string_view>

#include "base/error.h"
#include "trial/import/import_options.h"
#include "trial/trial_reader.h"

namespace haptometer::tools {

/// Reads the recording at `path` whole and says on stderr, as remarks of `verb`, what is lost of it
/// and what was assumed. Errors: as trial::ReadRecording.
[[nodiscard]] Result<trial::Recording> ReadAndTell(std::string_view verb, const std::string& path,
                                                   const trial::ImportOptions& import);

}  // namespace haptometer::tools
