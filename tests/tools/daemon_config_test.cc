#include "tools/daemon/daemon_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

DaemonConfig Parsed(std::string_view text) {
  auto config = ParseDaemonConfig(text, "d.toml");
  EXPECT_TRUE(config) << config.error().Text();
  return config.value_or(DaemonConfig{});
}

TEST(DaemonConfig, SaysWhatIsToBeRecordedAndWhere) {
  const DaemonConfig config = Parsed(R"(
    directory = "/data"
    file = "{utc}-{name}.bin"
    socket = "/run/x.sock"
    rotate_every_s = "10min"
    rotate_bytes = 1_000_000
    flush_s = 0.5
    reserve_bytes = 2_000_000
    [labels]
    rig = "A"
    shift = "day"
    [[sensor]]
    name = "left"
    port = "/dev/ttyUSB0"
    baud = 38400
    refresh_s = "7ms"
    [[sensor]]
    name = "right-2"
    port = "127.0.0.1:5000"
    sensor = "stream"
    format = "+00.00,mm,LF"
    averages = 16
    sampling_s = "0.33ms"
    labels = { shift = "night" })");
  EXPECT_EQ(config.trials.directory, "/data");
  EXPECT_EQ(config.trials.file, "{utc}-{name}.bin");
  EXPECT_EQ(config.socket, "/run/x.sock");
  EXPECT_EQ(config.rotation.duration_ns, 600 * kNsPerS);
  EXPECT_EQ(config.rotation.bytes, 1'000'000U);
  EXPECT_EQ(config.flush_s, 0.5);
  EXPECT_EQ(config.reserve_bytes, 2'000'000U);
  ASSERT_EQ(config.sensors.size(), 2U);
  const DaemonSensor& left = config.sensors[0];
  EXPECT_EQ(left.name, "left");
  EXPECT_EQ(left.options.sensor, "keyence-il");
  EXPECT_EQ(left.options.port, "/dev/ttyUSB0");
  EXPECT_EQ(left.options.baud, 38400);
  ASSERT_TRUE(left.options.refresh_s);
  EXPECT_EQ(left.options.refresh_s, 7e-3);
  EXPECT_EQ(left.labels, (std::map<std::string, std::string>{{"rig", "A"}, {"shift", "day"}}));
  const DaemonSensor& right = config.sensors[1];
  EXPECT_EQ(right.options.sensor, "stream");
  EXPECT_EQ(right.options.format, "+00.00,mm,LF");
  EXPECT_EQ(right.options.averages, 16);
  ASSERT_TRUE(right.options.sampling_s);
  EXPECT_EQ(right.options.sampling_s, 0.33e-3);
  EXPECT_EQ(right.labels, (std::map<std::string, std::string>{{"rig", "A"}, {"shift", "night"}}));
}

TEST(DaemonConfig, TwoLinesAreEnough) {
  const DaemonConfig config = Parsed("[[sensor]]\nname = 'a'\nport = 'p'\n");
  EXPECT_EQ(config.trials.directory, ".");
  EXPECT_EQ(config.rotation.duration_ns, 3600 * kNsPerS);
  EXPECT_FALSE(config.rotation.bytes);
  EXPECT_EQ(config.reserve_bytes, 64'000'000U);
}

TEST(DaemonConfig, ASizeAloneRotatesByNothingElse) {
  const DaemonConfig config = Parsed("rotate_bytes = 65536\n[[sensor]]\nname = 'a'\nport = 'p'\n");
  EXPECT_FALSE(config.rotation.duration_ns);
}

struct Wrong {
  const char* toml;
  const char* text;
};

class WrongDaemonConfigs : public ::testing::TestWithParam<Wrong> {};

TEST_P(WrongDaemonConfigs, AreRefusedByName) {
  const auto config = ParseDaemonConfig(GetParam().toml, "d.toml");
  ASSERT_FALSE(config);
  EXPECT_EQ(config.error().cause, Cause::kUsage);
  EXPECT_THAT(config.error().Text(), ::testing::HasSubstr(GetParam().text));
}

