// A DL-RS1A on a scripted wire and a manual clock: every way in which a reply can come, or not.
#include "acquire/sensor/keyence/keyence_il.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/acquire/scripted_il_unit.h"
#include "tests/findings.h"
#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

using tests::NumbersOf;

using ::testing::HasSubstr;
using trial::SampleStatus;

TEST_F(KeyenceIlTest, OneRowPerPollWithItsTwoTimes) {
  Started();
  for (int i = 0; i < 5; ++i) {
    const Reading reading = NextRow();
    EXPECT_EQ(Counts(reading), 2 + i);
    EXPECT_EQ(reading.time_ns - begin_ns_, 8 * kMs * i);
    EXPECT_EQ(reading.reply_ns - reading.time_ns, 8 * kMs);
  }
}

TEST_F(KeyenceIlTest, AReplyInSinglePiecesIsOneReading) {
  Started();
  std::vector<ScriptedIlUnit::Answer> pieces;
  pieces.reserve(12);
  const std::string line = "M0,-00.007\r\n";
  for (std::size_t i = 0; i < line.size(); ++i) {
    pieces.push_back({line.substr(i, 1), 8 * kMs + static_cast<MonotonicNs>(i) * kMs});
  }
  unit_.to_m0.push_back(pieces);
  const Reading reading = NextRow();
  EXPECT_EQ(Counts(reading), -7);
  EXPECT_EQ(reading.reply_ns - reading.time_ns, 19 * kMs);
}

TEST_F(KeyenceIlTest, SpecialValuesAreStatuses) {
  Started();
  for (const char* value : {"+99.999", "-99.999", "-99.998", "+EE.EEE"}) {
    unit_.to_m0.push_back({{std::string("M0,") + value + "\r\n"}});
  }
  EXPECT_EQ(NextStatus(), SampleStatus::kOver);
  EXPECT_EQ(NextStatus(), SampleStatus::kUnder);
  EXPECT_EQ(NextStatus(), SampleStatus::kInvalid);
  EXPECT_EQ(NextStatus(), SampleStatus::kDeviceError);
  ExpectSoundFrom(2);
}

TEST_F(KeyenceIlTest, AnErrorReplyIsARow) {
  Started();
  unit_.to_m0.push_back({{"ER,M0,29\r\n"}});
  EXPECT_EQ(NextStatus(), SampleStatus::kDeviceError);
  ExpectSoundFrom(2);
}

TEST_F(KeyenceIlTest, EachAmplifierIsAChannel) {
  unit_.to_m0.push_back({{"M0,-00.007,+00.018\r\n"}});
  const trial::TrialHeader& header = Started().header();
  ASSERT_EQ(header.channels.size(), 2U);
  EXPECT_EQ(header.channels[1].name, "displacement_01");
  unit_.to_m0.push_back({{"M0,-00.008,-99.998\r\n"}});
  const Reading reading = NextRow();
  ASSERT_EQ(reading.samples.size(), 2U);
  EXPECT_EQ(reading.samples[0].status, SampleStatus::kOk);
  EXPECT_EQ(reading.samples[1].status, SampleStatus::kInvalid);
  EXPECT_EQ(RowStatus(reading), SampleStatus::kInvalid);
}

