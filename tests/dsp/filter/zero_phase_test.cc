#include "dsp/filter/zero_phase.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numbers>
#include <tuple>
#include <vector>

#include "dsp/filter/cascade.h"
#include "tests/dsp/filter/exact_filter.h"
#include "tests/dsp/filter/scipy_reference.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

std::vector<FilterDesign> EveryDesign(double rate_hz) {
  std::vector<FilterDesign> designs;
  designs.reserve(kHighestOrder);
  for (int order = 1; order <= kHighestOrder; ++order) {
    designs.push_back(DesignBandPass({order, 20, 500}, rate_hz).value());
  }
  return designs;
}

bool SameBytes(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

// all blocks, in the order given by `stride` (coprime to their number), read `chunk` at a time
std::vector<double> ByBlocks(const ZeroPhaseBlocks& blocks, const std::vector<double>& in,
                             std::size_t stride, std::size_t chunk) {
  const ReadSamples read = [&](std::size_t first, std::span<double> out) -> Result<void> {
    EXPECT_LE(first + out.size(), in.size());
    for (std::size_t k = 0; k < out.size(); k += chunk) {
      const std::size_t count = std::min(chunk, out.size() - k);
      std::copy_n(&in[first + k], count, &out[k]);
    }
    return {};
  };
  std::vector<double> out(in.size());
  ZeroPhaseBlocks::Scratch scratch;
  std::vector<ZeroPhaseBlocks::PieceStates> states(blocks.pieces());
  const auto take = [&](std::size_t first, std::span<double> samples) {
    std::ranges::copy(samples, &out[first]);
  };
  for (std::size_t k = 0; k < blocks.blocks(); ++k) {
    EXPECT_TRUE(blocks.FilterPieces(k * stride % blocks.blocks(), read, take, states, scratch));
  }
  return out;
}

TEST(ZeroPhaseBlocks, EveryInstructionSetGivesTheSameBytes) {
  const std::vector<double> in = HandHeld(2e3, 10);
  for (const FilterDesign& design : EveryDesign(2e3)) {
    const std::vector<double> baseline =
        ByBlocks(ZeroPhaseBlocks(design, in.size(), InstructionSet::kBaseline), in, 1, 4096);
    for (const InstructionSet set : kInstructionSets) {
      if (!IsSupported(set)) continue;
      EXPECT_TRUE(
          SameBytes(ByBlocks(ZeroPhaseBlocks(design, in.size(), set), in, 1, 4096), baseline))
          << Name(set) << ", order " << design.order;
    }
  }
}

// Recorded once: no function of the C library takes part, so that designs and filtered samples have
// the same bytes from g++ and clang++, with and without fused products in the C library.
TEST(ZeroPhase, BytesAreThoseOfEachProcessorAndCompiler) {
  std::uint32_t state = 1;
  std::vector<double> in(20000);
  // whole numbers of a congruential generator
  for (double& sample : in) sample = (state = state * 1664525 + 1013904223) >> 12;
  // FNV-1a
  std::uint64_t hash = 14695981039346656037U;
  for (const double rate_hz : {1.5e3, 2e3, 10e3, 392e3}) {
    for (const FilterDesign& design : EveryDesign(rate_hz)) {
      for (const double sample : FilterZeroPhase(design, in)) {
        hash = (hash ^ std::bit_cast<std::uint64_t>(sample)) * 1099511628211U;
      }
    }
  }
  EXPECT_EQ(hash, 3426228421409753416U);
}

TEST(ZeroPhaseBlocks, ChunksOrderOfBlocksAndThreadsLeaveTheBytes) {
  const FilterDesign design = DesignBandPass({3, 100, 300}, 2e3).value();
  const std::vector<double> in = HandHeld(2e3, 150);  // 5 blocks, the last one not whole
  const ZeroPhaseBlocks blocks(design, in.size());
  ASSERT_EQ(blocks.blocks(), 5U);
  const std::vector<double> whole = FilterZeroPhase(design, in);
  for (const std::size_t chunk : {std::size_t{1}, std::size_t{7}, std::size_t{4096}, in.size()}) {
    EXPECT_TRUE(SameBytes(ByBlocks(blocks, in, 1, chunk), whole)) << chunk;
  }
  EXPECT_TRUE(SameBytes(ByBlocks(blocks, in, 3, 4096), whole));
  EXPECT_TRUE(SameBytes(FilterZeroPhase(design, in, 2), whole));
}

// the oracle is a block that is filtered piece by piece, to where nothing else lies
std::vector<double> ByPieces(const ZeroPhaseBlocks& blocks, const std::vector<double>& in) {
  std::vector<ZeroPhaseBlocks::PieceStates> states(blocks.pieces());
  std::vector<double> out(in.size());
  ZeroPhaseBlocks::Scratch scratch;
  const auto take = [&](std::size_t first, std::span<double> samples) {
    std::ranges::copy(samples, &out[first]);
  };
  EXPECT_TRUE(blocks.FilterPieces(0, ReadFrom(in), take, states, scratch));
  return out;
}

TEST(ZeroPhaseBlocks, ABlockWritesItsOutputOnlyWhereverThatLies) {
  constexpr double kUntouched = 17;
  const FilterDesign design = DesignBandPass({3, 100, 300}, 2e3).value();
  for (const std::size_t tiles : {1UZ, 2UZ, 3UZ, 6UZ}) {
    for (const std::size_t past : {1UZ, 2UZ, kTileSamples}) {
      std::vector<double> in = HandHeld(2e3, 13);
      in.resize((tiles - 1) * kTileSamples + past);
      const ZeroPhaseBlocks blocks(design, in.size());
      ASSERT_EQ(blocks.blocks(), 1U);
      const std::vector<double> expected = ByPieces(blocks, in);
      ZeroPhaseBlocks::Scratch scratch;
      for (std::size_t offset = 0; offset < 8; ++offset) {  // from a multiple of 64 bytes
        std::vector<double> place(in.size() + 8, kUntouched);
        blocks.Filter(0, in, std::span(place).subspan(offset, in.size()), scratch);
        const auto begin = place.begin() + static_cast<std::ptrdiff_t>(offset);
        const auto end = begin + std::ssize(in);
        EXPECT_TRUE(std::ranges::equal(std::span(begin, end), expected)) << tiles << ' ' << offset;
        EXPECT_EQ(std::count(place.begin(), begin, kUntouched), begin - place.begin());
        EXPECT_EQ(std::count(end, place.end(), kUntouched), place.end() - end);
      }
    }
  }
}

TEST(ZeroPhaseBlocks, PiecesAreTheBlocksAndCanBeFilteredAgain) {
  const FilterDesign design = DesignBandPass({3, 20, 300}, 2e3).value();
  const std::vector<double> in = HandHeld(2e3, 140);  // 5 blocks, 9 pieces, the last not whole
  const ZeroPhaseBlocks blocks(design, in.size());
  ASSERT_EQ(blocks.blocks(), 5U);
  ASSERT_EQ(blocks.pieces(), 9U);
  const std::vector<double> whole = FilterZeroPhase(design, in);
  std::vector<ZeroPhaseBlocks::PieceStates> states(blocks.pieces());
  std::vector<double> taken(in.size());
  ZeroPhaseBlocks::Scratch scratch;
  for (std::size_t block = 0; block < blocks.blocks(); ++block) {
    const auto take = [&](std::size_t first, std::span<double> samples) {
      std::ranges::copy(samples, &taken[first]);
    };
    EXPECT_TRUE(blocks.FilterPieces(block, ReadFrom(in), take, states, scratch));
  }
  EXPECT_TRUE(SameBytes(taken, whole));
  std::vector<double> again(in.size());
  for (std::size_t k = blocks.pieces(); k-- > 0;) {
    const SampleRange range = blocks.PieceRange(k);
    EXPECT_TRUE(blocks.FilterPiece(k, states[k], ReadFrom(in),
                                   std::span(again).subspan(range.first, range.count), scratch));
  }
  EXPECT_TRUE(SameBytes(again, whole));
}

// the oracle is the filter over all of it, with zeros in the signal's place and around it
TEST(ZeroPhaseBlocks, SamplesAheadAreFilteredAlone) {
  for (const int order : {2, 3, 6}) {
    const FilterDesign design = DesignBandPass({order, 20, 500}, 5e3).value();
    const ZeroPhaseBlocks blocks(design, 1000);
    std::vector<double> before = HandHeld(5e3, 30);
    before.resize(blocks.lead_in());
    for (const std::size_t inner : {std::size_t{1}, std::size_t{700}, blocks.lead_in()}) {
      std::vector<double> all(blocks.lead_in());
      all.insert(all.end(), before.rbegin(), before.rend());
      const std::size_t first = all.size();
      all.resize(first + inner + blocks.lead_in());
      const std::vector<double> expected = FilterZeroPhase(design, all);
      std::vector<double> out(inner);
      ZeroPhaseBlocks::Scratch scratch;
      blocks.FilterAhead(before, out, scratch);
      double largest = 0;
      for (std::size_t k = 0; k < inner; ++k) {
        largest = std::max(largest, std::abs(out[k] - expected[first + k]));
      }
      EXPECT_ABS(largest, 0, 3e-20, "what a lead-in leaves of 30 mm");
    }
  }
}

// two passes of the scalar cascade over the signal with its continuation
std::vector<double> ByCascade(const FilterDesign& design, const std::vector<double>& in,
                              std::size_t padding) {
  const auto size = static_cast<std::ptrdiff_t>(in.size());
  std::vector<double> padded;
  padded.reserve(in.size() + 2 * padding);
  const auto wide = static_cast<std::ptrdiff_t>(padding);
  const std::ptrdiff_t reach = size - 1;
  for (std::ptrdiff_t k = -wide; k < size + wide; ++k) {
    const std::ptrdiff_t at = std::clamp(k, -reach, size - 1 + reach);
    const auto value = [&](std::ptrdiff_t index) { return in[static_cast<std::size_t>(index)]; };
    if (at < 0) {
      padded.push_back(2 * value(0) - value(-at));
    } else if (at >= size) {
      padded.push_back(2 * value(size - 1) - value(2 * (size - 1) - at));
    } else {
      padded.push_back(value(std::clamp<std::ptrdiff_t>(at, 0, size - 1)));
    }
  }
  for (int pass = 0; pass < 2; ++pass) {
    Cascade cascade(design);
    cascade.StartFrom(padded.front());
    cascade.Process(padded, padded);
    std::ranges::reverse(padded);
  }
  return {padded.begin() + wide, padded.begin() + wide + size};
}

TEST(ZeroPhaseBlocks, AreTheTwoPassesOfTheCascade) {
  for (const std::size_t size : {1UZ, 2UZ, 100UZ, 4032UZ, 4033UZ, 12'345UZ}) {
    std::vector<double> in = HandHeld(2e3, 10);
    in.resize(size);
    for (const FilterDesign& design : EveryDesign(2e3)) {
      const std::size_t padding = ZeroPhaseBlocks(design, size).lead_in();
      const std::vector<double> expected = ByCascade(design, in, padding);
      const std::vector<double> actual = FilterZeroPhase(design, in);
      double worst = 0;
      double most = 1e-9;
      for (std::size_t k = 0; k < size; ++k) {
        worst = std::max(worst, std::abs(actual[k] - expected[k]));
        most = std::max(most, std::abs(expected[k]));
      }
      EXPECT_ABS(worst / most, 0, 1e-12, "rounding, and the seam of blocks");
    }
  }
}

TEST(ZeroPhaseBlocks, SeamsAreBelowRoundingUnderTremorAThousandTimesTheTone) {
  const FilterDesign design = DesignBandPass({6, 20, 500}, 2e3).value();
  const std::vector<double> in = HandHeld(2e3, 200);
  const ZeroPhaseBlocks blocks(design, in.size());
  ASSERT_GT(blocks.blocks(), 4U);
  const std::vector<double> expected = ByCascade(design, in, blocks.lead_in());
  const double error = RelativeRmsError(FilterZeroPhase(design, in), expected, 0);
  EXPECT_ABS(error, 0, 1e-13, "double's rounding");
}

// forward in 113 bits, rounded, backward in 113 bits
std::vector<double> QuadZeroPhase(const FilterDesign& design, const std::vector<double>& in) {
  std::vector<double> turned = QuadFiltered(design, in, in.front());
  std::ranges::reverse(turned);
  turned = QuadFiltered(design, turned, turned.front());
  std::ranges::reverse(turned);
  return turned;
}

TEST(ZeroPhaseBlocks, LoseNothingToAnOffsetAndTremor) {
  for (const double rate_hz : {10e3, 392e3}) {
    const std::vector<double> in = HandHeld(rate_hz, 1.8);
    const int order = 4;
    const FilterDesign design = Designed({order, 20, 500, Corners::kWhole}, rate_hz);
    const std::vector<double> exact = QuadZeroPhase(design, in);
    const std::vector<double> out = FilterZeroPhase(design, in);
    // the middle: both ends have rung out to 1e-15
    double error = 0;
    double power = 0;
    const auto edge = static_cast<std::size_t>(0.85 * rate_hz);
    for (std::size_t k = edge; k < in.size() - edge; ++k) {
      error += (out[k] - exact[k]) * (out[k] - exact[k]);
      power += exact[k] * exact[k];
    }
    EXPECT_ABS(std::sqrt(error / power), 0, 1e-13, "double's rounding of the state");
  }
}

TEST(ZeroPhaseBlocks, AConstantComesOutAsNothing) {
  const std::vector<double> in(10'000, 0.0301234567);
  for (const FilterDesign& design : EveryDesign(2e3)) {
    for (const double y : FilterZeroPhase(design, in)) {
      ASSERT_LE(std::abs(y), 1e-15 * in[0]) << design.order;
    }
  }
}

TEST(ZeroPhaseBlocks, HugeSignalsHaveARightGrid) {
  const FilterDesign design = Designed({6, 20, 500}, 392e3);
  for (const std::size_t size : {1'000'000'000UZ, 100'000'000'007UZ}) {
    const ZeroPhaseBlocks blocks(design, size);
    const SampleRange last = blocks.Range(blocks.blocks() - 1);
    EXPECT_EQ(last.end(), size);
    EXPECT_GE(last.count, 1U);
    EXPECT_LE(last.count, blocks.block_size());
    EXPECT_EQ(blocks.Range(blocks.blocks() - 2).end(), last.first);
    EXPECT_EQ(last.first, (blocks.blocks() - 1) * blocks.block_size());
  }
  // a block near the end of 5e9 samples of a source that is computed: the same bytes as of 3
  // blocks
  const FilterDesign small = DesignBandPass({2, 100, 300}, 2e3).value();
  const auto periodic = [](std::size_t first, std::span<double> out) -> Result<void> {
    for (std::size_t k = 0; k < out.size(); ++k) {
      out[k] = static_cast<double>((first + k) % 96) * 1e-6;  // 96 divides the block's size
    }
    return {};
  };
  const ZeroPhaseBlocks near(small, 1'000'000);
  const ZeroPhaseBlocks far(small, 5'000'000'000UZ);
  ASSERT_EQ(near.block_size() % 96, 0U);
  const auto filtered = [&](const ZeroPhaseBlocks& blocks, std::size_t block) {
    std::vector<double> out(blocks.block_size());
    std::vector<ZeroPhaseBlocks::PieceStates> states(blocks.pieces());
    ZeroPhaseBlocks::Scratch scratch;
    const auto take = [&](std::size_t first, std::span<double> samples) {
      std::ranges::copy(samples, &out[first - blocks.Range(block).first]);
    };
    EXPECT_TRUE(blocks.FilterPieces(block, periodic, take, states, scratch));
    return out;
  };
  EXPECT_TRUE(SameBytes(filtered(far, far.blocks() - 3), filtered(near, 2)));
}

TEST(ZeroPhaseBlocks, AReadThatFailsEndsTheBlock) {
  const ZeroPhaseBlocks blocks(Designed({2, 20, 500}, 10e3), 1000);
  const ReadSamples broken = [](std::size_t, std::span<double>) -> Result<void> {
    return CannotAnswer("file", "is cut short", "copy it again");
  };
  std::vector<ZeroPhaseBlocks::PieceStates> states(blocks.pieces());
  ZeroPhaseBlocks::Scratch scratch;
  EXPECT_FALSE(blocks.FilterPieces(0, broken, [](auto...) {}, states, scratch));
}

// whether this thread takes subnormal numbers for 0
struct Flushed {
  bool results = false;
  bool inputs = false;
  bool operator==(const Flushed&) const = default;
};
constexpr Flushed kBoth{true, true};
constexpr Flushed kNeither{false, false};

Flushed FlushedNow() {
  const volatile double least = std::numeric_limits<double>::min();
  const volatile double below = std::numeric_limits<double>::denorm_min();
  return {least / 2 == 0, below * 0x1p60 == 0};
}

TEST(ZeroPhaseBlocks, SilenceLeavesNoSubnormalNumbers) {
  // after a click the state decays through 1e-308 within 18 s
  std::vector<double> in(100'000, 0.0);
  in[0] = 1e-6;
  for (const FilterDesign& design : EveryDesign(2e3)) {
    std::vector<double> causal(in.size());
    Cascade cascade(design);
    cascade.Process(in, causal);
    for (const auto& out : {causal, FilterZeroPhase(design, in)}) {
      for (const double y : out) ASSERT_NE(std::fpclassify(y), FP_SUBNORMAL) << design.order;
    }
    EXPECT_LT(std::abs(causal.back()), 1e-300);
  }
}

TEST(ZeroPhaseBlocks, TheCallersModeStands) {
  const std::vector<double> in(1000, 1.0);
  const FilterDesign design = Designed({2, 20, 500}, 2e3);
  ASSERT_EQ(FlushedNow(), kNeither);
  (void)FilterZeroPhase(design, in);
  EXPECT_EQ(FlushedNow(), kNeither);
  {
    const FlushSubnormals flush;
    EXPECT_EQ(FlushedNow(), kBoth);
    (void)FilterZeroPhase(design, in);
    EXPECT_EQ(FlushedNow(), kBoth);
  }
  EXPECT_EQ(FlushedNow(), kNeither);
}

constexpr double kRateHz = 10e3;

TEST(ZeroPhase, AToneKeepsItsPhaseAndHasTheSquaredGain) {
  for (int order = 1; order <= kHighestOrder; ++order) {
    const FilterDesign design = Designed({order, 20, 500}, kRateHz);
    const std::vector<double> in = Samples(kRateHz, 60'000, 0.03, {{1e-6, 450, 0.3}});
    const std::vector<double> out = FilterZeroPhase(design, in);
    const double gain = std::norm(Response(design, 450));
    double worst_m = 0;
    for (std::size_t k = 29'000; k < 31'000; ++k) {
      const double phase = 2 * std::numbers::pi * 450 * static_cast<double>(k) / kRateHz + 0.3;
      worst_m = std::max(worst_m, std::abs(out[k] - gain * 1e-6 * std::sin(phase)));
    }
    EXPECT_ABS(worst_m, 0, 2e-17, "the input's own rounding at 30 mm, 3.5e-18 m");
  }
}

TEST(ZeroPhase, IsTheFilterOfScipyWhereThePaddingAgrees) {
  const std::vector<double> in = ScipyInput(kScipySamples);
  for (const FilteredSample& sample : kScipyFiltered) {
    const FilterDesign design = Designed({sample.order, 20, 500, Corners::kEach}, kRateHz);
    EXPECT_ABS(FilterZeroPhase(design, in)[sample.index], sample.zero_phase_m, 1e-12,
               "what 0.3 s of SciPy's padding leave at order 5, exp(-0.3 s x 38/s) of 0.1 um");
  }
}

TEST(ZeroPhase, ATurnedSignalGivesTheTurnedResult) {
  const FilterDesign design = Designed({6, 20, 500}, kRateHz);
  std::vector<double> in = Samples(kRateHz, 20'000, 0.03, {{1e-6, 100}, {3e-7, 333, 1}});
  const std::vector<double> out = FilterZeroPhase(design, in);
  std::ranges::reverse(in);
  const std::vector<double> turned = FilterZeroPhase(design, in);
  double worst_m = 0;
  for (std::size_t k = 0; k < in.size(); ++k) {
    worst_m = std::max(worst_m, std::abs(turned[in.size() - 1 - k] - out[k]));
  }
  EXPECT_ABS(worst_m, 0, 1e-16, "what the padding leaves");
}

TEST(ZeroPhase, ShortSignalsAreContinuedAsFarAsTheyReach) {
  const FilterDesign design = Designed({6, 20, 500}, kRateHz);
  EXPECT_TRUE(FilterZeroPhase(design, {}).empty());
  EXPECT_EQ(FilterZeroPhase(design, std::vector{0.03}), std::vector{0.0});
  for (const double y : FilterZeroPhase(design, std::vector{0.03, 0.03, 0.03})) EXPECT_EQ(y, 0);
  // two samples: a step, odd about each
  const std::vector<double> step = FilterZeroPhase(design, std::vector{0.0, 1e-6});
  EXPECT_NEAR(step[0], -step[1], 1e-20);
}

TEST(ZeroPhase, RingingIsTheSlowestPoles) {
  const FilterDesign design = Designed({6, 20, 500}, kRateHz);
  const auto samples = static_cast<double>(RingingSamples(design, 1e-6));
  EXPECT_NEAR(samples / kRateHz, std::log(1e6) / SlowestDecayPerS(design), 1 / kRateHz);
}

TEST(ZeroPhaseDeathTest, RangesAndSizesAreChecked) {
  const FilterDesign design = Designed({2, 20, 500}, 2e3);
  const std::vector<double> in(1000, 1.0);
  const ZeroPhaseBlocks blocks(design, in.size());
  std::vector<double> out(in.size() + 1);
  ZeroPhaseBlocks::Scratch scratch;
  EXPECT_DEATH(static_cast<void>(blocks.Range(blocks.blocks())), "check failed");
  EXPECT_DEATH(static_cast<void>(blocks.PieceRange(blocks.pieces())), "check failed");
  EXPECT_DEATH(blocks.Filter(0, in, out, scratch), "check failed");
  EXPECT_DEATH(FilterZeroPhase(design, in, out, 1), "check failed");
  EXPECT_DEATH(static_cast<void>(FilterZeroPhase(design, in, 0)), "check failed");
  const std::vector<double> before(blocks.lead_in() + 1);
  EXPECT_DEATH(blocks.FilterAhead(before, out, scratch), "check failed");
  EXPECT_DEATH(std::ignore = ReadFrom(in)(0, out), "check failed");
  EXPECT_DEATH(static_cast<void>(RingingSamples(design, 0)), "check failed");
  EXPECT_DEATH(static_cast<void>(RingingSamples(design, 1)), "check failed");
}

}  // namespace
}  // namespace haptometer::dsp
