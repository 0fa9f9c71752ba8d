#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "fit/impedance/impedance_fit.h"
#include "tests/residual.h"
#include "tools/fit/fit_figures.h"

namespace haptometer::tools {
namespace {

TEST(SweepPanels, PointsAndFitHaveTheirOwnFrequencies) {
  const plot::Panel panel = SweepPanel("a contact", "amplitude / um", {{40, 80}, {1, 2}},
                                       {{40, 60, 80}, {1.1, 1.5, 1.9}}, plot::LogAxes::kBoth);
  EXPECT_EQ(panel.title, "a contact");
  EXPECT_EQ(panel.log_axes, plot::LogAxes::kBoth);
  ASSERT_EQ(panel.series.size(), 2U);
  EXPECT_EQ(panel.series[0].y, (std::vector<double>{1, 2}));
  EXPECT_EQ(panel.series[1].x, (std::vector<double>{40, 60, 80}));
  EXPECT_EQ(panel.series[0].style.mark, plot::Mark::kPoints);
  EXPECT_EQ(panel.series[1].style.mark, plot::Mark::kLines);
}

TEST(SweepPanels, ResidualsOfTwoQuantitiesStayApart) {
  const plot::Panel panel =
      SweepResidualPanel("left", "residual / noise", {40, 80},
                         {{"magnitude", {-1, 1}}, {"phase", {0.5, 0}}}, plot::LogAxes::kX);
  ASSERT_EQ(panel.series.size(), 2U);
  EXPECT_EQ(panel.series[1].title, "phase");
  EXPECT_EQ(panel.series[1].y[0], 0.5);
  EXPECT_NE(panel.series[0].style.colour.rgb, panel.series[1].style.colour.rgb);
}

TEST(ImpedancePanels, ResidualsAreInUnitsOfTheNoiseAndTheFitRunsBetweenThePoints) {
  std::mt19937_64 engine(5);
  std::normal_distribution<double> noise;
  std::vector<fit::ImpedancePoint> points;
  for (int k = 80; k >= 0; --k) {  // any order
    const double hz = 180 + k;
    const std::complex<double> s(0, 2 * std::numbers::pi * hz);
    const auto z = 27.0 + s * 130e-6 + 1.0 / (1.4e-3 * s + 0.0322 + 2800.0 / s);
    points.push_back(
        {hz, z * std::exp(std::complex<double>(1e-3 * noise(engine), 2e-3 * noise(engine)))});
  }
  const auto fit = fit::FitImpedance(points, {}, fit::CaseCondition::kHeld, "z.csv");
  ASSERT_TRUE(fit) << fit.error().Text();
  const auto panels = ImpedancePanels(*fit);
  ASSERT_EQ(panels.size(), 3U);
  EXPECT_EQ(panels[0].series[0].x.front(), 180);
  EXPECT_GT(panels[0].series[1].x.size(), 500U);
  // the fit at the lowest point
  EXPECT_REL(panels[0].series[1].y.front(), std::abs(fit->model.front().ohm), 1e-12, "the same");
  EXPECT_REL(panels[1].series[1].y.front(),
             std::arg(fit->model.front().ohm) * 180 / std::numbers::pi, 1e-9, "the same");
  for (const plot::Series& series : panels[2].series) {
    double square = 0;
    for (const double y : series.y) square += y * y;
    EXPECT_ABS(square / 81, 1.0, 0.1, "of their own noise; five parameters of 162 residuals");
  }
}

}  // namespace
}  // namespace haptometer::tools
