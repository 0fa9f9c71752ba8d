#include "dsp/spectrum/frequency_response.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <span>
#include <vector>

#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRateHz = 2000;
constexpr double kResonanceHz = 225;
constexpr double kQuality = 15;
constexpr double kGain = 2e-6;  // m/V at rest

std::complex<double> ClosedForm(double frequency_hz) {
  const double u = frequency_hz / kResonanceHz;
  return kGain / std::complex<double>(1 - u * u, u / kQuality);
}

struct Sweep {
  std::vector<double> drive_v;
  std::vector<double> displacement_m;
};

// 2 V from `from_hz` to `to_hz` in `duration_s`, on a mass and
// spring: Runge and Kutta's fourth order, 20 steps a sample, wrong by (w h)^4/120 = 1e-8
Sweep Swept(double from_hz, double to_hz, double duration_s) {
  constexpr int kSteps = 20;
  const double h = 1 / kRateHz / kSteps;
  const double w = 2 * kPi * kResonanceHz;
  const auto drive = [=](double t_s) {
    return 2 * std::sin(2 * kPi * (from_hz + 0.5 * (to_hz - from_hz) * t_s / duration_s) * t_s);
  };
  using State = std::array<double, 2>;
  const auto slope = [=](const State& s, double t_s) {
    return State{s[1], w * w * (kGain * drive(t_s) - s[0]) - w / kQuality * s[1]};
  };
  const auto ahead = [](const State& s, const State& k, double by) {
    return State{s[0] + by * k[0], s[1] + by * k[1]};
  };
  Sweep sweep;
  State s{};
  const auto samples = static_cast<int>(duration_s * kRateHz);
  for (int n = 0; n < samples; ++n) {
    sweep.drive_v.push_back(drive(n / kRateHz));
    sweep.displacement_m.push_back(s[0]);
    for (int step = 0; step < kSteps; ++step) {
      const double t_s = n / kRateHz + step * h;
      const State a = slope(s, t_s);
      const State b = slope(ahead(s, a, h / 2), t_s + h / 2);
      const State c = slope(ahead(s, b, h / 2), t_s + h / 2);
      const State d = slope(ahead(s, c, h), t_s + h);
      for (std::size_t i = 0; i < 2; ++i) s[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
    }
  }
  return sweep;
}

TEST(FrequencyResponse, OfASweptOscillatorIsTheClosedForm) {
  const Sweep sweep = Swept(60, 500, 16);
  // segments of 4 s: sixty times Q / f0
  const auto points =
      MeasureResponse(sweep.drive_v, sweep.displacement_m, {kRateHz, 8000}, 100, 450).value();
  ASSERT_EQ(points.size(), 1401U);
  double worst = 0;
  double least_coherence = 1;
  for (const ResponsePoint& point : points) {
    const std::complex<double> truth = ClosedForm(point.frequency_hz);
    worst = std::max(worst, std::abs(point.response / truth - 1.0));
    least_coherence = std::min(least_coherence, point.coherence);
  }
  EXPECT_ABS(worst, 0, 0.01, "a window of 60 Q / f0: measured");
  EXPECT_GT(least_coherence, 0.999);
  const Resonance found = FitResonance(std::span<const ResponsePoint>(points));
  ASSERT_TRUE(found.converged);
  EXPECT_REL(found.frequency_hz, kResonanceHz, 1e-4, "the window's width: measured");
  EXPECT_REL(found.quality_factor, kQuality, 3e-3, "the window's width: measured");
  EXPECT_REL(found.gain, kGain, 3e-3, "the window's width: measured");
}

TEST(FrequencyResponse, NoiseLowersCoherenceAndIsStated) {
  Sweep sweep = Swept(60, 500, 16);
  Noise noise(3);
  for (double& x : sweep.displacement_m) x += 2e-6 * noise();
  const auto points =
      MeasureResponse(sweep.drive_v, sweep.displacement_m, {kRateHz, 2000}, 100, 450).value();
  int held = 0;
  for (const ResponsePoint& point : points) {
    const std::complex<double> truth = ClosedForm(point.frequency_hz);
    const double off = std::abs(std::abs(point.response) / std::abs(truth) - 1);
    held += off <= 1.96 * point.relative_uncertainty + 0.01 ? 1 : 0;
  }
  EXPECT_GE(held, static_cast<int>(0.9 * static_cast<double>(points.size())))
      << "95 % each, of neighbours that share a window's bins";
  const Resonance found = FitResonance(std::span<const ResponsePoint>(points));
  ASSERT_TRUE(found.converged);
  EXPECT_ABS(found.frequency_hz, kResonanceHz, 4 * found.frequency_uncertainty_hz, "as stated");
  EXPECT_ABS(found.quality_factor, kQuality, 4 * found.quality_factor_uncertainty + 0.15,
             "as stated, and 1 % of the window's width");
}

// Each bin's own ratio, coherence c and u = sqrt((1 - c) / (c degrees of freedom)), of two segments
// and of more.
TEST(FrequencyResponse, IsThatOfEachBin) {
  Noise noise(4);
  for (const std::size_t size : {1500UZ, 5000UZ}) {
    std::vector<double> drive(size);
    std::vector<double> moved(size);
    for (std::size_t k = 0; k < size; ++k) {
      drive[k] = noise();
      moved[k] = 2e-6 * (drive[k] + noise());
    }
    const WelchOptions options{kRateHz, 1000};
    const auto measured = MeasureResponse(drive, moved, options, 0, 1000);
    ASSERT_TRUE(measured) << size;
    const auto& points = *measured;
    const CrossSpectrum cross = WelchCrossSpectrum(drive, moved, options).value();
    const std::vector<double> coherence = Coherence(cross);
    ASSERT_EQ(points.size(), cross.cross.size());
    ASSERT_EQ(points.size(), 501U);
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double c = std::min(1.0, coherence[k]);
      EXPECT_EQ(points[k].frequency_hz, 2.0 * static_cast<double>(k));
      EXPECT_EQ(points[k].response, cross.cross[k] / cross.from_density[k]);
      EXPECT_EQ(points[k].coherence, c);
      EXPECT_REL(std::pow(points[k].relative_uncertainty, 2) * cross.grid.degrees_of_freedom,
                 1 / c - 1, 1e-9, "rounding of 1 - c");
    }
  }
}

