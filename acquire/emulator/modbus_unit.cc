#include "acquire/emulator/modbus_unit.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "base/error.h"

namespace haptometer::acquire::emulator {
namespace {

using trial::SampleStatus;

// serial line specification: 256 bytes including slave and CRC
constexpr std::size_t kLongestRtuFrame = 256;
// the quiet NaN of IEEE 754 binary32
constexpr std::uint32_t kQuietNan = 0x7FC00000;
// bytes that may wait in either direction; further bytes are lost, as by a full buffer
constexpr std::size_t kMostWaiting = 65'536;

// the address, slave or identifier that the fault makes of it
ModbusAdu Misaddressed(ModbusAdu adu, const Fault* fault) {
  if (fault == nullptr) return adu;
  if (fault->damage == Damage::kWrongSlave) ++adu.unit;
  if (fault->damage == Damage::kWrongTransaction) ++adu.transaction;
  return adu;
}

}  // namespace

// a head with the profile's rate and noise; its range does not limit the emulation
trial::SensorHead HeadOf(const SensorProfile& profile) {
  constexpr double kSamplingS = 1e-3;
  trial::SensorHead head;
  head.name = profile.name;
  head.sampling_s = profile.fastest_rate_hz ? 1.0 / *profile.fastest_rate_hz : kSamplingS;
  head.noise_rms_m = profile.noise_rms_m.value_or(0);
  head.range_min_m = -std::numeric_limits<double>::max();
  head.range_max_m = std::numeric_limits<double>::max();
  return head;
}

ModbusUnit::ModbusUnit(ModbusUnitSetup setup)
    : setup_(std::move(setup)),
      host_to_unit_(setup_.profile.wire.baud, BitsPerCharacter(setup_.profile.wire)),
      unit_to_host_(setup_.profile.wire.baud, BitsPerCharacter(setup_.profile.wire)) {
  HAPTOMETER_CHECK(WhatIsWrong(setup_.profile).empty(), "{}", WhatIsWrong(setup_.profile));
}

bool ModbusUnit::Shows(const Fault& fault) const {
  const SensorProfile& profile = setup_.profile;
  // faults of the frame, and a status register, show by themselves
  if (fault.status == SampleStatus::kOk) return true;
  if (profile.status_address && fault.status == SampleStatus::kInvalid) return true;
  // otherwise by a number that means no reading
  const std::uint32_t bits = BitsAt(0, &fault);
  const double number = NumberOf(bits, profile.type);
  const bool is_listed =
      std::ranges::find(profile.invalid_bits, bits) != profile.invalid_bits.end();
  return is_listed || !std::isfinite(number) ||
         (profile.least_number && number < *profile.least_number) ||
         (profile.most_number && number > *profile.most_number);
}

void ModbusUnit::Receive(std::string_view bytes, MonotonicNs now) {
  // TCP has no wire time: a request is complete when its bytes are there
  if (setup_.framing == ModbusFraming::kTcp) {
    frame_ += bytes;
    TakeTcp(now);
    return;
  }
  // bytes that arrived earlier first, so that a silent interval between them ends a frame
  RunTo(now);
  for (const char byte : bytes) {
    if (incoming_.size() < kMostWaiting) incoming_.push_back({byte, host_to_unit_.Send(now)});
  }
}

void ModbusUnit::Advance(MonotonicNs now, std::string& out) {
  RunTo(now);
  while (!outgoing_.empty() && outgoing_.front().time_ns <= now) {
    out += outgoing_.front().byte;
    outgoing_.pop_front();
  }
}

// earliest of: a byte leaves, a byte arrives, silence ends the frame
std::optional<MonotonicNs> ModbusUnit::NextDue() const {
  std::optional<MonotonicNs> due;
  const auto consider = [&](MonotonicNs time_ns) {
    due = std::min(due.value_or(time_ns), time_ns);
  };
  if (!outgoing_.empty()) consider(outgoing_.front().time_ns);
  if (!incoming_.empty()) {
    consider(incoming_.front().time_ns);
  } else if (setup_.framing == ModbusFraming::kRtu && !frame_.empty()) {
    consider(last_arrival_ns_ + SilentIntervalNs(setup_.profile.wire));
  }
  return due;
}

bool ModbusUnit::TakeHangUp() { return std::exchange(hang_up_, false); }

// RTU: takes the bytes that have arrived; a silent interval of 3.5 characters ends a request
void ModbusUnit::RunTo(MonotonicNs now) {
  if (setup_.framing == ModbusFraming::kTcp) return;
  const MonotonicNs silent_ns = SilentIntervalNs(setup_.profile.wire);
  while (true) {
    const bool arrives = !incoming_.empty() && incoming_.front().time_ns <= now;
    const MonotonicNs next_ns = arrives ? incoming_.front().time_ns : now;
    const MonotonicNs end_ns = last_arrival_ns_ + silent_ns;
    if (!frame_.empty() && end_ns <= next_ns) {
      EndFrame(end_ns);
      continue;
    }
    if (!arrives) return;
    // one byte more than allowed is kept, so that an overlong request fails its length check
    if (frame_.size() <= kLongestRtuFrame) frame_ += incoming_.front().byte;
    last_arrival_ns_ = next_ns;
    incoming_.pop_front();
  }
}

void ModbusUnit::TakeTcp(MonotonicNs now) {
  while (true) {
    const ParsedAdu parsed = ParseAdu(ModbusFraming::kTcp, frame_);
    if (parsed.state == AduState::kNeedMore) return;
    // no frame boundary can be found behind a wrong header: the connection ends
    if (parsed.state != AduState::kWhole) {
      frame_.clear();
      hang_up_ = true;
      return;
    }
    AnswerTo(parsed.adu, now);
    frame_.erase(0, parsed.bytes);
  }
}

// a frame with a wrong CRC or for another slave has no answer, as the specification requires
void ModbusUnit::EndFrame(MonotonicNs end_ns) {
  const std::string frame = std::exchange(frame_, {});
  const ParsedAdu parsed = ParseAdu(ModbusFraming::kRtu, frame);
  if (parsed.state != AduState::kWhole) return;
  if (parsed.adu.unit == setup_.profile.wire.slave) AnswerTo(parsed.adu, end_ns);
}

void ModbusUnit::AnswerTo(const ModbusAdu& request, MonotonicNs end_ns) {
  if (outgoing_.size() >= kMostWaiting) return;
  // faults count answers from 1
  const Fault* fault = setup_.faults.At(++answers_);
  if (fault != nullptr && fault->hangs_up) {
    hang_up_ = true;
    return;
  }
  // one request after the other: the turnaround begins when the last answer is ready
  const MonotonicNs at_ns = std::max(end_ns, busy_until_ns_) + setup_.turnaround_ns;
  busy_until_ns_ = at_ns + (fault != nullptr ? fault->delay_ns : 0);

  // the reading, or a refusal
  auto refusal = ModbusException::kNone;
  ReadRequest asked;
  // order of the Modbus specification: function, quantity, address
  if (request.function != setup_.profile.function) {
    refusal = ModbusException::kIllegalFunction;
  } else if (request.data.size() != 4) {
    refusal = ModbusException::kIllegalValue;
  } else {
    asked.address = RegisterAt(request.data, 0);
    asked.count = RegisterAt(request.data, 1);
    refusal = RefusalOf(asked);
  }
  // an injected refusal: exception 04
  if (fault != nullptr && fault->refuses) refusal = ModbusException::kDeviceFailure;
  const bool is_refused = refusal != ModbusException::kNone;
  const std::string data =
      is_refused ? std::string{static_cast<char>(refusal)} : DataOf(asked, at_ns, fault);
  const auto function = static_cast<std::uint8_t>(request.function | (is_refused ? 0x80U : 0U));
  std::string answer;
  // answer in the framing of the request, with the address that the fault makes of it
  AppendAdu(setup_.framing,
            Misaddressed({.transaction = request.transaction,
                          .unit = request.unit,
                          .function = function,
                          .data = data},
                         fault),
            answer);
  Queue(answer, busy_until_ns_, fault);
}

ModbusException ModbusUnit::RefusalOf(const ReadRequest& request) const {
  const SensorProfile& profile = setup_.profile;
  // 1 to 125 registers
  if (request.count < 1 || request.count > kMostModbusRegisters) {
    return ModbusException::kIllegalValue;
  }
  // registers of the reading and the scale register exist, no others
  for (int i = 0; i < request.count; ++i) {
    const int address = request.address + i + profile.address_base;
    const bool is_read = address >= profile.address && address < profile.address + profile.count;
    if (!is_read && address != profile.scale_address) return ModbusException::kIllegalAddress;
  }
  // an exact sensor accepts the two requests of its profile only
  const auto asks = [&](const ReadRequest& known) {
    return request.address == known.address && request.count == known.count;
  };
  const bool is_whole = asks(ReadingRequest(profile)) || asks(CheckRequest(profile));
  return profile.is_exact && !is_whole ? ModbusException::kIllegalValue : ModbusException::kNone;
}

std::string ModbusUnit::DataOf(const ReadRequest& request, MonotonicNs at_ns,
                               const Fault* fault) const {
  const SensorProfile& profile = setup_.profile;
  const std::vector<std::uint16_t> window = Window(at_ns, fault);
  // byte count, then registers, high byte first
  std::string data(1, static_cast<char>(2 * request.count));
  for (int i = 0; i < request.count; ++i) {
    const int address = request.address + i + profile.address_base;
    const std::uint16_t word = address == profile.scale_address
                                   ? setup_.scale_number
                                   : window[static_cast<std::size_t>(address - profile.address)];
    data += static_cast<char>(word >> 8U);
    data += static_cast<char>(word & 0xFFU);
  }
  return data;
}

// what one request reads, at the head's last sample
std::vector<std::uint16_t> ModbusUnit::Window(MonotonicNs at_ns, const Fault* fault) const {
  const SensorProfile& profile = setup_.profile;
  const auto offset = [&](int address) {
    return static_cast<std::size_t>(address - profile.address);
  };
  std::vector<std::uint16_t> window(static_cast<std::size_t>(profile.count));
  const std::int64_t sample = setup_.head.LastSample(at_ns);
  const auto value =
      std::span(window).subspan(offset(profile.value_address), RegistersOf(profile.type));
  BitsTo(BitsAt(sample, fault), profile.type, profile.order, value);
  // words in the wrong order; of a single register its bytes
  if (fault != nullptr && fault->damage == Damage::kSwappedWords) {
    if (value.size() == 2)
      std::swap(value[0], value[1]);
    else
      value[0] = std::rotl(value[0], 8);
  }
  const bool is_invalid = fault != nullptr && fault->status == SampleStatus::kInvalid;
  if (profile.status_address && is_invalid) {
    window[offset(*profile.status_address)] = profile.status_mask;
  }
  // the reading's number, its lowest part in the last register
  auto number = static_cast<std::uint64_t>(sample);
  for (int i = profile.timestamp_address ? profile.timestamp_count : 0; i > 0; --i) {
    window[offset(*profile.timestamp_address + i - 1)] = static_cast<std::uint16_t>(number);
    number >>= 16U;
  }
  return window;
}

std::uint32_t ModbusUnit::BitsAt(std::int64_t sample, const Fault* fault) const {
  const SensorProfile& profile = setup_.profile;
  const SampleStatus forced = fault != nullptr ? fault->status : SampleStatus::kOk;
  if (forced == SampleStatus::kOver && profile.most_number) {
    // beyond a limit of the profile
    return BitsOf(*profile.most_number + 1, profile.type).value_or(InvalidBits());
  }
  if (forced == SampleStatus::kUnder && profile.least_number) {
    return BitsOf(*profile.least_number - 1, profile.type).value_or(InvalidBits());
  }
  if (forced != SampleStatus::kOk) return InvalidBits();
  // number = (distance / unit_m - offset) / scale
  const double distance_m = setup_.standoff_m + setup_.head.Reading(sample).value_m;
  const double scale = profile.scale * (profile.scale_address ? setup_.scale_number : 1);
  const double number = (distance_m / profile.unit_m - profile.offset) / scale;
  return BitsOf(number, profile.type).value_or(InvalidBits());
}

// a number that the profile calls invalid, else NaN or all bits set
std::uint32_t ModbusUnit::InvalidBits() const {
  const SensorProfile& profile = setup_.profile;
  if (!profile.invalid_bits.empty()) return profile.invalid_bits.front();
  if (profile.type == RegisterType::kF32) return kQuietNan;
  return RegistersOf(profile.type) == 1 ? 0xFFFF : 0xFFFFFFFF;
}

void ModbusUnit::Queue(const std::string& answer, MonotonicNs ready_ns, const Fault* fault) {
  std::string bytes = answer;
  if (fault != nullptr) {
    bytes = Damaged(std::move(bytes), fault->damage, answers_);
    // here the frame is complete, so that no later step corrects its CRC
    if (fault->damage == Damage::kWrongCrc && setup_.framing == ModbusFraming::kRtu) {
      bytes.back() = static_cast<char>(static_cast<unsigned char>(bytes.back()) ^ 0x55U);
    }
  }
  const MonotonicNs pause_ns = fault != nullptr ? fault->pause_ns : 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    // a pause of the fault begins in the middle of the answer
    const MonotonicNs from_ns = ready_ns + (2 * i >= bytes.size() ? pause_ns : 0);
    // RTU bytes leave one after the other at the baud rate, TCP bytes at once
    const bool is_rtu = setup_.framing == ModbusFraming::kRtu;
    outgoing_.push_back({bytes[i], is_rtu ? unit_to_host_.Send(from_ns) : from_ns});
  }
  busy_until_ns_ = std::max(busy_until_ns_, ready_ns + pause_ns);
}

}  // namespace haptometer::acquire::emulator
