#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/sensor/line_link.h"
#include "acquire/sensor/repeat_marker.h"
#include "acquire/sensor/response_deadline.h"
#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "base/error.h"

namespace haptometer::acquire {

/// What a line is that came while a reading was asked for.
enum class LineMeaning : std::uint8_t {
  kReading,  ///< the answer; its values are in the samples
  kRefusal,  ///< the device says that it cannot give one
  kOther,    ///< whole and sound, but nobody asked for it now: thrown away
  kDamaged,  ///< no line of this device, or not of this recording
};

/// How one maker's protocol is polled: what to ask, and what a line means. Nothing here allocates.
class LineDialect {
 public:
  virtual ~LineDialect() = default;

  /// What is asked for a reading, with its end.
  [[nodiscard]] virtual std::string_view PollRequest() const = 0;
  /// What is asked to be sure that nothing old is outstanding: its answer is never taken for a
  /// reading, and the device answers in order.
  [[nodiscard]] virtual std::string_view StepRequest() const = 0;
  /// Whether `line` answers StepRequest(), be it by a refusal.
  [[nodiscard]] virtual bool AnswersStep(std::string_view line) const = 0;
  /// Reads a line that came while PollRequest() was outstanding. Fills `samples`, one a channel,
  /// where it is a reading; else their content is of no meaning.
  [[nodiscard]] virtual LineMeaning Read(std::string_view line,
                                         std::span<trial::Sample> samples) const = 0;
};

/// How a recording is polled.
struct PollPlan {
  std::size_t channels = 1;
  MonotonicNs refresh_ns = 0;       ///< of the device's buffer (sensor/repeat_marker.h); 0: none
  std::optional<double> rate_hz{};  ///< polls lie on the grid k / rate_hz; empty: without a pause
  MonotonicNs wire_ns = 0;          ///< that request and reply need on the wire; 0: not known
};

/// A device that answers one line to one line, polled for a recording: each poll is one row.
///
/// One command at a time. What was polled and not answered becomes a row too: kLate without an
/// answer, kBadFrame for bytes that are no reply, kDeviceError for a refusal. Repetitions are
/// marked (sensor/repeat_marker.h).
///
/// A reply carries no mark of its request: one late reply taken for the next would put every later
/// reading one poll behind. So after a missed deadline nothing is asked until the late reply has
/// come (and was thrown away) or the maker's second has passed; after damaged bytes, until the wire
/// was silent for 20 ms (a line that never falls silent gives a kBadFrame row a second). Then the
/// dialect's step is asked: the device answers in order, so when the step's answer is there, every
/// older one is behind us.
///
/// A device may also answer twice. What came before a request is sent is no reply to it; and a
/// reply that comes sooner than one can (sensor/response_deadline.h) is held back until a usual
/// exchange has passed: a further one that comes until then is the right one. So no row is given
/// sooner than the wire allows, and a device that has fallen one reply behind is in step again.
///
/// Cost: Next() does not allocate once the buffers have grown to the longest reply.
class PolledLine {
 public:
  /// `clock` must outlive the object.
  PolledLine(std::unique_ptr<Transport> transport, Clock& clock, Delimiter delimiter,
             std::size_t longest_line);

  // --- before the recording ---

  /// Asks one question and hands each line to `take` until it says that this was the answer.
  /// Returns whether it came within the maker's second. Errors (Cause::kFailed): the connection was
  /// lost, `stop` was set.
  [[nodiscard]] Result<bool> Exchange(std::string_view request,
                                      const std::function<bool(std::string_view line)>& take,
                                      const std::atomic<bool>& stop);

  // --- the recording ---

  /// Begins to poll, for the first time or anew: a reply that is still outstanding is not taken for
  /// the first reading. `dialect` must outlive it. Returns the instant from which times count.
  [[nodiscard]] MonotonicNs Begin(const LineDialect& dialect, PollPlan plan);
  /// As Sensor::Next().
  [[nodiscard]] Outcome Next(Reading& reading);

  /// What replies that came twice or too soon say of the device and its wire, in sentences.
  [[nodiscard]] std::vector<std::string> Remarks() const;

  [[nodiscard]] const LineLink& link() const { return link_; }
  [[nodiscard]] const std::string& name() const { return link_.transport().name(); }

 private:
  enum class Phase : std::uint8_t {
    kFree,      ///< nothing is outstanding
    kWaiting,   ///< a request is
    kDraining,  ///< a late reply may still come
    kQuieting,  ///< damaged bytes may still come
    kStepping,  ///< the step is outstanding; behind its answer nothing old can come
  };

  Outcome WaitForSlot();
  Outcome Ask(std::string_view request, Phase next);
  Outcome Wait(Reading& reading);
  Outcome Settle(Reading& reading);
  Outcome WaitForStep(Reading& reading);
  bool TakeLine(std::string_view line, Reading& reading);
  Outcome Accept(Reading& reading);
  void DropAnswered();
  Outcome GiveRow(Reading& reading, trial::SampleStatus status, MonotonicNs reply_ns, Phase next);

  Clock& clock_;
  LineLink link_;
  const LineDialect* dialect_ = nullptr;
  PollPlan plan_;
  ResponseDeadline deadline_;
  RepeatMarker repeats_{0};
  Phase phase_ = Phase::kFree;
  MonotonicNs begin_ns_ = 0;
  std::int64_t slot_ = 0;      ///< of the grid, where there is one
  bool slot_is_used_ = false;  ///< it was polled at
  MonotonicNs request_ns_ = 0;
  MonotonicNs quiet_since_ns_ = 0;
  MonotonicNs settle_since_ns_ = 0;  ///< how long nothing could be asked
  Reading held_;                     ///< a reply that came too soon
  std::size_t held_bytes_ = 0;       ///< of its line
  bool is_held_ = false;             ///< it waits for a further one
  ReplyCounts replies_;
  int unanswered_steps_ = 0;       ///< in a row
  bool start_was_silent_ = false;  ///< a reply to Exchange() may still come
};

}  // namespace haptometer::acquire
