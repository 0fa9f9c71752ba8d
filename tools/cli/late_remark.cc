#include "tools/cli/late_remark.h"

#include <unistd.h>

#include <chrono>
#include <utility>

#include "tools/cli/report.h"

namespace haptometer::cli {

LateRemark::LateRemark(std::string_view verb, std::string text, double after_s) {
  if (::isatty(STDERR_FILENO) == 0) return;
  waiting_ = std::thread([this, verb, text = std::move(text), after_s] {
    std::unique_lock lock(mutex_);
    const auto longest = std::chrono::duration<double>(after_s);
    if (!changed_.wait_for(lock, longest, [this] { return done_; })) Remark(verb, text);
  });
}

LateRemark::~LateRemark() {
  if (!waiting_.joinable()) return;
  {
    const std::scoped_lock lock(mutex_);
    done_ = true;
  }
  changed_.notify_all();
  waiting_.join();
}

}  // namespace haptometer::cli
