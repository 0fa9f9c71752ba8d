#include "trial/trial_rows.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "base/instruction_set.h"
#include "trial/block.h"
#include "trial/record.h"
#include "trial/time_base.h"
#include "trial/trial_format.h"

#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace haptometer::trial {

/// One channel in packed rows: where its value and its status lie in a row, and what they mean.
///
///   value = raw scale + offset
struct RowColumn {
  Encoding encoding = Encoding::kI32;
  std::size_t row_bytes = 0;
  std::size_t value_at = 0;
  std::size_t status_at = 0;
  double scale = 1;
  double offset = 0;

  /// Values (NaN where there is no measurement) and statuses of the first rows at `rows`, as many
  /// as either span has. A status of a later version is kInvalid. Rows of up to eight bytes are
  /// decoded eight at a time where the processor has AVX2, to the same values.
  void Decode(std::span<const std::byte> rows, std::span<double> values,
              std::span<SampleStatus> statuses) const;
};

namespace {

// bytes that are decoded at once, so that they remain in the processor's cache
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
  // all payloads are checked once; the rows are not retained, only where each block is
  HAPTOMETER_TRY(reader.CheckRows(threads));
  UniformGrid grid(reader.header().rate_hz);
  for (;;) {
    HAPTOMETER_LET(const auto chunk, reader.Next());
    if (chunk == nullptr) break;
    rows->blocks_.push_back({rows->head_.rows, chunk->offset()});
    grid.Append(chunk->first_index(), chunk->rows());
    rows->head_.rows += chunk->rows();
  }
  // the report is complete behind the last block
  rows->report_ = reader.report();
  rows->head_.stretches = StoredTimeBase(rows->report_).value_or(grid.stretches());
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
  // the block behind the one that holds row `first`
  auto block = std::ranges::upper_bound(blocks_, first, {}, &Rows::first);
  while (!values.empty()) {
    const Rows& rows = *(block - 1);
    // rows of this block from `first` on; the next block continues
    const std::size_t end = block == blocks_.end() ? head_.rows : block->first;
    const std::size_t count = std::min(values.size(), end - first);
    const std::uint64_t offset = rows.offset + (first - rows.first) * row_bytes;
    HAPTOMETER_TRY(ReadPiece(channel, offset, values.first(count), statuses.first(count)));
    first += count;
    values = values.subspan(count);
    statuses = statuses.subspan(count);
    ++block;
  }
  return {};
}

// rows of one block are contiguous, so a piece is one range of bytes
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
  // without initialisation, which would take as long as the decoding
  const std::size_t most_bytes = std::min(rows_at_once, values.size()) * layout.row_bytes;
  const auto bytes = std::make_unique_for_overwrite<std::byte[]>(most_bytes);
  while (!values.empty()) {
    const std::size_t count = std::min(rows_at_once, values.size());
    const std::span<std::byte> piece =
        std::span(bytes.get(), most_bytes).first(count * layout.row_bytes);
    HAPTOMETER_LET(const auto got, source_->ReadAt(offset, piece));
    // checked when the file was opened, so it is shorter now
    if (got < piece.size()) {
      return Failed(name_, "was cut shorter while it was read", "leave it alone meanwhile");
    }
    column.Decode(piece, values.first(count), statuses.first(count));
    offset += piece.size();
    values = values.subspan(count);
    statuses = statuses.subspan(count);
  }
  return {};
}

namespace {

// DecodeOk tests statuses by OR, which requires kOk to be 0
static_assert(static_cast<int>(SampleStatus::kOk) == 0);

// row by row, with any statuses; values in SI units, NaN where the status is no measurement
template <typename Raw>
void DecodeCarefully(const std::byte* row, const RowColumn& column, std::span<double> values,
                     std::span<SampleStatus> statuses) {
  for (std::size_t k = 0; k < values.size(); ++k, row += column.row_bytes) {
    const auto byte = std::to_integer<std::uint8_t>(row[column.status_at]);
    // a status of a later version is no measurement that this one can vouch for
    const auto status =
        byte < kSampleStatusCount ? static_cast<SampleStatus>(byte) : SampleStatus::kInvalid;
    const auto raw = static_cast<double>(LoadLittleEndian<Raw>(row + column.value_at));
    const double value = raw * column.scale + column.offset;
    values[k] = IsMeasurement(status) ? value : std::numeric_limits<double>::quiet_NaN();
    statuses[k] = status;
  }
}

// the same where every status is kOk, as almost always, without a branch for each row; returns
// whether this was so
template <typename Raw>
bool DecodeOk(const std::byte* row, const RowColumn& column, std::span<double> values) {
  // OR of all status bytes
  std::byte seen{};
  for (double& value : values) {
    seen |= row[column.status_at];
    const auto raw = static_cast<double>(LoadLittleEndian<Raw>(row + column.value_at));
    value = raw * column.scale + column.offset;
    row += column.row_bytes;
  }
  return seen == std::byte{};
}

#ifdef __x86_64__
// bytes of one load; eight rows are four loads of two rows each
constexpr std::size_t kLoadBytes = 16;
constexpr std::size_t kRowsAtOnce = 8;  // two in each load

// For two loads side by side: the bytes that become the values of rows 0, 1, 4, 5 or 2, 3, 6, 7 in
// their places, and those that hold a status.
struct Shuffles {
  alignas(32) std::array<std::uint8_t, 2 * kLoadBytes> outer{};
  alignas(32) std::array<std::uint8_t, 2 * kLoadBytes> inner{};
  alignas(32) std::array<std::uint8_t, 2 * kLoadBytes> status{};

