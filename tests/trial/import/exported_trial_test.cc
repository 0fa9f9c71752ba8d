// The objects of an exported trial, whatever kind of file they lie in.
#include "trial/import/exported_trial.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "trial/export/object_names.h"
#include "trial/trial_format.h"

namespace haptometer::trial {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kColumn = "displacement_m";

// four rows at 0, 0.5, 2, 2.5 s
ObjectsInMemory Objects() {
  TrialHeader header;
  header.rate_hz = 2;
  ChannelFormat channel;
  channel.name = "laser";
  channel.role = ChannelRole::kDisplacement;
  channel.unit = "m";
  header.channels.push_back(channel);
  ObjectsInMemory objects("f");
  objects.texts[objects::kHeader] = HeaderToJson(header);
  objects.numbers[objects::kTimes] = {0, 0.5, 2, 2.5};
  objects.numbers[objects::kStretches] = {0, 2, 0, 2, 0, 2, 2, 2, 2, 0.125};
  objects.numbers[kColumn] = {1, 2, 3, 4};
  objects.bytes[objects::StatusName(kColumn)] = {0, 1, 0, 0};
  return objects;
}

Recording Parsed(ObjectsInMemory objects) {
  auto recording = ReadExportedTrial(objects, FileKind::kNpy);
  EXPECT_TRUE(recording) << recording.error().Text();
  return recording ? std::move(*recording) : Recording{};
}

std::string ErrorOf(ObjectsInMemory objects) {
  const auto recording = ReadExportedTrial(objects, FileKind::kNpy);
  return recording ? "was read" : recording.error().Text();
}

TEST(ExportedTrial, HoldsStretchesValuesAndStatuses) {
  const Recording read = Parsed(Objects());
  const Record& record = read.record;
  EXPECT_EQ(record.rows, 4U);
  ASSERT_EQ(record.stretches.size(), 2U);
  EXPECT_EQ(record.stretches[1].first_row, 2U);
  EXPECT_EQ(record.stretches[1].rows, 2U);
  EXPECT_EQ(record.stretches[1].start_s, 2);
  EXPECT_EQ(record.stretches[1].rate_hz, 2);
  EXPECT_EQ(record.stretches[1].time_uncertainty_s, 0.125);
  EXPECT_THAT(record.channels.at(0).values, ElementsAre(1, 2, 3, 4));
  EXPECT_EQ(record.channels[0].statuses[1], SampleStatus::kRepeated);
  EXPECT_TRUE(read.report.is_export);
  EXPECT_FALSE(read.report.closed);
  EXPECT_EQ(read.report.rows, 4U);
  EXPECT_EQ(read.report.next_row, 4U);
}

TEST(ExportedTrial, EachLineIsAnEventOrARemark) {
  ObjectsInMemory objects = Objects();
  const auto event = [](const char* text) {
    Event made;
    made.text = text;
    return EventToJson(made) + "\n";
  };
  objects.texts[objects::kEvents] = event("one") + "\n" + event("two") + event("three");
  objects.texts[objects::kRemarks] = "first\nsecond\n\nthird";
  objects.bytes[objects::kClosed] = {1};
  const ReadReport report = Parsed(std::move(objects)).report;
  EXPECT_TRUE(report.closed);
  ASSERT_EQ(report.events.size(), 3U);
  EXPECT_EQ(report.events[0].text, "one");
  EXPECT_EQ(report.events[1].text, "two");
  EXPECT_EQ(report.events[2].text, "three");
  std::vector<std::string> remarks;
  for (const Finding& finding : report.findings.list()) {
    EXPECT_EQ(finding.kind, FindingKind::kNotedAtExport);
    remarks.push_back(std::get<std::string>(finding.numbers.at(0).value));
  }
  EXPECT_THAT(remarks, ElementsAre("first", "second", "third"));
  ObjectsInMemory damaged = Objects();
  damaged.texts[objects::kEvents] = event("one") + "{}\n";
  EXPECT_THAT(ErrorOf(std::move(damaged)), HasSubstr("its events_json hold a line that is none"));
}

TEST(ExportedTrial, StretchesCoverTheRowsInOrder) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const std::vector<std::vector<double>> bad{{},
                                             {0, 3, 0, 2, 0},
                                             {0, 5, 0, 2, 0},
                                             {1, 3, 0, 2, 0},
                                             {0, 2, 0, 2, 0, 1, 3, 2, 2, 0},
                                             {0, 2, 0, 2, 0, 3, 1, 2, 2, 0},
                                             {0, 2, 0, 2, 0, 2, 3, 2, 2, 0},
                                             {0, 4, 0, 2, 0, 4, 0, 9, 2, 0},
                                             {0, 4, kInf, 2, 0},
                                             {0, 4, 0, 0, 0},
                                             {0, 4, 0, -2, 0},
                                             {-1, 4, 0, 2, 0},
                                             {0, -4, 0, 2, 0},
                                             {0, 1e300, 0, 2, 0},
                                             {1e300, 4, 0, 2, 0}};
  for (const std::vector<double>& numbers : bad) {
    ObjectsInMemory objects = Objects();
    objects.numbers[objects::kStretches] = numbers;
    EXPECT_THAT(ErrorOf(std::move(objects)), HasSubstr("its stretches do not describe its rows"))
        << ::testing::PrintToString(numbers);
  }
  ObjectsInMemory objects = Objects();
  objects.numbers[objects::kStretches] = {0, 4, 0, 2};
  EXPECT_THAT(ErrorOf(std::move(objects)), HasSubstr("its stretches has another shape"));
}

