#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "dsp/analysis/drive_blocks.h"
#include "dsp/analysis/time_window.h"

/// States of the drive: one segmentation of a record's blocks, from which window and noise follow.
namespace haptometer::dsp {

/// What the drive does in an interval.
enum class DriveState : std::uint8_t {
  kOn,          ///< a tone that exceeds what noise puts on the ridge
  kOff,         ///< no such tone
  kTransition,  ///< a block in which the drive is switched
  kArtifact,    ///< residual power that rises and decays: a bump
};

/// "on", "off", "transition", "artifact".
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
  double scatter = 0;   ///< standard deviation of the blocks about that line, as a part of level_m
  double residual = 0;  ///< mean square beside the tone, m2
  double rms_m = 0;     ///< of the filtered samples
  double from_hz = 0;   ///< frequency at begin and end, by a line through the blocks
  double to_hz = 0;
  double coherence = 0;  ///< of a block's phase with the one before: 1 of a tone, 0 of noise
  bool is_steady = false;

  [[nodiscard]] std::size_t blocks() const { return end - first; }
  /// Whether the amplitude changes by more than 2 % and by more than its uncertainty gives (1 %).
  [[nodiscard]] bool Drifts() const {
    return std::abs(drift) > std::max(0.02, 2.6 * drift_uncertainty);
  }
};

/// Splits a course into states.
///
/// Optimal partitioning (Jackson et al., IEEE Signal Processing Letters 12(2), 2005, p. 105) with
/// the pruning of Killick et al. (JASA 107, 2012, p. 1590), of the level |z| (a line in each state)
/// and of ln(residual) (a constant) together. With m blocks in a state, RSS their squared residuals
/// and v = max(s^2, (RSS + 2 s^2) / (m + 2)) their variance,
///   cost = sum over states of m ln v1 + RSS1 / v1 + m ln v2 + RSS2 / v2 + 5 c ln n,   c = 1.5
/// s is what noise gives the level of a block and the logarithm of its residual. More than 2048
/// blocks are split in pieces, whose borders are kept only where they lower the cost.
///
/// A state is on where its level exceeds what noise alone puts on the ridge; a state of one block
/// between others is a transition. Neighbours of the same kind whose levels meet within 3 % are
/// one. A state is steady where its level changes by less than half and scatters by less than 0.6
/// of itself (0.15, and six blocks at least, up to twice `lower_hz`, where red noise has a narrow
/// ridge), and the phases of its blocks continue each other. Error rates:
/// tests/dsp/analysis/drive_states_test.cc. Cost: linear in the blocks for states of bounded
/// length.
[[nodiscard]] std::vector<StateInterval> FindStates(const BlockCourse& course, double lower_hz);

}  // namespace haptometer::dsp
