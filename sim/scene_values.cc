#include "sim/scene_values.h"

#include <fmt/core.h>

#include <cmath>

namespace haptometer::sim {

namespace {

constexpr double kSmallest = 1e-9;
constexpr double kLargest = 1e9;

}  // namespace

void RefuseUnlessReal(TomlTable& table, std::string_view key, double value) {
  if (value < kSmallest || value > kLargest) {
    table.Refuse(key,
                 fmt::format("{:g} is outside {:g} to {:g}, where all scenes lie", value, kSmallest,
                             kLargest),
                 "check its unit");
  }
}

double Positive(TomlTable& table, std::string_view key, Dimension dimension) {
  const double value = table.Require(key, dimension);
  if (!(value > 0)) table.Refuse(key, "must be greater than 0", "check its sign");
  RefuseUnlessReal(table, key, value);
  return value;
}

double NotNegative(TomlTable& table, std::string_view key, Dimension dimension) {
  const double value = table.Require(key, dimension);
  if (value < 0) table.Refuse(key, "must not be negative", "check its sign");
  if (value != 0) RefuseUnlessReal(table, key, value);
  return value;
}

double Signed(TomlTable& table, std::string_view key, Dimension dimension) {
  const double value = table.Number(key, dimension).value_or(0);
  if (value != 0) RefuseUnlessReal(table, key, std::abs(value));
  return value;
}

double NotNegativeOr(TomlTable& table, std::string_view key, Dimension dimension, double absent) {
  return table.Has(key) ? NotNegative(table, key, dimension) : absent;
}

}  // namespace haptometer::sim
