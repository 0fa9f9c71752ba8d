#include "acquire/capability.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/findings.h"
#include "tests/residual.h"

// What sensors can answer, against numbers worked out from their manuals.

namespace haptometer::acquire {
namespace {

using ::testing::HasSubstr;

const SensorAbility kFast{.name = "fast",
                          .rate_hz = 10'000,
                          .limit = RateLimit::kWire,
                          .resolution_m = 1e-7,
                          .noise_rms_m = 5e-7};

Capability Of(const std::string& name, const CapabilityQuestion& question = {}) {
  const auto all = Judge(KnownSensors(), question);
  const auto found = std::ranges::find_if(
      all, [&](const Capability& c) { return c.sensor.name.starts_with(name); });
  EXPECT_NE(found, all.end()) << name;
  return found == all.end() ? Capability{} : *found;
}

TEST(Capability, TheRateDecidesFirst) {
  SensorAbility slow = kFast;
  slow.rate_hz = 1279;
  EXPECT_FALSE(Judge(slow, {}).can_answer);
  EXPECT_EQ(Judge(slow, {}).reason.kind, FindingKind::kRateTooLow);
  EXPECT_EQ(tests::NumbersOf(Judge(slow, {}).reason),
            "rate_hz=1279 observable_hz=499.609 asked_hz=500 needed_hz=1280");
  slow.rate_hz = 1280;
  EXPECT_TRUE(Judge(slow, {}).can_answer);
  EXPECT_TRUE(Judge(kFast, {}).can_answer);
  EXPECT_REL(Judge(kFast, {}).highest_hz, 3906.25, 1e-15, "one quotient");
}

TEST(Capability, AveragingTakesTheUpperEdge) {
  SensorAbility averaged = kFast;
  averaged.sampling_s = 0.33e-3;
  averaged.averages = 4;
  // sin(pi f n T) / (n sin(pi f T)) at 500 Hz: sin 2.07345 / (4 sin 0.518363) = 0.8763 / 1.9819
  const Capability capability = Judge(averaged, {});
  EXPECT_REL(capability.gain_upper, 0.8763 / 1.9819, 2e-4, "four digits");
  EXPECT_REL(capability.gain_lower, 0.9989, 1e-4, "four digits");
  EXPECT_FALSE(capability.can_answer);
  EXPECT_EQ(capability.reason.kind, FindingKind::kAveragingTooLong);
  EXPECT_THAT(tests::NumbersOf(capability.reason),
              HasSubstr("averages=4 sampling_s=0.00033 gain=0.442"));
  averaged.averages = 2;
  EXPECT_TRUE(Judge(averaged, {}).can_answer);  // 0.869
}

TEST(Capability, StepsMayBeAsLargeAsWanted) {
  SensorAbility coarse = kFast;
  coarse.resolution_m = 1e-6;
  EXPECT_TRUE(Judge(coarse, {}).can_answer);
  coarse.resolution_m = 1e-2;
  EXPECT_EQ(Judge(coarse, {}).reason.kind, FindingKind::kStepsTooLarge);
  EXPECT_EQ(tests::NumbersOf(Judge(coarse, {}).reason), "step_m=0.01 wanted_m=1e-06");
  coarse.resolution_m.reset();
  EXPECT_TRUE(Judge(coarse, {}).can_answer);
}

TEST(Capability, NoiseInTheBandIsItsShareOfHalfTheRate) {
  const Capability capability = Judge(kFast, {.lower_hz = 20, .upper_hz = 500});
  EXPECT_REL(*capability.noise_in_band_m, 5e-7 * std::sqrt(480.0 / 5000), 1e-14, "a root");
  // B T = 4800 and noise of 0.15492 um, as in the tests of SmallestRms
  EXPECT_REL(*capability.smallest_rms_10_percent_m, 1.5492e-7 * std::sqrt(0.107403), 1e-4,
             "five digits");
  // a band above half the rate has nothing to say
  SensorAbility slow = kFast;
  slow.rate_hz = 30;
  EXPECT_FALSE(Judge(slow, {}).noise_in_band_m);
}

// whether a sensor that is `fast` but for one number can answer
bool CanAnswer(const SensorAbility& sensor) { return Judge(sensor, {}).can_answer; }

TEST(Capability, ARateMayFallShortByWhatTwoClocksAreOff) {
  // 1280 readings/s are needed; two quartzes of 50 ppm are left to the clocks (base/band.h)
  SensorAbility sensor = kFast;
  sensor.rate_hz = 1280 * (1 - 0.99e-4);
  EXPECT_TRUE(CanAnswer(sensor));
  sensor.rate_hz = 1280 * (1 - 1.01e-4);
  EXPECT_FALSE(CanAnswer(sensor));
}

TEST(Capability, StepsMayExceedTheWishByRoundingAlone) {
  SensorAbility sensor = kFast;
  sensor.resolution_m = 1e-6 * (1 + 0.99e-9);
  EXPECT_TRUE(CanAnswer(sensor));
  sensor.resolution_m = 1e-6 * (1 + 1.01e-9);
  EXPECT_FALSE(CanAnswer(sensor));
}

TEST(Capability, AveragingMayTakeThreeDecibels) {
  // a mean of two samples leaves cos(pi f T), which is 1 / sqrt(2) at f T = 1/4: 0.5 ms at 500 Hz
  SensorAbility sensor = kFast;
  sensor.averages = 2;
  sensor.sampling_s = 0.4975e-3;
  EXPECT_TRUE(CanAnswer(sensor));
  sensor.sampling_s = 0.5025e-3;
  EXPECT_FALSE(CanAnswer(sensor));
}

TEST(Capability, NothingIsAveragedAtZeroHertz) {
  SensorAbility averaged = kFast;
  averaged.sampling_s = 1e-3;
  averaged.averages = 16;
  EXPECT_EQ(Judge(averaged, {.lower_hz = 0, .upper_hz = 10}).gain_lower, 1);
}

TEST(Capability, SaysTheNoiseAndTheSmallestRms) {
  // 5e-7 sqrt(480 / 5000) = 1.549193e-7; times sqrt(0.1074032): 5.077084e-8
  EXPECT_EQ(tests::NumbersOf(Judge(kFast, {}).reason),
            "rate_hz=10000 observable_hz=3906.25 noise_m=1.54919e-07 smallest_m=5.07708e-08 "
            "record_s=10");
  SensorAbility silent = kFast;
  silent.noise_rms_m.reset();
  EXPECT_EQ(tests::NumbersOf(Judge(silent, {}).reason), "rate_hz=10000 observable_hz=3906.25");
}

TEST(Capability, NoNoiseNeedsNoSmallestRms) {
  SensorAbility sensor = kFast;
  sensor.noise_rms_m = 0;
  const Capability capability = Judge(sensor, {});
  EXPECT_EQ(capability.noise_in_band_m, 0);
  EXPECT_FALSE(capability.smallest_rms_10_percent_m);
}

TEST(KnownSensors, SayWhatTheirManualsAllow) {
  // 48.4 readings/s at 9600 baud, 122 at 38400; 7.8 ms of processing are 128/s
  EXPECT_REL(Of("IL-030 through a DL-RS1A, 9600").sensor.rate_hz, 48.4, 1e-3, "three digits");
  EXPECT_REL(Of("IL-030 through a DL-RS1A, 38400").sensor.rate_hz, 122.4, 1e-3, "four digits");
  EXPECT_REL(Of("IL-030 through a DL-EN1").sensor.rate_hz, 128.2, 1e-3, "four digits");
  EXPECT_EQ(Of("lines of 9 characters sent without request, 921600 baud").sensor.rate_hz, 10'240);
  // 15 characters at 115200 baud
  EXPECT_REL(Of("LK-G").sensor.rate_hz, 768, 1e-5, "rounded to nanoseconds");
}

// what the makers print of the IL-030: 1 um, 20 to 45 mm about 30 mm, and 11 um of noise a sample,
// which 16 averages make 11 um / 4
void ExpectAFactoryIl030(const SensorAbility& sensor) {
  EXPECT_EQ(sensor.sampling_s, 1e-3) << sensor.name;
  EXPECT_EQ(sensor.averages, 16) << sensor.name;
  EXPECT_EQ(sensor.resolution_m, 1e-6) << sensor.name;
  EXPECT_REL(sensor.noise_rms_m.value(), 2.75e-6, 1e-15, "a root and a quotient");
  EXPECT_EQ(sensor.range_min_m, -15e-3) << sensor.name;
  EXPECT_EQ(sensor.range_max_m, 10e-3) << sensor.name;
}

TEST(KnownSensors, AUnitHasTheTimesOfItsWireAndOfItsBuffer) {
  // 16 characters of 10 bits and 4 ms of processing; the buffer is renewed every 7 ms
  for (const int baud : {2400, 4800, 9600, 19200, 38400}) {
    const SensorAbility rs1a =
        Of("IL-030 through a DL-RS1A, " + std::to_string(baud) + " baud").sensor;
    ExpectAFactoryIl030(rs1a);
    EXPECT_REL(rs1a.wire_s, 160.0 / baud + 4e-3, 1e-6, "rounded to nanoseconds");
    EXPECT_EQ(rs1a.refresh_s, 7e-3);
    EXPECT_REL(rs1a.rate_hz, 1 / rs1a.wire_s, 1e-15, "the wire is slower than the buffer");
    EXPECT_EQ(rs1a.limit, RateLimit::kWire);
    EXPECT_TRUE(rs1a.is_polled);
  }
  const SensorAbility en1 = Of("IL-030 through a DL-EN1").sensor;
  ExpectAFactoryIl030(en1);
  EXPECT_REL(en1.refresh_s, 7.8e-3, 1e-12, "two quotients");
  EXPECT_EQ(en1.limit, RateLimit::kUnitProcessing);
  EXPECT_TRUE(en1.is_polled);
}

TEST(KnownSensors, AnLkgAndAStreamHaveTheStepOfTheirLastDigit) {
  // +01.2345 in mm
  const SensorAbility lkg = Of("LK-G").sensor;
  EXPECT_EQ(lkg.resolution_m, 1e-7);
  EXPECT_EQ(lkg.limit, RateLimit::kWireAlone);
  EXPECT_REL(lkg.wire_s, 150.0 / 115200, 1e-6, "rounded to nanoseconds");
  EXPECT_TRUE(lkg.is_polled);
  for (const int baud : {9600, 115200, 230400, 460800, 921600}) {
    const SensorAbility stream =
        Of("lines of 9 characters sent without request, " + std::to_string(baud) + " baud").sensor;
    EXPECT_REL(stream.resolution_m.value(), 1e-7, 1e-15, "one division");
    EXPECT_REL(stream.wire_s, 90.0 / baud, 1e-15, "a quotient");
    EXPECT_FALSE(stream.is_polled);
  }
}

TEST(KnownSensors, AnAnalogOutputIsRenewedWithEachRawSample) {
  const SensorAbility analog = AnalogOutput(2e-3, 4);
  EXPECT_EQ(analog.name, "IL-030, analog output and a DAQ, 2 ms, 4 averages");
  EXPECT_EQ(AnalogOutput(0.33e-3, 1).name, "IL-030, analog output and a DAQ, 0.33 ms, 1 average");
  EXPECT_EQ(AnalogOutput(1e-3, 2).name, "IL-030, analog output and a DAQ, 1 ms, 2 averages");
  EXPECT_EQ(analog.rate_hz, 500);
  EXPECT_EQ(analog.averages, 4);
  EXPECT_EQ(analog.sampling_s, 2e-3);
  EXPECT_REL(analog.noise_rms_m.value(), 5.5e-6, 1e-15, "11 um / sqrt(4)");
  EXPECT_FALSE(analog.resolution_m) << "that of a converter which is not stated";
  EXPECT_EQ(analog.limit, RateLimit::kAmplifierSampling);
}

TEST(KnownSensors, AModbusSensorsWireAndPeriodAreApart) {
  // 8 + 7 characters of 11 bits at 9600 baud and two intervals of 38.5 bits: 242 bits
  const SensorAbility riftek = Of("RIFTEK RF602, Modbus").sensor;
  EXPECT_REL(riftek.rate_hz, 9600.0 / 242, 1e-6, "rounded to nanoseconds");
  EXPECT_REL(riftek.wire_s, 242 / 9600.0, 1e-6, "rounded to nanoseconds");
  EXPECT_EQ(riftek.refresh_s, 5e-3) << "sampling period as delivered";
  EXPECT_EQ(riftek.limit, RateLimit::kWireAndSensor);
  EXPECT_TRUE(riftek.is_polled);
  EXPECT_EQ(Of("WIT-motion, DFRobot WT53R").sensor.resolution_m, 1e-3);
  EXPECT_EQ(Of("WIT-motion, DFRobot WT53R").sensor.refresh_s, 0) << "the maker states none";
  // as delivered 100 readings/s, which the wire exceeds
  EXPECT_EQ(Of("Benewake").sensor.rate_hz, 100);
  EXPECT_EQ(Of("Benewake").sensor.resolution_m, 1e-2);
}

TEST(KnownSensors, WhoAnswers20To500Hz) {
  EXPECT_TRUE(Of("IL-030, analog output and a DAQ, 0.33 ms, 1 average").can_answer);
  EXPECT_FALSE(Of("IL-030, analog output and a DAQ, 0.33 ms, 4").can_answer);
  EXPECT_FALSE(Of("IL-030, analog output and a DAQ, 1 ms, 16").can_answer);
  EXPECT_TRUE(Of("lines of 9 characters sent without request, 921600 baud").can_answer);
  EXPECT_TRUE(
      Of("lines of 9 characters sent without request, 115200 baud").can_answer);  // 1280 exactly
  EXPECT_FALSE(Of("lines of 9 characters sent without request, 9600 baud").can_answer);
  EXPECT_FALSE(Of("LK-G").can_answer);
  for (const int baud : {2400, 4800, 9600, 19200, 38400}) {
    EXPECT_FALSE(Of("IL-030 through a DL-RS1A, " + std::to_string(baud)).can_answer);
  }
  // an IL-030 without averaging: 11 um, of which 480 of 1515 Hz are in the band
  const Capability analog = Of("IL-030, analog output and a DAQ, 0.33 ms, 1 average");
  EXPECT_REL(*analog.noise_in_band_m, 11e-6 * std::sqrt(480 * 2 * 0.33e-3), 1e-12, "a root");
}

TEST(KnownSensors, ASlowBandIsForASlowWire) {
  const CapabilityQuestion slow{.lower_hz = 0.5, .upper_hz = 10};
  EXPECT_TRUE(Of("IL-030 through a DL-RS1A, 9600", slow).can_answer);
  EXPECT_REL(Of("IL-030 through a DL-RS1A, 9600", slow).gain_upper, 0.9587, 1e-3,
             "sin(0.16 pi) / (16 sin(0.01 pi)) by hand");
}

TEST(KnownSensors, AreSortedByWhetherTheyAnswerAndThenByReach) {
  const auto all = Judge(KnownSensors(), {});
  for (std::size_t i = 1; i < all.size(); ++i) {
    EXPECT_GE(all[i - 1].can_answer, all[i].can_answer);
    if (all[i - 1].can_answer == all[i].can_answer) {
      EXPECT_GE(all[i - 1].highest_hz, all[i].highest_hz);
    }
    EXPECT_EQ(all[i].reason.kind == FindingKind::kCanAnswer, all[i].can_answer);
  }
}

}  // namespace
// The smallest RMS that may be reported, against its equation and against noise from a generator.
namespace {

// the equation that SmallestRms is the root of
double RelativeUncertainty(const NoiseInBand& noise, double rms_m) {
  const double q = rms_m * rms_m / (noise.rms_m * noise.rms_m);
  const double noise_parts = noise.own_share + noise.record_s / noise.noise_record_s;
  return std::sqrt((noise_parts + 2 * q) / (4 * noise.bandwidth_hz * noise.record_s)) / q;
}

const NoiseInBand kIl030{.rms_m = 6e-6, .bandwidth_hz = 480, .record_s = 10, .noise_record_s = 10};

// worked by hand: B T = 4800; s = 4 * 4800 * 0.1^2 = 192, q = (1 + sqrt(385)) / 192 = 0.107403
TEST(SmallestRms, WorkedExample) {
  EXPECT_REL(SmallestRms(kIl030, 0.1), 6e-6 * std::sqrt(0.107403), 1e-5, "six digits");
  // s = 1.92, q = (1 + sqrt(4.84)) / 1.92 = 1.6666...
  EXPECT_REL(SmallestRms(kIl030, 0.01), 6e-6 * std::sqrt(3.2 / 1.92), 1e-14, "a few roundings");
}

// half of 41 Hz is 0.5 Hz above the band's lower edge: of the band 0.5 Hz is left
TEST(SmallestRms, ABandNarrowerThanOneHertzHasOneToo) {
  SensorAbility slow = kFast;
  slow.rate_hz = 41;
  const Capability capability = Judge(slow, {.lower_hz = 20, .upper_hz = 500, .record_s = 100});
  const NoiseInBand noise{.rms_m = 5e-7 * std::sqrt(0.5 / 20.5),
                          .bandwidth_hz = 0.5,
                          .record_s = 100,
                          .noise_record_s = 100};
  EXPECT_REL(capability.noise_in_band_m.value(), noise.rms_m, 1e-14, "a root");
  EXPECT_REL(RelativeUncertainty(noise, capability.smallest_rms_10_percent_m.value()), 0.1, 1e-13,
             "a few roundings");
  EXPECT_REL(RelativeUncertainty(noise, capability.smallest_rms_1_percent_m.value()), 0.01, 1e-13,
             "a few roundings");
  slow.rate_hz = 40;
  EXPECT_FALSE(Judge(slow, {.lower_hz = 20, .upper_hz = 500}).noise_in_band_m);
}

TEST(SmallestRms, IsTheRootOfTheUncertainty) {
  for (const double relative : {0.001, 0.01, 0.1, 0.5}) {
    for (const double noise_record_s : {1.0, 10.0, 1000.0}) {
      NoiseInBand noise = kIl030;
      noise.noise_record_s = noise_record_s;
      EXPECT_REL(RelativeUncertainty(noise, SmallestRms(noise, relative)), relative, 1e-13,
                 "a few roundings");
    }
  }
}

TEST(RecordLength, IsTheInverseOfTheUncertainty) {
  for (const double relative : {0.005, 0.02, 0.1}) {
    for (const double share : {0.05, 1.0}) {
      for (const double rms_m : {2e-6, 6e-6, 50e-6}) {
        NoiseInBand noise = kIl030;
        noise.noise_record_s = 1e6;
        noise.own_share = share;
        const auto record_s = RecordLength(noise, rms_m, relative);
        ASSERT_TRUE(record_s.has_value());
        noise.record_s = *record_s;
        EXPECT_REL(RelativeUncertainty(noise, rms_m), relative, 1e-10, "a quotient of sums");
        EXPECT_REL(RelativeUncertaintyOf(noise, rms_m), relative, 1e-10, "the same");
        EXPECT_REL(SmallestRms(noise, relative), rms_m, 1e-9, "the same, and a root");
      }
    }
  }
}

// q = 1, B = 480, share 1: (1 + 2) / (4 * 480 * 0.01^2 - 1/Tn) = 3 / (0.192 - 0.1) with Tn = 10 s
TEST(RecordLength, WorkedExample) {
  const auto record_s = RecordLength(kIl030, 6e-6, 0.01);
  ASSERT_TRUE(record_s.has_value());
  EXPECT_REL(*record_s, 3 / 0.092, 1e-13, "a difference of two");
}

TEST(RecordLength, IsNoneBelowTheNoisesOwnUncertainty) {
  // 1 / sqrt(4 B Tn) = 0.00722 at q = 1
  EXPECT_FALSE(RecordLength(kIl030, 6e-6, 0.0072).has_value());
  EXPECT_TRUE(RecordLength(kIl030, 6e-6, 0.0073).has_value());
}

// a tone in white noise, its power less that of other noise: B = half the rate, so B T = n / 2
TEST(SmallestRms, TheScatterIsThatOfSimulatedRecords) {
  constexpr int kSamples = 400;
  constexpr int kRecords = 4000;
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise;
  for (const double rms : {0.7, 1.0, 3.0}) {
    double sum = 0;
    double squares = 0;
    for (int record = 0; record < kRecords; ++record) {
      double power = 0;
      double noise_power = 0;
      for (int i = 0; i < kSamples; ++i) {
        const double tone =
            std::numbers::sqrt2 * rms * std::sin(2 * std::numbers::pi * 37 * i / kSamples + 0.3);
        power += std::pow(tone + noise(random), 2) / kSamples;
        noise_power += std::pow(noise(random), 2) / kSamples;
      }
      const double estimate = std::sqrt(std::max(power - noise_power, 0.0));
      sum += estimate;
      squares += estimate * estimate;
    }
    const double mean = sum / kRecords;
    const double scatter = std::sqrt(squares / kRecords - mean * mean) / mean;
    const NoiseInBand white{
        .rms_m = 1, .bandwidth_hz = 0.5, .record_s = kSamples, .noise_record_s = kSamples};
    // 4000 records know a scatter to 1.1 %; the root's bend adds the square of the scatter
    EXPECT_REL(scatter, RelativeUncertainty(white, rms), 0.04 + scatter * scatter,
               "three standard deviations of the simulation, and the bend of the root");
    EXPECT_REL(mean, rms, 0.01 + scatter * scatter, "subtracting the noise leaves no bias");
  }
}

}  // namespace
}  // namespace haptometer::acquire
