#include "tools/analyze/expectation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <utility>
#include <vector>

namespace haptometer::tools {
namespace {

using enum ExpectationFinding;
using trial::DataSource;

// 10 um at 225 Hz whose amplitude falls by 3 % over the window
dsp::BandAnalysis Measured() {
  dsp::BandAnalysis analysis;
  analysis.answered = true;
  analysis.numbers.emplace();
  analysis.numbers->rms.rms_m = 7e-6;
  analysis.numbers->part.from_drive = true;
  analysis.numbers->part.state.drift = -0.03;
  analysis.numbers->tone.emplace();
  analysis.numbers->tone->fit.frequency_hz = 225;
  analysis.numbers->tone->amplitude_m = 1e-5;
  analysis.numbers->part.window = {1, 3.5};
  analysis.numbers->sensor.averaging = {
      .knowledge = dsp::SensorKnowledge::kKnown, .sampling_s = 1e-4, .averages = 4};
  analysis.record.offset_m = 0.03;
  analysis.record.rows = 1000;
  analysis.record.measured = 980;
  analysis.slow_motion.emplace().tremor_rms = 2e-5;
  return analysis;
}

std::vector<ExpectationFinding> KindsOf(const std::string& text, const dsp::BandAnalysis& analysis,
                                        const std::vector<DataSource>& sources = {
                                            DataSource::kDevice}) {
  const auto expected = ParseExpectation(text);
  EXPECT_TRUE(expected) << text;
  std::vector<ExpectationFinding> kinds;
  for (const auto& found : DeviationsFrom(*expected, analysis, sources).list()) {
    EXPECT_EQ(found.severity, Severity::kDoubt);
    kinds.push_back(found.kind);
  }
  return kinds;
}

TEST(Expectation, IsMetWithinItsTolerance) {
  const dsp::BandAnalysis analysis = Measured();
  EXPECT_THAT(KindsOf("tone=226Hz+-1Hz, amplitude = 11um+-1um,rms=7.4um+-0.5um, change<3.1%, "
                      "source=device, distance=30mm+-1mm, bad<2.1%, steady>2.4s, tremor<21um, "
                      "averaging=4, repeats<1%",
                      analysis),
              ::testing::IsEmpty());
  EXPECT_THAT(KindsOf("source=device", analysis, {DataSource::kDevice, DataSource::kInterrupted}),
              ::testing::IsEmpty());
}

TEST(Expectation, NamesWhatDeviates) {
  const dsp::BandAnalysis analysis = Measured();
  EXPECT_THAT(KindsOf("tone=226.1Hz+-1Hz", analysis), ::testing::ElementsAre(kOtherTone));
  EXPECT_THAT(KindsOf("amplitude=8.9um+-1um", analysis), ::testing::ElementsAre(kOtherAmplitude));
  EXPECT_THAT(KindsOf("rms=6um+-0.9um", analysis), ::testing::ElementsAre(kOtherRms));
  EXPECT_THAT(KindsOf("change<2.9%", analysis), ::testing::ElementsAre(kChanges));
  EXPECT_THAT(KindsOf("source=device", analysis, {DataSource::kSimulated}),
              ::testing::ElementsAre(kOtherSource));
  EXPECT_THAT(KindsOf("distance=28mm+-1mm", analysis), ::testing::ElementsAre(kOtherDistance));
  EXPECT_THAT(KindsOf("bad<1.9%", analysis), ::testing::ElementsAre(kBadSamples));
  EXPECT_THAT(KindsOf("steady>2.6s", analysis), ::testing::ElementsAre(kShort));
  EXPECT_THAT(KindsOf("tremor<19um", analysis), ::testing::ElementsAre(kTremor));
  EXPECT_THAT(KindsOf("averaging=1", analysis), ::testing::ElementsAre(kOtherAveraging));
}

// 7 um that repeats of 8 um let expect
TEST(Expectation, OfRepeatsIsHeldAgainstThoseThatThereAre) {
  const auto expected = ParseExpectation("repeats<12%");
  const auto found = DeviationsFrom(*expected, Measured(), {}, 8e-6);
  ASSERT_EQ(found.list().size(), 1U);
  EXPECT_EQ(
      document::WordsOf(found.list()[0]),
      "the RMS differs by -12.5 % from the median of the earlier repeats, 8 um; less than 12 % "
      "is expected");
  EXPECT_TRUE(DeviationsFrom(*expected, Measured(), {}, 7.5e-6).list().empty());
  EXPECT_TRUE(DeviationsFrom(*expected, Measured(), {}).list().empty()) << "too few repeats";
}

// an RMS in um that was read as mm, a channel that counts the other way
TEST(Expectation, AFactorBeyondThreeAndTheOtherSignAreOfTheChannel) {
  dsp::BandAnalysis analysis = Measured();
  analysis.numbers->rms.rms_m = 7e-3;
  EXPECT_THAT(KindsOf("rms=7um+-1um", analysis), ::testing::ElementsAre(kOtherRms, kOtherScale));
  analysis.numbers->tone->amplitude_m = 3.4e-6;
  EXPECT_THAT(KindsOf("amplitude=10um+-1um", analysis), ::testing::ElementsAre(kOtherAmplitude));
  analysis.numbers->tone->amplitude_m = 3.3e-6;
  EXPECT_THAT(KindsOf("amplitude=10um+-1um", analysis),
              ::testing::ElementsAre(kOtherAmplitude, kOtherScale));
  analysis.record.offset_m = -0.03;
  EXPECT_THAT(KindsOf("distance=30mm+-1mm", analysis),
              ::testing::ElementsAre(kOtherDistance, kOtherSign));
}

TEST(Expectation, OfWhatIsNotDeterminedIsNotMet) {
  dsp::BandAnalysis refused = Measured();
  refused.answered = false;
  EXPECT_THAT(
      KindsOf("tone=225Hz+-1Hz, amplitude=10um+-1um, rms=7um+-1um, change<5%, source=device",
              refused, {}),
      ::testing::ElementsAre(kNotDetermined, kNotDetermined, kNotDetermined, kNotDetermined,
                             kNotDetermined));
}

TEST(Expectation, ThatIsNoneIsRefused) {
  for (const char* text : {"",
                           "tone",
                           "tone=225Hz",
                           "tone=225mm+-1mm",
                           "change<5",
                           "change<0%",
                           "change=5%",
                           "rms<5um",
                           "bad<1",
                           "steady>2mm",
                           "steady<2s",
                           "tremor<20",
                           "averaging=0",
                           "distance=30mm",
                           "repeats=5%",
                           "steady>1s+-1s",
                           "source=interrupted",
                           "source=moon",
                           "pitch=225Hz+-1Hz",
                           "tone=225Hz+-1Hz,tone=226Hz+-1Hz",
                           "source=device,",
                           "source=device,source=device"}) {
    const auto expected = ParseExpectation(text);
    ASSERT_FALSE(expected) << text;
    EXPECT_EQ(expected.error().cause, Cause::kUsage);
    EXPECT_THAT(expected.error().Text(), ::testing::StartsWith("--expect: ")) << text;
  }
}

struct Case {
  ExpectationFinding kind;
  std::vector<FindingNumber> numbers;
  std::string name;
  std::string text;
};

TEST(Expectation, DeviationsSayTheirSentences) {
  const std::vector<Case> cases{
      {kOtherTone,
       {{"frequency_hz", 230.0}, {"expected_hz", 225.0}, {"tolerance_hz", 1.0}},
       "other-tone-than-expected",
       "the tone is at 230 Hz; 225 Hz +- 1 Hz is expected"},
      {kOtherAmplitude,
       {{"amplitude_m", 12e-6}, {"expected_m", 10e-6}, {"tolerance_m", 1e-6}},
       "other-amplitude-than-expected",
       "the amplitude of the tone is 12 um; 10 um +- 1 um is expected"},
      {kOtherRms,
       {{"rms_m", 12e-6}, {"expected_m", 10e-6}, {"tolerance_m", 1e-6}},
       "other-rms-than-expected",
       "the vibration is 12 um RMS; 10 um +- 1 um is expected"},
      {kChanges,
       {{"change", 0.061}, {"most", 0.05}},
       "larger-change-than-expected",
       "the amplitude changes by 6.1 % over the window; less than 5 % is expected"},
      {kOtherDistance,
       {{"distance_m", 0.034}, {"expected_m", 0.03}, {"tolerance_m", 0.002}},
       "other-distance-than-expected",
       "the distance is 34 mm; 30 mm +- 2 mm is expected"},
      {kOtherScale,
       {{"quantity", std::string("the RMS")}, {"factor", 1000.0}},
       "other-scale-than-expected",
       "the RMS is 1000 times what is expected: check the unit, the scale and the calibration of "
       "the channel"},
      {kOtherSign,
       {{"distance_m", -0.03}, {"expected_m", 0.03}},
       "other-sign-than-expected",
       "the distance is -30 mm and 30 mm is expected: check the polarity of the channel"},
      {kBadSamples,
       {{"share", 0.02}, {"most", 0.01}},
       "more-bad-samples-than-expected",
       "2 % of the samples are no measurements; less than 1 % is expected"},
      {kShort,
       {{"steady_s", 0.8}, {"least_s", 2.0}},
       "shorter-than-expected",
       "800 ms of steady vibration can be used; more than 2 s is expected"},
      {kTremor,
       {{"tremor_m", 60e-6}, {"most_m", 50e-6}},
       "larger-tremor-than-expected",
       "the tremor is 60 um RMS; less than 50 um is expected"},
      {kOtherAveraging,
       {{"averages", 16.0}, {"expected", 1.0}},
       "other-averaging-than-expected",
       "the sensor averages 16 samples; 1 is expected"},
      {kOtherThanRepeats,
       {{"deviation", 0.3}, {"most", 0.1}, {"repeats_m", 8e-6}},
       "other-than-earlier-repeats",
       "the RMS differs by 30 % from the median of the earlier repeats, 8 um; less than 10 % is "
       "expected"},
      {kOtherSource,
       {{"source", std::string("simulated")}, {"expected", std::string("device")}},
       "other-source-than-expected",
       "the data are simulated; device is expected"},
      {kNotDetermined,
       {{"quantity", std::string("the RMS")}},
       "expected-quantity-not-determined",
       "the RMS is not determined, although a value is expected"}};
  std::set<ExpectationFinding> kinds;
  for (const Case& one : cases) {
    kinds.insert(one.kind);
    EXPECT_EQ(SentenceOf(one.kind).kind, one.name);
    EXPECT_EQ(document::Fill(SentenceOf(one.kind).text, one.numbers), one.text);
  }
  EXPECT_EQ(kinds.size(), static_cast<std::size_t>(kNotDetermined) + 1);
}

}  // namespace
}  // namespace haptometer::tools
