#include "tools/document/document.h"

#include <fmt/core.h>

#include <cmath>
#include <limits>

#include "tools/document/keys.h"

namespace haptometer::document {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// name of a companion value before the unit's ending: "rise_standard_uncertainty_s" of "rise_s"
std::string Companion(const Item& item, std::string_view what) {
  const std::string_view name = item.name, unit = item.unit.ending;
  const std::string_view ending = name.ends_with(unit) ? unit : "";
  return fmt::format("{}_{}{}", name.substr(0, name.size() - ending.size()), what, ending);
}

// the fields of an estimate: value, statistical and combined standard uncertainty, 95 % interval
std::vector<std::pair<std::string, Value>> EstimateFields(const Item& item) {
  using Number = std::optional<double>;
  const bool is_known = item.value.IsKnown();
  const auto known = [&](const Number& number) { return is_known ? number : Number(); };
  // NaN as the absent end of an interval
  const auto [lower, upper] = item.interval.value_or(Range{kNan, kNan});
  const auto field = [](const Key& key, Value value) {
    return std::pair(std::string(key.name), std::move(value));
  };
  // an upper limit exists only where there is no value
  return {field(kValue, item.value),
          field(kStandardUncertainty, known(item.statistical)),
          field(kCombinedUncertainty, known(item.standard_uncertainty)),
          field(Key{"lower_95"}, known(lower)),
          field(Key{"upper_95"}, known(upper)),
          field(Key{"at_most_95"}, is_known ? Number() : item.at_most),
          field(kUnit, item.unit.symbol),
          field(Key{"determined"}, is_known)};
}

const FindingNumber* Named(std::string_view name, const std::vector<FindingNumber>& numbers) {
  const auto found = std::ranges::find(numbers, name, &FindingNumber::name);
  return found == numbers.end() ? nullptr : &*found;
}

// a count or a number; NaN of a text
double NumberIn(const FindingNumber& finding) {
  if (const auto* count = std::get_if<std::int64_t>(&finding.value)) {
    return static_cast<double>(*count);
  }
  const auto* number = std::get_if<double>(&finding.value);
  return number ? *number : kNan;
}

// text for a place "name" or "name how"; nothing where the number is absent
std::optional<std::string> Replacement(std::string_view place,
                                       const std::vector<FindingNumber>& numbers) {
  const std::size_t blank = std::min(place.find(' '), place.size());
  const std::string_view name = place.substr(0, blank);
  const std::string_view how = place.substr(std::min(blank + 1, place.size()));
  const FindingNumber* found = Named(name, numbers);
  if (found == nullptr) return std::nullopt;
  if (const auto* text = std::get_if<std::string>(&found->value)) return *text;
  const auto* count = std::get_if<std::int64_t>(&found->value);
  const double number = NumberIn(*found);
  if (!std::isfinite(number)) return std::nullopt;
  // how: "s" plural ending, "SI" plain number, "%" share, "2%" of two digits, "6" six digits,
  // "+-other" its standard uncertainty; else the unit that the name ends with
  if (how == "s") return number == 1 ? "" : "s";
  if (how.starts_with("+-")) {
    const FindingNumber* found_beside = Named(how.substr(2), numbers);
    const double uncertainty = found_beside == nullptr ? 0 : NumberIn(*found_beside);
    // one that is too small to be shown leaves seven digits certain
    return QuantityText(number, UnitOfName(name), uncertainty > 0 ? 7 : 4, uncertainty);
  }
  if (how == "SI") return NumberText(number, 0, 0);
  if (count && how.empty()) return fmt::format("{}", *count);
  if (how == "2%") return QuantityText(number, kShare, 2);
  // four digits, or six, in the unit of the name's ending ("_m", "_hz")
  return QuantityText(number, how == "%" ? kShare : UnitOfName(name), how == "6" ? 6 : 4);
}

}  // namespace

bool Value::IsKnown() const {
  if (const auto* number = std::get_if<double>(this)) return std::isfinite(*number);
  if (const auto* range = std::get_if<Range>(this)) {
    // one finite end is enough for a one-sided range
    return std::isfinite(range->lower) || std::isfinite(range->upper);
  }
  return !std::holds_alternative<std::monostate>(*this);
}

Item& Section::Add(const Key& key, Value value, std::optional<double> standard_uncertainty) {
  items.push_back({.name = std::string(key.name),
                   .label = std::string(key.label),
                   .unit = key.unit,
                   .form = key.form,
                   .value = std::move(value),
                   .standard_uncertainty = standard_uncertainty});
  return items.back();
}

void Section::Find(Severity severity, std::string_view kind, std::string_view text,
                   std::vector<FindingNumber> numbers, std::string subject) {
  std::string words = Fill(text, numbers);
  findings.push_back({.kind = kind,
                      .severity = severity,
                      .text = std::move(words),
                      .subject = std::move(subject),
                      .numbers = std::move(numbers)});
}

std::vector<std::pair<std::string, Value>> FieldsOf(const Item& item) {
  // a number has one field, an uncertain one two, one with an interval three
  if (item.form == Form::kEstimate) return EstimateFields(item);
  std::vector<std::pair<std::string, Value>> fields{{item.name, item.value}};
  if (item.form == Form::kNumber) return fields;
  fields.emplace_back(Companion(item, kStandardUncertainty.name), item.standard_uncertainty);
  if (item.form == Form::kUncertain) return fields;
  fields.emplace_back(Companion(item, kInterval95.name), item.interval);
  return fields;
}

std::vector<const Section*> AllSections(const Section& section) {
  std::vector<const Section*> all{&section};
  for (const Section& inner : section.sections) {
    const auto within = AllSections(inner);
    all.insert(all.end(), within.begin(), within.end());
  }
  return all;
}

// [optional part] is kept if all its places have a number; {place} is replaced
std::string Fill(std::string_view text, const std::vector<FindingNumber>& numbers) {
  std::string filled;
  std::size_t part = 0;  // where in `filled` an optional part begins
  bool is_whole = true;  // the optional part so far
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] == '[') {
      part = filled.size();
      is_whole = true;
    } else if (text[at] == ']') {
      // cut back to the begin of the optional part
      if (!is_whole) filled.resize(part);
    } else if (text[at] == '{') {
      const std::size_t end = text.find('}', at);
      HAPTOMETER_CHECK(end != std::string_view::npos, "'{}' has a place without an end", text);
      const auto replacement = Replacement(text.substr(at + 1, end - at - 1), numbers);
      is_whole = is_whole && replacement;
      filled += replacement.value_or("(not known)");
      at = end;
    } else {
      filled += text[at];
    }
  }
  return filled;
}

}  // namespace haptometer::document
