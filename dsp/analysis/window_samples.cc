#include "dsp/analysis/window_samples.h"

#include <algorithm>

#include "base/check.h"
#include "dsp/analysis/displacement_channel.h"
#include "dsp/analysis/segments.h"

namespace haptometer::dsp {

Result<WindowSamples> ReadWindow(const trial::RowSource& source, const BandAnalysis& analysis,
                                 std::size_t most) {
  HAPTOMETER_CHECK(analysis.numbers, "an analysis without a window");
  const UsedPart& part = analysis.numbers->part;
  const auto channel = DisplacementChannel(source.head());
  if (!channel) return std::unexpected(channel.error());
  const auto segments = SplitIntoSegments(source, *channel, analysis.band.upper_hz);
  if (!segments) return std::unexpected(segments.error());
  const auto holds_window = [&](const Segment& segment) {
    return part.first_row >= segment.first_row &&
           part.first_row + part.rows <= segment.first_row + segment.size;
  };
  const auto segment = std::ranges::find_if(segments->parts, holds_window);
  HAPTOMETER_CHECK(segment != segments->parts.end(), "rows {} + {} are in no segment",
                   part.first_row, part.rows);

  WindowSamples window;
  const std::size_t count = std::min(part.rows, most);
  const std::size_t first = part.first_row - segment->first_row + (part.rows - count) / 2;
  window.rate_hz = segment->rate_hz;
  window.start_s = segment->start_s + static_cast<double>(first) / segment->rate_hz;
  window.values_m.resize(count);
  const SegmentSamples samples(source, *channel, *segment);
  if (auto read = samples.Read(first, window.values_m); !read) {
    return std::unexpected(read.error());
  }
  return window;
}

}  // namespace haptometer::dsp
