#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_question.h"
#include "dsp/analysis/drive_states.h"
#include "dsp/analysis/rms_estimate.h"
#include "dsp/analysis/sensor_gain.h"
#include "dsp/findings.h"
#include "dsp/readings/faults.h"
#include "dsp/spectrum/electrical.h"
#include "dsp/spectrum/envelope.h"
#include "dsp/spectrum/kinematics.h"
#include "dsp/spectrum/sine_fit.h"
#include "dsp/spectrum/slow_motion.h"
#include "dsp/spectrum/tone.h"
#include "trial/record.h"
#include "trial/row_source.h"

/// How displacement becomes numbers, step by step, and where each step is (1 to 3 in dsp/readings/,
/// the rest here):
///
///   1. uneven times to a grid   regular_grid.h
///   2. artifacts                clean_rows.h: rows that are absent, codes, spikes and held
///   readings
///                               become missing values (row_block.h, row_kernel.h, faults.h,
///                               raw_summary.h)
///   3. segments                 segments.h, their short holes filled by interpolation.h
///   4. what the record is       plausibility.h there; record_facts.h, and what is left where it is
///                               too slow for the band
///   5. the filter               band_filtering.h gives a band_signal.h for each piece, with
///                               below_band_model.h where too little settles without
///   6. the states of the drive  hum.h, drive_states.h
///   7. which rows count         window/window_choice.h
///   8. numbers of that window   window/window_numbers.h, by the steps of window/measured_window.h,
///                               with band_noise.h, sensor_gain.h, digitisation.h, rms_estimate.h
///   9. what goes with them      drive_channel.h, window/window_remarks.h
///
/// band_question.h is what is asked, this file what is answered. A record whose frequency moves has
/// a road of its own, sweep_analysis.h.
namespace haptometer::dsp {

/// What every record with one measurement or more tells, whatever the band.
struct RecordFacts {
  double rate_hz = 0;              ///< of the longest stretch
  double fresh_rate_hz = 0;        ///< the same without readings handed out again
  double duration_s = 0;           ///< of all stretches together
  double observable_upper_hz = 0;  ///< fresh_rate_hz / 2.56
  double offset_m = 0;             ///< mean of all measurements
  double peak_to_peak_m = 0;       ///< of all measurements, unfiltered
  std::size_t rows = 0;
  std::size_t measured = 0;  ///< rows with a measurement
  std::size_t bridged = 0;   ///< rows interpolated
  std::size_t segments = 0;  ///< pieces filtered each on its own
  std::array<std::size_t, trial::kSampleStatusCount> by_status{};  ///< rows of each status
};

/// Which rows the numbers are of, and how they were chosen.
struct UsedPart {
  TimeWindow window;  ///< all free of transients; whole periods of the tone
  std::size_t first_row = 0;
  std::size_t rows = 0;
  bool from_drive = false;        ///< whether the window lies in a state that is on
  StateInterval state;            ///< that state
  std::vector<TimeWindow> quiet;  ///< intervals of the segment without drive, away from it
  Finding why;                    ///< how they were chosen
};

/// Motion below the band and what of it the filter lets through.
struct BelowBand {
  double frequency_hz = 0;  ///< of the strongest tone below the lower corner
  double amplitude_m = 0;   ///< before the filter
  double leaked_rms_m = 0;  ///< amplitude |H(frequency)|^2 / sqrt(2): part of the band RMS
  bool modelled = false;    ///< taken out before the filter (dsp/spectrum/below_band_model.h)
};

/// The strongest tone in the band.
struct ToneNumbers {
  /// As it was before the filter; its amplitude as the sensor handed it out. Uncertainties are from
  /// the noise about it and from what leaks from below the band.
  SineFit fit;
  double amplitude_m = 0;  ///< with the sensor's gain divided out, where that is known
  double amplitude_uncertainty_m = 0;
  double amplitude_lower_m = 0;  ///< 95 % interval
  double amplitude_upper_m = 0;
  double frequency_lower_hz = 0;  ///< 95 % interval
  double frequency_upper_hz = 0;
  double sine_rms_m = 0;             ///< RMS of the fitted sine behind the filter
  double share_of_rms = 0;           ///< sine_rms_m / RMS as measured: 1 for a clean tone
  double velocity_m_per_s = 0;       ///< amplitude: 2 pi f amplitude_m
  double acceleration_m_per_s2 = 0;  ///< amplitude: (2 pi f)^2 amplitude_m
};

/// When the drive and the vibration of the window's part began, in the record's time.
struct OnsetNumbers {
  Edge edge;  ///< of unfiltered samples, at the tone (dsp/spectrum/envelope.h)
  /// When the voltage, current or trigger left its level of the quiet part by a tenth of the most
  /// that it does then (more where it is noisy); nothing without such a channel, or where its noise
  /// is above a quarter of that. A row before the first that did, and for a voltage or a current
  /// the time that a sine may need to get there (0.032 periods), are the interval whose middle this
  /// is.
  std::optional<double> drive_s;
  double drive_uncertainty_s = 0;  ///< standard: that interval's half width / sqrt(3)
  /// From there to the vibration's low level; the sensor's own delay is in it.
  std::optional<double> latency_s;
  double latency_uncertainty_s = 0;  ///< standard, of both
};

/// What the sensor did to the numbers.
struct SensorNumbers {
  SensorAveraging averaging;
  std::optional<double> gain_at_tone;      ///< where it is known and there is a tone
  bool divided_out = false;                ///< whether RMS and amplitude hold it
  std::optional<GainBounds> gain_in_band;  ///< least and greatest over the band
  bool amplitude_verified = false;         ///< false: "sensor averaging unknown", or below 0.5
};

/// How long after the drive's channel the vibration changes.
struct DriveDelay {
  double delay_s = 0;
  double uncertainty_s = 0;  ///< standard
  std::size_t changes = 0;   ///< that it is the median of
};

/// What a window says of the band.
struct BandNumbers {
  UsedPart part;
  std::vector<TimeWindow> excluded;  ///< parts of the window that no number is of
  std::vector<SteadyLine> hum;       ///< subtracted; times count from the segment's first sample
  std::optional<DriveDelay> delay;   ///< nothing without a drive channel that changes
  RmsEstimate rms;
  /// Too much of the window is clipped: rms.lower_m and the tone's amplitude_lower_m are lower
  /// limits, and nothing is known above them.
  bool is_lower_limit = false;
  double whole_rms_m = 0;     ///< of all filtered samples, unsettled ends and pauses too
  double peak_to_peak_m = 0;  ///< over the window, as measured
  double residual_rms_m = 0;  ///< over the window, without the tone and its harmonics in the band
  double bridged_rms_m = 0;   ///< bound on what bridging adds; 0: none bridged
  std::optional<NoiseFloor> floor;
  /// Without a floor, the noise (RMS) that the RMS may hold: what is beside a steady tone, else
  /// noise as dense throughout the band as in its quietest part.
  double kept_noise_m = 0;
  std::optional<BelowBand> below_band;
  std::optional<ToneNumbers> tone;
  /// Of unfiltered samples, without what dsp/spectrum/below_band_model.h explains below the band
  /// (20 s at most), up to the tenth and record.observable_upper_hz, as the sensor handed them out;
  /// nothing where no second one is observable. Of a window of more than 2^21 samples the middle
  /// 2^19.
  std::optional<Harmonics> harmonics;
  /// Nothing without a quiet part before the drive's, or where the noise is above a sixth of it.
  std::optional<OnsetNumbers> onset;
  /// Of filtered samples, in metres, as measured; `begin` and `end` are rows. Nothing where the
  /// rate is below about 3.1 times the upper corner. At most 2^21 samples.
  std::optional<Kinematics> kinematics;
  /// Of the record's voltage (V) and current (A) at the tone's frequency over the window; nothing,
  /// and a note, where they do not say. At most 2^21 samples.
  std::optional<ElectricalState> electrical;
  SensorNumbers sensor;
  NoisePower power;  ///< of the whole window, tone and all: what another trial takes as its floor
};

/// A tone of known frequency in a record too slow for the band.
struct KnownTone {
  SineFit fit;           ///< amplitude as the sensor handed it out
  bool aliased = false;  ///< the frequency lies above half the rate of new readings
};

/// What a record says about vibration in a band.
struct BandAnalysis {
  /// Whether `numbers` answers the question. Where it is false although `numbers` is there, they
  /// are an estimate that may be shown with the refusals beside it only.
  bool answered = false;
  Findings findings;  ///< refusals: why not; none when answered
  RecordFacts record;
  Faults faults;                       ///< rows count from the record's first
  BandPass band;                       ///< as used: the order may have been lowered
  std::optional<BandNumbers> numbers;  ///< nothing where no part could be filtered
  std::optional<KnownTone> known_tone;
  /// Relative standard uncertainty of the sensor's gain, part of the uncertainty of every length;
  /// nothing where none is stated.
  std::optional<double> gain_uncertainty;
  std::vector<StateInterval> states;  ///< of the drive, in order of time
  /// Drift and tremor of all rows, by means of 4 ms or more; nothing for a record with holes that
  /// long, or of uneven stretches.
  std::optional<SlowMotion> slow_motion;

