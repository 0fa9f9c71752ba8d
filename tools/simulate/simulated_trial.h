#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "sim/scene/scene.h"
#include "sim/waveforms.h"
#include "tools/document/provenance.h"
#include "tools/plot/gnuplot.h"
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

/// The most rows that are kept in memory: some half a gigabyte.
inline constexpr double kMostWaveformRows = 2e6;

/// Waveforms as a record: `displacement` of the scene's [sensor] target (the skin without one),
/// exact and as no sensor sees it, then `voltage`, `current`, and as channels of no role
/// mover_m, mover_m_per_s, case_m, case_m_per_s, skin_m, skin_m_per_s, finger_m (where it moves),
/// force_n, events.
[[nodiscard]] trial::Record RecordOf(const sim::Waveforms& waves, const sim::Scene& scene,
                                     const std::string& scene_path);

/// Whether `path` ends in a kind that is written (.csv, .h5, .bin) and may be written. Errors:
/// Cause::kUsage for another ending; as cli::CheckOutput.
[[nodiscard]] Result<void> CheckWaveformPath(const std::string& path, bool overwrite);

/// Writes such a record: as CSV with a column for each channel under its name, as HDF5 (a group
/// `waveforms`) or as a trial.bin; `analyze` reads the displacement out of each.
/// Errors: as CheckWaveformPath and cli::OutputFile.
[[nodiscard]] Result<void> WriteWaveforms(const std::string& path, const trial::Record& record,
                                          bool overwrite);

/// What `simulate --plot` draws: skin and mover's travel over time, their last ten periods of the
/// drive's highest frequency where there are more, voltage and current, and the spectrum of the
/// skin (amplitudes, Hann, all rows as one segment) over six decades up to eight times the highest
/// frequency that the rows were chosen for. Error: as dsp::WelchSpectrum, fewer than 2 rows.
[[nodiscard]] Result<std::vector<plot::Panel>> WaveformPanels(const sim::Waveforms& waves,
                                                              const sim::Scene& scene);

}  // namespace haptometer::tools
