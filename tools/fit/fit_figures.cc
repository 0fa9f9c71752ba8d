#include "tools/fit/fit_figures.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <utility>

#include "base/error.h"
#include "base/mapped.h"
#include "dsp/spectrum/welch.h"
#include "fit/poles.h"
#include "tools/plot/gnuplot.h"

namespace haptometer::tools {
namespace {

using fit::FittedRecord;
using fit::ImpulseRecord;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
// slices of time that a curve's envelope is drawn in
constexpr std::size_t kSlices = 2000;
// points that stay apart: a ringing's samples lie on a curve, noise has no shape but its points
constexpr std::size_t kMostOfRinging = 1000;
constexpr std::size_t kMostOfNoise = 2 * kSlices;
constexpr std::size_t kMostInSegment = std::size_t{1} << 22U;
constexpr double kCellsADecade = 400;  // of frequency: 0.6 %, half the width of a resonance of Q 80
constexpr std::size_t kEllipsePoints = 180;

// samples as points where these stay apart, as a line where there are more than `most`
plot::Style SampleStyle(std::size_t rows, std::size_t most, plot::Colour colour) {
  if (rows > most) return plot::Lines(colour);
  constexpr std::size_t kFew = 500;
  return plot::Points(colour, rows > kFew ? 0.25 : 0.5);
}

// rows of a record, behind the last one
struct Rows {
  std::size_t first = 0;
  std::size_t end = 0;
  [[nodiscard]] std::size_t count() const { return end - first; }
};

double TimeMs(const ImpulseRecord& record, std::size_t row) {
  return (record.start_s + static_cast<double>(row) * record.step_s) * 1e3;
}

// what `value` gives at each row, over time, in no more points than a panel needs
template <typename F>
plot::Series Curve(const ImpulseRecord& record, Rows rows, std::string title, plot::Style style,
                   const F& value) {
  std::vector<double> x(rows.count());
  std::vector<double> y(rows.count());
  for (std::size_t n = 0; n < rows.count(); ++n) {
    x[n] = TimeMs(record, rows.first + n);
    y[n] = value(rows.first + n);
  }
  plot::Series series{std::move(title), style};
  plot::AppendEnvelope(x, y, kSlices, &series.x, &series.y);
  return series;
}

Rows AllOf(const ImpulseRecord& record) { return {0, record.voltage_v.size()}; }

// rows of the fitted part, missing samples within it included
Rows PartOf(const FittedRecord& fitted) {
  return {fitted.first_sample, fitted.first_sample + fitted.residual_v.size()};
}

bool IsFitted(const FittedRecord& fitted, std::size_t row) {
  const Rows part = PartOf(fitted);
  return row >= part.first && row < part.end && std::isfinite(fitted.residual_v[row - part.first]);
}

// how a record's values are shown: volts as they are, a displacement about its offset in um
struct Shown {
  std::string label;
  std::string unit;
  double offset = 0;
  double factor = 1;
  [[nodiscard]] double Of(double value) const { return (value - offset) * factor; }
};

Shown ShownOf(const ImpulseRecord& record, double offset) {
  if (record.signal == fit::RecordedSignal::kVoltage) return {"voltage / V", "V"};
  return {"displacement / um", "um", offset, 1e6};
}

// a vertical line as high as the record
plot::Series Mark(const ImpulseRecord& record, const Shown& shown, Rows rows, std::string title,
                  plot::Style style, double time_s) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (std::size_t row = rows.first; row < rows.end; ++row) {
    if (!std::isfinite(record.voltage_v[row])) continue;
    low = std::min(low, record.voltage_v[row]);
    high = std::max(high, record.voltage_v[row]);
  }
  return {std::move(title), style, {1e3 * time_s, 1e3 * time_s}, {shown.Of(low), shown.Of(high)}};
}

// the samples, the fit over them, the impact and the begin of what is fitted
plot::Panel RecordPanel(const ImpulseRecord& record, const FittedRecord& fitted, Rows rows,
                        std::string title) {
  const Rows part = PartOf(fitted);
  const Shown shown = ShownOf(record, fitted.offset_v);
  const auto sample = [&](std::size_t row, bool used) {
    return IsFitted(fitted, row) == used ? shown.Of(record.voltage_v[row]) : kNan;
  };
  // the model is drawn at missing samples of the part too
  const auto model = [&](std::size_t row) {
    return row >= part.first && row < part.end ? shown.Of(fitted.model_v[row - part.first]) : kNan;
  };
  const double first_s = TimeMs(record, part.first) * 1e-3;
  return {std::move(title),
          "time / ms",
          shown.label,
          {Curve(record, rows, "not used", SampleStyle(rows.count(), kMostOfRinging, plot::kGrey),
                 [&](std::size_t row) { return sample(row, false); }),
           Curve(record, rows, "used", SampleStyle(rows.count(), kMostOfRinging, plot::kOrange),
                 [&](std::size_t row) { return sample(row, true); }),
           Curve(record, rows, "fit", plot::Lines(plot::kBlue), model),
           Mark(record, shown, rows, "impact", plot::Lines(plot::kDarkGrey, 1, 2), fitted.impact_s),
           Mark(record, shown, rows, "fit begins", plot::Lines(plot::kDarkGrey, 1, 3), first_s)}};
}

// from a period and a half before the impact to five behind it
Rows NearImpact(const ImpulseRecord& record, const FittedRecord& fitted) {
  const Rows part = PartOf(fitted);
  const double period_s =
      fitted.damped_frequency_hz > 0
          ? 1 / fitted.damped_frequency_hz
          : static_cast<double>(part.count()) * record.step_s / 10;  // no oscillation: its begin
  const auto row_at = [&](double time_s) {
    const double row = std::round((time_s - record.start_s) / record.step_s);
    return static_cast<std::size_t>(
        std::clamp(row, 0.0, static_cast<double>(record.voltage_v.size())));
  };
  const Rows near{row_at(fitted.impact_s - 1.5 * period_s), row_at(fitted.impact_s + 5 * period_s)};
  return near.count() < 2 ? part : near;
}

plot::Panel ResidualPanel(const ImpulseRecord& record, const FittedRecord& fitted) {
  const bool knows_noise = fitted.quiet_noise_v > 0;
  // without noise every residual is 0 of it
  const double unit = std::max(knows_noise ? fitted.quiet_noise_v : fitted.residual_rms_v, 1e-300);
  const Rows part = PartOf(fitted);
  return {fmt::format("residual in units of {}: {}",
                      knows_noise ? "the noise before the impact" : "its own RMS",
                      document::QuantityText(unit,
                                             record.signal == fit::RecordedSignal::kVoltage
                                                 ? document::kVolt
                                                 : document::kMetre,
                                             3)),
          "time / ms",
          "residual / noise",
          {Curve(record, part, "", SampleStyle(part.count(), kMostOfNoise, plot::kOrange),
                 [&](std::size_t row) { return fitted.residual_v[row - part.first] / unit; })}};
}

// a density on logarithmic axes: its means over cells of equal width there, which hold one line at
// the low end and many at the high one. The line at 0 has no place on such an axis
plot::Series InCells(std::string title, plot::Colour colour, const dsp::PowerSpectrum& spectrum) {
  plot::Series series{std::move(title), plot::Lines(colour)};
  // number of a line's cell, uniform in the logarithm of frequency
  const auto cell_of = [](std::size_t line) {
    return std::floor(kCellsADecade * std::log10(static_cast<double>(line)));
  };
  for (std::size_t k = 1; k < spectrum.density.size();) {
    const std::size_t first = k;
    double sum = 0;
    for (; k < spectrum.density.size() && cell_of(k) == cell_of(first); ++k) {
      sum += spectrum.density[k];
    }
    // a cell stands at the middle of its lines
    series.x.push_back(0.5 * static_cast<double>(first + k - 1) * spectrum.grid.resolution_hz);
    series.y.push_back(sum > 0 ? sum / static_cast<double>(k - first) : kNan);
  }
  return series;
}

// mean periodogram over segments of at most kMostInSegment samples
Result<plot::Series> Density(std::string title, plot::Colour colour,
                             const std::vector<double>& values, double step_s) {
  HAPTOMETER_LET(
      const auto spectrum,
      dsp::WelchSpectrum(values, {.rate_hz = 1 / step_s,
                                  .segment_size = std::min(values.size(), kMostInSegment),
                                  .window = dsp::WindowShape::kRectangular,
                                  .overlap = 0,
                                  .detrend = dsp::Detrend::kNothing}));
  return InCells(std::move(title), colour, spectrum);
}

// the fitted part's samples less the offset, the model where one is missing; and the residuals
std::vector<double> RingingOf(const FittedRecord& fitted, const Shown& shown) {
  std::vector<double> ringing(fitted.model_v.size());
  for (std::size_t n = 0; n < ringing.size(); ++n) {
    // a missing sample has the model's value: residual 0
    const double residual = fitted.residual_v[n];
    ringing[n] = (fitted.model_v[n] + (std::isfinite(residual) ? residual : 0) - fitted.offset_v) *
                 shown.factor;
  }
  return ringing;
}

std::vector<double> ResidualsOf(const FittedRecord& fitted, const Shown& shown) {
  std::vector<double> residuals = fitted.residual_v;
  for (double& residual : residuals) {
    residual = std::isfinite(residual) ? residual * shown.factor : 0;
  }
  return residuals;
}

bool HasPoints(const plot::Series& series) {
  return std::ranges::any_of(series.y, [](double y) { return std::isfinite(y); });
}

// no panel for a record that is constant
std::vector<plot::Panel> SpectrumPanels(const ImpulseRecord& record, const FittedRecord& fitted) {
  const Shown shown = ShownOf(record, fitted.offset_v);
  const auto ringing = Density("record", plot::kBlue, RingingOf(fitted, shown), record.step_s);
  const auto residual =
      Density("residual", plot::kOrange, ResidualsOf(fitted, shown), record.step_s);
  if (!ringing || !residual || !HasPoints(*ringing)) return {};
  plot::Panel panel{"spectra of the fitted part (rectangular window)",
                    "frequency / Hz",
                    fmt::format("density / {}^2/Hz", shown.unit),
                    {*ringing},
                    plot::LogAxes::kBoth};
  if (HasPoints(*residual)) panel.series.push_back(*residual);
  if (fitted.quiet_noise_v > 0) {
    // one-sided density of white noise: 2 s^2 dt
    const double white = 2 * std::pow(fitted.quiet_noise_v * shown.factor, 2) * record.step_s;
    panel.series.push_back({"noise before the impact",
                            plot::Lines(plot::kDarkGrey, 1, 2),
                            {ringing->x.front(), ringing->x.back()},
                            {white, white}});
  }
  return {std::move(panel)};
}

document::Figure UnfittedFigure(const ImpulseRecord& record, const std::string& reason) {
  const Shown shown = ShownOf(record, 0);
  return {fmt::format("{}: no fit.", record.name),
          {{fmt::format("{}: not fitted: {}", record.name, reason),
            "time / ms",
            shown.label,
            {Curve(record, AllOf(record), "not used",
                   SampleStyle(record.voltage_v.size(), kMostOfRinging, plot::kGrey),
                   [&](std::size_t row) { return shown.Of(record.voltage_v[row]); })}}}};
}

document::Figure RecordFigure(const ImpulseRecord& record, const FittedRecord& fitted) {
  const std::string title = fmt::format("{} ({})", record.name, LoadText(fitted.load_ohm));
  document::Figure figure{
      fmt::format("{}: record and fit, the same close to the impact, the residual, and the spectra "
                  "of both. Grey: not used.",
                  title),
      {RecordPanel(record, fitted, AllOf(record), title),
       RecordPanel(record, fitted, NearImpact(record, fitted), "close to the impact"),
       ResidualPanel(record, fitted)}};
  for (auto& panel : SpectrumPanels(record, fitted)) figure.panels.push_back(std::move(panel));
  return figure;
}

// whether two records ring alike by the fit: the same load and mass
bool ShareAPole(const FittedRecord& one, const FittedRecord& other) {
  return one.pole.frequency_hz == other.pole.frequency_hz &&
         one.pole.decay_per_s == other.pole.decay_per_s;
}

std::string PoleTitle(const FittedRecord& fitted, std::size_t records) {
  const fit::UncertainPole& pole = fitted.pole;
  return fmt::format("pole of {} ({}): {} Hz, {} 1/s",
                     records == 1 ? fitted.name : fmt::format("{} records", records),
                     LoadText(fitted.load_ohm),
                     document::NumberText(pole.frequency_hz, std::sqrt(pole.covariance[0][0]), 0),
                     document::NumberText(pole.decay_per_s, std::sqrt(pole.covariance[1][1]), 0));
}

// the pole of `fitted` with its region, and where the searches of all that share it began
plot::Panel PolePanel(const FittedRecord& fitted, const std::vector<FittedRecord>& records) {
  plot::Series starts{"start", plot::Style{plot::Mark::kPoints, plot::kOrange, 2, 1, 0.8, 2}};
  for (const FittedRecord& record : records) {
    if (!record.pole.determined || !ShareAPole(record, fitted)) continue;
    const double decay = record.start.decay_per_s;
    // damped frequency sqrt(q - d^2)/(2 pi); 0 for a start that does not oscillate
    const double square = record.start.stiffness_per_s2 - decay * decay;
    starts.x.push_back(std::sqrt(std::max(square, 0.0)) / (2 * std::numbers::pi));
    starts.y.push_back(decay);
  }
  plot::Series ellipse{"95 % region", plot::Lines(plot::kBlue)};
  for (const fit::PolePlace& place : fit::EllipseOf(fitted.pole, kEllipsePoints)) {
    ellipse.x.push_back(place.frequency_hz);
    ellipse.y.push_back(place.decay_per_s);
  }
  return {.title = PoleTitle(fitted, starts.x.size()),
          .x_label = "damped frequency / Hz",
          .y_label = "decay rate / (1/s)",
          .series = {std::move(ellipse),
                     {"fit",
                      plot::Points(plot::kBlue, 0.6),
                      {fitted.pole.frequency_hz},
                      {fitted.pole.decay_per_s}},
                     std::move(starts)},
          .has_margins = true};
}

document::Figure PoleFigure(const std::vector<FittedRecord>& records) {
  document::Figure figure{
      "The poles of the fit with the 95 % region of frequency and decay together (noise and given "
      "numbers), and the start of each record.",
      {}};
  for (std::size_t r = 0; r < records.size(); ++r) {
    // records that share a pole have one panel
    const auto before = records.begin() + static_cast<std::ptrdiff_t>(r);
    const bool is_known = std::any_of(records.begin(), before, [&](const FittedRecord& other) {
      return ShareAPole(other, records[r]);
    });
    if (records[r].pole.determined && !is_known) {
      figure.panels.push_back(PolePanel(records[r], records));
    }
  }
  return figure;
}

}  // namespace

