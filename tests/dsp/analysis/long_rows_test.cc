// Rows far beyond 2^31, made up as they are read: indices, counts and sizes must not wrap, and no
// read may cost more than its range.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "dsp/analysis/band_signal.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/readings/segments.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr std::size_t kRows = 6'000'000'000;
constexpr double kRateHz = 10e3;
constexpr double kToneHz = 100;  // 100 rows a period, so that no digit is lost far out

double ValueAt(std::size_t row) {
  return 0.03 + 1e-6 * std::sin(2 * std::numbers::pi * static_cast<double>(row % 100) / 100);
}

class ToneRows final : public trial::RowSource {
 public:
  ToneRows() {
    head_.rows = kRows;
    head_.stretches = {{0, kRows, 0, kRateHz, 0}};
    head_.channels.emplace_back();
  }
  [[nodiscard]] const trial::Record& head() const override { return head_; }
  [[nodiscard]] Result<void> Read(std::size_t /*channel*/, std::size_t first,
                                  std::span<double> values,
                                  std::span<trial::SampleStatus> statuses) const override {
    EXPECT_LE(first + values.size(), kRows);
    for (std::size_t k = 0; k < values.size(); ++k) {
      values[k] = ValueAt(first + k);
      statuses[k] = trial::SampleStatus::kOk;
    }
    return {};
  }

 private:
  trial::Record head_;
};

TEST(LongRows, ASegmentIsReadAnywhere) {
  const ToneRows rows;
  Segment segment;
  segment.first_row = 5;
  segment.size = kRows - 5;
  segment.rate_hz = kRateHz;
  segment.bridges = {{4'999'999'999, 7}};
  const SegmentSamples samples(rows, 0, segment);
  std::vector<double> read(3);
  ASSERT_TRUE(samples.Read(4'999'999'998, read));
  EXPECT_EQ(read[0], ValueAt(5'000'000'003));
  EXPECT_EQ(read[1], 7);
  ASSERT_TRUE(samples.Read(samples.size() - 3, read));
  EXPECT_EQ(read[2], ValueAt(kRows - 1));
}

TEST(LongRows, ABlockFarOutIsTheToneAndSoIsTheLast) {
  const ToneRows rows;
  Segment segment;
  segment.size = kRows;
  segment.rate_hz = kRateHz;
  const SegmentSamples samples(rows, 0, segment);
  const ReadSamples read = [&](std::size_t first, std::span<double> out) {
    return samples.Read(first, out);
  };
  const FilterDesign design = Designed({}, kRateHz);
  const ZeroPhaseBlocks blocks(design, kRows);
  const double gain = std::norm(Response(design, kToneHz));
  ZeroPhaseBlocks::Scratch scratch;
  std::vector<ZeroPhaseBlocks::PieceStates> states(blocks.pieces());
  // one with rows around 2^32, and the last one up to where it hangs on the end
  const std::size_t far = (std::size_t{1} << 32U) / blocks.block_size();
  for (const std::size_t block : {far, blocks.blocks() - 1}) {
    const SampleRange range = blocks.Range(block);
    std::vector<double> out(range.count);
    const auto take = [&](std::size_t first, std::span<double> piece) {
      std::ranges::copy(piece, &out[first - range.first]);
    };
    ASSERT_TRUE(blocks.FilterPieces(block, read, take, states, scratch));
    const std::size_t sure =
        range.end() == kRows ? range.count - std::min(range.count, blocks.lead_in()) : range.count;
    double worst = 0;
    for (std::size_t k = 0; k < sure; ++k) {
      worst = std::max(worst, std::abs(out[k] - gain * (ValueAt(range.first + k) - 0.03)));
    }
    EXPECT_ABS(worst, 0, 1e-16, "an offset of 30 mm in double");
  }
}

}  // namespace
}  // namespace haptometer::dsp
