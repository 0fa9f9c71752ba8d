#include "acquire/sensor/stream_sensor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <tuple>

#include "tests/acquire/scripted_transport.h"
#include "tests/acquire/sensor_rows.h"
#include "tests/findings.h"
#include "tests/residual.h"
#include "trial/time_base.h"

// Lines lost by the numbers that the others carry.

namespace haptometer::acquire {
namespace {

using tests::NumbersOf;

TEST(LineCounter, CountsWhatIsMissing) {
  LineCounter counter(1000);
  EXPECT_EQ(counter.LostBefore(997), 0);  // nothing is known of what came before
  EXPECT_EQ(counter.LostBefore(998), 0);
  EXPECT_EQ(counter.LostBefore(2), 3);  // 999, 0, 1
  EXPECT_EQ(counter.LostBefore(3), 0);
  EXPECT_EQ(counter.LostBefore(2), 998);
  EXPECT_EQ(counter.LostBefore(2), 999);  // a sensor sends no number twice
}

TEST(LineCounter, DamagedLinesWereThere) {
  LineCounter counter(100);
  counter.CountDamaged();
  EXPECT_EQ(counter.LostBefore(5), 0);
  counter.CountDamaged();
  EXPECT_EQ(counter.LostBefore(7), 0);
  counter.CountDamaged();
  EXPECT_EQ(counter.LostBefore(10), 1);
  counter.CountDamaged();
  counter.CountDamaged();
  EXPECT_EQ(counter.LostBefore(11), 0);  // noise that looked like lines
}

TEST(LineCounter, ALineWithoutACounterLosesNothing) {
  LineCounter counter(1);
  EXPECT_EQ(counter.LostBefore(0), 0);
  EXPECT_EQ(counter.LostBefore(0), 0);
}

// every line that was sent either came or is counted, as long as less than a turn is lost at once
TEST(LineCounter, AccountsForEveryLine) {
  std::mt19937 random(1);
  for (const std::int32_t turn : {10, 100, 1000}) {
    LineCounter counter(turn);
    std::int64_t sent = 0;
    std::int64_t came = 0;
    std::int64_t lost = 0;
    const std::int64_t first = 7;
    for (; came < 10'000; ++came) {
      if (came > 0) sent += 1 + static_cast<std::int64_t>(random() % static_cast<unsigned>(turn));
      lost += counter.LostBefore(static_cast<std::int32_t>((first + sent) % turn));
    }
    EXPECT_EQ(came + lost, sent + 1);
  }
}

}  // namespace
// Free-running lines on a scripted wire and a manual clock.
namespace {

using ::testing::HasSubstr;
using tests::ScriptedTransport;
using trial::SampleStatus;

constexpr MonotonicNs kMs = 1'000'000;

class StreamSensorTest : public ::testing::Test {
 protected:
  StreamSensorTest() {
    auto transport = std::make_unique<ScriptedTransport>(clock_);
    wire_ = transport.get();
    sensor_ = std::make_unique<StreamSensor>(std::move(transport), StreamSetup{}, clock_);
  }
  // half a line, a whole one, and the recording begins
  void Start() {
    wire_->Send("2345\r+00.0001\r", kMs);
    const auto started = sensor_->Start(kNeverStop);
    ASSERT_TRUE(started) << started.error().Text();
    begin_ns_ = sensor_->Begin();
  }
  Reading NextRow() { return NextRowOf(*sensor_); }
  std::string StartError() {
    const auto started = sensor_->Start(kNeverStop);
    EXPECT_FALSE(started);
    if (started) return {};
    EXPECT_EQ(started.error().cause, Cause::kCannotAnswer);
    EXPECT_LE(clock_.Now(), 4 * kNsPerS);
    return started.error().Text();
  }