INSTANTIATE_TEST_SUITE_P(
    Keys, WrongDaemonConfigs,
    ::testing::Values(
        Wrong{"", "d.toml: names no sensor; write a table [[sensor]] with name and port"},
        Wrong{"sensor = 3", "sensor: is not a list of tables; write [[sensor]]"},
        Wrong{"sensor = []", "names no sensor"},
        Wrong{"directroy = '/x'\n[[sensor]]\nname = 'a'\nport = 'p'",
              "key directroy is not known; did you mean directory?"},
        Wrong{"[[sensor]]\nname = 'a'\nprot = 'p'",
              "d.toml:3: [[sensor]] 1: key prot is not known; did you mean port?"},
        Wrong{"[[sensor]]\nname = 'a'\nport = 'p'\n[[sensor]]\nname = 'b'",
              "d.toml:4: [[sensor]] 2: port: is missing"},
        Wrong{"[[sensor]]\nport = 'p'", "name: is missing"},
        Wrong{"[[sensor]]\nname = '../x'\nport = 'p'", "name: is not a plain name"},
        Wrong{"[[sensor]]\nname = 'a'\nport = 'p'\n[[sensor]]\nname = 'a'\nport = 'q'",
              "sensor a: is given twice"},
        Wrong{"[[sensor]]\nname = 'a'\nport = 'p'\n[[sensor]]\nname = 'b'\nport = 'p'",
              "sensor b: p is another sensor's port too"},
        Wrong{"[[sensor]]\nname = 'a'\nport = 'p'\nsensor = 'replay'", "replay ends by itself"},
        Wrong{"[[sensor]]\nname = 'a'\nport = 'p'\nsensor = 'pipe'", "pipe ends by itself"},
        Wrong{"[[sensor]]\nname = 'a'\nport = 'p'\nsensor = 'scene:x.toml'", "ends by itself"},
        Wrong{"[[sensor]]\nname = 'a'\nport = 'p'\nsensor = 'steam'", "sensor a: --sensor: "},
        Wrong{"[[sensor]]\nname = 'a'\nport = 'p'\nformat = '+0,mm,CR'", "--format: is for lines"},
        Wrong{"[[sensor]]\nname = 'a'\nport = 'p'\nbaud = 7", "baud: 7 is not from 50 to"},
        Wrong{"[[sensor]]\nname = 'a'\nport = 'p'\nrefresh_s = '7mm'", "refresh_s"},
        Wrong{"[[sensor]]\nname = 'a'\nport = 'p'\nrefresh_s = '7ms+-3ms'",
              "refresh_s: has an uncertainty, which is not used here"},
        Wrong{"[[sensor]]\nname = 'a'\nsensor = 'keyence-il'\nport = 'p'\nrefresh_s = '2h'",
              "--refresh: must be above 0, and an hour at most"},
        Wrong{"[[sensor]]\nname = 'a'\nport = 'p'\nlabels = { n = 3 }", "n: is not a text"},
        Wrong{"rotate_every_s = 0.5", "rotate_every_s: is not from 1 s to 30 years"},
        Wrong{"rotate_bytes = 100", "rotate_bytes: must be 65536 or more"},
        Wrong{"reserve_bytes = 0", "reserve_bytes: must be 1048576 or more"},
        Wrong{"flush_s = -1", "flush_s: is not from 0.01 s"},
        Wrong{"file = 'a/{name}'\n[[sensor]]\nname = 'a'\nport = 'p'", "file: is a path"},
        Wrong{"file = '{utc}.bin'\n[[sensor]]\nname = 'a'\nport = 'p'\n"
              "[[sensor]]\nname = 'b'\nport = 'q'",
              "d.toml: file: \"{utc}.bin\" names all sensors' trials the same; write {name} in it"},
        Wrong{"file = '{nam}'\n[[sensor]]\nname = 'a'\nport = 'p'", "brace that means nothing"}));

TEST(DaemonConfig, TheKeysOfASensorAreThoseThatThePageLists) {
  std::ifstream page(std::string(HAPTOMETER_FIXTURES) + "/../docs/reference/daemon.md");
  const std::string text{std::istreambuf_iterator<char>(page), {}};
  const auto begin = text.find("The options of a sensor are those of `acquire`");
  const auto end = text.find("What changes a device", begin);
  ASSERT_NE(begin, std::string::npos);
  ASSERT_NE(end, std::string::npos);
  const std::string list = text.substr(begin, end - begin);
  std::vector<std::string> listed;
  const std::regex code("`([a-z_]+)`");
  for (std::sregex_iterator at(list.begin(), list.end(), code); at != std::sregex_iterator();
       ++at) {
    if ((*at)[1] != "acquire") listed.push_back((*at)[1]);
  }
  const auto names = SensorKeyNames();
  EXPECT_THAT(listed, ::testing::UnorderedElementsAreArray(names.begin(), names.end()));
}

TEST(TrialName, IsFilledInAndNeverThatOfAnotherFile) {
  const fs::path directory =
      fs::path(::testing::TempDir()) / ("trial_name_test_" + std::to_string(::getpid()));
  fs::create_directories(directory);
  const TrialPattern pattern{.directory = directory, .file = "{name}-{utc}-{part}.bin"};
  const auto next = [&] { return NextTrialPath(pattern, "left", "2026-03-01T12:34:56.789Z", 7); };
  EXPECT_EQ(next(), (directory / "left-20260301T123456Z-0007.bin").string());
  std::ofstream(next()) << "taken";
  EXPECT_EQ(next(), (directory / "left-20260301T123456Z-0007-2.bin").string());
  std::ofstream(next()) << "taken";
  EXPECT_EQ(next(), (directory / "left-20260301T123456Z-0007-3.bin").string());
  fs::remove_all(directory);
}

// the file that docs/how-to/record-for-days.md shows is one
TEST(DaemonConfig, TheDocumentedExampleIsRead) {
  std::ifstream file(std::string(HAPTOMETER_FIXTURES) + "/../docs/how-to/record-for-days.md");
  std::stringstream text;
  text << file.rdbuf();
  const std::string page = text.str();
  const std::size_t begin = page.find("```toml\n");
  ASSERT_NE(begin, std::string::npos);
  const std::string example = page.substr(begin + 8, page.find("```", begin + 8) - begin - 8);
  const DaemonConfig config = Parsed(example);
  EXPECT_EQ(config.sensors.size(), 2U);
}

}  // namespace
}  // namespace haptometer::tools