TEST(FrequencyResponse, WithoutADriveChannelTheSweepIsItsOwn) {
  // 440 Hz in 40 s; late by up to 11 Q / (pi f0) = 0.23 Hz
  const Sweep sweep = Swept(60, 500, 40);
  const auto points = SweptAmplitude(sweep.displacement_m, kRateHz, 80, 480);
  ASSERT_GT(points.size(), 500U);
  double worst = 0;
  double late_hz = 0;
  for (const SweptPoint& point : points) {
    late_hz = std::max(late_hz, std::abs(point.frequency_hz - (60 + 11 * point.time_s)));
    const double truth = 2 * std::abs(ClosedForm(point.frequency_hz));
    worst = std::max(worst, std::abs(point.amplitude / truth - 1));
  }
  EXPECT_ABS(late_hz, 0, 0.3, "Q / (pi f0) seconds of the sweep");
  EXPECT_ABS(worst, 0, 0.02, "on the flank, 0.12 Hz late, in 7.5: measured");
  const Resonance found = FitResonance(std::span<const SweptPoint>(points));
  ASSERT_TRUE(found.converged);
  EXPECT_ABS(found.frequency_hz, kResonanceHz, 0.23, "the stated lateness");
  EXPECT_REL(found.quality_factor, kQuality, 1e-3, "measured");
  EXPECT_REL(found.gain, 2 * kGain, 1e-3, "measured");
}

// exact points about the resonance, with noise
std::vector<ResponsePoint> Points(double relative_noise, Noise& noise) {
  std::vector<ResponsePoint> points;
  points.reserve(60);
  for (int k = 0; k < 60; ++k) {
    const double frequency_hz = 180.0 + 1.5 * k;
    const std::complex<double> truth = std::polar(1.0, 0.4) * ClosedForm(frequency_hz);
    const std::complex<double> error(relative_noise * noise(), relative_noise * noise());
    points.push_back({frequency_hz, truth * (1.0 + error), 1, relative_noise});
  }
  return points;
}

