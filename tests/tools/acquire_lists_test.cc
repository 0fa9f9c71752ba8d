// What --list-ports and --list-sensors print.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/residual.h"
#include "tools/acquire/recording_document.h"

namespace haptometer::tools {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const acquire::PortInfo kAdapter{.path = "/dev/ttyUSB0",
                                 .by_id = "/dev/serial/by-id/usb-FTDI",
                                 .description = "FT232R",
                                 .driver = "ftdi_sio",
                                 .usb_vendor = 0x0403,
                                 .usb_product = 0x6001,
                                 .usb_serial = "A50285BI",
                                 .latency_ns = 16'000'000,
                                 .held_by = "minicom (process 7)"};

TEST(PortList, SaysWhatIsKnownAndWhatItCosts) {
  const std::string text = PortListText({kAdapter, {.path = "/dev/ttyS0"}});
  EXPECT_THAT(text,
              AllOf(HasSubstr("/dev/serial/by-id/usb-FTDI\n"), HasSubstr("0403:6001 A50285BI"),
                    HasSubstr("16 ms\n"), HasSubstr("41.4 readings/s at most instead of"),
                    HasSubstr("minicom (process 7)")));
  EXPECT_THAT(text.substr(text.find("/dev/ttyS0")), "/dev/ttyS0\n");
  EXPECT_THAT(PortListText({}), HasSubstr("no serial port is there"));
}

TEST(PortList, WhatIsNotKnownIsNull) {
  const json document = json::parse(PortListJson({kAdapter, {.path = "/dev/ttyS0"}}));
  const json& usb = document["ports"][0];
  EXPECT_EQ(usb["usb_vendor"], 0x0403);
  EXPECT_EQ(usb["latency_s"], 0.016);
  EXPECT_REL(usb["dl_rs1a_38400_baud_rate_hz"].get<double>(), 41.4, 2e-3, "three digits");
  const json& board = document["ports"][1];
  EXPECT_EQ(board.size(), usb.size());
  for (const auto& [key, value] : board.items()) EXPECT_EQ(value.is_null(), key != "port") << key;
}

TEST(SensorList, AsksWhatTheOptionsSay) {
  const auto question =
      ReadCapabilityQuestion("20Hz-0.5kHz", Quantity{.value = 2e-6, .standard_uncertainty = 0});
  ASSERT_TRUE(question);
  EXPECT_EQ(question->lower_hz, 20);
  EXPECT_EQ(question->upper_hz, 500);
  EXPECT_EQ(question->resolution_m, 2e-6);
  EXPECT_EQ(ReadCapabilityQuestion("20-500Hz", std::nullopt)->resolution_m, 1e-6);
  for (const char* band : {"500-20Hz", "20Hz", "20-20Hz", "a-b"}) {
    const auto wrong = ReadCapabilityQuestion(band, std::nullopt);
    ASSERT_FALSE(wrong) << band;
    EXPECT_EQ(wrong.error().cause, Cause::kUsage);
    EXPECT_THAT(wrong.error().Text(), HasSubstr("--band"));
  }
  EXPECT_FALSE(ReadCapabilityQuestion("1-2Hz", Quantity{.value = 0, .standard_uncertainty = 0}));
}

TEST(SensorList, TextAndDocumentSayTheSame) {
  const acquire::CapabilityQuestion question;
  const std::string text = SensorListText(question);
  const json document = json::parse(SensorListJson(question));
  for (const json& sensor : document["sensors"]) {
    const std::string verdict = sensor["can_answer"] ? "yes     " : "cannot  ";
    EXPECT_THAT(text, HasSubstr(verdict + sensor["name"].get<std::string>() + "\n        " +
                                sensor["reason"].get<std::string>()));
  }
  // what no maker states is null, and the noise of no wire is invented
  EXPECT_TRUE(document["sensors"][0]["noise_in_band_m"].is_null());
  EXPECT_THAT(SensorListJson(question), Not(HasSubstr("NaN")));
}

}  // namespace
}  // namespace haptometer::tools
