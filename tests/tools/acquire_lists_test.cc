// What a recording, --list-ports and --list-sensors answer.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/residual.h"
#include "tools/acquire/recording_document.h"
#include "tools/document/render.h"

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

std::string TextOf(const document::Document& document) {
  return document::TextOf(document, document::Detail::kShort);
}

json Parsed(const document::Document& document) { return json::parse(document::JsonOf(document)); }

TEST(PortList, SaysWhatIsKnownAndWhatItCosts) {
  const std::string text = TextOf(PortsDocument({kAdapter, {.path = "/dev/ttyS0"}}));
  EXPECT_THAT(text, AllOf(HasSubstr("/dev/serial/by-id/usb-FTDI\n"),
                          HasSubstr("0403:6001 A50285BI"), HasSubstr("16 ms\n"),
                          HasSubstr("doubt: the adapter keeps short replies for 16 ms: readings at "
                                    "41.38 Hz at most in place of"),
                          HasSubstr("minicom (process 7)")));
  EXPECT_THAT(text, ::testing::EndsWith("  /dev/ttyS0\n    adapter  none is known\n"));
  EXPECT_THAT(TextOf(PortsDocument({})), HasSubstr("no serial port is there"));
}

TEST(PortList, WhatIsNotKnownIsNull) {
  const json document = Parsed(PortsDocument({kAdapter, {.path = "/dev/ttyS0"}}));
  const json& usb = document["ports"][0];
  EXPECT_EQ(usb["usb_vendor"], 0x0403);
  EXPECT_EQ(usb["latency_s"], 0.016);
  EXPECT_REL(usb["dl_rs1a_38400_baud_rate_hz"].get<double>(), 41.4, 2e-3, "three digits");
  const json& board = document["ports"][1];
  EXPECT_EQ(board.size(), usb.size());
  for (const auto& [key, value] : board.items()) EXPECT_EQ(value.is_null(), key != "port") << key;
  EXPECT_EQ(document["findings"].size(), 1U);
  EXPECT_EQ(document["findings"][0]["kind"], "latency-timer");
}

TEST(SensorList, AsksWhatTheOptionsSay) {
  const auto question = ReadCapabilityQuestion("20Hz-0.5kHz", 2e-6);
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
}

TEST(SensorList, TextAndJsonSayTheSame) {
  const document::Document made = SensorsDocument({});
  const std::string text = TextOf(made);
  const json document = Parsed(made);
  for (const json& sensor : document["sensors"]) {
    const std::string verdict = sensor["can_answer"] ? "yes: " : "cannot: ";
    EXPECT_THAT(text, HasSubstr(verdict + sensor["name"].get<std::string>() +
                                "\n    because       " + sensor["reason"].get<std::string>()));
    EXPECT_THAT(sensor["option"].get<std::string>(), ::testing::StartsWith("--sensor "));
  }
  EXPECT_EQ(document["band_hz"], json::parse("[20.0, 500.0]"));
  // what no maker states is null, and the noise of no wire is invented
  EXPECT_TRUE(document["sensors"][0]["noise_in_band_m"].is_null());
  EXPECT_THAT(document::JsonOf(made), Not(HasSubstr("NaN")));
}

// --- a recording ---

acquire::RecordingSummary Summary() {
  acquire::RecordingSummary summary;
  summary.readings = 30'005;
  summary.measured = 30'003;
  summary.gaps = 1;
  summary.rate_hz = 10'001.6;
  summary.elapsed_s = 3;
  summary.statuses[static_cast<std::size_t>(trial::SampleStatus::kOk)] = 30'003;
  summary.statuses[static_cast<std::size_t>(trial::SampleStatus::kLate)] = 2;
  summary.interval_sd_s = 8.6e-5;
  return summary;
}

trial::Metadata Emulated() {
  trial::Metadata metadata;
  metadata.source = "emulated device: virtual terminal s";
  metadata.sensor = "stream";
  metadata.fields = {{"latency_at_least_s", "9.7656e-05"}};
  return metadata;
}

