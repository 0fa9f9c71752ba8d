#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/mapped.h"
#include "trial/block.h"
#include "trial/export/description.h"
#include "trial/export/export.h"
#include "trial/import/table/csv_header.h"

namespace haptometer::trial {
namespace {

constexpr const char* kOtherFormats = "export it as .npy, .h5 or .csv, which keep what there is";

// the largest deviation of a rate from a whole number that is only stated: 0.1 Hz at 1 kHz, far
// below what a player or an ear resolves
constexpr double kRateTolerance = 1e-4;

// a RIFF chunk; an odd length is padded
void AppendChunk(std::string_view name, std::string_view content, std::string* bytes) {
  *bytes += name;
  AppendLittleEndian(static_cast<std::uint32_t>(content.size()), bytes);
  *bytes += content;
  if (content.size() % 2 == 1) *bytes += '\0';
}

// lengths in a WAV are 32 bits, and the bytes of a row of all tracks 16 bits
Result<void> CheckRoom(const Record& record) {
  if (record.rows == 0 || record.channels.empty()) return CannotAnswer("", "holds no samples");
  constexpr double kLargestBytes = 4.2e9;
  // 8 bytes for a value, 1 for its status
  const double bytes =
      9.0 * static_cast<double>(record.rows) * static_cast<double>(record.channels.size());
  if (bytes > kLargestBytes || record.channels.size() > 0xffff / 9) {
    return CannotAnswer("", "is larger than the 4 GiB that a WAV can hold", kOtherFormats);
  }
  return {};
}

// the rate in Hz of a record of one segment, which a WAV has as a whole number
Result<std::uint32_t> RateOf(const Record& record) {
  if (record.times_are_known) {
    return CannotAnswer("", "has times of its own that lie on no grid, and a WAV has none",
                        kOtherFormats);
  }
  if (record.stretches.size() != 1) {
    return CannotAnswer(
        "",
        fmt::format("has {} gap{}, and a WAV has no place for one", record.stretches.size() - 1,
                    record.stretches.size() == 2 ? "" : "s"),
        kOtherFormats);
  }
  const double rate_hz = record.stretches[0].rate_hz;
  const double whole_hz = std::round(rate_hz);
  const bool is_whole =
      whole_hz >= 1 && whole_hz < 4e9 && std::abs(rate_hz - whole_hz) <= kRateTolerance * whole_hz;
  if (!is_whole) {
    return CannotAnswer(
        "", fmt::format("has {:.8g} rows per second; a WAV needs a whole number of hertz", rate_hz),
        kOtherFormats);
  }
  return static_cast<std::uint32_t>(whole_hz);
}

// a WAV cannot mark a missing value, so one is enough for a refusal
Result<void> CheckMeasured(const Record& record) {
  std::size_t bad = 0;
  for (const Channel& channel : record.channels) {
    for (std::size_t row = 0; row < record.rows; ++row) {
      if (!IsMeasurement(channel.statuses[row]) || !std::isfinite(channel.values[row])) ++bad;
    }
  }
  if (bad == 0) return {};
  return CannotAnswer(
      "",
      fmt::format("holds {} value{} that {} no measurement, and a WAV cannot state that", bad,
                  bad == 1 ? "" : "s", bad == 1 ? "is" : "are"),
      kOtherFormats);
}

// mean of differences from the first value: 1e8 values near 30 mm retain their nanometres
double MeanOf(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value - values.front();
  return values.front() + sum / static_cast<double>(values.size());
}

// The mean, where it gives each value back bit for bit: where they lie within a factor of two of it
// their differences from it are exact (Sterbenz). Else 0, which loses nothing either.
double OffsetOf(const std::vector<double>& values) {
  const double mean = MeanOf(values);
  const bool is_exact = std::ranges::all_of(values, [mean](double value) {
    const double sample = value - mean;
    return std::bit_cast<std::uint64_t>(sample + mean) == std::bit_cast<std::uint64_t>(value);
  });
  return is_exact ? mean : 0;
}

// what restores the values: the offset of each channel, and the rate before it was rounded
std::string Comment(const Record& record, const std::vector<double>& offsets,
                    std::uint32_t rate_hz) {
  std::string comment = "samples in SI units, offset removed:";
  const std::vector<std::string> names = CsvColumnNames(record.channels);
  for (std::size_t c = 0; c < names.size(); ++c) {
    comment += fmt::format(" {} = sample + {};", names[c], offsets[c]);
  }
  const double exact_hz = record.stretches[0].rate_hz;
  comment += fmt::format(" rate {} Hz", exact_hz);
  if (exact_hz != rate_hz) comment += fmt::format(", written as {} Hz", rate_hz);
  if (HasArrivalTimes(record)) comment += "; without times of arrival";
  return comment;
}

// the chunks that only this program reads, as a list that others pass over
std::string OwnChunks(const Record& record, const std::string& description) {
  std::string chunks = "hapt";
  AppendChunk("desc", description, &chunks);
  const bool are_ok = std::ranges::all_of(record.channels, [](const Channel& channel) {
    return std::ranges::all_of(channel.statuses, [](auto s) { return s == SampleStatus::kOk; });
  });
  if (are_ok) return chunks;
  // a byte for each value, in the order of the samples
  std::string statuses;
  statuses.reserve(record.rows * record.channels.size());
  for (std::size_t row = 0; row < record.rows; ++row) {
    for (const Channel& channel : record.channels) {
      statuses += static_cast<char>(channel.statuses[row]);
    }
  }
  AppendChunk("stat", statuses, &chunks);
  return chunks;
}

// the chunk fmt: how samples are stored
std::string FormatChunk(std::size_t channels, std::uint32_t rate_hz) {
  std::string format;
  constexpr std::uint16_t kIeeeFloat = 3;
  constexpr std::uint16_t kSampleBytes = 8;
  AppendLittleEndian(kIeeeFloat, &format);
  AppendLittleEndian(static_cast<std::uint16_t>(channels), &format);
  AppendLittleEndian(rate_hz, &format);
  // bytes per second, for players; limited to 32 bits
  AppendLittleEndian(static_cast<std::uint32_t>(std::min<std::uint64_t>(
                         std::uint64_t{rate_hz} * kSampleBytes * channels, UINT32_MAX)),
                     &format);
  // bytes of a row, bits of a sample
  AppendLittleEndian(static_cast<std::uint16_t>(kSampleBytes * channels), &format);
  AppendLittleEndian(static_cast<std::uint16_t>(8 * kSampleBytes), &format);
  AppendLittleEndian(std::uint16_t{0}, &format);  // no extension
  return format;
}

// chunks fmt, fact, LIST INFO, LIST hapt and the beginning of data, in the order of the file
std::string Head(const Record& record, std::uint32_t rate_hz, const std::string& comment,
                 const std::string& description) {
  const std::size_t channels = record.channels.size();
  const auto data_bytes = static_cast<std::uint32_t>(8 * record.rows * channels);
  std::string fact;
  // fact: the number of rows, required for formats other than PCM
  AppendLittleEndian(static_cast<std::uint32_t>(record.rows), &fact);
  std::string info = "INFO";
  AppendChunk("ICMT", comment + '\0', &info);

  std::string chunks = "WAVE";
  AppendChunk("fmt ", FormatChunk(channels, rate_hz), &chunks);
  AppendChunk("fact", fact, &chunks);
  AppendChunk("LIST", info, &chunks);
  AppendChunk("LIST", OwnChunks(record, description), &chunks);
  chunks += "data";
  AppendLittleEndian(data_bytes, &chunks);
  std::string head = "RIFF";
  // length of the file behind this field
  AppendLittleEndian(static_cast<std::uint32_t>(chunks.size() + data_bytes), &head);
  return head + chunks;
}

}  // namespace

Result<std::string> WriteWav(const Recording& recording, const PieceSink& sink,
                             const FindingSayer& say) {
  const Record& record = recording.record;
  HAPTOMETER_TRY(CheckRoom(record));
  HAPTOMETER_LET(const auto rate_hz, RateOf(record));
  HAPTOMETER_TRY(CheckMeasured(record));
  // what is subtracted from each channel; the comment gives it in full
  const auto offsets = Mapped<double>(
      record.channels, [](const Channel& channel) { return OffsetOf(channel.values); });
  std::string comment = Comment(record, offsets, rate_hz);
  const auto append = [&](std::size_t row, std::string* bytes) {
    for (std::size_t c = 0; c < offsets.size(); ++c) {
      AppendLittleEndian(record.channels[c].values[row] - offsets[c], bytes);
    }
  };
  std::string head = Head(record, rate_hz, comment, DescriptionOf(recording, say, offsets));
  HAPTOMETER_TRY(WriteInPieces(std::move(head), record.rows, append, sink));
  return comment;
}

}  // namespace haptometer::trial
