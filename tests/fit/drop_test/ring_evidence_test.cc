// What is no ring-down, and what is one, by closed forms.
#include "fit/drop_test/ring_evidence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>

#include "fit/drop_test/disturbances.h"
#include "fit/drop_test/prepared_record.h"
#include "fit/drop_test/ring_start.h"
#include "tests/repetitions.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

constexpr double kStep = 1e-4;
constexpr double kTwoPi = 2 * std::numbers::pi;

double Ringing(double t, double hertz, double decay_per_s) {
  return t < 0 ? 0 : std::exp(-decay_per_s * t) * std::cos(kTwoPi * hertz * t);
}

// `signal` of time over 0.4 s from 30 ms before 0 on, in white noise
ImpulseRecord Recorded(const std::function<double(double)>& signal, double noise = 2e-3,
                       unsigned seed = 11) {
  ImpulseRecord record;
  record.name = "r.csv";
  record.step_s = kStep;
  record.start_s = -0.03;
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> white;
  for (int n = 0; n < 4300; ++n) {
    record.voltage_v.push_back(signal(record.start_s + n * kStep) + noise * white(engine));
  }
  return record;
}

// all of `record` behind its first samples
ImpulseRecord From(ImpulseRecord record, double time_s) {
  const auto first = std::lround((time_s - record.start_s) / record.step_s);
  record.voltage_v.erase(record.voltage_v.begin(), record.voltage_v.begin() + first);
  record.start_s = time_s;
  return record;
}

std::string Refusal(const ImpulseRecord& record) {
  const auto prepared = PrepareRecord(record);
  return prepared ? "" : prepared.error().Text();
}

TEST(RingEvidence, TheShareOfAnotherOscillationIsItsPower) {
  // a second oscillation of the same decay and b of the amplitude, far from the first in frequency:
  // its weighted power is b^2 of the ringing's
  for (const double b : {0.0, 0.03, 0.1}) {
    const auto record =
        Recorded([b](double t) { return Ringing(t, 130, 12) + b * Ringing(t, 303, 12); }, 1e-3);
    const RingSamples samples = BlocksOf(record, 320, record.voltage_v.size(), 1);
    const RingFit fit = FitRing(samples, {12, std::pow(kTwoPi * 130, 2)}, {});
    const RingEvidence evidence = EvidenceOf(samples, fit, 0);
    EXPECT_ABS(evidence.misfit_share, b * b, 0.05 * b * b + 4 * evidence.misfit_share_deviation,
               "what the fit takes of it, and four deviations of noise");
    EXPECT_ABS(evidence.decays, 12 * (samples.times_s.back() - samples.times_s.front()), 0.05,
               "noise and the second oscillation");
  }
}

TEST(RingEvidence, WhiteNoiseGivesNothingWithinItsDeviation) {
  const int repetitions = tests::kIsSanitized ? 10 : 100;
  double square = 0;
  for (int k = 0; k < repetitions; ++k) {
    const auto record =
        Recorded([](double t) { return Ringing(t, 130, 12); }, 0.1, static_cast<unsigned>(k) + 1);
    const RingSamples samples = BlocksOf(record, 320, record.voltage_v.size(), 4);
    const RingFit fit = FitRing(samples, {12, std::pow(kTwoPi * 130, 2)}, {});
    const RingEvidence evidence = EvidenceOf(samples, fit, 0);
    square += std::pow(evidence.misfit_share / evidence.misfit_share_deviation, 2);
  }
  // a mean square of n draws scatters by sqrt(2/n); the fit's own five parameters take some of it
  EXPECT_ABS(square / repetitions, 1.0, 0.2 + 3 * std::sqrt(2.0 / repetitions), "3 deviations");
}

TEST(RingEvidence, WhatIsNoRingDownIsNamed) {
  const auto none = [](double t) { return t < 0 ? 0.0 : 1.0; };
  EXPECT_THAT(Refusal(Recorded([&](double t) { return none(t) * std::exp(-25 * t); })),
              AnyOf(HasSubstr("does not oscillate"), HasSubstr("no ring-down")));
  EXPECT_THAT(
      Refusal(Recorded([&](double t) { return none(t) * (1 + 60 * t) * std::exp(-60 * t); })),
      AnyOf(HasSubstr("does not oscillate"), HasSubstr("no ring-down")));
  // two modes, the second of 0.6 of the first's amplitude
  EXPECT_THAT(
      Refusal(Recorded([](double t) { return Ringing(t, 90, 9) + 0.6 * Ringing(t, 171, 11); })),
      HasSubstr("is not a single decaying oscillation"));
  // chirps from 80 Hz, by 400 and 1600 Hz/s
  for (const double half_rate : {200.0, 800.0}) {
    EXPECT_THAT(
        Refusal(Recorded([&](double t) {
          return none(t) * std::exp(-9 * t) * std::sin(kTwoPi * (80 * t + half_rate * t * t));
        })),
        AnyOf(HasSubstr("is not a single decaying oscillation"), HasSubstr("begins to ring")))
        << half_rate;
  }
  // a steady oscillation that the record begins within
  EXPECT_THAT(Refusal(From(Recorded([](double t) { return std::cos(kTwoPi * 61 * t); }), 0)),
              HasSubstr("does not decay"));
  // a square of 25 Hz through 3 ms
  EXPECT_NE(Refusal(From(Recorded([](double t) {
                           const double part = std::fmod(t, 0.02);
                           const double sign = std::fmod(t, 0.04) < 0.02 ? 1 : -1;
                           return sign * (1 - 2 * std::exp(-part / 0.003));
                         }),
                         0)),
            "");
}

