#include "base/text.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/error.h"
#include "base/mapped.h"
#include "tools/document/render.h"

namespace haptometer::document {
namespace {

constexpr std::size_t kIndent = 2;

// The value alone, numbers in `unit`; uncertainty and resolution determine the digits.
struct CellVisitor {
  const Item& item;
  const SpokenUnit& unit;

  std::string operator()(bool yes) const { return yes ? "yes" : "no"; }
  std::string operator()(std::int64_t count) const { return fmt::format("{}", count); }
  std::string operator()(double number) const {
    if (!std::isfinite(number)) return "-";
    return NumberText(number * unit.factor, item.standard_uncertainty.value_or(0) * unit.factor,
                      item.resolution * unit.factor);
  }
  std::string operator()(const std::string& text) const { return text; }
  std::string operator()(const Range& range) const {
    return RangeText(range.lower * unit.factor, range.upper * unit.factor,
                     item.standard_uncertainty.value_or(0) * unit.factor,
                     item.resolution * unit.factor);
  }
  std::string operator()(const std::vector<std::string>& texts) const {
    return fmt::format("{}", fmt::join(texts, ", "));
  }
  template <typename T>
  std::string operator()(const T& /*other*/) const {
    return "-";
  }
};

// the largest magnitude, which selects the unit (m, mm or um)
double SizeOf(const Item& item) {
  const auto size = [](double number) { return std::isfinite(number) ? std::abs(number) : 0; };
  if (const auto* number = std::get_if<double>(&item.value)) return size(*number);
  if (const auto* range = std::get_if<Range>(&item.value)) {
    return std::max(size(range->lower), size(range->upper));
  }
  return size(item.at_most.value_or(0));
}

// the value, or "at most" with two digits where only an upper limit is known
std::string CellText(const Item& item, const SpokenUnit& unit) {
  if (item.value.IsKnown() || !item.at_most) {
    return std::visit(CellVisitor{item, unit}, static_cast<const AnyValue&>(item.value));
  }
  return fmt::format("at most {}",
                     NumberText(*item.at_most * unit.factor, 0, item.resolution * unit.factor, 2));
}

// the labelled items of a row; without values where the section that they belong to is not known
void AddCells(const Section& section, bool is_known, std::vector<Item>& cells) {
  for (const Item& item : section.items) {
    if (item.label.empty()) continue;
    cells.push_back(is_known ? item : Item{.label = item.label, .unit = item.unit});
  }
  for (const Section& inner : section.sections) {
    if (inner.heading.empty()) AddCells(inner, is_known && inner.is_known, cells);
  }
}

bool HasValue(const Item& item) { return item.value.IsKnown() || item.at_most; }

// one unit for a column, chosen by its largest number; else each cell has its own unit
Column ColumnOf(const std::vector<Item>& items) {
  double size = 0;
  for (const Item& item : items) size = std::max(size, SizeOf(item));
  // all in the units of the first, so that those can stand in the heading
  const auto symbol_of = [](const Item& item) { return item.unit.spoken[0].symbol; };
  const bool is_one =
      std::ranges::count(items, symbol_of(items.front()), symbol_of) == std::ssize(items);
  Column column{.heading = items.front().label, .is_text = true};
  const std::string_view heading_unit = is_one ? items.front().unit.For(size).symbol : "";
  if (!heading_unit.empty()) column.heading += fmt::format(" / {}", heading_unit);
  for (const Item& item : items) {
    const SpokenUnit unit = item.unit.For(is_one ? size : SizeOf(item));
    std::string cell = Printable(CellText(item, unit));
    if (!is_one && !unit.symbol.empty() && HasValue(item)) cell += fmt::format(" {}", unit.symbol);
    // a column of names and missing values is set to the left, numbers to the right
    column.is_text &= !item.value.IsKnown() || std::holds_alternative<std::string>(item.value) ||
                      std::holds_alternative<std::vector<std::string>>(item.value);
    column.cells.push_back(std::move(cell));
  }
  return column;
}

// characters as a terminal counts them: bytes that do not continue one in UTF-8
std::size_t WidthOf(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80; }));
}

// width of the labels in one column, with those of inner sections without a heading
std::size_t LabelWidth(const Section& section, Detail detail) {
  std::size_t width = 0;
  for (const Item& item : section.items) {
    if (item.value.IsKnown() || item.at_most) width = std::max(width, WidthOf(item.label));
  }
  for (const Section& inner : section.sections) {
    if (!inner.heading.empty() || !IsShown(inner) || inner.detail > detail) continue;
    width = std::max(width, LabelWidth(inner, detail));
  }
  return width;
}

// The text of a document while it grows; every line begins at the indent of its section.
struct TextWriter {
  Detail detail;
  std::string text{};

  void AddLine(std::size_t indent, std::string_view line) {
    fmt::format_to(std::back_inserter(text), "{:{}}{}\n", "", indent, Printable(line));
  }

  // `width`: of the labels of the section around it; a heading begins a column of its own
  void AddSection(const Section& section, std::size_t indent, std::size_t width) {
    if (!IsShown(section) || section.detail > detail) return;
    if (!section.heading.empty()) {
      AddLine(indent, section.heading);
      indent += kIndent;
      width = LabelWidth(section, detail);
    }
    if (!section.sources.empty()) AddLine(indent, "data: " + SourcesText(section.sources));
    AddItems(section, indent, width);
    if (section.shape == Section::Shape::kTable) return AddTable(section, indent);
    for (const Section& inner : section.sections) AddSection(inner, indent, width);
    for (const Finding& finding : section.findings) {
      AddLine(indent, FindingText(finding, section.heading));
    }
  }

