#include "tools/document/provenance.h"

#include <dlfcn.h>
#include <fmt/core.h>
#include <fmt/ranges.h>
#include <link.h>

// SHA-256 alone, which OpenSSL 3 calls deprecated in favour of EVP: that loads every algorithm and
// the configuration at each start of the program, and gives the same bytes
#define OPENSSL_SUPPRESS_DEPRECATED
#include <openssl/sha.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <system_error>
#include <tuple>

#include "base/clock.h"
#include "base/error.h"
#include "base/input_file.h"
#include "base/instruction_set.h"
#include "base/text.h"
#include "tools/cli/terminal.h"

namespace haptometer::document {

struct Sha256::State {
  SHA256_CTX hash{};
};

Sha256::Sha256() : state_(std::make_unique<State>()) { SHA256_Init(&state_->hash); }
Sha256::~Sha256() = default;

void Sha256::Add(std::string_view bytes) {
  SHA256_Update(&state_->hash, bytes.data(), bytes.size());
}

std::string Sha256::Hex() {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256_Final(digest.data(), &state_->hash);
  return fmt::format("{:02x}", fmt::join(digest, ""));
}

std::string Sha256Of(const std::string& path, std::uint64_t first_bytes) {
  Sha256 hash;
  std::ifstream file(path, std::ios::binary);
  if (!file) return {};
  // pieces of 256 KiB: a trial may exceed the memory
  std::vector<char> piece(1 << 18);
  std::uint64_t left = first_bytes;
  while (left > 0) {
    const auto size = std::min<std::uint64_t>(piece.size(), left);
    file.read(piece.data(), static_cast<std::streamsize>(size));
    const auto got = static_cast<std::uint64_t>(file.gcount());
    hash.Add({piece.data(), got});
    left -= got;
    if (got < size) break;
  }
  const bool is_whole = first_bytes == std::numeric_limits<std::uint64_t>::max() || left == 0;
  if (file.bad() || !is_whole) return {};
  return hash.Hex();
}

namespace {

#if defined(__clang__)
constexpr std::string_view kCompiler = "clang++ " __clang_version__;
#else
constexpr std::string_view kCompiler = "g++ " __VERSION__;
#endif
#if defined(__x86_64__)
constexpr std::string_view kArchitecture = "x86-64";
#else
constexpr std::string_view kArchitecture = "aarch64";
#endif

// the checksum that is computed beside what the command does
struct {
  std::string path;
  std::future<std::string> sha256;
} hash_ahead;

// checksums that are known, by device, inode, size and time of the last change
using StateKey = std::tuple<dev_t, ino_t, off_t, time_t, long>;

struct KnownHashes {
  std::mutex mutex;
  std::map<StateKey, std::string> sha256;
};

KnownHashes& Known() {
  static KnownHashes known;
  return known;
}

StateKey KeyOf(const struct stat& status) {
  return {status.st_dev, status.st_ino, status.st_size, status.st_mtim.tv_sec,
          status.st_mtim.tv_nsec};
}

std::string HashOf(const std::string& path) {
  const bool is_begun = hash_ahead.sha256.valid() && hash_ahead.path == path;
  return is_begun ? hash_ahead.sha256.get() : HashOfInput(path);
}

InputFile InputOf(const NotedInput& noted) {
  InputFile input{.path = noted.path,
                  .bytes = static_cast<std::uint64_t>(noted.status.st_size),
                  .sha256 = HashOf(noted.path)};
  // a file that has changed since it was read (inode, size, time) has no checksum of the data used
  struct stat now{};
  const auto& then = noted.status;
  const bool is_same = stat(noted.path.c_str(), &now) == 0 && now.st_ino == then.st_ino &&
                       now.st_size == then.st_size && now.st_mtim.tv_sec == then.st_mtim.tv_sec &&
                       now.st_mtim.tv_nsec == then.st_mtim.tv_nsec;
  if (!is_same) input.sha256.clear();
  return input;
}

}  // namespace

std::string HashOfInput(const std::string& path) {
  struct stat status{};
  if (stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return Sha256Of(path);
  {
    const std::scoped_lock lock(Known().mutex);
    const auto known = Known().sha256.find(KeyOf(status));
    if (known != Known().sha256.end()) return known->second;
  }
  const std::string sha256 = Sha256Of(path);
  struct stat after{};
  // a file that changes while it is read has no checksum that anything could be known by
  if (!sha256.empty() && stat(path.c_str(), &after) == 0 && KeyOf(after) == KeyOf(status)) {
    NoteHash(status, sha256);
  }
  return sha256;
}

void NoteHash(const struct stat& status, const std::string& sha256) {
  const std::scoped_lock lock(Known().mutex);
  Known().sha256.insert_or_assign(KeyOf(status), sha256);
}

const std::string& ComputedBy() {
  static const std::string text = [] {
    // the library of another program that this function is in; of the program itself it has no name
    Dl_info here{};
    link_map* file = nullptr;
    const int is_found = dladdr1(reinterpret_cast<const void*>(&ComputedBy), &here,
                                 reinterpret_cast<void**>(&file), RTLD_DL_LINKMAP);
    const bool is_library = is_found != 0 && file != nullptr && *file->l_name != '\0';
    const std::string sha256 = Sha256Of(is_library ? file->l_name : "/proc/self/exe");
    return fmt::format("haptometer {} ({}, {}, {}, program {:.16})", HAPTOMETER_VERSION, kCompiler,
                       kArchitecture, Name(UsableInstructionSet()), sha256);
  }();
  return text;
}

HashAhead::HashAhead(const std::string& path) {
  // what a pipe or a device sends can be read only once
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return;
  NoteInput(path);
  hash_ahead.path = path;
  hash_ahead.sha256 = std::async(std::launch::async, [path] { return Sha256Of(path); });
}

HashAhead::~HashAhead() {
  if (hash_ahead.sha256.valid()) hash_ahead.sha256.wait();
}

Provenance CollectProvenance(const std::vector<std::string>& command) {
  Provenance provenance{
      .version = HAPTOMETER_VERSION, .command = cli::CommandLine(command), .utc = UtcNow()};
  for (const NotedInput& noted : NotedInputs()) provenance.inputs.push_back(InputOf(noted));
  return provenance;
}

std::string CommentOf(const Provenance& provenance, std::string_view before) {
  std::string text = fmt::format("{0}haptometer {1}, {2}\n{0}command: {3}\n", before,
                                 provenance.version, provenance.utc, provenance.command);
  for (const InputFile& input : provenance.inputs) {
    text += fmt::format("{}input: {}, {} bytes, SHA-256 {}\n", before, Printable(input.path),
                        input.bytes, input.sha256.empty() ? "not known" : input.sha256);
  }
  return text;
}

}  // namespace haptometer::document
