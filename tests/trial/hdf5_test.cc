#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>

#include "tests/findings.h"
#include "tests/trial/recordings.h"
#include "tests/trial/trial_file.h"
#include "trial/block.h"
#include "trial/export/export.h"
#include "trial/export/object_names.h"
#include "trial/hdf5_id.h"
#include "trial/import/read_recording.h"
#include "trial/import/readers.h"
#include "trial/trial_format.h"

namespace haptometer::trial {
namespace {

using ::testing::HasSubstr;

void Write(const std::string& path, const std::vector<std::pair<std::string, Recording>>& trials) {
  auto writer = Hdf5Writer::Create(path);
  ASSERT_TRUE(writer) << writer.error().Text();
  for (const auto& [name, recording] : trials) {
    const auto done = writer->Add(name, recording, nullptr,
                                  [](const Finding& found) { return tests::NumbersOf(found); });
    ASSERT_TRUE(done) << done.error().Text();
  }
  ASSERT_TRUE(writer->Close());
}

TEST(Hdf5, WhatIsExportedIsReadBackBitForBit) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  const Recording polled = Polled();
  ASSERT_EQ(polled.report.losses.size(), 1);
  Write(path, {{"t", polled}});
  const auto back = ReadRecording(path);
  ASSERT_TRUE(back) << back.error().Text();
  ExpectSame(back->record, polled.record);
  EXPECT_EQ(back->report.kind, FileKind::kHdf5);
  EXPECT_TRUE(back->report.closed);
  ASSERT_EQ(back->report.events.size(), 1);
  EXPECT_EQ(EventToJson(back->report.events[0]), EventToJson(polled.report.events[0]));
  EXPECT_THAT(tests::NumbersOf(back->report.findings, FindingKind::kNotedAtExport),
              ::testing::MatchesRegex(
                  "text=block=3 from_byte=[0-9]+ to_byte=[0-9]+ first_row=10 last_row=19"));
}

// the numbers of a dataset of the trial t, as `type` lies in memory
template <typename T>
std::vector<T> NumbersIn(const std::string& path, const std::string& name, hid_t type) {
  const Hdf5Id file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  const Hdf5Id dataset(H5Dopen2(file.id(), ("t/" + name).c_str(), H5P_DEFAULT), H5Dclose);
  if (!dataset.ok()) return {};
  const Hdf5Id space(H5Dget_space(dataset.id()), H5Sclose);
  const Hdf5Id stored(H5Dget_type(dataset.id()), H5Tclose);
  EXPECT_GT(H5Tequal(stored.id(), type), 0) << name;
  std::vector<T> numbers(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.id())));
  EXPECT_GE(H5Dread(dataset.id(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()), 0);
  return numbers;
}

// docs/reference/formats.md: the group `raw`, each column in its own encoding
TEST(Hdf5, OfATrialTheRawNumbersAndTimesAreKept) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  for (const Timing timing : {Timing::kUniform, Timing::kArrival, Timing::kPolled}) {
    MemoryDisk disk;
    ManualClock clock;
    TrialHeader header = CountsHeader(timing);
    header.channels.resize(3, header.channels[0]);
    for (std::size_t c = 0; c < 3; ++c) {
      header.channels[c].name = "c" + std::to_string(c);
      header.channels[c].encoding = static_cast<Encoding>(c);
    }
    auto writer = WriterInto(&disk, header, clock);
    std::vector<std::int64_t> index, time_ns, reply_ns;
    std::vector<std::int32_t> counts;
    std::vector<float> floats;
    std::vector<double> doubles;
    for (int i = 0; i < 10; ++i) {
      index.push_back(i < 6 ? i + 3 : i + 8);
      time_ns.push_back(1000 + 20'000'000LL * i);
      reply_ns.push_back(time_ns.back() + 77 + i);
      counts.push_back(-7 * i);
      floats.push_back(static_cast<float>(i) / 3);
      doubles.push_back(i / 7.0);
      const std::array samples{Sample{RawValue::Counts(counts.back()), SampleStatus::kOk},
                               Sample{RawValue::F32(floats.back()), SampleStatus::kLate},
                               Sample{RawValue::F64(doubles.back()), SampleStatus::kOk}};
      ASSERT_TRUE(writer.Append({.index = index.back(),
                                 .time_ns = time_ns.back(),
                                 .reply_ns = reply_ns.back(),
                                 .samples = samples}));
      if (i == 3) {
        ASSERT_TRUE(writer.Flush());
      }
    }
    ASSERT_TRUE(writer.Finish());
    auto raw = TrialReader::OpenFrom(MakeMemorySource(disk.bytes), "t.bin");
    const auto recording = ReadBytes(disk.bytes);
    ASSERT_TRUE(raw && recording);
    auto hdf5 = Hdf5Writer::Create(path);
    ASSERT_TRUE(hdf5 && hdf5->Add("t", *recording, &*raw) && hdf5->Close());
    const auto times = [&](const char* name) {
      return NumbersIn<std::int64_t>(path, std::string("raw/") + name, H5T_STD_I64LE);
    };
    using Times = std::vector<std::int64_t>;
    EXPECT_EQ(times("index"), timing == Timing::kUniform ? index : Times{});
    EXPECT_EQ(times("time_ns"), timing == Timing::kArrival ? time_ns : Times{});
    EXPECT_EQ(times("request_ns"), timing == Timing::kPolled ? time_ns : Times{});
    EXPECT_EQ(times("reply_ns"), timing == Timing::kPolled ? reply_ns : Times{});
    EXPECT_EQ(NumbersIn<std::int32_t>(path, "raw/displacement_m", H5T_STD_I32LE), counts);
    EXPECT_EQ(NumbersIn<float>(path, "raw/displacement_2_m", H5T_IEEE_F32LE), floats);
    EXPECT_EQ(NumbersIn<double>(path, "raw/displacement_3_m", H5T_IEEE_F64LE), doubles);
    // the header is the trial's own, with the encodings
    const auto back = ReadRecording(path);
    ASSERT_TRUE(back) << back.error().Text();
    ExpectSame(back->record, recording->record);
  }
}

