#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include "acquire/emulator/fault.h"
#include "acquire/protocol/wire.h"
#include "base/clock.h"
#include "trial/sensor_head.h"

namespace haptometer::acquire::emulator {

/// What an emulated device does with bytes and time, and nothing else: no file, no thread, no
/// clock.
///
/// All times are nanoseconds since the device was switched on, so sample 0 is taken at 0. The
/// caller never goes back in time. How often it calls makes no difference to the bytes: only to how
/// late they are handed over.
class Device {
 public:
  virtual ~Device() = default;

  /// The host wrote `bytes` at `now`; they still have to cross the wire.
  virtual void Receive(std::string_view bytes, MonotonicNs now) = 0;

  /// Appends to `out` the bytes that have crossed the wire to the host by `now` and were not handed
  /// over before, in order.
  virtual void Advance(MonotonicNs now, std::string& out) = 0;

  /// When Advance() next has something to do; nothing while the device waits for the host.
  [[nodiscard]] virtual std::optional<MonotonicNs> NextDue() const = 0;

  /// Whether the device has just dropped off the line (a fault); asking clears it.
  [[nodiscard]] virtual bool TakeHangUp() = 0;

  /// The last byte of a line, by which a reader finds its place again.
  [[nodiscard]] virtual char line_end() const = 0;
};

/// One direction of an asynchronous wire (8N1, or as told): says when each byte has crossed it.
///
/// Bytes that follow each other without a pause are counted from the start of their burst, so no
/// rounding adds up: byte n of a burst ends at start + bits n / baud (protocol/wire.h).
class SerialLine {
 public:
  explicit SerialLine(int baud, int bits_per_character = kBitsPerCharacter)
      : baud_(baud), bits_per_character_(bits_per_character) {}

  /// Sends one byte that is ready at `ready`, behind those sent before, and returns when its last
  /// bit has arrived. `ready` may lie before the previous byte's end, never before the previous
  /// `ready`.
  MonotonicNs Send(MonotonicNs ready);

 private:
  int baud_;
  int bits_per_character_;
  MonotonicNs burst_start_ = 0;
  MonotonicNs burst_end_ = 0;
  std::size_t burst_bytes_ = 0;
};

/// The analog output of an amplifier: 5 V at the end of the head's linear range, 1 V/mm of an
/// IL-030, and 5.5 V where there is no reading. What the amplifier says of it (data 042) is
/// gain_error times this and offset_error_v.
struct AnalogOutput {
  double gain_error = 1;
  double offset_error_v = 0;
};

/// A sensor head that looks at something moving, over the emulator's time (0: switched on).
struct MovingHead {
  trial::SensorHead head;
  trial::Displacement
      displacement;        ///< metres at seconds since the start; also asked at negative times
  std::uint64_t seed = 1;  ///< of the noise
  AnalogOutput analog{};

  /// When raw sample `number` is complete: number * sampling_s, rounded to nanoseconds.
  [[nodiscard]] MonotonicNs SampleTime(std::int64_t number) const;

  /// The last raw sample complete at `now` >= 0.
  [[nodiscard]] std::int64_t LastSample(MonotonicNs now) const;

  /// The head's reading number `number` (trial/sensor_head.h).
  [[nodiscard]] trial::HeadReading Reading(std::int64_t number) const;
};

/// A device that answers one line to one line, over a wire: everything but what the lines mean.
///
/// Time: a request crosses the wire byte by byte, is processed when its CR, or the LF behind it,
/// has arrived, and the answer crosses the wire back; then the next request is taken in. So no
/// exchange takes less than request + processing + answer, and one who sends a request before the
/// answer is complete (the makers forbid it) wins nothing: it waits in a receive buffer of 256
/// bytes, and what does not fit is lost. An empty line is not answered (no manual says how).
class AskedUnit : public Device {
 public:
  void Receive(std::string_view bytes, MonotonicNs now) final;
  void Advance(MonotonicNs now, std::string& out) final;
  [[nodiscard]] std::optional<MonotonicNs> NextDue() const final;
  [[nodiscard]] bool TakeHangUp() final;
  [[nodiscard]] char line_end() const final { return line_end_; }

 protected:
  /// `longest_line`: characters of the longest request; `line_end`: the last byte of an answer.
  AskedUnit(int baud, std::size_t longest_line, char line_end, FaultPlan faults);

  /// How long the device needs for the request `line`.
  [[nodiscard]] virtual MonotonicNs ProcessingNs(std::string_view line) const = 0;

  /// What the device answers to `line`, processed at `now`, with its end. `fault` strikes it, or is
  /// nullptr; what it does to the bytes and their times is done here.
  [[nodiscard]] virtual std::string AnswerTo(std::string_view line, MonotonicNs now,
                                             const Fault* fault) = 0;
  /// What the device answers to a line that is too long and begins with `line`.
  [[nodiscard]] virtual std::string AnswerToOverlong(std::string_view line) const = 0;

  [[nodiscard]] const FaultPlan& faults() const { return faults_; }

 private:
  enum class Phase : std::uint8_t { kListening, kProcessing, kAnswering };
  struct Incoming {
    char byte;
    MonotonicNs written;
  };

  void RunTo(MonotonicNs now);
  bool Listen(MonotonicNs now);
  bool Process(MonotonicNs now);
  bool Answer(MonotonicNs now);
  [[nodiscard]] MonotonicNs NextArrival();
  void TakeByte(char byte, MonotonicNs arrival);
  void BeginProcessing(MonotonicNs arrival);
  void PrepareAnswer();
  void Strike(const Fault& fault);

  std::size_t longest_line_;
  char line_end_;
  FaultPlan faults_;
  Phase phase_ = Phase::kListening;
  SerialLine host_to_unit_;
  SerialLine unit_to_host_;
  std::deque<Incoming> incoming_;
  std::optional<MonotonicNs> next_arrival_;  ///< of incoming_.front(), once it is on the wire
  MonotonicNs free_since_ = 0;               ///< end of the previous answer
  std::string line_;
  bool overlong_ = false;
  bool line_feed_may_follow_ = false;  ///< the last byte was the CR that ended a request
  MonotonicNs processed_at_ = 0;
  std::string answer_;
  std::string held_back_;  ///< answers that wait for the next (a fault)
  std::size_t sent_ = 0;
  std::size_t pause_before_ = 0;  ///< byte of answer_ that the pause of a fault lies before
  MonotonicNs ready_ = 0;         ///< when answer_[sent_] is handed to the wire
  MonotonicNs pause_ns_ = 0;
  MonotonicNs next_departure_ = 0;  ///< when answer_[sent_] has crossed the wire
  std::string crossed_;             ///< has crossed the wire and waits for Advance()
  std::int64_t answers_ = 0;
  bool hang_up_ = false;
};

}  // namespace haptometer::acquire::emulator
