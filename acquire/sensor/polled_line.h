#pragma once

#include <array>
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
#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "base/error.h"

namespace haptometer::acquire {

/// Marks readings that may be the same buffer content of the unit handed out once more.
///
/// The unit refreshes its buffer every `refresh_ns` and M0 reads the buffer, so a faster poll gets
/// a content twice. Equal numbers do not prove that: a target at rest gives them too. What can be
/// known: a content that was first seen at t is replaced by t + refresh at the latest. So
///   - a reading that differs in any value is new;
///   - an equal one that was polled at t + refresh or later is new, and starts its own t;
///   - an equal one before that cannot be told from a repetition and is marked kRepeated.
/// Times are those of the requests: the unit samples its buffer at a fixed delay behind them, and
/// they do not suffer from the delays of USB on the way back.
class RepeatMarker {
 public:
  explicit RepeatMarker(MonotonicNs refresh_ns) : refresh_ns_(refresh_ns) {}

  /// Turns kOk into kRepeated in `reading` where the rule says so.
  void Mark(Reading& reading);

 private:
  MonotonicNs refresh_ns_;
  MonotonicNs first_seen_ns_ = 0;
  std::vector<trial::Sample> content_;  ///< as sent, before marking; empty before the first
};

/// When a reply can be the one to the request: not sooner than the wire carries both and than 0.9
/// times the fastest of the last 64 exchanges, and not later than a deadline: the maker's second at
/// first, then four times the slowest of them, from 50 ms to 1 s, so that one lost reply does not
/// cost a whole second's row.
///
/// What comes sooner is likely the second reply to a request before: a device that answers twice,
/// or that is one reply behind. Then the right one follows within a usual exchange.
class ResponseDeadline {
 public:
  /// `wire_ns`: what request and reply need on the wire; 0 where no wire is known.
  explicit ResponseDeadline(MonotonicNs wire_ns = 0) : wire_ns_(wire_ns) {}

  /// The unit answers within 1 s or not at all (DL-RS1A, IG Edition; the FD-MH Edition says 500
  /// ms).
  static constexpr MonotonicNs kLongestNs = kNsPerS;
  static constexpr MonotonicNs kShortestNs = 50'000'000;

  /// Notes an exchange that succeeded.
  void Note(MonotonicNs exchange_ns);

  /// How long to wait for the next reply, in ns.
  [[nodiscard]] MonotonicNs WaitNs() const;
  /// A reply that comes sooner after its request is doubtful, in ns.
  [[nodiscard]] MonotonicNs EarliestNs() const;
  /// How long to look for a further reply behind a doubtful one: 1.5 times the median exchange, at
  /// least EarliestNs(), in ns from the request.
  [[nodiscard]] MonotonicNs UsualNs() const;
  [[nodiscard]] MonotonicNs wire_ns() const { return wire_ns_; }

 private:
  MonotonicNs wire_ns_;
  std::array<MonotonicNs, 64> exchanges_ns_{};  ///< the last ones, in a ring
  std::size_t noted_ = 0;
};

/// Replies of a device that is asked one thing at a time.
struct ReplyCounts {
  std::uint64_t taken = 0;     ///< that became rows
  std::uint64_t surplus = 0;   ///< to requests that had been answered already: discarded
  std::uint64_t too_soon = 0;  ///< of those taken, that no wire carries as fast
};

/// What they show of the device and of its wire, on which request and reply need `wire_ns`; nothing
/// where all is well.
[[nodiscard]] Findings DoubtfulReplies(const ReplyCounts& replies, MonotonicNs wire_ns);

/// What a line is that came while a reading was asked for.
enum class LineMeaning : std::uint8_t {
  kReading,    ///< the answer; its values are in the samples
  kRefusal,    ///< the device says that it cannot give one
  kOther,      ///< whole and sound, but nobody asked for it now: thrown away
  kOtherForm,  ///< the answer, but not of this recording's amplifiers and decimals
  kDamaged,    ///< no line of this device, or not of this recording
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

/// What to do where requests come back on the wire and no reply follows.
inline constexpr std::string_view kEchoRemedy =
    "check the wiring: an RS-485 adapter must not receive what it sends, and transmit and receive "
    "lines must not be joined (loopback)";

/// How a recording is polled.
struct PollPlan {
  std::size_t channels = 1;
  MonotonicNs refresh_ns = 0;       ///< of the device's buffer (RepeatMarker above); 0: none
  std::optional<double> rate_hz{};  ///< polls lie on the grid k / rate_hz; empty: without a pause
  MonotonicNs wire_ns = 0;          ///< that request and reply need on the wire; 0: not known
};

/// A device that answers one line to one line, polled for a recording: each poll is one row.
///
/// One command at a time. What was polled and not answered becomes a row too: kLate without an
/// answer, kBadFrame for bytes that are no reply, kDeviceError for a refusal. Repetitions are
/// marked (RepeatMarker above).
///
/// A reply carries no mark of its request: one late reply taken for the next would put every later
/// reading one poll behind. So after a missed deadline nothing is asked until the late reply has
/// come (and was thrown away) or the maker's second has passed; after damaged bytes, until the wire
/// was silent for 20 ms (a line that never falls silent gives a kBadFrame row a second). Then the
/// dialect's step is asked: the device answers in order, so when the step's answer is there, every
/// older one is behind us.
///
/// A device may also answer twice. What came before a request is sent is no reply to it; and a
/// reply that comes sooner than one can (ResponseDeadline) is held back until a usual
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

  /// What replies that came twice, too soon or in another form, and requests that came back, show
  /// of the device and its wire.
  [[nodiscard]] Findings Found() const;
  /// Requests that came back on the wire: these lines are no replies, and are passed over.
  [[nodiscard]] std::uint64_t echoes() const { return echoes_; }

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
  bool CountEcho(std::string_view line, std::string_view request);
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
  std::uint64_t echoes_ = 0;
  std::uint64_t other_forms_ = 0;
  std::string other_form_;         ///< the first of them
  int unanswered_steps_ = 0;       ///< in a row
  bool start_was_silent_ = false;  ///< a reply to Exchange() may still come
};

}  // namespace haptometer::acquire
