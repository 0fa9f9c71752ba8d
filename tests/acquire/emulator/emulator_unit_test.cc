#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "acquire/emulator/dl_unit.h"
#include "tests/acquire/emulator_run.h"
#include "tests/residual.h"

namespace haptometer::acquire::emulator {
namespace {

using trial::SampleStatus;

constexpr MonotonicNs kMs = 1'000'000;
constexpr MonotonicNs kSecond = kNsPerS;

// an IL-030 without noise and averaging, so that every reading is known
DlRs1aSetup Quiet(trial::Displacement displacement) {
  DlRs1aSetup setup;
  setup.head = {.head = trial::Il030(), .displacement = std::move(displacement)};
  setup.head.head.noise_rms_m = 0;
  setup.head.head.averages = 1;
  return setup;
}

DlRs1aSetup Still(double position_m) {
  return Quiet([position_m](double) { return position_m; });
}

// sends `request` and waits long enough for any answer but a late one
std::string Ask(DlRs1aUnit& unit, ManualClock& clock, std::string_view request) {
  unit.Receive(request, clock.Now());
  return TextOf(RunUntil(unit, clock, clock.Now() + kSecond));
}

std::string Ask(const DlRs1aSetup& setup, std::string_view request) {
  ManualClock clock;
  DlRs1aUnit unit(setup);
  return Ask(unit, clock, request);
}

// --- bytes -----------------------------------------------------------------------------------

TEST(DlRs1aUnit, AnswersM0WithTheBytesSeenOnAWire) {
  // captured from a unit with two amplifiers: 4D 30 2C 2D 30 30 2E 30 30 37 2C ... 0D 0A
  const char expected[] = {0x4d, 0x30, 0x2c, 0x2d, 0x30, 0x30, 0x2e, 0x30, 0x30, 0x37, 0x0d, 0x0a};
  EXPECT_EQ(Ask(Still(-7e-6), "M0\r\n"), std::string(expected, sizeof expected));
}

struct Exchange {
  const char* request;
  const char* answer;
};

class DlRs1aAnswers : public ::testing::TestWithParam<Exchange> {};

TEST_P(DlRs1aAnswers, AreTheManuals) {
  EXPECT_EQ(Ask(Still(1.234e-3), GetParam().request), GetParam().answer);
}

INSTANTIATE_TEST_SUITE_P(
    Requests, DlRs1aAnswers,
    ::testing::Values(
        Exchange{"M0\r\n", "M0,+01.234\r\n"}, Exchange{"M0\r", "M0,+01.234\r\n"},
        Exchange{"MS\r\n", "MS,04,+01.234\r\n"}, Exchange{"SR,00,037\r\n", "SR,00,037,+01.234\r\n"},
        Exchange{"SR,00,038\r\n", "SR,00,038,+01.234\r\n"},
        Exchange{"SR,00,042\r\n", "SR,00,042,+1.234\r\n"},  // 1 V/mm of an IL-030
        Exchange{"SR,00,036\r\n", "SR,00,036,04\r\n"},
        Exchange{"SR,00,039\r\n", "SR,00,039,-99.998\r\n"},  // sample hold keeps no peak
        Exchange{"SR,00,033\r\n", "SR,00,033,00000\r\n"},
        Exchange{"SR,00,132\r\n", "SR,00,132,2\r\n"},  // 1 ms
        Exchange{"SR,00,133\r\n", "SR,00,133,0\r\n"},  // no averaging
        Exchange{"SR,00,136\r\n", "SR,00,136,0\r\n"}, Exchange{"SR,00,159\r\n", "SR,00,159,0\r\n"},
        Exchange{"SR,00,098\r\n", "SR,00,098,0\r\n"}, Exchange{"SR,00,152\r\n", "SR,00,152,0\r\n"},
        Exchange{"SR,00,193\r\n", "SR,00,193,4022\r\n"},
        Exchange{"SR,00,195\r\n", "SR,00,195,1\r\n"},
        Exchange{"SR,00,200\r\n", "SR,00,200,EMULATED\r\n"}));

INSTANTIATE_TEST_SUITE_P(
    Refusals, DlRs1aAnswers,
    ::testing::Values(Exchange{"SW,00,001,1\r\n", "ER,SW,67\r\n"},  // the switch stands on R
                      Exchange{"AW,001,1\r\n", "ER,AW,67\r\n"},
                      Exchange{"FR,00,037\r\n", "ER,FR,00\r\n"},  // DL-EN1 only
                      Exchange{"m0\r\n", "ER,m0,00\r\n"}, Exchange{"HELLO\r\n", "ER,HE,00\r\n"},
                      Exchange{"M0,1\r\n", "ER,M0,21\r\n"}, Exchange{"SR,00\r\n", "ER,SR,21\r\n"},
                      Exchange{"SR,0,037\r\n", "ER,SR,22\r\n"},
                      Exchange{"SR,00,37\r\n", "ER,SR,22\r\n"},
                      Exchange{"SR,00,999\r\n", "ER,SR,22\r\n"},
                      Exchange{"SR,06,101\r\n", "ER,SR,65\r\n"},  // as in the FD-S edition, p. 10
                      Exchange{"\r\n", ""}, Exchange{"M0", ""}, Exchange{"M0\n", ""}));

TEST(IlAmplifier, TakesTheCodesOfItsSettings) {
  // data numbers and highest codes of the communication unit's manual: bank, sampling cycle,
  // averaging, hold, memory of the zero shift, cutoff of the high-pass filter
  for (const auto& [number, highest] :
       {std::pair(98, 3), {132, 4}, {133, 14}, {136, 5}, {152, 1}, {159, 9}}) {
    IlAmplifier amplifier(Still(0).head, true);
    EXPECT_EQ(amplifier.Write(number, highest, 0), IlWriteOutcome::kDone) << number;
    EXPECT_EQ(amplifier.Read(number, {})->number, highest) << number;
    EXPECT_EQ(amplifier.Write(number, highest + 1, 0), IlWriteOutcome::kOutOfRange) << number;
    EXPECT_EQ(amplifier.Write(number, -1, 0), IlWriteOutcome::kOutOfRange) << number;
  }
}

SampleStatus StatusAt(const IlAmplifier& amplifier, MonotonicNs time_ns) {
  return amplifier.ReadingAt(time_ns, time_ns).status;
}

// data 132 and 133 and what two means of as many samples take, in ns
struct Settling {
  int number;
  int code;
  MonotonicNs two_means_ns;
};

TEST(IlAmplifier, ShowsNoValueForTwoMeansAfterAChange) {
  // an amplifier that begins with 1 ms and one average; 0 is the default, 1 ms; 13 is a filter
  for (const auto& [number, code, two_means_ns] : {Settling{133, 4, 32 * kMs},
                                                   {133, 12, 8192 * kMs},
                                                   {132, 1, 660'000},
                                                   {132, 0, 2 * kMs},
                                                   {132, 4, 10 * kMs},
                                                   {133, 13, 2 * kMs},
                                                   {136, 2, 2 * kMs}}) {
    IlAmplifier amplifier(Still(1e-3).head, true);
    EXPECT_EQ(amplifier.Write(number, code, kSecond), IlWriteOutcome::kDone);
    EXPECT_EQ(StatusAt(amplifier, kSecond + two_means_ns - 1), SampleStatus::kInvalid) << number;
    EXPECT_EQ(StatusAt(amplifier, kSecond + two_means_ns), SampleStatus::kOk)
        << number << ' ' << code;
  }
  // bank, memory of the zero shift, cutoff
  for (const int number : {98, 152, 159}) {
    IlAmplifier amplifier(Still(1e-3).head, true);
    EXPECT_EQ(amplifier.Write(number, 1, kSecond), IlWriteOutcome::kDone);
    EXPECT_EQ(StatusAt(amplifier, kSecond), SampleStatus::kOk) << number;
  }
}

TEST(IlAmplifier, AZeroShiftIsAddedToTheOneBefore) {
  // 1 mm at rest up to 10 s, then 3 mm
  IlAmplifier amplifier(Quiet([](double t_s) { return t_s < 10 ? 1e-3 : 3e-3; }).head, true);
  for (const MonotonicNs now : {1 * kSecond, 11 * kSecond}) {
    EXPECT_EQ(amplifier.Write(1, 0, now), IlWriteOutcome::kDone);
    EXPECT_EQ(amplifier.Write(1, 1, now), IlWriteOutcome::kDone);
    EXPECT_EQ(amplifier.ReadingAt(now, now).counts, 0);
  }
  EXPECT_EQ(amplifier.ReadingAt(kSecond, 11 * kSecond).counts, -2000) << "3 mm are 0 now";
}

// millivolts of data 042 where the value is `counts`
int AnalogMv(const char* head, int counts, int decimals, const AnalogOutput& analog = {}) {
  MovingHead moving = Still(0).head;
  moving.head.name = head;
  moving.analog = analog;
  const IlAmplifier amplifier(moving, true);
  EXPECT_EQ(amplifier.decimals(), decimals);
  return amplifier.Read(42, {.counts = counts, .decimals = decimals})->number;
}

TEST(IlAmplifier, ItsOutputIsFiveVoltsAtTheEndOfTheLinearRange) {
  // linear within 5, 10 and 140 mm of the reference; 5 mm where the range is not known
  EXPECT_EQ(AnalogMv("IL-030", 1234, 3), 1234);
  EXPECT_EQ(AnalogMv("IL-030", -4999, 3), -4999);
  EXPECT_EQ(AnalogMv("IL-065", 1000, 3), 500);
  EXPECT_EQ(AnalogMv("IL-300", 2800, 2), 1000);
  EXPECT_EQ(AnalogMv("IL-2000", 10, 1), 1000);
  // beyond, it stays
  EXPECT_EQ(AnalogMv("IL-030", 5001, 3), 5000);
  EXPECT_EQ(AnalogMv("IL-030", -7000, 3), -5000);
}

TEST(IlAmplifier, ItsOutputHasTheErrorThatIsStated) {
  const AnalogOutput analog{.gain_error = 1.01, .offset_error_v = 0.002};
  EXPECT_EQ(AnalogMv("IL-030", 1000, 3, analog), 1012);
  EXPECT_EQ(AnalogMv("IL-030", 7000, 3, analog), 5052);
  EXPECT_EQ(AnalogMv("IL-030", -7000, 3, analog), -5048);
}

TEST(AnalogVolts, AreFiveAndAHalfBeyondTheRange) {
  const trial::SensorHead head = trial::Il030();
  EXPECT_REL(AnalogVolts(head, 1.234e-3), 1.234, 1e-15, "a product");
  EXPECT_REL(AnalogVolts(head, -4.9e-3), -4.9, 1e-15, "a product");
  EXPECT_EQ(AnalogVolts(head, 10e-3), 5) << "within the range, beyond the linear part";
  EXPECT_EQ(AnalogVolts(head, -15e-3), -5);
  EXPECT_EQ(AnalogVolts(head, 10.001e-3), 5.5);
  EXPECT_EQ(AnalogVolts(head, -15.001e-3), 5.5);
}

TEST(DlRs1aUnit, RefusesALineTooLongAndUnderstandsTheNext) {
  ManualClock clock;
  DlRs1aUnit unit(Still(0));
  EXPECT_EQ(Ask(unit, clock, "SR," + std::string(200, '7') + "\r\n"), "ER,SR,20\r\n");
  EXPECT_EQ(Ask(unit, clock, "M0\r\n"), "M0,+00.000\r\n");
}

TEST(DlRs1aUnit, ShowsPlacesBeyondTheRangeAsTheManualSays) {
  EXPECT_EQ(Ask(Still(10.4e-3), "M0\r\n"), "M0,+99.999\r\n");
  EXPECT_EQ(Ask(Still(-15.4e-3), "M0\r\n"), "M0,-99.999\r\n");
  EXPECT_EQ(Ask(Still(10.4e-3), "MS\r\n"), "MS,01,+99.999\r\n");
  EXPECT_EQ(Ask(Still(-15.4e-3), "MS\r\n"), "MS,02,-99.999\r\n");
  EXPECT_EQ(Ask(Still(10e-3), "M0\r\n"), "M0,+10.000\r\n");
  // a nought from below keeps its plus sign
  EXPECT_EQ(Ask(Still(-0.4e-6), "M0\r\n"), "M0,+00.000\r\n");
}

// --- time ------------------------------------------------------------------------------------

TEST(SerialLine, CarriesOneByteAfterTheOther) {
  // 10 bits at 1 Mbaud: 10 us a byte; one that is ready early waits, one that is late begins anew
  SerialLine line(1'000'000);
  EXPECT_EQ(line.Send(0), 10'000);
  EXPECT_EQ(line.Send(0), 20'000);
  EXPECT_EQ(line.Send(15'000), 30'000);
  EXPECT_EQ(line.Send(30'000), 40'000);
  EXPECT_EQ(line.Send(45'000), 55'000);
  EXPECT_EQ(line.Send(45'001), 65'000);
}

TEST(MovingHead, ASampleIsThereFromItsTimeOn) {
  for (const double sampling_s : {0.33e-3, 1e-3, 1e-4, 1.0 / 3}) {
    MovingHead head = Still(0).head;
    head.head.sampling_s = sampling_s;
    for (const std::int64_t number : {1, 2, 3, 1000, 123'457}) {
      const MonotonicNs time_ns = head.SampleTime(number);
      EXPECT_ABS(static_cast<double>(time_ns), static_cast<double>(number) * sampling_s * 1e9, 0.5,
                 "rounded to a nanosecond");
      EXPECT_EQ(head.LastSample(time_ns), number);
      EXPECT_EQ(head.LastSample(time_ns - 1), number - 1);
    }
    EXPECT_EQ(head.LastSample(0), 0);
  }
}

struct Pace {
  int baud;
  double period_ms;  // 4 characters + 4 ms + 12 characters, of 10 bits
};

class DlRs1aPace : public ::testing::TestWithParam<Pace> {};

TEST_P(DlRs1aPace, IsTheWiresForEveryByte) {
  DlRs1aSetup setup = Still(0);
  setup.baud = GetParam().baud;
  ManualClock clock;
  DlRs1aUnit unit(setup);
  unit.Receive("M0\r\n", 0);
  const auto bytes = RunUntil(unit, clock, kSecond);
  ASSERT_EQ(bytes.size(), 12U);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const double expected_ms = 4 + 1e4 * static_cast<double>(4 + i + 1) / GetParam().baud;
    EXPECT_ABS(static_cast<double>(bytes[i].time) * 1e-6, expected_ms, 2e-6,
               "two times rounded down to a nanosecond");
  }
  EXPECT_ABS(static_cast<double>(bytes.back().time) * 1e-6, GetParam().period_ms, 5e-3,
             "two decimals of a printed table");
}

TEST_P(DlRs1aPace, IsKeptOverManyPollsAndNeverExceeded) {
  DlRs1aSetup setup = Still(0);
  setup.baud = GetParam().baud;
  ManualClock clock;
  DlRs1aUnit unit(setup);
  constexpr int kPolls = 1000;
  for (int poll = 0; poll < kPolls; ++poll) {
    unit.Receive("M0\r\n", clock.Now());
    std::string answer;
    while (!answer.ends_with('\n')) {
      ASSERT_TRUE(unit.NextDue());
      clock.SleepUntil(*unit.NextDue());
      unit.Advance(clock.Now(), answer);
    }
  }
  const double period_ns = 4e6 + 16e10 / GetParam().baud;
  EXPECT_ABS(static_cast<double>(clock.Now()), kPolls * period_ns, 2.0 * kPolls,
             "two times rounded down to a nanosecond in every poll");
}

INSTANTIATE_TEST_SUITE_P(Bauds, DlRs1aPace,
                         ::testing::Values(Pace{2400, 70.67}, Pace{4800, 37.33}, Pace{9600, 20.67},
                                           Pace{19200, 12.33}, Pace{38400, 8.17}));

TEST(DlRs1aUnit, CountsProcessingFromTheEndOfTheDelimiter) {
  // the bare CR saves one character; a LF that comes later than processing takes changes nothing
  ManualClock clock;
  DlRs1aUnit unit(Still(0));
  unit.Receive("M0\r", 0);
  const auto bytes = RunUntil(unit, clock, kSecond);
  EXPECT_ABS(static_cast<double>(bytes.front().time), 4e6 + 4e10 / 9600, 2, "rounding down");
  EXPECT_EQ(Ask(unit, clock, "\n"), "");
  EXPECT_EQ(Ask(unit, clock, "M0\r"), "M0,+00.000\r\n");
}

TEST(DlRs1aUnit, ALineFeedWithinTheProcessingBeginsItAnew) {
  // 3 characters at 9600 baud are 3.125 ms and processing is 4 ms: a LF 1 ns before 7.125 ms is on
  // the wire for a character, and 4 ms later the answer begins
  ManualClock clock;
  DlRs1aUnit unit(Still(0));
  unit.Receive("M0\r", 0);
  (void)RunUntil(unit, clock, 7'124'999);
  unit.Receive("\n", 7'124'999);
  const auto bytes = RunUntil(unit, clock, kSecond);
  ASSERT_EQ(bytes.size(), 12U);
  EXPECT_ABS(static_cast<double>(bytes.front().time), 7'124'999 + 4e6 + 2e10 / 9600, 2,
             "two times rounded down to a nanosecond");
}

TEST(DlRs1aUnit, GivesNothingToOneWhoDoesNotWaitForTheAnswer) {
  ManualClock clock;
  DlRs1aUnit unit(Still(0));
  unit.Receive("M0\r\nM0\r\nM0\r\n", 0);
  const auto bytes = RunUntil(unit, clock, kSecond);
  ASSERT_EQ(bytes.size(), 36U);
  EXPECT_ABS(static_cast<double>(bytes.back().time), 3 * (4e6 + 16e10 / 9600), 6,
             "six times rounded down");
}

TEST(DlRs1aUnit, LosesWhatItsReceiveBufferDoesNotHold) {
  ManualClock clock;
  DlRs1aUnit unit(Still(0));
  std::string requests;
  for (int i = 0; i < 100; ++i) requests += "M0\r\n";
  unit.Receive(requests, 0);
  EXPECT_EQ(RunUntil(unit, clock, 10 * kSecond).size(), 12 * 256U / 4);
}

TEST(DlRs1aUnit, TakesLongerForADirectRead) {
  ManualClock clock;
  DlRs1aUnit unit(Still(0));
  unit.Receive("SR,00,037\r\n", 0);
  const auto bytes = RunUntil(unit, clock, kSecond);
  EXPECT_ABS(static_cast<double>(bytes.back().time), 13e6 + (11 + 19) * 1e10 / 9600, 2,
             "two times rounded down");
}

// when the last byte of the answer to `request` has come, sent at 0
double LastByteNs(const DlRs1aSetup& setup, std::string_view request) {
  ManualClock clock;
  DlRs1aUnit unit(setup);
  unit.Receive(request, 0);
  const auto bytes = RunUntil(unit, clock, 2 * kSecond);
  return bytes.empty() ? 0 : static_cast<double>(bytes.back().time);
}

TEST(DlRs1aUnit, EachCommandHasItsProcessingTime) {
  // T4: M0 and MS 4 ms, SR and SW 13 ms, AW 57 ms; refused ones too. Characters of both ways
  struct Timed {
    const char* request;
    double processing_ns;
    int characters;
  };
  for (const auto& [request, processing_ns, characters] :
       {Timed{"MS\r\n", 4e6, 4 + 15}, Timed{"SW,00,001,1\r\n", 13e6, 13 + 10},
        Timed{"AW,001,1\r\n", 57e6, 10 + 10}, Timed{"FR,00,037\r\n", 13e6, 11 + 10}}) {
    EXPECT_ABS(LastByteNs(Still(0), request), processing_ns + characters * 1e10 / 9600, 2,
               "two times rounded down to a nanosecond");
  }
}

// --- readings --------------------------------------------------------------------------------

TEST(DlRs1aUnit, RepeatsTheBufferedReadingUntilItsRefresh) {
  // a ramp of 1 mm/s: the reading names its own sample in ms
  DlRs1aSetup setup = Quiet([](double t_s) { return 1e-3 * t_s; });
  setup.baud = 38400;
  setup.refresh_ns = 20 * kMs;
  ManualClock clock;
  DlRs1aUnit unit(setup);
  std::vector<std::string> answers;
  for (int poll = 0; poll < 8; ++poll) {
    unit.Receive("M0\r\n", clock.Now());
    std::string answer;
    while (!answer.ends_with('\n')) {
      clock.SleepUntil(*unit.NextDue());
      unit.Advance(clock.Now(), answer);
    }
    answers.push_back(answer.substr(3, 7));
  }
  // processed at 5.04 ms + poll * 8.167 ms; refreshed at 0, 20, 40, 60 ms
  EXPECT_EQ(answers, (std::vector<std::string>{"+00.000", "+00.000", "+00.020", "+00.020",
                                               "+00.020", "+00.040", "+00.040", "+00.060"}));
}

TEST(DlRs1aUnit, ReadsTheHeadsLastAverage) {
  DlRs1aSetup setup;
  setup.head = {.head = trial::Il030(), .displacement = [](double) { return 0.0; }, .seed = 7};
  setup.baud = 38400;
  // processed at 4 / 3840 s + 4 ms = 5.04 ms: refreshed at 0; after 100 ms at 105.04: 105, sample
  // 105
  ManualClock clock;
  DlRs1aUnit unit(setup);
  clock.Advance(100 * kMs);
  const std::string answer = Ask(unit, clock, "M0\r\n");
  const auto reading = trial::ReadingAt(trial::Il030(), setup.head.displacement, 105, 7);
  EXPECT_EQ(answer, dl::FormatM0Reply(dl_rs1a::Spelling(),
                                      std::vector<Value>{{.counts = static_cast<std::int32_t>(
                                                              std::lround(reading.value_m * 1e6)),
                                                          .decimals = 3}}));
  EXPECT_NE(reading.value_m, 0);
}

// --- splits ----------------------------------------------------------------------------------

// the bytes and when they were due do not depend on how often, and how late, the unit is asked
TEST(DlRs1aUnit, GivesTheSameBytesHoweverItIsCalled) {
  DlRs1aSetup setup = Quiet([](double t_s) { return 1e-3 * t_s; });
  const std::vector<std::pair<MonotonicNs, std::string>> script = {{0, "M0"},
                                                                   {3 * kMs, "\r"},
                                                                   {6 * kMs, "\nMS\r"},
                                                                   {50 * kMs, "\nSR,00,"},
                                                                   {51 * kMs, "037\r\nM0\r\n"},
                                                                   {200 * kMs, "\r\n\r\nXX\r"}};
  std::mt19937 random(1);
  std::string reference;
  for (int run = 0; run < 50; ++run) {
    DlRs1aUnit unit(setup);
    std::string out;
    MonotonicNs now = 0;
    std::uniform_int_distribution<MonotonicNs> step(1, run == 0 ? 10'000 : 40 * kMs);
    for (const auto& [time, bytes] : script) {
      for (; now < time; now += step(random)) unit.Advance(now, out);
      now = time;
      unit.Receive(bytes, now);
    }
    unit.Advance(kSecond, out);
    if (run == 0) reference = out;
    EXPECT_EQ(out, reference) << run;
  }
  EXPECT_EQ(std::count(reference.begin(), reference.end(), '\n'), 5) << reference;
}

// --- faults ----------------------------------------------------------------------------------

DlRs1aSetup Faulty(std::string_view plan) {
  DlRs1aSetup setup = Still(1.234e-3);
  setup.faults = *ParseFaultPlan(plan);
  return setup;
}

TEST(DlRs1aFaults, StrikeAsTheirNamesSay) {
  EXPECT_EQ(Ask(Faulty("silent"), "M0\r\n"), "");
  EXPECT_EQ(Ask(Faulty("truncate"), "M0\r\n"), "M0,+0");
  EXPECT_EQ(Ask(Faulty("error"), "M0\r\n"), "ER,M0,29\r\n");
  EXPECT_EQ(Ask(Faulty("invalid"), "M0\r\n"), "M0,-99.998\r\n");
  EXPECT_EQ(Ask(Faulty("over"), "MS\r\n"), "MS,01,+99.999\r\n");
  EXPECT_EQ(Ask(Faulty("invalid"), "SR,00,195\r\n"), "SR,00,195,1\r\n");

  const std::string garbage = Ask(Faulty("garbage"), "M0\r\n");
  ASSERT_EQ(garbage.size(), 12U);
  EXPECT_TRUE(garbage.ends_with("\r\n"));
  for (const char byte : garbage.substr(0, 10)) EXPECT_LT(byte, 0);
}

TEST(DlRs1aFaults, LateAnswersComeAfterTheManualsBound) {
  ManualClock clock;
  DlRs1aUnit unit(Faulty("late"));
  unit.Receive("M0\r\n", 0);
  const auto bytes = RunUntil(unit, clock, 2 * kSecond);
  ASSERT_EQ(bytes.size(), 12U);
  EXPECT_ABS(static_cast<double>(bytes.back().time), 1.5e9 + 4e6 + 16e10 / 9600, 2, "rounding");
}

TEST(DlRs1aFaults, SlowAnswersAndPausesLastAsLongAsTheySay) {
  EXPECT_ABS(LastByteNs(Faulty("slow"), "M0\r\n"), 0.4e9 + 4e6 + 16e10 / 9600, 2, "rounding");
  // the second half is ready 0.3 s after the first; six characters of it then cross the wire
  EXPECT_ABS(LastByteNs(Faulty("byte-gap"), "M0\r\n"), 0.3e9 + 4e6 + (4 + 6) * 1e10 / 9600, 2,
             "rounding");
}

TEST(DlRs1aFaults, WithoutATargetTheAlarmIsOut) {
  EXPECT_EQ(Ask(Faulty("invalid"), "MS\r\n"), "MS,08,-99.998\r\n");
  EXPECT_EQ(Ask(Faulty("invalid"), "SR,00,036\r\n"), "SR,00,036,08\r\n");
  EXPECT_EQ(Ask(Faulty("invalid"), "SR,00,042\r\n"), "SR,00,042,+5.500\r\n");
  EXPECT_EQ(Ask(Faulty("over"), "SR,00,036\r\n"), "SR,00,036,01\r\n");
  EXPECT_EQ(Ask(Faulty("under"), "SR,00,036\r\n"), "SR,00,036,02\r\n");
}

TEST(DlRs1aFaults, StrikeEverySoManyAnswers) {
  ManualClock clock;
  DlRs1aUnit unit(Faulty("silent:3"));
  std::string heard;
  for (int i = 1; i <= 9; ++i) heard += Ask(unit, clock, "M0\r\n").empty() ? '-' : '+';
  EXPECT_EQ(heard, "++-++-++-");
}

TEST(DlRs1aFaults, DisconnectDropsTheLineOnce) {
  ManualClock clock;
  DlRs1aUnit unit(Faulty("disconnect:2"));
  EXPECT_EQ(Ask(unit, clock, "M0\r\n"), "M0,+01.234\r\n");
  EXPECT_FALSE(unit.TakeHangUp());
  EXPECT_EQ(Ask(unit, clock, "M0\r\n"), "");
  EXPECT_TRUE(unit.TakeHangUp());
  EXPECT_FALSE(unit.TakeHangUp());
  EXPECT_EQ(Ask(unit, clock, "M0\r\n"), "M0,+01.234\r\n");
}

TEST(FaultPlan, IsRefusedWithWhatIsKnown) {
  const auto name = ParseFaultPlan("sulking:3");
  ASSERT_FALSE(name);
  EXPECT_EQ(name.error().cause, Cause::kUsage);
  EXPECT_EQ(name.error().Text(),
            "<fault>: 'sulking' is not a fault; give one of silent, slow, late, byte-gap, "
            "truncate, garbage, merged, wrong-id, error, invalid, over, under, amplifier-error, "
            "disconnect, crc, slave, transaction, word-order");
  for (const char* text :
       {"silent:", "silent:0", "silent:-1", "silent:1.5", "silent:99999999999999999999"}) {
    const auto every = ParseFaultPlan(text);
    ASSERT_FALSE(every) << text;
    EXPECT_EQ(every.error().remedy, "give silent:EVERY with a whole number from 1");
  }
  EXPECT_EQ(ParseFaultPlan("silent:1").value().every, 1);
}

TEST(Damaged, IsHalfOrNoneOrNoiseOfTheText) {
  EXPECT_EQ(Damaged("M0,+01\r\n", Damage::kNone, 1), "M0,+01\r\n");
  EXPECT_EQ(Damaged("M0,+01\r\n", Damage::kMissing, 1), "");
  EXPECT_EQ(Damaged("M0,+01\r\n", Damage::kTruncated, 1), "M0,");
  EXPECT_EQ(Damaged("M0,+0\r", Damage::kTruncated, 1), "M0") << "five characters and an end";
  const std::string noise = Damaged("M0,+01\r\n", Damage::kGarbled, 1);
  EXPECT_TRUE(noise.ends_with("\r\n"));
  EXPECT_EQ(noise.size(), 8U);
  EXPECT_EQ(noise, Damaged("M0,+99\r\n", Damage::kGarbled, 1)) << "of its number alone";
  EXPECT_NE(noise, Damaged("M0,+01\r\n", Damage::kGarbled, 2));
  // Numerical Recipes, 7.1: 3C6EF35F 47502932 D1CCF6E9 AAF95334 6252E503; their first bytes, with
  // the top bit
  EXPECT_EQ(Damaged("M0,+0\r", Damage::kGarbled, 0), "\xBC\xC7\xD1\xAA\xE2\r");
}

TEST(Faults, ThoseOfAnswersNeedAQuestion) {
  std::string asked;
  std::string modbus;
  for (const Fault& fault : Faults()) {
    if (NeedsAQuestion(fault)) asked += std::string(fault.name) + " ";
    if (fault.is_modbus) modbus += std::string(fault.name) + " ";
  }
  EXPECT_EQ(asked, "slow late byte-gap merged wrong-id error ");
  EXPECT_EQ(modbus, "crc slave transaction word-order ");
}

// --- settings --------------------------------------------------------------------------------

TEST(DlRs1aSetup, IsRefusedWhereTheDeviceHasNoSuchSetting) {
  DlRs1aSetup setup = Still(0);
  EXPECT_TRUE(Validate(setup));
  setup.baud = 115200;
  EXPECT_EQ(Validate(setup).error().Text(),
            "<baud>: a DL-RS1A has no 115200 baud; give one of 9600, 2400, 4800, 19200, 38400");
  EXPECT_EQ(Validate(setup).error().cause, Cause::kUsage);
  setup = Still(0);
  setup.head.head.sampling_s = 3e-3;
  EXPECT_EQ(Validate(setup).error().Text(),
            "<sampling>: an IL-1000 does not sample every 3 ms; give one of 0.33, 1, 2, 5 ms");
  setup = Still(0);
  setup.head.head.averages = 12;
  EXPECT_EQ(Validate(setup).error().Text(),
            "<averages>: an IL-1000 does not average 12; give a power of two from 1 to 4096");
  setup.head.head.averages = 128;
  EXPECT_TRUE(Validate(setup));
  EXPECT_EQ(Ask(setup, "SR,00,133\r\n"), "SR,00,133,7\r\n");
}

}  // namespace
}  // namespace haptometer::acquire::emulator
