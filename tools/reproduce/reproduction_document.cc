#include "tools/reproduce/reproduction_document.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/clock.h"
#include "tools/cli/json.h"

namespace haptometer::tools {
namespace {

using Json = nlohmann::ordered_json;

std::string_view Name(Relation relation) {
  switch (relation) {
    case Relation::kEquals:
      return "equals";
    case Relation::kBelow:
      return "below";
    case Relation::kAbove:
      return "above";
    case Relation::kNotPrinted:
      return "not printed";
  }
  return "not printed";
}

Json IntervalJson(const std::optional<dsp::Interval>& interval) {
  if (!interval) return nullptr;
  return Json::array({cli::NumberOrNull(interval->lower), cli::NumberOrNull(interval->upper)});
}

std::string_view KindWord(CauseKind kind) {
  switch (kind) {
    case CauseKind::kReading:
      return "reading";
    case CauseKind::kTuned:
      return "tuned";
    case CauseKind::kRounding:
      return "rounding";
  }
  return "reading";
}

Json CandidatesJson(const ThesisRow& row) {
  Json list = Json::array();
  for (const CandidateCause& cause : row.candidates) {
    list.push_back({{"text", cause.text},
                    {"kind", KindWord(cause.kind)},
                    {"gives", cli::NumberOrNull(cause.gives)},
                    {"from_rounded_interval", IntervalJson(cause.from_rounded)},
                    {"as_printed", Hits(row.number(), cause)}});
  }
  return list;
}

Json RowJson(const ThesisRow& row) {
  const ThesisNumber& number = row.number();
  const bool printed = number.relation != Relation::kNotPrinted;
  return {{"key", row.key},
          {"group", number.group},
          {"where", cli::TextOrNull(std::string(number.where))},
          {"what", number.what},
          {"relation", Name(number.relation)},
          {"printed", printed ? cli::NumberOrNull(SiValue(number)) : Json(nullptr)},
          {"printed_half_step", number.relation == Relation::kEquals
                                    ? cli::NumberOrNull(number.half_step * number.unit.si)
                                    : Json(nullptr)},
          {"unit", number.unit.si_name},
          {"ours", cli::NumberOrNull(row.ours)},
          {"ours_interval_95", IntervalJson(row.interval)},
          {"deviation", cli::NumberOrNull(DeviationOf(row))},
          {"verdict", Name(VerdictOf(row))},
          {"generated", row.generated},
          {"candidates", CandidatesJson(row)},
          {"remark", cli::TextOrNull(row.remark)}};
}

Json ChainJson(const std::optional<std::vector<ChainRow>>& rows) {
  if (!rows) return nullptr;
  Json list = Json::array();
  for (const ChainRow& row : *rows) {
    list.push_back({{"key", row.key},
                    {"sensor", row.sensor},
                    {"scene", row.scene},
                    {"quantity", row.quantity},
                    {"unit", row.unit},
                    {"truth", cli::NumberOrNull(row.truth)},
                    {"answer", cli::NumberOrNull(row.answer)},
                    {"answer_interval_95", IntervalJson(row.interval)},
                    {"holds", row.holds()},
                    {"remark", cli::TextOrNull(row.remark)}});
  }
  return list;
}

}  // namespace

std::string ReproductionJson(const Reproduction& reproduction,
                             const std::vector<std::string>& written) {
  Json rows = Json::array();
  for (const ThesisRow& row : reproduction.rows) rows.push_back(RowJson(row));
  return cli::JsonText({{"rows", std::move(rows)},
                        {"reproduced", CountOf(reproduction, RowVerdict::kReproduced)},
                        {"explained", CountOf(reproduction, RowVerdict::kExplained)},
                        {"explained_by_rounding", CountOf(reproduction, CauseKind::kRounding)},
                        {"explained_by_tuned", CountOf(reproduction, CauseKind::kTuned)},
                        {"disagree", CountOf(reproduction, RowVerdict::kDisagrees)},
                        {"not_printed", CountOf(reproduction, RowVerdict::kNotPrinted)},
                        {"circular", CircularRows(reproduction)},
                        {"chain", ChainJson(reproduction.chain)},
                        {"files", written},
                        {"assumptions", ReproductionAssumptions()}});
}

namespace {

std::string WithUnit(std::string number, std::string_view unit) {
  return unit.empty() ? number : fmt::format("{} {}", number, unit);
}

// as many decimals as are printed
std::string PrintedText(const ThesisNumber& number) {
  switch (number.relation) {
    case Relation::kNotPrinted:
      return "-";
    case Relation::kBelow:
      return WithUnit(fmt::format("< {:g}", number.value), number.unit.name);
    case Relation::kAbove:
      return WithUnit(fmt::format("> {:g}", number.value), number.unit.name);
    case Relation::kEquals:
      break;
  }
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(2 * number.half_step))));
  return WithUnit(fmt::format("{:.{}f}", number.value, decimals), number.unit.name);
}

std::string IntervalText(const std::optional<dsp::Interval>& interval, double si, int digits) {
  if (!interval) return {};
  return fmt::format(" [{:.{}g}, {:.{}g}]", interval->lower / si, digits, interval->upper / si,
                     digits);
}

std::string OursText(const ThesisRow& row) {
  if (!row.ours) return "not determined";
  const ThesisUnit& unit = row.number().unit;
  return WithUnit(
      fmt::format("{:.5g}{}", *row.ours / unit.si, IntervalText(row.interval, unit.si, 4)),
      unit.name);
}

