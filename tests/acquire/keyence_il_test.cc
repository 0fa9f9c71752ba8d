// A DL-RS1A on a scripted wire and a manual clock: every way in which a reply can come, or not.
#include "acquire/sensor/keyence_il.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/acquire/scripted_transport.h"
#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using tests::ScriptedTransport;
using trial::SampleStatus;

constexpr MonotonicNs kMs = 1'000'000;
const std::atomic<bool> kNeverStop{false};

/// A unit whose answers can be told reply by reply; without an instruction it is a sound IL-030
/// that counts up by 1 um, 8 ms after the request.
class Unit {
 public:
  struct Answer {
    std::string bytes;
    MonotonicNs after_ns = 8 * kMs;
  };

  explicit Unit(Clock& clock) : clock_(clock) {
    auto transport = std::make_unique<ScriptedTransport>(
        clock, [this](ScriptedTransport& to, const std::string& request) { Reply(to, request); });
    wire = transport.get();
    transport_ = std::move(transport);
  }

  std::unique_ptr<Transport> TakeTransport() { return std::move(transport_); }

  std::deque<std::vector<Answer>> to_m0;        ///< for the next M0s; then the default
  std::map<std::string, std::string> settings;  ///< "195" -> "1"
  std::string to_ms = "MS,04,+88.888\r\n";      ///< empty: never answered
  bool answers_sr = true;
  bool is_silent = false;
  std::int32_t next_um = 1;
  ScriptedTransport* wire = nullptr;

 private:
  void Reply(ScriptedTransport& to, const std::string& request) {
    if (is_silent) return;
    // one command at a time: it turns to this one when the last one is answered
    const MonotonicNs begin_ns = std::max(clock_.Now(), busy_until_ns_);
    if (request == "M0\r\n") {
      std::vector<Answer> answers;
      if (to_m0.empty()) {
        answers = {{dl_rs1a::FormatM0Reply(std::array{Value{next_um++, 3, SampleStatus::kOk}})}};
      } else {
        answers = to_m0.front();
        to_m0.pop_front();
      }
      for (const Answer& answer : answers) Answers(to, answer, begin_ns);
      return;
    }
    if (request == "MS\r\n") {
      Answers(to, {to_ms}, begin_ns);
      return;
    }
    ASSERT_TRUE(request.starts_with("SR,00,"));
    if (!answers_sr) return;
    const std::string number = request.substr(6, 3);
    const auto known = settings.find(number);
    to.Send(
        known == settings.end() ? "ER,SR,22\r\n" : "SR,00," + number + "," + known->second + "\r\n",
        20 * kMs);
  }

  void Answers(ScriptedTransport& to, const Answer& answer, MonotonicNs begin_ns) {
    const MonotonicNs at_ns = begin_ns + answer.after_ns;
    busy_until_ns_ = std::max(busy_until_ns_, at_ns);
    if (!answer.bytes.empty()) to.Send(answer.bytes, at_ns - clock_.Now());
  }

  Clock& clock_;
  MonotonicNs busy_until_ns_ = 0;
  std::unique_ptr<Transport> transport_;
};

class KeyenceIlTest : public ::testing::Test {
 protected:
  KeyenceIlTest() { unit_.settings = {{"195", "1"}}; }