std::string LoadText(double load_ohm) {
  return std::isinf(load_ohm) ? "open" : fmt::format("{:g} ohm", load_ohm);
}

std::vector<document::Figure> FitLraFigures(const fit::DropTestFit& fit,
                                            const std::vector<ImpulseRecord>& records,
                                            const std::vector<fit::LeftOutDrop>& left_out) {
  std::vector<document::Figure> figures;
  figures.reserve(records.size() + left_out.size() + 1);
  for (std::size_t r = 0; r < records.size(); ++r) {
    figures.push_back(fit.converged ? RecordFigure(records[r], fit.records[r])
                                    : UnfittedFigure(records[r], "the search did not converge"));
  }
  if (document::Figure poles = PoleFigure(fit.records); !poles.panels.empty()) {
    figures.push_back(std::move(poles));
  }
  for (document::Figure& figure : UnfittedFigures(left_out)) figures.push_back(std::move(figure));
  return figures;
}

std::vector<document::Figure> UnfittedFigures(const std::vector<fit::LeftOutDrop>& drops) {
  return Mapped<document::Figure>(drops, [](const fit::LeftOutDrop& drop) {
    return UnfittedFigure(drop.record, drop.why.what);
  });
}

namespace {

using fit::ImpedanceFit;

constexpr double kDegrees = 180 / std::numbers::pi;

// the fitted model between the points too
struct ModelCurves {
  FrequencyCurve ohm;
  FrequencyCurve degrees;
};

ModelCurves CurvesOf(const ImpedanceFit& fit) {
  constexpr int kPlaces = 1000;
  ModelCurves curves;
  for (int k = 0; k <= kPlaces; ++k) {
    // places uniform in the logarithm of frequency
    const double hertz =
        fit.lowest_hz * std::pow(fit.highest_hz / fit.lowest_hz, static_cast<double>(k) / kPlaces);
    const auto value = fit::ImpedanceAt(fit.parameters, hertz).ohm;
    for (FrequencyCurve* curve : {&curves.ohm, &curves.degrees}) curve->hertz.push_back(hertz);
    curves.ohm.values.push_back(std::abs(value));
    curves.degrees.values.push_back(kDegrees * std::arg(value));
  }
  return curves;
}

}  // namespace

