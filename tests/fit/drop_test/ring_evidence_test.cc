// What is no ring-down, and what is one, by closed forms.
#include "fit/drop_test/ring_evidence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "fit/drop_test/disturbances.h"
#include "fit/drop_test/prepared_record.h"
#include "fit/drop_test/ring_start.h"
#include "tests/findings.h"
#include "tests/fit/bound.h"
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
  double lasting = 0;
  for (int k = 0; k < repetitions; ++k) {
    const auto record =
        Recorded([](double t) { return Ringing(t, 130, 12); }, 0.1, static_cast<unsigned>(k) + 1);
    const RingSamples samples = BlocksOf(record, 320, record.voltage_v.size(), 4);
    const RingFit fit = FitRing(samples, {12, std::pow(kTwoPi * 130, 2)}, {});
    const RingEvidence evidence = EvidenceOf(samples, fit, 0);
    square += std::pow(evidence.misfit_share / evidence.misfit_share_deviation, 2);
    lasting += std::pow(evidence.lasting_share / evidence.lasting_share_deviation, 2);
  }
  // a mean square of n draws scatters by sqrt(2/n); the fit's own five parameters take some of it
  EXPECT_ABS(square / repetitions, 1.0, 0.2 + 3 * std::sqrt(2.0 / repetitions), "3 deviations");
  EXPECT_ABS(lasting / repetitions, 1.0, 0.2 + 3 * std::sqrt(2.0 / repetitions), "3 deviations");
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

// a fit of 12 samples a millisecond apart, with some residuals and two columns of its own
RingFit ByHand(const std::vector<double>& residuals) {
  RingFit fit;
  fit.poles = {.decay_per_s = 40, .stiffness_per_s2 = 1e5};
  fit.even_v = 0.8;
  fit.odd_v_per_s = 90;
  fit.jacobian = {.rows = residuals.size(), .columns = 2, .values = {}, .residuals = residuals};
  for (std::size_t n = 0; n < residuals.size(); ++n) {
    const bool is_even = n % 2 == 0;
    fit.jacobian.values.push_back(is_even ? 2 : 0);
    fit.jacobian.values.push_back(is_even ? 0 : 3);
  }
  return fit;
}

RingSamples TimesByHand(std::size_t count) {
  RingSamples samples;
  samples.step_s = 1e-3;
  for (std::size_t n = 0; n < count; ++n) {
    samples.times_s.push_back(0.1 + 1e-3 * static_cast<double>(n));
    samples.values_v.push_back(0);
  }
  return samples;
}

TEST(RingEvidence, IsTheClosedFormOfFewResiduals) {
  const std::vector<double> r{0.05,  -0.02, 0.03, 0.01,  -0.04, 0.06,
                              -0.01, 0.02,  0.02, -0.03, 0.04,  0.05};
  const RingFit fit = ByHand(r);
  double squares = 0, misfit = 0, ringing = 0, weights = 0, weight_squares = 0;
  double thirds = 0, third_weights = 0, even_thirds = 0;
  const auto weight = [](std::size_t n) { return std::exp(-80 * 1e-3 * static_cast<double>(n)); };
  const double amplitude = std::hypot(0.8, 90 / std::sqrt(1e5 - 1600));
  for (std::size_t n = 0; n < r.size(); ++n) {
    squares += r[n] * r[n];
    misfit += weight(n) * r[n] * r[n];
    weights += weight(n);
    weight_squares += weight(n) * weight(n);
    ringing += weight(n) * weight(n) * amplitude * amplitude / 2;
    if (n < 3) continue;
    const double third = std::pow(r[n] - 3 * r[n - 1] + 3 * r[n - 2] - r[n - 3], 2) / 20;
    thirds += third * (weight(n - 1) + weight(n - 2)) / 2;
    third_weights += (weight(n - 1) + weight(n - 2)) / 2;
    even_thirds += third / 9;
  }
  // n times the variance of mean squares of white residuals, 2, and of their third differences,
  // which follow each other by -15/20, 6/20 and -1/20, less twice their covariance of 2
  const double variance = 2 + 2 * (1 + 2 * (225 + 36 + 1) / 400.0) - 4;
  const auto expect = [&](double floor_v, double noise, double even_noise) {
    const RingEvidence found = EvidenceOf(TimesByHand(r.size()), fit, floor_v);
    EXPECT_REL(found.misfit_share, (misfit - noise * weights * 10 / 12) / ringing, 1e-12,
               "rounding");
    EXPECT_REL(found.misfit_share_deviation, noise * std::sqrt(variance * weight_squares) / ringing,
               1e-12, "rounding");
    const double first = amplitude * amplitude / 2;
    EXPECT_REL(found.lasting_share, (squares / 12 - even_noise) / first, 1e-12, "rounding");
    EXPECT_REL(found.lasting_share_deviation, even_noise * std::sqrt(variance / 12) / first, 1e-12,
               "rounding");
  };
  expect(0, thirds / third_weights, even_thirds);
  expect(0.5, 0.25, 0.25);  // a floor above the noise
  const RingEvidence found = EvidenceOf(TimesByHand(r.size()), fit, 0);
  EXPECT_REL(found.decays, 40 * 11e-3, 1e-12, "d T");
  EXPECT_REL(found.damping_ratio, 40 / std::sqrt(1e5), 1e-14, "of critical");
  // ln d's column is 2 long in six rows; 10 degrees of freedom
  EXPECT_REL(found.decays_deviation, 0.44 * std::sqrt(squares / 10 / 24), 1e-12, "closed form");
}

