// The texts of recordings: refused where a new one is not printable, escaped where an old one is
// read, whatever kind of file it comes from.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/text.h"
#include "tests/trial/trial_file.h"
#include "trial/export/export.h"
#include "trial/import/read_recording.h"
#include "trial/trial_format.h"
#include "trial/trial_writer.h"

namespace haptometer::trial {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

constexpr const char* kEvil = "x\n!touch PWNED\x1b[2J\u202e";
constexpr const char* kShown = "x\\n!touch PWNED\\x1b[2J\\u202e";

TrialHeader Header() {
  return {.rate_hz = 1000,
          .channels = {{.name = "distance", .role = ChannelRole::kDisplacement, .unit = "m"}}};
}

// every text of a header made evil
TrialHeader EvilHeader() {
  TrialHeader header = Header();
  header.channels[0].name = kEvil;
  header.channels[0].unit = kEvil;
  Metadata& metadata = header.metadata;
  metadata.source = metadata.sensor = metadata.head = metadata.hold = kEvil;
  metadata.laser_spot = metadata.utc_start = metadata.host = metadata.command_line = kEvil;
  metadata.labels = metadata.fields = {{kEvil, kEvil}};
  metadata.notes = {kEvil};
  return header;
}

void ExpectShown(const Metadata& metadata) {
  for (const std::string& text :
       {metadata.source, metadata.sensor, metadata.head, metadata.hold, metadata.laser_spot,
        metadata.utc_start, metadata.host, metadata.command_line}) {
    EXPECT_EQ(text, kShown);
  }
  EXPECT_THAT(metadata.labels, ElementsAre(Pair(kShown, kShown)));
  EXPECT_THAT(metadata.fields, ElementsAre(Pair(kShown, kShown)));
  EXPECT_THAT(metadata.notes, ElementsAre(kShown));
}

TEST(TrialTexts, ANewHeaderIsRefusedWhicheverTextIsNotPrintable) {
  const ScratchDirectory directory;
  const TrialHeader evil = EvilHeader();
  const std::vector<std::function<void(TrialHeader&)>> changes{
      [&](TrialHeader& h) { h.channels[0].name = kEvil; },
      [&](TrialHeader& h) { h.channels[0].unit = "V\xff"; },
      [&](TrialHeader& h) { h.metadata.source = evil.metadata.source; },
      [&](TrialHeader& h) { h.metadata.sensor = evil.metadata.sensor; },
      [&](TrialHeader& h) { h.metadata.head = evil.metadata.head; },
      [&](TrialHeader& h) { h.metadata.hold = evil.metadata.hold; },
      [&](TrialHeader& h) { h.metadata.laser_spot = evil.metadata.laser_spot; },
      [&](TrialHeader& h) { h.metadata.utc_start = evil.metadata.utc_start; },
      [&](TrialHeader& h) { h.metadata.host = evil.metadata.host; },
      [&](TrialHeader& h) { h.metadata.command_line = evil.metadata.command_line; },
      [&](TrialHeader& h) { h.metadata.labels["subject"] = "3\t"; },
      [&](TrialHeader& h) { h.metadata.labels[kEvil] = "3"; },
      [&](TrialHeader& h) { h.metadata.fields["field"] = "\r"; },
      [&](TrialHeader& h) { h.metadata.notes = {"fine", kEvil}; }};
  ManualClock clock;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    TrialHeader header = Header();
    changes[i](header);
    const std::string path = directory.File("t.bin");
    const auto refused = TrialWriter::Create(path, header, {}, clock);
    ASSERT_FALSE(refused) << i;
    EXPECT_EQ(refused.error().cause, Cause::kUsage) << i;
    EXPECT_TRUE(IsPrintable(refused.error().Text())) << i;
    EXPECT_FALSE(std::filesystem::exists(path)) << i;
  }
}

TEST(TrialTexts, ALabelGivenLaterIsRefused) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.bin");
  ManualClock clock;
  ASSERT_TRUE(TrialWriter::Create(path, Header(), {}, clock)->Finish());
  const auto bytes = std::filesystem::file_size(path);
  for (const Event& event :
       {Event{.kind = EventKind::kLabels, .labels = {{"subject", kEvil}}},
        Event{.kind = EventKind::kLabels, .labels = {{kEvil, "3"}}},
        Event{.kind = EventKind::kLabels, .text = kEvil, .labels = {{"subject", "3"}}}}) {
    const auto refused = AppendEvent(path, event);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().cause, Cause::kUsage);
  }
  EXPECT_EQ(std::filesystem::file_size(path), bytes);
}

