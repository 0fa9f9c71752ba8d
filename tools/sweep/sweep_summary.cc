#include "tools/sweep/sweep_summary.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/text.h"
#include "tools/cli/csv_cell.h"
#include "tools/cli/json.h"
#include "tools/sweep/answer_columns.h"

namespace haptometer::tools {
namespace {

using nlohmann::ordered_json;

constexpr std::string_view kLeast = ":least";

// a cell that is a number from end to end
std::optional<double> NumberOf(const std::string& cell) {
  double number = 0;
  const char* end = cell.data() + cell.size();
  const auto [stop, failure] = std::from_chars(cell.data(), end, number);
  if (failure != std::errc{} || stop != end) return std::nullopt;
  return number;
}

void TakeBest(SweepSummary& summary, const std::vector<std::string>& cells, std::size_t column) {
  const auto value = NumberOf(cells[column]);
  if (!value) return;
  ++summary.compared;
  const bool is_better = !summary.best || (summary.wish.least ? *value < summary.best->value
                                                              : *value > summary.best->value);
  if (!is_better) return;
  const auto first = cells.begin() + 1;
  summary.best =
      BestRow{.value = *value,
              .point = PointOfRow(cells.front()).value_or(0),
              .values = {first, first + static_cast<std::ptrdiff_t>(summary.header.varied)}};
}

void TakeRow(SweepSummary& summary, const std::vector<std::string>& cells, std::size_t column) {
  ++summary.rows;
  const auto first = cells.begin() + 1 + static_cast<std::ptrdiff_t>(summary.header.varied);
  const std::size_t remark = summary.header.columns.size() - 2;
  const auto end = cells.begin() + static_cast<std::ptrdiff_t>(remark);
  if (std::any_of(first, end, [](const std::string& cell) { return !cell.empty(); })) {
    ++summary.answered;
    TakeBest(summary, cells, column);
  } else if (summary.first_remark.empty()) {
    summary.first_remark = fmt::format("point {}: {}", cells.front(), cells[remark]);
  }
}

std::string BestName(const BestWish& wish) {
  return fmt::format("{} {}", wish.least ? "least" : "largest", wish.column);
}

}  // namespace

Result<BestWish> ReadBestWish(const std::string& word) {
  BestWish wish;
  wish.least = word.ends_with(kLeast);
  wish.column = wish.least ? word.substr(0, word.size() - kLeast.size()) : word;
  std::vector<std::string> names;
  for (const AnswerColumn& column : AnswerColumns()) names.emplace_back(column.name);
  if (std::ranges::find(names, wish.column) != names.end()) return wish;
  const std::string nearest = Nearest(wish.column, names);
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return Usage("--best", fmt::format("'{}' is no column of the answers", wish.column),
               nearest.empty() ? "use one of " + all : fmt::format("did you mean {}?", nearest));
}

Result<SweepSummary> Summarise(const std::string& table, const BestWish& wish) {
  auto reader = TableReader::Open(table);
  if (!reader) return std::unexpected(reader.error());
  SweepSummary summary{.table = table,
                       .header = reader->header(),
                       .wish = wish,
                       .first_remark = {},
                       .best = {},
                       .plot = {}};
  const std::vector<std::string>& columns = summary.header.columns;
  const auto found = std::ranges::find(columns, wish.column);
  if (found == columns.end()) {
    return CannotAnswer(table, fmt::format("has no column {}", wish.column),
                        "name one of its own by --best");
  }
  const auto column = static_cast<std::size_t>(found - columns.begin());
  for (auto row = reader->Next(); row; row = reader->Next()) {
    const std::vector<std::string> cells = cli::CellsOf(*row);
    if (cells.size() == columns.size()) TakeRow(summary, cells, column);
  }
  return summary;
}

std::string SummaryText(const SweepSummary& summary) {
  const std::string shard =
      summary.header.shard.empty() ? "" : fmt::format(" (shard {})", summary.header.shard);
  std::string text = fmt::format("{}: {} of {} points{}, {} answered\n", summary.table,
                                 summary.rows, summary.header.points, shard, summary.answered);
  if (summary.best) {
    text += fmt::format("  {}: {:.6g} at point {}", BestName(summary.wish), summary.best->value,
                        summary.best->point);
    for (std::size_t k = 0; k < summary.best->values.size(); ++k) {
      text += fmt::format(", {} = {}", summary.header.columns[k + 1], summary.best->values[k]);
    }
    if (summary.compared < summary.answered) {
      text += fmt::format(" (compared: {} of {} rows, the others have none)", summary.compared,
                          summary.answered);
    }
    text += '\n';
  } else if (summary.answered > 0) {
    text += fmt::format("  {}: no row has one\n", BestName(summary.wish));
  }
  if (!summary.plot.empty()) text += fmt::format("  drawn: {}\n", summary.plot);
  return text;
}

std::string SummaryJson(const SweepSummary& summary) {
  ordered_json document{{"table", summary.table},
                        {"points", summary.header.points},
                        {"shard", cli::TextOrNull(summary.header.shard)},
                        {"rows", summary.rows},
                        {"answered", summary.answered},
                        {"varied", ordered_json::array()},
                        {"best", nullptr},
                        {"plot", cli::TextOrNull(summary.plot)}};
  for (std::size_t k = 0; k < summary.header.varied; ++k) {
    document["varied"].push_back(summary.header.columns[k + 1]);
  }
  if (summary.best) {
    ordered_json values;
    for (std::size_t k = 0; k < summary.best->values.size(); ++k) {
      const std::string& text = summary.best->values[k];
      const auto number = NumberOf(text);
      values[summary.header.columns[k + 1]] = number ? ordered_json(*number) : ordered_json(text);
    }
    document["best"] = {
        {"column", summary.wish.column}, {"direction", summary.wish.least ? "least" : "largest"},
        {"value", summary.best->value},  {"rows_compared", summary.compared},
        {"point", summary.best->point},  {"values", values}};
  }
  return cli::JsonText(document);
}

}  // namespace haptometer::tools
