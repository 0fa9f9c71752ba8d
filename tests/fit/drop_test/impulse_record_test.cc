#include "fit/drop_test/impulse_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/findings.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using ::testing::HasSubstr;

trial::Record MakeRecording() {
  trial::Record record;
  record.rows = 3;
  record.channels = {{.name = "voltage_v",
                      .role = trial::ChannelRole::kVoltage,
                      .unit = "V",
                      .values = {0.1, 0.2, 0.3},
                      .statuses = {trial::SampleStatus::kOk, trial::SampleStatus::kClipped,
                                   trial::SampleStatus::kOk}}};
  record.stretches = {{.first_row = 0, .rows = 3, .start_s = -0.5, .rate_hz = 1000}};
  return record;
}

std::string ErrorOf(const trial::Record& record) {
  const auto file = ImpulseFromRecord(record, "impulse.csv");
  EXPECT_FALSE(file);
  if (file) return {};
  EXPECT_EQ(file.error().cause, Cause::kCannotAnswer);
  EXPECT_FALSE(file.error().remedy.empty());
  return file.error().Text();
}

TEST(ImpulseRecord, TakesVoltageTimeBaseAndEveryKey) {
  auto recording = MakeRecording();
  recording.metadata.fields = {{"case", "free"},
                               {"load_ohm", "33"},
                               {"drop_height_m", "0.010(1)"},
                               {"rebound", "0.1"},
                               {"moving_mass_kg", "1.40(3) g"},
                               {"case_mass_kg", "6e-4"},
                               {"resistance_ohm", "27 ohm"},
                               {"inductance_h", "130uH"},
                               {"operator", "somebody"}};
  const auto file = ImpulseFromRecord(recording, "impulse.csv");
  ASSERT_TRUE(file) << file.error().Text();
  EXPECT_EQ(file->record.name, "impulse.csv");
  EXPECT_EQ(file->record.start_s, -0.5);
  EXPECT_EQ(file->record.step_s, 1e-3);
  EXPECT_EQ(file->record.voltage_v[0], 0.1);
  EXPECT_TRUE(std::isnan(file->record.voltage_v[1]));  // clipped: not a measurement
  EXPECT_EQ(file->record.condition, CaseCondition::kFree);
  EXPECT_EQ(file->record.load_ohm->value, 33);
  EXPECT_EQ(file->record.drop_height_m->value, 0.01);
  EXPECT_ABS(file->record.drop_height_m->standard_uncertainty, 1e-3, 1e-15, "digits of a bracket");
  EXPECT_EQ(file->record.rebound->value, 0.1);
  EXPECT_ABS(file->knowns.moving_mass_kg->value, 1.4e-3, 1e-18, "g to kg");
  EXPECT_ABS(file->knowns.moving_mass_kg->standard_uncertainty, 3e-5, 1e-18, "g to kg");
  EXPECT_EQ(file->knowns.case_mass_kg->value, 6e-4);
  EXPECT_EQ(file->knowns.resistance_ohm->value, 27);
  EXPECT_ABS(file->knowns.inductance_h->value, 130e-6, 1e-18, "uH to H");
}

TEST(ImpulseRecord, AnAbsentKeyIsUnknownAndInfIsOpen) {
  auto recording = MakeRecording();
  auto file = ImpulseFromRecord(recording, "impulse.csv");
  ASSERT_TRUE(file);
  EXPECT_FALSE(file->record.load_ohm || file->record.condition || file->record.drop_height_m ||
               file->record.rebound || file->knowns.moving_mass_kg);
  recording.metadata.fields = {{"load_ohm", "inf"}};
  file = ImpulseFromRecord(recording, "impulse.csv");
  ASSERT_TRUE(file);
  EXPECT_TRUE(std::isinf(file->record.load_ohm->value));
}

TEST(ImpulseRecord, OfSeveralVoltagesNoneIsTaken) {
  auto recording = MakeRecording();
  recording.channels.push_back(*recording.Find(trial::ChannelRole::kVoltage));
  recording.channels.back().name = "CH2";
  const auto file = ImpulseFromRecord(recording, "impulse.csv");
  ASSERT_FALSE(file);
  EXPECT_NE(file.error().Text().find("CH2; name the channel that is the coil's"), std::string::npos)
      << file.error().Text();
}

TEST(ImpulseRecord, AUnitIsNeverSwallowedByTheKeysUnit) {
  // "0.01 m" must not become 0.01 mm
  auto recording = MakeRecording();
  recording.metadata.fields = {{"drop_height_m", "0.01 m"}};
  const auto file = ImpulseFromRecord(recording, "impulse.csv");
  ASSERT_TRUE(file);
  EXPECT_EQ(file->record.drop_height_m->value, 0.01);
}