// a clean ring-down of 130 Hz, and what a record must have to be one
struct Judged {
  RingSamples samples;
  RingFit fit;
  RingEvidence evidence{.decays = 3, .damping_ratio = 0.015};
};

Judged Clean() {
  const auto record = Recorded([](double t) { return Ringing(t, 130, 12); }, 1e-4);
  Judged judged{.samples = BlocksOf(record, 320, record.voltage_v.size(), 1), .fit = {}};
  judged.fit = FitRing(judged.samples, {12, std::pow(kTwoPi * 130, 2)}, {});
  return judged;
}

TEST(NoRingDown, BeginsWhereItsLimitsAre) {
  const Judged clean = Clean();
  const auto reason = [&](const RingEvidence& evidence, bool is_stated = false) {
    return NoRingDown(evidence, clean.samples, clean.fit, is_stated);
  };
  EXPECT_EQ(reason(clean.evidence), "");
  auto damped = clean.evidence;
  damped.damping_ratio = 0.698;
  EXPECT_EQ(reason(damped), "");
  damped.damping_ratio = 0.702;
  EXPECT_THAT(reason(damped), HasSubstr("does not oscillate"));
  EXPECT_EQ(reason(damped, true), "");
  auto cut = clean.evidence;
  cut.cuts = 2;
  EXPECT_EQ(reason(cut), "");
  cut.cuts = 3;
  EXPECT_THAT(reason(cut), HasSubstr("begins to ring 4 times and more"));
  auto steady = clean.evidence;
  steady.decays = 0.08;
  steady.decays_deviation = 0.01005;
  EXPECT_EQ(reason(steady), "");
  steady.decays_deviation = 0.00995;
  EXPECT_THAT(reason(steady), HasSubstr("does not decay: a driven oscillation of 130 Hz"));
  steady.begins = true;
  EXPECT_EQ(reason(steady), "");
}

TEST(NoRingDown, AMisfitCountsBeyondItsShareAndFiveDeviations) {
  const Judged clean = Clean();
  const auto reason = [&](double share, double deviation) {
    auto evidence = clean.evidence;
    evidence.misfit_share = share;
    evidence.misfit_share_deviation = deviation;
    return NoRingDown(evidence, clean.samples, clean.fit, false);
  };
  EXPECT_EQ(reason(0.01495, 1e-9), "");
  EXPECT_THAT(reason(0.01505, 1e-9), HasSubstr("1.5 % of the power at 130 Hz is not explained"));
  EXPECT_THAT(reason(4, 1e-9), HasSubstr("80 % of the power at 130 Hz is not explained"));
  EXPECT_NE(reason(0.01505, 0), "") << "without noise any misfit is certain";
  // deviations of ln(1 + misfit over noise), whose own is sqrt(2.62 sum g^2)/sum g
  double sum = 0;
  double squares = 0;
  for (const double time_s : clean.samples.times_s) {
    const double weight =
        std::exp(-2 * clean.fit.poles.decay_per_s * (time_s - clean.samples.times_s.front()));
    sum += weight;
    squares += weight * weight;
  }
  const double own = std::sqrt(2.62 * squares) / sum;
  const auto at = [&](double deviations) {
    return reason(0.1, 0.1 * own / std::expm1(deviations * own));
  };
  EXPECT_EQ(at(4.98), "");
  EXPECT_NE(at(5.02), "");
}

TEST(NoRingDown, WhatLastsCountsBeyondItsShareAndFiveDeviations) {
  const Judged clean = Clean();
  const auto reason = [&](double share, double deviation) {
    auto evidence = clean.evidence;
    evidence.lasting_share = share;
    evidence.lasting_share_deviation = deviation;
    return NoRingDown(evidence, clean.samples, clean.fit, false);
  };
  EXPECT_EQ(reason(0.00995, 1e-9), "");
  EXPECT_THAT(reason(0.01005, 1e-9), HasSubstr("1 % of its first power stays"));
  EXPECT_EQ(reason(0.05, 0.05 / 4.98), "");
  EXPECT_NE(reason(0.05, 0.05 / 5.02), "");
}

