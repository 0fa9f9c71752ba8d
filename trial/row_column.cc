#include "trial/row_column.h"

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "base/error.h"
#include "trial/block.h"

namespace haptometer::trial {
namespace {

static_assert(static_cast<int>(SampleStatus::kOk) == 0);

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

// the same where every status is kOk, as nearly always, without a branch for each row; whether it
// was so
template <typename Raw>
bool DecodeOk(const std::byte* row, const RowColumn& column, std::span<double> values) {
  std::byte seen{};
  for (double& value : values) {
    seen |= row[column.status_at];
    const auto raw = static_cast<double>(LoadLittleEndian<Raw>(row + column.value_at));
    value = raw * column.scale + column.offset;
    row += column.row_bytes;
  }
  return seen == std::byte{};
}

constexpr std::size_t kLoadBytes = 16;
constexpr std::size_t kRowsAtOnce = 8;  // two in each load

// of two loads side by side: the bytes that become the values of rows 0, 1, 4, 5 or 2, 3, 6, 7 in
// their places, and those that hold a status
struct Shuffles {
  alignas(32) std::array<std::uint8_t, 2 * kLoadBytes> outer{};
  alignas(32) std::array<std::uint8_t, 2 * kLoadBytes> inner{};
  alignas(32) std::array<std::uint8_t, 2 * kLoadBytes> status{};

  explicit Shuffles(const RowColumn& column) {
    constexpr std::uint8_t kZero = 0x80;
    outer.fill(kZero);
    inner.fill(kZero);
    for (std::size_t row = 0; row < 2; ++row) {
      for (const std::size_t load : {std::size_t{0}, kLoadBytes}) {
        const std::size_t begin = row * column.row_bytes;
        for (std::size_t k = 0; k < 4; ++k) {
          const auto from = static_cast<std::uint8_t>(begin + column.value_at + k);
          outer[load + 4 * row + k] = from;
          inner[load + 8 + 4 * row + k] = from;
        }
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
  while (values.size() >= kRowsAtOnce && end - at >= static_cast<std::ptrdiff_t>(3 * two + 16)) {
    const __m256i first = LoadPair(at, at + 2 * two);
    const __m256i second = LoadPair(at + two, at + 3 * two);
    seen = _mm256_or_si256(seen, _mm256_or_si256(first, second));
    const __m256i raw =
        _mm256_or_si256(_mm256_shuffle_epi8(first, outer), _mm256_shuffle_epi8(second, inner));
    const __m256d low = FourDoubles<Raw>(_mm256_castsi256_si128(raw));
    const __m256d high = FourDoubles<Raw>(_mm256_extracti128_si256(raw, 1));
    _mm256_storeu_pd(values.data(), _mm256_add_pd(_mm256_mul_pd(low, scale), offset));
    _mm256_storeu_pd(values.data() + 4, _mm256_add_pd(_mm256_mul_pd(high, scale), offset));
    values = values.subspan(kRowsAtOnce);
    at += 4 * two;
  }
  return _mm256_testz_si256(seen, LoadBytes(shuffles.status)) != 0;
}

template <typename Raw>
void DecodeAll(std::span<const std::byte> rows, const RowColumn& column, std::span<double> values,
               std::span<SampleStatus> statuses) {
  std::span<double> rest = values;
  bool ok = true;
  if constexpr (sizeof(Raw) == 4) {
    if (2 * column.row_bytes <= kLoadBytes && __builtin_cpu_supports("avx2") != 0) {
      ok = DecodeEights<Raw>(rows, column, rest);
    }
  }
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
