#include "fit/condensed_record.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <span>

#include "fit/ringing_moments.h"
#include "fit/row_reduction.h"
#include "sim/ring_down.h"

namespace haptometer::fit {
namespace {

using Position = Eigen::Index;

constexpr std::size_t kBlock = 128;
constexpr double kOnGrid = 1e-6;       // of a step: rounding
constexpr double kMostExponents = 40;  // e^-40 is lost beside any ringing
constexpr double kLeastAngle = 100;    // (q - d^2) t^2

// F's columns here: what blocks have, then the coil's current, which is over before the first of
// them
constexpr std::array kColumns{
    Part::kEven,  Part::kOdd,       Part::kTimesEven, Part::kTimesOdd,   Part::kConstant,
    Part::kDrift, Part::kHumCosine, Part::kHumSine,   Part::kElectrical, Part::kTimesElectrical};
constexpr Position kRinging = 5;  // up to kConstant
constexpr Position kInBlocks = 8;
constexpr std::size_t kWidth = kColumns.size();
using Square =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kInBlocks, kInBlocks>;

class Condensing {
 public:
  Condensing(const RingDownSamples& record, const RingingRates& rates)
      : record_(record),
        rates_(rates),
        recording_(record),
        width_(record.drifts || record.hum_hz > 0 ? kInBlocks : kRinging),
        moments_(rates.decay_per_s, rates.stiffness_per_s2, rates.electrical_rate_per_s,
                 record.step_s / record.time_scale) {}

  void Take(const std::vector<Stretch>& stretches) {
    rows_.reserve(kWidth * (stretches.size() * static_cast<std::size_t>(width_) + kBlock));
    for (const auto& [first, is_block] : stretches) {
      const std::size_t count = is_block ? kBlock : 1;
      if (is_block && IsMotionAlone(first)) {
        TakeBlock(first);
        continue;
      }
      for (std::size_t n = first; n < first + count; ++n) TakeSample(n);
    }
    // the blocks' rests in one row
    rows_.resize(rows_.size() + kWidth);
    samples_.push_back(std::sqrt(rest_));
  }

  [[nodiscard]] CondensedRecord condensed() const {
    std::vector<std::size_t> used;
    CondensedRecord condensed;
    for (std::size_t k = 0; k < kWidth; ++k) {
      const bool in_blocks = static_cast<Position>(k) < width_;
      const bool electrical = static_cast<Position>(k) >= kInBlocks && has_current_;
      if (!in_blocks && !electrical) continue;
      used.push_back(k);
      condensed.parts.push_back(kColumns[k]);
    }
    condensed.rows = ReduceRows({rows_, kWidth, samples_}, used);
    for (double& value : condensed.rows) value /= record_.noise_v;
    return condensed;
  }

 private:
  [[nodiscard]] double SinceBlow(std::size_t n) const {
    return (record_.times_s[n] - rates_.impact_s) / record_.time_scale;
  }

  // behind the blow and the coil's current's own decay
  [[nodiscard]] bool IsMotionAlone(std::size_t n) const {
    const double exponents = rates_.electrical_rate_per_s * SinceBlow(n);
    return SinceBlow(n) >= 0 && (rates_.electrical_rate_per_s == 0 || exponents > kMostExponents);
  }

  void TakeSample(std::size_t n) {
    const RingingMoment moment = moments_.At(SinceBlow(n));
    const auto [drift, cosine, sine] = recording_.At(record_.times_s[n]);
    const double weight = record_.root_weights.empty() ? 1 : record_.root_weights[n];
    has_current_ = has_current_ || moment.electrical > 0;
    for (const double part :
         {moment.even, moment.odd, moment.since_s * moment.even, moment.since_s * moment.odd, 1.0,
          drift, cosine, sine, moment.electrical, moment.since_s * moment.electrical}) {
      rows_.push_back(weight * part);
    }
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
      const double shown_s = static_cast<double>(k) * record_.step_s;
      const double angle = recording_.hum_rad_per_s * shown_s;
      parts.row(k).tail(kInBlocks - kRinging) << shown_s, std::cos(angle), std::sin(angle);
    }
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(parts);
    orthonormal_ = qr.householderQ() * Eigen::MatrixXd::Identity(parts.rows(), width_);
    triangle_ = qr.matrixQR().topRows(width_).triangularView<Eigen::Upper>();
  }

