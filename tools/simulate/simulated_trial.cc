#include "tools/simulate/simulated_trial.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <ranges>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "base/mapped.h"
#include "base/text.h"
#include "dsp/spectrum/welch.h"
#include "sim/linear/steady_state.h"
#include "sim/scene/scene_file.h"
#include "tools/cli/output_file.h"
#include "tools/document/keys.h"
#include "trial/export/export.h"
#include "trial/import/table/csv_header.h"
#include "trial/trial_reader.h"
#include "trial/trial_writer.h"

namespace haptometer::tools {
namespace {

std::vector<trial::ChannelFormat> FormatsOf(const trial::Record& record) {
  return Mapped(record.channels, FormatOf);
}

// a simulated record has one segment at a uniform rate
trial::TrialHeader SimulatedHeaderOf(const trial::Record& record) {
  return {.timing = trial::Timing::kUniform,
          .rate_hz = record.stretches.front().rate_hz,
          .channels = FormatsOf(record),
          .metadata = record.metadata};
}

// row by row, as a recorder writes them
Result<void> WriteRows(const trial::Record& record, Result<trial::TrialWriter> writer) {
  if (!writer) return std::unexpected(writer.error());
  const std::vector<trial::ChannelFormat> formats = FormatsOf(record);
  std::vector<trial::Sample> samples(formats.size());
  for (std::size_t row = 0; row < record.rows; ++row) {
    for (std::size_t c = 0; c < formats.size(); ++c) {
      const trial::Channel& channel = record.channels[c];
      samples[c] = {RawOf(formats[c], channel.values[row]), channel.statuses[row]};
    }
    const trial::Row next{.index = static_cast<std::int64_t>(row), .samples = samples};
    HAPTOMETER_TRY(writer->Append(next));
  }
  HAPTOMETER_TRY(writer->Finish());
  return {};
}

// writes a trial into a file that replaces an older one when it is complete
class OutputSink final : public trial::ByteSink {
 public:
  explicit OutputSink(cli::OutputFile* file) : file_(file) {}