  /// Row by row: the filtered signal, NaN where there is none; empty where nothing was filtered.
  std::vector<double> filtered_m;
};

/// Answers how much a record vibrates within a band.
///
/// The first displacement channel in metres is split into segments (dsp/readings/segments.h); each
/// is filtered with zero phase on its own, if it is no shorter than 2 periods of the lower corner.
/// Where less than half of one settles
/// (dsp/filter/transient.h), motion below the band is modelled (dsp/spectrum/below_band_model.h).
/// Too little settled all the same (below 2 periods of the lower corner): the order is lowered as
/// far as 2, as long as what leaks from below the band changes the RMS by less than 1 %; otherwise
/// the record is not answered.
///
/// Readings at known but uneven times (Record::times_are_known) are put on a regular grid first
/// (dsp/readings/regular_grid.h), and a note states rate, scatter and bound; where that cannot be
/// done, it is refused. All rows in the answer count the record's readings.
///
/// The window is the longest steady state of the drive (dsp/analysis/window/window_choice.h), whole
/// periods of its tone; without a state that is on nothing is answered, and the numbers are an
/// estimate of all that is free of transients. Of more than 2^21 samples the tone is sought in the
/// middle 2^19.
///
/// RMS^2 = (mean square - noise) / gain^2 (dsp/analysis/rms_estimate.h): the noise is the
/// question's floor, that of the record's intervals without drive (two periods of the lower
/// corner), or the spectrum beside the drive; the gain is the sensor's at the tone. Hum that is
/// there all the time is subtracted, and bumps are excluded. Type B bounds: what leaks from below
/// the band, the band's foot, hum that was not seen alone, drift of the amplitude, quantisation,
/// interpolation, and transients. The sensor's gain is included where its uncertainty is stated.
///
/// Not answered: fewer new readings a second than 2.56 x the upper corner; a polled sensor whose
/// times are uncertain by 0.1/upper corner or more (its readings are of unknown age; a free-running
/// one has a clock, however its arrivals scatter): then a tone of known frequency f is still fitted
/// where times are known to 0.1/f; readings that stand still (dsp/analysis/record_facts.h); too
/// little settled; a sensor gain below 0.5 at the tone; more
/// than 0.1 % of the window clipped. Errors: a wrong band or window (Cause::kUsage), no
/// displacement channel in metres, no measurement in it or one beyond 1e30 m
/// (Cause::kCannotAnswer).
/// `threads` changes no number; drift and tremor are found on a thread beside them. Further errors:
/// as RowSource::Read.
[[nodiscard]] Result<BandAnalysis> AnalyzeBand(const trial::RowSource& source,
                                               const BandQuestion& question, int threads = 1);
/// The same of a record in memory.
[[nodiscard]] Result<BandAnalysis> AnalyzeBand(const trial::Record& record,
                                               const BandQuestion& question);

/// Unfiltered displacement over the window of an analysis, small holes bridged.
struct WindowSamples {
  double start_s = 0;
  double rate_hz = 0;
  std::vector<double> values_m;
};

/// The samples that `analysis` (which has numbers) was made of `source`, at most `most` from the
/// middle of its window. Errors: as RowSource::Read. Cost: one pass over the record for its holes.
[[nodiscard]] Result<WindowSamples> ReadWindow(const trial::RowSource& source,
                                               const BandAnalysis& analysis, std::size_t most);

}  // namespace haptometer::dsp
