#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/tools/sweep_verb.h"

namespace haptometer::tools {
namespace {

using ::testing::HasSubstr;

TEST_F(SweepVerb, WritesTheSameBytesWithAnyThreads) {
  for (const auto& words : {kGrid, kSampled}) {
    const std::string one = Table(words, "one.csv", {"--threads", "1", "--overwrite"});
    for (const char* threads : {"2", "7"}) {
      EXPECT_EQ(Table(words, "more.csv", {"--threads", threads, "--overwrite"}), one);
    }
  }
}

TEST_F(SweepVerb, MergesShardsToTheBytesOfOneRun) {
  for (const auto& words : {kGrid, kSampled}) {
    const std::string whole = Table(words, "whole.csv", {"--overwrite"});
    for (const std::size_t shards : {1U, 2U, 3U, 4U, 5U, 6U, 7U, 41U}) {
      std::vector<std::string> merge{"--merge"};
      for (std::size_t k = shards; k > 0; --k) {  // in whatever order
        const std::string name = "s" + std::to_string(k) + ".csv";
        const std::string shard = std::to_string(k) + "/" + std::to_string(shards);
        const std::string table = Table(words, name, {"--shard", shard, "--overwrite"});
        EXPECT_EQ(RowsOf(table).size(), (RowsOf(whole).size() + shards - k) / shards);
        merge.push_back(Path(name));
      }
      EXPECT_EQ(Table(merge, "merged.csv", {"--overwrite"}), whole) << shards << " shards";
    }
  }
}

// in the rows every other byte and both sides of each line end, in the header every 31st: each run
// waits for the disk
TEST_F(SweepVerb, GoesOnFromAnyByteToTheSameBytes) {
  const std::vector<std::string> words{kCone, "--vary", "drive.frequency_hz=200:210:3"};
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--overwrite"}, {"--overwrite", "--shard", "2/2"}}) {
    const std::string whole = Table(words, "whole.csv", more);
    std::vector<std::string> resumed = more;
    resumed.front() = "--resume";
    const std::size_t rows = whole.find("row_crc32\n");
    for (std::size_t length = 0; length <= whole.size(); ++length) {
      const bool is_at_line_end = whole[std::min(length, whole.size() - 1)] == '\n' ||
                                  (length > 0 && whole[length - 1] == '\n');
      if (!is_at_line_end && length % (length < rows ? 31 : 2) != 0) continue;
      (void)File("cut.csv", whole.substr(0, length));
      ASSERT_EQ(Table(words, "cut.csv", resumed), whole) << "cut behind " << length << " bytes";
    }
  }
  EXPECT_EQ(Table(words, "new.csv", {"--resume"}), Table(words, "whole.csv", {"--overwrite"}));
}

// a header that ends within the provenance, of another command
TEST_F(SweepVerb, GoesOnFromWithinTheProvenance) {
  const std::vector<std::string> words{kCone, "--vary", "drive.frequency_hz=200:210:3"};
  const std::string whole = Table(words, "whole.csv");
  const std::string file = TemporaryFiles::Content("whole.csv");
  const std::size_t begin = file.find(kProvenance);
  const std::size_t end = file.find("point,", begin) + 20;
  ASSERT_LT(end, file.size());
  for (std::size_t length = begin; length < end; length += 17) {
    (void)File("cut.csv", file.substr(0, length));
    ASSERT_EQ(Table(words, "cut.csv", {"--resume"}), whole) << "cut behind " << length << " bytes";
  }
}

TEST_F(SweepVerb, GoesOnOnlyWithItsOwnTable) {
  const std::string whole = Table(kGrid, "t.csv");
  const auto refused = [&](std::vector<std::string> words, const std::vector<std::string>& more,
                           const std::string& said) {
    std::vector<std::string> resumed{"--resume"};
    resumed.insert(resumed.end(), more.begin(), more.end());
    const Outcome outcome = Sweep(std::move(words), "t.csv", resumed);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("t.csv: "));
    EXPECT_THAT(outcome.err, HasSubstr(said));
  };
  std::vector<std::string> finer = kGrid;
  finer[2] = "drive.frequency_hz=200Hz:250Hz:21";
  refused(finer, {},
          "was begun with 'vary = drive.frequency_hz=200:250:11', not 'vary = "
          "drive.frequency_hz=200:250:21'");
  std::vector<std::string> other_scene = kGrid;
  other_scene[0] = File("lra_adapter.toml", [] {
    std::ifstream file(kAdapter);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    return text + "[run]\nstart = 'rest'\n";
  }());
  refused(other_scene, {}, "was begun with 'scene_digest = ");
  refused(kSampled, {}, "was begun with 'vary = ");
  refused(kGrid, {"--shard", "1/2"}, "was begun with no --shard, not 1/2");
  EXPECT_EQ(Content("t.csv"), whole);

