#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <string>

#include "base/clock.h"

namespace haptometer::tests {

/// The master end of a pseudo-terminal: what stands in for the device. `path()` is the port.
class PtyPair {
 public:
  PtyPair() : master_(posix_openpt(O_RDWR | O_NOCTTY)) {
    EXPECT_GE(master_, 0);
    EXPECT_EQ(grantpt(master_), 0);
    EXPECT_EQ(unlockpt(master_), 0);
    path_ = ptsname(master_);
    termios settings{};
    tcgetattr(master_, &settings);
    cfmakeraw(&settings);
    tcsetattr(master_, TCSANOW, &settings);
  }
  PtyPair(const PtyPair&) = delete;
  PtyPair& operator=(const PtyPair&) = delete;
  ~PtyPair() { HangUp(); }

  void Send(const std::string& bytes) const {
    ASSERT_EQ(write(master_, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  /// Waits for exactly `size` bytes.
  [[nodiscard]] std::string Receive(std::size_t size) const {
    std::string bytes(size, '\0');
    std::size_t taken = 0;
    while (taken < size) {
      const ssize_t more = read(master_, bytes.data() + taken, size - taken);
      if (more <= 0) break;
      taken += static_cast<std::size_t>(more);
    }
    bytes.resize(taken);
    return bytes;
  }
  void HangUp() {
    if (master_ >= 0) close(master_);
    master_ = -1;
  }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] int master() const { return master_; }

 private:
  int master_;
  std::string path_;
};

/// A deadline on the system's clock, `seconds` from now.
inline MonotonicNs In(double seconds) { return SystemClock().Now() + NsFromSeconds(seconds); }

}  // namespace haptometer::tests
