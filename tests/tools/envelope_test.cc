#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/plot/gnuplot.h"
#include "tools/trial/trial.h"

namespace haptometer::plot {
namespace {

struct Curve {
  std::vector<double> x;
  std::vector<double> y;
};

Curve Enveloped(const std::vector<double>& y, std::size_t slices) {
  std::vector<double> x(y.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = static_cast<double>(i);
  Curve curve;
  AppendEnvelope(x, y, slices, &curve.x, &curve.y);
  return curve;
}

TEST(Envelope, NoPeakIsLostWhereverItLies) {
  for (std::size_t peak = 0; peak < 10'000; peak += 37) {
    std::vector<double> y(10'000);
    for (std::size_t i = 0; i < y.size(); ++i) y[i] = std::sin(static_cast<double>(i));
    y[peak] = peak % 2 == 0 ? 7 : -7;
    const Curve curve = Enveloped(y, 100);
    EXPECT_LE(curve.y.size(), 300);
    const auto found = std::ranges::find(curve.y, y[peak]);
    ASSERT_NE(found, curve.y.end()) << peak;
    EXPECT_EQ(curve.x[static_cast<std::size_t>(found - curve.y.begin())],
              static_cast<double>(peak));
    EXPECT_TRUE(std::ranges::is_sorted(curve.x));
  }
}

TEST(Envelope, BreaksStayBreaksAndHideNoPeak) {
  std::vector<double> y(1000, 0.0);
  y[500] = std::numeric_limits<double>::quiet_NaN();
  y[505] = 3;
  for (std::size_t i = 700; i < 800; ++i) y[i] = y[500];
  const Curve curve = Enveloped(y, 10);
  EXPECT_TRUE(std::ranges::find(curve.y, 3.0) != curve.y.end());
  EXPECT_EQ(std::ranges::count_if(curve.y, [](double v) { return std::isnan(v); }), 2);
  // short curves come back as they are
  EXPECT_EQ(Enveloped({1, 2, 3}, 10).y, (std::vector<double>{1, 2, 3}));
}

TEST(TrialPanel, GapsBreakTheLineAndBadSamplesAreMarked) {
  trial::Record record;
  record.rows = 4;
  record.stretches = {{.first_row = 0, .rows = 2, .start_s = 0, .rate_hz = 10},
                      {.first_row = 2, .rows = 2, .start_s = 5, .rate_hz = 10}};
  using enum trial::SampleStatus;
  record.channels = {{.name = "laser",
                      .role = trial::ChannelRole::kDisplacement,
                      .unit = "m",
                      .values = {1e-3, 3e-3, std::nan(""), 2e-3},
                      .statuses = {kOk, kRepeated, kLate, kOk}}};
  const Panel panel = tools::PanelOf(record, record.channels[0]);
  EXPECT_EQ(panel.title, "laser about 2000 um");
  ASSERT_EQ(panel.series.size(), 2);
  EXPECT_EQ(panel.series[0].x, (std::vector<double>{0, 0.1, 5, 5, 5.1}));
  EXPECT_TRUE(std::isnan(panel.series[0].y[2]) && std::isnan(panel.series[0].y[3]));
  EXPECT_EQ(panel.series[1].x, (std::vector<double>{5}));
  EXPECT_NEAR(panel.series[1].y.at(0), -1000, 1e-9);
}

}  // namespace
}  // namespace haptometer::plot
