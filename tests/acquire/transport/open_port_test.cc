// Bytes over real pseudo-terminals, pipes and loopback TCP; libserialport over a pseudo-terminal by
// modem_lines_shim.cc.
#include "acquire/transport/open_port.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <array>
#include <cerrno>
#include <filesystem>

#include "acquire/transport/descriptor.h"
#include "tests/acquire/pty_pair.h"

namespace haptometer::acquire {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;
using tests::In;
using tests::PtyPair;

constexpr double kLong_s = 10;  // never waited for where the code is right

std::string ReadAll(Transport& transport, std::size_t size) {
  std::string all;
  std::array<char, 5> buffer{};  // small, so that more than one read is needed
  while (all.size() < size) {
    const ReadOutcome outcome = transport.Read(buffer, In(kLong_s));
    if (outcome.state != ReadState::kBytes) break;
    all.append(buffer.data(), outcome.bytes);
  }
  return all;
}

ReadState StateOf(Transport& transport, MonotonicNs deadline) {
  std::array<char, 16> buffer{};
  return transport.Read(buffer, deadline).state;
}

// every byte value both ways, silence, then a hang-up after the last bytes
void ExpectAWorkingLine(Transport& port, PtyPair& device) {
  std::string every;
  for (int byte = 0; byte < 256; ++byte) every += static_cast<char>(byte);
  device.Send(every);
  EXPECT_EQ(ReadAll(port, every.size()), every);
  ASSERT_TRUE(port.Write(every, In(kLong_s)));
  EXPECT_EQ(device.Receive(every.size()), every);
  EXPECT_EQ(StateOf(port, In(0)), ReadState::kTimeout);
  EXPECT_EQ(StateOf(port, In(0.01)), ReadState::kTimeout);
  device.HangUp();
  EXPECT_EQ(StateOf(port, In(kLong_s)), ReadState::kGone);
  EXPECT_EQ(StateOf(port, In(kLong_s)), ReadState::kGone);
  const auto written = port.Write("M0\r\n", In(kLong_s));
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().cause, Cause::kFailed);
  EXPECT_THAT(written.error().Text(), HasSubstr("connection was lost"));
}

// a name under which libserialport takes a pseudo-terminal: it looks below /sys/class/tty, so the
// path climbs out of there to a link that points to it
class PortLink {
 public:
  explicit PortLink(const std::string& target)
      : link_(fs::path(::testing::TempDir()) / ("port_link_" + std::to_string(getpid()))) {
    fs::remove(link_);
    fs::create_symlink(target, link_);
  }
  PortLink(const PortLink&) = delete;
  PortLink& operator=(const PortLink&) = delete;
  ~PortLink() { fs::remove(link_); }
  [[nodiscard]] std::string name() const { return "/dev/../../.." + fs::absolute(link_).string(); }
  [[nodiscard]] std::string path() const { return link_; }

 private:
  fs::path link_;
};

TEST(VirtualTerminal, MovesBytesAndSeesTheHangUp) {
  PtyPair device;
  auto port = OpenPort(device.path(), 9600);
  ASSERT_TRUE(port) << port.error().Text();
  EXPECT_EQ((*port)->Source(), "virtual terminal " + device.path() + " (not a hardware port)");
  ExpectAWorkingLine(**port, device);
}

TEST(VirtualTerminal, IsFoundThroughALink) {
  PtyPair device;
  const PortLink link(device.path());
  auto port = OpenPort(link.path(), 9600);
  ASSERT_TRUE(port) << port.error().Text();
  EXPECT_THAT((*port)->Source(), HasSubstr(link.path()));
}

TEST(VirtualTerminal, ForgetsWhatWaitedInThePort) {
  PtyPair device;
  device.Send("stale");
  auto port = OpenPort(device.path(), 9600);
  ASSERT_TRUE(port);
  EXPECT_EQ(StateOf(**port, In(0.01)), ReadState::kTimeout);
}

TEST(SerialPort, LibserialportMovesBytesAndSeesTheHangUp) {
  PtyPair device;
  const PortLink link(device.path());
  auto port = OpenSerialPort(link.name(), "/dev/ttyUSB0", 38400);
  ASSERT_TRUE(port) << port.error().Text();
  EXPECT_EQ((*port)->Source(), "device: serial port /dev/ttyUSB0, 38400 baud 8N1");
  // the settings that reached the line
  termios settings{};
  ASSERT_EQ(tcgetattr(device.master(), &settings), 0);
  EXPECT_EQ(cfgetospeed(&settings), static_cast<speed_t>(B38400));
  EXPECT_EQ(settings.c_cflag & CSIZE, static_cast<tcflag_t>(CS8));
  EXPECT_EQ(settings.c_cflag & (PARENB | CSTOPB | CRTSCTS), 0U);
  EXPECT_EQ(settings.c_iflag & (IXON | IXOFF), 0U);
  ExpectAWorkingLine(**port, device);
}

