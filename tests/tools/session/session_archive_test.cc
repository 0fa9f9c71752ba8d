#include "tools/session/session_archive.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "trial/block.h"

namespace haptometer::tools {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using Contents = std::vector<std::pair<std::string, std::string>>;

PackList ListOfContents(const Contents& contents) {
  PackList list{.version = "1.2", .session = "day1", .utc = "2026-11-26T00:00:00Z", .files = {}};
  for (const auto& [name, content] : contents) {
    document::Sha256 sha256;
    sha256.Add(content);
    list.files.push_back(
        {name, content.size(), trial::Crc32(trial::BytesOfText(content)), sha256.Hex()});
  }
  return list;
}

std::string ArchiveOf(const Contents& contents) {
  const ArchiveLayout layout = LayoutOf(ListOfContents(contents));
  std::string bytes = layout.parts[0].header + layout.list;
  for (std::size_t k = 0; k < contents.size(); ++k) {
    bytes += layout.parts[k + 1].header + contents[k].second;
  }
  return bytes + layout.directory;
}

Result<CheckedArchive> Check(const std::string& bytes) {
  return CheckArchive(*trial::MakeMemorySource(bytes), "day1.zip");
}

std::vector<std::string> KindsOf(const CheckedArchive& checked) {
  std::vector<std::string> kinds;
  for (const auto& finding : checked.findings.list()) {
    kinds.push_back(finding.subject + ": " + std::string(SentenceOf(finding.kind).kind));
  }
  return kinds;
}

Contents Sample() {
  std::mt19937 draw(4);
  std::string noise(3000, '\0');
  for (char& c : noise) c = static_cast<char>(draw() & 0xffU);
  return {{"log.csv", "utc,event\n"},
          {"session.toml", "subjects = 1\n"},
          {"trials/ä.bin", noise},
          {"trials/empty.bin", ""}};
}

TEST(PackList, IsReadAsItWasWritten) {
  const std::string text = TextOf(ListOfContents(Sample()));
  const auto list = ReadPackList(text);
  ASSERT_TRUE(list);
  EXPECT_EQ(TextOf(*list), text);
  EXPECT_EQ(list->session, "day1");
  ASSERT_EQ(list->files.size(), 4U);
  EXPECT_EQ(list->files[2].name, "trials/ä.bin");
  EXPECT_EQ(list->files[2].bytes, 3000U);
}

TEST(PackList, RefusesNamesThatLeaveTheFolderAndRepeatedOnes) {
  for (const char* name : {"../x", "/etc/passwd", "a/../b", "a//b", "a/", "./a", "C:x", "a\\b", "",
                           "a\nb", "SHA256SUMS", "log.csv"}) {
    EXPECT_FALSE(ReadPackList(TextOf(ListOfContents({{"log.csv", "x"}, {name, "y"}})))) << name;
  }
}

// each byte of the archive on its own, changed in one bit and in all
TEST(CheckArchive, NamesEveryChangedByte) {
  const Contents contents = Sample();
  const std::string archive = ArchiveOf(contents);
  ASSERT_THAT(KindsOf(*Check(archive)), IsEmpty());
  const ArchiveLayout layout = LayoutOf(ListOfContents(contents));
  for (std::size_t at = 0; at < archive.size(); ++at) {
    for (const int change : {0x01, 0x80, 0xff}) {
      std::string changed = archive;
      changed[at] = static_cast<char>(changed[at] ^ change);
      const auto checked = Check(changed);
      ASSERT_TRUE(checked) << at << ": " << checked.error().Text();
      ASSERT_EQ(checked->findings.list().size(), 1U) << at;
      const auto& finding = checked->findings.list()[0];
      // where the byte lies: in which part, and in its header or its content
      std::string part = "directory of the archive";
      std::size_t place = at;
      for (std::size_t k = 0; k < layout.parts.size(); ++k) {
        const std::size_t bytes = k == 0 ? layout.list.size() : contents[k - 1].second.size();
        const std::size_t begin = layout.parts[k].content_at;
        if (at >= layout.parts[k].header_at && at < begin)
          part = "header of " + layout.parts[k].name;
        if (at < begin || at >= begin + bytes) continue;
        part = layout.parts[k].name;
        place = at - begin;
      }
      EXPECT_EQ(finding.subject, part) << at;
      EXPECT_THAT(document::WordsOf(finding), HasSubstr(fmt::format("byte {} of", place))) << at;
      EXPECT_THAT(document::WordsOf(finding),
                  HasSubstr(fmt::format("was 0x{:02x} and is 0x{:02x}",
                                        static_cast<unsigned char>(archive[at]),
                                        static_cast<unsigned char>(changed[at]))));
    }
  }
}

TEST(CheckArchive, NamesAFileThatWasChangedInSeveralBytes) {
  Contents contents = Sample();
  std::string archive = ArchiveOf(contents);
  const std::size_t at = archive.find(contents[2].second);
  archive.replace(at + 100, 4, "abcd");
  EXPECT_THAT(KindsOf(*Check(archive)), ElementsAre("trials/ä.bin: file-changed"));
}

TEST(CheckArchive, EveryCutIsFound) {
  const std::string archive = ArchiveOf(Sample());
  for (std::size_t bytes = 0; bytes < archive.size(); ++bytes) {
    const auto checked = Check(archive.substr(0, bytes));
    if (!checked) {
      EXPECT_LT(bytes, LayoutOf(ListOfContents(Sample())).parts[1].header_at) << bytes;
      continue;
    }
    EXPECT_THAT(KindsOf(*checked), Contains(": cut-short")) << bytes;
  }
}

// an archive whose directory another program wrote: the files of `contents` and others
std::string Repacked(const Contents& listed, const Contents& there, std::uint32_t mode = 0100644,
                     std::uint16_t method = 0) {
  Contents all = there;
  all.insert(all.begin(), {std::string(kPackListName), TextOf(ListOfContents(listed))});
  const ArchiveLayout layout = LayoutOf(ListOfContents(all));
  std::string bytes;
  std::string directory = layout.directory;
  const std::size_t list_bytes = layout.parts[1].header_at;
  for (std::size_t k = 0; k < all.size(); ++k) {
    bytes += layout.parts[k + 1].header + all[k].second;
  }
  // without the first file, which is the list of the repacked archive: 46 bytes and the name
  directory.erase(0, 46 + kPackListName.size());
  std::size_t at = 0;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const std::uint32_t header_at =
        static_cast<std::uint32_t>(layout.parts[k + 1].header_at - list_bytes);
    if (k > 0) {
      const std::uint32_t attributes = mode << 16U;
      std::copy_n(reinterpret_cast<const char*>(&attributes), 4,
                  directory.begin() + static_cast<long>(at) + 38);
      std::copy_n(reinterpret_cast<const char*>(&method), 2,
                  directory.begin() + static_cast<long>(at) + 10);
    }
    std::copy_n(reinterpret_cast<const char*>(&header_at), 4,
                directory.begin() + static_cast<long>(at) + 42);
    at += 46 + all[k].first.size();
  }
  const auto size = static_cast<std::uint32_t>(at);
  std::copy_n(reinterpret_cast<const char*>(&size), 4,
              directory.begin() + static_cast<long>(at) + 12);
  // a comment, so that it is not of the size that was written
  std::string comment = "x";
  directory[directory.size() - 2] = 1;
  return bytes + directory + comment;
}

