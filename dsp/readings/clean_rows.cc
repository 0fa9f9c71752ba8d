#include "dsp/readings/clean_rows.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "base/band.h"
#include "base/error.h"
#include "base/jobs.h"
#include "dsp/readings/row_kernel.h"

namespace haptometer::dsp {
namespace {

using trial::SampleStatus;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// how far the time between two stretches may lie from a whole number of periods: of stretches on
// clocks of their own one in five passes, and is then late by 6 % of a period at 0.4 of the rate
constexpr double kWholeRows = 0.1;
constexpr double kRoundingRows = 1e-6;  // of times in doubles, after a day
// rows before and after a block that a visitor may need
constexpr std::size_t kMarginRows = kFaultMarginRows + 2;
static_assert(kPassRows % kFaultBlockRows == 0);
// rows that are passed over together where none is an extreme
constexpr std::size_t kPieceRows = 1024;
// distinct values that are kept of either end: codes and the first measurement behind them
constexpr std::size_t kMostExtremes = 8;
constexpr double kFarM = 0.05;
constexpr double kRailSpans = 10;
constexpr std::size_t kLeastRailRows = 3;
constexpr std::size_t kLeastNines = 4;
// passes that look for spikes and held readings beside those of the pass before
constexpr int kMostRounds = 3;

// whole rows between two stretches on one clock, one at least: the stretches of a clocked source,
// and those of a stream that counts its readings, which lie on one line
std::optional<std::size_t> RowsBetween(trial::Timing timing, const trial::Stretch& before,
                                       const trial::Stretch& next) {
  if (timing == trial::Timing::kPolled) return std::nullopt;
  const bool is_clocked = timing == trial::Timing::kUniform;
  const double end_s = before.start_s + static_cast<double>(before.rows) / before.rate_hz;
  const double gap = (next.start_s - end_s) * before.rate_hz;
  const double whole = std::round(gap);
  const bool is_one_clock =
      std::abs(next.rate_hz / before.rate_hz - 1) <= (is_clocked ? kOneRate : 0) &&
      std::abs(gap - whole) <= (is_clocked ? kWholeRows : kRoundingRows);
  if (!is_one_clock || !(whole >= 1 && whole < 0x1p53)) return std::nullopt;
  return static_cast<std::size_t>(whole);
}

// distinct values at either end of what was seen, with their rows
class Extremes {
 public:
  struct Value {
    double value = 0;
    std::size_t rows = 0;
  };
  using Ends = std::vector<Value>;  // from the outermost inwards

  void Take(const RowBlock& block) {
    const auto values = block.values();
    const auto statuses = block.statuses();
    for (std::size_t at = 0; at < values.size(); at += kPieceRows) {
      const std::size_t end = std::min(at + kPieceRows, values.size());
      if (block.all_ok && IsWithin(values.subspan(at, end - at))) continue;
      // equal readings in a row are added together
      Value run;
      for (std::size_t k = at; k < end; ++k) {
        if (IsInside(values[k])) continue;
        if (!block.all_ok && !IsMeasured(values[k], statuses[k])) continue;
        if (run.rows > 0 && values[k] != run.value) Add(std::exchange(run, Value{}));
        run = {values[k], run.rows + 1};
      }
      if (run.rows > 0) Add(run);
    }
  }

  // keeps the values and counts their rows anew: what lies within them is no extreme
  void Recount() {
    for (Ends& kept : ends_) {
      for (Value& value : kept) value.rows = 0;
    }
  }

  void Merge(const Extremes& other) {
    for (const Value& value : other.ends_[0]) AddTo(0, value);
    for (const Value& value : other.ends_[1]) AddTo(1, value);
  }

  [[nodiscard]] const Ends& lowest() const { return ends_[0]; }
  [[nodiscard]] const Ends& highest() const { return ends_[1]; }

