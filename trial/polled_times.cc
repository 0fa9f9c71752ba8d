#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/median.h"
#include "trial/time_base.h"
#include "trial/time_lines.h"

namespace haptometer::trial {

namespace {

// the least-squares line of a piece; its own slope where it has rows enough
// rows centred on their mean: period = sum(x t) / sum(x^2)
TimeLine MeanLine(Times part, std::optional<double> common_period_ns) {
  const double mean_x = 0.5 * AsDouble(part.size() - 1);
  double mean_t = 0;
  for (const double t : part) mean_t += t / AsDouble(part.size());
  double xt = 0;
  double xx = 0;
  for (std::size_t j = 0; j < part.size(); ++j) {
    const double x = AsDouble(j) - mean_x;
    xt += x * (part[j] - mean_t);
    xx += x * x;
  }
  // two rows do not determine a period against the uncertainty of their times
  const bool is_short = part.size() < 3;
  const double own_ns = xx > 0 ? xt / xx : 0;
  const double period_ns = is_short ? common_period_ns.value_or(own_ns) : own_ns;
  return {mean_t - mean_x * period_ns, period_ns};
}

// scatter of polled times about `line`, and of the reading within request and reply
double PolledUncertaintyNs(Times part, Times waits, const TimeLine& line) {
  double squares = 0;
  for (std::size_t j = 0; j < part.size(); ++j) {
    const double residual = part[j] - line.start_ns - AsDouble(j) * line.period_ns;
    // the reading is anywhere within its wait: variance wait^2 / 12 (uniform distribution)
    squares += residual * residual + waits[j] * waits[j] / 12;
  }
  return std::sqrt(squares / AsDouble(part.size()));
}

}  // namespace

std::vector<Stretch> FitPolledTimes(std::span<const std::int64_t> request_ns,
                                    std::span<const std::int64_t> reply_ns,
                                    std::optional<double> nominal_rate_hz,
                                    std::span<const std::size_t> breaks) {
  HAPTOMETER_CHECK(request_ns.size() == reply_ns.size(), "{} requests, {} replies",
                   request_ns.size(), reply_ns.size());
  if (request_ns.empty()) return {};
  // time of a polled reading: the middle of request and reply
  std::vector<double> middles = SinceFirst(request_ns);
  std::vector<double> waits;
  for (std::size_t j = 0; j < middles.size(); ++j) {
    waits.push_back(static_cast<double>(reply_ns[j]) - static_cast<double>(request_ns[j]));
    middles[j] += 0.5 * waits[j];
  }
  // a pause between two polls begins a segment, as a break does
  const std::vector<double> intervals = Differences(middles);
  const double median_ns = UpperMedian(intervals);
  std::vector<std::size_t> starts(breaks.begin(), breaks.end());
  for (std::size_t j = 0; j < intervals.size(); ++j) {
    if (intervals[j] > 8 * median_ns) starts.push_back(j + 1);
  }
  // period for short segments: the median interval, else the nominal one
  std::optional<double> common_period_ns;
  if (nominal_rate_hz && *nominal_rate_hz > 0) common_period_ns = kNsPerSecond / *nominal_rate_hz;
  if (median_ns > 0) common_period_ns = median_ns;
  std::vector<Stretch> stretches;
  for (const RowPiece& piece : PiecesBetween(middles.size(), std::move(starts))) {
    const Times part = Times(middles).subspan(piece.first, piece.rows());
    const TimeLine line = MeanLine(part, common_period_ns);
    const double start_ns = static_cast<double>(request_ns.front()) + line.start_ns;
    const Times part_waits = Times(waits).subspan(piece.first, piece.rows());
    stretches.push_back(
        {.first_row = piece.first,
         .rows = piece.rows(),
         .start_s = start_ns / kNsPerSecond,
         .rate_hz = RateOf(line.period_ns),
         .time_uncertainty_s = PolledUncertaintyNs(part, part_waits, line) / kNsPerSecond});
  }
  return stretches;
}

}  // namespace haptometer::trial
