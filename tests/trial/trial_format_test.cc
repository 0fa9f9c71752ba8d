// The JSON of a trial.bin: what is no header, what is assumed where a key is absent, and which text
// is refused.
#include "trial/trial_format.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "tests/trial/trial_file.h"

namespace haptometer::trial {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr const char* kChannel = R"({"name": "a", "role": "voltage", "encoding": "f64"})";

std::string Uniform(const std::string& rate, const std::string& channels) {
  return fmt::format(R"({{"timing": "uniform", "rate_hz": {}, "channels": [{}]}})", rate, channels);
}

std::string Repeated(const std::string& channel, int count) {
  std::string list = channel;
  for (int k = 1; k < count; ++k) list += ", " + channel;
  return list;
}

TEST(TrialHeader, AUniformOneNeedsARate) {
  EXPECT_TRUE(HeaderFromJson(Uniform("1e-3", kChannel)));
  for (const char* rate : {"0", "-1", "null", "\"1000\""}) {
    EXPECT_FALSE(HeaderFromJson(Uniform(rate, kChannel))) << rate;
  }
  // the others have a time in each row
  for (const char* timing : {"arrival", "polled"}) {
    EXPECT_TRUE(
        HeaderFromJson(fmt::format(R"({{"timing": "{}", "channels": [{}]}})", timing, kChannel)));
  }
}

TEST(TrialHeader, HasOneTo1024Channels) {
  EXPECT_FALSE(HeaderFromJson(Uniform("10", "")));
  EXPECT_TRUE(HeaderFromJson(Uniform("10", kChannel)));
  EXPECT_EQ(HeaderFromJson(Uniform("10", Repeated(kChannel, 1024)))->channels.size(), 1024U);
  EXPECT_FALSE(HeaderFromJson(Uniform("10", Repeated(kChannel, 1025))));
}

TEST(TrialHeader, OfUnknownWordsOrNumbersIsNone) {
  EXPECT_FALSE(HeaderFromJson("{}"));
  EXPECT_FALSE(HeaderFromJson(R"({"timing": "guessed", "channels": []})"));
  for (const char* channel :
       {R"({"role": "voltage", "encoding": "f16"})", R"({"role": "angle", "encoding": "f64"})",
        R"({"role": "voltage"})", R"({"encoding": "f64"})",
        R"({"role": "voltage", "encoding": "f64", "scale": "1"})",
        R"({"role": "voltage", "encoding": "f64", "offset": 1e999})"}) {
    EXPECT_FALSE(HeaderFromJson(Uniform("10", channel))) << channel;
  }
}

TEST(TrialHeader, AChannelWithoutNumbersHasItsValuesAsTheyStand) {
  const auto header = HeaderFromJson(Uniform("10", kChannel));
  ASSERT_TRUE(header);
  const ChannelFormat& channel = header->channels.at(0);
  EXPECT_EQ(channel.scale, 1);
  EXPECT_EQ(channel.offset, 0);
  EXPECT_EQ(channel.range_min, -kInfinity);
  EXPECT_EQ(channel.range_max, kInfinity);
  EXPECT_EQ(channel.resolution, 0);
  EXPECT_EQ(header->metadata.tare_m, 0);
  EXPECT_EQ(header->metadata.averages, std::nullopt);
}

// numbers that differ, so that none stands for another
TEST(TrialHeader, EveryNumberComesBack) {
  TrialHeader header;
  header.rate_hz = 1.5;
  header.channels = {{.role = ChannelRole::kCurrent,
                      .encoding = Encoding::kF32,
                      .scale = 2.5,
                      .offset = -3.5,
                      .range_min = -4.5,
                      .range_max = 5.5,
                      .resolution = 6.5}};
  header.metadata.sampling_s = 7.5;
  header.metadata.averages = 8;
  header.metadata.nominal_rate_hz = 9.5;
  header.metadata.drive_frequency_hz = 10.5;
  header.metadata.drive_amplitude_v = 11.5;
  header.metadata.tare_m = 12.5;
  const auto back = HeaderFromJson(HeaderToJson(header));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->timing, Timing::kUniform);
  EXPECT_EQ(back->rate_hz, 1.5);
  const ChannelFormat& channel = back->channels.at(0);
  EXPECT_EQ(channel.role, ChannelRole::kCurrent);
  EXPECT_EQ(channel.encoding, Encoding::kF32);
  EXPECT_EQ(channel.scale, 2.5);
  EXPECT_EQ(channel.offset, -3.5);
  EXPECT_EQ(channel.range_min, -4.5);
  EXPECT_EQ(channel.range_max, 5.5);
  EXPECT_EQ(channel.resolution, 6.5);
  EXPECT_EQ(back->metadata.sampling_s, 7.5);
  EXPECT_EQ(back->metadata.averages, 8);
  EXPECT_EQ(back->metadata.nominal_rate_hz, 9.5);
  EXPECT_EQ(back->metadata.drive_frequency_hz, 10.5);
  EXPECT_EQ(back->metadata.drive_amplitude_v, 11.5);
  EXPECT_EQ(back->metadata.tare_m, 12.5);
  // and again as a channel of a record
  const Channel empty = ChannelOf(channel);
  EXPECT_EQ(empty.range_min, -4.5);
  EXPECT_EQ(empty.range_max, 5.5);
  EXPECT_EQ(empty.resolution, 6.5);
}

