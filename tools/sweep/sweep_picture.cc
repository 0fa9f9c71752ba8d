#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "base/text.h"
#include "tools/cli/csv_cell.h"
#include "tools/document/number_text.h"
#include "tools/plot/gnuplot.h"
#include "tools/sweep/sweep.h"

namespace haptometer::tools {
namespace {

// one curve per colour
constexpr std::size_t kMostCurves = 8;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

constexpr std::array<plot::Colour, kMostCurves> kColours{
    plot::kBlue,   plot::kOrange,  plot::kGreen, plot::kPurple,
    plot::kYellow, plot::kSkyBlue, plot::kBlack, plot::kGrey};

// a column as an axis names it, "drive frequency / Hz" of "drive.frequency_hz", and the factor of
// its numbers; `largest` chooses the unit
struct Axis {
  std::string quantity;
  std::string unit{};
  double factor = 1;
  [[nodiscard]] std::string label() const {
    return unit.empty() ? quantity : fmt::format("{} / {}", quantity, unit);
  }
};

Axis AxisOf(const std::string& name, const std::vector<double>& values) {
  const document::Unit unit = document::UnitOfName(name);
  double largest = 0;
  for (const double value : values) {
    if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
  }
  const document::SpokenUnit spoken = unit.For(largest);
  std::string quantity = name.substr(0, name.size() - unit.ending.size());
  std::ranges::replace_if(quantity, [](char c) { return c == '.' || c == '_'; }, ' ');
  if (quantity.ends_with(" rms")) quantity.replace(quantity.size() - 3, 3, "RMS");
  return {std::move(quantity), std::string(spoken.symbol), spoken.factor};
}

double NumberOrNaN(const std::string& cell) { return NumberFrom<double>(cell).value_or(kNaN); }

// column of a varied key: distinct values in the order of first appearance, and that of each row
struct KeyColumn {
  std::string name;
  bool is_logarithmic = false;
  std::vector<std::string> texts;
  std::vector<std::size_t> of_row;
  std::map<std::string, std::size_t> places;

