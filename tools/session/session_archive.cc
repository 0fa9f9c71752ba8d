#include "tools/session/session_archive.h"

#include <fmt/core.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "base/text.h"
#include "tools/cli/terminal.h"
#include "trial/block.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kListBegin = "# haptometer session pack, format 1\n";
constexpr std::string_view kListEnd = "# end, CRC-32 of the lines above ";
constexpr std::uint64_t kMostListBytes = std::uint64_t{1} << 24U;
constexpr std::size_t kPieceBytes = std::size_t{1} << 18U;

// signatures and sizes of the records of a ZIP
constexpr std::uint32_t kLocalHeader = 0x04034b50;
constexpr std::uint32_t kDirectoryEntry = 0x02014b50;
constexpr std::uint32_t kDirectoryEnd = 0x06054b50;
constexpr std::size_t kLocalHeaderBytes = 30;
constexpr std::size_t kDirectoryEntryBytes = 46;
constexpr std::size_t kDirectoryEndBytes = 22;
constexpr std::size_t kMostCommentBytes = 0xffff;
constexpr std::uint32_t kTypeOfFile = 0170000;  // of a mode in the upper half of the attributes
constexpr std::uint32_t kRegularFile = 0100000;

std::uint32_t CrcOf(std::string_view text) { return trial::Crc32(trial::BytesOfText(text)); }

void Append16(std::uint32_t value, std::string& bytes) {
  trial::AppendLittleEndian(static_cast<std::uint16_t>(value), &bytes);
}
void Append32(std::uint64_t value, std::string& bytes) {
  trial::AppendLittleEndian(static_cast<std::uint32_t>(value), &bytes);
}
std::uint32_t Read16(std::string_view bytes, std::size_t at) {
  return trial::LoadLittleEndian<std::uint16_t>(trial::BytesOfText(bytes).data() + at);
}
std::uint32_t Read32(std::string_view bytes, std::size_t at) {
  return trial::LoadLittleEndian<std::uint32_t>(trial::BytesOfText(bytes).data() + at);
}

// what header and directory have in common: from the version to the length of the extra field
void AppendCommon(const PackedFile& file, std::string& bytes) {
  constexpr std::uint32_t kVersion = 20;  // 2.0
  constexpr std::uint32_t kUtf8Names = 1U << 11U;
  constexpr std::uint32_t kFirstDay = 0x21;  // 1 January 1980: the list has the time
  for (const std::uint32_t value : {kVersion, kUtf8Names, 0U, 0U, kFirstDay}) {
    Append16(value, bytes);
  }
  Append32(file.crc32, bytes);
  // stored: both sizes are that of the file
  Append32(file.bytes, bytes);
  Append32(file.bytes, bytes);
  Append16(static_cast<std::uint32_t>(file.name.size()), bytes);
  Append16(0, bytes);
}

std::string LocalHeaderOf(const PackedFile& file) {
  std::string bytes;
  Append32(kLocalHeader, bytes);
  AppendCommon(file, bytes);
  return bytes + file.name;
}

std::string DirectoryEntryOf(const PackedFile& file, std::uint64_t header_at) {
  constexpr std::uint32_t kUnix = 0x0314;
  constexpr std::uint64_t kMode = std::uint64_t{0100644} << 16U;
  std::string bytes;
  Append32(kDirectoryEntry, bytes);
  Append16(kUnix, bytes);
  AppendCommon(file, bytes);
  // no comment, first disk, no text
  for (int k = 0; k < 3; ++k) Append16(0, bytes);
  Append32(kMode, bytes);
  Append32(header_at, bytes);
  return bytes + file.name;
}

std::string DirectoryEndOf(std::size_t files, std::size_t bytes, std::uint64_t at) {
  std::string end;
  Append32(kDirectoryEnd, end);
  Append32(0, end);
  // on this disk, and in all
  for (int k = 0; k < 2; ++k) Append16(static_cast<std::uint32_t>(files), end);
  Append32(bytes, end);
  Append32(at, end);
  Append16(0, end);
  return end;
}

}  // namespace

bool IsSafeName(std::string_view name) {
  if (name.empty() || name.size() > 4000 || !IsPrintable(name)) return false;
  if (name.find_first_of("\\:") != std::string_view::npos) return false;
  for (std::size_t at = 0; at <= name.size();) {
    const std::size_t end = std::min(name.find('/', at), name.size());
    const std::string_view part = name.substr(at, end - at);
    if (part.empty() || part == "." || part == "..") return false;
    at = end + 1;
  }
  return true;
}

