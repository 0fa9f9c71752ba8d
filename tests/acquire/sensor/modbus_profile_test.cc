// Sensor profiles: the built-in ones against the makers' frames, and the file format as documented.
#include "acquire/sensor/modbus_profile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "tests/findings.h"
#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

using ::testing::HasSubstr;
using tests::NumbersOf;

const SensorProfile& BuiltIn(const std::string& name) {
  for (const SensorProfile& profile : BuiltInProfiles()) {
    if (profile.name == name) return profile;
  }
  ADD_FAILURE() << name;
  return BuiltInProfiles()[0];
}

TEST(BuiltInProfiles, HaveNothingWrong) {
  for (const SensorProfile& profile : BuiltInProfiles()) {
    EXPECT_EQ(WhatIsWrong(profile), "") << profile.name;
    EXPECT_TRUE(FindProfile(profile.name)) << profile.name;
    EXPECT_NE(CheckRequest(profile).count, ReadingRequest(profile).count) << profile.name;
  }
}

std::string Frame(const ReadRequest& request) {
  std::string frame;
  AppendReadRequest(ModbusFraming::kRtu, request, frame);
  frame.resize(frame.size() - 2);  // the CRC is tested elsewhere
  return frame;
}

std::string Bytes(std::initializer_list<unsigned> bytes) {
  std::string text;
  for (const unsigned byte : bytes) text += static_cast<char>(byte);
  return text;
}

TEST(BuiltInProfiles, AskAsTheManualsDo) {
  EXPECT_EQ(Frame(ReadingRequest(BuiltIn("baumer-om20"))), Bytes({1, 4, 0, 200, 0, 13}));
  EXPECT_EQ(Frame(CheckRequest(BuiltIn("baumer-om20"))), Bytes({1, 4, 0, 202, 0, 2}));
  EXPECT_EQ(Frame(ReadingRequest(BuiltIn("riftek-rf602"))), Bytes({1, 4, 0, 6, 0, 1}));
  EXPECT_EQ(Frame(CheckRequest(BuiltIn("riftek-rf602"))), Bytes({1, 4, 0, 5, 0, 2}));
  EXPECT_EQ(Frame(CheckRequest(BuiltIn("benewake-tf-i"))), Bytes({1, 3, 0, 0, 0, 1}));
  EXPECT_EQ(Frame(ReadingRequest(BuiltIn("benewake-tf-i"))), Bytes({1, 3, 0, 0, 0, 2}));
  EXPECT_EQ(Frame(ReadingRequest(BuiltIn("wt53r"))), Bytes({0x50, 3, 0, 0x34, 0, 1}));
}

TEST(BuiltInProfiles, AnAddressBaseOfOneIsTakenOffOnTheWire) {
  SensorProfile profile = BuiltIn("riftek-rf602");
  profile.address_base = 1;
  EXPECT_EQ(WhatIsWrong(profile), "");
  EXPECT_EQ(Frame(ReadingRequest(profile)), Bytes({1, 4, 0, 5, 0, 1}));
}

struct WireRate {
  int baud;
  int count;
  double rate_hz;
};

class RtuRates : public ::testing::TestWithParam<WireRate> {};

// 8E1, both frames at 11 bits a character and two silent intervals of 3.5 characters, 1.75 ms above
// 19200 baud: worked by hand to whole readings
TEST_P(RtuRates, AreTheWiresArithmetic) {
  SensorProfile profile{.name = "any"};
  profile.wire.baud = GetParam().baud;
  profile.count = GetParam().count;
  EXPECT_ABS(HighestRateHz(profile), GetParam().rate_hz, 0.5, "rounded to whole readings");
}

INSTANTIATE_TEST_SUITE_P(Table, RtuRates,
                         ::testing::Values(WireRate{9600, 1, 40}, WireRate{9600, 13, 19},
                                           WireRate{19200, 2, 73}, WireRate{57600, 1, 157},
                                           WireRate{57600, 13, 91}, WireRate{115200, 2, 195},
                                           WireRate{230400, 13, 186}, WireRate{921600, 1, 272}));