TEST_F(KeyenceIlTest, ALateReplyIsNeverTakenForTheNext) {
  // whenever it comes, before or after the maker's second, and however short the patience is by
  // then
  for (const int known : {0, 64}) {
    for (const MonotonicNs late_ns : {300 * kMs, 999 * kMs, 1003 * kMs, 1500 * kMs, 2600 * kMs}) {
      SCOPED_TRACE(late_ns);
      unit_.next_um = 1;
      clock_.Advance(10 * kNsPerS);
      ScriptedIlUnit fresh(clock_);
      fresh.settings = {{"195", "1"}};
      sensor_ = std::make_unique<KeyenceIl>(
          fresh.TakeTransport(), KeyenceIlSetup{.baud = 38400, .refresh_ns = std::nullopt}, clock_);
      ASSERT_TRUE(sensor_->Start(kNeverStop));
      (void)sensor_->Begin();
      for (int i = 0; i < known; ++i) ExpectSoundFrom(2 + i);
      fresh.to_m0.push_back({{"M0,+77.777\r\n", late_ns}});
      Reading reading = NextRow();
      if (known == 0 && late_ns < kNsPerS) {  // in time: the unit is not known yet
        EXPECT_EQ(Counts(reading), 77'777);
        continue;
      }
      while (RowStatus(reading) == SampleStatus::kLate) reading = NextRow();
      // in step from the first reading on: its own number, within its own 8 ms (16 ms where the
      // unit had two MS to answer first)
      for (int i = 0; i < 5; ++i) {
        EXPECT_EQ(Counts(reading), 2 + known + i);
        EXPECT_EQ(reading.reply_ns - reading.time_ns,
                  (i == 0 && late_ns > 2 * kNsPerS ? 16 : 8) * kMs);
        reading = NextRow();
      }
    }
  }
}

TEST_F(KeyenceIlTest, AfterTheAdaptiveDeadlineTheLateReplyIsWaitedForAndThrownAway) {
  Started();
  for (int i = 0; i < 64; ++i) ExpectSoundFrom(2 + i);  // now 50 ms are allowed
  const std::uint64_t discarded = sensor_->discarded_bytes();
  unit_.to_m0.push_back({{"M0,+77.777\r\n", 300 * kMs}});
  const Reading late = NextRow();
  EXPECT_EQ(RowStatus(late), SampleStatus::kLate);
  EXPECT_EQ(late.reply_ns - late.time_ns, 50 * kMs);
  const Reading next = NextRow();
  EXPECT_EQ(Counts(next), 66);
  // the late reply, 20 ms of silence, MS and its reply
  EXPECT_EQ(next.time_ns - late.time_ns, (300 + 20 + 8) * kMs);
  EXPECT_EQ(sensor_->discarded_bytes() - discarded, 10U);
}

TEST_F(KeyenceIlTest, ALostReplyCostsTheMakersSecond) {
  Started();
  for (int i = 0; i < 64; ++i) ExpectSoundFrom(2 + i);
  unit_.to_m0.push_back({});
  const Reading lost = NextRow();
  EXPECT_EQ(RowStatus(lost), SampleStatus::kLate);
  const Reading next = NextRow();
  EXPECT_EQ(Counts(next), 66);
  EXPECT_EQ(next.time_ns - lost.time_ns, kNsPerS + 8 * kMs);
}

TEST_F(KeyenceIlTest, ARefusedMsBringsItInStepToo) {
  Started();
  unit_.to_ms = "ER,MS,00\r\n";
  unit_.to_m0.push_back({});
  EXPECT_EQ(NextStatus(), SampleStatus::kLate);
  ExpectSoundFrom(2);
}

TEST_F(KeyenceIlTest, AUnitThatNeverAnswersMsIsAskedM0Again) {
  Started();
  unit_.to_ms = "";
  unit_.to_m0.push_back({});
  for (int i = 0; i < 3; ++i) EXPECT_EQ(NextStatus(), SampleStatus::kLate) << i;
  ExpectSoundFrom(2);
}

TEST_F(KeyenceIlTest, ASilentUnitGivesALateRowASecondAndIsHeardWhenItIsBack) {
  Started();
  unit_.is_silent = true;
  Reading reading;
  for (int i = 0; i < 5; ++i) {
    reading = NextRow();
    EXPECT_EQ(RowStatus(reading), SampleStatus::kLate);
  }
  EXPECT_LE(reading.time_ns - begin_ns_, 4 * kNsPerS + 200 * kMs);
  unit_.is_silent = false;
  do reading = NextRow();
  while (RowStatus(reading) == SampleStatus::kLate);
  EXPECT_EQ(Counts(reading), 2);
}

TEST_F(KeyenceIlTest, ATruncatedReplyIsABadFrameAndSpoilsNoOther) {
  Started();
  unit_.to_m0.push_back({{"M0,-00."}});
  EXPECT_EQ(NextStatus(), SampleStatus::kBadFrame);
  ExpectSoundFrom(2);
}

TEST_F(KeyenceIlTest, MergedAndGarbledLinesAreBadFrames) {
  Started();
  for (const std::string& bytes :
       {std::string("M0,+00.0M0,+00.002\r\n"), std::string("\x81\x02\xFF\x00garbage\r\n", 13),
        std::string(500, 'x') + "\r\n", std::string("M0,+000.02\r\n"),
        std::string("M0,+00.001,+00.002\r\n"), std::string("SR,00,195,1\r\n")}) {
    unit_.to_m0.push_back({{bytes}});
  }
  for (int i = 0; i < 6; ++i) EXPECT_EQ(NextStatus(), SampleStatus::kBadFrame) << i;
  ExpectSoundFrom(2);
}

TEST_F(KeyenceIlTest, WhatFollowsDamagedBytesIsNotTakenForTheNextReply) {
  Started();
  // noise that looks like a line, and the reply itself long after it
  unit_.to_m0.push_back({{"\x01\x02\r\n", 8 * kMs}, {"M0,+77.777\r\n", 230 * kMs}});
  EXPECT_EQ(NextStatus(), SampleStatus::kBadFrame);
  ExpectSoundFrom(2);
}

TEST_F(KeyenceIlTest, ALineThatNeverFallsSilentGivesABadRowASecond) {
  Started();
  ExpectSoundFrom(2);
  std::vector<ScriptedIlUnit::Answer> babble;
  for (int i = 0; i < 500; ++i) babble.push_back({"?\r\n", 10 * kMs * i});
  unit_.to_m0.push_back(babble);
  int bad = 0;
  Reading reading = NextRow();
  for (; RowStatus(reading) == SampleStatus::kBadFrame; reading = NextRow()) ++bad;
  EXPECT_GE(bad, 4) << "5 s of it";
  EXPECT_LE(bad, 6);
  EXPECT_EQ(Counts(reading), 3) << "and then the unit is heard again";
}

TEST_F(KeyenceIlTest, BadRowsOfABabblingLineAreASecondAnd20MsApart) {
  Started();
  std::vector<ScriptedIlUnit::Answer> babble;
  for (int i = 0; i < 3000; ++i) babble.push_back({"?\r\n", 2 * kMs * i});
  unit_.to_m0.push_back(babble);
  MonotonicNs last_ns = NextRow().reply_ns;
  for (int row = 0; row < 3; ++row) {
    const Reading reading = NextRow();
    EXPECT_EQ(RowStatus(reading), SampleStatus::kBadFrame);
    EXPECT_EQ(reading.reply_ns - last_ns, 1022 * kMs) << "the first line behind 1020 ms";
    last_ns = reading.reply_ns;
  }
}

TEST_F(KeyenceIlTest, AHardwareTriggersLineIsNoReply) {
  Started();
  unit_.to_m0.push_back({{"DR,04,+77.777\r\n", 4 * kMs}, {"M0,-00.007\r\n", 9 * kMs}});
  EXPECT_EQ(Counts(NextRow()), -7);
}

TEST_F(KeyenceIlTest, AHangUpEndsIt) {
  Started();
  unit_.wire->HangUp(20 * kMs);
  Reading reading;
  Outcome outcome = Outcome::kNothing;
  for (int call = 0; call < 10 && outcome != Outcome::kGone; ++call)
    outcome = sensor_->Next(reading);
  EXPECT_EQ(outcome, Outcome::kGone);
}

TEST_F(KeyenceIlTest, NextNeverHoldsUpTheStopFlag) {
  Started();
  unit_.is_silent = true;
  Reading reading;
  for (int call = 0; call < 30; ++call) {
    const MonotonicNs before = clock_.Now();
    (void)sensor_->Next(reading);
    EXPECT_LE(clock_.Now() - before, 100 * kMs);
  }
}

TEST_F(KeyenceIlTest, RepeatedReadingsAreMarkedInTheRow) {
  Started({.baud = 38400, .refresh_ns = 20 * kMs});
  for (int i = 0; i < 3; ++i) unit_.to_m0.push_back({{"M0,+00.500\r\n"}});
  EXPECT_EQ(NextStatus(), SampleStatus::kOk);
  EXPECT_EQ(NextStatus(), SampleStatus::kRepeated);
  EXPECT_EQ(NextStatus(), SampleStatus::kRepeated);
  EXPECT_THAT(NumbersOf(sensor_->Found(), FindingKind::kUnitRate), HasSubstr("new_rate_hz=50"));
}

TEST_F(KeyenceIlTest, ABufferSlowerThanTheWireLimitsWhatIsObserved) {
  // 8.1667 ms an exchange; 25 ms a content: 40 new readings/s, of which 40 / 2.56 Hz
  Started({.baud = 38400, .refresh_ns = 25 * kMs});
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kUnitRate),
            "device=DL-RS1A rate_hz=122.449 observable_hz=15.625 baud=38400 new_rate_hz=40");
}