TEST(RingEvidence, AnOscillationThatBeginsInTheRecordIsNoHum) {
  // a fiftieth of a decay time: as little decay as above, but something struck it
  const auto ringing = [](double t) { return Ringing(t, 61, 0.05); };
  EXPECT_EQ(Refusal(Recorded(ringing)), "");
  EXPECT_THAT(Refusal(From(Recorded(ringing), 0.01)), HasSubstr("does not decay"));
}

TEST(RingEvidence, WhatFollowsAnotherMotionIsNone) {
  // a chirp that ends in an oscillation of 127 Hz: fitted alone it had 127.18 +- 0.02 Hz
  const auto ringing = [](double t) { return 0.5 * Ringing(t, 127, 40); };
  EXPECT_THAT(Refusal(Recorded([&](double t) {
                return t < 0 ? std::sin(kTwoPi * (140 * t + 1500 * t * t)) : ringing(t);
              })),
              HasSubstr("another motion precedes"));
  // noise as large as that is no motion
  EXPECT_EQ(Refusal(Recorded(ringing, 0.1)), "");
}

TEST(RingEvidence, AHumThatIsNotThereBeforeTheMotionIsNone) {
  // a chirp from 82 to 47 Hz in 0.1 s: a ring-down of 70.6 +- 0.2 Hz beside a hum of 60 Hz, it
  // seemed
  ImpulseRecord record = Recorded([](double t) {
    const double since = t + 0.03;
    const double falling = std::min(since, 0.1044);
    const double turns =
        81.95 * (since - 0.4313 * (since * falling - falling * falling / 2) / 0.1044);
    return std::exp(-19.16 * since) * std::sin(kTwoPi * turns + 1.73);
  });
  record.voltage_v.resize(3950);
  EXPECT_THAT(Refusal(record), HasSubstr("looks like hum of 60 Hz does not precede"));
  // one that is there all along, at any phase; asked where nothing yet takes the hum away
  for (const double phase : {0.0, 1.0, 2.5, 4.0}) {
    const ImpulseRecord humming = Recorded(
        [phase](double t) { return Ringing(t, 127, 4) + 0.3 * std::cos(kTwoPi * 60 * t + phase); });
    const auto start = FindRingStart(humming);
    ASSERT_TRUE(start) << phase;
    EXPECT_EQ(FindDisturbances(humming, *start).no_ring_down, "") << phase;
  }
}

TEST(RingEvidence, WhatStaysWhenTheRingingIsGoneIsNoPartOfIt) {
  // from 5 decay times on, where the ringing's own power tells nothing of it
  const auto late = [](double t) { return t > 0.12 ? std::min(1.0, (t - 0.12) / 0.1) : 0; };
  const auto record = Recorded(
      [&](double t) { return Ringing(t, 127, 40) + 0.3 * late(t) * std::sin(kTwoPi * 171 * t); });
  const RingSamples samples = BlocksOf(record, 305, record.voltage_v.size(), 1);
  const RingFit fit = FitRing(samples, {40, std::pow(kTwoPi * 127, 2)}, {});
  const RingEvidence evidence = EvidenceOf(samples, fit, 0);
  EXPECT_LT(evidence.misfit_share, 1e-3);
  // 0.09 over 0.18 s, a third of it over the 0.1 s of its rise, of 0.4 s
  EXPECT_ABS(evidence.lasting_share, 0.09 * (0.18 + 0.1 / 3) / 0.4, 0.005, "what the fit takes");
  EXPECT_NE(NoRingDown(evidence, samples, fit, false), "");
}

TEST(RingEvidence, AStatedDropMayBeAperiodic) {
  auto record =
      Recorded([](double t) { return t < 0 ? 0 : (1 - 400 * t) * std::exp(-400 * t); }, 1e-4);
  EXPECT_NE(Refusal(record), "");
  record.drop_height_m = Quantity{0.01, 0};
  EXPECT_EQ(Refusal(record), "");
}

TEST(RingEvidence, TrueRingDownsAreOnes) {
  // Q from 3 to 800, noise to a tenth of the amplitude
  for (const double decay_per_s : {130.0, 40.0, 12.0, 3.0, 0.5}) {
    for (const double noise : {1e-5, 1e-3, 0.03, 0.1}) {
      EXPECT_EQ(Refusal(Recorded([=](double t) { return Ringing(t, 127, decay_per_s); }, noise)),
                "")
          << decay_per_s << ", noise " << noise;
    }
  }
}

TEST(RingEvidence, ASlowPullBeforeTheReleaseIsLeftOut) {
  // a ramp over half a second with a sway of 5 Hz, a creep back, then 31 Hz
  ImpulseRecord record;
  record.name = "pull.csv";
  record.step_s = 1e-3;
  std::mt19937_64 engine(3);
  std::normal_distribution<double> white(0, 1e-3);
  for (int n = 0; n < 4000; ++n) {
    const double t = n * record.step_s;
    const double pull = -0.7 * std::min(t / 0.8, 1.0) + 0.012 * std::sin(kTwoPi * 5 * t);
    const double v = t < 0.9 ? pull : 0.4 * Ringing(t - 0.9, 31, 1.4);
    record.voltage_v.push_back(v + white(engine));
  }
  const auto prepared = PrepareRecord(record);
  ASSERT_TRUE(prepared) << prepared.error().Text();
  const PolePair& poles = prepared->part.poles;
  EXPECT_REL(std::sqrt(poles.stiffness_per_s2) / kTwoPi, 31.0, 1e-3, "noise, and d/w of 1e-5");
  EXPECT_REL(poles.decay_per_s, 1.4, 0.01, "noise");
}

}  // namespace
}  // namespace haptometer::fit
