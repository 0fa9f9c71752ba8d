#include "tools/acquire/list_sensors.h"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "tools/cli/band.h"

namespace haptometer::tools {
namespace {

using acquire::Capability;
using acquire::CapabilityQuestion;
using nlohmann::ordered_json;

ordered_json NumberOrNull(const std::optional<double>& number) {
  return number ? ordered_json(*number) : ordered_json(nullptr);
}

ordered_json ToJson(const Capability& capability) {
  const acquire::SensorAbility& sensor = capability.sensor;
  return {{"name", sensor.name},
          {"option", sensor.option},
          {"can_answer", capability.can_answer},
          {"reason", capability.reason},
          {"rate_hz", sensor.rate_hz},
          {"highest_observable_hz", capability.highest_hz},
          {"gain_at_lower", capability.gain_lower},
          {"gain_at_upper", capability.gain_upper},
          {"resolution_m", NumberOrNull(sensor.resolution_m)},
          {"noise_rms_m", NumberOrNull(sensor.noise_rms_m)},
          {"noise_in_band_m", NumberOrNull(capability.noise_in_band_m)},
          {"smallest_rms_10_percent_m", NumberOrNull(capability.smallest_rms_10_percent_m)},
          {"smallest_rms_1_percent_m", NumberOrNull(capability.smallest_rms_1_percent_m)},
          {"range_min_m", NumberOrNull(sensor.range_min_m)},
          {"range_max_m", NumberOrNull(sensor.range_max_m)}};
}

}  // namespace

Result<CapabilityQuestion> ReadCapabilityQuestion(const std::string& band,
                                                  const std::optional<Quantity>& resolution_m) {
  const auto read = cli::ParseBand(band);
  if (!read) return std::unexpected(read.error());
  if (!(read->lower_hz >= 0 && read->lower_hz < read->upper_hz)) {
    return Usage("--band", fmt::format("'{}' does not rise", band), "write it as 20-500Hz");
  }
  CapabilityQuestion question{.lower_hz = read->lower_hz, .upper_hz = read->upper_hz};
  if (resolution_m) question.resolution_m = resolution_m->value;
  if (!(question.resolution_m > 0)) {
    return Usage("--resolution", "must be above 0", "write e.g. 1um");
  }
  return question;
}

std::string SensorListText(const CapabilityQuestion& question) {
  std::string text = fmt::format("{:g}-{:g} Hz in steps of {:g} um:\n", question.lower_hz,
                                 question.upper_hz, 1e6 * question.resolution_m);
  for (const Capability& capability : Judge(acquire::KnownSensors(), question)) {
    text +=
        fmt::format("{:<7} {}\n        {}\n        {}\n", capability.can_answer ? "yes" : "cannot",
                    capability.sensor.name, capability.reason, capability.sensor.option);
  }
  return text;
}

std::string SensorListJson(const CapabilityQuestion& question) {
  ordered_json sensors = ordered_json::array();
  for (const Capability& capability : Judge(acquire::KnownSensors(), question)) {
    sensors.push_back(ToJson(capability));
  }
  const ordered_json document{{"band_hz", {question.lower_hz, question.upper_hz}},
                              {"wanted_resolution_m", question.resolution_m},
                              {"record_s", question.record_s},
                              {"sensors", sensors}};
  return document.dump(2) + "\n";
}

}  // namespace haptometer::tools