// 15 characters of 11 bits at 9600 baud, and two silent intervals of 38.5 bits
TEST(RtuPeriod, IsBothFramesAndTwoSilentIntervals) {
  SensorProfile profile{.name = "any"};
  EXPECT_ABS(static_cast<double>(RtuExchangeNs(profile)), 165e9 / 9600, 1, "rounded down");
  EXPECT_ABS(static_cast<double>(RtuPeriodNs(profile)), 242e9 / 9600, 3, "thrice rounded down");
  // a gap longer than the silent interval of 4.01 ms takes its place
  profile.least_gap_ns = 4'000'000;
  EXPECT_ABS(static_cast<double>(RtuPeriodNs(profile)), 242e9 / 9600, 3, "thrice rounded down");
  profile.least_gap_ns = 10'000'000;
  EXPECT_ABS(static_cast<double>(RtuPeriodNs(profile)), 203.5e9 / 9600 + 1e7, 2, "rounded down");
  // 8 + 31 characters at 57600 baud and twice 1.75 ms
  profile = BuiltIn("baumer-om20");
  EXPECT_ABS(static_cast<double>(RtuPeriodNs(profile)), 429e9 / 57600 + 3.5e6, 1, "rounded down");
}

TEST(RtuPeriod, TheSlowerOfWireAndSensorCounts) {
  // the wire allows 39.67 readings/s
  SensorProfile profile{.name = "any"};
  profile.fastest_rate_hz = 39;
  EXPECT_EQ(HighestRateHz(profile), 39);
  profile.fastest_rate_hz = 40;
  EXPECT_REL(HighestRateHz(profile), 9600.0 / 242, 1e-6, "rounded to nanoseconds");
}

TEST(WireRate, IsFoundWithWhatItObserves) {
  // a tone of a / 2.56 is observed of a readings/s; 1 / 3.5 ms at any baud rate
  SensorProfile profile{.name = "any"};
  EXPECT_EQ(NumbersOf(FindWireRate(profile), FindingKind::kRegistersRate),
            "profile=any baud=9600 registers=1 wire_s=0.0252083 rate_hz=39.6694 "
            "observable_hz=15.4959");
  EXPECT_EQ(NumbersOf(FindWireRate(profile), FindingKind::kRegistersTooSlow),
            "rate_hz=285.714 needed_hz=1280");
  profile.fastest_rate_hz = 16;
  EXPECT_EQ(NumbersOf(FindWireRate(profile), FindingKind::kRegistersRate),
            "profile=any baud=9600 registers=1 wire_s=0.0252083 rate_hz=39.6694 "
            "observable_hz=6.25 new_rate_hz=16");
  // over TCP the sensor's own rate counts alone
  profile.transport = ModbusFraming::kTcp;
  profile.fastest_rate_hz = 256;
  EXPECT_EQ(NumbersOf(FindWireRate(profile), FindingKind::kProfileRate),
            "profile=any rate_hz=256 observable_hz=100");
  profile.fastest_rate_hz.reset();
  EXPECT_EQ(NumbersOf(FindWireRate(profile), FindingKind::kProfileRateUnknown), "profile=any");
}