TEST_F(KeyenceIlTest, ARateBelowTheWiresLimitsWhatIsObserved) {
  Started({.baud = 38400, .rate_hz = 25.6});
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kUnitRate),
            "device=DL-RS1A rate_hz=25.6 observable_hz=10 baud=38400");
  EXPECT_EQ(sensor_->header().metadata.nominal_rate_hz, 25.6);
}

TEST_F(KeyenceIlTest, TheBestOfTheUnitIsOneAmplifierAtTheHighestBaudRate) {
  Started({.baud = 9600});
  // 16 characters of 10 bits and 4 ms
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kUnitRate),
            "device=DL-RS1A rate_hz=48.3871 observable_hz=18.9012 baud=9600");
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kUnitTooSlow),
            "device=DL-RS1A rate_hz=122.449 needed_hz=1280");
}

TEST_F(KeyenceIlTest, MsHasTheOutputsOfEachAmplifierInOrder) {
  unit_.to_m0.push_back({{"M0,-00.007,+00.018\r\n"}});
  unit_.to_ms = "MS,04,-00.008,02,+00.019\r\n";
  Started({.baud = 38400, .command = dl::Command::kMs});
  const Reading reading = NextRow();
  ASSERT_EQ(reading.samples.size(), 4U);
  EXPECT_EQ(Counts(reading.samples[0]), -8);
  EXPECT_EQ(Counts(reading.samples[1]), 19);
  EXPECT_EQ(Counts(reading.samples[2]), 4);
  EXPECT_EQ(Counts(reading.samples[3]), 2);
}

