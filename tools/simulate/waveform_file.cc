#include "tools/simulate/waveform_file.h"

#include <fmt/format.h>

#include <filesystem>
#include <iterator>
#include <utility>
#include <vector>

#include "base/text.h"
#include "tools/cli/output_file.h"
#include "tools/simulated_trial.h"
#include "trial/export/export.h"
#include "trial/import/csv_header.h"
#include "trial/trial_reader.h"

namespace haptometer::tools {
namespace {

constexpr std::size_t kPieceBytes = 1U << 16;

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

const Eigen::VectorXd& TargetOf(const sim::Waveforms& waves, const sim::Scene& scene) {
  const auto target = scene.sensor ? scene.sensor->target : sim::SensorTarget::kSkin;
  if (target == sim::SensorTarget::kMover) return waves.mover_m;
  return target == sim::SensorTarget::kCase ? waves.case_m : waves.skin_m;
}

// a channel's name as a column, with its unit
std::string ColumnOf(const trial::Channel& channel) {
  switch (channel.role) {
    case trial::ChannelRole::kDisplacement:
      return "displacement_m";
    case trial::ChannelRole::kVoltage:
      return "voltage_v";
    case trial::ChannelRole::kCurrent:
      return "current_a";
    default:
      return channel.name;
  }
}

std::string HeadOf(const trial::Record& record) {
  std::string head = trial::CsvMetadataLines(record.metadata);
  head += trial::CsvCommentLine("times", "grid");
  const trial::Stretch& stretch = record.stretches.front();
  head += trial::CsvCommentLine(
      "stretch", fmt::format("0 {} {} {} 0", stretch.rows, stretch.start_s, stretch.rate_hz));
  std::string columns = "time_s";
  for (std::size_t c = 0; c < record.channels.size(); ++c) {
    const trial::Channel& channel = record.channels[c];
    columns += "," + ColumnOf(channel);
    if (channel.role != trial::ChannelRole::kOther) continue;
    head += trial::CsvCommentLine(fmt::format("channel.{}.unit", c + 1), channel.unit);
  }
  return head + columns + "\n";
}

Result<void> WriteCsv(const trial::Record& record, cli::OutputFile& file) {
  std::string text = HeadOf(record);
  for (std::size_t row = 0; row < record.rows; ++row) {
    fmt::format_to(std::back_inserter(text), "{}", TimeOf(record, row));
    for (const trial::Channel& channel : record.channels) {
      fmt::format_to(std::back_inserter(text), ",{}", channel.values[row]);
    }
    text += '\n';
    if (text.size() < kPieceBytes && row + 1 < record.rows) continue;
    if (auto done = file.Write(text); !done) return done;
    text.clear();
  }
  return {};
}

Result<void> WriteHdf5(const trial::Record& record, const cli::OutputFile& file) {
  const auto part = file.PathForLibrary();
  if (!part) return std::unexpected(part.error());
  auto writer = trial::Hdf5Writer::Create(*part);
  if (!writer) return std::unexpected(writer.error());
  trial::Recording recording;
  recording.record = record;
  recording.report.closed = true;
  auto done = writer->Add("waveforms", recording, nullptr);
  return done ? writer->Close() : done;
}

}  // namespace

trial::Record RecordOf(const sim::Waveforms& waves, const sim::Scene& scene,
                       const std::string& scene_path) {
  using Role = trial::ChannelRole;
  trial::Record record;
  record.channels = {ChannelOf("displacement", Role::kDisplacement, "m", TargetOf(waves, scene)),
                     ChannelOf("voltage", Role::kVoltage, "V", waves.voltage_v),
                     ChannelOf("current", Role::kCurrent, "A", waves.current_a)};
  const auto add = [&](const char* name, const char* unit, const Eigen::VectorXd& values) {
    if (values.size() > 0) record.channels.push_back(ChannelOf(name, Role::kOther, unit, values));
  };
  add("mover_m", "m", waves.mover_m);
  add("mover_m_per_s", "m/s", waves.mover_m_per_s);
  add("case_m", "m", waves.case_m);
  add("case_m_per_s", "m/s", waves.case_m_per_s);
  add("skin_m", "m", waves.skin_m);
  add("skin_m_per_s", "m/s", waves.skin_m_per_s);
  add("finger_m", "m", waves.finger_m);
  add("force_n", "N", waves.force_n);
  add("events", "", waves.events);
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
  const auto kind = KindOf(path);
  if (!kind) return std::unexpected(kind.error());
  if (EndingOf(path) == ".bin") return WriteSimulatedTrial(path, record, overwrite);
  auto file = cli::OutputFile::Begin(path, *kind, overwrite);
  if (!file) return std::unexpected(file.error());
  auto done = EndingOf(path) == ".csv" ? WriteCsv(record, *file) : WriteHdf5(record, *file);
  if (done) return file->Finish();
  Error error = done.error();
  error.where = path;
  return std::unexpected(std::move(error));
}

}  // namespace haptometer::tools