TEST(BuiltInProfiles, HaveTheUnitsOfTheManuals) {
  // Baumer: a float in mm; RIFTEK: D S / 16384 mm; Benewake: whole cm; WT53R: whole mm
  const SensorProfile& baumer = BuiltIn("baumer-om20");
  EXPECT_EQ(baumer.type, RegisterType::kF32);
  EXPECT_EQ(baumer.unit_m * baumer.scale, 1e-3);
  EXPECT_EQ(baumer.wire.baud, 57600);
  EXPECT_EQ(baumer.wire.parity, Parity::kEven);
  EXPECT_EQ(baumer.value_address, 202);
  EXPECT_EQ(baumer.status_address, 201);
  EXPECT_EQ(baumer.timestamp_address, 209);
  EXPECT_EQ(baumer.timestamp_count, 4);
  EXPECT_EQ(baumer.status_mask, 2) << "alarm";
  for (const char* name : {"riftek-rf602", "acuity-ar100"}) {
    const SensorProfile& laser = BuiltIn(name);
    EXPECT_REL(laser.unit_m * laser.scale * 16384, 1e-3, 1e-15, "two products");
    EXPECT_EQ(laser.scale_address, 5);
    EXPECT_EQ(laser.most_number, 16384);
    EXPECT_EQ(laser.fastest_rate_hz, 200) << "5 ms as delivered";
    EXPECT_EQ(laser.wire.baud, 9600);
  }
  const SensorProfile& benewake = BuiltIn("benewake-tf-i");
  EXPECT_EQ(benewake.unit_m * benewake.scale, 1e-2);
  EXPECT_EQ(benewake.resolution_m, 1e-2);
  EXPECT_EQ(benewake.fastest_rate_hz, 100);
  EXPECT_EQ(benewake.invalid_bits, std::vector<std::uint32_t>{4500});
  EXPECT_EQ(benewake.wire.baud, 115200);
  const SensorProfile& wt53r = BuiltIn("wt53r");
  EXPECT_EQ(wt53r.unit_m * wt53r.scale, 1e-3);
  EXPECT_EQ(wt53r.resolution_m, 1e-3);
  EXPECT_EQ(wt53r.wire.baud, 115200);
  EXPECT_EQ(wt53r.wire.parity, Parity::kNone);
}

// --- limits ---

// what may just be, what may not, and the key that is then named
struct Limit {
  const char* key;
  void (*within)(SensorProfile& profile);
  void (*beyond)(SensorProfile& profile);
};

using P = SensorProfile;

class ProfileLimits : public ::testing::TestWithParam<Limit> {};

TEST_P(ProfileLimits, HoldOnBothSides) {
  SensorProfile within{.name = "any"};
  GetParam().within(within);
  EXPECT_EQ(WhatIsWrong(within), "");
  SensorProfile beyond{.name = "any"};
  GetParam().beyond(beyond);
  EXPECT_THAT(WhatIsWrong(beyond), ::testing::StartsWith(GetParam().key));
}

void OverTcp(SensorProfile& profile, int slave) {
  profile.transport = ModbusFraming::kTcp;
  profile.wire.slave = slave;
}

INSTANTIATE_TEST_SUITE_P(
    Wire, ProfileLimits,
    ::testing::Values(
        Limit{"slave:", [](P& p) { p.wire.slave = 1; }, [](P& p) { p.wire.slave = 0; }},
        Limit{"slave:", [](P& p) { p.wire.slave = 247; }, [](P& p) { p.wire.slave = 248; }},
        Limit{"slave:", [](P& p) { OverTcp(p, 0); }, [](P& p) { OverTcp(p, -1); }},
        Limit{"slave:", [](P& p) { OverTcp(p, 255); }, [](P& p) { OverTcp(p, 254); }},
        Limit{"stop_bits:", [](P& p) { p.wire.stop_bits = 2; }, [](P& p) { p.wire.stop_bits = 3; }},
        Limit{"stop_bits:", [](P& p) { p.wire.stop_bits = 1; }, [](P& p) { p.wire.stop_bits = 0; }},
        Limit{"response_timeout_s:", [](P& p) { p.longest_reply_ns = 60 * kNsPerS; },
              [](P& p) { p.longest_reply_ns = 60 * kNsPerS + 1; }},
        Limit{"response_timeout_s:", [](P& p) { p.response_timeout_ns = 1; },
              [](P& p) { p.response_timeout_ns = 0; }},
        Limit{"longest_reply_s:", [](P& p) { p.response_timeout_ns = p.longest_reply_ns; },
              [](P& p) { p.response_timeout_ns = p.longest_reply_ns + 1; }},
        Limit{"least_gap_s:", [](P& p) { p.least_gap_ns = 60 * kNsPerS; },
              [](P& p) { p.least_gap_ns = 60 * kNsPerS + 1; }},
        Limit{"least_gap_s:", [](P& p) { p.least_gap_ns = 0; }, [](P& p) { p.least_gap_ns = -1; }},
        Limit{"fastest_rate_hz:", [](P& p) { p.fastest_rate_hz = 1e-3; },
              [](P& p) { p.fastest_rate_hz = 0.99e-3; }}));

