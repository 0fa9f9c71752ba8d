#include "fit/ring_down_problem.h"

#include <ceres/jet.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "base/check.h"
#include "fit/ringing_moments.h"
#include "sim/ring_down.h"

namespace haptometer::fit {
namespace {

// the parameters behind which derivatives are automatic, up to the circuit's numbers
constexpr std::size_t kRingingCount = Index(Own::kDrift);
constexpr int kAutomatic = static_cast<int>(kSharedCount + kRingingCount);
using Jet = ceres::Jet<double, kAutomatic>;

Jet RingingMass(const RingDownSamples& record, const Jet* shared) {
  return record.mass_ratio * exp(shared[Index(Shared::kMass)]) + record.added_mass_kg;
}

// the circuit of one record from logarithmic parameters
sim::RingDown<Jet> Circuit(const RingDownSamples& record, double inductance_h, const Jet* shared) {
  return sim::RingDown<Jet>(
      {.stiffness_n_per_m = exp(shared[Index(Shared::kStiffness)]),
       .damping_n_s_per_m = exp(shared[Index(Shared::kDamping)]),
       .force_constant_squared_n2_per_a2 = shared[Index(Shared::kForceConstantSquared)],
       .mass_kg = RingingMass(record, shared),
       .coil_resistance_ohm = exp(shared[Index(Shared::kResistance)]),
       .inductance_h = inductance_h,
       .load_ohm = record.load_ohm});
}

// what the shape is multiplied by; not a number where a given speed meets an impossible Km^2
Jet Amplitude(const RingDownSamples& record, const Jet* shared, const Jet* own) {
  const Jet& square = shared[Index(Shared::kForceConstantSquared)];
  if (record.signal == RingingSignal::kReleaseVoltage) {
    return record.release_current_a * square / RingingMass(record, shared);
  }
  if (record.speed_m_per_s == 0) return exp(own[Index(Own::kAmplitude)]);
  return record.speed_m_per_s * sqrt(square);
}

// below 0 at first, as the thesis has it of the voltage (equation 2.1)
sim::RingingShape<Jet> Shape(RingingSignal signal, const sim::RingDown<Jet>& circuit) {
  if (signal == RingingSignal::kBlowVoltage) return circuit.voltage();
  if (signal == RingingSignal::kReleaseVoltage) return circuit.release();
  const auto& displacement = circuit.displacement();
  return {-displacement.even, -displacement.odd, -displacement.electrical};
}

// what one volt (or volt per second) of each disturbance adds at a time
struct Disturbances {
  explicit Disturbances(const RingDownSamples& record)
      : middle_s(0.5 * (record.times_s.front() + record.times_s.back())),
        hum_rad_per_s(2 * std::numbers::pi * record.hum_hz) {}