  KeyenceIl& Started(KeyenceIlSetup setup = {.baud = 38400, .refresh_ns = std::nullopt}) {
    sensor_ = std::make_unique<KeyenceIl>(unit_.TakeTransport(), setup, clock_);
    const auto started = sensor_->Start(kNeverStop);
    EXPECT_TRUE(started) << started.error().Text();
    begin_ns_ = sensor_->Begin();
    return *sensor_;
  }
  // the next row, however often Next() has to be called; a bound keeps a defect from hanging
  Reading NextRow() {
    Reading reading;
    for (int call = 0; call < 1000; ++call) {
      if (sensor_->Next(reading) == Outcome::kReading) return reading;
    }
    ADD_FAILURE() << "no row";
    return reading;
  }
  SampleStatus NextStatus() { return RowStatus(NextRow()); }
  static std::int32_t Counts(const Reading& reading) {
    return static_cast<std::int32_t>(reading.samples[0].raw.bits());
  }
  void ExpectSoundFrom(std::int32_t um) {
    const Reading reading = NextRow();
    EXPECT_EQ(RowStatus(reading), SampleStatus::kOk);
    EXPECT_EQ(Counts(reading), um);
  }
  Error StartError(int baud = 9600) {
    sensor_ = std::make_unique<KeyenceIl>(
        unit_.TakeTransport(), KeyenceIlSetup{.baud = baud, .refresh_ns = std::nullopt}, clock_);
    const auto started = sensor_->Start(kNeverStop);
    EXPECT_FALSE(started);
    return started ? Error{} : started.error();
  }

  ManualClock clock_;
  Unit unit_{clock_};
  std::unique_ptr<KeyenceIl> sensor_;
  MonotonicNs begin_ns_ = 0;
};

// --- start ---

TEST_F(KeyenceIlTest, ReadsTheUnitsSettingsIntoTheHeader) {
  unit_.settings = {
      {"195", "1"}, {"200", "IL-1000"}, {"132", "2"}, {"133", "4"},
      {"136", "0"}, {"033", "00000"},   {"098", "0"}, {"152", "0"}};  // 159 is refused: ER,SR,22
  const trial::TrialHeader& header = Started().header();
  EXPECT_EQ(header.timing, trial::Timing::kPolled);
  ASSERT_EQ(header.channels.size(), 1U);
  EXPECT_EQ(header.channels[0].role, trial::ChannelRole::kDisplacement);
  EXPECT_REL(header.channels[0].scale, 1e-6, 1e-15, "1 um steps in metres");
  // 20 to 45 mm away, displacement counted from 30 mm towards the head
  EXPECT_REL(header.channels[0].range_min, -15e-3, 1e-15, "range of the IL-030");
  EXPECT_REL(header.channels[0].range_max, 10e-3, 1e-15, "range of the IL-030");
  const trial::Metadata& metadata = header.metadata;
  EXPECT_EQ(metadata.sensor, "keyence-il");
  EXPECT_EQ(metadata.source, "device: scripted");
  EXPECT_EQ(metadata.head, "IL-030");
  EXPECT_EQ(metadata.sampling_s, 1e-3);
  EXPECT_EQ(metadata.averages, 16);
  EXPECT_EQ(metadata.hold, "sample");
  EXPECT_REL(metadata.nominal_rate_hz.value(), 122.449, 1e-5, "the sixth digit of 1 / 8.1667 ms");
  EXPECT_EQ(metadata.fields.at("keyence_data_133"), "4");
  EXPECT_FALSE(metadata.fields.contains("keyence_data_159"));
  EXPECT_THAT(unit_.wire->written(),
              AllOf(Contains("SR,00,195\r\n"), Contains("SR,00,132\r\n"), Contains("SR,00,133\r\n"),
                    Contains("SR,00,136\r\n"), Contains("SR,00,159\r\n"), Contains("SR,00,033\r\n"),
                    Contains("SR,00,098\r\n"), Contains("SR,00,152\r\n")));
}

TEST_F(KeyenceIlTest, AnEmulatorIsCalledOne) {
  unit_.settings["200"] = "EMULATED";
  EXPECT_EQ(Started().header().metadata.source, "emulated device: scripted");
}

TEST_F(KeyenceIlTest, AUnitThatDoesNotKnowSrIsRecordedAllTheSame) {
  unit_.answers_sr = false;
  const trial::Metadata& metadata = Started().header().metadata;
  EXPECT_EQ(metadata.head, "");
  EXPECT_EQ(metadata.averages, std::nullopt);
  EXPECT_LE(clock_.Now(), 3 * kNsPerS) << "two silences are enough to stop asking";
  ExpectSoundFrom(2);
}