  // rows that it would not write: of another length, a cell too few, one row too many
  const std::string value = std::string(whole).replace(whole.find("\n5,205,"), 7, "\n5,2061,");
  const std::string last = whole.substr(whole.rfind('\n', whole.size() - 2) + 1);
  for (const auto& [edited, row] :
       {std::pair(value, "row 5 was changed and has another length"),
        std::pair(whole + last, "row 34 is not what this sweep makes"),
        std::pair(whole.substr(0, whole.size() - last.size()) + "33,250,2000,1\n",
                  "row 33 was changed and has another length")}) {
    (void)File("t.csv", edited);
    refused(kGrid, {}, row);
    EXPECT_EQ(Content("t.csv"), edited);
  }
  (void)File("t.csv", "time_s,voltage_v\n1,2\n");
  const Outcome foreign = Sweep(kGrid, "t.csv", {"--resume"});
  EXPECT_EQ(foreign.status, 3);
  EXPECT_THAT(foreign.err, HasSubstr("t.csv: is not a table of haptometer sweep"));
}

// the table of a version that wrote no checksums
std::string WithoutChecksums(const std::string& table) {
  std::istringstream lines(table);
  std::string older;
  for (std::string line; std::getline(lines, line);) {
    older += line.starts_with('#') ? line : line.substr(0, line.rfind(','));
    older += '\n';
  }
  return older;
}

// any digit of any row: of a value, of a varied key, of the point, of the checksum itself
TEST_F(SweepVerb, ComputesARowAgainInWhichADigitChanged) {
  const std::string whole = Table(kGrid, "whole.csv");
  const std::size_t rows = whole.find("row_crc32\n") + 10;
  std::size_t tried = 0;
  for (std::size_t at = rows; at < whole.size(); at += 61) {
    const std::size_t digit = whole.find_first_of("0123456789", at);
    if (digit == std::string::npos) break;
    std::string changed = whole;
    changed[digit] = changed[digit] == '7' ? '3' : '7';
    (void)File("t.csv", changed);
    const Outcome outcome = Sweep(kGrid, "t.csv", {"--resume"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("doubt: 1 row did not match the row checksum"));
    ASSERT_EQ(Content("t.csv"), whole) << "byte " << digit;
    ++tried;
  }
  EXPECT_GT(tried, 60U);
}

TEST_F(SweepVerb, ComputesAllChangedRowsAgainBeforeItGoesOn) {
  const std::string whole = Table(kGrid, "whole.csv");
  std::string changed = whole.substr(0, whole.find("\n21,"));
  for (const char* row : {"\n3,", "\n11,", "\n20,"}) {
    char& digit = changed[changed.find("e-05", changed.find(row)) - 3];
    digit = digit == '4' ? '5' : '4';
  }
  (void)File("t.csv", changed + "\n21,22");
  const Outcome outcome = Sweep(kGrid, "t.csv", {"--resume"});
  EXPECT_THAT(outcome.out, HasSubstr("doubt: 3 rows did not match the row checksum"));
  EXPECT_EQ(Content("t.csv"), whole);
}

TEST_F(SweepVerb, MergesNoRowInWhichADigitChanged) {
  (void)Table(kSampled, "1.csv", {"--shard", "1/2"});
  std::string second = Table(kSampled, "2.csv", {"--shard", "2/2"});
  char& digit = second[second.find("e-05", second.find("\n14,")) - 3];
  digit = digit == '4' ? '5' : '4';
  (void)File("2.csv", second);
  const Outcome outcome = Sweep({"--merge", Path("1.csv"), Path("2.csv")}, "whole.csv");
  EXPECT_EQ(outcome.status, 3) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("holds a row that was changed or is none: '14,"));
}

