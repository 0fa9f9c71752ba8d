// Each disturbance's gain against least squares of its own columns, by Gram and Schmidt.
#include "fit/drop_test/suspects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <utility>
#include <vector>

#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using Kind = Suspect::Kind;
using Column = std::vector<double>;

constexpr double kDecay = 12;
constexpr double kHertz = 130;
constexpr double kStart = -7e-3;
constexpr std::size_t kRows = 500;
constexpr PolePair kPoles{kDecay, 4 * M_PI* M_PI* kHertz* kHertz};

// E and w O, w^2 = q: by their closed forms
double Even(double t) {
  return std::exp(-kDecay * t) * std::cos(std::sqrt(kPoles.stiffness_per_s2 - 144) * t);
}
double Odd(double t) {
  const double damped = std::sqrt(kPoles.stiffness_per_s2 - kDecay * kDecay);
  return std::exp(-kDecay * t) * std::sin(damped * t) * std::sqrt(kPoles.stiffness_per_s2) / damped;
}

// a ringing of 1 from the first sample on, with `more` of the time since then, in noise
RingSamples Samples(const std::function<double(double)>& more, double step_s = 4e-4,
                    double noise = 1e-3) {
  RingSamples samples;
  samples.step_s = step_s;
  std::mt19937_64 engine(5);
  std::normal_distribution<double> white(0, noise);
  for (std::size_t n = 0; n < kRows; ++n) {
    const double since_s = static_cast<double>(n) * step_s;
    const double value = Even(since_s) - 0.3 * Odd(since_s) + 0.2 + more(since_s) + white(engine);
    // a hole of 7 samples
    if (n >= 200 && n < 207) continue;
    samples.times_s.push_back(kStart + since_s);
    samples.values_v.push_back(value);
  }
  return samples;
}

double Dot(const Column& a, const Column& b) {
  double sum = 0;
  for (std::size_t n = 0; n < a.size(); ++n) sum += a[n] * b[n];
  return sum;
}

// `column` less its share in `basis`, twice for rounding
void TakeOut(const std::vector<Column>& basis, Column& column) {
  for (int round = 0; round < 2; ++round) {
    for (const Column& one : basis) {
      const double share = Dot(one, column);
      for (std::size_t n = 0; n < column.size(); ++n) column[n] -= share * one[n];
    }
  }
}

struct Tried {
  double gain = 0;
  double amplitude = 0;
};

// orthonormal: what a fit's own columns take
std::vector<Column> BasisOf(const Jacobian& jacobian) {
  std::vector<Column> basis;
  for (std::size_t k = 0; k < jacobian.columns; ++k) {
    Column one;
    for (std::size_t n = 0; n < jacobian.rows; ++n) {
      one.push_back(jacobian.values[n * jacobian.columns + k]);
    }
    const double before = std::sqrt(Dot(one, one));
    for (double& value : one) value /= before;
    TakeOut(basis, one);
    const double length = std::sqrt(Dot(one, one));
    for (double& value : one) value /= length;
    basis.push_back(one);
  }
  return basis;
}

// one or two columns fitted to what a fit leaves, beside the fit's own
Tried Try(const RingFit& fit, std::vector<Column> columns, const std::vector<Column>& basis) {
  const Jacobian& jacobian = fit.jacobian;
  Column left = jacobian.residuals;
  for (double& value : left) value = -value;
  TakeOut(basis, left);
  const double all = Dot(jacobian.residuals, jacobian.residuals);
  for (Column& column : columns) TakeOut(basis, column);
  // normal equations of up to two columns
  const Column none(left.size(), 0.0);
  const Column& a = columns[0];
  const Column& b = columns.size() > 1 ? columns[1] : none;
  const double aa = Dot(a, a), ab = Dot(a, b), bb = columns.size() > 1 ? Dot(b, b) : 1;
  const double ar = Dot(a, left), br = Dot(b, left);
  const double first = (ar * bb - br * ab) / (aa * bb - ab * ab);
  const double second = (br * aa - ar * ab) / (aa * bb - ab * ab);
  const double gained = first * ar + second * br;
  const auto count = static_cast<double>(columns.size());
  const double degrees = static_cast<double>(jacobian.rows - jacobian.columns) - count;
  return {gained / count / ((all - gained) / degrees), std::hypot(first, second)};
}

