// Lines over a network, which come in blocks: the wire's speed shows the times of none.
#include <gtest/gtest.h>

#include <memory>

#include "acquire/sensor/stream_sensor.h"
#include "tests/acquire/scripted_transport.h"
#include "tests/acquire/sensor_rows.h"
#include "tests/residual.h"
#include "trial/time_base.h"

namespace haptometer::acquire {
namespace {

// a scripted transport behind which no wire of known speed is
class Network final : public Transport {
 public:
  explicit Network(Clock& clock) : scripted(clock) {}

  ReadOutcome Read(std::span<char> buffer, MonotonicNs deadline) override {
    return scripted.Read(buffer, deadline);
  }
  Result<void> Write(std::string_view bytes, MonotonicNs deadline) override {
    return scripted.Write(bytes, deadline);
  }
  std::string Source() const override { return scripted.Source(); }
  std::optional<MonotonicNs> LatencyTimer() const override { return {}; }
  bool IsHardware() const override { return false; }
  const std::string& name() const override { return scripted.name(); }

  tests::ScriptedTransport scripted;
};

// 1200 lines each 0.4 s: as the wire's speed spread them, 10 240 lines/s came, and silences
TEST(StreamBlocks, ShowTheRateOfTheSource) {
  constexpr MonotonicNs kBlockNs = 400'000'000;
  ManualClock clock;
  auto network = std::make_unique<Network>(clock);
  std::string lines;
  for (int j = 0; j < 1200; ++j) lines += "+00.0001\r";
  for (int k = 0; k < 18; ++k) network->scripted.Send(lines, k * kBlockNs);
  StreamSensor sensor(std::move(network), {}, clock);
  ASSERT_TRUE(StartAndBegin(sensor));
  std::vector<std::int64_t> times_ns;
  Reading reading;
  while (clock.Now() < 17 * kBlockNs + kBlockNs / 2) {
    if (sensor.Next(reading) == Outcome::kReading) times_ns.push_back(reading.time_ns);
  }
  const auto stretches = trial::FitArrivalTimes(times_ns, std::nullopt);
  ASSERT_EQ(stretches.size(), 1);
  EXPECT_REL(stretches[0].rate_hz, 3000, 1e-9, "blocks of one length");
  EXPECT_ABS(stretches[0].time_uncertainty_s, 0.4, 1e-12, "a block");
}

}  // namespace
}  // namespace haptometer::acquire
