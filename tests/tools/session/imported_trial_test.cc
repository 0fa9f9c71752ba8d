// A file of another program as a trial of a session.
#include "tools/session/imported_trial.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/temporary_files.h"
#include "tools/document/provenance.h"
#include "trial/import/read_recording.h"

namespace haptometer::tools {
namespace {

class ImportedTrial : public tests::TemporaryFiles {
 protected:
  // the table as `analyze` reads it, and the trial that a session makes of it
  void Import(const std::string& text) {
    const std::string table = File("table.csv", text);
    auto read = trial::ReadRecording(table);
    ASSERT_TRUE(read) << read.error().Text();
    table_ = std::move(read->record);
    ManualClock clock;
    const std::filesystem::path path = table;
    const AttemptSource source = ImportOf({.folder = path.parent_path(), .pattern = "*.csv"},
                                          {.name = path.filename()}, clock, "");
    const std::string made = path.parent_path() / "made.bin";
    std::filesystem::remove(made);
    ASSERT_TRUE(source.write(made, source.header));
    auto written = trial::ReadRecording(made);
    ASSERT_TRUE(written) << written.error().Text();
    trial_ = std::move(written->record);
  }
  void ExpectTheSameTimes() const {
    EXPECT_EQ(trial_.timing, table_.timing);
    ASSERT_EQ(trial_.stretches.size(), table_.stretches.size());
    for (std::size_t s = 0; s < table_.stretches.size(); ++s) {
      EXPECT_EQ(trial_.stretches[s].first_row, table_.stretches[s].first_row);
      EXPECT_EQ(trial_.stretches[s].start_s, table_.stretches[s].start_s);
      EXPECT_EQ(trial_.stretches[s].rate_hz, table_.stretches[s].rate_hz);
      EXPECT_EQ(trial_.stretches[s].time_uncertainty_s, table_.stretches[s].time_uncertainty_s);
    }
  }
  trial::Record table_;
  trial::Record trial_;
};

// rows at `rate_hz` whose times are printed to 1 ms
std::string Printed(double rate_hz, int jump_after = 1000, double jump_s = 0) {
  std::string text = "time_s,displacement_mm\n";
  for (int i = 0; i < 200; ++i) {
    const double time_s = i / rate_hz + (i > jump_after ? jump_s : 0);
    text += fmt::format("{:.3f},0.{}\n", time_s, i % 10);
  }
  return text;
}

TEST_F(ImportedTrial, KeepsTheUncertaintyOfPrintedTimes) {
  Import(Printed(321.77));
  ASSERT_EQ(table_.timing, trial::Timing::kUniform);
  ASSERT_GT(table_.stretches.at(0).time_uncertainty_s, 0);
  ExpectTheSameTimes();
}

TEST_F(ImportedTrial, KeepsTimesThatAreExact) {
  Import(Printed(1000, 99, 0.05));
  ASSERT_EQ(table_.stretches.size(), 2U);
  ExpectTheSameTimes();
}

}  // namespace
}  // namespace haptometer::tools
