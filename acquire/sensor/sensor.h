#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "acquire/findings.h"
#include "base/clock.h"
#include "base/error.h"
#include "trial/trial_format.h"

namespace haptometer::acquire {

/// One row as a sensor hands it out; times on the sensor's clock (see Sensor::Begin).
struct Reading {
  std::int64_t index = 0;    ///< trial::Timing::kUniform: place on the grid
  MonotonicNs time_ns = 0;   ///< kArrival: arrival; kPolled: request
  MonotonicNs reply_ns = 0;  ///< kPolled: reply, or when waiting for it was given up
  /// Readings that the sensor's own counter says were lost directly before this one; 0 where the
  /// index says it (kUniform), or where nothing counts.
  std::int64_t lost_before = 0;
  /// Whether readings of a number that nobody counted may be missing directly before this one: of a
  /// replay, between the shots of triggers and around reconnections.
  bool follows_gap = false;
  std::vector<trial::Sample> samples;  ///< one a channel, in the header's order
};

/// The status of a whole row: that of its first value that is no measurement, else of its first.
[[nodiscard]] inline trial::SampleStatus RowStatus(const Reading& reading) {
  const auto bad = std::ranges::find_if_not(reading.samples, [](const trial::Sample& sample) {
    return trial::IsMeasurement(sample.status);
  });
  return bad == reading.samples.end() ? reading.samples.front().status : bad->status;
}

/// How Sensor::Next ended.
enum class Outcome : std::uint8_t {
  kReading,  ///< `reading` holds the next row
  kNothing,  ///< nothing yet; look at the stop flag and call again
  kEnd,      ///< a replay is over
  kGone,     ///< the connection was lost; nothing will come again
  kAway,     ///< the connection was lost just now and is tried again (ReconnectingSensor)
  kBack,     ///< it is back; readings follow
};

/// A transport and a protocol joined: says what it is, then hands out readings. One thread only.
class Sensor {
 public:
  virtual ~Sensor() = default;

  /// Talks to the device until it is known that it answers and what it is. Returns early with an
  /// error when `stop` is set. Errors (Cause::kCannotAnswer): it does not answer, or not readably;
  /// the message says what to try.
  [[nodiscard]] virtual Result<void> Start(const std::atomic<bool>& stop) = 0;

  /// What a recording of this sensor begins with; complete after Start().
  [[nodiscard]] virtual const trial::TrialHeader& header() const = 0;

  /// What this wire can and cannot observe, and what its settings do, to be shown before the
  /// recording; asked again after it, more may be known. Complete after Start().
  [[nodiscard]] virtual Findings Found() const = 0;

  /// Begins the readings and returns the instant from which their times count; indices count from
  /// 0. May be called again, as after a tare: what was asked before stays outstanding, so that its
  /// late answer is not taken for another's.
  [[nodiscard]] virtual MonotonicNs Begin() = 0;

  /// The next reading; waits at most a tenth of a second for it.
  [[nodiscard]] virtual Outcome Next(Reading& reading) = 0;

  /// Whether the source waits for its reader, as a file and a pipe do. Then no reading need be lost
  /// to a slow disk, and its own times say when something happened, not the clock.
  [[nodiscard]] virtual bool waits() const { return false; }

  /// How long readings stay away where one request is not answered; 0 of a sensor that is not
  /// asked.
  [[nodiscard]] virtual MonotonicNs LostReplyNs() const { return 0; }

  /// Bytes that formed no reading so far: partial lines, late replies, garbage.
  [[nodiscard]] virtual std::uint64_t discarded_bytes() const = 0;
};

}  // namespace haptometer::acquire
