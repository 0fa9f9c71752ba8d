#include "trial/import/column_doubts.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "trial/import/printed_number.h"
#include "trial/import/table_cells.h"

namespace haptometer::trial {
namespace {

constexpr std::size_t kRows = 8;
constexpr double kEven = 0.05;

bool GrowsEvenly(const std::vector<double>& values) {
  const double step = (values.back() - values.front()) / static_cast<double>(values.size() - 1);
  if (!(step > 0)) return false;
  for (std::size_t k = 1; k < values.size(); ++k) {
    if (!(std::abs(values[k] - values[k - 1] - step) <= kEven * step)) return false;
  }
  return true;
}

}  // namespace

std::vector<std::string> OverriddenUnits(const std::vector<CsvColumn>& said,
                                         const std::vector<CsvColumn>& read) {
  std::vector<std::string> remarks;
  if (said.size() != read.size()) return remarks;
  for (std::size_t i = 0; i < read.size(); ++i) {
    if (said[i].unit.empty() || read[i].kind == CsvColumnKind::kLeftOut) continue;
    if (said[i].unit == read[i].unit && said[i].factor == read[i].factor) continue;
    remarks.push_back(
        fmt::format("column {} holds units of {:g} {} by the file and of {:g} {} by --columns or "
                    "--scale; the file is not believed",
                    i + 1, said[i].factor, said[i].unit, read[i].factor, read[i].unit));
  }
  return remarks;
}

std::size_t EvenColumn(std::string_view rows, char separator, std::size_t except) {
  std::vector<std::vector<double>> columns;
  std::size_t count = 0;
  for (; count < kRows && !rows.empty(); ++count) {
    const std::size_t end = std::min(rows.find('\n'), rows.size() - 1);
    const auto cells = SplitCells(Trimmed(rows.substr(0, end + 1)), separator);
    rows.remove_prefix(end + 1);
    if (columns.empty()) columns.resize(cells.size());
    if (cells.size() != columns.size()) return 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      columns[i].push_back(
          ReadNumberWithComma(cells[i]).value_or(std::numeric_limits<double>::quiet_NaN()));
    }
  }
  if (count < kRows) return 0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (i + 1 != except && GrowsEvenly(columns[i])) return i + 1;
  }
  return 0;
}

}  // namespace haptometer::trial
