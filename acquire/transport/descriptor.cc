#include "acquire/transport/descriptor.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <linux/serial.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "base/error.h"

namespace haptometer::acquire {
namespace {

std::string Reason(int error_number) { return std::generic_category().message(error_number); }

// of a port that is in use: "is busy: minicom (process 123) holds it"
Error BusyPort(const std::string& name) {
  const std::string holder = PortHolder(name);
  return {Cause::kCannotAnswer, name,
          holder.empty() ? "is busy: another program holds it"
                         : fmt::format("is busy: {} holds it", holder),
          "end that program, or give another <port>"};
}

}  // namespace

// the other object closes the old descriptor at its end
OwnedDescriptor& OwnedDescriptor::operator=(OwnedDescriptor&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

OwnedDescriptor::~OwnedDescriptor() {
  if (descriptor_ >= 0) close(descriptor_);
}

// a time that has passed becomes 0, not a wait without limit
timespec TimespecOf(MonotonicNs ns) {
  ns = std::max<MonotonicNs>(ns, 0);
  return {.tv_sec = ns / kNsPerS, .tv_nsec = ns % kNsPerS};
}

// raw: no echo, no line editing, no conversion of CR and LF
bool MakeRaw(int descriptor) {
  termios settings{};
  if (tcgetattr(descriptor, &settings) != 0) return false;
  cfmakeraw(&settings);
  // CLOCAL: modem lines are ignored
  settings.c_cflag |= CLOCAL | CREAD;
  return tcsetattr(descriptor, TCSANOW, &settings) == 0;
}

// the events that are pending, 0 at the deadline
int WaitFor(int descriptor, int events, MonotonicNs deadline) {
  SystemClock clock;
  const timespec timeout = TimespecOf(deadline - clock.Now());
  pollfd watched{.fd = descriptor, .events = static_cast<short>(events), .revents = 0};
  return ppoll(&watched, 1, &timeout, nullptr) > 0 ? watched.revents : 0;
}

ReadOutcome ReadDescriptor(int descriptor, std::span<char> buffer, MonotonicNs deadline) {
  HAPTOMETER_CHECK(!buffer.empty(), "buffer of {} bytes", buffer.size());
  const int events = WaitFor(descriptor, POLLIN, deadline);
  if (events == 0) return {.state = ReadState::kTimeout, .bytes = 0};
  // a hang-up counts only after the bytes before it have been read
  const ssize_t taken = read(descriptor, buffer.data(), buffer.size());
  if (taken > 0) return {.state = ReadState::kBytes, .bytes = static_cast<std::size_t>(taken)};
  // no bytes yet; end of file or another error means that the port is gone
  const bool nothing_yet = taken < 0 && (errno == EAGAIN || errno == EINTR);
  const bool hung_up = (events & (POLLHUP | POLLERR | POLLNVAL)) != 0;
  return {.state = nothing_yet && !hung_up ? ReadState::kTimeout : ReadState::kGone, .bytes = 0};
}

Result<void> WriteDescriptor(int descriptor, std::string_view bytes, MonotonicNs deadline,
                             const std::string& name) {
  SystemClock clock;
  // a full buffer accepts a part; the rest follows when it is writable again
  while (!bytes.empty()) {
    const ssize_t taken = write(descriptor, bytes.data(), bytes.size());
    if (taken > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(taken));
      continue;
    }
    if (taken < 0 && errno != EAGAIN && errno != EINTR) {
      return Failed(name, fmt::format("the connection was lost ({})", Reason(errno)),
                    "check cable and power");
    }
    if (clock.Now() >= deadline) {
      return Failed(name, "the port does not take bytes", "check cable and flow control");
    }
    (void)WaitFor(descriptor, POLLOUT, deadline);
  }
  return {};
}

// an advisory lock between programs that use flock(); it ends with the descriptor
Result<void> LockPort(int descriptor, const std::string& name) {
  if (flock(descriptor, LOCK_EX | LOCK_NB) == 0) return {};
  if (errno == EWOULDBLOCK) return std::unexpected(BusyPort(name));
  return Failed(name, fmt::format("cannot be locked: {}", Reason(errno)));
}

// ASYNC_LOW_LATENCY: FTDI adapters then answer within 1 ms and not 16 ms
bool AskForLowLatency(int descriptor) {
  serial_struct settings{};
  if (ioctl(descriptor, TIOCGSERIAL, &settings) != 0) return false;
  settings.flags |= ASYNC_LOW_LATENCY;
  return ioctl(descriptor, TIOCSSERIAL, &settings) == 0;
}

Error PortDoesNotOpen(const std::string& name, int error_number) {
  switch (error_number) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return {Cause::kCannotAnswer, name, "is not there",
              "plug the sensor in and look for its port with: ls /dev/serial/by-id/"};
    case EACCES:
    case EPERM:
      return {Cause::kCannotAnswer, name, "may not be opened by this user",
              "join its group with: sudo usermod -aG dialout $USER, then log in again"};
    case EBUSY:
      return BusyPort(name);
    default:
      return {Cause::kCannotAnswer, name, fmt::format("does not open: {}", Reason(error_number)),
              "give a serial port, a virtual terminal or HOST:PORT"};
  }
}

namespace {

namespace fs = std::filesystem;

// whether /proc/PID/fd holds a link to the device
bool HasOpen(const fs::path& process, const fs::path& device) {
  std::error_code error;
  for (auto entry = fs::directory_iterator(process / "fd", error);
       !error && entry != fs::directory_iterator(); entry.increment(error)) {
    std::error_code unreadable;
    if (fs::read_symlink(entry->path(), unreadable) == device) return true;
  }
  return false;
}

}  // namespace

std::string PortHolder(const std::string& path) {
  // links of /dev/serial/by-id lead to the kernel's name
  std::error_code error;
  const fs::path device = fs::canonical(path, error);
  if (error) return {};
  for (auto entry = fs::directory_iterator("/proc", error);
       !error && entry != fs::directory_iterator(); entry.increment(error)) {
    // processes are the numeric names in /proc; other users' are not readable: they are not found
    const std::string process = entry->path().filename();
    const bool is_other =
        std::ranges::all_of(process, [](char c) { return c >= '0' && c <= '9'; }) &&
        process != std::to_string(getpid());
    if (!is_other || !HasOpen(entry->path(), device)) continue;
    std::string command;
    std::getline(std::ifstream(entry->path() / "comm"), command);
    return fmt::format("{} (process {})", command, process);
  }
  return {};
}

}  // namespace haptometer::acquire
