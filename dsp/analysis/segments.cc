#include "dsp/analysis/segments.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/check.h"

namespace haptometer::dsp {
namespace {

// least rate of a record whose holes are bridged, per upper corner
constexpr double kBridgeRatePerUpperCorner = 5;
// measured samples that the cubic takes on each side of a hole
constexpr std::size_t kSide = 2;

// rows with a measurement, and their values
class Measured {
 public:
  explicit Measured(const trial::Channel& channel) : channel_(channel) {}

  [[nodiscard]] bool At(std::size_t row) const {
    return trial::IsMeasurement(channel_.statuses[row]) && std::isfinite(channel_.values[row]);
  }
  // whether all of [begin, end) are measured; begin may have wrapped below 0, end may be too far
  [[nodiscard]] bool All(std::size_t begin, std::size_t end) const {
    if (begin > end || end > channel_.values.size()) return false;
    for (std::size_t row = begin; row < end; ++row) {
      if (!At(row)) return false;
    }
    return true;
  }
  [[nodiscard]] double Value(std::size_t row) const { return channel_.values[row]; }

 private:
  const trial::Channel& channel_;
};

// the cubic through the two samples before and after rows [first, first + size), at row first + k
double Bridged(const Measured& measured, std::size_t first, std::size_t size, std::size_t k) {
  const std::array<std::size_t, 4> rows{first - 2, first - 1, first + size, first + size + 1};
  const auto n = static_cast<double>(size);
  const std::array<double, 4> at{-2, -1, n, n + 1};
  const auto x = static_cast<double>(k);
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    double weight = 1;
    for (std::size_t j = 0; j < 4; ++j) {
      if (j != i) weight *= (x - at[j]) / (at[i] - at[j]);
    }
    sum += weight * measured.Value(rows[i]);
  }
  return sum;
}

// squared error of bridging `size` rows at `first`, all of which are known
double KnownErrorSquareSum(const Measured& measured, std::size_t first, std::size_t size) {
  double sum = 0;
  for (std::size_t k = 0; k < size; ++k) {
    const double error = Bridged(measured, first, size, k) - measured.Value(first + k);
    sum += error * error;
  }
  return sum;
}

// rows [begin, end) of one stretch
struct Rows {
  std::size_t begin = 0;
  std::size_t end = 0;
};

// What bridging the hole costs, tried on the nearest known rows on either side; nothing where the
// hole has no two neighbours or neither side can be tried.
std::optional<double> BridgeErrorSquareSum(const Measured& measured, Rows stretch, Rows hole) {
  const std::size_t size = hole.end - hole.begin;
  const auto known = [&](std::size_t begin, std::size_t end) {
    return begin >= stretch.begin && end <= stretch.end && measured.All(begin, end);
  };
  if (size > kLongestBridge || hole.begin < stretch.begin + kSide ||
      !known(hole.begin - kSide, hole.begin) || !known(hole.end, hole.end + kSide)) {
    return std::nullopt;
  }
  const std::size_t span = size + 2 * kSide;
  std::optional<double> worst;
  if (hole.begin >= stretch.begin + span && known(hole.begin - span, hole.begin)) {
    worst = KnownErrorSquareSum(measured, hole.begin - kSide - size, size);
  }
  if (known(hole.end, hole.end + span)) {
    const double after = KnownErrorSquareSum(measured, hole.end + kSide, size);
    worst = std::max(worst.value_or(0), after);
  }
  return worst;
}

// collects the segments of one stretch
class StretchSplitter {
 public:
  StretchSplitter(const trial::Stretch& stretch, const Measured& measured, bool may_bridge,
                  Segments& segments)
      : stretch_(stretch), measured_(measured), may_bridge_(may_bridge), segments_(segments) {}

  void Split() {
    const Rows all{stretch_.first_row, stretch_.first_row + stretch_.rows};
    for (std::size_t row = all.begin; row < all.end;) {
      if (measured_.At(row)) {
        Append(row, measured_.Value(row));
        ++row;
        continue;
      }
      Rows hole{row, row};
      while (hole.end < all.end && !measured_.At(hole.end)) ++hole.end;
      TakeHole(all, hole);
      row = hole.end;
    }
    Finish();
  }

 private:
  void TakeHole(Rows all, Rows hole) {
    const std::optional<double> error_square_sum =
        may_bridge_ ? BridgeErrorSquareSum(measured_, all, hole) : std::nullopt;
    if (!error_square_sum) return Finish();
    const std::size_t size = hole.end - hole.begin;
    for (std::size_t k = 0; k < size; ++k) {
      Append(hole.begin + k, Bridged(measured_, hole.begin, size, k));
    }
    segment_.bridged += size;
    segment_.bridged_error_square_sum += *error_square_sum;
  }

  void Append(std::size_t row, double value) {
    if (segment_.values.empty()) {
      segment_.first_row = row;
      segment_.rate_hz = stretch_.rate_hz;
      segment_.time_uncertainty_s = stretch_.time_uncertainty_s;
      segment_.start_s =
          stretch_.start_s + static_cast<double>(row - stretch_.first_row) / stretch_.rate_hz;
    }
    segment_.values.push_back(value);
  }

  void Finish() {
    if (segment_.values.empty()) return;
    segments_.bridged += segment_.bridged;
    segments_.parts.push_back(std::move(segment_));
    segment_ = {};
  }

  const trial::Stretch& stretch_;
  const Measured& measured_;
  bool may_bridge_;
  Segments& segments_;
  Segment segment_;
};

}  // namespace

Segments SplitIntoSegments(const trial::Record& record, const trial::Channel& channel,
                           double upper_hz) {
  HAPTOMETER_CHECK(channel.values.size() == record.rows && channel.statuses.size() == record.rows,
                   "{} values and {} statuses in {} rows", channel.values.size(),
                   channel.statuses.size(), record.rows);
  const Measured measured(channel);
  Segments segments;
  for (std::size_t row = 0; row < record.rows; ++row) {
    ++segments.by_status[static_cast<std::size_t>(channel.statuses[row])];
    if (measured.At(row)) ++segments.measured;
  }
  for (const trial::Stretch& stretch : record.stretches) {
    const bool may_bridge = stretch.rate_hz >= kBridgeRatePerUpperCorner * upper_hz;
    StretchSplitter(stretch, measured, may_bridge, segments).Split();
  }
  return segments;
}

}  // namespace haptometer::dsp
