#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/band.h"
#include "base/error.h"
#include "dsp/analysis/band_question.h"
#include "dsp/analysis/sensor_gain.h"
#include "dsp/findings.h"
#include "dsp/spectrum/frequency_response.h"
#include "dsp/statistics/distributions.h"
#include "trial/row_source.h"

namespace haptometer::dsp {

/// What is asked of a record in which the drive's frequency moves.
struct SweepQuestion {
  double lower_hz = kDefaultLowerHz;
  double upper_hz = kDefaultUpperHz;
  /// One over a segment's length, with a drive channel: a fourth of the record, 4 s at most, where
  /// absent (seven segments that overlap by half). Without one, one over a block's length: two
  /// periods of the lower frequency where absent.
  std::optional<double> resolution_hz = {};
};

/// What moves at one frequency.
struct SweepPoint {
  double frequency_hz = 0;
  double amplitude = 0;             ///< m/V, m/A, or m without drive channel
  std::optional<double> phase_rad;  ///< displacement less drive; with a drive channel
  std::optional<double> coherence;  ///< with a drive channel
};

/// One resonance through the points, with 95 % intervals.
struct SweepResonance {
  Resonance fit;
  Interval frequency_hz;    ///< Student's t of the scatter, plus what the method may change
  Interval quality_factor;  ///< the same
};

/// The answer; what it does not hold is among the findings.
struct SweepAnswer {
  bool answered = false;  ///< there are points
  Findings findings;      ///< refusals: why there are none; doubts: what else is not determined
  std::string drive;      ///< name of the drive channel; empty: none
  std::string amplitude_unit = "m";  ///< of the points: "m/V", "m/A", "m"
  TimeWindow window;                 ///< of the record
  double rate_hz = 0;
  double resolution_hz = 0;  ///< of the points: 1/segment, or 1/block without drive channel
  SensorAveraging sensor;
  bool amplitude_verified = false;  ///< false: "sensor averaging unknown"
  std::vector<SweepPoint> points;   ///< by frequency
  std::optional<SweepResonance> resonance;
};

/// Amplitude over frequency, and f0 and Q of the resonance in it.
///
/// The longest piece without a hole (dsp/readings/segments.h; 2^24 samples at most) of the first
/// displacement channel in metres. With a voltage channel, or else a current, measured beside it:
/// H1 by MeasureResponse, phase and coherence. Frequencies are left out whose
/// coherence is below 1 - (0.05/m)^(1/(n - 1)), with m frequencies and n half the degrees of
/// freedom (Bendat and Piersol, Random Data, 4th ed., 9.2): chance exceeds that at any of them in 5
/// % of records. The fit takes every third one, because a Hann window makes noise of nearer ones
/// alike. The intervals add, to Student's t, the change that half as long segments make: the
/// window's own widening falls with its length, so this bounds it.
///
/// Without one: amplitude alone, by SweptAmplitude of the band-passed displacement with the
/// filter's gain divided out, over the longest run of blocks whose frequency moves by less than one
/// over a block's length. f0 and Q then hold for a drive of constant amplitude. With
/// k = 2 rate Q^2 / (pi f0^2) the response at resonance is that of a steady drive times
/// 1 + j k - 3 k^2 - 15 j k^3 + ...; above k = 1/5 these terms do not decrease, and f0 and Q are
/// not determined. Below, f0's interval adds the sweep's lateness Q rate / (pi f0), Q's the change
/// that blocks twice as long make and k^2 Q.
///
/// The sensor's known gain is divided out of amplitudes; frequencies where it is below 0.5 are left
/// out. The upper frequency is lowered to 1/2.56 of the new readings a second. Not determined:
/// times that no clock gave (polled, uneven), too few samples, no resonance.
/// Errors: a wrong band or resolution (Cause::kUsage), no displacement channel in metres, as
/// RowSource::Read. Memory: some ten times the piece.
[[nodiscard]] Result<SweepAnswer> AnalyzeSweep(const trial::RowSource& source,
                                               const SweepQuestion& question);

}  // namespace haptometer::dsp