TEST(TrialHeader, OfARecordHasTheRateOfItsLongestStretch) {
  Record record;
  record.rows = 12;
  record.stretches = {{.first_row = 0, .rows = 4, .rate_hz = 9},
                      {.first_row = 4, .rows = 5, .rate_hz = 7},
                      {.first_row = 9, .rows = 3, .rate_hz = 11}};
  EXPECT_EQ(HeaderOf(record).rate_hz, 7);
  EXPECT_EQ(HeaderOf(Record{}).rate_hz, 0) << "of no rows";
}

// null is what is not known, as an absent key is
TEST(TrialHeader, NullsAreTakenAsAbsentKeys) {
  std::string channel = kChannel;
  for (const char* key : {"unit", "scale", "offset", "range_min", "range_max", "resolution"}) {
    channel.insert(1, fmt::format("\"{}\": null, ", key));
  }
  std::string json = Uniform("10", channel);
  for (const char* key :
       {"source", "sensor", "head", "sampling_s", "averages", "hold", "nominal_rate_hz",
        "laser_spot", "drive_frequency_hz", "drive_amplitude_v", "tare_m", "utc_start", "host",
        "command_line", "labels", "fields", "notes"}) {
    json.insert(1, fmt::format("\"{}\": null, ", key));
  }
  const auto with_nulls = HeaderFromJson(json);
  const auto without = HeaderFromJson(Uniform("10", kChannel));
  ASSERT_TRUE(with_nulls && without);
  EXPECT_EQ(HeaderToJson(*with_nulls), HeaderToJson(*without));
  EXPECT_EQ(without->metadata.sampling_s, std::nullopt);
  EXPECT_EQ(without->metadata.drive_amplitude_v, std::nullopt);
  EXPECT_TRUE(without->metadata.labels.empty() && without->metadata.notes.empty());
}

// the first displacement in metres, of a header and of a record
TEST(TrialHeader, ARecordingIsAboutItsFirstDisplacementInMetres) {
  TrialHeader header;
  Record record;
  EXPECT_EQ(DisplacementChannel(header), std::nullopt);
  EXPECT_EQ(DisplacementChannel(record), std::nullopt);
  struct Case {
    ChannelRole role;
    const char* unit;
    std::optional<std::size_t> about;
  };
  for (const Case& next :
       {Case{ChannelRole::kVoltage, "m", {}}, Case{ChannelRole::kDisplacement, "V", {}},
        Case{ChannelRole::kDisplacement, "m", 2}, Case{ChannelRole::kDisplacement, "m", 2}}) {
    header.channels.push_back({.role = next.role, .unit = next.unit});
    record.channels.push_back({.role = next.role, .unit = next.unit});
    EXPECT_EQ(DisplacementChannel(header), next.about);
    EXPECT_EQ(DisplacementChannel(record), next.about);
  }
  EXPECT_EQ(record.Find(ChannelRole::kDisplacement), &record.channels[1]);
  EXPECT_EQ(record.Find(ChannelRole::kCurrent), nullptr);
}

