#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>
#include <string>
#include <string_view>
#include <utility>

#include "acquire/emulator/server.h"
#include "acquire/emulator/stream_head.h"
#include "tests/acquire/emulator_run.h"
#include "tests/residual.h"

namespace haptometer::acquire::emulator {
namespace {

constexpr MonotonicNs kSecond = kNsPerS;

// a 10 kHz head without noise
StreamSetup Quiet(trial::Displacement displacement) {
  StreamSetup setup;
  setup.head = {.head = trial::Stream10kHz(), .displacement = std::move(displacement)};
  setup.head.head.noise_rms_m = 0;
  return setup;
}

// line k reads k steps
StreamSetup Counting() {
  return Quiet([](double t_s) { return 1e-3 * t_s; });
}

std::string Lines(const StreamSetup& setup, MonotonicNs until) {
  StreamHead head(setup);
  std::string out;
  head.Advance(until, out);
  return out;
}

TEST(StreamHead, WritesNineBytesALine) {
  EXPECT_EQ(Lines(Quiet([](double) { return 1.2345e-3; }), 99'999), "+01.2345\r");
  EXPECT_EQ(Lines(Quiet([](double) { return -1.2345e-3; }), 99'999), "-01.2345\r");
  EXPECT_EQ(Lines(Quiet([](double) { return -0.04e-6; }), 99'999), "+00.0000\r");
  EXPECT_EQ(Lines(Quiet([](double) { return 11e-3; }), 99'999), "+FFFFFFF\r");
  EXPECT_EQ(Lines(Quiet([](double) { return -11e-3; }), 99'999), "-FFFFFFF\r");
}

// 4.5 mm are 4.5e9 counts of 1 pm, beyond 32 bits
TEST(StreamHead, SendsLettersForWhatALineOfFineCountsCannotHold) {
  for (const double sign : {1.0, -1.0}) {
    StreamSetup setup = Quiet([sign](double) { return sign * 4.5e-3; });
    setup.head.head.sampling_s = 1e-3;
    setup.format = *ParseStreamFormat("+000000.000,nm,CR");
    EXPECT_EQ(Lines(setup, 199'999), sign > 0 ? "+FFFFFFFFFF\r" : "-FFFFFFFFFF\r");
  }
}

TEST(StreamHead, NumbersItsLinesAndSkipsTheNumberOfALostOne) {
  StreamSetup setup = Quiet([](double) { return 0.0; });
  setup.format = *ParseStreamFormat("0 +0.0,mm,LF");
  setup.faults = *ParseFaultPlan("silent:3");
  EXPECT_EQ(Lines(setup, 1'299'999),
            "0 +0.0\n1 +0.0\n3 +0.0\n4 +0.0\n6 +0.0\n7 +0.0\n9 +0.0\n0 +0.0\n2 +0.0\n");
}

TEST(StreamHead, SendsLineKWhenSampleKIsTaken) {
  // line k's last byte has crossed at k/rate + 90 bits; a second's worth, none skipped
  const StreamSetup setup = Counting();
  for (const std::int64_t k : {0, 1, 2, 4999, 9999}) {
    const auto end = static_cast<MonotonicNs>(k * 100'000 + 90'000'000'000 / 921600);
    EXPECT_EQ(Lines(setup, end).size(), 9U * static_cast<std::size_t>(k + 1)) << k;
    EXPECT_EQ(Lines(setup, end - 1).size(), 9U * static_cast<std::size_t>(k + 1) - 1) << k;
  }
  const std::string second = Lines(setup, kSecond - 1);
  ASSERT_EQ(second.size(), 90'000U);
  for (std::size_t k = 0; k < 10'000; ++k) {
    EXPECT_EQ(second.substr(9 * k, 9), "+0" + std::to_string(k / 10'000) + "." +
                                           std::to_string(10'000 + k % 10'000).substr(1) + "\r");
  }
}

TEST(StreamHead, GivesTheSameBytesHoweverItIsCalled) {
  const StreamSetup setup = Counting();
  const std::string reference = Lines(setup, kSecond / 10);
  std::mt19937 random(2);
  for (const MonotonicNs longest : {5'000, 300'000, 20'000'000}) {
    StreamHead head(setup);
    std::string out;
    std::uniform_int_distribution<MonotonicNs> step(1, longest);
    for (MonotonicNs now = 0; now < kSecond / 10; now += step(random)) head.Advance(now, out);
    head.Advance(kSecond / 10, out);
    EXPECT_EQ(out, reference);
  }
}

TEST(StreamHead, IsWokenAMillisecondAtATime) {
  ManualClock clock;
  StreamHead head(Counting());
  const auto bytes = RunUntil(head, clock, kSecond / 10);
  EXPECT_EQ(TextOf(bytes), Lines(Counting(), bytes.back().time));
  EXPECT_GE(bytes.size(), 880U);
  for (std::size_t i = 1; i < bytes.size(); ++i) {
    EXPECT_LE(bytes[i].time - bytes[i - 1].time, 1'000'000) << i;
  }
}

TEST(StreamHead, SlowHeadsSleepUntilTheNextSample) {
  StreamSetup setup = Counting();
  setup.head.head.sampling_s = 0.02;
  StreamHead head(setup);
  std::string out;
  head.Advance(10'000'000, out);
  EXPECT_EQ(out, "+00.0000\r");
  EXPECT_EQ(head.NextDue(), 20'000'000);
}

TEST(StreamHead, RefusesALineThatDoesNotFitBetweenTwoSamples) {
  StreamSetup setup = Counting();
  setup.baud = 115200;
  const auto refused = Validate(setup);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().cause, Cause::kUsage);
  EXPECT_EQ(refused.error().Text(),
            "<baud>: 9 characters at 115200 baud allow 1280 lines/s, the head gives 10000; use "
            "<baud> 921600 or <sampling> 782us");
  setup.head.head.sampling_s = 782e-6;
  EXPECT_TRUE(Validate(setup));
  setup.head.head.sampling_s = 781e-6;
  EXPECT_FALSE(Validate(setup));

  // 90 bits in 100 us fit exactly at 900 kbaud; beyond the common rates only a slower head helps
  setup.head.head.sampling_s = 1e-4;
  setup.baud = 900'000;
  EXPECT_TRUE(Validate(setup));
  EXPECT_EQ(Lines(setup, kSecond).size(), 90'000U);
  setup.baud = 899'999;
  EXPECT_FALSE(Validate(setup));
  setup.head.head.sampling_s = 1e-5;
  setup.baud = 921600;
  EXPECT_EQ(Validate(setup).error().remedy, "use <sampling> 98us");
}

TEST(StreamHead, HasTheFaultsThatNobodyNeedsToAskFor) {
  StreamSetup setup = Counting();
  setup.faults = *ParseFaultPlan("silent:3");
  EXPECT_EQ(Lines(setup, 399'999), "+00.0000\r+00.0001\r+00.0003\r");
  setup.faults = *ParseFaultPlan("silent");
  EXPECT_EQ(Lines(setup, kSecond), "");
  setup.faults = *ParseFaultPlan("truncate:2");
  EXPECT_EQ(Lines(setup, 299'999), "+00.0000\r+00.+00.0002\r");
  setup.faults = *ParseFaultPlan("invalid:2");
  EXPECT_EQ(Lines(setup, 199'999), "+00.0000\rXXXXXXXX\r");
  setup.faults = *ParseFaultPlan("over:2");
  EXPECT_EQ(Lines(setup, 199'999), "+00.0000\r+FFFFFFF\r");

  setup.faults = *ParseFaultPlan("disconnect:2");
  StreamHead head(setup);
  std::string out;
  head.Advance(199'999, out);
  EXPECT_EQ(out, "+00.0000\r");
  EXPECT_TRUE(head.TakeHangUp());
  EXPECT_FALSE(head.TakeHangUp());

  for (const char* name : {"late", "error"}) {
    setup.faults = *ParseFaultPlan(name);
    const auto refused = Validate(setup);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().Text(), std::string("<fault>: '") + name +
                                          "' is a fault of replies, and a stream has no requests; "
                                          "choose another, or <protocol> dl-rs1a");
  }
}

// --- what a reader who does not read loses ------------------------------------------------------

struct Sink {
  std::string taken;
  std::size_t room = 0;

  std::size_t operator()(std::string_view bytes) {
    const std::size_t count = std::min(room, bytes.size());
    taken += bytes.substr(0, count);
    room -= count;
    return count;
  }
};

TEST(LineWriter, LosesWholeLinesOnly) {
  Sink sink;
  LineWriter writer('\r', 0, std::ref(sink));
  sink.room = 5;
  writer.Write("abc\rdef\rghi\rj");  // takes "abc\rd", keeps "ef\r", drops ghi and the j of jkl
  EXPECT_EQ(sink.taken, "abc\rd");
  EXPECT_EQ(writer.dropped_lines(), 2U);
  sink.room = 100;
  writer.Write("kl\rmno\r");
  EXPECT_EQ(sink.taken, "abc\rdef\rmno\r");
  EXPECT_EQ(writer.dropped_lines(), 2U);
}

TEST(LineWriter, KeepsALineWhoseEndHasNotComeYet) {
  Sink sink;
  LineWriter writer('\r', 0, std::ref(sink));
  sink.room = 2;
  writer.Write("abc");
  writer.Write("d");
  writer.Write("e\rfgh\r");
  EXPECT_EQ(writer.dropped_lines(), 1U);
  sink.room = 100;
  writer.Write("");
  EXPECT_EQ(sink.taken, "abcde\r");
}

TEST(LineWriter, DropsFromTheStartOfALineWhenNothingIsTaken) {
  Sink sink;
  LineWriter writer('\r', 0, std::ref(sink));
  writer.Write("abc");
  writer.Write("def\rg");
  sink.room = 100;
  writer.Write("h\rijk\r");
  EXPECT_EQ(sink.taken, "ijk\r");
  EXPECT_EQ(writer.dropped_lines(), 2U);
}

TEST(LineWriter, DoesNotHoardALineWithoutEnd) {
  Sink sink;
  LineWriter writer('\r', 0, std::ref(sink));
  sink.room = 1;
  for (int i = 0; i < 1000; ++i) writer.Write("0123456789");
  sink.room = 100'000;
  writer.Write("\rabc\r");
  EXPECT_EQ(sink.taken.size(), 1U + 256U + 4U);
  EXPECT_TRUE(sink.taken.ends_with("abc\r"));
}

TEST(LineWriter, KeepsWholeLinesAsFarAsThereIsRoom) {
  Sink sink;
  LineWriter writer('\r', 9, std::ref(sink));
  writer.Write("abc\rdef\r");  // 8 bytes wait
  EXPECT_EQ(writer.dropped_lines(), 0U);
  writer.Write("ghi\rj");  // the newest are lost, as in a driver that is full
  EXPECT_EQ(writer.dropped_lines(), 2U);
  sink.room = 100;
  writer.Write("kl\rmno\r");
  EXPECT_EQ(sink.taken, "abc\rdef\rmno\r");
  EXPECT_EQ(writer.dropped_lines(), 2U);
}

TEST(LineWriter, ForgetsTheLineOfAHostThatHasGone) {
  Sink sink;
  LineWriter writer('\r', 0, std::ref(sink));
  sink.room = 2;
  writer.Write("abc\r");
  writer.Abandon();
  sink.room = 100;
  writer.Write("def\r");
  EXPECT_EQ(sink.taken, "abdef\r");
}

// whatever the room and the cuts: the taken text is whole lines in order, and taken + dropped = all
TEST(LineWriter, AccountsForEveryLine) {
  std::mt19937 random(3);
  for (int run = 0; run < 200; ++run) {
    Sink sink;
    LineWriter writer('\r', run % 2 == 0 ? 0 : 20, std::ref(sink));
    std::string all;
    for (int line = 0; line < 200; ++line) all += std::to_string(1000 + line) + "\r";
    std::size_t at = 0;
    while (at < all.size()) {
      sink.room += std::uniform_int_distribution<std::size_t>(0, 20)(random);
      const std::size_t count = std::uniform_int_distribution<std::size_t>(1, 30)(random);
      writer.Write(std::string_view(all).substr(at, count));
      at += count;
    }
    sink.room = 1000;
    writer.Write("");
    ASSERT_EQ(sink.taken.size() % 5, 0U);
    int last = 999;
    for (std::size_t i = 0; i < sink.taken.size(); i += 5) {
      const int number = std::stoi(sink.taken.substr(i, 4));
      EXPECT_GT(number, last);
      EXPECT_EQ(sink.taken[i + 4], '\r');
      last = number;
    }
    EXPECT_EQ(sink.taken.size() / 5 + writer.dropped_lines(), 200U);
  }
}

}  // namespace
}  // namespace haptometer::acquire::emulator