TEST_F(KeyenceIlTest, AReplyIsHeldBelowNineTenthsOfTheFastestOnly) {
  Started();
  for (int i = 0; i < 64; ++i) ExpectSoundFrom(2 + i);
  // 0.9 x 8 ms, and then 0.9 x 7.2 ms less 1 ns; a held reply is given after 1.5 x 8 ms
  unit_.to_m0.push_back({{"M0,+00.500\r\n", 7'200'000}});
  unit_.to_m0.push_back({{"M0,+00.600\r\n", 6'479'999}});
  const Reading at_once = NextRow();
  const Reading held = NextRow();
  EXPECT_EQ(held.time_ns - at_once.time_ns, 7'200'000);
  EXPECT_EQ(Counts(held), 600);
  EXPECT_EQ(held.reply_ns - held.time_ns, 6'479'999);
  EXPECT_EQ(NextRow().time_ns - held.time_ns, 12 * kMs);
}

TEST_F(KeyenceIlTest, ARepliesTimeIsTooShortBelowItsWiresAlone) {
  Started();
  const MonotonicNs wire_ns = dl_rs1a::LeastExchangeNs(38400, 1);
  unit_.to_m0.push_back({{"M0,+00.500\r\n", wire_ns}});
  EXPECT_EQ(Counts(NextRow()), 500);
  EXPECT_FALSE(sensor_->Found().Has(FindingKind::kRepliesTooSoon));
  unit_.to_m0.push_back({{"M0,+00.600\r\n", wire_ns - 1}});
  EXPECT_EQ(Counts(NextRow()), 600);
  // 160 bits at 38400 baud
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kRepliesTooSoon),
            "too_soon=1 replies=2 wire_s=0.00416667 rate_hz=240");
}

TEST_F(KeyenceIlTest, RepliesWithOtherDecimalsAreADoubt) {
  Started();
  ExpectSoundFrom(2);
  EXPECT_FALSE(sensor_->Found().Has(FindingKind::kOtherForm));
  for (const char* reply : {"M0,+001.23\r\n", "M0,+001.24\r\n"}) unit_.to_m0.push_back({{reply}});
  EXPECT_EQ(NextStatus(), SampleStatus::kBadFrame);
  EXPECT_EQ(NextStatus(), SampleStatus::kBadFrame);
  ExpectSoundFrom(3);
  EXPECT_EQ(tests::NumbersOf(sensor_->Found(), FindingKind::kOtherForm),
            "replies=2 example=M0,+001.23");
}

TEST_F(KeyenceIlTest, DamagedRepliesAreOfNoOtherForm) {
  Started();
  ExpectSoundFrom(2);
  unit_.to_m0.push_back({{"M0,+00.1\r\n"}});
  EXPECT_EQ(NextStatus(), SampleStatus::kBadFrame);
  EXPECT_FALSE(sensor_->Found().Has(FindingKind::kOtherForm));
}

TEST_F(KeyenceIlTest, RequestsThatComeBackAreIgnored) {
  unit_.to_m0.push_back({{"M0\r\n", 1 * kMs}, {"M0,+00.001\r\n"}});
  Started();
  for (int um = 2; um < 5; ++um) {
    unit_.to_m0.push_back({{"M0\r\n", 1 * kMs}, {"M0,+00.00" + std::to_string(um) + "\r\n"}});
    ExpectSoundFrom(um);
  }
  EXPECT_EQ(tests::NumbersOf(sensor_->Found(), FindingKind::kEcho), "echoes=4");
}

TEST_F(KeyenceIlTest, AWireThatOnlySendsRequestsBackIsNamed) {
  unit_.to_m0 = {{{"M0\r\n"}}, {{"M0\r\n"}}, {{"M0\r\n"}}};
  const Error error = StartError();
  EXPECT_EQ(error.cause, Cause::kCannotAnswer);
  EXPECT_THAT(error.what, HasSubstr("sends each request back"));
  EXPECT_THAT(error.remedy, HasSubstr("RS-485"));
}

}  // namespace
}  // namespace haptometer::acquire