  ManualClock clock_;
  ScriptedTransport* wire_ = nullptr;
  std::unique_ptr<StreamSensor> sensor_;
  MonotonicNs begin_ns_ = 0;
};

TEST_F(StreamSensorTest, TheHeaderHasTheAdaptersTimerWhereThereIsOne) {
  Start();
  EXPECT_FALSE(sensor_->header().metadata.fields.contains("latency_timer_s"));
  auto transport = std::make_unique<ScriptedTransport>(clock_);
  wire_ = transport.get();
  wire_->latency_ns = 2 * kMs;
  sensor_ = std::make_unique<StreamSensor>(std::move(transport), StreamSetup{}, clock_);
  Start();
  EXPECT_EQ(sensor_->header().metadata.fields.at("latency_timer_s"), "0.002");
}

TEST_F(StreamSensorTest, DropsTheFirstPartialLine) {
  // cut, it still looks like a line: "+01.2345" with its front missing must never be a reading
  wire_->Send("+00.5000\r+00.0001\r", kMs);
  ASSERT_TRUE(sensor_->Start(kNeverStop));
  EXPECT_EQ(sensor_->discarded_bytes(), 8U);
  wire_->Send("+00.0002\r", kMs);
  EXPECT_EQ(Counts(NextRow()), 2);
}

TEST_F(StreamSensorTest, WhatCameBeforeTheBeginningIsNoPartOfTheRecording) {
  wire_->Send("2345\r+00.0001\r", kMs);
  ASSERT_TRUE(sensor_->Start(kNeverStop));
  // lines arrive while the file is made; the last of them is cut by the beginning
  wire_->Send("+00.0002\r+00.0003\r+00.00", kMs);
  clock_.Advance(50 * kMs);
  const MonotonicNs begin_ns = sensor_->Begin();
  EXPECT_EQ(begin_ns, clock_.Now());
  wire_->Send("04\r+00.0005\r", kMs);
  const Reading reading = NextRow();
  EXPECT_EQ(Counts(reading), 5);
  EXPECT_EQ(reading.time_ns - begin_ns, kMs);
}

TEST_F(StreamSensorTest, TheHeaderSaysWhatACountIs) {
  Start();
  const trial::TrialHeader& header = sensor_->header();
  EXPECT_EQ(header.timing, trial::Timing::kArrival);
  EXPECT_REL(header.channels.at(0).scale, 1e-7, 1e-15, "0.1 um a count");
  EXPECT_EQ(header.metadata.sensor, "stream");
  EXPECT_EQ(header.metadata.source, "device: scripted");
}

TEST_F(StreamSensorTest, ALineArrivedBeforeTheBytesBehindIt) {
  Start();
  wire_->Send("+00.0001\r+00.0002\r+00.0003\r+00", 10 * kMs);
  // 21, 12 and 3 bytes behind, 10 bits each at 921600 baud: 227.86, 130.21, 32.55 us
  EXPECT_EQ(NextRow().time_ns - begin_ns_, 10 * kMs - 227'864);
  EXPECT_EQ(NextRow().time_ns - begin_ns_, 10 * kMs - 130'208);
  EXPECT_EQ(NextRow().time_ns - begin_ns_, 10 * kMs - 32'552);
  wire_->Send(".0004\r", kMs);
  EXPECT_EQ(NextRow().time_ns - begin_ns_, 11 * kMs);
}

TEST_F(StreamSensorTest, TimesNeverGoBack) {
  Start();
  std::string burst;
  for (int i = 0; i < 400; ++i) burst += "+00.0001\r";  // 39 ms of wire time at one instant
  wire_->Send("+00.0001\r", 10 * kMs);
  wire_->Send(burst, 11 * kMs);
  MonotonicNs last_ns = begin_ns_;
  for (int i = 0; i < 401; ++i) {
    const Reading reading = NextRow();
    ASSERT_GE(reading.time_ns, last_ns);
    last_ns = reading.time_ns;
  }
  EXPECT_EQ(last_ns - begin_ns_, 11 * kMs);
}

TEST_F(StreamSensorTest, ADamagedLineIsABadFrameAndTheNextIsRead) {
  Start();
  wire_->Send("+00.0002\r+00.00\r+00.0003\r+00.0+00.0004\r\xFF\x80.garb1\r+00.0005\r", kMs);
  const std::vector<SampleStatus> expected{SampleStatus::kOk,       SampleStatus::kBadFrame,
                                           SampleStatus::kOk,       SampleStatus::kBadFrame,
                                           SampleStatus::kBadFrame, SampleStatus::kOk};
  const std::uint64_t before = sensor_->discarded_bytes();
  std::vector<SampleStatus> got;
  got.reserve(expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) got.push_back(RowStatus(NextRow()));
  EXPECT_EQ(got, expected);
  EXPECT_EQ(sensor_->discarded_bytes() - before, 6U + 13U + 8U);
}

TEST_F(StreamSensorTest, ACounterTellsHowManyLinesWereLost) {
  const auto format = ParseStreamFormat("00,+00.0000,mm,CR");
  ASSERT_TRUE(format);
  auto transport = std::make_unique<ScriptedTransport>(clock_);
  wire_ = transport.get();
  sensor_ =
      std::make_unique<StreamSensor>(std::move(transport), StreamSetup{.format = *format}, clock_);
  wire_->Send("2345\r96,+00.0001\r", kMs);
  ASSERT_TRUE(sensor_->Start(kNeverStop));
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kLinesNumbered), "last=99");
  // what came before the beginning is not missing from it
  (void)sensor_->Begin();
  wire_->Send(
      "98,+00.0001\r99,+00.0002\r00,+00.0003\r"  // one turn of the counter
      "04,+00.0004\r"                            // 01, 02, 03 are lost
      "05,+00#0005\r06,+00.0006\r"               // damaged, not lost
      "07,+00.+00.0008\r09,+00.0009\r"           // two run together: one row, one line lost
      "08,+00.0009\r",                           // 10 .. 99 and 00 .. 07
      kMs);
  std::vector<std::int64_t> lost;
  for (int row = 0; row < 9; ++row) lost.push_back(NextRow().lost_before);
  EXPECT_EQ(lost, (std::vector<std::int64_t>{0, 0, 0, 3, 0, 0, 0, 1, 98}));
}

TEST_F(StreamSensorTest, EndlessGarbageIsOneBadFrame) {
  Start();
  std::string garbage(3000, 'x');
  wire_->Send(garbage.append("\r+00.0005\r"), kMs);
  EXPECT_EQ(RowStatus(NextRow()), SampleStatus::kBadFrame);
  EXPECT_EQ(Counts(NextRow()), 5);
}

TEST_F(StreamSensorTest, LettersAreStatuses) {
  Start();
  wire_->Send("+FFFFFFF\r-FFFFFFF\rXXXXXXXX\r", kMs);
  EXPECT_EQ(RowStatus(NextRow()), SampleStatus::kOver);
  EXPECT_EQ(RowStatus(NextRow()), SampleStatus::kUnder);
  EXPECT_EQ(RowStatus(NextRow()), SampleStatus::kInvalid);
}

TEST_F(StreamSensorTest, SilenceIsNothingAndAHangUpIsTheEnd) {
  Start();
  Reading reading;
  const MonotonicNs before = clock_.Now();
  EXPECT_EQ(sensor_->Next(reading), Outcome::kNothing);
  EXPECT_EQ(clock_.Now() - before, 100 * kMs);
  wire_->Send("+00.0002\r", kMs);
  wire_->HangUp(2 * kMs);
  EXPECT_EQ(sensor_->Next(reading), Outcome::kReading);
  EXPECT_EQ(sensor_->Next(reading), Outcome::kGone);
}

TEST_F(StreamSensorTest, SaysWhenNothingComes) {
  EXPECT_THAT(StartError(), HasSubstr("scripted: nothing comes at 921600 baud; check that"));
}

TEST_F(StreamSensorTest, SaysWhenLinesAreOfAnotherForm) {
  for (int i = 0; i < 30; ++i) wire_->Send("+1.2\r", 100 * kMs * i);
  EXPECT_THAT(StartError(), HasSubstr("sends lines of another form at 921600 baud: \"+1.2\"; "));
}

TEST_F(StreamSensorTest, WaitsForItsFirstLineForThreeSeconds) {
  wire_->Send("2345\r+00.0001\r", 2999 * kMs);
  EXPECT_TRUE(sensor_->Start(kNeverStop));
  EXPECT_EQ(clock_.Now(), 2999 * kMs);
  EXPECT_TRUE(wire_->written().empty()) << "nothing is written to a hardware port";
  auto transport = std::make_unique<ScriptedTransport>(clock_);
  transport->Send("2345\r+00.0001\r", 3001 * kMs);
  sensor_ = std::make_unique<StreamSensor>(std::move(transport), StreamSetup{}, clock_);
  EXPECT_FALSE(sensor_->Start(kNeverStop));
  EXPECT_EQ(clock_.Now(), 5999 * kMs);
}

TEST_F(StreamSensorTest, ShowsTheBeginningOfALineOfAnotherForm) {
  // 24 characters of it; four lines of nine characters together are one line of another form
  wire_->Send("abcdefghijklmnopqrstuvwxyz0123456789\r", kMs);
  EXPECT_THAT(StartError(), HasSubstr("baud: \"abcdefghijklmnopqrstuvwx\"; give"));
  auto transport = std::make_unique<ScriptedTransport>(clock_);
  transport->Send("abcdefghijklmnopqrstuvwxyz0123456789+\r", kMs);
  StreamSensor longer(std::move(transport), {}, clock_);
  const auto started = longer.Start(kNeverStop);
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().Text(), HasSubstr("bytes come at 921600 baud, but no line; give"));
}

TEST_F(StreamSensorTest, SaysWhenNoLineEndComes) {
  wire_->Send("\xF8\x80\x78", kMs);
  EXPECT_THAT(StartError(), HasSubstr("bytes come at 921600 baud, but no line; give the sensor's"));
}

TEST_F(StreamSensorTest, SaysWhatTheWireCanCarry) {
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kLinesRate),
            "baud=921600 characters=9 rate_hz=10240 observable_hz=4000");
  EXPECT_FALSE(sensor_->Found().Has(FindingKind::kLinesTooSlow));
  StreamSensor slow(std::make_unique<ScriptedTransport>(clock_), {.baud = 9600, .format = {}},
                    clock_);
  EXPECT_EQ(NumbersOf(slow.Found(), FindingKind::kLinesTooSlow), "needed_hz=1280");
}

