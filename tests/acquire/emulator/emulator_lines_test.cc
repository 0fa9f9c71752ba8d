// The emulated DL-EN1, LK-G3001 and a DL-RS1A with several amplifiers: their bytes, what writing to
// them does, and what the faults of answers do to bytes and times.
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "acquire/emulator/dl_unit.h"
#include "acquire/emulator/lkg_unit.h"
#include "tests/acquire/emulator_run.h"
#include "tests/acquire/il_series_emulated.h"
#include "tests/residual.h"

namespace haptometer::acquire::emulator {
namespace {

constexpr MonotonicNs kMs = 1'000'000;

// sends `request` and waits long enough for any answer but a late one
std::string Ask(Device& device, ManualClock& clock, std::string_view request) {
  device.Receive(request, clock.Now());
  return TextOf(RunUntil(device, clock, clock.Now() + kNsPerS));
}

struct Exchange {
  const char* request;
  const char* answer;
};

// --- DL-EN1 ----------------------------------------------------------------------------------

class DlEn1Answers : public ::testing::TestWithParam<Exchange> {};

TEST_P(DlEn1Answers, AreTheManuals) {
  ManualClock clock;
  DlEn1Unit unit({.heads = {StillHead(12.345e-3, "IL-065"), StillHead(-0.056789, "IL-300")}});
  EXPECT_EQ(Ask(unit, clock, GetParam().request), GetParam().answer);
}

INSTANTIATE_TEST_SUITE_P(
    Requests, DlEn1Answers,
    ::testing::Values(Exchange{"SR,01,195\r\n", "SR,01,195,+000000002\r\n"},
                      Exchange{"SR,02,195\r\n", "SR,02,195,+000000004\r\n"},
                      Exchange{"SR,01,200\r\n", "SR,01,200,EMULATED\r\n"},
                      Exchange{"FR,01,037\r\n", "FR,01,037,+000000003\r\n"},
                      Exchange{"FR,02,037\r\n", "FR,02,037,+000000002\r\n"},
                      Exchange{"FR,02,038\r\n", "FR,02,038,+000000002\r\n"},
                      Exchange{"FR,02,042\r\n", "FR,02,042,+000000003\r\n"},  // millivolts
                      Exchange{"FR,01,038\r\n", "FR,01,038,+000000003\r\n"},
                      Exchange{"FR,01,195\r\n", "FR,01,195,+000000000\r\n"},  // a code
                      Exchange{"FR,00,037\r\n", "ER,FR,022\r\n"},
                      Exchange{"FR,03,037\r\n", "ER,FR,022\r\n"},
                      Exchange{"FR,01,999\r\n", "ER,FR,020\r\n"},
                      Exchange{"SR,01,193\r\n", "SR,01,193,+000004022\r\n"},
                      Exchange{"SR,02,193\r\n", "SR,02,193,+000004023\r\n"},
                      Exchange{"SR,00,195\r\n", "ER,SR,022\r\n"},  // 00 is the unit itself
                      Exchange{"SR,03,195\r\n", "ER,SR,022\r\n"},
                      Exchange{"SR,01,999\r\n", "ER,SR,020\r\n"},
                      Exchange{"SW,01,132,+000000001\r\n", "ER,SW,014\r\n"},
                      Exchange{"AW,132,1\r\n", "ER,AW,255\r\n"},  // DL-RS1A only
                      Exchange{"ZZ\r\n", "ER,ZZ,255\r\n"}));

TEST(DlEn1Unit, SaysWhyItDoesNotWrite) {
  ManualClock clock;
  DlEn1Unit unit({.heads = {StillHead(0)}, .is_writable = true});
  EXPECT_EQ(Ask(unit, clock, "SW,01,037,+000000001\r\n"), "ER,SW,014\r\n") << "read only";
  EXPECT_EQ(Ask(unit, clock, "SW,01,999,+000000001\r\n"), "ER,SW,020\r\n") << "no such number";
  // a request for a shift is 0 or 1
  for (const char* code : {"+000000002", "-000000001"}) {
    EXPECT_EQ(Ask(unit, clock, std::string("SW,01,001,") + code + "\r\n"), "ER,SW,009\r\n");
  }
  EXPECT_EQ(Ask(unit, clock, "SW,01,001,+000000001\r\n"), "SW,01,001\r\n");
}

TEST(DlEn1Unit, SendsValuesWithoutAPoint) {
  ManualClock clock;
  // 5 mm is within both ranges; two decimals of an IL-300, three of an IL-030
  DlEn1Unit unit({.heads = {StillHead(5.678e-3), StillHead(-5.67e-3, "IL-300")}});
  EXPECT_EQ(Ask(unit, clock, "M0\r\n"), "M0,+000005678,-000000567\r\n");
  EXPECT_EQ(Ask(unit, clock, "MS\r\n"), "MS,04,+000005678,04,-000000567\r\n");
  EXPECT_EQ(Ask(unit, clock, "SR,02,037\r\n"), "SR,02,037,-000000567\r\n");
}

TEST(DlEn1Unit, HasTheUnitsSpecialValuesInM0AndTheAmplifiersInSr) {
  ManualClock clock;
  DlEn1Unit over({.heads = {StillHead(10.4e-3)}});
  EXPECT_EQ(Ask(over, clock, "M0\r\n"), "M0,+099999999\r\n");
  EXPECT_EQ(Ask(over, clock, "SR,01,037\r\n"), "SR,01,037,+000099999\r\n");
  ManualClock another;
  DlEn1Unit broken({.heads = {StillHead(0)}, .faults = *ParseFaultPlan("amplifier-error")});
  EXPECT_EQ(Ask(broken, another, "M0\r\n"), "M0,+100000000\r\n");
  EXPECT_EQ(Ask(broken, another, "SR,01,037\r\n"), "SR,01,037,+000100000\r\n");
}

// --- LK-G3001 --------------------------------------------------------------------------------

TEST(LkgUnit, AnswersInItsModes) {
  ManualClock clock;
  LkgUnit unit({.heads = {StillHead(1.234e-3)}});
  EXPECT_EQ(Ask(unit, clock, "M1\r"), "M1,+01.2340\r");
  EXPECT_EQ(Ask(unit, clock, "m1\r"), "M1,+01.2340\r") << "either case";
  EXPECT_EQ(Ask(unit, clock, "M2\r"), "M2,XXXXXXXX\r") << "no second head";
  EXPECT_EQ(Ask(unit, clock, "M0\r"), "M0,+01.2340,XXXXXXXX\r");
  EXPECT_EQ(Ask(unit, clock, "ZZ\r"), "ER,ZZ,00\r");
  EXPECT_EQ(Ask(unit, clock, "Q0\r"), "Q0\r");
  EXPECT_EQ(Ask(unit, clock, "M1\r"), "ER,M1,01\r") << "measures nothing in communication mode";
  EXPECT_EQ(Ask(unit, clock, "R0\r"), "R0\r");
  EXPECT_EQ(Ask(unit, clock, "M1\r"), "M1,+01.2340\r");
  EXPECT_EQ(Ask(unit, clock, std::string(40, 'x') + "\r"), "ER,xx,20\r");
}

// a still head whose range has no end
MovingHead EndlessHead(double position_m) {
  MovingHead head = StillHead(position_m);
  head.head.resolution_m = 0;
  head.head.range_min_m = -1e6;
  head.head.range_max_m = 1e6;
  return head;
}

TEST(DlEn1Unit, ShowsOverAndUnderBeyondTheAmplifiersDisplay) {
  // an IL-030 shows three decimals in five digits, and -99.998 and -99.999 are no measurements
  const auto shown = [](double position_m) {
    ManualClock clock;
    DlEn1Unit unit({.heads = {EndlessHead(position_m)}});
    return Ask(unit, clock, "SR,01,037\r\n");
  };
  EXPECT_EQ(shown(99.998e-3), "SR,01,037,+000099998\r\n");
  EXPECT_EQ(shown(-99.997e-3), "SR,01,037,-000099997\r\n");
  for (const double beyond_m : {99.999e-3, 0.1, 0.2, 1e5}) {
    EXPECT_EQ(shown(beyond_m), "SR,01,037,+000099999\r\n") << beyond_m;
    EXPECT_EQ(shown(-beyond_m), "SR,01,037,-000099999\r\n") << beyond_m;
  }
  EXPECT_EQ(shown(-99.998e-3), "SR,01,037,-000099999\r\n");
  // a zero shift takes what the head measures, not what the display holds
  ManualClock clock;
  DlEn1Unit far({.heads = {EndlessHead(-0.12)}, .is_writable = true});
  EXPECT_EQ(Ask(far, clock, "SW,01,001,+000000001\r\n"), "SW,01,001\r\n");
  EXPECT_EQ(Ask(far, clock, "SR,01,037\r\n"), "SR,01,037,+000000000\r\n");
}

// what OUT1 shows for a target at `position_m`, of a head without an end
std::string ShownAt(double position_m, int decimals) {
  const MovingHead head = EndlessHead(position_m);
  ManualClock clock;
  LkgUnit unit({.heads = {head}, .decimals = decimals});
  return Ask(unit, clock, "M1\r");
}

TEST(LkgUnit, ShowsOverAndUnderBeyondItsDisplay) {
  // seven characters: six digits and a point, or seven digits
  EXPECT_EQ(ShownAt(99.9999e-3, 4), "M1,+99.9999\r");
  EXPECT_EQ(ShownAt(100e-3, 4), "M1,+FFFFFFF\r");
  EXPECT_EQ(ShownAt(-99.9999e-3, 4), "M1,-99.9999\r");
  EXPECT_EQ(ShownAt(-100e-3, 4), "M1,-FFFFFFF\r");
  EXPECT_EQ(ShownAt(99.9999, 1), "M1,+99999.9\r");
  EXPECT_EQ(ShownAt(100, 1), "M1,+FFFFFFF\r");
  EXPECT_EQ(ShownAt(9999.999, 0), "M1,+9999999\r");
  EXPECT_EQ(ShownAt(10'000, 0), "M1,+FFFFFFF\r");
}

TEST(LkgUnit, AnswersAfterItsProcessing) {
  // 3 characters, 3 ms, 12 characters of 10 bits at 9600 baud
  ManualClock clock;
  LkgUnit unit({.heads = {StillHead(0)}});
  unit.Receive("M1\r", 0);
  const auto bytes = RunUntil(unit, clock, kNsPerS);
  ASSERT_EQ(bytes.size(), 12U);
  EXPECT_ABS(static_cast<double>(bytes.back().time), 3e6 + 15e10 / 9600, 2,
             "two times rounded down to a nanosecond");
}

TEST(LkgUnit, TheSecondOutputIsTheSecondHead) {
  ManualClock clock;
  LkgUnit unit({.heads = {StillHead(1.234e-3), StillHead(-5.678e-3)}});
  EXPECT_EQ(Ask(unit, clock, "M2\r"), "M2,-05.6780\r");
  EXPECT_EQ(Ask(unit, clock, "M0\r"), "M0,+01.2340,-05.6780\r");
}

TEST(LkgUnit, RefusesByTheFirstTwoCharacters) {
  ManualClock clock;
  LkgUnit unit({.heads = {StillHead(0)}});
  EXPECT_EQ(Ask(unit, clock, "ABC\r"), "ER,AB,00\r");
  EXPECT_EQ(Ask(unit, clock, "ab" + std::string(40, 'x') + "\r"), "ER,ab,20\r");
}

TEST(LkgUnit, IsRefusedWithoutABaudRate) {
  EXPECT_TRUE(Validate(LkgSetup{.baud = 1, .heads = {StillHead(0)}}));
  EXPECT_TRUE(Validate(LkgSetup{.heads = {StillHead(0), StillHead(0)}}));
  const auto none = Validate(LkgSetup{.baud = 0, .heads = {StillHead(0)}});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().Text(), "<baud>: must be above 0; give 9600");
}

TEST(LkgUnit, IsRefusedWithoutHeads) {
  EXPECT_FALSE(Validate(LkgSetup{}));
  EXPECT_FALSE(Validate(LkgSetup{.heads = {StillHead(0), StillHead(0), StillHead(0)}}));
}

// --- DL-RS1A with several amplifiers, and writing ----------------------------------------------

DlRs1aSetup ThreeAmplifiers() {
  DlRs1aSetup setup{.baud = 38400, .head = StillHead(1.234e-3)};
  setup.expansions = {StillHead(-2.5e-3), StillHead(3e-3, "IL-300")};
  return setup;
}

TEST(DlRs1aAmplifiers, AnswerInTheOrderOfTheirNumbers) {
  ManualClock clock;
  DlRs1aUnit unit(ThreeAmplifiers());
  EXPECT_EQ(Ask(unit, clock, "M0\r\n"), "M0,+01.234,-02.500,+003.00\r\n");
  EXPECT_EQ(Ask(unit, clock, "MS\r\n"), "MS,04,+01.234,04,-02.500,04,+003.00\r\n");
  EXPECT_EQ(Ask(unit, clock, "SR,02,037\r\n"), "SR,02,037,+003.00\r\n");
  EXPECT_EQ(Ask(unit, clock, "SR,00,193\r\n"), "SR,00,193,4022\r\n");
  EXPECT_EQ(Ask(unit, clock, "SR,01,193\r\n"), "SR,01,193,4023\r\n");
  EXPECT_EQ(Ask(unit, clock, "SR,03,037\r\n"), "ER,SR,65\r\n");
}

TEST(DlRs1aAmplifiers, AreWrittenWhereTheSwitchAllowsIt) {
  ManualClock clock;
  DlRs1aSetup setup = ThreeAmplifiers();
  setup.is_writable = true;
  DlRs1aUnit unit(setup);
  EXPECT_EQ(Ask(unit, clock, "SW,01,132,1\r\n"), "SW,01,132\r\n");
  EXPECT_EQ(Ask(unit, clock, "SR,01,132\r\n"), "SR,01,132,1\r\n");
  EXPECT_EQ(Ask(unit, clock, "SR,00,132\r\n"), "SR,00,132,2\r\n") << "only the one that was meant";
  EXPECT_EQ(Ask(unit, clock, "AW,133,4\r\n"), "AW,133\r\n");
  EXPECT_EQ(Ask(unit, clock, "SR,02,133\r\n"), "SR,02,133,4\r\n");
  EXPECT_EQ(Ask(unit, clock, "SW,00,133,15\r\n"), "ER,SW,22\r\n");
  EXPECT_EQ(Ask(unit, clock, "SW,00,195,1\r\n"), "ER,SW,22\r\n") << "read only";
  EXPECT_EQ(Ask(unit, clock, "SW,00,132,x\r\n"), "ER,SW,22\r\n");
  EXPECT_EQ(Ask(unit, clock, "SW,07,132,1\r\n"), "ER,SW,65\r\n");
}

TEST(DlRs1aAmplifiers, AreAllWrittenFromTheMainOneOn) {
  ManualClock clock;
  DlRs1aSetup setup = ThreeAmplifiers();
  setup.is_writable = true;
  DlRs1aUnit unit(setup);
  EXPECT_EQ(Ask(unit, clock, "AW,133,5\r\n"), "AW,133\r\n");
  for (const char* number : {"00", "01", "02"}) {
    const std::string data = std::string("SR,") + number + ",133";
    EXPECT_EQ(Ask(unit, clock, data + "\r\n"), data + ",5\r\n");
  }
  EXPECT_EQ(Ask(unit, clock, "SR,00,054\r\n"), "SR,00,054,1\r\n") << "a shift has succeeded";
}

TEST(DlRs1aAmplifiers, ShowNothingUntilAChangeHasSettled) {
  ManualClock clock;
  DlRs1aSetup setup = ThreeAmplifiers();
  setup.is_writable = true;
  DlRs1aUnit unit(setup);
  // 4096 averages of 1 ms
  ASSERT_EQ(Ask(unit, clock, "SW,00,133,12\r\n"), "SW,00,133\r\n");
  EXPECT_EQ(Ask(unit, clock, "M0\r\n"), "M0,-99.998,-02.500,+003.00\r\n");
  clock.Advance(9 * kNsPerS);
  EXPECT_EQ(Ask(unit, clock, "M0\r\n"), "M0,+01.234,-02.500,+003.00\r\n");
  // so does a change of the hold
  ASSERT_EQ(Ask(unit, clock, "SW,00,136,1\r\n"), "SW,00,136\r\n");
  EXPECT_EQ(Ask(unit, clock, "M0\r\n"), "M0,-99.998,-02.500,+003.00\r\n");
}

TEST(DlRs1aAmplifiers, AreFifteenAtMost) {
  DlRs1aSetup setup{.head = StillHead(0)};
  setup.expansions.assign(14, StillHead(0));
  EXPECT_TRUE(Validate(setup));
  setup.expansions.push_back(StillHead(0));
  EXPECT_FALSE(Validate(setup));
  DlEn1Setup en1{.heads = std::vector<MovingHead>(15, StillHead(0))};
  EXPECT_TRUE(Validate(en1));
  en1.heads.push_back(StillHead(0));
  EXPECT_FALSE(Validate(en1));
}

TEST(DlRs1aAmplifiers, ShiftTheirZeroAtTheEdge) {
  ManualClock clock;
  DlRs1aSetup setup = ThreeAmplifiers();
  setup.is_writable = true;
  DlRs1aUnit unit(setup);
  for (const char* request : {"SW,00,001,0\r\n", "SW,00,001,1\r\n", "SW,00,001,1\r\n"}) {
    EXPECT_EQ(Ask(unit, clock, request), "SW,00,001\r\n");
  }
  EXPECT_EQ(Ask(unit, clock, "M0\r\n"), "M0,+00.000,-02.500,+003.00\r\n");
  for (const char* request : {"SW,00,002,0\r\n", "SW,00,002,1\r\n"}) {
    EXPECT_EQ(Ask(unit, clock, request), "SW,00,002\r\n");
  }
  EXPECT_EQ(Ask(unit, clock, "M0\r\n"), "M0,+01.234,-02.500,+003.00\r\n");
}

// 1 mm, and 3 mm from the tenth second on
TEST(DlRs1aAmplifiers, ShiftTheirZeroOnceForEachEdge) {
  ManualClock clock;
  DlRs1aSetup setup{.baud = 38400,
                    .head = QuietHead([](double time_s) { return time_s < 10 ? 1e-3 : 3e-3; })};
  setup.is_writable = true;
  DlRs1aUnit unit(setup);
  const auto shown_after = [&](const char* code) {
    EXPECT_EQ(Ask(unit, clock, std::string("SW,00,001,") + code + "\r\n"), "SW,00,001\r\n");
    return Ask(unit, clock, "M0\r\n");
  };
  EXPECT_EQ(shown_after("0"), "M0,+01.000\r\n");
  EXPECT_EQ(shown_after("1"), "M0,+00.000\r\n");
  clock.Advance(10 * kNsPerS);
  EXPECT_EQ(shown_after("1"), "M0,+02.000\r\n") << "a level is no edge";
  EXPECT_EQ(shown_after("0"), "M0,+02.000\r\n");
  EXPECT_EQ(shown_after("1"), "M0,+00.000\r\n");
}

// --- faults of answers ---------------------------------------------------------------------------

DlRs1aSetup Faulty(std::string_view plan) {
  return {.baud = 38400, .head = StillHead(1.234e-3), .faults = *ParseFaultPlan(plan)};
}

TEST(AnswerFaults, ThoseOfTimeLeaveTheStatusOfAValue) {
  ManualClock clock;
  const FaultPlan slow = *ParseFaultPlan("slow");
  DlEn1Unit en1({.heads = {StillHead(10.4e-3)}, .faults = slow});
  EXPECT_EQ(Ask(en1, clock, "M0\r\n"), "M0,+099999999\r\n");
  ManualClock another;
  LkgUnit lkg({.heads = {StillHead(10.4e-3)}, .faults = slow});
  EXPECT_EQ(Ask(lkg, another, "M1\r"), "M1,+FFFFFFF\r");
}

TEST(AnswerFaults, AWrongIdIsInTheDecimalsToo) {
  ManualClock clock;
  DlEn1Unit unit({.heads = {StillHead(0)}, .faults = *ParseFaultPlan("wrong-id")});
  EXPECT_EQ(Ask(unit, clock, "FR,01,037\r\n"), "FR,02,037,+000000003\r\n");
  EXPECT_EQ(Ask(unit, clock, "SR,01,195\r\n"), "SR,02,195,+000000001\r\n");
}

TEST(AnswerFaults, AMergedAnswerComesWithTheNext) {
  ManualClock clock;
  DlRs1aUnit unit(Faulty("merged:3"));
  EXPECT_EQ(Ask(unit, clock, "M0\r\n"), "M0,+01.234\r\n");
  EXPECT_EQ(Ask(unit, clock, "M0\r\n"), "M0,+01.234\r\n");
  EXPECT_EQ(Ask(unit, clock, "M0\r\n"), "");
  EXPECT_EQ(Ask(unit, clock, "MS\r\n"), "M0,+01.234\r\nMS,04,+01.234\r\n");
}

TEST(AnswerFaults, AWrongIdIsAnotherAmplifiersOrOneTooMany) {
  ManualClock clock;
  DlRs1aUnit unit(Faulty("wrong-id"));
  EXPECT_EQ(Ask(unit, clock, "M0\r\n"), "M0,+01.234,+01.234\r\n");
  EXPECT_EQ(Ask(unit, clock, "SR,00,195\r\n"), "SR,01,195,1\r\n");
  ManualClock another;
  LkgUnit lkg({.heads = {StillHead(0)}, .faults = *ParseFaultPlan("wrong-id")});
  EXPECT_EQ(Ask(lkg, another, "M1\r"), "M2,XXXXXXXX\r");
}

TEST(AnswerFaults, AnErrorHasTheNumberThatWasAskedFor) {
  ManualClock clock;
  DlRs1aUnit unit(Faulty("error-65"));
  EXPECT_EQ(Ask(unit, clock, "M0\r\n"), "ER,M0,65\r\n");
  EXPECT_FALSE(ParseFaultPlan("error-"));
  EXPECT_FALSE(ParseFaultPlan("late-65"));
  EXPECT_EQ(ParseFaultPlan("error-7:20")->every, 20);
}

TEST(AnswerFaults, AByteGapPausesInTheMiddle) {
  ManualClock clock;
  DlRs1aUnit unit(Faulty("byte-gap:2"));
  EXPECT_EQ(Ask(unit, clock, "M0\r\n"), "M0,+01.234\r\n");
  unit.Receive("M0\r\n", clock.Now());
  const auto bytes = RunUntil(unit, clock, clock.Now() + kNsPerS);
  ASSERT_EQ(TextOf(bytes), "M0,+01.234\r\n");
  for (std::size_t i = 1; i < bytes.size(); ++i) {
    // the next byte is ready 300 ms after the answer began, of which it had used five bytes' time
    const bool gap = bytes[i].time - bytes[i - 1].time > 100 * kMs;
    EXPECT_EQ(gap, i == bytes.size() / 2) << i;
  }
}

}  // namespace
}  // namespace haptometer::acquire::emulator