TEST(SerialPort, LeavesStandardOutputOpen) {
  struct stat before{};
  ASSERT_EQ(fstat(STDOUT_FILENO, &before), 0);
  {
    const PtyPair device;
    const PortLink link(device.path());
    EXPECT_TRUE(OpenSerialPort(link.name(), "/dev/ttyUSB0", 38400));
  }
  struct stat after{};
  ASSERT_EQ(fstat(STDOUT_FILENO, &after), 0);
  EXPECT_EQ(after.st_dev, before.st_dev);
  EXPECT_EQ(after.st_ino, before.st_ino);
}

void ExpectBusy(const Result<std::unique_ptr<Transport>>& second, const std::string& name) {
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().cause, Cause::kCannotAnswer);
  EXPECT_THAT(second.error().Text(), HasSubstr(name + ": is busy"));
  EXPECT_THAT(second.error().Text(), HasSubstr("end that program"));
}

TEST(PortLock, ASecondOpenIsRefusedAndTheFirstWorksOn) {
  PtyPair device;
  auto first = OpenPort(device.path(), 9600);
  ASSERT_TRUE(first);
  ExpectBusy(OpenPort(device.path(), 9600), device.path());
  const PortLink link(device.path());
  ExpectBusy(OpenSerialPort(link.name(), "/dev/ttyUSB0", 9600), "/dev/ttyUSB0");
  device.Send("still ours");
  EXPECT_EQ(ReadAll(**first, 10), "still ours");
  // free again afterwards
  first->reset();
  EXPECT_TRUE(OpenPort(device.path(), 9600));
}

TEST(PortLock, ASerialPortIsFreeAgainAfterwards) {
  PtyPair device;
  const PortLink link(device.path());
  {
    auto first = OpenSerialPort(link.name(), "/dev/ttyUSB0", 9600);
    ASSERT_TRUE(first) << first.error().Text();
    ExpectBusy(OpenPort(device.path(), 9600), device.path());
  }
  EXPECT_TRUE(OpenPort(device.path(), 9600));
}

TEST(PortLock, ABusyPortsSettingsAreLeftAlone) {
  PtyPair device;
  const OwnedDescriptor other(open(device.path().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  ASSERT_EQ(flock(other.get(), LOCK_EX), 0);
  termios before{};
  ASSERT_EQ(tcgetattr(other.get(), &before), 0);
  before.c_iflag |= ICRNL;
  before.c_cc[VMIN] = 7;
  ASSERT_EQ(tcsetattr(other.get(), TCSANOW, &before), 0);
  const PortLink link(device.path());
  ExpectBusy(OpenSerialPort(link.name(), "/dev/ttyUSB0", 38400), "/dev/ttyUSB0");
  termios after{};
  ASSERT_EQ(tcgetattr(other.get(), &after), 0);
  EXPECT_EQ(after.c_iflag, before.c_iflag);
  EXPECT_EQ(after.c_cflag, before.c_cflag);
  EXPECT_EQ(after.c_cc[VMIN], 7);
}

TEST(PortHolder, NamesTheProcessThatHasThePortOpen) {
  PtyPair device;
  std::array<int, 2> ready{};
  ASSERT_EQ(pipe(ready.data()), 0);
  const pid_t holder = fork();
  if (holder == 0) {
    const int port = open(device.path().c_str(), O_RDWR | O_NOCTTY);
    flock(port, LOCK_EX);
    (void)!write(ready[1], "x", 1);
    pause();
    _exit(0);
  }
  char byte = 0;
  ASSERT_EQ(read(ready[0], &byte, 1), 1);
  EXPECT_THAT(PortHolder(device.path()), HasSubstr("(process " + std::to_string(holder) + ")"));
  const auto second = OpenPort(device.path(), 9600);
  ExpectBusy(second, device.path());
  // taken by flock, and by TIOCEXCL: the same words, and the same name
  const std::string named = "(process " + std::to_string(holder) + ") holds it; end that program";
  EXPECT_THAT(second.error().Text(), HasSubstr(named));
  EXPECT_EQ(PortDoesNotOpen(device.path(), EBUSY).Text(), second.error().Text());
  kill(holder, SIGKILL);
  waitpid(holder, nullptr, 0);
  EXPECT_EQ(PortHolder("/no/such/port"), "");
}

TEST(Descriptor, AReadableDescriptorWithoutBytesIsGone) {
  // a removed USB port: poll says readable, read gives 0
  std::array<int, 2> pair{};
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, pair.data()), 0);
  const OwnedDescriptor port(pair[0]);
  {
    const OwnedDescriptor device(pair[1]);
    ASSERT_EQ(write(device.get(), "last", 4), 4);
  }
  std::array<char, 16> buffer{};
  const ReadOutcome last = ReadDescriptor(port.get(), buffer, In(kLong_s));
  EXPECT_EQ(last.state, ReadState::kBytes);
  EXPECT_EQ(last.bytes, 4U);
  EXPECT_EQ(ReadDescriptor(port.get(), buffer, In(kLong_s)).state, ReadState::kGone);
}

