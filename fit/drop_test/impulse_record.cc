#include "fit/drop_test/impulse_record.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <numbers>
#include <string_view>
#include <unordered_set>

#include "base/text.h"

namespace haptometer::fit {
namespace {

// `key` of the header: an SI number, or a text with its unit
Result<std::optional<Quantity>> Field(const trial::Record& record, const std::string& name,
                                      const std::string& key, Dimension dimension) {
  const auto found = record.metadata.fields.find(key);
  if (found == record.metadata.fields.end()) return std::optional<Quantity>{};
  const std::string where = name + ": " + key;
  // a number alone is SI, because the key carries its unit
  std::string text = found->second;
  const bool is_bare = !text.empty() && std::string_view("0123456789.)").contains(text.back());
  if (is_bare) text += SiUnit(dimension);
  const auto quantity = ParseQuantity(text, dimension, where);
  if (quantity) return *quantity;
  return CannotAnswer(where, quantity.error().what, quantity.error().remedy);
}

Result<std::optional<CaseCondition>> Condition(const trial::Record& record,
                                               const std::string& name) {
  const auto found = record.metadata.fields.find("case");
  if (found == record.metadata.fields.end()) return std::optional<CaseCondition>{};
  if (found->second == "held") return CaseCondition::kHeld;
  if (found->second == "free") return CaseCondition::kFree;
  return CannotAnswer(name + ": case", fmt::format("'{}' is not known", found->second),
                      "write held or free");
}

// reads one key after another and keeps the first error
class HeaderReader {
 public:
  HeaderReader(const trial::Record& record, const std::string& name)
      : record_(record), name_(name) {}

  std::optional<Quantity> Read(const std::string& key, Dimension dimension, double least,
                               double most) {
    auto field = Field(record_, name_, key, dimension);
    if (!field) {
      Keep(field.error());
      return {};
    }
    if (*field && !((*field)->value >= least && (*field)->value <= most)) {
      Keep(CannotAnswer(name_ + ": " + key, fmt::format("{} is out of range", (*field)->value),
                        least > 0 ? "it must be positive"
                                  : fmt::format("it lies from {} to {}", least, most))
               .error());
      return {};
    }
    return *field;
  }

  void Keep(const Error& error) {
    if (!error_) error_ = error;
  }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

