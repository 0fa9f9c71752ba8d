#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_question.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/analysis/decision_limits.h"
#include "dsp/analysis/hum.h"
#include "dsp/filter/butterworth.h"

/// States of the drive: what a filtered segment is like, block by block, and one segmentation of
/// the blocks, from which window and noise follow.
namespace haptometer::dsp {

/// One block: the tone on the ridge of the spectrum, and what is beside it.
///
/// The least-squares fit of (a + a' t) cos + (b + b' t) sin about the block's middle at the ridge's
/// frequency: an amplitude that rises and a frequency that differs by a few hertz leave nothing in
/// the residual.
struct DriveBlock {
  std::complex<double> amplitude_m;  ///< a - i b: of cos(2 pi f t + phase), t from the fit's middle
  double frequency_hz = 0;           ///< of the fit: ridge + Im(amplitude' / amplitude) / (2 pi)
  double mean_square = 0;            ///< of the samples, m2
  double residual = 0;               ///< mean square beside the tone, m2; four parameters less

  [[nodiscard]] double level_m() const { return std::abs(amplitude_m); }
};

/// The blocks of a segment without its transients, one after the other; the last one ends within a
/// block of their end.
///
/// Of a long segment the fit is of a part in each block's middle. The mean square is that of the
/// whole block, and where it differs from the part's by more than a twentieth and four standard
/// deviations of what noise gives, the rest of the difference is added to the residual: a pause or
/// a burst beside the part shows there.
struct BlockCourse {
  double start_s = 0;
  double block_s = 0;
  double bandwidth_hz = 0;  ///< of the noise
  std::vector<DriveBlock> blocks;
  double fitted = 1;                    ///< part of a block that its fit is of
  std::vector<DriveBlock> following{};  ///< fits of what follows each part; empty: the next block

  /// From the begin of block `first` to that of block `end`.
  [[nodiscard]] TimeWindow Window(std::size_t first, std::size_t end) const {
    return {start_s + static_cast<double>(first) * block_s,
            start_s + static_cast<double>(end) * block_s};
  }
  /// Independent values in a fit: 2 x bandwidth x its duration.
  [[nodiscard]] double degrees_of_freedom() const { return 2 * bandwidth_hz * fitted * block_s; }
};

/// Filtered samples of a segment of `size` from which MeasureBlocks finds the shortest blocks of a
/// long segment: as few as hold the band.
///
/// Every n-th sample, n the greatest number that leaves 5.2 upper corners: behind both passes of an
/// order-6 filter what folds into the band is below 1e-7 of it. All of them where they are 2^21 at
/// most (16 MB: ten minutes of a band up to 500 Hz), else at most 2^20 in frames.
[[nodiscard]] KeptFrames FramesToKeep(std::size_t size, double rate_hz, const BandPass& band);

/// Filtered samples [begin, end) of a signal, one in n of FramesToKeep's, with `lines` subtracted.
/// Errors: as BandSignal::Read. Memory: the samples.
[[nodiscard]] Result<std::vector<double>> ReadForStates(const BandSignal& signal,
                                                        const BandPass& band,
                                                        std::span<const SteadyLine> lines,
                                                        std::size_t begin, std::size_t end);

/// Measures what is free of transients of `signal` in blocks of at least `least_block_s`.
///
/// A block lasts the longer of `least_block_s` and four periods of the tone, whose frequency is
/// that of the ridge through the spectra of two blocks each (dsp/spectrum/ridge.h). A tone that
/// moves by 100 Hz/s is followed.
///
/// Where FramesToKeep gives frames, there are so many blocks as frames of two of those blocks hold
/// 2^20 samples, each as long as it takes: the spectrum is that of the frame in the middle, the fit
/// that of its first half. A record of which more than four blocks differ from the others or from
/// their frame is measured block by block all the same, for 26 B a thinned sample. Errors: as
/// BandSignal::Read. Cost: a transform a block; frames of other blocks than the shortest are
/// filtered again. Memory: 10 B a bin and block, 64 MB at most.
[[nodiscard]] Result<BlockCourse> MeasureBlocks(const BandSignal& signal, const BandPass& band,
                                                double least_block_s,
                                                std::span<const SteadyLine> lines);

/// What the drive does in an interval.
enum class DriveState : std::uint8_t {
  kOn,          ///< a tone that exceeds what noise puts on the ridge
  kOff,         ///< no such tone
  kTransition,  ///< the drive is switched, or comes or goes below the noise
};

/// "on", "off", "transition".
[[nodiscard]] std::string_view Name(DriveState state);

/// Blocks [first, end) of one state.
struct StateInterval {
  DriveState state = DriveState::kOff;
  std::size_t first = 0;
  std::size_t end = 0;
  TimeWindow time;
  double level_m = 0;  ///< mean amplitude of the tone
  double drift = 0;    ///< change of the amplitude from begin to end, as a part of level_m
  double drift_uncertainty = 0;  ///< standard, from the scatter
  double scatter = 0;  ///< standard deviation of the blocks about that line, as a part of level_m
  /// Half width of the mean level over other parts of an amplitude that goes up and down n times,
  /// as a part of level_m, where drive and window end within one: 2 sqrt(2) scatter / (pi n); else
  /// 0.
  double modulation = 0;
  double residual = 0;  ///< mean square beside the tone, m2
  double rms_m = 0;     ///< of the filtered samples
  double from_hz = 0;   ///< frequency at begin and end, by a line through the blocks
  double to_hz = 0;
  double coherence = 0;  ///< of a block's phase with the one before: 1 of a tone, 0 of noise
  bool is_steady = false;
  /// A clear tone at the band's foot that is too short to be told from tremor; it is off.
  bool is_short_at_foot = false;

  [[nodiscard]] std::size_t blocks() const { return end - first; }
  /// Whether the amplitude changes noticeably, and by more than its uncertainty gives (1e-3).
  [[nodiscard]] bool Drifts() const {
    return std::abs(drift) > std::max(kNoticeable, kFalseAlarmDeviations * drift_uncertainty);
  }
};

/// Splits a course into states.
///
/// The cheapest partition (dsp/statistics/change_points.h) of the level |z| (a line in each state)
/// and of ln(residual) (a constant) together. With m blocks in a state, RSS their squared residuals
/// and v = max(s^2, (RSS + 2 s^2) / (m + 2)) their variance,
///   cost = sum over states of m ln v1 + RSS1 / v1 + m ln v2 + RSS2 / v2 + 5 c ln n,   c = 1.5
/// s is what noise gives the level of a block and the logarithm of its residual.
///
/// A state is on where its level exceeds what noise alone puts on the ridge; a state of one block
/// between others is a transition, and so is one that is off but changes by half its level.
/// Neighbours of the same kind whose levels meet within 2 % are one, and so are those of a drive
/// whose amplitude goes up and down all the time. A state is steady where its level changes and
/// scatters by less than half of itself, and the phases of its blocks continue each other. Up to
/// twice `lower_hz`, where red noise has a narrow ridge and tremor its harmonics, it scatters by
/// less than 0.15 over eight blocks, or changes and scatters by less than 0.02 over three that the
/// tone explains; what is not steady there is off. Limits and error rates:
/// dsp/analysis/decision_limits.h. Cost: linear in the blocks for states of bounded length.
[[nodiscard]] std::vector<StateInterval> FindStates(const BlockCourse& course, double lower_hz);

}  // namespace haptometer::dsp
