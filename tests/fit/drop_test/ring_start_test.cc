#include "fit/drop_test/ring_start.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/fit/synthetic_drop.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using tests::MakeRecord;
using tests::SyntheticDrop;

TEST(RingStart, FindsImpactOffsetAndNoise) {
  SyntheticDrop drop;
  drop.noise_v = 2e-3;
  drop.quiet_s = 0.1;
  const auto start = FindRingStart(MakeRecord(drop));
  ASSERT_TRUE(start);
  EXPECT_ABS(start->impact_s, 0.37e-4, 2e-6, "phase from 1250 samples at 0.5 % noise");
  EXPECT_ABS(start->impact_voltage_v, std::sqrt(0.02 * 9.80665), 2e-3, "amplitude to 0.4 %");
  EXPECT_ABS(start->offset_v, 0.01, 2e-4, "mean of 1250 samples");
  EXPECT_REL(start->quiet_noise_v, 2e-3, 0.12, "490 samples, 3 sigma 10 %");
  EXPECT_REL(start->residual_rms_v, 2e-3, 0.1, "the pole pair fits");
  // the fit starts behind the blow by an eighth of a period, 0.56 ms
  const double first_s = -0.1 + static_cast<double>(start->first_sample) * drop.step_s;
  EXPECT_GT(first_s, 0.5e-3);
  EXPECT_LT(first_s, 1.0e-3);
  EXPECT_LT(-0.1 + static_cast<double>(start->quiet_samples) * drop.step_s, 0.0);
}

TEST(RingStart, ARecordThatBeginsWithTheBlowHasNoQuietStretch) {
  SyntheticDrop drop;
  drop.quiet_s = 0;
  drop.impact_s = -1e-6;
  const auto start = FindRingStart(MakeRecord(drop));
  ASSERT_TRUE(start);
  EXPECT_EQ(start->quiet_samples, 0U);
  EXPECT_EQ(start->quiet_noise_v, 0.0);
  EXPECT_ABS(start->impact_s, -1e-6, 3e-7, "offset taken from the median");
}

TEST(RingStart, PolarityIsThatOfTheFirstHalfPeriod) {
  for (const double polarity : {1.0, -1.0}) {
    SyntheticDrop drop;
    drop.polarity = polarity;
    const auto start = FindRingStart(MakeRecord(drop));
    ASSERT_TRUE(start);
    EXPECT_GT(polarity * start->impact_voltage_v, 0.4);
  }
}

TEST(RingStart, SilenceBeforeTheBlowStaysOutside) {
  // 1 ms of silence kept in a fit would cost 7 % of the damping
  SyntheticDrop drop;
  drop.quiet_s = 0.05;
  const auto record = MakeRecord(drop);
  const auto start = FindRingStart(record);
  ASSERT_TRUE(start);
  EXPECT_REL(start->poles.decay_per_s, 11.5, 1e-9, "noise-free");
}

TEST(RingStart, NoiseDoesNotMoveTheBlow) {
  // noise of a third of the amplitude: single samples before the blow pass half of the largest one
  for (unsigned seed = 1; seed <= 20; ++seed) {
    tests::SyntheticDrop drop;
    drop.noise_v = 0.33 * tests::ImpactSpeed(drop);
    drop.quiet_s = 0.03;
    drop.seed = seed;
    const auto start = FindRingStart(tests::MakeRecord(drop));
    ASSERT_TRUE(start) << start.error().Text();
    EXPECT_ABS(start->impact_s, drop.impact_s, 4e-4, "a tenth of a period");
  }
}

TEST(RingStart, TooShortARecordSaysWhatIsMissing) {
  SyntheticDrop drop;
  drop.quiet_s = 0;
  drop.length_s = 0.007;
  const auto start = FindRingStart(MakeRecord(drop));
  ASSERT_FALSE(start);
  EXPECT_EQ(start.error().cause, Cause::kCannotAnswer);
  EXPECT_EQ(start.error().where, "drop.csv");
  EXPECT_FALSE(start.error().remedy.empty());
  ImpulseRecord empty;
  EXPECT_FALSE(FindRingStart(empty));
}

}  // namespace
}  // namespace haptometer::fit
