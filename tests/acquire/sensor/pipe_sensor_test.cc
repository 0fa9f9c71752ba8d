#include "acquire/sensor/pipe_sensor.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "acquire/transport/descriptor.h"
#include "acquire/transport/open_port.h"
#include "tests/acquire/pty_pair.h"
#include "tests/acquire/scripted_transport.h"
#include "tests/acquire/sensor_rows.h"
#include "tests/findings.h"
#include "tests/residual.h"

// "displacement:m,voltage:V" and a calibration become channels.

namespace haptometer::acquire {
namespace {

using tests::NumbersOf;

using ::testing::HasSubstr;
using ::testing::Not;
using trial::ChannelRole;

// a file of the test that runs, removed with it
class CalibrationFile {
 public:
  explicit CalibrationFile(const std::string& text)
      : path_(::testing::TempDir() +
              ::testing::UnitTest::GetInstance()->current_test_info()->name() + ".toml") {
    std::ofstream(path_) << text;
  }
  ~CalibrationFile() { std::filesystem::remove(path_); }
  CalibrationFile(const CalibrationFile&) = delete;
  CalibrationFile& operator=(const CalibrationFile&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

std::string ErrorOf(std::string_view text, SampleFormat format = SampleFormat::kF64,
                    const std::string& calibration = {}) {
  const auto channels = ReadPipeChannels(text, format, calibration);
  if (channels) return "no error";
  EXPECT_EQ(channels.error().cause, Cause::kUsage);
  return channels.error().Text();
}

TEST(PipeChannels, AreNamedLikeTheColumnsOfACsv) {
  const auto channels =
      ReadPipeChannels("displacement:um,Voltage:mV,current_a,trigger,displacement_2:m,temperature",
                       SampleFormat::kF32, "");
  ASSERT_TRUE(channels) << channels.error().Text();
  const auto& formats = channels->formats;
  ASSERT_EQ(formats.size(), 6U);
  EXPECT_EQ(formats[0].name, "displacement");
  EXPECT_EQ(formats[0].role, ChannelRole::kDisplacement);
  EXPECT_EQ(formats[0].unit, "m");
  EXPECT_EQ(formats[0].scale, 1e-6);
  EXPECT_EQ(formats[0].encoding, trial::Encoding::kF32);
  EXPECT_EQ(formats[1].role, ChannelRole::kVoltage);
  EXPECT_EQ(formats[1].scale, 1e-3);
  EXPECT_EQ(formats[2].name, "current");
  EXPECT_EQ(formats[2].role, ChannelRole::kCurrent);
  EXPECT_EQ(formats[3].role, ChannelRole::kTrigger);
  EXPECT_EQ(formats[4].name, "displacement_2");
  EXPECT_EQ(formats[4].role, ChannelRole::kDisplacement);
  EXPECT_EQ(formats[5].role, ChannelRole::kOther);
}

TEST(PipeChannels, AreRefusedWhereTheySayTooLittle) {
  EXPECT_THAT(ErrorOf("displacement"), HasSubstr("displacement does not state its unit"));
  EXPECT_THAT(ErrorOf("displacement:V"),
              HasSubstr("displacement cannot be in V, which is a unit of voltage; give its "
                        "<calibration>; without one name it voltage:V, or displacement:m where"));
  // by the word before a _, whatever follows
  EXPECT_THAT(ErrorOf("displacement_2:V"),
              HasSubstr("give its <calibration>; without one name it"));
  EXPECT_THAT(ErrorOf("voltage:um"), HasSubstr("name it displacement:um"));
  EXPECT_THAT(ErrorOf("displacements:um"), Not(HasSubstr("<calibration>")));
  EXPECT_THAT(ErrorOf("displacement:furlong"), HasSubstr("furlong does not state its unit"));
  EXPECT_THAT(ErrorOf("time:s,voltage:V"), HasSubstr("time:s"));
  EXPECT_THAT(ErrorOf("status,voltage:V"), HasSubstr("status"));
  EXPECT_THAT(ErrorOf("voltage:V,voltage:V"), HasSubstr("call the second one voltage_2"));
  EXPECT_THAT(ErrorOf(""), HasSubstr("names no channel"));
  EXPECT_THAT(ErrorOf("voltage:V,"), HasSubstr("names no channel"));
  EXPECT_THAT(ErrorOf("voltage:"), HasSubstr("names no channel"));
}

TEST(PipeChannels, AreAsManyAsATrialHas) {
  std::string names = "trigger";
  for (std::size_t i = 1; i < trial::kMaxChannels; ++i) names += fmt::format(",t{}", i);
  const auto most = ReadPipeChannels(names, SampleFormat::kF32, "");
  ASSERT_TRUE(most) << most.error().Text();
  EXPECT_EQ(most->formats.size(), trial::kMaxChannels);
  EXPECT_THAT(ErrorOf(names + ",more"), HasSubstr("names more than"));
}

TEST(PipeChannels, AChannelThatTheCalibrationDoesNotKnowIsTheOneThatIsMisspelt) {
  const CalibrationFile file("[displacement]\nscale_m_per_v = 1e-3\n");
  EXPECT_THAT(ErrorOf("dispalcement:V", SampleFormat::kF64, file.path()),
              HasSubstr("calibrates displacement, which is none of the channels dispalcement; call "
                        "the channel that it is for displacement"));
}

TEST(PipeChannels, TheCalibrationStatesTheAveraging) {
  const CalibrationFile file(
      "averages = 4\nsampling_s = '0.33ms'\n[displacement]\nscale_m_per_v = 1e-3\n");
  const auto channels = ReadPipeChannels("displacement", SampleFormat::kF64, file.path());
  ASSERT_TRUE(channels) << channels.error().Text();
  EXPECT_EQ(channels->averaging.averages, 4);
  EXPECT_EQ(channels->averaging.sampling_s, 0.33e-3);
}

TEST(PipeChannels, ACalibratedChannelComesInVolts) {
  const CalibrationFile file("[displacement]\nscale_m_per_v = 1e-3\nbad_above_v = 5.25\n");
  for (const char* text : {"displacement,voltage:V", "displacement:V,voltage:V"}) {
    const auto channels = ReadPipeChannels(text, SampleFormat::kF64, file.path());
    ASSERT_TRUE(channels) << channels.error().Text();
    EXPECT_EQ(channels->formats[0].scale, 1e-3);
    EXPECT_EQ(channels->formats[0].unit, "m");
    EXPECT_EQ(channels->limits[0].bad_above, 5.25);
    EXPECT_EQ(channels->formats[1].scale, 1);
    EXPECT_EQ(channels->fields.at("calibration"), file.path());
  }
  const auto milli = ReadPipeChannels("displacement:mV", SampleFormat::kF64, file.path());
  ASSERT_TRUE(milli);
  EXPECT_REL(milli->formats[0].scale, 1e-6, 1e-15, "one product");
  EXPECT_REL(milli->limits[0].bad_above, 5250, 1e-15, "one quotient");
  EXPECT_THAT(ErrorOf("displacement:m", SampleFormat::kF64, file.path()),
              HasSubstr("displacement comes in V by its calibration, not in m"));
}

TEST(PipeChannels, CountsNeedACalibration) {
  EXPECT_THAT(ErrorOf("displacement", SampleFormat::kI16),
              HasSubstr("the size of a count of displacement is not stated"));
  EXPECT_THAT(ErrorOf("displacement:m", SampleFormat::kI16),
              HasSubstr("counts of displacement have no unit"));
  const CalibrationFile no_counts("[displacement]\nscale_m_per_v = 1e-3\n");
  EXPECT_THAT(ErrorOf("displacement", SampleFormat::kI16, no_counts.path()),
              HasSubstr("add v_per_count"));
}

TEST(PipeChannels, CountsOfATriggerStayCounts) {
  const CalibrationFile file(
      "[displacement]\nscale_m_per_v = 1e-3\nv_per_count = 0.5\nv_at_zero_count = 1\n");
  const auto channels = ReadPipeChannels("displacement,trigger", SampleFormat::kI16, file.path());
  ASSERT_TRUE(channels) << channels.error().Text();
  EXPECT_EQ(channels->formats[0].scale, 0.5e-3);
  EXPECT_EQ(channels->formats[0].offset, 1e-3);
  EXPECT_EQ(channels->formats[0].encoding, trial::Encoding::kI32);
  EXPECT_EQ(channels->formats[1].scale, 1);
  EXPECT_EQ(channels->formats[1].role, ChannelRole::kTrigger);
}

}  // namespace
// Samples through a scripted pipe on a manual clock.
namespace {

using ::testing::HasSubstr;
using tests::ScriptedTransport;
using trial::SampleStatus;

constexpr MonotonicNs kMs = 1'000'000;

class PipeSensorTest : public ::testing::Test {
 protected:
  void Make(const std::string& channels, SampleFormat format) {
    auto transport = std::make_unique<ScriptedTransport>(clock_);
    pipe_ = transport.get();
    const auto read = ReadPipeChannels(channels, format, "");
    ASSERT_TRUE(read) << read.error().Text();
    sensor_ = std::make_unique<PipeSensor>(
        std::move(transport), PipeSetup{.format = format, .rate_hz = 10'000, .channels = *read},
        clock_);
  }
  std::string StartError() {
    const auto started = sensor_->Start(kNeverStop);
    EXPECT_FALSE(started);
    if (started) return {};
    EXPECT_EQ(started.error().cause, Cause::kCannotAnswer);
    return started.error().Text();
  }
  // the statuses of the rows up to the end
  std::vector<SampleStatus> ToTheEnd() {
    std::vector<SampleStatus> statuses;
    Reading reading;
    (void)sensor_->Begin();
    for (int call = 0; call < 10'000; ++call) {
      const Outcome outcome = sensor_->Next(reading);
      if (outcome == Outcome::kEnd) return statuses;
      if (outcome != Outcome::kReading) continue;
      EXPECT_EQ(reading.index, static_cast<std::int64_t>(statuses.size()));
      statuses.push_back(RowStatus(reading));
    }
    ADD_FAILURE() << "no end";
    return statuses;
  }

  ManualClock clock_;
  ScriptedTransport* pipe_ = nullptr;
  std::unique_ptr<PipeSensor> sensor_;
};

TEST_F(PipeSensorTest, RowsLieOnAGridWhateverTheirArrival) {
  Make("displacement:um,voltage:V", SampleFormat::kText);
  pipe_->Send("1,2\n3,", kMs);
  pipe_->Send("4\n5,6\n", 700 * kMs);
  pipe_->HangUp(701 * kMs);
  ASSERT_TRUE(sensor_->Start(kNeverStop));
  const trial::TrialHeader& header = sensor_->header();
  EXPECT_EQ(header.timing, trial::Timing::kUniform);
  EXPECT_EQ(header.rate_hz, 10'000);
  EXPECT_EQ(header.metadata.sensor, "pipe");
  EXPECT_EQ(header.metadata.source, "device: scripted, 2 x text");
  EXPECT_EQ(header.channels.at(0).scale, 1e-6);
  EXPECT_EQ(ToTheEnd(), std::vector(3, SampleStatus::kOk));
  EXPECT_EQ(sensor_->discarded_bytes(), 0U);
}

TEST_F(PipeSensorTest, TheGridOfASecondBeginningStartsAtZeroToo) {
  Make("voltage:V", SampleFormat::kText);
  pipe_->Send("1\n2\n3\n4\n", kMs);
  pipe_->HangUp(2 * kMs);
  ASSERT_TRUE(sensor_->Start(kNeverStop));
  (void)sensor_->Begin();
  Reading reading;
  EXPECT_EQ(sensor_->Next(reading), Outcome::kReading);
  EXPECT_EQ(sensor_->Next(reading), Outcome::kReading);
  EXPECT_EQ(reading.index, 1);
  EXPECT_EQ(ToTheEnd().size(), 2U) << "what a tare took is gone, and the grid begins behind it";
}

TEST_F(PipeSensorTest, ACutRowAtTheEndIsCounted) {
  Make("voltage:V", SampleFormat::kF64);
  pipe_->Send(std::string(8 * 3 + 5, '\0'), kMs);
  pipe_->HangUp(2 * kMs);
  ASSERT_TRUE(sensor_->Start(kNeverStop));
  EXPECT_EQ(ToTheEnd().size(), 3U);
  EXPECT_EQ(sensor_->discarded_bytes(), 5U);
}

TEST_F(PipeSensorTest, AHeadingIsPassedOverAndALaterWrongLineKeepsItsPlace) {
  Make("voltage:V", SampleFormat::kText);
  pipe_->Send("# my DAQ\nvolts\n1\nx\n3\n", kMs);
  pipe_->HangUp(2 * kMs);
  ASSERT_TRUE(sensor_->Start(kNeverStop));
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kHeadingLines), "lines=2 first=volts");
  EXPECT_EQ(ToTheEnd(),
            (std::vector{SampleStatus::kOk, SampleStatus::kBadFrame, SampleStatus::kOk}));
  EXPECT_EQ(sensor_->discarded_bytes(), 1U);  // the x; the heading is no part of the recording
}

TEST_F(PipeSensorTest, SaysWhatDoesNotFit) {
  Make("voltage:V,current:A", SampleFormat::kText);
  pipe_->Send("1,2,3\n1,2,3\n", kMs);
  pipe_->HangUp(2 * kMs);
  EXPECT_THAT(StartError(), HasSubstr("no line is a row of 2 x text: \"1,2,3\""));
}

TEST_F(PipeSensorTest, AHeadingHasAHundredLinesAtMost) {
  for (const int lines : {100, 101}) {
    Make("voltage:V", SampleFormat::kText);
    std::string text;
    for (int line = 0; line < lines; ++line) text += "volts\n";
    pipe_->Send(text + "1\n", kMs);
    pipe_->HangUp(2 * kMs);
    EXPECT_EQ(sensor_->Start(kNeverStop).has_value(), lines == 100) << lines;
  }
}

TEST_F(PipeSensorTest, StatesWhatItsRateObserves) {
  Make("voltage:V", SampleFormat::kText);
  pipe_->Send("1\n", kMs);
  ASSERT_TRUE(sensor_->Start(kNeverStop));
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kStatedRate),
            "rate_hz=10000 observable_hz=3906.25 half_rate_hz=5000");
  EXPECT_EQ(sensor_->header().metadata.nominal_rate_hz, 10'000);
}

TEST_F(PipeSensorTest, GivesUpOnEndlessText) {
  Make("voltage:V", SampleFormat::kText);
  std::string lines;
  for (int i = 0; i < 200; ++i) lines += "hello\n";
  pipe_->Send(lines, kMs);
  EXPECT_THAT(StartError(), HasSubstr("\"hello\""));
}

TEST_F(PipeSensorTest, SaysWhenTheInputIsEmptyOrTooShort) {
  Make("voltage:V", SampleFormat::kF64);
  pipe_->Send("abc", kMs);
  pipe_->HangUp(2 * kMs);
  EXPECT_THAT(StartError(), HasSubstr("scripted: ended before a whole row came (3 bytes did)"));
}

TEST_F(PipeSensorTest, WaitsForAProgramThatIsSlowToBeginButNotForever) {
  Make("voltage:V", SampleFormat::kText);
  pipe_->Send("1\n", 59 * kNsPerS);
  EXPECT_TRUE(sensor_->Start(kNeverStop));
  Make("voltage:V", SampleFormat::kText);
  EXPECT_THAT(StartError(), HasSubstr("no row came in 60 s"));
}

TEST_F(PipeSensorTest, CanBeInterruptedWhileItWaits) {
  Make("voltage:V", SampleFormat::kText);
  const std::atomic<bool> stop{true};
  const auto started = sensor_->Start(stop);
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().cause, Cause::kFailed);
}

TEST_F(PipeSensorTest, SilenceIsNothing) {
  Make("voltage:V", SampleFormat::kText);
  pipe_->Send("1\n", kMs);
  ASSERT_TRUE(sensor_->Start(kNeverStop));
  Reading reading;
  EXPECT_EQ(sensor_->Next(reading), Outcome::kReading);
  const MonotonicNs before = clock_.Now();
  EXPECT_EQ(sensor_->Next(reading), Outcome::kNothing);
  EXPECT_EQ(clock_.Now() - before, 100 * kMs);
}

TEST_F(PipeSensorTest, ADecimalCommaIsNamed) {
  Make("displacement:um,voltage:V", SampleFormat::kText);
  pipe_->Send("Weg;Spannung\n-0,326;0,0000\n1,5;0,5\n", kMs);
  pipe_->HangUp(2 * kMs);
  EXPECT_THAT(StartError(), HasSubstr("\"-0,326;0,0000\" is a row of 2 x text only where it is the "
                                      "decimal sign; write decimal points"));
}

// --- the rate at which rows come ---

// rows that come together, some time after the beginning
struct Block {
  MonotonicNs at_ns;
  std::size_t rows;
};

// `rows` every 50 ms from `first_ns` on, up to `last_ns`
std::vector<Block> Every50Ms(std::size_t rows, MonotonicNs first_ns, MonotonicNs last_ns) {
  std::vector<Block> blocks;
  for (MonotonicNs at_ns = first_ns; at_ns <= last_ns; at_ns += 50 * kMs) {
    blocks.push_back({at_ns, rows});
  }
  return blocks;
}

class RowRate : public PipeSensorTest {
 protected:
  // what is found of the blocks at 10 kHz, as stated, by a reader that takes `a_row_ns` for a row
  std::string FoundOf(const std::vector<Block>& blocks, MonotonicNs a_row_ns = 0) {
    clock_ = {};
    Make("voltage:V", SampleFormat::kF64);
    for (const Block& block : blocks) {
      pipe_->Send(std::string(sizeof(double) * block.rows, '\0'), block.at_ns);
    }
    pipe_->HangUp(blocks.back().at_ns);
    EXPECT_TRUE(sensor_->Start(kNeverStop));
    Reading reading;
    (void)sensor_->Begin();
    while (sensor_->Next(reading) != Outcome::kEnd) clock_.Advance(a_row_ns);
    return NumbersOf(sensor_->Found(), FindingKind::kRowRateDiffers);
  }
};

// a span ends with the first block after 0.25 s; the first one, from 50 to 300 ms, is not judged
TEST_F(RowRate, OfASourceThatIsLiveIsComparedWithTheStatedOne) {
  EXPECT_EQ(FoundOf(Every50Ms(250, 50 * kMs, 3050 * kMs)),
            "rate_hz=5000 elapsed_s=2.5 stated_hz=10000");
  EXPECT_EQ(FoundOf(Every50Ms(1000, 50 * kMs, 1600 * kMs)),
            "rate_hz=20000 elapsed_s=1.25 stated_hz=10000");
  EXPECT_EQ(FoundOf(Every50Ms(530, 50 * kMs, 1600 * kMs)),
            "rate_hz=10600 elapsed_s=1.25 stated_hz=10000");
  for (const std::size_t rows : {480U, 500U, 520U}) {
    EXPECT_EQ(FoundOf(Every50Ms(rows, 50 * kMs, 9000 * kMs)), "none") << rows;
  }
}

TEST_F(RowRate, IsJudgedOverOneSecondAtLeast) {
  EXPECT_EQ(FoundOf(Every50Ms(250, 50 * kMs, 1300 * kMs)), "none");
  EXPECT_NE(FoundOf(Every50Ms(250, 50 * kMs, 1350 * kMs)), "none");
}

// a file: all at once, or over seconds at what its disk gives; and a reader slower than the source
TEST_F(RowRate, OfAFileOrASlowReaderIsNotJudged) {
  EXPECT_EQ(FoundOf({{kMs, 100'000}}), "none");
  EXPECT_EQ(FoundOf(Every50Ms(5500, 50 * kMs, 1600 * kMs)), "none") << "eleven times as fast";
  EXPECT_EQ(FoundOf(Every50Ms(2000, 50 * kMs, 1600 * kMs), 24'000), "none")
      << "busy for 48 of 50 ms";
  EXPECT_EQ(FoundOf({{kMs, 10'000}}, kMs), "none") << "1 kHz by the reader";
  EXPECT_EQ(FoundOf(Every50Ms(500, 50 * kMs, 3000 * kMs), kMs / 5), "none")
      << "5 kHz by the reader";
}

TEST_F(RowRate, IsThatOfMostOfTheTime) {
  for (const MonotonicNs changed_ns : {1500 * kMs, 3000 * kMs}) {
    std::vector<Block> blocks = Every50Ms(500, 50 * kMs, changed_ns);
    std::ranges::copy(Every50Ms(250, changed_ns + 50 * kMs, 4500 * kMs),
                      std::back_inserter(blocks));
    EXPECT_EQ(FoundOf(blocks) == "none", changed_ns == 3000 * kMs);
  }
}

TEST_F(RowRate, AStallIsNoOtherRate) {
  // at the start, with and without the rows that came meanwhile
  for (const std::size_t meanwhile : {1U, 30'000U}) {
    std::vector<Block> blocks{{kMs, 10}, {3000 * kMs, meanwhile}};
    std::ranges::copy(Every50Ms(500, 3050 * kMs, 4500 * kMs), std::back_inserter(blocks));
    EXPECT_EQ(FoundOf(blocks), "none") << meanwhile;
  }
  // in the middle, for longer than all the rest
  std::vector<Block> blocks = Every50Ms(500, 50 * kMs, 1000 * kMs);
  std::ranges::copy(Every50Ms(500, 6000 * kMs, 7000 * kMs), std::back_inserter(blocks));
  EXPECT_EQ(FoundOf(blocks), "none");
}

// --- the pipe itself ---

// --- the pace by its spans ---

// spans of a source that is stated to send 1000 rows/s; the first one is never judged
struct Spans {
  int count;
  MonotonicNs ns;
  std::int64_t rows;
  MonotonicNs waited_ns;
};

// "SPANS ROWS NS" of another rate, "" where there is none
std::string OtherRate(std::initializer_list<Spans> judged) {
  RowPace pace(1000);
  std::int64_t rows = 7;
  MonotonicNs now = 100 * kMs;
  // rows that come at once belong to no span, nor does the span behind them
  pace.AddWait(0, 0, kNsPerS);
  pace.AddWait(rows, now, 0);
  now += 300 * kMs;
  // a span's waits are those from its beginning on
  pace.AddWait(rows += 300, now, judged.begin()->waited_ns);
  for (auto spans = judged.begin(); spans != judged.end(); ++spans) {
    for (int i = 0; i < spans->count; ++i) {
      const bool is_last = i + 1 == spans->count;
      const auto* next = is_last && spans + 1 != judged.end() ? spans + 1 : spans;
      pace.AddWait(rows += spans->rows, now += spans->ns, next->waited_ns);
    }
  }
  const auto other = pace.AtOtherRate();
  return other ? fmt::format("{} {} {}", other->spans, other->rows, other->ns / kMs) : "";
}

TEST(RowPace, IsAnotherOneBeyondFivePercent) {
  EXPECT_EQ(OtherRate({{4, 500 * kMs, 526, 400 * kMs}}), "4 2104 2000");
  EXPECT_EQ(OtherRate({{4, 500 * kMs, 524, 400 * kMs}}), "");
  EXPECT_EQ(OtherRate({{4, 500 * kMs, 476, 400 * kMs}}), "");
  EXPECT_EQ(OtherRate({{4, 500 * kMs, 474, 400 * kMs}}), "4 1896 2000");
}

TEST(RowPace, IsJudgedWhereTheReaderWaitsForHalfOfTheTime) {
  EXPECT_EQ(OtherRate({{4, 500 * kMs, 700, 250 * kMs}}), "4 2800 2000");
  EXPECT_EQ(OtherRate({{4, 500 * kMs, 700, 250 * kMs - 1}}), "");
  // ten times as fast is still live, more is a file
  EXPECT_EQ(OtherRate({{4, 500 * kMs, 5000, 400 * kMs}}), "4 20000 2000");
  EXPECT_EQ(OtherRate({{4, 500 * kMs, 5001, 400 * kMs}}), "");
}

TEST(RowPace, NeedsThreeSpansThatLastASecond) {
  EXPECT_EQ(OtherRate({{2, 600 * kMs, 900, 500 * kMs}}), "");
  EXPECT_EQ(OtherRate({{3, 334 * kMs, 500, 300 * kMs}}), "3 1500 1002");
  EXPECT_EQ(OtherRate({{3, 333 * kMs, 500, 300 * kMs}}), "") << "0.999 s";
  EXPECT_EQ(OtherRate({{4, 250 * kMs, 500, 200 * kMs}}), "4 2000 1000");
  // a shorter span is continued
  EXPECT_EQ(OtherRate({{8, 250 * kMs - 1, 500, 200 * kMs}}), "4 4000 1999");
}

TEST(RowPace, NeedsMostOfTheLiveSpans) {
  const Spans sound{3, 500 * kMs, 500, 400 * kMs};
  EXPECT_EQ(OtherRate({sound, {3, 500 * kMs, 700, 400 * kMs}}), "");
  EXPECT_EQ(OtherRate({sound, {4, 500 * kMs, 700, 400 * kMs}}), "4 2800 2000");
  EXPECT_EQ(OtherRate({{3, 500 * kMs, 300, 400 * kMs}, {3, 500 * kMs, 700, 400 * kMs}}), "")
      << "as many below as above";
  EXPECT_EQ(OtherRate({{3, 500 * kMs, 300, 400 * kMs}, {4, 500 * kMs, 700, 400 * kMs}}),
            "4 2800 2000");
  // spans of a slow reader do not count
  EXPECT_EQ(OtherRate({{9, 500 * kMs, 500, 10 * kMs}, {3, 500 * kMs, 700, 400 * kMs}}),
            "3 2100 1500");
}

TEST(InputPipe, HandsOutWhatIsWrittenAndThenItsEnd) {
  const std::string path = ::testing::TempDir() + "haptometer_fifo";
  std::filesystem::remove(path);
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  auto pipe = OpenInputPipe(path);
  ASSERT_TRUE(pipe) << pipe.error().Text();
  SystemClock clock;
  std::array<char, 16> buffer{};
  // no writer yet: silence, not an end
  EXPECT_EQ((*pipe)->Read(buffer, clock.Now()).state, ReadState::kTimeout);
  {
    const OwnedDescriptor writer(open(path.c_str(), O_WRONLY | O_CLOEXEC));
    ASSERT_EQ(write(writer.get(), "abc", 3), 3);
    const ReadOutcome outcome = (*pipe)->Read(buffer, clock.Now() + kNsPerS);
    EXPECT_EQ(outcome.state, ReadState::kBytes);
    EXPECT_EQ(std::string(buffer.data(), outcome.bytes), "abc");
  }
  EXPECT_EQ((*pipe)->Read(buffer, clock.Now() + kNsPerS).state, ReadState::kGone);
  EXPECT_FALSE((*pipe)->Write("x", clock.Now()));
  std::filesystem::remove(path);
}

TEST(InputPipe, RefusesWhatHoldsNoSamples) {
  const auto error = [](const std::string& path) {
    const auto pipe = OpenInputPipe(path);
    return pipe ? "no error" : pipe.error().Text();
  };
  EXPECT_THAT(error(::testing::TempDir()), HasSubstr("is a directory; pipe samples into it"));
  EXPECT_THAT(error(::testing::TempDir() + "missing/fifo"), HasSubstr("is not there"));
  const tests::PtyPair terminal;
  EXPECT_THAT(error(terminal.path()), HasSubstr("is a terminal; pipe samples into it"));
}

}  // namespace
}  // namespace haptometer::acquire
