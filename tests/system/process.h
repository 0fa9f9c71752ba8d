#pragma once

#include <gtest/gtest.h>
#include <sys/types.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace haptometer::tests {

/// What a finished program left behind.
struct Outcome {
  int status =
      -1;  ///< exit status; 128 + signal when a signal ended it; -1 when it had to be killed
  std::string out;  ///< standard output
  std::string err;  ///< standard error
};

/// A running program of the build (HAPTOMETER_PROGRAMS), started without a shell. The destructor
/// ends it, by its process id.
class Process {
 public:
  /// arguments[0] is the program's name: "haptometer", "acquire".
  explicit Process(const std::vector<std::string>& arguments);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// Waits for a whole line on standard output that begins with `prefix`, and returns the rest of
  /// it; nothing when it does not come within `deadline_s`.
  [[nodiscard]] std::optional<std::string> WaitForLine(const std::string& prefix,
                                                       double deadline_s);

  /// Waits until `holds`, asked again every few hundredths of a second. Fails with what the program
  /// said on standard error when it ends before, or after `deadline_s`.
  [[nodiscard]] ::testing::AssertionResult WaitUntil(const std::function<bool()>& holds,
                                                     double deadline_s);

  /// Waits until there is a file at `path`, as WaitUntil.
  [[nodiscard]] ::testing::AssertionResult WaitForFile(const std::string& path, double deadline_s);

  void Signal(int signal) const;

  /// Reads its standard output no more.
  void CloseOutput();

  /// Waits for its end; kills it after `deadline_s`.
  [[nodiscard]] Outcome Wait(double deadline_s);

  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  bool ReadOnce(double until_s);
  [[nodiscard]] bool HasEnded() const;

  pid_t pid_ = -1;
  int out_fd_ = -1;
  int err_fd_ = -1;
  Outcome outcome_;
};

/// Runs a program to its end, at most 60 s.
[[nodiscard]] Outcome RunProgram(const std::vector<std::string>& arguments);

}  // namespace haptometer::tests