INSTANTIATE_TEST_SUITE_P(
    Registers, ProfileLimits,
    ::testing::Values(
        Limit{"address_base:", [](P& p) { p.address_base = p.address = p.value_address = 1; },
              [](P& p) { p.address_base = p.address = p.value_address = 2; }},
        Limit{"count:", [](P& p) { p.count = 125; }, [](P& p) { p.count = 126; }},
        Limit{"count:", [](P& p) { p.count = 1; }, [](P& p) { p.count = 0; }},
        Limit{"count:", [](P& p) { p.address = p.value_address = 65535; },
              [](P& p) { p.address = p.value_address = 65536; }},
        Limit{"count:", [](P& p) { p.address = p.value_address = 65535; },
              [](P& p) { p.address = p.value_address = std::numeric_limits<int>::max(); }},
        Limit{"[value] address:", [](P& p) { p.count = 2, p.value_address = 1; },
              [](P& p) { p.value_address = std::numeric_limits<int>::max(); }},
        Limit{"count:", [](P& p) { p.address_base = 1, p.address = p.value_address = 65536; },
              [](P& p) { p.address_base = 1, p.address = p.value_address = 65537; }},
        Limit{"[value] address:", [](P& p) { p.count = 2, p.value_address = 1; },
              [](P& p) { p.count = 2, p.value_address = 2; }},
        Limit{"[value] address:", [](P& p) { p.count = 2, p.type = RegisterType::kF32; },
              [](P& p) { p.count = 1, p.type = RegisterType::kF32; }},
        Limit{"[value] address:", [](P& p) { p.address = 3, p.value_address = 3; },
              [](P& p) { p.address = 3, p.value_address = 2; }},
        Limit{
            "[status] address:", [](P& p) { p.count = 2, p.status_address = 1, p.status_mask = 1; },
            [](P& p) { p.count = 2, p.status_address = 2, p.status_mask = 1; }},
        Limit{"[timestamp] address:",
              [](P& p) { p.count = 3, p.timestamp_address = 1, p.timestamp_count = 2; },
              [](P& p) { p.count = 3, p.timestamp_address = 1, p.timestamp_count = 3; }},
        Limit{"[timestamp] address:",
              [](P& p) { p.count = 3, p.timestamp_address = 1, p.timestamp_count = 1; },
              [](P& p) { p.count = 3, p.timestamp_address = 1, p.timestamp_count = 0; }},
        Limit{"check_count:", [](P& p) { p.check_address = 0, p.check_count = 125; },
              [](P& p) { p.check_address = 0, p.check_count = 126; }},
        Limit{"check_address:", [](P& p) { p.check_address = 0, p.check_count = 2; },
              [](P& p) { p.check_address = 0; }},
        Limit{"scale:", [](P& p) { p.scale = -1e-9; }, [](P& p) { p.scale = 0; }},
        Limit{"scale:", [](P& p) { p.scale = 1e300; },
              [](P& p) { p.scale = std::numeric_limits<double>::infinity(); }},
        Limit{"offset:", [](P& p) { p.offset = -1e300; }, [](P& p) { p.offset = std::nan(""); }},
        Limit{"unit:", [](P& p) { p.unit_m = 1e-300; }, [](P& p) { p.unit_m = 0; }},
        Limit{"unit:", [](P& p) { p.unit_m = 1e300; },
              [](P& p) { p.unit_m = std::numeric_limits<double>::infinity(); }},
        Limit{"scale_address:", [](P& p) { p.scale_address = 65535; },
              [](P& p) { p.scale_address = 65536; }},
        Limit{"least:", [](P& p) { p.most_number = -1; },
              [](P& p) { p.least_number = 0, p.most_number = -1; }},
        Limit{"raw:", [](P& p) { p.invalid_bits = {0xFFFF}; },
              [](P& p) { p.invalid_bits = {0x10000}; }},
        Limit{"least:", [](P& p) { p.least_number = 1, p.most_number = 1.01; },
              [](P& p) { p.least_number = 1, p.most_number = 1; }}));

