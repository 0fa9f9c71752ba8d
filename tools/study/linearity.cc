#include "tools/study/linearity.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "dsp/statistics/moments.h"
#include "tools/cli/json.h"
#include "tools/cli/options.h"
#include "tools/cli/shared_options.h"
#include "tools/cli/terminal.h"
#include "tools/study/study_document.h"
#include "tools/study/study_table.h"
#include "tools/study/text_table.h"

// study linearity FILES|CSV: RMS against the drive's amplitude.

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "study linearity";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Whether the RMS goes in a line with the drive's amplitude.",
    .examples = {"haptometer study linearity sweep/*.bin",
                 "haptometer study linearity sweep.csv --floor 0.8um --plot linearity.svg",
                 "haptometer study linearity sweep/*.bin --json"}};

struct Wanted {
  std::vector<std::string> files;
  std::optional<Quantity> floor_m;
  std::string plot;
  cli::BandWords band;
  cli::ImportWords import;
};

// what could be read, and the status of what could not
struct Readings {
  std::vector<DriveReading> readings;
  int status = 0;
};

// a table that has its RMS already, told by its header
bool IsSweepTable(const std::string& path) {
  if (std::filesystem::path(path).extension() != ".csv") return false;
  return ReadTextTable(path, {"drive_v", "rms_m"}).has_value();
}

Result<void> TakeTable(const std::string& path, Readings& taken) {
  const auto table = ReadTextTable(path, {"drive_v", "rms_m"});
  if (!table) return std::unexpected(table.error());
  const auto drive = NumbersOf(*table, "drive_v");
  if (!drive) return std::unexpected(drive.error());
  const auto rms = NumbersOf(*table, "rms_m");
  if (!rms) return std::unexpected(rms.error());
  const auto text = [&](const std::string& column, std::size_t row) {
    const auto found = table->columns.find(column);
    return found == table->columns.end() ? std::string() : found->second[row];
  };
  for (std::size_t i = 0; i < table->rows(); ++i) {
    if ((*drive)[i] < 0 || (*rms)[i] < 0) {
      return CannotAnswer(fmt::format("{}:{}", path, table->lines[i]),
                          "has a negative amplitude or RMS", "mend that line");
    }
    taken.readings.push_back({text("subject", i), text("condition", i), (*drive)[i], (*rms)[i]});
  }
  return {};
}

// Errors are reported; the other trials are still used. The floor is taken off all of them alike,
// by AnalyzeLinearity, so none is taken off here.
void TakeTrial(const StudyTrial& trial, Readings& taken) {
  std::optional<Error> error = trial.error;
  if (!error && !trial.rms_with_floor_m) {
    error = Error{Cause::kCannotAnswer, trial.file,
                  trial.reasons.empty() ? "has no RMS" : trial.reasons.front(), ""};
  }
  if (!error && (!trial.drive_v || !(*trial.drive_v >= 0))) {
    error = Error{Cause::kCannotAnswer, trial.file, "does not say its drive_amplitude_v",
                  "give a table with drive_v,rms_m"};
  }
  if (error) {
    taken.status = cli::WorseStatus(taken.status, cli::ReportError(kVerb, *error));
    return;
  }
  taken.readings.push_back(
      {trial.subject, trial.condition, *trial.drive_v, *trial.rms_with_floor_m});
}

Result<Readings> Read(const Wanted& wanted) {
  const auto question = cli::BandQuestionOf(wanted.band);
  if (!question) return std::unexpected(question.error());
  const auto import = cli::ImportOf(wanted.import);
  if (!import) return std::unexpected(import.error());
  Readings taken;
  std::vector<TrialFile> trials;
  for (const std::string& path : wanted.files) {
    if (!IsSweepTable(path)) {
      trials.push_back({.path = path, .labels = {}, .error = {}});
      continue;
    }
    if (auto read = TakeTable(path, taken); !read) {
      taken.status = cli::WorseStatus(taken.status, cli::ReportError(kVerb, read.error()));
    }
  }
  for (const StudyTrial& trial : AnalyzeTrials(trials, *question, *import)) {
    TakeTrial(trial, taken);
  }
  return taken;
}

}  // namespace

