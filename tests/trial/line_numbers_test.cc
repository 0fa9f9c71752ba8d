#include "trial/line_numbers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "tests/residual.h"

// Losses by numbers against times of arrival: what is lost stands, what the times do not hold does
// not.

namespace haptometer::trial {
namespace {

constexpr std::uint64_t kTurn = 1000;

// a wire that hands its lines on every `chunk_s`, some 30 us late, and stalls from .. to
struct Wire {
  const char* name;
  double rate_hz = 1000;
  double chunk_s = 0.010;
  std::pair<double, double> stall_s{0, 0};
};

// a line that came: when it was sent, in periods, and its number
struct Line {
  std::size_t place = 0;
  std::uint64_t number = 0;
};

struct Came {
  std::vector<std::int64_t> time_ns;
  std::vector<MissingRows> missing;  ///< by the numbers, as a counter reports them
};

Came Over(const Wire& wire, const std::vector<Line>& lines, std::uint64_t turn = kTurn) {
  std::mt19937_64 random(3);
  std::exponential_distribution<double> delay_s(1 / 30e-6);
  Came came;
  double latest_s = 0;
  for (std::size_t row = 0; row < lines.size(); ++row) {
    const double sent_s = static_cast<double>(lines[row].place) / wire.rate_hz;
    double arrived_s = std::ceil(sent_s / wire.chunk_s) * wire.chunk_s + delay_s(random);
    if (arrived_s > wire.stall_s.first && arrived_s < wire.stall_s.second) {
      arrived_s = wire.stall_s.second;
    }
    latest_s = std::max(latest_s, arrived_s);
    came.time_ns.push_back(std::llround(latest_s * 1e9));
    if (row == 0) continue;
    const auto between = (lines[row].number + 2 * turn - 1 - lines[row - 1].number) % turn;
    if (between > 0) came.missing.push_back({row, between});
  }
  return came;
}

// lines for a time; `change` may give one another number, or lose or repeat it
std::vector<Line> Lines(double rate_hz,
                        const std::function<int(std::size_t place, Line& line)>& change,
                        double duration_s = 4) {
  std::vector<Line> lines;
  for (std::size_t place = 0; place < static_cast<std::size_t>(duration_s * rate_hz); ++place) {
    Line line{place, place % kTurn};
    const int times = change(place, line);
    for (int k = 0; k < times; ++k) lines.push_back(line);
  }
  return lines;
}

const Wire kWires[] = {{.name = "Tcp"},
                       {.name = "Usb", .chunk_s = 0.016},
                       {.name = "Fast", .rate_hz = 8300, .chunk_s = 0.016},
                       {.name = "Slow", .rate_hz = 100, .chunk_s = 0.016},
                       {.name = "Packets", .chunk_s = 0.1},
                       {.name = "Blocks", .rate_hz = 2000, .chunk_s = 0.4},
                       {.name = "Stall", .stall_s = {1.5, 2.4}},
                       {.name = "StallAtTheBegin", .stall_s = {0, 1.2}},
                       {.name = "StallAtTheEnd", .stall_s = {2.9, 4.2}}};

class LinesOver : public ::testing::TestWithParam<Wire> {};

std::size_t Refused(const Wire& wire, const std::vector<Line>& lines) {
  const Came came = Over(wire, lines);
  return JudgeLosses(came.time_ns, came.missing, {.turn = kTurn}).refused.size();
}

TEST_P(LinesOver, WhatIsLostIsBelieved) {
  const Wire& wire = GetParam();
  // a part of a turn, at any place, also within a stall
  for (const std::size_t lost : {1U, 7U, 80U, 300U, 999U}) {
    for (const double at_s : {0.05, 0.6, 1.6, 2.0, 3.0, 3.5}) {
      const auto from = static_cast<std::size_t>(at_s * wire.rate_hz);
      EXPECT_EQ(Refused(wire, Lines(wire.rate_hz,
                                    [&](std::size_t place, Line&) {
                                      return place < from || place >= from + lost ? 1 : 0;
                                    })),
                0U)
          << lost << " at " << at_s;
    }
  }
  // some of many lines, up to nine of ten
  for (const double share : {0.01, 0.1, 0.5, 0.9}) {
    std::mt19937_64 random(7);
    std::bernoulli_distribution is_lost(share);
    EXPECT_EQ(Refused(wire, Lines(wire.rate_hz,
                                  [&](std::size_t, Line&) { return is_lost(random) ? 0 : 1; })),
              0U)
        << share;
  }
}

INSTANTIATE_TEST_SUITE_P(Wires, LinesOver, ::testing::ValuesIn(kWires),
                         [](const auto& at) { return std::string(at.param.name); });

// what the time base makes of lines at 1 kHz: every row is at its place, but for `slack_s`
void ExpectPlaces(const Wire& wire, const std::vector<Line>& lines, std::size_t refused,
                  const NumberedLines& numbered = {.turn = kTurn}) {
  const Came came = Over(wire, lines);
  const JudgedLosses judged = JudgeLosses(came.time_ns, came.missing, numbered);
  EXPECT_EQ(judged.refused.size(), refused);
  const auto stretches = FitArrivalTimes(came.time_ns, std::nullopt, judged.missing, refused == 0);
  double worst_s = 0;
  for (const Stretch& stretch : stretches) {
    for (std::size_t k = 0; k < stretch.rows; ++k) {
      const double time_s = stretch.start_s + static_cast<double>(k) / stretch.rate_hz;
      const double sent_s = static_cast<double>(lines[stretch.first_row + k].place) / wire.rate_hz;
      worst_s = std::max(worst_s, std::abs(time_s - sent_s));
    }
  }
  EXPECT_LT(worst_s, 2.5e-3) << "lines sent twice are a period off, fits some delays of 30 us";
}

class WrongNumbers : public ::testing::TestWithParam<Wire> {};

TEST_P(WrongNumbers, AreNotLosses) {
  const Wire& wire = GetParam();
  for (const auto& [duration_s, at] : {std::pair(4.0, 1700U), {4.0, 2600U}, {1.5, 490U}}) {
    const auto expect = [&](std::size_t refused,
                            const std::function<int(std::size_t, Line&)>& change) {
      SCOPED_TRACE(::testing::Message() << duration_s << " s, at " << at);
      ExpectPlaces(wire, Lines(wire.rate_hz, change, duration_s), refused);
    };
    // sent twice
    expect(1, [&](std::size_t place, Line&) { return place == at ? 2 : 1; });
    // another digit: far off, and by one
    for (const std::uint64_t off : {500U, 1U, 999U}) {
      expect(2, [&](std::size_t place, Line& line) {
        if (place == at) line.number = (place + off) % kTurn;
        return 1;
      });
    }
    // a counter that was reset, and one that went back
    for (const std::uint64_t back : {700U, 5U}) {
      expect(1, [&](std::size_t place, Line& line) {
        if (place >= at) line.number = (place + kTurn - back) % kTurn;
        return 1;
      });
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Wires, WrongNumbers,
                         ::testing::Values(Wire{.name = "Tcp"},
                                           Wire{.name = "Usb", .chunk_s = 0.016},
                                           Wire{.name = "Packets", .chunk_s = 0.1},
                                           Wire{.name = "Stall", .stall_s = {1.5, 2.1}}),
                         [](const auto& at) { return std::string(at.param.name); });

// lost lines beside a line that came twice keep their number
TEST(LineNumbers, ALossBesideAWrongNumberIsExact) {
  const auto lines = Lines(1000, [](std::size_t place, Line&) {
    if (place >= 1200 && place < 1500) return 0;
    return place == 2400 ? 2 : 1;
  });
  ExpectPlaces({.name = ""}, lines, 1);
  const Came came = Over({.name = ""}, lines);
  const auto judged = JudgeLosses(came.time_ns, came.missing, {.turn = kTurn});
  ASSERT_EQ(judged.missing.size(), 2);
  EXPECT_EQ(judged.missing[0].count, 300);
  EXPECT_EQ(judged.missing[1].count, std::nullopt);
  EXPECT_EQ(judged.refused[0].row, 2101);
  EXPECT_EQ(judged.refused[0].count, 999);
}

// a number that stands still claims a turn per line: more than the wire carries
TEST(LineNumbers, ANumberThatStandsStillIsNoLoss) {
  for (const std::size_t from : {0U, 1700U, 3000U}) {
    const auto lines = Lines(1000, [&](std::size_t place, Line& line) {
      if (place >= from) line.number = from % kTurn;
      return 1;
    });
    ExpectPlaces({.name = ""}, lines, 4000 - from - 1, {.turn = kTurn, .wire_ns = 141e3});
  }
  // lines that come faster than that wire could carry them do not speak of it
  const auto lines = Lines(1000, [](std::size_t place, Line&) { return place == 1700 ? 0 : 1; });
  const Came came = Over({.name = ""}, lines);
  EXPECT_EQ(JudgeLosses(came.time_ns, came.missing, {.turn = kTurn, .wire_ns = 2e6}).refused.size(),
            0U);
}

TEST(LineNumbers, NothingComesOfNothing) {
  EXPECT_TRUE(JudgeLosses({}, {}, {}).missing.empty());
  const std::vector<MissingRows> unknown{{.row = 1}};
  EXPECT_EQ(JudgeLosses(std::vector<std::int64_t>{0, 1, 2}, unknown, {}).missing.size(), 1U);
  // claims behind the last row, and times that run backwards
  const std::vector<MissingRows> behind{{0, 5}, {2, 999}, {3, 4}};
  EXPECT_LE(JudgeLosses(std::vector<std::int64_t>{9, 5, 0}, behind, {.turn = kTurn}).missing.size(),
            3U);
}

}  // namespace
}  // namespace haptometer::trial
