#include <fmt/core.h>
#include <fmt/ranges.h>

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquire/sensor/keyence/keyence_il.h"
#include "acquire/transport/open_port.h"
#include "base/mapped.h"
#include "tools/acquire/sensor_options.h"
#include "tools/calibrate/calibration_answer.h"
#include "tools/calibrate/reference_points.h"
#include "tools/cli/options.h"
#include "tools/cli/output_file.h"
#include "tools/cli/terminal.h"
#include "tools/document/present.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "calibrate";
constexpr std::string_view kPipePrefix = "pipe:";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Determine the gain of a sensor's analog output, with its uncertainty.",
    .examples = {"haptometer calibrate pairs.csv -o il030.toml",
                 "haptometer calibrate --reference /dev/ttyUSB0 --input 'pipe:my_daq --text'"
                 " -o il030.toml",
                 "haptometer calibrate today.csv --check il030.toml"}};

// The command line.
struct Wanted {
  std::vector<std::string> pairs;
  SensorOptions reference;
  std::string input;
  std::optional<double> displacement_uncertainty_m;
  std::optional<double> voltage_uncertainty_v;
  std::string scale_uncertainty;
  double daq_min_v = -std::numeric_limits<double>::infinity();
  double daq_max_v = std::numeric_limits<double>::infinity();
  std::optional<std::int64_t> averages;
  std::optional<double> sampling_s;
  std::string check;
  std::string output;
  bool overwrite = false;
  StillQuestion still;
  document::Outputs outputs;
};