int RunStudyLinearity(int argc, const char* const* argv) {
  cli::Options options(kText);
  Wanted wanted;
  options.Positionals("files", &wanted.files,
                      "Trials that say their drive_amplitude_v, or CSV with drive_v,rms_m");
  options.Number("--floor", &wanted.floor_m, Dimension::kLength,
                 "RMS with the drive off, subtracted in power (default: the readings at 0 V)");
  options.Output("--plot", &wanted.plot, "FILE.svg|png|pdf", "Draw RMS against drive");
  cli::DeclareBand(&options, &wanted.band, cli::Shown::kHelpAll);
  cli::DeclareImport(&options, &wanted.import);
  if (const auto status = options.Parse(argc, argv)) return *status;
  if (!wanted.plot.empty()) {
    if (auto drawable = plot::CheckPlotPath(wanted.plot); !drawable) {
      return cli::ReportError(kVerb, drawable.error());
    }
  }
  const auto taken = Read(wanted);
  if (!taken) return cli::ReportError(kVerb, taken.error());
  if (taken->readings.empty()) return taken->status;
  const LinearityResult result = AnalyzeLinearity(
      taken->readings, wanted.floor_m ? std::optional(wanted.floor_m->value) : std::nullopt);
  cli::Print(options.json() ? LinearityJson(result) : LinearityText(result));
  int status = taken->status;
  for (const DriveLine& line : result.lines) {
    if (!line.line) status = cli::WorseStatus(status, ExitStatus(Cause::kCannotAnswer));
  }
  if (wanted.plot.empty()) return status;
  if (auto drawn = plot::DrawPanels(wanted.plot, LinearityPanels(result)); !drawn) {
    return cli::ReportError(kVerb, drawn.error());
  }
  return status;
}

