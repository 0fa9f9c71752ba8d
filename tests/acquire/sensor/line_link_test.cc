// Lines of a transport: when they came, and how many bytes formed none.
#include "acquire/sensor/line_link.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "tests/acquire/scripted_transport.h"

namespace haptometer::acquire {
namespace {

using tests::ScriptedTransport;

constexpr MonotonicNs kMs = 1'000'000;

class LineLinkTest : public ::testing::Test {
 protected:
  LineLinkTest() {
    auto transport = std::make_unique<ScriptedTransport>(clock_);
    wire_ = transport.get();
    link_ = std::make_unique<LineLink>(std::move(transport), clock_, Delimiter::kCr, 8);
  }

  ManualClock clock_;
  ScriptedTransport* wire_ = nullptr;
  std::unique_ptr<LineLink> link_;
};

TEST_F(LineLinkTest, ALineHasTheTimeOfItsBytesAndThoseBehindIt) {
  wire_->Send("ab\rcd\re", 5 * kMs);
  const LinkLine first = link_->Read(100 * kMs);
  EXPECT_EQ(first.state, LinkState::kLine);
  EXPECT_EQ(first.text, "ab");
  EXPECT_EQ(first.chunk_ns, 5 * kMs);
  EXPECT_EQ(first.bytes_behind, 4U);
  const LinkLine second = link_->Read(100 * kMs);
  EXPECT_EQ(second.chunk_ns, 5 * kMs);
  EXPECT_EQ(second.bytes_behind, 1U);
  EXPECT_EQ(link_->last_bytes_ns(), 5 * kMs);
  EXPECT_EQ(link_->Read(100 * kMs).state, LinkState::kNothing);
  EXPECT_EQ(clock_.Now(), 100 * kMs);
  EXPECT_EQ(link_->waiting_bytes(), 1U);
  EXPECT_EQ(link_->discarded_bytes(), 0U);
}

TEST_F(LineLinkTest, AFlushCountsWhatItThrowsAway) {
  wire_->Send("half", kMs);
  EXPECT_EQ(link_->Read(2 * kMs).state, LinkState::kNothing);
  wire_->Send("defg\rhi", 0);
  wire_->Send("later\r", kMs);
  EXPECT_EQ(link_->Flush(), 4U + 7U);
  EXPECT_EQ(link_->discarded_bytes(), 11U);
  EXPECT_EQ(link_->waiting_bytes(), 0U);
  EXPECT_EQ(link_->Flush(), 0U);
  EXPECT_EQ(link_->discarded_bytes(), 11U);
  EXPECT_EQ(link_->Read(100 * kMs).text, "later") << "it had not come yet";
}

TEST_F(LineLinkTest, CountsLinesThatAreTooLongOrOfNoUse) {
  // nine characters and the delimiter
  wire_->Send("123456789\rok\r", 0);
  EXPECT_EQ(link_->Read(kMs).state, LinkState::kOverlong);
  EXPECT_EQ(link_->discarded_bytes(), 10U);
  EXPECT_EQ(link_->Read(kMs).text, "ok");
  link_->CountDiscarded(2);
  EXPECT_EQ(link_->discarded_bytes(), 12U);
}

TEST_F(LineLinkTest, AHangUpIsGone) {
  wire_->HangUp(3 * kMs);
  EXPECT_EQ(link_->Read(100 * kMs).state, LinkState::kGone);
  EXPECT_EQ(clock_.Now(), 3 * kMs);
}

TEST_F(LineLinkTest, AnEmulatorIsNotCalledADevice) {
  EXPECT_EQ(link_->Source(false), "device: scripted");
  EXPECT_EQ(link_->Source(true), "emulated device: scripted");
}

}  // namespace
}  // namespace haptometer::acquire
