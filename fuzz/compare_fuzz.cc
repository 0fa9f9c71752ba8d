// A document of analyze --json, as compare reads it: numbers with uncertainties, or a refusal.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "fuzz/memory_path.h"
#include "fuzz/require.h"
#include "fuzz/seeds.h"
#include "tools/compare/measured.h"

namespace {

constexpr std::array<std::string_view, 1> kSeeds{
    R"({"trials": [{"file": "a.bin", "answered": true, "reasons": [], "data_source": ["device"],
    "band": {"lower_hz": 20, "upper_hz": 500}, "band_rms_m": 4.6e-5,
    "band_rms_standard_uncertainty_m": 3e-7, "tone_frequency_hz": 225,
    "tone_frequency_standard_uncertainty_hz": 1e-2, "onset": {"rise_s": 0.05,
    "rise_standard_uncertainty_s": 1e-3}, "electrical": {"current_rms_a": {"value": 0.13,
    "standard_uncertainty": 1e-3}}}], "findings": [{"severity": "doubt", "text": "t",
    "subject": "a.bin"}]})"};

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned random) {
  return haptometer::fuzz::MutateFromSeeds(kSeeds, 0, {data, max_size}, size, random);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptometer;
  if (size == 0 || data[0] != '{') return -1;  // a recording, which trial_fuzz reads
  const fuzz::MemoryPath document({reinterpret_cast<const char*>(data), size});
  const auto measured = tools::ReadMeasured(std::array{document.path()});
  if (!measured) {
    fuzz::Require(!measured.error().Text().empty());
    return 0;
  }
  fuzz::Require(!measured->files.empty());
  for (const auto& number : measured->numbers) {
    // sums of the largest doubles may be infinite, but no uncertainty is 0 or negative
    fuzz::Require(!number || number->uncertainty > 0 || std::isnan(number->uncertainty));
  }
  return 0;
}
