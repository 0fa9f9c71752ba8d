#include "tools/verb_call.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstddef>
#include <string>
#include <thread>
#include <vector>

#include "tools/cli/terminal.h"
#include "tools/document/render.h"

namespace haptometer::tools {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::string kTrial = HAPTOMETER_FIXTURES "/recorded_trial.bin";
const std::string kScene = HAPTOMETER_FIXTURES "/lra_adapter.toml";

TEST(CallVerb, GivesTheDocumentThatItPrintsAsJson) {
  const VerbAnswer answer = CallVerb({"analyze", "--json", kTrial}, false);
  EXPECT_EQ(answer.status, 0);
  EXPECT_THAT(answer.errors, IsEmpty());
  ASSERT_TRUE(answer.document);
  EXPECT_EQ(document::JsonOf(*answer.document), answer.output);
}

TEST(CallVerb, ComputesFiguresWhereTheyAreWanted) {
  const auto figures = [](bool wanted) {
    const VerbAnswer answer = CallVerb({"analyze", "--json", kTrial}, wanted);
    std::size_t count = 0;
    for (const document::Section* section : document::AllSections(answer.document->root)) {
      count += section->figures.size();
    }
    return count;
  };
  EXPECT_EQ(figures(false), 0U);
  EXPECT_GT(figures(true), 0U);
}

TEST(CallVerb, KeepsErrorsAndTheStatusOfTheCommand) {
  const VerbAnswer wrong = CallVerb({"analyze", kTrial, "--band=30-20Hz"}, false);
  EXPECT_EQ(wrong.status, 2);
  EXPECT_FALSE(wrong.document);
  EXPECT_THAT(wrong.errors, HasSubstr("is not a band"));
  EXPECT_EQ(CallVerb({"no-verb"}, false).status, 2);
  EXPECT_EQ(CallVerb({"trial", "info", kTrial}, false).status, 0);
}

// the inputs of one call do not forbid the outputs of the next
TEST(CallVerb, ForgetsTheInputsOfTheCallBefore) {
  const std::string table = ::testing::TempDir() + "verb_call.csv";
  const std::vector<std::string> words{"sweep", kScene, "--vary=drive.frequency_hz=200",
                                       "-o",    table,  "--overwrite"};
  ASSERT_EQ(CallVerb(words, false).status, 0);
  EXPECT_EQ(CallVerb({"trial", "info", table}, false).status, 3);
  EXPECT_EQ(CallVerb(words, false).status, 0);
}

TEST(InterruptVerb, EndsAVerbAndNotTheNextOne) {
  struct sigaction before{};
  sigaction(SIGINT, nullptr, &before);
  // a run that would take minutes
  VerbAnswer ended;
  std::thread running([&] {
    ended =
        CallVerb({"simulate", HAPTOMETER_FIXTURES "/lra_stops.toml", "--duration=5000s"}, false);
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  InterruptVerb();
  running.join();
  EXPECT_EQ(ended.status, 130);
  EXPECT_FALSE(ended.document);
  EXPECT_EQ(CallVerb({"simulate", kScene}, false).status, 0);
  // a second Ctrl-C would end the process, were the signal caught
  struct sigaction after{};
  sigaction(SIGINT, nullptr, &after);
  EXPECT_EQ(before.sa_handler, after.sa_handler);
}

}  // namespace
}  // namespace haptometer::tools
