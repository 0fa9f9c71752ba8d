// What a DL-RS1A is asked before a recording, and what is said when it does not answer.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "acquire/sensor/keyence/keyence_il.h"
#include "tests/acquire/scripted_il_unit.h"
#include "tests/acquire/scripted_transport.h"
#include "tests/findings.h"
#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

using tests::NumbersOf;

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using trial::SampleStatus;

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

TEST_F(KeyenceIlTest, AHeadWithoutARangeHasNone) {
  unit_.settings = {{"195", "107"}};
  const trial::ChannelFormat& channel = Started().header().channels.at(0);
  EXPECT_EQ(channel.range_min, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(channel.range_max, std::numeric_limits<double>::infinity());
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
  EXPECT_THAT(error.Text(), HasSubstr("scripted: nothing answers at 9600 baud; try <baud> 2400, "
                                      "4800, 19200 or 38400, and check "));
  EXPECT_EQ(clock_.Now(), 3 * kNsPerS);
}

TEST_F(KeyenceIlTest, TheLastBaudRateNamesTheFirstFour) {
  unit_.is_silent = true;
  EXPECT_THAT(StartError(38400).Text(), HasSubstr("try <baud> 2400, 4800, 9600 or 19200, and"));
}

TEST_F(KeyenceIlTest, GarbageAtTheWrongBaudRateIsToldFromSilence) {
  for (int i = 0; i < 3; ++i)
    unit_.to_m0.push_back({{std::string("\xF8\x80\x78\x00\xE0\n", 6), 8 * kMs}});
  EXPECT_THAT(
      StartError().Text(),
      AllOf(HasSubstr("bytes come at 9600 baud, but no reply of a DL-RS1A; try <baud> 2400"),
            HasSubstr("; a sensor that sends without request is read by <sensor> stream")));
}

TEST_F(KeyenceIlTest, HalfACommandLeftInTheUnitSpoilsOnlyTheFirstProbe) {
  unit_.to_m0.push_back({{"ER,SR,20\r\n"}});
  Started();
  ExpectSoundFrom(2);
}

TEST_F(KeyenceIlTest, ARefusedM0SaysWhatTheNumberMeans) {
  for (int i = 0; i < 3; ++i) unit_.to_m0.push_back({{"ER,M0,66\r\n"}});
  EXPECT_THAT(StartError().Text(),
              HasSubstr("refuses M0 with error 66: the unit cannot communicate with the amplifier "
                        "next to it; check the D-bus"));
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
  const Findings found = Started().Found();
  EXPECT_THAT(NumbersOf(found, FindingKind::kUnitRate),
              AllOf(HasSubstr("device=DL-RS1A rate_hz=122.4"), HasSubstr(" observable_hz=47.8"),
                    HasSubstr(" baud=38400")));
  EXPECT_THAT(NumbersOf(found, FindingKind::kUnitTooSlow),
              AllOf(HasSubstr(" rate_hz=122.4"), HasSubstr(" needed_hz=1280")));
  // sinc(0.443) = 1/sqrt(2): 0.443 / 16 ms
  EXPECT_THAT(NumbersOf(found, FindingKind::kAveragingCorner),
              HasSubstr("averages=16 sampling_s=0.001 corner_hz=27.68"));
  EXPECT_EQ(NumbersOf(found, FindingKind::kHold), "hold=peak");
  EXPECT_EQ(NumbersOf(found, FindingKind::kAmplifierError), "flags=00004");
}

// --- the analog output ---

class KeyenceAnalog : public KeyenceIlTest {
 protected:
  // data 038 and 042 as the amplifier sends them
  Result<IlAnalog> Analog(const std::string& value, const std::string& output) {
    unit_.settings["038"] = value;
    unit_.settings["042"] = output;
    return Started().ReadAnalog(kNeverStop);
  }
};

TEST_F(KeyenceAnalog, IsTheValueAndItsVolts) {
  const auto analog = Analog("-01.234", "-1.239");
  ASSERT_TRUE(analog) << analog.error().Text();
  EXPECT_EQ(analog->status, SampleStatus::kOk);
  EXPECT_REL(analog->displacement_m, -1.234e-3, 1e-15, "a product and a quotient");
  EXPECT_REL(analog->volts, -1.239, 1e-15, "a product");
}

TEST_F(KeyenceAnalog, FollowsThePointOfTheValue) {
  const auto analog = Analog("+056.78", "+0.406");
  ASSERT_TRUE(analog) << analog.error().Text();
  EXPECT_REL(analog->displacement_m, 56.78e-3, 1e-15, "a product and a quotient");
}

TEST_F(KeyenceAnalog, FiveAndAHalfVoltsAreNoReading) {
  EXPECT_EQ(Analog("+01.234", "+5.500")->status, SampleStatus::kInvalid);
}

TEST_F(KeyenceAnalog, AHighOutputIsOne) {
  EXPECT_EQ(Analog("+01.234", "+5.499")->status, SampleStatus::kOk);
}

TEST_F(KeyenceAnalog, ASpecialValueIsItsStatus) {
  EXPECT_EQ(Analog("+99.999", "+5.500")->status, SampleStatus::kOver);
}

TEST_F(KeyenceAnalog, ACurrentIsRefused) {
  const auto current = Analog("+01.234", "12.00");
  ASSERT_FALSE(current);
  EXPECT_EQ(current.error().cause, Cause::kCannotAnswer);
  EXPECT_THAT(current.error().Text(), HasSubstr("the analog output is '12.00', no voltage"));
}

TEST_F(KeyenceAnalog, HalfOfItIsLate) {
  unit_.settings["042"] = "+1.234";
  EXPECT_EQ(Started().ReadAnalog(kNeverStop)->status, SampleStatus::kLate);
}

TEST_F(KeyenceAnalog, AValueWithoutItsVoltsIsLate) {
  unit_.settings["038"] = "+01.234";
  EXPECT_EQ(Started().ReadAnalog(kNeverStop)->status, SampleStatus::kLate);
}

TEST_F(KeyenceAnalog, ADamagedValueIsABadFrame) {
  EXPECT_EQ(Analog("+01.2x4", "+1.234")->status, SampleStatus::kBadFrame);
}

TEST_F(KeyenceAnalog, WhatTheUnitDoesNotKnowIsLate) {
  EXPECT_EQ(Started().ReadAnalog(kNeverStop)->status, SampleStatus::kLate);
}

// --- a DL-EN1's decimals ---

class En1Decimals : public ::testing::Test {
 protected:
  // two amplifiers, of which data 195 and the answers to FR are told; "" is refused
  Result<void> Start(const std::array<std::string, 2>& heads, const std::array<std::string, 2>& fr,
                     std::optional<int> decimals = {}) {
    auto transport = std::make_unique<tests::ScriptedTransport>(
        clock_, [=, this](tests::ScriptedTransport& to, const std::string& request) {
          const auto other = others_.find(request);
          to.Send(other == others_.end() ? Answer(request, heads, fr) : other->second, 2 * kMs);
        });
    sensor_ = std::make_unique<KeyenceIl>(
        std::move(transport), KeyenceIlSetup{.unit = IlUnit::kDlEn1, .decimals = decimals}, clock_);
    return sensor_->Start(kNeverStop);
  }
  static std::string Answer(const std::string& request, const std::array<std::string, 2>& heads,
                            const std::array<std::string, 2>& fr) {
    if (request == "M0\r\n") return "M0,+000001234,-000000056\r\n";
    const std::string line = request.substr(0, request.size() - 2);
    const std::size_t place = request[4] == '1' ? 0 : 1;
    const bool asks_head = line.ends_with(",195");
    const std::string data = request.starts_with("FR") ? fr[place] : asks_head ? heads[place] : "";
    return data.empty() ? "ER," + line.substr(0, 2) + ",020\r\n" : line + "," + data + "\r\n";
  }
  double Scale(std::size_t channel) const { return sensor_->header().channels.at(channel).scale; }

  std::map<std::string, std::string> others_;  ///< replies to requests, before all others
  ManualClock clock_;
  std::unique_ptr<KeyenceIl> sensor_;
};

TEST_F(En1Decimals, SpecialValuesOfTheIlSeriesAreThoseOfItsHeads) {
  others_ = {{"M0\r\n", "M0,+000099999,+000099999\r\n"}};
  ASSERT_TRUE(Start({"+000000001", ""}, {"", "+000000003"}));
  (void)sensor_->Begin();
  const Reading row = NextRowOf(*sensor_);
  EXPECT_EQ(row.samples.at(0).status, SampleStatus::kOver);
  EXPECT_EQ(row.samples.at(1).status, SampleStatus::kOk) << "of an amplifier that is not known";
}

TEST_F(En1Decimals, TheAnalogOutputsValueMayBeSpecial) {
  others_ = {{"SR,01,038\r\n", "SR,01,038,+000099999\r\n"},
             {"SR,01,042\r\n", "SR,01,042,+000001234\r\n"}};
  ASSERT_TRUE(Start({"+000000001", "+000000001"}, {"", ""}));
  EXPECT_EQ(sensor_->ReadAnalog(kNeverStop)->status, SampleStatus::kOver);
  others_["SR,01,038\r\n"] = "SR,01,038,-000001234\r\n";
  const auto analog = sensor_->ReadAnalog(kNeverStop);
  ASSERT_TRUE(analog) << analog.error().Text();
  EXPECT_REL(analog->displacement_m, -1.234e-3, 1e-15, "a product and a quotient");
  EXPECT_REL(analog->volts, 1.234, 1e-15, "a product");
}

TEST_F(En1Decimals, SilenceIsToldFromGarbage) {
  others_ = {{"M0\r\n", ""}};
  const auto silent = Start({"", ""}, {"", ""});
  ASSERT_FALSE(silent);
  EXPECT_THAT(silent.error().Text(), AllOf(HasSubstr("nothing answers; check the address"),
                                           Not(HasSubstr("<sensor> stream"))));
  others_ = {{"M0\r\n", "+01.2345\r\n"}};
  const auto garbage = Start({"", ""}, {"", ""});
  ASSERT_FALSE(garbage);
  EXPECT_THAT(garbage.error().Text(),
              AllOf(HasSubstr("bytes come, but no reply of a DL-EN1; check the address"),
                    HasSubstr("; a sensor that sends without request is read by <sensor> stream")));
}

TEST_F(En1Decimals, AReplyOfAnotherAmplifierOrNumberIsNone) {
  for (const char* reply : {"SR,02,195,+000000004\r\n", "SR,01,200,+000000004\r\n"}) {
    others_ = {{"SR,01,195\r\n", reply}};
    ASSERT_TRUE(Start({"+000000001", "+000000001"}, {"+000000003", "+000000003"}));
    EXPECT_FALSE(sensor_->header().metadata.fields.contains("keyence_data_195")) << reply;
  }
}

TEST_F(En1Decimals, AreThoseOfTheUserThenOfFrThenOfTheHead) {
  // code 4 is an IL-300, of two decimals
  ASSERT_TRUE(Start({"+000000001", "+000000004"}, {"+000000004", ""}));
  EXPECT_REL(Scale(0), 1e-7, 1e-14, "a power");
  EXPECT_REL(Scale(1), 1e-5, 1e-14, "a power");
  ASSERT_TRUE(Start({"+000000001", "+000000004"}, {"+000000004", ""}, 1));
  EXPECT_REL(Scale(0), 1e-4, 1e-14, "a power");
  EXPECT_REL(Scale(1), 1e-4, 1e-14, "a power");
}

TEST_F(En1Decimals, AreZeroToNine) {
  ASSERT_TRUE(Start({"", ""}, {"+000000000", "+000000009"}));
  EXPECT_REL(Scale(0), 1e-3, 1e-14, "a power");
  EXPECT_REL(Scale(1), 1e-12, 1e-14, "a power");
  EXPECT_FALSE(Start({"", ""}, {"+000000000", "+000000010"}));
  EXPECT_FALSE(Start({"", ""}, {"-000000001", "+000000003"}));
}

TEST_F(En1Decimals, TheAmplifierThatDoesNotTellThemIsNamed) {
  const auto first = Start({"", "+000000001"}, {"", ""});
  ASSERT_FALSE(first);
  EXPECT_THAT(first.error().Text(),
              HasSubstr("amplifier 01 does not report its decimal places; give them with"));
  const auto second = Start({"+000000001", ""}, {"", ""});
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().Text(), HasSubstr("amplifier 02 does not report its decimal places"));
}

}  // namespace
}  // namespace haptometer::acquire
