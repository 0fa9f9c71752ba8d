// Exports as HDF5, MAT, NPY and WAV, read back: the recording itself is the oracle, bit by bit. And
// the bytes of those that are written without a library, against their formats.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "tests/findings.h"
#include "tests/trial/recordings.h"
#include "tests/trial/trial_file.h"
#include "trial/block.h"
#include "trial/export/description.h"
#include "trial/export/export.h"
#include "trial/import/read_recording.h"
#include "trial/import/readers.h"
#include "trial/trial_format.h"

namespace haptometer::trial {
namespace {

using ::testing::HasSubstr;

std::string Say(const Finding& found) { return tests::NumbersOf(found); }

// the export that writes pieces of bytes
Result<void> WriteStream(const std::string& path, const Recording& recording) {
  std::ofstream file(path, std::ios::binary);
  const auto sink = [&](std::string_view bytes) -> Result<void> {
    file << bytes;
    return {};
  };
  if (path.ends_with(".npy")) return WriteNpy(recording, sink, Say);
  HAPTOMETER_TRY(WriteWav(recording, sink, Say));
  return {};
}

// the exports that are made by a library
Result<void> Export(const std::string& path, const Recording& recording) {
  if (path.ends_with(".h5")) {
    HAPTOMETER_LET(auto writer, Hdf5Writer::Create(path));
    HAPTOMETER_TRY(writer.Add("t", recording, nullptr, Say));
    return writer.Close();
  }
  if (!path.ends_with(".mat")) return WriteStream(path, recording);
  HAPTOMETER_LET(auto writer, MatWriter::Create(path));
  HAPTOMETER_TRY(writer.Add("t", recording, Say));
  return writer.Close();
}

// 2000 rows at 8 kHz of two channels: a distance of 30 mm and a voltage about 0
Recording TwoChannels() {
  Recording recording;
  Record& record = recording.record;
  record.rows = 2000;
  record.stretches = {{.rows = 2000, .start_s = 0.25, .rate_hz = 8000}};
  record.channels = {{.name = "OUT1", .role = ChannelRole::kDisplacement, .unit = "m"},
                     {.name = "coil", .role = ChannelRole::kVoltage, .unit = "V"}};
  record.channels[0].range_max = 0.035;
  record.channels[0].resolution = 1e-7;
  for (std::size_t n = 0; n < record.rows; ++n) {
    const double phase = 2 * std::numbers::pi * 225 * static_cast<double>(n) / 8000;
    record.channels[0].values.push_back(0.03 + 1e-4 * std::sin(phase));
    record.channels[1].values.push_back(std::cos(phase) / 3);
    // a status beside ok that is a measurement, of one channel
    record.channels[0].statuses.push_back(n % 3 == 1 ? SampleStatus::kRepeated : SampleStatus::kOk);
    record.channels[1].statuses.push_back(SampleStatus::kOk);
  }
  Metadata& metadata = record.metadata;
  metadata.source = "simulated";
  metadata.averages = 16;
  metadata.sampling_s = 1e-4;
  metadata.drive_frequency_hz = 225;
  metadata.fields = {{"calibration.OUT1.relative_standard_uncertainty", "0.005"}};
  metadata.labels = {{"subject", "\xc3\xa4"}};
  recording.report.closed = true;
  recording.report.events = {
      {.kind = EventKind::kRemark, .row = 2000, .text = "interrupted: \xe2\x88\x9e"}};
  return recording;
}

// lines that arrived in bursts, with a gap where lines were lost
Recording Arrived() {
  MemoryDisk disk;
  ManualClock clock;
  auto writer = WriterInto(&disk, CountsHeader(Timing::kArrival), clock);
  for (int i = 0; i < 3000; ++i) {
    const int n = i < 1500 ? i : i + 700;
    // sent each millisecond, delivered each 16 ms
    const std::int64_t time_ns = (n / 16 + 1) * std::int64_t{16'000'000};
    EXPECT_TRUE(AppendCounts(&writer, n * 37 % 1001, {.time_ns = time_ns}));
  }
  EXPECT_TRUE(writer.Finish());
  auto read = ReadBytes(disk.bytes);
  EXPECT_TRUE(read);
  return std::move(*read);
}

// a recording with times of its own, on no grid
Recording Known() {
  auto record = ParseCsv("time_s,displacement_m\n0,1\n0.25,2\n0.6,3\n0.7,4\n", "f.csv");
  EXPECT_TRUE(record && record->times_are_known);
  Recording recording{.record = *std::move(record), .report = {}};
  recording.report.closed = true;
  return recording;
}

void ExpectRoundTrip(const std::string& path, const Recording& recording) {
  const auto done = Export(path, recording);
  ASSERT_TRUE(done) << done.error().Text();
  const auto back = ReadRecording(path);
  ASSERT_TRUE(back) << back.error().Text();
  ExpectSame(back->record, recording.record);
  EXPECT_EQ(back->record.timing, recording.record.timing);
  EXPECT_EQ(back->record.times_are_known, recording.record.times_are_known);
  EXPECT_TRUE(back->report.is_export);
  EXPECT_EQ(back->report.closed, recording.report.closed);
  EXPECT_EQ(back->report.rows, recording.record.rows);
  ASSERT_EQ(back->report.events.size(), recording.report.events.size());
  for (std::size_t i = 0; i < back->report.events.size(); ++i) {
    EXPECT_EQ(EventToJson(back->report.events[i]), EventToJson(recording.report.events[i]));
  }
  // losses become remarks, one each
  EXPECT_EQ(back->report.findings.list().size(), recording.report.losses.size());
  EXPECT_FALSE(IsTable(path));
}

class Exports : public ::testing::TestWithParam<const char*> {};

TEST_P(Exports, HoldTheLabelsAsRecordedToo) {
  const ScratchDirectory directory;
  const std::string path = directory.File(std::string("t") + GetParam());
  Recording changed = TwoChannels();
  changed.report.first_labels = {{"subject", "1"}};
  changed.report.events = {{.kind = EventKind::kLabels, .labels = {{"subject", "\xc3\xa4"}}}};
  ASSERT_TRUE(Export(path, changed));
  const auto back = ReadRecording(path);
  ASSERT_TRUE(back) << back.error().Text();
  EXPECT_EQ(back->record.metadata.labels, changed.record.metadata.labels);
  ASSERT_EQ(back->report.events.size(), 2U);
  EXPECT_EQ(back->report.events[0].labels, changed.report.first_labels);
  EXPECT_EQ(back->report.events[0].text, "as recorded");
  EXPECT_EQ(back->report.events[1].labels, changed.report.events[0].labels);
  // where there were none at first, there is nothing to add
  changed.report.first_labels.clear();
  ASSERT_TRUE(Export(path, changed));
  EXPECT_EQ(ReadRecording(path)->report.events.size(), 1U);
}

TEST(ExportsByALibrary, IntoNoFolderAreRefused) {
  const ScratchDirectory directory;
  for (const char* name : {"none/t.h5", "none/t.mat"}) {
    const auto refused = Export(directory.File(name), TwoChannels());
    ASSERT_FALSE(refused) << name;
    EXPECT_EQ(refused.error().cause, Cause::kFailed);
    EXPECT_EQ(refused.error().remedy, "is there room, and may you write there?");
  }
}

TEST_P(Exports, AreReadBackBitForBit) {
  const ScratchDirectory directory;
  const std::string path = directory.File(std::string("t") + GetParam());
  ExpectRoundTrip(path, TwoChannels());
  Recording unfinished = TwoChannels();
  unfinished.report.closed = false;
  ExpectRoundTrip(path, unfinished);
}

// a WAV has no place for these
TEST_P(Exports, OfGapsAndTimesOffTheGridAreReadBackOrRefused) {
  const ScratchDirectory directory;
  const std::string path = directory.File(std::string("t") + GetParam());
  const Recording arrived = Arrived();
  ASSERT_EQ(arrived.record.stretches.size(), 2);
  for (const Recording& recording : {arrived, Polled(), Known()}) {
    if (std::string(GetParam()) != ".wav") {
      ExpectRoundTrip(path, recording);
      continue;
    }
    const auto done = Export(path, recording);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().cause, Cause::kCannotAnswer);
  }
}

TEST_P(Exports, OfAnotherSizeThanTheyStateAreRefusedOrHarmless) {
  const ScratchDirectory directory;
  const std::string path = directory.File(std::string("t") + GetParam());
  ASSERT_TRUE(Export(path, TwoChannels()));
  std::ifstream file(path, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(file), {}};
  const std::size_t step = whole.size() / 37;
  for (std::size_t cut = 200; cut + 1 < whole.size(); cut += step) {
    std::ofstream(path, std::ios::binary) << whole.substr(0, cut);
    const auto read = ReadRecording(path);
    // never a part of the trial as if it were the whole
    EXPECT_FALSE(read && read->report.is_export) << cut;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Exports, ::testing::Values(".h5", ".mat", ".npy", ".wav"));

TEST(WavExport, OfAStreamKeepsAllButTheTimesOfArrival) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.wav");
  Recording stream = TwoChannels();
  stream.record.timing = Timing::kArrival;
  stream.record.stretches[0].rate_hz = 8000.2;
  stream.record.stretches[0].time_uncertainty_s = 2e-5;
  for (std::size_t row = 0; row < stream.record.rows; ++row) {
    stream.record.raw_times_s.push_back(TimeOf(stream.record, row) + 1e-4);
  }
  ASSERT_TRUE(Export(path, stream));
  const auto back = ReadRecording(path);
  ASSERT_TRUE(back) << back.error().Text();
  stream.record.raw_times_s.clear();
  ExpectSame(back->record, stream.record);
}

// --- the bytes of an export ------------------------------------------------------------------

// what is handed to the sink, in one piece
std::string BytesOf(const auto& write) {
  std::string bytes;
  const auto done = write([&](std::string_view piece) -> Result<void> {
    bytes += piece;
    return {};
  });
  EXPECT_TRUE(done) << (done ? "" : done.error().Text());
  return bytes;
}

template <typename T>
T NumberAt(const std::string& bytes, std::size_t at) {
  return LoadLittleEndian<T>(BytesOfText(bytes).subspan(at, sizeof(T)).data());
}

// `channels` of one value each
Recording OneRow(std::size_t channels) {
  Recording recording;
  recording.record.rows = 1;
  recording.record.stretches = {{.rows = 1, .rate_hz = 100}};
  for (std::size_t c = 0; c < channels; ++c) {
    recording.record.channels.push_back(
        {.name = "c", .values = {1}, .statuses = {SampleStatus::kOk}});
  }
  return recording;
}

// trial/export/export.h: pieces of 64 KiB or a little more, the last one of what is left
TEST(WriteInPieces, HandsOutPiecesOf64KibibytesAndTheRest) {
  constexpr std::size_t kPiece = std::size_t{1} << 16;
  for (const std::size_t row_bytes : {kPiece / 16, kPiece / 16 - 1, kPiece / 16 + 1}) {
    std::vector<std::size_t> sizes;
    const auto sink = [&](std::string_view piece) -> Result<void> {
      sizes.push_back(piece.size());
      return {};
    };
    const auto append = [&](std::size_t /*row*/, std::string* bytes) {
      bytes->append(row_bytes, 'r');
    };
    ASSERT_TRUE(WriteInPieces(std::string(row_bytes, 'h'), 35, append, sink));
    const std::size_t rows = row_bytes < kPiece / 16 ? 17 : 16;
    EXPECT_EQ(sizes, (std::vector<std::size_t>{rows * row_bytes, rows * row_bytes,
                                               (36 - 2 * rows) * row_bytes}));
  }
  const auto full = WriteInPieces(
      "head", 0, [](std::size_t /*row*/, std::string* /*bytes*/) {},
      [](std::string_view piece) -> Result<void> { return Failed("", std::string(piece)); });
  EXPECT_EQ(full.error().what, "head");
}

// docs/reference/formats.md
std::string CsvOf(const Record& record) {
  return BytesOf([&](const PieceSink& sink) { return WriteCsv(record, sink); });
}

Record ThreeRows() {
  Record record;
  record.rows = 3;
  record.stretches = {{.rows = 2, .start_s = 0.25, .rate_hz = 8},
                      {.first_row = 2, .rows = 1, .start_s = 1, .rate_hz = 4}};
  const std::vector<SampleStatus> ok(3);
  record.channels = {{.name = "a",
                      .role = ChannelRole::kDisplacement,
                      .unit = "m",
                      .values = {0.5, std::nan(""), -1e-7},
                      .statuses = ok},
                     {.name = "b",
                      .role = ChannelRole::kVoltage,
                      .unit = "V",
                      .values = {1, 2, 3},
                      .statuses = ok}};
  record.channels[0].range_min = -4;
  record.channels[0].resolution = 0.125;
  record.channels[1].range_max = 5;
  return record;
}

TEST(CsvExport, HasALineForEachThingAndARowForEachRow) {
  Record record = ThreeRows();
  const std::string stretches = "# stretch = 0 2 0.25 8 0\n# stretch = 2 1 1 4 0\n";
  const std::string channels =
      "# channel.1.name = a\n# channel.1.range_min = -4\n# channel.1.resolution = 0.125\n"
      "# channel.2.name = b\n# channel.2.range_max = 5\n";
  EXPECT_EQ(CsvOf(record), "# times = grid\n" + stretches + channels +
                               "time_s,displacement_m,voltage_v\n"
                               "0.25,0.5,1\n0.375,,2\n1,-1e-07,3\n");
  // one column of statuses where all channels have the same, else one each
  for (Channel& channel : record.channels) channel.statuses[2] = SampleStatus::kLate;
  EXPECT_TRUE(
      CsvOf(record).ends_with("time_s,displacement_m,voltage_v,status\n"
                              "0.25,0.5,1,ok\n0.375,,2,ok\n1,,,late\n"));
  record.channels[0].statuses[2] = SampleStatus::kRepeated;
  EXPECT_TRUE(
      CsvOf(record).ends_with("time_s,displacement_m,voltage_v,status_1,status_2\n"
                              "0.25,0.5,1,ok,ok\n0.375,,2,ok,ok\n"
                              "1,-1e-07,,repeated,late\n"));
  // raw times stand beside those that follow from the grid, or are the times
  record = ThreeRows();
  record.raw_times_s = {0.3, 0.4, 1.1};
  for (const auto& [timing, word] :
       {std::pair{Timing::kArrival, "arrived"}, std::pair{Timing::kPolled, "polled"}}) {
    record.timing = timing;
    const std::string text = CsvOf(record);
    EXPECT_TRUE(text.starts_with(std::string("# times = ") + word + "\n"));
    EXPECT_TRUE(
        text.ends_with("time_s,arrival_s,displacement_m,voltage_v\n"
                       "0.25,0.3,0.5,1\n0.375,0.4,,2\n1,1.1,-1e-07,3\n"));
  }
  record.times_are_known = true;
  EXPECT_TRUE(CsvOf(record).starts_with("# times = known\n"));
  EXPECT_TRUE(
      CsvOf(record).ends_with("time_s,displacement_m,voltage_v\n"
                              "0.3,0.5,1\n0.4,,2\n1.1,-1e-07,3\n"));
}

TEST(CsvExport, OfNoChannelIsRefused) {
  const auto sink = [](std::string_view /*piece*/) { return Result<void>(); };
  for (const auto& refused : {WriteCsv(Record{}, sink), WriteNpy(Recording{.report = {}}, sink)}) {
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().cause, Cause::kCannotAnswer);
    EXPECT_EQ(refused.error().what, "the record holds no channel");
  }
}