Tried Try(const RingFit& fit, std::vector<Column> columns) {
  return Try(fit, std::move(columns), BasisOf(fit.jacobian));
}

Column Each(const RingSamples& samples, const std::function<double(double)>& of_time) {
  Column column;
  for (const double time_s : samples.times_s) column.push_back(of_time(time_s));
  return column;
}

void ExpectTried(const Suspect& suspect, const Tried& tried, double tolerance = 1e-6) {
  EXPECT_GT(tried.gain, 30);
  EXPECT_REL(suspect.gain, tried.gain, tolerance, "rounding");
  EXPECT_REL(suspect.amplitude_v, tried.amplitude, tolerance, "rounding");
}

TEST(PeriodOf, IsThatWithoutDamping) { EXPECT_REL(PeriodOf({3, 16}), M_PI / 2, 1e-15, "rounding"); }

TEST(WorstSuspect, ADriftIsALineFromTheFirstSampleToTheLast) {
  const auto samples = Samples([](double t) { return 0.05 * t; });
  const RingFit fit = FitRing(samples, kPoles, {});
  const Suspect worst = WorstSuspect(samples, fit, {}, true, true);
  ASSERT_EQ(worst.kind, Kind::kDrift);
  Column line;
  const auto rows = static_cast<double>(samples.times_s.size());
  for (double n = 0; n < rows; ++n) line.push_back(n / (rows - 1) - 0.5);
  ExpectTried(worst, Try(fit, {line}));
  EXPECT_TRUE(worst.is_positive);
  // one that is fitted already is none
  const RingBackground drifts{.drifts = true};
  EXPECT_EQ(WorstSuspect(samples, FitRing(samples, kPoles, drifts), drifts, true, true).kind,
            Kind::kNone);
  const auto down = Samples([](double t) { return -0.05 * t; });
  EXPECT_FALSE(WorstSuspect(down, FitRing(down, kPoles, {}), {}, true, true).is_positive);
}

Tried TryLine(const RingSamples& samples, const RingFit& fit, double hum_hz) {
  return Try(fit, {Each(samples, [&](double t) { return std::cos(2 * M_PI * hum_hz * t); }),
                   Each(samples, [&](double t) { return std::sin(2 * M_PI * hum_hz * t); })});
}

TEST(WorstSuspect, AHumIsACosineAndASineOfTheRecordsTime) {
  for (const double hum_hz : {50.0, 60.0}) {
    const auto samples =
        Samples([&](double t) { return 0.01 * std::sin(2 * M_PI * hum_hz * t + 1); });
    const RingFit fit = FitRing(samples, kPoles, {});
    const Suspect worst = WorstSuspect(samples, fit, {}, true, true);
    ASSERT_EQ(worst.kind, Kind::kHum);
    EXPECT_EQ(worst.value, hum_hz);
    ExpectTried(worst, TryLine(samples, fit, hum_hz));
  }
}

TEST(WorstSuspect, HarmonicsFollowUpToTheFifthAndToFourLines) {
  const auto found = [](double hertz, std::vector<double> known_hz) -> double {
    const auto samples = Samples([&](double t) {
      double hum = 0.01 * std::sin(2 * M_PI * hertz * t + 1);
      for (const double one : known_hz) hum += 0.02 * std::sin(2 * M_PI * one * t + 1);
      return hum;
    });
    const RingBackground background{.hum_hz = std::move(known_hz)};
    const RingFit fit = FitRing(samples, kPoles, background);
    const Suspect worst = WorstSuspect(samples, fit, background, false, false);
    if (worst.kind != Kind::kHum) return 0;
    EXPECT_EQ(worst.value, hertz);
    ExpectTried(worst, TryLine(samples, fit, hertz));
    return worst.value;
  };
  for (const double hertz : {100.0, 150.0, 200.0, 250.0}) EXPECT_EQ(found(hertz, {50}), hertz);
  EXPECT_EQ(found(300, {50}), 0);
  EXPECT_EQ(found(300, {60}), 300);
  EXPECT_EQ(found(60, {50}), 0) << "no harmonic";
  EXPECT_EQ(found(250, {50, 100, 150}), 250);
  EXPECT_EQ(found(250, {50, 100, 150, 200}), 0) << "four lines are the most";
}

