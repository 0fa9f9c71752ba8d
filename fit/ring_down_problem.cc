#include "fit/ring_down_problem.h"

#include <ceres/jet.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "base/check.h"
#include "sim/ring_down.h"

namespace haptometer::fit {
namespace {

// the circuit of one record from logarithmic parameters
template <typename T>
sim::RingDown<T> Circuit(const RingDownSamples& record, double inductance_h, const T* shared) {
  using std::exp;
  return sim::RingDown<T>(
      {.stiffness_n_per_m = exp(shared[Index(Shared::kStiffness)]),
       .damping_n_s_per_m = exp(shared[Index(Shared::kDamping)]),
       .force_constant_squared_n2_per_a2 = shared[Index(Shared::kForceConstantSquared)],
       .mass_kg = record.mass_ratio * exp(shared[Index(Shared::kMass)]) + record.added_mass_kg,
       .coil_resistance_ohm = exp(shared[Index(Shared::kResistance)]),
       .inductance_h = inductance_h,
       .load_ohm = record.load_ohm});
}

// what the ratio is multiplied by; not a number where a given speed meets an impossible Km^2
template <typename T>
T Amplitude(const RingDownSamples& record, const T* shared, const T* own) {
  using std::exp;
  using std::sqrt;
  if (record.ringing == Ringing::kReleaseVoltage) {
    const T mass_kg = record.mass_ratio * exp(shared[Index(Shared::kMass)]) + record.added_mass_kg;
    return record.release_current_a * shared[Index(Shared::kForceConstantSquared)] / mass_kg;
  }
  if (record.speed_m_per_s == 0) return exp(own[Index(Own::kAmplitude)]);
  return record.speed_m_per_s * sqrt(shared[Index(Shared::kForceConstantSquared)]);
}

// below 0 at first, as the thesis has it of the voltage (equation 2.1)
template <typename T>
T Ratio(Ringing ringing, const sim::RingDown<T>& circuit, const T& time_s) {
  if (ringing == Ringing::kBlowVoltage) return circuit.VoltageRatio(time_s);
  if (ringing == Ringing::kReleaseVoltage) return circuit.ReleaseRatio(time_s);
  return -circuit.DisplacementRatio(time_s);
}

// the ringing and the offset; the blow's direction is such that the first half period has
// `polarity`
template <typename T>
T RingingAt(const RingDownSamples& record, const sim::RingDown<T>& circuit,
            const T& signed_amplitude, const T* own, double time_s) {
  const T since_impact_s = (time_s - own[Index(Own::kImpact)]) / record.time_scale;
  return own[Index(Own::kOffset)] -
         signed_amplitude * Ratio(record.ringing, circuit, since_impact_s);
}

// what one volt (or volt per second) of each disturbance adds at a time
struct Disturbances {
  explicit Disturbances(const RingDownSamples& record)
      : middle_s(0.5 * (record.times_s.front() + record.times_s.back())),
        hum_rad_per_s(2 * std::numbers::pi * record.hum_hz) {}

  [[nodiscard]] std::array<double, 3> At(double time_s) const {
    return {time_s - middle_s, std::cos(hum_rad_per_s * time_s), std::sin(hum_rad_per_s * time_s)};
  }
  [[nodiscard]] double Sum(const double* own, double time_s) const {
    const auto [drift, cosine, sine] = At(time_s);
    return own[Index(Own::kDrift)] * drift + own[Index(Own::kHumCosine)] * cosine +
           own[Index(Own::kHumSine)] * sine;
  }

