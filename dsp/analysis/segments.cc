#include "dsp/analysis/segments.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "base/error.h"
#include "dsp/analysis/faults.h"
#include "dsp/analysis/measured.h"

namespace haptometer::dsp {
namespace {

// least rate of a record whose gaps are interpolated, per upper corner
constexpr double kBridgeRatePerUpperCorner = 5;
// measured samples that the cubic takes on each side of a gap
constexpr std::size_t kSide = 2;
// rows before and after a block that decide on a gap within it: a gap, the rows on which its
// interpolation is tried, and one that ends the gap; and those that a visitor may need
constexpr std::size_t kMarginRows =
    std::max(2 * kLongestBridge + 2 * kSide + 1, kFaultMarginRows + 2);
static_assert(kPassRows % kFaultBlockRows == 0);

// rows [begin, end)
struct Rows {
  std::size_t begin = 0;
  std::size_t end = 0;
};

// the rows at hand: a block and its margins
class Window {
 public:
  // reads rows [block.begin, block.end) of `rows` with their margins
  Result<void> Load(const trial::RowSource& source, std::size_t channel, Rows block,
                    std::size_t rows) {
    record_rows_ = rows;
    block_ = block;
    held_.begin = block.begin - std::min(block.begin, kMarginRows);
    held_.end = block.end + std::min(rows - block.end, kMarginRows);
    values_.resize(held_.end - held_.begin);
    statuses_.resize(values_.size());
    if (auto read = source.Read(channel, held_.begin, values_, statuses_); !read) return read;
    all_ok_ = AllOk(statuses_) && AllFinite(values_);
    return {};
  }

  // whether every row held is measured and has the status kOk
  [[nodiscard]] bool all_ok() const { return all_ok_; }

  [[nodiscard]] Rows block() const { return block_; }
  [[nodiscard]] RowBlock AsBlock() const {
    return {block_.begin, block_.end, record_rows_, held_.begin, values_, statuses_, all_ok_};
  }

  [[nodiscard]] bool At(std::size_t row) const {
    return IsMeasured(values_[row - held_.begin], statuses_[row - held_.begin]);
  }
  [[nodiscard]] double Value(std::size_t row) const { return values_[row - held_.begin]; }
  // whether all of [begin, end) are at hand and measured
  [[nodiscard]] bool All(std::size_t begin, std::size_t end) const {
    if (begin < held_.begin || end > held_.end) return false;
    return FirstUnmeasured(begin, end) == end;
  }
  // the first row of [begin, end) without a measurement, or `end`
  [[nodiscard]] std::size_t FirstUnmeasured(std::size_t begin, std::size_t end) const {
    if (all_ok_) return std::max(begin, end);
    while (begin < end && At(begin)) ++begin;
    return begin;
  }
  // the first row of [begin, end) with a measurement, or the end of what is at hand
  [[nodiscard]] std::size_t FirstMeasured(std::size_t begin, std::size_t end) const {
    end = std::min(end, held_.end);
    while (begin < end && !At(begin)) ++begin;
    return begin;
  }

 private:
  std::size_t record_rows_ = 0;
  Rows block_;
  Rows held_;
  bool all_ok_ = false;
  std::vector<double> values_;
  std::vector<trial::SampleStatus> statuses_;
};

// Lagrange's cubic through the two samples before and after `size` rows at `first`, at first + k
double Bridged(const Window& window, std::size_t first, std::size_t size, std::size_t k) {
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
    sum += weight * window.Value(rows[i]);
  }
  return sum;
}

// squared error of the same interpolation for `size` rows at `first` that are all known
double KnownErrorSquareSum(const Window& window, std::size_t first, std::size_t size) {
  double sum = 0;
  for (std::size_t k = 0; k < size; ++k) {
    const double error = Bridged(window, first, size, k) - window.Value(first + k);
    sum += error * error;
  }
  return sum;
}

// Squared error of interpolating the gap, estimated on the nearest known rows on either side;
// nothing where the gap has no two neighbours or neither side can be tried.
std::optional<double> BridgeErrorSquareSum(const Window& window, Rows stretch, Rows hole) {
  const std::size_t size = hole.end - hole.begin;
  const auto known = [&](std::size_t begin, std::size_t end) {
    return begin >= stretch.begin && end <= stretch.end && window.All(begin, end);
  };
  // two measured samples on each side, at the same rate and without a break of the times
  if (size > kLongestBridge || hole.begin < stretch.begin + kSide ||
      !known(hole.begin - kSide, hole.begin) || !known(hole.end, hole.end + kSide)) {
    return std::nullopt;
  }
  // known rows as many as the gap, with two neighbours on either side
  const std::size_t span = size + 2 * kSide;
  std::optional<double> worst;
  if (hole.begin >= stretch.begin + span && known(hole.begin - span, hole.begin)) {
    worst = KnownErrorSquareSum(window, hole.begin - kSide - size, size);
  }
  if (known(hole.end, hole.end + span)) {
    const double after = KnownErrorSquareSum(window, hole.end + kSide, size);
    worst = std::max(worst.value_or(0), after);
  }
  // values whose cubes overflow are not interpolated
  if (worst && !std::isfinite(*worst)) return std::nullopt;
  return worst;
}

// Collects the segments of a record block by block. A gap is decided on where it begins, with the
// window's margins; one that is too long to interpolate ends the segment.
class Splitter {
 public:
  Splitter(const trial::Record& head, double upper_hz, Segments& segments)
      : stretches_(head.stretches), upper_hz_(upper_hz), segments_(segments) {}

