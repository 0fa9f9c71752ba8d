// A study's manifest: read or refused, and its contrasts are pairs.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "fuzz/memory_path.h"
#include "fuzz/seeds.h"
#include "tools/study/manifest.h"

namespace {

constexpr std::array<std::string_view, 1> kSeeds{
    "pattern = \"{subject}_{condition}_{repeat}\"\nconditions = [\"stock\", \"ia1\"]\ncontrasts = "
    "[[\"ia1\", \"stock\"]]\nband = \"20-500Hz\"\norder = 6\ncorner = \"whole\"\nfloor = "
    "\"floor.bin\"\n[[trials]]\nfiles = \"*.bin\"\nsubject = \"3\"\n[[trials]]\nfiles = "
    "'b/*.csv'\ncondition = 'ia1'\n"};

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned random) {
  return haptometer::fuzz::MutateFromSeeds(kSeeds, 0, {data, max_size}, size, random);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptometer;
  const fuzz::MemoryPath file({reinterpret_cast<const char*>(data), size});
  const auto manifest = tools::ReadManifest(file.path());
  if (!manifest) {
    fuzz::Require(!manifest.error().Text().empty());
    return 0;
  }
  for (const auto& contrast : manifest->contrasts) {
    fuzz::Require(!contrast.treatment.empty() && !contrast.control.empty() &&
                  contrast.treatment != contrast.control);
  }
  for (const auto& group : manifest->groups) fuzz::Require(!group.files.empty());
  return 0;
}