  double middle_s;
  double hum_rad_per_s;
};

// false, a rejected step, where a trial point is so far away that the voltage overflows
bool WriteResiduals(const RingDownSamples& record, double inductance_h, const double* shared,
                    const double* own, std::span<double> residuals) {
  const auto circuit = Circuit(record, inductance_h, shared);
  const double signed_amplitude = record.polarity * Amplitude(record, shared, own);
  const Disturbances disturbances(record);
  for (std::size_t n = 0; n < record.times_s.size(); ++n) {
    const double time_s = record.times_s[n];
    const double model_v =
        RingingAt(record, circuit, signed_amplitude, own, time_s) + disturbances.Sum(own, time_s);
    residuals[n] = (model_v - record.voltages_v[n]) / record.noise_v;
    if (!std::isfinite(residuals[n])) return false;
  }
  return true;
}

// the parameters behind which derivatives are automatic: all but the disturbances
constexpr std::size_t kRingingCount = Index(Own::kDrift);
constexpr int kAutomatic = static_cast<int>(kSharedCount + kRingingCount);
using Jet = ceres::Jet<double, kAutomatic>;

struct Jets {
  std::array<Jet, kSharedCount> shared;
  std::array<Jet, kRingingCount> own;
};

Jets MakeJets(const double* shared, const double* own) {
  Jets jets;
  for (std::size_t k = 0; k < kSharedCount; ++k)
    jets.shared[k] = Jet(shared[k], static_cast<int>(k));
  for (std::size_t k = 0; k < kRingingCount; ++k) {
    jets.own[k] = Jet(own[k], static_cast<int>(kSharedCount + k));
  }
  return jets;
}

// one record's rows: `rows` begins at the record's first row, `columns` wide; its own parameters
// begin at column `first`
void WriteDerivatives(const RingDownSamples& record, double inductance_h, const double* shared,
                      const double* own, std::size_t first, std::size_t columns, double* rows) {
  const Jets jets = MakeJets(shared, own);
  const auto circuit = Circuit(record, inductance_h, jets.shared.data());
  const Jet signed_amplitude =
      record.polarity * Amplitude(record, jets.shared.data(), jets.own.data());
  const Disturbances disturbances(record);
  for (std::size_t n = 0; n < record.times_s.size(); ++n) {
    double* row = rows + n * columns;
    std::fill_n(row, columns, 0.0);
    const Jet voltage =
        RingingAt(record, circuit, signed_amplitude, jets.own.data(), record.times_s[n]);
    for (std::size_t k = 0; k < kSharedCount; ++k) {
      row[k] = voltage.v[static_cast<int>(k)] / record.noise_v;
    }
    for (std::size_t k = 0; k < kRingingCount; ++k) {
      row[first + k] = voltage.v[static_cast<int>(kSharedCount + k)] / record.noise_v;
    }
    const auto disturbance = disturbances.At(record.times_s[n]);
    for (std::size_t k = 0; k < disturbance.size(); ++k) {
      row[first + kRingingCount + k] = disturbance[k] / record.noise_v;
    }
  }
}

std::size_t RowCount(const std::vector<RingDownSamples>& records) {
  std::size_t rows = 0;
  for (const auto& record : records) rows += record.times_s.size();
  return rows;
}

}  // namespace

std::vector<double> ToColumns(const RingDownPoint& point) {
  std::vector<double> columns(point.shared.begin(), point.shared.end());
  for (const auto& own : point.own) columns.insert(columns.end(), own.begin(), own.end());
  return columns;
}

RingDownPoint FromColumns(const std::vector<double>& columns) {
  RingDownPoint point;
  std::copy_n(columns.begin(), kSharedCount, point.shared.begin());
  point.own.resize((columns.size() - kSharedCount) / kOwnCount);
  for (std::size_t r = 0; r < point.own.size(); ++r) {
    std::copy_n(columns.begin() + static_cast<std::ptrdiff_t>(Column(r, Own::kAmplitude)),
                kOwnCount, point.own[r].begin());
  }
  return point;
}

RingDownProblem::RingDownProblem(std::vector<RingDownSamples> records, double inductance_h)
    : records_(std::move(records)), inductance_h_(inductance_h) {}

LeastSquares RingDownProblem::Whole() const {
  const std::size_t columns = kSharedCount + kOwnCount * records_.size();
  const auto evaluate = [this, columns](std::span<const double> point, std::span<double> residuals,
                                        std::span<double> jacobian) {
    std::size_t row = 0;
    for (std::size_t r = 0; r < records_.size(); ++r) {
      const std::size_t rows = records_[r].times_s.size();
      const std::size_t first = Column(r, Own::kAmplitude);
      const double* own = point.data() + first;
      if (!WriteResiduals(records_[r], inductance_h_, point.data(), own,
                          residuals.subspan(row, rows))) {
        return false;
      }
      if (!jacobian.empty()) {
        WriteDerivatives(records_[r], inductance_h_, point.data(), own, first, columns,
                         jacobian.data() + row * columns);
      }
      row += rows;
    }
    return true;
  };
  return {RowCount(records_), columns, evaluate};
}

SolverReport RingDownProblem::Minimise(const std::vector<bool>& is_free,
                                       RingDownPoint* point) const {
  HAPTOMETER_CHECK(point->own.size() == records_.size(), "{} records, {} points", records_.size(),
                   point->own.size());
  std::vector<double> columns = ToColumns(*point);
  const SolverReport report = fit::Minimise(Whole(), is_free, &columns);
  *point = FromColumns(columns);
  return report;
}

Jacobian RingDownProblem::Linearise(const RingDownPoint& point) const {
  return fit::Linearise(Whole(), ToColumns(point));
}

std::vector<double> RingDownProblem::Residuals(const RingDownPoint& point) const {
  std::vector<double> residuals(RowCount(records_));
  Whole().evaluate(ToColumns(point), residuals, {});
  return residuals;
}

std::vector<double> RingDownProblem::Voltages(const RingDownPoint& point, std::size_t record,
                                              const std::vector<double>& times_s) const {
  const auto circuit = Circuit(records_[record], inductance_h_, point.shared.data());
  const Disturbances disturbances(records_[record]);
  const double* own = point.own[record].data();
  const double signed_amplitude =
      records_[record].polarity * Amplitude(records_[record], point.shared.data(), own);
  std::vector<double> voltages(times_s.size());
  for (std::size_t n = 0; n < times_s.size(); ++n) {
    voltages[n] = RingingAt(records_[record], circuit, signed_amplitude, own, times_s[n]) +
                  disturbances.Sum(own, times_s[n]);
  }
  return voltages;
}

}  // namespace haptometer::fit