TEST(Resonance, ExactPointsGiveItBack) {
  Noise noise(1);
  const Resonance found = FitResonance(std::span<const ResponsePoint>(Points(0, noise)));
  ASSERT_TRUE(found.converged);
  EXPECT_REL(found.frequency_hz, kResonanceHz, 1e-14, "rounding");
  EXPECT_REL(found.quality_factor, kQuality, 1e-12, "rounding");
  EXPECT_REL(found.gain, kGain, 1e-12, "rounding");
  std::vector<SweptPoint> amplitudes;
  for (const ResponsePoint& point : Points(0, noise)) {
    amplitudes.push_back({0, point.frequency_hz, std::abs(point.response)});
  }
  const Resonance magnitude = FitResonance(std::span<const SweptPoint>(amplitudes));
  ASSERT_TRUE(magnitude.converged);
  EXPECT_REL(magnitude.frequency_hz, kResonanceHz, 1e-14, "rounding");
  EXPECT_REL(magnitude.quality_factor, kQuality, 1e-12, "rounding");
}

TEST(Resonance, IntervalsHoldTheTruth) {
  constexpr int kRepetitions = 2000;
  constexpr double kT116 = 1.9806;  // Student's t, 97.5 %, 2 x 60 - 4 degrees of freedom
  Noise noise(23);
  int frequency = 0;
  int quality = 0;
  for (int r = 0; r < kRepetitions; ++r) {
    const Resonance found = FitResonance(std::span<const ResponsePoint>(Points(0.02, noise)));
    ASSERT_TRUE(found.converged);
    frequency +=
        std::abs(found.frequency_hz - kResonanceHz) <= kT116 * found.frequency_uncertainty_hz ? 1
                                                                                              : 0;
    quality += std::abs(found.quality_factor - kQuality) <= kT116 * found.quality_factor_uncertainty
                   ? 1
                   : 0;
  }
  EXPECT_NEAR(frequency, 1900, 40) << "95 % +- 2 % of 2000";
  EXPECT_NEAR(quality, 1900, 40);
}

TEST(Resonance, IsNotMadeUp) {
  EXPECT_FALSE(FitResonance(std::span<const ResponsePoint>()).converged);
  Noise noise(2);
  const auto points = Points(0, noise);
  EXPECT_FALSE(FitResonance(std::span(points).first(2)).converged) << "four numbers for four";
  EXPECT_FALSE(FitResonance(std::span(points).first(15)).converged)
      << "180 to 201 Hz: the resonance lies outside";
  EXPECT_FALSE(
      MeasureResponse(std::vector<double>(100), std::vector<double>(100), {kRateHz, 100}, 100, 450))
      << "one segment";
  EXPECT_TRUE(SweptAmplitude(std::vector<double>(100), kRateHz, 80, 480).empty());
}

// of one point, chance gives a coherence above 1 - 0.05^(1 / (m - 1)) in 5 %, m = 0.94 segments
TEST(KeepSignificant, OfOnePointIsTheLevelOfFivePercent) {
  constexpr double kSegments = 10;
  const double level = 1 - std::pow(0.05, 1 / (0.94 * kSegments - 1));
  for (const double beside : {-1e-6, 1e-6}) {
    std::vector<ResponsePoint> points(1);
    points[0].coherence = level + beside;
    KeepSignificant(points, kSegments);
    EXPECT_EQ(points.empty(), beside < 0);
  }
}

// amplitudes at frequencies of which none is the resonance's, each off by `noise` times a normal
// number
std::vector<SweptPoint> Amplitudes(double noise_m, Noise& noise) {
  std::vector<SweptPoint> points;
  for (int k = 0; k < 60; ++k) {
    const double frequency_hz = 180.7 + 1.5 * k;
    const double amplitude = 2 * std::abs(ClosedForm(frequency_hz)) + noise_m * noise();
    points.push_back({0, frequency_hz, amplitude});
  }
  return points;
}

// Neighbours on both sides make a point's weight: points in the other order have the same fit.
TEST(Resonance, OfPointsInTheOtherOrderIsTheSame) {
  Noise noise(6);
  std::vector<ResponsePoint> points = Points(0.02, noise);
  for (ResponsePoint& point : points) point.relative_uncertainty = 0.02 * std::exp(noise());
  const Resonance one = FitResonance(std::span<const ResponsePoint>(points));
  std::ranges::reverse(points);
  const Resonance other = FitResonance(std::span<const ResponsePoint>(points));
  ASSERT_TRUE(one.converged && other.converged);
  constexpr double kRest = 1e-7;  // where the steps end
  EXPECT_REL(other.frequency_hz, one.frequency_hz, kRest, "two iterations");
  EXPECT_REL(other.frequency_uncertainty_hz, one.frequency_uncertainty_hz, kRest, "the same");
  EXPECT_REL(other.quality_factor, one.quality_factor, kRest, "the same");
  EXPECT_REL(other.gain, one.gain, kRest, "the same");
}

