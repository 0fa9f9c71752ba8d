#include <fmt/core.h>

#include <utility>

#include "tools/document/render.h"
#include "tools/report/html_page.h"

namespace haptometer::document {
namespace {

using Rows = std::vector<std::vector<std::string>>;

// label and value of each item
void AddItemRows(const Section& section, Rows& rows) {
  for (const Item& item : section.items) {
    std::string value = item.label.empty() ? "" : ItemText(item);
    if (!value.empty()) rows.push_back({item.label, std::move(value)});
  }
}

void AddItems(const Section& section, report::HtmlPage& page) {
  Rows rows;
  if (!section.sources.empty()) rows.push_back({"data", SourcesText(section.sources)});
  AddItemRows(section, rows);
  if (!rows.empty()) page.Table({}, rows);
}

// a line of one table for each, because each row of the table may have one
void AddBelow(const Section& table, report::HtmlPage& page) {
  Rows rows;
  for (const Section* below : SectionsBelow(table)) {
    Rows items;
    for (const Section* part : AllSections(*below)) AddItemRows(*part, items);
    std::string text;
    for (const auto& item : items) {
      text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", item[0], item[1]);
    }
    if (!text.empty()) rows.push_back({below->heading, std::move(text)});
  }
  if (!rows.empty()) page.Table({}, rows);
}

void AddTable(const Section& table, report::HtmlPage& page) {
  const std::vector<Column> columns = ColumnsOf(table);
  std::vector<std::string> head;
  Rows rows(table.sections.size());
  for (const Column& column : columns) {
    head.push_back(column.heading);
    for (std::size_t k = 0; k < rows.size(); ++k) rows[k].push_back(column.cells[k]);
  }
  if (!columns.empty()) page.Table(head, rows);
}

// `level`: 0 of the document's own parts
Result<void> AddSection(const Section& section, int level, report::HtmlPage& page) {
  if (!IsShown(section)) return {};
  if (!section.heading.empty()) {
    level == 0 ? page.Section(section.heading) : page.Subsection(section.heading);
    ++level;
  }
  // refusals and doubts stand out
  for (const Finding& finding : section.findings) {
    const std::string text = FindingText(finding, section.heading);
    finding.severity == Severity::kNote ? page.Paragraph(text) : page.Warning(text);
  }
  AddItems(section, page);
  for (const Figure& figure : section.figures) {
    if (auto drawn = page.Figure(figure.caption, figure.panels); !drawn) return drawn;
  }
  if (section.shape == Section::Shape::kTable) {
    AddTable(section, page);
    AddBelow(section, page);
    return {};
  }
  for (const Section& inner : section.sections) {
    if (auto added = AddSection(inner, level, page); !added) return added;
  }
  return {};
}

}  // namespace

Result<std::string> HtmlOf(const Document& document) {
  const Provenance& provenance = document.provenance;
  report::HtmlPage page(document.title, fmt::format("haptometer {}, {}: {}", provenance.version,
                                                    provenance.utc, provenance.command));
  if (auto added = AddSection(document.root, 0, page); !added) {
    return std::unexpected(added.error());
  }
  Rows inputs;
  for (const InputFile& input : provenance.inputs) {
    inputs.push_back({input.path, fmt::format("{}", input.bytes), input.sha256});
  }
  if (!inputs.empty()) {
    page.Section("Inputs");
    page.Table({"file", "bytes", "SHA-256"}, inputs);
  }
  return page.Html();
}

}  // namespace haptometer::document
