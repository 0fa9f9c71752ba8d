// WAV files, made here byte by byte as the specification says.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/findings.h"
#include "tests/residual.h"
#include "trial/import/readers.h"
#include "trial/trial_format.h"

namespace haptometer::trial {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// `number` in `bytes` bytes, the least first
std::string Le(std::uint64_t number, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(number >> (8 * i) & 0xffU);
  return text;
}

std::string Chunk(const std::string& name, const std::string& content) {
  return name + Le(content.size(), 4) + content + std::string(content.size() % 2, '\0');
}

struct Form {
  std::uint16_t tag = 1;  // 1: whole numbers, 3: floats
  std::uint16_t bits = 16;
  std::uint16_t channels = 1;
  std::uint32_t rate_hz = 8000;
  std::size_t row_bytes = 0;  // 0: as it has to be
};

std::string FormatOf(const Form& form) {
  const std::size_t row =
      form.row_bytes > 0 ? form.row_bytes : std::size_t{form.channels} * (form.bits / 8U);
  return Le(form.tag, 2) + Le(form.channels, 2) + Le(form.rate_hz, 4) + Le(row * form.rate_hz, 4) +
         Le(row, 2) + Le(form.bits, 2);
}

// the extensible form with the bits that hold a sample
std::string Extensible(const Form& form, std::uint16_t valid_bits, std::uint16_t tag) {
  return FormatOf({.tag = 0xfffe, .bits = form.bits, .channels = form.channels}) + Le(22, 2) +
         Le(valid_bits, 2) + Le(0, 4) + Le(tag, 2) + std::string(14, '\0');
}

std::string Riff(const std::string& chunks) {
  return "RIFF" + Le(4 + chunks.size(), 4) + "WAVE" + chunks;
}

std::string Wav(const std::string& format, const std::string& samples) {
  return Riff(Chunk("fmt ", format) + Chunk("data", samples));
}

std::string Samples(const std::vector<std::int64_t>& counts, int bytes) {
  std::string text;
  for (const std::int64_t count : counts) text += Le(static_cast<std::uint64_t>(count), bytes);
  return text;
}

Recording Parsed(const std::string& bytes, const ImportOptions& options = {}) {
  auto recording = ParseWav(bytes, "f.wav", options);
  EXPECT_TRUE(recording) << recording.error().Text();
  return recording ? std::move(*recording) : Recording{};
}

std::string ErrorOf(const std::string& bytes) {
  const auto recording = ParseWav(bytes, "f.wav");
  return recording ? "was read" : recording.error().Text();
}

const std::vector<SampleStatus>& StatusesOf(const Recording& recording) {
  return recording.record.channels.at(0).statuses;
}

// --- samples -------------------------------------------------------------------------------------

TEST(Wav, WholeNumbersArePartsOfFullScale) {
  struct Case {
    int bytes;
    double full_scale;
  };
  for (const auto& [bytes, full_scale] : {Case{2, 0x1p15}, {3, 0x1p23}, {4, 0x1p31}}) {
    const std::vector<std::int64_t> counts{0, 1, -1, 257, -1000, 20'000};
    const Form form{.bits = static_cast<std::uint16_t>(8 * bytes)};
    const Recording read = Parsed(Wav(FormatOf(form), Samples(counts, bytes)));
    ASSERT_EQ(read.record.rows, counts.size());
    for (std::size_t i = 0; i < counts.size(); ++i) {
      EXPECT_EQ(read.record.channels.at(0).values[i], static_cast<double>(counts[i]) / full_scale)
          << bytes;
    }
  }
  // a byte counts from 128
  const Recording bytes = Parsed(Wav(FormatOf({.bits = 8}), Samples({128, 129, 127, 64, 1}, 1)));
  EXPECT_THAT(bytes.record.channels.at(0).values,
              ElementsAre(0, 1 / 128.0, -1 / 128.0, -0.5, -127 / 128.0));
}

TEST(Wav, FloatsAreAsTheyAre) {
  const std::string floats =
      Le(std::bit_cast<std::uint32_t>(-2.5F), 4) + Le(std::bit_cast<std::uint32_t>(1.0F), 4);
  const Recording single = Parsed(Wav(FormatOf({.tag = 3, .bits = 32}), floats));
  EXPECT_THAT(single.record.channels.at(0).values, ElementsAre(-2.5, 1));
  EXPECT_THAT(StatusesOf(single), ElementsAre(SampleStatus::kOk, SampleStatus::kOk));
  const std::string doubles =
      Le(std::bit_cast<std::uint64_t>(0.1), 8) + Le(std::bit_cast<std::uint64_t>(-1.0), 8);
  EXPECT_THAT(Parsed(Wav(FormatOf({.tag = 3, .bits = 64}), doubles)).record.channels.at(0).values,
              ElementsAre(0.1, -1));
}

// the ends of a converter of n bits are -1 and 1 - 2^(1 - n)
TEST(Wav, EitherEndOfTheConverterIsClipped) {
  using enum SampleStatus;
  const auto statuses = [](int bytes, const std::vector<std::int64_t>& counts) {
    const Form form{.bits = static_cast<std::uint16_t>(8 * bytes)};
    return StatusesOf(Parsed(Wav(FormatOf(form), Samples(counts, bytes))));
  };
  EXPECT_THAT(statuses(1, {0, 1, 254, 255}), ElementsAre(kClipped, kOk, kOk, kClipped));
  EXPECT_THAT(statuses(2, {-32768, -32767, 32766, 32767}),
              ElementsAre(kClipped, kOk, kOk, kClipped));
  EXPECT_THAT(statuses(3, {-8388608, -8388607, 8388606, 8388607}),
              ElementsAre(kClipped, kOk, kOk, kClipped));
  EXPECT_THAT(statuses(4, {-2147483648, -2147483647, 2147483646, 2147483647}),
              ElementsAre(kClipped, kOk, kOk, kClipped));
}

TEST(Wav, TheExtensibleFormSaysHowManyBitsHoldASample) {
  using enum SampleStatus;
  // 24 bits at the upper end of 32: the last count below full scale is (2^23 - 1) 2^8
  const std::string samples = Samples({8388607LL << 8, 8388606LL << 8, -8388608LL << 8, 256}, 4);
  const Recording read = Parsed(Wav(Extensible({.bits = 32}, 24, 1), samples));
  EXPECT_THAT(StatusesOf(read), ElementsAre(kClipped, kOk, kClipped, kOk));
  EXPECT_EQ(read.record.channels[0].values[3], 0x1p-23);
  // of 32 bits that count is one of many below the end
  for (const int valid : {32, 0, 40}) {
    EXPECT_THAT(StatusesOf(Parsed(
                    Wav(Extensible({.bits = 32}, static_cast<std::uint16_t>(valid), 1), samples))),
                ElementsAre(kOk, kOk, kClipped, kOk));
  }
  EXPECT_THAT(ErrorOf(Wav(Extensible({.bits = 32}, 32, 6), samples)), HasSubstr("neither PCM"));
}

// the GUID that holds the coding begins at byte 24 of the format
TEST(Wav, AnExtensibleFormWithoutItsGuidIsNotRead) {
  const std::string whole = Extensible({.bits = 16}, 16, 1);
  const std::string data = Chunk("data", Samples({1, 2}, 2));
  EXPECT_EQ(Parsed(Riff(Chunk("fmt ", whole.substr(0, 26)) + data)).record.rows, 2U);
  // what stands behind the format begins as the GUID of PCM does
  const std::string other = Chunk(std::string("\1\0xx", 4), "abcd");
  EXPECT_THAT(ErrorOf(Riff(Chunk("fmt ", whole.substr(0, 24)) + other + data)),
              HasSubstr("neither PCM"));
}

TEST(Wav, AFormatThatContradictsItselfIsNotRead) {
  const std::string samples = Samples({1, 2, 3, 4}, 2);
  for (const Form& form : {Form{.bits = 12},
                           {.bits = 40},
                           {.tag = 3, .bits = 16},
                           {.tag = 2},
                           {.channels = 0},
                           {.rate_hz = 0},
                           {.row_bytes = 4}}) {
    EXPECT_THAT(ErrorOf(Wav(FormatOf(form), samples)), HasSubstr("neither PCM"))
        << form.tag << " " << form.bits << " " << form.channels << " " << form.rate_hz;
  }
  EXPECT_THAT(ErrorOf(Wav(FormatOf({}).substr(0, 15), samples)), HasSubstr("neither PCM"));
}

TEST(Wav, ChannelsFollowEachOtherInARow) {
  const Form form{.channels = 3, .rate_hz = 48'000};
  const Recording read = Parsed(Wav(FormatOf(form), Samples({1, 2, 3, 4, 5, 6, 7}, 2)));
  const Record& record = read.record;
  ASSERT_EQ(record.channels.size(), 3U);
  EXPECT_EQ(record.rows, 2U) << "of the last row a part is there";
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(record.channels[c].name, fmt::format("channel_{}", c + 1));
    EXPECT_EQ(record.channels[c].values[1], static_cast<double>(c + 4) / 32'768);
  }
  EXPECT_EQ(record.stretches.at(0).rate_hz, 48'000);
  EXPECT_EQ(record.stretches[0].start_s, 0);
}

// --- chunks --------------------------------------------------------------------------------------

TEST(Wav, OtherChunksArePassedOverWithTheirPadding) {
  const std::string format = Chunk("fmt ", FormatOf({.bits = 8}));
  const std::string data = Chunk("data", Samples({130, 131, 132}, 1));
  const Recording read = Parsed(Riff(Chunk("junk", "abc") + format + Chunk("LIST", "INFOx") + data +
                                     Chunk("data", Samples({1, 1, 1, 1}, 1))));
  EXPECT_THAT(read.record.channels.at(0).values, ElementsAre(2 / 128.0, 3 / 128.0, 4 / 128.0))
      << "of the first chunk of data";
}

// the header's number of bytes of samples, against those that are there
std::string Stating(std::uint32_t bytes) {
  return Riff(Chunk("fmt ", FormatOf({})) + "data" + Le(bytes, 4) + Samples({1, 2, 3, 4}, 2));
}

TEST(Wav, SamplesThatAreMissingAreADoubt) {
  const auto found = [](std::uint32_t bytes) {
    return tests::NumbersOf(Parsed(Stating(bytes)).report.findings, FindingKind::kStatedRowsDiffer);
  };
  EXPECT_EQ(found(8), "none");
  EXPECT_EQ(found(9), "none") << "a part of a row";
  EXPECT_EQ(found(10), "stated_rows=5 rows=4");
  EXPECT_EQ(found(0xffff'feff), "stated_rows=2147483519 rows=4");
  // what programs write that do not know the length
  EXPECT_EQ(found(0xffff'ff00), "none");
  EXPECT_EQ(found(0xffff'ffff), "none");
  EXPECT_EQ(found(0), "none");
  EXPECT_EQ(Parsed(Stating(0)).record.rows, 4U);
}

// a chunk of data without a length is the rest of the file, unless a whole chunk follows it
TEST(Wav, DataOfNoLengthEndAtAWholeChunk) {
  const auto error_of = [](const std::string& behind) {
    return ErrorOf(Riff(Chunk("fmt ", FormatOf({})) + "data" + Le(0, 4) + behind));
  };
  constexpr const char* kNone = "holds 0 rows";
  // the names of chunks are letters, digits and blanks
  for (const char c : {' ', '0', '9', 'A', 'Z', 'a', 'z'}) {
    EXPECT_THAT(error_of(std::string("ab1") + c + Le(4, 4) + "wxyz"), HasSubstr(kNone)) << c;
    EXPECT_THAT(error_of(c + std::string("ab1") + Le(4, 4) + "wxyz"), HasSubstr(kNone)) << c;
  }
  for (const char c : {'\x1f', '!', '/', ':', '@', '[', '`', '{', '\0', '\xe9'}) {
    EXPECT_EQ(error_of(std::string("ab1") + c + Le(4, 4) + "wxyz"), "was read") << c;
  }
  // a chunk is all there
  EXPECT_THAT(error_of("abcd" + Le(0, 4)), HasSubstr(kNone));
  EXPECT_EQ(error_of("abcd" + Le(5, 4) + "wxyz"), "was read");
  EXPECT_EQ(error_of("abcd" + std::string(3, '\0')), "was read") << "seven bytes are no chunk";
  EXPECT_EQ(
      Parsed(Riff(Chunk("fmt ", FormatOf({})) + "data" + Le(0, 4) + "abcd" + std::string(3, '\0')))
          .record.rows,
      3U);
}

// rows of no samples: the columns are not made
TEST(Wav, TwiceTheColumnsOfATableAreTheMost) {
  EXPECT_THAT(ErrorOf(Wav(FormatOf({.bits = 8, .channels = 8192}), "")),
              HasSubstr("f.wav: holds 0 rows"));
  EXPECT_THAT(ErrorOf(Wav(FormatOf({.bits = 8, .channels = 8193}), "")), HasSubstr("neither PCM"));
}

// --- exports -------------------------------------------------------------------------------------

struct Own {
  std::string offsets = "[0.5]";
  int channels = 1;  // of the header
  std::string statuses{};
};

// two samples 0.25 and -0.25 of a displacement in m, with the list of this program
std::string Export(const Own& own) {
  TrialHeader header;
  ChannelFormat channel;
  channel.name = "laser";
  channel.role = ChannelRole::kDisplacement;
  channel.unit = "m";
  header.rate_hz = 4;
  header.channels.assign(static_cast<std::size_t>(own.channels), channel);
  const std::string description = fmt::format(
      R"({{"header":{},"events":[],"remarks":[],"stretches":[[0,2,0,4,0]],"closed":true,)"
      R"("times_are_known":false,"sample_offsets":{}}})",
      HeaderToJson(header), own.offsets);
  std::string list = "hapt" + Chunk("desc", description);
  if (!own.statuses.empty()) list += Chunk("stat", own.statuses);
  return Riff(Chunk("fmt ", FormatOf({})) + Chunk("data", Samples({8192, -8192}, 2)) +
              Chunk("LIST", list));
}

TEST(WavExports, AnOffsetIsAddedToItsChannel) {
  using enum SampleStatus;
  const Recording read = Parsed(Export({}));
  EXPECT_TRUE(read.report.is_export);
  EXPECT_THAT(read.record.channels.at(0).values, ElementsAre(0.75, 0.25));
  EXPECT_THAT(StatusesOf(read), ElementsAre(kOk, kOk)) << "where none are stated";
  EXPECT_THAT(StatusesOf(Parsed(Export({.statuses = {1, 0}}))), ElementsAre(kRepeated, kOk));
  EXPECT_THAT(ErrorOf(Export({.statuses = {1, 0, 0}})),
              HasSubstr("its displacement_m_status has another length"));
}

TEST(WavExports, TheHeaderAndTheOffsetsAreOfTheSamples) {
  EXPECT_THAT(ErrorOf(Export({.channels = 2})),
              HasSubstr("f.wav: its header_json is not that of its samples"));
  EXPECT_THAT(ErrorOf(Export({.channels = 0})), HasSubstr("is not that of its samples"));
  for (const char* offsets : {"[]", "[0.5, 0.5]"}) {
    EXPECT_THAT(ErrorOf(Export({.offsets = offsets})),
                HasSubstr("f.wav: its sample_offsets are not its own"));
  }
}

}  // namespace
}  // namespace haptometer::trial
