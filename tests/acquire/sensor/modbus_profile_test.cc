// Sensor profiles: the built-in ones against the makers' frames, and the file format as documented.
#include "acquire/sensor/modbus_profile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/input_file.h"
#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

using ::testing::HasSubstr;

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
