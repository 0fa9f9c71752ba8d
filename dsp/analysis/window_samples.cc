#include "dsp/analysis/window_samples.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "dsp/analysis/clean_rows.h"
#include "dsp/analysis/record_facts.h"
#include "dsp/analysis/regular_grid.h"
#include "dsp/analysis/segments.h"

namespace haptometer::dsp {
namespace {

// samples of `window` in `segment`, at most `most` from its middle
WindowSamples PlaceOf(const Segment& segment, const TimeWindow& window, std::size_t most) {
  const double begin = std::round((window.begin_s - segment.start_s) * segment.rate_hz);
  const double wanted = std::round(window.duration_s() * segment.rate_hz);
  const auto first = std::min(static_cast<std::size_t>(begin), segment.size);
  const std::size_t size = std::min(static_cast<std::size_t>(wanted), segment.size - first);
  const std::size_t count = std::min(size, most);
  const std::size_t begin_of_middle = first + (size - count) / 2;
  WindowSamples samples;
  samples.rate_hz = segment.rate_hz;
  samples.start_s = segment.start_s + static_cast<double>(begin_of_middle) / segment.rate_hz;
  samples.values_m.resize(count);
  return samples;
}

// samples before the filter, from the segment that holds the window's middle
Result<WindowSamples> ReadFrom(const trial::RowSource& source, const BandAnalysis& analysis,
                               std::size_t most) {
  const auto channel = AnalyzedChannel(source.head());
  if (!channel) return std::unexpected(channel.error());
  const auto clean = Clean(source, *channel);
  if (!clean) return std::unexpected(clean.error());
  const Segments* segments = &clean->segments;
  const TimeWindow& window = analysis.numbers->part.window;
  const double middle_s = (window.begin_s + window.end_s) / 2;
  const auto holds_window = [&](const Segment& segment) {
    return middle_s >= segment.start_s &&
           middle_s < segment.start_s + static_cast<double>(segment.size) / segment.rate_hz;
  };
  const auto segment = std::ranges::find_if(segments->parts, holds_window);
  HAPTOMETER_CHECK(segment != segments->parts.end(), "{} s are in no segment", middle_s);
  WindowSamples samples = PlaceOf(*segment, window, most);
  const double first = std::round((samples.start_s - segment->start_s) * segment->rate_hz);
  const auto read = SegmentSamples(*clean->rows, *channel, *segment)
                        .Read(static_cast<std::size_t>(first), samples.values_m);
  if (!read) return std::unexpected(read.error());
  return samples;
}

}  // namespace

Result<WindowSamples> ReadWindow(const trial::RowSource& source, const BandAnalysis& analysis,
                                 std::size_t most) {
  HAPTOMETER_CHECK(analysis.numbers, "an analysis without a window");
  // as in AnalyzeBand: known times are put on the same grid first
  if (!source.head().times_are_known) return ReadFrom(source, analysis, most);
  const auto grid = OnRegularGrid(source, analysis.band.upper_hz);
  if (!grid) return std::unexpected(grid.error());
  HAPTOMETER_CHECK(!grid->refusal, "an analysis of times without a grid");
  return ReadFrom(trial::RecordRows(grid->record), analysis, most);
}

}  // namespace haptometer::dsp
