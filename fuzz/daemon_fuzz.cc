// A daemon's file and a daemon's answer: whatever they say, they are read or refused.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "tools/daemon/daemon_config.h"
#include "tools/daemon/status.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptometer::tools;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto config = ParseDaemonConfig(text, "d.toml");
  if (config && (config->sensors.empty() || config->reserve_bytes == 0)) std::abort();
  if (!config && config.error().Text().empty()) std::abort();
  // what is read is written and read again as the same
  if (const auto status = ParseStatus(text, "s")) {
    const std::string json = StatusJson(*status);
    const auto again = ParseStatus(json, "s");
    if (!again || StatusJson(*again) != json || StatusLine(*again) != StatusLine(*status)) {
      std::abort();
    }
  }
  return 0;
}
