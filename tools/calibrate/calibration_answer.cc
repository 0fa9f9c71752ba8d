#include "tools/calibrate/calibration_answer.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "acquire/protocol/keyence/dl_rs1a.h"
#include "base/input_file.h"
#include "base/text.h"
#include "base/toml.h"
#include "dsp/statistics/distributions.h"
#include "tools/study/text_table.h"
#include "trial/import/table/named_columns.h"
#include "trial/import/table/row_numbers.h"

namespace haptometer::tools {
namespace {

// the least length and voltage of base/quantity.h
constexpr double kLeastStated = 1e-15;
constexpr double kErrorLevelV = 1e-3 * acquire::dl_rs1a::kAnalogErrorMv;
// DAQ and amplifier may differ by so much there
constexpr double kErrorToleranceV = 0.05;
// what an amplifier's output of +-5 V reaches at most; above it stands its error level
constexpr double kHighestReadingV = 5.25;

constexpr KnownColumn kDisplacements[]{
    {"displacement_m", 1}, {"displacement_mm", 1e-3}, {"displacement_um", 1e-6}};
constexpr KnownColumn kVoltages[]{{"voltage_v", 1}, {"voltage_mv", 1e-3}};
constexpr KnownColumn kDisplacementUncertainties[]{{"displacement_standard_uncertainty_m", 1},
                                                   {"displacement_standard_uncertainty_mm", 1e-3},
                                                   {"displacement_standard_uncertainty_um", 1e-6}};
constexpr KnownColumn kVoltageUncertainties[]{{"voltage_standard_uncertainty_v", 1},
                                              {"voltage_standard_uncertainty_mv", 1e-3}};
constexpr std::string_view kHeader = "displacement_mm,voltage_v";

// names of the table's displacements and voltages, with factors to SI
struct PairColumns {
  std::vector<KnownColumn> displacements{std::begin(kDisplacements), std::end(kDisplacements)};
  std::vector<KnownColumn> voltages{std::begin(kVoltages), std::end(kVoltages)};
};

// Other names are known by their units, as analyze knows them: "Weg (mm)". A column that is none
// of these would be passed over with its meaning; row numbers have none.
Result<PairColumns> ColumnsOf(const TextTable& table) {
  PairColumns columns_of;
  std::vector<std::string> known;
  for (const std::span<const KnownColumn> columns :
       {std::span<const KnownColumn>(kDisplacements), std::span<const KnownColumn>(kVoltages),
        std::span<const KnownColumn>(kDisplacementUncertainties),
        std::span<const KnownColumn>(kVoltageUncertainties)}) {
    for (const KnownColumn& column : columns) known.emplace_back(column.name);
  }
  const auto has_any = [&table](std::span<const KnownColumn> columns) {
    return std::ranges::any_of(columns, [&table](const KnownColumn& one) {
      return table.columns.contains(std::string(one.name));
    });
  };
  const bool has_displacement = has_any(kDisplacements);
  const bool has_voltage = has_any(kVoltages);
  for (const auto& [name, cells] : table.columns) {
    if (std::ranges::count(known, name) > 0 || trial::IsRowNumberName(name)) continue;
    // beside a column of this program another one of its quantity has no known meaning
    const trial::CsvColumn quantity = trial::ReadQuantity(name);
    const KnownColumn column{name, quantity.factor};
    if (quantity.role == trial::ChannelRole::kDisplacement && !has_displacement) {
      columns_of.displacements.push_back(column);
      continue;
    }
    if (quantity.role == trial::ChannelRole::kVoltage && !has_voltage) {
      columns_of.voltages.push_back(column);
      continue;
    }
    const std::string nearest = Nearest(name, known);
    return CannotAnswer(table.name, fmt::format("has a column '{}', which is none of pairs", name),
                        nearest.empty()
                            ? fmt::format("its header is {}, with the units in the names", kHeader)
                            : fmt::format("is it {}?", nearest));
  }
  return columns_of;
}

Result<std::vector<double>> RequiredColumn(const TextTable& table,
                                           std::span<const KnownColumn> known,
                                           std::string_view what) {
  HAPTOMETER_LET(auto column, FindColumn(table, known));
  if (column) return *std::move(column);
  return CannotAnswer(table.name, fmt::format("has no {} with its unit", what),
                      fmt::format("its header is {}", kHeader));
}

// uncertainties of a column, of an option, or none (0)
Result<std::vector<double>> Uncertainties(const TextTable& table,
                                          std::span<const KnownColumn> known,
                                          std::optional<double> of_all, const char* option,
                                          bool* are_stated) {
  HAPTOMETER_LET(auto column, FindColumn(table, known));
  if (column && of_all) {
    return Usage(option, fmt::format("{} states the uncertainties itself", table.name),
                 "leave one of the two out");
  }
  *are_stated = *are_stated || column || of_all;
  if (!column) return std::vector<double>(table.rows(), of_all.value_or(0));
  const auto below = std::ranges::find_if(*column, [](double u) { return u < 0; });
  if (below == column->end()) return *std::move(column);
  const std::size_t line = table.lines[static_cast<std::size_t>(below - column->begin())];
  return CannotAnswer(fmt::format("{}:{}", table.name, line), "has a standard uncertainty below 0",
                      "correct that cell");
}

// Excludes the points at +5.5 V, the amplifier's error level, unless all of them fit the line of
// the others, or the output goes beyond.
void ExcludeErrorLevel(CalibrationPoints* found) {
  const auto is_there = [](const fit::LinePoint& point) {
    return std::abs(point.x - kErrorLevelV) <= kErrorToleranceV;
  };
  const auto is_above = [](const fit::LinePoint& point) {
    return point.x > kErrorLevelV + kErrorToleranceV;
  };
  if (std::ranges::none_of(found->points, is_there)) return;
  if (std::ranges::any_of(found->points, is_above)) return;
  CalibrationPoints rest = *found;
  rest.points.clear();
  rest.lines.clear();
  for (std::size_t i = 0; i < found->points.size(); ++i) {
    if (is_there(found->points[i])) {
      rest.error_level.push_back(found->lines[i]);
    } else {
      rest.points.push_back(found->points[i]);
      rest.lines.push_back(found->lines[i]);
    }
  }
  const auto line = fit::FitStraightLine(rest.points, found->scatter);
  const auto fits = [&](const fit::LinePoint& point) {
    return !is_there(point) ||
           std::abs((point.y - line->intercept) / line->slope - point.x) <= kErrorToleranceV;
  };
  if (!line || !std::ranges::all_of(found->points, fits)) *found = std::move(rest);
}

}  // namespace

Result<CalibrationPoints> ReadPairs(const std::string& path,
                                    std::optional<double> input_uncertainty_v,
                                    std::optional<double> displacement_uncertainty_m,
                                    const trial::RawLimits& rails) {
  constexpr std::uint64_t kMostBytes = 1ULL << 24;
  HAPTOMETER_LET(const auto text, ReadInputFile(path, kMostBytes));
  if (text.find('\0') != std::string::npos) {
    return CannotAnswer(path, "is no table", fmt::format("give a CSV whose header is {}", kHeader));
  }
  HAPTOMETER_LET(const auto table, ReadTextTable(path, {}));
  HAPTOMETER_LET(const auto columns, ColumnsOf(table));
  HAPTOMETER_LET(const auto metres, RequiredColumn(table, columns.displacements, "displacement"));
  HAPTOMETER_LET(const auto volts, RequiredColumn(table, columns.voltages, "voltage"));
  bool are_stated = false;
  HAPTOMETER_LET(const auto of_metres,
                 Uncertainties(table, kDisplacementUncertainties, displacement_uncertainty_m,
                               "--displacement-uncertainty", &are_stated));
  HAPTOMETER_LET(const auto of_volts,
                 Uncertainties(table, kVoltageUncertainties, input_uncertainty_v,
                               "--voltage-uncertainty", &are_stated));

  CalibrationPoints found;
  found.scatter = are_stated ? fit::Scatter::kStated : fit::Scatter::kFromResiduals;
  for (std::size_t i = 0; i < volts.size(); ++i) {
    if (volts[i] <= rails.rail_min || volts[i] >= rails.rail_max) {
      found.at_rail.push_back(table.lines[i]);
    } else if (are_stated && of_volts[i] == 0 && of_metres[i] == 0) {
      return CannotAnswer(fmt::format("{}:{}", path, table.lines[i]), "is stated to be exact",
                          "give one of its uncertainties above 0");
    } else {
      // without a statement all noise is in the voltage, and of one size
      found.points.push_back({volts[i], metres[i], are_stated ? of_volts[i] : 1, of_metres[i]});
      found.lines.push_back(table.lines[i]);
    }
  }
  ExcludeErrorLevel(&found);
  return found;
}

namespace {

// points of one size of noise: of each quantity that of the means, pooled over all
std::vector<fit::LinePoint> LineOf(const std::vector<StillPoint>& points,
                                   MeanValue StillPoint::* y) {
  double of_x = 0;
  double of_y = 0;
  for (const StillPoint& point : points) {
    of_x += std::pow(point.input_v.standard_error, 2) / static_cast<double>(points.size());
    of_y += std::pow((point.*y).standard_error, 2) / static_cast<double>(points.size());
  }
  // readings that all agree have no scatter: then the DAQ's alone counts, or any
  if (of_x == 0 && of_y == 0) of_x = 1;
  std::vector<fit::LinePoint> line;
  line.reserve(points.size());
  for (const StillPoint& point : points) {
    line.push_back({point.input_v.mean, (point.*y).mean, std::sqrt(of_x), std::sqrt(of_y)});
  }
  return line;
}

}  // namespace

Result<CalibrationPoints> PointsOf(ReferencePoints found, const trial::Metadata& reference,
                                   std::size_t wanted) {
  constexpr std::size_t kLeastPoints = 3;
  if (found.points.size() < kLeastPoints && found.input_ended) {
    return CannotAnswer(
        "--input",
        fmt::format("its program ended after {} of {} points", found.points.size(), wanted),
        "check that it can be started as written, and writes a line of volts for each sample until "
        "it is stopped");
  }
  if (found.points.size() < kLeastPoints) {
    const char* why = found.error_level > 0 ? "the output stood at +5.5 V, the amplifier's error "
                                              "level, which is no reading"
                      : found.moving > 0    ? "the target moved, or scattered by more than --still"
                      : found.at_rail > 0   ? "the DAQ was at the end of its range"
                                            : "the target stayed where it was";
    return CannotAnswer(
        Printable(reference.source),
        fmt::format("{} of {} points were still: {}", found.points.size(), wanted, why),
        "hold the target still for three seconds at each place");
  }
  CalibrationPoints points{.points = LineOf(found.points, &StillPoint::displacement_m),
                           .analog = LineOf(found.points, &StillPoint::analog_v)};
  points.windows = std::move(found);
  points.wanted = wanted;
  points.reference = reference;
  return points;
}

double CalibrationAnswer::RelativeUncertainty() const {
  return std::hypot(fit.relative_uncertainty, scale_uncertainty);
}

std::optional<double> CalibrationAnswer::BadAboveV() const {
  const bool is_below = std::ranges::all_of(
      measured.points, [](const fit::LinePoint& point) { return point.x <= kHighestReadingV; });
  return is_below ? std::optional(kHighestReadingV) : std::nullopt;
}

std::string CalibrationAnswer::NameOf(std::size_t point) const {
  return measured.lines.empty() ? fmt::format("point {}", point + 1)
                                : fmt::format("line {} of the table", measured.lines[point]);
}

Result<CalibrationAnswer> AnswerOf(CalibrationPoints points) {
  CalibrationAnswer answer;
  answer.measured = std::move(points);
  HAPTOMETER_LET(answer.fit, fit::FitCalibration(answer.measured.points, answer.measured.scatter));
  if (!answer.measured.analog.empty()) {
    HAPTOMETER_LET(answer.daq,
                   fit::FitCalibration(answer.measured.analog, answer.measured.scatter));
  }
  return answer;
}

Result<CalibrationCheck> CheckAgainst(const std::string& path, const CalibrationAnswer& answer) {
  const trial::ChannelFormat format{.name = "displacement",
                                    .role = trial::ChannelRole::kDisplacement};
  HAPTOMETER_LET(const auto calibration, trial::ReadCalibrationFile(path, {&format, 1}));
  CalibrationCheck check{.file = path, .stated = calibration.channels.at(format.name)};
  const trial::ChannelCalibration& stated = check.stated;
  if (!stated.gain_uncertainty && !stated.scale_uncertainty) {
    return CannotAnswer(path, "states no uncertainty of its gain",
                        "add relative_standard_uncertainty, or make it by calibrate");
  }
  // uncertainties as those of many degrees of freedom: u t / 1.96
  const double of_file =
      stated.degrees_of_freedom
          ? dsp::StudentCritical(*stated.degrees_of_freedom) / dsp::kNormalCritical
          : 1;
  const double file_gain = stated.gain_uncertainty
                               ? *stated.gain_uncertainty * std::abs(stated.scale)
                               : of_file * *stated.scale_uncertainty;
  const fit::StraightLine& line = answer.fit.line;
  check.gain_error = fit::NormalizedError(
      line.slope, answer.RelativeUncertainty() * std::abs(line.slope), stated.scale, file_gain);
  // in the middle of today's points the lines' gains hardly matter
  const auto [least, most] = std::ranges::minmax(answer.measured.points, {}, &fit::LinePoint::x);
  const double middle = (least.x + most.x) / 2;
  const double today_m = line.intercept + line.slope * middle;
  const double stated_m = stated.offset + stated.scale * middle;
  check.shift_m = today_m - stated_m;
  if (stated.offset_uncertainty && stated.scale_uncertainty) {
    const fit::StraightLine of_then{.slope_uncertainty = *stated.scale_uncertainty,
                                    .intercept_uncertainty = *stated.offset_uncertainty,
                                    .covariance = stated.covariance};
    check.shift_error = fit::NormalizedError(
        today_m, line.UncertaintyAt(middle) * line.coverage_95 / dsp::kNormalCritical, stated_m,
        of_file * of_then.UncertaintyAt(middle));
  }
  return check;
}

std::string CalibrationText(const CalibrationAnswer& answer,
                            const document::Provenance& provenance) {
  const fit::StraightLine& line = answer.fit.line;
  const auto [least, most] = std::ranges::minmax(answer.measured.points, {}, &fit::LinePoint::x);
  constexpr std::size_t kDateLength = 10;  // 2026-03-01
  std::string text = fmt::format("# written by haptometer calibrate\ndate = {}\n",
                                 TomlString(provenance.utc.substr(0, kDateLength)));
  const auto number = [&text](std::string_view key, double value) {
    if (std::isfinite(value)) text += fmt::format("{} = {}\n", key, value);
  };
  // of lengths and voltages what is smaller than a file may state is rounding
  const auto rounded = [](double value) { return std::abs(value) < kLeastStated ? 0 : value; };
  if (answer.averaging.averages) text += fmt::format("averages = {}\n", *answer.averaging.averages);
  if (answer.averaging.sampling_s) number("sampling_s", *answer.averaging.sampling_s);

  text += fmt::format("\n[displacement]\n");
  number("scale_m_per_v", line.slope);
  number("offset_m", rounded(line.intercept));
  number("scale_standard_uncertainty_m_per_v", line.slope_uncertainty);
  number("offset_standard_uncertainty_m", rounded(line.intercept_uncertainty));
  number("scale_offset_covariance_m2_per_v",
         rounded(line.intercept_uncertainty) == 0 ? 0 : line.covariance);
  if (line.coverage_95 > 1.0001 * dsp::kNormalCritical) {
    number("degrees_of_freedom", line.degrees_of_freedom);
  }
  // a share of 0, of points without noise, is none that a budget could hold
  if (answer.RelativeUncertainty() > 0) {
    number("relative_standard_uncertainty", answer.RelativeUncertainty());
  }
  number("nonlinearity_m", rounded(answer.fit.nonlinearity));
  if (answer.fit.hysteresis) number("hysteresis_m", rounded(answer.fit.hysteresis->difference));
  number("calibrated_min_v", rounded(least.x));
  number("calibrated_max_v", rounded(most.x));
  if (const auto bad_above_v = answer.BadAboveV()) number("bad_above_v", *bad_above_v);
  number("daq_min_v", answer.limits.rail_min);
  number("daq_max_v", answer.limits.rail_max);

  text += "\n[provenance]\n";
  const auto said = [&text](std::string_view key, const std::string& value) {
    if (!value.empty()) text += fmt::format("{} = {}\n", key, TomlString(value));
  };
  said("version", provenance.version);
  said("command", provenance.command);
  said("utc", provenance.utc);
  said("source", answer.measured.reference.source);
  said("head", answer.measured.reference.head);
  for (std::size_t i = 0; i < provenance.inputs.size(); ++i) {
    const document::InputFile& input = provenance.inputs[i];
    said(fmt::format("input_{}", i + 1),
         fmt::format("{}, {} bytes, SHA-256 {}", Printable(input.path), input.bytes, input.sha256));
  }
  return text;
}

}  // namespace haptometer::tools