TEST(ImpulseRecord, BadKeysAreNamed) {
  const auto error_with = [](const std::string& key, const std::string& value) {
    auto recording = MakeRecording();
    recording.metadata.fields = {{key, value}};
    return ErrorOf(recording);
  };
  EXPECT_THAT(error_with("case", "loose"), HasSubstr("impulse.csv: case: 'loose' is not known"));
  EXPECT_THAT(error_with("load_ohm", "some"), HasSubstr("impulse.csv: load_ohm"));
  EXPECT_THAT(error_with("load_ohm", "0"), HasSubstr("out of range"));
  EXPECT_THAT(error_with("moving_mass_kg", "-1e-3"), HasSubstr("moving_mass_kg"));
  EXPECT_THAT(error_with("drop_height_m", "10 ohm"), HasSubstr("drop_height_m"));
  EXPECT_THAT(error_with("rebound", "1.5"), HasSubstr("rebound"));
}

TEST(ImpulseRecord, ARecordingWithoutAVoltageOrWithGapsIsRefused) {
  auto recording = MakeRecording();
  recording.stretches = {{.first_row = 0, .rows = 1, .start_s = 0, .rate_hz = 1000},
                         {.first_row = 1, .rows = 2, .start_s = 1, .rate_hz = 1000}};
  EXPECT_THAT(ErrorOf(recording), HasSubstr("gaps"));
  recording = MakeRecording();
  recording.channels[0].role = trial::ChannelRole::kCurrent;
  EXPECT_THAT(ErrorOf(recording), HasSubstr("no voltage"));
}

// times of 1000 rows at 1 kHz, each known to 7.07e-5 s: sqrt(2) of that over 1 s
TEST(ImpulseRecord, RoundedTimesAreAnUncertainTimeScale) {
  const trial::Stretch known{
      .rows = 1000, .rate_hz = 1000, .time_uncertainty_s = 1e-4 / std::numbers::sqrt2};
  ASSERT_TRUE(TimeScaleOf(known));
  EXPECT_EQ(TimeScaleOf(known)->value, 1);
  EXPECT_REL(TimeScaleOf(known)->standard_uncertainty, 1e-4, 1e-15, "rounding");
  EXPECT_FALSE(TimeScaleOf({.rows = 1000, .rate_hz = 1000, .time_uncertainty_s = 7e-8}));
  EXPECT_TRUE(TimeScaleOf({.rows = 1000, .rate_hz = 1000, .time_uncertainty_s = 7.1e-8}));
  auto recording = MakeRecording();
  recording.stretches[0].time_uncertainty_s = 1e-4;
  const auto file = ImpulseFromRecord(recording, "t.csv");
  ASSERT_TRUE(file) << file.error().Text();
  EXPECT_EQ(file->record.time_scale, TimeScaleOf(recording.stretches[0]));
}

TEST(ImpulseRecord, WithoutAVoltageADisplacementIsTaken) {
  auto recording = MakeRecording();
  recording.channels[0].role = trial::ChannelRole::kDisplacement;
  const auto file = ImpulseFromRecord(recording, "tap.csv");
  ASSERT_TRUE(file) << file.error().Text();
  EXPECT_EQ(file->record.signal, RecordedSignal::kDisplacement);
  EXPECT_EQ(file->record.unit, "m");
  recording.channels.push_back(recording.channels[0]);
  EXPECT_THAT(ErrorOf(recording), HasSubstr("several displacements"));
}

constexpr double kPeriodSamples = 40;

// a ring-down of amplitude 1 and Q = 60, rounded to `step` and cut at `limit`
std::vector<double> RingDown(double step, double limit) {
  std::vector<double> values;
  for (int n = 0; n < 1200; ++n) {
    const double angle = 2 * std::numbers::pi * n / kPeriodSamples;
    double v = std::exp(-angle / 120) * std::sin(angle + 0.3);
    if (step > 0) v = std::round(v / step) * step;
    values.push_back(std::clamp(v, -limit, limit));
  }
  return values;
}

std::size_t Masked(std::vector<double> values) { return MaskRails(values, kPeriodSamples); }

TEST(MaskRails, LeavesWholePeaksAlone) {
  EXPECT_EQ(Masked(RingDown(0, 2)), 0U);
  for (const double step : {1e-4, 0.0078125, 0.1}) {
    SCOPED_TRACE(step);
    EXPECT_EQ(Masked(RingDown(step, 2)), 0U) << "a rounded peak is flat for a while";
  }
}