TEST(Hdf5, ANameThatIsTakenIsAnError) {
  const ScratchDirectory directory;
  auto writer = Hdf5Writer::Create(directory.File("t.h5"));
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->Add("t", Polled(), nullptr));
  const auto again = writer->Add("t", Polled(), nullptr);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().what, "could not be written as HDF5");
  EXPECT_TRUE(writer->Close());
}

// a trial in which nothing has been recorded yet
TEST(Hdf5, OfNoRowsIsWritten) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  const auto empty = ReadBytes(CountingTrial(0, 1));
  ASSERT_TRUE(empty);
  Write(path, {{"t", *empty}});
  EXPECT_TRUE(NumbersIn<double>(path, "time_s", H5T_IEEE_F64LE).empty());
  EXPECT_TRUE(NumbersIn<double>(path, "displacement_m", H5T_IEEE_F64LE).empty());
}

TEST(Hdf5Id, IsClosedOnceAndStatesAFailure) {
  static int closed = 0;
  const auto fails = [](std::int64_t id) {
    closed = static_cast<int>(id);
    return -1;
  };
  const auto succeeds = [](std::int64_t id) {
    closed = static_cast<int>(id);
    return 0;
  };
  Hdf5Id failing(7, fails);
  EXPECT_TRUE(failing.ok());
  EXPECT_FALSE(failing.Close());
  EXPECT_EQ(closed, 7);
  closed = 0;
  EXPECT_FALSE(failing.ok());
  EXPECT_TRUE(failing.Close()) << "there is nothing to close";
  EXPECT_EQ(closed, 0);
  Hdf5Id first(0, succeeds);
  EXPECT_TRUE(first.ok()) << "0 is one";
  {
    const Hdf5Id second = std::move(first);
    EXPECT_EQ(second.id(), 0);
    closed = 9;
  }
  EXPECT_EQ(closed, 0);
  EXPECT_TRUE(Hdf5Id(3, succeeds).Close());
  EXPECT_EQ(closed, 3);
}

TEST(Hdf5, ATrialThatGrowsMeanwhileIsExportedAsItWasRead) {
  const ScratchDirectory directory;
  const auto recording = ReadBytes(CountingTrial(30, 7));
  ASSERT_TRUE(recording);
  for (const int rows : {29, 30, 31, 100}) {
    auto raw = TrialReader::OpenFrom(MakeMemorySource(CountingTrial(rows, 7)), "t.bin");
    ASSERT_TRUE(raw);
    auto writer = Hdf5Writer::Create(directory.File("t.h5"));
    ASSERT_TRUE(writer);
    const auto done = writer->Add("t", *recording, &*raw);
    EXPECT_EQ(done.has_value(), rows >= 30) << rows;
    if (!done) {
      EXPECT_EQ(done.error().cause, Cause::kCannotAnswer);
      EXPECT_THAT(done.error().Text(), HasSubstr("has fewer rows than when it was opened"));
    }
  }
}

TEST(Hdf5, SeveralTrialsAreToldApartByTheirNames) {
  const ScratchDirectory directory;
  const std::string path = directory.File("all.h5");
  Recording csv;
  csv.record = *ParseCsv("time_s,voltage_v\n0,1\n1,2\n", "f");
  csv.report.closed = true;
  Write(path, {{"a", Polled()}, {"b", csv}});
  EXPECT_EQ(ReadRecording(path).error().Text(),
            path + ": holds 2 trials: a, b; name one as " + path + "/a");
  EXPECT_THAT(ReadRecording(path + "/c").error().Text(), HasSubstr("holds no trial 'c', but a, b"));
  const auto b = ReadRecording(path + "/b");
  ASSERT_TRUE(b) << b.error().Text();
  ExpectSame(b->record, csv.record);
}

