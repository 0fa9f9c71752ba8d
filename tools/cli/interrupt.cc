#include "tools/cli/interrupt.h"

#include <csignal>

namespace haptometer::cli {
namespace {

std::atomic<bool> interrupted{false};
std::atomic<int> which{0};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
              "a signal handler may only touch lock-free atomics");

extern "C" void OnSignal(int signal) {
  which.store(signal);
  interrupted.store(true);
}

}  // namespace

void CatchInterrupts() {
  struct sigaction action{};
  action.sa_handler = OnSignal;
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // a second signal ends the program at once
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGHUP, &action, nullptr);  // a closed terminal must not cost a recording its end
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow further is an error like a full disk
}

void InterruptAsBy(int signal) { OnSignal(signal); }

const std::atomic<bool>& Interrupted() { return interrupted; }

int InterruptedStatus(int otherwise) { return interrupted.load() ? 128 + which.load() : otherwise; }

}  // namespace haptometer::cli
