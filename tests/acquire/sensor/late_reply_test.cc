// A reply that comes too late must never be taken for the next reading, whatever the protocol: a
// peer that answers in order, each value the number of its own request, with late replies strewn
// in.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>

#include "acquire/protocol/keyence/dl_en1.h"
#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/protocol/keyence/lkg.h"
#include "acquire/sensor/keyence/keyence_il.h"
#include "acquire/sensor/keyence/keyence_lkg.h"
#include "tests/acquire/scripted_transport.h"
#include "tests/findings.h"

namespace haptometer::acquire {
namespace {

using tests::NumbersOf;

constexpr MonotonicNs kMs = 1'000'000;

// one maker's lines, as far as the peer needs them
struct Maker {
  std::string poll;
  std::string step;
  std::string step_answer;
  std::function<std::string(int number)> reading;
  std::function<std::string(const std::string& request)> other;  // what the start asks for
  std::function<std::unique_ptr<Sensor>(std::unique_ptr<Transport>, Clock&)> sensor;
};

// answers in order, one after the other; a poll in four or so is late by up to 2.5 s
class NumberingPeer {
 public:
  NumberingPeer(const Maker& maker, Clock& clock, unsigned seed)
      : maker_(maker), clock_(clock), random_(seed) {}

  void Answer(tests::ScriptedTransport& to, const std::string& request) {
    const MonotonicNs now = clock_.Now();
    MonotonicNs after_ns = usual_ns;
    std::string answer;
    if (request == maker_.poll) {
      number_at[now] = ++polls;
      answer = maker_.reading(polls);
      if (strikes && random_() % 4 == 0) {
        after_ns = Lateness();
        ++late;
      }
    } else {
      answer = request == maker_.step ? maker_.step_answer : maker_.other(request);
    }
    busy_until_ns_ = (is_parallel ? now : std::max(now, busy_until_ns_)) + after_ns;
    to.Send(answer, busy_until_ns_ - now);
    if (again_after_ns > 0 && request == maker_.poll && polls % 7 == 0) {
      to.Send(answer, busy_until_ns_ - now + again_after_ns);
      ++twice;
    }
  }

  std::map<MonotonicNs, int> number_at;  // of the poll that was sent then
  int polls = 0;
  int late = 0;
  bool strikes = false;
  MonotonicNs usual_ns = 8 * kMs;
  MonotonicNs again_after_ns = 0;  // each seventh reading is sent again after this
  int twice = 0;
  bool is_parallel = false;  // it answers each request for itself, whatever is still to be answered

 private:
  // shorter than the patience by then, within the maker's second, about it, and beyond
  MonotonicNs Lateness() {
    constexpr MonotonicNs kLeast[] = {20 * kMs, 51 * kMs, 980 * kMs, 1001 * kMs};
    constexpr MonotonicNs kMost[] = {60 * kMs, 999 * kMs, 1030 * kMs, 2500 * kMs};
    const std::size_t kind = random_() % 4;
    return std::uniform_int_distribution<MonotonicNs>(kLeast[kind], kMost[kind])(random_);
  }

