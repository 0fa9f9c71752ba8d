#include <fmt/core.h>

#include <utility>

#include "base/clock.h"
#include "tools/reproduce/reproduction_output.h"

namespace haptometer::tools {
namespace {

using Rows = std::vector<std::vector<std::string>>;

std::vector<std::string> CellsOf(std::string what, const RowWords& words) {
  std::string verdict = words.verdict;
  for (const std::string& line : words.why) verdict += fmt::format("; {}", line);
  return {std::move(what), words.printed, words.ours, words.deviation, std::move(verdict)};
}

void AddGroup(const Reproduction& reproduction, std::string_view group, report::HtmlPage& page) {
  Rows rows;
  for (const ThesisRow& row : reproduction.rows) {
    const ThesisNumber& number = row.number();
    if (number.group != group) continue;
    rows.push_back(CellsOf(number.where.empty() ? std::string(number.what)
                                                : fmt::format("{} ({})", number.what, number.where),
                           WordsOf(row)));
  }
  page.Subsection(group);
  page.Table({"", "printed", "ours", "deviation", "verdict"}, rows);
}

void AddRows(const Reproduction& reproduction, report::HtmlPage& page) {
  page.Section("Row by row");
  std::string_view group;
  for (const ThesisRow& row : reproduction.rows) {
    if (row.number().group == group) continue;
    group = row.number().group;
    AddGroup(reproduction, group, page);
  }
}

void AddChain(const std::vector<ChainRow>& chain, report::HtmlPage& page) {
  Rows rows;
  rows.reserve(chain.size());
  for (const ChainRow& row : chain) {
    rows.push_back(
        CellsOf(fmt::format("{}; {}, {}", row.sensor, row.scene, row.quantity), WordsOf(row)));
  }
  page.Section("Scene, sensor, record, analysis");
  page.Table({"", "truth", "answer", "deviation", "interval"}, rows);
}

}  // namespace

Result<report::HtmlPage> ReproductionReport(const Reproduction& reproduction,
                                            const std::vector<ThesisFigure>& figures,
                                            const std::string& command) {
  report::HtmlPage page(
      "A Mechanical Amplifier for Haptic Feedback, computed anew",
      fmt::format("haptometer {}, {}: {}", HAPTOMETER_VERSION, UtcNow(), command));
  page.Paragraph(
      "Every number of J. Lindsay's thesis (University of Washington, 2013) beside what this "
      "program computes.");
  page.Paragraph(CountsText(reproduction) + ".");
  page.List(ReproductionAssumptions());
  AddRows(reproduction, page);
  if (reproduction.chain) AddChain(*reproduction.chain, page);
  page.Section("Figures");
  for (const ThesisFigure& figure : figures) {
    if (auto drawn = page.Figure(figure.caption, figure.panels); !drawn) {
      return std::unexpected(drawn.error());
    }
  }
  return page;
}

}  // namespace haptometer::tools