// --- files ---

TEST(ProfileFile, TheDocumentedExampleIsRead) {
  const auto page =
      ReadInputFile(std::string(HAPTOMETER_FIXTURES) + "/../docs/reference/sensors.md");
  ASSERT_TRUE(page);
  const std::size_t modbus = page->find("## Modbus");
  const std::size_t begin = page->find("```toml\n", modbus) + 8;
  ASSERT_NE(modbus, std::string::npos);
  const auto profile =
      ReadProfileText(page->substr(begin, page->find("```", begin) - begin), "doc");
  ASSERT_TRUE(profile) << profile.error().Text();
  EXPECT_EQ(profile->name, "my-sensor");
  EXPECT_EQ(profile->wire.baud, 9600);
  EXPECT_EQ(profile->wire.parity, Parity::kEven);
  EXPECT_EQ(profile->response_timeout_ns, kNsPerS / 2);
  EXPECT_EQ(Frame(ReadingRequest(*profile)), Bytes({1, 4, 0, 29, 0, 6}));
  EXPECT_EQ(Frame(CheckRequest(*profile)), Bytes({1, 4, 0, 29, 0, 2}));
  EXPECT_EQ(profile->type, RegisterType::kF32);
  EXPECT_EQ(profile->order, WordOrder::kCdab);
  EXPECT_EQ(profile->unit_m, 1e-3);
  EXPECT_EQ(profile->invalid_bits, std::vector<std::uint32_t>{0});
  EXPECT_EQ(profile->least_number, 0.5);
  EXPECT_EQ(profile->most_number, 100);
  EXPECT_EQ(profile->status_address, 30);
  EXPECT_EQ(profile->status_mask, 3);
  EXPECT_EQ(profile->timestamp_count, 2);
  EXPECT_EQ(profile->resolution_m, 2e-6);
  EXPECT_EQ(profile->fastest_rate_hz, 100);
}

TEST(ProfileFile, TheShortestIsEnough) {
  const auto profile =
      ReadProfileText("name = \"s\"\n[request]\naddress = 0\n[value]\nunit = \"cm\"\n", "short");
  ASSERT_TRUE(profile) << profile.error().Text();
  EXPECT_EQ(profile->unit_m, 1e-2);
  EXPECT_EQ(Frame(ReadingRequest(*profile)), Bytes({1, 3, 0, 0, 0, 1}));
  EXPECT_EQ(Frame(CheckRequest(*profile)), Bytes({1, 3, 0, 0, 0, 2}));
}

struct Refusal {
  const char* text;
  const char* says;
};

class ProfileRefusals : public ::testing::TestWithParam<Refusal> {};

TEST_P(ProfileRefusals, NameTheKeyAndTheRemedy) {
  const std::string text = std::string("name = \"s\"\n") + GetParam().text;
  const auto profile = ReadProfileText(text, "p.toml");
  ASSERT_FALSE(profile);
  EXPECT_THAT(profile.error().Text(), HasSubstr(GetParam().says));
}

constexpr const char* kBeyond = "[request]\naddress = 3\n[value]\naddress = 4\nunit = \"mm\"\n";