 private:
  const trial::Record& record_;
  const std::string& name_;
  std::optional<Error> error_;
};

// Of unknown keys, those that are written like the known ones and are near one of them: headers of
// other programs contain many further keys.
Findings MistypedKeys(const trial::Record& record, const std::string& name) {
  static const std::vector<std::string> kKnown{
      "case",           "load_ohm",     "drop_height_m",     "rebound",
      "voltage_scale",  "time_scale",   "moving_mass_kg",    "case_mass_kg",
      "resistance_ohm", "inductance_h", "release_current_a", "added_mass_kg"};
  Findings findings;
  for (const auto& [key, value] : record.metadata.fields) {
    // written alike: an underscore, no space and no capital letter
    const bool looks_alike = key.contains('_') && std::ranges::none_of(key, [](char c) {
                               return c == ' ' || std::isupper(static_cast<unsigned char>(c));
                             });
    if (!looks_alike || std::ranges::find(kKnown, key) != kKnown.end()) continue;
    const std::string nearest = Nearest(key, kKnown);
    if (nearest.empty()) continue;
    findings.Add(About(name, Severity::kNote, FindingKind::kHeaderKeyUnknown,
                       {{"key", key}, {"nearest", nearest}}));
  }
  return findings;
}

// a voltage or displacement by role, or the only channel where no role states what it measures
Result<const trial::Channel*> FindSignal(const trial::Record& record, const std::string& name) {
  for (const auto role : {trial::ChannelRole::kVoltage, trial::ChannelRole::kDisplacement}) {
    std::vector<std::string> names;
    for (const auto& channel : record.channels) {
      if (channel.role == role) names.push_back(channel.name);
    }
    const bool is_voltage = role == trial::ChannelRole::kVoltage;
    if (names.size() > 1) {
      return CannotAnswer(
          name,
          fmt::format("has several {}: {}", is_voltage ? "voltages" : "displacements",
                      fmt::join(names, ", ")),
          fmt::format("name the channel that is {}", is_voltage ? "the coil's" : "the actuator's"));
    }
    if (names.size() == 1) return record.Find(role);
  }
  if (record.channels.size() == 1 && record.channels[0].role == trial::ChannelRole::kOther) {
    return record.channels.data();
  }
  return CannotAnswer(name, "has no voltage", "give a CSV with the columns time_s,voltage_v");
}

}  // namespace

std::string_view Name(CaseCondition condition) {
  return condition == CaseCondition::kHeld ? "held" : "free";
}

std::optional<Quantity> TimeScaleOf(const trial::Stretch& stretch) {
  constexpr double kLeast = 1e-7;
  const double share = std::numbers::sqrt2 * stretch.time_uncertainty_s * stretch.rate_hz /
                       static_cast<double>(stretch.rows);
  if (!(share >= kLeast)) return std::nullopt;
  return Quantity{1, share};
}

Result<ImpulseFile> ImpulseFromRecord(const trial::Record& record, const std::string& name) {
  HAPTOMETER_LET(const auto found, FindSignal(record, name));
  const trial::Channel& signal = *found;
  // one segment on the source's own clock, because the fit needs a uniform grid
  if (record.stretches.size() != 1 ||
      (record.timing != trial::Timing::kUniform && record.stretches[0].time_uncertainty_s > 0)) {
    return CannotAnswer(name, "has gaps or a non-uniform time base",
                        "export the whole oscilloscope record at its own sample interval");
  }
  ImpulseFile file;
  file.record.name = name;
  file.record.start_s = record.stretches[0].start_s;
  file.record.step_s = 1 / record.stretches[0].rate_hz;
  file.record.voltage_v = signal.values;
  // samples whose status is no measurement are missing
  for (std::size_t n = 0; n < signal.statuses.size(); ++n) {
    if (!trial::IsMeasurement(signal.statuses[n])) file.record.voltage_v[n] = std::nan("");
  }
  if (signal.role == trial::ChannelRole::kDisplacement) {
    file.record.signal = RecordedSignal::kDisplacement;
    file.record.unit = "m";
  }

  // finite positive numbers; a load may be infinite, which is an open circuit
  constexpr double kLargest = 1e300;
  constexpr double kSmallest = 1e-300;
  HeaderReader header(record, name);
  const double open = std::numeric_limits<double>::infinity();
  file.record.load_ohm = header.Read("load_ohm", Dimension::kResistance, kSmallest, open);
  file.record.drop_height_m = header.Read("drop_height_m", Dimension::kLength, kSmallest, kLargest);
  file.record.rebound = header.Read("rebound", Dimension::kNone, 0, 1);
  file.record.release_current_a =
      header.Read("release_current_a", Dimension::kCurrent, kSmallest, kLargest);
  file.record.added_mass_kg = header.Read("added_mass_kg", Dimension::kMass, kSmallest, kLargest);
  file.record.voltage_scale = header.Read("voltage_scale", Dimension::kNone, kSmallest, kLargest);
  file.record.time_scale = header.Read("time_scale", Dimension::kNone, kSmallest, kLargest);
  if (!file.record.time_scale) file.record.time_scale = TimeScaleOf(record.stretches[0]);
  file.knowns.moving_mass_kg = header.Read("moving_mass_kg", Dimension::kMass, kSmallest, kLargest);
  file.knowns.case_mass_kg = header.Read("case_mass_kg", Dimension::kMass, kSmallest, kLargest);
  file.knowns.resistance_ohm =
      header.Read("resistance_ohm", Dimension::kResistance, kSmallest, kLargest);
  file.knowns.inductance_h = header.Read("inductance_h", Dimension::kInductance, 0, kLargest);
  auto condition = Condition(record, name);
  if (condition) {
    file.record.condition = *condition;
  } else {
    header.Keep(condition.error());
  }
  if (header.error()) return std::unexpected(*header.error());
  file.findings = MistypedKeys(record, name);
  return file;
}

namespace {

constexpr std::size_t kMostCodes = 4096;
constexpr double kCodeTolerance = 0.1;  // of a step: printed decimals round
constexpr double kFewSamples = 2;

// The finite values in rising order, each once. Of a converter with few codes no copy of the many
// samples is sorted.
std::vector<double> DistinctValues(const std::vector<double>& values) {
  const auto is_finite = [](double v) { return std::isfinite(v); };
  std::unordered_set<double> codes;
  for (auto v = values.begin(); v != values.end() && codes.size() <= kMostCodes; ++v) {
    if (is_finite(*v)) codes.insert(*v);
  }
  std::vector<double> distinct(codes.begin(), codes.end());
  // more than a converter has: all samples
  if (codes.size() > kMostCodes) {
    distinct.clear();
    distinct.reserve(values.size());
    std::ranges::copy_if(values, std::back_inserter(distinct), is_finite);
  }
  std::ranges::sort(distinct);
  distinct.erase(std::ranges::unique(distinct).begin(), distinct.end());
  return distinct;
}

// the most samples at `extreme` within half a period, and in all
struct AtExtreme {
  std::size_t most_together = 0;
  std::size_t all = 0;
};

AtExtreme CountAt(const std::vector<double>& values, double extreme, double period_samples) {
  const auto half = static_cast<std::size_t>(std::max(period_samples / 2, 1.0));
  AtExtreme count;
  std::size_t together = 0;
  for (std::size_t n = 0; n < values.size(); ++n) {
    // sliding count over half a period
    const bool leaves = n >= half && values[n - half] == extreme;
    together += (values[n] == extreme ? 1U : 0U);
    together -= leaves ? 1U : 0U;
    count.all += values[n] == extreme ? 1U : 0U;
    count.most_together = std::max(count.most_together, together);
  }
  return count;
}

// of all values' differences; 0 where they are no multiples of one, or are too many
double StepBetween(const std::vector<double>& distinct) {
  if (distinct.size() < 2 || distinct.size() > kMostCodes) return 0;
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < distinct.size(); ++k) {
    step = std::min(step, distinct[k] - distinct[k - 1]);
  }
  // values lie on a grid if all differences are multiples of the least, up to printed decimals
  for (std::size_t k = 1; k < distinct.size(); ++k) {
    const double steps = (distinct[k] - distinct[k - 1]) / step;
    if (std::abs(steps - std::round(steps)) > kCodeTolerance) return 0;
  }
  return step;
}

}  // namespace