TEST(TrialHeader, ATextThatIsNotPrintableIsNamedByItsChannel) {
  TrialHeader header;
  header.channels = {{.name = "a", .unit = "V"}, {.name = "b", .unit = "V"}, {.name = "c"}};
  EXPECT_TRUE(CheckTexts(header));
  header.channels[2].unit = "\x1b";
  EXPECT_EQ(CheckTexts(header).error().where, "the unit of channel 3");
  header.channels[1].name = "\x1b";
  EXPECT_EQ(CheckTexts(header).error().where, "the name of channel 2");
}

TEST(TrialEvent, TellsNoLossFromOneOfUnknownSize) {
  const auto none = EventFromJson(R"({"event": "remark", "row": 3})");
  ASSERT_TRUE(none);
  EXPECT_FALSE(none->missing);
  EXPECT_FALSE(none->BeginsStretch());
  const auto unknown = EventFromJson(R"({"event": "remark", "row": 3, "missing": null})");
  ASSERT_TRUE(unknown && unknown->missing);
  EXPECT_EQ(*unknown->missing, std::nullopt);
  EXPECT_TRUE(unknown->BeginsStretch());
  EXPECT_EQ(**EventFromJson(R"({"event": "gap", "missing": 7})")->missing, 7U);
  // gaps and reconnects of older files carry no number
  for (const char* kind : {"gap", "reconnect"}) {
    const auto event = EventFromJson(fmt::format(R"({{"event": "{}"}})", kind));
    ASSERT_TRUE(event) << kind;
    EXPECT_TRUE(event->BeginsStretch()) << kind;
  }
}

TEST(TrialEvent, AnInfiniteRateComesBack) {
  const Stretch stretch{.first_row = 2, .rows = 3, .start_s = 0.5, .rate_hz = kInfinity};
  const auto back =
      EventFromJson(EventToJson({.kind = EventKind::kTimeBase, .row = 5, .stretch = stretch}));
  ASSERT_TRUE(back && back->stretch);
  EXPECT_EQ(back->row, 5U);
  EXPECT_EQ(back->stretch->first_row, 2U);
  EXPECT_EQ(back->stretch->rows, 3U);
  EXPECT_EQ(back->stretch->start_s, 0.5);
  EXPECT_EQ(back->stretch->rate_hz, kInfinity);
  EXPECT_EQ(back->stretch->time_uncertainty_s, 0);
}

TEST(RawValue, IsTheNumberOfItsEncoding) {
  EXPECT_EQ(RawValue::Counts(-7).Number(Encoding::kI32), -7);
  EXPECT_EQ(RawValue::F32(-0.375F).Number(Encoding::kF32), -0.375);
  EXPECT_EQ(RawValue::F64(-1e-300).Number(Encoding::kF64), -1e-300);
  EXPECT_EQ(BytesOf(Encoding::kI32), 4U);
  EXPECT_EQ(BytesOf(Encoding::kF32), 4U);
  EXPECT_EQ(BytesOf(Encoding::kF64), 8U);
}

TEST(DisplacementCounts, AreWholeStepsInMetres) {
  const ChannelFormat format = DisplacementCounts("head 1", 1e-6);
  EXPECT_EQ(format.name, "head 1");
  EXPECT_EQ(format.role, ChannelRole::kDisplacement);
  EXPECT_EQ(format.unit, "m");
  EXPECT_EQ(format.encoding, Encoding::kI32);
  EXPECT_EQ(format.scale, 1e-6);
  EXPECT_EQ(format.offset, 0);
  EXPECT_EQ(format.resolution, 1e-6);
}

// the closing block counts the values of all channels by status
TEST(TrialTotals, AreWrittenByTheNamesOfTheStatuses) {
  TrialTotals totals;
  totals.rows = 45;
  for (std::size_t k = 0; k < kSampleStatusCount; ++k) totals.statuses[k] = k + 1;
  EXPECT_EQ(TotalsToJson(totals),
            R"({"rows":45,"statuses":{"ok":1,"repeated":2,"over":3,"under":4,"invalid":5,)"
            R"("device_error":6,"late":7,"clipped":8,"bad_frame":9}})");
}

}  // namespace
}  // namespace haptometer::trial