INSTANTIATE_TEST_SUITE_P(
    All, ProfileRefusals,
    ::testing::Values(
        Refusal{"[reqest]\naddress = 0\n", "did you mean request?"},
        Refusal{"[request]\nadress = 0\n[value]\nunit = \"mm\"\n", "did you mean address?"},
        Refusal{"[value]\nunit = \"mm\"\n", "request: is missing; add the table"},
        Refusal{"[request]\naddress = 0\n", "value: is missing; add the table"},
        Refusal{"[request]\naddress = 0\n[value]\n", "unit: is missing"},
        Refusal{"[request]\n[value]\nunit = \"mm\"\n", "address: is missing"},
        Refusal{"[wire]\nbaud = 9601\n[request]\naddress = 0\n[value]\nunit = \"mm\"\n",
                "baud: 9601 cannot be set"},
        Refusal{"[wire]\nslave = 255\n[request]\naddress = 0\n[value]\nunit = \"mm\"\n",
                "slave: must be 1 to 247"},
        Refusal{"[request]\naddress = 0\nfunction = 6\n[value]\nunit = \"mm\"\n",
                "function: must be 3 or 4"},
        Refusal{"[request]\naddress = 0\ncount = 126\n[value]\nunit = \"mm\"\n", "1 to 125"},
        Refusal{"[request]\naddress = 65535\ncount = 2\n[value]\nunit = \"mm\"\n", "65535"},
        Refusal{"[request]\naddress = 0\naddress_base = 1\n[value]\nunit = \"mm\"\n", "count:"},
        Refusal{kBeyond, "must lie within the registers that are read"},
        Refusal{"[request]\naddress = 0\n[value]\nunit = \"mm\"\n[invalid]\nraw = [65536]\n",
                "raw: does not fit"},
        Refusal{"[request]\naddress = 0\n[value]\nunit = \"mm\"\n[invalid]\nraw = 0\n",
                "is not a list of whole numbers"},
        Refusal{"[request]\naddress = 0\n[value]\nunit = \"mm\"\nscale = 0\n", "scale: must be"},
        Refusal{"[request]\naddress = 0\ncheck_address = 0\ncheck_count = 1\n"
                "[value]\nunit = \"mm\"\n",
                "check_count: must differ"},
        Refusal{"[request]\naddress = 0\n[value]\nunit = \"mm\"\n[status]\naddress = 0\n",
                "mask: must be 1 to 0xFFFF"}));

// a profile of one register, with these lines in [wire], [value] and [invalid]
Result<SensorProfile> ProfileWith(const std::string& wire, const std::string& value,
                                  const std::string& invalid = "") {
  return ReadProfileText("name = \"s\"\n[wire]\n" + wire + "\n[request]\naddress = 0\ncount = 2\n" +
                             "[value]\n" + value + "\n[invalid]\n" + invalid + "\n",
                         "p.toml");
}

TEST(ProfileFile, UnitsAreTheirLengths) {
  for (const auto& [unit, metres] :
       {std::pair("m", 1.0), {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}, {"nm", 1e-9}}) {
    const auto profile = ProfileWith("", std::string("unit = \"") + unit + "\"");
    ASSERT_TRUE(profile) << profile.error().Text();
    EXPECT_REL(profile->unit_m, metres, 1e-15, "a decimal read once");
  }
}

TEST(ProfileFile, TimesAreSecondsUpToAMinute) {
  const auto profile = ProfileWith(
      "least_gap_s = 0.002\nresponse_timeout_s = 0.25\nlongest_reply_s = 60", "unit = \"mm\"");
  ASSERT_TRUE(profile) << profile.error().Text();
  EXPECT_EQ(profile->least_gap_ns, 2'000'000);
  EXPECT_EQ(profile->response_timeout_ns, 250'000'000);
  EXPECT_EQ(profile->longest_reply_ns, 60 * kNsPerS);
  for (const char* wire : {"longest_reply_s = 60.01", "least_gap_s = -0.001"}) {
    EXPECT_THAT(ProfileWith(wire, "unit = \"mm\"").error().Text(), HasSubstr("must be 0 to 60 s"));
  }
}

