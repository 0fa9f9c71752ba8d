#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquire/protocol/modbus.h"
#include "acquire/sensor/modbus_profile.h"
#include "acquire/sensor/polled_line.h"
#include "acquire/sensor/sensor.h"
#include "acquire/transport/modbus_port.h"

namespace haptometer::acquire {

/// What went wrong on the wire so far, by kind.
struct ModbusErrors {
  std::array<std::uint64_t, kModbusFaultCount> faults{};  ///< by ModbusFault
  std::array<std::uint64_t, 256> exceptions{};            ///< by exception code
};

/// "2 timeout, 1 wrong CRC, 3 exception 02 (illegal data address)"; "" where nothing went wrong.
[[nodiscard]] std::string InWords(const ModbusErrors& errors);

/// How a Modbus sensor is polled.
struct ModbusSetup {
  SensorProfile profile;
  std::optional<double> rate_hz{};  ///< polls a second at most; empty: as fast as it answers
};

/// A distance sensor that is polled for registers over Modbus RTU or TCP, as its profile says.
///
/// One request at a time; each is a row with the instants of request and reply, also where no
/// reading came of it: kLate without an answer, kBadFrame for bytes that are no reply,
/// kDeviceError for an exception, kInvalid, kUnder and kOver by the profile. A reading whose
/// timestamp registers did not change is kRepeated; without such registers, one that may be the
/// same by the sensor's own rate (acquire/sensor/polled_line.h).
///
/// Late replies. Over TCP each carries its request's transaction identifier: one with another is
/// thrown away and waiting goes on; after 8 rows in a row without a sound reply the connection
/// counts as lost, since a peer that is off by one never comes back into step. RTU has no
/// identifier: a late reply to the same question passes every check of the next one. So the port is
/// flushed before each request; after a missed deadline nothing is asked until the late reply has
/// come (and was thrown away) or `longest_reply_ns` has passed, after damage until the wire was
/// silent for 20 ms. Then two kinds of question with replies of different length alternate, as in
/// the alternating bit protocol: the reading is asked for until some reply of its length has come
/// (thrown away: whose it is cannot be known), then a check (CheckRequest) until one of the other
/// length has come. A device that answers in order has then sent everything that is older, however
/// late it was, and the next reply of a reading's length is that of the next reading.
///
/// A device may also answer twice. A reply that comes sooner than one can
/// (ResponseDeadline) is held back until a usual exchange has passed: a further one that
/// comes until then is the right one. So no row is given sooner than the wire allows.
///
/// What remains: a device that answers out of order; and one of which Start() found that it does
/// not answer the check with registers. There only `longest_reply_ns` of waiting stands between a
/// late reply and the next request, and Found() has it.
class ModbusSensor final : public Sensor {
 public:
  /// `clock` must outlive the sensor and be the one of the link's deadlines.
  ModbusSensor(std::unique_ptr<ModbusLink> link, ModbusSetup setup, Clock& clock);

  /// Reads the scale register where the profile has one, then one reading, three tries each; then
  /// learns how the device answers a check, in one try.
  [[nodiscard]] Result<void> Start(const std::atomic<bool>& stop) override;
  [[nodiscard]] const trial::TrialHeader& header() const override { return header_; }
  /// Also tells the errors so far, so that it may be asked again after a recording.
  [[nodiscard]] Findings Found() const override;
  /// What is outstanding from before stays so: it is drained, as after a missed deadline.
  [[nodiscard]] MonotonicNs Begin() override;
  /// Allocates nothing once `reading` holds a row.
  [[nodiscard]] Outcome Next(Reading& reading) override;
  [[nodiscard]] MonotonicNs LostReplyNs() const override {
    return std::max(profile_.response_timeout_ns, profile_.longest_reply_ns);
  }
  [[nodiscard]] std::uint64_t discarded_bytes() const override { return discarded_bytes_; }

  [[nodiscard]] const ModbusErrors& errors() const { return errors_; }

 private:
  enum class Phase : std::uint8_t {
    kFree,      ///< nothing is outstanding
    kWaiting,   ///< a reading is
    kSettling,  ///< a late or damaged reply may still come, and then readings
    kDraining,  ///< the same, and then a step
    kStepping,  ///< a reading whose reply is thrown away, or a check, is outstanding
  };

  /// How long one call waits at most: with the link's 20 ms a tenth of a second.
  static constexpr MonotonicNs kSliceNs = 80'000'000;

  Result<std::string> Ask(ReadRequest request, const std::atomic<bool>& stop);
  Result<ReadReply> Exchange(ReadRequest request, int tries, const std::atomic<bool>& stop);
  Result<void> LearnCheck(const std::atomic<bool>& stop);
  void MakeHeader(double register_scale);
  void Describe(trial::Metadata& metadata) const;

  bool Send(ReadRequest request, Phase next);
  ModbusReply Receive(MonotonicNs deadline);
  ReadReply Parse(const ModbusReply& reply);
  Outcome AskForReading();
  Outcome Wait(Reading& reading);
  Outcome TakeReply(const ReadReply& reply, Reading& reading);
  Outcome Drain(Reading& reading);
  Outcome WaitForStep(Reading& reading);
  Outcome Accept(trial::Sample sample, std::string_view registers, MonotonicNs reply_ns,
                 Reading& reading);
  void MarkRepeated(std::string_view registers, Reading& reading);
  Outcome GiveRow(Reading& reading, trial::Sample sample, Phase next, MonotonicNs drain_until_ns);
  Outcome GiveFault(Reading& reading, ModbusFault fault);

  [[nodiscard]] bool is_rtu() const { return link_->framing() == ModbusFraming::kRtu; }

  SensorProfile profile_;
  std::optional<double> rate_hz_;
  std::unique_ptr<ModbusLink> link_;
  Clock& clock_;
  trial::TrialHeader header_;
  ModbusErrors errors_;
  std::optional<RepeatMarker> repeats_;
  std::string timestamp_;  ///< registers as last sent
  Phase phase_ = Phase::kFree;
  ReadRequest request_;  ///< the last one sent
  std::string frame_;    ///< its bytes
  std::uint16_t next_transaction_ = 1;
  MonotonicNs request_ns_ = 0;
  MonotonicNs free_from_ns_ = 0;     ///< the wire's silent interval is over
  MonotonicNs next_poll_ns_ = 0;     ///< by rate_hz
  MonotonicNs settle_since_ns_ = 0;  ///< how long nothing could be asked for
  MonotonicNs drain_until_ns_ = 0;
  bool other_transaction_ = false;   ///< a reply to another request came while waiting
  int bad_rows_ = 0;                 ///< in a row
  bool has_checks_ = false;          ///< the device answers checks with registers
  bool next_step_is_check_ = false;  ///< else a reading's reply is still owed
  bool start_was_silent_ = false;    ///< a reply to Start() may still come
  ResponseDeadline exchanges_;       ///< RTU: when a reply can be the one to its request
  trial::Sample held_sample_;        ///< of a reply that came too soon
  std::string held_registers_;
  MonotonicNs held_ns_ = 0;
  bool is_held_ = false;  ///< it waits for a further one
  ReplyCounts replies_;
  std::uint64_t echoes_ = 0;  ///< requests that came back
  std::uint64_t discarded_bytes_ = 0;
};

}  // namespace haptometer::acquire
