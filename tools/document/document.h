#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "acquire/findings.h"
#include "base/error.h"
#include "base/finding.h"
#include "dsp/findings.h"
#include "dsp/statistics/distributions.h"
#include "sim/findings.h"
#include "tools/document/number_text.h"
#include "tools/document/provenance.h"
#include "tools/plot/gnuplot.h"
#include "trial/findings.h"

/// What a verb answers with: one Document, which text, JSON, HTML and CSV are made of
/// (tools/document/render.h).
///
/// A key, its label and its unit stand together in one Key, which the verb names where it adds the
/// value; a key of several places is a constant. Values are in SI units.
namespace haptometer::document {

/// What JSON and CSV hold of an item.
enum class Form : std::uint8_t {
  kNumber,     ///< the value under its name
  kUncertain,  ///< beside it NAME_standard_uncertainty, before the unit's ending
  kInterval,   ///< beside both NAME_interval_95, before the unit's ending: [lower, upper]
  /// An object {value, standard_uncertainty (statistical), combined_standard_uncertainty, lower_95,
  /// upper_95, at_most_95, unit, determined}.
  kEstimate,
};

struct Key {
  std::string_view name;        ///< "band_rms_m"; empty: not in JSON and CSV
  std::string_view label = {};  ///< "vibration"; empty: not in text and HTML
  Unit unit = kNone;
  Form form = Form::kNumber;

  [[nodiscard]] constexpr Key As(Form other) const { return {name, label, unit, other}; }
};

using Range = dsp::Interval;  ///< two ends: of a window, an interval, a band

using AnyValue =
    std::variant<std::monostate, bool, std::int64_t, double, std::string, Range,
                 std::vector<double>, std::vector<std::string>, std::vector<std::vector<double>>>;

/// A value that may be not known: null in JSON, an empty cell in CSV, "-" in a table, no line in a
/// text. Not known are an empty optional and a number that is not finite. Lists of numbers and
/// matrices are for JSON.
struct Value : AnyValue {
  Value() = default;
  template <typename T>
    requires(std::constructible_from<AnyValue, T> && !std::integral<T>)
  Value(T value) : AnyValue(std::move(value)) {}
  Value(bool yes) : AnyValue(yes) {}
  Value(std::integral auto count) : AnyValue(static_cast<std::int64_t>(count)) {}
  Value(std::string_view text) : AnyValue(std::string(text)) {}
  template <typename T>
  Value(const std::optional<T>& known) {
    if (known) *this = Value(*known);
  }

  [[nodiscard]] bool IsKnown() const;
};

/// The text; not known where it is empty.
[[nodiscard]] inline Value TextOrNotKnown(std::string_view text) {
  return text.empty() ? Value() : Value(text);
}

/// A member of what is known; not known of nothing.
template <typename T, typename Member>
[[nodiscard]] Value MemberOf(const std::optional<T>& known, Member T::* member) {
  return known ? Value((*known).*member) : Value();
}

/// A value with all that is known of it, in the value's SI unit.
struct Item {
  std::string name{};
  std::string label{};
  Unit unit = kNone;
  Form form = Form::kNumber;
  Value value{};
  std::optional<double> standard_uncertainty{};  ///< all causes together
  std::optional<double> statistical{};           ///< of it the statistical part (kEstimate)
  std::optional<Range> interval{};               ///< of 95 %
  std::optional<double> at_most{};               ///< of 95 %, where the value is not known
  /// The least step that the input can show; text shows no digit below it. 0: no limit.
  double resolution = 0;
  std::string note{};  ///< said behind the value: "in 20-500 Hz"
};

/// What of a document a text shows; kPage is of a page alone.
enum class Detail : std::uint8_t { kShort, kAll, kPage };

/// What is drawn into a page, or with all others of the document into one picture.
struct Figure {
  std::string caption;
  std::vector<plot::Panel> panels;
};

/// A finding in words: {kind, severity, text, subject, numbers} in JSON.
struct Finding {
  std::string_view kind;  ///< "few-readings"
  Severity severity = Severity::kNote;
  std::string text{};     ///< one sentence without a full stop
  std::string subject{};  ///< file, channel, record; empty: the whole
  std::vector<FindingNumber> numbers{};
};

/// A part of a document, shown in the order of its members.
struct Section {
  enum class Shape : std::uint8_t {
    kObject,  ///< an object in JSON
    kTable,   ///< an array of its sections; a table with a row for each, rows in CSV. The columns
              ///< are the labelled items of a row and of the sections within it; a section within
              ///< it that has a heading, of items alone, is no part of the table and stands below
    kArray,   ///< an array of its sections, which stand one below the other
  };
  /// In JSON; of an object empty: its keys are those of the one around it. Tables and arrays of one
  /// name within one object are one array.
  std::string_view name{};
  std::string heading{};  ///< empty: stands below the section around it without one
  Shape shape = Shape::kObject;
  Detail detail = Detail::kShort;
  /// Where false, null in JSON (the object, or each of its keys) and nothing in text.
  bool is_known = true;
  std::vector<DataSource> sources{};  ///< of its data; `data_source` in JSON
  std::vector<Item> items{};
  std::vector<Figure> figures{};
  std::vector<Section> sections{};
  std::vector<Finding> findings{};  ///< in JSON in the document's list `findings`

