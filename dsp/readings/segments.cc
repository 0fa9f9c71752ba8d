#include "dsp/readings/segments.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "base/error.h"
#include "dsp/readings/interpolation.h"

namespace haptometer::dsp {
namespace {

// a longer hole than the model reaches over four times is not known any more
constexpr std::size_t kLongestPerOrder = 4;
// holes whose rows are filled by one model, at most
constexpr std::size_t kGroupRows = 1024;
// the mean square error of an interpolated hole, over the variance of the samples about it: of
// white noise, which its neighbours do not determine, it is 1
constexpr double kMostError = 2;

// Collects the segments of one `Stretch`, hole by hole.
class Splitter {
 public:
  Splitter(const trial::RowSource& source, std::size_t channel, const trial::Stretch& stretch,
           Segments& segments)
      : source_(source),
        channel_(channel),
        stretch_(stretch),
        end_(stretch.first_row + stretch.rows),
        longest_(LongestHole(stretch.rate_hz)),
        segments_(segments) {}

  Result<void> Take(std::span<const RowRange> holes) {
    Begin(stretch_.first_row);
    for (std::size_t k = 0; k < holes.size();) {
      if (!MayFill(holes[k])) {
        Finish(holes[k].begin, holes[k].end);
        ++k;
        continue;
      }
      // holes near each other share a model
      std::size_t last = k + 1;
      while (last < holes.size() && MayFill(holes[last]) &&
             holes[last].begin - holes[last - 1].end <= kInterpolationReach &&
             holes[last].end - holes[k].begin <= kGroupRows) {
        ++last;
      }
      HAPTOMETER_TRY(Fill(holes.subspan(k, last - k)));
      k = last;
    }
    Finish(end_, end_);
    return {};
  }

 private:
  // short enough, and between two measured samples
  [[nodiscard]] bool MayFill(const RowRange& hole) const {
    return hole.rows() <= longest_ && hole.begin > stretch_.first_row && hole.end < end_;
  }

  Result<void> Fill(std::span<const RowRange> holes) {
    const std::size_t begin =
        std::max(stretch_.first_row,
                 holes.front().begin - std::min(holes.front().begin, kInterpolationReach));
    const std::size_t end = std::min(end_, holes.back().end + kInterpolationReach);
    // the neighbourhood as it was measured: what was interpolated before would feed its own errors
    std::vector<double> values(end - begin);
    std::vector<trial::SampleStatus> statuses(values.size());
    HAPTOMETER_TRY(source_.Read(channel_, begin, values, statuses));
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (!IsMeasured(values[k], statuses[k])) values[k] = std::numeric_limits<double>::quiet_NaN();
    }
    const auto found = Interpolate(values, holes.front().begin - begin, holes.back().end - begin);
    const double most = kMostError * VarianceOf(values);
    // each hole on its own: interpolated, or the end of a segment
    std::size_t at = 0;
    for (const RowRange& hole : holes) {
      if (!found || !Bridged(hole, std::span(*found).subspan(at, hole.rows()), most)) {
        Finish(hole.begin, hole.end);
      }
      at += hole.rows();
    }
    return {};
  }

  bool Bridged(const RowRange& hole, std::span<const Interpolated> samples, double most) {
    double square_sum = 0;
    for (const Interpolated& sample : samples) square_sum += sample.error_square;
    if (!(square_sum <= most * static_cast<double>(hole.rows()))) return false;
    for (std::size_t k = 0; k < hole.rows(); ++k) {
      segment_.bridges.push_back({hole.begin + k - segment_.first_row, samples[k].value,
                                  samples[k].error_square, samples[k].covariance_sum});
    }
    return true;
  }

  static double VarianceOf(std::span<const double> values) {
    double sum = 0;
    double square_sum = 0;
    double count = 0;
    const auto first = std::ranges::find_if(values, [](double x) { return !std::isnan(x); });
    for (const double x : values) {
      if (std::isnan(x)) continue;
      sum += x - *first;
      square_sum += (x - *first) * (x - *first);
      ++count;
    }
    return (square_sum - sum * sum / count) / count;
  }

