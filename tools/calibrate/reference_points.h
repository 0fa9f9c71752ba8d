#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "acquire/sensor/keyence/keyence_il.h"
#include "acquire/transport/transport.h"
#include "base/clock.h"
#include "base/error.h"
#include "trial/calibration.h"

namespace haptometer::tools {

/// Mean and standard error of one quantity while the target is still.
struct MeanValue {
  double mean = 0;
  double standard_error = 0;
};

/// One place of the target: what the amplifier measures and puts out, and what the DAQ samples.
struct StillPoint {
  MeanValue displacement_m;
  MeanValue analog_v;
  MeanValue input_v;
};

/// When a point counts. A window of window_s is still where
///   - each reading of the amplifier lies within still_m of their mean,
///   - the means of its two halves differ by still_m / 4 at most, or by three standard errors,
///   - those of the DAQ's samples by 5 mV, or by five standard errors.
/// A point is the second of two still windows in a row at one place, so that the target, the
/// amplifier's averaging and the DAQ's buffer have settled; its place differs by apart_m from that
/// of the point before.
struct StillQuestion {
  std::size_t points = 7;  ///< wanted
  double window_s = 1;     ///< a window lasts longer until it has 8 readings
  double still_m = 20e-6;
  double apart_m = 0.2e-3;
  double timeout_s = 300;    ///< of the whole measurement
  trial::RawLimits rails{};  ///< of the DAQ
};

/// What a window showed.
enum class WindowState : std::uint8_t {
  kPoint,      ///< a point: it counts
  kSettling,   ///< still, for the first time at this place
  kSamePlace,  ///< still, where the point before was
  kMoving,
  kErrorLevel,  ///< the amplifier has no reading: its output is at +5.5 V, which is none
  kAtRail,      ///< of the DAQ
  kNoSamples,   ///< of the DAQ, or no answer of the amplifier
};

struct ReferencePoints {
  std::vector<StillPoint> points;
  std::size_t moving = 0;       ///< windows
  std::size_t error_level = 0;  ///< windows
  std::size_t at_rail = 0;      ///< windows
  bool input_ended = false;     ///< before there were as many points as asked for
};

/// Collects points until there are as many as asked for, `stop` is set, the time is over or the
/// samples end. `reference` is started and not begun; `input` gives lines that begin with a number,
/// volts. `tell` gets each window's state and what there is by then.
///
/// Errors: the amplifier's (KeyenceIl::ReadAnalog); Cause::kFailed: it does not answer five times
/// in a row, or the input gives no number in ten windows.
[[nodiscard]] Result<ReferencePoints> CollectPoints(
    acquire::KeyenceIl& reference, acquire::Transport& input, Clock& clock,
    const std::atomic<bool>& stop, const StillQuestion& question,
    const std::function<void(WindowState, const ReferencePoints&)>& tell);

}  // namespace haptometer::tools
