// Replies that are whole and still no readings: of another form than at the start, and requests
// that come back on the wire.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/acquire/scripted_il_unit.h"
#include "tests/findings.h"

namespace haptometer::acquire {
namespace {

using ::testing::HasSubstr;
using trial::SampleStatus;

TEST_F(KeyenceIlTest, RepliesWithOtherDecimalsAreADoubt) {
  Started();
  ExpectSoundFrom(2);
  EXPECT_FALSE(sensor_->Found().Has(FindingKind::kOtherForm));
  for (const char* reply : {"M0,+001.23\r\n", "M0,+001.24\r\n"}) unit_.to_m0.push_back({{reply}});
  EXPECT_EQ(NextStatus(), SampleStatus::kBadFrame);
  EXPECT_EQ(NextStatus(), SampleStatus::kBadFrame);
  ExpectSoundFrom(3);
  EXPECT_EQ(tests::NumbersOf(sensor_->Found(), FindingKind::kOtherForm),
            "replies=2 example=M0,+001.23");
}

TEST_F(KeyenceIlTest, DamagedRepliesAreOfNoOtherForm) {
  Started();
  ExpectSoundFrom(2);
  unit_.to_m0.push_back({{"M0,+00.1\r\n"}});
  EXPECT_EQ(NextStatus(), SampleStatus::kBadFrame);
  EXPECT_FALSE(sensor_->Found().Has(FindingKind::kOtherForm));
}

TEST_F(KeyenceIlTest, RequestsThatComeBackArePassedOver) {
  unit_.to_m0.push_back({{"M0\r\n", 1 * kMs}, {"M0,+00.001\r\n"}});
  Started();
  for (int um = 2; um < 5; ++um) {
    unit_.to_m0.push_back({{"M0\r\n", 1 * kMs}, {"M0,+00.00" + std::to_string(um) + "\r\n"}});
    ExpectSoundFrom(um);
  }
  EXPECT_EQ(tests::NumbersOf(sensor_->Found(), FindingKind::kEcho), "echoes=4");
}

TEST_F(KeyenceIlTest, AWireThatOnlySendsRequestsBackIsNamed) {
  unit_.to_m0 = {{{"M0\r\n"}}, {{"M0\r\n"}}, {{"M0\r\n"}}};
  const Error error = StartError();
  EXPECT_EQ(error.cause, Cause::kCannotAnswer);
  EXPECT_THAT(error.what, HasSubstr("sends each request back"));
  EXPECT_THAT(error.remedy, HasSubstr("RS-485"));
}

}  // namespace
}  // namespace haptometer::acquire