// squared length of the last of `columns` beside all of the others: 1 / its element of (J'J)^-1
double SquareBesideOthers(std::vector<std::vector<double>> columns) {
  const auto product = [](const std::vector<double>& a, const std::vector<double>& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  };
  for (std::size_t k = 0; k + 1 < columns.size(); ++k) {
    for (std::size_t later = k + 1; later < columns.size(); ++later) {
      const double share = product(columns[later], columns[k]) / product(columns[k], columns[k]);
      for (std::size_t n = 0; n < columns[k].size(); ++n) {
        columns[later][n] -= share * columns[k][n];
      }
    }
  }
  return product(columns.back(), columns.back());
}

// (J'J)^-1 times the residual's variance, J by differences at what was found; of points that weigh
// the same the phase of the gain turns the rows alone.
TEST(Resonance, UncertaintiesAreThoseOfTheLinearisedModel) {
  Noise noise(8);
  std::vector<ResponsePoint> points = Points(0.02, noise);
  double power = 0;
  for (ResponsePoint& point : points) {
    point.relative_uncertainty = 1e-7 / std::abs(point.response);
    power += std::norm(point.response);
  }
  const Resonance found = FitResonance(std::span<const ResponsePoint>(points));
  ASSERT_TRUE(found.converged);
  const auto curve = [&](double at_hz, double f0_hz, double ln_q) {
    const double u = at_hz / f0_hz;
    return found.gain / std::complex<double>(1 - u * u, u / std::exp(ln_q));
  };
  const double f0_hz = found.frequency_hz;
  const double ln_q = std::log(found.quality_factor);
  constexpr double kStep = 1e-4;
  std::vector<double> real;
  std::vector<double> imaginary;
  std::vector<double> frequency;
  std::vector<double> quality;
  for (const ResponsePoint& point : points) {
    const double at_hz = point.frequency_hz;
    const std::complex<double> value = curve(at_hz, f0_hz, ln_q);
    const std::complex<double> by_f0 =
        (curve(at_hz, f0_hz + kStep, ln_q) - curve(at_hz, f0_hz - kStep, ln_q)) / (2 * kStep);
    const std::complex<double> by_q =
        (curve(at_hz, f0_hz, ln_q + kStep) - curve(at_hz, f0_hz, ln_q - kStep)) / (2 * kStep);
    real.insert(real.end(), {value.real(), value.imag()});
    imaginary.insert(imaginary.end(), {-value.imag(), value.real()});
    frequency.insert(frequency.end(), {by_f0.real(), by_f0.imag()});
    quality.insert(quality.end(), {by_q.real(), by_q.imag()});
  }
  const double deviation =
      found.residual_share * std::sqrt(power / static_cast<double>(2 * points.size() - 4));
  EXPECT_REL(found.frequency_uncertainty_hz,
             deviation / std::sqrt(SquareBesideOthers({real, imaginary, quality, frequency})), 1e-6,
             "differences");
  EXPECT_REL(found.quality_factor_uncertainty,
             found.quality_factor * deviation /
                 std::sqrt(SquareBesideOthers({real, imaginary, frequency, quality})),
             1e-6, "differences");
  EXPECT_EQ(found.degrees_of_freedom, 116);
}

TEST(Resonance, OfExactAmplitudesBesideItIsFound) {
  Noise noise(1);
  const Resonance found = FitResonance(std::span<const SweptPoint>(Amplitudes(0, noise)));
  ASSERT_TRUE(found.converged);
  EXPECT_REL(found.frequency_hz, kResonanceHz, 1e-12, "rounding");
  EXPECT_REL(found.quality_factor, kQuality, 1e-11, "rounding");
  EXPECT_REL(found.gain, 2 * kGain, 1e-11, "rounding");
  EXPECT_EQ(found.degrees_of_freedom, 57);
}

