#include "tools/daemon/daemon_config.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <set>
#include <variant>

#include "base/mapped.h"
#include "tools/acquire/recording.h"

namespace haptometer::tools {
namespace {

// least rotate_bytes and reserve_bytes
constexpr long long kSmallestTrial = 65536;
constexpr long long kSmallestReserve = 1 << 20;
constexpr MonotonicNs kDefaultRotationNs = 3600 * kNsPerS;

// a name that is safe in a file's name on all systems: no separator, no leading dot, 64 bytes
bool IsPlainName(std::string_view name) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.';
  };
  return !name.empty() && name.size() <= 64 && name.front() != '.' &&
         std::ranges::all_of(name, is_plain);
}

// a time within [least_s, 30 years]
std::optional<double> Seconds(TomlTable& table, std::string_view key, double least_s) {
  const auto seconds = table.Number(key, Dimension::kTime);
  if (seconds && !(*seconds >= least_s && *seconds <= kLongestTimeS)) {
    table.Refuse(key, fmt::format("is not from {:g} s to 30 years", least_s));
    return std::nullopt;
  }
  return seconds;
}

std::optional<std::uint64_t> Bytes(TomlTable& table, std::string_view key, long long least) {
  const auto bytes = table.Integer(key);
  if (!bytes) return std::nullopt;
  if (*bytes < least) table.Refuse(key, fmt::format("must be {} or more", least));
  return static_cast<std::uint64_t>(*bytes);
}

acquire::RotationLimits ReadRotation(TomlTable& table) {
  acquire::RotationLimits limits;
  if (const auto every_s = Seconds(table, "rotate_every_s", 1)) {
    limits.duration_ns = NsFromSeconds(*every_s);
  }
  limits.bytes = Bytes(table, "rotate_bytes", kSmallestTrial);
  // neither time nor size is stated: one trial per hour
  if (!limits.duration_ns && !limits.bytes) limits.duration_ns = kDefaultRotationNs;
  return limits;
}

DaemonSensor ReadSensor(TomlTable& table, const std::map<std::string, std::string>& labels) {
  DaemonSensor sensor;
  sensor.name = table.Text("name").value_or("");
  if (!IsPlainName(sensor.name)) {
    table.Refuse("name", table.Has("name") ? "is not a plain name" : "is missing",
                 "write letters, digits, '_', '-' and '.', e.g. \"left\"");
  }
  sensor.options = ReadSensorKeys(table);
  if (sensor.options.port.empty()) {
    table.Refuse("port", "is missing", "name the sensor's port, e.g. \"/dev/ttyUSB0\"");
  }
  sensor.labels = table.Texts("labels");
  // insert keeps existing keys: the sensor's own labels override those of the file
  sensor.labels.insert(labels.begin(), labels.end());
  return sensor;
}

// conditions between sensors, after all keys are read
Result<void> CheckSensors(const DaemonConfig& config, const std::string& where) {
  if (config.sensors.empty()) {
    return Usage(where, "names no sensor", "write a table [[sensor]] with name and port");
  }
  // names become names of files, and a port has one reader
  std::set<std::string_view> names;
  std::set<std::string_view> ports;
  for (const DaemonSensor& sensor : config.sensors) {
    const std::string place = fmt::format("{}: sensor {}", where, sensor.name);
    if (!names.insert(sensor.name).second) {
      return Usage(place, "is given twice", "give each [[sensor]] its own name");
    }
    if (!ports.insert(sensor.options.port).second) {
      return Usage(place, fmt::format("{} is another sensor's port too", sensor.options.port),
                   "give each [[sensor]] its own port");
    }
    // no device that could return: a daemon has nothing to wait for
    const SensorKind* kind = FindSensorKind(sensor.options.sensor);
    if (kind != nullptr && kind->ends_by_itself) {
      return Usage(place, fmt::format("{} ends by itself", sensor.options.sensor),
                   "record it with acquire, without --daemon");
    }
    if (auto checked = CheckSensor(sensor.options); !checked) {
      Error error = checked.error();
      error.where = fmt::format("{}: {}", place, error.where);
      return std::unexpected(error);
    }
  }
  return {};
}

Result<DaemonConfig> Read(TomlTable table) {
  DaemonConfig config;
  config.trials.directory = table.Text("directory").value_or(".");
  if (auto file = table.Text("file")) config.trials.file = *file;
  config.socket = table.Text("socket").value_or("");
  config.rotation = ReadRotation(table);
  config.flush_s = Seconds(table, "flush_s", 0.01).value_or(config.flush_s);
  config.reserve_bytes =
      Bytes(table, "reserve_bytes", kSmallestReserve).value_or(config.reserve_bytes);
  const auto labels = table.Texts("labels");
  for (TomlTable* sensor : table.Tables("sensor")) {
    config.sensors.push_back(ReadSensor(*sensor, labels));
  }
  // errors of keys first (unknown, missing, out of range), then those of their combination
  HAPTOMETER_TRY(table.Finish());
  for (const auto& checked :
       {CheckPattern(config.trials.file, config.sensors.size(), table.where() + ": file"),
        CheckSensors(config, table.where())}) {
    if (!checked) return std::unexpected(checked.error());
  }
  return config;
}

