// Writing to IL amplifiers, against the emulated units: what is changed, what is said, and that
// nothing is written unless it was asked for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "acquire/emulator/dl_unit.h"
#include "acquire/sensor/keyence/keyence_il.h"
#include "tests/acquire/device_transport.h"
#include "tests/acquire/il_series_emulated.h"
#include "tests/acquire/scripted_transport.h"
#include "tests/acquire/sensor_rows.h"
#include "tests/findings.h"
#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

using tests::NumbersOf;

using emulator::StillHead;
using ::testing::AllOf;
using ::testing::HasSubstr;
using trial::SampleStatus;

std::vector<il_setting::Write> Writes(std::initializer_list<std::string_view> texts) {
  std::vector<il_setting::Write> writes;
  for (const std::string_view text : texts) {
    const auto parsed = il_setting::Parse(text);
    writes.insert(writes.end(), parsed.value().begin(), parsed.value().end());
  }
  return writes;
}

class KeyenceChange : public ::testing::Test {
 protected:
  Result<void> StartRs1a(KeyenceIlSetup setup, bool is_writable = true) {
    setup.baud = 38400;
    emulator::DlRs1aSetup unit{.baud = 38400, .head = StillHead(1.234e-3)};
    unit.expansions = {StillHead(-2.5e-3), StillHead(3e-3, "IL-300")};
    unit.is_writable = is_writable;
    device_ = std::make_unique<emulator::DlRs1aUnit>(unit);
    return Start(setup);
  }
  Result<void> StartEn1(KeyenceIlSetup setup, bool is_writable = true) {
    setup.unit = IlUnit::kDlEn1;
    device_ = std::make_unique<emulator::DlEn1Unit>(emulator::DlEn1Setup{
        .heads = {StillHead(1.234e-3), StillHead(3e-3, "IL-300")}, .is_writable = is_writable});
    return Start(setup);
  }
  Result<void> Start(const KeyenceIlSetup& setup) {
    sensor_ = std::make_unique<KeyenceIl>(
        std::make_unique<tests::DeviceTransport>(*device_, clock_), setup, clock_);
    return StartAndBegin(*sensor_);
  }
  Reading NextRow() { return NextRowOf(*sensor_); }
  const trial::Metadata& metadata() const { return sensor_->header().metadata; }

  ManualClock clock_;
  std::unique_ptr<emulator::Device> device_;
  std::unique_ptr<KeyenceIl> sensor_;
};

TEST_F(KeyenceChange, EveryAmplifierIsAChannelWithItsOwnStepAndRange) {
  ASSERT_TRUE(StartRs1a({}));
  const auto& channels = sensor_->header().channels;
  ASSERT_EQ(channels.size(), 3U);
  EXPECT_EQ(channels[0].name, "displacement");
  EXPECT_EQ(channels[1].name, "displacement_01");
  EXPECT_EQ(channels[2].name, "displacement_02");
  EXPECT_REL(channels[1].scale, 1e-6, 1e-15, "1 um steps");
  EXPECT_REL(channels[2].scale, 1e-5, 1e-15, "an IL-300 has two decimals");
  // 160 to 450 mm about 300 mm
  EXPECT_REL(channels[2].range_min, -150e-3, 1e-15, "range of the IL-300");
  EXPECT_REL(channels[2].range_max, 140e-3, 1e-15, "range of the IL-300");
  EXPECT_EQ(metadata().fields.at("keyence_data_195"), "1");
  EXPECT_EQ(metadata().fields.at("keyence_data_195_02"), "4");
  const Reading row = NextRow();
  EXPECT_EQ(Counts(row.samples[0]), 1234);
  EXPECT_EQ(Counts(row.samples[1]), -2500);
  EXPECT_EQ(Counts(row.samples[2]), 300);
}