namespace {

using Json = nlohmann::ordered_json;

constexpr double kUm = 1e-6;  // in metres
constexpr std::string_view kNoInterval = "interval not determined";

// of the readings at 0 V, together
std::optional<double> DriveOffRms(const std::vector<DriveReading>& readings) {
  std::vector<double> off;
  for (const DriveReading& reading : readings) {
    if (reading.drive_v == 0) off.push_back(reading.rms_m);
  }
  return off.empty() ? std::nullopt : std::optional(dsp::Rms(off));
}

DriveLine LineOf(const std::vector<DriveReading>& readings, const std::optional<double>& floor_m) {
  DriveLine line;
  line.subject = readings.front().subject;
  line.condition = readings.front().condition;
  line.floor_m = floor_m ? floor_m : DriveOffRms(readings);
  const double floor_power = line.floor_m ? *line.floor_m * *line.floor_m : 0;
  for (const DriveReading& reading : readings) {
    if (reading.drive_v == 0) continue;
    const double power = reading.rms_m * reading.rms_m - floor_power;
    if (!(power > 0)) {
      ++line.below_floor;
      continue;
    }
    line.drive_v.push_back(reading.drive_v);
    line.rms_m.push_back(std::sqrt(power));
  }
  line.line = dsp::FitLine(line.drive_v, line.rms_m);
  line.curvature = dsp::FitCurvature(line.drive_v, line.rms_m);
  if (line.line) {
    const double highest = *std::ranges::max_element(line.drive_v);
    line.full_scale_m = line.line->intercept + line.line->slope * highest;
  }
  return line;
}

std::string NameOf(const DriveLine& line) {
  std::string name = line.condition;
  if (!line.subject.empty()) {
    fmt::format_to(std::back_inserter(name), "{}subject {}", name.empty() ? "" : ", ",
                   line.subject);
  }
  return name.empty() ? "drive sweep" : name;
}

// deviation over full scale, in percent
double Percent(double deviation_m, const DriveLine& line) {
  return 100 * deviation_m / std::abs(line.full_scale_m);
}

void AppendCurvature(const DriveLine& line, std::string& text) {
  if (!line.curvature) {
    text += "    curvature     not determined: fewer than 4 readings, or than 3 levels\n";
    return;
  }
  const dsp::Curvature& bend = *line.curvature;
  fmt::format_to(std::back_inserter(text), "    {:<14}{}, the quadratic term: {}\n", "curvature",
                 WithCi(bend.quadratic, bend.interval, kNoInterval, {kUm, "um/V^2"}),
                 bend.p ? fmt::format("t({:g}) = {:.4g}, p = {:.3g}", bend.df, *bend.t, *bend.p)
                        : "not tested, all points are on the parabola");
}

void AppendLine(const DriveLine& line, std::string& text) {
  fmt::format_to(std::back_inserter(text), "  {}: {} readings\n", NameOf(line), line.rms_m.size());
  if (line.floor_m) {
    fmt::format_to(std::back_inserter(text), "    {:<14}{:.4g} um, subtracted in power\n", "floor",
                   *line.floor_m / kUm);
  } else {
    text +=
        "    floor         not known: nothing subtracted (a reading at 0 V, or --floor, tells)\n";
  }
  if (line.below_floor > 0) {
    fmt::format_to(std::back_inserter(text), "    {:<14}{} readings, not on the line\n",
                   "below floor", line.below_floor);
  }
  if (!line.line) {
    text += "    slope         not determined: fewer than 3 readings, or levels alike\n";
    return;
  }
  const dsp::Line& fit = *line.line;
  fmt::format_to(std::back_inserter(text), "    {:<14}{}\n", "slope",
                 WithCi(fit.slope, fit.slope_interval, kNoInterval, {kUm, "um/V"}));
  fmt::format_to(std::back_inserter(text), "    {:<14}{}\n", "at 0 V",
                 WithCi(fit.intercept, fit.intercept_interval, kNoInterval, {kUm, "um"}));
  fmt::format_to(std::back_inserter(text),
                 "    {:<14}{:.3g} um at most, {:.2g} % of full scale; R^2 = {:.6f}\n",
                 "off the line", fit.largest_deviation / kUm, Percent(fit.largest_deviation, line),
                 fit.r_squared);
  AppendCurvature(line, text);
}

Json LineJson(const DriveLine& line) {
  Json json{{"subject", cli::TextOrNull(line.subject)},
            {"condition", cli::TextOrNull(line.condition)},
            {"readings", line.rms_m.size()},
            {"below_floor", line.below_floor},
            {"floor_m", cli::NumberOrNull(line.floor_m)},
            {"drive_v", line.drive_v},
            {"rms_m", line.rms_m}};
  for (const char* key :
       {"slope_m_per_v", "slope_interval_m_per_v", "intercept_m", "intercept_interval_m",
        "r_squared", "residual_deviation_m", "largest_deviation_m",
        "largest_deviation_of_full_scale", "curvature_m_per_v2", "curvature_interval_m_per_v2",
        "curvature_t", "curvature_df", "curvature_p"}) {
    json[key] = nullptr;
  }
  if (!line.line) return json;
  const dsp::Line& fit = *line.line;
  json["slope_m_per_v"] = fit.slope;
  json["slope_interval_m_per_v"] = {fit.slope_interval.lower, fit.slope_interval.upper};
  json["intercept_m"] = fit.intercept;
  json["intercept_interval_m"] = {fit.intercept_interval.lower, fit.intercept_interval.upper};
  json["r_squared"] = fit.r_squared;
  json["residual_deviation_m"] = fit.residual_deviation;
  json["largest_deviation_m"] = fit.largest_deviation;
  json["largest_deviation_of_full_scale"] =
      cli::NumberOrNull(Percent(fit.largest_deviation, line) / 100);
  if (!line.curvature) return json;
  const dsp::Curvature& bend = *line.curvature;
  json["curvature_m_per_v2"] = bend.quadratic;
  json["curvature_interval_m_per_v2"] = {bend.interval.lower, bend.interval.upper};
  json["curvature_t"] = cli::NumberOrNull(bend.t);
  json["curvature_df"] = bend.df;
  json["curvature_p"] = cli::NumberOrNull(bend.p);
  return json;
}

Json SlopeJson(const SlopeOverSubjects& over) {
  Json json{{"condition", cli::TextOrNull(over.condition)},
            {"subjects", over.slope_m_per_v.n},
            {"slope_m_per_v", over.slope_m_per_v.mean},
            {"slope_interval_m_per_v", nullptr},
            {"curvature_m_per_v2", nullptr},
            {"curvature_interval_m_per_v2", nullptr},
            {"curvature_p", nullptr}};
  if (const auto& test = over.slope_m_per_v.test) {
    json["slope_interval_m_per_v"] = {test->mean.lower, test->mean.upper};
  }
  if (!over.curvature_m_per_v2) return json;
  json["curvature_m_per_v2"] = over.curvature_m_per_v2->mean;
  if (const auto& test = over.curvature_m_per_v2->test) {
    json["curvature_interval_m_per_v2"] = {test->mean.lower, test->mean.upper};
    json["curvature_p"] = test->p;
  }
  return json;
}

std::string MeanText(const dsp::OneSample& values, std::string_view unit) {
  return WithCi(values.mean, values.test ? std::optional(values.test->mean) : std::nullopt,
                kNoInterval, {kUm, unit});
}

}  // namespace