TEST(CheckArchive, NamesWhatWasAddedAndWhatIsMissing) {
  const Contents listed{{"log.csv", "a"}, {"session.toml", "b"}};
  EXPECT_THAT(KindsOf(*Check(Repacked(listed, {{"log.csv", "a"}}))),
              ElementsAre("session.toml: file-missing"));
  EXPECT_THAT(
      KindsOf(*Check(Repacked(listed, {{"log.csv", "a"}, {"session.toml", "b"}, {"more", "c"}}))),
      ElementsAre("more: file-added"));
  EXPECT_THAT(KindsOf(*Check(Repacked(listed, listed))), ElementsAre(": other-size"));
  EXPECT_THAT(KindsOf(*Check(Repacked(listed, {{"log.csv", "a"}, {"session.toml", "c"}}))),
              ElementsAre("session.toml: byte-changed"));
  EXPECT_THAT(KindsOf(*Check(
                  Repacked(listed, {{"log.csv", "a"}, {"log.csv", "a"}, {"session.toml", "b"}}))),
              ElementsAre("log.csv: named-twice"));
}

TEST(CheckArchive, NamesWhatAHostileArchiveHolds) {
  const Contents listed{{"log.csv", "a"}};
  EXPECT_THAT(KindsOf(*Check(Repacked(listed, {{"log.csv", "a"}, {"../x", "c"}}))),
              ElementsAre("../x: unsafe-name"));
  EXPECT_THAT(KindsOf(*Check(Repacked(listed, {{"log.csv", "a"}, {"/etc/x", "c"}}))),
              ElementsAre("/etc/x: unsafe-name"));
  // a link in the place of a file, and one that was deflated
  const auto linked = Check(Repacked(listed, {{"log.csv", "a"}}, 0120777));
  EXPECT_THAT(KindsOf(*linked), ElementsAre("log.csv: no-file"));
  EXPECT_THAT(linked->places, IsEmpty());
  EXPECT_THAT(KindsOf(*Check(Repacked(listed, {{"log.csv", "a"}}, 0100644, 8))),
              ElementsAre("log.csv: compressed"));
}

