// An archive of session pack: whatever its bytes are, each is found to be unchanged or not, within
// the room that it has; a list that is read is written as the same.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "fuzz/require.h"
#include "fuzz/seeds.h"
#include "tools/session/session_archive.h"
#include "trial/block.h"

namespace {

using namespace haptometer;

// an archive of two files, the second empty
const std::string& Archive() {
  static const std::string archive = [] {
    const std::string content = "subjects = [\"1\"]\n";
    tools::PackList list{.version = "1", .session = "day1", .utc = "now", .files = {}};
    for (const auto& [name, of] :
         {std::pair("session.toml", content), std::pair("a/b.bin", std::string())}) {
      document::Sha256 sha256;
      sha256.Add(of);
      list.files.push_back({name, of.size(), trial::Crc32(trial::BytesOfText(of)), sha256.Hex()});
    }
    const tools::ArchiveLayout layout = tools::LayoutOf(list);
    std::string bytes;
    for (const auto& part : layout.parts) {
      bytes += part.header;
      if (part.name == tools::kPackListName) bytes += layout.list;
      if (part.name == "session.toml") bytes += content;
    }
    return bytes + layout.directory;
  }();
  return archive;
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned random) {
  const std::array<std::string_view, 1> seeds{Archive()};
  return haptometer::fuzz::MutateFromSeeds(seeds, 0, {data, max_size}, size, random);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  if (const auto list = tools::ReadPackList(text)) fuzz::Require(tools::TextOf(*list) == text);
  const auto source = trial::MakeMemorySource(text);
  const auto checked = tools::CheckArchive(*source, "archive");
  if (!checked) {
    fuzz::Require(!checked.error().Text().empty());
    return 0;
  }
  // only files of the list, of safe names, that lie in the archive are unpacked
  std::uint64_t bytes = 0;
  for (const auto& [name, at] : checked->places) {
    const auto file = std::ranges::find(checked->list.files, name, &tools::PackedFile::name);
    fuzz::Require(file != checked->list.files.end() && tools::IsSafeName(name));
    fuzz::Require(at + file->bytes <= size);
    bytes += file->bytes;
  }
  fuzz::Require(bytes <= size);
  // without a finding it is byte for byte what was written
  const tools::ArchiveLayout layout = tools::LayoutOf(checked->list);
  if (checked->findings.list().empty()) {
    fuzz::Require(size == layout.bytes() && text.ends_with(layout.directory));
  }
  return 0;
}
