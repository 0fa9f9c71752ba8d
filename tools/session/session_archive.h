#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/finding.h"
#include "tools/document/document.h"
#include "trial/byte_io.h"

/// The archive of `session pack`: a ZIP (PKWARE APPNOTE 6.3) without compression.
///
/// Its first file, SHA256SUMS, lists the others with size, CRC-32 and SHA-256. All bytes of the
/// archive follow from that list and the files' contents, so that every changed byte is found, and
/// reading it takes no more room than it has. `sha256sum -c SHA256SUMS` checks the unpacked files.
namespace haptometer::tools {

inline constexpr std::string_view kPackListName = "SHA256SUMS";
/// Sizes and places have 32 bits in a ZIP without its extension, the number of files 16.
inline constexpr std::uint64_t kMostArchiveBytes = 0xffff'fffe;
inline constexpr std::size_t kMostPackedFiles = 0xfffe;

struct PackedFile {
  std::string name{};  ///< relative, with '/' between folders
  std::uint64_t bytes = 0;
  std::uint32_t crc32 = 0;
  std::string sha256{};  ///< 64 hexadecimal digits
};

/// What SHA256SUMS states.
struct PackList {
  std::string version;  ///< of haptometer
  std::string session;  ///< name of the folder
  std::string utc;
  std::vector<PackedFile> files;
};

/// The list as SHA256SUMS, which ReadPackList() reads as the same.
[[nodiscard]] std::string TextOf(const PackList& list);

/// Nothing of a text that TextOf() does not give: one of an unsafe or repeated name included.
[[nodiscard]] std::optional<PackList> ReadPackList(std::string_view text);

/// Whether a file of this name stays in the folder on every system: printable, relative, of parts
/// that are neither empty nor "." nor "..", without backslash and colon.
[[nodiscard]] bool IsSafeName(std::string_view name);

/// The bytes of an archive that are of no file in its list, and where all lie.
struct ArchiveLayout {
  struct Part {
    std::string name;
    std::uint64_t header_at = 0;
    std::string header;
    std::uint64_t content_at = 0;
  };
  std::string list{};         ///< content of the first part
  std::vector<Part> parts{};  ///< SHA256SUMS, and the files in their order
  std::uint64_t directory_at = 0;
  std::string directory{};
  [[nodiscard]] std::uint64_t bytes() const { return directory_at + directory.size(); }
};

/// Cost: O(files).
[[nodiscard]] ArchiveLayout LayoutOf(const PackList& list);

/// How an archive differs from the one that was written, each of a file or a part.
enum class ArchiveFinding : std::uint8_t {
  kByteChanged,        ///< at (within the file, from 0), was, is
  kFileChanged,        ///< by more than a byte, or larger than 256 MiB
  kHeaderByteChanged,  ///< at (within the archive), was, is: of a header or the directory
  kHeaderChanged,      ///< bytes, at (the first)
  kFileMissing,
  kFileAdded,
  kNamedTwice,
  kUnsafeName,  ///< added; its name leads out of the folder
  kLink,        ///< symbolic link, device or folder in the place of a file
  kCompressed,  ///< packed again by another program
  kCutShort,    ///< bytes, of_bytes
  kOtherSize,   ///< bytes, of_bytes: of the archive
};

/// The words of a kind.
[[nodiscard]] document::Sentence SentenceOf(ArchiveFinding kind);

struct CheckedArchive {
  PackList list;
  std::map<std::string, std::uint64_t> places;  ///< of the contents of files that are unchanged
  Findings<ArchiveFinding> findings;            ///< refusals; none where nothing was changed
};

/// Compares every byte of an archive with what its list states. One changed byte of a file is
/// found by the difference of its CRC-32 and confirmed by its SHA-256.
///
/// Errors (Cause::kCannotAnswer): no archive of session pack, a list that cannot be read, or a disk
/// that cannot. Reads the archive once, and damaged files a few times; memory: 16 MiB at most of
/// the list, and of a directory.
[[nodiscard]] Result<CheckedArchive> CheckArchive(const trial::ByteSource& archive,
                                                  const std::string& where);

/// CRC-32 and SHA-256 of the bytes; `sink`, where it is given, gets them in pieces. Left by
/// cli::Interruption where the program is interrupted.
using PieceSink = std::function<Result<void>(std::string_view)>;
struct ContentHash {
  std::uint32_t crc32 = 0;
  std::string sha256;
};
[[nodiscard]] Result<ContentHash> HashOf(const trial::ByteSource& source, std::uint64_t at,
                                         std::uint64_t bytes, const PieceSink& sink = {});

}  // namespace haptometer::tools