TEST(Remarks, AreOneLineForEachLossAndFinding) {
  ReadReport report;
  EXPECT_EQ(RemarksOf(report, Say), "");
  report.losses = {{.offset = 7, .bytes = 3, .block = 2, .rows = 0}};
  report.findings.Note(FindingKind::kRowsExcluded, {{"excluded", 4}});
  report.findings.Doubt(FindingKind::kInputTooLarge, {{"most_v", 12.5}});
  EXPECT_EQ(RemarksOf(report, Say), "block=2 from_byte=7 to_byte=9\nexcluded=4\nmost_v=12.5\n");
  EXPECT_EQ(RemarksOf(report, {}), "");
}

// numpy/lib/format.py: the data begin at a multiple of 64, behind at most 63 blanks and a line end
void ExpectNpyHead(const std::string& bytes) {
  ASSERT_TRUE(bytes.starts_with("\x93NUMPY"));
  const bool is_short = bytes[6] == 1;
  const std::size_t before = is_short ? 10 : 12;
  const std::size_t length =
      is_short ? NumberAt<std::uint16_t>(bytes, 8) : NumberAt<std::uint32_t>(bytes, 8);
  EXPECT_EQ((before + length) % 64, 0U);
  const std::string dictionary = bytes.substr(before, length);
  EXPECT_EQ(dictionary.back(), '\n');
  const std::size_t last = dictionary.find_last_not_of(" \n");
  EXPECT_EQ(dictionary[last], '}');
  EXPECT_LE(dictionary.size() - last - 2, 63U) << "blanks";
}

