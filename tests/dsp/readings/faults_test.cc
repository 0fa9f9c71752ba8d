#include "dsp/readings/faults.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <numbers>
#include <vector>

#include "tests/dsp/row_blocks.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

using trial::SampleStatus;

constexpr double kRateHz = 10e3;

// a look that tells nothing, so that every row is looked at on its own
FaultLook BlindLook(FaultLook look) {
  for (RowRepeats& piece : look.pieces) piece = {.triples = 1};
  std::ranges::fill(look.largest_errors, std::numeric_limits<double>::infinity());
  return look;
}

enum class Looking : bool { kBlindly, kAhead };

Faults Scan(const std::vector<double>& values, const FaultScale& scale = {},
            std::size_t block_rows = 245 * kFaultBlockRows, std::vector<SampleStatus> statuses = {},
            Looking looking = Looking::kAhead) {
  statuses.resize(values.size(), SampleStatus::kOk);
  FaultScanner scanner(scale);
  ForEachBlock(values, statuses, block_rows, kFaultMarginRows + 2, [&](const RowBlock& block) {
    const FaultLook look = scanner.Look(block);
    scanner.Feed(block, looking == Looking::kAhead ? look : BlindLook(look));
  });
  return scanner.Finish();
}

void ExpectSame(const Faults& faults, const Faults& others) {
  EXPECT_EQ(faults.count, others.count);
  EXPECT_EQ(faults.rows, others.rows);
  ASSERT_EQ(faults.list.size(), others.list.size());
  for (std::size_t k = 0; k < others.list.size(); ++k) {
    EXPECT_EQ(faults.list[k].kind, others.list[k].kind);
    EXPECT_EQ(faults.list[k].first_row, others.list[k].first_row);
    EXPECT_EQ(faults.list[k].size, others.list[k].size);
  }
}

// 0.2 mm at 225 Hz over 0.5 mm of tremor, with 0.5 um of noise in steps of 0.1 um
std::vector<double> Streamed(std::size_t count, std::uint64_t seed, double step = 1e-7) {
  std::vector<double> values = Samples(kRateHz, count, 0.03, {{2e-4, 225, 0.3}, {5e-4, 8.3, 1}});
  Noise noise(seed);
  for (double& x : values) x = std::round((x + 5e-7 * noise()) / step) * step;
  return values;
}

void ExpectNone(const Faults& faults) {
  for (std::size_t k = 0; k < kFaultKindCount; ++k) {
    EXPECT_EQ(faults.count[k], 0U) << Name(static_cast<FaultKind>(k));
  }
}

