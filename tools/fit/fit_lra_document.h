#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "fit/drop_test/drop_test_fit.h"
#include "tools/fit/fit_figures.h"
#include "tools/report/html_page.h"

namespace haptometer::tools {

/// The answer of fit-lra as one JSON document (docs/reference/fit-lra.md): everything that
/// FitLraText says; what is not determined is null.
[[nodiscard]] std::string FitLraJson(const fit::DropTestFit& fit,
                                     const std::vector<std::string>& doubts,
                                     const std::vector<std::string>& remarks,
                                     const std::vector<Error>& left_out);

/// What stands in a document where no record could be fitted: nothing determined.
[[nodiscard]] fit::DropTestFit NothingDetermined();

/// The answer of fit-lra for people: constants with 95 % intervals, what is doubtful, records,
/// inputs, assumptions.
[[nodiscard]] std::string FitLraText(const fit::DropTestFit& fit,
                                     const std::vector<std::string>& doubts);

/// A result and how it is called.
struct NamedValue {
  std::string_view name;
  fit::FittedValue value;
};

/// Kv, Bv, Km, f0, Q, the ratios to the mass and, where it was found, the mass; in the order in
/// which they are told.
[[nodiscard]] std::vector<NamedValue> ValuesOf(const fit::DropTestFit& fit);

/// "open", "33 ohm".
[[nodiscard]] std::string LoadText(double load_ohm);

/// "1.2 mV"; of a displacement "0.1 um".
[[nodiscard]] std::string AmountText(fit::RecordedSignal signal, double value);

/// What is told of a record: its ringing, its residual, what was found in it; at least two lines.
[[nodiscard]] std::vector<std::string> RecordLines(const fit::FittedRecord& record);

/// A given number and what it does: "moving mass 1.4 g", "taken as exact; +1 % of it: Kv +1.000 %".
struct GivenLine {
  std::string what;
  std::string text;
};

/// The given numbers that move a constant.
[[nodiscard]] std::vector<GivenLine> GivenLines(const fit::DropTestFit& fit);

/// What the page of `fit-lra --report` is made of.
struct ReportedFit {
  fit::DropTestFit fit;
  std::vector<std::string> doubts;
  std::vector<std::string> remarks;
  std::vector<Error> left_out;
  std::vector<FitFigure> figures;
  std::string command;  ///< how it was called
};

/// The page of `fit-lra --report`: the constants, what is not determined and what is doubtful, the
/// figures, the uncertainty budget with correlations, every record, the given numbers and what they
/// do, assumptions, remarks and how the solver ended. Errors: as HtmlPage::Figure.
[[nodiscard]] Result<report::HtmlPage> FitLraReport(const ReportedFit& reported);

/// Kv, Bv and Km with their symbols, in this order.
[[nodiscard]] std::array<std::pair<std::string_view, const fit::FittedValue*>, 3> ConstantsOf(
    const fit::DropTestFit& fit);

/// A cause of uncertainty and its standard uncertainties in percent of Kv, Bv and Km; absent for
/// what is not determined.
struct BudgetRow {
  std::string cause;      ///< "moving mass 1.4 g +- 0.03 g"
  std::string_view type;  ///< "A", "B" (JCGM 100:2008); empty: of all causes together
  std::array<std::optional<double>, 3> percent;
};

/// What the records' noise makes (type A), what each given number makes (type B), what is not
/// determined, and all together. A cause that moves nothing is left out; without any determined
/// constant there is no row.
[[nodiscard]] std::vector<BudgetRow> BudgetOf(const fit::DropTestFit& fit);

/// Correlation coefficients of Kv, Bv and Km, all causes together; absent for what is not
/// determined.
[[nodiscard]] std::array<std::array<std::optional<double>, 3>, 3> CorrelationOf(
    const fit::DropTestFit& fit);

/// A percentage of a budget, two digits; "-" where it is absent or below 1e-6.
[[nodiscard]] std::string PercentText(const std::optional<double>& percent);

/// In the unit that people say: "1.4 g" of 0.0014 "kg".
[[nodiscard]] std::string InSpokenUnit(double value, const std::string& unit);

/// A mass in kg as people say it.
[[nodiscard]] fit::FittedValue InGrams(fit::FittedValue kilograms);

/// A value and its 95 % interval, each for a cell: "8200.00" and "+- 0.51", of a lopsided one both
/// ends, "0.72 to 1.25". "not determined" and, where there is one, the upper limit.
struct FittedCells {
  std::string value;
  std::string interval;
};
[[nodiscard]] FittedCells CellsOf(const fit::FittedValue& value);

/// "  Ka   8200.00 +- 0.51 N/m" with a line end; of a lopsided interval both ends, "1.00, 0.72 to
/// 1.25 N/A". "at most" and the limit, or "not determined", where it is not.
[[nodiscard]] std::string FittedLine(std::string_view name, const fit::FittedValue& value);

/// {value, standard_uncertainty, combined_standard_uncertainty, lower_95, upper_95, at_most_95,
/// unit, determined}; the numbers are null where it is not determined, at_most_95 where it is.
[[nodiscard]] nlohmann::ordered_json FittedJson(const fit::FittedValue& value);

/// A title and below it the sentences, a line each; nothing where there are none.
[[nodiscard]] std::string SentenceSection(std::string_view title,
                                          const std::vector<std::string>& sentences);

}  // namespace haptometer::tools