TEST(NpyExport, ItsDataBeginAtAMultipleOf64) {
  for (std::size_t channels = 1; channels <= 40; ++channels) {
    const Recording recording = OneRow(channels);
    const std::string bytes =
        BytesOf([&](const PieceSink& sink) { return WriteNpy(recording, sink); });
    ExpectNpyHead(bytes);
    EXPECT_EQ(bytes[6], 1);
    // the second array, of the description
    ExpectNpyHead(bytes.substr(bytes.rfind("\x93NUMPY")));
  }
  const Recording wide = OneRow(2000);
  const std::string bytes = BytesOf([&](const PieceSink& sink) { return WriteNpy(wide, sink); });
  ExpectNpyHead(bytes);
  EXPECT_EQ(bytes[6], 2) << "a head of 16 bits has no room for the names";
}

// the chunk `name` in bytes, from the byte behind its length
std::size_t ChunkAt(const std::string& bytes, std::string_view name) {
  std::size_t at = 12;
  while (at + 8 <= bytes.size() && bytes.substr(at, 4) != name) {
    const auto length = NumberAt<std::uint32_t>(bytes, at + 4);
    at += 8 + length + length % 2;
  }
  EXPECT_EQ(bytes.substr(at, 4), name);
  return at + 8;
}

// "Multimedia Programming Interface and Data Specifications 1.0", 1991, and WAVE_FORMAT_IEEE_FLOAT
TEST(WavExport, ItsChunksHoldTheLengthsOfTheFormat) {
  const Recording recording = TwoChannels();
  const std::string bytes =
      BytesOf([&](const PieceSink& sink) { return WriteWav(recording, sink); });
  EXPECT_EQ(NumberAt<std::uint32_t>(bytes, 4), bytes.size() - 8);
  const std::size_t format = ChunkAt(bytes, "fmt ");
  EXPECT_EQ(NumberAt<std::uint16_t>(bytes, format), 3U);
  EXPECT_EQ(NumberAt<std::uint16_t>(bytes, format + 2), 2U) << "channels";
  EXPECT_EQ(NumberAt<std::uint32_t>(bytes, format + 4), 8000U) << "rows a second";
  EXPECT_EQ(NumberAt<std::uint32_t>(bytes, format + 8), 8000U * 16) << "bytes a second";
  EXPECT_EQ(NumberAt<std::uint16_t>(bytes, format + 12), 16U) << "bytes a row";
  EXPECT_EQ(NumberAt<std::uint16_t>(bytes, format + 14), 64U) << "bits a sample";
  EXPECT_EQ(NumberAt<std::uint32_t>(bytes, ChunkAt(bytes, "fact")), 2000U);
  const std::size_t data = ChunkAt(bytes, "data");
  EXPECT_EQ(NumberAt<std::uint32_t>(bytes, data - 4), 2000U * 16);
  EXPECT_EQ(bytes.size() - data, 2000U * 16);
  // the mean of the first channel is taken off
  double mean = 0;
  for (const double value : recording.record.channels[0].values) mean += value / 2000;
  EXPECT_NEAR(NumberAt<double>(bytes, data), recording.record.channels[0].values[0] - mean, 1e-14)
      << "rounding of 2000 sums";
  // about 0 a mean would lose bits
  EXPECT_EQ(NumberAt<double>(bytes, data + 8), recording.record.channels[1].values[0]);
}

