#include "trial/byte_io.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "base/input_file.h"
#include "base/instruction_set.h"

#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace haptometer::trial {
namespace {

class FileSink final : public ByteSink {
 public:
  FileSink(int descriptor, std::string path) : descriptor_(descriptor), path_(std::move(path)) {
    struct stat status{};
    // only a regular file can be cut, moved or appended to; a pipe has no size
    is_regular_ = fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode);
    size_ = kept_ = is_regular_ ? status.st_size : 0;
  }
  ~FileSink() override { close(descriptor_); }
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;

  Result<std::size_t> WriteSome(std::span<const std::byte> bytes) override {
    // another program may have cut or deleted the file since the last write
    HAPTOMETER_TRY(CheckWhole());
    // a signal (Ctrl-C) may interrupt a write before its first byte
    ssize_t written = -1;
    do {
      written = write(descriptor_, bytes.data(), bytes.size());
    } while (written < 0 && errno == EINTR);
    // a write of 0 bytes without an error is a full disk
    if (written <= 0) return Failed("", std::strerror(written < 0 ? errno : ENOSPC));
    size_ += written;
    return static_cast<std::size_t>(written);
  }

  Result<void> Sync() override {
    HAPTOMETER_TRY(CheckWhole());
    // pipes and character devices (/dev/null) cannot be synced and need not be
    if (fdatasync(descriptor_) == 0 || errno == EINVAL || errno == EROFS) return {};
    return Failed("", std::strerror(errno));
  }

  void Keep() override { kept_ = size_; }

  void CutToKept() override {
    // never longer than it is: that would insert zeros
    struct stat status{};
    if (!is_regular_ || fstat(descriptor_, &status) != 0 || status.st_size <= kept_) return;
    if (ftruncate(descriptor_, kept_) == 0) size_ = kept_;
  }

  std::string MovedTo() const override {
    // the open file and the file at the path are the same if inode and device are
    struct stat ours{};
    struct stat there{};
    if (!is_regular_ || fstat(descriptor_, &ours) != 0) return {};
    const bool is_there = stat(path_.c_str(), &there) == 0 && there.st_ino == ours.st_ino &&
                          there.st_dev == ours.st_dev;
    if (is_there) return {};
    // Linux has the present path of an open file in /proc
    std::error_code error;
    const auto now =
        std::filesystem::read_symlink(fmt::format("/proc/self/fd/{}", descriptor_), error);
    return error ? "another place" : now.string();
  }

 private:
  // whether the file is still the one that was written, and as long
  Result<void> CheckWhole() {
    struct stat status{};
    if (!is_regular_ || fstat(descriptor_, &status) != 0) return {};
    // no name refers to the file any longer: what is written is lost when it is closed
    if (status.st_nlink == 0) {
      return Failed("", "another program deleted or replaced the file",
                    "nothing of it is kept: record it again");
    }
    if (status.st_size < size_) {
      return Failed(
          "",
          fmt::format("another program cut the file from {} to {} bytes", size_, status.st_size),
          "only what lies before the cut is kept: record it again");
    }
    size_ = status.st_size;
    return {};
  }

  int descriptor_;
  std::string path_;
  bool is_regular_ = false;
  off_t size_ = 0;  ///< of the file, when it was last examined or written
  off_t kept_ = 0;  ///< of it, what is whole
};

// keeps other writers out; the lock ends with the descriptor, also when the process is killed
Result<std::unique_ptr<ByteSink>> Locked(int descriptor, const std::string& path,
                                         bool is_emptied = false) {
  // an advisory lock, which every writer of this program requests
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    close(descriptor);
    return Failed(path, "is being recorded by another program",
                  "wait for it to finish, or name another file");
  }
  // emptied only under the lock, so that a running recording is not destroyed
  if (is_emptied && ftruncate(descriptor, 0) != 0 && errno != EINVAL) {
    const int reason = errno;
    close(descriptor);
    return Failed(path, std::string("cannot be emptied: ") + std::strerror(reason),
                  "name another file");
  }
  return std::make_unique<FileSink>(descriptor, path);
}

// appending writes go to the file's end, even if another program appended meanwhile
constexpr int kAppendFlags = O_WRONLY | O_APPEND | O_CLOEXEC;

}  // namespace

Result<int> OpenForAppending(const std::string& path, const std::string& name) {
  const int descriptor = open(path.c_str(), kAppendFlags | O_NOCTTY | O_NONBLOCK);
  if (descriptor < 0 && errno == ENXIO) {
    return Usage(name, "is a pipe that no program reads", "start its reader first, or name a file");
  }
  if (descriptor < 0) {
    return Failed(name, std::string("cannot be written: ") + std::strerror(errno),
                  "is there room, and may you write there?");
  }
  // its writes wait for the reader
  static_cast<void>(fcntl(descriptor, F_SETFL, O_APPEND));
  return descriptor;
}