TEST_F(KeyenceIlTest, SilenceNamesTheOtherBaudRates) {
  unit_.is_silent = true;
  const Error error = StartError(9600);
  EXPECT_EQ(error.cause, Cause::kCannotAnswer);
  EXPECT_THAT(error.Text(), HasSubstr("scripted: nothing answers at 9600 baud; try --baud 2400, "
                                      "4800, 19200 or 38400, and check "));
  EXPECT_EQ(clock_.Now(), 3 * kNsPerS);
}

TEST_F(KeyenceIlTest, TheLastBaudRateNamesTheFirstFour) {
  unit_.is_silent = true;
  EXPECT_THAT(StartError(38400).Text(), HasSubstr("try --baud 2400, 4800, 9600 or 19200, and"));
}

TEST_F(KeyenceIlTest, GarbageAtTheWrongBaudRateIsToldFromSilence) {
  for (int i = 0; i < 3; ++i)
    unit_.to_m0.push_back({{std::string("\xF8\x80\x78\x00\xE0\n", 6), 8 * kMs}});
  EXPECT_THAT(StartError().Text(),
              HasSubstr("bytes come at 9600 baud, but no reply of a DL-RS1A; try --baud 2400"));
}

TEST_F(KeyenceIlTest, HalfACommandLeftInTheUnitSpoilsOnlyTheFirstProbe) {
  unit_.to_m0.push_back({{"ER,SR,20\r\n"}});
  Started();
  ExpectSoundFrom(2);
}

TEST_F(KeyenceIlTest, ARefusedM0SaysWhatTheNumberMeans) {
  for (int i = 0; i < 3; ++i) unit_.to_m0.push_back({{"ER,M0,66\r\n"}});
  EXPECT_THAT(StartError().Text(), HasSubstr("refuses M0 with error 66: the unit cannot talk to an "
                                             "amplifier beside it; check the D-bus"));
}

TEST_F(KeyenceIlTest, AHangUpDuringTheStartIsSaid) {
  unit_.is_silent = true;
  unit_.wire->HangUp(300 * kMs);
  EXPECT_THAT(StartError().Text(), HasSubstr("the connection was lost"));
}

TEST_F(KeyenceIlTest, TheStopFlagEndsTheStart) {
  unit_.is_silent = true;
  sensor_ = std::make_unique<KeyenceIl>(unit_.TakeTransport(), KeyenceIlSetup{}, clock_);
  const std::atomic<bool> stop{true};
  EXPECT_FALSE(sensor_->Start(stop));
  EXPECT_EQ(clock_.Now(), 0);
}

TEST_F(KeyenceIlTest, SaysWhatTheWireCannotObserve) {
  unit_.settings = {{"195", "1"}, {"132", "2"}, {"133", "4"}, {"136", "1"}, {"033", "00004"}};
  const std::vector<std::string> remarks = Started().Remarks();
  EXPECT_THAT(remarks, Contains(AllOf(HasSubstr("at 38400 baud gives at most 122.4 readings/s"),
                                      HasSubstr("up to 47.8 Hz"))));
  EXPECT_THAT(remarks, Contains(AllOf(HasSubstr("20-500 Hz vibration cannot be observed"),
                                      HasSubstr("analog output"), HasSubstr("--sensor stream"))));
  // sinc(0.443) = 1/sqrt(2): 0.443 / 16 ms
  EXPECT_THAT(remarks, Contains(HasSubstr("averages 16 samples of 1 ms: a vibration at 27.7 Hz")));
  EXPECT_THAT(remarks, Contains(HasSubstr("holds (peak)")));
  EXPECT_THAT(remarks, Contains(HasSubstr("reports an error (flags 00004)")));
}

// --- readings ---

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
  std::vector<Unit::Answer> pieces;
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
      Unit fresh(clock_);
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

// --- repetitions ---

