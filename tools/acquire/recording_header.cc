#include "tools/acquire/recording_header.h"

#include <unistd.h>

#include <array>
#include <utility>

#include "base/clock.h"
#include "base/text.h"

namespace haptometer::tools {

trial::TrialHeader RecordingHeader(const acquire::Sensor& sensor, bool is_replay,
                                   const std::map<std::string, std::string>& labels,
                                   std::string command_line) {
  trial::TrialHeader header = sensor.header();
  trial::Metadata& metadata = header.metadata;
  if (!is_replay) {
    std::array<char, 256> host{};
    gethostname(host.data(), host.size() - 1);
    metadata.host = Printable(host.data());
    metadata.utc_start = UtcNow();
  }
  metadata.command_line = std::move(command_line);
  for (const auto& [key, value] : labels) metadata.labels[key] = value;
  return header;
}

}  // namespace haptometer::tools