void Declare(cli::Options& options, Wanted& wanted) {
  options
      .Positionals("pairs", &wanted.pairs,
                   "CSV of displacement_mm,voltage_v in the order of measurement", 0)
      .is_repeated = false;
  options.Text("--reference", &wanted.reference.port, "PORT",
               "Port of the amplifier, which then is the reference: its reading (data 038) and "
               "what it puts out (data 042)");
  options.Text("--input", &wanted.input, "pipe:COMMAND",
               "With --reference: program whose lines are the DAQ's samples in V");
  options.Choice("--sensor", &wanted.reference.sensor, {"keyence-il", "keyence-en1"},
                 "With --reference: the unit of the amplifier");
  options.Count("--baud", &wanted.reference.baud, 2400, 38'400, "Bits per second of its wire")
      .Default("9600");
  options.Count("--points", &wanted.still.points, 3, 1000, "Points to measure against it");
  options.Number("--still", &wanted.still.still_m, Dimension::kLength, cli::Within(1e-9, 1),
                 "Largest distance of a reading from the mean while the target is still");
  options.Number("--apart", &wanted.still.apart_m, Dimension::kLength, cli::Within(1e-9, 1),
                 "Least distance of a point from the one before");
  options.Number("--timeout", &wanted.still.timeout_s, Dimension::kTime, cli::Within(1, 1e5),
                 "Longest time for all points");
  options.Number("--displacement-uncertainty", &wanted.displacement_uncertainty_m,
                 Dimension::kLength, cli::AtLeast(0),
                 "Standard uncertainty of each displacement of the table");
  options.Number("--voltage-uncertainty", &wanted.voltage_uncertainty_v, Dimension::kVoltage,
                 cli::AtLeast(0), "Standard uncertainty of each voltage of the table");
  options.Text("--reference-uncertainty", &wanted.scale_uncertainty, "SHARE",
               "Relative standard uncertainty of the reference's scale, common to all points, as "
               "0.1%");
  options.Range("--daq-range", &wanted.daq_min_v, &wanted.daq_max_v, Dimension::kVoltage, {},
                "Range of the DAQ, as -10V:10V: at its ends a sample is clipped");
  options
      .Count("--averaging", &wanted.averages, 1, 1'000'000,
             "Samples that the sensor averages in a reading, to keep in the file; 1: none")
      .Default("with --reference the amplifier's");
  options.Number("--sampling", &wanted.sampling_s, Dimension::kTime, cli::Above(0),
                 "Period of the samples that --averaging is of");
  options.Text("--check", &wanted.check, "FILE.toml",
               "Compare with this calibration: status 3 where |E_n| of the gain exceeds 1 (k = 2)");
  options.Output("-o,--output", &wanted.output, "FILE.toml", "Calibration file to write");
  options.Flag("--overwrite,--force", &wanted.overwrite, "Replace an existing calibration file");
  document::DeclareOutputs(options, wanted.outputs,
                           {.all = "Print each point too, and the provenance",
                            .plot = "Draw the points on the line and their residuals"});
}

Result<void> CheckTogether(const Wanted& wanted) {
  const bool has_reference = !wanted.reference.port.empty();
  HAPTOMETER_TRY(cli::CheckRules({
      {wanted.pairs.size() > 1, "", "more than one table is given", "join them into one"},
      {wanted.pairs.empty() != has_reference, "", "what to calibrate from is not clear",
       "give a table of pairs, or --reference PORT --input pipe:COMMAND"},
      {has_reference && wanted.input.empty(), "--input", "is missing",
       "give the program that writes the DAQ's samples, as --input 'pipe:my_daq'"},
      {!has_reference && !wanted.input.empty(), "--input", "belongs to --reference",
       "add --reference PORT"},
      {has_reference &&
           (!wanted.input.starts_with(kPipePrefix) || wanted.input.size() == kPipePrefix.size()),
       "--input", "is not pipe:COMMAND", "write e.g. --input 'pipe:my_daq'"},
      {has_reference && (wanted.displacement_uncertainty_m || wanted.voltage_uncertainty_v),
       wanted.displacement_uncertainty_m ? "--displacement-uncertainty" : "--voltage-uncertainty",
       "is for a table of pairs", "leave it out: the scatter of the points gives it"},
      {wanted.averages.value_or(1) > 1 && !wanted.sampling_s, "--sampling",
       "is missing: the period of the samples that are averaged", "give it, e.g. --sampling 1ms"},
      {!(wanted.daq_min_v < wanted.daq_max_v), "--daq-range", "has no width",
       "write e.g. -10V:10V"},
  }));
  if (has_reference) HAPTOMETER_TRY(CheckSensor(wanted.reference));
  if (!wanted.output.empty()) {
    HAPTOMETER_TRY(CheckOutput(wanted.output, cli::kCalibrationOutput, wanted.overwrite));
  }
  return {};
}

// what to do after a window, for the one who moves the target
void TellWindow(WindowState state, const ReferencePoints& found, std::size_t wanted,
                WindowState& before) {
  const bool is_new = std::exchange(before, state) != state;
  if (state == WindowState::kPoint) {
    const StillPoint& point = found.points.back();
    cli::Remark(kVerb, fmt::format("point {} of {}: {:.4f} mm, {:.4f} V; {}", found.points.size(),
                                   wanted, 1e3 * point.displacement_m.mean, point.input_v.mean,
                                   found.points.size() < wanted ? "move the target on" : "done"));
  } else if (state == WindowState::kMoving && is_new) {
    cli::Remark(kVerb, "the target moves, or scatters by more than --still: no point");
  } else if (state == WindowState::kErrorLevel && is_new) {
    cli::Remark(kVerb, "the amplifier's output stands at +5.5 V, its error level: no reading");
  } else if (state == WindowState::kAtRail && is_new) {
    cli::Remark(kVerb, "the DAQ is at the end of its range: no point");
  }
}

Result<CalibrationPoints> MeasurePoints(const Wanted& wanted) {
  SystemClock clock;
  HAPTOMETER_LET(const auto sensor, OpenSensor(wanted.reference, clock));
  auto* amplifier = dynamic_cast<acquire::KeyenceIl*>(sensor.get());
  HAPTOMETER_CHECK(amplifier != nullptr, "{} is no IL", wanted.reference.sensor);
  cli::CatchInterrupts();
  HAPTOMETER_TRY(amplifier->Start(cli::Interrupted()));
  HAPTOMETER_LET(const auto input,
                 acquire::OpenCommandPipe(wanted.input.substr(kPipePrefix.size())));
  cli::Remark(kVerb, fmt::format("source: {}; hold the target still at each of {} places",
                                 amplifier->header().metadata.source, wanted.still.points));
  auto before = WindowState::kSettling;
  const auto tell = [&](WindowState state, const ReferencePoints& found) {
    TellWindow(state, found, wanted.still.points, before);
  };
  HAPTOMETER_LET(auto found,
                 CollectPoints(*amplifier, *input, clock, cli::Interrupted(), wanted.still, tell));
  return PointsOf(std::move(found), amplifier->header().metadata, wanted.still.points);
}

// error of a fit with the place of its points
template <typename T>
Result<T> At(const std::string& where, Result<T> result) {
  if (!result && result.error().where.empty()) result.error().where = where;
  return result;
}

// "line 3 of the table, line 6 of the table"
std::string NamesOfOutliers(const CalibrationAnswer& answer) {
  const auto name = [&](const fit::Outlier& one) { return answer.NameOf(one.point); };
  return fmt::format("{}", fmt::join(Mapped(answer.fit.outliers->points, name), ", "));
}

Result<int> Calibrate(Wanted& wanted, int argc, const char* const* argv) {
  HAPTOMETER_TRY(CheckTogether(wanted));
  double scale_uncertainty = 0;
  if (!wanted.scale_uncertainty.empty()) {
    HAPTOMETER_LET(scale_uncertainty, trial::ParseGainUncertainty(wanted.scale_uncertainty,
                                                                  "--reference-uncertainty"));
  }
  const trial::RawLimits rails{.rail_min = wanted.daq_min_v, .rail_max = wanted.daq_max_v};
  wanted.still.rails = rails;
  const bool has_pairs = !wanted.pairs.empty();
  const std::string where = has_pairs ? wanted.pairs.front() : wanted.reference.port;
  HAPTOMETER_LET(auto points, has_pairs ? ReadPairs(where, wanted.voltage_uncertainty_v,
                                                    wanted.displacement_uncertainty_m, rails)
                                        : MeasurePoints(wanted));
  HAPTOMETER_LET(auto answer, At(where, AnswerOf(std::move(points))));
  answer.scale_uncertainty = scale_uncertainty;
  answer.limits = rails;
  // an option overrides what the amplifier says
  answer.averaging = {.averages = answer.measured.reference.averages,
                      .sampling_s = answer.measured.reference.sampling_s};
  if (wanted.averages) answer.averaging.averages = static_cast<int>(*wanted.averages);
  if (wanted.sampling_s) answer.averaging.sampling_s = wanted.sampling_s;
  if (!wanted.check.empty()) {
    HAPTOMETER_LET(answer.check, CheckAgainst(wanted.check, answer));
  }
  if (!wanted.output.empty()) {
    // no reader would take such a file
    if (answer.RelativeUncertainty() > trial::kLargestGainUncertainty) {
      return CannotAnswer(
          where,
          fmt::format("the gain is uncertain by {:.0f} %: no calibration is written",
                      100 * answer.RelativeUncertainty()),
          answer.fit.outliers
              ? fmt::format("correct {}, far from the others", NamesOfOutliers(answer))
              : "measure more points, further apart");
    }
    HAPTOMETER_TRY(WriteOutput(wanted.output, cli::kCalibrationOutput, wanted.overwrite,
                               CalibrationText(answer, document::ProvenanceOf(kVerb, argc, argv))));
  }
  int status = document::Present(CalibrationDocument(answer, where), wanted.outputs, argc, argv);
  // a calibration that is no longer valid is an expectation that does not hold
  if (answer.check && !answer.check->Agrees().value_or(true)) {
    status = cli::WorseStatus(status, ExitStatus(Cause::kCannotAnswer));
  }
  return cli::InterruptedStatus(status);
}

}  // namespace

int RunCalibrate(int argc, const char* const* argv) {
  cli::Options options(kText);
  Wanted wanted;
  Declare(options, wanted);
  return document::RunVerb(kVerb, options, wanted.outputs, argc, argv,
                           [&] { return Calibrate(wanted, argc, argv); });
}

}  // namespace haptometer::tools
