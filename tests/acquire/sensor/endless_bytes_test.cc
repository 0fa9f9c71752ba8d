// A peer that never falls silent and ends no line, at once: whoever waits for a line looks
// at the clock and at the stop flag all the same.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>

#include "acquire/sensor/keyence/keyence_il.h"
#include "acquire/sensor/keyence/keyence_lkg.h"
#include "acquire/sensor/line_link.h"
#include "acquire/sensor/pipe_sensor.h"
#include "acquire/sensor/stream_sensor.h"

namespace haptometer::acquire {
namespace {

constexpr MonotonicNs kMs = 1'000'000;
constexpr MonotonicNs kReadNs = kMs;  // what 16 KiB take at 16 MB/s

// Each read fills the buffer. It ends by itself after a minute, so that a hang fails and ends.
class EndlessTransport final : public Transport {
 public:
  EndlessTransport(Clock& clock, std::string block) : clock_(clock), block_(std::move(block)) {}

  ReadOutcome Read(std::span<char> buffer, MonotonicNs /*deadline*/) override {
    if (clock_.Now() > 60 * kNsPerS) return {ReadState::kGone, 0};
    clock_.SleepUntil(clock_.Now() + kReadNs);
    for (char& byte : buffer) byte = block_[place_++ % block_.size()];
    return {ReadState::kBytes, buffer.size()};
  }
  Result<void> Write(std::string_view /*bytes*/, MonotonicNs /*deadline*/) override { return {}; }
  std::string Source() const override { return "device: endless"; }
  const std::string& name() const override { return name_; }

 private:
  Clock& clock_;
  std::string block_;
  std::size_t place_ = 0;
  std::string name_ = "endless";
};

class EndlessBytes : public ::testing::TestWithParam<const char*> {
 protected:
  std::string block_ = std::string(GetParam()) == "NUL" ? std::string(1, '\0') : GetParam();
  ManualClock clock_;
};

TEST_P(EndlessBytes, DoNotProlongTheWaitForALine) {
  for (const Delimiter delimiter : {Delimiter::kCr, Delimiter::kLf}) {
    LineLink link(std::make_unique<EndlessTransport>(clock_, block_), clock_, delimiter, 20);
    const MonotonicNs deadline = clock_.Now() + 100 * kMs;
    // lines that are too long are handed out one by one
    while (clock_.Now() < deadline && link.Read(deadline).state == LinkState::kOverlong) {
    }
    EXPECT_LE(clock_.Now(), deadline + kReadNs);
    EXPECT_LE(link.waiting_bytes(), 21U);
    EXPECT_LE(link.Read(clock_.Now()).bytes_behind, 20'000U) << "a deadline that is over";
    EXPECT_LE(clock_.Now(), deadline + 2 * kReadNs);
  }
}

TEST_P(EndlessBytes, EndAStartByItsPatienceAndByTheFlag) {
  const auto sensor = [&](int kind) -> std::unique_ptr<Sensor> {
    auto transport = std::make_unique<EndlessTransport>(clock_, block_);
    if (kind == 0) {
      return std::make_unique<KeyenceIl>(std::move(transport), KeyenceIlSetup{}, clock_);
    }
    if (kind == 1) {
      return std::make_unique<KeyenceLkg>(std::move(transport), KeyenceLkgSetup{}, clock_);
    }
    if (kind == 2)
      return std::make_unique<StreamSensor>(std::move(transport), StreamSetup{}, clock_);
    PipeSetup setup{.format = SampleFormat::kText, .rate_hz = 1000, .channels = {}};
    setup.channels.formats.resize(1);
    setup.channels.limits.resize(1);
    return std::make_unique<PipeSensor>(std::move(transport), std::move(setup), clock_);
  };
  for (int kind = 0; kind < 4; ++kind) {
    std::atomic<bool> stop{false};
    const MonotonicNs begin_ns = clock_.Now();
    EXPECT_FALSE(sensor(kind)->Start(stop)) << kind;
    EXPECT_LE(clock_.Now() - begin_ns, 4 * kNsPerS) << kind;
    stop = true;
    const MonotonicNs stopped_ns = clock_.Now();
    EXPECT_FALSE(sensor(kind)->Start(stop)) << kind;
    EXPECT_LE(clock_.Now() - stopped_ns, 200 * kMs) << kind;
  }
}

INSTANTIATE_TEST_SUITE_P(Blocks, EndlessBytes, ::testing::Values("\r", "\n", "\r\n", "+", "NUL"));

}  // namespace
}  // namespace haptometer::acquire