TEST_F(StreamSensorTest, TheRangeIsThatOfTheDigits) {
  Start();
  const trial::ChannelFormat& channel = sensor_->header().channels.at(0);
  EXPECT_REL(channel.range_max, 99.9999e-3, 1e-15, "a product");
  EXPECT_REL(channel.range_min, -99.9999e-3, 1e-15, "a product");
  // 9 characters of 10 bits at 921600 baud
  EXPECT_EQ(sensor_->header().metadata.fields.at(std::string(trial::kLatencyField)), "9.7656e-05");
}

TEST(StreamSensorCounter, StandsInTheHeaderAndInTheFindings) {
  for (const auto& [text, numbers, last] :
       {std::tuple("000,+00.0000,mm,CR", "0 to 999", "last=999"),
        {"0,+00.0000,mm,CR", "0 to 9", "last=9"},
        {"+00.0000,mm,CR", "", ""}}) {
    const StreamFormat format = ParseStreamFormat(text).value();
    ManualClock clock;
    auto transport = std::make_unique<ScriptedTransport>(clock);
    ScriptedTransport* wire = transport.get();
    StreamSensor sensor(std::move(transport), {.baud = 9600, .format = format}, clock);
    const std::string line = FormatStreamLine(format, {1, 4, SampleStatus::kOk}, 5);
    wire->Send(line + line + line, kMs);
    ASSERT_TRUE(sensor.Start(kNeverStop));
    const auto& fields = sensor.header().metadata.fields;
    const auto field = fields.find(std::string(trial::kLineNumbersField));
    EXPECT_EQ(field == fields.end() ? "" : field->second, numbers) << text;
    EXPECT_EQ(sensor.Found().Has(FindingKind::kLinesNumbered), *last != 0) << text;
    if (*last != 0) {
      EXPECT_EQ(NumbersOf(sensor.Found(), FindingKind::kLinesNumbered), last);
    }
  }
}

