#include "tools/acquire/advise_document.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <vector>

#include "dsp/filter/butterworth.h"
#include "tools/cli/shared_options.h"
#include "tools/document/keys.h"
#include "trial/calibration.h"

namespace haptometer::tools {
namespace {

using document::Section;

constexpr double kMostAccuracy = 0.25;

// what the promise rests on, and what the best route's own numbers warn of
acquire::Findings RemarksOn(const Route& route, const RouteQuestion& question) {
  acquire::Findings found;
  acquire::Finding promise{.kind = acquire::FindingKind::kPromiseRests,
                           .numbers = {{"coverage", kRouteCoverage}}};
  if (question.calibration) promise.numbers.emplace_back("calibration", *question.calibration);
  found.Add(std::move(promise));
  if (!route.images.empty()) {
    // the largest one
    const acquire::FoldedImage& image = route.images.front();
    acquire::Finding folds{.severity = Severity::kDoubt,
                           .kind = acquire::FindingKind::kImagesFold,
                           .numbers = {{"daq_rate_hz", route.rate_hz},
                                       {"image_hz", image.image_hz},
                                       {"folded_hz", image.folded_hz},
                                       {"relative", image.relative},
                                       {"better_hz", route.better_daq_rate_hz.value_or(0)}}};
    if (route.images.size() > 1) folds.numbers.emplace_back("others", route.images.size() - 1);
    found.Add(std::move(folds));
  }
  if (route.answers && route.unseen > 0.1 * question.accuracy) {
    found.Note(acquire::FindingKind::kUnseenByAnalyze, {{"relative", route.unseen}});
  }
  return found;
}

Section RouteSection(const Route& route) {
  Section section{.heading = fmt::format("{}: {}", route.answers ? "yes" : "cannot", route.name)};
  section.Add(document::kName, route.name);
  section.Add(document::kAnswers, route.answers);
  section.Add({"because", "because"}, ReasonOf(route));
  section.Add({document::kSettings.name, "set"}, OptionsOf(route));
  section.Add({"length_of_record_s", "record", document::kSecond}, route.record_s);
  section.Add({"floor_record_s", "and without drive", document::kSecond},
              route.needs_floor ? document::Value(route.record_s) : document::Value());
  section.Add({"latency_at_least_s", "latency at least", document::kSecond}, route.latency_s);
  section.Add({"gain_at_drive", "gain at the drive"}, route.gain).resolution = 1e-4;
  section.Add({document::kLimitedBy.name, "limited by"}, NameOf(route.limited_by));
  section.Add({"predicted_relative_half_interval"}, route.predicted_relative_uncertainty);
  section.Add({"floor_relative_half_interval"}, route.floor);
  section.Add({"age_relative_error"}, route.unseen);
  section.Add(document::kRate, route.rate_hz).label.clear();
  return section;
}

// no route answers: the refusal, with the least interval where an accuracy is what prevents it
void FindNoAnswer(const std::vector<Route>& routes, const RouteQuestion& question,
                  Section& section) {
  std::optional<double> least;
  for (const Route& route : routes) {
    if (route.floor) least = std::min(*route.floor, least.value_or(*route.floor));
  }
  std::vector<FindingNumber> numbers{{"accuracy", question.accuracy}};
  if (least) numbers.emplace_back("half_interval", *least);
  section.Find(Severity::kRefusal, "no-route-answers",
               "no way reaches +-{accuracy %}[; the least interval at any length is "
               "+-{half_interval %}]",
               std::move(numbers));
}

// the command that records by this route
std::string CommandOf(const Route& route) {
  const bool is_pipe = !route.settings.empty() && route.settings.front().second == "pipe";
  return fmt::format("{}haptometer acquire {}{}{} -o trial.bin", is_pipe ? "my_daq | " : "",
                     is_pipe ? "" : "--port PORT ", OptionsOf(route),
                     route.record_s ? fmt::format(" --duration {:g}s", *route.record_s) : "");
}

// the command that analyses its record
std::string AnalysisOf(const Route& route, const RouteQuestion& question) {
  return fmt::format("haptometer analyze trial.bin --band {:g}-{:g}Hz{}", question.lower_hz,
                     question.upper_hz, route.needs_floor ? " --floor off.bin" : "");
}

}  // namespace

std::string_view NameOf(RouteLimit limit) {
  // in the order of the enumerators
  static constexpr std::array<std::string_view, 9> kNames{"the wire or its unit",
                                                          "sampling",
                                                          "the sensor's noise",
                                                          "the steps",
                                                          "averaging",
                                                          "a reading's age",
                                                          "the calibration",
                                                          "the filter's ends",
                                                          "the shortest window"};
  return kNames.at(static_cast<std::size_t>(limit));
}

std::string OptionsOf(const Route& route) {
  std::string options;
  for (const auto& [setting, value] : route.settings) {
    options += fmt::format("{}--{} {}", options.empty() ? "" : " ", setting, value);
  }
  return options;
}

std::string ReasonOf(const Route& route) {
  // the sentence of a floor names the limit
  acquire::Finding reason = route.reason;
  reason.numbers.emplace_back("limit", std::string(NameOf(route.limited_by)));
  return document::WordsOf(reason);
}

void DeclareAdvise(cli::Options& options, AdviseWords& words) {
  options.Flag("--advise", &words.advise,
               "List the ways to measure --rms at --drive in --band to --accuracy, with the record "
               "that each needs, and record nothing");
  options.Number("--drive", &words.drive_hz, Dimension::kFrequency, cli::Above(0),
                 "Frequency of the drive, for --advise");
  options.Number("--rms", &words.rms_m, Dimension::kLength, cli::Above(0),
                 "Expected RMS, for --advise");
  options
      .Text("--accuracy", &words.accuracy, "SHARE",
            "Half of the 95 % interval of the RMS that --advise is to reach, as 1%")
      .Default("1%");
  options.Number("--noise", &words.noise_rms_m, Dimension::kLength, cli::AtLeast(0),
                 "RMS noise of one reading of a sensor whose maker states none, for --advise",
                 cli::Shown::kHelpAll);
  options
      .Number("--daq-rate", &words.daq_rate_hz, Dimension::kFrequency, cli::AtLeast(1),
              "Rate of the DAQ behind an analog output, for --advise", cli::Shown::kHelpAll)
      .Default("the lowest that folds no image of the drive into the band");
  options.Text("--calibration-uncertainty", &words.calibration_uncertainty, "SHARE",
               "Relative standard uncertainty of the sensor's gain, as 0.5%, for --advise",
               cli::Shown::kHelpAll);
}

Result<void> CheckNotAdvised(const AdviseWords& words) {
  const std::string_view what = "is a number for advice";
  const std::string_view remedy = "add --advise";
  return cli::CheckRules(
      {{words.drive_hz.has_value(), "--drive", what, remedy},
       {words.rms_m.has_value(), "--rms", what, remedy},
       {!words.accuracy.empty(), "--accuracy", what, remedy},
       {words.noise_rms_m.has_value(), "--noise", what, remedy},
       {words.daq_rate_hz.has_value(), "--daq-rate", what, remedy},
       {!words.calibration_uncertainty.empty(), "--calibration-uncertainty", what, remedy}});
}

Result<RouteQuestion> ReadRouteQuestion(const AdviseWords& words, const std::string& band) {
  HAPTOMETER_LET(const auto corners, cli::ParseBand(band));
  dsp::BandPass pass;
  pass.lower_hz = corners.lower_hz;
  pass.upper_hz = corners.upper_hz;
  // a rate of 4 f_upper permits each valid band: only impossible corners are refused here
  HAPTOMETER_TRY(dsp::DesignBandPass(pass, 4 * pass.upper_hz));
  const double drive_hz = words.drive_hz.value_or(0);
  HAPTOMETER_TRY(cli::CheckRules(
      {{!words.drive_hz, "--drive", "is missing", "give the drive's frequency, e.g. --drive 225Hz"},
       {!(drive_hz >= pass.lower_hz && drive_hz <= pass.upper_hz), "--drive",
        "lies outside of --band", "give a band around it"},
       {!words.rms_m, "--rms", "is missing", "give the expected RMS, e.g. --rms 10um"}}));
  RouteQuestion question{.lower_hz = pass.lower_hz,
                         .upper_hz = pass.upper_hz,
                         .drive_hz = drive_hz,
                         .rms_m = *words.rms_m};
  if (!words.accuracy.empty()) {
    HAPTOMETER_LET(question.accuracy, cli::ReadAccuracy(words.accuracy, 0, kMostAccuracy));
  }
  question.noise_rms_m = words.noise_rms_m;
  question.daq_rate_hz = words.daq_rate_hz;
  if (words.calibration_uncertainty.empty()) return question;
  HAPTOMETER_LET(question.calibration, trial::ParseGainUncertainty(words.calibration_uncertainty,
                                                                   "--calibration-uncertainty"));
  return question;
}

document::Document RoutesDocument(const RouteQuestion& question) {
  document::Document document{
      .verb = "acquire",
      .title =
          fmt::format("{:g} um at {:g} Hz in {:g}-{:g} Hz to {:g} % (half of the 95 % interval)",
                      1e6 * question.rms_m, question.drive_hz, question.lower_hz, question.upper_hz,
                      100 * question.accuracy)};
  const std::vector<Route> routes = AdviseRoutes(question);
  Section& root = document.root;
  root.Add({"wanted_relative_half_interval"}, question.accuracy);
  root.Add({"interval_coverage_factor"}, kRouteCoverage);
  Section band{.name = document::kBand.name};
  band.Add(document::kLowerHz, question.lower_hz);
  band.Add(document::kUpperHz, question.upper_hz);
  root.sections = {std::move(band),
                   document::ListOf({.name = "routes", .shape = Section::Shape::kArray}, routes,
                                    [](const Route& route) { return RouteSection(route); })};
  const Route& best = routes.front();
  Section remarks;
  document::AddFindings(remarks, RemarksOn(best, question));
  if (!best.answers) FindNoAnswer(routes, question, remarks);
  root.sections.push_back(std::move(remarks));
  // the commands last
  Section next{.heading = "next"};
  next.Add(document::kCommand, best.answers ? document::Value(CommandOf(best)) : document::Value());
  next.items.back().label = "record with";
  next.Add({"analyze_command", "then"},
           best.answers ? document::Value(AnalysisOf(best, question)) : document::Value());
  root.sections.push_back(std::move(next));
  return document;
}

}  // namespace haptometer::tools
