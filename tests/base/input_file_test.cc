#include "base/input_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace haptometer {
namespace {

namespace fs = std::filesystem;

class InputFile : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(directory_); }
  void TearDown() override { fs::remove_all(directory_); }
  std::string Write(const std::string& name, const std::string& content) const {
    std::ofstream(directory_ / name, std::ios::binary) << content;
    return directory_ / name;
  }
  const fs::path directory_ =
      fs::path(::testing::TempDir()) / ("input_file_test_" + std::to_string(::getpid()));
};

TEST_F(InputFile, ContentComesBackByteForByte) {
  std::string content(200'001, '\0');  // more than three of the pieces in which it is read
  for (std::size_t i = 0; i < content.size(); ++i) content[i] = static_cast<char>(i * 7);
  const auto read = ReadInputFile(Write("a.bin", content));
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_EQ(*read, content);
}

TEST_F(InputFile, MissingDirectoryAndEmptyAreTold) {
  const std::string missing = directory_ / "none.csv";
  EXPECT_EQ(ReadInputFile(missing).error().Text(), missing + ": no such file; check the path");
  EXPECT_EQ(ReadInputFile(directory_).error().what, "is a directory");
  EXPECT_EQ(ReadInputFile(Write("empty", "")).error().what, "is empty");
  EXPECT_EQ(ReadInputFile(missing).error().cause, Cause::kCannotAnswer);
}

TEST_F(InputFile, WhatDoesNotOpenHasTheReasonOfTheSystem) {
  const Error error = ReadInputFile(directory_ / std::string(300, 'x')).error();
  EXPECT_EQ(error.cause, Cause::kCannotAnswer);
  EXPECT_EQ(error.what, std::strerror(ENAMETOOLONG));
  EXPECT_EQ(error.remedy, "check its permissions");
  const std::filesystem::path loop = directory_ / "loop";
  std::filesystem::create_symlink("loop", loop);
  EXPECT_EQ(ReadInputFile(loop).error().what, std::strerror(ELOOP));
  EXPECT_EQ(ReadInputFile(loop).error().remedy, "remove the link");
}

// the memory of this process: nothing is at its beginning
TEST_F(InputFile, ThatCannotBeReadIsNotTakenForAnEmptyOne) {
  if (!fs::exists("/proc/self/mem")) GTEST_SKIP() << "no such file on this system";
  const Error error = ReadInputFile("/proc/self/mem").error();
  ForgetInputs();
  EXPECT_EQ(error.Text(), "/proc/self/mem: could not be read to its end; check the disk");
}

TEST_F(InputFile, AFileThatTheCommandWroteIsForgotten) {
  ForgetInputs();  // those that other tests of this process read
  const std::string read = Write("read", "1"), written = Write("written", "2");
  for (const std::string& path : {read, written}) NoteInput(path);
  ForgetInput(directory_ / "none");
  ForgetInput(written);
  const auto noted = NotedInputs();
  ForgetInputs();
  ASSERT_EQ(noted.size(), 1U);
  EXPECT_EQ(noted.front().path, read);
}

TEST_F(InputFile, TooLargeIsRefusedBeforeMemoryRunsOut) {
  const std::string path = Write("large", std::string(2 << 20, 'x'));
  EXPECT_EQ(ReadInputFile(path, 1 << 20).error().what, "is larger than 1 MiB");
  EXPECT_EQ(ReadInputFile("/dev/zero", 1 << 20).error().what, "is larger than 1 MiB");
}

TEST_F(InputFile, OfExactlyTheLimitIsRead) {
  constexpr std::uint64_t kLimit = 200'000;
  EXPECT_TRUE(ReadInputFile(Write("at", std::string(kLimit, 'x')), kLimit));
  EXPECT_FALSE(ReadInputFile(Write("above", std::string(kLimit + 1, 'x')), kLimit));
}

TEST_F(InputFile, InputsAreNotedOnceAndInTheirOrder) {
  ForgetInputs();  // those that other tests of this process read
  const std::string first = Write("z", "1"), second = Write("a", "2"), third = Write("m", "3");
  fs::create_hard_link(first, directory_ / "link");
  NoteInput(first);
  NoteInput(second);
  NoteInput(directory_ / "link");  // the first file by another name
  NoteInput(directory_);           // no regular file
  NoteInput(third);
  const auto noted = NotedInputs();
  struct stat status{};
  ASSERT_EQ(stat((directory_ / "link").c_str(), &status), 0);
  EXPECT_TRUE(IsNotedInput(status));
  ForgetInputs();
  EXPECT_FALSE(IsNotedInput(status));
  ASSERT_EQ(noted.size(), 3U);
  EXPECT_EQ(noted[0].path, first);
  EXPECT_EQ(noted[1].path, second);
  EXPECT_EQ(noted[2].path, third);
}

}  // namespace
}  // namespace haptometer