// one value polled every `period`; which of the readings are marked
std::vector<bool> Marked(MonotonicNs refresh_ns, MonotonicNs period_ns,
                         const std::vector<std::int32_t>& counts) {
  RepeatMarker marker(refresh_ns);
  std::vector<bool> marked;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    Reading reading;
    reading.time_ns = static_cast<MonotonicNs>(i) * period_ns;
    reading.samples = {{trial::RawValue::Counts(counts[i]), SampleStatus::kOk}};
    marker.Mark(reading);
    marked.push_back(reading.samples[0].status == SampleStatus::kRepeated);
  }
  return marked;
}

using Marks = std::vector<bool>;

TEST(RepeatMarker, AtRestSlowerThanTheRefreshNothingIsRepeated) {
  EXPECT_EQ(Marked(7 * kMs, 8 * kMs, {5, 5, 5, 5}), (Marks{false, false, false, false}));
  EXPECT_EQ(Marked(7 * kMs, 7 * kMs, {5, 5, 5}), (Marks{false, false, false}));
}

TEST(RepeatMarker, FasterThanTheRefreshEqualReadingsAreMarkedUntilItMustHavePassed) {
  EXPECT_EQ(Marked(20 * kMs, 8 * kMs, {5, 5, 5, 5, 5, 5, 5}),
            (Marks{false, true, true, false, true, true, false}));
}

TEST(RepeatMarker, ADifferentReadingIsNewAtAnyTime) {
  EXPECT_EQ(Marked(20 * kMs, 8 * kMs, {5, 6, 6, 5, 5}), (Marks{false, false, true, false, true}));
}

TEST(RepeatMarker, WhatIsNoMeasurementKeepsItsStatus) {
  RepeatMarker marker(20 * kMs);
  for (int i = 0; i < 2; ++i) {
    Reading reading;
    reading.time_ns = 8 * kMs * i;
    reading.samples = {{trial::RawValue::Counts(-99'998), SampleStatus::kInvalid},
                       {trial::RawValue::Counts(3), SampleStatus::kOk}};
    marker.Mark(reading);
    EXPECT_EQ(reading.samples[0].status, SampleStatus::kInvalid);
    EXPECT_EQ(reading.samples[1].status, i == 0 ? SampleStatus::kOk : SampleStatus::kRepeated);
  }
}

TEST_F(KeyenceIlTest, RepeatedReadingsAreMarkedInTheRow) {
  Started({.baud = 38400, .refresh_ns = 20 * kMs});
  for (int i = 0; i < 3; ++i) unit_.to_m0.push_back({{"M0,+00.500\r\n"}});
  EXPECT_EQ(NextStatus(), SampleStatus::kOk);
  EXPECT_EQ(NextStatus(), SampleStatus::kRepeated);
  EXPECT_EQ(NextStatus(), SampleStatus::kRepeated);
  EXPECT_THAT(sensor_->Remarks(), Contains(HasSubstr("50.0 of them fresh")));
}

TEST(ResponseDeadline, IsTheMakersSecondUntilTheUnitIsKnown) {
  ResponseDeadline deadline;
  EXPECT_EQ(deadline.WaitNs(), kNsPerS);
  for (int i = 0; i < 63; ++i) deadline.Note(8 * kMs);
  EXPECT_EQ(deadline.WaitNs(), kNsPerS);
  deadline.Note(8 * kMs);
  EXPECT_EQ(deadline.WaitNs(), 50 * kMs);
  deadline.Note(30 * kMs);
  EXPECT_EQ(deadline.WaitNs(), 120 * kMs);
  deadline.Note(900 * kMs);
  EXPECT_EQ(deadline.WaitNs(), kNsPerS);
  for (int i = 0; i < 64; ++i) deadline.Note(8 * kMs);
  EXPECT_EQ(deadline.WaitNs(), 50 * kMs);
}

}  // namespace
}  // namespace haptometer::acquire