  // what makes the parts of the block at `n` of those of the one at 0
  [[nodiscard]] Square Shift(std::size_t n) const {
    const double t = SinceBlow(n);
    const auto [even, odd] =
        sim::DampedFundamentals(rates_.decay_per_s, rates_.stiffness_per_s2, t);
    const double discriminant = rates_.decay_per_s * rates_.decay_per_s - rates_.stiffness_per_s2;
    Square shift = Square::Zero(width_, width_);
    const Eigen::Matrix2d turn{{even, odd}, {discriminant * odd, even}};
    shift.block<2, 2>(0, 0) = turn;
    shift.block<2, 2>(0, 2) = t * turn;
    shift.block<2, 2>(2, 2) = turn;
    shift(4, 4) = 1;
    if (width_ == kRinging) return shift;
    const auto [drift, cosine, sine] = recording_.At(record_.times_s[n]);
    shift(4, 5) = drift;
    shift(5, 5) = 1;
    shift.block<2, 2>(6, 6) << cosine, sine, -sine, cosine;
    return shift;
  }

  void TakeBlock(std::size_t first) {
    if (orthonormal_.size() == 0) MakeBasis();
    const Eigen::Map<const Eigen::VectorXd> values(record_.voltages_v.data() + first,
                                                   static_cast<Position>(kBlock));
    const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kInBlocks, 1> products =
        orthonormal_.transpose() * values;
    rest_ += (values - orthonormal_ * products).squaredNorm();
    const Square parts = triangle_ * Shift(first);
    for (Position row = 0; row < width_; ++row) {
      for (Position k = 0; k < width_; ++k) rows_.push_back(parts(row, k));
      rows_.resize(rows_.size() + kWidth - static_cast<std::size_t>(width_));
      samples_.push_back(products[row]);
    }
  }

  const RingDownSamples& record_;
  const RingingRates& rates_;
  RecordingParts recording_;
  Position width_;  // of a block's parts
  RingingMoments moments_;
  Eigen::MatrixXd orthonormal_;
  Square triangle_;
  bool has_current_ = false;
  double rest_ = 0;
  std::vector<double> rows_;
  std::vector<double> samples_;
};

}  // namespace

std::array<double, 3> RecordingParts::At(double time_s) const {
  if (hum_rad_per_s == 0) return {time_s - middle_s, 1, 0};
  return {time_s - middle_s, std::cos(hum_rad_per_s * time_s), std::sin(hum_rad_per_s * time_s)};
}

std::vector<Stretch> StretchesOf(const RingDownSamples& record) {
  std::vector<Stretch> stretches;
  const auto& times = record.times_s;
  std::size_t first = 0;
  while (first < times.size()) {
    std::size_t end = first;  // of the samples on the grid that begins at `first`
    const std::size_t most =
        record.root_weights.empty() ? std::min(times.size(), first + kBlock) : first;
    while (end < most && std::abs((times[end] - times[first]) / record.step_s -
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

bool CanBeCondensed(const RingDownSamples& record, const RingingRates& rates) {
  const double length_s = (record.times_s.back() - rates.impact_s) / record.time_scale;
  const double square = rates.stiffness_per_s2 - rates.decay_per_s * rates.decay_per_s;
  return record.step_s > 0 && length_s > 0 && square * length_s * length_s > kLeastAngle;
}

CondensedRecord CondenseRecord(const RingDownSamples& record, const std::vector<Stretch>& stretches,
                               const RingingRates& rates) {
  Condensing condensing(record, rates);
  condensing.Take(stretches);
  return condensing.condensed();
}

}  // namespace haptometer::fit
