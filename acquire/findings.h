#pragma once

#include <cstdint>

#include "base/finding.h"

namespace haptometer::acquire {

/// What a sensor, its wire and its settings can and cannot observe, and what was seen while it was
/// read. The numbers of each kind stand behind it; the subject is an amplifier or a file where
/// there are several.
enum class FindingKind : std::uint8_t {
  // --- what a wire carries
  kUnitRate,            ///< device, baud (of a serial line), rate_hz, new_rate_hz (where lower),
                        ///< observable_hz
  kUnitTooSlow,         ///< device, rate_hz (highest), needed_hz: not for 20-500 Hz
  kLkgRate,             ///< baud, rate_hz, observable_hz
  kLinesRate,           ///< baud, characters, rate_hz, observable_hz
  kLinesTooSlow,        ///< needed_hz: not for 20-500 Hz at this baud rate
  kLinesNumbered,       ///< last: losses are counted up to as many lines in a row
  kStatedRate,          ///< rate_hz, observable_hz, half_rate_hz
  kRegistersRate,       ///< profile, baud, registers, wire_s, rate_hz, new_rate_hz (where lower),
                        ///< observable_hz
  kRegistersTooSlow,    ///< rate_hz (highest), needed_hz
  kProfileRate,         ///< profile, rate_hz, observable_hz
  kProfileRateUnknown,  ///< profile
  kLatencyTimer,        ///< port, latency_s, rate_hz, rate_at_1_ms_hz

  // --- settings of the device
  kSettingChanged,    ///< setting, before, after
  kNotSettled,        ///< no value since the settings were changed
  kAveragingCorner,   ///< averages, sampling_s, corner_hz: -3 dB
  kDifferenceFilter,  ///< is on
  kHighPassFilter,    ///< corner_hz: is on
  kHold,              ///< hold
  kAmplifierError,    ///< flags
  kSettingsNotRead,   ///< sampling, averaging and filters
  kOtherSettings,     ///< of a device that came back: averaging, sampling period or head
  kTcpProfile,        ///< profile: on a serial port
  kNoCheckRequest,    ///< profile, longest_reply_s
  kIdealSensor,       ///< rate_hz: the scene has no sensor

  // --- what was seen
  kHeadingLines,    ///< lines, first
  kLinesTooSoon,    ///< lines, elapsed_s, baud, wire_s
  kRowRateDiffers,  ///< rate_hz (of arrival), elapsed_s, stated_hz
  kSurplusReplies,  ///< replies
  kRepliesTooSoon,  ///< too_soon, replies, wire_s, rate_hz
  kWireErrors,      ///< errors
  kReplayCutShort,  ///< the trial that is replayed
  kReplayLosses,    ///< losses, rows_lost (where known)
  kFellSilent,      ///< last_reading_s, length_s: of what was to be recorded, or was
  kOtherForm,       ///< replies, example: whole, but with other decimals or amplifiers
  kEcho,            ///< echoes: requests that came back on the wire

  // --- whether a sensor can answer a question (acquire/capability.h)
  kCanAnswer,   ///< rate_hz, limit, observable_hz, noise_m, smallest_m, record_s (where known)
  kRateTooLow,  ///< rate_hz, limit, observable_hz, asked_hz, needed_hz
  kAveragingTooLong,  ///< averages, sampling_s, gain, asked_hz
  kStepsTooLarge,     ///< step_m, wanted_m

  // --- whether a route can answer to an accuracy, half of a 95 % interval as a part of the RMS
  kRouteAnswers,     ///< record_s, half_interval
  kNoiseNotStated,   ///< of a reading: no length can be promised
  kReadingsTooOld,   ///< uncertainty_s, upper_hz, limit_s: of a reading's time
  kFloorTooHigh,     ///< half_interval, accuracy, limit: at any length
  kImagesFold,       ///< daq_rate_hz, image_hz, folded_hz, relative, better_hz
  kUnseenByAnalyze,  ///< relative: of the RMS, by a value's age
  kPromiseRests,     ///< coverage: what is supposed
};

using Finding = FindingOf<FindingKind>;
using Findings = haptometer::Findings<FindingKind>;

}  // namespace haptometer::acquire
