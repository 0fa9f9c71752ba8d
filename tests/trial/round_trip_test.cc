// Properties of random recordings: what is written is what is read, as trial.bin and as CSV.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>

#include "tests/trial/trial_file.h"
#include "trial/export/export.h"
#include "trial/import/readers.h"
#include "trial/trial_format.h"

namespace haptometer::trial {
namespace {

rc::Gen<double> AnyFinite() {
  return rc::gen::map(rc::gen::arbitrary<std::uint64_t>(), [](std::uint64_t bits) {
    const double value = std::bit_cast<double>(bits);
    return std::isfinite(value) ? value : 1.0;
  });
}

rc::Gen<std::string> Words() {
  return rc::gen::map(rc::gen::string<std::string>(), [](std::string text) {
    for (char& c : text) {
      if (static_cast<unsigned char>(c) < 0x21 || static_cast<unsigned char>(c) > 0x7e) c = '_';
    }
    return text;
  });
}

SampleStatus AnyStatus() {
  return static_cast<SampleStatus>(*rc::gen::inRange<int>(0, kSampleStatusCount));
}

ChannelFormat AnyChannel() {
  ChannelFormat channel;
  channel.name = *Words();
  channel.role = static_cast<ChannelRole>(*rc::gen::inRange(0, 5));
  channel.unit = *Words();
  channel.encoding = static_cast<Encoding>(*rc::gen::inRange(0, 3));
  channel.scale = *AnyFinite();
  channel.offset = *AnyFinite();
  channel.resolution = std::abs(*AnyFinite());
  if (*rc::gen::arbitrary<bool>()) channel.range_max = *AnyFinite();
  return channel;
}

TrialHeader AnyHeader() {
  TrialHeader header;
  header.timing = static_cast<Timing>(*rc::gen::inRange(0, 3));
  header.rate_hz = header.timing == Timing::kUniform ? *rc::gen::inRange(1, 100'000) : 0;
  const int channels = *rc::gen::inRange(1, 5);
  for (int c = 0; c < channels; ++c) header.channels.push_back(AnyChannel());
  header.metadata.source = *Words();
  header.metadata.labels =
      *rc::gen::container<std::map<std::string, std::string>>(Words(), Words());
  header.metadata.notes = *rc::gen::container<std::vector<std::string>>(Words());
  if (*rc::gen::arbitrary<bool>()) header.metadata.sampling_s = *AnyFinite();
  return header;
}

// one row with its samples kept alive
struct AnyRow {
  Row row;
  std::vector<Sample> samples{};
};

std::vector<AnyRow> AnyRows(const TrialHeader& header) {
  std::vector<AnyRow> rows(*rc::gen::inRange<std::size_t>(0, 60));
  std::int64_t index = 0;
  for (AnyRow& any : rows) {
    index += *rc::gen::weightedElement<int>({{8, 1}, {1, 2}, {1, 1000}});
    any.row.index = index;
    any.row.time_ns = *rc::gen::arbitrary<std::int64_t>();
    any.row.reply_ns = *rc::gen::arbitrary<std::int64_t>();
    for (const ChannelFormat& channel : header.channels) {
      const auto bits = *rc::gen::arbitrary<std::uint64_t>();
      const bool is_wide = channel.encoding == Encoding::kF64;
      any.samples.push_back({RawValue::Bits(is_wide ? bits : bits & 0xffffffff), AnyStatus()});
    }
  }
  return rows;
}

// checks one chunk's rows against what was written
void ExpectRows(const Chunk& chunk, const TrialHeader& header, const std::vector<AnyRow>& rows) {
  for (std::size_t i = 0; i < chunk.rows(); ++i) {
    const AnyRow& any = rows.at(chunk.first_row() + i);
    if (header.timing == Timing::kUniform) {
      RC_ASSERT(chunk.first_index() + static_cast<std::int64_t>(i) == any.row.index);
    } else {
      RC_ASSERT(chunk.TimeNs(i) == any.row.time_ns);
    }
    if (header.timing == Timing::kPolled) RC_ASSERT(chunk.ReplyNs(i) == any.row.reply_ns);
    for (std::size_t c = 0; c < header.channels.size(); ++c) {
      RC_ASSERT(chunk.At(i, c).raw.bits() == any.samples[c].raw.bits());
      RC_ASSERT(chunk.At(i, c).status == any.samples[c].status);
    }
  }
}

TEST(RoundTrip, AnyTrialComesBackBitForBit) {
  const bool holds = rc::check("trial", [] {
    const TrialHeader header = AnyHeader();
    const std::vector<AnyRow> rows = AnyRows(header);
    MemoryDisk disk;
    disk.most_at_once = *rc::gen::inRange<std::size_t>(1, 5000);
    ManualClock clock;
    auto writer = WriterInto(&disk, header, clock);
    for (const AnyRow& any : rows) {
      Row row = any.row;
      row.samples = any.samples;
      RC_ASSERT(writer.Append(row).has_value());
      if (*rc::gen::inRange(0, 10) == 0) RC_ASSERT(writer.Flush().has_value());
    }
    RC_ASSERT(writer.Finish().has_value());
    auto reader = TrialReader::OpenFrom(MakeMemorySource(disk.bytes), "t.bin");
    RC_ASSERT(reader.has_value());
    RC_ASSERT(HeaderToJson(reader->header()) == HeaderToJson(header));
    std::size_t seen = 0;
    for (;;) {
      const auto chunk = reader->Next();
      RC_ASSERT(chunk.has_value());
      if (*chunk == nullptr) break;
      RC_ASSERT((*chunk)->first_row() == seen);
      ExpectRows(**chunk, header, rows);
      seen += (*chunk)->rows();
    }
    RC_ASSERT(seen == rows.size());
    RC_ASSERT(reader->report().closed && reader->report().losses.empty());
    // the record in memory keeps its promises whatever the times were
    const auto read = ReadBytes(disk.bytes);
    RC_ASSERT(read.has_value());
    std::size_t covered = 0;
    for (const Stretch& stretch : read->record.stretches) {
      RC_ASSERT(stretch.first_row == covered && stretch.rows > 0 && stretch.rate_hz > 0);
      covered += stretch.rows;
    }
    RC_ASSERT(covered == rows.size());
  });
  EXPECT_TRUE(holds);
}

Record AnyRecord() {
  Record record;
  record.rows = *rc::gen::inRange<std::size_t>(2, 40);
  const bool is_grid = *rc::gen::arbitrary<bool>();
  double time_s = *rc::gen::inRange(-5, 5);
  for (std::size_t row = 0; row < record.rows && !is_grid; ++row) {
    time_s += 1e-3 * *rc::gen::inRange(1, 100);
    record.raw_times_s.push_back(time_s);
  }
  const double start_s = is_grid ? time_s : record.raw_times_s.front();
  record.stretches = {{.first_row = 0,
                       .rows = record.rows,
                       .start_s = start_s,
                       .rate_hz = is_grid ? *rc::gen::inRange(1, 99'999) / 7.0 : 1000.0,
                       .time_uncertainty_s = is_grid ? 0 : 1e-3}};
  if (!is_grid) record.stretches[0].rate_hz = 1 / 0.05;
  const int channels = *rc::gen::inRange(1, 4);
  for (int c = 0; c < channels; ++c) {
    Channel channel;
    channel.role = static_cast<ChannelRole>(*rc::gen::inRange(0, 5));
    channel.name = "c" + *Words();
    constexpr std::array<const char*, 5> kUnits{"m", "V", "A", "", "N"};
    channel.unit = kUnits[static_cast<std::size_t>(channel.role)];
    for (std::size_t row = 0; row < record.rows; ++row) {
      channel.statuses.push_back(*rc::gen::arbitrary<bool>() ? SampleStatus::kOk : AnyStatus());
      channel.values.push_back(IsMeasurement(channel.statuses.back())
                                   ? *AnyFinite()
                                   : std::numeric_limits<double>::quiet_NaN());
    }
    record.channels.push_back(std::move(channel));
  }
  record.metadata.source = "s" + *Words();
  record.metadata.drive_frequency_hz = *AnyFinite();
  record.metadata.fields = {{"load_ohm", "inf"}};
  return record;
}

TEST(RoundTrip, AnyRecordComesBackFromCsv) {
  const bool holds = rc::check("csv", [] {
    const Record record = AnyRecord();
    std::string text;
    RC_ASSERT(WriteCsv(record, [&](std::string_view piece) -> Result<void> {
                text += piece;
                return {};
              }).has_value());
    const auto back = ParseCsv(text, "f.csv");
    RC_ASSERT(back.has_value());
    RC_ASSERT(back->rows == record.rows);
    RC_ASSERT(back->metadata.source == record.metadata.source);
    RC_ASSERT(back->metadata.fields == record.metadata.fields);
    RC_ASSERT(back->metadata.drive_frequency_hz == record.metadata.drive_frequency_hz);
    RC_ASSERT(back->raw_times_s.empty() || back->raw_times_s == record.raw_times_s);
    for (std::size_t c = 0; c < record.channels.size(); ++c) {
      RC_ASSERT(back->channels[c].name == record.channels[c].name);
      RC_ASSERT(back->channels[c].role == record.channels[c].role);
      RC_ASSERT(back->channels[c].unit == record.channels[c].unit);
      RC_ASSERT(back->channels[c].statuses == record.channels[c].statuses);
      for (std::size_t row = 0; row < record.rows; ++row) {
        RC_ASSERT(std::bit_cast<std::uint64_t>(back->channels[c].values[row]) ==
                  std::bit_cast<std::uint64_t>(record.channels[c].values[row]));
      }
    }
    // the grid itself comes back exactly
    if (record.raw_times_s.empty()) {
      for (std::size_t row = 0; row < record.rows; ++row) {
        RC_ASSERT(TimeOf(*back, row) == TimeOf(record, row));
      }
    }
  });
  EXPECT_TRUE(holds);
}

TEST(RoundTrip, AnyByteReplacedIsFoundOrHarmless) {
  const std::string whole = CountingTrial(300, 30);
  const bool holds = rc::check("damage", [&] {
    std::string bytes = whole;
    // a burst of random bytes at a random place, or a piece cut out
    const auto at = *rc::gen::inRange<std::size_t>(0, bytes.size());
    const auto length = *rc::gen::inRange<std::size_t>(1, 200);
    if (*rc::gen::arbitrary<bool>()) {
      bytes.erase(at, length);
    } else {
      for (std::size_t i = at; i < std::min(bytes.size(), at + length); ++i) {
        bytes[i] = *rc::gen::arbitrary<char>();
      }
    }
    const auto read = ReadBytes(bytes);
    if (!read) return;
    for (std::size_t row = 0; row < read->record.rows; ++row) {
      const double place = std::round(TimeOf(read->record, row) * 1000);
      RC_ASSERT(read->record.channels[0].values[row] == place * 1e-6 + 0.25);
    }
    RC_ASSERT(bytes == whole || !read->report.losses.empty() || !read->report.closed);
    if (const auto lost = read->report.RowsLost(); lost && read->report.closed) {
      RC_ASSERT(read->record.rows + *lost == 300);
    }
  });
  EXPECT_TRUE(holds);
}

}  // namespace
}  // namespace haptometer::trial