TEST(ProfileFile, AMaskHasSixteenBits) {
  const auto with = [](const std::string& status) {
    return ReadProfileText(
        "name = \"s\"\n[request]\naddress = 0\n[value]\nunit = \"mm\"\n"
        "[status]\naddress = 0\n" +
            status,
        "p.toml");
  };
  EXPECT_EQ(with("mask = 1").value().status_mask, 1);
  EXPECT_EQ(with("mask = 0xFFFF").value().status_mask, 0xFFFF);
  for (const char* mask : {"mask = 0", "mask = 0x10000", "mask = -1"}) {
    ASSERT_FALSE(with(mask)) << mask;
    EXPECT_THAT(with(mask).error().Text(), HasSubstr("mask: must be 1 to 0xFFFF")) << mask;
  }
  EXPECT_EQ(with("mask = 1").value().status_meaning, StatusMeaning::kInvalid);
  EXPECT_EQ(with("mask = 1\nmeans = \"invalid\"").value().status_meaning, StatusMeaning::kInvalid);
  EXPECT_EQ(with("mask = 1\nmeans = \"device_error\"").value().status_meaning,
            StatusMeaning::kDeviceError);
}

TEST(ProfileFile, StatusAndTimestampStandInRegisterNoughtUnlessStated) {
  const auto profile = ReadProfileText(
      "name = \"s\"\n[request]\naddress = 0\ncount = 2\n[value]\nunit = \"mm\"\n"
      "[status]\nmask = 1\n[timestamp]\n",
      "p.toml");
  ASSERT_TRUE(profile) << profile.error().Text();
  EXPECT_EQ(profile->status_address, 0);
  EXPECT_EQ(profile->timestamp_address, 0);
  EXPECT_EQ(profile->timestamp_count, 1);
}

TEST(CheckRequest, OfSeveralRegistersHasOneFewer) {
  for (const int count : {2, 3, 125}) {
    const SensorProfile profile{.name = "any", .count = count};
    EXPECT_EQ(CheckRequest(profile).count, count - 1);
    EXPECT_EQ(CheckRequest(profile).address, ReadingRequest(profile).address);
  }
  EXPECT_EQ(CheckRequest({.name = "any", .count = 1}).count, 2);
  EXPECT_EQ(ReadingRequest({.name = "any"}).transaction, 0);
}

TEST(ProfileFile, InvalidNumbersFitTheirType) {
  const std::string one = "unit = \"mm\"\ntype = \"i16\"";
  EXPECT_EQ(ProfileWith("", one, "raw = [-32768, 65535]")->invalid_bits,
            (std::vector<std::uint32_t>{0x8000, 0xFFFF}));
  EXPECT_FALSE(ProfileWith("", one, "raw = [-32769]"));
  EXPECT_FALSE(ProfileWith("", one, "raw = [65536]"));
  const std::string two = "unit = \"mm\"\ntype = \"i32\"";
  EXPECT_EQ(ProfileWith("", two, "raw = [-2147483648, 4294967295]")->invalid_bits,
            (std::vector<std::uint32_t>{0x80000000, 0xFFFFFFFF}));
  EXPECT_FALSE(ProfileWith("", two, "raw = [-2147483649]"));
  EXPECT_FALSE(ProfileWith("", two, "raw = [4294967296]"));
}

TEST(ProfileFile, AnUnknownNameIsAnswered) {
  EXPECT_THAT(FindProfile("baumer-om2").error().Text(), HasSubstr("did you mean baumer-om20?"));
}

TEST(ProfileFile, NegativeInvalidNumbersAreTheirBits) {
  const auto profile = ReadProfileText(
      "name = \"s\"\n[request]\naddress = 0\n[value]\ntype = \"i16\"\nunit = \"mm\"\n"
      "[invalid]\nraw = [-1, 0x8000]\n",
      "p.toml");
  ASSERT_TRUE(profile) << profile.error().Text();
  EXPECT_EQ(profile->invalid_bits, (std::vector<std::uint32_t>{0xFFFF, 0x8000}));
}

}  // namespace
}  // namespace haptometer::acquire
