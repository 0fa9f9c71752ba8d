// Records that hold little: noise of half the amplitude and more, a few cycles only. Each constant
// lies inside its interval or below its limit, or the record is refused with its energy.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "fit/drop_test/drop_test_fit.h"
#include "tests/fit/synthetic_drop.h"
#include "tests/fit/unprepared_drops.h"
#include "tests/repetitions.h"

namespace haptometer::fit {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using tests::SyntheticDrop;

struct Case {
  std::string name;
  double noise = 0;   // of the first amplitude
  double cycles = 0;  // recorded behind the blow; 0: three decay times
  double step_s = 2e-4;
};

// how often an interval or a limit is stated and holds the truth
struct Count {
  int intervals = 0;
  int limits = 0;
  int wrong = 0;

  void Add(const FittedValue& value, double truth) {
    if (value.determined) {
      ++intervals;
      wrong += value.lower <= truth && truth <= value.upper ? 0 : 1;
    } else if (value.at_most) {
      ++limits;
      wrong += truth <= *value.at_most ? 0 : 1;
    }
  }
};

class LittleEnergy : public ::testing::TestWithParam<Case> {};

SyntheticDrop DropOf(const Case& tried, unsigned seed) {
  SyntheticDrop drop;
  drop.step_s = tried.step_s;
  if (tried.cycles > 0) drop.length_s = tried.cycles / 225.08;
  drop.noise_v = tried.noise * tests::SpeedVoltage(drop);
  drop.seed = seed;
  return drop;
}

TEST_P(LittleEnergy, IsInsideItsIntervalOrRefused) {
  const Case& tried = GetParam();
  const int repetitions = tests::Repetitions(tests::kIsSanitized ? 4 : 60);
  Count stiffness;
  Count damping;
  Count force;
  int refused = 0;
  for (int k = 0; k < repetitions; ++k) {
    const auto open = DropOf(tried, 2 * static_cast<unsigned>(k) + 1);
    auto loaded = DropOf(tried, 2 * static_cast<unsigned>(k) + 2);
    loaded.load_ohm = 33;
    const auto fit =
        FitDropTest({tests::MakeRecord(open), tests::MakeRecord(loaded)}, tests::ThesisKnowns());
    if (!fit) {
      ++refused;
      EXPECT_THAT(fit.error().Text(), AnyOf(HasSubstr("dB more energy than the noise"),
                                            HasSubstr("periods after the impact")));
      continue;
    }
    stiffness.Add(fit->stiffness, open.stiffness_n_per_m);
    damping.Add(fit->damping, open.damping_n_s_per_m);
    force.Add(fit->force_constant, open.force_constant_n_per_a);
  }
  if (tried.noise <= 0.2) {
    EXPECT_EQ(refused, 0) << "there is enough to answer something";
  }
  std::printf("%s: %d of %d refused\n", tried.name.c_str(), refused, repetitions);
  for (const auto& [name, count] :
       {std::pair{"Kv", stiffness}, std::pair{"Bv", damping}, std::pair{"Km", force}}) {
    SCOPED_TRACE(name);
    std::printf("  %s: %d intervals, %d limits, %d of both wrong\n", name, count.intervals,
                count.limits, count.wrong);
    // of all records: which ones are answered depends on their noise
    const double slack = 2.5 * std::sqrt(0.95 * 0.05 * repetitions);
    EXPECT_LE(count.wrong, 0.05 * repetitions + slack);
  }
}

INSTANTIATE_TEST_SUITE_P(Drops, LittleEnergy,
                         ::testing::Values(Case{"Noise05", 0.5, 0}, Case{"Noise1", 1, 0},
                                           Case{"Noise2", 2, 0}, Case{"Noise5", 5, 0},
                                           Case{"Cycles45Noise002", 0.02, 4.5, 1e-4},
                                           Case{"Cycles45Noise02", 0.2, 4.5, 1e-4},
                                           Case{"Cycles45Noise05", 0.5, 4.5, 1e-4},
                                           Case{"Cycles3Noise002", 0.02, 3, 5e-5},
                                           Case{"Cycles2Noise002", 0.02, 2.1, 5e-5},
                                           Case{"Cycles2Noise02", 0.2, 2.1, 5e-5}),
                         [](const auto& tried) { return tried.param.name; });

}  // namespace
}  // namespace haptometer::fit
