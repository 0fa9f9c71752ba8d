#include "dsp/analysis/sweep_piece.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "dsp/analysis/row_block.h"

namespace haptometer::dsp {
namespace {

// limit of memory: some ten copies of the piece are made
constexpr std::size_t kMostSamples = std::size_t{1} << 24U;

// a voltage, or else a current; a trigger has no amplitude to divide by
std::optional<std::size_t> DriveChannelOf(const trial::Record& head) {
  for (const trial::ChannelRole role :
       {trial::ChannelRole::kVoltage, trial::ChannelRole::kCurrent}) {
    if (const trial::Channel* channel = head.Find(role)) {
      return static_cast<std::size_t>(channel - head.channels.data());
    }
  }
  return std::nullopt;
}

// [first, last) of the longest run of measured values
std::pair<std::size_t, std::size_t> LongestRun(std::span<const double> values,
                                               std::span<const trial::SampleStatus> statuses) {
  std::pair<std::size_t, std::size_t> longest{0, 0};
  std::size_t begin = 0;
  for (std::size_t k = 0; k <= values.size(); ++k) {
    if (k < values.size() && IsMeasured(values[k], statuses[k])) continue;
    if (k - begin > longest.second - longest.first) longest = {begin, k};
    begin = k + 1;
  }
  return longest;
}

void Crop(std::vector<double>& values, std::size_t first, std::size_t last) {
  values = {values.begin() + static_cast<std::ptrdiff_t>(first),
            values.begin() + static_cast<std::ptrdiff_t>(last)};
}

// adds the drive beside the displacement, both cut to where the drive is measured
Result<void> AddDrive(const trial::RowSource& source, std::size_t channel, std::size_t first_row,
                      SweepPiece& piece, Findings& findings) {
  std::vector<double> values(piece.displacement_m.size());
  std::vector<trial::SampleStatus> statuses(values.size());
  if (auto read = source.Read(channel, first_row, values, statuses); !read) return read;
  const auto [first, last] = LongestRun(values, statuses);
  const trial::Channel& drive = source.head().channels[channel];
  // a constant channel is no excitation: the sweep is then analysed without it
  const auto moves = [&] {
    const auto run = std::span(values).subspan(first, last - first);
    return !run.empty() && std::ranges::min(run) < std::ranges::max(run);
  };
  if (!moves()) {
    findings.Note(FindingKind::kDriveConstant, {{"channel", drive.name}});
    return {};
  }
  if (last - first < values.size()) {
    findings.Note(FindingKind::kDriveGaps, {{"channel", drive.name}});
  }
  Crop(values, first, last);
  Crop(piece.displacement_m, first, last);
  piece.start_s += static_cast<double>(first) / piece.rate_hz;
  piece.drive = std::move(values);
  piece.drive_channel = channel;
  return {};
}

}  // namespace

Result<SweepPiece> ReadSweepPiece(const trial::RowSource& source, std::size_t channel,
                                  const Segments& segments, Findings& findings) {
  // longest in time, since rates may differ
  const auto longest = std::ranges::max_element(
      segments.parts, {}, [](const Segment& s) { return static_cast<double>(s.size) / s.rate_hz; });
  if (longest == segments.parts.end()) return SweepPiece{};
  if (segments.parts.size() > 1) {
    findings.Note(FindingKind::kLongestSegment, {{"segments", segments.parts.size()}});
  }
  if (longest->size > kMostSamples) {
    findings.Note(FindingKind::kSamplesLimited,
                  {{"samples", longest->size}, {"used", kMostSamples}});
  }
  SweepPiece piece;
  piece.start_s = longest->start_s;
  piece.rate_hz = longest->rate_hz;
  piece.displacement_m.resize(std::min(longest->size, kMostSamples));
  const SegmentSamples samples(source, channel, *longest);
  if (auto read = samples.Read(0, piece.displacement_m); !read)
    return std::unexpected(read.error());
  if (const auto drive = DriveChannelOf(source.head())) {
    const auto added = AddDrive(source, *drive, longest->first_row, piece, findings);
    if (!added) return std::unexpected(added.error());
  }
  return piece;
}

}  // namespace haptometer::dsp
