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

}  // namespace

void MarkRowsWrittenTwice(const std::vector<Channel>& channels, CsvRows::Segment* segment) {
  const auto& times_s = segment->times.times_s();
  const auto& repeated = segment->times.repeated();
  Share with_time{.of = static_cast<double>(repeated.size())};
  Share beside;
  std::size_t counted = 0;  // rows up to it are counted
  // row `i` of the segment, where its time differs from that of the row before
  const auto count_beside = [&](std::size_t i) {
    if (i <= counted || i >= times_s.size() || times_s[i] == times_s[i - 1]) return;
    counted = i;
    ++beside.of;
    if (RepeatsValues(channels, segment->first_row + i)) ++beside.count;
  };
  for (const std::size_t i : repeated) {
    // the rows next to it alone: readings may rest in another part of the record
    count_beside(i - 1);
    count_beside(i + 1);
    if (!RepeatsValues(channels, segment->first_row + i)) continue;
    if (with_time.count == 0) segment->first_copy = i;
    ++with_time.count;
  }
  if (repeated.empty() || !AreCopies(with_time, beside)) return;
  segment->copies = static_cast<std::size_t>(with_time.count);
}

}  // namespace haptometer::trial
