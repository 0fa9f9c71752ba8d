#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace haptometer::tools {

enum class SensorType : std::uint8_t {
  kKeyenceEn1,
  kKeyenceIl,
  kKeyenceLkg,
  kModbus,
  kPipe,
  kReplay,
  kScene,
  kStream,
};

/// One of what acquire can record from.
struct SensorKind {
  SensorType type{};
  std::string_view name;        ///< in `--sensor`; of a scene what stands before its file
  bool is_il = false;           ///< amplifiers of the IL series, whose settings can be changed
  bool is_keyence = false;      ///< asked by one of Keyence's commands
  bool is_asked = false;        ///< gives a reading for each request
  bool is_played = false;       ///< has a speed of our choice
  bool ends_by_itself = false;  ///< cannot come back once it is over
};

/// The kind that `sensor`, the word behind `--sensor`, names; nullptr where there is none.
[[nodiscard]] const SensorKind* FindSensorKind(std::string_view sensor);

/// Whether `sensor` names the kind `type`.
[[nodiscard]] bool IsSensor(std::string_view sensor, SensorType type);

/// All names for a message: "keyence-en1, ..., stream, scene:FILE".
[[nodiscard]] std::string SensorNames();

}  // namespace haptometer::tools
