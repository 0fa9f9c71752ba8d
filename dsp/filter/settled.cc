#include "dsp/filter/settled.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

// grows outwards from the middle of `size` samples as far as the dependence is within `tolerance`
SampleRange Grow(std::size_t size, const EndDependence& dependence, double tolerance) {
  const auto within = [&](double value) { return std::abs(value) <= tolerance; };
  const std::size_t middle = size / 2;
  // what neither part covers has settled
  const std::size_t last_from = size - dependence.last.size();
  std::size_t begin = std::min(middle, dependence.first.size());
  while (begin > 0 && within(dependence.first[begin - 1])) --begin;
  std::size_t end = std::max(middle, last_from);
  if (dependence.last.empty()) {
    end = middle;
    while (end < size && within(dependence.first[end])) ++end;
  } else {
    while (end < size && within(dependence.last[end - last_from])) ++end;
  }
  return {begin, end - begin};
}

}  // namespace

Result<EndDependence> MeasureEndDependence(const ZeroPhaseBlocks& blocks, const ReadSamples& read,
                                           ZeroPhaseBlocks::Scratch& scratch) {
  EndDependence dependence;
  const std::size_t size = blocks.size();
  const bool is_short = size <= 2 * blocks.lead_in();
  dependence.first.resize(is_short ? size : blocks.lead_in());
  dependence.last.resize(is_short ? 0 : blocks.lead_in());
  for (auto* part : {&dependence.first, &dependence.last}) {
    const std::size_t first = part == &dependence.first ? 0 : size - part->size();
    auto done = blocks.Filter(SampleRange{first, part->size()}, read,
                              Continuation::kOddLessConstant, *part, scratch);
    if (!done) return std::unexpected(done.error());
  }
  return dependence;
}

SampleRange SettledRange(std::size_t size, const EndDependence& dependence, const RangeRms& rms) {
  // the tolerance hangs on the RMS of what has settled: begin with everything and shrink
  SampleRange settled{0, size};
  for (std::size_t before = size + 1; settled.count > 0 && settled.count < before;) {
    before = settled.count;
    settled = Grow(size, dependence, kSettledTolerance * rms(settled));
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
