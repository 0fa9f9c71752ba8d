#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "dsp/filter/transient.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {

// a filtered signal and the part of it that does not depend on what lay beyond its ends
struct SettledSignal {
  std::vector<double> filtered;  // all of it, continued oddly
  std::size_t begin = 0;         // first settled sample
  std::size_t end = 0;           // one past the last; begin == end: nothing has settled
};

inline SettledSignal FilterSettled(const FilterDesign& design, std::span<const double> signal) {
  SettledSignal settled{FilterZeroPhase(design, signal)};
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
