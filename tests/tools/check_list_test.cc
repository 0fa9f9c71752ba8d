// The list of a check, from made findings: every point once ok, once to fix; and the findings, from
// made records.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>

#include "acquire/capability.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"
#include "tools/acquire/check.h"
#include "tools/document/render.h"

namespace haptometer::tools {
namespace {

using ::testing::HasSubstr;
using trial::SampleStatus;

// an IL-030 that nothing is wrong with: 3030 readings/s would be its analog output by a clocked DAQ
trial::TrialHeader SoundHeader() {
  trial::TrialHeader header;
  header.timing = trial::Timing::kUniform;
  header.rate_hz = 3000;
  header.channels = {{.name = "displacement",
                      .role = trial::ChannelRole::kDisplacement,
                      .unit = "m",
                      .resolution = 1e-6}};
  trial::Metadata& metadata = header.metadata;
  metadata.sensor = "keyence-il";
  metadata.head = "IL-030";
  metadata.source = "device: serial port /dev/ttyUSB0, 38400 baud 8N1";
  metadata.sampling_s = 0.33e-3;
  metadata.averages = 1;
  metadata.hold = "sample";
  metadata.fields = {{"keyence_data_133", "+00000"}, {"latency_timer_s", "0.001"}};
  return header;
}

CheckFindings SoundFindings() {
  CheckFindings findings;
  findings.summary.readings = 30'000;
  findings.summary.statuses[0] = 30'000;
  findings.summary.interval_sd_s = 1e-5;
  findings.measured = 30'000;
  findings.duration_s = 10;
  findings.fresh_rate_hz = 3000;
  findings.level_m = 0.5e-3;
  findings.least_m = -4e-3;
  findings.greatest_m = 5e-3;
  findings.resolution_m = 1e-6;
  findings.longest_hold = 3;
  findings.noise_m = 2e-6;
  return findings;
}

const CheckQuestion kQuestion{.band = dsp::BandPass{},
                              .command = "acquire --port /dev/ttyUSB0 --band 20-500Hz",
                              .command_of_other_band = "acquire --port /dev/ttyUSB0",
                              .smallest_rms_m = std::nullopt};

CheckItem Point(const std::string& name, const trial::TrialHeader& header,
                const CheckFindings& findings, const CheckQuestion& question = kQuestion) {
  for (const CheckItem& item : CheckList(header, findings, question)) {
    if (item.name == name) return item;
  }
  ADD_FAILURE() << "no point " << name;
  return {};
}

TEST(CheckList, OfASoundSensorIsReady) {
  const auto items = CheckList(SoundHeader(), SoundFindings(), kQuestion);
  std::vector<std::string> names;
  names.reserve(items.size());
  for (const CheckItem& item : items) {
    names.push_back(item.name);
    EXPECT_EQ(item.verdict, Verdict::kOk) << item.name << ": " << item.finding;
    EXPECT_EQ(item.remedy, "") << item.name;
    EXPECT_NE(item.finding, "") << item.name;
  }
  EXPECT_THAT(names,
              ::testing::ElementsAre("sensor", "distance", "hold", "high-pass", "averaging", "rate",
                                     "noise", "repeated", "bad", "clock", "latency"));
  EXPECT_TRUE(IsReady(items));
}

// what the list is made from
struct Made {
  trial::TrialHeader header = SoundHeader();
  CheckFindings findings = SoundFindings();
  CheckQuestion question = kQuestion;

