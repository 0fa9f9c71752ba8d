#include "trial/import/table/stated_clock.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "trial/import/table/table_cells.h"

namespace haptometer::trial {
namespace {

// letters and digits alone, in lower case; bytes above 0x7f are retained
std::string Bare(std::string_view text) {
  std::string bare = LowerCase(text);
  std::erase_if(bare, [](char c) {
    return !(c >= 'a' && c <= 'z') && !(c >= '0' && c <= '9') && static_cast<signed char>(c) >= 0;
  });
  return bare;
}

// "CH1:0.05" without its channel
std::string_view WithoutChannel(std::string_view value) {
  const std::size_t colon = value.find(':');
  if (colon == std::string_view::npos || !value.starts_with("CH")) return value;
  if (value.substr(2, colon - 2).find_first_not_of("0123456789") != std::string_view::npos) {
    return value;
  }
  return Trimmed(value.substr(colon + 1));
}

// the beginning of a text up to its last digit or point
std::string_view NumberIn(std::string_view text) {
  const std::size_t last = text.find_last_of("0123456789.");
  return last == std::string_view::npos ? "" : Trimmed(text.substr(0, last + 1));
}

// a number with the unit behind it, as printed: "20.0uS", "1 MSa/s"
struct Measured {
  double number = 0;
  std::string_view unit{};
};

std::optional<Measured> ReadMeasured(std::string_view text) {
  text = Trimmed(text);
  const std::string_view printed = NumberIn(text);
  const auto number = ReadNumberWithComma(printed);
  if (!number || !std::isfinite(*number)) return std::nullopt;
  return Measured{*number, Trimmed(text.substr(printed.size()))};
}

// the interval in s of a text with a unit of time, by default s
std::optional<double> IntervalOf(std::string_view text) {
  const auto measured = ReadMeasured(text);
  if (!measured) return std::nullopt;
  const auto unit = FindUnit(measured->unit.empty() ? "s" : measured->unit);
  if (!unit || unit->si_unit != "s" || !(measured->number > 0)) return std::nullopt;
  return measured->number * unit->factor;
}

// the interval in s of a rate: "100000Hz", "1 MSa/s", "5e8"
std::optional<double> IntervalOfRate(std::string_view text) {
  const auto measured = ReadMeasured(text);
  if (!measured || !(measured->number > 0)) return std::nullopt;
  std::string_view unit = measured->unit;
  double factor = 1;
  // prefixes are case-sensitive: M is mega
  constexpr std::array<std::pair<char, double>, 4> kPrefixes{
      {{'k', 1e3}, {'K', 1e3}, {'M', 1e6}, {'G', 1e9}}};
  for (const auto& [letter, times] : kPrefixes) {
    if (!unit.starts_with(letter)) continue;
    factor = times;
    unit.remove_prefix(1);
    break;
  }
  const std::string bare = Bare(unit);
  // units of a rate without prefix: Hz, Sa/s, S/s
  if (!bare.empty() && bare != "hz" && bare != "sas" && bare != "ss") return std::nullopt;
  return 1 / (measured->number * factor);
}

// a key by which instruments state their clock, and how its value is read
struct IntervalKey {
  std::string_view name;  // Bare()
  std::optional<double> (*read)(std::string_view);
};

constexpr std::array kIntervalKeys{IntervalKey{"sampleinterval", IntervalOf},
                                   IntervalKey{"samplinginterval", IntervalOf},
                                   IntervalKey{"deltat", IntervalOf},
                                   IntervalKey{"xinc", IntervalOf},
                                   IntervalKey{"increment", IntervalOf},
                                   IntervalKey{"hresolution", IntervalOf},
                                   IntervalKey{"timeinterval", IntervalOf},
                                   IntervalKey{"samplingperiod", IntervalOf},
                                   IntervalKey{"clock", IntervalOf},
                                   IntervalKey{"samplerate", IntervalOfRate},
                                   IntervalKey{"samplingrate", IntervalOfRate},
                                   IntervalKey{"samplingfrequencyhz", IntervalOfRate},
                                   IntervalKey{"samplingfrequency", IntervalOfRate}};

// equal within 1e-6: the same number printed twice
bool Agree(double a, double b) { return std::abs(a - b) <= 1e-6 * std::abs(a); }

// the value of "HUnit" in s, by default 1; nothing where it is no time
std::optional<double> HorizontalUnit(const std::vector<TableKey>& keys) {
  const auto values = ValuesOf(keys, "HUnit");
  const auto unit = FindUnit(values.empty() ? "s" : values[0]);
  if (!unit || unit->si_unit != "s") return std::nullopt;
  return unit->factor;
}

// time of the first row in s: from the index of the trigger, or as printed
std::optional<double> StartOf(const std::vector<TableKey>& keys, double interval_s) {
  const auto number = [&](std::string_view name) -> std::optional<double> {
    const auto values = ValuesOf(keys, name);
    // a start of two meanings is none
    if (values.empty() || MayGroupThousands(values[0], ',')) return std::nullopt;
    const auto read = ReadNumberWithComma(values[0]);
    return read && std::isfinite(*read) ? read : std::nullopt;
  };
  // the trigger is time 0, so the first row is `index` intervals before it
  for (const char* key : {"Trigger Point", "Zero Index"}) {
    if (const auto index = number(key)) return -*index * interval_s;
  }
  const auto start_s = number("XOrg");
  if (start_s) return start_s;
  const auto offset = number("HOffset");
  const auto unit_s = HorizontalUnit(keys);
  return offset && unit_s ? std::optional(*offset * *unit_s) : std::nullopt;
}

// one statement of an interval or rate; nothing where `value` is none. Errors: its unit is no time
Result<std::optional<StatedClock>> ReadClockKey(const IntervalKey& known, const TableKey& key,
                                                std::string_view value,
                                                const std::vector<TableKey>& keys,
                                                const std::string& name) {
  const auto interval_s = known.read(value);
  if (!interval_s) return std::nullopt;
  StatedClock clock{.interval_s = *interval_s,
                    .from = std::string(key.key),
                    .printed = std::string(NumberIn(value))};
  if (known.name == "hresolution") {
    const auto unit_s = HorizontalUnit(keys);
    if (!unit_s) {
      return CannotAnswer(
          name, fmt::format("has 'HUnit' {}, which is no time", ValuesOf(keys, "HUnit")[0]),
          "save the channels as waveforms over the time");
    }
    clock.interval_s *= *unit_s;
  }
  if (!IsSampleInterval(clock.interval_s)) return std::nullopt;
  return clock;
}

bool HasTwoMeanings(std::string_view printed) {
  return MayGroupThousands(printed, ',') || MayGroupThousands(printed, '.');
}

}  // namespace

std::optional<TableKey> ReadTableKey(std::string_view line, char separator) {
  line = Trimmed(line);
  if (line.starts_with('#')) line = Trimmed(line.substr(1));
  // "key, value, value" or, in one cell, "key: value" or "key = value"
  auto cells = SplitCells(line, separator);
  while (cells.size() > 1 && cells.back().empty()) cells.pop_back();
  TableKey key{.key = cells[0]};
  if (cells.size() == 1) {
    // "#CLOCK=20.0uS", "XInc: 1e-9"
    const std::size_t sign = line.find_first_of(":=");
    if (sign == std::string_view::npos) return std::nullopt;
    key.key = Trimmed(line.substr(0, sign));
    cells.push_back(Trimmed(line.substr(sign + 1)));
  }
  while (key.key.ends_with(':') || key.key.ends_with('=') || key.key.ends_with(' ')) {
    key.key.remove_suffix(1);
  }
  if (key.key.empty() || cells.size() < 2 || cells[1].empty()) return std::nullopt;
  for (std::size_t i = 1; i < cells.size(); ++i) key.values.push_back(WithoutChannel(cells[i]));
  return key;
}

std::vector<std::string_view> ValuesOf(const std::vector<TableKey>& keys, std::string_view name) {
  const std::string wanted = Bare(name);
  const auto found =
      std::ranges::find_if(keys, [&](const TableKey& key) { return Bare(key.key) == wanted; });
  return found == keys.end() ? std::vector<std::string_view>{} : found->values;
}

Result<std::optional<StatedClock>> FindStatedClock(const std::vector<TableKey>& keys,
                                                   const std::string& name) {
  std::optional<StatedClock> clock;
  for (const TableKey& key : keys) {
    // every statement of an interval or rate in the header must agree with the first
    const auto known = std::ranges::find(kIntervalKeys, Bare(key.key), &IntervalKey::name);
    if (known == kIntervalKeys.end()) continue;
    for (const std::string_view value : key.values) {
      HAPTOMETER_LET(auto stated, ReadClockKey(*known, key, value, keys, name));
      // "Sample Rate,100,000 Hz": the comma within the number separates its parts
      if (!stated && clock && value.starts_with("000")) clock->printed += ",000";
      if (!stated) continue;
      if (clock && !Agree(clock->interval_s, stated->interval_s)) {
        return CannotAnswer(
            name,
            fmt::format("states two sample intervals: {:.6g} s by '{}' and {:.6g} s by '{}'",
                        clock->interval_s, clock->from, stated->interval_s, key.key),
            "remove the wrong line, or give <rate> and leave the times out with <columns>");
      }
      // what one statement leaves open the other may show
      if (!clock) clock = stated;
      if (!HasTwoMeanings(stated->printed)) clock->printed = stated->printed;
    }
  }
  if (clock) clock->start_s = StartOf(keys, clock->interval_s);
  return clock;
}

bool IsSampleInterval(double interval_s) {
  return interval_s > 0 && std::isfinite(interval_s) && std::isfinite(1 / interval_s);
}

bool MayGroupThousands(const StatedClock& clock, bool has_decimal_commas) {
  return MayGroupThousands(clock.printed, ',') ||
         (has_decimal_commas && MayGroupThousands(clock.printed, '.'));
}

// the number of rows that the header states, for a comparison with the rows that are read
std::optional<std::size_t> FindStatedRows(const std::vector<TableKey>& keys) {
  constexpr double kMost = 1e15;
  for (const char* key :
       {"Record Length", "Number of Data points", "Samples", "SIZE", "Points", "Sample Count"}) {
    const auto values = ValuesOf(keys, key);
    if (values.empty()) continue;
    std::string_view value = values[0];
    // Siglent: "Record Length,Analog:7000"
    if (LowerCase(value).starts_with("analog:")) value.remove_prefix(7);
    const auto rows = ReadNumber(value);
    if (rows && *rows >= 1 && *rows < kMost && *rows == std::floor(*rows)) {
      return static_cast<std::size_t>(*rows);
    }
  }
  return std::nullopt;
}

namespace {

// the number directly before `end`, with blanks between them
std::optional<double> NumberBefore(std::string_view text, std::size_t end) {
  const std::string_view before = Trimmed(text.substr(0, end));
  const std::size_t other = before.find_last_not_of("0123456789.eE+-");
  return ReadNumber(before.substr(other == std::string_view::npos ? 0 : other + 1));
}

// the first number with Hz, kHz, MHz or GHz in a text, in Hz
std::optional<double> RateIn(std::string_view text) {
  const std::size_t unit = text.find("Hz");
  if (unit == std::string_view::npos || unit == 0) return std::nullopt;
  const char prefix = text[unit - 1];
  const double factor = prefix == 'k' ? 1e3 : prefix == 'M' ? 1e6 : prefix == 'G' ? 1e9 : 1;
  const auto number = NumberBefore(text, factor == 1 ? unit : unit - 1);
  if (!number || !(*number > 0) || !std::isfinite(*number)) return std::nullopt;
  return *number * factor;
}

// whether a key or note is about a rate or sampling ("ampl" is in "sample")
bool SpeaksOfRate(std::string_view text) {
  for (const char* word : {"ampl", "rate", "RATE", "AMPL", "Rate"}) {
    if (text.find(word) != std::string_view::npos) return true;
  }
  return false;
}

}  // namespace

std::optional<double> StatedRate(const Metadata& metadata) {
  // nominal_rate_hz first, then fields, then notes
  if (metadata.nominal_rate_hz) return metadata.nominal_rate_hz;
  for (const auto& [key, value] : metadata.fields) {
    if (!SpeaksOfRate(key)) continue;
    if (key.ends_with("_hz")) {
      if (const auto number = ReadNumber(value); number && *number > 0) return number;
    }
    if (const auto rate_hz = RateIn(value)) return rate_hz;
  }
  for (const std::string& note : metadata.notes) {
    if (!SpeaksOfRate(note)) continue;
    if (const auto rate_hz = RateIn(note)) return rate_hz;
  }
  return std::nullopt;
}

void FindContradictedRate(const Record& record, Findings& findings) {
  const auto stated_hz = StatedRate(record.metadata);
  if (!stated_hz || record.stretches.empty()) return;
  const double rate_hz = std::ranges::max_element(record.stretches, {}, &Stretch::rows)->rate_hz;
  // thousands = log10(stated / measured) / 3, a whole number if units of the time are confused
  const double thousands = std::log10(*stated_hz / rate_hz) / 3;
  // within 5 % (0.021 decades), as rates are stated
  const double whole = std::round(thousands);
  if (!std::isfinite(thousands) || whole == 0 || std::abs(thousands - whole) * 3 > 0.021) return;
  findings.Doubt(FindingKind::kTimesInOtherUnit, {{"rate_hz", rate_hz}, {"stated_hz", *stated_hz}});
}

}  // namespace haptometer::trial