TEST_F(StreamSensorTest, ARangeWithoutASignBeginsAtNought) {
  StreamFormat format;
  format.sign = SignRule::kNever;
  ManualClock clock;
  auto transport = std::make_unique<ScriptedTransport>(clock);
  ScriptedTransport* wire = transport.get();
  StreamSensor sensor(std::move(transport), {.baud = 9600, .format = format}, clock);
  wire->Send("00.0001\r00.0001\r00.0001\r", kMs);
  ASSERT_TRUE(sensor.Start(kNeverStop));
  EXPECT_EQ(sensor.header().channels.at(0).range_min, 0);
  EXPECT_REL(sensor.header().channels.at(0).range_max, 99.9999e-3, 1e-15, "a product");
}

TEST_F(StreamSensorTest, LinesOnANarrowWireAreTooSlow) {
  // 1280 lines/s are needed: 115200 baud carry them exactly, 1e-4 less is left to the clocks
  StreamSensor enough(std::make_unique<ScriptedTransport>(clock_), {.baud = 115189, .format = {}},
                      clock_);
  EXPECT_FALSE(enough.Found().Has(FindingKind::kLinesTooSlow));
  StreamSensor less(std::make_unique<ScriptedTransport>(clock_), {.baud = 115188, .format = {}},
                    clock_);
  EXPECT_TRUE(less.Found().Has(FindingKind::kLinesTooSlow));
}

