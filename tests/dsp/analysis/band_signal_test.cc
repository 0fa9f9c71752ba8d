#include "dsp/analysis/band_signal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "dsp/filter/transient.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/statistics/moments.h"
#include "tests/dsp/filter/settled_signal.h"
#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 10e3;

// a record, its rows and its one segment, which must outlive the signal
struct Held {
  explicit Held(trial::Record held) : record(std::move(held)) {
    segments = SplitAtHoles(rows, 0, {}).value();
  }
  [[nodiscard]] BandSignal Filter(int threads = 1, const BandPass& band = {}) const {
    const Segment& segment = segments.parts.at(0);
    return BandSignal::Filter({rows, 0, segment}, Designed(band, segment.rate_hz), threads).value();
  }

  trial::Record record;
  trial::RecordRows rows{record};
  Segments segments;
};

std::vector<double> ReadAll(const BandSignal& signal, std::size_t size_at_once) {
  std::vector<double> all(signal.size());
  for (std::size_t first = 0; first < all.size(); first += size_at_once) {
    const std::size_t count = std::min(size_at_once, all.size() - first);
    EXPECT_TRUE(signal.Read(first, std::span(all).subspan(first, count)));
  }
  return all;
}

void ExpectSameCells(const BandSignal& a, const BandSignal& b) {
  ASSERT_EQ(a.cells().size(), b.cells().size());
  for (std::size_t k = 0; k < a.cells().size(); ++k) {
    EXPECT_EQ(a.cells()[k].square_sum, b.cells()[k].square_sum);
    EXPECT_EQ(a.cells()[k].least, b.cells()[k].least);
    EXPECT_EQ(a.cells()[k].most, b.cells()[k].most);
  }
  EXPECT_EQ(a.settled_begin(), b.settled_begin());
  EXPECT_EQ(a.settled_end(), b.settled_end());
}

