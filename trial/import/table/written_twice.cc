#include "trial/import/table/written_twice.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace haptometer::trial {
namespace {

// whether `row` has every value and status of the row before
bool RepeatsValues(const std::vector<Channel>& channels, std::size_t row) {
  return std::ranges::all_of(channels, [&](const Channel& channel) {
    const double value = channel.values[row];
    const double before = channel.values[row - 1];
    const bool is_equal = value == before || (std::isnan(value) && std::isnan(before));
    return is_equal && channel.statuses[row] == channel.statuses[row - 1];
  });
}

// how often something was counted among how many
struct Share {
  double count = 0;
  double of = 0;

  [[nodiscard]] double value() const { return count / of; }
};

// a log(a / b), 0 for a = 0
double Term(double a, double b) { return a > 0 ? a * std::log(a / b) : 0; }

// of two-valued variables, times their number
double Entropy(const Share& share, double expected) {
  const double a = share.value();
  return share.of * (Term(a, expected) + Term(1 - a, 1 - expected));
}

// whether values repeat with the time more often than beside it, and by more than chance gives
bool AreCopies(const Share& with_time, const Share& beside) {
  if (beside.of == 0 || with_time.value() <= beside.value()) return false;
  const double both = (with_time.count + beside.count) / (with_time.of + beside.of);
  const double p = beside.value();
  const double by_chance = p * (with_time.of - with_time.count) / (1 - p);
  return Entropy(with_time, both) + Entropy(beside, both) > std::log(1000.0) &&
         by_chance <= with_time.count / 10;
}

// rows up to `reach` from one with the time of the row before, whose own time is another, and how
// many of them repeat the values
Share Beside(const std::vector<Channel>& channels, const CsvRows::Segment& segment,
             std::size_t reach) {
  const auto& times_s = segment.times.times_s();
  Share beside;
  std::size_t next = 1;  // the first row that is not counted yet
  for (const std::size_t i : segment.times.repeated()) {
    const std::size_t end = std::min(i + reach + 1, times_s.size());
    for (next = std::max(next, i > reach ? i - reach : 1); next < end; ++next) {
      if (times_s[next] == times_s[next - 1]) continue;
      ++beside.of;
      if (RepeatsValues(channels, segment.first_row + next)) ++beside.count;
    }
  }
  return beside;
}

}  // namespace

void MarkRowsWrittenTwice(const std::vector<Channel>& channels, CsvRows::Segment* segment) {
  constexpr std::size_t kFar = 512;
  constexpr double kSeldom = 0.01;
  const auto& repeated = segment->times.repeated();
  Share with_time{.of = static_cast<double>(repeated.size())};
  for (const std::size_t i : repeated) {
    if (!RepeatsValues(channels, segment->first_row + i)) continue;
    if (with_time.count == 0) segment->first_copy = i;
    ++with_time.count;
  }
  if (with_time.count == 0) return;
  // the rows next to them alone, as readings may rest in another part of the record; more of them
  // where hardly any repeat
  const Share next = Beside(channels, *segment, 1);
  const Share around = next.count == 0 ? Beside(channels, *segment, kFar) : next;
  const bool is_seldom = around.value() <= kSeldom;
  if (!AreCopies(with_time, next) && !(is_seldom && AreCopies(with_time, around))) return;
  segment->copies = static_cast<std::size_t>(with_time.count);
}

}  // namespace haptometer::trial
