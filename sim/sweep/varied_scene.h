#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/toml.h"
#include "sim/scene/scene.h"
#include "sim/sweep/sweep_points.h"

namespace haptometer::sim {

/// A scene.toml some of whose keys take one value after the other.
class VariedScene {
 public:
  /// `keys` as "drive.frequency_hz"; those that the file lacks are added to it.
  /// Errors: the file's, and those of base/toml.h. Whether the format knows the keys shows
  /// when a scene is read.
  [[nodiscard]] static Result<VariedScene> ReadFile(const std::string& path,
                                                    const std::vector<std::string>& keys);

  /// The scene with `values`, one a key, read by the strict reader (sim/scene/scene_file.h).
  /// Errors: its own, without the line, which would be that of no file. Cost: about 20 us. Threads
  /// may share it.
  [[nodiscard]] Result<Scene> Read(std::span<const SweepValue> values) const;

  /// CRC-32 of what the scene holds besides the values of the keys: the same for the same contents,
  /// whatever its comments and its order. Files that its texts, or `further` ones, name by a path
  /// from its directory count with their contents.
  [[nodiscard]] std::uint32_t Digest(std::span<const std::string> further) const;

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  VariedScene(std::string path, TomlTemplate document, std::size_t keys);

  std::string path_;
  TomlTemplate document_;
  std::size_t keys_;
};

/// `error` as it reads where the file at `path` goes without saying: "[drive]: frequency_hz: must
/// be greater than 0; check its sign".
[[nodiscard]] std::string WithoutPath(const Error& error, std::string_view path);

}  // namespace haptometer::sim