TEST(Resonance, IntervalsOfAmplitudesHoldTheTruth) {
  constexpr int kRepetitions = 400;
  constexpr double kT57 = 2.0024655;  // Student's t, 97.5 %, 60 - 3 degrees of freedom
  Noise noise(29);
  int frequency = 0;
  int quality = 0;
  for (int r = 0; r < kRepetitions; ++r) {
    const Resonance found = FitResonance(std::span<const SweptPoint>(Amplitudes(6e-7, noise)));
    ASSERT_TRUE(found.converged);
    const double off_hz = std::abs(found.frequency_hz - kResonanceHz);
    frequency += off_hz <= kT57 * found.frequency_uncertainty_hz ? 1 : 0;
    const double off = std::abs(found.quality_factor - kQuality);
    quality += off <= kT57 * found.quality_factor_uncertainty ? 1 : 0;
  }
  EXPECT_NEAR(frequency, 380, 18) << "95 % of 400, four deviations of the count";
  EXPECT_NEAR(quality, 380, 18);
}

// 120 weighted residuals of deviation 0.02 less four parameters, over 120 weighted values of 1 in
// 60 pairs
TEST(Resonance, ResidualShareIsThatOfTheNoise) {
  constexpr int kRepetitions = 100;
  Noise noise(31);
  double square = 0;
  for (int r = 0; r < kRepetitions; ++r) {
    const Resonance found = FitResonance(std::span<const ResponsePoint>(Points(0.02, noise)));
    square += found.residual_share * found.residual_share / kRepetitions;
  }
  EXPECT_REL(std::sqrt(square), 0.02 * std::sqrt(116.0 / 60), 0.03,
             "four deviations: 1 / sqrt(2 116 100), and medians as weights");
}

// exact points; those above the resonance 5 % too large and uncertain by `share`
double FrequencyOffBy(double share_below, double share_above) {
  Noise noise(1);
  auto points = Points(0, noise);
  for (ResponsePoint& point : points) {
    const bool is_above = point.frequency_hz > kResonanceHz;
    point.relative_uncertainty = is_above ? share_above : share_below;
    if (is_above) point.response *= 1.05;
  }
  const Resonance found = FitResonance(std::span<const ResponsePoint>(points));
  EXPECT_TRUE(found.converged);
  return std::abs(found.frequency_hz - kResonanceHz);
}

// below 1e-3 of its value no uncertainty counts, above it each does
TEST(Resonance, PointsWeighByTheirUncertaintyDownToAThousandth) {
  const double alike_hz = FrequencyOffBy(0.1, 0.1);
  EXPECT_GT(alike_hz, 0.05) << "5 % on one side, in a width of 15 Hz";
  EXPECT_LT(FrequencyOffBy(1e-3, 0.1), 0.01 * alike_hz) << "weights of 10 000 to one";
  EXPECT_REL(FrequencyOffBy(0, 0.1), FrequencyOffBy(1e-3, 0.1), 0.5,
             "0 counts as a thousandth: of its own value, not of its neighbours'");
  EXPECT_REL(FrequencyOffBy(1e-5, 5e-4), alike_hz, 0.3, "both count as a thousandth");
}

// exact points of one deviation, but for one that is 5 % off with `ratio` times that deviation
double FrequencyWithOneOff(double ratio) {
  constexpr double kOffHz = 240;
  const double deviation = 0.01 * std::abs(ClosedForm(kOffHz));
  Noise noise(1);
  auto points = Points(0, noise);
  for (ResponsePoint& point : points) {
    const bool is_off = point.frequency_hz == kOffHz;
    if (is_off) point.response *= 1.05;
    point.relative_uncertainty = (is_off ? ratio : 1) * deviation / std::abs(point.response);
  }
  const Resonance found = FitResonance(std::span<const ResponsePoint>(points));
  EXPECT_TRUE(found.converged);
  return std::abs(found.frequency_hz - kResonanceHz);
}

TEST(Resonance, APointKeepsItsOwnUncertaintyWhereThatIsTenTimesAsLarge) {
  // weights in squares of 1 and of 1 / 101
  EXPECT_REL(FrequencyWithOneOff(9.99) / FrequencyWithOneOff(10.05), 101, 0.2,
             "of 60 points one has less than a fifth of what determines f0");
}

// of 40 points the level is 1 - (0.05 / 40)^(1 / (m - 1)), m = 0.94 segments
TEST(KeepSignificant, OfManyPointsIsTheLevelOfAllOfThem) {
  constexpr double kSegments = 25;
  const double level = 1 - std::pow(0.05 / 40, 1 / (0.94 * kSegments - 1));
  std::vector<ResponsePoint> points(40);
  for (std::size_t k = 0; k < points.size(); ++k) {
    points[k].coherence = level + (k % 2 == 0 ? -1e-9 : 1e-9);
  }
  KeepSignificant(points, kSegments);
  EXPECT_EQ(points.size(), 20U);
}

