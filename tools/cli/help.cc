#include "tools/cli/help.h"

#include <fmt/core.h>

#include <array>
#include <cmath>

#include "tools/document/keys.h"
#include "tools/document/render.h"

namespace haptometer::cli {
namespace {

using document::Section;
using document::Value;

// unit of a bound, in the order of Dimension
constexpr std::array kUnits{document::kNone,
                            document::kMetre,
                            document::kKilogram,
                            document::kHenry,
                            document::kSecond,
                            document::kHertz,
                            document::kVolt,
                            document::kAmpere,
                            document::kOhm,
                            document::kNewtonPerMetre,
                            document::kNewtonSecondPerMetre,
                            document::kNewtonPerAmpere};

// a bound in the usual unit (mm, ms), or in the SI unit where that needs no power of ten
std::string EndText(const Option& option, double end) {
  if (end == 0) return "0";
  std::string text = NumberText(end, option.dimension);
  const std::string_view unit = SiUnit(option.dimension);
  // a power of ten only where the value is too large for the usual unit
  if (text.find('e') == std::string::npos || unit.empty()) return text;
  return fmt::format("{:g} {}", end, unit);
}

std::string_view NameOf(Option::Kind kind) {
  constexpr std::array<std::string_view, 6> kNames{"flag",  "text",   "choice",
                                                   "count", "number", "range"};
  return kNames[static_cast<std::size_t>(kind)];
}

// an option as JSON, for --describe-options
Section SectionOf(const Option& option) {
  const bool is_number =
      option.kind == Option::Kind::kNumber || option.kind == Option::Kind::kRange;
  Section section;
  section.Add(document::kName, option.name);
  section.Add(document::kKind, NameOf(option.kind));
  section.Add({"placeholder"}, document::TextOrNotKnown(option.placeholder));
  section.Add(document::kUnit,
              is_number ? document::TextOrNotKnown(SiUnit(option.dimension)) : Value());
  section.Add({"least"}, option.bounds.least);
  section.Add({"most"}, option.bounds.most);
  section.Add({"above"}, option.bounds.is_above);
  section.Add({"below"}, option.bounds.is_below);
  section.Add({"choices"}, option.choices);
  section.Add({"default"}, document::TextOrNotKnown(option.default_text));
  section.Add({"rare"}, option.is_rare);
  section.Add(document::kText, option.text);
  return section;
}

}  // namespace

std::string NumberText(double value, Dimension dimension) {
  // six digits, in the unit in which the value is written
  return document::QuantityText(value, kUnits.at(static_cast<std::size_t>(dimension)), 6);
}

std::string BoundsText(const Option& option) {
  const Bounds& bounds = option.bounds;
  const bool has_least = std::isfinite(bounds.least), has_most = std::isfinite(bounds.most);
  const std::string least = EndText(option, bounds.least), most = EndText(option, bounds.most);
  // a closed end is "from" or "to", an open one "above" or "below"
  if (has_least && has_most) {
    return fmt::format("{} {} to {}{}", bounds.is_above ? "above" : "from", least,
                       bounds.is_below ? "below " : "", most);
  }
  if (has_least) return (bounds.is_above ? "above " : "at least ") + least;
  if (has_most) return (bounds.is_below ? "below " : "at most ") + most;
  return "";
}

std::string HelpOf(const Option& option) {
  std::string added = BoundsText(option);
  if (!option.default_text.empty()) {
    added += fmt::format("{}default {}", added.empty() ? "" : "; ", option.default_text);
  }
  return added.empty() ? option.text : fmt::format("{} [{}]", option.text, added);
}

// NaN satisfies no bound; without bounds both are infinite
Result<void> CheckBounds(const Option& option, double number, const std::string& text) {
  const Bounds& bounds = option.bounds;
  const bool is_above = bounds.is_above ? number > bounds.least : number >= bounds.least;
  const bool is_below = bounds.is_below ? number < bounds.most : number <= bounds.most;
  if (is_above && is_below) return {};
  return Usage(option.name, fmt::format("'{}' is not {}", text, BoundsText(option)),
               "write one within");
}

std::string DescriptionOf(const VerbText& verb, const std::deque<Option>& options) {
  Section section;
  section.Add(document::kName, verb.name);
  section.Add({"summary"}, verb.summary);
  section.Add({"examples"}, std::vector<std::string>(verb.examples.begin(), verb.examples.end()));
  Section& list =
      section.sections.emplace_back(Section{.name = "options", .shape = Section::Shape::kArray});
  for (const Option& option : options) list.sections.push_back(SectionOf(option));
  return document::JsonOf(section);
}

}  // namespace haptometer::cli
