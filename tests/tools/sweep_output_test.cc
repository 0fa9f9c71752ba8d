#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/analyze/analyze.h"
#include "tools/document/render.h"

namespace haptometer::tools {
namespace {

using ::testing::ContainsRegex;
using ::testing::EndsWith;
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

document::Document DocumentOf(const dsp::SweepAnswer& answer) {
  document::Document document{.verb = "analyze", .title = "sweep.bin"};
  document.root = SweepSection("sweep.bin", answer, true);
  return document;
}

TEST(SweepDocument, SaysF0AndQWithTheirIntervals) {
  const std::string text = TextOf(DocumentOf(Answered(true)), document::Detail::kShort);
  EXPECT_THAT(text, StartsWith("sweep.bin\n"));
  EXPECT_THAT(text, ContainsRegex("swept +100 to 300 Hz, 5 points"));
  EXPECT_THAT(text, ContainsRegex("largest amplitude +20 um/V, at 200 Hz"));
  EXPECT_THAT(text,
              ContainsRegex("natural frequency +200.00\\(50\\) Hz; 95 %: 199.00 to 201.00 Hz"));
  EXPECT_THAT(text, ContainsRegex("quality factor Q +10.00\\(25\\); 95 %: 9.50 to 10.50"));
}

TEST(SweepDocument, WritesColumnsNamedByTheirUnit) {
  document::Provenance provenance;
  provenance.version = "0.0";
  const std::string driven = SweepCsv(Answered(true), provenance);
  EXPECT_THAT(driven, HasSubstr("\n# haptometer 0.0"));
  EXPECT_THAT(driven,
              HasSubstr("\nfrequency_hz,amplitude_m_per_v,phase_rad,coherence\n100.0,2.66"));
  EXPECT_THAT(driven,
              ContainsRegex("\n200.0,(2e-05|1.9999999999999998e-05),-1.5707963267948966,0.875\n"));
  const std::string alone = SweepCsv(Answered(false), {});
  EXPECT_THAT(alone, HasSubstr("\nfrequency_hz,amplitude_m,phase_rad,coherence\n100.0,2.66"));
  EXPECT_THAT(alone, ContainsRegex("\n200.0,(2e-05|1.9999999999999998e-05),,\n"));
  EXPECT_THAT(SweepCsv({}, {}), EndsWith("\nfrequency_hz,amplitude_m,phase_rad,coherence\n"));
}

TEST(SweepDocument, JsonHoldsNullForWhatIsNotKnown) {
  const auto json = [](const dsp::SweepAnswer& answer) {
    return nlohmann::json::parse(JsonOf(DocumentOf(answer)));
  };
  const auto whole = json(Answered(true));
  EXPECT_EQ(whole["resonance"]["quality_factor"], 10);
  EXPECT_EQ(whole["resonance"]["frequency_interval_95_hz"], nlohmann::json({199, 201}));
  EXPECT_EQ(whole["points"].size(), 5U);
  EXPECT_EQ(whole["points"][2]["coherence"], 0.875);
  const auto alone = json(Answered(false));
  EXPECT_TRUE(alone["points"][0]["phase_rad"].is_null());
  EXPECT_TRUE(alone["drive_channel"].is_null());
  const auto none = json({});
  EXPECT_TRUE(none["resonance"].is_null());
  EXPECT_TRUE(none["window_s"].is_null());
  EXPECT_TRUE(none["points"].empty());
}

TEST(SweepDocument, RefusalsAreItsReasons) {
  dsp::SweepAnswer answer;
  answer.findings.Refuse(dsp::FindingKind::kNoResponse);
  answer.findings.Doubt(dsp::FindingKind::kNoDriveChannel);
  const auto json = nlohmann::json::parse(JsonOf(DocumentOf(answer)));
  EXPECT_EQ(json["reasons"], nlohmann::json({"the displacement shows no response to the drive"}));
  EXPECT_EQ(json["findings"].size(), 2U);
}

std::vector<plot::Panel> PanelsOf(const dsp::SweepAnswer& answer) {
  return SweepSection("sweep.bin", answer, true).figures.at(0).panels;
}

TEST(SweepDocument, DrawsAPanelForWhatIsThere) {
  const auto panels = PanelsOf(Answered(true));
  ASSERT_EQ(panels.size(), 3U);
  EXPECT_EQ(panels[0].title, "resonance at 200 Hz, Q 10");
  EXPECT_EQ(panels[0].series[0].y, panels[0].series[1].y) << "the points lie on the curve";
  EXPECT_EQ(PanelsOf(Answered(false)).size(), 1U);
  EXPECT_TRUE(SweepSection("sweep.bin", {}, true).figures.empty());
  const auto svg = plot::DrawSvg(panels);
  ASSERT_TRUE(svg);
  EXPECT_THAT(*svg, HasSubstr("amplitude / µm/V"));
}

}  // namespace
}  // namespace haptometer::tools
