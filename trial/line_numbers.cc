#include "trial/line_numbers.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <optional>

#include "base/median.h"
#include "trial/time_lines.h"

namespace haptometer::trial {
namespace {

constexpr double kLeastEarlyNs = 5e6;
constexpr double kPeriods = 2;
constexpr double kAgree = 0.05;  // of two estimates of a period
constexpr double kScatters = 3;
constexpr std::size_t kWindows = 5;       // in time, of which the envelope is the least level
constexpr std::size_t kFewestRows = 16;   // of a window that shows whether it is in time
constexpr std::size_t kMostOpen = 64;     // losses that are not confirmed yet
constexpr double kHeldNs = kNsPerSecond;  // lines that ports may have held before the first row

// a loss that the numbers claim
struct Claim {
  std::size_t row = 0;
  double rows = 0;  // 0: missing rows of unknown number
  bool is_refused = false;
};

// median time per line over four windows, ns; nothing of too few rows
std::optional<double> PlainPeriod(const TimedRows& rows, std::size_t window_rows) {
  const std::size_t count = std::clamp(rows.size() / 4, window_rows, 4 * window_rows);
  std::vector<double> periods;
  for (std::size_t end = count; end < rows.size(); end += count) {
    const std::size_t first = end - count;
    periods.push_back((rows.times[end] - rows.times[first]) /
                      (rows.places[end] - rows.places[first]));
  }
  if (periods.empty()) return std::nullopt;
  return UpperMedian(std::move(periods));
}

// The source, whose period a few large losses that were none spoil, and many true ones that are not
// counted: with them or without, whichever agrees with the plain median. Else rather too short a
// period: lost lines then seem to take less time.
SourcePeriod SourceOf(const TimedRows& rows) {
  const SourcePeriod with = PeriodOf(rows);
  const auto plain_ns = PlainPeriod(rows, with.window_rows);
  const auto agrees = [&](const SourcePeriod& source) {
    return std::abs(source.ns - *plain_ns) <= kAgree * *plain_ns;
  };
  if (!plain_ns || agrees(with)) return with;
  const std::vector<double> numbers = PlacesOf(rows.size(), {});
  const SourcePeriod without = PeriodOf({rows.times, numbers});
  if (agrees(without)) return without;
  return {(1 - kAgree) * *plain_ns, with.window_rows, with.block_ns, with.is_of_blocks};
}

// what a row may be early by without any wrong number
double MarginOf(const TimedRows& rows, const SourcePeriod& source) {
  const auto windows = WindowsOf(rows, source.ns, source.window_rows);
  std::vector<double> steps;
  for (std::size_t k = 1; k < windows.size(); ++k) {
    steps.push_back(std::abs(windows[k].level_ns - windows[k - 1].level_ns));
  }
  const double scatter_ns = kDeviationsPerMedian * UpperMedian(std::move(steps));
  return std::max({kLeastEarlyNs, kPeriods * source.ns, kScatters * scatter_ns, source.block_ns});
}

// Goes through the rows in their order, and takes back losses whose lines come too early.
class EarlyLines {
 public:
  EarlyLines(const TimedRows& rows, const SourcePeriod& source)
      : rows_(rows), source_(source), margin_ns_(MarginOf(rows, source)) {}

  void Claimed(Claim& claim) {
    // a window that ends here holds nothing of this loss
    if (claim.row - first_ >= kFewestRows) CloseWindow(claim.row);
    if (claim.rows == 0) return Forget(claim.row);
    open_.push_back(&claim);
    if (open_.size() > kMostOpen) open_.pop_front();
  }

  void Came(std::size_t row) {
    if (!levels_ns_.empty()) TakeBack(row, *std::ranges::min_element(levels_ns_) - Level(row));
    if (row == first_ || Level(row) < Level(least_)) least_ = row;
    if (row + 1 - first_ >= source_.window_rows) CloseWindow(row + 1);
  }

 private:
  double Level(std::size_t row) const {
    return rows_.times[row] - (rows_.places[row] - refused_rows_) * source_.ns;
  }

  // missing rows of unknown number: a new envelope begins
  void Forget(std::size_t row) {
    levels_ns_.clear();
    open_.clear();
    first_ = row;
  }

  void TakeBack(std::size_t row, double early_ns) {
    if (early_ns <= margin_ns_ || open_.empty()) return;
    const auto largest = std::ranges::max_element(open_, {}, &Claim::rows);
    const double claimed_ns = (*largest)->rows * source_.ns;
    if (early_ns < 0.5 * claimed_ns || claimed_ns < 0.5 * early_ns) return;
    (*largest)->is_refused = true;
    refused_rows_ += (*largest)->rows;
    open_.erase(largest);
    first_ = row;
  }

