#include "trial/trial_rows.h"

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "trial/block.h"
#include "trial/row_column.h"
#include "trial/uniform_grid.h"

namespace haptometer::trial {
namespace {

// bytes that are decoded in one go: they stay in the processor's nearer cache
constexpr std::size_t kPieceBytes = std::size_t{1} << 16U;

}  // namespace

TrialRows::TrialRows(const TrialHeader& header, std::string name)
    : name_(std::move(name)), header_(header) {
  head_.timing = header.timing;
  head_.channels.reserve(header.channels.size());
  for (const ChannelFormat& format : header.channels) head_.channels.push_back(ChannelOf(format));
}

Result<std::unique_ptr<TrialRows>> TrialRows::From(TrialReader reader, std::string name,
                                                   int threads) {
  HAPTOMETER_CHECK(CanRead(reader.header()), "timing {}", trial::Name(reader.header().timing));
  std::unique_ptr<TrialRows> rows(new TrialRows(reader.header(), std::move(name)));
  if (auto checked = reader.CheckRows(threads); !checked) {
    return std::unexpected(checked.error());
  }
  UniformGrid grid(reader.header().rate_hz);
  for (;;) {
    const auto chunk = reader.Next();
    if (!chunk) return std::unexpected(chunk.error());
    if (*chunk == nullptr) break;
    rows->blocks_.push_back({rows->head_.rows, (*chunk)->offset()});
    grid.Append((*chunk)->first_index(), (*chunk)->rows());
    rows->head_.rows += (*chunk)->rows();
  }
  rows->report_ = reader.report();
  rows->head_.stretches = grid.stretches();
  rows->head_.metadata = MetadataOf(reader.header(), rows->report_);
  rows->source_ = std::move(reader).TakeSource();
  return rows;
}

Result<void> TrialRows::Read(std::size_t channel, std::size_t first, std::span<double> values,
                             std::span<SampleStatus> statuses) const {
  HAPTOMETER_CHECK(channel < head_.channels.size() && values.size() == statuses.size() &&
                       first <= head_.rows && values.size() <= head_.rows - first,
                   "channel {}, rows {} + {} of {}", channel, first, values.size(), head_.rows);
  const std::size_t row_bytes = LayoutOf(header_).row_bytes;
  auto block = std::ranges::upper_bound(blocks_, first, {}, &Rows::first);
  while (!values.empty()) {
    const Rows& rows = *(block - 1);
    const std::size_t end = block == blocks_.end() ? head_.rows : block->first;
    const std::size_t count = std::min(values.size(), end - first);
    const std::uint64_t offset = rows.offset + (first - rows.first) * row_bytes;
    if (auto read = ReadPiece(channel, offset, values.first(count), statuses.first(count)); !read) {
      return read;
    }
    first += count;
    values = values.subspan(count);
    statuses = statuses.subspan(count);
    ++block;
  }
  return {};
}

Result<void> TrialRows::ReadPiece(std::size_t channel, std::uint64_t offset,
                                  std::span<double> values,
                                  std::span<SampleStatus> statuses) const {
  const RowLayout layout = LayoutOf(header_);
  const ChannelFormat& format = header_.channels[channel];
  const RowColumn column{format.encoding,
                         layout.row_bytes,
                         layout.value_offsets[channel],
                         layout.status_offset + channel,
                         format.scale,
                         format.offset};
  const std::size_t rows_at_once = std::max(std::size_t{1}, kPieceBytes / layout.row_bytes);
  // for overwriting: clearing it would cost as much as decoding it
  const std::size_t most_bytes = std::min(rows_at_once, values.size()) * layout.row_bytes;
  const auto bytes = std::make_unique_for_overwrite<std::byte[]>(most_bytes);
  while (!values.empty()) {
    const std::size_t count = std::min(rows_at_once, values.size());
    const std::span<std::byte> piece =
        std::span(bytes.get(), most_bytes).first(count * layout.row_bytes);
    const auto got = source_->ReadAt(offset, piece);
    if (!got) return std::unexpected(got.error());
    if (*got < piece.size()) {
      return Failed(name_, "was cut shorter while it was read", "leave it alone meanwhile");
    }
    column.Decode(piece, values.first(count), statuses.first(count));
    offset += piece.size();
    values = values.subspan(count);
    statuses = statuses.subspan(count);
  }
  return {};
}

}  // namespace haptometer::trial
