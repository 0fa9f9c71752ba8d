#include "tools/daemon/status_report.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "tools/cli/json.h"

namespace haptometer::tools {
namespace {

using nlohmann::ordered_json;

constexpr std::array kStates{LoopState::kStarting,       LoopState::kWaitingForDevice,
                             LoopState::kRecording,      LoopState::kAway,
                             LoopState::kWaitingForDisk, LoopState::kStopped};

ordered_json ToJson(const SensorStatus& sensor) {
  return {{"name", sensor.name},
          {"port", sensor.port},
          {"sensor", sensor.sensor},
          {"state", Name(sensor.state)},
          {"since_utc", cli::TextOrNull(sensor.since_utc)},
          {"file", cli::TextOrNull(sensor.file)},
          {"readings", sensor.readings},
          {"rate_hz", cli::NumberOrNull(sensor.rate_hz)},
          {"bad", sensor.bad},
          {"gaps", sensor.gaps},
          {"lost", sensor.lost},
          {"reconnects", sensor.reconnects},
          {"disk_waits", sensor.disk_waits},
          {"last_error", cli::TextOrNull(sensor.last_error)}};
}

// What stands under a key, made printable, because anything may answer on a socket; where it is of
// another kind, the default, which says nothing
std::string Text(const ordered_json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? Printable(found->get<std::string>()) : "";
}

std::uint64_t Count(const ordered_json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0;
}

std::optional<double> Number(const ordered_json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

std::optional<SensorStatus> FromJson(const ordered_json& object) {
  const std::string state = Text(object, "state");
  const auto found = std::ranges::find_if(kStates, [&](LoopState s) { return Name(s) == state; });
  if (!object.is_object() || found == kStates.end()) return std::nullopt;
  return SensorStatus{.name = Text(object, "name"),
                      .port = Text(object, "port"),
                      .sensor = Text(object, "sensor"),
                      .state = *found,
                      .since_utc = Text(object, "since_utc"),
                      .file = Text(object, "file"),
                      .readings = Count(object, "readings"),
                      .rate_hz = Number(object, "rate_hz"),
                      .bad = Count(object, "bad"),
                      .gaps = Count(object, "gaps"),
                      .lost = Count(object, "lost"),
                      .reconnects = Count(object, "reconnects"),
                      .disk_waits = Count(object, "disk_waits"),
                      .last_error = Text(object, "last_error")};
}

}  // namespace

std::string_view Name(LoopState state) {
  switch (state) {
    case LoopState::kStarting:
      return "starting";
    case LoopState::kWaitingForDevice:
      return "waiting for device";
    case LoopState::kRecording:
      return "recording";
    case LoopState::kAway:
      return "away";
    case LoopState::kWaitingForDisk:
      return "waiting for disk";
    case LoopState::kStopped:
      return "stopped";
  }
  return "";
}

std::string StatusJson(const DaemonStatus& status) {
  ordered_json sensors = ordered_json::array();
  for (const SensorStatus& sensor : status.sensors) sensors.push_back(ToJson(sensor));
  const ordered_json document{
      {"config", status.config}, {"utc", status.utc}, {"sensors", std::move(sensors)}};
  return cli::JsonText(document);
}

Result<DaemonStatus> ParseStatus(std::string_view json, const std::string& where) {
  const auto refused = CannotAnswer(where, "answers with no status of a daemon",
                                    "is it haptometer's, and of this version?");
  const ordered_json document = ordered_json::parse(json, nullptr, false);
  if (!document.is_object() || !document.contains("sensors")) return refused;
  DaemonStatus status{.config = Text(document, "config"), .utc = Text(document, "utc")};
  for (const ordered_json& object : document["sensors"]) {
    auto sensor = FromJson(object);
    if (!sensor) return refused;
    status.sensors.push_back(std::move(*sensor));
  }
  return status;
}

std::string StatusText(const DaemonStatus& status) {
  std::string text;
  for (const SensorStatus& sensor : status.sensors) {
    text += fmt::format("{}: {} since {}, {} readings", sensor.name, Name(sensor.state),
                        sensor.since_utc, sensor.readings);
    if (sensor.rate_hz) text += fmt::format(" ({:.1f}/s)", *sensor.rate_hz);
    text += fmt::format(", {} bad, {} gaps, {} lost, {} reconnects, {} waits for disk", sensor.bad,
                        sensor.gaps, sensor.lost, sensor.reconnects, sensor.disk_waits);
    if (!sensor.file.empty()) text += fmt::format("\n  {}", sensor.file);
    if (!sensor.last_error.empty()) text += fmt::format("\n  last error: {}", sensor.last_error);
    text += "\n";
  }
  return text;
}

std::string StatusLine(const DaemonStatus& status) {
  const auto recording =
      std::ranges::count(status.sensors, LoopState::kRecording, &SensorStatus::state);
  std::string line = fmt::format("{} of {} recording", recording, status.sensors.size());
  for (const SensorStatus& sensor : status.sensors) {
    if (sensor.state == LoopState::kRecording) continue;
    line += fmt::format("; {}: {}", sensor.name, Name(sensor.state));
  }
  return line;
}

}  // namespace haptometer::tools
