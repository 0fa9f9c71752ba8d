// What the daemon says of itself, and the socket on which it says it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

#include "tools/daemon/status.h"
#include "tools/document/render.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

DaemonStatus Sample() {
  return {.config = "d.toml",
          .utc = "2026-03-01T12:00:00.000Z",
          .sensors = {{.name = "left",
                       .port = "/dev/ttyUSB0",
                       .sensor = "keyence-il",
                       .state = LoopState::kRecording,
                       .since_utc = "2026-03-01T11:00:00.000Z",
                       .file = "/data/left.bin",
                       .readings = 172'800,
                       .rate_hz = 48.0,
                       .bad = 1,
                       .gaps = 2,
                       .lost = 3,
                       .reconnects = 4,
                       .disk_waits = 5,
                       .last_error = "went \"away\""},
                      {.name = "right", .state = LoopState::kAway, .since_utc = "x"}}};
}

TEST(DaemonStatus, ComesBackFromItsJson) {
  const auto read = ParseStatus(StatusJson(Sample()), "s");
  ASSERT_TRUE(read);
  ASSERT_EQ(read->sensors.size(), 2U);
  const SensorStatus& left = read->sensors[0];
  EXPECT_EQ(left.port, "/dev/ttyUSB0");
  EXPECT_EQ(left.state, LoopState::kRecording);
  EXPECT_EQ(left.readings, 172'800U);
  EXPECT_EQ(left.rate_hz, 48.0);
  EXPECT_EQ(left.disk_waits, 5U);
  EXPECT_EQ(left.last_error, "went \"away\"");
  EXPECT_FALSE(read->sensors[1].rate_hz);
  // every field of both
  EXPECT_EQ(StatusJson(*read), StatusJson(Sample()));
}

TEST(DaemonStatus, IsReadableByPeople) {
  const std::string text = document::TextOf(StatusDocument(Sample()), document::Detail::kShort);
  EXPECT_THAT(text, ::testing::StartsWith("d.toml: 1 of 2 recording; right: away\n"));
  EXPECT_THAT(text, ::testing::ContainsRegex(
                        " left +recording +2026-03-01T11:00:00.000Z +172800 +48.0 +1 +2 +3 +4 +5 "
                        "+/data/left.bin\n"));
  EXPECT_THAT(text, ::testing::ContainsRegex(" right +away +x +0 +- +0 +0 +0 +0 +0 +-\n"));
  EXPECT_THAT(text, HasSubstr("note: left: last error: went \"away\"\n"));
  EXPECT_EQ(StatusLine(Sample()), "1 of 2 recording; right: away");
}

TEST(DaemonStatus, AnythingElseIsNone) {
  for (const char* text : {"", "[]", "{}", "null", "{\"sensors\": 3}", "{\"sensors\": [{}]}",
                           "{\"sensors\": [{\"state\": 7}]}", "{\"sensors\": [[]]}", "\xff"}) {
    const auto status = ParseStatus(text, "s");
    ASSERT_FALSE(status) << text;
    EXPECT_EQ(status.error().cause, Cause::kCannotAnswer);
  }
}

class Sockets : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(directory_); }
  void TearDown() override { fs::remove_all(directory_); }
  const fs::path directory_ =
      fs::path(::testing::TempDir()) / ("status_socket_test_" + std::to_string(::getpid()));
  const std::string path_ = directory_ / "below" / "s.sock";
};

TEST_F(Sockets, WhoeverAsksIsAnswered) {
  const std::string long_text(300'000, 'x');  // more than a socket takes at once
  auto socket = StatusSocket::Listen(path_);
  ASSERT_TRUE(socket) << socket.error().Text();
  std::atomic<bool> done{false};
  std::thread daemon([&] {
    while (!done.load()) socket->AnswerOne(kNsPerS / 100, [&] { return long_text; });
  });
  for (int i = 0; i < 3; ++i) EXPECT_EQ(AskStatus(path_, 60 * kNsPerS), long_text);
  done.store(true);
  daemon.join();
}

TEST_F(Sockets, ALiveOneIsRefusedAndADeadOneReplaced) {
  {
    const auto first = StatusSocket::Listen(path_);
    ASSERT_TRUE(first);
    const auto second = StatusSocket::Listen(path_);
    ASSERT_FALSE(second);
    EXPECT_THAT(second.error().Text(), HasSubstr("another daemon answers there"));
    EXPECT_TRUE(fs::is_socket(path_));
  }
  EXPECT_FALSE(fs::exists(path_)) << "it takes its socket along";
  // a killed daemon leaves its socket
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path_.copy(address.sun_path, sizeof address.sun_path - 1);
  const int dead = ::socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(::bind(dead, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  close(dead);
  ASSERT_TRUE(fs::is_socket(path_));
  EXPECT_TRUE(StatusSocket::Listen(path_));
}

TEST_F(Sockets, NothingElseIsTakenOutOfTheWay) {
  fs::create_directories(fs::path(path_).parent_path());
  std::ofstream(path_) << "data";
  const auto socket = StatusSocket::Listen(path_);
  ASSERT_FALSE(socket);
  EXPECT_THAT(socket.error().Text(), HasSubstr("is there and no socket"));
  EXPECT_EQ(fs::file_size(path_), 4U);
}

TEST_F(Sockets, APathThatIsTooLongIsRefused) {
  const auto socket = StatusSocket::Listen(directory_ / std::string(120, 'x'));
  ASSERT_FALSE(socket);
  EXPECT_EQ(socket.error().cause, Cause::kUsage);
}

TEST_F(Sockets, SomebodyWhoSaysNothingIsGivenUp) {
  const auto socket = StatusSocket::Listen(path_);  // and nobody who answers
  ASSERT_TRUE(socket);
  const auto answer = AskStatus(path_, kNsPerS / 20);
  ASSERT_FALSE(answer);
  EXPECT_THAT(answer.error().Text(), HasSubstr("gives no status in time"));
}

TEST_F(Sockets, NobodyThereIsSaid) {
  const auto answer = AskStatus(path_, kNsPerS);
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().cause, Cause::kCannotAnswer);
  EXPECT_THAT(answer.error().Text(), HasSubstr("no daemon answers"));
}

}  // namespace
}  // namespace haptometer::tools
