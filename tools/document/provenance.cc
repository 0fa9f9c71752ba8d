#include "tools/document/provenance.h"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <openssl/evp.h>

#include <array>
#include <fstream>
#include <memory>
#include <span>

#include "base/clock.h"
#include "base/input_file.h"
#include "base/text.h"
#include "tools/cli/terminal.h"

namespace haptometer::document {
namespace {

// SHA-256 (FIPS 180-4) in hexadecimal; empty where the file cannot be read
std::string Sha256Of(const std::string& path) {
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> hash(EVP_MD_CTX_new(),
                                                                     &EVP_MD_CTX_free);
  std::ifstream file(path, std::ios::binary);
  if (!hash || EVP_DigestInit_ex(hash.get(), EVP_sha256(), nullptr) != 1 || !file) return {};
  // pieces of 256 KiB: a trial may exceed the memory
  std::vector<char> piece(1 << 18);
  while (file.read(piece.data(), static_cast<std::streamsize>(piece.size())) || file.gcount() > 0) {
    EVP_DigestUpdate(hash.get(), piece.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (file.bad()) return {};
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned length = 0;
  EVP_DigestFinal_ex(hash.get(), digest.data(), &length);
  return fmt::format("{:02x}", fmt::join(std::span(digest.data(), length), ""));
}

InputFile InputOf(const NotedInput& noted) {
  InputFile input{.path = noted.path,
                  .bytes = static_cast<std::uint64_t>(noted.status.st_size),
                  .sha256 = Sha256Of(noted.path)};
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