// rows behind a line that is too long for a row are not cut off
TEST_F(SweepVerb, RefusesATableWithALineOfMegabytes) {
  const std::string whole = Table(kGrid, "whole.csv");
  const std::size_t third = whole.find("\n3,") + 1;
  const std::string table =
      whole.substr(0, third) + std::string(1'300'000, 'x') + "\n" + whole.substr(third);
  (void)File("t.csv", table);
  const Outcome outcome = Sweep(kGrid, "t.csv", {"--resume"});
  EXPECT_EQ(outcome.status, 2) << outcome.err;
  EXPECT_EQ(Content("t.csv"), table);
}

TEST_F(SweepVerb, ReadsNoTableWithoutChecksums) {
  (void)File("t.csv", WithoutChecksums(Table(kGrid, "whole.csv")));
  for (const Outcome& outcome :
       {Sweep(kGrid, "t.csv", {"--resume"}), Sweep({"--merge", Path("t.csv")}, "merged.csv")}) {
    EXPECT_EQ(outcome.status, 3);
    EXPECT_THAT(outcome.err, HasSubstr("was made by an older version, without checksums"));
  }
}

TEST_F(SweepVerb, ReplacesATableOnlyWhereItIsToldTo) {
  (void)File("t.csv", "the only copy\n");
  const Outcome outcome = Sweep(kGrid, "t.csv");
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr("already exists; continue it with --resume"));
  EXPECT_EQ(Content("t.csv"), "the only copy\n");
  // and no file of another kind
  EXPECT_THAT(Sweep(kGrid, "t.csv", {"--overwrite"}).err, HasSubstr("is not a sweep's table"));
  EXPECT_EQ(Content("t.csv"), "the only copy\n");
  EXPECT_EQ(RowsOf(Table(kGrid, "u.csv", {})).size(), 33U);
  EXPECT_EQ(
      RowsOf(Table({kCone, "--vary", "drive.amplitude_v=1,2"}, "u.csv", {"--overwrite"})).size(),
      2U);
}

TEST_F(SweepVerb, RefusesWhatMakesNoWhole) {
  const auto shard = [&](const std::string& name, const std::string& part,
                         const std::string& seed) {
    std::vector<std::string> words = kSampled;
    words.back() = seed;
    return Table(words, name, {"--shard", part});
  };
  const std::string second = shard("2.csv", "2/3", "7");
  (void)shard("1.csv", "1/3", "7");
  (void)shard("3.csv", "3/3", "7");
  (void)shard("other.csv", "3/3", "8");
  (void)shard("half.csv", "1/2", "7");
  (void)File("cut.csv", second.substr(0, second.size() - 5));
  (void)File("short.csv", second.substr(0, second.rfind('\n', second.size() - 2) + 1));
  (void)File("header.csv", second.substr(0, 80));
  const auto refused = [&](const std::vector<std::string>& names, int status,
                           const std::string& said) {
    std::vector<std::string> words{"--merge"};
    for (const std::string& name : names) words.push_back(Path(name));
    const Outcome outcome = Sweep(words, "whole.csv");
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(said));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1);
    EXPECT_FALSE(std::filesystem::exists(Path("whole.csv")));
  };
  refused({"1.csv", "3.csv"}, 3, "point 2 of 40 is in none of the tables");
  refused({"2.csv", "3.csv"}, 3, "point 1 of 40 is in none");
  refused({"1.csv", "short.csv", "3.csv"}, 3, "point 38 of 40 is in none");
  refused({"1.csv", "2.csv", "3.csv", "2.csv"}, 2, "holds point 2, which ");
  refused({"half.csv", "2.csv", "3.csv", "1.csv"}, 2, "holds point 1, which ");
  refused({"1.csv", "2.csv", "other.csv"}, 2,
          "'sampling = latin hypercube, 40 samples, seed 8', not 'sampling");
  refused({"1.csv", "cut.csv", "3.csv"}, 3,
          "cut.csv: ends within a row; continue it with --resume");
  refused({"1.csv", "header.csv"}, 3, "header.csv: is not a table of haptometer sweep");
  refused({"1.csv", "none.csv"}, 3, "none.csv: no such file");
}

}  // namespace
}  // namespace haptometer::tools
