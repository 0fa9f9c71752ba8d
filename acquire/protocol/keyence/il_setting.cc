#include "acquire/protocol/keyence/il_setting.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "acquire/protocol/keyence/dl_rs1a.h"

namespace haptometer::acquire::il_setting {
namespace {

struct Key {
  std::string_view name;
  int number;
  int codes;  // 0 to codes - 1
};

constexpr std::array kKeys = {
    Key{"sampling", dl_rs1a::kSamplingCycle, 5}, Key{"averaging", dl_rs1a::kAveraging, 15},
    Key{"hold", dl_rs1a::kHold, 6}, Key{"high-pass", dl_rs1a::kHighPassCutoff, 10}};
constexpr std::string_view kOff = "off";

// the name of a code; "" where there is none
std::string CodeName(int number, int code) {
  switch (number) {
    case dl_rs1a::kSamplingCycle:
      if (code == 0) return "default";
      if (const auto s = dl_rs1a::SamplingSeconds(code)) return fmt::format("{:g}ms", *s * 1e3);
      return {};
    case dl_rs1a::kAveraging:
      if (code == dl_rs1a::kDifferenceFilter) return "difference";
      if (code == dl_rs1a::kHighPassFilter) return "high-pass";
      if (const auto averages = dl_rs1a::Averages(code)) return fmt::to_string(*averages);
      return {};
    case dl_rs1a::kHold: {
      std::string name(dl_rs1a::HoldName(code));
      std::ranges::replace(name, ' ', '-');
      return name;
    }
    case dl_rs1a::kHighPassCutoff:
      if (const auto hz = dl_rs1a::HighPassHz(code)) return fmt::format("{:g}Hz", *hz);
      return {};
    default:
      return {};
  }
}

std::vector<std::string> Values(const Key& key) {
  std::vector<std::string> values;
  if (key.number == dl_rs1a::kHighPassCutoff) values.emplace_back(kOff);
  for (int code = 0; code < key.codes; ++code) values.push_back(CodeName(key.number, code));
  return values;
}

}  // namespace

Result<std::vector<Write>> Parse(std::string_view text) {
  const std::size_t equals = text.find('=');
  const std::string_view name = text.substr(0, equals);
  const auto key = std::ranges::find(kKeys, name, &Key::name);
  if (equals == std::string_view::npos || key == kKeys.end()) {
    return Usage("--set", fmt::format("'{}' is no setting of an IL amplifier", text),
                 "write sampling=..., averaging=..., hold=... or high-pass=...");
  }
  std::string value(text.substr(equals + 1));
  std::ranges::replace(value, ' ', '-');
  const bool is_high_pass = key->number == dl_rs1a::kHighPassCutoff;
  if (is_high_pass && value == kOff) {
    return std::vector{Write{std::string(name), dl_rs1a::kAveraging, 0, dl_rs1a::kHighPassFilter}};
  }
  for (int code = 0; code < key->codes; ++code) {
    if (CodeName(key->number, code) != value) continue;
    std::vector writes{Write{std::string(name), key->number, code}};
    if (is_high_pass) {
      writes.push_back({std::string(name), dl_rs1a::kAveraging, dl_rs1a::kHighPassFilter});
    }
    return writes;
  }
  return Usage("--set", fmt::format("an IL amplifier has no {} '{}'", name, value),
               fmt::format("use one of {}", fmt::join(Values(*key), ", ")));
}

std::string Describe(int number, int code) {
  const std::string name = CodeName(number, code);
  return name.empty() ? fmt::to_string(code) : name;
}

}  // namespace haptometer::acquire::il_setting