TEST(MaskRails, TakesOutEverySampleAtALimit) {
  for (const double step : {0.0, 0.0078125}) {
    SCOPED_TRACE(step);
    auto values = RingDown(step, 0.796875);  // whole steps of 1/128
    const auto at_limit = static_cast<std::size_t>(
        std::ranges::count_if(values, [](double v) { return std::abs(v) == 0.796875; }));
    EXPECT_EQ(MaskRails(values, kPeriodSamples), at_limit);
    EXPECT_GT(at_limit, 20U);
    EXPECT_EQ(static_cast<std::size_t>(
                  std::ranges::count_if(values, [](double v) { return std::isnan(v); })),
              at_limit);
  }
}

TEST(MaskRails, OneLimitAloneIsEnough) {
  auto values = RingDown(0, 2);
  for (double& v : values) v = std::min(v, 0.8);
  EXPECT_GT(MaskRails(values, kPeriodSamples), 10U);
  EXPECT_LT(*std::ranges::min_element(values), -0.85) << "the other side is whole";
}

TEST(MaskRails, AConstantRecordHasNoRails) {
  EXPECT_EQ(Masked(std::vector<double>(100, 1.0)), 0U);
  EXPECT_EQ(Masked({}), 0U);
}

TEST(ConverterStep, IsTheDistanceOfNeighbouringCodes) {
  EXPECT_DOUBLE_EQ(ConverterStep(RingDown(0.0078125, 2)), 0.0078125);
  EXPECT_EQ(ConverterStep(RingDown(0, 2)), 0) << "not rounded";
  EXPECT_EQ(ConverterStep({1, 1, 1}), 0) << "one value has no neighbour";
  EXPECT_EQ(ConverterStep({0.25, 0.5, 0.25}), 0.25) << "two are neighbours";
  EXPECT_DOUBLE_EQ(ConverterStep({0, 2, 6, std::nan("")}), 2) << "codes may be missing";
  EXPECT_EQ(ConverterStep({0, 2, 5}), 0) << "2.5 steps of 2 are none";
  // 4096 codes at most
  std::vector<double> codes;
  for (int code = 4095; code >= 0; --code) codes.push_back(0.25 * code);
  EXPECT_EQ(ConverterStep(codes), 0.25);
  codes.push_back(1024);
  EXPECT_EQ(ConverterStep(codes), 0) << "more than a converter of 12 bits has";
}

TEST(ImpulseRecord, NumbersAreTakenUpToTheEndsOfTheirRanges) {
  const auto is_taken = [](const std::string& key, const std::string& value) {
    auto recording = MakeRecording();
    recording.metadata.fields = {{key, value}};
    return ImpulseFromRecord(recording, "impulse.csv").has_value();
  };
  for (const auto* value : {"0", "1", "0.999"}) EXPECT_TRUE(is_taken("rebound", value)) << value;
  for (const auto* value : {"-0.001", "1.001"}) EXPECT_FALSE(is_taken("rebound", value)) << value;
  EXPECT_TRUE(is_taken("inductance_h", "0"));
  EXPECT_FALSE(is_taken("inductance_h", "-1e-6"));
  for (const auto* key :
       {"load_ohm", "drop_height_m", "release_current_a", "added_mass_kg", "voltage_scale",
        "time_scale", "moving_mass_kg", "case_mass_kg", "resistance_ohm"}) {
    EXPECT_TRUE(is_taken(key, "1e-3")) << key;
    EXPECT_FALSE(is_taken(key, "0")) << key;
    EXPECT_FALSE(is_taken(key, "-1e-3")) << key;
  }
}

TEST(ImpulseRecord, TakesReleaseScalesAndAddedMass) {
  auto recording = MakeRecording();
  recording.metadata.fields = {{"release_current_a", "50(1) mA"},
                               {"added_mass_kg", "0.5 g"},
                               {"voltage_scale", "1.02(1)"},
                               {"time_scale", "0.999"}};
  const auto file = ImpulseFromRecord(recording, "impulse.csv");
  ASSERT_TRUE(file) << file.error().Text();
  EXPECT_REL(file->record.release_current_a->value, 0.05, 1e-14, "mA to A");
  EXPECT_REL(file->record.release_current_a->standard_uncertainty, 1e-3, 1e-12, "mA to A");
  EXPECT_REL(file->record.added_mass_kg->value, 5e-4, 1e-14, "g to kg");
  EXPECT_EQ(file->record.voltage_scale->value, 1.02);
  EXPECT_REL(file->record.voltage_scale->standard_uncertainty, 0.01, 1e-12, "digits of a bracket");
  EXPECT_EQ(file->record.time_scale->value, 0.999);
}

// steps of 1 from -10 to 10, and `run` samples at 10 together
std::vector<double> WithPlateau(std::size_t run) {
  std::vector<double> values;
  for (int code = -10; code < 10; ++code) values.push_back(code);
  values.insert(values.end(), run, 10.0);
  for (int code = 9; code > -10; --code) values.push_back(code);
  return values;
}

