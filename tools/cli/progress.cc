#include "tools/cli/progress.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

#include "base/text.h"
#include "tools/cli/terminal.h"

namespace haptometer::cli {
namespace {

// no bar for the first second; at most ten updates per second
constexpr MonotonicNs kQuietNs = kNsPerS;
constexpr MonotonicNs kRefreshNs = kNsPerS / 10;
constexpr int kWidth = 20;

// of WorkProgress: first line, update of a terminal's line, and interval of lines in a log
constexpr std::chrono::milliseconds kQuiet{2000};
constexpr std::chrono::milliseconds kRefresh{200};
constexpr std::chrono::milliseconds kLineEvery{10'000};

constexpr std::array kInterrupts{SIGINT, SIGTERM};

// a line without its end is on the terminal: EndAtOnce() ends it first
volatile std::sig_atomic_t line_is_open = 0;

// in a signal handler write and _exit only, which are async-signal-safe
extern "C" void EndAtOnce(int signal) {
  if (line_is_open != 0) {
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, "\n", 1);
  }
  ::_exit(128 + signal);
}

// what a verb says within another program has no terminal
bool IsErrorTerminal() { return !IsWithinProgram() && ::isatty(STDERR_FILENO) == 1; }

}  // namespace

Progress::Progress(std::string_view what)
    : what_(what), begun_ns_(clock_.Now()), on_terminal_(IsErrorTerminal()) {}

Progress::~Progress() {
  if (shown_) PrintError("\r\033[K");
}

void Progress::Update(double share) {
  if (!on_terminal_) return;
  const MonotonicNs now_ns = clock_.Now();
  if (now_ns - begun_ns_ < kQuietNs || now_ns - shown_ns_ < kRefreshNs) return;
  shown_ns_ = now_ns;
  shown_ = true;
  PrintError(fmt::format("\r{}\033[K",
                         ProgressBar(Printable(what_), share, SecondsFromNs(now_ns - begun_ns_))));
  std::fflush(stderr);
}

std::string ProgressBar(std::string_view what, double share, double elapsed_s) {
  // remaining time for constant speed: elapsed (1 - share) / share
  const double done = std::clamp(share, 0.0, 1.0);
  const auto filled = static_cast<std::size_t>(done * kWidth);
  std::string bar = fmt::format("{}  [{:#<{}}{:-<{}}] {:3.0f} %", what, "", filled, "",
                                kWidth - filled, std::floor(100 * done));
  if (done > 0) bar += fmt::format(", {:.0f} s left", elapsed_s * (1 - done) / done);
  return bar;
}

double SecondsPerItem(std::uint64_t first, std::uint64_t items,
                      const std::function<void(std::uint64_t)>& make) {
  constexpr std::uint64_t kTimed = 3;
  constexpr double kEnoughS = 1;
  const std::uint64_t count = std::min(kTimed, items - first);
  SystemClock clock;
  const MonotonicNs begun_ns = clock.Now();
  double taken_s = 0;
  std::uint64_t timed = 0;
  while (timed < count && taken_s < kEnoughS && !Interrupted()) {
    make(first + (items - first - 1) * timed / std::max<std::uint64_t>(1, count - 1));
    taken_s = SecondsFromNs(clock.Now() - begun_ns);
    ++timed;
  }
  return timed == 0 ? 0 : taken_s / static_cast<double>(timed);
}

WorkProgress::WorkProgress(std::string_view verb, std::string advice)
    : verb_(verb),
      advice_(std::move(advice)),
      begun_ns_(clock_.Now()),
      on_terminal_(IsErrorTerminal()) {
  if (IsWithinProgram()) return;
  struct sigaction ends{};
  ends.sa_handler = EndAtOnce;
  for (std::size_t k = 0; k < kInterrupts.size(); ++k) {
    sigaction(kInterrupts[k], nullptr, &before_[k]);
    // an ignored signal, as by nohup, stays ignored
    if (before_[k].sa_handler != SIG_IGN) sigaction(kInterrupts[k], &ends, nullptr);
  }
  telling_ = std::thread([this] {
    std::unique_lock lock(mutex_);
    const auto done = [this] { return done_; };
    // a thread of its own: the work updates share_ without waiting for the terminal
    for (auto wait = kQuiet; !changed_.wait_for(lock, wait, done);
         wait = on_terminal_ ? kRefresh : kLineEvery) {
      Say(SecondsFromNs(clock_.Now() - begun_ns_));
    }
  });
}

void WorkProgress::Update(std::string_view what, double share) {
  LeaveIfInterrupted();
  const std::scoped_lock lock(mutex_);
  what_ = what;
  share_ = share;
}

WorkProgress::~WorkProgress() {
  if (!telling_.joinable()) return;
  {
    const std::scoped_lock lock(mutex_);
    done_ = true;
  }
  changed_.notify_all();
  telling_.join();
  if (shown_ && on_terminal_) PrintError("\r\033[K");
  line_is_open = 0;
  // signals act again as before the work
  for (std::size_t k = 0; k < kInterrupts.size(); ++k) {
    sigaction(kInterrupts[k], &before_[k], nullptr);
  }
}

void WorkProgress::Say(double elapsed_s) {
  std::string line = WorkLine(verb_, what_, share_, elapsed_s);
  if (!shown_) line += "; " + advice_;
  shown_ = true;
  line_is_open = on_terminal_ ? 1 : 0;
  PrintError(fmt::format("{}{}{}", on_terminal_ ? "\r\033[K" : "", line, on_terminal_ ? "" : "\n"));
  std::fflush(stderr);
}

std::string WorkLine(std::string_view verb, std::string_view what, double share, double elapsed_s) {
  // less than a hundredth tells nothing of the rest
  constexpr double kLeastShare = 0.01;
  const double done = std::clamp(share, 0.0, 1.0);
  const std::string left =
      done < kLeastShare ? "" : fmt::format(", {:.0f} s left", elapsed_s * (1 - done) / done);
  return fmt::format("{}: {}: {:.0f} % of the most work that is tried, {:.0f} s{}; Ctrl-C ends it",
                     verb, what, std::floor(100 * done), elapsed_s, left);
}

}  // namespace haptometer::cli
