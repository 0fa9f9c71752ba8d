// A session's folder when other programs use it, too.
#include "tools/session/session_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/temporary_files.h"

namespace haptometer::tools {
namespace {

class SessionFolderTest : public tests::TemporaryFiles {
 protected:
  static SessionPlan Plan() {
    SessionPlan plan;
    plan.subjects = {"ann"};
    plan.conditions = {"weak"};
    plan.duration_s = 1;
    plan.source = {"--port", "/dev/ttyUSB0"};
    return plan;
  }
  std::string Day() const { return (directory_ / "day").string(); }
};

// an editor that keeps a backup renames the log and writes another one
TEST_F(SessionFolderTest, ALogThatWasRenamedIsNotWritten) {
  ASSERT_TRUE(SessionFolder::Create(Day(), Plan()));
  auto session = SessionFolder::Open(Day());
  ASSERT_TRUE(session) << session.error().Text();
  const std::string log = Day() + "/log.csv";
  std::filesystem::rename(log, log + ".bak");
  std::filesystem::copy_file(log + ".bak", log);
  const auto before = std::filesystem::file_size(log + ".bak");
  SessionLogLine line;
  line.event = SessionEvent::kBegin;
  line.cell = session->cells()[0];
  line.attempt = 1;
  line.file = "a.bin";
  const auto appended = session->Append(line);
  ASSERT_FALSE(appended);
  EXPECT_TRUE(appended.error().Text().contains("log.csv.bak")) << appended.error().Text();
  EXPECT_EQ(std::filesystem::file_size(log + ".bak"), before);
  EXPECT_EQ(std::filesystem::file_size(log), before);
}

// what `session new` could write and no command could read
TEST_F(SessionFolderTest, APlanThatIsTooLargeIsRefusedAndNothingMade) {
  SessionPlan plan = Plan();
  for (int k = 0; k < 20'000; ++k) {
    plan.files_before.push_back("a recording with a name of sixty characters, as cameras give " +
                                std::to_string(k));
  }
  const auto made = SessionFolder::Create(Day(), plan);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().cause, Cause::kCannotAnswer);
  EXPECT_FALSE(std::filesystem::exists(Day()));
}

}  // namespace
}  // namespace haptometer::tools
