#include "fit/drop_test/condensed_record.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "fit/least_squares.h"
#include "sim/ring_down.h"

namespace haptometer::fit {
namespace {

using Position = Eigen::Index;

constexpr std::size_t kBlock = 128;
constexpr double kOnGrid = 1e-6;       // of a step: rounding
constexpr double kMostExponents = 40;  // e^-40 is lost beside any ringing
constexpr double kLeastAngle = 100;    // (q - d^2) t^2

// F's columns here: what every block has, the disturbances that the record has (from kDrift on),
// then the coil's current, which is over before the first block
constexpr std::array kRingingColumns{Part::kEven, Part::kOdd, Part::kTimesEven, Part::kTimesOdd,
                                     Part::kConstant};
constexpr std::array kCurrentColumns{Part::kElectrical, Part::kTimesElectrical};
constexpr Position kRinging = std::ssize(kRingingColumns);
constexpr Position kInBlocks = kRinging + 1 + 2 * static_cast<Position>(kMostHumLines);
using Stretch = Condenser::Stretch;
using Square =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kInBlocks, kInBlocks>;
using Products = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kInBlocks, 1>;

// Rows with the squares and products of a record's parts and samples at given poles. A block of the
// uniform grid becomes as few rows as it has parts: one QR of the first block's parts serves all
// blocks, because parts at t + s are linear in parts at s (addition theorems).
class Condensing {
 public:
  Condensing(const RingDownSamples& record, const RingingRates& rates)
      : record_(record),
        rates_(rates),
        recording_(record),
        width_(record.drifts || recording_.lines > 0
                   ? kRinging + 1 + 2 * static_cast<Position>(recording_.lines)
                   : kRinging),
        columns_(static_cast<std::size_t>(width_) + kCurrentColumns.size()),
        moments_(rates.decay_per_s, rates.stiffness_per_s2, rates.electrical_rate_per_s,
                 record.step_s / record.time_scale) {}

  void Take(const std::vector<Stretch>& stretches) {
    rows_.reserve(columns_ * (stretches.size() * static_cast<std::size_t>(width_) + kBlock));
    for (const auto& [first, is_block] : stretches) {
      const std::size_t count = is_block ? kBlock : 1;
      if (is_block && IsMotionAlone(first)) {
        TakeBlock(first);
        continue;
      }
      // before the impact, or while the coil's current lasts: sample by sample
      for (std::size_t n = first; n < first + count; ++n) TakeSample(n);
    }
    // the blocks' rests in one row
    rows_.resize(rows_.size() + columns_);
    samples_.push_back(std::sqrt(rest_));
  }

  [[nodiscard]] std::vector<CondensedRow> condensed() const {
    // columns that occur: those of blocks, and the current's where a sample has any
    std::vector<std::size_t> used(has_current_ ? columns_ : static_cast<std::size_t>(width_));
    std::iota(used.begin(), used.end(), 0UZ);
    const std::size_t size = used.size() + 1;
    const auto reduced = ReduceRows({rows_, columns_, samples_}, used);
    std::vector<CondensedRow> condensed(size);
    for (std::size_t row = 0; row < size; ++row) {
      const double* values = reduced.data() + row * size;
      auto& [parts, value_v] = condensed[row];
      for (std::size_t k = 0; k < used.size(); ++k) {
        parts[PartOf(k)] = values[k] / record_.noise_v;
      }
      // D = (t E - O)/(2 (d^2 - q)), linear in the other parts
      parts[Index(Part::kByDiscriminant)] =
          (parts[Index(Part::kTimesEven)] - parts[Index(Part::kOdd)]) / (2 * discriminant());
      value_v = values[used.size()] / record_.noise_v;
    }
    return condensed;
  }

 private:
  [[nodiscard]] double discriminant() const {
    return rates_.decay_per_s * rates_.decay_per_s - rates_.stiffness_per_s2;
  }
  [[nodiscard]] double SinceBlow(std::size_t n) const {
    return (record_.times_s[n] - rates_.impact_s) / record_.time_scale;
  }