  explicit Shuffles(const RowColumn& column) {
    // an index with the highest bit set gives a zero byte
    constexpr std::uint8_t kZero = 0x80;
    outer.fill(kZero);
    inner.fill(kZero);
    for (std::size_t row = 0; row < 2; ++row) {
      for (const std::size_t load : {std::size_t{0}, kLoadBytes}) {
        const std::size_t begin = row * column.row_bytes;
        // four bytes of the raw value, to their place in the lower or upper half of the load
        for (std::size_t k = 0; k < 4; ++k) {
          const auto from = static_cast<std::uint8_t>(begin + column.value_at + k);
          outer[load + 4 * row + k] = from;
          inner[load + 8 + 4 * row + k] = from;
        }
        // mask of the status byte
        status[load + begin + column.status_at] = 0xff;
      }
    }
  }
};

[[gnu::target("avx2")]] inline __m256i LoadBytes(
    const std::array<std::uint8_t, 2 * kLoadBytes>& bytes) {
  return _mm256_load_si256(reinterpret_cast<const __m256i*>(bytes.data()));
}

[[gnu::target("avx2")]] inline __m256i LoadPair(const std::byte* low, const std::byte* high) {
  return _mm256_inserti128_si256(
      _mm256_castsi128_si256(_mm_loadu_si128(reinterpret_cast<const __m128i*>(low))),
      _mm_loadu_si128(reinterpret_cast<const __m128i*>(high)), 1);
}

// four raw values as doubles, which is exact for i32 and f32
template <typename Raw>
[[gnu::target("avx2")]] inline __m256d FourDoubles(__m128i raw) {
  if constexpr (std::is_same_v<Raw, float>) {
    return _mm256_cvtps_pd(_mm_castsi128_ps(raw));
  } else {
    return _mm256_cvtepi32_pd(raw);
  }
}

// DecodeOk of whole eights of short rows; no byte behind `rows` is read
template <typename Raw>
[[gnu::target("avx2")]] bool DecodeEights(std::span<const std::byte> rows, const RowColumn& column,
                                          std::span<double>& values) {
  const Shuffles shuffles(column);
  const __m256i outer = LoadBytes(shuffles.outer);
  const __m256i inner = LoadBytes(shuffles.inner);
  const __m256d scale = _mm256_set1_pd(column.scale);
  const __m256d offset = _mm256_set1_pd(column.offset);
  __m256i seen = _mm256_setzero_si256();
  const std::size_t two = 2 * column.row_bytes;
  const std::byte* at = rows.data();
  const std::byte* const end = at + rows.size();
  // the last load begins at row 6 of the eight and is 16 bytes long
  while (values.size() >= kRowsAtOnce && end - at >= static_cast<std::ptrdiff_t>(3 * two + 16)) {
    const __m256i first = LoadPair(at, at + 2 * two);
    const __m256i second = LoadPair(at + two, at + 3 * two);
    // all bytes are collected; the mask selects the statuses at the end
    seen = _mm256_or_si256(seen, _mm256_or_si256(first, second));
    // eight raw values in the order of the rows
    const __m256i raw =
        _mm256_or_si256(_mm256_shuffle_epi8(first, outer), _mm256_shuffle_epi8(second, inner));
    const __m256d low = FourDoubles<Raw>(_mm256_castsi256_si128(raw));
    const __m256d high = FourDoubles<Raw>(_mm256_extracti128_si256(raw, 1));
    // value = raw * scale + offset, multiplied and added separately as in DecodeOk
    _mm256_storeu_pd(values.data(), _mm256_add_pd(_mm256_mul_pd(low, scale), offset));
    _mm256_storeu_pd(values.data() + 4, _mm256_add_pd(_mm256_mul_pd(high, scale), offset));
    values = values.subspan(kRowsAtOnce);
    at += 4 * two;
  }
  return _mm256_testz_si256(seen, LoadBytes(shuffles.status)) != 0;
}
#endif

// eights, then single rows; all rows again with care where a status is not kOk
template <typename Raw>
void DecodeAll(std::span<const std::byte> rows, const RowColumn& column, std::span<double> values,
               std::span<SampleStatus> statuses) {
  std::span<double> rest = values;
  bool ok = true;
#ifdef __x86_64__
  if constexpr (sizeof(Raw) == 4) {
    // two rows fit in a load of 16 bytes
    if (2 * column.row_bytes <= kLoadBytes && UsableInstructionSet() >= InstructionSet::kAvx2) {
      ok = DecodeEights<Raw>(rows, column, rest);
    }
  }
#endif
  const std::size_t done = values.size() - rest.size();
  ok = ok && DecodeOk<Raw>(rows.data() + done * column.row_bytes, column, rest);
  if (!ok) return DecodeCarefully<Raw>(rows.data(), column, values, statuses);
  std::ranges::fill(statuses, SampleStatus::kOk);
}

}  // namespace

void RowColumn::Decode(std::span<const std::byte> rows, std::span<double> values,
                       std::span<SampleStatus> statuses) const {
  HAPTOMETER_CHECK(values.size() == statuses.size() && rows.size() == values.size() * row_bytes,
                   "{} bytes for {} values and {} statuses", rows.size(), values.size(),
                   statuses.size());
  switch (encoding) {
    case Encoding::kI32:
      return DecodeAll<std::int32_t>(rows, *this, values, statuses);
    case Encoding::kF32:
      return DecodeAll<float>(rows, *this, values, statuses);
    case Encoding::kF64:
      return DecodeAll<double>(rows, *this, values, statuses);
  }
}

}  // namespace haptometer::trial