  // label and value, the values of a section aligned
  void AddItems(const Section& section, std::size_t indent, std::size_t width) {
    for (const Item& item : section.items) {
      const std::string value = item.label.empty() ? "" : ItemText(item);
      if (value.empty()) continue;
      const std::size_t fill = width - WidthOf(item.label);
      AddLine(indent, fmt::format("{}{:{}}  {}", item.label, "", fill, value));
    }
  }

  void AddTable(const Section& table, std::size_t indent) {
    const std::vector<Column> columns = ColumnsOf(table);
    std::vector<std::size_t> widths;
    widths.reserve(columns.size());
    for (const Column& column : columns) {
      widths.push_back(WidthOf(column.heading));
      for (const std::string& cell : column.cells) {
        widths.back() = std::max(widths.back(), WidthOf(cell));
      }
    }
    // numbers aligned to the right, so that equal decimals stand one below the other
    for (std::size_t row = 0; !columns.empty() && row <= table.sections.size(); ++row) {
      std::string line;
      for (std::size_t k = 0; k < columns.size(); ++k) {
        const Column& column = columns[k];
        const std::string& cell = row == 0 ? column.heading : column.cells[row - 1];
        const std::string fill(widths[k] - WidthOf(cell), ' ');
        if (!line.empty()) line += std::string(kIndent, ' ');
        line += column.is_text ? cell + fill : fill + cell;
      }
      // no blanks at a line's end
      AddLine(indent, line.substr(0, line.find_last_not_of(' ') + 1));
    }
    for (const Section* below : SectionsBelow(table)) AddSection(*below, indent, 0);
  }
};

}  // namespace

bool IsShown(const Section& section) {
  if (!section.is_known) return false;
  if (section.shape != Section::Shape::kObject) return !section.sections.empty();
  // an item without a label stands in JSON only
  const auto is_shown = [](const Item& item) {
    return !item.label.empty() && !ItemText(item).empty();
  };
  return !section.sources.empty() || !section.figures.empty() || !section.findings.empty() ||
         std::ranges::any_of(section.items, is_shown) ||
         std::ranges::any_of(section.sections, IsShown);
}

std::string ItemText(const Item& item) {
  if (!HasValue(item)) return {};
  const SpokenUnit unit = item.unit.For(SizeOf(item));
  const std::string symbol = unit.symbol.empty() ? "" : fmt::format(" {}", unit.symbol);
  std::string text = CellText(item, unit) + symbol;
  if (!item.value.IsKnown()) {
    text += " (95 %)";
  } else if (item.interval) {
    // an interval whose ends are shown as the same number adds nothing
    const CellVisitor said{item, unit};
    const auto [lower, upper] = *item.interval;
    if (said(Range{lower, lower}) != said(Range{upper, upper})) {
      text += fmt::format("; 95 %: {}{}", said(*item.interval), symbol);
    }
  }
  return item.note.empty() ? text : text + ", " + item.note;
}

std::vector<Column> ColumnsOf(const Section& table) {
  std::vector<std::vector<Item>> rows;
  // all rows have the same cells, so that column k is one quantity
  for (const Section& row : table.sections) {
    AddCells(row, row.is_known, rows.emplace_back());
    HAPTOMETER_CHECK(rows.back().size() == rows.front().size(), "a row of {} has {} cells",
                     table.name, rows.back().size());
  }
  std::vector<Column> columns;
  for (std::size_t k = 0; !rows.empty() && k < rows.front().size(); ++k) {
    const auto items = Mapped<Item>(rows, [&](const auto& row) { return row[k]; });
    // a column without any value is omitted
    if (std::ranges::any_of(items, HasValue)) columns.push_back(ColumnOf(items));
  }
  return columns;
}

std::vector<const Section*> SectionsBelow(const Section& table) {
  std::vector<const Section*> sections;
  for (const Section& row : table.sections) {
    for (const Section& inner : row.sections) {
      if (!inner.heading.empty()) sections.push_back(&inner);
    }
  }
  return sections;
}

std::string FindingText(const Finding& finding, std::string_view heading) {
  const std::string_view what =
      finding.severity == Severity::kRefusal ? "not answered" : NameOf(finding.severity);
  // a heading that already names the subject is not repeated
  const bool is_said = finding.subject.empty() || finding.subject == heading;
  return is_said ? fmt::format("{}: {}", what, finding.text)
                 : fmt::format("{}: {}: {}", what, finding.subject, finding.text);
}

std::string SourcesText(const std::vector<DataSource>& sources) {
  const auto name = [](DataSource source) { return NameOf(source); };
  return fmt::format("{}", fmt::join(Mapped(sources, name), ", "));
}

std::string TextOf(const Section& section, Detail detail) {
  TextWriter writer{.detail = detail};
  writer.AddSection(section, kIndent, LabelWidth(section, detail));
  return std::move(writer.text);
}

std::string TextOf(const Document& document, Detail detail) {
  TextWriter writer{.detail = detail};
  writer.AddLine(0, document.title);
  std::string text = std::move(writer.text) + TextOf(document.root, detail);
  if (detail == Detail::kAll) text += CommentOf(document.provenance, "  ");
  return text;
}

}  // namespace haptometer::document
