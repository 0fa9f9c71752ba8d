// A file of results as study --merge reads it: its answers stand in the place of analyses, or it is
// refused. The seed is what a shard of two trials writes.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <string_view>

#include "base/input_file.h"
#include "fuzz/memory_path.h"
#include "fuzz/seeds.h"
#include "fuzz/verb_run.h"
#include "tools/verbs.h"
#include "trial/byte_io.h"

namespace {

using namespace haptometer;
namespace fs = std::filesystem;

// a folder with two trials of one subject
const std::string& Folder() {
  static const std::string folder = [] {
    const fs::path path =
        fs::temp_directory_path() / ("trial_results_fuzz_" + std::to_string(getpid()));
    fs::create_directories(path);
    for (const char* condition : {"a", "b"}) {
      std::ofstream file(path / (std::string(condition) + ".csv"));
      file << "# label.subject = 1\n# label.condition = " << condition
           << "\ntime_s,displacement_um\n";
      for (int n = 0; n < 64; ++n) file << n * 1e-3 << ',' << n % 4 << '\n';
    }
    return path.string();
  }();
  return folder;
}

std::string Whole() {
  const fs::path part = fs::temp_directory_path() / ("part_fuzz_" + std::to_string(getpid()));
  fuzz::RunVerb(tools::RunStudy, {"study", Folder(), "--shard", "1/1", "-o", part.string()});
  std::ifstream file(part, std::ios::binary);
  std::string whole{std::istreambuf_iterator<char>(file), {}};
  fs::remove(part);
  return whole;
}

// the file with lengths and checksums that agree, so that what they protect is reached
std::string Repaired(std::string file) {
  constexpr std::size_t kHead = 2 * sizeof(std::uint32_t);
  const std::size_t title = file.find('\n');
  const std::size_t head = title == std::string::npos ? title : file.find('\n', title + 1);
  if (head == std::string::npos) return file;
  for (std::size_t at = head + 1; at + kHead <= file.size();) {
    std::uint32_t numbers[2];
    std::memcpy(numbers, file.data() + at, kHead);
    const std::size_t left = file.size() - at - kHead;
    numbers[0] = static_cast<std::uint32_t>(std::min<std::size_t>(numbers[0], left));
    const std::string_view payload = std::string_view(file).substr(at + kHead, numbers[0]);
    numbers[1] = trial::Crc32(std::as_bytes(std::span(payload)));
    std::memcpy(file.data() + at, numbers, kHead);
    at += kHead + payload.size();
  }
  return file;
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned random) {
  static const std::string whole = Whole();
  const std::array<std::string_view, 1> seeds{whole};
  return fuzz::MutateFromSeeds(seeds, 0, {data, max_size}, size, random);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // a path in memory ends with its file: what was read before is no input of this merge
  ForgetInputs();
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  const fuzz::MemoryPath file(size % 2 == 0 ? Repaired(bytes) : bytes);
  fuzz::RunVerb(tools::RunStudy,
                {"study", Folder(), "--allow-mixed", "--all", "--merge", file.path()});
  return 0;
}