double ConverterStep(const std::vector<double>& values_v) {
  return StepBetween(DistinctValues(values_v));
}

std::size_t MaskRails(std::vector<double>& values_v, double period_samples) {
  const auto distinct = DistinctValues(values_v);
  if (distinct.size() < 3) return 0;
  const double step = StepBetween(distinct);
  // middle of the codes that occur
  const double rest = distinct[distinct.size() / 2];
  std::size_t masked = 0;
  for (const double extreme : {distinct.front(), distinct.back()}) {
    const auto count = CountAt(values_v, extreme, period_samples);
    const double amplitude = std::abs(extreme - rest);
    const double share = std::min(step / std::max(amplitude, step), 1.0);
    // periods that a sine of amplitude A stays within a step of its peak: acos(1 - step/A)/pi
    const double natural =
        step > 0 ? std::acos(1 - share) * period_samples / std::numbers::pi : 0.0;
    // a rail: more samples together than that, or repeated extremes of values without steps
    const bool together = static_cast<double>(count.most_together) > natural + kFewSamples;
    const bool unrounded = step == 0 && static_cast<double>(count.all) > kFewSamples;
    if (!together && !unrounded) continue;
    masked += count.all;
    std::ranges::replace(values_v, extreme, std::nan(""));
  }
  return masked;
}

}  // namespace haptometer::fit