std::string TextOf(const PackList& list) {
  std::string text = fmt::format("{}# version {}\n# session {}\n# packed {}\n", kListBegin,
                                 list.version, list.session, list.utc);
  for (const PackedFile& file : list.files) {
    text += fmt::format("# {} bytes, CRC-32 {:08x}\n{}  {}\n", file.bytes, file.crc32, file.sha256,
                        file.name);
  }
  return text + fmt::format("{}{:08x}\n", kListEnd, CrcOf(text));
}

namespace {

// takes a line away that is between `before` and `after`
std::optional<std::string_view> TakeLine(std::string_view& text, std::string_view before) {
  const std::size_t end = text.find('\n');
  if (end == std::string_view::npos || !text.starts_with(before)) return std::nullopt;
  const std::string_view line = text.substr(before.size(), end - before.size());
  text.remove_prefix(end + 1);
  return line;
}

// both lines of a file
std::optional<PackedFile> TakeFile(std::string_view& text) {
  constexpr std::string_view kBetween = " bytes, CRC-32 ";
  constexpr std::size_t kDigits = 64;
  const auto sizes = TakeLine(text, "# ");
  const auto sum = TakeLine(text, "");
  if (!sizes || !sum || sum->size() < kDigits + 3) return std::nullopt;
  const std::size_t between = sizes->find(kBetween);
  if (between == std::string_view::npos) return std::nullopt;
  const auto bytes = NumberFrom<std::uint64_t>(sizes->substr(0, between));
  if (!bytes) return std::nullopt;
  PackedFile file{.name = std::string(sum->substr(kDigits + 2)),
                  .bytes = *bytes,
                  .sha256 = std::string(sum->substr(0, kDigits))};
  const std::string_view crc = sizes->substr(between + kBetween.size());
  std::from_chars(crc.begin(), crc.end(), file.crc32, 16);
  return file;
}

}  // namespace

std::optional<PackList> ReadPackList(std::string_view text) {
  PackList list;
  std::string_view rest = text;
  if (!rest.starts_with(kListBegin)) return std::nullopt;
  rest.remove_prefix(kListBegin.size());
  for (const auto& [before, value] :
       {std::pair("# version ", &list.version), std::pair("# session ", &list.session),
        std::pair("# packed ", &list.utc)}) {
    const auto line = TakeLine(rest, before);
    if (!line) return std::nullopt;
    *value = *line;
  }
  std::set<std::string, std::less<>> names{std::string(kPackListName)};
  std::uint64_t all_bytes = 0;
  while (!rest.starts_with(kListEnd)) {
    auto file = TakeFile(rest);
    if (!file || !IsSafeName(file->name) || !names.insert(file->name).second) return std::nullopt;
    // each size on its own first, so that the sum cannot overflow
    if (file->bytes > kMostArchiveBytes) return std::nullopt;
    all_bytes += file->bytes;
    if (all_bytes > kMostArchiveBytes || names.size() > kMostPackedFiles) return std::nullopt;
    list.files.push_back(*std::move(file));
  }
  // one text for each list: what was read differently, or has another checksum, is none
  if (TextOf(list) != text) return std::nullopt;
  return list;
}

ArchiveLayout LayoutOf(const PackList& list) {
  ArchiveLayout layout{.list = TextOf(list)};
  std::vector<PackedFile> files{{.name = std::string(kPackListName),
                                 .bytes = layout.list.size(),
                                 .crc32 = CrcOf(layout.list),
                                 .sha256 = {}}};
  files.insert(files.end(), list.files.begin(), list.files.end());
  for (const PackedFile& file : files) {
    ArchiveLayout::Part part{file.name, layout.directory_at, LocalHeaderOf(file), 0};
    part.content_at = part.header_at + part.header.size();
    layout.directory_at = part.content_at + file.bytes;
    layout.directory += DirectoryEntryOf(file, part.header_at);
    layout.parts.push_back(std::move(part));
  }
  layout.directory += DirectoryEndOf(files.size(), layout.directory.size(), layout.directory_at);
  return layout;
}