TEST(WorstSuspect, AHumHasAPeriodInTheSamplesAndIsNoAlias) {
  // the poles and the step are scaled together; 500 samples
  const auto has_hum = [](double step_s) {
    RingSamples samples = Samples([](double) { return 0.0; });
    const double scale = step_s / samples.step_s;
    samples.step_s = step_s;
    for (std::size_t n = 0; n < samples.times_s.size(); ++n) {
      double& time_s = samples.times_s[n];
      time_s *= scale;
      samples.values_v[n] += 0.05 * std::sin(2 * M_PI * 60 * time_s + 1);
    }
    const RingFit fit =
        FitRing(samples, {kDecay / scale, kPoles.stiffness_per_s2 / scale / scale}, {});
    return WorstSuspect(samples, fit, {.drifts = true}, false, false).kind == Kind::kHum;
  };
  EXPECT_TRUE(has_hum(0.4 / 60 * 0.999));
  EXPECT_FALSE(has_hum(0.4 / 60 * 1.001));
  EXPECT_TRUE(has_hum(1 / 60. / (kRows - 1) * 1.001));
  EXPECT_FALSE(has_hum(1 / 60. / (kRows - 1) * 0.999));
}

TEST(WorstSuspect, ALineCountsFromAGainOfThirtyOn) {
  double silent = 0;
  double found = 2e-2;
  double silent_gain = 0;
  double found_gain = 0;
  for (int halving = 0; halving < 12; ++halving) {
    const double hum = (silent + found) / 2;
    const auto samples =
        Samples([&](double t) { return hum * std::sin(2 * M_PI * 50 * t); }, 4e-4, 1e-2);
    const RingFit fit = FitRing(samples, kPoles, {});
    const bool has = WorstSuspect(samples, fit, {}, false, false).kind == Kind::kHum;
    (has ? found : silent) = hum;
    (has ? found_gain : silent_gain) = TryLine(samples, fit, 50).gain;
  }
  EXPECT_REL(found_gain, 30.0, 2e-3, "halved 12 times");
  EXPECT_REL(silent_gain, 30.0, 2e-3, "halved 12 times");
}

// the columns of a jump half a step before the `first`-th sample
Tried TryBlow(const RingSamples& samples, const RingFit& fit, std::size_t first,
              const std::vector<Column>& basis) {
  const double d = fit.poles.decay_per_s;
  const double natural = std::sqrt(fit.poles.stiffness_per_s2);
  const double damped = std::sqrt(natural * natural - d * d);
  const double blow_s = samples.times_s[first] - samples.step_s / 2;
  const auto since = [&](const std::function<double(double)>& shape) {
    return Each(samples, [&](double t) {
      return t < blow_s ? 0 : std::exp(-d * (t - blow_s)) * shape(damped * (t - blow_s));
    });
  };
  return Try(fit, {since([](double angle) { return std::cos(angle); }), since([&](double angle) {
                     return natural / damped * std::sin(angle);
                   })},
             basis);
}

TEST(WorstSuspect, AnImpactIsTheBestJumpAroundTheBestOfAHalfPeriodsGrid) {
  // behind the first samples, about the hole, and before the last ones
  for (const double at : {8., 77., 79., 80., 81., 192., 195., 212., 469., 471., 473., 476., 489.}) {
    SCOPED_TRACE(at);
    const double at_s = 4e-4 * (at - 0.5);
    const auto samples = Samples(
        [&](double t) { return t < at_s ? 0 : 0.08 * Odd(t - at_s) + 0.02 * Even(t - at_s); });
    const RingFit fit = FitRing(samples, kPoles, {});
    const Suspect worst = WorstSuspect(samples, fit, {.drifts = true}, false, true);
    const auto basis = BasisOf(fit.jacobian);
    // 19.2 samples a period: trials every 10th, the last two left out, then all nearer than 10
    Tried most;
    std::size_t best = 0;
    const auto consider = [&](std::size_t first) {
      const Tried tried = TryBlow(samples, fit, first, basis);
      if (tried.gain <= most.gain) return;
      most = tried;
      best = first;
    };
    for (std::size_t first = 10; first < samples.times_s.size() - 20; first += 10) consider(first);
    const std::size_t middle = best;
    for (std::size_t first = middle - 9; first < middle + 10; ++first) consider(first);
    ASSERT_EQ(worst.kind, Kind::kBlow);
    EXPECT_EQ(worst.first, best);
    EXPECT_EQ(worst.value, samples.times_s[best] - samples.step_s / 2);
    ExpectTried(worst, most);
    // not where impacts are not asked for
    EXPECT_NE(WorstSuspect(samples, fit, {.drifts = true}, false, false).kind, Kind::kBlow);
  }
}

