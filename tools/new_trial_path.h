#pragma once

#include <string>
#include <string_view>

namespace haptometer::tools {

/// An instant as UtcNow() gives it, for a file's name: 2026-03-01T12:00:00.123Z as
/// 20260301T120000Z.
[[nodiscard]] std::string CompactUtc(std::string_view utc);

/// `path`, or where something of this name is there already, the first of `STEM<separator>2.EXT`,
/// `STEM<separator>3.EXT`, ... that is not.
[[nodiscard]] std::string FirstFreePath(const std::string& path, char separator);

}  // namespace haptometer::tools