TEST_F(KeyenceChange, TheEn1sChannelsFollowFr) {
  ASSERT_TRUE(StartEn1({}));
  const auto& channels = sensor_->header().channels;
  ASSERT_EQ(channels.size(), 2U);
  EXPECT_EQ(channels[0].name, "displacement");
  EXPECT_EQ(channels[1].name, "displacement_02");
  EXPECT_REL(channels[0].scale, 1e-6, 1e-15, "1 um steps");
  EXPECT_REL(channels[1].scale, 1e-5, 1e-15, "an IL-300 has two decimals");
  EXPECT_EQ(metadata().sensor, "keyence-en1");
  EXPECT_EQ(metadata().head, "IL-030");
  EXPECT_EQ(metadata().averages, 1);
  EXPECT_EQ(metadata().source, "emulated device: emulator on a manual clock");
  const Reading row = NextRow();
  EXPECT_EQ(Counts(row.samples[0]), 1234);
  EXPECT_EQ(Counts(row.samples[1]), 300);
}

TEST_F(KeyenceChange, MsRecordsTheOutputsToo) {
  ASSERT_TRUE(StartRs1a({.command = dl::Command::kMs}));
  const auto& channels = sensor_->header().channels;
  ASSERT_EQ(channels.size(), 6U);
  EXPECT_EQ(channels[3].name, "outputs");
  EXPECT_EQ(channels[3].role, trial::ChannelRole::kOther);
  EXPECT_EQ(channels[5].name, "outputs_02");
  const Reading row = NextRow();
  ASSERT_EQ(row.samples.size(), 6U);
  EXPECT_EQ(Counts(row.samples[0]), 1234);
  EXPECT_EQ(Counts(row.samples[3]), 4) << "GO";
}

TEST_F(KeyenceChange, ASettingIsWrittenToEveryAmplifierAndReadBack) {
  ASSERT_TRUE(StartRs1a({.writes = Writes({"sampling=0.33ms", "averaging=4"})}));
  EXPECT_EQ(metadata().sampling_s, 0.33e-3);
  EXPECT_EQ(metadata().averages, 4);
  EXPECT_EQ(metadata().fields.at("changed_sampling"), "1ms -> 0.33ms");
  EXPECT_EQ(metadata().fields.at("changed_averaging_02"), "1 -> 4");
  EXPECT_EQ(metadata().fields.at("keyence_data_133_01"), "2");
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kSettingChanged),
            "setting=sampling before=1ms after=0.33ms");
  // the values were waited for: they are there from the first row on
  EXPECT_EQ(RowStatus(NextRow()), SampleStatus::kOk);
}

TEST_F(KeyenceChange, TheLongestAveragingIsWaitedFor) {
  // 4096 x 1 ms, of which the emulated amplifier needs two
  ASSERT_TRUE(StartRs1a({.writes = Writes({"averaging=4096"})}));
  EXPECT_GE(clock_.Now(), NsFromSeconds(8.192));
  EXPECT_EQ(RowStatus(NextRow()), SampleStatus::kOk);
}

TEST_F(KeyenceChange, TheLongestAveragingOfADefaultCycleIsWaitedFor) {
  // the emulated head's default is 1 ms
  ASSERT_TRUE(StartRs1a({.writes = Writes({"sampling=default", "averaging=4096"})}));
  EXPECT_GE(clock_.Now(), NsFromSeconds(8.192));
  EXPECT_EQ(RowStatus(NextRow()), SampleStatus::kOk);
}

TEST_F(KeyenceChange, WithoutATargetTheWaitEndsAndIsSaid) {
  device_ = std::make_unique<emulator::DlRs1aUnit>(emulator::DlRs1aSetup{
      .head = StillHead(0), .faults = *emulator::ParseFaultPlan("invalid"), .is_writable = true});
  ASSERT_TRUE(Start({.writes = Writes({"averaging=2"})}));
  EXPECT_LE(clock_.Now(), 4 * kNsPerS);
  EXPECT_TRUE(sensor_->Found().Has(FindingKind::kNotSettled));
}

TEST_F(KeyenceChange, WhatIsSetAlreadyIsNotWritten) {
  ASSERT_TRUE(StartRs1a({.writes = Writes({"sampling=1ms", "high-pass=off"})}, false));
  EXPECT_FALSE(metadata().fields.contains("changed_sampling"));
}

