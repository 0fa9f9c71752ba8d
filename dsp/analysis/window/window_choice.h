#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/band_filtering.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/analysis/hum.h"
#include "dsp/analysis/window/window_states.h"

/// The step of AnalyzeBand that chooses which rows its numbers are of: from the states of the drive
/// to the window, and to the intervals without drive that noise is measured in.
namespace haptometer::dsp {

/// Samples [begin, end) of a signal, all free of transients.
struct ChosenPart {
  const BandSignal* signal = nullptr;
  std::size_t begin = 0;
  std::size_t end = 0;
  SampleRanges excluded{};            ///< samples within, bumps
  SampleRanges may_be_bumps{};        ///< samples within; most of them
  std::vector<SteadyLine> hum{};      ///< of the signal; to be subtracted
  UsedPart part{};                    ///< how it was chosen; window and rows are not set yet
  std::optional<DriveDelay> delay{};  ///< of the vibration behind a drive channel
  std::optional<Finding> refusal{};   ///< why there is no drive; its numbers are not set yet
  std::optional<Finding> other{};     ///< vibration outside of the window
};

/// The longest part that a tone is sought and fitted in as a whole, in samples (5 s at 392 kHz).
inline constexpr std::size_t kMostFitted = std::size_t{1} << 21U;
/// Samples in the middle of a longer part that stand for it: 1.3 s at 392 kHz, 52 s at 10 kHz.
inline constexpr std::size_t kFittedOfLonger = std::size_t{1} << 19U;

/// How many samples in the middle of a part of `size` a tone is sought and fitted in.
[[nodiscard]] constexpr std::size_t FittedOf(std::size_t size) {
  return size <= kMostFitted ? size : kFittedOfLonger;
}

/// Finds the states of the drive in `all` (at least one), fills `analysis.states`, and chooses as
/// `question` says (see AnalyzeBand).
///
/// The longest steady state that is on, a block shorter at each end at which it changes. Where no
/// state is on in blocks of a period of the lower corner, blocks of 4 and 16 times that are tried,
/// and the strongest tone of the whole: they show tones below the noise. Hum (dsp/analysis/hum.h)
/// is subtracted before. Blocks of the window in which the residual rises far above its median are
/// bumps, and excluded. Nothing, and a refusal, where a given window is not free of transients.
/// Errors: as RowSource::Read.
[[nodiscard]] Result<std::optional<ChosenPart>> ChoosePart(const std::vector<BandSignal>& all,
                                                           const BandQuestion& question,
                                                           BandAnalysis* analysis);

/// Filtered samples [begin, end), or the FittedOf(end - begin) in their middle.
[[nodiscard]] Result<std::vector<double>> ReadMiddle(const BandSignal& signal, std::size_t begin,
                                                     std::size_t end);

}  // namespace haptometer::dsp
