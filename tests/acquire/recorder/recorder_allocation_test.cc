// Recording allocates nothing once it runs: counted in every thread of this program.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <new>
#include <string_view>
#include <utility>

#include "acquire/recorder/recorder.h"
#include "acquire/sensor/keyence/keyence_il.h"
#include "acquire/sensor/keyence/keyence_lkg.h"
#include "acquire/sensor/modbus_sensor.h"
#include "acquire/sensor/pipe_sensor.h"
#include "acquire/sensor/stream_sensor.h"
#include "tests/acquire/counting_sensor.h"
#include "trial/trial_writer.h"

namespace {

std::atomic<bool> counting{false};
std::atomic<int> allocations{0};

void* Allocate(std::size_t bytes) {
  if (counting.load()) ++allocations;
  if (void* memory = std::malloc(bytes)) return memory;
  throw std::bad_alloc();
}

}  // namespace

// with the sanitizers' own operators out of the way, malloc and free still are theirs
void* operator new(std::size_t bytes) { return Allocate(bytes); }
void* operator new[](std::size_t bytes) { return Allocate(bytes); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t /*bytes*/) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t /*bytes*/) noexcept { std::free(memory); }

namespace haptometer::acquire {
namespace {

/// Takes everything.
class NullSink final : public trial::ByteSink {
 public:
  Result<std::size_t> WriteSome(std::span<const std::byte> bytes) override { return bytes.size(); }
  Result<void> Sync() override { return {}; }
};

/// Says what it is told to, again and again: an answer to each request, or lines unasked.
class ParrotTransport final : public Transport {
 public:
  ParrotTransport(std::string_view line, Clock& clock, bool unasked,
                  std::string_view refusal = "ER,SR,22\r\n")
      : line_(line), refusal_(refusal), clock_(clock), unasked_(unasked) {}
  ReadOutcome Read(std::span<char> buffer, MonotonicNs deadline) override {
    if (!unasked_ && !asked_) {
      clock_.SleepUntil(deadline);
      return {ReadState::kTimeout, 0};
    }
    if (deadline < clock_.Now()) return {ReadState::kTimeout, 0};
    clock_.SleepUntil(clock_.Now() + kMs);
    const std::string_view answer = unasked_ || asked_value_ ? line_ : refusal_;
    asked_ = false;
    std::copy(answer.begin(), answer.end(), buffer.begin());
    return {ReadState::kBytes, answer.size()};
  }
  Result<void> Write(std::string_view bytes, MonotonicNs /*deadline*/) override {
    asked_ = true;
    asked_value_ = bytes.starts_with('M');
    return {};
  }
  std::string Source() const override { return "device: a parrot"; }
  const std::string& name() const override { return name_; }

 private:
  std::string_view line_;
  std::string_view refusal_;  // of everything but the polls
  Clock& clock_;
  bool unasked_;
  bool asked_ = false;
  bool asked_value_ = false;
  std::string name_ = "parrot";
};

/// Answers each request with as many zeros as were asked for, 1 ms later.
class ParrotModbusLink final : public ModbusLink {
 public:
  explicit ParrotModbusLink(Clock& clock) : clock_(clock) { reply_.reserve(kLongestModbusAdu); }
  bool Send(std::string_view frame) override {
    const ModbusAdu request = ParseAdu(ModbusFraming::kRtu, frame).adu;
    const std::size_t bytes = std::size_t{2} * RegisterAt(request.data, 1);
    data_[0] = static_cast<char>(bytes);
    reply_.clear();
    AppendAdu(
        ModbusFraming::kRtu,
        {.unit = request.unit, .function = request.function, .data = {data_.data(), bytes + 1}},
        reply_);
    return true;
  }
  ModbusReply Receive(std::size_t /*expected_bytes*/, MonotonicNs /*deadline*/) override {
    clock_.SleepUntil(clock_.Now() + kMs);
    return {.arrival = ModbusArrival::kFrame, .bytes = reply_};
  }
  std::size_t Flush() override { return 0; }
  ModbusFraming framing() const override { return ModbusFraming::kRtu; }
  std::string Source() const override { return "device: a parrot"; }
  const std::string& name() const override { return name_; }

