#include "fit/ring_fit.h"

#include <Eigen/QR>
#include <cmath>
#include <numbers>
#include <span>

#include "base/check.h"
#include "fit/ringing_moments.h"
#include "sim/ring_down.h"

namespace haptometer::fit {
namespace {

constexpr std::size_t kPoleParameters = 2;
constexpr std::size_t kEven = kPoleParameters;
constexpr std::size_t kOdd = kEven + 1;
constexpr std::size_t kOffset = kOdd + 1;

// the columns behind offset that do not depend on the poles
class Background {
 public:
  Background(const RingSamples& samples, const RingBackground& background)
      : first_s_(samples.times_s.front()),
        length_s_(samples.times_s.back() - first_s_),
        hum_rad_per_s_(2 * std::numbers::pi * background.hum_hz),
        drifts_(background.drifts) {}

  [[nodiscard]] std::size_t count() const {
    return (drifts_ ? 1U : 0U) + (hum_rad_per_s_ > 0 ? 2U : 0U);
  }
  void Write(double time_s, double* columns) const {
    if (drifts_) *columns++ = (time_s - first_s_) / length_s_ - 0.5;
    if (hum_rad_per_s_ <= 0) return;
    columns[0] = std::cos(hum_rad_per_s_ * time_s);
    columns[1] = std::sin(hum_rad_per_s_ * time_s);
  }

 private:
  double first_s_;
  double length_s_;
  double hum_rad_per_s_;
  bool drifts_;
};

// row n of the linear columns: even, odd, 1, background
void WriteColumns(const PolePair& poles, const Background& background, double since_s,
                  double time_s, double* columns) {
  const auto pair = sim::DampedFundamentals(poles.decay_per_s, poles.stiffness_per_s2, since_s);
  columns[0] = pair.even;
  columns[1] = pair.odd;
  columns[2] = 1;
  background.Write(time_s, columns + 3);
}

std::vector<double> StartPoint(const RingSamples& samples, const PolePair& poles,
                               const Background& background) {
  const auto linear = static_cast<Eigen::Index>(3 + background.count());
  const auto rows = static_cast<Eigen::Index>(samples.values_v.size());
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> columns(rows, linear);
  for (Eigen::Index n = 0; n < rows; ++n) {
    const double time_s = samples.times_s[static_cast<std::size_t>(n)];
    WriteColumns(poles, background, time_s - samples.times_s.front(), time_s,
                 columns.row(n).data());
  }
  const Eigen::Map<const Eigen::VectorXd> values(samples.values_v.data(), rows);
  const Eigen::VectorXd fitted = columns.colPivHouseholderQr().solve(values);
  std::vector<double> point{std::log(poles.decay_per_s), std::log(poles.stiffness_per_s2)};
  point.insert(point.end(), fitted.begin(), fitted.end());
  return point;
}

bool Evaluate(const RingSamples& samples, const Background& background,
              std::span<const double> point, std::span<double> residuals,
              std::span<double> jacobian) {
  const double decay = std::exp(point[0]);
  const double stiffness = std::exp(point[1]);
  RingingMoments moments(decay, stiffness, 0, samples.step_s);
  std::vector<double> columns(point.size() - kPoleParameters);
  for (std::size_t n = 0; n < residuals.size(); ++n) {
    const RingingMoment moment = moments.At(samples.times_s[n] - samples.times_s.front());
    columns[0] = moment.even;
    columns[1] = moment.odd;
    columns[2] = 1;
    background.Write(samples.times_s[n], columns.data() + 3);
    residuals[n] = -samples.values_v[n];
    for (std::size_t k = 0; k < columns.size(); ++k) {
      residuals[n] += point[kPoleParameters + k] * columns[k];
    }
    if (!std::isfinite(residuals[n])) return false;
    if (jacobian.empty()) continue;
    const RingingSlopes slopes = moments.SlopesAt(moment);
    double* row = jacobian.data() + n * point.size();
    row[0] = decay * (point[kEven] * slopes.even_by_decay + point[kOdd] * slopes.odd_by_decay);
    row[1] = stiffness *
             (point[kEven] * slopes.even_by_stiffness + point[kOdd] * slopes.odd_by_stiffness);
    std::ranges::copy(columns, row + kPoleParameters);
  }
  return true;
}

}  // namespace

RingSamples BlocksOf(const ImpulseRecord& record, std::size_t first, std::size_t end,
                     std::size_t block) {
  RingSamples samples;
  samples.step_s = static_cast<double>(block) * record.step_s;
  for (std::size_t n = first; n + block <= end; n += block) {
    double sum = 0;
    for (std::size_t k = n; k < n + block; ++k) sum += record.voltage_v[k];
    if (!std::isfinite(sum)) continue;
    const double middle = static_cast<double>(n) + 0.5 * static_cast<double>(block - 1);
    samples.times_s.push_back(record.start_s + middle * record.step_s);
    samples.values_v.push_back(sum / static_cast<double>(block));
  }
  return samples;
}

double RingFit::Envelope(double since_s) const {
  // E = e^(-d t) cos(w t) and O = e^(-d t) sin(w t) / w, w^2 = q - d^2
  const double square = poles.stiffness_per_s2 - poles.decay_per_s * poles.decay_per_s;
  const double quadrature = square > 0 ? odd_v_per_s / std::sqrt(square) : 0;
  return std::hypot(even_v, quadrature) * std::exp(-poles.decay_per_s * since_s);
}

RingFit FitRing(const RingSamples& samples, const PolePair& start,
                const RingBackground& background) {
  HAPTOMETER_CHECK(samples.values_v.size() >= 16, "{} samples", samples.values_v.size());
  const Background columns(samples, background);
  std::vector<double> point = StartPoint(samples, start, columns);
  const LeastSquares problem{
      samples.values_v.size(), point.size(),
      [&](std::span<const double> at, std::span<double> residuals, std::span<double> jacobian) {
        return Evaluate(samples, columns, at, residuals, jacobian);
      }};
  RingFit fit;
  fit.converged = Minimise(problem, std::vector<bool>(point.size(), true), &point).converged;
  fit.poles = {std::exp(point[0]), std::exp(point[1])};
  fit.even_v = point[kEven];
  fit.odd_v_per_s = point[kOdd];
  fit.offset_v = point[kOffset];
  std::size_t next = kOffset + 1;
  if (background.drifts) fit.drift_v = point[next++];
  if (background.hum_hz > 0) fit.hum_v = std::hypot(point[next], point[next + 1]);
  fit.jacobian = Linearise(problem, point);
  return fit;
}

}  // namespace haptometer::fit
