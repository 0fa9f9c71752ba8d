#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/sensor/keyence/keyence_il.h"
#include "tests/acquire/scripted_transport.h"
#include "tests/acquire/sensor_rows.h"

namespace haptometer::acquire {

inline constexpr MonotonicNs kMs = 1'000'000;

/// A unit whose answers can be told reply by reply; without an instruction it is a sound IL-030
/// that counts up by 1 um, 8 ms after the request.
class ScriptedIlUnit {
 public:
  struct Answer {
    std::string bytes;
    MonotonicNs after_ns = 8 * kMs;
  };

  explicit ScriptedIlUnit(Clock& clock) : clock_(clock) {
    auto transport = std::make_unique<tests::ScriptedTransport>(
        clock,
        [this](tests::ScriptedTransport& to, const std::string& request) { Reply(to, request); });
    wire = transport.get();
    transport_ = std::move(transport);
  }

  std::unique_ptr<Transport> TakeTransport() { return std::move(transport_); }

  std::deque<std::vector<Answer>> to_m0;        ///< for the next M0s; then the default
  std::map<std::string, std::string> settings;  ///< "195" -> "1", "01,195" -> "4"
  std::string to_ms = "MS,04,+88.888\r\n";      ///< empty: never answered
  bool answers_sr = true;
  bool is_silent = false;
  std::int32_t next_um = 1;
  tests::ScriptedTransport* wire = nullptr;

 private:
  void Reply(tests::ScriptedTransport& to, const std::string& request) {
    if (is_silent) return;
    // one command at a time: it turns to this one when the last one is answered
    const MonotonicNs begin_ns = std::max(clock_.Now(), busy_until_ns_);
    if (request == "M0\r\n") {
      std::vector<Answer> answers;
      if (to_m0.empty()) {
        answers = {{dl::FormatM0Reply(dl_rs1a::Spelling(),
                                      std::array{Value{next_um++, 3, trial::SampleStatus::kOk}})}};
      } else {
        answers = to_m0.front();
        to_m0.pop_front();
      }
      for (const Answer& answer : answers) Answers(to, answer, begin_ns);
      return;
    }
    if (request == "MS\r\n") {
      Answers(to, {to_ms}, begin_ns);
      return;
    }
    ASSERT_TRUE(request.starts_with("SR,"));
    if (!answers_sr) return;
    // "00,195": the main amplifier's may be given without its number
    const std::string asked = request.substr(3, 6);
    auto known = settings.find(asked);
    if (known == settings.end() && asked.starts_with("00,")) known = settings.find(asked.substr(3));
    to.Send(known == settings.end() ? "ER,SR,22\r\n" : "SR," + asked + "," + known->second + "\r\n",
            20 * kMs);
  }

  void Answers(tests::ScriptedTransport& to, const Answer& answer, MonotonicNs begin_ns) {
    const MonotonicNs at_ns = begin_ns + answer.after_ns;
    busy_until_ns_ = std::max(busy_until_ns_, at_ns);
    if (!answer.bytes.empty()) to.Send(answer.bytes, at_ns - clock_.Now());
  }

  Clock& clock_;
  MonotonicNs busy_until_ns_ = 0;
  std::unique_ptr<Transport> transport_;
};

class KeyenceIlTest : public ::testing::Test {
 protected:
  KeyenceIlTest() { unit_.settings = {{"195", "1"}}; }

  KeyenceIl& Started(KeyenceIlSetup setup = {.baud = 38400, .refresh_ns = std::nullopt}) {
    sensor_ = std::make_unique<KeyenceIl>(unit_.TakeTransport(), setup, clock_);
    const auto started = sensor_->Start(kNeverStop);
    EXPECT_TRUE(started) << started.error().Text();
    begin_ns_ = sensor_->Begin();
    return *sensor_;
  }
  Reading NextRow() { return NextRowOf(*sensor_); }
  trial::SampleStatus NextStatus() { return RowStatus(NextRow()); }
  void ExpectSoundFrom(std::int32_t um) {
    const Reading reading = NextRow();
    EXPECT_EQ(RowStatus(reading), trial::SampleStatus::kOk);
    EXPECT_EQ(Counts(reading), um);
  }
  Error StartError(int baud = 9600) {
    sensor_ = std::make_unique<KeyenceIl>(
        unit_.TakeTransport(), KeyenceIlSetup{.baud = baud, .refresh_ns = std::nullopt}, clock_);
    const auto started = sensor_->Start(kNeverStop);
    EXPECT_FALSE(started);
    return started ? Error{} : started.error();
  }

  ManualClock clock_;
  ScriptedIlUnit unit_{clock_};
  std::unique_ptr<KeyenceIl> sensor_;
  MonotonicNs begin_ns_ = 0;
};

}  // namespace haptometer::acquire