TEST_F(KeyenceChange, TheHighPassIsItsCornerAndTheFilter) {
  ASSERT_TRUE(StartRs1a({.writes = Writes({"high-pass=10Hz"})}));
  EXPECT_EQ(metadata().fields.at("keyence_data_159"), "6");
  EXPECT_EQ(metadata().fields.at("keyence_data_133"), "14");
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kHighPassFilter), "corner_hz=10");
}

TEST_F(KeyenceChange, FindingsOfTheFirstAmplifierHaveNoSubject) {
  ASSERT_TRUE(StartRs1a({.writes = Writes({"averaging=4"})}));
  std::vector<std::string> subjects;
  for (const Finding& found : sensor_->Found().list()) {
    if (found.kind == FindingKind::kAveragingCorner) subjects.push_back(found.subject);
  }
  EXPECT_EQ(subjects, (std::vector<std::string>{"", "amplifier 01", "amplifier 02"}));
}

// what data of these numbers mean for a recording
Findings FoundOf(std::initializer_list<std::pair<int, const char*>> data) {
  UnitSettings settings;
  for (const auto& [number, text] : data) settings.Set(number, text);
  return settings.Found();
}

TEST(UnitSettings, AMeanHasItsCornerFromTwoReadingsOn) {
  EXPECT_TRUE(FoundOf({}).list().empty());
  EXPECT_TRUE(FoundOf({{132, "2"}, {133, "0"}}).list().empty()) << "one reading is no mean";
  EXPECT_TRUE(FoundOf({{132, "0"}, {133, "1"}}).list().empty()) << "the cycle is not known";
  EXPECT_TRUE(FoundOf({{132, "2"}}).list().empty());
  // 0.443 / 2 ms
  EXPECT_EQ(NumbersOf(FoundOf({{132, "2"}, {133, "1"}}), FindingKind::kAveragingCorner),
            "averages=2 sampling_s=0.001 corner_hz=221.5");
}

TEST(UnitSettings, FiltersHoldAndErrorsAreDoubts) {
  EXPECT_TRUE(FoundOf({{133, "13"}}).Has(FindingKind::kDifferenceFilter));
  for (const char* averaging : {"12", "14"}) {
    EXPECT_FALSE(FoundOf({{133, averaging}}).Has(FindingKind::kDifferenceFilter)) << averaging;
  }
  EXPECT_EQ(NumbersOf(FoundOf({{133, "14"}, {159, "3"}}), FindingKind::kHighPassFilter),
            "corner_hz=1");
  EXPECT_TRUE(FoundOf({{133, "13"}, {159, "3"}}).list().size() == 1) << "of another filter";
  EXPECT_TRUE(FoundOf({{133, "14"}, {159, "10"}}).list().empty()) << "no such corner";
  EXPECT_TRUE(FoundOf({{133, "14"}}).list().empty());
  EXPECT_TRUE(FoundOf({{136, "0"}, {33, "00000"}}).list().empty());
  EXPECT_EQ(NumbersOf(FoundOf({{136, "1"}}), FindingKind::kHold), "hold=peak");
  EXPECT_EQ(NumbersOf(FoundOf({{33, "00001"}}), FindingKind::kAmplifierError), "flags=00001");
}

TEST(UnitSettings, AReadingTakesTheSlowestCycleWhereItIsNotKnown) {
  UnitSettings settings;
  EXPECT_EQ(settings.ResponseSeconds(), 0);
  settings.Set(133, "4");
  EXPECT_REL(settings.ResponseSeconds(), 80e-3, 1e-15, "16 times 5 ms");
  settings.Set(132, "2");
  EXPECT_REL(settings.ResponseSeconds(), 16e-3, 1e-15, "16 times 1 ms");
}

TEST_F(KeyenceChange, ALockedUnitNamesItsSwitch) {
  const auto started = StartRs1a({.writes = Writes({"sampling=0.33ms"})}, false);
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().cause, Cause::kCannotAnswer);
  EXPECT_EQ(started.error().Text(),
            "emulator: the DL-RS1A refuses to write data 132 with error 67: writing is locked; the "
            "unit's R/W switch is in position R; slide the R/W switch of the DL-RS1A to W, and "
            "back to R afterwards");
  EXPECT_THAT(StartEn1({.device_zero = true}, false).error().Text(),
              HasSubstr("the DL-EN1 refuses to write data 001 with error 014"));
}

