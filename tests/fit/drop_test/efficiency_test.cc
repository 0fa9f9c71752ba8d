// Errors of the fitted constants against the Cramer-Rao bound, and against their own statement.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "fit/drop_test/drop_test_fit.h"
#include "tests/fit/synthetic_drop.h"
#include "tests/fit/unprepared_drops.h"
#include "tests/repetitions.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using tests::MakeRecord;
using tests::SyntheticDrop;

// variance of decay and of angular frequency of A e^(-d t) cos(w t + p) in white noise s over a
// length T: (2 s^2 dt/A^2) I0/(I0 I2 - I1^2), I_k the integrals of t^k e^(-2 d t)
double RateVariance(double amplitude, double decay, double noise, double step_s, double length_s) {
  const double x = 2 * decay * length_s;
  const double left = std::exp(-x);
  const double i0 = (1 - left) / (2 * decay);
  const double i1 = (1 - left * (1 + x)) / std::pow(2 * decay, 2);
  const double i2 = (2 - left * (2 + 2 * x + x * x)) / std::pow(2 * decay, 3);
  return 2 * noise * noise * step_s / (amplitude * amplitude) * i0 / (i0 * i2 - i1 * i1);
}

struct Poles {
  double decay = 0;
  double angular = 0;
};

Poles PolesOf(const SyntheticDrop& drop) {
  const double mass = tests::EffectiveMass(drop);
  const double electric = drop.force_constant_n_per_a * drop.force_constant_n_per_a /
                          (drop.resistance_ohm + drop.load_ohm);
  const double decay = (drop.damping_n_s_per_m + electric) / (2 * mass);
  return {decay, std::sqrt(drop.stiffness_n_per_m / mass - decay * decay)};
}

// of a record from an eighth of a period behind the blow, where the fit begins at the earliest
double RateVariance(const SyntheticDrop& drop) {
  const Poles poles = PolesOf(drop);
  const double lost_s = std::numbers::pi / (4 * poles.angular);
  const double divider =
      std::isinf(drop.load_ohm) ? 1 : drop.load_ohm / (drop.load_ohm + drop.resistance_ohm);
  const double amplitude = drop.force_constant_n_per_a * tests::ImpactSpeed(drop) * divider *
                           std::exp(-poles.decay * lost_s);
  const double noise = std::hypot(drop.noise_v, drop.step_v / std::sqrt(12.0));
  return RateVariance(amplitude, poles.decay, noise, drop.step_s, drop.length_s - lost_s);
}

// relative bounds of Kv, Bv and Km of an open and a loaded record together
struct Bounds {
  double stiffness = 0;
  double damping = 0;
  double force_constant = 0;
};

Bounds BoundsOf(const SyntheticDrop& open, const SyntheticDrop& loaded) {
  const double first = RateVariance(open);
  const double second = RateVariance(loaded);
  const Poles poles = PolesOf(open);
  // both records tell the frequency
  const double angular = 1 / (1 / first + 1 / second);
  return {2 * std::sqrt(angular) / poles.angular, std::sqrt(first) / poles.decay,
          std::sqrt(first + second) / (2 * (PolesOf(loaded).decay - poles.decay))};
}

// what 2000 (or fewer) errors of one constant say
class Errors {
 public:
  void Add(const FittedValue& value, double truth) {
    if (!value.determined) {
      ++refused_;
      return;
    }
    const double error = value.value - truth;
    const double pull = error / value.standard_uncertainty;
    squares_ += error * error / (truth * truth);
    pulls_ += pull;
    pull_squares_ += pull * pull;
    ++count_;
  }
  [[nodiscard]] double relative_rms() const { return std::sqrt(squares_ / count_); }
  [[nodiscard]] double pull_mean() const { return pulls_ / count_; }
  [[nodiscard]] double pull_deviation() const {
    return std::sqrt(pull_squares_ / count_ - pull_mean() * pull_mean());
  }
  [[nodiscard]] double refused_share() const {
    return static_cast<double>(refused_) / (count_ + refused_);
  }
  // of a deviation estimated from so many
  [[nodiscard]] double own_share() const { return 1 / std::sqrt(2.0 * count_); }

 private:
  double squares_ = 0;
  double pulls_ = 0;
  double pull_squares_ = 0;
  int count_ = 0;
  int refused_ = 0;
};

struct Bar {
  double bound_factor = 1.05;
  double least_pull = 0.9;
  double most_pull = 1.1;
  double most_pull_mean = 0.15;
  double most_refused = 0;
};

