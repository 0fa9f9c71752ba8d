// The emulator over real pseudo-terminals and sockets. No time is asserted: only what arrives.
#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "acquire/emulator/dl_unit.h"
#include "acquire/emulator/server.h"
#include "acquire/emulator/stream_head.h"
#include "acquire/transport/descriptor.h"

namespace haptometer::acquire::emulator {
namespace {

namespace fs = std::filesystem;
constexpr int kDeadlineMs = 20'000;

// a device in a thread of its own, from construction to Stop()
class Running {
 public:
  Running(std::unique_ptr<Device> device, std::unique_ptr<Endpoint> endpoint)
      : device_(std::move(device)), endpoint_(std::move(endpoint)) {
    thread_ = std::thread([this] {
      report_ = Serve(*device_, *endpoint_, stop_, std::nullopt, [this](const std::string& name) {
        const std::lock_guard lock(mutex_);
        names_.push_back(name);
      });
      endpoint_.reset();
    });
    while (Names().empty()) std::this_thread::yield();
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;
  ~Running() { Join(); }

  Result<ServeReport> Stop() {
    Join();
    return report_;
  }
  std::vector<std::string> Names() {
    const std::lock_guard lock(mutex_);
    return names_;
  }

 private:
  void Join() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

  std::unique_ptr<Device> device_;
  std::unique_ptr<Endpoint> endpoint_;
  std::atomic<bool> stop_{false};
  std::mutex mutex_;
  std::vector<std::string> names_;
  Result<ServeReport> report_;
  std::thread thread_;
};

std::unique_ptr<Device> Unit(std::string_view faults = "") {
  DlRs1aSetup setup;
  setup.head = {.head = trial::Il030(), .displacement = [](double) { return 1.234e-3; }};
  setup.head.head.noise_rms_m = 0;
  setup.baud = 38400;
  setup.processing_ns = 100'000;
  if (!faults.empty()) setup.faults = *ParseFaultPlan(faults);
  return std::make_unique<DlRs1aUnit>(std::move(setup));
}

// line k reads k modulo 100 000 steps
std::unique_ptr<Device> Counter(double rate_hz, std::string_view faults = "") {
  StreamSetup setup;
  setup.head.head = {.name = "counter",
                     .sampling_s = 1 / rate_hz,
                     .resolution_m = 1e-7,
                     .range_min_m = -1,
                     .range_max_m = 1};
  setup.head.displacement = [rate_hz](double t_s) {
    return 1e-7 * static_cast<double>(std::llround(t_s * rate_hz) % 100'000);
  };
  setup.baud = 20'000'000;
  if (!faults.empty()) setup.faults = *ParseFaultPlan(faults);
  return std::make_unique<StreamHead>(std::move(setup));
}

std::unique_ptr<Endpoint> Pty(const std::string& link = "") {
  auto endpoint = OpenPty(link);
  EXPECT_TRUE(endpoint) << endpoint.error().Text();
  return std::move(*endpoint);
}

OwnedDescriptor OpenPath(const std::string& path) {
  return OwnedDescriptor(open(path.c_str(), O_RDWR | O_NOCTTY));
}

// bytes until `enough` of them are there; nothing more comes after a hang-up or the deadline
std::string ReadAtLeast(int descriptor, std::size_t enough) {
  std::string bytes;
  while (bytes.size() < enough) {
    pollfd watched{.fd = descriptor, .events = POLLIN, .revents = 0};
    if (poll(&watched, 1, kDeadlineMs) <= 0) break;
    char buffer[4096];
    const ssize_t count = read(descriptor, buffer, sizeof buffer);
    if (count <= 0) break;
    bytes.append(buffer, static_cast<std::size_t>(count));
  }
  return bytes;
}

std::string Ask(int descriptor, const std::string& request, std::size_t answer_size) {
  EXPECT_EQ(write(descriptor, request.data(), request.size()),
            static_cast<ssize_t>(request.size()));
  return ReadAtLeast(descriptor, answer_size);
}

// the numbers of the whole lines in `bytes`, whose first line may be cut
std::vector<int> Numbers(const std::string& bytes) {
  std::vector<int> numbers;
  std::size_t at = bytes.find('\r') + 1;
  for (; at + 9 <= bytes.size(); at += 9) {
    const std::string line = bytes.substr(at, 9);
    EXPECT_EQ(line[0], '+') << at;
    EXPECT_EQ(line[8], '\r') << at;
    numbers.push_back(std::stoi(line.substr(1, 2) + line.substr(4, 4)));
  }
  return numbers;
}

// --- a pseudo-terminal --------------------------------------------------------------------------

TEST(EmulatorOnPty, IsARawTerminalThatAnswers) {
  Running running(Unit(), Pty());
  const OwnedDescriptor port = OpenPath(running.Names().front());
  termios settings{};
  ASSERT_EQ(tcgetattr(port.get(), &settings), 0);
  EXPECT_EQ(settings.c_lflag & (ECHO | ICANON | ISIG), 0U);
  EXPECT_EQ(settings.c_cflag & (CSIZE | PARENB | CSTOPB), static_cast<tcflag_t>(CS8));
  for (int poll = 0; poll < 20; ++poll) {
    ASSERT_EQ(Ask(port.get(), "M0\r\n", 12), "M0,+01.234\r\n") << poll;
  }
  EXPECT_EQ(running.Stop()->bytes, 20U * 12);
}

TEST(EmulatorOnPty, OpensWhereStandardInputIsClosed) {
  // the terminal is descriptor 0 then
  const int kept = fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 3);
  close(STDIN_FILENO);
  const bool is_open = OpenPty("").has_value();
  if (kept >= 0) {
    dup2(kept, STDIN_FILENO);
    close(kept);
  }
  EXPECT_TRUE(is_open);
}

TEST(EmulatorOnPty, LosesNoLineForOneWhoReads) {
  constexpr int kLinesPerS = 2000;
  const auto begin = std::chrono::steady_clock::now();
  Running running(Counter(kLinesPerS), Pty());
  const OwnedDescriptor port = OpenPath(running.Names().front());
  const std::vector<int> numbers = Numbers(ReadAtLeast(port.get(), 9000));
  const auto report = running.Stop();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  ASSERT_GT(numbers.size(), 900U);
  int missing = 0;
  for (std::size_t i = 1; i < numbers.size(); ++i) missing += numbers[i] - numbers[i - 1] - 1;
  EXPECT_LE(missing, static_cast<int>(report->dropped_lines));
  // while all that was sent has room, even if a machine that stands still leaves it unread
  if (took.count() * kLinesPerS * 9 < LineWriter::kPortRoom) {
    EXPECT_EQ(report->dropped_lines, 0U) << took.count() << " s";
  } else {
    GTEST_SKIP() << "the machine stood still: " << took.count() << " s for half a second's lines";
  }
}

TEST(EmulatorOnPty, LosesWholeCountedLinesWhenNobodyReads) {
  Running running(Counter(200'000), Pty());
  const OwnedDescriptor port = OpenPath(running.Names().front());
  // 1.8 MB/s into 64 KiB and what the terminal takes; the stall is as long as it takes to be sure
  std::string bytes = ReadAtLeast(port.get(), 9);
  usleep(300'000);
  bytes += ReadAtLeast(port.get(), 200'000);
  const auto report = running.Stop();
  const std::vector<int> numbers = Numbers(bytes);
  std::uint64_t missing = 0;
  for (std::size_t i = 1; i < numbers.size(); ++i) {
    missing += static_cast<std::uint64_t>((numbers[i] - numbers[i - 1] + 99'999) % 100'000);
  }
  EXPECT_GT(missing, 10'000U);
  EXPECT_GE(report->dropped_lines, missing);
}

TEST(EmulatorOnPty, ServesTheNextHostAfterOneHasGone) {
  Running running(Unit(), Pty());
  for (int host = 0; host < 3; ++host) {
    const OwnedDescriptor port = OpenPath(running.Names().front());
    EXPECT_EQ(Ask(port.get(), "M0\r\n", 12), "M0,+01.234\r\n") << host;
  }
}

TEST(EmulatorOnPty, ComesBackUnderAnotherNameAfterItDroppedOffTheLine) {
  Running running(Unit("disconnect:2"), Pty());
  const OwnedDescriptor port = OpenPath(running.Names().front());
  EXPECT_EQ(Ask(port.get(), "M0\r\n", 12), "M0,+01.234\r\n");
  EXPECT_EQ(Ask(port.get(), "M0\r\n", 12), "");
  while (running.Names().size() < 2) std::this_thread::yield();
  EXPECT_NE(running.Names().back(), running.Names().front());
  const OwnedDescriptor again = OpenPath(running.Names().back());
  EXPECT_EQ(Ask(again.get(), "M0\r\n", 12), "M0,+01.234\r\n");
  EXPECT_EQ(running.Stop()->hang_ups, 1U);
}

// --- its link -----------------------------------------------------------------------------------

class EmulatorLink : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(directory_); }
  void TearDown() override { fs::remove_all(directory_); }
  const fs::path directory_ =
      fs::path(::testing::TempDir()) / ("emulator_link_" + std::to_string(::getpid()));
  const std::string link_ = directory_ / "sensor";
};

TEST_F(EmulatorLink, LeadsToTheTerminalAndGoesWithIt) {
  {
    Running running(Unit("disconnect:2"), Pty(link_));
    EXPECT_EQ(running.Names().front(), link_);
    const OwnedDescriptor port = OpenPath(link_);
    const fs::path before = fs::read_symlink(link_);
    EXPECT_EQ(Ask(port.get(), "M0\r\n", 12), "M0,+01.234\r\n");
    EXPECT_EQ(Ask(port.get(), "M0\r\n", 12), "");
    // it follows the terminal that replaces a pulled one
    while (fs::read_symlink(link_) == before) std::this_thread::yield();
    const OwnedDescriptor again = OpenPath(link_);
    EXPECT_EQ(Ask(again.get(), "M0\r\n", 12), "M0,+01.234\r\n");
  }
  EXPECT_FALSE(fs::exists(fs::symlink_status(link_)));
}

TEST_F(EmulatorLink, ReplacesAStaleLinkAndNothingElse) {
  fs::create_symlink("/dev/pts/99999", link_);
  EXPECT_TRUE(OpenPty(link_));
  std::ofstream(link_) << "somebody's file";
  const auto file = OpenPty(link_);
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().Text(),
            link_ + ": exists and is not a link to a terminal; remove it or give another name");
  EXPECT_TRUE(fs::is_regular_file(link_));
  EXPECT_EQ(file.error().cause, Cause::kFailed);

  const auto nowhere = OpenPty(directory_ / "absent" / "sensor");
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(nowhere.error().what, "cannot be linked: No such file or directory");
}

TEST_F(EmulatorLink, LeavesALinkThatIsNoLongerItsOwn) {
  {
    const auto endpoint = Pty(link_);
    fs::remove(link_);
    fs::create_symlink("/dev/pts/99999", link_);
  }
  EXPECT_EQ(fs::read_symlink(link_), "/dev/pts/99999");
}

// --- TCP ----------------------------------------------------------------------------------------

OwnedDescriptor Connect(const std::string& name) {
  const std::size_t colon = name.rfind(':');
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(name.substr(colon + 1))));
  inet_pton(AF_INET, name.substr(0, colon).c_str(), &address.sin_addr);
  OwnedDescriptor host(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  EXPECT_EQ(connect(host.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  return host;
}

std::unique_ptr<Endpoint> Tcp() {
  auto endpoint = ListenTcp("127.0.0.1:0");
  EXPECT_TRUE(endpoint) << endpoint.error().Text();
  return std::move(*endpoint);
}

TEST(EmulatorOnTcp, ServesOneHostAfterTheOther) {
  Running running(Unit(), Tcp());
  EXPECT_TRUE(running.Names().front().starts_with("127.0.0.1:"));
  EXPECT_NE(running.Names().front(), "127.0.0.1:0");
  for (int host = 0; host < 3; ++host) {
    const OwnedDescriptor port = Connect(running.Names().front());
    EXPECT_EQ(Ask(port.get(), "M0\r\n", 12), "M0,+01.234\r\n") << host;
  }
}

TEST(EmulatorOnTcp, LosesNoLineForOneWhoReads) {
  Running running(Counter(10'000), Tcp());
  const OwnedDescriptor port = Connect(running.Names().front());
  const std::vector<int> numbers = Numbers(ReadAtLeast(port.get(), 45'000));
  ASSERT_GT(numbers.size(), 4900U);
  for (std::size_t i = 1; i < numbers.size(); ++i) ASSERT_EQ(numbers[i], numbers[i - 1] + 1);
}

TEST(EmulatorOnTcp, DropsTheConnectionAndTakesTheNext) {
  Running running(Unit("disconnect:2"), Tcp());
  const OwnedDescriptor port = Connect(running.Names().front());
  EXPECT_EQ(Ask(port.get(), "M0\r\n", 12), "M0,+01.234\r\n");
  EXPECT_EQ(Ask(port.get(), "M0\r\n", 12), "");
  const OwnedDescriptor again = Connect(running.Names().front());
  EXPECT_EQ(Ask(again.get(), "M0\r\n", 12), "M0,+01.234\r\n");
}

TEST(EmulatorOnTcp, RefusesWhatIsNoAddress) {
  for (const char* text : {"", "5000", ":5000", "localhost:"}) {
    const auto endpoint = ListenTcp(text);
    ASSERT_FALSE(endpoint) << text;
    EXPECT_EQ(endpoint.error().cause, Cause::kUsage);
    EXPECT_EQ(endpoint.error().remedy, "give 127.0.0.1:0, for example");
  }
  // the system would take the port modulo 65536
  for (const char* text : {"127.0.0.1:http", "127.0.0.1:65536", "127.0.0.1:99999", "127.0.0.1:-1",
                           "127.0.0.1:+5", "[::1]:70001", "localhost:4294967297"}) {
    const auto endpoint = ListenTcp(text);
    ASSERT_FALSE(endpoint) << text;
    EXPECT_EQ(endpoint.error().cause, Cause::kUsage);
    EXPECT_EQ(endpoint.error().remedy, "give a port from 1 to 65535, or 0 for any free one");
  }
  const auto first = ListenTcp("127.0.0.1:0");
  ASSERT_TRUE(first);
  const auto second = ListenTcp((*first)->name());
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().cause, Cause::kFailed);
  EXPECT_EQ(second.error().what, "cannot be listened on: Address already in use");
}

// --- ends ---------------------------------------------------------------------------------------

TEST(EmulatorServer, EndsAfterItsTime) {
  const auto device = Unit();
  const auto endpoint = Pty();
  const std::atomic<bool> stop{false};
  int announced = 0;
  const auto report =
      Serve(*device, *endpoint, stop, 5'000'000, [&](const std::string& /*name*/) { ++announced; });
  ASSERT_TRUE(report);
  EXPECT_EQ(announced, 1);
  EXPECT_EQ(report->bytes, 0U);
}

}  // namespace
}  // namespace haptometer::acquire::emulator
