#include <fmt/core.h>

#include <array>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "tools/document/render.h"

namespace haptometer::document {
namespace {

using Rows = std::vector<std::vector<std::string>>;

// one column that fits a narrow screen and A4; on paper no figure or row is split
constexpr std::string_view kStyle = R"(
body { font: 16px/1.5 Helvetica, Arial, sans-serif; color: #222; max-width: 60rem;
       margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: 0; overflow-wrap: anywhere; }
h2 { font-size: 1.2rem; margin-top: 2rem; border-bottom: 1px solid #ccc; }
p.subtitle { color: #555; margin-top: .2rem; overflow-wrap: anywhere; }
p.warning { border-left: .3rem solid #d55e00; background: #fdf3ec; padding: .5rem 1rem; }
h3 { font-size: 1rem; margin: 1.5rem 0 .3rem; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { text-align: left; vertical-align: top; padding: .25rem .75rem .25rem 0;
         border-bottom: 1px solid #e4e4e4; overflow-wrap: anywhere; }
thead th { border-bottom: 2px solid #888; }
tbody th { font-weight: normal; color: #555; width: 11rem; }
figure { margin: 1.5rem 0; }
figure svg { width: 100%; height: auto; }
figcaption { color: #555; font-size: .9rem; }
@media print {
  body { margin: 0; max-width: none; font-size: 10pt; }
  figure, tr, p.warning { break-inside: avoid; }
  h2, h3 { break-after: avoid; }
}
)";

// `text`, printable, with the special characters of HTML escaped
std::string Escaped(std::string_view text) {
  constexpr std::string_view kSpecial = "&<>\"";
  constexpr std::array<std::string_view, 4> kEscapes{"&amp;", "&lt;", "&gt;", "&quot;"};
  std::string escaped;
  for (const char c : PrintableLines(text)) {
    const std::size_t place = kSpecial.find(c);
    if (place == std::string_view::npos) {
      escaped += c;
    } else {
      escaped += kEscapes.at(place);
    }
  }
  return escaped;
}

// the svg element alone, without XML declaration and document type
std::string_view SvgElement(std::string_view svg) {
  const std::size_t begin = svg.find("<svg");
  return begin == std::string_view::npos ? svg : svg.substr(begin);
}

// The body of a page while it grows: self-contained, and all text is escaped here.
struct HtmlWriter {
  std::string body{};
  int figures = 0;

  // `tag` with its attributes: "p class=\"warning\""
  void Add(std::string_view tag, std::string_view text) {
    body += fmt::format("<{}>{}</{}>\n", tag, Escaped(text), tag.substr(0, tag.find(' ')));
  }

  // the first cell of a row is its heading; `header` may be empty
  void AddRows(const std::vector<std::string>& header, const Rows& rows) {
    if (header.empty() && rows.empty()) return;
    body += "<table>\n";
    if (!header.empty()) {
      body += "<thead><tr>";
      for (const std::string& cell : header) {
        body += fmt::format("<th scope=\"col\">{}</th>", Escaped(cell));
      }
      body += "</tr></thead>\n";
    }
    body += "<tbody>\n";
    for (const std::vector<std::string>& row : rows) {
      body += fmt::format("<tr><th scope=\"row\">{}</th>", Escaped(row.front()));
      for (std::size_t i = 1; i < row.size(); ++i) {
        body += fmt::format("<td>{}</td>", Escaped(row[i]));
      }
      body += "</tr>\n";
    }
    body += "</tbody>\n</table>\n";
  }

  Result<void> AddFigure(const Figure& figure) {
    HAPTOMETER_LET(const auto svg, plot::DrawSvg(figure.panels));
    body += fmt::format("<figure>\n{}\n<figcaption>Figure {}. {}</figcaption>\n</figure>\n",
                        SvgElement(svg), ++figures, Escaped(figure.caption));
    return {};
  }

  // sections below a table's rows, one line of text for each
  void AddBelow(const Section& table);
  void AddTable(const Section& table);
  // `level`: 0 for the document's own parts (h2), deeper ones are h3
  Result<void> AddSection(const Section& section, int level);
};

// label and value of each item
void AddItemRows(const Section& section, Rows& rows) {
  for (const Item& item : section.items) {
    std::string value = item.label.empty() ? "" : ItemText(item);
    if (!value.empty()) rows.push_back({item.label, std::move(value)});
  }
}

void HtmlWriter::AddBelow(const Section& table) {
  Rows rows;
  for (const Section* below : SectionsBelow(table)) {
    Rows items;
    // label and value of all inner sections, separated by semicolons
    for (const Section* part : AllSections(*below)) AddItemRows(*part, items);
    std::string text;
    for (const auto& item : items) {
      text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", item[0], item[1]);
    }
    if (!text.empty()) rows.push_back({below->heading, std::move(text)});
  }
  AddRows({}, rows);
}

void HtmlWriter::AddTable(const Section& table) {
  const std::vector<Column> columns = ColumnsOf(table);
  if (columns.empty()) return;
  std::vector<std::string> head;
  Rows rows(table.sections.size());
  for (const Column& column : columns) {
    head.push_back(column.heading);
    for (std::size_t k = 0; k < rows.size(); ++k) rows[k].push_back(column.cells[k]);
  }
  AddRows(head, rows);
}

Result<void> HtmlWriter::AddSection(const Section& section, int level) {
  if (!IsShown(section)) return {};
  if (!section.heading.empty()) Add(level++ == 0 ? "h2" : "h3", section.heading);
  // refusals and doubts are marked as warnings and come before the numbers
  for (const Finding& finding : section.findings) {
    Add(finding.severity == Severity::kNote ? "p" : "p class=\"warning\"",
        FindingText(finding, section.heading));
  }
  Rows items;
  if (!section.sources.empty()) items.push_back({"data", SourcesText(section.sources)});
  AddItemRows(section, items);
  AddRows({}, items);
  for (const Figure& figure : section.figures) HAPTOMETER_TRY(AddFigure(figure));
  if (section.shape == Section::Shape::kTable) {
    AddTable(section);
    AddBelow(section);
    return {};
  }
  for (const Section& inner : section.sections) HAPTOMETER_TRY(AddSection(inner, level));
  return {};
}

}  // namespace

Result<std::string> HtmlOf(const Document& document) {
  const Provenance& provenance = document.provenance;
  HtmlWriter page;
  page.Add("h1", document.title);
  page.Add("p class=\"subtitle\"", fmt::format("haptometer {}, {}: {}", provenance.version,
                                               provenance.utc, provenance.command));
  HAPTOMETER_TRY(page.AddSection(document.root, 0));
  // inputs with size and checksum, so that a number can be traced to its file
  Rows inputs;
  for (const InputFile& input : provenance.inputs) {
    inputs.push_back({input.path, fmt::format("{}", input.bytes), input.sha256});
  }
  if (!inputs.empty()) {
    page.Add("h2", "Inputs");
    page.AddRows({"input file", "bytes", "SHA-256"}, inputs);
  }
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n{}</body>\n</html>\n",
      Escaped(document.title), kStyle, page.body);
}

}  // namespace haptometer::document