std::string CauseText(const ThesisNumber& number, const CandidateCause& cause) {
  return fmt::format(
      "{}: {}: {}{}", Name(cause.kind), cause.text,
      WithUnit(fmt::format("{:.5g}", cause.gives / number.unit.si), number.unit.name),
      Hits(number, cause) ? ", as printed" : "");
}

std::string DeviationText(const std::optional<double>& deviation) {
  return deviation ? fmt::format("{:+.2f} %", 100 * *deviation) : std::string();
}

// broken at spaces into lines of kWhyColumns, six columns in
std::string Wrapped(std::string_view line) {
  constexpr std::size_t kWhyColumns = 110;
  std::string text = "      ";
  std::size_t column = 0;
  while (!line.empty()) {
    const std::size_t end = std::min(line.find(' '), line.size());
    if (column > 0 && column + 1 + end > kWhyColumns) {
      text += "\n        ";
      column = 2;
    } else if (column > 0) {
      text += ' ';
      ++column;
    }
    text += line.substr(0, end);
    column += end;
    line.remove_prefix(std::min(end + 1, line.size()));
  }
  return text + '\n';
}

void AppendRow(std::string& text, std::string_view what, const RowWords& words) {
  fmt::format_to(std::back_inserter(text), "  {:<49} {:>12} {:>25} {:>10}  {}\n", what,
                 words.printed, words.ours, words.deviation, words.verdict);
  for (const std::string& line : words.why) text += Wrapped(line);
}

std::string ChainText(const std::vector<ChainRow>& rows) {
  std::string text = "\nScene -> sensor -> record -> analyze: the answer beside the truth\n";
  std::string_view sensor;
  for (const ChainRow& row : rows) {
    if (row.sensor != sensor) {
      sensor = row.sensor;
      fmt::format_to(std::back_inserter(text), "\n{}\n", sensor);
    }
    AppendRow(text, fmt::format("{}: {}", row.scene, row.quantity), WordsOf(row));
  }
  const auto holding = std::ranges::count_if(rows, &ChainRow::holds);
  return text + fmt::format("\n{} of {} hold\n", holding, rows.size());
}

}  // namespace

RowWords WordsOf(const ThesisRow& row) {
  const ThesisNumber& number = row.number();
  RowWords words{.printed = PrintedText(number),
                 .ours = OursText(row),
                 .deviation = DeviationText(DeviationOf(row)),
                 .verdict = std::string(Name(VerdictOf(row))) + (row.generated ? " *" : ""),
                 .why = {}};
  if (!row.remark.empty()) words.why.push_back(row.remark);
  if (VerdictOf(row) == RowVerdict::kReproduced) return words;
  for (const CandidateCause& cause : row.candidates) words.why.push_back(CauseText(number, cause));
  return words;
}

RowWords WordsOf(const ChainRow& row) {
  const bool length = row.unit == "m";
  const double si = length ? 1e-6 : 1;
  const std::string_view unit = length ? "um" : row.unit;
  RowWords words{.printed = "-", .ours = "not answered", .deviation = {}, .verdict = {}, .why = {}};
  if (row.truth) words.printed = WithUnit(fmt::format("{:.6g}", *row.truth / si), unit);
  if (row.answer) {
    words.ours = WithUnit(
        fmt::format("{:.6g}{}", *row.answer / si, IntervalText(row.interval, si, 6)), unit);
  }
  if (row.truth && row.answer) words.deviation = DeviationText(*row.answer / *row.truth - 1);
  words.verdict = row.holds() ? "holds" : "misses";
  if (!row.remark.empty()) words.why.push_back(row.remark);
  return words;
}

std::string CountsText(const Reproduction& reproduction) {
  return fmt::format(
      "{} reproduced, {} explained by a candidate (of these {} only by the rounding of inputs, {} "
      "only by a tuned number), {} disagree; {} not printed; {} are of trials made with the "
      "printed "
      "number itself and not counted",
      CountOf(reproduction, RowVerdict::kReproduced), CountOf(reproduction, RowVerdict::kExplained),
      CountOf(reproduction, CauseKind::kRounding), CountOf(reproduction, CauseKind::kTuned),
      CountOf(reproduction, RowVerdict::kDisagrees), CountOf(reproduction, RowVerdict::kNotPrinted),
      CircularRows(reproduction));
}

std::string ReproductionText(const Reproduction& reproduction) {
  std::string text = fmt::format(
      "J. Lindsay, \"A Mechanical Amplifier for Haptic Feedback\", University of Washington, "
      "2013,\n"
      "computed anew: {}\n\n  {:<49} {:>12} {:>25} {:>10}  verdict\n",
      CountsText(reproduction), "", "printed", "ours", "deviation");
  std::string_view group;
  for (const ThesisRow& row : reproduction.rows) {
    const ThesisNumber& number = row.number();
    if (number.group != group) {
      group = number.group;
      fmt::format_to(std::back_inserter(text), "\n{}\n", group);
    }
    RowWords words = WordsOf(row);
    if (!number.where.empty()) words.verdict += fmt::format(" ({})", number.where);
    AppendRow(text, number.what, words);
  }
  text += '\n';
  for (const std::string& assumption : ReproductionAssumptions()) {
    fmt::format_to(std::back_inserter(text), "assumed: {}\n", assumption);
  }
  return reproduction.chain ? text + ChainText(*reproduction.chain) : text;
}

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