void Expect(const Errors& errors, double bound, const std::string& name, const Bar& bar) {
  SCOPED_TRACE(name);
  const double slack = 2.5 * errors.own_share();  // of the repetitions themselves
  const double ratio = errors.relative_rms() / bound;
  std::printf("  %s: RMSE / bound %.3f, pulls %.3f +- %.3f (bound %.2g %%)\n", name.c_str(), ratio,
              errors.pull_mean(), errors.pull_deviation(), 100 * bound);
  EXPECT_LE(ratio, bar.bound_factor + slack);
  EXPECT_LE(errors.refused_share(), bar.most_refused);
  // a mean of so many pulls has sqrt(2) times the deviation of their deviation
  EXPECT_ABS(errors.pull_mean(), 0.0, bar.most_pull_mean + std::sqrt(2.0) * slack, "of pulls");
  EXPECT_GE(errors.pull_deviation(), bar.least_pull - slack);
  EXPECT_LE(errors.pull_deviation(), bar.most_pull + slack);
}

struct Case {
  std::string name;
  CaseCondition condition = CaseCondition::kHeld;
  double noise = 0;  // of the open record's first amplitude
  int bits = 0;      // over twice that amplitude; 0: not quantised
  Bar bar;
};

class Efficiency : public ::testing::TestWithParam<Case> {};

SyntheticDrop DropOf(const Case& tried, unsigned seed) {
  SyntheticDrop drop;
  drop.condition = tried.condition;
  drop.step_s = tried.condition == CaseCondition::kHeld ? 2e-4 : 1e-4;
  const double amplitude = tests::ImpactSpeed(drop);
  drop.noise_v = tried.noise * amplitude;
  if (tried.bits > 0) drop.step_v = 2.5 * amplitude / (1 << tried.bits);
  drop.seed = seed;
  drop.impact_s = 1e-7 * (seed % 997);
  return drop;
}

TEST_P(Efficiency, ErrorsAreAtTheBoundAndAsStated) {
  const Case& tried = GetParam();
  const int repetitions = tests::Repetitions(tests::kIsSanitized ? 6 : 100);
  Errors stiffness;
  Errors damping;
  Errors force_constant;
  Bounds bounds;
  for (int k = 0; k < repetitions; ++k) {
    const SyntheticDrop open = DropOf(tried, 2 * static_cast<unsigned>(k) + 1);
    SyntheticDrop loaded = DropOf(tried, 2 * static_cast<unsigned>(k) + 2);
    loaded.load_ohm = 33;
    bounds = BoundsOf(open, loaded);
    const auto fit = FitDropTest({MakeRecord(open), MakeRecord(loaded)}, tests::ThesisKnowns());
    ASSERT_TRUE(fit) << fit.error().Text();
    stiffness.Add(fit->stiffness, open.stiffness_n_per_m);
    damping.Add(fit->damping, open.damping_n_s_per_m);
    if (bounds.force_constant < 0.05) {
      force_constant.Add(fit->force_constant, open.force_constant_n_per_a);
    }
  }
  std::printf("%s, %d repetitions\n", tried.name.c_str(), repetitions);
  Expect(stiffness, bounds.stiffness, "Kv", tried.bar);
  Expect(damping, bounds.damping, "Bv", tried.bar);
  if (bounds.force_constant < 0.05) Expect(force_constant, bounds.force_constant, "Km", tried.bar);
}

constexpr auto kHeld = CaseCondition::kHeld;
constexpr auto kFree = CaseCondition::kFree;
// rounding to steps that the noise does not reach is no noise: it repeats itself where the ring
// does, and may be less than step / sqrt(12) where the ring is slow against the samples, or all of
// one sign
constexpr Bar kCorrelatedRounding{
    .bound_factor = 1.6, .least_pull = 0, .most_pull = 1.1, .most_pull_mean = 1};

INSTANTIATE_TEST_SUITE_P(
    Drops, Efficiency,
    ::testing::Values(
        Case{"HeldNoise0002", kHeld, 0.002, 0, {}}, Case{"HeldNoise002", kHeld, 0.02, 0, {}},
        Case{"HeldNoise02", kHeld, 0.2, 0, {}}, Case{"FreeNoise0002", kFree, 0.002, 0, {}},
        Case{"FreeNoise002", kFree, 0.02, 0, {}}, Case{"FreeNoise02", kFree, 0.2, 0, {}},
        Case{"HeldEightBitsNoise0003", kHeld, 0.003, 8, {}},
        Case{"HeldEightBitsNoise002", kHeld, 0.02, 8, {}},
        Case{"FreeEightBitsNoise0003", kFree, 0.003, 8, {}},
        Case{"HeldEightBitsNoNoise", kHeld, 0, 8, kCorrelatedRounding},
        Case{"HeldEightBitsNoise0001", kHeld, 0.001, 8, kCorrelatedRounding},
        Case{"FreeEightBitsNoNoise", kFree, 0, 8, kCorrelatedRounding}),
    [](const auto& tried) { return tried.param.name; });

}  // namespace
}  // namespace haptometer::fit