TEST(StreamSensorBegin, ALineThatHadBegunIsNoRow) {
  ManualClock clock;
  auto transport = std::make_unique<ScriptedTransport>(clock);
  ScriptedTransport* wire = transport.get();
  StreamSensor sensor(std::move(transport), {.baud = 9600, .format = {}}, clock);
  wire->Send("2345\r+00.0001\r", kMs);
  ASSERT_TRUE(sensor.Start(kNeverStop));
  // one character of it had come
  wire->Send("+", kMs);
  clock.Advance(10 * kMs);
  (void)sensor.Begin();
  wire->Send("00.0002\r+00.0003\r", 10 * kMs);
  const Reading first = NextRowOf(sensor);
  EXPECT_EQ(RowStatus(first), SampleStatus::kOk);
  EXPECT_EQ(Counts(first), 3);
}

TEST(StreamSensorStart, OneByteIsNotSilence) {
  for (const char* bytes : {"", "x"}) {
    ManualClock clock;
    auto transport = std::make_unique<ScriptedTransport>(clock);
    if (*bytes != 0) transport->Send(bytes, kMs);
    StreamSensor sensor(std::move(transport), {.baud = 9600, .format = {}}, clock);
    const auto started = sensor.Start(kNeverStop);
    ASSERT_FALSE(started);
    EXPECT_THAT(started.error().Text(),
                HasSubstr(*bytes != 0 ? "bytes come at 9600 baud, but no line"
                                      : "nothing comes at 9600 baud"));
  }
}

// `lines` at once, 0.1 s after the beginning, at 9600 baud
Findings FoundAfter(int lines) {
  ManualClock clock;
  auto transport = std::make_unique<ScriptedTransport>(clock);
  ScriptedTransport* wire = transport.get();
  StreamSensor sensor(std::move(transport), {.baud = 9600, .format = {}}, clock);
  wire->Send("2345\r+00.0001\r", kMs);
  EXPECT_TRUE(sensor.Start(kNeverStop));
  (void)sensor.Begin();
  std::string text;
  for (int line = 0; line < lines; ++line) text += "+00.0001\r";
  wire->Send(text, 100 * kMs);
  for (int line = 0; line < lines; ++line) (void)NextRowOf(sensor);
  return sensor.Found();
}

TEST(StreamSensorRate, MoreLinesThanTheWireCarriesAreFound) {
  // 9.375 ms a line; what the port held from before the beginning is a second's at most
  EXPECT_FALSE(FoundAfter(117).Has(FindingKind::kLinesTooSoon)) << "1.097 s of 1.1 s";
  EXPECT_EQ(NumbersOf(FoundAfter(118), FindingKind::kLinesTooSoon),
            "lines=118 elapsed_s=0.1 baud=9600 wire_s=1.10625");
}

// a scripted transport behind which no wire of known speed is
class Network final : public Transport {
 public:
  explicit Network(Clock& clock) : scripted(clock) {}

  ReadOutcome Read(std::span<char> buffer, MonotonicNs deadline) override {
    return scripted.Read(buffer, deadline);
  }
  Result<void> Write(std::string_view bytes, MonotonicNs deadline) override {
    return scripted.Write(bytes, deadline);
  }
  std::string Source() const override { return scripted.Source(); }
  std::optional<MonotonicNs> LatencyTimer() const override { return {}; }
  bool IsHardware() const override { return false; }
  const std::string& name() const override { return scripted.name(); }

  tests::ScriptedTransport scripted;
};

// 1200 lines each 0.4 s: as the wire's speed spread them, 10 240 lines/s came, and silences
TEST(StreamBlocks, ShowTheRateOfTheSource) {
  constexpr MonotonicNs kBlockNs = 400'000'000;
  ManualClock clock;
  auto network = std::make_unique<Network>(clock);
  std::string lines;
  for (int j = 0; j < 1200; ++j) lines += "+00.0001\r";
  for (int k = 0; k < 18; ++k) network->scripted.Send(lines, k * kBlockNs);
  StreamSensor sensor(std::move(network), {}, clock);
  ASSERT_TRUE(StartAndBegin(sensor));
  std::vector<std::int64_t> times_ns;
  Reading reading;
  while (clock.Now() < 17 * kBlockNs + kBlockNs / 2) {
    if (sensor.Next(reading) == Outcome::kReading) times_ns.push_back(reading.time_ns);
  }
  const auto stretches = trial::FitArrivalTimes(times_ns, std::nullopt);
  ASSERT_EQ(stretches.size(), 1);
  EXPECT_REL(stretches[0].rate_hz, 3000, 1e-9, "blocks of one length");
  EXPECT_ABS(stretches[0].time_uncertainty_s, 0.4, 1e-12, "a block");
}

}  // namespace
}  // namespace haptometer::acquire
