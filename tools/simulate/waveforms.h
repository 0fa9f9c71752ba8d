#pragma once

#include <string>
#include <vector>

#include "base/error.h"
#include "sim/scene/scene.h"
#include "sim/waveforms.h"
#include "tools/plot/gnuplot.h"
#include "trial/record.h"

namespace haptometer::tools {

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