 private:
  [[nodiscard]] bool IsWithin(std::span<const double> values) const {
    if (ends_[0].size() < kMostExtremes) return false;
    const RowSum sum = WidestRowKernel().sum_from(values.data(), values.size(), 0);
    return sum.least > ends_[0].back().value && sum.most < ends_[1].back().value;
  }
  // most rows of a piece that holds an extreme are none
  [[nodiscard]] bool IsInside(double value) const {
    return ends_[0].size() == kMostExtremes && value > ends_[0].back().value &&
           value < ends_[1].back().value;
  }
  void Add(const Value& value) {
    AddTo(0, value);
    AddTo(1, value);
  }
  void AddTo(std::size_t end, const Value& value) {
    Ends& kept = ends_[end];
    const auto is_further_in = [&](const Value& k) {
      return end == 0 ? k.value >= value.value : k.value <= value.value;
    };
    if (kept.size() == kMostExtremes && !is_further_in(kept.back())) return;
    const auto at = std::ranges::find_if(kept, is_further_in);
    if (at != kept.end() && at->value == value.value) {
      at->rows += value.rows;
      return;
    }
    kept.insert(at, value);
    if (kept.size() > kMostExtremes) kept.pop_back();
  }

  std::array<Ends, 2> ends_;
};

// four nines or more, the last of which may be an eight: an instrument's word for no reading
bool IsNines(double value) {
  std::string digits = fmt::format("{:.8e}", std::abs(value));
  digits = digits.substr(0, digits.find('e'));
  std::erase(digits, '.');
  digits.erase(digits.find_last_not_of('0') + 1);
  if (digits.size() < kLeastNines || (digits.back() != '8' && digits.back() != '9')) return false;
  digits.pop_back();
  return digits.find_first_not_of('9') == std::string::npos;
}

// whether `value`, `gap` from values that span `span`, is a code
bool IsCode(const Extremes::Value& value, double gap, double span) {
  if (!(gap > span)) return false;
  return IsNines(value.value) || gap > kFarM ||
         (span > 0 && gap > kRailSpans * span && value.rows >= kLeastRailRows);
}

// The codes at either end: the most values that may be taken off so that each is one, seen from
// those that are left, which hold most rows.
std::vector<NoReadingCode> CodesOf(const Extremes& extremes, std::size_t measured) {
  const auto& low = extremes.lowest();
  const auto& high = extremes.highest();
  std::vector<NoReadingCode> codes;
  for (std::size_t below = 0; below < low.size(); ++below) {
    for (std::size_t above = 0; above < high.size(); ++above) {
      const double least = low[below].value;
      const double most = high[above].value;
      if (least > most || below + above <= codes.size()) continue;
      std::vector<NoReadingCode> found;
      std::size_t rows = 0;
      for (std::size_t k = 0; k < below; ++k) {
        if (!IsCode(low[k], least - low[k].value, most - least)) break;
        rows += low[k].rows;
        const bool is_invalid = fmt::format("{:.4e}", low[k].value).starts_with("-9.9998");
        found.push_back({low[k].value, is_invalid ? SampleStatus::kInvalid : SampleStatus::kUnder,
                         low[k].rows});
      }
      for (std::size_t k = 0; k < above; ++k) {
        if (!IsCode(high[k], high[k].value - most, most - least)) break;
        rows += high[k].rows;
        found.push_back({high[k].value, SampleStatus::kOver, high[k].rows});
      }
      if (found.size() == below + above && 2 * rows < measured) codes = std::move(found);
    }
  }
  return codes;
}

// what one pass over all rows gives
struct Pass {
  Faults faults;
  RawSummary summary;
  Extremes extremes;
  std::vector<RowRange> holes;
  Segments counts;
};

// rows of each status, and holes
void Count(const RowBlock& block, Pass& pass) {
  Segments& counts = pass.counts;
  if (block.all_ok) {
    counts.by_status[0] += block.rows();
    counts.measured += block.rows();
    return;
  }
  const auto values = block.values();
  const auto statuses = block.statuses();
  for (std::size_t k = 0; k < values.size(); ++k) {
    ++counts.by_status[static_cast<std::size_t>(statuses[k])];
    if (IsMeasured(values[k], statuses[k])) {
      ++counts.measured;
      continue;
    }
    const std::size_t row = block.first_row + k;
    if (pass.holes.empty() || pass.holes.back().end < row) pass.holes.push_back({row, row});
    pass.holes.back().end = row + 1;
  }
}

// adds what a pass without the excluded rows finds: spikes and held readings to those before; steps
// and clipping replace those that were seen beside them
void Merge(const Faults& pass, Faults& all) {
  using enum FaultKind;
  std::erase_if(all.list, [](const Fault& f) { return f.kind == kStep || f.kind == kClipped; });
  all.list.insert(all.list.end(), pass.list.begin(), pass.list.end());
  std::ranges::sort(all.list, {}, &Fault::first_row);
  std::array<std::size_t, kFaultKindCount> listed{};
  std::erase_if(all.list, [&](const Fault& fault) {
    return ++listed[static_cast<std::size_t>(fault.kind)] > kMostListed;
  });
  all.clipped = pass.clipped;
  for (std::size_t k = 0; k < kFaultKindCount; ++k) {
    const auto kind = static_cast<FaultKind>(k);
    const bool adds = kind == kSpike || kind == kHeld;
    all.count[k] = (adds ? all.count[k] : 0) + pass.count[k];
    all.rows[k] = (adds ? all.rows[k] : 0) + pass.rows[k];
  }
  all.excluded.insert(all.excluded.end(), pass.excluded.begin(), pass.excluded.end());
  std::ranges::sort(all.excluded, {}, &RowRange::begin);
}

// a block of rows with its margins
class Window {
 public:
  Result<RowBlock> Load(const CleanRows& source, std::size_t channel, std::size_t first) {
    const std::size_t rows = source.head().rows;
    const std::size_t end = first + std::min(kPassRows, rows - first);
    const std::size_t held = first - std::min(first, kMarginRows);
    values_.resize(end + std::min(rows - end, kMarginRows) - held);
    statuses_.resize(values_.size());
    HAPTOMETER_TRY(source.Read(channel, held, values_, statuses_));
    return RowBlock{
        first, end, rows, held, values_, statuses_, AllOk(statuses_) && AllFinite(values_)};
  }

