#pragma once

#include <string>

#include "base/error.h"
#include "tools/document/document.h"

/// The forms of a document, each written once for all verbs.
namespace haptometer::document {

/// For people: the title, then a line for each labelled item, tables with aligned columns, findings
/// below the section that they are of. kAll shows the sections of that detail too, and the
/// provenance.
[[nodiscard]] std::string TextOf(const Document& document, Detail detail);
/// A part of that text.
[[nodiscard]] std::string TextOf(const Section& section, Detail detail);

/// One JSON object, indented, with a line end, printable (base/text.h). Numbers are
/// round-trip doubles in SI units; what is not known is null. `findings` and `provenance` stand
/// behind the keys of the root.
[[nodiscard]] std::string JsonOf(const Document& document);

/// The section alone, without findings and provenance.
[[nodiscard]] std::string JsonOf(const Section& section);

/// A section of shape kTable as a table with commas: behind a comment with the provenance a column
/// for each field (FieldsOf) of its first row. Values as in JSON, texts as cli::CellOf(); what is
/// not known is empty.
[[nodiscard]] std::string CsvOf(const Section& table, const Provenance& provenance);

/// One self-contained page with everything, figures drawn by gnuplot. Errors: as plot::DrawSvg.
[[nodiscard]] Result<std::string> HtmlOf(const Document& document);

// --- what text and page share ---

/// Whether there is anything to show: neither not known nor without parts that are shown.
[[nodiscard]] bool IsShown(const Section& section);

/// The value as a reader sees it: number, unit, interval and note. Empty where it is not known.
[[nodiscard]] std::string ItemText(const Item& item);

/// A column of a table: heading, with the unit of all its numbers ("vibration / um"), and cells.
/// Where the rows differ in unit, it stands in the cells.
struct Column {
  std::string heading;
  bool is_text = false;  ///< no cell is a number
  std::vector<std::string> cells{};
};

/// One for each labelled item of a row and of the sections within it without a heading, of which
/// some row has a value.
[[nodiscard]] std::vector<Column> ColumnsOf(const Section& table);

/// The sections with a heading within the rows.
[[nodiscard]] std::vector<const Section*> SectionsBelow(const Section& table);

/// "doubt: SUBJECT: TEXT"; a refusal is "not answered". Without the subject below a heading that
/// says it.
[[nodiscard]] std::string FindingText(const Finding& finding, std::string_view heading);

/// The sources with commas between.
[[nodiscard]] std::string SourcesText(const std::vector<DataSource>& sources);

}  // namespace haptometer::document