Result<std::unique_ptr<ByteSink>> CreateFileSink(const std::string& path, IfExists if_exists) {
  // made exclusively first, so that no file appears between a check and the opening
  const int made = open(path.c_str(), kAppendFlags | O_CREAT | O_EXCL, 0666);
  if (made >= 0) return Locked(made, path);
  if (errno != EEXIST) {
    return Failed(path, std::string("cannot be created: ") + std::strerror(errno),
                  "name a file in a directory that exists and that you may write to");
  }
  if (if_exists == IfExists::kRefuse) {
    return Usage(path, "already exists", "name another file, or give <overwrite>");
  }
  HAPTOMETER_LET(const int opened, OpenForAppending(path, path));
  return Locked(opened, path, true);
}

Result<std::unique_ptr<ByteSink>> OpenFileSinkAtEnd(const std::string& path) {
  const int descriptor = open(path.c_str(), kAppendFlags | O_NONBLOCK);
  if (descriptor >= 0) return Locked(descriptor, path);
  return CannotAnswer(path, std::string("cannot be opened for writing: ") + std::strerror(errno),
                      "check the path and its permissions");
}

namespace {

class FileSource final : public ByteSource {
 public:
  FileSource(int descriptor, std::uint64_t size, std::string path)
      : descriptor_(descriptor), size_(size), path_(std::move(path)) {}
  ~FileSource() override { close(descriptor_); }
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  std::uint64_t size() const override { return size_; }

  Result<std::size_t> ReadAt(std::uint64_t offset, std::span<std::byte> into) const override {
    std::size_t done = 0;
    while (done < into.size()) {
      const ssize_t got = pread(descriptor_, into.data() + done, into.size() - done,
                                static_cast<off_t>(offset + done));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) {
        return CannotAnswer(path_, std::string("cannot be read: ") + std::strerror(errno),
                            "check the disk");
      }
      // the file's end: shorter than requested, no error
      if (got == 0) break;
      done += static_cast<std::size_t>(got);
    }
    return done;
  }

 private:
  int descriptor_;
  std::uint64_t size_;
  std::string path_;
};

class MemorySource final : public ByteSource {
 public:
  explicit MemorySource(std::string bytes) : bytes_(std::move(bytes)) {}

  std::uint64_t size() const override { return bytes_.size(); }

  Result<std::size_t> ReadAt(std::uint64_t offset, std::span<std::byte> into) const override {
    if (offset >= bytes_.size() || into.empty()) return std::size_t{0};
    const std::size_t count = std::min<std::size_t>(into.size(), bytes_.size() - offset);
    std::memcpy(into.data(), bytes_.data() + offset, count);
    return count;
  }

 private:
  std::string bytes_;
};

}  // namespace

Result<std::unique_ptr<ByteSource>> OpenFileSource(const std::string& path) {
  // not blocking, so that a named pipe without a writer is refused rather than waited for
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) {
    if (errno == ENOENT) return CannotAnswer(path, "no such file", "check the path");
    return DoesNotOpen(path, errno);
  }
  struct stat status{};
  // the descriptor is closed on each refusal
  auto refuse = [&](const char* what, const char* remedy) {
    close(descriptor);
    return CannotAnswer(path, what, remedy);
  };
  if (fstat(descriptor, &status) != 0) return refuse("cannot be examined", "check the disk");
  if (S_ISDIR(status.st_mode)) return refuse("is a directory", "name a file in it");
  if (!S_ISREG(status.st_mode)) return refuse("is not a regular file", "save it to a file first");
  if (status.st_size == 0) return refuse("is empty", "was the recording interrupted?");
  NoteInput(path);
  return std::make_unique<FileSource>(descriptor, static_cast<std::uint64_t>(status.st_size), path);
}

std::unique_ptr<ByteSource> MakeMemorySource(std::string bytes) {
  return std::make_unique<MemorySource>(std::move(bytes));
}

namespace {

// continues from `crc`, that of the bytes before
std::uint32_t ByZlib(std::uint32_t crc, std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

#ifdef __x86_64__
// CRC by carry-less multiplication: four lanes of 16 bytes are in flight at once
constexpr std::size_t kLane = 16;
constexpr std::size_t kLanes = 4;
// start and final value of the CRC, all ones
constexpr std::uint32_t kOnes = 0xffff'ffff;

[[gnu::target("pclmul,sse4.1")]] inline __m128i Load(const std::byte* bytes) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes));
}

// `lane` advanced by as many bits as `powers` state, plus `next` (in GF(2), a XOR)
[[gnu::target("pclmul,sse4.1")]] inline __m128i Folded(__m128i lane, __m128i powers, __m128i next) {
  const __m128i low = _mm_clmulepi64_si128(lane, powers, 0x00);
  const __m128i high = _mm_clmulepi64_si128(lane, powers, 0x11);
  return _mm_xor_si128(_mm_xor_si128(low, high), next);
}

