#include "tools/cli/output_file.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <span>
#include <utility>

#include "base/input_file.h"
#include "base/text.h"
#include "trial/byte_io.h"

namespace haptometer::cli {
namespace {

namespace fs = std::filesystem;

// bytes that are read to determine the kind of an existing file
constexpr std::size_t kBeginBytes = 1U << 20;
// a marked file is read whole for its checksum, up to 1 GiB
constexpr std::size_t kLargestMarkedBytes = 1U << 30;
constexpr mode_t kNewMode = 0666;  // less the user's umask
// permission bits that a replaced file passes on
constexpr mode_t kPermissions = 0777;

// what an output path leads to, behind all links
struct Place {
  std::string target;             // path behind all symbolic links
  std::optional<int> descriptor;  // of this process, where the path names one
  struct stat status{};           // of the existing file
  bool exists = false;

  [[nodiscard]] bool is_file() const { return !descriptor && (!exists || S_ISREG(status.st_mode)); }
};

std::unexpected<Error> CannotBeWritten(const std::string& path, int failure) {
  return Failed(path, std::string("cannot be written: ") + std::strerror(failure),
                "is there room, and may you write there?");
}

// the descriptor that `path` names: /dev/stdout, /dev/fd/3
std::optional<int> DescriptorOf(std::string_view path) {
  if (path == "/dev/stdout") return STDOUT_FILENO;
  if (path == "/dev/stderr") return STDERR_FILENO;
  for (const std::string_view folder : {"/dev/fd/", "/proc/self/fd/"}) {
    if (!path.starts_with(folder)) continue;
    if (const auto number = NumberFrom<int>(path.substr(folder.size()))) return number;
  }
  return std::nullopt;
}

Result<Place> PlaceOf(const std::string& path) {
  constexpr int kMostLinks = 40;  // as in the kernel (MAXSYMLINKS)
  Place place;
  place.target = path;
  // follow links one by one: fs::canonical would fail for a file that does not exist yet
  for (int links = 0; links <= kMostLinks; ++links) {
    place.descriptor = DescriptorOf(place.target);
    if (place.descriptor) {
      place.exists = fstat(*place.descriptor, &place.status) == 0;
      if (!place.exists) return CannotBeWritten(path, errno);
      return place;
    }
    // nothing there: a new file, unless a link leads to it
    if (lstat(place.target.c_str(), &place.status) != 0) {
      if (errno != ENOENT && errno != ENOTDIR) return CannotBeWritten(path, errno);
      if (links > 0) return Usage(path, "is a link to nothing", "name another file");
      return place;
    }
    place.exists = true;
    if (!S_ISLNK(place.status.st_mode)) return place;
    std::error_code failure;
    const fs::path next = fs::read_symlink(place.target, failure);
    if (failure) return CannotBeWritten(path, failure.value());
    // a relative link counts from its own folder
    place.target = fs::path(place.target).parent_path() / next;
  }
  return CannotBeWritten(path, ELOOP);
}

std::string FolderOf(const std::string& target) {
  const fs::path folder = fs::path(target).parent_path();
  return folder.empty() ? "." : folder.string();
}

Result<void> CheckFolder(const std::string& path, const std::string& target) {
  std::error_code ignored;
  const std::string folder = FolderOf(target);
  if (!fs::is_directory(folder, ignored)) {
    return Usage(path, "lies in a directory that does not exist", "make it, or name another");
  }
  if (access(folder.c_str(), W_OK) != 0) return CannotBeWritten(path, errno);
  return {};
}

// the first `most` bytes of an open file; pread leaves its offset unchanged
std::string BeginOf(int descriptor, std::size_t most) {
  std::string content;
  std::array<char, 1U << 16> piece{};
  while (content.size() < most) {
    const ssize_t got =
        pread(descriptor, piece.data(), piece.size(), static_cast<off_t>(content.size()));
    if (got <= 0) break;
    content.append(piece.data(), static_cast<std::size_t>(got));
  }
  return content;
}

// whether an existing file may be replaced: writable, not in use, of the same kind
Result<void> CheckReplaceable(const std::string& path, const std::string& target,
                              const OutputKind& kind, bool overwrite) {
  if (!kind.is_marked && !overwrite) {
    return Usage(path, "already exists", "name another file, or give --overwrite");
  }
  if (access(target.c_str(), W_OK) != 0) return CannotBeWritten(path, errno);
  // O_NONBLOCK: a pipe put there since must not block; O_NOFOLLOW: nor may a link be followed
  const int descriptor = open(target.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return CannotBeWritten(path, errno);
  // a trial that is being recorded is locked by its writer
  const bool is_busy = flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  const std::string content =
      BeginOf(descriptor, kind.is_marked ? kLargestMarkedBytes : kBeginBytes);
  close(descriptor);
  if (is_busy) {
    return Usage(path, "is being written by another program", "wait for it, or name another file");
  }
  if (IsOfKind(content, kind)) return {};
  if (kind.is_marked) {
    return Usage(path, fmt::format("exists and is not {}, or was changed since", kind.name),
                 "name another file, or remove that one");
  }
  return Usage(path, fmt::format("exists and is not {}", kind.name),
               "name another file: --overwrite replaces a file of the same kind only");
}

// an input of this command is never an output, under any name (device and inode)
Result<void> CheckPlace(const std::string& path, const Place& place, const OutputKind& kind,
                        bool overwrite) {
  if (path == "-") {
    return Usage(path, "stands for standard output, where nothing is written",
                 "name a file; ./- is one of that name");
  }
  if (place.exists && IsNotedInput(place.status)) {
    return Usage(path, "is an input of this command", "name another file to write");
  }
  if (!place.is_file()) {
    const mode_t mode = place.status.st_mode;
    if (S_ISDIR(mode)) return Usage(path, "is a directory", "name a file");
    if (S_ISBLK(mode) || S_ISSOCK(mode)) {
      return Usage(path, "exists and is not a file", "name another");
    }
    return {};
  }
  HAPTOMETER_TRY(CheckFolder(path, place.target));
  return place.exists ? CheckReplaceable(path, place.target, kind, overwrite) : Result<void>{};
}

// hidden name of a part, 64 random bits
std::string RandomName() {
  std::uint64_t number = 0;
  // without entropy (early boot) the process id; O_EXCL protects an existing file
  if (getrandom(&number, sizeof number, GRND_NONBLOCK) < 0)
    number = static_cast<std::uint64_t>(getpid());
  return fmt::format(".haptometer-{:016x}.part", number);
}

// the new name must survive a loss of power; file systems that cannot sync a folder are ignored
void SyncFolder(const std::string& target) {
  const int folder = open(FolderOf(target).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;
  static_cast<void>(fsync(folder));
  close(folder);
}

// renames the part to `target` if nothing is there; else false with errno
bool NameNew(const std::string& part, const std::string& target) {
  // one atomic step, so that two programs cannot both create the name
  if (renameat2(AT_FDCWD, part.c_str(), AT_FDCWD, target.c_str(), RENAME_NOREPLACE) == 0) {
    return true;
  }
  if (errno != EINVAL && errno != ENOSYS) return false;
  // a file system without RENAME_NOREPLACE: create the name exclusively, then rename over it
  const int taken = open(target.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kNewMode);
  if (taken < 0) return false;
  close(taken);
  if (rename(part.c_str(), target.c_str()) == 0) return true;
  // the empty file that only held the name is removed
  const int failure = errno;
  unlink(target.c_str());
  errno = failure;
  return false;
}

}  // namespace

Result<void> RenameNew(const std::string& from, const std::string& to) {
  if (!NameNew(from, to)) {
    return Failed(to, "cannot be made: " + std::generic_category().message(errno),
                  "check the disk, and that no other program writes there");
  }
  SyncFolder(to);
  return {};
}

namespace {

using std::string_view_literals::operator""sv;

// mark at the end of a generated file: kMark and the CRC-32 of all bytes before, in hexadecimal
constexpr std::string_view kMark = "made by haptometer ";
// PNG, third edition: signature, IEND chunk with length and CRC, type and keyword of a text chunk
constexpr std::string_view kPngBegin = "\x89PNG\r\n\x1a\n";
constexpr std::string_view kPngEnd = "\0\0\0\0IEND\xae\x42\x60\x82"sv;
constexpr std::string_view kTextType = "tEXtSoftware\0"sv;

// what stands around the mark, so that it is a comment of the format
struct Frame {
  std::string_view before;
  std::string_view after;
};

// PDF comment or XML comment (SVG, HTML)
Frame FrameOf(std::string_view content) {
  if (content.starts_with("%PDF")) return {"% ", "\n"};
  return {"<!-- ", " -->\n"};
}

std::uint32_t CrcOf(std::string_view bytes) {
  return trial::Crc32(std::as_bytes(std::span(bytes)));
}

// four bytes in network order, as in PNG
std::string BigEndian(std::uint32_t number) {
  std::string bytes;
  for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>((number >> shift) & 0xffU);
  return bytes;
}

std::string MarkOf(std::string_view before) {
  return fmt::format("{}{:08x}", kMark, CrcOf(before));
}

// length, type and data, CRC of type and data (PNG, third edition, 5.3)
std::string TextChunk(std::string_view text) {
  const std::string data = std::string(kTextType) + std::string(text);
  constexpr std::size_t kTypeBytes = 4;
  return BigEndian(static_cast<std::uint32_t>(data.size() - kTypeBytes)) + data +
         BigEndian(CrcOf(data));
}

// whether the mark's checksum is that of the bytes before it: an edited file has another one
bool EndsWithMark(std::string_view content) {
  const std::size_t at = content.rfind(kMark);
  if (at == std::string_view::npos) return false;
  const bool is_png = content.starts_with(kPngBegin);
  // a chunk's length field is 4 bytes, before type and keyword
  const std::size_t frame = is_png ? 4 + kTextType.size() : FrameOf(content).before.size();
  if (at < frame) return false;
  const std::string_view before = content.substr(0, at - frame);
  return Marked(std::string(before) + std::string(is_png ? kPngEnd : "")) == content;
}

// text behind leading lines "# ..."
std::string_view WithoutComments(std::string_view text) {
  while (text.starts_with("# ")) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return {};
    text.remove_prefix(end + 1);
  }
  return text;
}

}  // namespace

Result<void> CheckOutput(const std::string& path, const OutputKind& kind, bool overwrite) {
  const auto place = PlaceOf(path);
  return place ? CheckPlace(path, *place, kind, overwrite) : std::unexpected(place.error());
}

bool AreOneOutput(const std::string& one, const std::string& other) {
  const auto first = PlaceOf(one);
  const auto second = PlaceOf(other);
  if (!first || !second || !first->is_file() || !second->is_file()) return false;
  // one file by device and inode; files that do not exist yet by their absolute paths
  if (first->exists != second->exists) return false;
  if (first->exists) {
    return first->status.st_dev == second->status.st_dev &&
           first->status.st_ino == second->status.st_ino;
  }
  std::error_code ignored;
  const auto whole = [&](const Place& place) {
    return fs::weakly_canonical(fs::absolute(place.target, ignored), ignored);
  };
  return whole(*first) == whole(*second);
}

Result<OutputFile> OutputFile::Begin(const std::string& path, const OutputKind& kind,
                                     bool overwrite) {
  HAPTOMETER_LET(auto place, PlaceOf(path));
  HAPTOMETER_TRY(CheckPlace(path, place, kind, overwrite));
  OutputFile file(path, kind, overwrite);
  file.target_ = place.target;
  // a regular file: written as a part in the same folder, renamed when it is complete
  if (place.is_file()) {
    HAPTOMETER_TRY(file.MakePart());
    return file;
  }
  // buffered output was printed earlier and must precede these bytes
  std::fflush(nullptr);
  // descriptors, pipes and devices: written directly, without truncation
  if (place.descriptor) {
    file.descriptor_ = fcntl(*place.descriptor, F_DUPFD_CLOEXEC, 0);
    if (file.descriptor_ < 0) return file.NotWritten(errno);
    return file;
  }
  HAPTOMETER_LET(file.descriptor_, trial::OpenForAppending(place.target, path));
  return file;
}

OutputFile::OutputFile(std::string path, OutputKind kind, bool overwrite)
    : path_(std::move(path)), kind_(kind), overwrite_(overwrite) {}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      target_(std::move(other.target_)),
      part_(std::exchange(other.part_, {})),
      kind_(other.kind_),
      overwrite_(other.overwrite_),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

// a part without Finish() is removed: no incomplete output remains
OutputFile::~OutputFile() {
  if (descriptor_ >= 0) close(descriptor_);
  if (!part_.empty()) unlink(part_.c_str());
}

std::unexpected<Error> OutputFile::NotWritten(int failure) const {
  return CannotBeWritten(path_, failure);
}

// in the target's folder, since a rename does not cross file systems
Result<void> OutputFile::MakePart() {
  constexpr int kMostTries = 100;
  for (int tries = 0; tries < kMostTries; ++tries) {
    const std::string part = fs::path(target_).parent_path() / RandomName();
    descriptor_ = open(part.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kNewMode);
    if (descriptor_ >= 0) {
      part_ = part;
      return {};
    }
    if (errno != EEXIST) break;
  }
  return NotWritten(errno);
}

// a write may take fewer bytes than given; 0 bytes count as a full disk
Result<void> OutputFile::Write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return NotWritten(written < 0 ? errno : ENOSPC);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return {};
}

// a library opens by path: /proc/self/fd leads to the part even if its name is replaced
Result<std::string> OutputFile::PathForLibrary() const {
  if (part_.empty()) {
    return Usage(
        path_, fmt::format("is not a regular file, and {} is not written in one piece", kind_.name),
        "name a file");
  }
  return fmt::format("/proc/self/fd/{}", descriptor_);
}

Result<void> OutputFile::Finish() {
  // data on the disk before the name: after a loss of power a name never leads to missing data
  const int synced = fsync(descriptor_);
  // pipes and devices cannot be synced
  if (synced != 0 && !(part_.empty() && (errno == EINVAL || errno == EROFS))) {
    return NotWritten(errno);
  }
  if (part_.empty()) return {};
  auto done = TakePlace();
  if (done) SyncFolder(target_);
  return done;
}

Result<void> OutputFile::TakePlace() {
  if (NameNew(part_, target_)) {
    part_.clear();
    return {};
  }
  if (errno != EEXIST) return NotWritten(errno);
  // checked again: another file may have been created since Begin()
  if (auto good = CheckOutput(target_, kind_, overwrite_); !good) {
    Error error = good.error();
    error.where = path_;
    return std::unexpected(std::move(error));
  }
  // owner and permissions of the replaced file are kept
  struct stat older{};
  if (lstat(target_.c_str(), &older) != 0 || !S_ISREG(older.st_mode)) return NotWritten(EEXIST);
  // owner first, because a change of owner may clear permissions
  static_cast<void>(fchown(descriptor_, older.st_uid, older.st_gid) == 0);
  static_cast<void>(fchmod(descriptor_, older.st_mode & kPermissions) == 0);
  if (rename(part_.c_str(), target_.c_str()) != 0) return NotWritten(errno);
  part_.clear();
  return {};
}

Result<void> WriteOutput(const std::string& path, const OutputKind& kind, bool overwrite,
                         std::string_view content) {
  HAPTOMETER_LET(auto file, OutputFile::Begin(path, kind, overwrite));
  HAPTOMETER_TRY(file.Write(content));
  return file.Finish();
}

std::string Marked(std::string content) {
  if (!content.starts_with(kPngBegin)) {
    const Frame frame = FrameOf(content);
    const std::string mark = MarkOf(content);
    content += frame.before;
    content += mark;
    content += frame.after;
    return content;
  }
  HAPTOMETER_CHECK(content.ends_with(kPngEnd), "a PNG of {} bytes without its end", content.size());
  // the text chunk must precede IEND, the last chunk
  content.resize(content.size() - kPngEnd.size());
  content += TextChunk(MarkOf(content));
  content += kPngEnd;
  return content;
}

// a complete picture ends with IEND, %%EOF or </svg>: an interrupted plot program leaves less
bool IsWholePicture(std::string_view content) {
  if (content.starts_with(kPngBegin)) return content.ends_with(kPngEnd);
  while (content.ends_with('\n')) content.remove_suffix(1);
  if (content.starts_with("%PDF")) return content.ends_with("%%EOF");
  return content.starts_with("<?xml") && content.ends_with("</svg>");
}

bool IsOfKind(std::string_view content, const OutputKind& kind) {
  if (kind.is_marked) return content.starts_with(kind.begin) && EndsWithMark(content);
  // an empty file holds nothing that could be lost
  if (content.empty()) return true;
  return (kind.has_comments ? WithoutComments(content) : content).starts_with(kind.begin);
}

}  // namespace haptometer::cli
