#pragma once

#include <map>
#include <string>

namespace haptometer::tools {

/// Whether `output` names a directory, in which trials get names of their own: it ends in '/', or
/// is one.
[[nodiscard]] bool IsDirectoryName(const std::string& output);

/// A file in `directory` that does not exist yet: UTC start, sensor and labels, such as
/// `20260301T120000Z_stream_condition-adapter_subject-3.bin`; behind a name that is taken stands
/// _2, _3 and so on. Of labels, characters other than letters, digits, '.' and '-' become '_', and
/// a name is cut at 200 characters.
///
/// `utc_start` is as UtcNow() gives it.
[[nodiscard]] std::string NewTrialName(const std::string& directory, const std::string& utc_start,
                                       const std::string& sensor,
                                       const std::map<std::string, std::string>& labels);

}  // namespace haptometer::tools