// x^n modulo the polynomial, bits reflected and shifted by one: x^(n + 32) and x^(n - 32) advance
// the halves of a lane by n bits
constexpr std::int64_t Power(int n) {
  // 0xedb88320: the polynomial of CRC-32 with its bits reflected; one step multiplies by x
  std::uint32_t power = 0x8000'0000;
  for (int k = 0; k < n; ++k) power = (power >> 1U) ^ ((power & 1U) != 0 ? 0xedb8'8320 : 0);
  return static_cast<std::int64_t>(power) << 1U;
}
static_assert(Power(512 + 32) == 0x1'5444'2bd4 && Power(512 - 32) == 0x1'c6e4'1596,
              "Gopal et al., table for the gzip CRC");

// 64 bytes and more, begun from `start`
[[gnu::target("pclmul,sse4.1")]] std::uint32_t ByFolding(std::uint32_t start,
                                                         std::span<const std::byte> bytes) {
  // 512 bits: the distance of a lane's next block; 128 bits: the distance of two lanes
  const __m128i by_512 = _mm_set_epi64x(Power(512 - 32), Power(512 + 32));
  const __m128i by_128 = _mm_set_epi64x(Power(128 - 32), Power(128 + 32));
  __m128i lanes[kLanes];
  for (std::size_t k = 0; k < kLanes; ++k) lanes[k] = Load(&bytes[k * kLane]);
  // the CRC of what came before is added to the first 32 bits
  lanes[0] = _mm_xor_si128(lanes[0], _mm_cvtsi32_si128(static_cast<int>(start)));
  bytes = bytes.subspan(kLanes * kLane);
  for (; bytes.size() >= kLanes * kLane; bytes = bytes.subspan(kLanes * kLane)) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      lanes[k] = Folded(lanes[k], by_512, Load(&bytes[k * kLane]));
    }
  }
  // the four lanes become one of 128 bits with the same remainder
  __m128i folded = lanes[0];
  for (std::size_t k = 1; k < kLanes; ++k) folded = Folded(folded, by_128, lanes[k]);
  std::array<std::byte, kLane> rest;
  _mm_storeu_si128(reinterpret_cast<__m128i*>(rest.data()), folded);
  // the start is in them already: begun from 0, which zlib calls the CRC of all ones
  return ByZlib(ByZlib(kOnes, rest), bytes);
}

// AVX-512: each lane is 64 bytes, so that the lanes are 2048 bits apart
constexpr std::size_t kWideLane = 64;

[[gnu::target("vpclmulqdq,avx512f")]] inline __m512i LoadWide(const std::byte* bytes) {
  return _mm512_loadu_si512(bytes);
}

// the same of 256 bytes and more, four times as wide
[[gnu::target("vpclmulqdq,avx512f")]] std::uint32_t ByWideFolding(
    std::uint32_t start, std::span<const std::byte> bytes) {
  constexpr std::int64_t kLow = Power(2048 + 32);
  constexpr std::int64_t kHigh = Power(2048 - 32);
  const __m512i by_2048 = _mm512_set4_epi64(kHigh, kLow, kHigh, kLow);
  __m512i lanes[kLanes];
  for (std::size_t k = 0; k < kLanes; ++k) lanes[k] = LoadWide(&bytes[k * kWideLane]);
  const __m512i begin = _mm512_zextsi128_si512(_mm_cvtsi32_si128(static_cast<int>(start)));
  lanes[0] = _mm512_xor_si512(lanes[0], begin);
  bytes = bytes.subspan(kLanes * kWideLane);
  for (; bytes.size() >= kLanes * kWideLane; bytes = bytes.subspan(kLanes * kWideLane)) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const __m512i low = _mm512_clmulepi64_epi128(lanes[k], by_2048, 0x00);
      const __m512i high = _mm512_clmulepi64_epi128(lanes[k], by_2048, 0x11);
      const __m512i next = LoadWide(&bytes[k * kWideLane]);
      lanes[k] = _mm512_xor_si512(_mm512_xor_si512(low, high), next);
    }
  }
  // the 256 remaining bytes have the same CRC as all before: they are folded as above
  std::array<std::byte, kLanes * kWideLane> rest;
  for (std::size_t k = 0; k < kLanes; ++k) _mm512_storeu_si512(&rest[k * kWideLane], lanes[k]);
  return ByZlib(ByFolding(0, rest), bytes);
}
#endif

}  // namespace

std::uint32_t Crc32(std::span<const std::byte> bytes) {
#ifdef __x86_64__
  // the widest method that the processor supports and the length allows; AVX-512 began without
  // carry-less products
  static const bool folds = UsableInstructionSet() >= InstructionSet::kAvx2;
  static const bool folds_widely = UsableInstructionSet() == InstructionSet::kAvx512 &&
                                   __builtin_cpu_supports("vpclmulqdq") != 0;
  if (folds_widely && bytes.size() >= kLanes * kWideLane) return ByWideFolding(kOnes, bytes);
  if (folds && bytes.size() >= kLanes * kLane) return ByFolding(kOnes, bytes);
#endif
  return ByZlib(0, bytes);
}

}  // namespace haptometer::trial