// several blocks, a tone in tremor
trial::Record LongRecord() {
  return RecordOf(Samples(kRateHz, 600'000, 0.03, {{1e-6, 100, 1}, {5e-4, 8.3}}), kRateHz);
}

TEST(BandSignal, IsTheZeroPhaseFilterOfTheWholeSegment) {
  const Held held(LongRecord());
  const BandSignal signal = held.Filter();
  EXPECT_EQ(ReadAll(signal, signal.size()),
            FilterZeroPhase(signal.design(), held.record.channels[0].values));
}

TEST(BandSignal, NeitherThreadsNorRangesChangeABit) {
  const Held held(LongRecord());
  const BandSignal signal = held.Filter(1);
  for (const int threads : {2, 3}) ExpectSameCells(held.Filter(threads), signal);
  const std::vector<double> whole = ReadAll(signal, signal.size());
  EXPECT_EQ(ReadAll(signal, 100'003), whole);
  // short ranges cost a block each, so only where blocks meet and at the ends
  for (const std::size_t size : {1U, 7U, 4096U}) {
    for (const std::size_t first : {0U, 231'000U, 595'904U}) {
      std::vector<double> part(size);
      ASSERT_TRUE(signal.Read(first, part));
      EXPECT_TRUE(std::ranges::equal(part, std::span(whole).subspan(first, size)));
    }
  }
}

// Frames hold what is read without them, whatever piece or block they lie in.
TEST(BandSignal, FramesAreThoseSamples) {
  const Held held(LongRecord());
  const Segment& segment = held.segments.parts.at(0);
  const FilterDesign design = Designed({}, kRateHz);
  const BandSignal none = held.Filter();
  const std::vector<double> whole = ReadAll(none, none.size());
  // all, frames of which the last is cut, and frames of which the last is missing
  for (const KeptFrames& frames : {KeptFrames{3, 200'000, 0, 200'000},
                                   KeptFrames{3, 1001, 370, 620}, KeptFrames{7, 5000, 3000, 260}}) {
    for (const int threads : {1, 2}) {
      const BandSignal signal =
          BandSignal::Filter({held.rows, 0, segment}, design, threads, frames).value();
      const std::size_t last = (whole.size() - 1) / frames.stride + 1;
      for (std::size_t begin = frames.offset; begin < last; begin += frames.period) {
        // from within the frame, and on beyond it where there is no other
        const std::size_t first = begin + frames.frame / 3;
        if (first >= last) break;
        const std::size_t more = begin + 2 * frames.period > last ? 50 : 0;
        std::vector<double> read(std::min(begin + frames.frame + more, last) - first);
        ASSERT_TRUE(signal.ReadThinned(first * frames.stride, frames.stride, read));
        for (std::size_t n = 0; n < read.size(); ++n) {
          ASSERT_EQ(read[n], whole[(first + n) * frames.stride]) << first + n;
        }
      }
    }
  }
}

TEST(BandSignal, SumsAndExtremesAreThoseOfTheSamples) {
  const Held held(LongRecord());
  const BandSignal signal = held.Filter();
  const std::vector<double> whole = ReadAll(signal, signal.size());
  const std::vector<std::pair<std::size_t, std::size_t>> ranges{
      {0, 600'000}, {0, 1}, {3, 5}, {8, 10}, {9, 18}, {100'001, 500'003}, {599'999, 600'000}};
  for (const auto& [begin, end] : ranges) {
    const auto part = std::span(whole).subspan(begin, end - begin);
    const double rms = Rms(part);
    EXPECT_REL(*signal.SquareSum(begin, end), rms * rms * static_cast<double>(part.size()), 2e-15,
               "order of the sums");
    const Extremes extremes = *signal.ExtremesOf(begin, end);
    EXPECT_EQ(extremes.least, std::ranges::min(part));
    EXPECT_EQ(extremes.most, std::ranges::max(part));
  }
  EXPECT_EQ(*signal.SquareSum(5, 5), 0);
}

TEST(BandSignal, SettlesWhereTheTwoContinuationsAgree) {
  for (const std::size_t size : {9'000U, 12'000U, 30'000U, 600'000U}) {
    const Held held(RecordOf(Samples(kRateHz, size, 0.03, {{1e-6, 100, 1}, {5e-4, 8.3}}), kRateHz));
    const BandSignal signal = held.Filter();
    const SettledSignal whole = FilterSettled(signal.design(), held.record.channels[0].values);
    // the tolerance's RMS is taken over whole cells, so a cell beside the ends may fall either way
    const auto cell = static_cast<double>(signal.cell_samples());
    if (whole.begin == whole.end) {
      EXPECT_LE(signal.settled_end() - signal.settled_begin(), 2 * signal.cell_samples());
      continue;
    }
    EXPECT_ABS(static_cast<double>(signal.settled_begin()), static_cast<double>(whole.begin),
               2 * cell, "whole cells");
    EXPECT_ABS(static_cast<double>(signal.settled_end()), static_cast<double>(whole.end), 2 * cell,
               "whole cells");
  }
}

TEST(BandSignal, CellsLastAMillisecondAtMost) {
  EXPECT_EQ(Held(RecordOf(std::vector<double>(100, 0.03), 10e3)).Filter().cell_samples(), 9U);
  EXPECT_EQ(Held(RecordOf(std::vector<double>(100, 0.03), 392e3)).Filter().cell_samples(), 336U);
  EXPECT_EQ(Held(RecordOf(std::vector<double>(100, 0.03), 1300)).Filter().cell_samples(), 1U);
  EXPECT_EQ(Held(RecordOf(std::vector<double>(100, 0.03), 1999)).Filter().cell_samples(), 1U);
  EXPECT_EQ(Held(RecordOf(std::vector<double>(100, 0.03), 2000)).Filter().cell_samples(), 2U);
}

TEST(BandSignal, OneSampleAndAConstantAreSilent) {
  for (const std::size_t size : {1U, 2U, 5000U, 300'000U}) {
    const Held held(RecordOf(std::vector<double>(size, 0.03), kRateHz));
    const BandSignal signal = held.Filter(2);
    EXPECT_EQ(*signal.SquareSum(0, size), 0);
    EXPECT_EQ(signal.settled_begin(), 0U);
    EXPECT_EQ(signal.settled_end(), size);
  }
}

TEST(BandSignal, ValuesBeyondAllMeasureSettleNowhere) {
  std::vector<double> values(30'000, 0.03);
  values[10'000] = 1e308;
  values[20'000] = -1e308;
  const BandSignal signal = Held(RecordOf(values, kRateHz)).Filter();
  EXPECT_EQ(signal.settled_begin(), signal.settled_end());
}

// Zero phase is the same from either side. Whole cells, so that they lie alike in the reversed
// record; tremor makes what settles depend on the ends.
TEST(BandSignal, OfTheReversedRecordTheOtherEndSettlesAlike) {
  for (const std::size_t size : {18'000U, 63'000U, 126'000U}) {
    for (const double phase : {0.3, 2.2}) {
      std::vector<double> values =
          Samples(kRateHz, size, 0.03, {{1e-6, 100, 1}, {5e-4, 8.3, phase}});
      const BandSignal signal = Held(RecordOf(values, kRateHz)).Filter();
      ASSERT_EQ(size % signal.cell_samples(), 0U);
      std::ranges::reverse(values);
      const BandSignal reversed = Held(RecordOf(values, kRateHz)).Filter();
      EXPECT_EQ(reversed.settled_begin(), size - signal.settled_end()) << size;
      EXPECT_EQ(reversed.settled_end(), size - signal.settled_begin()) << size;
    }
  }
}

// RMS over all samples of all signals, whatever their lengths.
TEST(BandSignal, TheRmsOfAllCountsEverySample) {
  const Held held(LongRecord());
  const Held other(RecordOf(Samples(kRateHz, 30'001, 0, {{4e-6, 150}}), kRateHz));
  const std::vector<BandSignal> both{held.Filter(), other.Filter()};
  double sum = 0;
  for (const BandSignal& signal : both) {
    for (const double x : ReadAll(signal, signal.size())) sum += x * x;
  }
  EXPECT_REL(WholeRms(both), std::sqrt(sum / 630'001), 1e-12, "order of the sums");
}

// rows of a record that count how often they are read
class CountedRows final : public trial::RowSource {
 public:
  explicit CountedRows(const trial::Record& record) : rows_(record) {}
  [[nodiscard]] const trial::Record& head() const override { return rows_.head(); }
  [[nodiscard]] Result<void> Read(std::size_t channel, std::size_t first, std::span<double> values,
                                  std::span<trial::SampleStatus> statuses) const override {
    ++reads;
    return rows_.Read(channel, first, values, statuses);
  }
  mutable std::size_t reads = 0;

 private:
  trial::RecordRows rows_;
};

// Of 300 000 samples: one sample in all, and frames of which the last, or the only one, is cut to
// one sample. What is kept is not filtered again.
TEST(BandSignal, AFrameOfOneSampleIsKept) {
  const trial::Record record =
      RecordOf(Samples(kRateHz, 300'000, 0.03, {{1e-6, 100, 1}, {5e-4, 8.3}}), kRateHz);
  const CountedRows rows(record);
  Segment segment;
  segment.size = record.rows;
  segment.rate_hz = kRateHz;
  const std::vector<double> whole =
      FilterZeroPhase(Designed({}, kRateHz), record.channels[0].values);
  struct Case {
    KeptFrames frames;
    std::size_t thinned;  // number of the thinned sample
  };
  for (const auto& [frames, thinned] :
       {Case{{300'000, 1, 0, 1}, 0}, Case{{100'000, 20, 2, 5}, 2}, Case{{60'000, 3, 1, 2}, 4}}) {
    const BandSignal signal =
        BandSignal::Filter({rows, 0, segment}, Designed({}, kRateHz), 1, frames).value();
    const std::size_t reads = rows.reads;
    std::vector<double> read(1);
    ASSERT_TRUE(signal.ReadThinned(thinned * frames.stride, frames.stride, read));
    EXPECT_EQ(read[0], whole[thinned * frames.stride]) << frames.stride;
    EXPECT_EQ(rows.reads, reads) << frames.stride;
  }
}

// A cell of less than a millisecond holds one sample, and two where there were more than 2^20.
TEST(BandSignal, CellsAreAMillionAtMost) {
  constexpr std::size_t kMost = std::size_t{1} << 20U;
  for (const std::size_t size : {kMost, kMost + 1}) {
    const Held held(RecordOf(std::vector<double>(size, 0.03), 1300));
    EXPECT_EQ(held.Filter(2).cell_samples(), size - kMost + 1);
  }
}

}  // namespace
}  // namespace haptometer::dsp
