#include "tools/acquire/options/trigger_option.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>
#include <sstream>
#include <vector>

#include "base/quantity.h"
#include "trial/record.h"

namespace haptometer::tools {
namespace {

using acquire::TriggerKind;

constexpr std::array kKinds = {TriggerKind::kAbove, TriggerKind::kBelow, TriggerKind::kRising,
                               TriggerKind::kFalling};
constexpr std::string_view kOption = "--trigger";
constexpr std::string_view kExample = "write e.g. 'rising 0.1mm' or 'voltage rising 1V'";

std::optional<TriggerKind> KindOf(const std::string& word) {
  const auto found =
      std::ranges::find_if(kKinds, [&](TriggerKind kind) { return Name(kind) == word; });
  return found == kKinds.end() ? std::nullopt : std::optional(*found);
}

Dimension DimensionOf(const std::string& unit) {
  for (const Dimension dimension : {Dimension::kLength, Dimension::kVoltage, Dimension::kCurrent}) {
    if (SiUnit(dimension) == unit) return dimension;
  }
  return Dimension::kNone;
}

// whether any channel could have this threshold
Result<void> CheckQuantity(const std::string& text) {
  Result<Quantity> last;
  for (const Dimension dimension :
       {Dimension::kVoltage, Dimension::kCurrent, Dimension::kNone, Dimension::kLength}) {
    last = ParseQuantity(text, dimension, kOption);
    if (last) return {};
  }
  return std::unexpected(last.error());
}

}  // namespace

Result<TriggerWish> ParseTrigger(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  const auto kind =
      std::ranges::find_if(words, [](const std::string& word) { return KindOf(word).has_value(); });
  if (kind == words.end() || kind + 1 == words.end()) {
    return Usage(std::string(kOption),
                 fmt::format("'{}' is not [CHANNEL] above|below|rising|falling VALUE", text),
                 std::string(kExample));
  }
  TriggerWish wish{.channel = fmt::format("{}", fmt::join(words.begin(), kind, " ")),
                   .kind = *KindOf(*kind),
                   .threshold = fmt::format("{}", fmt::join(kind + 1, words.end(), " "))};
  if (auto sound = CheckQuantity(wish.threshold); !sound) return std::unexpected(sound.error());
  return wish;
}

Result<acquire::TriggerSetup> ResolveTrigger(const TriggerWish& wish,
                                             const trial::TrialHeader& header) {
  // which channel
  const auto displacement = trial::DisplacementChannel(header);
  std::size_t number = displacement.value_or(0);
  if (!wish.channel.empty()) {
    const auto found =
        std::ranges::find(header.channels, wish.channel, &trial::ChannelFormat::name);
    if (found == header.channels.end()) {
      std::vector<std::string> names;
      names.reserve(header.channels.size());
      for (const trial::ChannelFormat& channel : header.channels) names.push_back(channel.name);
      return Usage(std::string(kOption), fmt::format("there is no channel '{}'", wish.channel),
                   fmt::format("the sensor has {}", fmt::join(names, ", ")));
    }
    number = static_cast<std::size_t>(found - header.channels.begin());
  }

  // how high, in its unit
  const trial::ChannelFormat& channel = header.channels[number];
  const auto threshold = ParseQuantity(wish.threshold, DimensionOf(channel.unit), kOption);
  if (!threshold) return std::unexpected(threshold.error());
  acquire::TriggerSetup setup;
  setup.channel = number;
  setup.kind = wish.kind;
  setup.threshold = threshold->value;
  if (displacement == number) setup.threshold += header.metadata.tare_m;
  return setup;
}

}  // namespace haptometer::tools