  // place of the value of the next row
  void Take(const std::string& text) {
    const auto [found, is_new] = places.emplace(text, texts.size());
    if (is_new) texts.push_back(text);
    of_row.push_back(found->second);
  }
  [[nodiscard]] bool AreNumbers() const {
    return std::ranges::all_of(
        texts, [](const std::string& text) { return std::isfinite(NumberOrNaN(text)); });
  }
  // the values as numbers, or 0, 1, 2 ... for texts
  [[nodiscard]] std::vector<double> Numbers() const {
    const bool are_numbers = AreNumbers();
    std::vector<double> numbers(texts.size());
    for (std::size_t k = 0; k < texts.size(); ++k) {
      numbers[k] = are_numbers ? NumberOrNaN(texts[k]) : static_cast<double>(k);
    }
    return numbers;
  }
  [[nodiscard]] Axis axis() const {
    return AreNumbers() ? AxisOf(name, Numbers()) : AxisOf(name, {});
  }
  // positions of the values on the axis, in its unit
  [[nodiscard]] std::vector<double> Positions() const {
    std::vector<double> positions = Numbers();
    const double factor = AreNumbers() ? axis().factor : 1;
    for (double& position : positions) position *= factor;
    return positions;
  }
};

// the table's columns that a picture needs
struct SweepColumns {
  bool is_sampled = false;
  std::string label{};  // of the column that is drawn, with its unit
  std::vector<KeyColumn> keys{};
  std::vector<double> values{};  // NaN: not answered
};

SweepColumns ReadColumns(TableReader& reader, const std::string& column) {
  const TableHeader& header = reader.header();
  SweepColumns columns;
  for (std::size_t k = 0; k < header.varied; ++k) {
    KeyColumn key;
    key.name = header.columns[k + 1];
    // a range with equal ratios is drawn on a logarithmic axis
    const std::string log = fmt::format("# vary = {}=log:", key.name);
    key.is_logarithmic = std::ranges::any_of(
        header.question, [&](const std::string& line) { return line.starts_with(log); });
    columns.keys.push_back(std::move(key));
  }
  // samples of a Latin hypercube have no order: points without lines
  columns.is_sampled = std::ranges::any_of(header.question, [](const std::string& line) {
    return line.starts_with("# sampling = latin");
  });
  const auto place =
      static_cast<std::size_t>(std::ranges::find(header.columns, column) - header.columns.begin());
  for (auto row = reader.Next(); row; row = reader.Next()) {
    const std::vector<std::string> cells = cli::CellsOf(*row);
    // damaged rows are not drawn
    if (cells.size() != header.columns.size() || place >= cells.size()) continue;
    for (std::size_t k = 0; k < header.varied; ++k) columns.keys[k].Take(cells[k + 1]);
    columns.values.push_back(NumberOrNaN(cells[place]));
  }
  const Axis axis = AxisOf(column, columns.values);
  columns.label = axis.label();
  for (double& value : columns.values) value *= axis.factor;
  return columns;
}

plot::Panel PanelOver(const KeyColumn& key, const std::string& label) {
  plot::Panel panel{.x_label = key.axis().label(), .y_label = label};
  panel.log_axes = key.is_logarithmic ? plot::LogAxes::kX : plot::LogAxes::kNone;
  if (key.AreNumbers()) return panel;
  // texts are names at the ticks
  for (std::size_t k = 0; k < key.texts.size(); ++k) {
    panel.ticks.push_back({static_cast<double>(k), key.texts[k]});
  }
  return panel;
}

// rows for which `keep` holds, in the order of their positions
template <typename Keep>
plot::Series SeriesOver(const KeyColumn& key, const SweepColumns& columns, const Keep& keep) {
  const std::vector<double> positions = key.Positions();
  std::vector<std::pair<double, double>> points;
  for (std::size_t row = 0; row < columns.values.size(); ++row) {
    if (keep(row)) points.emplace_back(positions[key.of_row[row]], columns.values[row]);
  }
  std::ranges::sort(points, {}, &std::pair<double, double>::first);
  plot::Series series;
  series.x.reserve(points.size());
  series.y.reserve(points.size());
  for (const auto& [x, y] : points) {
    series.x.push_back(x);
    series.y.push_back(y);
  }
  return series;
}

plot::Style StyleOf(const SweepColumns& columns, std::size_t curve) {
  return {.mark = columns.is_sampled ? plot::Mark::kPoints : plot::Mark::kLinesPoints,
          .colour = kColours[curve % kColours.size()],
          .size = 0.3};
}

// one panel with a curve for each value of `other`, uniformly chosen where there are more than 8
plot::Panel CurvesOver(const KeyColumn& key, const KeyColumn& other, const SweepColumns& columns) {
  plot::Panel panel = PanelOver(key, columns.label);
  const std::size_t curves = std::min(other.texts.size(), kMostCurves);
  for (std::size_t k = 0; k < curves; ++k) {
    // first and last value are always among the chosen ones
    const std::size_t value = curves < 2 ? 0 : k * (other.texts.size() - 1) / (curves - 1);
    plot::Series series =
        SeriesOver(key, columns, [&](std::size_t row) { return other.of_row[row] == value; });
    const double position = other.Positions()[value];
    const Axis axis = other.axis();
    series.title = other.AreNumbers() ? fmt::format("{} {:.6g}{}{}", axis.quantity, position,
                                                    axis.unit.empty() ? "" : " ", axis.unit)
                                      : fmt::format("{} {}", axis.quantity, other.texts[value]);
    series.style = StyleOf(columns, k);
    panel.series.push_back(std::move(series));
  }
  return panel;
}

// uniform steps, to 1e-6: the cells of a map are of equal size
bool IsEven(const KeyColumn& key) {
  if (!key.AreNumbers() || key.texts.size() < 2) return false;
  const std::vector<double> x = key.Positions();
  const double step = x[1] - x[0];
  for (std::size_t k = 1; k < x.size(); ++k) {
    if (!(std::abs(x[k] - x[k - 1] - step) <= 1e-6 * std::abs(step))) return false;
  }
  return step != 0;
}

plot::Map MapOf(const SweepColumns& columns) {
  const KeyColumn& across = columns.keys[0];
  const KeyColumn& up = columns.keys[1];
  const std::vector<double> x = across.Positions();
  const std::vector<double> y = up.Positions();
  plot::Map map{.x_label = across.axis().label(),
                .y_label = up.axis().label(),
                .value_label = columns.label,
                .x_start = x[0],
                .x_step = x[1] - x[0],
                .y_start = y[0],
                .y_step = y[1] - y[0]};
  // points without an answer remain empty
  map.values.assign(x.size(), std::vector<double>(y.size(), kNaN));
  for (std::size_t row = 0; row < columns.values.size(); ++row) {
    map.values[across.of_row[row]][up.of_row[row]] = columns.values[row];
  }
  return map;
}

Result<void> DrawPoints(const std::string& path, const SweepColumns& columns) {
  std::vector<plot::Panel> panels;
  panels.reserve(columns.keys.size());
  for (const KeyColumn& key : columns.keys) {
    plot::Panel panel = PanelOver(key, columns.label);
    panel.series.push_back(SeriesOver(key, columns, [](std::size_t) { return true; }));
    panel.series.back().style = StyleOf(columns, 0);
    panels.push_back(std::move(panel));
  }
  return plot::DrawPanels(path, panels);
}

}  // namespace

Result<void> CheckPicture(const std::string& path, const TableHeader& header) {
  // a picture is checked against the header before the sweep
  if (path.empty()) return {};
  if (!header.shard.empty()) {
    return Usage("--plot", "draws whole sweeps, not a shard", "give it to --merge");
  }
  if (header.varied > 2) {
    return Usage("--plot", fmt::format("draws one or two varied keys, not {}", header.varied),
                 "vary fewer, or draw from the table");
  }
  return plot::CheckPlotPath(path);
}

Result<void> DrawSweep(const std::string& path, const std::string& table,
                       const std::string& column) {
  HAPTOMETER_LET(auto reader, TableReader::Open(table));
  const SweepColumns columns = ReadColumns(reader, column);
  const bool has_value =
      std::ranges::any_of(columns.values, [](double v) { return std::isfinite(v); });
  if (!has_value) return CannotAnswer(path, fmt::format("no point has a {} to draw", column));
  // one key, or samples: a panel per key
  if (columns.keys.size() == 1 || columns.is_sampled) return DrawPoints(path, columns);
  // the longer axis is horizontal
  const bool first_is_longer = columns.keys[0].texts.size() >= columns.keys[1].texts.size();
  const KeyColumn& longer = columns.keys[first_is_longer ? 0 : 1];
  const KeyColumn& shorter = columns.keys[first_is_longer ? 1 : 0];
  // more values than curves on a uniform grid: a map
  if (shorter.texts.size() > kMostCurves && IsEven(longer) && IsEven(shorter)) {
    return plot::DrawMap(path, MapOf(columns));
  }
  return plot::DrawPanels(path, {CurvesOver(longer, shorter, columns)});
}

}  // namespace haptometer::tools