TEST(IndependentPoints, AreEveryThirdFrequency) {
  std::vector<ResponsePoint> points;
  for (int bin = 50; bin < 62; ++bin) {
    points.push_back({.frequency_hz = 0.4 * bin, .response = 1});
  }
  const auto kept = IndependentPoints(points, 0.4);
  ASSERT_EQ(kept.size(), 4U);
  for (std::size_t k = 0; k < kept.size(); ++k) {
    EXPECT_REL(kept[k].frequency_hz, 0.4 * (51 + 3 * static_cast<double>(k)), 1e-15, "bin 51 on");
  }
}

// blocks of 0.1 s: a run goes on below 10 Hz from one to the next, and without a block between them
TEST(LongestSweep, EndsAtAJumpOfOneOverABlockAndAtAMissingBlock) {
  for (const double jump_hz : {9.9, 10.1}) {
    const std::vector<SweptPoint> points{{0.1, 100, 1},
                                         {0.2, 101, 1},
                                         {0.3, 101 - jump_hz, 1},
                                         {0.4, 100 - jump_hz, 1},
                                         {0.5, 99 - jump_hz, 1}};
    const auto longest = LongestSweep(points, 0.1);
    ASSERT_EQ(longest.size(), jump_hz < 10 ? 5U : 3U) << jump_hz;
    EXPECT_EQ(longest.back().time_s, 0.5);
  }
  for (const double missing_s : {0.149, 0.151}) {
    const std::vector<SweptPoint> points{
        {0.1, 100, 1}, {0.2, 101, 1}, {0.3, 102, 1}, {0.3 + missing_s, 103, 1}};
    EXPECT_EQ(LongestSweep(points, 0.1).size(), missing_s < 0.15 ? 4U : 3U) << missing_s;
  }
  EXPECT_TRUE(LongestSweep({}, 0.1).empty());
}

TEST(SweepRate, IsTheMedianOfTheRates) {
  // 10, 20, 30 Hz/s in any direction, and a jump
  const std::vector<SweptPoint> points{{0, 100, 1},   {0.1, 101, 1}, {0.2, 99, 1},
                                       {0.3, 102, 1}, {0.4, 402, 1}, {0.5, 400.5, 1}};
  EXPECT_REL(SweepRate(points), 20, 1e-12, "rounding: 10, 15, 20, 30 and 3000");
}

TEST(FrequencyResponse, UncertaintyIsThatOfTheCoherence) {
  Sweep sweep = Swept(60, 500, 8);
  Noise noise(5);
  for (double& x : sweep.displacement_m) x += 2e-6 * noise();
  const WelchOptions options{kRateHz, 1000};
  const auto points =
      MeasureResponse(sweep.drive_v, sweep.displacement_m, options, 100, 450).value();
  const auto spectrum = WelchSpectrum(sweep.drive_v, options).value();
  // 31 segments that overlap by half: r_1 = 1/36
  const double freedom = 62 / (1 + 2 * (1 - 1.0 / 31) / 36);
  ASSERT_EQ(spectrum.grid.segments, 31U);
  ASSERT_EQ(points.size(), 176U) << "every 2 Hz, both ends included";
  EXPECT_EQ(points.front().frequency_hz, 100);
  EXPECT_EQ(points.back().frequency_hz, 450);
  for (const ResponsePoint& point : points) {
    const double c = point.coherence;
    EXPECT_REL(point.relative_uncertainty, std::sqrt((1 - c) / (c * freedom)), 1e-12, "rounding");
  }
}