TEST(Descriptor, AnInputErrorIsGone) {
  // the other way round: a master whose slave has closed reads EIO
  PtyPair pair;
  {
    const OwnedDescriptor slave(open(pair.path().c_str(), O_RDWR | O_NOCTTY));
  }
  std::array<char, 16> buffer{};
  EXPECT_EQ(ReadDescriptor(pair.master(), buffer, In(kLong_s)).state, ReadState::kGone);
  EXPECT_EQ(errno, EIO);
}

TEST(Descriptor, AFullPortIsReportedAtTheDeadline) {
  PtyPair device;
  auto port = OpenPort(device.path(), 9600);
  ASSERT_TRUE(port);
  const auto written = (*port)->Write(std::string(1 << 20, 'x'), In(0.05));
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().Text(), HasSubstr("does not take bytes"));
}

class LoopbackServer {
 public:
  LoopbackServer() : listener_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* generic = reinterpret_cast<sockaddr*>(&address);
    EXPECT_EQ(bind(listener_.get(), generic, size), 0);
    EXPECT_EQ(listen(listener_.get(), 1), 0);
    EXPECT_EQ(getsockname(listener_.get(), generic, &size), 0);
    port_ = std::to_string(ntohs(address.sin_port));
  }
  [[nodiscard]] OwnedDescriptor Accept() const {
    return OwnedDescriptor(accept(listener_.get(), nullptr, nullptr));
  }
  [[nodiscard]] const std::string& port() const { return port_; }

 private:
  OwnedDescriptor listener_;
  std::string port_;
};

TEST(TcpStream, MovesBytesAndSeesTheHangUp) {
  signal(SIGPIPE, SIG_IGN);
  const LoopbackServer server;
  for (const std::string host : {"127.0.0.1", "localhost"}) {
    auto port = OpenPort(host + ":" + server.port(), 9600);
    ASSERT_TRUE(port) << port.error().Text();
    const OwnedDescriptor device = server.Accept();
    ASSERT_TRUE((*port)->Write("M0\r\n", In(kLong_s)));
    std::array<char, 4> got{};
    ASSERT_EQ(recv(device.get(), got.data(), got.size(), MSG_WAITALL), 4);
    EXPECT_EQ(std::string(got.data(), 4), "M0\r\n");
    ASSERT_EQ(write(device.get(), "M0,+00.001\r\n", 12), 12);
    EXPECT_EQ(ReadAll(**port, 12), "M0,+00.001\r\n");
    EXPECT_EQ(StateOf(**port, In(0.01)), ReadState::kTimeout);
    shutdown(device.get(), SHUT_RDWR);
    EXPECT_EQ(StateOf(**port, In(kLong_s)), ReadState::kGone);
    EXPECT_THAT((*port)->Source(), HasSubstr("TCP connection " + host));
  }
}

TEST(TcpStream, SaysWhyItDoesNotConnect) {
  std::string port;
  {
    port = LoopbackServer().port();
  }  // nobody listens there any more
  const auto refused = OpenPort("127.0.0.1:" + port, 9600);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().cause, Cause::kCannotAnswer);
  EXPECT_THAT(refused.error().Text(), HasSubstr("does not connect: Connection refused; "));
  const auto unknown = OpenPort("no-such-host.invalid:64000", 9600);
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().Text(), HasSubstr("the host is not known"));
}

TEST(CommandPipe, HandsOutWhatTheCommandWritesAndThenItsEnd) {
  auto pipe = OpenCommandPipe("printf abcdefgh");
  ASSERT_TRUE(pipe) << pipe.error().Text();
  EXPECT_EQ(ReadAll(**pipe, 8), "abcdefgh");
  EXPECT_EQ(StateOf(**pipe, In(kLong_s)), ReadState::kGone);
  EXPECT_EQ((*pipe)->Source(), "piped in by: printf abcdefgh");
  EXPECT_FALSE((*pipe)->Write("x", In(kLong_s)));
}