// the chunk of statuses, a byte a value
TEST(WavExport, HoldsStatusesWhereOneIsNotOk) {
  const std::string chunk = std::string("stat\x03\0\0\0", 8);
  Recording recording = OneRow(3);
  auto& channels = recording.record.channels;
  const auto bytes = [&] {
    return BytesOf([&](const PieceSink& sink) { return WriteWav(recording, sink); });
  };
  EXPECT_EQ(bytes().find(chunk), std::string::npos);
  channels[1].statuses = {SampleStatus::kRepeated};
  EXPECT_NE(bytes().find(chunk + std::string("\0\1\0", 3)), std::string::npos);
  for (auto& channel : channels) channel.statuses = {SampleStatus::kRepeated};
  EXPECT_NE(bytes().find(chunk + "\1\1\1"), std::string::npos);
}

std::string ErrorOfWav(const Recording& recording) {
  const auto done = WriteWav(recording, [](std::string_view /*piece*/) { return Result<void>(); });
  return done ? "" : done.error().what;
}

TEST(WavExport, ItsRateIsAWholeNumberWithin100Ppm) {
  Recording recording = OneRow(1);
  for (const double share : {-1.01e-4, -0.99e-4, 0.0, 0.99e-4, 1.01e-4}) {
    recording.record.stretches[0].rate_hz = 1000 * (1 + share);
    EXPECT_EQ(ErrorOfWav(recording).empty(), std::abs(share) < 1e-4) << share;
  }
  for (const double rate_hz : {0.4, 3.3, 4e9}) {
    recording.record.stretches[0].rate_hz = rate_hz;
    EXPECT_THAT(ErrorOfWav(recording), HasSubstr("a whole number of hertz")) << rate_hz;
  }
}

