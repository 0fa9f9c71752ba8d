#include "tools/daemon/sensor_keys.h"

#include <fmt/core.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace haptometer::tools {
namespace {

struct TextKey {
  std::string SensorOptions::* field;
};
struct CountKey {
  std::optional<std::int64_t> SensorOptions::* field;
  std::int64_t least;
  std::int64_t most;
};
struct QuantityKey {
  std::optional<Quantity> SensorOptions::* field;
  Dimension dimension;
};

struct Key {
  std::string_view name;
  std::variant<TextKey, CountKey, QuantityKey> kind;
};

// one line a key
constexpr std::array kKeys{
    Key{"sensor", TextKey{&SensorOptions::sensor}},
    Key{"port", TextKey{&SensorOptions::port}},
    Key{"format", TextKey{&SensorOptions::format}},
    Key{"baud", CountKey{&SensorOptions::baud, 50, 4'000'000}},
    Key{"refresh_s", QuantityKey{&SensorOptions::refresh_s, Dimension::kTime}},
    Key{"rate_hz", QuantityKey{&SensorOptions::rate_hz, Dimension::kFrequency}},
    Key{"command", TextKey{&SensorOptions::command}},
    Key{"decimals", CountKey{&SensorOptions::decimals, 0, 5}},
    Key{"profile", TextKey{&SensorOptions::profile}},
    Key{"slave", CountKey{&SensorOptions::slave, 0, 255}},
};

// how each kind of key is read
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
    if (table.Has(name)) options.*key.field = table.RequireQuantity(name, key.dimension);
  }
};

}  // namespace

SensorOptions ReadSensorKeys(TomlTable& table) {
  SensorOptions options;
  for (const Key& key : kKeys) std::visit(ReadInto{table, key.name, options}, key.kind);
  return options;
}

std::vector<std::string_view> SensorKeyNames() {
  std::vector<std::string_view> names;
  names.reserve(kKeys.size());
  for (const Key& key : kKeys) names.push_back(key.name);
  return names;
}

}  // namespace haptometer::tools
