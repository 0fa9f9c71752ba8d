#include "trial/trial_format.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/names.h"
#include "base/text.h"

namespace haptometer::trial {
namespace {

constexpr Names<Encoding, 3> kEncodingNames{{"i32", "f32", "f64"}};
constexpr Names<Timing, 3> kTimingNames{{"uniform", "arrival", "polled"}};
constexpr Names<EventKind, kEventKindCount> kEventNames{
    {"gap", "reconnect", "remark", "labels", "time_base", "excluded", "included"}};

}  // namespace

std::string_view Name(Encoding encoding) { return kEncodingNames.Of(encoding); }
std::string_view Name(Timing timing) { return kTimingNames.Of(timing); }
std::string_view Name(EventKind kind) { return kEventNames.Of(kind); }

std::size_t BytesOf(Encoding encoding) { return encoding == Encoding::kF64 ? 8 : 4; }

Channel ChannelOf(const ChannelFormat& format) {
  return {.name = format.name,
          .role = format.role,
          .unit = format.unit,
          .range_min = format.range_min,
          .range_max = format.range_max,
          .resolution = format.resolution};
}

ChannelFormat DisplacementCounts(std::string name, double step_m) {
  return {.name = std::move(name),
          .role = ChannelRole::kDisplacement,
          .unit = "m",
          .encoding = Encoding::kI32,
          .scale = step_m,
          .resolution = step_m};
}

// rate_hz is that of the longest segment
TrialHeader HeaderOf(const Record& record) {
  TrialHeader header{.timing = record.timing, .metadata = record.metadata};
  if (!record.stretches.empty()) {
    header.rate_hz = std::ranges::max_element(record.stretches, {}, &Stretch::rows)->rate_hz;
  }
  for (const Channel& channel : record.channels) {
    header.channels.push_back({.name = channel.name,
                               .role = channel.role,
                               .unit = channel.unit,
                               .range_min = channel.range_min,
                               .range_max = channel.range_max,
                               .resolution = channel.resolution});
  }
  return header;
}

namespace {

using Json = nlohmann::ordered_json;

// JSON on one line; bytes that are no UTF-8 are replaced, so that writing cannot fail
std::string Dumped(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// unknown, unbounded and infinite are null
Json NumberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

// unknown is null
template <typename T>
Json ValueOrNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

// the value under `key`, or `otherwise` where it is absent or null; a wrong type throws
template <typename T>
T Get(const Json& json, const char* key, T otherwise) {
  const auto found = json.find(key);
  if (found == json.end() || found->is_null()) return otherwise;
  return found->get<T>();
}

template <typename T>
std::optional<T> GetOptional(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end() || found->is_null()) return std::nullopt;
  return found->get<T>();
}

// The texts of a file are made printable here, because any program may have written them: the code
// behind this place meets no control character.
std::string Text(const Json& json, const char* key) {
  return Printable(Get<std::string>(json, key, ""));
}

std::map<std::string, std::string> Texts(const Json& json, const char* key) {
  std::map<std::string, std::string> texts;
  for (const auto& [name, text] : Get<std::map<std::string, std::string>>(json, key, {})) {
    texts[Printable(name)] = Printable(text);
  }
  return texts;
}

std::vector<std::string> TextList(const Json& json, const char* key) {
  auto texts = Get<std::vector<std::string>>(json, key, {});
  for (std::string& text : texts) text = Printable(text);
  return texts;
}

// the enumerator among the first `count` whose Name() is the text under `key`
template <typename Enum>
std::optional<Enum> GetEnum(const Json& json, const char* key, std::size_t count) {
  const auto name = Text(json, key);
  for (std::size_t i = 0; i < count; ++i) {
    if (Name(static_cast<Enum>(i)) == name) return static_cast<Enum>(i);
  }
  return std::nullopt;
}

// the keys are those of docs/reference/formats.md
Json ToJson(const ChannelFormat& channel) {
  return {{"name", channel.name},
          {"role", Name(channel.role)},
          {"unit", channel.unit},
          {"encoding", Name(channel.encoding)},
          {"scale", channel.scale},
          {"offset", channel.offset},
          {"range_min", NumberOrNull(channel.range_min)},
          {"range_max", NumberOrNull(channel.range_max)},
          {"resolution", channel.resolution}};
}

// nothing where role or encoding is unknown, or where scale or offset is no finite number
std::optional<ChannelFormat> ChannelFrom(const Json& json) {
  ChannelFormat channel;
  const auto role = GetEnum<ChannelRole>(json, "role", 5);
  const auto encoding = GetEnum<Encoding>(json, "encoding", 3);
  if (!role || !encoding) return std::nullopt;
  channel.role = *role;
  channel.encoding = *encoding;
  channel.name = Text(json, "name");
  channel.unit = Text(json, "unit");
  channel.scale = Get(json, "scale", 1.0);
  channel.offset = Get(json, "offset", 0.0);
  // absent or null: unbounded
  channel.range_min = Get(json, "range_min", channel.range_min);
  channel.range_max = Get(json, "range_max", channel.range_max);
  channel.resolution = Get(json, "resolution", 0.0);
  // an infinite scale would make all values infinite or NaN
  if (!std::isfinite(channel.scale) || !std::isfinite(channel.offset)) return std::nullopt;
  return channel;
}

void AddMetadata(const Metadata& metadata, Json* json) {
  json->update({{"source", metadata.source},
                {"sensor", metadata.sensor},
                {"head", metadata.head},
                {"sampling_s", ValueOrNull(metadata.sampling_s)},
                {"averages", ValueOrNull(metadata.averages)},
                {"hold", metadata.hold},
                {"nominal_rate_hz", ValueOrNull(metadata.nominal_rate_hz)},
                {"laser_spot", metadata.laser_spot},
                {"drive_frequency_hz", ValueOrNull(metadata.drive_frequency_hz)},
                {"drive_amplitude_v", ValueOrNull(metadata.drive_amplitude_v)},
                {"tare_m", NumberOrNull(metadata.tare_m)},
                {"utc_start", metadata.utc_start},
                {"host", metadata.host},
                {"command_line", metadata.command_line},
                {"labels", metadata.labels},
                {"fields", metadata.fields},
                {"notes", metadata.notes}});
}

Metadata MetadataFrom(const Json& json) {
  return {.source = Text(json, "source"),
          .sensor = Text(json, "sensor"),
          .head = Text(json, "head"),
          .sampling_s = GetOptional<double>(json, "sampling_s"),
          .averages = GetOptional<int>(json, "averages"),
          .hold = Text(json, "hold"),
          .nominal_rate_hz = GetOptional<double>(json, "nominal_rate_hz"),
          .laser_spot = Text(json, "laser_spot"),
          .drive_frequency_hz = GetOptional<double>(json, "drive_frequency_hz"),
          .drive_amplitude_v = GetOptional<double>(json, "drive_amplitude_v"),
          .tare_m = Get(json, "tare_m", 0.0),
          .utc_start = Text(json, "utc_start"),
          .host = Text(json, "host"),
          .command_line = Text(json, "command_line"),
          .labels = Texts(json, "labels"),
          .fields = Texts(json, "fields"),
          .notes = TextList(json, "notes")};
}

// nothing where a value is unusable; absent channels or a wrong type throw
std::optional<TrialHeader> HeaderFrom(const Json& json) {
  TrialHeader header;
  const auto timing = GetEnum<Timing>(json, "timing", 3);
  if (!timing) return std::nullopt;
  header.timing = *timing;
  header.rate_hz = Get(json, "rate_hz", 0.0);
  // a grid needs a rate; the other timings have a time in each row
  const bool rate_is_usable = std::isfinite(header.rate_hz) && header.rate_hz > 0;
  if (header.timing == Timing::kUniform && !rate_is_usable) return std::nullopt;
  for (const Json& channel_json : json.at("channels")) {
    const auto channel = ChannelFrom(channel_json);
    if (!channel) return std::nullopt;
    header.channels.push_back(*channel);
  }
  // the limit guards against a damaged or hostile file
  if (header.channels.empty() || header.channels.size() > kMaxChannels) return std::nullopt;
  header.metadata = MetadataFrom(json);
  return header;
}

// keys and values; `what` is one of them
Result<void> CheckTexts(const std::string& what, const std::map<std::string, std::string>& texts) {
  for (const auto& [key, value] : texts) {
    HAPTOMETER_TRY(CheckPrintable("the name of a " + what, key));
    HAPTOMETER_TRY(CheckPrintable(fmt::format("{} {}", what, key), value));
  }
  return {};
}

// an infinite rate (all rows at one time) is null
Json ToJson(const Stretch& stretch) {
  return {{"first_row", stretch.first_row},
          {"rows", stretch.rows},
          {"start_s", stretch.start_s},
          {"rate_hz", NumberOrNull(stretch.rate_hz)},
          {"time_uncertainty_s", stretch.time_uncertainty_s}};
}

Stretch StretchFrom(const Json& json) {
  return {.first_row = json.at("first_row").get<std::size_t>(),
          .rows = json.at("rows").get<std::size_t>(),
          .start_s = json.at("start_s").get<double>(),
          .rate_hz = Get(json, "rate_hz", std::numeric_limits<double>::infinity()),
          .time_uncertainty_s = Get(json, "time_uncertainty_s", 0.0)};
}

Event EventFrom(const Json& json) {
  Event event;
  event.row = Get<std::uint64_t>(json, "row", 0);
  event.time_ns = GetOptional<std::int64_t>(json, "time_ns");
  event.utc = Text(json, "utc");
  event.text = Text(json, "text");
  event.labels = Texts(json, "labels");
  if (json.contains("stretch")) event.stretch = StretchFrom(json.at("stretch"));
  // an absent `missing` is no loss; a null one is a loss of unknown size
  if (json.contains("missing")) event.missing = GetOptional<std::uint64_t>(json, "missing");
  const auto kind = GetEnum<EventKind>(json, "event", kEventKindCount);
  if (kind) {
    event.kind = *kind;
  } else {
    // an event of a later version becomes a remark that names its kind
    event.text = Printable(json.at("event").get<std::string>()) + ": " + event.text;
  }
  return event;
}

}  // namespace

// refuses texts that are not printable before they are in a file
Result<void> CheckTexts(const TrialHeader& header) {
  for (std::size_t i = 0; i < header.channels.size(); ++i) {
    const std::string channel = "channel " + std::to_string(i + 1);
    HAPTOMETER_TRY(CheckPrintable("the name of " + channel, header.channels[i].name));
    HAPTOMETER_TRY(CheckPrintable("the unit of " + channel, header.channels[i].unit));
  }
  const Metadata& metadata = header.metadata;
  for (const auto& [key, member] : kMetadataTexts) {
    HAPTOMETER_TRY(CheckPrintable(std::string(key), metadata.*member));
  }
  for (const std::string& note : metadata.notes) HAPTOMETER_TRY(CheckPrintable("a note", note));
  HAPTOMETER_TRY(CheckTexts("field", metadata.fields));
  return CheckTexts("label", metadata.labels);
}

Result<void> CheckTexts(const Event& event) {
  HAPTOMETER_TRY(CheckPrintable("the text of an event", event.text));
  return CheckTexts("label", event.labels);
}

std::string HeaderToJson(const TrialHeader& header) {
  Json json{{"format", "haptometer trial"},
            {"timing", Name(header.timing)},
            // only a grid has a rate of its own
            {"rate_hz", header.timing == Timing::kUniform ? Json(header.rate_hz) : Json(nullptr)},
            {"channels", Json::array()}};
  for (const ChannelFormat& channel : header.channels) json["channels"].push_back(ToJson(channel));
  AddMetadata(header.metadata, &json);
  return Dumped(json);
}

// any error in the text, including a wrong type, gives nothing
std::optional<TrialHeader> HeaderFromJson(std::string_view json) {
  try {
    return HeaderFrom(Json::parse(json));
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

std::string EventToJson(const Event& event) {
  Json json{
      {"event", Name(event.kind)}, {"row", event.row}, {"time_ns", ValueOrNull(event.time_ns)}};
  if (!event.utc.empty()) json["utc"] = Printable(event.utc);
  if (!event.text.empty()) json["text"] = Printable(event.text);
  if (event.kind == EventKind::kLabels) json["labels"] = event.labels;
  if (event.stretch) json["stretch"] = ToJson(*event.stretch);
  if (event.missing) json["missing"] = ValueOrNull(*event.missing);
  return Dumped(json);
}

std::optional<Event> EventFromJson(std::string_view json) {
  try {
    return EventFrom(Json::parse(json));
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

std::string TotalsToJson(const TrialTotals& totals) {
  Json statuses = Json::object();
  // number of samples by status, over all channels
  for (std::size_t i = 0; i < kSampleStatusCount; ++i) {
    statuses[std::string(Name(static_cast<SampleStatus>(i)))] = totals.statuses[i];
  }
  return Dumped({{"rows", totals.rows}, {"statuses", statuses}});
}

}  // namespace haptometer::trial