  /// Adds an item; the reference holds until the next is added.
  Item& Add(const Key& key, Value value, std::optional<double> standard_uncertainty = {});
  /// Adds a finding of the verb itself, with its words where it arises; `text` as in Sentence.
  void Find(Severity severity, std::string_view kind, std::string_view text,
            std::vector<FindingNumber> numbers = {}, std::string subject = {});
};

/// `section`, a table unless it says so, with what `to_section` makes of each element of the list.
template <typename List, typename ToSection>
[[nodiscard]] Section ListOf(Section section, const List& list, const ToSection& to_section) {
  if (section.shape == Section::Shape::kObject) section.shape = Section::Shape::kTable;
  for (const auto& element : list) section.sections.push_back(to_section(element));
  return section;
}

struct Document {
  std::string verb;         ///< "analyze"
  std::string title{};      ///< the first line, and the page's title
  Provenance provenance{};  ///< filled by Present()
  Section root{};
};

/// The numbers of an item under their names as JSON and CSV hold them; of kEstimate those within
/// its object.
[[nodiscard]] std::vector<std::pair<std::string, Value>> FieldsOf(const Item& item);

/// The section and all within it, in the order of the text.
[[nodiscard]] std::vector<const Section*> AllSections(const Section& section);

/// What the findings of a kind say. Each room's kinds have one table, a function `Sentence
/// SentenceOf(Kind)` that is declared beside the kind's enum or here.
struct Sentence {
  std::string_view kind;  ///< its name in JSON: "few-readings"
  /// A sentence without a full stop, which may name options. In it stand for numbers of the
  /// finding:
  ///
  /// {needed_hz}  the number in the unit that its name ends with, to four digits: "2.5 mm"; a text
  ///              or a count as it is
  /// {drops s}    the plural's ending: nothing where the number is 1, or else "s"
  /// {leak %}     the number in percent; {leak 2%} to two digits
  /// {from_s SI}  the number in the SI unit, to six digits and without it: for options
  /// [...]        a part that is left out where a number in it is not there
  ///
  /// Elsewhere a number that is not there, or not finite, is "(not known)".
  std::string_view text;
};

/// A row of a table of sentences.
template <typename Kind>
struct KindSentence {
  Kind kind;
  std::string_view name, text;
};

/// The sentence of a kind; a kind without a row is an error of the program.
template <typename Kind>
[[nodiscard]] Sentence SentenceIn(std::type_identity_t<std::span<const KindSentence<Kind>>> table,
                                  Kind kind) {
  const auto row = std::ranges::find(table, kind, &KindSentence<Kind>::kind);
  HAPTOMETER_CHECK(row != table.end(), "a kind without words: {}", static_cast<int>(kind));
  return {row->name, row->text};
}

[[nodiscard]] Sentence SentenceOf(trial::FindingKind kind);    ///< findings_trial.cc
[[nodiscard]] Sentence SentenceOf(acquire::FindingKind kind);  ///< findings_acquire.cc
[[nodiscard]] Sentence SentenceOf(dsp::FindingKind kind);      ///< findings_dsp.cc
[[nodiscard]] Sentence SentenceOf(sim::FindingKind kind);      ///< findings_sim.cc

/// The sentence with the numbers in their places.
[[nodiscard]] std::string Fill(std::string_view text, const std::vector<FindingNumber>& numbers);

/// The finding in words.
template <typename Kind>
[[nodiscard]] std::string WordsOf(const FindingOf<Kind>& found) {
  return Fill(SentenceOf(found.kind).text, found.numbers);
}

/// Adds the findings to the section, in words.
template <typename Kind>
void AddFindings(Section& section, const Findings<Kind>& findings) {
  for (const FindingOf<Kind>& found : findings.list()) {
    section.findings.push_back({.kind = SentenceOf(found.kind).kind,
                                .severity = found.severity,
                                .text = WordsOf(found),
                                .subject = found.subject,
                                .numbers = found.numbers});
  }
}

}  // namespace haptometer::document
