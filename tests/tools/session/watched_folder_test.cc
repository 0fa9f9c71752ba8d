#include "tools/session/watched_folder.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <string>

#include "tools/document/provenance.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

constexpr MonotonicNs kComplete = 2 * kNsPerS;

class WatchedFolderTest : public ::testing::Test {
 protected:
  WatchedFolderTest() {
    folder_ = fs::path(::testing::TempDir()) /
              ::testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~WatchedFolderTest() override { fs::remove_all(folder_); }

  // a file of this time of modification
  void Write(const std::string& name, const std::string& text, std::int64_t modified_ns) const {
    std::ofstream(folder_ / name) << text;
    const timespec time{.tv_sec = modified_ns / kNsPerS, .tv_nsec = modified_ns % kNsPerS};
    const std::array<timespec, 2> both{time, time};
    ASSERT_EQ(utimensat(AT_FDCWD, (folder_ / name).c_str(), both.data(), 0), 0);
  }
  [[nodiscard]] FolderSource Source() const {
    return {.folder = folder_, .pattern = "*.csv", .unchanged_s = 2};
  }
  // the name of what is found; empty: nothing
  [[nodiscard]] std::string Found(WatchedFolder& folder, MonotonicNs now_ns) const {
    const auto found = folder.Examine(state_, now_ns);
    EXPECT_TRUE(found.has_value());
    return *found ? (*found)->file.name : "";
  }
  // a new a.csv is found and imported, and written again; what is found then
  [[nodiscard]] NewFile WrittenAgain(WatchedFolder& folder, const std::string& before,
                                     const std::string& after) {
    Write("a.csv", before, 100);
    EXPECT_EQ(Found(folder, 0), "");
    Import(folder, "a.csv", kComplete);
    Write("a.csv", after, 200);
    EXPECT_EQ(Found(folder, kComplete), "");
    const auto found = folder.Examine(state_, 2 * kComplete);
    EXPECT_TRUE(found.has_value());
    return *found ? **found : NewFile{};
  }
  void Import(WatchedFolder& folder, const std::string& name, MonotonicNs now_ns) {
    const auto found = folder.Examine(state_, now_ns);
    ASSERT_TRUE(found.has_value() && *found);
    ASSERT_EQ((*found)->file.name, name);
    state_.attempts.push_back({.cell = {"1", name, 1},
                               .file = name,
                               .verdict = SessionVerdict::kGood,
                               .origin = TextOf((*found)->file)});
  }

  fs::path folder_;
  SessionState state_;
};

TEST_F(WatchedFolderTest, AFileThatGrowsIsNotCompleteAndHoldsBackLaterOnes) {
  WatchedFolder folder(Source(), {});
  Write("b.csv", "1", 100);
  EXPECT_EQ(Found(folder, 0), "");
  EXPECT_EQ(folder.pending(), "b.csv is still changing");
  Write("b.csv", "12", 200);
  Write("a.csv", "1", 300);
  EXPECT_EQ(Found(folder, kComplete), "") << "changed since";
  Write("b.csv", "23", 200);
  EXPECT_EQ(Found(folder, 2 * kComplete - 1), "");
  EXPECT_EQ(Found(folder, 2 * kComplete), "b.csv") << "written before a.csv";
  EXPECT_EQ(folder.pending(), "");
}

TEST_F(WatchedFolderTest, AnEmptyFileIsNamedAndHoldsBackNone) {
  WatchedFolder folder(Source(), {});
  Write("a.csv", "", 100);
  EXPECT_EQ(Found(folder, 0), "");
  EXPECT_EQ(folder.pending(), "a.csv is empty");
  Write("b.csv", "1", 200);
  EXPECT_EQ(Found(folder, 0), "");
  EXPECT_EQ(folder.pending(), "b.csv is still changing");
  EXPECT_EQ(Found(folder, kComplete), "b.csv");
}

TEST_F(WatchedFolderTest, NeitherTheClockNorFilesThatWereThereCount) {
  Write("before.csv", "1", 100);
  Write("empty.csv", "", 100);
  Write("other.txt", "1", 100);
  Write(".hidden.csv", "1", 100);
  const auto files = FilesIn(Source());
  ASSERT_TRUE(files.has_value());
  ASSERT_EQ(files->size(), 2U);
  SessionPlan plan;
  plan.files_before = {TextOf((*files)[0])};
  WatchedFolder folder(Source(), plan);
  // of a time before: of a clock that was set back
  Write("new.csv", "1", 50);
  EXPECT_EQ(Found(folder, 0), "");
  EXPECT_EQ(Found(folder, kComplete), "new.csv");
  Import(folder, "new.csv", kComplete);
  EXPECT_EQ(Found(folder, 3 * kComplete), "");
  // written over: another file
  Write("before.csv", "2", 400);
  EXPECT_EQ(Found(folder, 3 * kComplete), "");
  EXPECT_EQ(Found(folder, 4 * kComplete), "before.csv");
}

TEST_F(WatchedFolderTest, EachFileIsFoundOnceByItsContent) {
  WatchedFolder folder(Source(), {});
  EXPECT_EQ(WrittenAgain(folder, "1", "1").file.name, "") << "touched: of the same content";
  EXPECT_EQ(folder.pending(), "");
  // the same content under another name is another file
  Write("b.csv", "1", 600);
  EXPECT_EQ(Found(folder, 3 * kComplete), "");
  Import(folder, "b.csv", 4 * kComplete);
  // an attempt that did not end imported nothing
  state_.attempts.back().verdict.reset();
  EXPECT_EQ(Found(folder, 4 * kComplete), "b.csv");
}

TEST_F(WatchedFolderTest, AFileThatContinuesIsOfTheSameCell) {
  WatchedFolder folder(Source(), {});
  EXPECT_EQ(WrittenAgain(folder, "12", "123").continued, (SessionCell{"1", "a.csv", 1}));
  Write("a.csv", "223", 300);
  EXPECT_EQ(Found(folder, 2 * kComplete), "");
  const auto other = folder.Examine(state_, 3 * kComplete);
  ASSERT_TRUE(other.has_value() && *other);
  EXPECT_EQ((*other)->continued, std::nullopt) << "another content";
}

TEST_F(WatchedFolderTest, TextsOfFilesAreReadAsTheyAreWritten) {
  for (const FolderFile& file :
       {FolderFile{"run 1, b.csv", 12, 345, std::string(64, 'a')}, FolderFile{"x", 0, -1, ""},
        FolderFile{"SHA-256 x, 1 bytes, modified 2, y", ~0ULL, 1LL << 62, ""}}) {
    const auto read = ReadFolderFile(TextOf(file));
    ASSERT_TRUE(read.has_value()) << TextOf(file);
    EXPECT_EQ(TextOf(*read), TextOf(file));
    EXPECT_EQ(read->name, file.name);
  }
  for (const char* wrong : {"", "a.csv", "1 bytes, modified 2, ", "-1 bytes, modified 2, a",
                            "1 bytes, modified x, a", "SHA-256 ab, 1 bytes, modified 2, a"}) {
    EXPECT_FALSE(ReadFolderFile(wrong)) << wrong;
  }
}

TEST_F(WatchedFolderTest, TheHashIsThatOfTheFirstBytes) {
  Write("a.csv", "abcdef", 100);
  Write("b.csv", "abc", 100);
  // FIPS 180-4, example of "abc"
  const std::string abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
  EXPECT_EQ(document::Sha256Of(folder_ / "b.csv"), abc);
  EXPECT_EQ(document::Sha256Of(folder_ / "a.csv", 3), abc);
  EXPECT_EQ(document::Sha256Of(folder_ / "b.csv", 4), "") << "it is shorter";
}

TEST_F(WatchedFolderTest, AFolderThatIsGoneIsAnError) {
  fs::remove_all(folder_);
  WatchedFolder folder(Source(), {});
  EXPECT_FALSE(folder.Examine(state_, 0).has_value());
}

}  // namespace
}  // namespace haptometer::tools
