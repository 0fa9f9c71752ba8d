#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

namespace haptometer::cli {

/// A remark for work whose length nobody knows: said once on a terminal's stderr when the work has
/// taken `after_s`, never where it is done before.
class LateRemark {
 public:
  LateRemark(std::string_view verb, std::string text, double after_s);
  /// The work is done.
  ~LateRemark();
  LateRemark(const LateRemark&) = delete;
  LateRemark& operator=(const LateRemark&) = delete;

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool done_ = false;
  std::thread waiting_;
};

}  // namespace haptometer::cli
