// Real-looking mistakes at the real program: each is answered in one line that names the thing and
// the remedy, with the right exit status, and destroys nothing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>

#include "tests/system/emulated_device.h"

namespace haptometer::tests {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const std::string kFixtures = HAPTOMETER_FIXTURES;

class BadInput : public EmulatedDeviceTest {
 protected:
  std::string Write(const std::string& name, const std::string& content) const {
    std::ofstream(directory_ / name, std::ios::binary) << content;
    return directory_ / name;
  }
  static std::string Content(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
};

// one line on stderr that holds `thing` and, behind a semicolon, a remedy; no trace of the inside
void ExpectOneLine(const Outcome& outcome, int status, const std::string& thing) {
  EXPECT_EQ(outcome.status, status) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr(thing));
  EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
  EXPECT_NE(outcome.err.find("; "), std::string::npos) << "no remedy: " << outcome.err;
  for (const char* trace : {"terminate called", "exception", ".cc:", "std::", "check failed"}) {
    EXPECT_EQ(outcome.err.find(trace), std::string::npos) << outcome.err;
  }
}

std::string RandomBytes(std::size_t n) {
  std::mt19937 engine(7);
  std::string bytes(n, '\0');
  std::ranges::generate(bytes, [&] { return static_cast<char>(engine()); });
  return bytes;
}

TEST_F(BadInput, FilesThatCannotAnswerGiveStatus3) {
  const std::string empty = Write("empty.bin", "");
  const std::string random = Write("random.bin", RandomBytes(4096));
  const std::string text = Write("text.csv", "dear diary,\nthe motor buzzed today\n");
  for (const char* verb : {"analyze", "fit-lra"}) {
    for (const std::string& path :
         {std::string("/no/such/file.bin"), directory_.string(), empty, random, text}) {
      // analyze reads the recordings of a folder, each with a line of its own
      if (verb == std::string("analyze") && path == directory_.string()) continue;
      SCOPED_TRACE(verb + (" " + path));
      ExpectOneLine(RunProgram({"haptometer", verb, path}), 3, path);
    }
  }
  for (const std::string& path : {std::string("/no/such/file.bin"), directory_.string(), empty}) {
    ExpectOneLine(RunProgram({"haptometer", "trial", "info", path}), 3, path);
    ExpectOneLine(RunProgram({"haptometer", "simulate", path}), 3, path);
  }
  ExpectOneLine(RunProgram({"haptometer", "trial", "info", random}), 3, random);
}

TEST_F(BadInput, WrongCommandLinesGiveStatus2) {
  const std::string impulse = kFixtures + "/impulse.csv";
  ExpectOneLine(RunProgram({"haptometer", "analyse", "x"}), 2, "did you mean analyze?");
  ExpectOneLine(RunProgram({"analyze", "--bnad", "20-500Hz", "x.bin"}), 2, "--bnad");
  ExpectOneLine(RunProgram({"acquire", "--prot", "/dev/ttyUSB0"}), 2, "did you mean --port?");
  ExpectOneLine(RunProgram({"fit-lra", impulse, "--drop-height", "10"}), 2, "did you mean 10mm?");
  ExpectOneLine(RunProgram({"fit-lra", impulse, "--moving-mass", "1.4"}), 2, "did you mean 1.4g?");
  ExpectOneLine(RunProgram({"fit-lra", impulse, "--inductance", "130"}), 2, "did you mean 130uH?");
  ExpectOneLine(
      RunProgram({"haptometer", "simulate", Write("typo.toml", "[actuator]\nmodell = 'x'\n")}), 2,
      "did you mean model?");
}

TEST_F(BadInput, OneDropIsNotCountedTwice) {
  const std::string impulse = kFixtures + "/impulse.csv";
  ExpectOneLine(RunProgram({"fit-lra", impulse, kFixtures + "/../fixtures/impulse.csv"}), 2,
                "is given twice");
}

TEST_F(BadInput, ATrialWithGapsIsNoRingDown) {
  ExpectOneLine(RunProgram({"fit-lra", kFixtures + "/recorded_trial.bin"}), 3, "has gaps or");
}

TEST_F(BadInput, APlotThatCannotBeDrawnIsRefusedBeforeTheWork) {
  const std::string trial = kFixtures + "/recorded_trial.bin";
  const std::string elsewhere = directory_ / "none" / "x.svg";
  ExpectOneLine(RunProgram({"analyze", trial, "--plot", elsewhere}), 2, elsewhere);
  const std::string occupied = directory_ / "d.svg";
  fs::create_directory(occupied);
  const Outcome outcome = RunProgram({"analyze", trial, "--plot", occupied});
  ExpectOneLine(outcome, 2, occupied);
  EXPECT_EQ(outcome.out, "");
  EXPECT_TRUE(fs::is_directory(occupied));
}

TEST_F(BadInput, AnAbsentPortGivesStatus3AndLeavesNoFile) {
  const std::string trial = directory_ / "t.bin";
  ExpectOneLine(RunProgram({"acquire", "--port", "/dev/ttyNOT0", "-o", trial}), 3, "/dev/ttyNOT0");
  EXPECT_FALSE(fs::exists(trial));
}

TEST_F(BadInput, ABusyPortGivesStatus3AndDoesNotDisturbTheFirst) {
  Emulate({"--scene", kScene, "--protocol", "stream", "--baud", "921600"});
  const std::string first_file = directory_ / "first.bin";
  Process first({"acquire", "--port", port_, "--sensor", "stream", "--baud", "921600", "--duration",
                 "2s", "-o", first_file, "--json"});
  ASSERT_TRUE(first.WaitForFile(first_file, 30));
  ExpectOneLine(RunProgram({"acquire", "--port", port_, "--sensor", "stream", "--baud", "921600",
                            "-o", directory_ / "second.bin"}),
                3, port_);
  EXPECT_EQ(first.Wait(30).status, 0);
}

TEST_F(BadInput, AnExistingRecordingIsNotOverwritten) {
  const std::string kept = Write("kept.bin", "the only copy");
  ExpectOneLine(RunProgram({"acquire", "--port", "/dev/ttyNOT0", "-o", kept}), 2, kept);
  EXPECT_EQ(Content(kept), "the only copy");
}

TEST_F(BadInput, ATruncatedTrialIsReadAsFarAsItGoesAndSaysSo) {
  const std::string whole = directory_ / "whole.bin";
  ASSERT_EQ(RunProgram({"haptometer", "simulate", kScene, "-o", whole}).status, 0);
  const std::string content = Content(whole);
  const std::string cut = Write("cut.bin", content.substr(0, content.size() * 3 / 4));
  const Outcome info = RunProgram({"haptometer", "trial", "info", cut});
  EXPECT_EQ(info.status, 0) << info.err;
  EXPECT_THAT(info.out + info.err, HasSubstr("cut short"));
  const Outcome head =
      RunProgram({"haptometer", "trial", "info", Write("head.bin", content.substr(0, 20))});
  ExpectOneLine(head, 3, "head.bin");
}

}  // namespace
}  // namespace haptometer::tests