// 100 whole periods in blocks of 50 samples: all but the first and the last
TEST(SweptAmplitude, OfASteadyToneIsTheToneInEveryBlock) {
  const std::vector<double> tone = Samples(kRateHz, 1000, 0, {{3e-6, 200, 0.4}});
  const auto points = SweptAmplitude(tone, kRateHz, 80, 480);
  ASSERT_EQ(points.size(), 18U);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double middle = 50 * static_cast<double>(k + 1) + 24.5;
    EXPECT_REL(points[k].time_s, middle / kRateHz, 1e-14, "rounding");
    EXPECT_REL(points[k].frequency_hz, 200, 1e-10, "rounding of a transform");
    EXPECT_REL(points[k].amplitude, 3e-6, 1e-10, "rounding of a transform");
  }
  EXPECT_TRUE(SweptAmplitude(tone, kRateHz, 201, 480).empty()) << "below the frequencies";
  EXPECT_TRUE(SweptAmplitude(tone, kRateHz, 80, 199).empty()) << "above them";
  const auto few = std::span(tone);
  EXPECT_EQ(SweptAmplitude(few.first(150), kRateHz, 80, 480).size(), 1U);
  EXPECT_TRUE(SweptAmplitude(few.first(149), kRateHz, 80, 480).empty()) << "no three blocks";
  // blocks of two samples and of three, and none of one
  for (const double periods : {0.08, 0.12}) {
    const auto short_blocks = SweptAmplitude(tone, kRateHz, 80, 480, periods);
    ASSERT_EQ(short_blocks.size(), periods < 0.1 ? 498U : 331U);
    for (const SweptPoint& point : short_blocks) {
      EXPECT_REL(point.frequency_hz, 200, 1e-9, "rounding of a transform");
      EXPECT_REL(point.amplitude, 3e-6, 1e-9, "rounding of a transform");
    }
  }
  EXPECT_TRUE(SweptAmplitude(tone, kRateHz, 80, 480, 0.05).empty());
}

// A phase that bends by 9.8 rad over each half block, or not at all: demodulated by its own
// parabola a chirp has the amplitude of the tone, and the frequency of the block's middle.
TEST(SweptAmplitude, OfAChirpIsItsAmplitudeAtTheFrequencyOfEachBlock) {
  for (const double hz_per_s : {50.0, -50.0}) {
    const double from_hz = 200 - 2 * hz_per_s;
    std::vector<double> chirp(8000);
    for (std::size_t k = 0; k < chirp.size(); ++k) {
      const double t_s = static_cast<double>(k) / kRateHz;
      chirp[k] = 3e-6 * std::cos(2 * kPi * (from_hz + 0.5 * hz_per_s * t_s) * t_s + 0.7);
    }
    const auto points = SweptAmplitude(chirp, kRateHz, 80, 480, 40);
    ASSERT_EQ(points.size(), 6U) << "blocks of 0.5 s but the first and the last";
    for (const SweptPoint& point : points) {
      EXPECT_REL(point.frequency_hz, from_hz + hz_per_s * point.time_s, 1e-5, "measured 1e-6");
      EXPECT_REL(point.amplitude, 3e-6, 1e-4, "measured 1e-5");
    }
  }
}

// 10 Hz/s down, 5 Hz/s up and 12 Hz/s up, over unequal times
TEST(SweepRate, IsTheMedianBetweenNeighbours) {
  const std::vector<SweptPoint> points{{0, 110, 1}, {1, 100, 1}, {3, 110, 1}, {7, 158, 1}};
  EXPECT_REL(SweepRate(points), 10, 1e-14, "rounding");
}

// a tone on a bin and one of `amplitude` on another; a Hann window shares each with two bins, which
// have a quarter of its density
std::size_t PointsWithADriveOf(double amplitude) {
  const std::vector<double> drive =
      Samples(kRateHz, 8000, 0, {{1, 200, 0.3}, {amplitude, 300, 0.1}});
  return MeasureResponse(drive, drive, {kRateHz, 1000}, 100, 450).value().size();
}

TEST(FrequencyResponse, LeavesOutTheBinsThatHoldNoDrive) {
  const std::vector<double> drive = Samples(kRateHz, 8000, 0, {{1, 200, 0.3}, {1, 300, 0.1}});
  const auto points = MeasureResponse(drive, drive, {kRateHz, 1000}, 100, 450).value();
  std::vector<double> at_hz;
  for (const ResponsePoint& point : points) at_hz.push_back(point.frequency_hz);
  EXPECT_EQ(at_hz, (std::vector<double>{198, 200, 202, 298, 300, 302})) << "lines of a Hann window";
}

TEST(FrequencyResponse, LeavesOutWhatHoldsLessThan1eMinus10OfTheDrive) {
  EXPECT_EQ(PointsWithADriveOf(0), 3U);
  EXPECT_EQ(PointsWithADriveOf(0.999e-5), 3U);
  EXPECT_EQ(PointsWithADriveOf(1.001e-5), 4U);
  EXPECT_EQ(PointsWithADriveOf(1.999e-5), 4U);
  EXPECT_EQ(PointsWithADriveOf(2.001e-5), 6U);
}

}  // namespace
}  // namespace haptometer::dsp