TEST(MaskRails, APeakMayBeAsFlatAsARoundedSineAndTwoSamplesMore) {
  // amplitude 10 and steps of 1: acos(1 - 1/10)/pi = 0.14357 of 100 samples, and 2
  for (const std::size_t run : {14U, 16U}) {
    auto values = WithPlateau(run);
    EXPECT_EQ(MaskRails(values, 100), 0U) << run;
  }
  auto values = WithPlateau(17);
  EXPECT_EQ(MaskRails(values, 100), 17U);
  // as many, but half a period apart from each other
  auto apart = WithPlateau(9);
  apart.insert(apart.end(), 20, 0.0);
  const auto again = WithPlateau(9);
  apart.insert(apart.end(), again.begin(), again.end());
  EXPECT_EQ(MaskRails(apart, 100), 0U);
}

TEST(MaskRails, ThreeEqualExtremesOfUnroundedValuesAreARail) {
  const auto masked = [](std::size_t equal) {
    auto values = RingDown(0, 2);
    for (std::size_t k = 0; k < equal; ++k) values[100 * k] = 3;
    return MaskRails(values, kPeriodSamples);
  };
  EXPECT_EQ(masked(2), 0U);
  EXPECT_EQ(masked(3), 3U);
}

TEST(ConverterStep, HasUpTo4096CodesThatAreWholeStepsApart) {
  const auto step = [](int codes) {
    std::vector<double> values;
    for (int code = 0; code < codes; ++code) values.push_back(0.25 * code);
    return ConverterStep(values);
  };
  EXPECT_EQ(step(4096), 0.25);
  EXPECT_EQ(step(4097), 0);
  // decimals that are printed may round a tenth of a step away
  EXPECT_DOUBLE_EQ(ConverterStep({0, 1, 3.0995}), 1);
  EXPECT_EQ(ConverterStep({0, 1, 3.1005}), 0);
}

TEST(ImpulseRecord, KeysThatAreNearlyKnownOnesAreNamed) {
  const auto found = [](const std::string& key) {
    auto recording = MakeRecording();
    recording.metadata.fields = {{key, "1"}};
    const auto file = ImpulseFromRecord(recording, "impulse.csv");
    EXPECT_TRUE(file);
    if (!file || file->findings.list().empty()) return std::string();
    EXPECT_EQ(file->findings.list().front().subject, "impulse.csv");
    EXPECT_EQ(tests::NumberOf<std::string>(file->findings, FindingKind::kHeaderKeyUnknown, "key"),
              key);
    return tests::NumberOf<std::string>(file->findings, FindingKind::kHeaderKeyUnknown, "nearest");
  };
  EXPECT_EQ(found("load_ohms"), "load_ohm");
  EXPECT_EQ(found("moving_mas_kg"), "moving_mass_kg");
  // known; written as no key of this program is; and unlike all of them
  for (const auto* key : {"load_ohm", "loadohm", "Load_ohms", "load_ohms ", "colour_of_the_case"}) {
    EXPECT_EQ(found(key), "") << key;
  }
}

TEST(ImpulseRecord, TheFirstOfSeveralBadKeysIsNamed) {
  auto recording = MakeRecording();
  recording.metadata.fields = {{"load_ohm", "0"}, {"rebound", "2"}, {"case", "loose"}};
  EXPECT_THAT(ErrorOf(recording), HasSubstr("load_ohm"));
  recording.metadata.fields = {{"rebound", "2"}, {"case", "loose"}};
  EXPECT_THAT(ErrorOf(recording), HasSubstr("rebound"));
}

TEST(ImpulseRecord, ASingleChannelOfNoKnownKindIsTakenAsTheVoltage) {
  auto recording = MakeRecording();
  recording.channels[0].role = trial::ChannelRole::kOther;
  const auto file = ImpulseFromRecord(recording, "impulse.csv");
  ASSERT_TRUE(file) << file.error().Text();
  EXPECT_EQ(file->record.signal, RecordedSignal::kVoltage);
  EXPECT_EQ(file->record.voltage_v[2], 0.3);
  recording.channels.push_back(recording.channels[0]);
  EXPECT_THAT(ErrorOf(recording), HasSubstr("no voltage"));
}

TEST(ImpulseRecord, TimesOfArrivalAreTakenWhereTheyAreExact) {
  auto recording = MakeRecording();
  recording.timing = trial::Timing::kArrival;
  EXPECT_TRUE(ImpulseFromRecord(recording, "impulse.csv"));
  recording.stretches[0].time_uncertainty_s = 1e-6;
  EXPECT_THAT(ErrorOf(recording), HasSubstr("non-uniform"));
}

}  // namespace
}  // namespace haptometer::fit
