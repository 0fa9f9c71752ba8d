#include "acquire/transport/input_pipe.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace haptometer::acquire {
namespace {

constexpr int kPipeBytes = 1 << 20;
constexpr const char* kRemedy =
    "pipe samples into it, e.g. my_daq | acquire --sensor pipe --rate 10kHz --channels "
    "displacement:m -o trial.bin";

}  // namespace

InputPipe::InputPipe(OwnedDescriptor descriptor, std::string name)
    : descriptor_(std::move(descriptor)), name_(std::move(name)) {}

Result<std::unique_ptr<Transport>> InputPipe::Open(const std::string& path) {
  const bool is_stdin = path.empty() || path == "-";
  const std::string name = is_stdin ? "standard input" : path;
  // a named pipe must not wait here for its writer
  OwnedDescriptor descriptor(is_stdin ? fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0)
                                      : open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  if (descriptor.get() < 0 && is_stdin) return CannotAnswer(name, "is closed", kRemedy);
  if (descriptor.get() < 0) return std::unexpected(PortDoesNotOpen(name, errno));
  if (isatty(descriptor.get()) != 0) return CannotAnswer(name, "is a terminal", kRemedy);
  struct stat status{};
  if (fstat(descriptor.get(), &status) == 0 && S_ISDIR(status.st_mode)) {
    return CannotAnswer(name, "is a directory", kRemedy);
  }
  (void)fcntl(descriptor.get(), F_SETPIPE_SZ, kPipeBytes);
  return std::unique_ptr<Transport>(new InputPipe(std::move(descriptor), name));
}

ReadOutcome InputPipe::Read(std::span<char> buffer, MonotonicNs deadline) {
  return ReadDescriptor(descriptor_.get(), buffer, deadline);
}

Result<void> InputPipe::Write(std::string_view /*bytes*/, MonotonicNs /*deadline*/) {
  return Failed(name_, "takes no bytes");
}

std::string InputPipe::Source() const { return fmt::format("piped in: {}", name_); }

}  // namespace haptometer::acquire