document::Sentence SentenceOf(ArchiveFinding kind) {
  using enum ArchiveFinding;
  static constexpr document::KindSentence<ArchiveFinding> kSentences[] = {
      {kByteChanged, "byte-changed", "byte {at} of it was {was} and is {is}"},
      {kFileChanged, "file-changed", "its content was changed"},
      {kHeaderByteChanged, "header-byte-changed", "byte {at} of the archive was {was} and is {is}"},
      {kHeaderChanged, "header-changed",
       "{bytes} bytes were changed, the first is byte {at} of the archive"},
      {kFileMissing, "file-missing", "is missing"},
      {kFileAdded, "file-added", "was added"},
      {kNamedTwice, "named-twice", "is named more than once"},
      {kUnsafeName, "unsafe-name", "was added, with a name that leads out of the folder"},
      {kLink, "no-file", "is a link, a folder or a device, and no file"},
      {kCompressed, "compressed", "is compressed or has another size: it was packed again"},
      {kCutShort, "cut-short", "{bytes} of {of_bytes} bytes are there"},
      {kOtherSize, "other-size", "{bytes} bytes are there, and {of_bytes} were written"},
  };
  return document::SentenceIn(kSentences, kind);
}

Result<ContentHash> HashOf(const trial::ByteSource& source, std::uint64_t at, std::uint64_t bytes,
                           const PieceSink& sink) {
  document::Sha256 sha256;
  ContentHash hash;
  std::string piece;
  while (bytes > 0) {
    cli::LeaveIfInterrupted();
    piece.resize(std::min<std::uint64_t>(bytes, kPieceBytes));
    HAPTOMETER_LET(const auto got, source.ReadAt(at, std::as_writable_bytes(std::span(piece))));
    // a file that has become shorter meanwhile has another hash
    if (got == 0) break;
    piece.resize(got);
    sha256.Add(piece);
    hash.crc32 = static_cast<std::uint32_t>(
        crc32_z(hash.crc32, reinterpret_cast<const Bytef*>(piece.data()), piece.size()));
    if (sink) HAPTOMETER_TRY(sink(piece));
    at += got;
    bytes -= got;
  }
  hash.sha256 = sha256.Hex();
  return hash;
}

namespace {

// A file whose CRC-32 differs by `difference` and in which one byte may have changed. The CRC is
// linear: a change e of a byte with k bytes behind it makes the difference A^(k+1) e, where A is
// the step of a zero byte. A is undone byte by byte from the end until a difference of one byte is
// left.
class ChangedPlaces {
 public:
  ChangedPlaces(std::uint32_t difference, std::uint64_t bytes)
      : difference_(difference), left_(bytes) {
    for (std::uint32_t byte = 0; byte < 256; ++byte) {
      std::uint32_t entry = byte;
      for (int bit = 0; bit < 8; ++bit)
        entry = (entry >> 1U) ^ ((entry & 1U) != 0 ? kPolynomial : 0);
      // the upper bytes of the entries are all different, so that the step has an inverse
      step_.at(entry >> 24U) = (entry << 8U) | byte;
    }
  }

  struct Change {
    std::uint64_t at = 0;
    std::uint8_t difference = 0;
  };
  // the next place from the end that explains the difference
  std::optional<Change> Next() {
    while (left_ > 0) {
      --left_;
      difference_ = (difference_ << 8U) ^ step_[difference_ >> 24U];
      if (difference_ > 0 && difference_ < 256) {
        return Change{left_, static_cast<std::uint8_t>(difference_)};
      }
    }
    return std::nullopt;
  }

 private:
  static constexpr std::uint32_t kPolynomial = 0xedb88320;
  std::array<std::uint32_t, 256> step_{};
  std::uint32_t difference_;
  std::uint64_t left_;
};

// Chance explains a difference once in 16 million bytes, and each place costs reading the file
// again: of larger files the place is not looked for.
constexpr int kMostPlaces = 100;
constexpr std::uint64_t kMostLookedThrough = std::uint64_t{1} << 28U;

std::string ByteText(std::uint8_t byte) { return fmt::format("0x{:02x}", byte); }

FindingOf<ArchiveFinding> Refusal(ArchiveFinding kind, std::string_view subject,
                                  std::vector<FindingNumber> numbers = {}) {
  return {Severity::kRefusal, kind, std::move(numbers), std::string(subject)};
}

FindingOf<ArchiveFinding> ByteFinding(ArchiveFinding kind, std::string_view subject,
                                      std::uint64_t at, std::uint8_t was, std::uint8_t is) {
  return Refusal(kind, subject, {{"at", at}, {"was", ByteText(was)}, {"is", ByteText(is)}});
}

// An archive while it is checked.
struct ArchiveCheck {
  const trial::ByteSource& archive;
  const std::string& where;
  CheckedArchive checked{};
  std::uint64_t content_bytes = 0;  // that were read

