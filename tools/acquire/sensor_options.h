#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "base/error.h"
#include "tools/cli/options.h"

namespace haptometer::tools {

/// What `--sensor` begins with for a simulated scene: scene:FILE.
inline constexpr std::string_view kScenePrefix = "scene:";

/// Which sensor, and how it is spoken to: what the command line or a daemon's file says of it.
struct SensorOptions {
  std::string port;
  std::string sensor = "keyence-il";
  std::string format;
  std::string profile;                   ///< modbus: a name or a file
  std::optional<std::int64_t> slave;     ///< modbus: its address
  std::string channels;                  ///< pipe
  std::string calibration;               ///< pipe: a file
  std::optional<std::int64_t> averages;  ///< pipe, stream: of the sensor before it
  std::optional<double> sampling_s;      ///< pipe, stream: period of what is averaged
  std::string speed;                     ///< replay, scene: "recorded", "max" or a factor
  std::optional<std::int64_t> baud;
  std::optional<double> refresh_s;
  std::optional<double> rate_hz;         ///< pipe: of its rows; keyence-*, modbus: of polls
  std::string command;                   ///< keyence-*: "m0", "m1", "m2", "ms"; "": the usual
  std::optional<std::int64_t> decimals;  ///< keyence-en1, keyence-lkg
  bool device_zero = false;              ///< keyence-il, keyence-en1: changes the device
  std::vector<std::string> settings;     ///< keyence-il, keyence-en1: KEY=VALUE; change the device

  [[nodiscard]] bool is_scene() const { return sensor.starts_with(kScenePrefix); }
};

/// `wanted` without what would change the device once more: for a reconnection.
[[nodiscard]] SensorOptions WithoutChanges(SensorOptions wanted);

/// Declares the options that name a sensor.
void DeclareSensor(cli::Options& options, SensorOptions& wanted);

/// What is wrong with them, before anything is touched. Errors (Cause::kUsage).
[[nodiscard]] Result<void> CheckSensor(const SensorOptions& wanted);

/// Rows of one recorded second a second: `speed` as a number above 0, infinite for "max".
/// Errors (Cause::kUsage).
[[nodiscard]] Result<double> ReadSpeed(const std::string& speed);

/// Where its readings come from, in messages: the port, or what stands for one.
[[nodiscard]] std::string PortName(const SensorOptions& wanted);

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

/// Opens the sensor's port and joins it to its protocol; says nothing to the device yet
/// (Sensor::Start does). `wanted` has passed CheckSensor(); `clock` must outlive the sensor.
///
/// May be called again after the sensor was lost: nothing is kept between calls.
///
/// A scene's sensor has no wire between: the rows that `simulate -o` writes, as fast as they are
/// asked for, up to the scene's duration, or without an end; each Begin() plays it from its start.
/// A scene without [sensor] gets an ideal one on the skin, with a remark.
/// Errors: Cause::kUsage for a setting that the sensor does not have, Cause::kCannotAnswer for a
/// port that is none, is not there or is in use; those of ReadPlayedScene
/// (tools/simulate/simulated_trial.h).
[[nodiscard]] Result<std::unique_ptr<acquire::Sensor>> OpenSensor(const SensorOptions& wanted,
                                                                  Clock& clock);

}  // namespace haptometer::tools