struct TextKey {
  std::string SensorOptions::* field;
};
struct CountKey {
  std::optional<std::int64_t> SensorOptions::* field;
  std::int64_t least;
  std::int64_t most;
};
struct QuantityKey {
  std::optional<double> SensorOptions::* field;
  Dimension dimension;
};

// a key of the file and the field of SensorOptions that it sets
struct SensorKey {
  std::string_view name;
  std::variant<TextKey, CountKey, QuantityKey> kind;
};

// units and limits as those of the options of acquire
constexpr std::array kKeys{
    SensorKey{"sensor", TextKey{&SensorOptions::sensor}},
    SensorKey{"port", TextKey{&SensorOptions::port}},
    SensorKey{"format", TextKey{&SensorOptions::format}},
    SensorKey{"baud", CountKey{&SensorOptions::baud, 50, 4'000'000}},
    SensorKey{"refresh_s", QuantityKey{&SensorOptions::refresh_s, Dimension::kTime}},
    SensorKey{"rate_hz", QuantityKey{&SensorOptions::rate_hz, Dimension::kFrequency}},
    SensorKey{"command", TextKey{&SensorOptions::command}},
    SensorKey{"decimals", CountKey{&SensorOptions::decimals, 0, 5}},
    SensorKey{"averages", CountKey{&SensorOptions::averages, 1, 1'000'000}},
    SensorKey{"sampling_s", QuantityKey{&SensorOptions::sampling_s, Dimension::kTime}},
    SensorKey{"profile", TextKey{&SensorOptions::profile}},
    SensorKey{"slave", CountKey{&SensorOptions::slave, 0, 255}},
};

// reads a key by its kind; errors collect in the table until Finish()
struct ReadInto {
  TomlTable& table;
  std::string_view name;
  SensorOptions& options;

  void operator()(const TextKey& key) const {
    if (auto text = table.Text(name)) options.*key.field = std::move(*text);
  }
  void operator()(const CountKey& key) const {
    const auto count = table.Integer(name);
    if (!count) return;
    if (*count < key.least || *count > key.most) {
      table.Refuse(name, fmt::format("{} is not from {} to {}", *count, key.least, key.most));
    }
    options.*key.field = *count;
  }
  void operator()(const QuantityKey& key) const {
    if (!table.Has(name)) return;
    const Quantity given = table.RequireQuantity(name, key.dimension);
    if (!given.exact()) table.Refuse(name, "has an uncertainty, which is not used here");
    options.*key.field = given.value;
  }
};

void Replace(std::string& text, std::string_view placeholder, std::string_view by) {
  // continues behind the inserted text, which may hold the placeholder itself
  for (std::size_t at = 0; (at = text.find(placeholder, at)) != std::string::npos;) {
    text.replace(at, placeholder.size(), by);
    at += by.size();
  }
}

std::string Filled(std::string_view pattern, std::string_view name, std::string_view utc,
                   std::uint64_t part) {
  std::string text(pattern);
  Replace(text, "{name}", name);
  Replace(text, "{utc}", utc);
  Replace(text, "{part}", fmt::format("{:04}", part));
  return text;
}

}  // namespace

Result<DaemonConfig> ReadDaemonConfig(const std::string& path) {
  HAPTOMETER_LET(auto table, TomlTable::ParseFile(path));
  return Read(std::move(table));
}

Result<DaemonConfig> ParseDaemonConfig(std::string_view text, const std::string& where) {
  HAPTOMETER_LET(auto table, TomlTable::ParseText(text, where));
  return Read(std::move(table));
}

SensorOptions ReadSensorKeys(TomlTable& table) {
  SensorOptions options;
  for (const SensorKey& key : kKeys) std::visit(ReadInto{table, key.name, options}, key.kind);
  return options;
}

std::vector<std::string_view> SensorKeyNames() { return Mapped(kKeys, &SensorKey::name); }

Result<void> CheckPattern(std::string_view file, std::size_t sensors, std::string_view where) {
  constexpr const char* kRemedy = "write a name with {name}, {utc} and {part} in it";
  if (file.empty()) return Usage(std::string(where), "is empty", kRemedy);
  // filled with samples: a slash is a path, a remaining brace an unknown placeholder
  const std::string filled = Filled(file, "n", "u", 1);
  if (filled.find_first_of(std::string_view("/\0", 2)) != std::string::npos) {
    return Usage(std::string(where), "is a path", "name the directory under `directory`");
  }
  if (filled.find_first_of("{}") != std::string::npos) {
    return Usage(std::string(where), fmt::format("\"{}\" has a brace that means nothing", file),
                 kRemedy);
  }
  // several sensors write at the same time: without {name} their files would collide
  if (sensors > 1 && !file.contains("{name}")) {
    return Usage(std::string(where), fmt::format("\"{}\" names all sensors' trials the same", file),
                 "write {name} in it");
  }
  return {};
}

std::string NextTrialPath(const TrialPattern& pattern, std::string_view name, std::string_view utc,
                          std::uint64_t part) {
  // {utc} and {part} may repeat when the wall clock is set back: a number is appended
  const std::string file = Filled(pattern.file, name, CompactUtc(utc), part);
  return FirstFreePath((std::filesystem::path(pattern.directory) / file).string(), '-');
}

}  // namespace haptometer::tools