// 16 bits hold the bytes of a row: 9 for each of 7281 tracks
TEST(WavExport, HasRoomFor7281ChannelsAnd4GiB) {
  EXPECT_EQ(ErrorOfWav(OneRow(7281)), "");
  EXPECT_THAT(ErrorOfWav(OneRow(7282)), HasSubstr("4 GiB"));
  EXPECT_THAT(ErrorOfWav(OneRow(0)), HasSubstr("holds no samples"));
  Recording empty = OneRow(1);
  empty.record.rows = 0;
  EXPECT_THAT(ErrorOfWav(empty), HasSubstr("holds no samples"));
  // 9 bytes a value: 4.19e9 and 4.20e9 bytes; the first is refused for another reason
  Recording large = OneRow(1);
  large.record.stretches.clear();
  large.record.rows = 466'000'000;
  EXPECT_THAT(ErrorOfWav(large), ::testing::Not(HasSubstr("4 GiB")));
  large.record.rows = 467'000'000;
  EXPECT_THAT(ErrorOfWav(large), HasSubstr("4 GiB"));
}

TEST(WavExport, CountsItsGaps) {
  Recording recording = OneRow(1);
  for (const char* told : {"", "has 1 gap, and", "has 2 gaps, and"}) {
    EXPECT_THAT(ErrorOfWav(recording), HasSubstr(told));
    recording.record.stretches.push_back({.first_row = 1, .rate_hz = 100});
  }
}