LinearityResult AnalyzeLinearity(const std::vector<DriveReading>& readings,
                                 const std::optional<double>& floor_m) {
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
  for (const auto& [condition, values] : slopes) {
    if (values.size() < 2) continue;
    result.slopes.push_back({condition, dsp::TestMean(values), {}});
    const std::vector<double>& bends = curvatures[condition];
    if (bends.size() >= 2) result.slopes.back().curvature_m_per_v2 = dsp::TestMean(bends);
  }
  return result;
}

std::string LinearityText(const LinearityResult& result) {
  std::string text = "RMS = intercept + slope x drive\n";
  for (const DriveLine& line : result.lines) AppendLine(line, text);
  for (const SlopeOverSubjects& over : result.slopes) {
    fmt::format_to(std::back_inserter(text), "  {}{}{} subjects: mean slope {}", over.condition,
                   over.condition.empty() ? "" : ", ", over.slope_m_per_v.n,
                   MeanText(over.slope_m_per_v, "um/V"));
    if (const auto& bend = over.curvature_m_per_v2) {
      fmt::format_to(std::back_inserter(text), "; mean curvature {}{}", MeanText(*bend, "um/V^2"),
                     bend->test ? fmt::format(", p = {:.3g}", bend->test->p) : "");
    }
    text += '\n';
  }
  return text;
}

std::string LinearityJson(const LinearityResult& result) {
  Json lines = Json::array();
  for (const DriveLine& line : result.lines) lines.push_back(LineJson(line));
  Json slopes = Json::array();
  for (const SlopeOverSubjects& over : result.slopes) slopes.push_back(SlopeJson(over));
  return cli::JsonText({{"lines", std::move(lines)}, {"over_subjects", std::move(slopes)}});
}

std::vector<plot::Panel> LinearityPanels(const LinearityResult& result) {
  constexpr plot::Colour kColours[] = {plot::kBlue, plot::kOrange, plot::kGreen, plot::kPurple};
  plot::Panel panel;
  panel.title = "readings with the floor removed, and their lines";
  panel.x_label = "drive amplitude / V";
  panel.y_label = "RMS displacement / um";
  panel.y_from_zero = true;
  panel.x_from_zero = true;
  std::size_t number = 0;
  for (const DriveLine& line : result.lines) {
    const plot::Colour colour = kColours[number++ % std::size(kColours)];
    plot::Series points{NameOf(line), plot::Points(colour, 0.7), line.drive_v, {}, {}};
    for (const double rms_m : line.rms_m) points.y.push_back(rms_m / kUm);
    panel.series.push_back(std::move(points));
    if (!line.line) continue;
    const double high = *std::ranges::max_element(line.drive_v);
    const auto at = [&](double v) { return (line.line->intercept + line.line->slope * v) / kUm; };
    panel.series.push_back({"", plot::Lines(colour), {0, high}, {at(0), at(high)}, {}});
  }
  return {panel};
}

}  // namespace haptometer::tools