TEST(Hdf5, DamagedFilesAreRefusedOrHarmless) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  Write(path, {{"t", Polled()}});
  std::ifstream file(path, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(file), {}};
  // cut anywhere: never a part of it as if it were the whole
  for (std::size_t cut = 8; cut + 1 < whole.size(); cut += 97) {
    std::ofstream(path, std::ios::binary) << whole.substr(0, cut);
    const auto read = ReadRecording(path);
    ASSERT_FALSE(read) << cut;
    EXPECT_EQ(read.error().cause, Cause::kCannotAnswer);
  }
}

TEST(Hdf5, TimesThatAreKnownStayKnown) {
  auto record = ParseCsv("time_s,displacement_m\n0,1\n0.25,2\n0.6,3\n0.7,4\n", "f.csv");
  ASSERT_TRUE(record);
  ASSERT_TRUE(record->times_are_known);
  const std::string path = ::testing::TempDir() + "known.h5";
  Write(path, {{"t", Recording{.record = *record, .report = {}}}});
  const auto again = ReadHdf5(path, "");
  ASSERT_TRUE(again) << again.error().Text();
  EXPECT_TRUE(again->record.times_are_known);
  EXPECT_TRUE(SameBits(again->record.raw_times_s, record->raw_times_s));
  std::remove(path.c_str());
}

// writes the flag `closed` of the trial t again, as `count` numbers of a type
void SetClosed(const std::string& path, hid_t type, hsize_t count, const void* numbers) {
  const Hdf5Id file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
  const Hdf5Id group(H5Gopen2(file.id(), "t", H5P_DEFAULT), H5Gclose);
  EXPECT_GE(H5Adelete(group.id(), objects::kClosed), 0);
  if (count == 0) return;
  const Hdf5Id space(H5Screate_simple(1, &count, nullptr), H5Sclose);
  const Hdf5Id attribute(
      H5Acreate2(group.id(), objects::kClosed, type, space.id(), H5P_DEFAULT, H5P_DEFAULT),
      H5Aclose);
  EXPECT_GE(H5Awrite(attribute.id(), type, numbers), 0);
}

TEST(Hdf5, AFlagIsOneWholeNumberThatIsNotZero) {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.h5");
  const auto is_closed = [&path](hid_t type, hsize_t count, const void* numbers) {
    Write(path, {{"t", Polled()}});
    SetClosed(path, type, count, numbers);
    const auto read = ReadRecording(path);
    EXPECT_TRUE(read);
    return read && read->report.closed;
  };
  constexpr std::array<std::int32_t, 2> kOnes{1, 1};
  constexpr std::int32_t kZero = 0, kTwo = 2;
  constexpr double kOne = 1;
  EXPECT_TRUE(is_closed(H5T_NATIVE_INT32, 1, kOnes.data()));
  EXPECT_TRUE(is_closed(H5T_NATIVE_INT32, 1, &kTwo));
  EXPECT_FALSE(is_closed(H5T_NATIVE_INT32, 1, &kZero));
  EXPECT_FALSE(is_closed(H5T_NATIVE_INT32, 2, kOnes.data()));
  EXPECT_FALSE(is_closed(H5T_NATIVE_DOUBLE, 1, &kOne));
  EXPECT_FALSE(is_closed(H5T_NATIVE_INT32, 0, nullptr)) << "none";
}

TEST(ReadRecording, WhatIsKnownAndNotReadIsNamed) {
  const std::pair<std::string, const char*> kFiles[]{
      {std::string("RF64\xff\xff\xff\xffWAVEds64", 16), "is a WAV file of more than 4 GiB"},
      {"MATLAB 7.3 MAT-file, Platform: posix", "is a MATLAB file of version 7.3"},
      {std::string("PK\x03\x04\x14\0", 6), "is a ZIP archive"},
      {std::string("TDSm\x0e\0", 6), "is a LabVIEW TDMS file"},
      {std::string("\x0f\x0f:WFM#003", 10), "is a binary waveform of a Tektronix"}};
  const std::string path = ::testing::TempDir() + "kind.bin";
  for (const auto& [bytes, message] : kFiles) {
    std::ofstream(path, std::ios::binary) << bytes;
    const auto read = ReadRecording(path);
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().cause, Cause::kCannotAnswer);
    EXPECT_THAT(read.error().Text(), HasSubstr(message));
    EXPECT_THAT(read.error().remedy, HasSubstr("export its columns as a CSV"));
  }
  std::remove(path.c_str());
}

}  // namespace
}  // namespace haptometer::trial