  // bytes from `at` on, fewer where the archive ends
  [[nodiscard]] Result<std::string> BytesAt(std::uint64_t at, std::uint64_t bytes) const {
    const std::uint64_t all = archive.size();
    std::string read(at < all ? std::min(bytes, all - at) : 0, '\0');
    if (read.empty()) return read;
    HAPTOMETER_LET(const auto got, archive.ReadAt(at, std::as_writable_bytes(std::span(read))));
    read.resize(got);
    return read;
  }

  void Add(FindingOf<ArchiveFinding> finding) { checked.findings.Add(std::move(finding)); }

  Result<void> ReadList();
  bool MendList(std::string_view bytes);
  Result<bool> CompareBytes(std::string_view part, std::uint64_t at, std::string_view expected);
  Result<void> CheckLayout(const ArchiveLayout& layout);
  Result<void> CheckDirectory(const ArchiveLayout& layout);
  Result<void> CheckContent(const PackedFile& file, std::uint64_t at);
  Result<void> FindChange(const PackedFile& file, std::uint64_t at, std::uint32_t crc32);
};

// the list, which is the first file, of known beginning and end
Result<void> ArchiveCheck::ReadList() {
  const std::size_t begin = kLocalHeaderBytes + kPackListName.size();
  HAPTOMETER_LET(const auto bytes, BytesAt(0, kMostListBytes));
  const std::string_view content = std::string_view(bytes).substr(std::min(begin, bytes.size()));
  // one of both may be damaged
  const bool is_named =
      std::string_view(bytes).substr(0, begin).ends_with(kPackListName) && !content.empty();
  if (!is_named && !content.starts_with(kListBegin)) {
    return CannotAnswer(where, "is no archive of session pack: its first file is not SHA256SUMS",
                        "give a file that haptometer session pack wrote");
  }
  const std::size_t last = std::min(content.find(kListEnd), content.size());
  const std::size_t end = std::min(content.find('\n', last), content.size() - 1) + 1;
  if (auto list = ReadPackList(content.substr(0, end))) {
    checked.list = *std::move(list);
    return {};
  }
  if (MendList(bytes)) return {};
  return CannotAnswer(where,
                      "has a damaged list: SHA256SUMS was changed in more than one byte, is cut "
                      "short, or names a file that leads out of the folder",
                      "its files cannot be compared with anything");
}

// one changed byte of the list, of which the header has size and CRC-32: the list without the
// change has its own checksum right
bool ArchiveCheck::MendList(std::string_view bytes) {
  const std::size_t begin = kLocalHeaderBytes + kPackListName.size();
  const std::uint64_t size = Read32(bytes, 18);
  if (size > bytes.size() - begin) return false;
  std::string content(bytes.substr(begin, size));
  ChangedPlaces places(CrcOf(content) ^ Read32(bytes, 14), size);
  for (int k = 0; k < kMostPlaces; ++k) {
    const auto change = places.Next();
    if (!change) return false;
    const auto is = static_cast<std::uint8_t>(content[change->at]);
    const auto was = static_cast<std::uint8_t>(is ^ change->difference);
    content[change->at] = static_cast<char>(was);
    if (auto list = ReadPackList(content)) {
      checked.list = *std::move(list);
      Add(ByteFinding(ArchiveFinding::kByteChanged, kPackListName, change->at, was, is));
      return true;
    }
    content[change->at] = static_cast<char>(is);
  }
  return false;
}

// whether the bytes at a place are the expected ones; what differs is found
Result<bool> ArchiveCheck::CompareBytes(std::string_view part, std::uint64_t at,
                                        std::string_view expected) {
  HAPTOMETER_LET(const auto bytes, BytesAt(at, expected.size()));
  std::uint64_t changed = expected.size() - bytes.size();
  std::uint64_t first = bytes.size();
  for (std::size_t k = bytes.size(); k-- > 0;) {
    if (bytes[k] == expected[k]) continue;
    ++changed;
    first = k;
  }
  if (changed == 0) return true;
  if (changed == 1 && first < bytes.size()) {
    Add(ByteFinding(ArchiveFinding::kHeaderByteChanged, part, at + first,
                    static_cast<std::uint8_t>(expected[first]),
                    static_cast<std::uint8_t>(bytes[first])));
  } else {
    Add(Refusal(ArchiveFinding::kHeaderChanged, part, {{"bytes", changed}, {"at", at + first}}));
  }
  return false;
}

// --- a directory that another program may have written ---

struct DirectoryEntry {
  std::string name;
  bool is_stored = false;
  bool is_file = true;
  std::uint64_t bytes = 0;
  std::uint64_t header_at = 0;
};

// where the last record begins; it has a comment to the end of the archive
std::optional<std::size_t> FindEnd(std::string_view tail) {
  for (std::size_t at = tail.size(); at-- > 0;) {
    if (tail.size() - at < kDirectoryEndBytes || Read32(tail, at) != kDirectoryEnd) continue;
    if (at + kDirectoryEndBytes + Read16(tail, at + 20) == tail.size()) return at;
  }
  return std::nullopt;
}

std::optional<std::vector<DirectoryEntry>> EntriesOf(std::string_view directory) {
  std::vector<DirectoryEntry> entries;
  while (!directory.empty()) {
    if (directory.size() < kDirectoryEntryBytes || Read32(directory, 0) != kDirectoryEntry) {
      return std::nullopt;
    }
    const std::size_t name = Read16(directory, 28);
    const std::size_t all =
        kDirectoryEntryBytes + name + Read16(directory, 30) + Read16(directory, 32);
    if (all > directory.size()) return std::nullopt;
    const std::uint32_t type = (Read32(directory, 38) >> 16U) & kTypeOfFile;
    entries.push_back({.name = std::string(directory.substr(kDirectoryEntryBytes, name)),
                       .is_stored = Read16(directory, 10) == 0,
                       // 0: a system that states no type
                       .is_file = type == 0 || type == kRegularFile,
                       .bytes = Read32(directory, 20),
                       .header_at = Read32(directory, 42)});
    directory.remove_prefix(all);
  }
  return entries;
}

// nothing where the end of the archive is none
Result<std::optional<std::vector<DirectoryEntry>>> ReadDirectory(const ArchiveCheck& check) {
  const std::uint64_t all = check.archive.size();
  const std::uint64_t most = std::min<std::uint64_t>(all, kDirectoryEndBytes + kMostCommentBytes);
  HAPTOMETER_LET(const auto tail, check.BytesAt(all - most, most));
  const auto end = FindEnd(tail);
  if (!end) return std::nullopt;
  const std::uint64_t bytes = Read32(tail, *end + 12);
  const std::uint64_t end_at = all - most + *end;
  if (bytes > std::min(end_at, kMostListBytes)) return std::nullopt;
  HAPTOMETER_LET(const auto directory, check.BytesAt(end_at - bytes, bytes));
  return EntriesOf(directory);
}

// An archive of another size than was written: what its own directory has more, less and otherwise.
Result<void> ArchiveCheck::CheckDirectory(const ArchiveLayout& layout) {
  using enum ArchiveFinding;
  HAPTOMETER_LET(const auto entries, ReadDirectory(*this));
  if (!entries) {
    Add(Refusal(archive.size() < layout.bytes() ? kCutShort : kOtherSize, "",
                {{"bytes", archive.size()}, {"of_bytes", layout.bytes()}}));
    // what of it is there lies where it was written
    for (std::size_t k = 0; k < checked.list.files.size(); ++k) {
      HAPTOMETER_TRY(CheckContent(checked.list.files[k], layout.parts[k + 1].content_at));
    }
    return {};
  }
  std::map<std::string_view, const PackedFile*> expected{{kPackListName, nullptr}};
  for (const PackedFile& file : checked.list.files) expected[file.name] = &file;
  std::set<std::string_view> seen;
  for (const DirectoryEntry& entry : *entries) {
    const std::string name = Printable(entry.name);
    const auto known = expected.find(entry.name);
    if (!seen.insert(entry.name).second) {
      Add(Refusal(kNamedTwice, name));
    } else if (!entry.is_file) {
      Add(Refusal(kLink, name));
    } else if (known == expected.end()) {
      Add(Refusal(IsSafeName(entry.name) ? kFileAdded : kUnsafeName, name));
    } else if (known->second == nullptr) {
      continue;
    } else if (!entry.is_stored || entry.bytes != known->second->bytes) {
      Add(Refusal(kCompressed, name));
    } else {
      HAPTOMETER_LET(const auto header, BytesAt(entry.header_at, kLocalHeaderBytes));
      // a header that is not there: the content lies behind the end
      const std::uint64_t more = header.size() < kLocalHeaderBytes
                                     ? archive.size()
                                     : Read16(header, 26) + Read16(header, 28);
      HAPTOMETER_TRY(CheckContent(*known->second, entry.header_at + kLocalHeaderBytes + more));
    }
  }
  for (const auto& [name, file] : expected) {
    if (!seen.contains(name)) Add(Refusal(kFileMissing, name));
  }
  // bytes that belong to no file
  if (checked.findings.list().empty()) {
    Add(Refusal(kOtherSize, "", {{"bytes", archive.size()}, {"of_bytes", layout.bytes()}}));
  }
  return {};
}

// --- contents ---

// which byte of a changed file was changed, where it is one
Result<void> ArchiveCheck::FindChange(const PackedFile& file, std::uint64_t at,
                                      std::uint32_t crc32) {
  ChangedPlaces places(crc32 ^ file.crc32, file.bytes <= kMostLookedThrough ? file.bytes : 0);
  for (int k = 0; k < kMostPlaces; ++k) {
    const auto change = places.Next();
    if (!change) break;
    HAPTOMETER_LET(const auto byte, BytesAt(at + change->at, 1));
    if (byte.empty()) break;
    const auto is = static_cast<std::uint8_t>(byte.front());
    const auto was = static_cast<std::uint8_t>(is ^ change->difference);
    // the file with that byte as it was
    document::Sha256 sha256;
    std::uint64_t done = 0;
    HAPTOMETER_TRY(HashOf(archive, at, file.bytes, [&](std::string_view piece) -> Result<void> {
      std::string mended(piece);
      if (change->at >= done && change->at - done < piece.size()) {
        mended[change->at - done] = static_cast<char>(was);
      }
      sha256.Add(mended);
      done += piece.size();
      return {};
    }));
    if (sha256.Hex() != file.sha256) continue;
    Add(ByteFinding(ArchiveFinding::kByteChanged, file.name, change->at, was, is));
    return {};
  }
  Add(Refusal(ArchiveFinding::kFileChanged, file.name));
  return {};
}

Result<void> ArchiveCheck::CheckContent(const PackedFile& file, std::uint64_t at) {
  // contents that lie in each other are no files: together they have room in the archive
  content_bytes += file.bytes;
  if (at + file.bytes > archive.size() || content_bytes > archive.size()) {
    Add(Refusal(ArchiveFinding::kFileMissing, file.name));
    return {};
  }
  HAPTOMETER_LET(const auto hash, HashOf(archive, at, file.bytes));
  if (hash.crc32 == file.crc32 && hash.sha256 == file.sha256) {
    checked.places[file.name] = at;
    return {};
  }
  return FindChange(file, at, hash.crc32);
}

// an archive of the size that was written: every byte has its place
Result<void> ArchiveCheck::CheckLayout(const ArchiveLayout& layout) {
  for (const ArchiveLayout::Part& part : layout.parts) {
    HAPTOMETER_TRY(CompareBytes("header of " + part.name, part.header_at, part.header));
  }
  HAPTOMETER_TRY(CompareBytes("directory of the archive", layout.directory_at, layout.directory));
  for (std::size_t k = 0; k < checked.list.files.size(); ++k) {
    HAPTOMETER_TRY(CheckContent(checked.list.files[k], layout.parts[k + 1].content_at));
  }
  return {};
}

}  // namespace

Result<CheckedArchive> CheckArchive(const trial::ByteSource& archive, const std::string& where) {
  ArchiveCheck check{.archive = archive, .where = where};
  HAPTOMETER_TRY(check.ReadList());
  const ArchiveLayout layout = LayoutOf(check.checked.list);
  if (archive.size() == layout.bytes()) {
    HAPTOMETER_TRY(check.CheckLayout(layout));
  } else {
    HAPTOMETER_TRY(check.CheckDirectory(layout));
  }
  return std::move(check.checked);
}

}  // namespace haptometer::tools