  Result<std::size_t> WriteSome(std::span<const std::byte> bytes) override {
    HAPTOMETER_TRY(file_->Write({reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
    return bytes.size();
  }

  // Finish() of the file synchronises
  Result<void> Sync() override { return {}; }

 private:
  cli::OutputFile* file_;
};

std::string EndingOf(const std::string& path) {
  return std::filesystem::path(path).extension().string();
}

Result<cli::OutputKind> KindOf(const std::string& path) {
  const std::string ending = EndingOf(path);
  if (ending == ".csv") return cli::kRowsOutput;
  if (ending == ".h5" || ending == ".hdf5") return cli::kHdf5Output;
  if (ending == ".bin") return cli::kTrialOutput;
  return Usage(path, "has an ending that no waveforms are written to", "use .csv, .h5 or .bin");
}

trial::Channel ChannelOf(std::string name, trial::ChannelRole role, std::string unit,
                         const Eigen::VectorXd& values) {
  trial::Channel channel;
  channel.name = std::move(name);
  channel.role = role;
  channel.unit = std::move(unit);
  channel.values.assign(values.begin(), values.end());
  channel.statuses.assign(channel.values.size(), trial::SampleStatus::kOk);
  return channel;
}

// the displacement channel is that of the sensor's target, the skin without a sensor
const Eigen::VectorXd& TargetOf(const sim::Waveforms& waves, const sim::Scene& scene) {
  const auto target = scene.sensor ? scene.sensor->target : sim::SensorTarget::kSkin;
  if (target == sim::SensorTarget::kMover) return waves.mover_m;
  return target == sim::SensorTarget::kCase ? waves.case_m : waves.skin_m;
}

// a CSV that is read back with all metadata; channels without a role have their own names
Result<void> WriteCsv(const trial::Record& record, cli::OutputFile& file) {
  std::vector<std::string> names = trial::CsvColumnNames(record.channels);
  for (std::size_t c = 0; c < names.size(); ++c) {
    const trial::Channel& channel = record.channels[c];
    if (channel.role == trial::ChannelRole::kOther) names[c] = channel.name;
  }
  return trial::WriteCsv(
      record, [&](std::string_view piece) { return file.Write(piece); }, std::move(names));
}

Result<void> WriteHdf5(const trial::Record& record, const cli::OutputFile& file) {
  HAPTOMETER_LET(const auto part, file.PathForLibrary());
  HAPTOMETER_LET(auto writer, trial::Hdf5Writer::Create(part));
  trial::Recording recording;
  recording.record = record;
  // a simulated record has no recorder that could be interrupted
  recording.report.closed = true;
  auto done = writer.Add("waveforms", recording, nullptr);
  return done ? writer.Close() : done;
}

constexpr double kUm = 1e-6;  // in metres
constexpr double kMa = 1e-3;  // in amperes
constexpr double kShownPeriods = 10;
constexpr double kLeastShown = 1e-6;  // of the spectrum's largest amplitude
constexpr double kShownPart = 0.125;  // of the rate

// values from row `first` on, in units of `unit`, over time in s
plot::Series Curve(std::string title, plot::Colour colour, const Eigen::VectorXd& values,
                   double unit, Eigen::Index first, double rate_hz) {
  plot::Series series{.title = std::move(title), .style = plot::Lines(colour)};
  for (Eigen::Index row = first; row < values.size(); ++row) {
    series.x.push_back(static_cast<double>(row) / rate_hz);
    series.y.push_back(values(row) / unit);
  }
  return series;
}

plot::Panel MotionPanel(const sim::Waveforms& waves, std::string title, Eigen::Index first) {
  // travel of the mover in its case: xv - xa
  const Eigen::VectorXd travel_m = waves.mover_m - waves.case_m;
  return {std::move(title),
          "time / s",
          "displacement / um",
          {Curve("mover in its case", plot::kGrey, travel_m, kUm, first, waves.rate_hz),
           Curve("skin", plot::kBlue, waves.skin_m, kUm, first, waves.rate_hz)}};
}

// voltage and current, each with an axis of its own
std::vector<plot::Panel> ElectricalPanels(const sim::Waveforms& waves) {
  return {{"voltage at the coil",
           "time / s",
           "voltage / V",
           {Curve("", plot::kBlue, waves.voltage_v, 1, 0, waves.rate_hz)}},
          {"current at the coil",
           "time / s",
           "current / mA",
           {Curve("", plot::kOrange, waves.current_a, kMa, 0, waves.rate_hz)}}};
}

Result<plot::Panel> SpectrumPanel(const sim::Waveforms& waves) {
  // one segment of Welch's method: the whole run with a Hann window
  HAPTOMETER_LET(const auto spectrum,
                 dsp::WelchSpectrum({waves.skin_m.data(), static_cast<std::size_t>(waves.rows())},
                                    {.rate_hz = waves.rate_hz,
                                     .segment_size = static_cast<std::size_t>(waves.rows()),
                                     .detrend = dsp::Detrend::kNothing}));
  const std::vector<double> amplitudes_m = dsp::AmplitudeSpectrum(spectrum);
  // from bin 1: the constant part is no vibration
  double largest_m = 0;
  for (const double each_m : amplitudes_m | std::views::drop(1)) {
    largest_m = std::max(largest_m, each_m);
  }
  const double least_m = kLeastShown * largest_m;
  plot::Series series{.style = plot::Lines(plot::kBlue)};
  for (std::size_t k = 1; k < amplitudes_m.size(); ++k) {
    const double frequency_hz = static_cast<double>(k) * spectrum.grid.resolution_hz;
    if (frequency_hz > kShownPart * waves.rate_hz) break;
    series.x.push_back(frequency_hz);
    // below 1e-6 of the largest amplitude: leakage and rounding, drawn as a gap
    series.y.push_back(amplitudes_m[k] >= least_m && least_m > 0
                           ? amplitudes_m[k] / kUm
                           : std::numeric_limits<double>::quiet_NaN());
  }
  plot::Panel panel{
      fmt::format("spectrum of the skin, {:.3g} Hz apart (Hann)", spectrum.grid.resolution_hz),
      "frequency / Hz",
      "amplitude / um",
      {std::move(series)}};
  panel.log_axes = least_m > 0 ? plot::LogAxes::kY : plot::LogAxes::kNone;
  return panel;
}

}  // namespace

Result<void> WriteSimulatedTrial(const std::string& path, const trial::Record& record,
                                 bool overwrite) {
  HAPTOMETER_LET(auto file, cli::OutputFile::Begin(path, cli::kTrialOutput, overwrite));
  auto written = WriteSimulatedTrialIn(std::make_unique<OutputSink>(&file), path, record);
  return written ? file.Finish() : written;
}

Result<void> WriteSimulatedTrialIn(std::unique_ptr<trial::ByteSink> sink, const std::string& name,
                                   const trial::Record& record) {
  SystemClock clock;
  return WriteRows(record, trial::TrialWriter::CreateIn(std::move(sink), name,
                                                        SimulatedHeaderOf(record), {}, clock));
}

// format of a channel's values in the file
trial::ChannelFormat FormatOf(const trial::Channel& channel) {
  trial::ChannelFormat format{.name = channel.name,
                              .role = channel.role,
                              .unit = channel.unit,
                              .range_min = channel.range_min,
                              .range_max = channel.range_max,
                              .resolution = channel.resolution};
  const double largest = std::max(std::abs(channel.range_min), std::abs(channel.range_max));
  // steps of the sensor as integers, where the range fits into 32 bits; else doubles
  if (channel.resolution > 0 &&
      largest / channel.resolution < std::numeric_limits<std::int32_t>::max()) {
    format.encoding = trial::Encoding::kI32;
    format.scale = channel.resolution;
  }
  return format;
}

trial::RawValue RawOf(const trial::ChannelFormat& format, double value) {
  if (format.encoding == trial::Encoding::kF64) return trial::RawValue::F64(value);
  // a value that is not a number has a status of its own; its count is not used
  if (std::isnan(value)) return trial::RawValue::Counts(0);
  return trial::RawValue::Counts(static_cast<std::int32_t>(std::lround(value / format.scale)));
}

// command, version, time and inputs with their digests, so that a trial can be computed again
void AddProvenance(const document::Provenance& provenance, trial::Metadata& metadata) {
  metadata.command_line = provenance.command;
  metadata.fields["version"] = "haptometer " + provenance.version;
  metadata.fields["simulated_utc"] = provenance.utc;
  for (std::size_t k = 0; k < provenance.inputs.size(); ++k) {
    const document::InputFile& input = provenance.inputs[k];
    metadata.fields[fmt::format("input_{}", k + 1)] =
        fmt::format("{}, {} bytes, SHA-256 {}", Printable(input.path), input.bytes, input.sha256);
  }
}

Result<sim::Scene> ReadPlayedScene(const std::string& path) {
  HAPTOMETER_LET(auto scene, sim::ReadSceneFile(path));
  // a start in the steady state requires that it exists
  if (sim::StartOf(scene) != sim::Start::kSteady) return scene;
  const double error = scene.drive.kind == sim::DriveKind::kTones
                           ? sim::SolveSteadyTones(scene).error_estimate
                           : sim::SolveSteadyState(scene).error_estimate;
  if (!(error < 1)) {
    return CannotAnswer(path, "has no steady state: the drive excites an undamped resonance",
                        "add damping, or start = \"rest\" to [run]");
  }
  return scene;
}

trial::Record RecordOf(const sim::Waveforms& waves, const sim::Scene& scene,
                       const std::string& scene_path) {
  using Role = trial::ChannelRole;
  trial::Record record;
  record.channels = {ChannelOf("displacement", Role::kDisplacement, "m", TargetOf(waves, scene)),
                     ChannelOf("voltage", Role::kVoltage, "V", waves.voltage_v),
                     ChannelOf("current", Role::kCurrent, "A", waves.current_a)};
  const auto add = [&](const document::Key& key, const Eigen::VectorXd& values) {
    // absent bodies have no values (no finger without tremor)
    if (values.size() == 0) return;
    record.channels.push_back(
        ChannelOf(std::string(key.name), Role::kOther, std::string(key.unit.symbol), values));
  };
  add({"mover_m", {}, document::kMetre}, waves.mover_m);
  add({"mover_m_per_s", {}, document::kMetrePerSecond}, waves.mover_m_per_s);
  add({"case_m", {}, document::kMetre}, waves.case_m);
  add({"case_m_per_s", {}, document::kMetrePerSecond}, waves.case_m_per_s);
  add({"skin_m", {}, document::kMetre}, waves.skin_m);
  add({"skin_m_per_s", {}, document::kMetrePerSecond}, waves.skin_m_per_s);
  add({"finger_m", {}, document::kMetre}, waves.finger_m);
  add({"force_n", {}, document::kNewton}, waves.force_n);
  add(document::kEvents, waves.events);
  // one segment at a uniform rate from 0 s
  record.rows = static_cast<std::size_t>(waves.rows());
  record.stretches.push_back(
      {.first_row = 0, .rows = record.rows, .start_s = 0, .rate_hz = waves.rate_hz});
  trial::Metadata& metadata = record.metadata;
  metadata.source = "simulated: exact motion, no sensor";
  metadata.hold = "sample";
  metadata.sampling_s = 1 / waves.rate_hz;
  metadata.averages = 1;
  metadata.nominal_rate_hz = waves.rate_hz;
  metadata.laser_spot = Name(scene.sensor ? scene.sensor->target : sim::SensorTarget::kSkin);
  metadata.fields["scene"] = Printable(scene_path);
  metadata.drive_amplitude_v = sim::LargestVoltageV(scene.drive);
  if (scene.drive.frequency_hz > 0) metadata.drive_frequency_hz = scene.drive.frequency_hz;
  return record;
}

Result<void> CheckWaveformPath(const std::string& path, bool overwrite) {
  const auto kind = KindOf(path);
  return kind ? cli::CheckOutput(path, *kind, overwrite) : std::unexpected(kind.error());
}

Result<void> WriteWaveforms(const std::string& path, const trial::Record& record, bool overwrite) {
  HAPTOMETER_LET(const auto kind, KindOf(path));
  if (EndingOf(path) == ".bin") return WriteSimulatedTrial(path, record, overwrite);
  HAPTOMETER_LET(auto file, cli::OutputFile::Begin(path, kind, overwrite));
  auto done = EndingOf(path) == ".csv" ? WriteCsv(record, file) : WriteHdf5(record, file);
  if (done) return file.Finish();
  Error error = done.error();
  error.where = path;
  return std::unexpected(std::move(error));
}

Result<std::vector<plot::Panel>> WaveformPanels(const sim::Waveforms& waves,
                                                const sim::Scene& scene) {
  std::vector<plot::Panel> panels{MotionPanel(waves, "the run", 0)};
  const double highest_hz = sim::HighestFrequencyHz(scene.drive);
  const auto shown =
      highest_hz > 0
          ? static_cast<Eigen::Index>(std::ceil(kShownPeriods * waves.rate_hz / highest_hz))
          : waves.rows();
  // the end has its own panel where the run is twice as long
  if (2 * shown < waves.rows() && sim::IsLasting(scene.drive)) {
    panels.push_back(MotionPanel(waves, "its end", waves.rows() - shown - 1));
  }
  for (plot::Panel& panel : ElectricalPanels(waves)) panels.push_back(std::move(panel));
  HAPTOMETER_LET(auto spectrum, SpectrumPanel(waves));
  panels.push_back(std::move(spectrum));
  return panels;
}

}  // namespace haptometer::tools