TEST(NoRingDown, AFrequencyThatChangesIsNamedFromATwentiethOn) {
  // of a chirp; halved 12 times
  double silent = 0;
  double said = 300;
  std::string text;
  for (int halving = 0; halving < 12; ++halving) {
    const double rate = (silent + said) / 2;
    const auto record = Recorded(
        [rate](double t) {
          return t < 0 ? 0 : std::exp(-12 * t) * std::cos(kTwoPi * (130 * t + rate * t * t));
        },
        1e-3);
    Judged judged = Clean();
    judged.samples = BlocksOf(record, 320, record.voltage_v.size(), 1);
    const auto reason = NoRingDown(judged.evidence, judged.samples, judged.fit, false);
    (reason.empty() ? silent : said) = rate;
    if (!reason.empty()) text = reason;
  }
  double from_hz = 0;
  double to_hz = 0;
  ASSERT_EQ(
      std::sscanf(text.substr(text.find("from")).c_str(), "from %lf to %lf Hz", &from_hz, &to_hz),
      2)
      << text;
  EXPECT_REL(std::log(to_hz / from_hz), 0.05, 0.02, "four digits of each frequency");
}

// how far the frequencies of the first 140 samples and the next 140 differ, in deviations: each of
// a fit, with the Cramer-Rao bound for the variance that it leaves
double ChangeInDeviations(const RingSamples& samples) {
  std::array<double, 2> logarithm{};
  std::array<double, 2> deviation{};
  for (std::size_t part = 0; part < 2; ++part) {
    RingSamples some = samples;
    const auto first = static_cast<std::ptrdiff_t>(part * 140);
    some.times_s.assign(samples.times_s.begin() + first, samples.times_s.begin() + first + 140);
    some.values_v.assign(samples.values_v.begin() + first, samples.values_v.begin() + first + 140);
    const RingFit fit = FitRing(some, {25, std::pow(kTwoPi * 130, 2)}, {});
    // ln d, ln w, both amplitudes, offset
    const double w = std::sqrt(fit.poles.stiffness_per_s2 - std::pow(fit.poles.decay_per_s, 2));
    const auto model = [&](const std::vector<double>& p) {
      std::vector<double> values;
      for (const double time_s : some.times_s) {
        const double t = time_s - some.times_s.front();
        const double angle = std::exp(p[1]) * t;
        values.push_back(std::exp(-std::exp(p[0]) * t) *
                             (p[2] * std::cos(angle) + p[3] * std::sin(angle)) +
                         p[4]);
      }
      return values;
    };
    const auto bounds = tests::CramerRaoDeviations(model,
                                                   {std::log(fit.poles.decay_per_s), std::log(w),
                                                    fit.even_v, fit.odd_v_per_s / w, fit.offset_v},
                                                   {1e-3, 1e-4, 1e-3, 1e-3, 1e-3});
    logarithm[part] = 0.5 * std::log(fit.poles.stiffness_per_s2);
    deviation[part] = bounds[1] * std::sqrt(fit.Squares() / (140 - 5));
  }
  return std::abs(logarithm[1] - logarithm[0]) / std::hypot(deviation[0], deviation[1]);
}

TEST(NoRingDown, AFrequencyThatChangesIsNamedFromSixDeviationsOn) {
  // by 8 % from the first 14 ms, 0.35 of a decay time of 40 ms, to the next; in ever more noise
  double named = 0;
  double silent = 0.2;
  std::array<double, 2> deviations{};
  for (int halving = 0; halving < 14; ++halving) {
    const double noise = (named + silent) / 2;
    const auto record = Recorded(
        [](double t) {
          return t < 0 ? 0 : std::exp(-25 * t) * std::cos(kTwoPi * (125 * t + 370 * t * t));
        },
        noise);
    Judged judged = Clean();
    judged.fit.poles = {25, std::pow(kTwoPi * 130, 2)};
    judged.samples = BlocksOf(record, 310, record.voltage_v.size(), 1);
    const bool has = !NoRingDown(judged.evidence, judged.samples, judged.fit, false).empty();
    (has ? named : silent) = noise;
    deviations[has ? 0 : 1] = ChangeInDeviations(judged.samples);
  }
  EXPECT_REL(deviations[0], 6.0, 3e-3, "ln w for ln sqrt(q): d^2/q = 1e-3; halved 14 times");
  EXPECT_REL(deviations[1], 6.0, 3e-3, "ln w for ln sqrt(q): d^2/q = 1e-3; halved 14 times");
}

