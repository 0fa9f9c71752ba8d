// libserialport asks every port for its modem lines and refuses one that has none, such as a
// pseudo-terminal. This ioctl stands before the C library's for the whole test program: where the
// kernel knows no modem lines it says that they are there and all off, so that libserialport itself
// can be driven over a pseudo-terminal.
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>

extern "C" int ioctl(int descriptor, unsigned long request, ...) noexcept {
  va_list arguments;
  va_start(arguments, request);
  void* argument = va_arg(arguments, void*);
  va_end(arguments);
  const int result = static_cast<int>(syscall(SYS_ioctl, descriptor, request, argument));
  if (result == 0 || (errno != ENOTTY && errno != EINVAL)) return result;
  if (request == TIOCMGET) {
    *static_cast<int*>(argument) = 0;
    return 0;
  }
  const bool sets_them = request == TIOCMSET || request == TIOCMBIS || request == TIOCMBIC;
  return sets_them ? 0 : result;
}
