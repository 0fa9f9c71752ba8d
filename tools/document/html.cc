#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "base/typeset.h"
#include "tools/document/render.h"

namespace haptometer::document {
namespace {

using Rows = std::vector<std::vector<std::string>>;

// one column that fits a narrow screen and A4; a number is never split, a wide table scrolls on a
// screen and is smaller on paper, where no figure or row is split
constexpr std::string_view kStyle = R"(
@page { size: A4; margin: 15mm; }
body { font: 16px/1.5 Helvetica, Arial, sans-serif; color: #222; max-width: 64rem;
       margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: 0; overflow-wrap: anywhere; }
h2 { font-size: 1.2rem; margin-top: 2rem; border-bottom: 1px solid #ccc; }
p, td { overflow-wrap: anywhere; }
p.subtitle { color: #555; margin-top: .2rem; }
p.warning { border-left: .3rem solid #d55e00; background: #fdf3ec; padding: .5rem 1rem; }
h3 { font-size: 1rem; margin: 1.5rem 0 .3rem; }
div { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; margin-bottom: 1rem; font-variant-numeric: tabular-nums; }
th, td { text-align: left; vertical-align: top; padding: .25rem .75rem .25rem 0;
         border-bottom: 1px solid #e4e4e4; }
thead th { border-bottom: 2px solid #888; vertical-align: bottom; }
tbody th { font-weight: normal; color: #555; width: 11rem; overflow-wrap: anywhere; }
table.data tbody th { color: inherit; width: auto; }
table.data .long { min-width: 6rem; overflow-wrap: anywhere; }
table.data .text, table.data thead th { overflow-wrap: normal; }
table.data .number { text-align: right; }
table.data tbody .number, table.data tbody .word { white-space: nowrap; }
figure { margin: 1.5rem 0; }
figure svg { width: 100%; height: auto; }
figcaption { color: #555; font-size: .9rem; }
@media print {
  body { margin: 0; padding: 0; max-width: none; font-size: 10pt; }
  figure, tr, p.warning { break-inside: avoid; }
  h2, h3 { break-after: avoid; }
  div { overflow: visible; }
  table.data { font-size: 7.5pt; }
  th, td { padding-right: .4rem; }
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

// How a column is set: numbers to the right and never divided; names of at most 20 characters are
// not divided either; files and hashes wherever there is no room.
std::string_view KindOf(const Column& column) {
  constexpr std::size_t kMostUndivided = 20;
  if (!column.is_text) return "number";
  std::size_t longest = 0;
  std::size_t longest_word = 0;
  for (const std::string& cell : column.cells) {
    longest = std::max(longest, cell.size());
    for (std::size_t begin = 0; begin < cell.size();) {
      const std::size_t end = std::min(cell.find(' ', begin), cell.size());
      longest_word = std::max(longest_word, end - begin);
      begin = end + 1;
    }
  }
  if (longest <= kMostUndivided) return "word";
  return longest_word > kMostUndivided ? "long" : "text";
}

// The body of a page while it grows: self-contained, and all text is escaped here.
struct HtmlWriter {
  std::string body{};
  int figures = 0;

  // `tag` with its attributes: "p class=\"warning\""
  void Add(std::string_view tag, std::string_view text) {
    body += fmt::format("<{}>{}</{}>\n", tag, Escaped(text), tag.substr(0, tag.find(' ')));
  }

  // labels and values; the first cell of a row is its heading
  void AddRows(const Rows& rows) {
    if (rows.empty()) return;
    body += "<table>\n<tbody>\n";
    for (const std::vector<std::string>& row : rows) {
      body += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", Escaped(row[0]),
                          Escaped(row[1]));
    }
    body += "</tbody>\n</table>\n";
  }

  // a table with a heading for each column; all have the same number of cells
  void AddColumns(const std::vector<Column>& columns) {
    if (columns.empty()) return;
    body += "<div><table class=\"data\">\n<thead><tr>";
    for (const Column& column : columns) {
      body += fmt::format("<th scope=\"col\" class=\"{}\">{}</th>", KindOf(column),
                          Escaped(column.heading));
    }
    body += "</tr></thead>\n<tbody>\n";
    for (std::size_t row = 0; row < columns.front().cells.size(); ++row) {
      body += "<tr>";
      for (const Column& column : columns) {
        const std::string_view tag = &column == &columns.front() ? "th scope=\"row\"" : "td";
        body += fmt::format("<{} class=\"{}\">{}</{}>", tag, KindOf(column),
                            Escaped(column.cells[row]), tag.substr(0, 2));
      }
      body += "</tr>\n";
    }
    body += "</tbody>\n</table></div>\n";
  }

  Result<void> AddFigures(const Section& section) {
    for (const Figure& figure : section.figures) {
      HAPTOMETER_LET(const auto svg, plot::DrawSvg(figure.panels));
      body += fmt::format("<figure>\n{}\n<figcaption>Figure {}. {}</figcaption>\n</figure>\n",
                          SvgElement(svg), ++figures, Escaped(Typeset(figure.caption)));
    }
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
    if (!value.empty()) rows.push_back({Typeset(item.label), Typeset(value)});
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
  AddRows(rows);
}

void HtmlWriter::AddTable(const Section& table) {
  std::vector<Column> columns = ColumnsOf(table);
  for (Column& column : columns) {
    column.heading = Typeset(column.heading);
    // a text may be a name, which stays as it is
    if (column.is_text) continue;
    for (std::string& cell : column.cells) cell = Typeset(cell);
  }
  AddColumns(columns);
}

Result<void> HtmlWriter::AddSection(const Section& section, int level) {
  if (!IsShown(section)) return {};
  if (!section.heading.empty()) Add(level++ == 0 ? "h2" : "h3", section.heading);
  // refusals and doubts are marked as warnings and come before the numbers
  for (const Finding& finding : section.findings) {
    Add(finding.severity == Severity::kNote ? "p" : "p class=\"warning\"",
        Typeset(FindingText(finding, section.heading)));
  }
  Rows items;
  if (!section.sources.empty()) items.push_back({"data", SourcesText(section.sources)});
  AddItemRows(section, items);
  AddRows(items);
  if (section.shape == Section::Shape::kTable) {
    HAPTOMETER_TRY(AddFigures(section));
    AddTable(section);
    AddBelow(section);
    return {};
  }
  // numbers first: figures stand behind the sections without a heading
  const auto headed = std::ranges::find_if(
      section.sections, [](const Section& inner) { return !inner.heading.empty(); });
  for (auto inner = section.sections.begin(); inner != section.sections.end(); ++inner) {
    if (inner == headed) HAPTOMETER_TRY(AddFigures(section));
    HAPTOMETER_TRY(AddSection(*inner, level));
  }
  return headed == section.sections.end() ? AddFigures(section) : Result<void>{};
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
  std::vector<Column> inputs{{.heading = "input file", .is_text = true},
                             {.heading = "bytes"},
                             {.heading = "SHA-256", .is_text = true}};
  for (const InputFile& input : provenance.inputs) {
    inputs[0].cells.push_back(input.path);
    inputs[1].cells.push_back(fmt::format("{}", input.bytes));
    inputs[2].cells.push_back(input.sha256);
  }
  if (!provenance.inputs.empty()) {
    page.Add("h2", "Inputs");
    page.AddColumns(inputs);
  }
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n{}</body>\n</html>\n",
      Escaped(document.title), kStyle, page.body);
}

}  // namespace haptometer::document