TEST(ExportedTrial, StatusesAreThoseThatThereAre) {
  ObjectsInMemory objects = Objects();
  objects.bytes[objects::StatusName(kColumn)] = {8, 2, 0, 0};
  const Record record = Parsed(std::move(objects)).record;
  EXPECT_EQ(record.channels.at(0).statuses[0], SampleStatus::kBadFrame);
  EXPECT_TRUE(std::isnan(record.channels[0].values[0]));
  EXPECT_TRUE(std::isnan(record.channels[0].values[1]));
  EXPECT_EQ(record.channels[0].values[2], 3);
  ObjectsInMemory other = Objects();
  other.bytes[objects::StatusName(kColumn)] = {9, 0, 0, 0};
  EXPECT_THAT(ErrorOf(std::move(other)), HasSubstr("its displacement_m_status is none"));
}

TEST(ExportedTrial, EachObjectHasOneNumberARow) {
  for (const std::size_t length : {std::size_t{3}, std::size_t{5}}) {
    ObjectsInMemory values = Objects();
    values.numbers[kColumn].resize(length);
    EXPECT_THAT(ErrorOf(std::move(values)), HasSubstr("its displacement_m has another length"));
    ObjectsInMemory statuses = Objects();
    statuses.bytes[objects::StatusName(kColumn)].resize(length);
    EXPECT_THAT(ErrorOf(std::move(statuses)),
                HasSubstr("its displacement_m_status has another length"));
    ObjectsInMemory arrivals = Objects();
    arrivals.numbers[objects::kArrivalTimes].resize(length);
    EXPECT_THAT(ErrorOf(std::move(arrivals)), HasSubstr("its arrival_s has another length"));
  }
  for (const char* missing : {objects::kTimes, objects::kStretches, kColumn}) {
    ObjectsInMemory objects = Objects();
    objects.numbers.erase(missing);
    EXPECT_THAT(ErrorOf(std::move(objects)), HasSubstr(fmt::format("its {} is missing", missing)));
  }
}

TEST(ExportedTrial, TimesOfArrivalHaveTwoNames) {
  for (const char* name : {objects::kArrivalTimes, objects::kFormerArrivalTimes}) {
    ObjectsInMemory objects = Objects();
    objects.numbers[name] = {1, 1, 3, 2};
    EXPECT_THAT(Parsed(std::move(objects)).record.raw_times_s, ElementsAre(1, 1, 3, 2)) << name;
  }
}

TEST(ExportedTrial, TimesThatAreKnownDoNotFall) {
  const auto with_times = [](const std::vector<double>& times_s) {
    ObjectsInMemory objects = Objects();
    objects.bytes[objects::kTimesAreKnown] = {1};
    objects.numbers[objects::kTimes] = times_s;
    return objects;
  };
  const Record record = Parsed(with_times({0, 0.25, 0.25, 7})).record;
  EXPECT_TRUE(record.times_are_known);
  EXPECT_THAT(record.raw_times_s, ElementsAre(0, 0.25, 0.25, 7));
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (const auto& times_s : {std::vector<double>{0, 0.5, 0.25, 7}, {0, 0.25, 0.5, kInf}}) {
    EXPECT_THAT(ErrorOf(with_times(times_s)), HasSubstr("its time_s do not grow"));
  }
}