  [[nodiscard]] std::array<double, 3> At(double time_s) const {
    if (hum_rad_per_s == 0) return {time_s - middle_s, 1, 0};
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

// A record's ringing at a point: offset - (even E + odd O + electrical e^(-p t)), and its
// derivatives. The blow's direction is such that the first half period has the record's polarity.
class Ringing {
 public:
  Ringing(const RingDownSamples& record, double inductance_h, const Jets& jets)
      : circuit_(Circuit(record, inductance_h, jets.shared.data())),
        impact_s_(jets.own[Index(Own::kImpact)].a),
        offset_v_(jets.own[Index(Own::kOffset)].a),
        per_time_scale_(1 / record.time_scale),
        moments_(circuit_.decay_per_s().a, circuit_.stiffness_per_s2().a,
                 circuit_.electrical_rate_per_s().a, record.step_s / record.time_scale) {
    const Jet amplitude = record.polarity * Amplitude(record, jets.shared.data(), jets.own.data());
    const auto shape = Shape(record.signal, circuit_);
    even_ = amplitude * shape.even;
    odd_ = amplitude * shape.odd;
    electrical_ = amplitude * shape.electrical;
  }

  // to the next sample's time
  void MoveTo(double time_s) { moment_ = moments_.At((time_s - impact_s_) * per_time_scale_); }
  [[nodiscard]] double voltage() const {
    return offset_v_ -
           (even_.a * moment_.even + odd_.a * moment_.odd + electrical_.a * moment_.electrical);
  }

  // times `weight`: the shared parameters' at `row`, the ringing's own from `row + first` on
  void WriteDerivatives(double weight, std::size_t first, double* row) const {
    const RingingSlopes slopes = moments_.SlopesAt(moment_);
    const double by_decay = even_.a * slopes.even_by_decay + odd_.a * slopes.odd_by_decay;
    const double by_stiffness =
        even_.a * slopes.even_by_stiffness + odd_.a * slopes.odd_by_stiffness;
    const double by_electrical_rate = -electrical_.a * moment_.since_s * moment_.electrical;
    const auto by = [&](int k) {
      return -weight *
             (even_.v[k] * moment_.even + odd_.v[k] * moment_.odd +
              electrical_.v[k] * moment_.electrical + by_decay * circuit_.decay_per_s().v[k] +
              by_stiffness * circuit_.stiffness_per_s2().v[k] +
              by_electrical_rate * circuit_.electrical_rate_per_s().v[k]);
    };
    for (int k = 0; k < static_cast<int>(kSharedCount); ++k) row[k] = by(k);
    row[first + Index(Own::kAmplitude)] =
        by(static_cast<int>(kSharedCount + Index(Own::kAmplitude)));
    const double by_time = even_.a * slopes.even_by_time + odd_.a * slopes.odd_by_time -
                           circuit_.electrical_rate_per_s().a * electrical_.a * moment_.electrical;
    row[first + Index(Own::kImpact)] = weight * by_time * per_time_scale_;
    row[first + Index(Own::kOffset)] = weight;
  }

 private:
  sim::RingDown<Jet> circuit_;
  Jet even_;
  Jet odd_;
  Jet electrical_;
  double impact_s_;
  double offset_v_;
  double per_time_scale_;
  RingingMoments moments_;
  RingingMoment moment_;
};

// Where one record's rows go.
struct RecordRows {
  std::span<double> residuals;
  double* derivatives = nullptr;  // the first row's; null where none are asked for
  std::size_t columns = 0;        // of a row
  std::size_t first = 0;          // the record's own
};

// false, a rejected step, where a trial point is so far away that the voltage overflows
bool WriteRows(const RingDownSamples& record, double inductance_h, const double* shared,
               const double* own, const RecordRows& rows) {
  Ringing ringing(record, inductance_h, MakeJets(shared, own));
  const Disturbances disturbances(record);
  for (std::size_t n = 0; n < record.times_s.size(); ++n) {
    const double time_s = record.times_s[n];
    const double weight =
        (record.root_weights.empty() ? 1 : record.root_weights[n]) / record.noise_v;
    ringing.MoveTo(time_s);
    const double model_v = ringing.voltage() + disturbances.Sum(own, time_s);
    rows.residuals[n] = (model_v - record.voltages_v[n]) * weight;
    if (!std::isfinite(rows.residuals[n])) return false;
    if (rows.derivatives == nullptr) continue;
    double* row = rows.derivatives + n * rows.columns;
    std::fill_n(row, rows.columns, 0.0);
    ringing.WriteDerivatives(weight, rows.first, row);
    const auto disturbance = disturbances.At(time_s);
    for (std::size_t k = 0; k < disturbance.size(); ++k) {
      row[rows.first + kRingingCount + k] = disturbance[k] * weight;
    }
  }
  return true;
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
      RecordRows out{.residuals = residuals.subspan(row, rows), .columns = columns, .first = first};
      if (!jacobian.empty()) out.derivatives = jacobian.data() + row * columns;
      if (!WriteRows(records_[r], inductance_h_, point.data(), point.data() + first, out)) {
        return false;
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

bool RingDownProblem::IsDefined(const RingDownPoint& point) const {
  std::vector<double> residuals(RowCount(records_));
  return Whole().evaluate(ToColumns(point), residuals, {});
}

std::vector<double> RingDownProblem::Residuals(const RingDownPoint& point) const {
  std::vector<double> residuals(RowCount(records_));
  Whole().evaluate(ToColumns(point), residuals, {});
  return residuals;
}

std::vector<double> RingDownProblem::Voltages(const RingDownPoint& point, std::size_t record,
                                              const std::vector<double>& times_s) const {
  const double* own = point.own[record].data();
  Ringing ringing(records_[record], inductance_h_, MakeJets(point.shared.data(), own));
  const Disturbances disturbances(records_[record]);
  std::vector<double> voltages(times_s.size());
  for (std::size_t n = 0; n < times_s.size(); ++n) {
    ringing.MoveTo(times_s[n]);
    voltages[n] = ringing.voltage() + disturbances.Sum(own, times_s[n]);
  }
  return voltages;
}

RecordPoles RingDownProblem::Poles(const RingDownPoint& point, std::size_t record) const {
  const Jets jets = MakeJets(point.shared.data(), point.own[record].data());
  const auto circuit = Circuit(records_[record], inductance_h_, jets.shared.data());
  RecordPoles poles{{circuit.decay_per_s().a, circuit.stiffness_per_s2().a}};
  for (std::size_t k = 0; k < kSharedCount; ++k) {
    poles.decay_slopes[k] = circuit.decay_per_s().v[static_cast<int>(k)];
    poles.stiffness_slopes[k] = circuit.stiffness_per_s2().v[static_cast<int>(k)];
  }
  return poles;
}

}  // namespace haptometer::fit
