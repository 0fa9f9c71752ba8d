#pragma once

#include <memory>
#include <string>

#include "base/error.h"
#include "sim/scene/scene.h"
#include "tools/document/provenance.h"
#include "trial/byte_io.h"
#include "trial/record.h"
#include "trial/trial_format.h"

namespace haptometer::tools {

/// Writes a simulated record as a trial.bin; `overwrite` replaces an older one.
/// Errors: as cli::OutputFile.
[[nodiscard]] Result<void> WriteSimulatedTrial(const std::string& path, const trial::Record& record,
                                               bool overwrite);

/// The same into any sink; `name` stands for the path in messages.
[[nodiscard]] Result<void> WriteSimulatedTrialIn(std::unique_ptr<trial::ByteSink> sink,
                                                 const std::string& name,
                                                 const trial::Record& record);

/// How a trial keeps a simulated channel: one that is rounded to steps as whole counts of them, any
/// other as doubles.
[[nodiscard]] trial::ChannelFormat FormatOf(const trial::Channel& channel);

/// `value` (in the channel's unit) as `format` keeps it; 0 counts for NaN, which is no measurement.
[[nodiscard]] trial::RawValue RawOf(const trial::ChannelFormat& format, double value);

/// Adds the program's version and command, and the input's SHA-256 and the time as fields.
void AddProvenance(const document::Provenance& provenance, trial::Metadata& metadata);

/// A scene that can be played as a motion. Errors: those of sim::ReadSceneFile;
/// Cause::kCannotAnswer for a steady state that does not exist.
[[nodiscard]] Result<sim::Scene> ReadPlayedScene(const std::string& path);

}  // namespace haptometer::tools