  // the window [first_, end): where it came no faster than the source sends, it shows the envelope
  void CloseWindow(std::size_t end) {
    const double took_ns = rows_.times[end - 1] - rows_.times[first_];
    const double sent_ns = (rows_.places[end - 1] - rows_.places[first_]) * source_.ns;
    first_ = end;
    if (took_ns < kCatchingUp * sent_ns) return;
    const double level_ns = Level(least_);
    // losses before a line that is on the envelope are confirmed
    const bool is_low =
        levels_ns_.empty() || level_ns < *std::ranges::min_element(levels_ns_) + margin_ns_;
    if (is_low) std::erase_if(open_, [&](const Claim* claim) { return claim->row <= least_; });
    levels_ns_.push_back(level_ns);
    if (levels_ns_.size() > kWindows) levels_ns_.pop_front();
  }

  TimedRows rows_;
  SourcePeriod source_;
  double margin_ns_;
  double refused_rows_ = 0;
  std::size_t first_ = 0;         // of the window that is open
  std::size_t least_ = 0;         // its row with the least level
  std::deque<double> levels_ns_;  // of the last windows in time
  std::deque<Claim*> open_;       // losses whose lines have not been seen in time
};

// whether the lines that came fit on their wire, but not with all that are claimed
bool ExceedsTheWire(const TimedRows& rows, double wire_ns) {
  const double room_ns = rows.times.back() - rows.times.front() + kHeldNs;
  return AsDouble(rows.size()) * wire_ns <= room_ns && rows.places.back() * wire_ns > room_ns;
}

void Judge(const TimedRows& rows, const NumberedLines& lines, std::vector<Claim>& claims) {
  if (ExceedsTheWire(rows, lines.wire_ns)) {
    for (Claim& claim : claims) claim.is_refused = claim.rows > 0;
    return;
  }
  EarlyLines early(rows, SourceOf(rows));
  auto claim = claims.begin();
  for (std::size_t row = 0; row < rows.size(); ++row) {
    for (; claim != claims.end() && claim->row == row; ++claim) early.Claimed(*claim);
    early.Came(row);
  }
}

// whether two losses beside one line are its wrong number: together they make up turns
bool IsWrongNumber(const Claim& before, const Claim& behind, std::uint64_t turn) {
  return turn > 0 && behind.row == before.row + 1 && before.rows > 0 && behind.rows > 0 &&
         (before.is_refused || behind.is_refused) &&
         std::fmod(before.rows + behind.rows, static_cast<double>(turn)) == 0;
}

JudgedLosses Sorted(std::vector<Claim> claims, std::uint64_t turn) {
  JudgedLosses judged;
  bool follows_refused = false;
  for (std::size_t k = 0; k < claims.size(); ++k) {
    Claim& claim = claims[k];
    const bool is_first = k + 1 < claims.size() && IsWrongNumber(claim, claims[k + 1], turn);
    const bool is_second = k > 0 && IsWrongNumber(claims[k - 1], claim, turn);
    claim.is_refused = claim.is_refused || is_first || is_second;
    const auto count =
        claim.rows > 0 ? std::optional(static_cast<std::uint64_t>(claim.rows)) : std::nullopt;
    if (!claim.is_refused) {
      judged.missing.push_back({claim.row, count});
    } else {
      judged.refused.push_back({claim.row, count});
      // a break, unless the one before is that of these numbers already
      const bool follows = follows_refused && claims[k - 1].row + 1 >= claim.row;
      if (!is_first && !is_second && !follows) judged.missing.push_back({claim.row, std::nullopt});
    }
    follows_refused = claim.is_refused;
  }
  return judged;
}

}  // namespace

JudgedLosses JudgeLosses(std::span<const std::int64_t> time_ns,
                         std::span<const MissingRows> missing, const NumberedLines& lines) {
  const auto claims_a_number = [](const MissingRows& at) { return at.count.value_or(0) > 0; };
  if (time_ns.empty() || std::ranges::none_of(missing, claims_a_number)) {
    return {{missing.begin(), missing.end()}, {}};
  }
  std::vector<Claim> claims;
  claims.reserve(missing.size());
  for (const MissingRows& at : missing) {
    claims.push_back({.row = at.row, .rows = static_cast<double>(at.count.value_or(0))});
  }
  const std::vector<double> times = SinceFirst(time_ns);
  const std::vector<double> places = PlacesOf(times.size(), missing);
  Judge({times, places}, lines, claims);
  return Sorted(std::move(claims), lines.turn);
}

}  // namespace haptometer::trial
