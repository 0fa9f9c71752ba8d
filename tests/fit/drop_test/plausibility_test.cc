#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fit/drop_test/drop_test_fit.h"
#include "tests/fit/synthetic_drop.h"

namespace haptometer::fit {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

std::vector<std::string> DoubtsOf(const ImpulseRecord& record, const ActuatorKnowns& knowns) {
  const auto fit = FitDropTest({record}, knowns);
  EXPECT_TRUE(fit) << fit.error().Text();
  return fit ? FindDoubts(*fit, {record}, knowns) : std::vector<std::string>{};
}

TEST(Plausibility, TheThesisActuatorIsNotDoubted) {
  const auto record = tests::MakeRecordWithHeight({});
  EXPECT_THAT(DoubtsOf(record, tests::ThesisKnowns()), IsEmpty());
}

TEST(Plausibility, MillisecondsAsSecondsAreNamed) {
  auto record = tests::MakeRecord({});
  record.step_s *= 1e3;
  record.start_s *= 1e3;
  EXPECT_THAT(DoubtsOf(record, tests::ThesisKnowns()), Contains(HasSubstr("are the times in ms")));
}

TEST(Plausibility, MillivoltsAsVoltsAreNamed) {
  auto record = tests::MakeRecordWithHeight({});
  for (double& v : record.voltage_v) v *= 1e3;
  const auto doubts = DoubtsOf(record, tests::ThesisKnowns());
  EXPECT_THAT(doubts, Contains(HasSubstr("is the column in mV")));
  EXPECT_THAT(doubts, Contains(HasSubstr("force constant of 1000 N/A")));
}

TEST(Plausibility, GramsAsKilogramsAndMillimetresAsMetresAreNamed) {
  auto record = tests::MakeRecordWithHeight({});
  record.drop_height_m = Quantity{10, 0};
  const ActuatorKnowns knowns{Quantity{1.4, 0}, Quantity{0.6e-3, 0}, Quantity{27, 0}, {}};
  const auto doubts = DoubtsOf(record, knowns);
  EXPECT_THAT(doubts, Contains(HasSubstr("a moving mass of 1.4 kg")));
  EXPECT_THAT(doubts, Contains(HasSubstr("a drop height of 10 m")));
  EXPECT_THAT(doubts, Not(Contains(HasSubstr("case mass"))));
}

}  // namespace
}  // namespace haptometer::fit