  [[nodiscard]] std::size_t PartOf(std::size_t column) const {
    if (column < kRingingColumns.size()) return Index(kRingingColumns[column]);
    const auto width = static_cast<std::size_t>(width_);
    return column < width ? Index(Part::kDrift) + column - kRingingColumns.size()
                          : Index(kCurrentColumns[column - width]);
  }

  // behind the impact and the coil's current's own decay
  [[nodiscard]] bool IsMotionAlone(std::size_t n) const {
    const double exponents = rates_.electrical_rate_per_s * SinceBlow(n);
    return SinceBlow(n) >= 0 && (rates_.electrical_rate_per_s == 0 || exponents > kMostExponents);
  }

  void TakeSample(std::size_t n) {
    const RingingMoment moment = moments_.At(SinceBlow(n));
    const auto recorded = recording_.At(record_.times_s[n]);
    const double weight = record_.root_weights.empty() ? 1 : record_.root_weights[n];
    has_current_ = has_current_ || moment.electrical > 0;
    for (const double part : {moment.even, moment.odd, moment.since_s * moment.even,
                              moment.since_s * moment.odd, 1.0}) {
      rows_.push_back(weight * part);
    }
    for (Position k = kRinging; k < width_; ++k) {
      rows_.push_back(weight * recorded[static_cast<std::size_t>(k - kRinging)]);
    }
    rows_.push_back(weight * moment.electrical);
    rows_.push_back(weight * moment.since_s * moment.electrical);
    samples_.push_back(weight * record_.voltages_v[n]);
  }

  // the parts of the samples 0 ... kBlock - 1 on the grid, as orthonormal columns times a triangle
  void MakeBasis() {
    const double step_s = record_.step_s / record_.time_scale;
    Eigen::MatrixXd parts(static_cast<Position>(kBlock), width_);
    for (Position k = 0; k < parts.rows(); ++k) {
      const auto [since_s, even, odd, electrical] = moments_.At(static_cast<double>(k) * step_s);
      parts.row(k).head(kRinging) << even, odd, since_s * even, since_s * odd, 1;
      if (width_ == kRinging) continue;
      // drift and hum run in the record's own time, shown over true by the time scale
      const double shown_s = static_cast<double>(k) * record_.step_s;
      parts(k, kRinging) = shown_s;
      for (std::size_t line = 0; line < recording_.lines; ++line) {
        const double angle = recording_.hum_rad_per_s[line] * shown_s;
        parts(k, CosineOf(line)) = std::cos(angle);
        parts(k, CosineOf(line) + 1) = std::sin(angle);
      }
    }
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(parts);
    orthonormal_ = qr.householderQ() * Eigen::MatrixXd::Identity(parts.rows(), width_);
    triangle_ = qr.matrixQR().topRows(width_).triangularView<Eigen::Upper>();
  }

  [[nodiscard]] static Position CosineOf(std::size_t line) {
    return kRinging + 1 + 2 * static_cast<Position>(line);
  }

  // the basis's triangle turned to the parts of the block at `n`, in as many rows
  void WriteParts(std::size_t n, double* row) const {
    const double t = SinceBlow(n);
    const auto [even, odd] =
        sim::DampedFundamentals(rates_.decay_per_s, rates_.stiffness_per_s2, t);
    // E(t + s) = E E + (d^2 - q) O O and O(t + s) = E O + O E, also times t + s
    const double odd_to_even = discriminant() * odd;
    const auto recorded = recording_.At(record_.times_s[n]);
    for (Position k = 0; k < width_; ++k, row += columns_) {
      const auto triangle = triangle_.row(k);
      row[0] = triangle[0] * even + triangle[1] * odd_to_even;
      row[1] = triangle[0] * odd + triangle[1] * even;
      row[2] = triangle[2] * even + triangle[3] * odd_to_even + t * row[0];
      row[3] = triangle[2] * odd + triangle[3] * even + t * row[1];
      row[4] = triangle[4];
      if (width_ == kRinging) continue;
      row[kRinging] = triangle[kRinging] + recorded[0] * triangle[4];
      for (std::size_t line = 0; line < recording_.lines; ++line) {
        const Position at = CosineOf(line);
        const double cosine = recorded[1 + 2 * line];
        const double sine = recorded[2 + 2 * line];
        row[at] = triangle[at] * cosine - triangle[at + 1] * sine;
        row[at + 1] = triangle[at] * sine + triangle[at + 1] * cosine;
      }
    }
  }

