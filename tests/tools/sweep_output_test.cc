#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/analyze/sweep_document.h"

namespace haptometer::tools {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

// f0 200 Hz, Q 10, 2 um/V at rest
dsp::SweepAnswer Answered(bool with_drive) {
  dsp::SweepAnswer answer;
  answer.answered = true;
  answer.amplitude_unit = with_drive ? "m/V" : "m";
  if (with_drive) answer.drive = "coil";
  answer.rate_hz = 2000;
  answer.window = {0, 8};
  answer.resolution_hz = 50;
  for (int k = 2; k <= 6; ++k) {
    const double u = k * 50 / 200.0;
    dsp::SweepPoint point{k * 50.0, 2e-6 / std::hypot(1 - u * u, u / 10), {}, {}};
    if (with_drive) {
      point.phase_rad = -std::atan2(u / 10, 1 - u * u);
      point.coherence = 0.875;
    }
    answer.points.push_back(point);
  }
  dsp::Resonance fit;
  fit.frequency_hz = 200;
  fit.quality_factor = 10;
  fit.gain = 2e-6;
  fit.degrees_of_freedom = 6;
  fit.converged = true;
  answer.resonance = dsp::SweepResonance{fit, {199, 201}, {9.5, 10.5}};
  return answer;
}

std::string Printed(const dsp::SweepAnswer& answer) {
  ::testing::internal::CaptureStdout();
  PrintSweep("sweep.bin", answer);
  return ::testing::internal::GetCapturedStdout();
}

TEST(SweepOutput, SaysF0AndQWithTheirIntervals) {
  const std::string text = Printed(Answered(true));
  EXPECT_THAT(text, StartsWith("sweep.bin\n"));
  EXPECT_THAT(text, HasSubstr("100 Hz to 300 Hz, 5 points"));
  EXPECT_THAT(text, HasSubstr("20 um/V amplitude at 200 Hz"));
  EXPECT_THAT(text, HasSubstr("200.00 Hz (95 % interval 199.00 to 201.00 Hz)"));
  EXPECT_THAT(text, HasSubstr("10.00 (95 % interval 9.50 to 10.50)"));
}

TEST(SweepOutput, WritesColumnsNamedByTheirUnit) {
  EXPECT_THAT(SweepCsv(Answered(true)),
              HasSubstr("\nfrequency_hz,amplitude_m_per_v,phase_rad,coherence\n100,2.66"));
  EXPECT_THAT(SweepCsv(Answered(true)), HasSubstr("\n200,2e-05,-1.57079633,0.875\n"));
  EXPECT_THAT(SweepCsv(Answered(false)),
              HasSubstr("\nfrequency_hz,amplitude_m,phase_rad,coherence\n100,2.66"));
  EXPECT_THAT(SweepCsv(Answered(false)), HasSubstr("\n200,2e-05,,\n"));
}

TEST(SweepOutput, JsonHoldsNullForWhatIsNotKnown) {
  const auto whole = SweepJson("sweep.bin", Answered(true));
  EXPECT_EQ(whole["resonance"]["quality_factor"], 10);
  EXPECT_EQ(whole["resonance"]["frequency_interval_95_hz"], nlohmann::json({199, 201}));
  EXPECT_EQ(whole["points"].size(), 5U);
  EXPECT_EQ(whole["points"][2]["coherence"], 0.875);
  const auto alone = SweepJson("sweep.bin", Answered(false));
  EXPECT_TRUE(alone["points"][0]["phase_rad"].is_null());
  EXPECT_TRUE(alone["drive_channel"].is_null());
  const auto none = SweepJson("sweep.bin", {});
  EXPECT_TRUE(none["resonance"].is_null());
  EXPECT_TRUE(none["window_s"].is_null());
  EXPECT_TRUE(none["points"].empty());
}

TEST(SweepOutput, DrawsAPanelForWhatIsThere) {
  const auto panels = SweepPanels(Answered(true));
  ASSERT_EQ(panels.size(), 3U);
  EXPECT_EQ(panels[0].title, "resonance at 200 Hz, Q 10");
  EXPECT_EQ(panels[0].series[0].y, panels[0].series[1].y) << "the points lie on the curve";
  EXPECT_EQ(SweepPanels(Answered(false)).size(), 1U);
  EXPECT_TRUE(SweepPanels({}).empty());
  const auto svg = plot::DrawSvg(panels);
  ASSERT_TRUE(svg);
  EXPECT_THAT(*svg, HasSubstr("amplitude / um/V"));
}

}  // namespace
}  // namespace haptometer::tools
