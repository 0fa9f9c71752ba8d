#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/emulator/device.h"
#include "acquire/emulator/fault.h"
#include "acquire/sensor/modbus_profile.h"

namespace haptometer::acquire::emulator {

/// How an emulated Modbus distance sensor is set up.
struct ModbusUnitSetup {
  SensorProfile profile;
  ModbusFraming framing = ModbusFraming::kRtu;
  MovingHead head{};
  double standoff_m = 0.025;        ///< distance at displacement 0
  std::uint16_t scale_number = 50;  ///< what the profile's scale register holds
  MonotonicNs turnaround_ns = 0;    ///< from the end of a request to its answer
  FaultPlan faults{};
};

/// Head of an emulated sensor of `profile`: as fast and as coarse as the profile says (1 kHz where
/// it does not), without noise where none is stated.
[[nodiscard]] trial::SensorHead HeadOf(const SensorProfile& profile);

/// A Modbus distance sensor with the registers that its profile names, and no others.
///
/// Function 03 or 04, as the profile says, reads them: the distance (standoff + displacement), the
/// status register (its mask's bits where there is no reading), the timestamp registers (the
/// reading's number), the scale register; the rest of what one request reads is 0. Other functions
/// are refused with exception 01, other addresses with 02, no or too many registers, and of an
/// exact profile a part of its block, with 03. Requests to other slaves are not answered (RTU).
///
/// RTU: bytes cross the wire one by one; a request ends with the silent interval t3.5; damaged ones
/// are not answered. TCP: no time passes on the wire; a peer that sends no Modbus header is hung up
/// on. Requests are answered in order, so a late answer delays those behind it.
///
/// Source: acquire/protocol/modbus.h. A distance that the register cannot hold is
/// given as one that the profile calls invalid.
class ModbusUnit final : public Device {
 public:
  /// `setup.profile` has nothing wrong with it (WhatIsWrong).
  explicit ModbusUnit(ModbusUnitSetup setup);

  /// Whether a reading under `fault` differs from a good one. Where a limit of the profile is the
  /// end of its type's range, no number lies beyond it.
  [[nodiscard]] bool Shows(const Fault& fault) const;

  void Receive(std::string_view bytes, MonotonicNs now) override;
  void Advance(MonotonicNs now, std::string& out) override;
  [[nodiscard]] std::optional<MonotonicNs> NextDue() const override;
  [[nodiscard]] bool TakeHangUp() override;
  /// Frames have no such byte; what a full pipe drops is dropped up to a byte that may be anywhere.
  [[nodiscard]] char line_end() const override { return '\n'; }

 private:
  struct TimedByte {
    char byte;
    MonotonicNs time_ns;
  };

  void RunTo(MonotonicNs now);
  void TakeTcp(MonotonicNs now);
  void EndFrame(MonotonicNs end_ns);
  void AnswerTo(const ModbusAdu& request, MonotonicNs end_ns);
  [[nodiscard]] std::string DataOf(const ReadRequest& request, MonotonicNs at_ns,
                                   const Fault* fault) const;
  [[nodiscard]] ModbusException RefusalOf(const ReadRequest& request) const;
  [[nodiscard]] std::vector<std::uint16_t> Window(MonotonicNs at_ns, const Fault* fault) const;
  [[nodiscard]] std::uint32_t BitsAt(std::int64_t sample, const Fault* fault) const;
  [[nodiscard]] std::uint32_t InvalidBits() const;
  void Queue(const std::string& answer, MonotonicNs ready_ns, const Fault* fault);

  ModbusUnitSetup setup_;
  SerialLine host_to_unit_;
  SerialLine unit_to_host_;
  std::deque<TimedByte> incoming_;  ///< RTU: with the times of arrival
  std::string frame_;               ///< of the request under way
  MonotonicNs last_arrival_ns_ = 0;
  std::deque<TimedByte> outgoing_;  ///< with the times at which they have crossed the wire
  MonotonicNs busy_until_ns_ = 0;
  std::int64_t answers_ = 0;
  bool hang_up_ = false;
};

}  // namespace haptometer::acquire::emulator
