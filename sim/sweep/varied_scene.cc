#include "sim/sweep/varied_scene.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "base/input_file.h"
#include "base/mapped.h"
#include "sim/scene/scene_file.h"
#include "trial/byte_io.h"

namespace haptometer::sim {
namespace {

namespace fs = std::filesystem;

// "scene.toml:12: [drive]" as ": [drive]", "scene.toml" as "": what stands behind path and line
std::string_view BehindPath(std::string_view where, std::string_view path) {
  where.remove_prefix(path.size());
  if (where.size() < 2 || where[0] != ':' || where[1] < '0' || where[1] > '9') return where;
  return where.substr(std::min(where.find_first_not_of("0123456789", 1), where.size()));
}

}  // namespace

VariedScene::VariedScene(std::string path, TomlTemplate document, std::size_t keys)
    : path_(std::move(path)), document_(std::move(document)), keys_(keys) {}

Result<VariedScene> VariedScene::ReadFile(const std::string& path,
                                          const std::vector<std::string>& keys) {
  HAPTOMETER_LET(const auto text, ReadInputFile(path, 1ULL << 20));
  HAPTOMETER_LET(auto document, TomlTemplate::ParseText(text, path, keys));
  return VariedScene(path, std::move(document), keys.size());
}

Result<Scene> VariedScene::Read(std::span<const SweepValue> values) const {
  const auto literals = Mapped<std::string>(values, &SweepValue::literal);
  auto scene = ReadSceneText(document_.Fill(literals), path_);
  if (scene || !scene.error().where.starts_with(path_)) return scene;
  // line numbers belong to the filled text, not to the user's file: they are removed
  Error error = scene.error();
  error.where = path_ + std::string(BehindPath(error.where, path_));
  return std::unexpected(std::move(error));
}

std::uint32_t VariedScene::Digest(std::span<const std::string> further) const {
  // keys as ?, so that the digest does not depend on a point's values
  std::string content = document_.Fill(std::vector<std::string>(keys_, "?"));
  std::vector<std::string> texts = document_.texts();
  texts.insert(texts.end(), further.begin(), further.end());
  std::ranges::sort(texts);
  for (const std::string& text : texts) {
    // any text may be the name of a file beside the scene, whose content belongs to the digest
    const std::string beside = (fs::path(path_).parent_path() / text).string();
    std::error_code none;
    if (text.empty() || !fs::is_regular_file(beside, none)) continue;
    // one that cannot be read matters only where the scene is read with it, which then reports it
    if (const auto file = ReadInputFile(beside)) content += *file;
  }
  return trial::Crc32(std::as_bytes(std::span(content)));
}

std::string WithoutPath(const Error& error, std::string_view path) {
  Error bare = error;
  if (bare.where.starts_with(path)) {
    std::string_view rest = BehindPath(bare.where, path);
    if (rest.starts_with(": ")) rest.remove_prefix(2);
    bare.where = std::string(rest);
  }
  return bare.Text();
}

}  // namespace haptometer::sim