 private:
  Clock& clock_;
  std::array<char, kLongestModbusAdu> data_{};
  std::string reply_;
  std::string name_ = "parrot";
};

// allocations between reading 1000 and reading 20000 of a recording
int AllocationsWhileRecording(Sensor& sensor, Clock& clock) {
  ManualClock writer_clock;
  auto writer = trial::TrialWriter::CreateIn(std::make_unique<NullSink>(), "nowhere",
                                             sensor.header(), {}, writer_clock);
  EXPECT_TRUE(writer);
  SingleTrial sink(*writer);
  int seen = 0;
  allocations = 0;
  const auto summary = Record(sensor, sink, clock, kNeverStop, {.readings = 20'001},
                              {.reading = [&seen](const Reading&) {
                                ++seen;
                                if (seen == 1000) counting = true;
                                if (seen == 20'000) counting = false;
                              }});
  counting = false;
  EXPECT_TRUE(summary);
  EXPECT_EQ(summary->readings, 20'001U);
  EXPECT_EQ(summary->bad(), 0U);
  return allocations;
}

TEST(RecorderAllocation, TheCounterCounts) {
  allocations = 0;
  counting = true;
  delete new int;
  counting = false;
  EXPECT_EQ(allocations, 1);
}

TEST(RecorderAllocation, ARunningStreamAllocatesNothing) {
  ManualClock clock;
  StreamSensor sensor(std::make_unique<ParrotTransport>("+01.2345\r+01.2346\r", clock, true), {},
                      clock);
  ASSERT_TRUE(sensor.Start(kNeverStop));
  EXPECT_EQ(AllocationsWhileRecording(sensor, clock), 0);
}

TEST(RecorderAllocation, ARunningPipeAllocatesNothing) {
  for (const auto& [format, rows] :
       {std::pair(SampleFormat::kText, std::string_view("1.5, 2.5\n-3e-7, 4\n")),
        std::pair(SampleFormat::kF32, std::string_view("0123456789abcdef"))}) {
    ManualClock clock;
    const auto channels = ReadPipeChannels("displacement:m,voltage:V", format, "");
    ASSERT_TRUE(channels);
    PipeSensor sensor(std::make_unique<ParrotTransport>(rows, clock, true),
                      {.format = format, .rate_hz = 1000, .channels = *channels}, clock);
    ASSERT_TRUE(sensor.Start(kNeverStop));
    EXPECT_EQ(AllocationsWhileRecording(sensor, clock), 0);
  }
}

TEST(RecorderAllocation, ARunningPollAllocatesNothing) {
  ManualClock clock;
  KeyenceIl sensor(std::make_unique<ParrotTransport>("M0,-00.007,+00.018\r\n", clock, false), {},
                   clock);
  ASSERT_TRUE(sensor.Start(kNeverStop));
  EXPECT_EQ(AllocationsWhileRecording(sensor, clock), 0);
}

TEST(RecorderAllocation, ARunningModbusPollAllocatesNothing) {
  ManualClock clock;
  // with a timestamp and with a rate that marks repetitions
  for (const char* name : {"baumer-om20", "benewake-tf-i"}) {
    ModbusSensor sensor(std::make_unique<ParrotModbusLink>(clock), {.profile = *FindProfile(name)},
                        clock);
    ASSERT_TRUE(sensor.Start(kNeverStop));
    EXPECT_EQ(AllocationsWhileRecording(sensor, clock), 0) << name;
  }
}

TEST(RecorderAllocation, ARunningDlEn1AllocatesNothing) {
  ManualClock clock;
  KeyenceIl sensor(
      std::make_unique<ParrotTransport>("M0,+000000018\r\n", clock, false, "ER,SR,016\r\n"),
      {.unit = IlUnit::kDlEn1, .rate_hz = 100, .decimals = 3}, clock);
  ASSERT_TRUE(sensor.Start(kNeverStop));
  EXPECT_EQ(AllocationsWhileRecording(sensor, clock), 0);
}

TEST(RecorderAllocation, ARunningLkgAllocatesNothing) {
  ManualClock clock;
  KeyenceLkg sensor(std::make_unique<ParrotTransport>("M1,+01.2345\r", clock, false), {}, clock);
  ASSERT_TRUE(sensor.Start(kNeverStop));
  EXPECT_EQ(AllocationsWhileRecording(sensor, clock), 0);
}

}  // namespace
}  // namespace haptometer::acquire
