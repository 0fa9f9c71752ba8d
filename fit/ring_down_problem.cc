#include "fit/ring_down_problem.h"

#include <ceres/jet.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "base/check.h"
#include "fit/condensed_record.h"
#include "fit/ringing_moments.h"
#include "fit/row_reduction.h"
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

using Parts = Eigen::Matrix<double, static_cast<int>(kPartCount), 1>;
// a record's own parameters follow the shared ones
constexpr std::size_t kParameters = kSharedCount + kOwnCount;
using PartSlopes =
    Eigen::Matrix<double, static_cast<int>(kPartCount), static_cast<int>(kParameters)>;

Parts Unit(Part part) { return Parts::Unit(static_cast<Eigen::Index>(part)); }

// A record's ringing at a point: offset - (even E + odd O + electrical e^(-p t)). The blow's
// direction is such that the first half period has the record's polarity.
class Ringing {
 public:
  Ringing(const RingDownSamples& record, double inductance_h, const double* shared,
          const double* own)
      : Ringing(record, inductance_h, MakeJets(shared, own), own) {}

  [[nodiscard]] RingingRates rates() const {
    return {.decay_per_s = circuit_.decay_per_s().a,
            .stiffness_per_s2 = circuit_.stiffness_per_s2().a,
            .electrical_rate_per_s = circuit_.electrical_rate_per_s().a,
            .impact_s = own_[Index(Own::kImpact)]};
  }

  [[nodiscard]] double discriminant_per_s2() const {
    const double d = circuit_.decay_per_s().a;
    return d * d - circuit_.stiffness_per_s2().a;
  }

  // the voltage as a sum of parts
  [[nodiscard]] Parts voltage() const {
    return even_.a * Unit(Part::kEven) + odd_.a * Unit(Part::kOdd) +
           electrical_.a * Unit(Part::kElectrical) +
           own_[Index(Own::kOffset)] * Unit(Part::kConstant) +
           own_[Index(Own::kDrift)] * Unit(Part::kDrift) +
           own_[Index(Own::kHumCosine)] * Unit(Part::kHumCosine) +
           own_[Index(Own::kHumSine)] * Unit(Part::kHumSine);
  }

  // and its derivative by each parameter
  [[nodiscard]] PartSlopes slopes() const {
    const double d = circuit_.decay_per_s().a;
    const double discriminant = discriminant_per_s2();
    const double rate = circuit_.electrical_rate_per_s().a;
    const Parts by_decay = -even_.a * Unit(Part::kTimesEven) +
                           (d * even_.a - odd_.a) * Unit(Part::kTimesOdd) +
                           2 * d * odd_.a * Unit(Part::kByDiscriminant);
    const Parts by_stiffness =
        -0.5 * even_.a * Unit(Part::kTimesOdd) - odd_.a * Unit(Part::kByDiscriminant);
    const Parts by_rate = -electrical_.a * Unit(Part::kTimesElectrical);
    const Parts by_time = (odd_.a - d * even_.a) * Unit(Part::kEven) +
                          (discriminant * even_.a - d * odd_.a) * Unit(Part::kOdd) -
                          rate * electrical_.a * Unit(Part::kElectrical);
    PartSlopes slopes;
    for (int k = 0; k < kAutomatic; ++k) {
      slopes.col(k) = even_.v[k] * Unit(Part::kEven) + odd_.v[k] * Unit(Part::kOdd) +
                      electrical_.v[k] * Unit(Part::kElectrical) +
                      circuit_.decay_per_s().v[k] * by_decay +
                      circuit_.stiffness_per_s2().v[k] * by_stiffness +
                      circuit_.electrical_rate_per_s().v[k] * by_rate;
    }
    const auto own = [&slopes](Own parameter) {
      return slopes.col(static_cast<Eigen::Index>(kSharedCount + Index(parameter)));
    };
    own(Own::kImpact) = -per_time_scale_ * by_time;
    own(Own::kOffset) = Unit(Part::kConstant);
    own(Own::kDrift) = Unit(Part::kDrift);
    own(Own::kHumCosine) = Unit(Part::kHumCosine);
    own(Own::kHumSine) = Unit(Part::kHumSine);
    return slopes;
  }

 private:
  Ringing(const RingDownSamples& record, double inductance_h, const Jets& jets, const double* own)
      : circuit_(Circuit(record, inductance_h, jets.shared.data())),
        per_time_scale_(1 / record.time_scale),
        own_(own, kOwnCount) {
    const Jet amplitude = -record.polarity * Amplitude(record, jets.shared.data(), jets.own.data());
    const auto shape = Shape(record.signal, circuit_);
    even_ = amplitude * shape.even;
    odd_ = amplitude * shape.odd;
    electrical_ = amplitude * shape.electrical;
  }