  void Take(const Window& window) {
    while (next_row_ < window.block().end) {
      const trial::Stretch& stretch = stretches_[stretch_];
      const Rows all{stretch.first_row, stretch.first_row + stretch.rows};
      // a segment never exceeds its `Stretch` of rows at one rate
      TakePart(window, all, std::min(all.end, window.block().end));
      if (next_row_ < all.end) continue;
      Finish(all.end);
      next_row_ = all.end;
      ++stretch_;
    }
  }

 private:
  // rows of one `Stretch` up to `end`, and those of a gap that begins before it
  void TakePart(const Window& window, Rows all, std::size_t end) {
    while (next_row_ < end) {
      const std::size_t bad = window.FirstUnmeasured(next_row_, end);
      if (bad > next_row_) Begin(next_row_);
      next_row_ = bad;
      if (bad < end) TakeHole(window, all, {bad, window.FirstMeasured(bad, all.end)});
    }
  }

  void TakeHole(const Window& window, Rows all, Rows hole) {
    next_row_ = hole.end;
    // interpolation needs a rate far above the band, and measured neighbours
    const bool may_bridge = stretches_[stretch_].rate_hz >= kBridgeRatePerUpperCorner * upper_hz_;
    const std::optional<double> error_square_sum =
        may_bridge ? BridgeErrorSquareSum(window, all, hole) : std::nullopt;
    if (!error_square_sum) return Finish(hole.begin);
    for (std::size_t row = hole.begin; row < hole.end; ++row) {
      segment_.bridges.push_back(
          {row - segment_.first_row,
           Bridged(window, hole.begin, hole.end - hole.begin, row - hole.begin)});
    }
    segment_.bridged_error_square_sum += *error_square_sum;
  }

  void Begin(std::size_t row) {
    if (open_) return;
    const trial::Stretch& stretch = stretches_[stretch_];
    segment_.first_row = row;
    segment_.rate_hz = stretch.rate_hz;
    segment_.time_uncertainty_s = stretch.time_uncertainty_s;
    segment_.start_s =
        stretch.start_s + static_cast<double>(row - stretch.first_row) / stretch.rate_hz;
    open_ = true;
  }

  // closes the segment before `end_row`
  void Finish(std::size_t end_row) {
    if (!open_) return;
    segment_.size = end_row - segment_.first_row;
    segments_.bridged += segment_.bridges.size();
    segments_.parts.push_back(std::exchange(segment_, {}));
    open_ = false;
  }

  const std::vector<trial::Stretch>& stretches_;
  double upper_hz_;
  Segments& segments_;
  std::size_t stretch_ = 0;   // the one that next_row_ lies in
  std::size_t next_row_ = 0;  // all before it are decided on
  bool open_ = false;         // whether segment_ has begun
  Segment segment_;
};

// rows of each status, and measured ones
void Count(const Window& window, Segments& segments) {
  const auto values = window.AsBlock().values();
  const auto statuses = window.AsBlock().statuses();
  if (window.all_ok()) {
    segments.by_status[0] += values.size();
    segments.measured += values.size();
    return;
  }
  for (std::size_t k = 0; k < values.size(); ++k) {
    ++segments.by_status[static_cast<std::size_t>(statuses[k])];
    segments.measured += IsMeasured(values[k], statuses[k]) ? 1 : 0;
  }
}

}  // namespace

Result<Segments> SplitIntoSegments(const trial::RowSource& source, std::size_t channel,
                                   double upper_hz, const RowVisitor& visit, int threads) {
  const trial::Record& head = source.head();
  Segments segments;
  Splitter splitter(head, upper_hz, segments);
  const std::size_t blocks = (head.rows + kPassRows - 1) / kPassRows;
  const auto done = RunJobsInOrder(blocks, threads, [&]() -> OrderedWorker {
    // blocks are read and visited in parallel; counts and segments follow in order of the blocks
    return [&, window = Window()](std::size_t job) mutable -> Result<Finish> {
      const std::size_t row = job * kPassRows;
      const Rows block{row, row + std::min(kPassRows, head.rows - row)};
      if (auto loaded = window.Load(source, channel, block, head.rows); !loaded) {
        return std::unexpected(loaded.error());
      }
      return [&, visited = visit ? visit(window.AsBlock()) : Finish()]() mutable {
        Count(window, segments);
        splitter.Take(window);
        if (visited) visited();
      };
    };
  });
  if (!done) return std::unexpected(done.error());
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
    if (auto read = source_->Read(channel_, segment_->first_row + first + at, piece,
                                  std::span(statuses.get(), piece.size()));
        !read) {
      return read;
    }
  }
  // interpolated samples replace the unmeasured ones
  auto bridge = std::ranges::lower_bound(segment_->bridges, first, {}, &Bridge::sample);
  for (; bridge != segment_->bridges.end() && bridge->sample - first < out.size(); ++bridge) {
    out[bridge->sample - first] = bridge->value;
  }
  return {};
}

}  // namespace haptometer::dsp