std::vector<plot::Panel> ImpedancePanels(const ImpedanceFit& fit) {
  const std::vector<fit::ImpedancePoint>& points = fit.measured;
  FrequencyCurve ohm;
  FrequencyCurve degrees;
  std::vector<SweepResiduals> left{{"magnitude", {}}, {"phase", {}}};
  for (std::size_t n = 0; n < points.size(); ++n) {
    ohm.values.push_back(std::abs(points[n].ohm));
    degrees.values.push_back(kDegrees * std::arg(points[n].ohm));
    ohm.hertz.push_back(points[n].frequency_hz);
    // ln of the ratio: magnitude and phase residuals; 1e-300 guards a fit without noise
    const std::complex<double> ratio = std::log(points[n].ohm / fit.model[n].ohm);
    left[0].values.push_back(ratio.real() / std::max(fit.magnitude_noise, 1e-300));
    left[1].values.push_back(ratio.imag() / std::max(fit.phase_noise_rad, 1e-300));
  }
  degrees.hertz = ohm.hertz;
  const ModelCurves model = CurvesOf(fit);
  const std::string noise =
      fmt::format("residual in units of a point's noise: {:.2g} %, {:.2g} deg",
                  100 * fit.magnitude_noise, kDegrees * fit.phase_noise_rad);
  constexpr auto kX = plot::LogAxes::kX;
  return {SweepPanel("", "|Z| / ohm", ohm, model.ohm, kX),
          SweepPanel("", "phase / deg", degrees, model.degrees, kX),
          SweepResidualPanel(noise, "residual / noise", ohm.hertz, left, kX)};
}

namespace {

plot::Style SweepPoints(plot::Colour colour) { return plot::Points(colour, 0.4); }

}  // namespace

plot::Panel SweepPanel(std::string title, std::string label, const FrequencyCurve& measured,
                       const FrequencyCurve& fitted, plot::LogAxes axes) {
  return {std::move(title),
          "frequency / Hz",
          std::move(label),
          {{"sweep", SweepPoints(plot::kOrange), measured.hertz, measured.values},
           {"fit", plot::Lines(plot::kBlue), fitted.hertz, fitted.values}},
          axes};
}

plot::Panel SweepResidualPanel(std::string title, std::string label,
                               const std::vector<double>& hertz,
                               const std::vector<SweepResiduals>& residuals, plot::LogAxes axes) {
  constexpr std::array kColours{plot::kOrange, plot::kBlue};
  HAPTOMETER_CHECK(residuals.size() <= kColours.size(), "{} quantities", residuals.size());
  plot::Panel panel{std::move(title), "frequency / Hz", std::move(label), {}, axes};
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    panel.series.push_back(
        {residuals[k].title, SweepPoints(kColours[k]), hertz, residuals[k].values});
  }
  return panel;
}

}  // namespace haptometer::tools
