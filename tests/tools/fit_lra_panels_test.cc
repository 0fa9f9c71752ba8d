#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/fit/synthetic_drop.h"
#include "tests/fit/unprepared_drops.h"
#include "tests/residual.h"
#include "tools/fit/fit_figures.h"

namespace haptometer::tools {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using tests::SyntheticDrop;

struct Fitted {
  std::vector<fit::ImpulseRecord> records;
  fit::DropTestFit fit;
};

// drops named a, b, c ... and their fit
Fitted FitOf(const std::vector<SyntheticDrop>& drops) {
  Fitted fitted;
  for (const SyntheticDrop& drop : drops) {
    fitted.records.push_back(tests::MakeRecord(drop));
    fitted.records.back().name = std::string(1, static_cast<char>('a' + fitted.records.size() - 1));
  }
  auto fit = fit::FitDropTest(fitted.records, tests::ThesisKnowns());
  EXPECT_TRUE(fit) << (fit ? "" : fit.error().Text());
  if (fit) fitted.fit = *fit;
  return fitted;
}

SyntheticDrop Noisy(unsigned seed, double load_ohm = tests::kOpen) {
  SyntheticDrop drop;
  drop.noise_v = 2e-3;
  drop.seed = seed;
  drop.load_ohm = load_ohm;
  return drop;
}

std::vector<document::Figure> FiguresOf(const Fitted& fitted) {
  return FitLraFigures(fitted.fit, fitted.records, {});
}

const plot::Series& SeriesOf(const plot::Panel& panel, const std::string& title) {
  const auto found = std::ranges::find(panel.series, title, &plot::Series::title);
  EXPECT_NE(found, panel.series.end()) << title;
  return found == panel.series.end() ? panel.series.front() : *found;
}

std::size_t CountOf(const std::vector<double>& values) {
  return static_cast<std::size_t>(
      std::ranges::count_if(values, [](double value) { return std::isfinite(value); }));
}

TEST(FitLraFigures, ARecordShowsWhatIsUsedAndTheFitOverIt) {
  const Fitted fitted = FitOf({Noisy(1)});
  const auto figures = FiguresOf(fitted);
  ASSERT_EQ(figures.size(), 2U);
  ASSERT_EQ(figures[0].panels.size(), 4U);
  const plot::Panel& panel = figures[0].panels[0];
  const fit::FittedRecord& record = fitted.fit.records[0];
  const std::size_t rows = fitted.records[0].voltage_v.size();
  EXPECT_EQ(CountOf(SeriesOf(panel, "used").y), record.samples);
  EXPECT_EQ(CountOf(SeriesOf(panel, "not used").y), rows - record.samples);
  const plot::Series& model = SeriesOf(panel, "fit");
  ASSERT_EQ(model.y.size(), rows);
  EXPECT_EQ(model.y[record.first_sample + 7], record.model_v[7]);
  EXPECT_TRUE(std::isnan(model.y[record.first_sample - 1]));
  EXPECT_REL(SeriesOf(panel, "impact").x[0], 1e3 * record.impact_s, 1e-15, "ms");
  EXPECT_REL(SeriesOf(panel, "fit begins").x[0], model.x[record.first_sample], 1e-12, "rounding");
  // a period and a half before to five behind
  const plot::Series& near = SeriesOf(figures[0].panels[1], "fit");
  EXPECT_ABS(near.x.back() - near.x.front(), 6.5e3 / 225.07, 0.3, "whole samples of 0.2 ms");
}

TEST(FitLraFigures, ResidualsAreInUnitsOfTheNoiseBeforeTheImpact) {
  const Fitted fitted = FitOf({Noisy(2)});
  const plot::Panel panel = FiguresOf(fitted)[0].panels[2];
  const fit::FittedRecord& record = fitted.fit.records[0];
  ASSERT_GT(record.quiet_noise_v, 0);
  EXPECT_THAT(panel.title, HasSubstr("the noise before the impact"));
  EXPECT_REL(panel.series[0].y[5], record.residual_v[5] / record.quiet_noise_v, 1e-15, "rounding");
  SyntheticDrop sudden = Noisy(2);
  sudden.quiet_s = -0.001;
  const plot::Panel own = FiguresOf(FitOf({sudden}))[0].panels[2];
  EXPECT_THAT(own.title, HasSubstr("its own RMS"));
  double square = 0;
  for (const double y : own.series[0].y) square += y * y;
  EXPECT_REL(square / static_cast<double>(own.series[0].y.size()), 1.0, 1e-12, "of itself");
}

TEST(FitLraFigures, ASpectrumHoldsThePowerAndItsPeakIsTheResonance) {
  const Fitted fitted = FitOf({Noisy(3)});
  const plot::Panel panel = FiguresOf(fitted)[0].panels[3];
  EXPECT_EQ(panel.log_axes, plot::LogAxes::kBoth);
  const plot::Series& record = SeriesOf(panel, "record");
  const auto peak = std::ranges::max_element(record.y) - record.y.begin();
  EXPECT_ABS(record.x[static_cast<std::size_t>(peak)], 225.07, 4.1, "one line is 1/0.25 s");
  // the residual is white: as dense as the noise before the impact says, all over
  const plot::Series& residual = SeriesOf(panel, "residual");
  const double white = SeriesOf(panel, "noise before the impact").y[0];
  EXPECT_REL(white, 2 * std::pow(fitted.fit.records[0].quiet_noise_v, 2) * 2e-4, 1e-12,
             "one-sided");
  double power = 0;  // the upper half, where cells hold several lines
  std::size_t cells = 0;
  for (std::size_t k = 0; k < residual.x.size(); ++k) {
    if (residual.x[k] < 1000) continue;
    power += residual.y[k];
    ++cells;
  }
  EXPECT_REL(power / static_cast<double>(cells), white, 0.3,
             "50 quiet samples tell their variance to 20 %, and these cells theirs to 6 %");
}

TEST(FitLraFigures, RecordsThatRingAlikeShareAPanelOfTheirPole) {
  const Fitted fitted = FitOf({Noisy(4), Noisy(5), Noisy(6, 33)});
  const auto figures = FiguresOf(fitted);
  ASSERT_EQ(figures.size(), 4U);
  const auto& poles = figures.back().panels;
  ASSERT_EQ(poles.size(), 2U);
  EXPECT_THAT(poles[0].title, StartsWith("pole of 2 records (open): 225.07"));
  EXPECT_THAT(poles[1].title, StartsWith("pole of c (33 ohm): 225.0"));
  EXPECT_EQ(SeriesOf(poles[0], "start").x.size(), 2U);
  EXPECT_EQ(SeriesOf(poles[1], "start").x.size(), 1U);
  const fit::UncertainPole& pole = fitted.fit.records[2].pole;
  EXPECT_EQ(SeriesOf(poles[1], "fit").y[0], pole.decay_per_s);
  const plot::Series& region = SeriesOf(poles[1], "95 % region");
  EXPECT_REL(std::ranges::max(region.y) - pole.decay_per_s,
             2.4477 * std::sqrt(pole.covariance[1][1]), 1e-3, "180 points");
}

TEST(FitLraFigures, LongRecordsAreDrawnAsTheirEnvelope) {
  SyntheticDrop drop = Noisy(7);
  drop.step_s = 4e-6;
  const Fitted fitted = FitOf({drop});
  ASSERT_GT(fitted.records[0].voltage_v.size(), 60'000U);
  for (const document::Figure& figure : FiguresOf(fitted)) {
    for (const plot::Panel& panel : figure.panels) {
      for (const plot::Series& series : panel.series) EXPECT_LE(series.x.size(), 6000U);
    }
  }
  const plot::Series used = SeriesOf(FiguresOf(fitted)[0].panels[0], "used");
  EXPECT_EQ(used.style.mark, plot::Mark::kLines);
  const double highest =
      *std::ranges::max_element(fitted.records[0].voltage_v.begin() +
                                    static_cast<std::ptrdiff_t>(fitted.fit.records[0].first_sample),
                                fitted.records[0].voltage_v.end());
  double drawn = 0;
  for (const double y : used.y) drawn = std::isfinite(y) ? std::max(drawn, y) : drawn;
  EXPECT_EQ(drawn, highest);
}

TEST(FitLraFigures, ALasersRecordIsShownInMicrometresAboutItsOffset) {
  SyntheticDrop drop;
  drop.displacement_share = 0.7;
  drop.condition = fit::CaseCondition::kFree;
  drop.step_s = 1e-4;
  drop.noise_v = 1e-7;
  drop.offset_v = 0.03;
  const Fitted fitted = FitOf({drop});
  const auto panels = FiguresOf(fitted)[0].panels;
  EXPECT_EQ(panels[0].y_label, "displacement / um");
  const fit::FittedRecord& record = fitted.fit.records[0];
  EXPECT_ABS(SeriesOf(panels[0], "fit").y[record.first_sample],
             1e6 * (record.model_v[0] - record.offset_v), 1e-6, "0.03 m cancels");
  EXPECT_THAT(panels[2].title, testing::EndsWith(" um"));
  EXPECT_EQ(panels[3].y_label, "density / um^2/Hz");
  EXPECT_REL(SeriesOf(panels[3], "noise before the impact").y[0],
             2e-4 * std::pow(1e6 * record.quiet_noise_v, 2), 1e-12, "one-sided");
}

TEST(FitLraFigures, WithoutAnOscillationThereIsNoPole) {
  SyntheticDrop drop;
  drop.damping_n_s_per_m = 3 * std::sqrt(2800 * 1.4e-3);
  drop.step_s = 2e-5;
  drop.length_s = 0.02;
  // an aperiodic motion is fitted where a height says what began it
  Fitted fitted{{tests::MakeRecordWithHeight(drop)}, {}};
  const auto fit = fit::FitDropTest(fitted.records, tests::ThesisKnowns());
  ASSERT_TRUE(fit) << fit.error().Text();
  fitted.fit = *fit;
  const auto figures = FiguresOf(fitted);
  ASSERT_EQ(figures.size(), 1U);
  EXPECT_GE(figures[0].panels.size(), 3U);
}

TEST(FitLraFigures, WithoutAFitThereIsTheRecordAndTheReason) {
  Fitted fitted = FitOf({Noisy(8)});
  fitted.fit.converged = false;
  fitted.fit.records[0].pole.determined = false;
  const fit::LeftOutDrop silent{fitted.records[0], {Cause::kCannotAnswer, "a", "no ring-down", ""}};
  const auto figures = FitLraFigures(fitted.fit, fitted.records, {silent});
  ASSERT_EQ(figures.size(), 2U);
  for (const document::Figure& figure : figures) {
    ASSERT_EQ(figure.panels.size(), 1U);
    ASSERT_EQ(figure.panels[0].series.size(), 1U) << "the record alone";
    EXPECT_EQ(CountOf(figure.panels[0].series[0].y), fitted.records[0].voltage_v.size());
  }
  EXPECT_EQ(figures[0].panels[0].title, "a: not fitted: the search did not converge");
  EXPECT_EQ(figures[1].panels[0].title, "a: not fitted: no ring-down");
}

}  // namespace
}  // namespace haptometer::tools
