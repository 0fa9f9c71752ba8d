#include "dsp/filter/zero_phase.h"

#include <atomic>
#include <thread>

#include "base/error.h"

namespace haptometer::dsp {

std::vector<double> FilterZeroPhase(const FilterDesign& design, std::span<const double> signal,
                                    Continuation continuation, int threads) {
  HAPTOMETER_CHECK(threads >= 1, "threads = {}", threads);
  const ZeroPhaseBlocks blocks(design, signal.size());
  std::vector<double> filtered(signal.size());
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    ZeroPhaseBlocks::Scratch scratch;
    for (std::size_t block = next++; block < blocks.blocks(); block = next++) {
      const SampleRange range = blocks.Range(block);
      const std::span<double> out = std::span(filtered).subspan(range.first, range.count);
      blocks.Filter(block, signal, continuation, out, scratch);
    }
  };
  std::vector<std::jthread> helpers;
  helpers.reserve(static_cast<std::size_t>(threads - 1));
  for (int k = 1; k < threads; ++k) helpers.emplace_back(work);
  work();
  return filtered;
}

}  // namespace haptometer::dsp