  void Begin(std::size_t row) {
    segment_.first_row = row;
    segment_.rate_hz = stretch_.rate_hz;
    segment_.time_uncertainty_s = stretch_.time_uncertainty_s;
    segment_.start_s =
        stretch_.start_s + static_cast<double>(row - stretch_.first_row) / stretch_.rate_hz;
  }

  // closes the segment before `end_row`; the next one begins at `next_row`
  void Finish(std::size_t end_row, std::size_t next_row) {
    segment_.size = end_row - segment_.first_row;
    segments_.bridged += segment_.bridges.size();
    if (segment_.size > 0) segments_.parts.push_back(std::move(segment_));
    segment_ = {};
    Begin(next_row);
  }

  const trial::RowSource& source_;
  std::size_t channel_;
  const trial::Stretch& stretch_;
  std::size_t end_;
  std::size_t longest_;
  Segments& segments_;
  Segment segment_;
};

}  // namespace

std::size_t LongestHole(double rate_hz) {
  const double rows =
      std::min(kLongestHoleS * rate_hz, static_cast<double>(kLongestPerOrder * kModelOrder));
  return std::max<std::size_t>(1, static_cast<std::size_t>(rows));
}

Result<Segments> SplitAtHoles(const trial::RowSource& source, std::size_t channel,
                              std::span<const RowRange> holes) {
  Segments segments;
  std::vector<RowRange> within;
  std::size_t next = 0;
  for (const trial::Stretch& stretch : source.head().stretches) {
    const RowRange all{stretch.first_row, stretch.first_row + stretch.rows};
    // a segment never exceeds its stretch: a hole over the end of one is cut
    within.clear();
    while (next < holes.size() && holes[next].end <= all.begin) ++next;
    for (std::size_t k = next; k < holes.size() && holes[k].begin < all.end; ++k) {
      within.push_back({std::max(holes[k].begin, all.begin), std::min(holes[k].end, all.end)});
    }
    HAPTOMETER_TRY(Splitter(source, channel, stretch, segments).Take(within));
  }
  return segments;
}

Result<void> SegmentSamples::Read(std::size_t first, std::span<double> out) const {
  HAPTOMETER_CHECK(first <= size() && out.size() <= size() - first, "samples {} + {} of {}", first,
                   out.size(), size());
  // in pieces: statuses are read too, but not kept
  constexpr std::size_t kPiece = std::size_t{1} << 14U;
  const std::size_t most = std::min(kPiece, out.size());
  const auto statuses = std::make_unique_for_overwrite<trial::SampleStatus[]>(most);
  for (std::size_t at = 0; at < out.size(); at += kPiece) {
    const std::span<double> piece = out.subspan(at, std::min(kPiece, out.size() - at));
    HAPTOMETER_TRY(source_->Read(channel_, segment_->first_row + first + at, piece,
                                 std::span(statuses.get(), piece.size())));
  }
  // interpolated samples replace the unmeasured ones
  for (const Bridge& bridge : BridgesWithin(first, out.size())) {
    out[bridge.sample - first] = bridge.value;
  }
  return {};
}

Result<void> SegmentSamples::ReadMeasured(std::size_t first, std::span<double> out) const {
  HAPTOMETER_TRY(Read(first, out));
  for (const Bridge& bridge : BridgesWithin(first, out.size())) {
    out[bridge.sample - first] = std::numeric_limits<double>::quiet_NaN();
  }
  return {};
}

std::span<const Bridge> SegmentSamples::BridgesWithin(std::size_t first, std::size_t size) const {
  const auto begin = std::ranges::lower_bound(segment_->bridges, first, {}, &Bridge::sample);
  const auto end = std::ranges::lower_bound(segment_->bridges, first + size, {}, &Bridge::sample);
  return {begin, end};
}

}  // namespace haptometer::dsp