TEST(CheckArchive, ContentsThatLieInEachOtherTakeNoMoreRoomThanTheArchive) {
  const std::string megabyte(1 << 20, 'x');
  Contents listed;
  for (int k = 0; k < 50; ++k) listed.emplace_back("f" + std::to_string(k), megabyte);
  std::string bomb = Repacked(listed, {listed[0]});
  // each of 50 entries leads to the one content
  const std::size_t entry = bomb.find("PK\x01\x02", megabyte.size());
  const std::size_t first = bomb.find("PK\x01\x02", entry + 4);
  const std::size_t end = bomb.find("PK\x05\x06", first);
  const std::string one = bomb.substr(first, end - first);
  std::string more;
  for (int k = 1; k < 10; ++k) {
    std::string other = one;
    other[other.size() - 1] = static_cast<char>('0' + k);
    more += other;
  }
  bomb.insert(end, more);
  std::uint32_t bytes = 0;
  const std::size_t size_at = end + more.size() + 12;
  std::copy_n(bomb.begin() + static_cast<long>(size_at), 4, reinterpret_cast<char*>(&bytes));
  bytes += static_cast<std::uint32_t>(more.size());
  std::copy_n(reinterpret_cast<const char*>(&bytes), 4, bomb.begin() + static_cast<long>(size_at));
  const auto checked = Check(bomb);
  ASSERT_TRUE(checked);
  EXPECT_EQ(checked->places.size(), 1U);
}

TEST(CheckArchive, RefusesWhatIsNoArchiveOfASession) {
  for (const std::string bytes : {"", "PK",
                                  "PK\x05\x06"
                                  "\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"}) {
    const auto checked = Check(bytes);
    ASSERT_FALSE(checked);
    EXPECT_EQ(checked.error().cause, Cause::kCannotAnswer);
  }
  // a list that leads out of the folder is none
  EXPECT_THAT(Check(ArchiveOf({{"../x", "a"}})).error().Text(),
              HasSubstr("names a file that leads out of the folder"));
}

}  // namespace
}  // namespace haptometer::tools
