#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dsp/spectrum/fft.h"
#include "fit/calibration/calibration_fit.h"
#include "fit/calibration/straight_line.h"
#include "fit/drop_test/drop_test_fit.h"
#include "fit/impedance/impedance_fit.h"
#include "fit/poles.h"
#include "fit/skin/skin_fit.h"
#include "sim/scene/actuator.h"
#include "tests/fit/synthetic_drop.h"
#include "tests/fit/unprepared_drops.h"
#include "tests/hard_cases/hard_case.h"

namespace haptometer::hard_cases {
namespace {

// sums of squares and products about the means
struct Moments {
  long double xx = 0, yy = 0, xy = 0;
};

Moments MomentsOf(const std::vector<fit::LinePoint>& points) {
  long double mean_x = 0, mean_y = 0;
  const auto n = static_cast<long double>(points.size());
  for (const fit::LinePoint& p : points) {
    mean_x += static_cast<long double>(p.x) / n;
    mean_y += static_cast<long double>(p.y) / n;
  }
  Moments m;
  for (const fit::LinePoint& p : points) {
    const long double x = static_cast<long double>(p.x) - mean_x;
    const long double y = static_cast<long double>(p.y) - mean_y;
    m.xx += x * x;
    m.yy += y * y;
    m.xy += x * y;
  }
  return m;
}

// a line of slope 2 whose points lie beside it to either side, at `offset`
std::vector<fit::LinePoint> Scattered(double u_x, double u_y, double offset) {
  constexpr std::array kAside{0.5, -0.75, 0.25, 0.75, -0.5, -0.25};
  std::vector<fit::LinePoint> points;
  double x = 0;
  for (const double aside : kAside) {
    points.push_back({offset + x + aside, 2 * x - aside, u_x, u_y});
    x += 1;
  }
  return points;
}

double OrdinarySlope(const std::vector<fit::LinePoint>& points) {
  const Moments m = MomentsOf(points);
  return static_cast<double>(m.xy / m.xx);
}

TEST(HardCasesFit, LineWithEqualUncertaintyOfBothCoordinates) {
  const auto points = Scattered(0.1, 0.1, 0);
  const Moments m = MomentsOf(points);
  const long double d = m.yy - m.xx;
  const auto line = fit::FitStraightLine(points, fit::Scatter::kFromResiduals);
  ASSERT_TRUE(line.has_value());
  // Deming's closed form; the bar is that of an iteration that ends at 1e-15 of the slope's change
  Check(
      {"fit", "line, x as uncertain as y", "errors of x reduce the slope", "ordinary least squares",
       1e-12},
      {(d + std::sqrt(d * d + 4 * m.xy * m.xy)) / (2 * m.xy), line->slope, OrdinarySlope(points)});
}

TEST(HardCasesFit, LineWithExactY) {
  const auto points = Scattered(0.1, 0, 0);
  const Moments m = MomentsOf(points);
  const auto line = fit::FitStraightLine(points, fit::Scatter::kFromResiduals);
  ASSERT_TRUE(line.has_value());
  Check(
      {"fit", "line, y exact", "all of the scatter is that of x", "ordinary least squares", 1e-12},
      {m.yy / m.xy, line->slope, OrdinarySlope(points)});
}

TEST(HardCasesFit, LineBesideALargeOffset) {
  const auto points = Scattered(0, 0.1, 1e9);
  double x = 0, y = 0, xx = 0, xy = 0;
  for (const fit::LinePoint& p : points) {
    x += p.x;
    y += p.y;
    xx += p.x * p.x;
    xy += p.x * p.y;
  }
  const double n = static_cast<double>(points.size());
  const Moments m = MomentsOf(points);
  const auto line = fit::FitStraightLine(points, fit::Scatter::kFromResiduals);
  ASSERT_TRUE(line.has_value());
  Check({"fit", "line, x beside 1e9", "the spread of x is 1e-9 of it",
         "normal equations of raw sums", 1e-12},
        {m.xy / m.xx, line->slope, (n * xy - x * y) / (n * xx - x * x)});
}

// e^(-decay t) cos(w t) at `rate_hz`
std::vector<double> RingDown(double decay_per_s, double frequency_hz, double rate_hz,
                             std::size_t samples) {
  std::vector<double> values;
  for (std::size_t k = 0; k < samples; ++k) {
    const double t_s = static_cast<double>(k) / rate_hz;
    values.push_back(std::exp(-decay_per_s * t_s) *
                     std::cos(2 * std::numbers::pi * frequency_hz * t_s));
  }
  return values;
}

// decay from the largest samples of each period
double DecayFromPeaks(const std::vector<double>& values, double rate_hz) {
  double first = 0, last = 0, first_s = 0, last_s = 0;
  for (std::size_t k = 1; k + 1 < values.size(); ++k) {
    if (!(values[k] > values[k - 1] && values[k] >= values[k + 1] && values[k] > 0)) continue;
    if (first == 0) {
      first = values[k];
      first_s = static_cast<double>(k) / rate_hz;
    }
    last = values[k];
    last_s = static_cast<double>(k) / rate_hz;
  }
  return std::log(first / last) / (last_s - first_s);
}

void CheckDecay(const char* name, double decay_per_s, double frequency_hz, double rate_hz,
                std::size_t samples, double bar) {
  const auto values = RingDown(decay_per_s, frequency_hz, rate_hz, samples);
  const auto poles = fit::EstimatePoles(values, 1 / rate_hz);
  ASSERT_TRUE(poles.has_value());
  Check(
      {"fit", name, "no sample lies on a peak", "logarithmic decrement of sampled peaks", bar},
      {static_cast<long double>(decay_per_s), poles->decay_per_s, DecayFromPeaks(values, rate_hz)});
}

// bars: without noise a pencil of a rank-two matrix leaves rounding times its condition
TEST(HardCasesFit, DecayOfFewSamplesAPeriod) {
  CheckDecay("decay of 225 Hz at 1 kHz", 11.5, 225.3, 1e3, 200, 1e-9);
}

TEST(HardCasesFit, DecayOfAStronglyDampedMode) {
  CheckDecay("decay of Q 3", 220, 210.7, 1e4, 400, 1e-6);
}

TEST(HardCasesFit, FrequencyByZeroCrossings) {
  constexpr double kDecay = 220, kFrequency = 210.7, kRate = 1e4;
  const auto values = RingDown(kDecay, kFrequency, kRate, 400);
  const auto poles = fit::EstimatePoles(values, 1 / kRate);
  ASSERT_TRUE(poles.has_value());
  const long double w = 2 * std::numbers::pi_v<long double> * 210.7L;
  // first two falling crossings, to a sample
  std::vector<double> crossings_s;
  for (std::size_t k = 1; k < values.size(); ++k) {
    if (values[k - 1] > 0 && values[k] <= 0) crossings_s.push_back(static_cast<double>(k) / kRate);
  }
  const double naive = 2 * std::numbers::pi / (crossings_s[1] - crossings_s[0]);
  Check({"fit", "natural frequency squared of Q 3", "the period is that of the damped motion",
         "2 pi over the time between two zero crossings, squared", 1e-6},
        {w * w + 220.0L * 220.0L, poles->stiffness_per_s2, naive * naive});
}

TEST(HardCasesFit, LinePublishedForUncertaintiesOfBothCoordinates) {
  // Pearson's points with York's weights 1/u^2; York et al., Am. J. Phys. 72, 367 (2004), table II
  constexpr double kPearson[][4] = {
      {0.0, 1000, 5.9, 1},  {0.9, 1000, 5.4, 1.8}, {1.8, 500, 4.4, 4}, {2.6, 800, 4.6, 8},
      {3.3, 200, 3.5, 20},  {4.4, 80, 3.7, 20},    {5.2, 60, 2.8, 70}, {6.1, 20, 2.8, 70},
      {6.5, 1.8, 2.4, 100}, {7.4, 1, 1.5, 500}};
  std::vector<fit::LinePoint> points;
  for (const auto& row : kPearson) {
    points.push_back({row[0], row[2], 1 / std::sqrt(row[1]), 1 / std::sqrt(row[3])});
  }
  const auto line = fit::FitStraightLine(points, fit::Scatter::kStated);
  ASSERT_TRUE(line.has_value());
  // the bar: digits printed
  Check({"fit", "slope of Pearson's points with York's weights",
         "each point has weights of its own", "ordinary least squares", 1.1e-9},
        {-0.480533407L, line->slope, OrdinarySlope(points)});
}

TEST(HardCasesFit, CalibrationWithATypingError) {
  // 10.0 V written for 1.0 V
  std::vector<fit::LinePoint> points, right;
  constexpr std::array kAside{2e-6, -1e-6, 1e-6, -2e-6, 0.0, 1e-6, -1e-6, 2e-6, -2e-6};
  for (std::size_t k = 0; k < kAside.size(); ++k) {
    const auto volts = static_cast<double>(k);
    points.push_back({volts + (k == 1 ? 9 : 0), 1e-3 * volts + kAside[k], 0, 1e-6});
    if (k != 1) right.push_back(points.back());
  }
  const auto line = fit::FitCalibration(points, fit::Scatter::kFromResiduals);
  ASSERT_TRUE(line.has_value() && line->outliers.has_value());
  const Moments m = MomentsOf(right);
  Check({"fit", "slope of nine calibration points, one ten times too far",
         "the point draws the line to itself", "ordinary least squares", 1e-12},
        {m.xy / m.xx, line->outliers->others.slope, OrdinarySlope(points)});
}

TEST(HardCasesFit, DecayOfHighQInAShortRecord) {
  // Q = pi 200 / 2 = 314 in ten periods
  constexpr double kRate = 4e3;
  const auto values = RingDown(2, 200.3, kRate, 200);
  const auto poles = fit::EstimatePoles(values, 1 / kRate);
  ASSERT_TRUE(poles.has_value());
  // half-power width of the zero-padded spectrum
  std::vector<double> padded(values);
  padded.resize(16'384);
  const auto spectrum = dsp::RealSpectrum(padded);
  double peak = 0;
  for (const auto& line : spectrum) peak = std::fmax(peak, std::abs(line));
  const auto above = std::ranges::count_if(
      spectrum, [&](const auto& line) { return std::abs(line) >= peak / std::numbers::sqrt2; });
  const double naive = std::numbers::pi * static_cast<double>(above) * kRate / 16'384;
  Check({"fit", "decay of Q 314 in ten periods", "the record is shorter than a decay time",
         "half-power width of the spectrum", 1e-6},
        {2, poles->decay_per_s, naive});
}

// ---------------------------------------------------------------- drop tests

constexpr double kMassKg = 1.4e-3, kKv = 2800, kBv = 0.0322, kKm = 1, kCoilOhm = 27,
                 kHenry = 130e-6;

constexpr long double Long(double value) { return static_cast<long double>(value); }

// the terminals' voltage of M x'' + Bv x' + Kv x = -Km i, L i' + (R + RL) i = Km x' after an impact
// of 0.4 m/s, in the three natural motions of the circuit
class Circuit {
 public:
  explicit Circuit(long double load_ohm) : load_ohm_(load_ohm) {
    const auto m = Long(kMassKg), b = Long(kBv), k = Long(kKv), l = Long(kHenry);
    const auto r = Long(kCoilOhm) + load_ohm;
    // (M s^2 + B s + K)(L s + R) + Km^2 s by Newton's method from the uncoupled poles
    poles_ = {Complex(-r / l, 0), Complex(-20, 1400), Complex(-20, -1400)};
    for (Complex& s : poles_) {
      for (int step = 0; step < 60; ++step) {
        const Complex spring = m * s * s + b * s + k, coil = l * s + r;
        const Complex slope = (2.0L * m * s + b) * coil + spring * l + 1.0L;
        s -= (spring * coil + s) / slope;
      }
    }
    // x = 0, x' = 0.4, i = Km s c / (L s + R) = 0
    Eigen::Matrix<Complex, 3, 3> rows;
    for (int j = 0; j < 3; ++j) {
      const Complex s = poles_[static_cast<std::size_t>(j)];
      rows.col(j) << 1.0L, s, s / (l * s + r);
    }
    const Eigen::Matrix<Complex, 3, 1> start(0.0L, 0.4L, 0.0L);
    const Eigen::Matrix<Complex, 3, 1> shares = rows.fullPivLu().solve(start);
    for (std::size_t j = 0; j < 3; ++j) {
      current_[j] = shares(static_cast<Eigen::Index>(j)) * poles_[j] / (l * poles_[j] + r);
    }
  }

  [[nodiscard]] double VoltageAt(double t_s) const {
    Complex current = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      current += current_[j] * std::exp(poles_[j] * static_cast<long double>(t_s));
    }
    return static_cast<double>(load_ohm_ * current.real());
  }
  [[nodiscard]] double decay_per_s() const { return -static_cast<double>(poles_[1].real()); }

 private:
  using Complex = std::complex<long double>;
  long double load_ohm_;
  std::array<Complex, 3> poles_{};
  std::array<Complex, 3> current_{};
};

// 10 ms of silence, then what `voltage` gives, 5 kHz
template <typename Voltage>
fit::ImpulseRecord RecordOf(double load_ohm, const Voltage& voltage) {
  fit::ImpulseRecord record;
  record.name = "drop.csv";
  record.step_s = 2e-4;
  record.start_s = -0.01;
  record.load_ohm = Quantity{load_ohm, 0};
  for (int k = -50; k < 1250; ++k) {
    record.voltage_v.push_back(k < 0 ? 0 : voltage(2e-4 * k + 1.3e-5));
  }
  return record;
}

fit::ActuatorKnowns Knowns() {
  return {Quantity{kMassKg, 0}, Quantity{0.6e-3, 0}, Quantity{kCoilOhm, 0}, Quantity{kHenry, 0}};
}

// an open circuit's voltage: Km x' of the spring and Bv alone, from the impact
double OpenVoltage(double t_s) {
  const double d = kBv / (2 * kMassKg);
  const double w = std::sqrt(kKv / kMassKg - d * d);
  return 0.4 * std::exp(-d * t_s) * (std::cos(w * t_s) - d / w * std::sin(w * t_s));
}

TEST(HardCasesFit, ForceConstantFromTwoLoads) {
  const Circuit loaded(27);
  const std::vector<fit::ImpulseRecord> records = {
      RecordOf(std::numeric_limits<double>::infinity(), OpenVoltage),
      RecordOf(27, [&](double t_s) { return loaded.VoltageAt(t_s); })};
  const auto fitted = fit::FitDropTest(records, Knowns());
  ASSERT_TRUE(fitted.has_value());
  const double naive = std::sqrt(2 * kMassKg * (loaded.decay_per_s() - kBv / (2 * kMassKg)) * 54);
  // the bar: rounding of the records, 1e-16 of 0.4 V, through decays that differ by half
  Check({"fit", "Km from ring-downs with two loads, coil of 130 uH",
         "the current lags behind the motion", "Km^2 = 2 M (d1 - d0)(R + RL)", 1e-10},
        {1, fitted->force_constant.value, naive});
}

// decay from the second of the record's peaks, which are interpolated, to a tenth of it
double DecayOfPeaks(const std::vector<double>& values, double step_s) {
  std::vector<std::pair<double, double>> peaks;  // time, height
  for (std::size_t k = 1; k + 1 < values.size(); ++k) {
    const double a = values[k - 1], b = values[k], c = values[k + 1];
    if (!(b > a && b >= c && b > 0)) continue;
    const double aside = (a - c) / (2 * (a - 2 * b + c));
    const double height = b - (a - c) * aside / 4;
    if (peaks.size() > 1 && height < peaks[1].second / 10) break;
    peaks.emplace_back((static_cast<double>(k) + aside) * step_s, height);
  }
  return std::log(peaks[1].second / peaks.back().second) / (peaks.back().first - peaks[1].first);
}

// speed of x'' + 2 d x' + q x = -q f sign(x') after an impact: between turns a damped sine about
// +-f
double SpeedWithFriction(double t_s, double friction_m) {
  const double d = kBv / (2 * kMassKg), q = kKv / kMassKg, w = std::sqrt(q - d * d);
  double sign = 1, place = friction_m, speed = 0.4, begin_s = 0;
  for (;;) {
    const double pull = (q * place + d * speed) / w;
    const double turn_s = begin_s + (speed == 0 ? std::numbers::pi : std::atan(speed / pull)) / w;
    const double now_s = std::fmin(t_s, turn_s) - begin_s;
    const double fall = std::exp(-d * now_s), c = std::cos(w * now_s), s = std::sin(w * now_s);
    if (t_s <= turn_s) return fall * (speed * c - pull * s);
    // the place about the other side's middle
    place = fall * (place * c + (speed + d * place) / w * s) - 2 * sign * friction_m;
    sign = -sign;
    if (std::fabs(place) <= 2 * friction_m) return 0;
    speed = 0;
    begin_s = turn_s;
  }
}

TEST(HardCasesFit, DampingBesideDryFriction) {
  // 0.5 % of the spring's force at the first peak of 0.28 mm
  const auto record = RecordOf(std::numeric_limits<double>::infinity(),
                               [](double t_s) { return SpeedWithFriction(t_s, 1.4e-6); });
  const auto fitted = fit::FitDropTest({record}, Knowns());
  ASSERT_TRUE(fitted.has_value());
  const std::vector<double> ringing(record.voltage_v.begin() + 50, record.voltage_v.end());
  // the bar: half the width of the 95 % interval that the fit states
  Check({"fit", "Bv beside dry friction of 0.5 % of the first peak's spring force",
         "friction takes the same from each half swing", "decrement of the peaks", 1.6e-2},
        {Long(kBv), fitted->damping.value, 2 * kMassKg * DecayOfPeaks(ringing, 2e-4)});
}

TEST(HardCasesFit, TimeOfAnImpactBetweenSamples) {
  const auto record = RecordOf(std::numeric_limits<double>::infinity(), OpenVoltage);
  const auto fitted = fit::FitDropTest({record}, Knowns());
  ASSERT_TRUE(fitted.has_value());
  // the first sample beyond half of the largest
  const double half = *std::ranges::max_element(record.voltage_v) / 2;
  const auto first = std::ranges::find_if(record.voltage_v, [&](double v) { return v > half; });
  const auto place = static_cast<double>(first - record.voltage_v.begin());
  // the bar: rounding of the voltage, 1e-16 of the period of 4.4 ms
  Check({"fit", "time of an impact 13 us before a sample", "only the ringing contains it",
         "the first sample beyond half of the peak", 1e-9},
        {-1.3e-5L, fitted->records[0].impact_s, record.start_s + place * record.step_s});
}

TEST(HardCasesFit, DampingBesideOutliers) {
  // every 29th sample is off by up to a tenth of a volt
  auto record = RecordOf(std::numeric_limits<double>::infinity(), OpenVoltage);
  for (std::size_t k = 60; k < record.voltage_v.size(); k += 29) {
    record.voltage_v[k] += 0.1 * std::sin(static_cast<double>(k * k));
  }
  const auto robust = fit::FitDropTest({record}, Knowns(), fit::Loss::kHuber);
  const auto squares = fit::FitDropTest({record}, Knowns());
  ASSERT_TRUE(robust.has_value() && squares.has_value());
  // the bar: the others have no noise, so that nothing but rounding is left of them
  Check({"fit", "Bv where every 29th sample is off by up to a quarter of the peak",
         "squares weigh what is far away most", "least squares", 1e-9},
        {Long(kBv), robust->damping.value, squares->damping.value});
}

// mass times (pi / half a period)^2, half a period between the first two changes of sign
double StiffnessOfZeros(const fit::ImpulseRecord& record, const tests::SyntheticDrop& drop) {
  std::vector<double> zeros;
  const auto first = static_cast<std::size_t>((drop.quiet_s + drop.impact_s) / drop.step_s) + 2;
  for (std::size_t k = first; k + 1 < record.voltage_v.size() && zeros.size() < 2; ++k) {
    if (record.voltage_v[k] * record.voltage_v[k + 1] < 0) zeros.push_back(static_cast<double>(k));
  }
  if (zeros.size() < 2) return 0;
  const double w = std::numbers::pi / ((zeros[1] - zeros[0]) * drop.step_s);
  return drop.moving_mass_kg * w * w;
}

// Found by random search: of little more than one period with Q 3.25, a wrong oscillation with a
// drift leaves 9 % of the amplitude.
TEST(HardCasesFit, DropsOfLittleMoreThanOnePeriod) {
  int answered = 0, wrong = 0, naive_wrong = 0;
  for (const double samples : {30.0, 39.88, 56.51}) {
    for (int k = 0; k < 21; ++k) {
      const tests::SyntheticDrop drop = tests::HeavilyDampedDrop(0.95 + 0.1 * k, samples);
      const fit::ImpulseRecord record = tests::MakeRecord(drop);
      const double truth = drop.stiffness_n_per_m;
      naive_wrong += std::abs(StiffnessOfZeros(record, drop) - truth) > 0.02 * truth ? 1 : 0;
      const auto fitted = fit::FitDropTest({record}, tests::ThesisKnowns());
      if (!fitted || fitted->findings.Refused()) continue;
      ++answered;
      const fit::FittedValue& stiffness = fitted->stiffness;
      const double off = std::abs(stiffness.value - truth);
      wrong += off > 5 * stiffness.combined_standard_uncertainty ? 1 : 0;
    }
  }
  // what shows two periods is answered
  ASSERT_GT(answered, 13);
  Check({"fit", "63 drops of one to three periods with Q 3.25: wrong answers",
         "another oscillation with a drift fits as well", "half a period between zeros, to 2 %", 0},
        {0, static_cast<double>(wrong), static_cast<double>(naive_wrong)});
}

// ---------------------------------------------------------------- impedance and skin

// bars: rounding of the points, 1e-16, times a condition of 1e5

TEST(HardCasesFit, DampingFromAnImpedance) {
  // R + j w L + Km^2 j w / (Kv - w^2 M + j w Bv)
  std::vector<fit::ImpedancePoint> points;
  for (int k = 0; k < 300; ++k) {
    const double hz = 100 * std::pow(5, k / 299.0), w = 2 * std::numbers::pi * hz;
    const std::complex<double> motion(kKv - w * w * kMassKg, w * kBv);
    points.push_back(
        {hz, std::complex(kCoilOhm, w * kHenry) + std::complex(0.0, kKm * kKm * w) / motion});
  }
  const auto fitted = fit::FitImpedance(points, Knowns(), fit::CaseCondition::kHeld, "z.csv");
  ASSERT_TRUE(fitted.has_value());
  // M times the width of |Z| at 1/sqrt(2) of its peak, between points in a straight line
  double peak = 0, width_hz = 0;
  for (const auto& point : points) peak = std::fmax(peak, std::abs(point.ohm));
  for (std::size_t k = 1; k < points.size(); ++k) {
    const double before = std::abs(points[k - 1].ohm) - peak / std::numbers::sqrt2;
    const double after = std::abs(points[k].ohm) - peak / std::numbers::sqrt2;
    if (before * after >= 0) continue;
    const double place = before / (before - after);
    const double hz = std::lerp(points[k - 1].frequency_hz, points[k].frequency_hz, place);
    width_hz += before < 0 ? -hz : hz;
  }
  Check({"fit", "Bv from 300 points of an impedance", "the coil's resistance lies below the peak",
         "mass times the width of |Z| at 1/sqrt(2)", 1e-11},
        {Long(kBv), fitted->damping.value, kMassKg * 2 * std::numbers::pi * width_hz});
}

TEST(HardCasesFit, SkinUnderAnActuator) {
  // Lindsay 2013, equations 2.1-2.3, in long double: displacement over current, skin of 1 g
  using Complex = std::complex<long double>;
  const long double ks = 1861.7L, bs = 2.2189L, mass = 0.6e-3L + 1e-3L;
  fit::SkinSweep sweep{.name = "skin.csv", .area_m2 = {}, .points = {}};
  for (int k = 0; k < 30; ++k) {
    const double hz = 30 * std::pow(20, k / 29.0);
    const long double w = 2 * std::numbers::pi_v<long double> * static_cast<long double>(hz);
    const Complex spring(2800, w * 0.0322L), moving = w * w * 1.4e-3L;
    const Complex skin = Complex(ks - w * w * mass, w * bs);
    const Complex motion = moving / (skin * (spring - moving) - moving * spring);
    sweep.points.push_back({.frequency_hz = hz,
                            .displacement_m = 0.1 * static_cast<double>(std::abs(motion)),
                            .drive = 0.1});
  }
  const auto actuator = sim::FindActuator("thesis-c10-100");
  ASSERT_TRUE(actuator.has_value());
  const auto fitted = fit::FitSkin(sweep, *actuator);
  ASSERT_TRUE(fitted.has_value());
  // both masses times the square of the angular frequency of the largest displacement
  const auto& largest =
      *std::ranges::max_element(sweep.points, {}, &fit::SkinPoint::displacement_m);
  const double naive = 2e-3 * std::pow(2 * std::numbers::pi * largest.frequency_hz, 2);
  Check({"fit", "skin's stiffness from amplitudes of 30 to 600 Hz",
         "the actuator moves with it, and phases are not measured",
         "masses times the largest displacement's w^2", 1e-10},
        {ks, fitted->stiffness.value, naive});
}

}  // namespace
}  // namespace haptometer::hard_cases
