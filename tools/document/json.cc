#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/text.h"
#include "tools/cli/csv_cell.h"
#include "tools/document/keys.h"
#include "tools/document/render.h"

namespace haptometer::document {
namespace {

using Json = nlohmann::ordered_json;

// the value; a number that is not finite is null, as JSON has neither NaN nor infinity
struct JsonVisitor {
  Json operator()(std::monostate) const { return nullptr; }
  Json operator()(double number) const { return std::isfinite(number) ? Json(number) : Json(); }
  Json operator()(const Range& range) const {
    return (*this)(std::vector{range.lower, range.upper});
  }
  template <typename T>
  Json operator()(const std::vector<T>& list) const {
    Json json = Json::array();
    for (const T& one : list) json.push_back((*this)(one));
    return json;
  }
  // bool, count and text as they are
  template <typename T>
  Json operator()(const T& value) const {
    return value;
  }
};

Json ValueJson(const Value& value, bool is_known) {
  if (!is_known || !value.IsKnown()) return nullptr;
  return std::visit(JsonVisitor{}, static_cast<const AnyValue&>(value));
}

Json TextOrNull(const std::string& text) { return text.empty() ? Json() : Json(text); }

// Indented, with a line end. Bytes of names and paths that are no UTF-8 become U+FFFD, and what is
// not printable its \u escape, so that a terminal shows the document as it is.
std::string JsonText(const Json& json) {
  return PrintableLines(json.dump(2, ' ', false, Json::error_handler_t::replace)) + "\n";
}

Json JsonOfSection(const Section& section);
Json ObjectOf(const Section& section);

// an estimate is an object of its own, other items are one to three fields of the section's object
void AddItem(const Item& item, bool is_known, Json& json) {
  const bool is_object = item.form == Form::kEstimate;
  Json& object = is_object ? json[item.name] : json;
  if (is_object && !is_known) return;
  for (const auto& [name, value] : FieldsOf(item)) object[name] = ValueJson(value, is_known);
}

// parts of the section become parts of the object; all are null where the section is not known
void AddParts(const Section& section, bool is_known, Json& json) {
  for (const Item& item : section.items) {
    if (!item.name.empty()) AddItem(item, is_known, json);
  }
  for (const DataSource source : section.sources) json[kDataSources.name].push_back(NameOf(source));
  for (const Section& inner : section.sections) {
    if (!inner.name.empty()) {
      Json part = is_known ? JsonOfSection(inner) : Json(nullptr);
      // arrays of one name are joined: a list may come in several sections
      Json& there = json[inner.name];
      if (!there.is_array() || !part.is_array()) {
        there = std::move(part);
      } else {
        for (Json& element : part) there.push_back(std::move(element));
      }
    } else if (inner.shape == Section::Shape::kObject) {
      // a section without a name adds its keys to the object around it
      AddParts(inner, is_known && inner.is_known, json);
    }
  }
}

Json ObjectOf(const Section& section) {
  Json json = Json::object();
  AddParts(section, section.is_known, json);
  return json;
}

Json JsonOfSection(const Section& section) {
  if (!section.is_known) return nullptr;
  // arrays and tables: one object for each row
  if (section.shape == Section::Shape::kObject) return ObjectOf(section);
  Json array = Json::array();
  for (const Section& element : section.sections) array.push_back(ObjectOf(element));
  return array;
}

Json FindingJson(const Finding& finding) {
  Json numbers = Json::object();
  for (const FindingNumber& number : finding.numbers) {
    numbers[std::string(number.name)] = std::visit(JsonVisitor{}, number.value);
  }
  return {{kKind.name, finding.kind},
          {"severity", NameOf(finding.severity)},
          {kText.name, finding.text},
          {kSubject.name, TextOrNull(finding.subject)},
          {"numbers", numbers}};
}

Json ProvenanceJson(const Provenance& provenance) {
  Json inputs = Json::array();
  for (const InputFile& input : provenance.inputs) {
    inputs.push_back(
        {{"path", input.path}, {kBytes.name, input.bytes}, {"sha256", TextOrNull(input.sha256)}});
  }
  return {{"version", provenance.version},
          {kCommand.name, provenance.command},
          {kUtc.name, provenance.utc},
          {kInputs.name, inputs}};
}

// --- CSV tables ---

// names and cells of a row, inner sections behind its own items; an empty cell is not known
void AddCells(const Section& section, bool is_known, std::string& names, std::string& cells) {
  for (const Item& item : section.items) {
    for (const auto& [name, value] : FieldsOf(item)) {
      if (item.name.empty()) continue;
      const std::string comma = names.empty() ? "" : ",";
      const Json json = ValueJson(value, is_known);
      // escaped as a CSV cell: a name may hold commas or begin like a formula
      names += comma + cli::CellOf(name);
      cells += comma;
      if (json.is_null()) continue;
      cells += cli::CellOf(json.is_string() ? json.get<std::string>() : json.dump());
    }
  }
  for (const Section& inner : section.sections) {
    if (inner.heading.empty()) AddCells(inner, is_known && inner.is_known, names, cells);
  }
}

}  // namespace

std::string JsonOf(const Document& document) {
  Json json = ObjectOf(document.root);
  // findings of all sections in one list, in the order of the text
  Json& findings = json["findings"] = Json::array();
  for (const Section* section : AllSections(document.root)) {
    for (const Finding& finding : section->findings) findings.push_back(FindingJson(finding));
  }
  json["provenance"] = ProvenanceJson(document.provenance);
  return JsonText(json);
}

std::string JsonOf(const Section& section) { return JsonText(ObjectOf(section)); }

std::string CsvOf(const Section& table, const Provenance& provenance) {
  std::string csv = CommentOf(provenance, "# ");
  for (const Section& element : table.sections) {
    std::string names, cells;
    AddCells(element, element.is_known, names, cells);
    // the names of the first row are the heading
    if (&element == table.sections.data()) csv += names + "\n";
    csv += cells + "\n";
  }
  return csv;
}

}  // namespace haptometer::document
