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
