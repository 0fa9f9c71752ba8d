#include "fit/drop_test/ring_down_problem.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <utility>

#include "base/error.h"
#include "base/mapped.h"
#include "fit/drop_test/condensed_record.h"
#include "fit/drop_test/ringing_model.h"

namespace haptometer::fit {
namespace {

// Where one record's rows go.
struct RecordRows {
  std::span<double> residuals;
  double* derivatives = nullptr;  // the first row's; null where none are needed
  std::size_t columns = 0;        // of a row
  std::size_t first = 0;          // the record's own

  // one row's derivatives by the shared parameters and the record's own; 0 by all others'
  void Write(std::size_t n, const double* slopes) const {
    double* row = derivatives + n * columns;
    std::fill_n(row, columns, 0.0);
    std::copy_n(slopes, kSharedCount, row);
    std::copy_n(slopes + kSharedCount, kOwnCount, row + first);
  }
};

// residuals are dimensionless: root of the robust weight, over the record's noise in V
double Weight(const RingDownSamples& record, std::size_t n) {
  return (record.root_weights.empty() ? 1 : record.root_weights[n]) / record.noise_v;
}

// adds `factor` times the derivatives of a sum of parts
void AddSlopes(const RingingSum& sum, const PartNumbers& parts, double factor,
               AnsweredSlopes* slopes) {
  for (std::size_t part = 0; part < kPartCount; ++part) {
    if (parts[part] == 0) continue;
    const double share = factor * parts[part];
    for (std::size_t k = 0; k < slopes->size(); ++k) (*slopes)[k] += share * sum.slopes[part][k];
  }
}

// false, a rejected step, where a trial point is so far away that the voltage overflows
bool WriteRows(const RingDownSamples& record, const RingingSum& sum, const RecordRows& rows) {
  RingingParts parts(record, sum.rates);
  RingingParts parts_of_slopes = parts;
  for (std::size_t n = 0; n < record.times_s.size(); ++n) {
    const double weight = Weight(record, n);
    // residual (model - sample) over the noise; slopes by the chain rule through the parts
    const double model_v = parts.SumAt(record.times_s[n], sum.voltage);
    rows.residuals[n] = (model_v - record.voltages_v[n]) * weight;
    if (!std::isfinite(rows.residuals[n])) return false;
    if (rows.derivatives == nullptr) continue;
    AnsweredSlopes slopes{};
    AddSlopes(sum, parts_of_slopes.At(record.times_s[n]), weight, &slopes);
    rows.Write(n, slopes.data());
  }
  return true;
}

// a record's rows condensed to as few that have the same squares and products
constexpr std::size_t kCondensedRows = kAnsweredCount + 1;

bool WriteCondensed(const std::vector<CondensedRow>& condensed, const RingingSum& sum,
                    const RecordRows& rows) {
  for (std::size_t k = 0; k < kCondensedRows; ++k) {
    // the rows behind the condensed ones are 0
    const auto [parts, value] = k < condensed.size() ? condensed[k] : CondensedRow{};
    rows.residuals[k] = std::inner_product(parts.begin(), parts.end(), sum.voltage.begin(), -value);
    if (!std::isfinite(rows.residuals[k])) return false;
    if (rows.derivatives == nullptr) continue;
    AnsweredSlopes slopes{};
    AddSlopes(sum, parts, 1, &slopes);
    rows.Write(k, slopes.data());
  }
  return true;
}

// all rows, reduced by QR: for a record that cannot be condensed
bool WriteReduced(const RingDownSamples& record, const RingingSum& sum, const RecordRows& rows) {
  const std::size_t samples = record.times_s.size();
  std::vector<double> residuals(samples);
  std::vector<double> derivatives(rows.derivatives == nullptr ? 0 : samples * kAnsweredCount);
  const RecordRows whole{.residuals = residuals,
                         .derivatives = derivatives.empty() ? nullptr : derivatives.data(),
                         .columns = kAnsweredCount,
                         .first = kSharedCount};
  if (!WriteRows(record, sum, whole)) return false;
  // without derivatives only the sum of squares counts
  if (derivatives.empty()) {
    std::ranges::fill(rows.residuals, 0.0);
    const double squares =
        std::inner_product(residuals.begin(), residuals.end(), residuals.begin(), 0.0);
    rows.residuals[0] = std::sqrt(squares);
    return true;
  }
  std::vector<std::size_t> all(kAnsweredCount);
  std::iota(all.begin(), all.end(), std::size_t{0});
  const auto reduced = ReduceRows({derivatives, kAnsweredCount, residuals}, all);
  for (std::size_t k = 0; k < kCondensedRows; ++k) {
    const double* row = reduced.data() + k * kCondensedRows;
    rows.residuals[k] = row[kAnsweredCount];
    rows.Write(k, row);
  }
  return true;
}

std::size_t SampleCount(const std::vector<RingDownSamples>& records) {
  std::size_t rows = 0;
  for (const auto& record : records) rows += record.times_s.size();
  return rows;
}

// what each drop's own constants are above those of all, over the scatter
void WriteScatter(const std::vector<RingDownSamples>& records, std::span<const double> point,
                  std::span<double> residuals, std::span<double> jacobian) {
  std::size_t row = 0;
  for (std::size_t r = 0; r < records.size(); ++r) {
    for (const auto& [own, scatter] : {std::pair(Own::kStiffness, records[r].stiffness_scatter),
                                       {Own::kDamping, records[r].damping_scatter}}) {
      if (scatter == 0) continue;
      const std::size_t column = Column(r, own);
      residuals[row] = point[column] / scatter;
      if (!jacobian.empty()) {
        const auto slopes = jacobian.subspan(row * point.size(), point.size());
        std::ranges::fill(slopes, 0.0);
        slopes[column] = 1 / scatter;
      }
      ++row;
    }
  }
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
    // each record's rows follow those of the previous one; its parameters are one block of columns
    std::size_t row = 0;
    for (std::size_t r = 0; r < records_.size(); ++r) {
      const std::size_t rows = records_[r].times_s.size();
      const std::size_t first = Column(r, Own::kAmplitude);
      RecordRows out{.residuals = residuals.subspan(row, rows), .columns = columns, .first = first};
      if (!jacobian.empty()) out.derivatives = jacobian.data() + row * columns;
      const auto sum = SumOfParts(records_[r], inductance_h_, point.data(), point.data() + first);
      if (!WriteRows(records_[r], sum, out)) return false;
      row += rows;
    }
    WriteScatter(records_, point, residuals.subspan(row),
                 jacobian.empty() ? jacobian : jacobian.subspan(row * columns));
    return true;
  };
  return {SampleCount(records_) + ScatterRows(), columns, evaluate};
}

LeastSquares RingDownProblem::Condensed() const {
  const std::size_t columns = kSharedCount + kOwnCount * records_.size();
  // one condenser per record, which keeps its rows while the poles do not change
  auto condensers = Mapped<Condenser>(records_, std::identity{});
  const auto evaluate = [this, columns, condensers = std::move(condensers)](
                            std::span<const double> point, std::span<double> residuals,
                            std::span<double> jacobian) mutable {
    for (std::size_t r = 0; r < records_.size(); ++r) {
      const std::size_t first = Column(r, Own::kAmplitude);
      RecordRows out{.residuals = residuals.subspan(r * kCondensedRows, kCondensedRows),
                     .columns = columns,
                     .first = first};
      if (!jacobian.empty()) out.derivatives = jacobian.data() + r * kCondensedRows * columns;
      const auto sum = SumOfParts(records_[r], inductance_h_, point.data(), point.data() + first);
      // short or heavily damped records are not condensed
      const bool is_defined = CanBeCondensed(records_[r], sum.rates)
                                  ? WriteCondensed(condensers[r].At(sum.rates), sum, out)
                                  : WriteReduced(records_[r], sum, out);
      if (!is_defined) return false;
    }
    const std::size_t rows = kCondensedRows * records_.size();
    WriteScatter(records_, point, residuals.subspan(rows),
                 jacobian.empty() ? jacobian : jacobian.subspan(rows * columns));
    return true;
  };
  return {kCondensedRows * records_.size() + ScatterRows(), columns, evaluate};
}

SolverReport RingDownProblem::Minimise(const std::vector<bool>& is_free, RingDownPoint* point,
                                       Jacobian* condensed) const {
  HAPTOMETER_CHECK(point->own.size() == records_.size(), "{} records, {} points", records_.size(),
                   point->own.size());
  // over the condensed rows, whose cost does not grow with the samples
  std::vector<double> columns = ToColumns(*point);
  const LeastSquares problem = Condensed();
  const SolverReport report = fit::Minimise(problem, is_free, &columns);
  if (condensed != nullptr) *condensed = fit::Linearise(problem, columns);
  *point = FromColumns(columns);
  return report;
}

Jacobian RingDownProblem::Linearise(const RingDownPoint& point) const {
  return fit::Linearise(Whole(), ToColumns(point));
}

Jacobian RingDownProblem::Condense(const RingDownPoint& point) const {
  return fit::Linearise(Condensed(), ToColumns(point));
}

std::size_t RingDownProblem::ScatterRows() const {
  std::size_t rows = 0;
  for (const auto& record : records_) {
    rows += (record.stiffness_scatter > 0 ? 1UZ : 0UZ) + (record.damping_scatter > 0 ? 1UZ : 0UZ);
  }
  return rows;
}

bool RingDownProblem::IsDefined(const RingDownPoint& point) const {
  std::vector<double> residuals(SampleCount(records_) + ScatterRows());
  return Whole().evaluate(ToColumns(point), residuals, {});
}

std::vector<double> RingDownProblem::Residuals(const RingDownPoint& point) const {
  std::vector<double> residuals(SampleCount(records_) + ScatterRows());
  Whole().evaluate(ToColumns(point), residuals, {});
  return residuals;
}

std::vector<double> RingDownProblem::ProductsOf(const RingDownPoint& point, std::size_t r,
                                                std::span<const double> changes) const {
  const RingDownSamples& record = records_[r];
  const auto sum = SumOfParts(record, inductance_h_, point.shared.data(), point.own[r].data());
  RingingParts parts(record, sum.rates);
  // J' change without J: sums of the parts over the samples, then their slopes
  PartNumbers along{};
  for (std::size_t n = 0; n < record.times_s.size(); ++n) {
    const PartNumbers here = parts.At(record.times_s[n]);
    const double change = Weight(record, n) * changes[n];
    for (std::size_t k = 0; k < kPartCount; ++k) along[k] += change * here[k];
  }
  AnsweredSlopes slopes{};
  AddSlopes(sum, along, 1, &slopes);
  std::vector<double> products(kSharedCount + kOwnCount * records_.size());
  std::copy_n(slopes.begin(), kSharedCount, products.begin());
  std::copy_n(slopes.begin() + kSharedCount, kOwnCount,
              products.begin() + static_cast<std::ptrdiff_t>(Column(r, Own::kAmplitude)));
  return products;
}

std::vector<double> RingDownProblem::Products(const RingDownPoint& point,
                                              std::span<const double> changes) const {
  std::vector<double> products(kSharedCount + kOwnCount * records_.size());
  for (std::size_t r = 0; r < records_.size(); ++r) {
    const std::size_t rows = records_[r].times_s.size();
    const auto own = ProductsOf(point, r, changes.first(rows));
    std::ranges::transform(products, own, products.begin(), std::plus{});
    changes = changes.subspan(rows);
  }
  return products;
}

std::vector<double> RingDownProblem::Voltages(const RingDownPoint& point, std::size_t record,
                                              const std::vector<double>& times_s) const {
  const auto sum =
      SumOfParts(records_[record], inductance_h_, point.shared.data(), point.own[record].data());
  RingingParts parts(records_[record], sum.rates);
  std::vector<double> voltages(times_s.size());
  std::ranges::transform(times_s, voltages.begin(),
                         [&](double time_s) { return parts.SumAt(time_s, sum.voltage); });
  return voltages;
}

RecordPoles RingDownProblem::Poles(const RingDownPoint& point, std::size_t record) const {
  return SumOfParts(records_[record], inductance_h_, point.shared.data(), point.own[record].data())
      .poles;
}

namespace {

constexpr double kMostNoise = 0.5;  // steps, beyond which no rounding error is left
constexpr std::size_t kCases = 16;

// 0 ... 15 with its four bits in reverse order
std::size_t Reversed(std::size_t n) {
  return (n & 1) << 3 | (n & 2) << 1 | (n & 4) >> 1 | (n & 8) >> 3;
}

// the middle of the `n`th of so many equal parts of -1/2 to 1/2
double Place(std::size_t n) {
  return (static_cast<double>(n) + 0.5) / static_cast<double>(kCases) - 0.5;
}

}  // namespace

double MeanRoundingError(double x, double noise) {
  const double below = std::floor(x);
  // E(code) = below - 3 + P(code >= below - 2) + ... + P(code >= below + 3): 5 deviations of noise
  double code = below - 3;
  for (int m = -2; m <= 3; ++m) {
    const double above = x - below - m + 0.5;
    code += noise > 0 ? 0.5 * std::erfc(-above / (noise * std::numbers::sqrt2))
                      : (above >= 0 ? 1.0 : 0.0);
  }
  return code - x;
}

std::vector<std::vector<double>> RoundingChanges(const RingDownProblem& problem,
                                                 const RingDownPoint& point,
                                                 const Identifiability& seen, std::size_t record,
                                                 double step_v, double deviation_v) {
  if (step_v == 0) return {};
  // its square is the noise's and the rounding's, 1/12 of a step squared
  const double noise = std::sqrt(std::max(std::pow(deviation_v / step_v, 2) - 1.0 / 12, 0.0));
  if (noise >= kMostNoise) return {};
  const RingDownSamples& samples = problem.records()[record];
  auto motion_v = problem.Voltages(point, record, samples.times_s);
  const double offset_v = point.own[record][Index(Own::kOffset)];
  double peak_v = 0;
  for (double& v : motion_v) {
    v -= offset_v;
    peak_v = std::max(peak_v, std::abs(v));
  }
  std::vector<double> errors(motion_v.size());
  std::vector<std::vector<double>> changes;
  for (std::size_t k = 0; k < kCases; ++k) {
    // offset by part of a step, peak within a step either way
    const double offset = offset_v / step_v + Place(k);
    const double scale = (peak_v / step_v + 2 * Place(Reversed(k))) / peak_v;
    for (std::size_t n = 0; n < motion_v.size(); ++n) {
      const double weight = samples.root_weights.empty() ? 1 : samples.root_weights[n];
      const double error_v = step_v * MeanRoundingError(offset + scale * motion_v[n], noise);
      errors[n] = error_v * weight / (samples.noise_v * std::sqrt(double{kCases}));
    }
    changes.push_back(Response(seen, problem.ProductsOf(point, record, errors)));
  }
  return changes;
}

}  // namespace haptometer::fit
