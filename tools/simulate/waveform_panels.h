#pragma once

#include <vector>

#include "base/error.h"
#include "sim/scene/scene.h"
#include "sim/waveforms.h"
#include "tools/plot/gnuplot.h"

namespace haptometer::tools {

/// What `simulate --plot` draws: skin and mover's travel over time, their last ten periods of the
/// drive's highest frequency where there are more, voltage and current, and the spectrum of the
/// skin (amplitudes, Hann, all rows as one segment) over six decades up to eight times the highest
/// frequency that the rows were chosen for. Error: as dsp::WelchSpectrum, fewer than 2 rows.
[[nodiscard]] Result<std::vector<plot::Panel>> WaveformPanels(const sim::Waveforms& waves,
                                                              const sim::Scene& scene);

}  // namespace haptometer::tools