TEST(NoRingDown, AHarmonicThatIsLeftIsNamedByItsNumber) {
  const auto reason = [](double ratio) {
    const auto record = Recorded(
        [ratio](double t) { return Ringing(t, 130, 12) + 0.3 * Ringing(t, 130 * ratio, 12); });
    const RingSamples samples = BlocksOf(record, 320, record.voltage_v.size(), 1);
    const RingFit fit = FitRing(samples, {12, std::pow(kTwoPi * 130, 2)}, {});
    return NoRingDown(EvidenceOf(samples, fit, 0), samples, fit, false);
  };
  EXPECT_THAT(reason(3), HasSubstr("what is left has 3 times its frequency (no sinusoid)"));
  EXPECT_THAT(reason(2), HasSubstr("what is left has 2 times its frequency (no sinusoid)"));
  // within 3 %; lines of the residual's spectrum are 0.5 % of the frequency apart
  EXPECT_THAT(reason(2.98), HasSubstr("3 times its frequency"));
  EXPECT_THAT(reason(2.96), HasSubstr("strongest at 38"));
  EXPECT_THAT(reason(3.04), HasSubstr("strongest at 39"));
}

TEST(RingEvidence, AReleaseBehindASlowPullIsReportedWithItsTime) {
  ImpulseRecord record;
  record.name = "pull.csv";
  record.step_s = 1e-3;
  record.start_s = 5;
  std::mt19937_64 engine(3);
  std::normal_distribution<double> white(0, 1e-3);
  for (int n = 0; n < 4000; ++n) {
    const double t = n * record.step_s;
    const double pull = -0.7 * std::min(t / 0.8, 1.0) + 0.012 * std::sin(kTwoPi * 5 * t);
    record.voltage_v.push_back((t < 0.9 ? pull : 0.4 * Ringing(t - 0.9, 31, 1.4)) + white(engine));
  }
  const auto prepared = PrepareRecord(record);
  ASSERT_TRUE(prepared) << prepared.error().Text();
  const Findings& found = prepared->part.found;
  const double at_s = tests::NumberOf(found, FindingKind::kReleaseBehindSlow, "at_s");
  const double from_s = tests::NumberOf(found, FindingKind::kReleaseBehindSlow, "from_s");
  EXPECT_ABS(at_s, 5.9, 0.5 / 31, "half a period");
  EXPECT_EQ(from_s, prepared->record.start_s);
  EXPECT_GT(from_s, at_s - 1e-3);
  EXPECT_LT(from_s, 5.9 + 3.5 / 31) << "three periods behind the onset at most";
}

// a ring-down of 127 Hz with a hum of 60 Hz: `share` of the first amplitude from the impact on,
// and `share_before` before it
ImpulseRecord WithHum(double share, double share_before) {
  return Recorded(
      [=](double t) {
        return Ringing(t, 127, 4) + (t < 0 ? share_before : share) * std::cos(kTwoPi * 60 * t);
      },
      1e-5);
}

bool HumIsMissing(const ImpulseRecord& record) {
  const auto start = FindRingStart(record);
  EXPECT_TRUE(start);
  if (!start) return false;
  const std::string reason = FindDisturbances(record, *start).no_ring_down;
  EXPECT_TRUE(reason.empty() || reason.contains("looks like hum of 60 Hz")) << reason;
  return !reason.empty();
}

TEST(RingEvidence, AHumMayBeMissingBeforeUpToAFifthOfTheRinging) {
  // the part begins an eighth of a period behind the impact, 1 ms
  const double ringing = std::exp(-4 * 1e-3);
  EXPECT_FALSE(HumIsMissing(WithHum(0.99 * 0.2 * ringing, 0)));
  EXPECT_TRUE(HumIsMissing(WithHum(1.01 * 0.2 * ringing, 0)));
}

TEST(RingEvidence, AHumIsMissingWhereItLeavesAQuarterOfItsPowerBefore) {
  // a hum of 0.3 that was weaker before: the mean square about the mean of what is too much there
  const auto start = FindRingStart(WithHum(0.3, 0.15));
  ASSERT_TRUE(start);
  double sum = 0;
  double squares = 0;
  const auto count = static_cast<double>(start->quiet_samples);
  for (std::size_t n = 0; n < start->quiet_samples; ++n) {
    const double hum = std::cos(kTwoPi * 60 * (-0.03 + static_cast<double>(n) * kStep));
    sum += hum / count;
    squares += hum * hum / count;
  }
  const double left = std::sqrt(0.25 * 0.5 / (squares - sum * sum));
  EXPECT_TRUE(HumIsMissing(WithHum(0.3, 0.3 * (1 - 1.01 * left))));
  EXPECT_FALSE(HumIsMissing(WithHum(0.3, 0.3 * (1 - 0.99 * left))));
}

}  // namespace
}  // namespace haptometer::fit
