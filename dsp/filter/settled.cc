#include "dsp/filter/settled.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "dsp/filter/end_continuations.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

// what lies two time constants beyond a settled part is wrong by e^2 / 1e4: enough for an RMS
constexpr double kRmsTimeConstants = 4;

// what the filter makes, in the `inner` samples of a signal, of what lies beyond them
class Inside {
 public:
  Inside(const ZeroPhaseBlocks& blocks, std::size_t inner, ZeroPhaseBlocks::Scratch& scratch)
      : blocks_(blocks), filtered_(inner), scratch_(scratch) {}

  // of `before` ahead of them and `after` behind them, where there are any; valid until the next
  // call
  std::span<const double> Of(std::span<const double> before, std::span<const double> after) {
    if (after.empty()) {
      blocks_.FilterAhead(before, filtered_, scratch_);
      return filtered_;
    }
    blocks_.FilterAhead(after, filtered_, scratch_);
    std::ranges::reverse(filtered_);
    if (before.empty()) return filtered_;
    ahead_.resize(filtered_.size());
    blocks_.FilterAhead(before, ahead_, scratch_);
    for (std::size_t k = 0; k < filtered_.size(); ++k) filtered_[k] += ahead_[k];
    return filtered_;
  }

 private:
  const ZeroPhaseBlocks& blocks_;
  std::vector<double> filtered_;
  std::vector<double> ahead_;
  ZeroPhaseBlocks::Scratch& scratch_;
};

// the dependence of `inner` samples on either end; an end that is far away has no continuations
std::vector<double> DependenceOf(const ZeroPhaseBlocks& blocks, const EndContinuations& before,
                                 std::size_t inner, const EndContinuations& after,
                                 ZeroPhaseBlocks::Scratch& scratch) {
  Inside inside(blocks, inner, scratch);
  std::vector<double> dependence(inner);
  const auto add = [&](std::span<const double> filtered, double tolerance) {
    for (std::size_t k = 0; k < inner; ++k) {
      dependence[k] = std::max(dependence[k], std::abs(filtered[k]) / tolerance);
    }
  };
  const std::span<const double> constant = inside.Of(before.constant, after.constant);
  if (before.expected.empty() && after.expected.empty()) {
    add(constant, kFastTolerance);
    return dependence;
  }
  add(constant, kConstantTolerance);
  std::vector<double> expected(constant.begin(), constant.end());
  const std::span<const double> change = inside.Of(before.expected, after.expected);
  for (std::size_t k = 0; k < inner; ++k) expected[k] = std::abs(expected[k] + change[k]);
  for (std::size_t doubt = 0; doubt < before.doubts.size(); ++doubt) {
    const std::span<const double> more = inside.Of(before.doubts[doubt], after.doubts[doubt]);
    for (std::size_t k = 0; k < inner; ++k) expected[k] += std::abs(more[k]);
  }
  add(expected, kExpectedTolerance);
  add(inside.Of(before.fast, after.fast), kFastTolerance);
  return dependence;
}

// the longest of the stretches in which the dependence is at most `limit`
class LongestStretch {
 public:
  // `count` further samples that all have settled, or not
  void Add(bool settled, std::size_t count) {
    at_ += count;
    if (!settled) {
      begin_ = at_;
    } else if (at_ - begin_ > longest_.count) {
      longest_ = {begin_, at_ - begin_};
    }
  }
  [[nodiscard]] SampleRange longest() const { return longest_; }

 private:
  std::size_t at_ = 0;
  std::size_t begin_ = 0;  // of the stretch at hand
  SampleRange longest_;
};

SampleRange LongestWithin(std::size_t size, const EndDependence& dependence, double limit) {
  LongestStretch stretch;
  for (const double value : dependence.first) stretch.Add(value <= limit, 1);
  stretch.Add(true, size - dependence.first.size() - dependence.last.size());
  for (const double value : dependence.last) stretch.Add(value <= limit, 1);
  return stretch.longest();
}

// a range of `least` values or more of `size` about the same middle
SampleRange Widened(const SampleRange& range, std::size_t size, std::size_t least) {
  if (range.count >= least) return range;
  const std::size_t count = std::min(least, size);
  const std::size_t middle = range.first + range.count / 2;
  const std::size_t first = middle - std::min(middle, count / 2);
  return {std::min(first, size - count), count};
}

}  // namespace

Result<EndDependence> MeasureEndDependence(const ZeroPhaseBlocks& blocks, const ReadSamples& read,
                                           ZeroPhaseBlocks::Scratch& scratch) {
  const FilterDesign& design = blocks.design();
  const std::size_t size = blocks.size();
  const std::size_t lead_in = blocks.lead_in();
  EndDependence dependence;
  if (size == 0) return dependence;
  const bool is_short = size <= 2 * lead_in;
  std::vector<double> seen(is_short ? size : lead_in + 1);
  if (auto done = read(0, seen); !done) return std::unexpected(done.error());
  std::ranges::reverse(seen);  // so that its end is the signal's begin
  const EndContinuations before = ContinueEnd(design, seen, lead_in);
  if (!is_short) dependence.first = DependenceOf(blocks, before, lead_in, {}, scratch);
  if (auto done = read(size - seen.size(), seen); !done) return std::unexpected(done.error());
  const EndContinuations after = ContinueEnd(design, seen, lead_in);
  if (is_short) {
    dependence.first = DependenceOf(blocks, before, size, after, scratch);
  } else {
    dependence.last = DependenceOf(blocks, {}, lead_in, after, scratch);
  }
  return dependence;
}

SampleRange SettledRange(std::size_t size, const EndDependence& dependence, const RangeRms& rms,
                         std::size_t least) {
  // the limit hangs on the RMS of what has settled: begin with everything and shrink
  SampleRange settled{0, size};
  for (std::size_t before = size + 1; settled.count > 0 && settled.count < before;) {
    before = settled.count;
    settled = LongestWithin(size, dependence, rms(Widened(settled, size, least)));
  }
  return settled;
}

std::size_t LeastRmsSamples(const FilterDesign& design) {
  return static_cast<std::size_t>(kRmsTimeConstants * design.rate_hz / SlowestDecayPerS(design));
}

SettledSignal FilterSettled(const FilterDesign& design, std::span<const double> signal,
                            int threads) {
  SettledSignal settled;
  settled.filtered = FilterZeroPhase(design, signal, Continuation::kOdd, threads);
  ZeroPhaseBlocks::Scratch scratch;
  const auto dependence =
      MeasureEndDependence(ZeroPhaseBlocks(design, signal.size()), ReadFrom(signal), scratch);
  HAPTOMETER_CHECK(dependence, "memory cannot fail");
  const std::span<const double> filtered = settled.filtered;
  const SampleRange range = SettledRange(
      signal.size(), *dependence,
      [&](const SampleRange& part) { return Rms(filtered.subspan(part.first, part.count)); },
      LeastRmsSamples(design));
  settled.begin = range.first;
  settled.end = range.end();
  return settled;
}

}  // namespace haptometer::dsp