TEST(CommandPipe, EndsItsCommand) {
  auto pipe = OpenCommandPipe("echo $$; exec sleep 60");
  ASSERT_TRUE(pipe) << pipe.error().Text();
  std::string number;
  while (!number.ends_with('\n')) number += ReadAll(**pipe, 1);
  const auto process = static_cast<pid_t>(std::stoi(number));
  EXPECT_EQ(kill(process, 0), 0) << "it runs";
  pipe->reset();
  EXPECT_EQ(kill(process, 0), -1);
  EXPECT_EQ(errno, ESRCH);
}

TEST(NetworkName, IsSplitAtItsLastColon) {
  const auto parts = [](const std::string& name) {
    const NetworkName split = SplitNetworkName(name);
    return split.host + " " + split.service;
  };
  EXPECT_EQ(parts("localhost:64000"), "localhost 64000");
  EXPECT_EQ(parts("[::1]:502"), "::1 502");
  EXPECT_EQ(parts("::1:502"), "::1 502");
  EXPECT_EQ(parts("[::1:502"), "[::1 502") << "one bracket alone is left";
}

TEST(Descriptor, SaysWhyAPortDoesNotOpen) {
  const auto text = [](int error_number) { return PortDoesNotOpen("tty", error_number).Text(); };
  for (const int gone : {ENOENT, ENODEV, ENXIO}) {
    EXPECT_THAT(text(gone), HasSubstr("tty: is not there; plug"));
  }
  for (const int refused : {EACCES, EPERM}) {
    EXPECT_THAT(text(refused), HasSubstr("tty: may not be opened by this user; join its group"));
  }
  EXPECT_THAT(text(EBUSY), HasSubstr("tty: is busy: another program holds it; end that program"));
  EXPECT_THAT(text(EIO), HasSubstr("tty: does not open: "));
}

TEST(TcpPort, IsANumberUpTo65535) {
  EXPECT_EQ(TcpPort("0"), 0);
  EXPECT_EQ(TcpPort("65535"), 65535);
  for (const char* text : {"65536", "-1", "", "80 ", "http"}) EXPECT_FALSE(TcpPort(text)) << text;
}

TEST(OpenPort, APortOfZeroIsNone) {
  EXPECT_EQ(KindOfPort("127.0.0.1:1").value(), PortKind::kNetwork);
  EXPECT_EQ(KindOfPort("127.0.0.1:65535").value(), PortKind::kNetwork);
  for (const char* name : {"127.0.0.1:0", "127.0.0.1:65536"}) {
    const auto kind = KindOfPort(name);
    ASSERT_FALSE(kind) << name;
    EXPECT_EQ(kind.error().cause, Cause::kUsage);
    EXPECT_THAT(kind.error().Text(), HasSubstr("a port from 1 to 65535"));
  }
}

TEST(OpenPort, APathOrANameWithoutAPortIsNoNetworkName) {
  for (const char* name :
       {"/no/such:1", "./a:1", ":80", "12345", "localhost:", "localhost:1a", "localhost:-1", ""}) {
    const auto kind = KindOfPort(name);
    ASSERT_FALSE(kind) << name;
    EXPECT_EQ(kind.error().cause, Cause::kCannotAnswer) << name;
    EXPECT_THAT(kind.error().Text(), Not(HasSubstr("TCP port"))) << name;
  }
  EXPECT_EQ(KindOfPort("[::1]:64000").value(), PortKind::kNetwork);
  EXPECT_EQ(KindOfPort("h:1").value(), PortKind::kNetwork);
}

TEST(OpenPort, NamesThePortTheFaultAndTheRemedy) {
  const auto text = [](const std::string& name) {
    const auto port = OpenPort(name, 9600);
    EXPECT_FALSE(port);
    EXPECT_EQ(port.error().cause, Cause::kCannotAnswer);
    return port.error().Text();
  };
  EXPECT_THAT(text("/dev/ttyNOT0"), HasSubstr("/dev/ttyNOT0: is not there; plug the sensor in"));
  EXPECT_THAT(text("/tmp"), HasSubstr("/tmp: is not a port; "));
  EXPECT_THAT(text("/dev/null"), HasSubstr("/dev/null: is not a serial port; "));
  EXPECT_THAT(PortDoesNotOpen("/dev/ttyUSB0", EACCES).Text(), HasSubstr("usermod -aG dialout"));
  EXPECT_THAT(PortDoesNotOpen("/dev/ttyUSB0", EBUSY).Text(), HasSubstr("is busy"));
  EXPECT_THAT(PortDoesNotOpen("/dev/ttyUSB0", EMFILE).Text(), HasSubstr("Too many open files"));
}

}  // namespace
}  // namespace haptometer::acquire
