// Signals that end a run in order, and those that end it at once.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>
#include <tuple>

#include "tools/cli/terminal.h"

namespace haptometer::cli {
namespace {

// a signal twice, and the status of an end in order
void EndAfterTwo(int signal, std::chrono::milliseconds apart) {
  CatchInterrupts();
  std::raise(signal);
  std::this_thread::sleep_for(apart);
  std::raise(signal);
  std::_Exit(InterruptedStatus(0));
}

// the kernel and the shell each send one when a terminal is closed, and `timeout` sends to the
// process and to its group
TEST(Interrupts, TwiceWithinMillisecondsAreOne) {
  for (const auto& [signal, status] :
       {std::tuple(SIGHUP, 129), std::tuple(SIGINT, 130), std::tuple(SIGTERM, 143)}) {
    EXPECT_EXIT(EndAfterTwo(signal, std::chrono::milliseconds(5)), testing::ExitedWithCode(status),
                "");
  }
}

TEST(Interrupts, AskedForAgainEndAtOnce) {
  for (const int signal : {SIGINT, SIGTERM}) {
    EXPECT_EXIT(EndAfterTwo(signal, std::chrono::milliseconds(400)),
                testing::KilledBySignal(signal), "");
  }
  EXPECT_EXIT(EndAfterTwo(SIGHUP, std::chrono::milliseconds(400)), testing::ExitedWithCode(129),
              "");
}

// nohup ignores the signal of a closed terminal
TEST(Interrupts, ThatWereIgnoredStayIgnored) {
  const auto end = [] {
    std::signal(SIGHUP, SIG_IGN);
    CatchInterrupts();
    std::raise(SIGHUP);
    std::_Exit(InterruptedStatus(0));
  };
  EXPECT_EXIT(end(), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace haptometer::cli