TEST_F(KeyenceChange, TheDevicesZeroIsShifted) {
  ASSERT_TRUE(StartRs1a({.device_zero = true}));
  EXPECT_EQ(metadata().fields.at("changed_zero"), "+01.234 -> +00.000");
  EXPECT_EQ(metadata().fields.at("changed_zero_02"), "+003.00 -> +000.00");
  const Reading row = NextRow();
  for (const trial::Sample& sample : row.samples) EXPECT_EQ(Counts(sample), 0);
}

TEST_F(KeyenceChange, ARefusalInTheMiddleNamesWhatWasChanged) {
  // the answers are a probe, 27 settings, then SR, SW, SR for each write: the second SW is the 33rd
  emulator::DlRs1aSetup unit{.baud = 38400, .head = StillHead(1.234e-3)};
  unit.expansions = {StillHead(-2.5e-3), StillHead(3e-3, "IL-300")};
  unit.is_writable = true;
  unit.faults = *emulator::ParseFaultPlan("error-22:33");
  device_ = std::make_unique<emulator::DlRs1aUnit>(unit);
  EXPECT_THAT(
      Start({.baud = 38400, .writes = Writes({"sampling=0.33ms", "averaging=4"})}).error().Text(),
      AllOf(HasSubstr("refuses to write data 133 with error 22"),
            HasSubstr("; already changed: amplifier 00: sampling 1ms -> 0.33ms; see the")));
}

TEST_F(KeyenceChange, TheEn1WritesInItsOwnSpelling) {
  ASSERT_TRUE(StartEn1({.writes = Writes({"averaging=128"}), .device_zero = true}));
  EXPECT_EQ(metadata().averages, 128);
  EXPECT_EQ(metadata().fields.at("changed_averaging_02"), "1 -> 128");
  EXPECT_EQ(metadata().fields.at("changed_zero"), "+000001234 -> +000000000");
  EXPECT_EQ(Counts(NextRow().samples[0]), 0);
}

TEST_F(KeyenceChange, PollsLieOnTheGridAndAreNeverFaster) {
  ASSERT_TRUE(StartRs1a({.rate_hz = 30}));
  MonotonicNs first_ns = 0;
  for (int row = 0; row < 100; ++row) {
    const Reading reading = NextRow();
    if (row == 0) first_ns = reading.time_ns;
    EXPECT_ABS(SecondsFromNs(reading.time_ns - first_ns), row / 30.0, 1e-9, "rounded to ns");
  }
  EXPECT_EQ(metadata().nominal_rate_hz, 30);
}

TEST_F(KeyenceChange, ATooHighRateLeavesSlotsOut) {
  // three amplifiers at 38400 baud take 12.3 ms; of a grid of 10 ms every second slot is used
  ASSERT_TRUE(StartRs1a({.rate_hz = 100}));
  const MonotonicNs first_ns = NextRow().time_ns;
  for (int row = 1; row < 20; ++row) {
    EXPECT_ABS(SecondsFromNs(NextRow().time_ns - first_ns), row * 0.02, 1e-9, "rounded to ns");
  }
}

TEST_F(KeyenceChange, SeveralAmplifiersShareTheWireAndTheBuffer) {
  // 8 + 3 x 8 characters of 10 bits and 4 ms; contents of three amplifiers are renewed every 13 ms
  ASSERT_TRUE(StartRs1a({}));
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kUnitRate),
            "device=DL-RS1A rate_hz=81.0811 observable_hz=30.0481 baud=38400 new_rate_hz=76.9231");
  // MS has 8 + 3 x 11
  ASSERT_TRUE(StartRs1a({.command = dl::Command::kMs}));
  EXPECT_REL(metadata().nominal_rate_hz.value(), 1 / (410.0 / 38400 + 4e-3), 1e-6,
             "rounded to nanoseconds");
}

