// A drops file's text: whatever it says, it is read or refused.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "tools/fit/drop_records.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto file = haptometer::tools::ReadDropsText(text, "shelf/drops.toml");
  if (!file) {
    if (file.error().Text().empty()) std::abort();
    return 0;
  }
  if (file->drops.empty()) std::abort();
  for (const auto& drop : file->drops) {
    if (drop.name.empty()) std::abort();
    if (drop.load_ohm && !(drop.load_ohm->value > 0)) std::abort();
    if (drop.rebound && !(drop.rebound->value >= 0 && drop.rebound->value <= 1)) std::abort();
  }
  return 0;
}
