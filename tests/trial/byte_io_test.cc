// Of CRCs the oracle is zlib, and the check value that every catalogue has.
#include "trial/byte_io.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <zlib.h>

#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "tests/trial/trial_file.h"
#include "trial/block.h"

namespace haptometer::trial {
namespace {

std::uint32_t ByZlib(std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

TEST(Crc32, OfTheNineDigits) { EXPECT_EQ(Crc32(BytesOfText("123456789")), 0xcbf4'3926U); }

TEST(Crc32, IsZlibsForEveryLengthAndPlace) {
  std::mt19937 random(1);
  std::vector<std::byte> bytes(1000);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  for (std::size_t size = 0; size <= 800; ++size) {
    for (const std::size_t first : {0U, 1U, 7U, 16U, 33U}) {
      const auto part = std::span(bytes).subspan(first, size);
      EXPECT_EQ(Crc32(part), ByZlib(part)) << size << " from " << first;
    }
  }
}

TEST(Crc32, IsZlibsForZerosOnesAndSingleBits) {
  for (const std::size_t size : {64U, 100U, 128U, 65'536U, 1'000'003U}) {
    std::vector<std::byte> bytes(size);
    EXPECT_EQ(Crc32(bytes), ByZlib(bytes)) << size;
    bytes[size / 3] = std::byte{0x10};
    EXPECT_EQ(Crc32(bytes), ByZlib(bytes)) << size;
    bytes.assign(size, std::byte{0xff});
    EXPECT_EQ(Crc32(bytes), ByZlib(bytes)) << size;
  }
}

TEST(ByteSource, GivesWhatThereIsBehindTheOffset) {
  const ScratchDirectory directory;
  const std::string path = directory.File("ten");
  std::ofstream(path) << "0123456789";
  auto file = OpenFileSource(path);
  ASSERT_TRUE(file);
  std::vector<std::unique_ptr<ByteSource>> sources;
  sources.push_back(std::move(*file));
  sources.push_back(MakeMemorySource("0123456789"));
  for (const auto& source : sources) {
    EXPECT_EQ(source->size(), 10U);
    const auto read = [&](std::uint64_t offset, std::size_t size) {
      std::string bytes(size, '?');
      const auto got = source->ReadAt(offset, std::as_writable_bytes(std::span(bytes)));
      EXPECT_TRUE(got);
      return bytes.substr(0, got.value_or(0));
    };
    EXPECT_EQ(read(0, 10), "0123456789");
    EXPECT_EQ(read(3, 4), "3456");
    EXPECT_EQ(read(8, 4), "89");
    EXPECT_EQ(read(9, 1), "9");
    EXPECT_EQ(read(10, 4), "");
    EXPECT_EQ(read(99, 4), "");
    EXPECT_EQ(read(3, 0), "");
  }
}

TEST(ByteSource, OfWhatIsNoFileWithBytesIsRefused) {
  const ScratchDirectory directory;
  const auto told = [&](const std::string& name) {
    const auto source = OpenFileSource(directory.File(name));
    if (source) return std::string("opened");
    EXPECT_EQ(source.error().cause, Cause::kCannotAnswer);
    return source.error().what;
  };
  std::ofstream(directory.File("empty")) << "";
  ASSERT_EQ(mkfifo(directory.File("pipe").c_str(), 0600), 0);
  EXPECT_EQ(told("none"), "no such file");
  EXPECT_EQ(told("."), "is a directory");
  EXPECT_EQ(told("empty"), "is empty");
  EXPECT_EQ(told("pipe"), "is not a regular file") << "without waiting for its writer";
}

TEST(ByteSink, OfAPipeThatNobodyReadsIsRefused) {
  const ScratchDirectory directory;
  const std::string path = directory.File("pipe");
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  const auto refused = CreateFileSink(path, IfExists::kReplace);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().cause, Cause::kUsage);
  EXPECT_EQ(refused.error().what, "is a pipe that no program reads");
  EXPECT_EQ(OpenFileSinkAtEnd(directory.File("none")).error().cause, Cause::kCannotAnswer);
}

// what was appended since the last whole block goes
TEST(ByteSink, IsCutToWhatWasKept) {
  const ScratchDirectory directory;
  const std::string path = directory.File("sink");
  auto sink = CreateFileSink(path, IfExists::kRefuse);
  ASSERT_TRUE(sink);
  const auto content = [&] {
    std::ifstream file(path);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  ASSERT_TRUE(WriteAll(sink->get(), BytesOfText("whole")));
  (*sink)->Keep();
  ASSERT_TRUE(WriteAll(sink->get(), BytesOfText("part")));
  EXPECT_EQ(content(), "wholepart");
  (*sink)->CutToKept();
  EXPECT_EQ(content(), "whole");
  (*sink)->CutToKept();
  EXPECT_EQ(content(), "whole");
  ASSERT_TRUE(WriteAll(sink->get(), BytesOfText("!")));
  EXPECT_EQ(content(), "whole!");
  EXPECT_EQ((*sink)->MovedTo(), "");
}

}  // namespace
}  // namespace haptometer::trial
