#include "tools/study/linearity.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "tools/study/study_document.h"
#include "tools/study/study_table.h"
#include "tools/study/text_table.h"

namespace haptometer::tools {
namespace {

// a CSV with drive and RMS, recognised by its header
bool IsSweepTable(const std::string& path) {
  if (std::filesystem::path(path).extension() != ".csv") return false;
  return ReadTextTable(path, {"drive_v", "rms_m"}).has_value();
}

Result<void> TakeTable(const std::string& path, DriveReadings& taken) {
  HAPTOMETER_LET(const auto table, ReadTextTable(path, {"drive_v", "rms_m"}));
  HAPTOMETER_LET(const auto drive, NumbersOf(table, "drive_v"));
  HAPTOMETER_LET(const auto rms, NumbersOf(table, "rms_m"));
  // subject and condition are optional columns
  const auto text = [&](const std::string& column, std::size_t row) {
    const auto found = table.columns.find(column);
    return found == table.columns.end() ? std::string() : found->second[row];
  };
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (drive[i] < 0 || rms[i] < 0) {
      return CannotAnswer(fmt::format("{}:{}", path, table.lines[i]),
                          "has a negative amplitude or RMS", "correct that line");
    }
    taken.readings.push_back({text("subject", i), text("condition", i), drive[i], rms[i]});
  }
  return {};
}

// An error of a trial excludes that trial only. The RMS includes the noise, because
// AnalyzeLinearity subtracts the same floor from all readings.
Result<DriveReading> ReadingOf(const StudyTrial& trial) {
  if (trial.error) return std::unexpected(*trial.error);
  if (!trial.rms_with_floor_m) {
    const std::vector<std::string> reasons = ReasonsOf(trial);
    return CannotAnswer(trial.file, reasons.empty() ? "has no RMS" : reasons.front(), "");
  }
  if (!trial.drive_v || !(*trial.drive_v >= 0)) {
    return CannotAnswer(trial.file, "does not state its drive_amplitude_v",
                        "give a table with drive_v,rms_m");
  }
  return DriveReading{trial.subject, trial.condition, *trial.drive_v, *trial.rms_with_floor_m};
}

}  // namespace

DriveReadings ReadDriveReadings(const std::vector<std::string>& files,
                                const dsp::BandQuestion& question,
                                const trial::ImportOptions& import) {
  DriveReadings taken;
  std::set<document::DataSource> sources;
  std::vector<TrialFile> trials;
  for (const std::string& path : files) {
    if (!IsSweepTable(path)) {
      trials.push_back({.path = path});
    } else if (auto read = TakeTable(path, taken); !read) {
      taken.errors.push_back(read.error());
    } else {
      // a table's origin is not stated in it
      sources.insert(document::DataSource::kImported);
    }
  }
  for (const StudyTrial& trial : AnalyzeTrials(trials, question, import)) {
    if (auto reading = ReadingOf(trial)) {
      taken.readings.push_back(*std::move(reading));
      sources.insert(trial.sources.begin(), trial.sources.end());
    } else {
      taken.errors.push_back(reading.error());
    }
  }
  taken.sources.assign(sources.begin(), sources.end());
  return taken;
}

namespace {

// RMS of the readings at 0 V: root of their mean square
std::optional<double> DriveOffRms(const std::vector<DriveReading>& readings) {
  std::vector<double> off;
  for (const DriveReading& reading : readings) {
    if (reading.drive_v == 0) off.push_back(reading.rms_m);
  }
  return off.empty() ? std::nullopt : std::optional(dsp::Rms(off));
}

// line RMS = intercept + slope x drive, after subtraction of the floor in mean square
DriveLine LineOf(const std::vector<DriveReading>& readings, const std::optional<double>& floor_m) {
  DriveLine line;
  line.subject = readings.front().subject;
  line.condition = readings.front().condition;
  // a stated floor overrides the readings at 0 V
  line.floor_m = floor_m ? floor_m : DriveOffRms(readings);
  const double floor_power = line.floor_m ? *line.floor_m * *line.floor_m : 0;
  for (const DriveReading& reading : readings) {
    if (reading.drive_v == 0) continue;
    const double power = reading.rms_m * reading.rms_m - floor_power;
    // at or below the floor no amplitude remains; counted
    if (!(power > 0)) {
      ++line.below_floor;
      continue;
    }
    line.drive_v.push_back(reading.drive_v);
    line.rms_m.push_back(std::sqrt(power));
  }
  // straight line, and parabola for the test of curvature
  line.line = dsp::FitLine(line.drive_v, line.rms_m);
  line.curvature = dsp::FitCurvature(line.drive_v, line.rms_m);
  // full scale: value of the line at the highest drive, m
  if (line.line) {
    const double highest = *std::ranges::max_element(line.drive_v);
    line.full_scale_m = line.line->intercept + line.line->slope * highest;
  }
  return line;
}

}  // namespace

LinearityResult AnalyzeLinearity(const std::vector<DriveReading>& readings,
                                 const std::optional<double>& floor_m) {
  // a line per condition and subject
  std::map<std::pair<std::string, std::string>, std::vector<DriveReading>> groups;
  for (const DriveReading& reading : readings) {
    groups[{reading.condition, reading.subject}].push_back(reading);
  }
  LinearityResult result;
  std::map<std::string, std::vector<double>> slopes;
  std::map<std::string, std::vector<double>> curvatures;
  for (const auto& [name, group] : groups) {
    result.lines.push_back(LineOf(group, floor_m));
    const auto& line = result.lines.back().line;
    if (line) slopes[name.first].push_back(line->slope);
    const auto& curvature = result.lines.back().curvature;
    if (curvature) curvatures[name.first].push_back(curvature->quadratic);
  }
  // means over subjects need two lines of a condition
  for (const auto& [condition, values] : slopes) {
    if (values.size() < 2) continue;
    result.slopes.push_back({condition, dsp::TestMean(values), {}});
    const std::vector<double>& bends = curvatures[condition];
    if (bends.size() >= 2) result.slopes.back().curvature_m_per_v2 = dsp::TestMean(bends);
  }
  return result;
}

}  // namespace haptometer::tools
