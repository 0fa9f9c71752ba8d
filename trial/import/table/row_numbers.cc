#include "trial/import/table/row_numbers.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <utility>

#include "trial/import/table/table_cells.h"

namespace haptometer::trial {
namespace {

// beyond it whole numbers are not exact
constexpr double kMostNumber = 0x1p53;
// share of rows behind missing ones: whole milliseconds of 700 rows/s jump at 43 % of them
constexpr double kMostJumps = 0.1;

}  // namespace

bool IsRowNumberName(std::string_view name) {
  constexpr std::string_view kNames[]{"",
                                      "#",
                                      "no",
                                      "no.",
                                      "nr",
                                      "nr.",
                                      "number",
                                      "row",
                                      "row no.",
                                      "index",
                                      "point",
                                      "points",
                                      "sample",
                                      "samples",
                                      "scan",
                                      "sample no.",
                                      "sample number",
                                      "sample_number",
                                      "sample index",
                                      "samplenr"};
  return std::ranges::find(kNames, LowerCase(Trimmed(name))) != std::end(kNames);
}

void RowNumbers::Add(double number, std::size_t line) {
  const std::size_t row = rows_++;
  const double step = number - std::exchange(last_, number);
  if (bad_line_ > 0) return;
  const bool is_whole = std::abs(number) < kMostNumber && number == std::floor(number);
  if (!is_whole || (row > 0 && !(step > 0))) {
    bad_line_ = line;
    return;
  }
  if (row == 0) return;
  if (runs_.empty() || runs_.back().step != step) {
    runs_.push_back({.first_row = row, .line = line, .step = step});
  }
  ++runs_.back().rows;
}

// the step of most rows; of several, the least
double RowNumbers::UsualStep() const {
  std::map<double, std::size_t> rows;
  for (const Run& run : runs_) rows[run.step] += run.rows;
  return std::ranges::max_element(rows, {}, [](const auto& step) { return step.second; })->first;
}

std::vector<Stretch> RowNumbers::Divide(const Stretch& whole, Findings* findings) const {
  const double usual = runs_.empty() ? 1 : UsualStep();
  const auto jump = std::ranges::find_if(runs_, [&](const Run& run) { return run.step != usual; });
  auto uneven =
      std::ranges::find_if(runs_, [&](const Run& run) { return std::fmod(run.step, usual) != 0; });
  std::size_t jumps = 0;
  for (const Run& run : runs_) jumps += run.step == usual ? 0 : run.rows;
  // many: times in whole units, or what else is no number of rows
  const bool is_other = static_cast<double>(jumps) > kMostJumps * static_cast<double>(whole.rows);
  if (is_other && uneven == runs_.end()) uneven = jump;
  // which rows are missing can be stated where all numbers lie on one grid
  if (bad_line_ > 0 || uneven != runs_.end()) {
    findings->Doubt(FindingKind::kRowNumbersUneven,
                    {{"line", bad_line_ > 0 ? bad_line_ : uneven->line}});
    return {whole};
  }
  std::vector<Stretch> stretches{whole};
  double missing = 0;
  for (const Run& run : runs_) {
    if (run.step == usual) continue;
    // each row of the run lies behind missing ones
    for (std::size_t row = run.first_row; row < run.first_row + run.rows; ++row) {
      missing += run.step / usual - 1;
      stretches.back().rows = row - stretches.back().first_row;
      Stretch next = whole;
      next.first_row = row;
      next.start_s += (static_cast<double>(row) + missing) / whole.rate_hz;
      stretches.push_back(next);
    }
  }
  stretches.back().rows = whole.rows - stretches.back().first_row;
  if (jump != runs_.end()) {
    findings->Note(FindingKind::kRowsMissing, {{"missing", static_cast<std::int64_t>(missing)},
                                               {"places", stretches.size() - 1},
                                               {"line", jump->line}});
  }
  return stretches;
}

}  // namespace haptometer::trial
