// Of CRCs the oracle is zlib, and the check value that every catalogue has.
#include "trial/byte_io.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "base/instruction_set.h"
#include "tests/trial/trial_file.h"
#include "trial/block.h"

namespace haptometer::trial {
namespace {

std::uint32_t ByZlib(std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

TEST(Crc32, OfTheNineDigits) { EXPECT_EQ(Crc32(BytesOfText("123456789")), 0xcbf4'3926U); }

std::vector<std::byte> RandomBytes(std::size_t size) {
  std::mt19937 random(1);
  std::vector<std::byte> bytes(size);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

TEST(Crc32, IsZlibsForEveryLengthAndPlace) {
  const std::vector<std::byte> bytes = RandomBytes(1000);
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

// each instruction set in a process of its own, because the environment is read once
TEST(Crc32DeathTest, IsZlibsWithEveryInstructionSet) {
  const std::string before = GTEST_FLAG_GET(death_test_style);
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  for (const InstructionSet set : kInstructionSets) {
    const std::string limit(Name(set));
    EXPECT_EXIT(
        {
          setenv("HAPTOMETER_INSTRUCTION_SET", limit.c_str(), 1);
          const std::vector<std::byte> bytes = RandomBytes(700);
          bool is_equal = UsableInstructionSet() <= set;
          for (std::size_t size = 0; size + 3 <= bytes.size(); ++size) {
            const auto part = std::span(bytes).subspan(3, size);
            is_equal = is_equal && Crc32(part) == ByZlib(part);
          }
          std::_Exit(is_equal ? 0 : 1);
        },
        testing::ExitedWithCode(0), "")
        << limit;
  }
  GTEST_FLAG_SET(death_test_style, before);
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
  // no file has this byte, and none of a negative number
  std::byte byte{};
  const auto refused = sources[0]->ReadAt(std::uint64_t{1} << 63, {&byte, 1});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().cause, Cause::kCannotAnswer);
  EXPECT_EQ(refused.error().Text(),
            path + ": cannot be read: " + std::strerror(EINVAL) + "; check the disk");
  EXPECT_EQ(sources[1]->ReadAt(std::uint64_t{1} << 63, {&byte, 1}).value(), 0U);
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
  EXPECT_EQ(told("empty/x"), std::strerror(ENOTDIR));
  EXPECT_EQ(OpenFileSource(directory.File("empty/x")).error().remedy, "check its permissions");
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

TEST(ByteSink, OfWhatCannotBeWrittenHasTheReasonOfTheSystem) {
  const ScratchDirectory directory;
  const auto folder = CreateFileSink(directory.File("."), IfExists::kReplace);
  ASSERT_FALSE(folder);
  EXPECT_EQ(folder.error().cause, Cause::kFailed);
  EXPECT_EQ(folder.error().what, std::string("cannot be written: ") + std::strerror(EISDIR));
  EXPECT_EQ(CreateFileSink(directory.File("."), IfExists::kRefuse).error().what, "already exists");
}

// a pipe has no size and no place: it is neither emptied, cut, synced nor looked for
TEST(ByteSink, OfAPipeHandsItsBytesToTheReader) {
  const ScratchDirectory directory;
  const std::string path = directory.File("pipe");
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  const int reader = open(path.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  auto sink = CreateFileSink(path, IfExists::kReplace);
  ASSERT_TRUE(sink) << sink.error().Text();
  std::filesystem::rename(path, directory.File("moved"));
  ASSERT_TRUE(WriteAll(sink->get(), BytesOfText("whole")));
  (*sink)->Keep();
  ASSERT_TRUE(WriteAll(sink->get(), BytesOfText("part")));
  (*sink)->CutToKept();
  EXPECT_TRUE((*sink)->Sync());
  EXPECT_EQ((*sink)->MovedTo(), "");
  std::string bytes(20, '?');
  EXPECT_EQ(read(reader, bytes.data(), bytes.size()), 9);
  EXPECT_TRUE(bytes.starts_with("wholepart?"));
  // without a reader the write fails
  close(reader);
  const auto before = std::signal(SIGPIPE, SIG_IGN);
  const auto failed = (*sink)->WriteSome(BytesOfText("more"));
  std::signal(SIGPIPE, before);
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().cause, Cause::kFailed);
  EXPECT_EQ(failed.error().what, std::strerror(EPIPE));
}

// another file stands at its former place
TEST(ByteSink, ThatIsMovedIsFoundBehindAnotherOfItsName) {
  const ScratchDirectory directory;
  const std::string path = directory.File("a"), other = directory.File("b");
  auto sink = CreateFileSink(path, IfExists::kRefuse);
  ASSERT_TRUE(sink);
  std::filesystem::rename(path, other);
  std::ofstream(path) << "another's";
  EXPECT_TRUE(std::filesystem::equivalent((*sink)->MovedTo(), other));
  ASSERT_TRUE(WriteAll(sink->get(), BytesOfText("ours")));
  EXPECT_EQ(std::filesystem::file_size(other), 4U);
  EXPECT_EQ(std::filesystem::file_size(path), 9U);
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
