#include "tools/acquire/sensor_kind.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>

#include "tools/acquire/options/sensor_options.h"

namespace haptometer::tools {
namespace {

// a scene comes last: FILE is open
constexpr std::array<SensorKind, 8> kKinds{{
    {.type = SensorType::kKeyenceEn1,
     .name = "keyence-en1",
     .is_il = true,
     .is_keyence = true,
     .is_asked = true},
    {.type = SensorType::kKeyenceIl,
     .name = "keyence-il",
     .is_il = true,
     .is_keyence = true,
     .is_asked = true},
    {.type = SensorType::kKeyenceLkg, .name = "keyence-lkg", .is_keyence = true, .is_asked = true},
    {.type = SensorType::kModbus, .name = "modbus", .is_asked = true},
    {.type = SensorType::kPipe, .name = "pipe", .ends_by_itself = true},
    {.type = SensorType::kReplay, .name = "replay", .is_played = true, .ends_by_itself = true},
    {.type = SensorType::kStream, .name = "stream"},
    {.type = SensorType::kScene, .name = kScenePrefix, .is_played = true, .ends_by_itself = true},
}};

}  // namespace

const SensorKind* FindSensorKind(std::string_view sensor) {
  if (sensor.starts_with(kScenePrefix)) sensor = kScenePrefix;
  const auto* const found = std::ranges::find(kKinds, sensor, &SensorKind::name);
  return found == kKinds.end() ? nullptr : found;
}

bool IsSensor(std::string_view sensor, SensorType type) {
  const SensorKind* kind = FindSensorKind(sensor);
  return kind != nullptr && kind->type == type;
}

std::string SensorNames() {
  std::string names;
  for (const SensorKind& kind : kKinds) {
    names += fmt::format("{}{}", names.empty() ? "" : ", ", kind.name);
  }
  return names + "FILE";
}

}  // namespace haptometer::tools