 private:
  std::vector<double> values_;
  std::vector<SampleStatus> statuses_;
};

double HighestRate(const trial::Record& head) {
  double rate_hz = 0;
  for (const trial::Stretch& stretch : head.stretches) rate_hz = std::max(rate_hz, stretch.rate_hz);
  return rate_hz;
}

Result<Pass> PassOver(const CleanRows& source, std::size_t number, int threads) {
  const trial::Record& head = source.head();
  const trial::Channel& channel = head.channels[number];
  RawSummarizer summarizer(head);
  FaultScanner scanner(
      {channel.range_min, channel.range_max, channel.resolution, LongestHole(HighestRate(head))});
  Pass pass;
  const std::size_t blocks = (head.rows + kPassRows - 1) / kPassRows;
  const auto done = RunJobsInOrder(blocks, threads, [&]() -> OrderedWorker {
    // blocks are read and looked at in parallel; results follow in order of the blocks
    return
        [&, window = Window(), extremes = Extremes()](std::size_t job) mutable -> Result<Finish> {
          const auto block = window.Load(source, number, job * kPassRows);
          if (!block) return std::unexpected(block.error());
          extremes.Recount();
          extremes.Take(*block);
          return [&, block = *block, summed = summarizer.LookAt(*block),
                  looked = scanner.Look(*block), seen = extremes] {
            Count(block, pass);
            summarizer.Feed(block, summed);
            scanner.Feed(block, looked);
            pass.extremes.Merge(seen);
          };
        };
  });
  if (!done) return std::unexpected(done.error());
  pass.faults = scanner.Finish();
  pass.summary = summarizer.Finish();
  return pass;
}

}  // namespace

CleanRows::CleanRows(const trial::RowSource& source, std::size_t channel)
    : source_(source), channel_(channel), source_rows_(source.head().rows), head_(source.head()) {
  Join(source.head().stretches);
}

// stretches on one clock whose distance is a whole number of rows become one
void CleanRows::Join(const std::vector<trial::Stretch>& stretches) {
  head_.stretches.clear();
  head_.rows = 0;
  std::size_t absent = 0;
  for (std::size_t k = 0; k < stretches.size(); ++k) {
    const trial::Stretch& stretch = stretches[k];
    const auto missing =
        k > 0 ? RowsBetween(head_.timing, stretches[k - 1], stretch) : std::nullopt;
    if (missing && *missing <= source_rows_ - absent) {
      absent += *missing;
      trial::Stretch& last = head_.stretches.back();
      last.rows += *missing + stretch.rows;
      // the rate by the first row and the last, as of a table whose missing values are empty
      const double last_s =
          stretch.start_s + static_cast<double>(stretch.rows - 1) / stretch.rate_hz;
      last.rate_hz = static_cast<double>(last.rows - 1) / (last_s - last.start_s);
      head_.rows += *missing;
    } else {
      head_.stretches.push_back(stretch);
      head_.stretches.back().first_row = head_.rows;
    }
    parts_.push_back({head_.rows, stretch.first_row, stretch.rows});
    head_.rows += stretch.rows;
  }
}

const CleanRows::Part& CleanRows::PartOf(std::size_t row) const {
  return *std::prev(std::ranges::upper_bound(parts_, row, {}, &Part::first_row));
}

std::size_t CleanRows::RowOf(std::size_t row) const {
  if (parts_.empty()) return row;
  const Part& part = PartOf(row);
  return part.source_row + std::min(row - part.first_row, part.rows);
}

bool CleanRows::IsAbsent(std::size_t row) const {
  const Part& part = PartOf(row);
  return row - part.first_row >= part.rows;
}

Result<void> CleanRows::Read(std::size_t channel, std::size_t first, std::span<double> values,
                             std::span<SampleStatus> statuses) const {
  if (!AnyAbsent()) {
    HAPTOMETER_TRY(source_.Read(channel, first, values, statuses));
  } else {
    std::ranges::fill(values, kNaN);
    std::ranges::fill(statuses, SampleStatus::kLate);
    const std::size_t end = first + values.size();
    // the rows of each part in their places
    for (const Part* part = &PartOf(first); part <= &parts_.back() && part->first_row < end;
         ++part) {
      const std::size_t begin = std::max(first, part->first_row);
      const std::size_t part_end = std::min(end, part->first_row + part->rows);
      if (begin >= part_end) continue;
      HAPTOMETER_TRY(source_.Read(channel, part->source_row + (begin - part->first_row),
                                  values.subspan(begin - first, part_end - begin),
                                  statuses.subspan(begin - first, part_end - begin)));
    }
  }
  if (channel == channel_) Exclude(first, values, statuses);
  return {};
}

void CleanRows::Exclude(std::size_t first, std::span<double> values,
                        std::span<SampleStatus> statuses) const {
  for (const NoReadingCode& code : codes_) {
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (values[k] != code.value || !trial::IsMeasurement(statuses[k])) continue;
      values[k] = kNaN;
      statuses[k] = code.status;
    }
  }
  const std::size_t end = first + values.size();
  auto range = std::ranges::upper_bound(excluded_, first, {}, &RowRange::end);
  for (; range != excluded_.end() && range->begin < end; ++range) {
    for (std::size_t row = std::max(first, range->begin); row < std::min(end, range->end); ++row) {
      values[row - first] = kNaN;
      statuses[row - first] = SampleStatus::kInvalid;
    }
  }
}