TEST(WavExport, CountsWhatIsNoMeasurement) {
  Recording recording = TwoChannels();
  recording.record.channels[0].statuses[3] = SampleStatus::kLate;
  EXPECT_THAT(ErrorOfWav(recording), HasSubstr("holds 1 value that is no measurement"));
  recording.record.channels[1].values[5] = std::nan("");
  EXPECT_THAT(ErrorOfWav(recording), HasSubstr("holds 2 values that are no measurement"));
}

// 16 bytes of times and 9 a channel in each row: 25 bytes
TEST(MatExport, OfMoreThanTwoGigabytesIsRefused) {
  const ScratchDirectory directory;
  auto writer = MatWriter::Create(directory.File("t.mat"));
  ASSERT_TRUE(writer);
  Recording large = OneRow(1);
  large.record.rows = 80'800'000;
  const auto refused = writer->Add("t", large);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().cause, Cause::kCannotAnswer);
  EXPECT_THAT(refused.error().what, HasSubstr("2 GiB"));
}

// what Close finds at the path stands for what the disk has taken
TEST(MatExport, ThatIsNotWholeOnTheDiskIsAnError) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.mat"), whole = directory.File("whole.mat");
  ASSERT_TRUE(Export(whole, TwoChannels()));
  std::ifstream file(whole, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  struct Case {
    std::string found;
    int variables;
    bool is_whole;
  };
  const std::string second = bytes.substr(128);
  for (const Case& at :
       {Case{bytes, 1, true}, Case{bytes + second, 2, true}, Case{bytes, 2, false},
        Case{bytes + second, 1, false}, Case{bytes.substr(0, bytes.size() - 1), 1, false},
        Case{bytes + std::string(7, '\0'), 1, false}, Case{bytes + std::string(8, '\0'), 1, false},
        Case{bytes.substr(0, 128), 1, false}, Case{"", 1, false}}) {
    auto writer = MatWriter::Create(path);
    ASSERT_TRUE(writer);
    for (int k = 0; k < at.variables; ++k) {
      ASSERT_TRUE(writer->Add("t" + std::to_string(k), OneRow(1), Say));
    }
    std::filesystem::remove(path);
    std::ofstream(path, std::ios::binary) << at.found;
    const auto closed = writer->Close();
    EXPECT_EQ(closed.has_value(), at.is_whole) << at.found.size() << " " << at.variables;
    if (closed) continue;
    EXPECT_EQ(closed.error().cause, Cause::kFailed);
    EXPECT_EQ(closed.error().what, "could not be written as a MATLAB file");
  }
}

TEST(MatExport, OneOfSeveralIsReadByItsName) {
  const ScratchDirectory directory;
  const std::string path = directory.File("all.mat");
  auto writer = MatWriter::Create(path);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->Add("a", Polled()));
  ASSERT_TRUE(writer->Add("b", TwoChannels()));
  ASSERT_TRUE(writer->Close());
  EXPECT_EQ(ReadRecording(path).error().Text(),
            path + ": holds 2 trials: a, b; name one as " + path + "/a");
  EXPECT_THAT(ReadRecording(path + "/c").error().Text(), HasSubstr("holds no variable 'c'"));
  const auto b = ReadRecording(path + "/b");
  ASSERT_TRUE(b) << b.error().Text();
  ExpectSame(b->record, TwoChannels().record);
}

}  // namespace
}  // namespace haptometer::trial
