#include "trial/calibration.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string_view>
#include <utility>

#include "base/quantity.h"
#include "base/text.h"
#include "base/toml.h"

namespace haptometer::trial {
namespace {

// a unit as it stands in keys: scale_m_per_v
struct KeyUnit {
  std::string_view letter;
  std::string_view quantity;  // displacement_m
  Dimension dimension = Dimension::kNone;
};

constexpr KeyUnit kMetre{"m", "displacement", Dimension::kLength};
constexpr KeyUnit kVolt{"v", "voltage", Dimension::kVoltage};
constexpr KeyUnit kAmpere{"a", "current", Dimension::kCurrent};

// the unit in which a channel of this role is calibrated; nullptr where it has none
const KeyUnit* UnitOf(ChannelRole role) {
  switch (role) {
    case ChannelRole::kDisplacement:
      return &kMetre;
    case ChannelRole::kVoltage:
      return &kVolt;
    case ChannelRole::kCurrent:
      return &kAmpere;
    case ChannelRole::kTrigger:
    case ChannelRole::kOther:
      return nullptr;
  }
  return nullptr;
}

// key of a channel's table, and end of the field that keeps it
constexpr std::string_view kRelativeUncertainty = "relative_standard_uncertainty";

std::string UncertaintyField(const std::string& channel) {
  return fmt::format("calibration.{}.{}", channel, kRelativeUncertainty);
}

// "least" or "most" of the calibrated range
std::string RangeField(const std::string& channel, std::string_view end) {
  return fmt::format("calibration.{}.calibrated_{}", channel, end);
}

// one pair of input and value: { voltage_v = -5, displacement_m = "-5mm" }
struct Point {
  double input = 0;
  double value = 0;
};

// keys are named after quantities: input voltage_v, value displacement_m
std::optional<Point> ReadPoint(TomlTable& table, std::string_view key, const KeyUnit& in,
                               const KeyUnit& out) {
  TomlTable* point = table.Table(key);
  if (point == nullptr) return std::nullopt;
  const std::string value_key = fmt::format("{}_{}", out.quantity, out.letter);
  // input and value of one unit need different keys
  const std::string input_key = in.letter == out.letter
                                    ? fmt::format("input_{}", in.letter)
                                    : fmt::format("{}_{}", in.quantity, in.letter);
  return Point{.input = point->Require(input_key, in.dimension),
               .value = point->Require(value_key, out.dimension)};
}

// the line through two points, or as it is stated
void ReadLine(TomlTable& table, const KeyUnit& in, const KeyUnit& out,
              ChannelCalibration* calibration) {
  const std::string scale_key = fmt::format("scale_{}_per_{}", out.letter, in.letter);
  const std::string offset_key = fmt::format("offset_{}", out.letter);
  const auto scale = table.Number(scale_key, Dimension::kNone);
  const auto offset = table.Number(offset_key, out.dimension);
  const auto first = ReadPoint(table, "first", in, out);
  const auto second = ReadPoint(table, "second", in, out);
  if (first && second) {
    if (scale || offset) {
      table.Refuse(scale ? scale_key : offset_key, "is given twice",
                   "give the two points, or scale and offset");
    }
    // scale = (y2 - y1) / (x2 - x1), offset = y1 - scale * x1
    calibration->scale = (second->value - first->value) / (second->input - first->input);
    calibration->offset = first->value - calibration->scale * first->input;
    if (!std::isfinite(calibration->scale) || calibration->scale == 0) {
      table.Refuse("second", "does not differ from the first point in both numbers",
                   "give two points that lie apart");
    }
    return;
  }
  if (first || second) {
    table.Refuse(first ? "second" : "first", "is missing", "a line needs two points");
  }
  // what is measured in its own unit needs no slope
  if (!scale && in.letter != out.letter) {
    table.Refuse(scale_key, "is missing", "give it, or two points first and second");
  }
  calibration->scale = scale.value_or(1);
  calibration->offset = offset.value_or(0);
  if (calibration->scale == 0) table.Refuse(scale_key, "must not be 0", "check it");
}

// limits in the input unit; absent: infinite
void ReadLimits(TomlTable& table, const KeyUnit& in, RawLimits* limits) {
  const auto read = [&](std::string_view name, double* limit) {
    *limit = table.Number(fmt::format("{}_{}", name, in.letter), in.dimension).value_or(*limit);
  };
  read("bad_below", &limits->bad_below);
  read("bad_above", &limits->bad_above);
  read("daq_min", &limits->rail_min);
  read("daq_max", &limits->rail_max);
  if (!(limits->bad_below < limits->bad_above)) {
    table.Refuse(fmt::format("bad_below_{}", in.letter), "is not below bad_above");
  }
  if (!(limits->rail_min < limits->rail_max)) {
    table.Refuse(fmt::format("daq_min_{}", in.letter), "is not below daq_max");
  }
}

// counts of a converter: input = count * input_per_count + input_at_zero_count
void ReadCounts(TomlTable& table, const KeyUnit& in, ChannelCalibration* calibration) {
  const std::string per_count = fmt::format("{}_per_count", in.letter);
  calibration->input_per_count = table.Number(per_count, in.dimension);
  calibration->input_at_zero_count =
      table.Number(fmt::format("{}_at_zero_count", in.letter), in.dimension).value_or(0);
  if (calibration->input_per_count && !(*calibration->input_per_count > 0)) {
    table.Refuse(per_count, "must be greater than 0", "a falling line has a negative scale");
  }
}

// how the line was found: uncertainties, linearity, range
void ReadEvidence(TomlTable& table, const KeyUnit& in, const KeyUnit& out,
                  ChannelCalibration* calibration) {
  const auto read = [&](const std::string& key, Dimension dimension) {
    const auto number = table.Number(key, dimension);
    if (number) calibration->stated[key] = *number;
    return number;
  };
  const auto read_size = [&](const std::string& key, Dimension dimension) {
    const auto number = read(key, dimension);
    if (number && !(*number >= 0)) table.Refuse(key, "is below 0");
    return number;
  };
  calibration->scale_uncertainty = read_size(
      fmt::format("scale_standard_uncertainty_{}_per_{}", out.letter, in.letter), Dimension::kNone);
  calibration->offset_uncertainty =
      read_size(fmt::format("offset_standard_uncertainty_{}", out.letter), out.dimension);
  // |cov(a, b)| <= u(a) u(b), but for rounding
  const std::string covariance =
      fmt::format("scale_offset_covariance_{}2_per_{}", out.letter, in.letter);
  calibration->covariance = read(covariance, Dimension::kNone).value_or(0);
  if (std::abs(calibration->covariance) > 1.0001 * calibration->scale_uncertainty.value_or(0) *
                                              calibration->offset_uncertainty.value_or(0)) {
    table.Refuse(covariance, "is more than the product of both standard uncertainties");
  }
  if (const auto degrees = read("degrees_of_freedom", Dimension::kNone)) {
    if (!(*degrees >= 1 && *degrees <= 1e6)) table.Refuse("degrees_of_freedom", "is not 1 to 1e6");
    calibration->degrees_of_freedom = static_cast<int>(std::clamp(*degrees, 1.0, 1e6));
  }
  read_size(fmt::format("nonlinearity_{}", out.letter), out.dimension);
  read(fmt::format("hysteresis_{}", out.letter), out.dimension);
  const std::string range_min = fmt::format("calibrated_min_{}", in.letter);
  calibration->calibrated_min = read(range_min, in.dimension);
  calibration->calibrated_max = read(fmt::format("calibrated_max_{}", in.letter), in.dimension);
  if (calibration->calibrated_min && calibration->calibrated_max &&
      !(*calibration->calibrated_min < *calibration->calibrated_max)) {
    table.Refuse(range_min, "is not below calibrated_max");
  }
}

Averaging ReadAveraging(TomlTable& table) {
  constexpr long long kMostAverages = 1'000'000;
  Averaging averaging;
  averaging.sampling_s = table.Number("sampling_s", Dimension::kTime);
  if (averaging.sampling_s && !(*averaging.sampling_s > 0)) {
    table.Refuse("sampling_s", "is not above 0");
  }
  const auto averages = table.Integer("averages");
  if (!averages) return averaging;
  if (*averages < 1 || *averages > kMostAverages) table.Refuse("averages", "is not 1 to 1e6");
  averaging.averages = static_cast<int>(std::clamp(*averages, 1LL, kMostAverages));
  // a mean of several has a gain only with the period of what it averages
  if (*averages > 1 && !averaging.sampling_s) {
    table.Refuse("sampling_s", "is missing", "state the period of the samples that are averaged");
  }
  return averaging;
}

ChannelCalibration ReadChannel(TomlTable& table, ChannelRole role) {
  ChannelCalibration calibration;
  const KeyUnit* out = UnitOf(role);
  if (out == nullptr) {
    // every key of it is refused with this one
    table.Refuse("role", fmt::format("a channel of role {} has no unit", Name(role)),
                 "calibrate displacement, voltage and current channels");
    return calibration;
  }
  // the DAQ measures volts unless the file states a current
  const auto input = table.Choice("input", {"voltage", "current"});
  const KeyUnit& in = input == "current" ? kAmpere : kVolt;
  calibration.input_unit = input == "current" ? "A" : "V";
  ReadLine(table, in, *out, &calibration);
  ReadLimits(table, in, &calibration.limits);
  ReadCounts(table, in, &calibration);
  ReadEvidence(table, in, *out, &calibration);
  const std::string relative(kRelativeUncertainty);
  calibration.gain_uncertainty = table.Number(relative, Dimension::kNone);
  if (calibration.gain_uncertainty && !(*calibration.gain_uncertainty > 0 &&
                                        *calibration.gain_uncertainty <= kLargestGainUncertainty)) {
    table.Refuse(relative, "is not above 0 and at most 0.2");
  }
  calibration.range_min = table.Number(fmt::format("range_min_{}", out->letter), out->dimension);
  calibration.range_max = table.Number(fmt::format("range_max_{}", out->letter), out->dimension);
  if (calibration.range_min && calibration.range_max &&
      !(*calibration.range_min < *calibration.range_max)) {
    table.Refuse(fmt::format("range_min_{}", out->letter), "is not below range_max");
  }
  return calibration;
}

// why a file calibrates none of the channels: an actuator's, or one of another channel
Result<void> CheckKind(const TomlTable& table, const std::string& names) {
  if (table.Has("moving_mass_kg")) {
    return Usage(table.where(), "is an actuator, and no calibration",
                 "give it in a scene, or as the actuator of a fit");
  }
  for (const ChannelRole role :
       {ChannelRole::kDisplacement, ChannelRole::kVoltage, ChannelRole::kCurrent}) {
    if (!table.Has(Name(role))) continue;
    return Usage(table.where(),
                 fmt::format("calibrates {}, which is none of the channels {}", Name(role), names),
                 fmt::format("call the channel that it is for {}", Name(role)));
  }
  return {};
}

// only tables of the channels are read; Finish refuses all other keys
Result<Calibration> ReadCalibration(TomlTable table, std::span<const ChannelFormat> channels) {
  Calibration calibration;
  calibration.name = table.Text("name").value_or("");
  calibration.date = table.Text("date").value_or("");
  calibration.notes = table.Text("notes").value_or("");
  calibration.averaging = ReadAveraging(table);
  calibration.provenance = table.Texts("provenance");
  std::string names;
  for (const ChannelFormat& channel : channels) {
    names += (names.empty() ? "" : ", ") + channel.name;
    TomlTable* of_channel = table.Table(channel.name);
    if (of_channel == nullptr) continue;
    calibration.channels[channel.name] = ReadChannel(*of_channel, channel.role);
  }
  if (calibration.channels.empty()) HAPTOMETER_TRY(CheckKind(table, names));
  HAPTOMETER_TRY(table.Finish());
  if (calibration.channels.empty()) {
    return Usage(table.where(), "calibrates none of the channels " + names,
                 "give it a table [displacement]");
  }
  // a calibration without a name has that of its file
  if (calibration.name.empty()) calibration.name = table.where();
  return calibration;
}

// "; DAQ -10 to 10 V", with infinite bounds omitted
std::string Bounds(std::string_view what, double low, double high, std::string_view unit) {
  if (std::isinf(low) && std::isinf(high)) return {};
  if (std::isinf(low)) return fmt::format("; {} up to {} {}", what, high, unit);
  if (std::isinf(high)) return fmt::format("; {} from {} {}", what, low, unit);
  return fmt::format("; {} {} to {} {}", what, low, high, unit);
}

}  // namespace

SampleStatus StatusOf(const RawLimits& limits, double number) {
  if (!std::isfinite(number)) return SampleStatus::kInvalid;
  // the rail first: a clipped value may also lie beyond what the sensor puts out
  if (number <= limits.rail_min || number >= limits.rail_max) return SampleStatus::kClipped;
  if (number < limits.bad_below || number > limits.bad_above) return SampleStatus::kInvalid;
  return SampleStatus::kOk;
}

void StateAveraging(const Averaging& averaging, Metadata* metadata) {
  if (averaging.averages) metadata->averages = averaging.averages;
  if (averaging.sampling_s) metadata->sampling_s = averaging.sampling_s;
}

Result<Calibration> ReadCalibrationFile(const std::string& path,
                                        std::span<const ChannelFormat> channels) {
  HAPTOMETER_LET(auto table, TomlTable::ParseFile(path));
  return ReadCalibration(std::move(table), channels);
}

Result<Calibration> ReadCalibrationText(std::string_view text, const std::string& where,
                                        std::span<const ChannelFormat> channels) {
  HAPTOMETER_LET(auto table, TomlTable::ParseText(text, where));
  return ReadCalibration(std::move(table), channels);
}

RawLimits Calibrate(const ChannelCalibration& calibration, double input_per_raw,
                    double input_at_zero_raw, ChannelFormat* channel) {
  HAPTOMETER_CHECK(input_per_raw > 0, "input_per_raw = {}", input_per_raw);
  // value = (raw * per_raw + at_zero) * scale + offset
  channel->scale = input_per_raw * calibration.scale;
  channel->offset = input_at_zero_raw * calibration.scale + calibration.offset;

  // the ends of what can be measured, unless the sensor's own are stated
  const RawLimits& limits = calibration.limits;
  const auto value = [&](double input) { return input * calibration.scale + calibration.offset; };
  const double at_low = value(std::max(limits.rail_min, limits.bad_below));
  const double at_high = value(std::min(limits.rail_max, limits.bad_above));
  // a falling line (negative scale) exchanges the ends
  channel->range_min = calibration.range_min.value_or(std::min(at_low, at_high));
  channel->range_max = calibration.range_max.value_or(std::max(at_low, at_high));

  // limits in raw units: raw = (input - at_zero) / per_raw
  const auto raw = [&](double input) { return (input - input_at_zero_raw) / input_per_raw; };
  RawLimits raw_limits{.rail_min = raw(limits.rail_min),
                       .rail_max = raw(limits.rail_max),
                       .bad_below = raw(limits.bad_below),
                       .bad_above = raw(limits.bad_above)};
  // the highest count is one step below the rail; the resolution is one count
  if (channel->encoding == Encoding::kI32) {
    raw_limits.rail_max -= 1;
    channel->resolution = std::abs(channel->scale);
  }
  return raw_limits;
}

std::map<std::string, std::string> CalibrationFields(const Calibration& calibration) {
  std::map<std::string, std::string> fields{{"calibration", calibration.name}};
  if (!calibration.date.empty()) fields["calibration.date"] = calibration.date;
  if (!calibration.notes.empty()) fields["calibration.notes"] = calibration.notes;
  for (const auto& [key, text] : calibration.provenance) {
    fields["calibration.provenance." + key] = text;
  }
  for (const auto& [name, channel] : calibration.channels) {
    const RawLimits& limits = channel.limits;
    // one sentence per channel, so that a trial documents its own calibration
    fields["calibration." + name] = fmt::format(
        "{} = {} per {} x input + {}{}{}", name, channel.scale, channel.input_unit, channel.offset,
        Bounds("measures", limits.bad_below, limits.bad_above, channel.input_unit),
        Bounds("DAQ", limits.rail_min, limits.rail_max, channel.input_unit));
    if (channel.gain_uncertainty) {
      fields[UncertaintyField(name)] = fmt::format("{}", *channel.gain_uncertainty);
    }
    for (const auto& [key, number] : channel.stated) {
      fields[fmt::format("calibration.{}.{}", name, key)] = fmt::format("{}", number);
    }
    if (channel.calibrated_min && channel.calibrated_max) {
      const auto [least, most] =
          std::minmax({*channel.calibrated_min * channel.scale + channel.offset,
                       *channel.calibrated_max * channel.scale + channel.offset});
      fields[RangeField(name, "least")] = fmt::format("{}", least);
      fields[RangeField(name, "most")] = fmt::format("{}", most);
    }
  }
  return fields;
}

namespace {

// The channel whose volts are a sensor's: that of this name, else a voltage beside which no other
// channel can be meant. One without a unit may be volts, and the voltage the drive's.
Result<Channel*> SensorChannel(const std::string& where, Record* record) {
  constexpr const char* kRemedy =
      "call it sensor, by <columns> time_s,sensor,voltage_v or in the file's header (in mV: "
      "<columns> time_s,voltage_mv,-)";
  if (record->Find(ChannelRole::kDisplacement) != nullptr) {
    return Usage("<calibration>", where + " has a displacement already", "leave it out");
  }
  const auto named = std::ranges::find(record->channels, "sensor", &Channel::name);
  if (named != record->channels.end() && !named->unit.empty() && named->unit != "V") {
    return Usage("<calibration>", fmt::format("{} has its sensor in {}", where, named->unit),
                 "give its volts");
  }
  if (named != record->channels.end()) return &*named;
  std::vector<Channel*> possible;
  std::string names;
  for (Channel& channel : record->channels) {
    if (channel.role != ChannelRole::kVoltage && !channel.unit.empty()) continue;
    possible.push_back(&channel);
    names += (names.empty() ? "" : ", ") + channel.name;
  }
  if (possible.size() == 1 && possible[0]->role == ChannelRole::kVoltage) return possible[0];
  return Usage("<calibration>",
               possible.empty() ? where + " has no voltage that it could be of"
                                : where + " does not state which voltage it is of: " + names,
               kRemedy);
}

}  // namespace

Result<void> CalibrateRecord(const std::string& path, const std::string& where, Record* record,
                             Findings* findings) {
  ChannelFormat format{.name = "displacement", .role = ChannelRole::kDisplacement};
  HAPTOMETER_LET(const auto calibration, ReadCalibrationFile(path, {&format, 1}));
  const ChannelCalibration& line = calibration.channels.at(format.name);
  if (line.input_unit != "V") {
    return Usage(path, "is of a current", "give one of volts");
  }
  HAPTOMETER_LET(Channel* const channel, SensorChannel(where, record));
  const RawLimits limits = Calibrate(line, 1, 0, &format);
  double most_v = 0;
  for (std::size_t row = 0; row < record->rows; ++row) {
    if (!IsMeasurement(channel->statuses[row])) continue;
    double& value = channel->values[row];
    if (std::isfinite(value)) most_v = std::max(most_v, std::abs(value));
    const SampleStatus status = StatusOf(limits, value);
    if (status != SampleStatus::kOk) channel->statuses[row] = status;
    value = IsMeasurement(channel->statuses[row]) ? value * line.scale + line.offset
                                                  : std::numeric_limits<double>::quiet_NaN();
  }
  const bool has_reading = std::ranges::any_of(channel->statuses, IsMeasurement);
  if (most_v > kMostOutputV && !has_reading) {
    return CannotAnswer(
        where,
        fmt::format("reaches {:g} V, and has no reading by the calibration's limits", most_v),
        "if its column is in mV, name it by <columns> time_s,voltage_mv");
  }
  // pairs in mV give a range in them
  most_v = std::max({most_v, std::abs(line.calibrated_min.value_or(0)),
                     std::abs(line.calibrated_max.value_or(0))});
  if (most_v > kMostOutputV) findings->Doubt(FindingKind::kInputTooLarge, {{"most_v", most_v}});
  if (record->channels.size() > 1) {
    findings->Note(FindingKind::kCalibrationOf, {{"channel", channel->name}});
  }
  channel->name = format.name;
  channel->role = format.role;
  channel->unit = "m";
  channel->range_min = format.range_min;
  channel->range_max = format.range_max;
  channel->resolution *= std::abs(line.scale);
  // copied in, so that the recording explains itself
  record->metadata.fields.merge(CalibrationFields(calibration));
  Metadata& metadata = record->metadata;
  if (!metadata.averages && !metadata.sampling_s) StateAveraging(calibration.averaging, &metadata);
  return {};
}

std::optional<ValueRange> CalibratedRangeOf(const Metadata& metadata, const std::string& channel) {
  const auto least = metadata.fields.find(RangeField(channel, "least"));
  const auto most = metadata.fields.find(RangeField(channel, "most"));
  if (least == metadata.fields.end() || most == metadata.fields.end()) return std::nullopt;
  const ValueRange range{NumberFrom<double>(least->second).value_or(std::nan("")),
                         NumberFrom<double>(most->second).value_or(std::nan(""))};
  // what was edited to no range is none
  if (!(range.least < range.most)) return std::nullopt;
  return range;
}

Result<double> ParseGainUncertainty(std::string_view text, std::string_view where) {
  const bool is_percent = text.ends_with('%');
  if (is_percent) text.remove_suffix(1);
  const auto is = [](int (*kind)(int), char c) { return kind(static_cast<unsigned char>(c)) != 0; };
  // "2um": a number, and letters behind it
  if (!text.empty() && is(std::isdigit, text.front()) && is(std::isalpha, text.back())) {
    return Usage(std::string(where),
                 fmt::format("'{}' has a unit, and is a share of the gain", text),
                 "write a share, as 0.5% or 0.005");
  }
  HAPTOMETER_LET(const auto number, ParseQuantity(text, Dimension::kNone, where));
  const double relative = is_percent ? number.value / 100 : number.value;
  // a bare 0.5 is a forgotten %
  if (relative > 0 && relative <= kLargestGainUncertainty) return relative;
  return Usage(
      std::string(where),
      fmt::format("{:g} % is no relative standard uncertainty of a calibration", 100 * relative),
      fmt::format("give a share above 0 and at most {:g} %, as 0.5%",
                  100 * kLargestGainUncertainty));
}

Result<std::optional<double>> GainUncertaintyOf(const Metadata& metadata,
                                                const std::string& channel) {
  const auto stated = metadata.fields.find(UncertaintyField(channel));
  if (stated == metadata.fields.end()) return std::nullopt;
  HAPTOMETER_LET(const auto relative, ParseGainUncertainty(stated->second, stated->first));
  return relative;
}

}  // namespace haptometer::trial
