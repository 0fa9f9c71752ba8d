#include "tools/cli/progress.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/text.h"

namespace haptometer::cli {
namespace {

constexpr MonotonicNs kQuietNs = kNsPerS;
constexpr MonotonicNs kRefreshNs = kNsPerS / 10;
constexpr int kWidth = 20;

}  // namespace

Progress::Progress(std::string_view what)
    : what_(what), begun_ns_(clock_.Now()), on_terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (shown_) fmt::print(stderr, "\r\033[K");
}

void Progress::Update(double share) {
  if (!on_terminal_) return;
  const MonotonicNs now_ns = clock_.Now();
  if (now_ns - begun_ns_ < kQuietNs || now_ns - shown_ns_ < kRefreshNs) return;
  shown_ns_ = now_ns;
  shown_ = true;
  fmt::print(stderr, "\r{}\033[K",
             ProgressBar(Printable(what_), share, SecondsFromNs(now_ns - begun_ns_)));
  std::fflush(stderr);
}

std::string ProgressBar(std::string_view what, double share, double elapsed_s) {
  const double done = std::clamp(share, 0.0, 1.0);
  const auto filled = static_cast<std::size_t>(done * kWidth);
  std::string bar = fmt::format("{}  [{:#<{}}{:-<{}}] {:3.0f} %", what, "", filled, "",
                                kWidth - filled, std::floor(100 * done));
  if (done > 0) bar += fmt::format(", {:.0f} s left", elapsed_s * (1 - done) / done);
  return bar;
}

}  // namespace haptometer::cli