TEST_F(KeyenceChange, AnEn1IsAsFastAsItsProcessing) {
  // 9.8 ms with two amplifiers, 7.8 ms with one
  ASSERT_TRUE(StartEn1({}));
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kUnitRate),
            "device=DL-EN1 rate_hz=102.041 observable_hz=39.8597");
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kUnitTooSlow),
            "device=DL-EN1 rate_hz=128.205 needed_hz=1280");
  EXPECT_EQ(metadata().nominal_rate_hz, std::nullopt) << "its response time is not stated";
}

// how long a start takes that sets the averaging of a head without a target
double StartWithoutATarget(std::string_view averaging) {
  ManualClock clock;
  emulator::DlRs1aUnit unit({.baud = 38400,
                             .head = StillHead(0),
                             .faults = *emulator::ParseFaultPlan("invalid"),
                             .is_writable = true});
  KeyenceIl sensor(std::make_unique<tests::DeviceTransport>(unit, clock),
                   {.baud = 38400, .writes = Writes({averaging})}, clock);
  EXPECT_TRUE(sensor.Start(kNeverStop));
  return SecondsFromNs(clock.Now());
}

TEST(KeyenceChangeWait, IsTwoMeansLongerWithALongerMean) {
  // 2 s and two means: of 4096 ms, and of 2 ms
  EXPECT_ABS(StartWithoutATarget("averaging=4096") - StartWithoutATarget("averaging=2"), 8.188,
             0.02, "each ends with an exchange of 8.2 ms");
}

TEST_F(KeyenceChange, AnEn1sOutputIsReadInMillivolts) {
  emulator::MovingHead head = StillHead(1.234e-3);
  head.analog = {.gain_error = 1.01, .offset_error_v = 0.002};
  device_ = std::make_unique<emulator::DlEn1Unit>(emulator::DlEn1Setup{.heads = {head}});
  ASSERT_TRUE(Start({.unit = IlUnit::kDlEn1}));
  const auto analog = sensor_->ReadAnalog(kNeverStop);
  ASSERT_TRUE(analog) << analog.error().Text();
  EXPECT_EQ(analog->status, SampleStatus::kOk);
  EXPECT_REL(analog->displacement_m, 1.234e-3, 1e-15, "a product and a quotient");
  EXPECT_REL(analog->volts, 1.248, 1e-15, "1.01 x 1.234 + 0.002 = 1.24834, in whole mV");
}

// --- the zero shift by its bytes -------------------------------------------------------------

// A unit whose zero shift has these results (data 054), the last one for ever; "" is refused.
class ShiftingUnit {
 public:
  explicit ShiftingUnit(std::vector<std::string> results) : results_(std::move(results)) {}

  Result<void> Start() {
    auto transport = std::make_unique<tests::ScriptedTransport>(
        clock, [this](tests::ScriptedTransport& to, const std::string& request) {
          to.Send(Answer(request), 10'000'000);
        });
    wire_ = transport.get();
    sensor_ = std::make_unique<KeyenceIl>(
        std::move(transport), KeyenceIlSetup{.baud = 38400, .device_zero = true}, clock);
    return sensor_->Start(kNeverStop);
  }
  // the requests that write or ask for the result, "W0" for a 0 written and "R"
  // places of the writes that are refused, from 0
  std::vector<std::size_t> refused;

  [[nodiscard]] std::string Requests() const {
    std::string requests;
    for (const std::string& request : wire_->written()) {
      if (request.starts_with("SW,00,001,")) requests += "W" + request.substr(10, 1) + " ";
      if (request.starts_with("SR,00,054")) requests += "R ";
    }
    return requests;
  }
  ManualClock clock;

 private:
  std::string Answer(const std::string& request) {
    if (request == "M0\r\n") return "M0,+01.234\r\n";
    if (request.starts_with("SW")) {
      const bool is_refused = std::ranges::find(refused, writes_++) != refused.end();
      return is_refused ? "ER,SW,22\r\n" : "SW,00,001\r\n";
    }
    if (request.starts_with("SR,00,037")) return "SR,00,037,+01.234\r\n";
    if (!request.starts_with("SR,00,054")) return "ER,SR,22\r\n";
    const std::string& result = results_[std::min(asked_++, results_.size() - 1)];
    return result.empty() ? "ER,SR,22\r\n" : "SR,00,054," + result + "\r\n";
  }

