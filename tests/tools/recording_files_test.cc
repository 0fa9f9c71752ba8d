// Which files of a folder are recordings.
#include "tools/cli/recording_files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/temporary_files.h"

namespace haptometer::cli {
namespace {

class RecordingFiles : public tests::TemporaryFiles {
 protected:
  // a recording of this name, in folders that are made
  void Put(const std::string& name) const {
    std::filesystem::create_directories((directory_ / name).parent_path());
    (void)File(name, "time_s,displacement_m\n0,0\n1e-3,0\n");
  }
  std::vector<std::string> Found() const {
    std::vector<std::string> names;
    const auto files = RecordingsIn(directory_);
    if (!files) return {files.error().Text()};
    for (const RecordingFile& file : *files) {
      // not relative(), which follows links
      names.push_back(std::filesystem::path(file.path).lexically_relative(directory_));
    }
    return names;
  }
};

TEST_F(RecordingFiles, EndInAnyCaseAndLieInFolders) {
  Put("F0001CH1.CSV");
  Put("a/b/one.csv");
  Put("two.lvm");
  Put("notes.txt");
  EXPECT_EQ(Found(), (std::vector<std::string>{"F0001CH1.CSV", "a/b/one.csv", "two.lvm"}));
}

TEST_F(RecordingFiles, AreNotWhatIsHidden) {
  Put("one.csv");
  Put(".Trash-1000/files/old.csv");
  Put("a/._one.csv");
  EXPECT_EQ(Found(), std::vector<std::string>{"one.csv"});
}

TEST_F(RecordingFiles, AreListedOnceWhateverLinksLeadToThem) {
  Put("t1.csv");
  std::filesystem::create_symlink("t1.csv", directory_ / "latest.csv");
  EXPECT_EQ(Found(), std::vector<std::string>{"t1.csv"});
}

TEST_F(RecordingFiles, AreLinksThatLeadNowhereToo) {
  Put("one.csv");
  std::filesystem::create_symlink("loop.csv", directory_ / "loop.csv");
  std::filesystem::create_symlink("deleted.csv", directory_ / "lost.csv");
  EXPECT_EQ(Found(), (std::vector<std::string>{"loop.csv", "lost.csv", "one.csv"}))
      << "reading one of them tells that it is lost";
}

TEST_F(RecordingFiles, AreNotASubsetWhereAFolderCannotBeRead) {
  Put("one.csv");
  Put("locked/two.csv");
  const auto locked = directory_ / "locked";
  std::filesystem::permissions(locked, std::filesystem::perms::none);
  // the superuser reads every folder: as nobody
  const bool is_superuser = geteuid() == 0;
  if (is_superuser) {
    ASSERT_EQ(seteuid(65534), 0);
  }
  const auto files = RecordingsIn(directory_);
  if (is_superuser) {
    ASSERT_EQ(seteuid(0), 0);
  }
  std::filesystem::permissions(locked, std::filesystem::perms::owner_all);
  ASSERT_FALSE(files);
  EXPECT_TRUE(files.error().Text().contains("locked")) << files.error().Text();
}

}  // namespace
}  // namespace haptometer::cli