  // samples = Q (Q' samples) + rest: the products are rows, the rest's square is a constant
  void TakeBlock(std::size_t first) {
    if (orthonormal_.size() == 0) MakeBasis();
    const Eigen::Map<const Eigen::VectorXd> values(record_.voltages_v.data() + first,
                                                   static_cast<Position>(kBlock));
    Products products(width_);
    products.noalias() = orthonormal_.transpose() * values;
    left_ = values;
    left_.noalias() -= orthonormal_ * products;
    rest_ += left_.squaredNorm();
    const std::size_t row = samples_.size();
    samples_.insert(samples_.end(), products.begin(), products.end());
    rows_.resize(columns_ * samples_.size());
    WriteParts(first, rows_.data() + columns_ * row);
  }

  const RingDownSamples& record_;
  const RingingRates& rates_;
  RecordingParts recording_;
  Position width_;       // of a block's parts
  std::size_t columns_;  // with the current's
  RingingMoments moments_;
  Eigen::MatrixXd orthonormal_;
  Eigen::VectorXd left_;  // of a block's samples, by these
  Square triangle_;
  bool has_current_ = false;
  double rest_ = 0;
  std::vector<double> rows_;
  std::vector<double> samples_;
};

// whole blocks on the record's uniform grid, and single samples
std::vector<Stretch> StretchesOf(const RingDownSamples& record) {
  std::vector<Stretch> stretches;
  const auto& times = record.times_s;
  const double steps_per_s = record.step_s > 0 ? 1 / record.step_s : 0;
  std::size_t first = 0;
  while (first < times.size()) {
    std::size_t end = first;  // of the samples on the grid that begins at `first`
    // robust weights differ from sample to sample: no blocks
    const std::size_t most =
        record.root_weights.empty() ? std::min(times.size(), first + kBlock) : first;
    while (end < most && std::abs((times[end] - times[first]) * steps_per_s -
                                  static_cast<double>(end - first)) < kOnGrid) {
      ++end;
    }
    const bool is_block = end == first + kBlock;
    const std::size_t next = is_block ? end : std::max(end, first + 1);
    for (std::size_t n = first; n < next; n += is_block ? kBlock : 1)
      stretches.push_back({n, is_block});
    first = next;
  }
  return stretches;
}

}  // namespace

bool CanBeCondensed(const RingDownSamples& record, const RingingRates& rates) {
  const double length_s = (record.times_s.back() - rates.impact_s) / record.time_scale;
  const double square = rates.stiffness_per_s2 - rates.decay_per_s * rates.decay_per_s;
  // D follows from the other parts by a division by d^2 - q, without loss from this angle on
  return record.step_s > 0 && length_s > 0 && square * length_s * length_s > kLeastAngle;
}

Condenser::Condenser(const RingDownSamples& record)
    : record_(&record), stretches_(StretchesOf(record)) {}

const std::vector<CondensedRow>& Condenser::At(const RingingRates& rates) {
  if (rates_ == rates) return last_;
  Condensing condensing(*record_, rates);
  condensing.Take(stretches_);
  last_ = condensing.condensed();
  rates_ = rates;
  return last_;
}

}  // namespace haptometer::fit
