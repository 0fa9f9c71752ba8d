#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/band_filtering.h"
#include "dsp/analysis/band_noise.h"
#include "dsp/analysis/rms_estimate.h"
#include "dsp/analysis/window/window_choice.h"
#include "dsp/spectrum/sine_fit.h"
#include "trial/record.h"

/// A window while MeasureWindow (dsp/analysis/window/window_numbers.h) measures it, and the steps
/// of that. Errors of all: as RowSource::Read.
namespace haptometer::dsp {

/// What is being measured. The steps fill it in this order, each by what those before it left:
/// SamplesOf, ToneOf, `rows` by WholePeriods, DescribePart, `numbers.tone`, MeasurePower; the
/// sensor's gain (`power.sensor_gain`, window_numbers.cc), TakeFloor, BoundSteps, BoundsOf,
/// `numbers.rms` (rms_estimate.h), FinishTone, DescribeHarmonics.
struct MeasuredWindow {
  const trial::Record& head;
  double step_m = 0;  ///< one step of the displacement's source
  const ChosenPart& chosen;
  const BandQuestion& question;
  BandAnalysis& analysis;
  BandNumbers numbers{};
  ThinnedSamples samples{};         ///< filtered, of the chosen part, or of its middle
  NoiseBeside beside{};             ///< of these
  double steps_m = 0;               ///< bound of what the converter's steps hide
  double hum_square = 0;            ///< mean square that hum adds, m2
  std::optional<SineFit> second{};  ///< the strongest tone beside the tone
  double mirrored_m = 0;  ///< amplitude as far on the tone's other side, of a modulation's sideband
  double tone_variance = 0;         ///< of the tone's mean square, m4
  std::optional<double> density{};  ///< of the noise at the drive, m2/Hz
  std::size_t rows = 0;             ///< of the window
  BandPower power{};                ///< what the RMS is estimated from (rms_estimate.h)

  [[nodiscard]] const BandSignal& signal() const { return *chosen.signal; }
  [[nodiscard]] double rate_hz() const { return signal().rate_hz(); }
  [[nodiscard]] double duration_s() const { return static_cast<double>(rows) / rate_hz(); }
  [[nodiscard]] const BandPass& band() const { return analysis.band; }
  [[nodiscard]] double bandwidth_hz() const { return band().upper_hz - band().lower_hz; }
};

/// Rows of the part's begin that hold whole periods of the tone: a part of a period biases its RMS.
[[nodiscard]] std::size_t WholePeriods(const MeasuredWindow& window,
                                       const std::optional<SineFit>& tone);

/// States which rows are the window's, what of them is excluded, and the hum.
void DescribePart(MeasuredWindow& window);

/// Mean square in m2 over the samples kept, `inset` away from each end of what is kept, from the
/// sums of their cells; 0 where none are.
[[nodiscard]] Result<double> MeanSquareKept(const MeasuredWindow& window,
                                            const SampleRanges& excluded, std::size_t inset);

/// Filtered samples of [begin, end) in m, or of their middle, without hum; the hum's part of their
/// mean square, m2, goes to `hum_square`.
[[nodiscard]] Result<std::vector<double>> WithoutHum(const MeasuredWindow& window,
                                                     std::size_t begin, std::size_t end,
                                                     double* hum_square);

/// Filtered samples of the longest part kept, thinned; sets `window.hum_square`.
[[nodiscard]] Result<ThinnedSamples> SamplesOf(MeasuredWindow& window);

// tone: dsp/analysis/window/window_tone.cc

/// The strongest tone of the samples; nothing where there is none, or where a drive that is clear
/// in every block moves by so many bins that no sine holds half of it. Fitted again without the
/// strongest one of the others (`window.second`), which moves it as a line below the band does.
[[nodiscard]] std::optional<SineFit> ToneOf(MeasuredWindow& window);

/// The tone before the filter and before the sensor, with uncertainties from the noise about it.
/// Power beside the tone of a weak drive is hardly told from noise: `numbers.rms.lower_m` is then
/// lowered to the tone's.
void FinishTone(MeasuredWindow& window);

/// Harmonics of the tone in the samples before the filter, with a cubic drift; motion below the
/// band that one model explains is subtracted first, because it would cover them.
[[nodiscard]] Result<void> DescribeHarmonics(MeasuredWindow& window);

// noise: dsp/analysis/window/window_noise.cc

/// The window's mean square, what its tone leaves of it, and the noise beside the drive.
[[nodiscard]] Result<void> MeasurePower(MeasuredWindow& window);

/// Noise from the question's file, the intervals without drive, or the spectrum beside the drive;
/// then what is drive:  mean square - noise, with the variance 2 drive S / T of its beat with
/// noise.
[[nodiscard]] Result<void> TakeFloor(MeasuredWindow& window);

// errors beyond scatter: dsp/analysis/window/window_bounds.cc

/// What rounding to steps may change of the drive's RMS, as a half width in m: `window.steps_m`.
[[nodiscard]] Result<void> BoundSteps(MeasuredWindow& window);

/// Half widths (m) of errors that the scatter of the samples does not contain.
[[nodiscard]] Result<std::vector<RmsBound>> BoundsOf(const MeasuredWindow& window);

}  // namespace haptometer::dsp
