// What the first bytes of a file say of its kind.
#include "trial/import/read_recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/trial/trial_file.h"
#include "trial/import/import_options.h"

namespace haptometer::trial {
namespace {

using ::testing::HasSubstr;

// a file with these bytes
std::string FileOf(const ScratchDirectory& directory, const std::string& bytes) {
  std::string path = directory.File("f");
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

// signatures by the makers' descriptions of their formats, and what the message says of each
TEST(KindsOfFiles, WhatIsNotReadIsNamed) {
  const ScratchDirectory directory;
  const std::pair<std::string, const char*> kKinds[]{
      {"MATLAB 7.3 MAT-file", "a MATLAB file of version 7.3"},
      {"RF64", "(RF64)"},
      {"\x89PNG\r\n\x1a\n", "(PNG)"},
      {"\xff\xd8\xff\xe0", "(JPEG)"},
      {"%PDF-1.4", "a PDF document"},
      {"PK\x03\x04", "a ZIP archive"},
      {"\x1f\x8b\x08", "compressed by gzip"},
      {"\xd0\xcf\x11\xe0\xa1\xb1", "an old Excel or Word document"},
      {"TDSm", "a LabVIEW TDMS file"},
      {"<SALEAE>", "a binary export of Saleae Logic"},
      {"RG01", "a Rigol oscilloscope"},
      {"RG03", "a Rigol oscilloscope"},
      {"AG10", "a Keysight oscilloscope"},
      {"AG01", "a Keysight oscilloscope"},
      {"\x0f\x0f:WFM#003", "a Tektronix oscilloscope"},
      {"#9000000346WAVEDESC", "a LeCroy oscilloscope"},
      {"WAVEDESC", "a LeCroy oscilloscope"},
      {"PAR1", "an Apache Parquet table"}};
  for (const auto& [bytes, message] : kKinds) {
    const auto read = ReadRecording(FileOf(directory, bytes));
    ASSERT_FALSE(read) << message;
    EXPECT_THAT(read.error().Text(), HasSubstr(message));
  }
}

// the signature at another place, and a byte less of it
TEST(KindsOfFiles, ASignatureStandsWholeAtItsPlace) {
  const ScratchDirectory directory;
  for (const char* bytes :
       {" TDSm", "TDS", "PK\x03", "x:WFM#", "#9000000346WAVEDES", " WAVEDESC"}) {
    const auto read = ReadRecording(FileOf(directory, bytes));
    ASSERT_FALSE(read) << bytes;
    EXPECT_THAT(read.error().Text(), ::testing::Not(HasSubstr(": is a "))) << bytes;
  }
}

TEST(KindsOfFiles, AControlCharacterIsNoText) {
  const ScratchDirectory directory;
  for (const int c : {0, 1, 8, 9, 10, 11, 12, 13, 14, 0x1f, 0x20, 0x7e, 0x7f, 0x80, 0xff}) {
    const bool is_text = (c >= 0x20 && c != 0x7f) || c == '\t' || c == '\r' || c == '\n';
    const std::string bytes = std::string("a") + static_cast<char>(c) + "b";
    EXPECT_EQ(IsTable(FileOf(directory, bytes)), is_text) << c;
  }
}

TEST(KindsOfFiles, AByteOrderMarkIsTwoDifferentBytes) {
  const ScratchDirectory directory;
  const auto is_table = [&](const std::string& bytes) { return IsTable(FileOf(directory, bytes)); };
  EXPECT_TRUE(
      is_table(std::string("\xff\xfe"
                           "1\0",
                           4)));
  EXPECT_TRUE(
      is_table(std::string("\xfe\xff\0"
                           "1",
                           4)));
  EXPECT_FALSE(
      is_table("\xff\xff"
               "1"));
  EXPECT_FALSE(
      is_table("\xfe\xfe"
               "1"));
  EXPECT_FALSE(
      is_table("\xff"
               "1"));
  // UTF-16 without a mark, of Latin letters and one of another script
  EXPECT_TRUE(is_table(std::string("a\0b\0c\0d\0e\0\xbc\x03", 12)));
  EXPECT_FALSE(is_table(std::string("abcde\xbc\x03", 7)));
}

TEST(KindsOfFiles, ARiffFileIsASoundWhereItSaysSo) {
  const ScratchDirectory directory;
  const auto error_of = [&](const std::string& bytes) {
    const auto read = ReadRecording(FileOf(directory, bytes));
    return read ? "was read" : read.error().Text();
  };
  EXPECT_THAT(error_of("RIFFxxxxWAVE"), HasSubstr("is a WAV file that holds neither PCM"));
  EXPECT_THAT(error_of("RIFFxxxxAVI "), HasSubstr("no time column is named"));
  EXPECT_THAT(error_of("WAVExxxxRIFF"), HasSubstr("no time column is named"));
  EXPECT_THAT(error_of(""), HasSubstr("is empty"));
  EXPECT_THAT(error_of("\x93NUMPY"), HasSubstr("is a NumPy array whose head is damaged"));
  // what is neither text nor another kind should be a trial
  EXPECT_THAT(error_of(std::string("a\0b", 3)),
              HasSubstr(", or a CSV whose header line begins with time_s"));
  EXPECT_FALSE(ReadRecording("no-file-of-this-name"));
}

// two bytes 1 and 2 as an NPY, and one channel as text
const std::string kNpy = std::string("\x93NUMPY\1\0\x3a\0", 10) +
                         "{'descr': '|u1', 'fortran_order': False, 'shape': (2,), }\n\1\2";
constexpr const char* kCsv = "time_s,voltage_v\n0,1\n0.5,2\n";

TEST(KindsOfFiles, OneRecordingHasNoNameInItsFile) {
  const ScratchDirectory directory;
  const ImportOptions at_rate{.rate_hz = 10.0};
  for (const std::string& bytes : {kNpy, std::string(kCsv)}) {
    const std::string path = FileOf(directory, bytes);
    const auto inner = ReadRecording(path + "/x", at_rate);
    ASSERT_FALSE(inner);
    EXPECT_EQ(inner.error().Text(),
              path + "/x: lies in a file that holds one recording; name the file");
  }
  const auto npy = ReadRecording(FileOf(directory, kNpy), at_rate);
  ASSERT_TRUE(npy) << npy.error().Text();
  EXPECT_EQ(npy->report.kind, FileKind::kNpy);
  EXPECT_EQ(npy->report.file_bytes, kNpy.size());
  EXPECT_EQ(npy->record.channels.at(0).values, (std::vector<double>{1, 2}));
}

TEST(KindsOfFiles, WhatHoldsNumbersWithoutAHeaderIsATable) {
  const ScratchDirectory directory;
  EXPECT_TRUE(IsTable(FileOf(directory, kNpy))) << "no export";
  EXPECT_TRUE(IsTable(FileOf(directory, kNpy.substr(0, 20)))) << "a damaged one";
  EXPECT_TRUE(IsTable(FileOf(directory, "")));
  EXPECT_TRUE(IsTable(directory.File(""))) << "no file";
  EXPECT_FALSE(IsTable(FileOf(directory, std::string("a\0b", 3))));
}

TEST(KindsOfFiles, TextsHaveTheirKindAndTheirCalibration) {
  const ScratchDirectory directory;
  const std::string calibration = directory.File("c.toml");
  std::ofstream(calibration) << "[displacement]\nscale_m_per_v = 0.001\noffset_m = 0.5\n";
  const std::string lvm =
      "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\nChannels\t1\nY_Unit_Label\tV\n"
      "***End_of_Header***\nX_Value\tvoltage_v\n0\t1\n0.5\t2\n";
  for (const std::string& text : {std::string(kCsv), lvm}) {
    const auto read = ReadRecording(FileOf(directory, text), {.calibration = calibration});
    ASSERT_TRUE(read) << read.error().Text();
    EXPECT_EQ(read->report.kind, text == kCsv ? FileKind::kCsv : FileKind::kLvm);
    EXPECT_TRUE(read->report.closed);
    EXPECT_EQ(read->report.rows, 2U);
    EXPECT_EQ(read->report.next_row, 2U);
    EXPECT_EQ(read->record.channels.at(0).role, ChannelRole::kDisplacement);
    EXPECT_EQ(read->record.channels[0].values, (std::vector<double>{0.501, 0.502}));
  }
}

// --- layouts -------------------------------------------------------------------------------------

TEST(TableFormats, AreLookedForInSixtyFourLines) {
  EXPECT_EQ(FindTableFormat(std::string(63, '\n') + "LeCroy,1\n"), TableFormat::kLecroy);
  EXPECT_EQ(FindTableFormat(std::string(64, '\n') + "LeCroy,1\n"), TableFormat::kPlain);
}

TEST(TableFormats, AreLookedForInTheBeginningOfALine) {
  constexpr std::string_view kSign = ",Start,Increment";
  const auto format = [&](std::size_t before) {
    return FindTableFormat(std::string(before, 'x') + std::string(kSign));
  };
  EXPECT_EQ(format(400 - kSign.size()), TableFormat::kRigolSequence);
  EXPECT_EQ(format(401 - kSign.size()), TableFormat::kPlain);
}

TEST(TableFormats, ReadTheSameBehindAnySeparatorAndDecoration) {
  for (const char* text :
       {"X,CH1\nSecond,Volt\n", "x;ch1;\nsecond;volt\n", "\"X\"\t\"CH1\"\r\n\"Second\"\t\"Volt\"",
        " X , CH1\r\n Second , Volt", "words\nX,CH1\nSecond,Volt\n"}) {
    EXPECT_EQ(FindTableFormat(text), TableFormat::kRigolSeconds) << text;
  }
  // lines that do not follow each other
  EXPECT_EQ(FindTableFormat("X,CH1\n\nSecond,Volt\n"), TableFormat::kPlain);
  EXPECT_EQ(FindTableFormat("Second,Volt\nX,CH1\n"), TableFormat::kPlain);
}

// a sign each of every layout, and signs of which a part is missing
TEST(TableFormats, AreFoundByTheirSigns) {
  using enum TableFormat;
  const std::pair<const char*, TableFormat> kSigns[]{
      {"#Digilent WaveForms Oscilloscope", kDigilent},
      {"#CHANNEL:CH1", kHantek},
      {"#CLOCK=20.0uS\n#SIZE=3", kHantek},
      {"#SIZE=3\nwords\n#CLOCK=20.0uS", kHantek},
      {"#CLOCK=20.0uS", kPlain},
      {"#SIZE=3", kPlain},
      {"LECROYWP715Zi-A,1,Waveform", kLecroy},
      {"Record Length,3,,0,1", kTektronixTds},
      {"Record Length,3,x,0,1", kPlain},
      {"Record Length,3,,x,1", kPlain},
      {"Record Length,3,,0,x", kPlain},
      {"Record Length,3,,0", kPlain},
      {"words\nRecord Length,3,,0,1", kPlain},
      {"Model,DPO4104\nWaveform Type,ANALOG", kTektronixDpo},
      {"Model,MSO46\nWaveform Type,ANALOG\nZero Index,5", kTektronixMso},
      {"Model,MSO46\nZero Index,5", kPlain},
      {"Waveform Type,ANALOG", kPlain},
      {"Record Length,Analog:7000", kSiglent},
      {"Source,CH1\nSecond,Volt", kSiglent},
      {"X,CH1\nSequence,Volt", kRigolSequence},
      {"CH1,CH2,Start,Increment", kRigolSequence},
      {"CH1V,t0 = 0s, tInc = 1s", kRigolSequence},
      {"Number of Data points,5", kRigolUltrascope},
      {"X,CH1(V)", kRigolVolts},
      {"X,CH2(V)", kRigolVolts},
      {"X,CH3(V)", kPlain},
      {",CH1\nSecond,Volt", kRigolDs1204},
      {"x-axis,1\nsecond,Volt", kKeysightInfiniivision},
      {"Revision:,0", kKeysightInfiniium},
      {"XInc:,1e-9", kKeysightInfiniium},
      {"Meta data\nPhysical channel,Start Time", kNiPxi},
      {"waveform,A\nt0,5/7/2021", kNiElvis},
      {"Time,Channel A", kPicoscope},
      {"Zeit,Kanal A", kPicoscope},
      {"Time [s],Channel 0", kSaleae},
      {"Time [s],A [V]", kPlain},
      {"Time [s],A (mV),B", kPlain},
      // brackets that do not close, or close before they open
      {"Time [s],D0,A [V", kSaleae},
      {"Time [s],D0,A )(V", kSaleae},
      // of channels that have other names than Saleae gives one has
      {"Time [s],Coil,A1", kSaleae},
      {"Time [s],Laser", kPlain},
      {"Time [s],Laser mm", kPlain},
      {"Time [s],Force [N]", kPlain},
      {"Time [s],Channel", kPlain},
      {"Time [s],Channel 0 x", kPlain},
      {"t/s,CH1/V", kOpenhantek},
      {"in s,CH1 in V", kRohdeSchwarz},
      {"Time in s,CH1 in V", kRohdeSchwarz},
      {"Time,A", kPlain}};
  for (const auto& [text, format] : kSigns) EXPECT_EQ(FindTableFormat(text), format) << text;
}

TEST(TableFormats, HaveNamesThatLeadBackToThem) {
  for (const TableFormatFacts& facts : TableFormats()) {
    EXPECT_EQ(TableFormatFromName(facts.name), facts.format) << facts.name;
    EXPECT_EQ(FactsOf(facts.format).title, facts.title);
  }
  EXPECT_EQ(TableFormats().size(), 21U);
  EXPECT_EQ(TableFormatFromName("lecro"), std::nullopt);
}

}  // namespace
}  // namespace haptometer::trial
