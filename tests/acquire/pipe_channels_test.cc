// "displacement:m,voltage:V" and a calibration become channels.
#include "acquire/sensor/pipe_channels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

using ::testing::HasSubstr;
using trial::ChannelRole;

// a file of the test that runs, removed with it
class CalibrationFile {
 public:
  explicit CalibrationFile(const std::string& text)
      : path_(::testing::TempDir() +
              ::testing::UnitTest::GetInstance()->current_test_info()->name() + ".toml") {
    std::ofstream(path_) << text;
  }
  ~CalibrationFile() { std::filesystem::remove(path_); }
  CalibrationFile(const CalibrationFile&) = delete;
  CalibrationFile& operator=(const CalibrationFile&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

std::string ErrorOf(std::string_view text, SampleFormat format = SampleFormat::kF64,
                    const std::string& calibration = {}) {
  const auto channels = ReadPipeChannels(text, format, calibration);
  if (channels) return "no error";
  EXPECT_EQ(channels.error().cause, Cause::kUsage);
  return channels.error().Text();
}

TEST(PipeChannels, AreNamedLikeTheColumnsOfACsv) {
  const auto channels =
      ReadPipeChannels("displacement:um,Voltage:mV,current_a,trigger,displacement_2:m,temperature",
                       SampleFormat::kF32, "");
  ASSERT_TRUE(channels) << channels.error().Text();
  const auto& formats = channels->formats;
  ASSERT_EQ(formats.size(), 6U);
  EXPECT_EQ(formats[0].name, "displacement");
  EXPECT_EQ(formats[0].role, ChannelRole::kDisplacement);
  EXPECT_EQ(formats[0].unit, "m");
  EXPECT_EQ(formats[0].scale, 1e-6);
  EXPECT_EQ(formats[0].encoding, trial::Encoding::kF32);
  EXPECT_EQ(formats[1].role, ChannelRole::kVoltage);
  EXPECT_EQ(formats[1].scale, 1e-3);
  EXPECT_EQ(formats[2].name, "current");
  EXPECT_EQ(formats[2].role, ChannelRole::kCurrent);
  EXPECT_EQ(formats[3].role, ChannelRole::kTrigger);
  EXPECT_EQ(formats[4].name, "displacement_2");
  EXPECT_EQ(formats[4].role, ChannelRole::kDisplacement);
  EXPECT_EQ(formats[5].role, ChannelRole::kOther);
}

TEST(PipeChannels, AreRefusedWhereTheySayTooLittle) {
  EXPECT_THAT(ErrorOf("displacement"), HasSubstr("displacement does not say its unit"));
  EXPECT_THAT(ErrorOf("displacement:V"), HasSubstr("displacement:V does not say its unit"));
  EXPECT_THAT(ErrorOf("time:s,voltage:V"), HasSubstr("time:s"));
  EXPECT_THAT(ErrorOf("status,voltage:V"), HasSubstr("status"));
  EXPECT_THAT(ErrorOf("voltage:V,voltage:V"), HasSubstr("call the second one voltage_2"));
  EXPECT_THAT(ErrorOf(""), HasSubstr("names no channel"));
  EXPECT_THAT(ErrorOf("voltage:V,"), HasSubstr("names no channel"));
  EXPECT_THAT(ErrorOf("voltage:"), HasSubstr("names no channel"));
}

TEST(PipeChannels, ACalibratedChannelComesInVolts) {
  const CalibrationFile file("[displacement]\nscale_m_per_v = 1e-3\nbad_above_v = 5.25\n");
  for (const char* text : {"displacement,voltage:V", "displacement:V,voltage:V"}) {
    const auto channels = ReadPipeChannels(text, SampleFormat::kF64, file.path());
    ASSERT_TRUE(channels) << channels.error().Text();
    EXPECT_EQ(channels->formats[0].scale, 1e-3);
    EXPECT_EQ(channels->formats[0].unit, "m");
    EXPECT_EQ(channels->limits[0].bad_above, 5.25);
    EXPECT_EQ(channels->formats[1].scale, 1);
    EXPECT_EQ(channels->fields.at("calibration"), file.path());
  }
  const auto milli = ReadPipeChannels("displacement:mV", SampleFormat::kF64, file.path());
  ASSERT_TRUE(milli);
  EXPECT_REL(milli->formats[0].scale, 1e-6, 1e-15, "one product");
  EXPECT_REL(milli->limits[0].bad_above, 5250, 1e-15, "one quotient");
  EXPECT_THAT(ErrorOf("displacement:m", SampleFormat::kF64, file.path()),
              HasSubstr("displacement comes in V by its calibration, not in m"));
}

TEST(PipeChannels, CountsNeedACalibration) {
  EXPECT_THAT(ErrorOf("displacement", SampleFormat::kI16),
              HasSubstr("nothing says what a count of displacement is"));
  EXPECT_THAT(ErrorOf("displacement:m", SampleFormat::kI16),
              HasSubstr("counts of displacement have no unit"));
  const CalibrationFile no_counts("[displacement]\nscale_m_per_v = 1e-3\n");
  EXPECT_THAT(ErrorOf("displacement", SampleFormat::kI16, no_counts.path()),
              HasSubstr("add v_per_count"));
}

TEST(PipeChannels, CountsOfATriggerStayCounts) {
  const CalibrationFile file(
      "[displacement]\nscale_m_per_v = 1e-3\nv_per_count = 0.5\nv_at_zero_count = 1\n");
  const auto channels = ReadPipeChannels("displacement,trigger", SampleFormat::kI16, file.path());
  ASSERT_TRUE(channels) << channels.error().Text();
  EXPECT_EQ(channels->formats[0].scale, 0.5e-3);
  EXPECT_EQ(channels->formats[0].offset, 1e-3);
  EXPECT_EQ(channels->formats[0].encoding, trial::Encoding::kI32);
  EXPECT_EQ(channels->formats[1].scale, 1);
  EXPECT_EQ(channels->formats[1].role, ChannelRole::kTrigger);
}

}  // namespace
}  // namespace haptometer::acquire