  sim::RingDown<Jet> circuit_;
  Jet even_;
  Jet odd_;
  Jet electrical_;
  double per_time_scale_;
  std::span<const double> own_;
};

// The parts at one sample after another.
class PartsAt {
 public:
  PartsAt(const RingDownSamples& record, const RingingRates& rates)
      : recording_(record),
        impact_s_(rates.impact_s),
        per_time_scale_(1 / record.time_scale),
        moments_(rates.decay_per_s, rates.stiffness_per_s2, rates.electrical_rate_per_s,
                 record.step_s / record.time_scale) {}

  // `complete`: those that only derivatives need, too
  const Parts& At(double time_s, bool complete) {
    const RingingMoment moment = moments_.At((time_s - impact_s_) * per_time_scale_);
    const auto [t, even, odd, electrical] = moment;
    const auto [drift, cosine, sine] = recording_.At(time_s);
    const double by_discriminant = complete ? moments_.OddByDiscriminant(moment) : 0;
    parts_ << even, odd, t * even, t * odd, by_discriminant, electrical, t * electrical, 1, drift,
        cosine, sine;
    return parts_;
  }

 private:
  RecordingParts recording_;
  double impact_s_;
  double per_time_scale_;
  RingingMoments moments_;
  Parts parts_;
};

using ParameterRow = Eigen::Matrix<double, 1, static_cast<int>(kParameters)>;

// Where one record's rows go.
struct RecordRows {
  std::span<double> residuals;
  double* derivatives = nullptr;  // the first row's; null where none are asked for
  std::size_t columns = 0;        // of a row
  std::size_t first = 0;          // the record's own

  // one row's derivatives by the shared parameters and the record's own; 0 by all others'
  void Write(std::size_t n, const ParameterRow& slopes) const {
    double* row = derivatives + n * columns;
    std::fill_n(row, columns, 0.0);
    std::copy_n(slopes.data(), kSharedCount, row);
    std::copy_n(slopes.data() + kSharedCount, kOwnCount, row + first);
  }
};

// false, a rejected step, where a trial point is so far away that the voltage overflows
bool WriteRows(const RingDownSamples& record, const Ringing& ringing, const RecordRows& rows) {
  const Parts voltage = ringing.voltage();
  const PartSlopes slopes = ringing.slopes();
  PartsAt parts(record, ringing.rates());
  for (std::size_t n = 0; n < record.times_s.size(); ++n) {
    const double weight =
        (record.root_weights.empty() ? 1 : record.root_weights[n]) / record.noise_v;
    const Parts& here = parts.At(record.times_s[n], rows.derivatives != nullptr);
    rows.residuals[n] = (voltage.dot(here) - record.voltages_v[n]) * weight;
    if (!std::isfinite(rows.residuals[n])) return false;
    if (rows.derivatives == nullptr) continue;
    rows.Write(n, weight * (here.transpose() * slopes));
  }
  return true;
}

// a record's rows as few that have the same squares and products
constexpr std::size_t kCondensedRows = kParameters + 1;

// T times the voltage's parts less its last column, and T times their slopes: T'T = [F y]'[F y]
bool WriteByParts(const CondensedRecord& condensed, const Ringing& ringing,
                  const RecordRows& rows) {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto size = static_cast<Eigen::Index>(condensed.parts.size()) + 1;
  const Eigen::Map<const RowMajor> all(condensed.rows.data(), size, size);
  const double discriminant = ringing.discriminant_per_s2();
  // dO/d(d^2 - q) = (t E - O)/(2 (d^2 - q))
  const auto expressed = [&](auto coefficients) {
    const auto by_discriminant =
        (coefficients.row(static_cast<Eigen::Index>(Part::kByDiscriminant)) / (2 * discriminant))
            .eval();
    coefficients.row(static_cast<Eigen::Index>(Part::kTimesEven)) += by_discriminant;
    coefficients.row(static_cast<Eigen::Index>(Part::kOdd)) -= by_discriminant;
    RowMajor used(size - 1, coefficients.cols());
    for (Eigen::Index k = 0; k + 1 < size; ++k) {
      used.row(k) =
          coefficients.row(static_cast<Eigen::Index>(condensed.parts[static_cast<std::size_t>(k)]));
    }
    return used;
  };
  Eigen::Map<Eigen::VectorXd> residuals(rows.residuals.data(), std::ssize(rows.residuals));
  residuals.setZero();
  residuals.head(size) = all.leftCols(size - 1) * expressed(ringing.voltage()) - all.col(size - 1);
  if (!residuals.allFinite()) return false;
  if (rows.derivatives == nullptr) return true;
  const RowMajor slopes = all.leftCols(size - 1) * expressed(ringing.slopes());
  for (Eigen::Index k = 0; k < std::ssize(rows.residuals); ++k) {
    if (k < size) {
      rows.Write(static_cast<std::size_t>(k), slopes.row(k));
    } else {
      rows.Write(static_cast<std::size_t>(k), ParameterRow::Zero());
    }
  }
  return true;
}

