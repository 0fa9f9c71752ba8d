#include "tools/simulate/simulated_trial.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "base/clock.h"
#include "base/mapped.h"
#include "base/text.h"
#include "sim/linear/steady_state.h"
#include "sim/scene/scene_file.h"
#include "tools/cli/output_file.h"
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

}  // namespace haptometer::tools
