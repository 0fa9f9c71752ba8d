#include "dsp/readings/faults.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <numbers>
#include <utility>
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

// each is among the neighbours of the other, by which its errors have the shape of neither alone
TEST(Faults, RowsOfTwoSpikesBesideEachOtherAreExact) {
  for (std::size_t apart = 1; apart <= 6; ++apart) {
    for (const double second : {1.3e-4, -1.5e-4, -0.9e-4}) {
      SCOPED_TRACE(testing::Message() << apart << " rows, " << second);
      std::vector<double> values = Streamed(30'000, 9);
      values[13'000] += 1.5e-4;
      values[13'000 + apart] += second;
      const Faults faults = Scan(values);
      ASSERT_EQ(faults.Count(FaultKind::kSpike), 2U);
      EXPECT_EQ(faults.list[0].first_row, 13'000U);
      EXPECT_EQ(faults.list[1].first_row, 13'000 + apart);
      EXPECT_EQ(faults.Rows(FaultKind::kSpike), 2U);
      EXPECT_EQ(faults.Count(FaultKind::kStep), 0U);
      EXPECT_ABS(faults.list[0].size, 1.5e-4, apart < 6 ? 3e-6 : 2.5e-5,
                 "noise of 0.5 um; at six rows one spike's errors alone");
    }
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

// a wave of 223.7 Hz in noise of 0.5 um, at most 100 um: what is clipped for three rows and more
struct ClippedWave {
  explicit ClippedWave(double amplitude_m, double least_m = -1e-4) {
    values = Samples(kRateHz, 60'000, 0, {{amplitude_m, 223.7}});
    is_clipped.resize(values.size());
    Noise noise(2);
    std::size_t begin = 0;  // of equal rows
    for (std::size_t k = 0; k < values.size(); ++k) {
      values[k] = std::round((values[k] + 5e-7 * noise()) / 1e-8) * 1e-8;
      values[k] = std::clamp(values[k], least_m, 1e-4);
      if (values[k] != values[begin]) begin = k;
      if ((values[k] != least_m && values[k] != 1e-4) || k < begin + 2) continue;
      runs += k == begin + 2 ? 1 : 0;
      for (std::size_t row = begin; row <= k; ++row) is_clipped[row] = true;
    }
  }
  // of rows [first, end)
  [[nodiscard]] std::size_t Rows(std::size_t first, std::size_t end) const {
    std::size_t rows = 0;
    for (std::size_t k = first; k < end; ++k) rows += is_clipped[k] ? 1 : 0;
    return rows;
  }

  std::vector<double> values;
  std::vector<bool> is_clipped;
  std::size_t runs = 0;
};

// 2684 half periods, of which 1000 are listed: of 120 um 37 % of the rows, of 300 um 78 %
TEST(Faults, AllClippedRunsAreKnownListedOrNot) {
  for (const double amplitude_m : {1.2e-4, 3e-4}) {
    const ClippedWave wave(amplitude_m);
    const Faults faults = Scan(wave.values);
    EXPECT_GT(wave.runs, 2 * kMostListed);
    EXPECT_EQ(faults.Count(FaultKind::kClipped), wave.runs);
    EXPECT_EQ(faults.Rows(FaultKind::kClipped), wave.Rows(0, wave.values.size()));
    EXPECT_EQ(faults.Count(FaultKind::kHeld), 0U) << "none of what is clipped";
    EXPECT_TRUE(faults.excluded.empty());
    ASSERT_EQ(faults.list.size(), kMostListed);
    EXPECT_LT(faults.list.back().first_row, 23'000U) << "the first ones of both ends";
    // in windows before, about and behind the end of the list
    for (const auto& [first, end] :
         {std::pair<std::size_t, std::size_t>{3, 5'017}, {20'001, 30'007}, {40'009, 60'000}}) {
      EXPECT_EQ(ClippedRows(faults, first, end - first), wave.Rows(first, end)) << first;
    }
  }
}

// the edges of a wave that is clipped are kinks; a spike between two of them is one
TEST(Faults, TheEdgesOfAClippedWaveAreNeitherSpikesNorSteps) {
  for (const double amplitude_m : {1.04e-4, 1.2e-4, 3e-4}) {
    for (const double least_m : {-1e-4, -1.0}) {
      ClippedWave wave(amplitude_m, least_m);
      const Faults faults = Scan(wave.values);
      EXPECT_EQ(faults.Count(FaultKind::kSpike), 0U) << amplitude_m;
      EXPECT_EQ(faults.Count(FaultKind::kStep), 0U) << amplitude_m;
      if (amplitude_m > 2e-4) continue;
      // 11 rows after the wave rises through 0, where it falls
      wave.values[20'000] -= 2e-4;
      EXPECT_EQ(Scan(wave.values).Count(FaultKind::kSpike), 1U) << amplitude_m;
    }
  }
}

TEST(WindowFaults, ClippedRowsAreThoseOfTheWindow) {
  FaultScanner scanner({-1, 1, 0});
  std::vector<double> values(12'000);
  for (std::size_t k = 0; k < values.size(); ++k)
    values[k] = k % 6 == 0 ? 2 : 0.001 * static_cast<double>(k % 7);
  const std::vector<SampleStatus> statuses(values.size());
  ForEachBlock(values, statuses, 3 * kFaultBlockRows, 0,
               [&](const RowBlock& block) { scanner.Feed(block, scanner.Look(block)); });
  const Faults faults = scanner.Finish();
  EXPECT_EQ(faults.Rows(FaultKind::kClipped), 2000U);
  EXPECT_EQ(ClippedRows(faults, 0, 6000), 1000U);
  EXPECT_EQ(ClippedRows(faults, 9000, 3000), 500U);
  EXPECT_EQ(ClippedRows(faults, 9001, 299), 49U);
  EXPECT_EQ(ClippedRows(faults, 9001, 5), 0U);
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

// A straight line of one step a row on which `pairs` rows repeat the one before, and a hold of five
// rows that is left by five steps.
std::vector<double> WithPairsAndAHold(std::size_t pairs) {
  constexpr std::size_t kHold = 4100;
  std::vector<double> values(2 * kFaultBlockRows);
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = static_cast<double>(k);
  for (std::size_t pair = 0; pair < pairs; ++pair) {
    values[31 * pair + 15] = values[31 * pair + 14];
  }
  for (std::size_t k = kHold; k < kHold + 5; ++k) values[k] = static_cast<double>(kHold);
  return values;
}

// rows p^4, p the share of runs that are longer than one row
double HoldsByChance(const std::vector<double>& values) {
  double runs = 0;
  double longer = 0;
  for (std::size_t k = 0; k < values.size();) {
    std::size_t end = k + 1;
    while (end < values.size() && values[end] == values[k]) ++end;
    runs += 1;
    longer += end - k > 1 ? 1 : 0;
    k = end;
  }
  return static_cast<double>(values.size()) * std::pow(longer / runs, 4);
}

TEST(Faults, AHoldIsLongerThanChanceGivesOnceInAHundredRecords) {
  const std::vector<double> rare = WithPairsAndAHold(262);
  EXPECT_LT(HoldsByChance(rare), 0.01);
  EXPECT_GT(HoldsByChance(rare), 0.0098) << "near to what is allowed";
  const Faults found = Scan(rare);
  ASSERT_EQ(found.Count(FaultKind::kHeld), 1U);
  EXPECT_EQ(found.Rows(FaultKind::kHeld), 5U);
  const auto hold = std::ranges::find(found.list, FaultKind::kHeld, &Fault::kind);
  EXPECT_EQ(hold->first_row, 4100U);
  EXPECT_EQ(hold->size, 5);
  const std::vector<double> usual = WithPairsAndAHold(263);
  EXPECT_GT(HoldsByChance(usual), 0.01);
  EXPECT_EQ(Scan(usual).Count(FaultKind::kHeld), 0U);
}

// A source that is three times slower than the rate: a hold is twice the mean run or longer, which
// is a little more than three rows. It is left by a steep step.
TEST(Faults, AHoldIsLongerThanTwiceTheUsualRun) {
  for (const std::size_t rows : {6U, 7U}) {
    std::vector<double> values;
    for (std::size_t run = 0; run < 1000; ++run) {
      values.insert(values.end(), run == 500 ? rows : 3,
                    static_cast<double>(run > 500 ? run + 20 : run));
    }
    EXPECT_EQ(Scan(values).Count(FaultKind::kHeld), rows - 6) << rows;
  }
}

// the record's last row is alone in its piece of 256 rows
TEST(Faults, AHoldMayEndWithTheRecord) {
  std::vector<double> values(257, 300);
  for (std::size_t k = 0; k < 253; ++k) values[k] = static_cast<double>(k);
  EXPECT_EQ(Scan(values).Rows(FaultKind::kHeld), 4U);
}

// a hold of three rows is left by three steps, one of four rows by four
TEST(Faults, AHoldIsOfFourRows) {
  for (const std::size_t rows : {3U, 4U}) {
    std::vector<double> values(1000);
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = static_cast<double>(k);
    for (std::size_t k = 500; k < 500 + rows; ++k) values[k] = 500;
    EXPECT_EQ(Scan(values).Count(FaultKind::kHeld), rows - 3) << rows;
  }
}

// The record's highest and lowest values lie in its first rows; the rows behind them are plain.
TEST(Faults, ClippedRunsAreKeptWherePlainRowsFollow) {
  for (const double sign : {1.0, -1.0}) {
    std::vector<double> values = Samples(kRateHz, 20'000, 0, {{1e-3, 50}});
    std::size_t rows = 0;
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (k >= 1000) values[k] *= 0.5;
      rows += sign * values[k] > 0.8e-3 ? 1 : 0;
      values[k] = sign * std::min(sign * values[k], 0.8e-3);
    }
    for (const Looking looking : {Looking::kAhead, Looking::kBlindly}) {
      const Faults faults = Scan(values, {}, 245 * kFaultBlockRows, {}, looking);
      EXPECT_EQ(faults.Count(FaultKind::kClipped), 5U) << "five periods";
      EXPECT_EQ(faults.Rows(FaultKind::kClipped), rows);
    }
  }
}

// ten hills of one step a row, whose tops of `rows` rows are entered and left by `jump` steps
Faults OfTops(std::size_t rows, double jump) {
  std::vector<double> values;
  for (int hill = 0; hill < 10; ++hill) {
    for (int k = 0; k < 20; ++k) values.push_back(k);
    values.insert(values.end(), rows, 19 + jump);
    for (int k = 19; k > 0; --k) values.push_back(k);
  }
  return Scan(values, {-100, 100, 1});
}

// half a step more than a parabola: 4.5, 24/8 + 0.5, 36/16 + 0.5, ... steps; 2.5 at least
TEST(Faults, AnExtremeIsClippedFromThreeRowsAndSteepEdgesOn) {
  for (const auto& [rows, steps] :
       {std::pair<std::size_t, double>{3, 4.5}, {4, 3.5}, {5, 2.75}, {20, 2.5}}) {
    EXPECT_EQ(OfTops(rows, steps - 0.01).Count(FaultKind::kClipped), 0U) << rows;
    EXPECT_EQ(OfTops(rows, steps + 0.01).Count(FaultKind::kClipped), 10U) << rows;
  }
  EXPECT_EQ(OfTops(2, 50).Count(FaultKind::kClipped), 0U);
}

// tops whose curvature is 0.3 to 1.1 steps a row^2: some hold three and four equal rows beside
// which the next is three or four steps lower
TEST(Faults, ARoundedSineIsNeitherClippedNorHeld) {
  for (const double noise_steps : {0.0, 0.05, 0.2})
    for (const double curvature : {0.3, 0.45, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1}) {
      for (const double cycles : {0.013, 0.0341, 0.0737}) {
        std::vector<double> values(20'000);
        Noise noise(1);
        for (std::size_t k = 0; k < values.size(); ++k) {
          const double turns = cycles * static_cast<double>(k);
          const double amplitude = 2 * curvature / std::pow(2 * std::numbers::pi * cycles, 2);
          values[k] = std::round(amplitude * std::sin(2 * std::numbers::pi * turns) +
                                 noise_steps * noise());
        }
        const Faults faults = Scan(values, {-1e9, 1e9, 1});
        EXPECT_EQ(faults.Count(FaultKind::kClipped), 0U) << curvature << ' ' << cycles;
        EXPECT_EQ(faults.Count(FaultKind::kHeld), 0U) << curvature << ' ' << cycles;
      }
    }
}

// a straight line has no errors of its own: four steps decide
TEST(Faults, ASpikeIsOfMoreThanFourSteps) {
  for (const double height : {3.96, -3.96, 4.04, -4.04}) {
    std::vector<double> values(6000);
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = static_cast<double>(k);
    values[3000] += height;
    const Faults faults = Scan(values, {-1e4, 1e4, 1});
    if (std::abs(height) < 4) {
      ExpectNone(faults);
      continue;
    }
    ASSERT_EQ(faults.Count(FaultKind::kSpike), 1U) << height;
    EXPECT_EQ(faults.list[0].first_row, 3000U);
    EXPECT_EQ(faults.list[0].rows, 1U);
    EXPECT_REL(faults.list[0].size, height, 1e-12, "rounding of 3000");
  }
}

TEST(Faults, ARangeIsReachedAtItsEnds) {
  const std::vector<double> values{0, 1, 2, 3, 2, 1, 0, -1, -2, -1, 0};
  EXPECT_EQ(Scan(values, {-2, 3, 1}).Count(FaultKind::kClipped), 2U);
  EXPECT_EQ(Scan(values, {-2.01, 3.01, 1}).Count(FaultKind::kClipped), 0U);
}

// a step of height h has the density 2 h^2 / (2 pi f)^2: over 20 to 500 Hz and 2 s
TEST(StepPower, IsThatOfTheStepsAmongTheRows) {
  Faults faults;
  faults.list = {{FaultKind::kStep, 99, 1, 7},
                 {FaultKind::kStep, 100, 1, 3e-6},
                 {FaultKind::kSpike, 200, 1, 9},
                 {FaultKind::kStep, 20'099, 1, -4e-6},
                 {FaultKind::kStep, 20'100, 1, 7}};
  const double turn = 2 * std::numbers::pi;
  const double energy = 2 * 25e-12 / (turn * turn) * (1.0 / 20 - 1.0 / 500);
  EXPECT_REL(StepPower(faults, 100, 20'000, {6, 20, 500}, kRateHz), energy / 2, 1e-13, "rounding");
  EXPECT_EQ(StepPower({}, 100, 20'000, {6, 20, 500}, kRateHz), 0);
}

// on a straight line the fault's own errors are all there is: its rows and its height are exact, in
// a block's middle and about its end
TEST(Faults, OnAStraightLineRowsAndHeightsAreExact) {
  for (const std::size_t first : {2000U, 4093U, 4094U, 4095U, 4096U, 4097U}) {
    for (const std::size_t rows : {0U, 1U, 2U, 3U}) {  // 0: a step
      for (const double height : {10.0, -7.0}) {
        SCOPED_TRACE(testing::Message() << rows << " rows at " << first);
        std::vector<double> values(9000);
        for (std::size_t k = 0; k < values.size(); ++k) values[k] = 0.5 * static_cast<double>(k);
        const std::size_t end = rows == 0 ? values.size() : first + rows;
        for (std::size_t k = first; k < end; ++k) values[k] += height;
        const Faults faults = Scan(values, {-1e4, 1e4, 0.5});
        ASSERT_EQ(faults.list.size(), 1U);
        EXPECT_EQ(faults.list[0].kind, rows == 0 ? FaultKind::kStep : FaultKind::kSpike);
        EXPECT_EQ(faults.list[0].first_row, first);
        EXPECT_EQ(faults.list[0].rows, std::max<std::size_t>(rows, 1));
        EXPECT_REL(faults.list[0].size, height, 1e-11, "rounding of 4500");
      }
    }
  }
}

TEST(FaultsDeathTest, ABlockHoldsItsMargins) {
  const std::vector<double> values(3 * kFaultBlockRows, 1.0);
  const std::vector<SampleStatus> statuses(values.size(), SampleStatus::kOk);
  const auto scan = [&](std::size_t margin) {
    FaultScanner scanner({});
    ForEachBlock(values, statuses, kFaultBlockRows, margin, [&](const RowBlock& block) {
      // a look reads two rows at most beyond the block
      scanner.Feed(block, scanner.Look(block));
    });
    return scanner.Finish().runs;
  };
  EXPECT_EQ(scan(kFaultMarginRows), 1U);
  EXPECT_DEATH(static_cast<void>(scan(kFaultMarginRows - 1)), "check failed");
}

// A parabola has no cubic error. Its least change, of half a unit, lies in the middle of 256 rows
// that are looked at together; at their ends it changes by 127 units, four times which would hide
// the spike.
TEST(Faults, TheLeastChangeIsThatOfAllRows) {
  constexpr double kVertex = 3 * 256 + 128;
  for (const Looking looking : {Looking::kAhead, Looking::kBlindly}) {
    std::vector<double> values(2 * kFaultBlockRows);
    for (std::size_t k = 0; k < values.size(); ++k) {
      values[k] = 0.5 * std::pow(static_cast<double>(k) - kVertex, 2);
    }
    values[960] += 300;
    const Faults faults = Scan(values, {}, 245 * kFaultBlockRows, {}, looking);
    ASSERT_EQ(faults.list.size(), 1U);
    EXPECT_EQ(faults.list[0].kind, FaultKind::kSpike);
    EXPECT_EQ(faults.list[0].first_row, 960U);
    EXPECT_EQ(faults.list[0].rows, 1U);
    EXPECT_REL(faults.list[0].size, 300, 1e-9, "rounding of 2.6e7");
    ASSERT_EQ(faults.excluded.size(), 1U);
    EXPECT_EQ(faults.excluded[0].begin, 960U);
    EXPECT_EQ(faults.excluded[0].end, 961U);
  }
}

}  // namespace
}  // namespace haptometer::dsp
