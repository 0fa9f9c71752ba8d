#include "dsp/filter/settled.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "dsp/filter/expected_motion.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

// of the slow motion that is looked at and expected, in time constants of the slowest pole
constexpr double kSeenTimeConstants = 12;
constexpr double kExpectedTimeConstants = 8;

// `count` samples beyond the end of `signal`, nearest first: other continuations less the odd one
struct Differences {
  std::vector<double> constant;
  std::vector<double> expected;  // empty: nothing is expected
  std::vector<double> fast;      // as `constant`, of what is left without the slow motion
};

Differences BeyondEnd(const FilterDesign& design, std::span<const double> signal,
                      std::size_t count) {
  const double time_constant = design.rate_hz / SlowestDecayPerS(design);
  const auto seen =
      std::min(static_cast<std::size_t>(kSeenTimeConstants * time_constant), signal.size());
  const auto ahead = static_cast<std::size_t>(kExpectedTimeConstants * time_constant);
  Differences differences;
  differences.constant.reserve(count);
  for (std::size_t k = 1; k <= count; ++k) {
    differences.constant.push_back(signal[signal.size() - 1 - std::min(k, signal.size() - 1)] -
                                   signal.back());
  }
  if (seen < kLeastExpectedMotionSamples) return differences;
  const ExpectedMotion motion = FitExpectedMotion(signal.last(seen));
  const auto last = static_cast<double>(seen - 1);
  differences.expected = differences.constant;
  differences.fast.assign(count, 0);
  for (std::size_t k = 1; k <= std::min({ahead, count, seen - 1}); ++k) {
    const auto away = static_cast<double>(k);
    differences.expected[k - 1] += motion.At(last + away) - motion.At(last);
    differences.fast[k - 1] =
        differences.constant[k - 1] - motion.At(last - away) + motion.At(last);
  }
  return differences;
}

// what the filter makes, in `inner` samples, of `before` (nearest first) ahead of them and `after`
// behind them
std::vector<double> Inside(const FilterDesign& design, std::span<const double> before,
                           std::size_t inner, std::span<const double> after,
                           ZeroPhaseBlocks::Scratch& scratch) {
  std::vector<double> around(before.size() + inner + after.size());
  std::ranges::reverse_copy(before, around.begin());
  std::ranges::copy_backward(after, around.end());
  std::vector<double> inside(inner);
  const auto done = ZeroPhaseBlocks(design, around.size())
                        .Filter(SampleRange{before.size(), inner}, ReadFrom(around),
                                Continuation::kConstant, inside, scratch);
  HAPTOMETER_CHECK(done, "memory cannot fail");
  return inside;
}

// the dependence of `inner` samples on either end; an end that is far away has no differences
std::vector<double> DependenceOf(const FilterDesign& design, const Differences& before,
                                 std::size_t inner, const Differences& after,
                                 ZeroPhaseBlocks::Scratch& scratch) {
  std::vector<double> dependence(inner);
  const auto add = [&](std::span<const double> first, std::span<const double> last,
                       double tolerance) {
    const std::vector<double> filtered = Inside(design, first, inner, last, scratch);
    for (std::size_t k = 0; k < inner; ++k) {
      dependence[k] = std::max(dependence[k], std::abs(filtered[k]) / tolerance);
    }
  };
  if (before.expected.empty() && after.expected.empty()) {
    add(before.constant, after.constant, kFastTolerance);
  } else {
    add(before.constant, after.constant, kConstantTolerance);
    add(before.expected, after.expected, kExpectedTolerance);
    add(before.fast, after.fast, kFastTolerance);
  }
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

}  // namespace

Result<EndDependence> MeasureEndDependence(const ZeroPhaseBlocks& blocks, const ReadSamples& read,
                                           ZeroPhaseBlocks::Scratch& scratch) {
  const FilterDesign& design = blocks.design();
  const std::size_t size = blocks.size();
  const std::size_t lead_in = blocks.lead_in();
  EndDependence dependence;
  if (size == 0) return dependence;
  const bool is_short = size <= 2 * lead_in;
  const std::size_t seen = is_short ? size : lead_in + 1;
  std::vector<double> first(seen);
  std::vector<double> last(seen);
  if (auto done = read(0, first); !done) return std::unexpected(done.error());
  if (auto done = read(size - seen, last); !done) return std::unexpected(done.error());
  std::ranges::reverse(first);  // so that its end is the signal's begin
  const Differences before = BeyondEnd(design, first, lead_in);
  const Differences after = BeyondEnd(design, last, lead_in);
  if (is_short) {
    dependence.first = DependenceOf(design, before, size, after, scratch);
  } else {
    dependence.first = DependenceOf(design, before, lead_in, {}, scratch);
    dependence.last = DependenceOf(design, {}, lead_in, after, scratch);
  }
  return dependence;
}

SampleRange SettledRange(std::size_t size, const EndDependence& dependence, const RangeRms& rms) {
  // the limit hangs on the RMS of what has settled: begin with everything and shrink
  SampleRange settled{0, size};
  for (std::size_t before = size + 1; settled.count > 0 && settled.count < before;) {
    before = settled.count;
    settled = LongestWithin(size, dependence, rms(settled));
  }
  return settled;
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
  const SampleRange range = SettledRange(signal.size(), *dependence, [&](const SampleRange& part) {
    return Rms(filtered.subspan(part.first, part.count));
  });
  settled.begin = range.first;
  settled.end = range.end();
  return settled;
}

}  // namespace haptometer::dsp