// all rows, reduced
bool WriteReduced(const RingDownSamples& record, const Ringing& ringing, const RecordRows& rows) {
  const std::size_t samples = record.times_s.size();
  std::vector<double> residuals(samples);
  std::vector<double> derivatives(rows.derivatives == nullptr ? 0 : samples * kParameters);
  const RecordRows whole{.residuals = residuals,
                         .derivatives = rows.derivatives == nullptr ? nullptr : derivatives.data(),
                         .columns = kParameters,
                         .first = kSharedCount};
  if (!WriteRows(record, ringing, whole)) return false;
  std::ranges::fill(rows.residuals, 0.0);
  if (rows.derivatives == nullptr) {
    rows.residuals[0] =
        Eigen::Map<const Eigen::VectorXd>(residuals.data(), std::ssize(residuals)).norm();
    return true;
  }
  std::vector<std::size_t> all(kParameters);
  std::iota(all.begin(), all.end(), std::size_t{0});
  const auto reduced = ReduceRows({derivatives, kParameters, residuals}, all);
  for (std::size_t k = 0; k < kCondensedRows; ++k) {
    const double* row = reduced.data() + k * kCondensedRows;
    rows.Write(k, Eigen::Map<const ParameterRow>(row));
    rows.residuals[k] = row[kParameters];
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
      const Ringing ringing(records_[r], inductance_h_, point.data(), point.data() + first);
      if (!WriteRows(records_[r], ringing, out)) return false;
      row += rows;
    }
    return true;
  };
  return {RowCount(records_), columns, evaluate};
}

LeastSquares RingDownProblem::Condensed() const {
  const std::size_t columns = kSharedCount + kOwnCount * records_.size();
  std::vector<std::vector<Stretch>> stretches;
  stretches.reserve(records_.size());
  for (const RingDownSamples& record : records_) stretches.push_back(StretchesOf(record));
  const auto evaluate = [this, columns, stretches = std::move(stretches)](
                            std::span<const double> point, std::span<double> residuals,
                            std::span<double> jacobian) {
    for (std::size_t r = 0; r < records_.size(); ++r) {
      const std::size_t first = Column(r, Own::kAmplitude);
      RecordRows out{.residuals = residuals.subspan(r * kCondensedRows, kCondensedRows),
                     .columns = columns,
                     .first = first};
      if (!jacobian.empty()) out.derivatives = jacobian.data() + r * kCondensedRows * columns;
      const Ringing ringing(records_[r], inductance_h_, point.data(), point.data() + first);
      const bool is_defined =
          CanBeCondensed(records_[r], ringing.rates())
              ? WriteByParts(CondenseRecord(records_[r], stretches[r], ringing.rates()), ringing,
                             out)
              : WriteReduced(records_[r], ringing, out);
      if (!is_defined) return false;
    }
    return true;
  };
  return {kCondensedRows * records_.size(), columns, evaluate};
}

SolverReport RingDownProblem::Minimise(const std::vector<bool>& is_free,
                                       RingDownPoint* point) const {
  HAPTOMETER_CHECK(point->own.size() == records_.size(), "{} records, {} points", records_.size(),
                   point->own.size());
  std::vector<double> columns = ToColumns(*point);
  const SolverReport report = fit::Minimise(Condensed(), is_free, &columns);
  *point = FromColumns(columns);
  return report;
}

Jacobian RingDownProblem::Linearise(const RingDownPoint& point) const {
  return fit::Linearise(Whole(), ToColumns(point));
}

Jacobian RingDownProblem::Condense(const RingDownPoint& point) const {
  return fit::Linearise(Condensed(), ToColumns(point));
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
  const Ringing ringing(records_[record], inductance_h_, point.shared.data(),
                        point.own[record].data());
  const Parts voltage = ringing.voltage();
  PartsAt parts(records_[record], ringing.rates());
  std::vector<double> voltages(times_s.size());
  std::ranges::transform(times_s, voltages.begin(),
                         [&](double time_s) { return voltage.dot(parts.At(time_s, false)); });
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
