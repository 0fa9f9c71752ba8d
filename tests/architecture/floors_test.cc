// Reads every #include line of the rooms against the table of floors: the link lists of CMake
// cannot see an include of a header whose functions are not called.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace haptometer {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = HAPTOMETER_SOURCE;

// what a room may include, itself aside
const std::map<std::string, std::set<std::string>> kFloors{
    {"base", {}},
    {"trial", {"base"}},
    {"acquire", {"base", "trial"}},
    {"dsp", {"base", "trial"}},
    {"sim", {"base", "trial", "dsp"}},
    {"fit", {"base", "trial", "dsp", "sim"}},
    {"tools", {"base", "trial", "acquire", "dsp", "sim", "fit"}},
};

struct Include {
  fs::path file;
  std::string target;  // "dsp/statistics/moments.h" or "ceres/ceres.h"
};

std::vector<Include> IncludesBelow(const std::string& room) {
  static const std::regex pattern(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
  std::vector<Include> includes;
  for (const auto& entry : fs::recursive_directory_iterator(kSource / room)) {
    const auto ending = entry.path().extension();
    if (ending != ".h" && ending != ".cc") continue;
    std::ifstream file(entry.path());
    for (std::string line; std::getline(file, line);) {
      std::smatch match;
      if (std::regex_search(line, match, pattern)) {
        includes.push_back({fs::relative(entry.path(), kSource), match[1]});
      }
    }
  }
  return includes;
}

class Floors : public ::testing::TestWithParam<std::string> {};

TEST_P(Floors, ARoomIncludesOnlyWhatStandsBelowIt) {
  const std::string& room = GetParam();
  const auto includes = IncludesBelow(room);
  EXPECT_GT(includes.size(), 3U) << "the search found nothing: is " << kSource / room << " right?";
  for (const Include& include : includes) {
    const std::string target = include.target.substr(0, include.target.find('/'));
    EXPECT_FALSE(target == "tests" || target == "bench" || target == "fuzz")
        << include.file << " includes " << include.target << ", which is no part of the product";
    if (!kFloors.contains(target) || target == room) continue;
    EXPECT_TRUE(kFloors.at(room).contains(target))
        << include.file << " includes " << include.target << ", which is not below " << room;
  }
}

// a folder that is read in one go; a header or source of its own where more than one file needs it
TEST(Folders, HoldAtMostThirtySourcesAndFewSmallOnes) {
  constexpr int kMostInFolder = 30, kShort = 40, kMostShort = 60;
  std::map<fs::path, int> sources;
  int few_lines = 0;
  for (const auto& [room, below] : kFloors) {
    for (const auto& entry : fs::recursive_directory_iterator(kSource / room)) {
      const auto ending = entry.path().extension();
      if (ending != ".h" && ending != ".cc") continue;
      ++sources[fs::relative(entry.path().parent_path(), kSource)];
      std::ifstream file(entry.path());
      int lines = 0;
      for (std::string line; std::getline(file, line);) ++lines;
      few_lines += lines < kShort ? 1 : 0;
    }
  }
  EXPECT_GT(sources.size(), 20U) << "the search is blind";
  for (const auto& [folder, count] : sources) EXPECT_LE(count, kMostInFolder) << folder;
  EXPECT_LE(few_lines, kMostShort);
}

INSTANTIATE_TEST_SUITE_P(Rooms, Floors,
                         ::testing::Values("base", "trial", "acquire", "dsp", "sim", "fit",
                                           "tools"),
                         [](const auto& room) { return room.param; });

struct HeavyPart {
  std::string prefix;           // of the include
  std::set<std::string> files;  // that may include it; a directory ends in '/'
};

// heavy headers decide the build time, so each is let in by name
const std::vector<HeavyPart> kHeavyParts{
    {"boost/", {"dsp/statistics/distributions.cc"}},
    {"ceres/", {"fit/"}},
    {"toml++/", {"base/toml.cc"}},
    {"CLI/", {"tools/cli/options.cc"}},
    {"libserialport.h", {"acquire/transport/"}},
    {"modbus/", {"acquire/sensor/", "acquire/transport/"}},
    {"hdf5", {"trial/"}},
    {"matio", {"trial/export/"}},
    {"openssl/", {"tools/document/provenance.cc"}},
    {"unsupported/Eigen/MatrixFunctions", {"sim/linear/driven_step.cc"}},
};

bool IsLetIn(const HeavyPart& part, const std::string& file) {
  for (const std::string& allowed : part.files) {
    if (allowed.ends_with('/') ? file.starts_with(allowed) : file == allowed) return true;
  }
  return false;
}

TEST(HeavyHeaders, AreIncludedWhereTheyAreLetInAndInNoHeader) {
  int found = 0;
  for (const auto& [room, below] : kFloors) {
    for (const Include& include : IncludesBelow(room)) {
      if (include.target == "nlohmann/json.hpp") {
        EXPECT_EQ(include.file.extension(), ".cc")
            << include.file << " drags in " << include.target;
      }
      for (const HeavyPart& part : kHeavyParts) {
        if (!include.target.starts_with(part.prefix)) continue;
        ++found;
        EXPECT_TRUE(IsLetIn(part, include.file.string())) << include.file << ": " << include.target;
        EXPECT_EQ(include.file.extension(), ".cc") << include.file << ": " << include.target;
      }
    }
  }
  EXPECT_GE(found, 2) << "the search is blind";
}

}  // namespace
}  // namespace haptometer