TEST(WorstSuspect, ARingingThatChangesWithItsAmplitudeIsNoImpact) {
  for (const double power : {2.0, -1.0}) {
    SCOPED_TRACE(power);
    const auto samples =
        Samples([&](double t) { return 0.05 * Odd(t) * std::exp(-power * kDecay * t); });
    const RingFit fit = FitRing(samples, kPoles, {});
    const Suspect worst = WorstSuspect(samples, fit, {.drifts = true}, false, true);
    ASSERT_EQ(worst.kind, Kind::kNonlinear);
    const double d = fit.poles.decay_per_s;
    const double natural = std::sqrt(fit.poles.stiffness_per_s2);
    const double damped = std::sqrt(natural * natural - d * d);
    const auto shape = [&](double t) { return std::exp(-(1 + power) * d * (t - kStart)); };
    ExpectTried(
        worst, Try(fit, {Each(samples,
                              [&](double t) { return shape(t) * std::cos(damped * (t - kStart)); }),
                         Each(samples, [&](double t) {
                           return natural / damped * shape(t) * std::sin(damped * (t - kStart));
                         })}));
  }
}

TEST(WorstSuspect, FrictionIsTheMotionsDerivativeByIt) {
  for (const RecordedSignal signal : {RecordedSignal::kVoltage, RecordedSignal::kDisplacement}) {
    RingSamples samples = Samples([](double) { return 0.0; });
    samples.signal = signal;
    std::vector<double> since_s;
    for (const double time_s : samples.times_s) since_s.push_back(time_s - kStart);
    // 0.2 % of the first swing's force
    const double natural = std::sqrt(kPoles.stiffness_per_s2);
    const double per_motion = signal == RecordedSignal::kVoltage ? natural : 1;
    const auto motion = [&](const PolePair& poles, double even, double odd, double friction) {
      return MotionWithFriction({.poles = poles,
                                 .even_v = even,
                                 .odd_v_per_s = odd,
                                 .friction = friction,
                                 .signal = signal},
                                since_s);
    };
    const double little = 2e-3 / per_motion;
    const auto with = motion(kPoles, 1, -0.3 * natural, little);
    const auto without = motion(kPoles, 1, -0.3 * natural, 0);
    for (std::size_t n = 0; n < with.size(); ++n) samples.values_v[n] += with[n] - without[n];
    const RingFit fit = FitRing(samples, kPoles, {});
    const Suspect worst = WorstSuspect(samples, fit, {}, true, true);
    ASSERT_EQ(worst.kind, Kind::kFriction);
    EXPECT_TRUE(worst.is_positive);
    // the derivative at no friction by a difference of second order
    const double step = 1e-6 / per_motion;
    const auto at = [&](double friction) {
      return motion(fit.poles, fit.even_v, fit.odd_v_per_s, friction);
    };
    const auto none = at(0), once = at(step), twice = at(2 * step);
    Column column;
    for (std::size_t n = 0; n < none.size(); ++n) {
      column.push_back((4 * once[n] - twice[n] - 3 * none[n]) / (2 * step));
    }
    ExpectTried(worst, Try(fit, {column}), 2e-3);
    EXPECT_NE(WorstSuspect(samples, fit, {}, false, true).kind, Kind::kFriction);
    EXPECT_NE(WorstSuspect(samples, fit, {.has_friction = true}, true, true).kind, Kind::kFriction);
  }
}

}  // namespace
}  // namespace haptometer::fit
