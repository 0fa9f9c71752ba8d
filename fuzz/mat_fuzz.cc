// Any bytes as a MATLAB file, from exports that are sound: no crash, and what is read keeps the
// promises of a record.
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "fuzz/recordings.h"
#include "fuzz/seeds.h"
#include "trial/export/export.h"
#include "trial/import/readers.h"

namespace {

using namespace haptometer;

std::string Exported(bool has_gap) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("mat_fuzz_" + std::to_string(getpid()) + ".mat");
  auto writer = trial::MatWriter::Create(path.string());
  fuzz::Require(writer.has_value());
  const auto added = writer->Add("trial", fuzz::SeedRecording(has_gap));
  const auto closed = writer->Close();
  fuzz::Require(added && closed);
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  std::filesystem::remove(path);
  return bytes;
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned random) {
  static const std::string whole = Exported(false);
  static const std::string with_gap = Exported(true);
  const std::array<std::string_view, 2> seeds{whole, with_gap};
  return fuzz::MutateFromSeeds(seeds, 0, {data, max_size}, size, random);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::RequireSound(trial::ParseMat({reinterpret_cast<const char*>(data), size}, "fuzz", ""));
  return 0;
}