  std::vector<std::string> results_;
  std::size_t asked_ = 0;
  std::size_t writes_ = 0;
  tests::ScriptedTransport* wire_ = nullptr;
  std::unique_ptr<KeyenceIl> sensor_;
};

TEST(ZeroShift, IsWrittenAsZeroOneZeroAndItsEndIsAwaited) {
  ShiftingUnit unit({"0", "0", "1"});
  EXPECT_TRUE(unit.Start());
  EXPECT_EQ(unit.Requests(), "W0 W1 W0 R R R ");
}

TEST(ZeroShift, AnAmplifierThatDoesNotSayItsEndIsBelieved) {
  ShiftingUnit silent({""});
  EXPECT_TRUE(silent.Start());
  EXPECT_EQ(silent.Requests(), "W0 W1 W0 R ");
  // one that stays busy is waited for during a second, of which each question takes 10 ms
  ShiftingUnit busy({"0"});
  EXPECT_TRUE(busy.Start());
  EXPECT_EQ(busy.clock.Now() - silent.clock.Now(), 990'000'000);
}

TEST(ZeroShift, AFailedOneEndsTheStart) {
  ShiftingUnit unit({"0", "2"});
  const auto started = unit.Start();
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().cause, Cause::kCannotAnswer);
  EXPECT_THAT(started.error().Text(),
              HasSubstr("amplifier 00 could not shift its zero; bring the"));
}

TEST(ZeroShift, ARefusedRequestIsTakenBack) {
  struct Case {
    std::vector<std::size_t> refused;
    const char* requests;
    bool may_remain;
  };
  for (const Case& at : {Case{{0}, "W0 ", false}, Case{{1}, "W0 W1 W0 ", false},
                         Case{{1, 2}, "W0 W1 W0 ", true}, Case{{2}, "W0 W1 W0 ", false}}) {
    ShiftingUnit unit({"1"});
    unit.refused = at.refused;
    const auto started = unit.Start();
    ASSERT_FALSE(started);
    EXPECT_EQ(unit.Requests(), at.requests);
    EXPECT_EQ(started.error().Text().contains("data 001 of amplifier 00 may still be 1"),
              at.may_remain)
        << started.error().Text();
  }
}

// --- a written code by its bytes -------------------------------------------------------------

// What "averaging=4", code 2, is written as where data 133 reads `before`; "" is refused. `keeps`:
// the amplifier acknowledges the code and keeps the old one.
struct Written {
  std::vector<std::string> requests;
  std::string change;
  std::string error;
};

Written WrittenWhere(std::string data, bool keeps = false,
                     std::string_view setting = "averaging=4") {
  ManualClock clock;
  Written written;
  const auto answer = [&](tests::ScriptedTransport& to, const std::string& request) {
    std::string reply = "ER,SR,22\r\n";
    if (request == "M0\r\n") reply = "M0,+01.234\r\n";
    if (request.starts_with("SR,00,133") && !data.empty()) reply = "SR,00,133," + data + "\r\n";
    if (request.starts_with("SW")) {
      written.requests.push_back(request);
      if (!keeps) data = request.substr(10, request.size() - 12);
      reply = "SW,00,133\r\n";
    }
    to.Send(reply, 10'000'000);
  };
  KeyenceIl sensor(std::make_unique<tests::ScriptedTransport>(clock, answer),
                   {.baud = 38400, .writes = Writes({setting})}, clock);
  const auto started = sensor.Start(kNeverStop);
  if (!started) written.error = started.error().Text();
  const auto& fields = sensor.header().metadata.fields;
  if (fields.contains("changed_averaging")) written.change = fields.at("changed_averaging");
  return written;
}

