// What the first bytes of a file say of its kind.
#include "trial/import/read_recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <utility>

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