  [[nodiscard]] std::vector<CheckItem> List() const {
    return CheckList(header, findings, question);
  }
};

struct Wrong {
  std::string point;
  std::function<void(Made&)> spoil;
  std::string finding;
  std::string remedy;
};

void PrintTo(const Wrong& wrong, std::ostream* out) { *out << wrong.point; }

class WrongSensors : public ::testing::TestWithParam<Wrong> {};

// the spoilt point, and it alone, is to be fixed
TEST_P(WrongSensors, AreToBeFixedByACommand) {
  Made made;
  GetParam().spoil(made);
  for (const CheckItem& item : made.List()) {
    if (item.name != GetParam().point) {
      EXPECT_NE(item.verdict, Verdict::kFix) << item.name << ": " << item.finding;
      continue;
    }
    EXPECT_EQ(item.verdict, Verdict::kFix) << item.finding;
    EXPECT_THAT(item.finding, HasSubstr(GetParam().finding));
    EXPECT_THAT(item.remedy, HasSubstr(GetParam().remedy));
  }
  EXPECT_FALSE(IsReady(made.List()));
}

std::vector<Wrong> WrongPlacesAndSettings() {
  return {{"sensor", [](Made& s) { s.findings.summary.connection_lost = true; },
           "the connection was lost after 30000 readings", "cable"},
          {"distance", [](Made& s) { s.findings.greatest_m = 5.001e-3; },
           "linear within +-5 mm of 30 mm", "move the head by 0.50 mm"},
          {"distance", [](Made& s) { s.findings.least_m = -5.001e-3; }, "-5.001 to 5.000 mm",
           "until the amplifier shows about 0"},
          {"distance", [](Made& s) { s.findings.level_m.reset(); }, "no reading was a measurement",
           "within the head's range"},
          {"hold", [](Made& s) { s.header.metadata.hold = "peak"; }, "peak",
           "acquire --port /dev/ttyUSB0 --band 20-500Hz --set hold=sample --check"},
          {"high-pass",
           [](Made& s) {
             s.header.metadata.fields["keyence_data_133"] = "14";
             s.header.metadata.averages.reset();
           },
           "on", "--set high-pass=off"},
          {"high-pass",
           [](Made& s) {
             s.header.metadata.fields["keyence_data_133"] = "+00013";
             s.header.metadata.averages.reset();
           },
           "difference-count", "--set averaging=1"},
          {"averaging",
           [](Made& s) {
             s.header.metadata.sampling_s = 1e-3;
             s.header.metadata.averages = 16;
           },
           "16 readings of 1 ms: 0.840 of 20 Hz, 0.070 of 175 Hz", "--set averaging=1"},
          {"averaging",
           [](Made& s) {
             s.header.metadata.averages = 128;
             s.question.band.lower_hz = 1;
             s.question.band.upper_hz = 20;
           },
           "of 20 Hz", "--set averaging=32"}};
}

std::vector<Wrong> WrongRatesAndNoise() {
  return {{"rate", [](Made& s) { s.findings.fresh_rate_hz = 1279; },
           "1279 new readings/s show up to 499.609 Hz", "--band 20-499Hz --check"},
          {"rate",
           [](Made& s) {
             s.findings.fresh_rate_hz = 10'007;
             s.question.band.upper_hz = 4000;
           },
           "up to 3908.98 Hz", "--band 20-3908Hz --check"},
          {"rate", [](Made& s) { s.findings.fresh_rate_hz = 48; }, "18.75 Hz", "--sensor pipe"},
          {"noise",
           [](Made& s) {
             s.findings.noise_m.reset();
             s.findings.no_noise_because = "only 0.1 s settled";
           },
           "only 0.1 s settled", "--check"},
          {"noise", [](Made& s) { s.question.smallest_rms_m = 0.6e-6; }, "0.6 um are required",
           "diffuse target"},
          {"clock", [](Made& s) { s.findings.summary.gaps = 1; }, "1 gaps", "without a hub"},
          {"clock",
           [](Made& s) {
             s.header.timing = trial::Timing::kPolled;
             s.findings.time_uncertainty_s = 0.2e-3;
           },
           "500 Hz needs 0.2 ms", "a clock of its own"},
          {"latency", [](Made& s) { s.header.metadata.fields["latency_timer_s"] = "0.016"; },
           "for 16 ms", "latency_timer"}};
}

std::vector<Wrong> WrongReadings() {
  return {{"repeated", [](Made& s) { s.findings.longest_hold = 15'001; }, "15001 of 30000",
           "touch the target"},
          {"repeated", [](Made& s) { s.findings.summary.statuses = {26'999, 3001}; }, "10.0 %",
           "fewer amplifiers"},
          {"bad",
           [](Made& s) {
             s.findings.summary.statuses[0] = 29'969;
             s.findings.summary.statuses[static_cast<std::size_t>(SampleStatus::kInvalid)] = 30;
             s.findings.summary.statuses[static_cast<std::size_t>(SampleStatus::kLate)] = 1;
           },
           "31 of 30000 readings, most of them invalid", "shield it from light"},
          {"bad",
           [](Made& s) {
             s.findings.summary.statuses[0] = 20'000;
             s.findings.summary.statuses[static_cast<std::size_t>(SampleStatus::kLate)] = 10'000;
           },
           "late", "--baud to a lower speed"},
          {"bad",
           [](Made& s) {
             s.findings.summary.statuses[0] = 20'000;
             s.findings.summary.statuses[static_cast<std::size_t>(SampleStatus::kClipped)] = 10'000;
           },
           "clipped", "widen the DAQ's range"}};
}

INSTANTIATE_TEST_SUITE_P(Settings, WrongSensors, ::testing::ValuesIn(WrongPlacesAndSettings()));
INSTANTIATE_TEST_SUITE_P(Rates, WrongSensors, ::testing::ValuesIn(WrongRatesAndNoise()));
INSTANTIATE_TEST_SUITE_P(Readings, WrongSensors, ::testing::ValuesIn(WrongReadings()));

TEST(CheckList, WithoutAReadingAlmostNothingIsOk) {
  const CheckItem item = Point("sensor", SoundHeader(), {});
  EXPECT_EQ(item.verdict, Verdict::kFix);
  EXPECT_THAT(item.remedy, HasSubstr("cable"));
  EXPECT_FALSE(IsReady(CheckList(SoundHeader(), {}, kQuestion)));
}

TEST(CheckList, WhatTheSensorDoesNotSayIsUnknownAndNothingToFix) {
  trial::TrialHeader header = SoundHeader();
  header.metadata = {};
  header.metadata.source = "device: serial port p, 921600 baud 8N1, low latency";
  header.metadata.sensor = "stream";
  const auto items = CheckList(header, SoundFindings(), kQuestion);
  std::vector<std::string> unknown;
  for (const CheckItem& item : items) {
    if (item.verdict == Verdict::kUnknown) unknown.push_back(item.name);
  }
  EXPECT_THAT(unknown, ::testing::ElementsAre("distance", "hold", "high-pass", "averaging"));
  EXPECT_TRUE(IsReady(items));
}

TEST(CheckList, TheEndsOfTheLinearRangeAreWithin) {
  CheckFindings findings = SoundFindings();
  findings.least_m = -5e-3;
  findings.greatest_m = 5e-3;
  EXPECT_EQ(Point("distance", SoundHeader(), findings).verdict, Verdict::kOk);
}

TEST(CheckList, GainsAreTheMovingAverages) {
  trial::Metadata metadata;
  EXPECT_TRUE(AveragingGains(metadata, dsp::BandPass{}).empty());
  metadata.averages = 4;
  EXPECT_TRUE(AveragingGains(metadata, dsp::BandPass{}).empty()) << "the period is not known";
  metadata.sampling_s = 1e-3;
  const auto gains = AveragingGains(metadata, dsp::BandPass{});
  ASSERT_EQ(gains.size(), 4U);
  for (const ToneGain& tone : gains) {
    // the mean of four samples of a rotating phasor, written out
    std::complex<double> sum = 0;
    for (int k = 0; k < 4; ++k) {
      sum += std::polar(1.0, 2 * std::numbers::pi * tone.frequency_hz * k * 1e-3);
    }
    EXPECT_ABS(tone.gain, std::abs(sum) / 4, 1e-14, "rounding");
  }
  // a band below the resonances asks for its corners alone
  EXPECT_EQ(AveragingGains(metadata, {.order = 6, .lower_hz = 1, .upper_hz = 20}).size(), 2U);
}

TEST(CheckList, TheSmallestRmsIsThatOfTheNoiseOrOfTheSteps) {
  CheckFindings findings = SoundFindings();
  EXPECT_DOUBLE_EQ(*SmallestRmsOf(findings, dsp::BandPass{}, 0.1),
                   acquire::SmallestRms({2e-6, 480, 10, 10}, 0.1));
  findings.noise_m = 0;
  // 1 um / sqrt(12) over 1500 Hz, of which 480 Hz count
  const double rounding_m = 1e-6 / std::sqrt(12.0) * std::sqrt(480.0 / 1500.0);
  EXPECT_REL(*SmallestRmsOf(findings, dsp::BandPass{}, 0.1),
             acquire::SmallestRms({rounding_m, 480, 10, 10}, 0.1), 1e-12, "rounding");
  findings.noise_m.reset();
  EXPECT_FALSE(SmallestRmsOf(findings, dsp::BandPass{}, 0.1));
}

// --- the findings ------------------------------------------------------------------------------

trial::Record RecordOf(const std::vector<double>& values_m, double rate_hz) {
  trial::Record record;
  record.rows = values_m.size();
  record.stretches = {{0, record.rows, 0, rate_hz, 1e-6}};
  trial::Channel channel;
  channel.role = trial::ChannelRole::kDisplacement;
  channel.unit = "m";
  channel.values = values_m;
  channel.statuses.assign(record.rows, SampleStatus::kOk);
  record.channels.push_back(channel);
  return record;
}

TEST(CheckFindings, AreThoseOfTheRecord) {
  // white noise of 1 um over 5000 Hz: 1 um sqrt(480/5000) in the band, beside a tone that is there
  std::vector<double> values = dsp::Samples(10e3, 100'000, 2e-3, {{20e-6, 225, 0}});
  dsp::Noise noise(3);
  for (double& value : values) value += 1e-6 * noise();
  const CheckFindings findings = FindingsOf(RecordOf(values, 10e3), {}, dsp::BandPass{});
  EXPECT_ABS(*findings.level_m, 2e-3, 1e-7, "the mean of whole periods, and 1 um / sqrt(1e5)");
  EXPECT_REL(*findings.noise_m, 1e-6 * std::sqrt(480.0 / 5000.0), 0.05,
             "1/sqrt(2 B T) = 1 %, and the filter's noise bandwidth is not quite 480 Hz");
  EXPECT_ABS(*findings.tone_hz, 225, 1e-3, "noise");
  EXPECT_REL(*findings.tone_rms_m, 20e-6 / std::numbers::sqrt2, 1e-3, "noise");
  EXPECT_DOUBLE_EQ(findings.fresh_rate_hz, 10e3);
  EXPECT_DOUBLE_EQ(findings.duration_s, 10);
  EXPECT_DOUBLE_EQ(findings.time_uncertainty_s, 1e-6);
  EXPECT_EQ(findings.measured, 100'000U);
}

TEST(CheckFindings, CountWhatIsHeldAndLeaveOutWhatIsNoMeasurement) {
  trial::Record record = RecordOf({1e-3, 2e-3, 2e-3, 9, 2e-3, 3e-3}, 10);
  record.channels[0].statuses[3] = SampleStatus::kInvalid;
  const CheckFindings findings = FindingsOf(record, {}, {.order = 6, .lower_hz = 1, .upper_hz = 3});
  EXPECT_EQ(findings.measured, 5U);
  EXPECT_EQ(findings.longest_hold, 3U) << "a hole does not prove that the value moved";
  EXPECT_EQ(*findings.greatest_m, 3e-3);
  EXPECT_FALSE(findings.noise_m);
  EXPECT_NE(findings.no_noise_because, "");
}

TEST(CheckFindings, AreOfTheChannelInMetres) {
  trial::Record record = RecordOf({1e-3, 2e-3}, 10);
  trial::Channel volts = record.channels[0];
  volts.unit = "V";
  volts.values = {7, 8};
  record.channels.insert(record.channels.begin(), volts);
  EXPECT_EQ(FindingsOf(record, {}, dsp::BandPass{}).greatest_m, 2e-3);
}

TEST(CheckFindings, OfARecordWithoutAMeasurementSaySo) {
  trial::Record record = RecordOf({1e-3, 2e-3}, 10);
  record.channels[0].statuses = {SampleStatus::kInvalid, SampleStatus::kOver};
  const CheckFindings findings = FindingsOf(record, {}, dsp::BandPass{});
  EXPECT_EQ(findings.measured, 0U);
  EXPECT_FALSE(findings.level_m);
  EXPECT_FALSE(IsReady(CheckList(SoundHeader(), findings, kQuestion)));
}

// --- what is printed ---------------------------------------------------------------------------

TEST(CheckOutput, HasTheSameFactsInBothForms) {
  CheckFindings findings = SoundFindings();
  findings.fresh_rate_hz = 48;
  findings.noise_m.reset();
  const auto items = CheckList(SoundHeader(), findings, kQuestion);
  const document::Document made = CheckDocument(SoundHeader(), findings, kQuestion, items);
  const std::string text = document::TextOf(made, document::Detail::kShort);
  EXPECT_THAT(text, ::testing::StartsWith("not ready: 2 to fix\n"));
  EXPECT_THAT(text, HasSubstr("  FIX  rate       48 new readings/s"));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("smallest RMS to 10 %")));
  EXPECT_THAT(document::TextOf(made, document::Detail::kAll), HasSubstr("new readings"));
  const auto document = nlohmann::json::parse(document::JsonOf(made));
  EXPECT_EQ(document["ready"], false);
  EXPECT_EQ(document["items"].size(), items.size());
  EXPECT_EQ(document["items"][5]["verdict"], "fix");
  EXPECT_EQ(document["items"][0]["remedy"], nullptr);
  EXPECT_EQ(document["noise_rms_m"], nullptr);
  EXPECT_EQ(document["smallest_rms_10_percent_m"], nullptr);
  EXPECT_EQ(document["new_readings_per_s"], 48);
  EXPECT_EQ(document["averaging_gains"].size(), 4U);
}

}  // namespace
}  // namespace haptometer::tools
