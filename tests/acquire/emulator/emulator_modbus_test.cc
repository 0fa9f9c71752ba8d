// The emulated Modbus sensor by its bytes: what it answers to each request, and when.
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "acquire/emulator/modbus_unit.h"
#include "tests/acquire/emulator_run.h"
#include "tests/acquire/il_series_emulated.h"
#include "tests/residual.h"

namespace haptometer::acquire::emulator {
namespace {

constexpr MonotonicNs kMs = 1'000'000;
constexpr auto kRtu = ModbusFraming::kRtu;
constexpr auto kTcp = ModbusFraming::kTcp;

// a head at `position_m` that takes a sample every `sampling_s` and has no end
MovingHead HeadAt(double position_m, double sampling_s = 1e-3) {
  MovingHead head = StillHead(position_m);
  head.head.resolution_m = 0;
  head.head.sampling_s = sampling_s;
  head.head.range_min_m = -1e3;
  head.head.range_max_m = 1e3;
  return head;
}

// one register of whole millimetres at 9600 baud 8E1, 25 mm away
ModbusUnitSetup Plain(ModbusFraming framing = kTcp) {
  return {.profile = {.name = "plain"}, .framing = framing, .head = HeadAt(0)};
}

// registers 11 to 17 in the maker's count from 1: two others, a value, a timestamp of three
ModbusUnitSetup Full(MovingHead head) {
  SensorProfile profile{.name = "full"};
  profile.function = 4;
  profile.address_base = 1;
  profile.address = 11;
  profile.count = 7;
  profile.value_address = 13;
  profile.type = RegisterType::kU32;
  profile.unit_m = 1e-6;
  profile.status_address = 12;
  profile.status_mask = 0x0104;
  profile.timestamp_address = 15;
  profile.timestamp_count = 3;
  profile.scale_address = 20;
  return {.profile = profile, .framing = kTcp, .head = std::move(head), .scale_number = 1};
}

std::string Frame(ModbusFraming framing, const ReadRequest& request) {
  std::string frame;
  AppendReadRequest(framing, request, frame);
  return frame;
}

struct Answered {
  int exception = 0;
  std::vector<int> registers;
  bool is_there = false;
};

// what `bytes` answer to a request
Answered AnswerIn(ModbusFraming framing, const std::string& bytes) {
  const ParsedAdu parsed = ParseAdu(framing, bytes);
  if (parsed.state != AduState::kWhole) return {};
  Answered answered;
  answered.is_there = true;
  const std::string_view data = parsed.adu.data;
  if ((parsed.adu.function & 0x80U) != 0) {
    answered.exception = data.at(0);
    return answered;
  }
  EXPECT_EQ(static_cast<std::size_t>(data.at(0)), data.size() - 1);
  for (std::size_t i = 0; i < (data.size() - 1) / 2; ++i) {
    answered.registers.push_back(RegisterAt(data.substr(1), i));
  }
  return answered;
}

// what the unit answers to `frame`, written at `at_ns`, within two seconds
Answered Ask(const ModbusUnitSetup& setup, const std::string& frame, MonotonicNs at_ns = 0) {
  ManualClock clock;
  ModbusUnit unit(setup);
  clock.Advance(at_ns);
  unit.Receive(frame, at_ns);
  return AnswerIn(setup.framing, TextOf(RunUntil(unit, clock, at_ns + 2 * kNsPerS)));
}

Answered Ask(const ModbusUnitSetup& setup, const ReadRequest& request, MonotonicNs at_ns = 0) {
  return Ask(setup, Frame(setup.framing, request), at_ns);
}

// what it answers to the request of its own profile
Answered AskForReading(const ModbusUnitSetup& setup, MonotonicNs at_ns = 0) {
  return Ask(setup, ReadingRequest(setup.profile), at_ns);
}

ModbusUnitSetup Faulty(ModbusUnitSetup setup, std::string_view plan) {
  setup.faults = *ParseFaultPlan(plan);
  return setup;
}

using Registers = std::vector<int>;

// --- values ----------------------------------------------------------------------------------

TEST(ModbusUnit, GivesStandoffAndDisplacement) {
  ModbusUnitSetup setup = Plain();
  EXPECT_EQ(AskForReading(setup).registers, Registers{25});
  setup.head = HeadAt(7e-3);
  EXPECT_EQ(AskForReading(setup).registers, Registers{32});
  setup.head = HeadAt(-7e-3);
  setup.standoff_m = 0.1;
  EXPECT_EQ(AskForReading(setup).registers, Registers{93});
}

TEST(ModbusUnit, UndoesUnitOffsetAndScale) {
  // 32 mm are 3.2 cm: (3.2 + 5) / 0.02 = 410
  ModbusUnitSetup setup = Plain();
  setup.head = HeadAt(7e-3);
  setup.profile.unit_m = 1e-2;
  setup.profile.offset = -5;
  setup.profile.scale = 0.02;
  EXPECT_EQ(AskForReading(setup).registers, Registers{410});
}

TEST(ModbusUnit, AScaleRegisterDividesTheNumber) {
  // RIFTEK RF602 of 50 mm: 16384 at 50 mm, so 8192 at 25 mm
  SensorProfile riftek = BuiltInProfiles()[1];
  ASSERT_EQ(riftek.name, "riftek-rf602");
  ModbusUnitSetup setup{.profile = riftek, .framing = kTcp, .head = HeadAt(0)};
  EXPECT_EQ(AskForReading(setup).registers, Registers{8192});
  ReadRequest scale = ReadingRequest(riftek);
  scale.address = 5;
  EXPECT_EQ(Ask(setup, scale).registers, Registers{50});
  setup.scale_number = 100;
  EXPECT_EQ(AskForReading(setup).registers, Registers{4096});
  EXPECT_EQ(Ask(setup, scale).registers, Registers{100});
}

TEST(ModbusUnit, WhatTheRegisterDoesNotHoldIsInvalid) {
  ModbusUnitSetup setup = Plain();
  setup.standoff_m = 65.535;
  EXPECT_EQ(AskForReading(setup).registers, Registers{65'535});
  setup.standoff_m = 65.536;
  setup.profile.invalid_bits = {17};
  EXPECT_EQ(AskForReading(setup).registers, Registers{17});
  setup.profile.invalid_bits.clear();
  EXPECT_EQ(AskForReading(setup).registers, Registers{0xFFFF});
}

TEST(ModbusUnit, HasValueStatusAndTimestampAtTheirAddresses) {
  // 25 mm + 53.927 mm = 78927 um = 0x0001344F; sample 70 000 = 0x00011170, its lowest part last
  const ModbusUnitSetup setup = Full(HeadAt(53.927e-3, 1e-6));
  EXPECT_EQ(AskForReading(setup, 70 * kMs).registers,
            (Registers{0, 0, 0x0001, 0x344F, 0, 0x0001, 0x1170}));
  // sample 2^33 + 5
  const MonotonicNs late_ns = ((std::int64_t{1} << 33) + 5) * 1000;
  EXPECT_EQ(AskForReading(setup, late_ns).registers,
            (Registers{0, 0, 0x0001, 0x344F, 0x0002, 0x0000, 0x0005}));
}

TEST(ModbusUnit, ASensorThatStatesNoRateHasAThousandSamplesASecond) {
  SensorProfile profile{.name = "any"};
  EXPECT_EQ(HeadOf(profile).sampling_s, 1e-3);
  EXPECT_EQ(HeadOf(profile).noise_rms_m, 0);
  EXPECT_EQ(HeadOf(profile).resolution_m, 0);
  profile.fastest_rate_hz = 200;
  profile.noise_rms_m = 3e-6;
  EXPECT_EQ(HeadOf(profile).sampling_s, 5e-3);
  EXPECT_EQ(HeadOf(profile).noise_rms_m, 3e-6);
}

// --- refusals --------------------------------------------------------------------------------

TEST(ModbusUnit, RefusesOtherFunctionsCountsAndAddresses) {
  // Modbus Application Protocol V1.1b3: 01 function, 02 address, 03 value
  const ModbusUnitSetup setup = Full(HeadAt(0));
  const auto exception = [&](int function, int address, int count) {
    ReadRequest request = ReadingRequest(setup.profile);
    request.function = static_cast<std::uint8_t>(function);
    request.address = static_cast<std::uint16_t>(address);
    request.count = static_cast<std::uint16_t>(count);
    return Ask(setup, request).exception;
  };
  // registers 11 to 17 are 10 to 16 on the wire, and the scale register is 19
  EXPECT_EQ(exception(4, 10, 7), 0);
  EXPECT_EQ(exception(4, 10, 1), 0);
  EXPECT_EQ(exception(4, 16, 1), 0);
  EXPECT_EQ(exception(4, 19, 1), 0);
  EXPECT_EQ(exception(3, 10, 7), 1);
  EXPECT_EQ(exception(4, 9, 1), 2);
  EXPECT_EQ(exception(4, 17, 1), 2);
  EXPECT_EQ(exception(4, 18, 1), 2);
  EXPECT_EQ(exception(4, 20, 1), 2);
  EXPECT_EQ(exception(4, 10, 8), 2);
  EXPECT_EQ(exception(4, 10, 125), 2);
  EXPECT_EQ(exception(4, 10, 126), 3);
  EXPECT_EQ(exception(4, 10, 0), 3);
}

TEST(ModbusUnit, RefusesARequestOfAnotherLength) {
  std::string frame;
  AppendAdu(kTcp, {.transaction = 1, .unit = 1, .function = 3, .data = "\x01\x02\x03"}, frame);
  EXPECT_EQ(Ask(Plain(), frame).exception, 3);
}

TEST(ModbusUnit, AnExactSensorAnswersItsOwnTwoRequestsOnly) {
  ModbusUnitSetup setup = Full(HeadAt(0));
  setup.profile.is_exact = true;
  setup.profile.check_address = 13;
  setup.profile.check_count = 2;
  EXPECT_EQ(AskForReading(setup).exception, 0);
  EXPECT_EQ(Ask(setup, CheckRequest(setup.profile)).registers.size(), 2U);
  ReadRequest part = ReadingRequest(setup.profile);
  part.count = 2;
  EXPECT_EQ(Ask(setup, part).exception, 3);
  part.address = 12;
  part.count = 1;
  EXPECT_EQ(Ask(setup, part).exception, 3);
}

TEST(ModbusUnit, DoesNotAnswerForAnotherSlaveNorADamagedRequest) {
  const ModbusUnitSetup setup = Plain(kRtu);
  ReadRequest request = ReadingRequest(setup.profile);
  EXPECT_TRUE(Ask(setup, request).is_there);
  request.unit = 2;
  EXPECT_FALSE(Ask(setup, request).is_there);
  std::string damaged = Frame(kRtu, ReadingRequest(setup.profile));
  damaged[3] ^= 1;
  EXPECT_FALSE(Ask(setup, damaged).is_there);
}

TEST(ModbusUnit, HangsUpOnAPeerThatSpeaksNoModbus) {
  ManualClock clock;
  ModbusUnit unit(Plain());
  unit.Receive(Frame(kTcp, {}), 0);
  EXPECT_FALSE(unit.TakeHangUp());
  unit.Receive("GET / HTTP/1.1\r\n", 0);
  EXPECT_TRUE(unit.TakeHangUp());
  EXPECT_FALSE(unit.TakeHangUp());
}

// --- time ------------------------------------------------------------------------------------

// when each byte of the answers to `frames`, written at 0, has come
std::vector<TimedByte> Timed(const ModbusUnitSetup& setup, const std::string& frames) {
  ManualClock clock;
  ModbusUnit unit(setup);
  unit.Receive(frames, 0);
  return RunUntil(unit, clock, 3 * kNsPerS);
}

TEST(ModbusUnit, AnswersOnASerialWireAfterSilenceAndTurnaround) {
  // 11 bits a character at 9600 baud: 8 characters, 3.5 of silence, 5 ms, 7 characters
  ModbusUnitSetup setup = Plain(kRtu);
  setup.turnaround_ns = 5 * kMs;
  const auto bytes = Timed(setup, Frame(kRtu, ReadingRequest(setup.profile)));
  ASSERT_EQ(bytes.size(), 7U);
  const double character_ns = 11e9 / 9600;
  EXPECT_ABS(static_cast<double>(bytes.front().time), 12.5 * character_ns + 5e6, 3,
             "three times rounded down to a nanosecond");
  EXPECT_ABS(static_cast<double>(bytes.back().time), 18.5 * character_ns + 5e6, 3,
             "three times rounded down to a nanosecond");
}

TEST(ModbusUnit, AnswersOneRequestAfterTheOther) {
  ModbusUnitSetup setup = Plain();
  setup.turnaround_ns = 5 * kMs;
  const std::string frame = Frame(kTcp, ReadingRequest(setup.profile));
  // 11 bytes each, which cross at once
  const auto sound = Timed(setup, frame + frame + frame);
  ASSERT_EQ(sound.size(), 33U);
  for (std::size_t i = 0; i < sound.size(); ++i) {
    EXPECT_EQ(sound[i].time, 5 * kMs * static_cast<MonotonicNs>(1 + i / 11)) << i;
  }
  // an answer that is late by 0.4 s delays the one behind it
  const auto slow = Timed(Faulty(setup, "slow:2"), frame + frame + frame);
  ASSERT_EQ(slow.size(), 33U);
  EXPECT_EQ(slow[10].time, 5 * kMs);
  EXPECT_EQ(slow[11].time, 410 * kMs);
  EXPECT_EQ(slow[22].time, 415 * kMs);
}

TEST(ModbusUnit, APauseLiesBeforeTheSecondHalfAndDelaysTheNext) {
  const ModbusUnitSetup setup = Faulty(Plain(), "byte-gap:2");
  const std::string frame = Frame(kTcp, ReadingRequest(setup.profile));
  const auto bytes = Timed(setup, frame + frame + frame);
  ASSERT_EQ(bytes.size(), 33U);
  for (std::size_t i = 11; i < 22; ++i) {
    // of 11 bytes the last five
    EXPECT_EQ(bytes[i].time, i - 11 < 6 ? 0 : 300 * kMs) << i;
  }
  EXPECT_EQ(bytes[22].time, 300 * kMs);
}

// --- faults ----------------------------------------------------------------------------------

TEST(ModbusUnit, FaultsOfTheValueAreInItsRegisters) {
  const ModbusUnitSetup full = Full(HeadAt(53.927e-3));
  // a status bit, and all bits of the value set
  EXPECT_EQ(AskForReading(Faulty(full, "invalid")).registers,
            (Registers{0, 0x0104, 0xFFFF, 0xFFFF, 0, 0, 0}));
  EXPECT_EQ(AskForReading(Faulty(full, "word-order")).registers,
            (Registers{0, 0, 0x344F, 0x0001, 0, 0, 0}));
  ModbusUnitSetup over = Plain();
  over.profile.most_number = 100;
  EXPECT_EQ(AskForReading(Faulty(over, "over")).registers, Registers{101});
  ModbusUnitSetup under = Plain();
  under.profile.least_number = 100;
  EXPECT_EQ(AskForReading(Faulty(under, "under")).registers, Registers{99});
  // 25 = 0x0019, the bytes of the one register swapped
  EXPECT_EQ(AskForReading(Faulty(Plain(), "word-order")).registers, Registers{0x1900});
  EXPECT_EQ(AskForReading(Faulty(Plain(), "error")).exception, 4);
}

TEST(ModbusUnit, AFaultOfTheValueNeedsANumberForIt) {
  const auto shows = [](SensorProfile profile, std::string_view name) {
    const FaultPlan plan = ParseFaultPlan(name).value();
    return ModbusUnit({.profile = std::move(profile), .head = HeadAt(0), .faults = plan})
        .Shows(*plan.fault);
  };
  SensorProfile profile{.name = "u16", .least_number = 0, .most_number = 65'535};
  for (const char* name : {"over", "under", "invalid", "amplifier-error"}) {
    EXPECT_FALSE(shows(profile, name)) << name;
  }
  EXPECT_TRUE(shows(profile, "silent"));
  profile.most_number = 65'534;
  EXPECT_TRUE(shows(profile, "over"));
  profile.most_number = 65'535;
  profile.invalid_bits = {0xFFFF};
  for (const char* name : {"over", "under", "invalid"}) EXPECT_TRUE(shows(profile, name)) << name;
}

TEST(ModbusUnit, AFloatWithoutAReadingIsNotANumber) {
  ModbusUnitSetup setup = Plain();
  setup.profile.type = RegisterType::kF32;
  setup.profile.count = 2;
  EXPECT_EQ(AskForReading(setup).registers, (Registers{0x41C8, 0})) << "25 in IEEE 754";
  EXPECT_EQ(AskForReading(Faulty(setup, "invalid")).registers, (Registers{0x7FC0, 0}));
}

TEST(ModbusUnit, FaultsOfTheAddressAreOffByOne) {
  const auto adu = [](std::string_view plan) {
    ManualClock clock;
    ModbusUnit unit(Faulty(Plain(), plan));
    unit.Receive(Frame(kTcp, {.transaction = 7}), 0);
    const std::string bytes = TextOf(RunUntil(unit, clock, kNsPerS));
    return std::pair(ParseAdu(kTcp, bytes).adu.transaction, ParseAdu(kTcp, bytes).adu.unit);
  };
  EXPECT_EQ(adu("slave"), std::pair(std::uint16_t{7}, std::uint8_t{2}));
  EXPECT_EQ(adu("transaction"), std::pair(std::uint16_t{8}, std::uint8_t{1}));
  EXPECT_EQ(adu("slave:2"), std::pair(std::uint16_t{7}, std::uint8_t{1})) << "the second answer";
}

}  // namespace
}  // namespace haptometer::acquire::emulator