  const Maker& maker_;
  Clock& clock_;
  std::mt19937 random_;
  MonotonicNs busy_until_ns_ = 0;
};

Maker DlRs1a() {
  return {.poll = "M0\r\n",
          .step = "MS\r\n",
          .step_answer = "MS,04,+88.888\r\n",
          .reading =
              [](int number) {
                return dl::FormatM0Reply(dl_rs1a::Spelling(), std::array{Value{number, 3, {}}});
              },
          .other = [](const std::string&) { return "ER,SR,22\r\n"; },
          .sensor =
              [](std::unique_ptr<Transport> transport, Clock& clock) {
                return std::make_unique<KeyenceIl>(std::move(transport), KeyenceIlSetup{}, clock);
              }};
}

// the other way round: MS is polled and M0 is the step
Maker DlRs1aByMs() {
  Maker maker = DlRs1a();
  maker.poll = "MS\r\n";
  maker.step = "M0\r\n";
  maker.step_answer = "M0,+88.888\r\n";
  maker.reading = [](int number) {
    return dl::FormatMsReply(dl_rs1a::Spelling(), std::array{4}, std::array{Value{number, 3, {}}});
  };
  maker.sensor = [](std::unique_ptr<Transport> transport, Clock& clock) {
    return std::make_unique<KeyenceIl>(std::move(transport),
                                       KeyenceIlSetup{.command = dl::Command::kMs}, clock);
  };
  return maker;
}

Maker DlEn1() {
  return {.poll = "M0\r\n",
          .step = "MS\r\n",
          .step_answer = "MS,04,+000088888\r\n",
          .reading =
              [](int number) {
                return dl::FormatM0Reply(dl_en1::Spelling(), std::array{Value{number, 0, {}}});
              },
          .other =
              [](const std::string& request) {
                return request.starts_with("FR") ? std::string("FR,01,037,+000000003\r\n")
                                                 : std::string("ER,SR,016\r\n");
              },
          .sensor =
              [](std::unique_ptr<Transport> transport, Clock& clock) {
                return std::make_unique<KeyenceIl>(std::move(transport),
                                                   KeyenceIlSetup{.unit = IlUnit::kDlEn1}, clock);
              }};
}

Maker Lkg() {
  return {.poll = "M1\r",
          .step = "M2\r",
          .step_answer = "M2,+88.8888\r",
          .reading =
              [](int number) {
                return lkg::FormatReply(lkg::Command::kM1, std::array{Value{number, 4, {}}});
              },
          .other = [](const std::string&) { return "ER,XX,00\r"; },
          .sensor =
              [](std::unique_ptr<Transport> transport, Clock& clock) {
                return std::make_unique<KeyenceLkg>(std::move(transport), KeyenceLkgSetup{}, clock);
              }};
}

struct Count {
  int late = 0;
  int rows = 0;
  int misattributed = 0;
  int without_value = 0;
};

// runs one sensor until the peer has been late `wanted` times
Count RunLate(const Maker& maker, unsigned seed, int wanted) {
  ManualClock clock;
  NumberingPeer peer(maker, clock, seed);
  auto sensor = maker.sensor(std::make_unique<tests::ScriptedTransport>(
                                 clock, [&](tests::ScriptedTransport& to,
                                            const std::string& bytes) { peer.Answer(to, bytes); }),
                             clock);
  const std::atomic<bool> stop{false};
  const auto started = sensor->Start(stop);
  EXPECT_TRUE(started) << started.error().Text();
  (void)sensor->Begin();
  // half of the runs meet lateness before the unit is known, half after
  Count count;
  Reading reading;
  for (int call = 0; peer.late < wanted && call < 1'000'000; ++call) {
    peer.strikes = seed % 2 == 0 || count.rows >= 70;
    // a recording that begins anew, as after a tare, may find a poll outstanding
    if (seed % 3 == 0 && call % 97 == 96) (void)sensor->Begin();
    if (sensor->Next(reading) != Outcome::kReading) continue;
    ++count.rows;
    if (RowStatus(reading) != trial::SampleStatus::kOk) {
      ++count.without_value;
      continue;
    }
    const auto counts = static_cast<std::int32_t>(reading.samples[0].raw.bits());
    if (peer.number_at.at(reading.time_ns) != counts) ++count.misattributed;
  }
  count.late = peer.late;
  return count;
}

class LateReplies : public ::testing::TestWithParam<std::pair<const char*, Maker (*)()>> {};

TEST_P(LateReplies, AreNeverTakenForTheNextReading) {
  const Maker maker = GetParam().second();
  Count total;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Count count = RunLate(maker, seed, 50);
    total.late += count.late;
    total.rows += count.rows;
    total.misattributed += count.misattributed;
    total.without_value += count.without_value;
  }
  EXPECT_EQ(total.late, 1000);
  EXPECT_EQ(total.misattributed, 0);
  // most late replies cost a row, and the sound ones in between are there
  EXPECT_GT(total.without_value, 300);
  EXPECT_GT(total.rows - total.without_value, 2000);
  RecordProperty("rows", total.rows);
}

INSTANTIATE_TEST_SUITE_P(Makers, LateReplies,
                         ::testing::Values(std::pair{"DlRs1a", &DlRs1a},
                                           std::pair{"DlRs1aByMs", &DlRs1aByMs},
                                           std::pair{"DlEn1", &DlEn1}, std::pair{"Lkg", &Lkg}),
                         [](const auto& made) { return std::string(made.param.first); });

// A device that answers twice: the further reply comes while the next request is outstanding.
class DoubledReplies : public LateReplies {};

TEST_P(DoubledReplies, AreDiscardedAndCounted) {
  constexpr int kRows = 703;  // the last one does not come twice
  constexpr MonotonicNs kExchangeNs = 22 * kMs;
  const Maker maker = GetParam().second();
  for (const MonotonicNs again_after_ns : {1 * kMs, 5 * kMs, 11 * kMs, 17 * kMs, 19 * kMs}) {
    for (const bool is_parallel : {false, true}) {
      ManualClock clock;
      NumberingPeer peer(maker, clock, 1);
      peer.usual_ns = kExchangeNs;
      peer.is_parallel = is_parallel;
      auto sensor =
          maker.sensor(std::make_unique<tests::ScriptedTransport>(
                           clock, [&](tests::ScriptedTransport& to,
                                      const std::string& bytes) { peer.Answer(to, bytes); }),
                       clock);
      const std::atomic<bool> stop{false};
      ASSERT_TRUE(sensor->Start(stop));
      const MonotonicNs begin_ns = sensor->Begin();
      Reading reading;
      int misattributed = 0;
      for (int row = 0; row < kRows;) {
        if (sensor->Next(reading) != Outcome::kReading) continue;
        ++row;
        // the first exchanges show what is usual
        if (row == 70) peer.again_after_ns = again_after_ns;
        ASSERT_EQ(RowStatus(reading), trial::SampleStatus::kOk);
        const auto counts = static_cast<std::int32_t>(reading.samples[0].raw.bits());
        if (peer.number_at.at(reading.time_ns) != counts) ++misattributed;
      }
      EXPECT_EQ(misattributed, 0) << again_after_ns << " ns later, parallel: " << is_parallel;
      EXPECT_GE(clock.Now() - begin_ns, kRows * kExchangeNs) << "no row without an exchange";
      EXPECT_EQ(NumbersOf(sensor->Found(), FindingKind::kSurplusReplies),
                fmt::format("replies={}", peer.twice));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Makers, DoubledReplies,
                         ::testing::Values(std::pair{"DlRs1a", &DlRs1a},
                                           std::pair{"DlRs1aByMs", &DlRs1aByMs},
                                           std::pair{"DlEn1", &DlEn1}, std::pair{"Lkg", &Lkg}),
                         [](const auto& made) { return std::string(made.param.first); });

// A peer on no wire at all answers at once: no more rows are taken than the stated rate carries.
TEST(ReplyRate, IsThatOfTheWireAndSaidWhereItIsAboveIt) {
  const Maker maker = DlRs1a();
  ManualClock clock;
  NumberingPeer peer(maker, clock, 1);
  peer.usual_ns = kMs / 10;
  auto sensor = maker.sensor(std::make_unique<tests::ScriptedTransport>(
                                 clock, [&](tests::ScriptedTransport& to,
                                            const std::string& bytes) { peer.Answer(to, bytes); }),
                             clock);
  const std::atomic<bool> stop{false};
  ASSERT_TRUE(sensor->Start(stop));
  const MonotonicNs begin_ns = sensor->Begin();
  Reading reading;
  int rows = 0;
  while (clock.Now() - begin_ns < 10 * kNsPerS) rows += sensor->Next(reading) == Outcome::kReading;
  // M0 CR LF and M0,+00.000 CR LF: 16 characters of 10 bits at 9600 baud
  EXPECT_NEAR(rows, 10 * 9600.0 / 160, 1);
  EXPECT_LT(reading.reply_ns - reading.time_ns, kMs) << "the time at which it came";
  EXPECT_TRUE(sensor->Found().Has(FindingKind::kRepliesTooSoon));
}

}  // namespace
}  // namespace haptometer::acquire
