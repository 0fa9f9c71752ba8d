// A trial.bin that version 0.1.0 recorded stays readable, and its analysis stays true.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/residual.h"
#include "tests/system/emulated_device.h"

namespace haptometer::tests {
namespace {

const std::string kTrial = std::string(HAPTOMETER_FIXTURES) + "/recorded_trial.bin";

TEST(RecordedTrial, IsReadWhole) {
  const auto trial = TrialInfo(kTrial);
  EXPECT_EQ(trial["closed"], true);
  EXPECT_EQ(trial["rows"], 10'000);
  EXPECT_EQ(trial["statuses"]["ok"], 10'000);
}

TEST(RecordedTrial, HoldsTheScenesVibration) {
  const Outcome analyzed = RunProgram({"analyze", kTrial, "--json"});
  ASSERT_EQ(analyzed.status, 0) << analyzed.err;
  const auto trial = nlohmann::json::parse(analyzed.out)["trials"][0];
  // truth: the scene's exact answer; 0.5 um of noise adds 0.155 um in band, in power 3e-7 of the
  // RMS
  EXPECT_REL(trial["band_rms_m"].get<double>(), 0.2001762058e-3, 5e-4,
             "0.4 s window: three of its stated uncertainty, and the ends' 2.5e-5");
  EXPECT_ABS(trial["tone_frequency_hz"].get<double>(), 225.0, 0.05, "the bar of the product");
}

}  // namespace
}  // namespace haptometer::tests