TEST(Faults, AnHonestRecordHasNone) {
  ExpectNone(Scan(Streamed(100'000, 1), {-0.1, 0.1, 1e-7}));
  ExpectNone(Scan(Streamed(100'000, 2)));
  // tones without noise, exact or on steps of 1 um, whatever their period in rows
  for (const double hz : {100.0, 312.5, 1250.0, 2500.0 / 3}) {
    ExpectNone(Scan(Samples(kRateHz, 20'000, 0.03, {{1e-4, hz, 0.1}})));
  }
  std::vector<double> slow = Samples(kRateHz, 50'000, 0.03, {{2e-5, 1.3, 0.2}});
  for (double& x : slow) x = std::round(x / 1e-6) * 1e-6;
  ExpectNone(Scan(slow, {-0.1, 0.1, 1e-6}));
  ExpectNone(Scan(slow));
  // a drive that begins within a block, within 10 ms
  std::vector<double> gated = Streamed(30'000, 3);
  const std::vector<double> tone = Samples(kRateHz, 30'000, 0, {{2e-4, 225, 0.3}});
  for (std::size_t k = 0; k < 12'345; ++k) {
    gated[k] -=
        tone[k] *
        (k < 12'245
             ? 1
             : std::pow(std::cos(0.005 * std::numbers::pi * static_cast<double>(k - 12'245)), 2));
  }
  ExpectNone(Scan(gated));
}

TEST(Faults, ConstantShortAndEmptyRecordsHaveNone) {
  ExpectNone(Scan({}));
  ExpectNone(Scan({1.0}));
  ExpectNone(Scan(std::vector<double>(10'000, 0.03)));
  ExpectNone(Scan({1, 2, 3, 4, 5}));
  ExpectNone(Scan(std::vector<double>(100, std::nan(""))));
}

TEST(Faults, SpikesAreFoundWithTheirRowsAndHeights) {
  std::vector<double> values = Streamed(30'000, 4);
  values[5'000] += 20e-6;
  values[4'095] -= 30e-6;  // where a block ends
  for (std::size_t k = 20'000; k < 20'003; ++k) values[k] += 40e-6;
  const Faults faults = Scan(values, {-0.1, 0.1, 1e-7});
  ASSERT_EQ(faults.Count(FaultKind::kSpike), 3U);
  EXPECT_EQ(faults.Rows(FaultKind::kSpike), 5U);
  EXPECT_EQ(faults.list[0].first_row, 4'095U);
  EXPECT_EQ(faults.list[1].first_row, 5'000U);
  EXPECT_EQ(faults.list[2].first_row, 20'000U);
  EXPECT_EQ(faults.list[2].rows, 3U);
  EXPECT_ABS(faults.list[0].size, -30e-6, 3e-6, "noise of 0.5 um");
  EXPECT_ABS(faults.list[1].size, 20e-6, 3e-6, "noise of 0.5 um");
  EXPECT_ABS(faults.list[2].size, 40e-6, 3e-6, "noise of 0.5 um");
  EXPECT_EQ(faults.Count(FaultKind::kStep), 0U);
}

TEST(Faults, SpikesNearEachOtherAreBothFound) {
  for (const std::size_t apart : {6U, 12U, 23U, 31U}) {
    std::vector<double> values = Streamed(30'000, 9);
    values[13'000] += 1e-3;
    values[13'000 + apart] -= 1e-3;
    EXPECT_EQ(Scan(values).Count(FaultKind::kSpike), 2U) << apart;
  }
}

TEST(Faults, AStepIsNotASpike) {
  std::vector<double> values = Streamed(30'000, 5);
  for (std::size_t k = 17'000; k < values.size(); ++k) values[k] += 25e-6;
  const Faults faults = Scan(values, {-0.1, 0.1, 1e-7});
  ASSERT_EQ(faults.Count(FaultKind::kStep), 1U);
  EXPECT_EQ(faults.list[0].first_row, 17'000U);
  EXPECT_ABS(faults.list[0].size, 25e-6, 4e-6, "noise of 0.5 um");
  EXPECT_EQ(faults.Count(FaultKind::kSpike), 0U);
}

TEST(Faults, ADriveThatIsSwitchedIsNeitherASpikeNorAStep) {
  for (const double drive_hz : {75.0, 225.0}) {
    for (const double rate_hz : {400.0, 1000.0, 5000.0, 50'000.0}) {
      const auto rows = static_cast<std::size_t>(rate_hz);
      std::vector<double> values = Samples(rate_hz, 3 * rows, 0, {{20e-6, drive_hz}});
      Noise noise(8);
      for (std::size_t k = 0; k < values.size(); ++k) {
        if (k < rows || k >= 2 * rows) values[k] = 0;
        values[k] += 0.03 + 0.02e-6 * noise();
      }
      ExpectNone(Scan(values, {-0.1, 0.1, 0}));
      values[rows - 200] += 30e-6;  // a spike beside it stays one
      EXPECT_EQ(Scan(values, {-0.1, 0.1, 0}).Count(FaultKind::kSpike), 1U) << rate_hz;
    }
  }
}

TEST(Faults, HeldReadingsAreToldFromASlowSignalOnSteps) {
  std::vector<double> values = Streamed(30'000, 6);
  for (std::size_t k = 1; k < 12; ++k) values[8'000 + k] = values[8'000];
  const Faults faults = Scan(values, {-0.1, 0.1, 1e-7});
  ASSERT_EQ(faults.Count(FaultKind::kHeld), 1U);
  EXPECT_EQ(faults.Rows(FaultKind::kHeld), 12U);
  const auto held = std::ranges::find(faults.list, FaultKind::kHeld, &Fault::kind);
  EXPECT_EQ(held->first_row, 8'000U);
  EXPECT_GT(held->size, 2e-6) << "what the motion did meanwhile";
  // all but the first are excluded, of a hold as long as may be and no longer
  for (const std::size_t longest : {11U, 12U}) {
    const Faults judged = Scan(values, {-0.1, 0.1, 1e-7, longest});
    const bool is_excluded = std::ranges::any_of(judged.excluded, [](const auto& range) {
      const auto& [first, end] = range;
      return first <= 8'001 && end >= 8'012;  // with what the kink at its end spoils
    });
    EXPECT_EQ(is_excluded, longest == 12) << longest;
  }
}

TEST(Faults, RowsThatTheSourceCallsRepeatedAreNoHold) {
  std::vector<double> values = Samples(kRateHz, 10'000, 0.03, {{2e-4, 225}});
  std::vector<SampleStatus> statuses(values.size(), SampleStatus::kOk);
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (k % 5 == 0) continue;
    values[k] = values[k - k % 5];
    statuses[k] = SampleStatus::kRepeated;
  }
  EXPECT_EQ(Scan(values, {}, kFaultBlockRows, statuses).Count(FaultKind::kHeld), 0U);
}

// each reading of a source stands there `times` times: no hold, and none clipped at the extremes,
// which steps of 0.1 um make equal
TEST(Faults, RowsThatRepeatAllAlongAreNeitherHeldNorClipped) {
  for (const std::size_t times : {2U, 3U, 4U, 7U}) {
    std::vector<double> values(30'000);
    const std::vector<double> fresh = Samples(1666, values.size() / times + 1, 0, {{2e-5, 300.3}});
    for (std::size_t k = 0; k < values.size(); ++k) {
      values[k] = std::round(fresh[k / times] / 1e-7) * 1e-7;
    }
    const Faults faults = Scan(values, {});
    EXPECT_EQ(faults.Count(FaultKind::kHeld), 0U) << times;
    EXPECT_EQ(faults.Count(FaultKind::kClipped), 0U) << times;
    EXPECT_EQ(faults.Count(FaultKind::kSpike), 0U) << times;
  }
}

TEST(Faults, ClippedAtTheRangeAtAStatusOrAtARepeatedExtreme) {
  const std::vector<double> truth = Samples(kRateHz, 20'000, 0, {{1e-3, 50}});
  std::vector<double> values = truth;
  std::size_t rows = 0;
  for (double& x : values) {
    if (x > 0.8e-3) ++rows;
    x = std::min(x, 0.8e-3);
  }
  for (const FaultScale& scale : {FaultScale{}, FaultScale{-2e-3, 0.8e-3, 0}}) {
    const Faults faults = Scan(values, scale);
    EXPECT_EQ(faults.Count(FaultKind::kClipped), 100U) << "one a period";
    EXPECT_EQ(faults.Rows(FaultKind::kClipped), rows);
    EXPECT_EQ(faults.Count(FaultKind::kHeld), 0U) << "once is enough";
  }
  std::vector<SampleStatus> statuses(values.size(), SampleStatus::kOk);
  std::fill_n(statuses.begin() + 100, 7, SampleStatus::kClipped);
  const Faults faults = Scan(truth, {}, kFaultBlockRows, statuses);
  ASSERT_EQ(faults.Count(FaultKind::kClipped), 1U);
  EXPECT_EQ(faults.list[0].first_row, 100U);
  EXPECT_EQ(faults.list[0].rows, 7U);
}

TEST(Faults, HowRowsAreFedChangesNothing) {
  std::vector<double> values = Streamed(20'000, 7);
  for (std::size_t k = 100; k < values.size(); k += 997) values[k] += 30e-6;
  for (std::size_t k = 1; k < 20; ++k) values[9'000 + k] = values[9'000];
  const Faults whole = Scan(values);
  EXPECT_GT(whole.list.size(), 19U);
  for (const std::size_t blocks : {1U, 2U, 3U}) {
    ExpectSame(Scan(values, {}, blocks * kFaultBlockRows), whole);
  }
  // a last block that is shorter than the margin, or a little longer
  for (const std::size_t rows : {8'192U, 8'193U, 8'240U, 8'241U}) {
    const std::vector<double> some(values.begin(),
                                   std::next(values.begin(), static_cast<std::ptrdiff_t>(rows)));
    ExpectSame(Scan(some, {}, kFaultBlockRows), Scan(some));
  }
}

TEST(WindowFaults, ClippedRowsBeyondTheListCountAsIfInside) {
  FaultScanner scanner({-1, 1, 0});
  std::vector<double> values(12'000);
  for (std::size_t k = 0; k < values.size(); ++k)
    values[k] = k % 6 == 0 ? 2 : 0.001 * static_cast<double>(k % 7);
  const std::vector<SampleStatus> statuses(values.size());
  ForEachBlock(values, statuses, 3 * kFaultBlockRows, 0,
               [&](const RowBlock& block) { scanner.Feed(block, scanner.Look(block)); });
  const Faults faults = scanner.Finish();
  EXPECT_EQ(faults.Rows(FaultKind::kClipped), 2000U);
  EXPECT_EQ(ClippedRows(faults, 0, 6000), 2000U) << "1000 listed, 1000 that may be anywhere";
  EXPECT_EQ(ClippedRows(faults, 9000, 3000), 1000U);
  EXPECT_EQ(ClippedRows(faults, 9000, 300), 300U);
}

// what is told of rows side by side is what a look at each row tells, holes or none
TEST(Faults, PlainPiecesSayWhatTheirRowsSay) {
  for (const double swing_steps : {0.7, 3.0, 40.0, 4000.0}) {
    std::vector<double> values(9'000);
    for (std::size_t k = 0; k < values.size(); ++k) {
      values[k] = 1e-8 * std::round(swing_steps * std::sin(0.01 * static_cast<double>(k)));
    }
    for (std::size_t k = 50; k < values.size(); k += 531) values[k] += 3e-7;
    for (std::size_t k = 1; k < 9; ++k) values[5'000 + k] = values[5'000];
    std::vector<SampleStatus> statuses(values.size());
    for (std::size_t k = 6'000; k < 8'000; k += 301) statuses[k] = SampleStatus::kOver;
    for (const FaultScale& scale : {FaultScale{}, FaultScale{-2.9e-8, 1, 1e-8}}) {
      SCOPED_TRACE(swing_steps);
      for (const auto& some : {std::vector<SampleStatus>(), statuses}) {
        ExpectSame(Scan(values, scale, 3 * kFaultBlockRows, some, Looking::kAhead),
                   Scan(values, scale, 3 * kFaultBlockRows, some, Looking::kBlindly));
      }
    }
  }
}

}  // namespace
}  // namespace haptometer::dsp
