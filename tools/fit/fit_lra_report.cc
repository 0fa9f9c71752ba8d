#include "tools/fit/fit_lra_report.h"

#include <fmt/core.h>

#include <cmath>
#include <utility>

#include "base/clock.h"
#include "tools/fit/fit_lra_budget.h"
#include "tools/fit/fit_lra_output.h"
#include "tools/fit/fitted_value_output.h"

namespace haptometer::tools {
namespace {

using fit::DropTestFit;
using report::HtmlPage;
using Rows = std::vector<std::vector<std::string>>;

// one record by its name, several by their number
std::string Title(const DropTestFit& fit) {
  return fit.records.size() == 1
             ? fmt::format("Constants of an actuator from {}", fit.records[0].name)
             : fmt::format("Constants of an actuator from {} drops", fit.records.size());
}

void AddConstants(const DropTestFit& fit, HtmlPage& page) {
  Rows rows;
  for (const auto& [name, value] : ValuesOf(fit)) {
    auto [number, interval] = CellsOf(value);
    rows.push_back({std::string(name), std::move(number), std::move(interval), value.unit});
  }
  page.Section("Constants");
  page.Table({"", "value", "95 % interval", "unit"}, rows);
  page.Paragraph(fmt::format(
      "{} standard uncertainties where the interval is even; noise and given numbers together.{}",
      fit::kCoverage95,
      fit.mass_symbol == "Mv" ? "" : fmt::format(" M is the reduced mass {}.", fit.mass_symbol)));
}

void AddBudget(const DropTestFit& fit, HtmlPage& page) {
  Rows rows;
  for (const BudgetRow& row : BudgetOf(fit)) {
    rows.push_back({row.cause, std::string(row.type), PercentText(row.percent[0]),
                    PercentText(row.percent[1]), PercentText(row.percent[2])});
  }
  if (rows.empty()) return;
  page.Section("Uncertainty budget");
  page.Paragraph(
      "Standard uncertainties in percent; type A: from the records' own noise, type B: from "
      "numbers "
      "that were given (JCGM 100:2008).");
  page.Table({"cause", "type", "Kv", "Bv", "Km"}, rows);
}

void AddCorrelation(const DropTestFit& fit, HtmlPage& page) {
  const auto correlation = CorrelationOf(fit);
  const auto constants = ConstantsOf(fit);
  Rows rows;
  for (std::size_t i = 0; i < constants.size(); ++i) {
    std::vector<std::string> row{std::string(constants[i].first)};
    for (const auto& coefficient : correlation[i]) {
      row.push_back(coefficient ? fmt::format("{:+.4f}", *coefficient) : "-");
    }
    rows.push_back(std::move(row));
  }
  page.Subsection("Correlation, all causes together");
  page.Table({"", "Kv", "Bv", "Km"}, rows);
}

void AddRecords(const DropTestFit& fit, HtmlPage& page) {
  page.Section("Records");
  for (const fit::FittedRecord& record : fit.records) {
    page.Subsection(record.name);
    page.List(RecordLines(record));
  }
}

void AddGiven(const DropTestFit& fit, HtmlPage& page) {
  Rows rows;
  for (auto& [what, text] : GivenLines(fit)) rows.push_back({what, text});
  if (rows.empty()) return;
  page.Section("Given, and what it does");
  page.Table({}, rows);
}

void AddSentences(const std::string& heading, const std::vector<std::string>& sentences,
                  HtmlPage& page) {
  if (sentences.empty()) return;
  page.Section(heading);
  page.List(sentences);
}

void AddSettings(const DropTestFit& fit, HtmlPage& page) {
  const std::string chi = fit.chi_square_per_degree > 0
                              ? fmt::format("{:.3g}", fit.chi_square_per_degree)
                              : "not known: nothing was recorded before an impact";
  page.Section("Settings and search");
  page.Table(
      {}, {{"model", "drop test with the coil's circuit, all records together"},
           {"search",
            fmt::format("{} after {} iterations: {}", fit.converged ? "converged" : "not converged",
                        fit.iterations, fit.termination)},
           {"chi^2 a degree", chi},
           {"scatter of drops", fmt::format("Birge ratio {:.3g} of frequencies, {:.3g} of decays",
                                            fit.frequency_birge_ratio, fit.decay_birge_ratio)},
           {"coverage", fmt::format("95 %, factor {}", fit::kCoverage95)}});
}

}  // namespace

Result<HtmlPage> FitLraReport(const ReportedFit& reported) {
  const DropTestFit& fit = reported.fit;
  HtmlPage page(Title(fit), fmt::format("haptometer {}, {}: {}", HAPTOMETER_VERSION, UtcNow(),
                                        reported.command));
  for (const Error& error : reported.left_out) page.Warning("left out: " + error.Text());
  for (const auto& sentence : fit.undetermined) page.Warning("not determined: " + sentence);
  for (const auto& sentence : reported.doubts) page.Warning("doubtful: " + sentence);
  AddConstants(fit, page);
  AddBudget(fit, page);
  AddCorrelation(fit, page);
  page.Section("Figures");
  for (const FitFigure& figure : reported.figures) {
    if (auto drawn = page.Figure(figure.caption, figure.panels); !drawn) {
      return std::unexpected(drawn.error());
    }
  }
  AddRecords(fit, page);
  AddGiven(fit, page);
  AddSentences("Assumed", fit.assumptions, page);
  AddSentences("Remarks", reported.remarks, page);
  AddSettings(fit, page);
  return page;
}

}  // namespace haptometer::tools