TEST(WrittenCode, HasTheDigitsOfTheOneBefore) {
  using Requests = std::vector<std::string>;
  EXPECT_EQ(WrittenWhere("4").requests, Requests{"SW,00,133,2\r\n"});
  EXPECT_EQ(WrittenWhere("0004").requests, Requests{"SW,00,133,0002\r\n"});
  EXPECT_EQ(WrittenWhere("+04").requests, Requests{"SW,00,133,+02\r\n"});
  EXPECT_EQ(WrittenWhere("-04").requests, Requests{"SW,00,133,+02\r\n"});
  EXPECT_EQ(WrittenWhere("").requests, Requests{"SW,00,133,2\r\n"}) << "not known";
  EXPECT_EQ(WrittenWhere("02").requests, Requests{}) << "it is set already";
  EXPECT_EQ(WrittenWhere("0004").change, "16 -> 4");
  EXPECT_EQ(WrittenWhere("").change, "unknown -> 4");
}

TEST(WrittenCode, OffReplacesTheHighPassFilterAlone) {
  using Requests = std::vector<std::string>;
  const auto requests = [](const char* data) {
    return WrittenWhere(data, false, "high-pass=off").requests;
  };
  EXPECT_EQ(requests("14"), Requests{"SW,00,133,00\r\n"});
  for (const char* other : {"13", "04", "00", ""}) EXPECT_EQ(requests(other), Requests{}) << other;
}

TEST(WrittenCode, ThatWasNotTakenIsRefused) {
  EXPECT_THAT(WrittenWhere("4", true).error,
              HasSubstr("amplifier 00 was set to averaging = 4 but reports 16"));
}

// --- names -----------------------------------------------------------------------------------

TEST(IlSetting, NamesAreTheMakersCodes) {
  using il_setting::Parse;
  using il_setting::Write;
  EXPECT_EQ(*Parse("sampling=default"), (std::vector{Write{"sampling", 132, 0}}));
  EXPECT_EQ(*Parse("sampling=0.33ms"), (std::vector{Write{"sampling", 132, 1}}));
  EXPECT_EQ(*Parse("sampling=5ms"), (std::vector{Write{"sampling", 132, 4}}));
  EXPECT_EQ(*Parse("averaging=1"), (std::vector{Write{"averaging", 133, 0}}));
  EXPECT_EQ(*Parse("averaging=16"), (std::vector{Write{"averaging", 133, 4}}));
  EXPECT_EQ(*Parse("averaging=4096"), (std::vector{Write{"averaging", 133, 12}}));
  EXPECT_EQ(*Parse("averaging=difference"), (std::vector{Write{"averaging", 133, 13}}));
  EXPECT_EQ(*Parse("hold=sample"), (std::vector{Write{"hold", 136, 0}}));
  EXPECT_EQ(*Parse("hold=auto bottom"), (std::vector{Write{"hold", 136, 5}}));
  EXPECT_EQ(*Parse("high-pass=100Hz"),
            (std::vector{Write{"high-pass", 159, 9}, Write{"high-pass", 133, 14}}));
  EXPECT_EQ(*Parse("high-pass=off"), (std::vector{Write{"high-pass", 133, 0, 14}}));
}

TEST(IlSetting, OthersAreRefusedWithThoseThereAre) {
  const auto key = il_setting::Parse("speed=1ms");
  ASSERT_FALSE(key);
  EXPECT_EQ(key.error().Text(),
            "<set>: 'speed=1ms' is not a setting of an IL amplifier; write sampling=..., "
            "averaging=..., hold=... or high-pass=...");
  EXPECT_EQ(key.error().cause, Cause::kUsage);
  EXPECT_EQ(il_setting::Parse("sampling=3ms").error().Text(),
            "<set>: an IL amplifier has no sampling '3ms'; use one of default, 0.33ms, 1ms, 2ms, "
            "5ms");
  EXPECT_THAT(il_setting::Parse("high-pass=3Hz").error().Text(), HasSubstr("one of off, 0.1Hz"));
  EXPECT_FALSE(il_setting::Parse("sampling"));
  EXPECT_FALSE(il_setting::Parse("averaging=3"));
  EXPECT_FALSE(il_setting::Parse(""));
}

}  // namespace
}  // namespace haptometer::acquire