Result<CleanChannel> Clean(const trial::RowSource& source, std::size_t channel, int threads) {
  CleanChannel clean{.rows = std::make_unique<CleanRows>(source, channel)};
  auto pass = PassOver(*clean.rows, channel, threads);
  if (!pass) return std::unexpected(pass.error());
  // codes first: nothing else may be judged beside them
  clean.codes = CodesOf(pass->extremes, pass->counts.measured);
  if (!clean.codes.empty()) {
    clean.rows->ExcludeValues(clean.codes);
    pass = PassOver(*clean.rows, channel, threads);
    if (!pass) return std::unexpected(pass.error());
  }
  clean.faults = pass->faults;
  // a spike beside another is seen once the other is gone
  for (int round = 0; round < kMostRounds && !pass->faults.excluded.empty(); ++round) {
    clean.rows->ExcludeRows(clean.faults.excluded);
    pass = PassOver(*clean.rows, channel, threads);
    if (!pass) return std::unexpected(pass.error());
    Merge(pass->faults, clean.faults);
  }
  clean.summary = std::move(pass->summary);
  auto segments = SplitAtHoles(*clean.rows, channel, pass->holes);
  if (!segments) return std::unexpected(segments.error());
  clean.segments = std::move(*segments);
  clean.segments.measured = pass->counts.measured;
  clean.segments.by_status = pass->counts.by_status;
  return clean;
}

}  // namespace haptometer::dsp