TEST(TrialTexts, AnOldHeaderAndItsEventsAreReadEscaped) {
  const auto header = HeaderFromJson(HeaderToJson(EvilHeader()));
  ASSERT_TRUE(header);
  EXPECT_EQ(header->channels[0].name, kShown);
  EXPECT_EQ(header->channels[0].unit, kShown);
  ExpectShown(header->metadata);
  const auto labels =
      EventFromJson(R"({"event": "labels", "text": "a\nb", "labels": {"c\u001bd": "e\rf"}})");
  ASSERT_TRUE(labels);
  EXPECT_EQ(labels->text, "a\\nb");
  EXPECT_THAT(labels->labels, ElementsAre(Pair("c\\x1bd", "e\\rf")));
  const auto unknown = EventFromJson(R"({"event": "new\nkind", "text": "a\u0085b"})");
  ASSERT_TRUE(unknown);
  EXPECT_EQ(unknown->text, "new\\nkind: a\\u0085b");
}

// the same of a table, in whose lines a line end cannot be, and of a LabVIEW file
TEST(TrialTexts, AForeignFileIsReadEscaped) {
  const ScratchDirectory directory;
  const std::string table = directory.File("t.csv");
  std::ofstream(table) << std::string(600, '#') << "\n# source = a\x1b[31m\n# label.k\x07 = v\x7f\n"
                       << "# field\xc2\x9b = f\xe2\x80\xae\n# note = n\x08\n"
                       << "# channel.1.name = c\x1b\n"
                       << "time_s,voltage_v\n0,1\n0.001,2\n0.002,3\n";
  const auto recording = ReadRecording(table);
  ASSERT_TRUE(recording) << recording.error().Text();
  const Metadata& metadata = recording->record.metadata;
  EXPECT_EQ(metadata.source, "a\\x1b[31m");
  EXPECT_THAT(metadata.labels, ElementsAre(Pair("k\\x07", "v\\u007f")));
  EXPECT_THAT(metadata.fields, ElementsAre(Pair("field\\u009b", "f\\u202e")));
  EXPECT_THAT(metadata.notes, ::testing::Contains("n\\x08"));
  EXPECT_EQ(recording->record.channels[0].name, "c\\x1b");

  const std::string labview = directory.File("t.lvm");
  std::ofstream(labview) << "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\n"
                         << "X_Columns\tOne\n"
                         << "Description\t" << std::string(600, 'd') << "\x1b[2J\n"
                         << "***End_of_Header***\t\nChannels\t1\nY_Unit_Label\tm\x1bV\n"
                         << "***End_of_Header***\t\nX_Value\tna\x07me\tComment\n"
                         << "0\t1\t\n0.001\t2\thi\x1b\n0.002\t3\t\n";
  const auto measured = ReadRecording(labview);
  ASSERT_TRUE(measured) << measured.error().Text();
  EXPECT_EQ(measured->record.channels[0].name, "na\\x07me");
  EXPECT_EQ(measured->record.channels[0].unit, "m\\x1bV");
  for (const auto& [key, value] : measured->record.metadata.fields) {
    EXPECT_TRUE(IsPrintable(key) && IsPrintable(value)) << Printable(key);
  }
  for (const std::string& note : measured->record.metadata.notes) EXPECT_TRUE(IsPrintable(note));
}

// a record in memory may hold anything: its lines stay its lines
TEST(TrialTexts, AnExportedTableKeepsOneLineAText) {
  Record record;
  record.rows = 2;
  record.channels = {{.name = kEvil, .unit = "V", .values = {1, 2}, .statuses = {{}, {}}}};
  record.stretches = {{.rows = 2, .rate_hz = 10}};
  record.metadata.source = "a\nb";
  record.metadata.labels = {{"c\n# d", "e"}};
  std::string table;
  ASSERT_TRUE(WriteCsv(record, [&](std::string_view piece) {
    table += piece;
    return Result<void>{};
  }));
  EXPECT_THAT(table, HasSubstr("# source = a\\nb\n# label.c\\n# d = e\n"));
  EXPECT_THAT(table, HasSubstr(std::string("name = ") + kShown + "\n"));
}

}  // namespace
}  // namespace haptometer::trial
