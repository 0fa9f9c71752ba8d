#include "dsp/filter/settled.h"

#include <algorithm>
#include <cmath>

#include "dsp/filter/zero_phase.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

// grows [begin, end) from the middle of `odd` outwards as far as both results agree to `tolerance`
void GrowWindow(std::span<const double> odd, std::span<const double> constant, double tolerance,
                SettledSignal& settled) {
  const std::size_t middle = odd.size() / 2;
  settled.begin = middle;
  while (settled.begin > 0 &&
         std::abs(odd[settled.begin - 1] - constant[settled.begin - 1]) <= tolerance) {
    --settled.begin;
  }
  settled.end = middle;
  while (settled.end < odd.size() &&
         std::abs(odd[settled.end] - constant[settled.end]) <= tolerance) {
    ++settled.end;
  }
}

}  // namespace

SettledSignal FilterSettled(const FilterDesign& design, std::span<const double> signal) {
  SettledSignal settled;
  settled.filtered = FilterZeroPhase(design, signal, Continuation::kOdd);
  const std::vector<double> constant = FilterZeroPhase(design, signal, Continuation::kConstant);
  const std::span<const double> odd = settled.filtered;

  // the tolerance hangs on the RMS of what has settled: begin with everything and shrink
  settled.end = odd.size();
  for (std::size_t before = odd.size() + 1; settled.end > settled.begin;) {
    const std::size_t size = settled.end - settled.begin;
    if (size >= before) break;
    before = size;
    const double tolerance = kSettledTolerance * Rms(odd.subspan(settled.begin, size));
    GrowWindow(odd, constant, tolerance, settled);
  }
  return settled;
}

}  // namespace haptometer::dsp