TEST(ExportedTrial, AnObjectOfAnotherTypeIsMissing) {
  const auto error_of = [](const auto& change) {
    ObjectsInMemory objects = Objects();
    change(objects);
    return ErrorOf(std::move(objects));
  };
  EXPECT_EQ(error_of([](auto& o) { o.texts.erase(objects::kHeader); }),
            "f: its header_json is missing, or is of another type; export the trial again with "
            "haptometer trial export");
  EXPECT_THAT(error_of([](auto& o) { o.texts[objects::kHeader] = "{}"; }),
              HasSubstr("f: its header_json is not a trial's header"));
  EXPECT_THAT(error_of([](auto& o) { o.bytes.erase(objects::StatusName(kColumn)); }),
              HasSubstr("its displacement_m_status is missing, or is of another type"));
  // what is there in another type is not passed over
  EXPECT_THAT(error_of([](auto& o) { o.bytes[objects::kArrivalTimes] = {0, 1, 2, 3}; }),
              HasSubstr("its arrival_s is missing, or is of another type"));
  EXPECT_THAT(error_of([](auto& o) { o.texts[objects::kArrivalTimes] = "0"; }),
              HasSubstr("its arrival_s is missing, or is of another type"));
  EXPECT_THAT(error_of([](auto& o) { o.numbers[objects::kEvents] = {1}; }),
              HasSubstr("its events_json is missing, or is of another type"));
}

TEST(ExportedTrial, AFlagIsOneByteThatIsNotZero) {
  using Bytes = std::vector<std::uint8_t>;
  for (const auto& [bytes, is_set] : {std::pair{Bytes{1}, true},
                                      {Bytes{2}, true},
                                      {Bytes{0}, false},
                                      {Bytes{1, 1}, false},
                                      {Bytes{}, false}}) {
    ObjectsInMemory objects = Objects();
    objects.bytes[objects::kClosed] = bytes;
    EXPECT_EQ(Parsed(std::move(objects)).report.closed, is_set) << ::testing::PrintToString(bytes);
  }
}

// --- descriptions --------------------------------------------------------------------------------

std::string Description(const std::string& stretches, const std::string& more = "") {
  return fmt::format(R"({{"header":{{"a":1}},"stretches":{},"closed":true,"times_are_known":false,)"
                     R"("events":[{{"b":2}},{{}}],"remarks":["one","two"]{}}})",
                     stretches, more);
}

TEST(Descriptions, HoldTheObjectsOfATrial) {
  ObjectsInMemory objects("f");
  ASSERT_TRUE(AddDescription(
      Description("[[0,2,-1,null,0.5],[2,1,0,4,0]]", R"(,"sample_offsets":[0.25,-3])"), &objects));
  EXPECT_EQ(objects.texts[objects::kHeader], R"({"a":1})");
  EXPECT_EQ(objects.texts[objects::kEvents], "{\"b\":2}\n{}\n");
  EXPECT_EQ(objects.texts[objects::kRemarks], "one\ntwo\n");
  // JSON has no infinity, and this program writes null for it
  EXPECT_THAT(objects.numbers[objects::kStretches],
              ElementsAre(0, 2, -1, std::numeric_limits<double>::infinity(), 0.5, 2, 1, 0, 4, 0));
  EXPECT_THAT(objects.numbers[kSampleOffsets], ElementsAre(0.25, -3));
  EXPECT_TRUE(objects.Flag(objects::kClosed));
  EXPECT_FALSE(objects.Flag(objects::kTimesAreKnown));
  ObjectsInMemory without("f");
  ASSERT_TRUE(AddDescription(Description("[]"), &without));
  EXPECT_TRUE(without.numbers[kSampleOffsets].empty());
  EXPECT_TRUE(without.numbers[objects::kStretches].empty());
}

TEST(Descriptions, ThatAreNoneAreDamaged) {
  for (const std::string& text :
       {std::string("{}"), std::string("[1"), Description("[[0,\"2\",0,4,0]]"),
        Description("[]", R"(,"sample_offsets":[true])")}) {
    ObjectsInMemory objects("f");
    const auto added = AddDescription(text, &objects);
    ASSERT_FALSE(added) << text;
    EXPECT_EQ(added.error().Text(),
              "f: its description is damaged; export the trial again with haptometer trial export");
  }
}

// a number in 14 lists in the header lies 16 levels deep
TEST(Descriptions, WhatLiesDeeperThanSixteenLevelsIsLeftOut) {
  const auto header = [](std::size_t lists) {
    const std::string json = fmt::format(
        R"({{"header":{{"a":{}7{}}},"stretches":[],"closed":true,"times_are_known":false,)"
        R"("events":[],"remarks":[]}})",
        std::string(lists, '['), std::string(lists, ']'));
    ObjectsInMemory objects("f");
    EXPECT_TRUE(AddDescription(json, &objects));
    return objects.texts[objects::kHeader];
  };
  EXPECT_THAT(header(14), HasSubstr("[7]"));
  EXPECT_THAT(header(15), HasSubstr("[[]]"));
}

}  // namespace
}  // namespace haptometer::trial