TEST(RecordingDocument, SaysWhatCameOfIt) {
  acquire::Findings found;
  found.Note(acquire::FindingKind::kSettingsNotRead);
  const document::Document made = RecordingDocument(
      "t.bin", Emulated(), Summary(), TimeBaseReview{.gaps = 1, .uncertainty_s = 2.2e-6}, found);
  const std::string text = TextOf(made);
  EXPECT_THAT(text, ::testing::StartsWith("t.bin: 30005 readings in 3.000 s\n  data: emulated\n"));
  for (const char* said :
       {"10001.6 Hz\n", "0.086 ms\n", "  2, 2 late\n", "note: the times of arrival are fitted",
        "note: all times have one constant delay of at least 0.09766 ms, whose value is not "
        "known"}) {
    EXPECT_THAT(text, HasSubstr(said));
  }
  EXPECT_THAT(text, Not(HasSubstr("lost to a slow disk"))) << "0 is not worth a line";
  EXPECT_THAT(text, Not(HasSubstr("are not read"))) << "was said before the recording";
  EXPECT_THAT(document::TextOf(made, document::Detail::kAll), HasSubstr("are not read"));
  const json document = Parsed(made);
  EXPECT_EQ(document["bad"], 2);
  EXPECT_EQ(document["bad_by_kind"]["late"], 2);
  EXPECT_EQ(document["distinct"], 30'003);
  EXPECT_EQ(document["data_source"], json::parse(R"(["emulated"])"));
  EXPECT_EQ(document["time_uncertainty_s"], 2.2e-6);
  EXPECT_EQ(document["findings"].size(), 3U);
  EXPECT_EQ(document["lost"], 0);
}

TEST(RecordingDocument, NumbersThatTheTimesRefuteAreADoubt) {
  TimeBaseReview review;
  review.doubts.Doubt(trial::FindingKind::kNumbersRefuted,
                      {{"lines", 1}, {"row", 700}, {"missing", 999}});
  EXPECT_THAT(
      TextOf(RecordingDocument("t.bin", Emulated(), Summary(), review, {})),
      HasSubstr("doubt: by the number of 1 line more lines are missing than the times hold"));
}

TEST(RecordingDocument, TheLengthIsThatOfTheRowsAndTheWaitIsBesideIt) {
  // 12500 rows at 5 kHz, of which the first was the 7500th
  acquire::RecordingSummary summary;
  summary.readings = 12'500;
  summary.rate_hz = 5000;
  summary.elapsed_s = 19'999 / 5000.0;
  summary.triggers = 1;
  const document::Document made = RecordingDocument("t.bin", Emulated(), summary, {}, {});
  EXPECT_THAT(TextOf(made), ::testing::StartsWith("t.bin: 12500 readings in 2.500 s, after 1.500 s "
                                                  "of waiting for the trigger\n"));
  EXPECT_EQ(Parsed(made)["duration_s"], 2.5);
  EXPECT_EQ(Parsed(made)["elapsed_s"], 3.9998);
  summary.triggers = 3;
  EXPECT_THAT(TextOf(RecordingDocument("t.bin", Emulated(), summary, {}, {})),
              HasSubstr("after 1.500 s of waiting for triggers\n"));
  // the trigger fired at the first row
  summary.elapsed_s = 12'499 / 5000.0;
  EXPECT_THAT(TextOf(RecordingDocument("t.bin", Emulated(), summary, {}, {})),
              ::testing::StartsWith("t.bin: 12500 readings in 2.500 s\n"));
  // one row has no length
  summary = {};
  summary.readings = 1;
  summary.elapsed_s = 0.2;
  const document::Document single = RecordingDocument("t.bin", Emulated(), summary, {}, {});
  EXPECT_THAT(TextOf(single), ::testing::StartsWith("t.bin: 1 reading\n"));
  EXPECT_TRUE(Parsed(single)["duration_s"].is_null());
}

TEST(RecordingDocument, ADoubtIsInTheAnswer) {
  acquire::Findings found;
  found.Doubt(acquire::FindingKind::kWireErrors, {{"errors", "1 timeout"}});
  EXPECT_THAT(TextOf(RecordingDocument("t.bin", Emulated(), Summary(), {}, found)),
              HasSubstr("  doubt: errors on the wire: 1 timeout\n"));
}

TEST(RecordingDocument, ATrialWithTheNameOfATableIsNoted) {
  for (const char* file :
       {"a.csv", "b.TXT", "c.tsv", "d.npy", "e.mat", "f.wav", "g.h5", "h.hdf5"}) {
    const std::string text = TextOf(RecordingDocument(file, Emulated(), Summary(), {}, {}));
    EXPECT_THAT(text, HasSubstr("note: the file is a trial, though its name ends in .")) << file;
    EXPECT_THAT(text, HasSubstr("haptometer trial export FILE -o OUT.csv")) << file;
  }
  for (const char* file : {"a.bin", "csv", "", "a.csv.bin", "d.csv/t.bin"}) {
    EXPECT_THAT(TextOf(RecordingDocument(file, Emulated(), Summary(), {}, {})),
                Not(HasSubstr("the file is a trial")))
        << file;
  }
}

TEST(RecordingDocument, ShowsAnInterruptionAndWhatIsNotKnown) {
  acquire::RecordingSummary summary = Summary();
  summary.interrupted = true;
  summary.lost = 7;
  const document::Document made = RecordingDocument("", Emulated(), summary, {}, {});
  EXPECT_THAT(TextOf(made), ::testing::StartsWith("nothing kept: 30005 readings"));
  EXPECT_THAT(TextOf(made), HasSubstr("data: emulated, interrupted\n"));
  EXPECT_THAT(TextOf(made), HasSubstr("lost to a slow disk  7\n"));
  const json document = Parsed(made);
  EXPECT_TRUE(document["file"].is_null() && document["time_uncertainty_s"].is_null());
  EXPECT_EQ(document["interrupted"], true);
}

}  // namespace
}  // namespace haptometer::tools
