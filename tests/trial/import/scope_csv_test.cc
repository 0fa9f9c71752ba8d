// Every layout of fixtures/scope_csv (fixtures/generate/scope_csv.py): the layout is told, the
// right columns are read in the right units, and the rows are where the file says.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "tests/findings.h"
#include "tests/residual.h"
#include "trial/import/read_recording.h"
#include "trial/import/readers.h"

namespace haptometer::trial {
namespace {

using tests::NumbersOf;

using ::testing::HasSubstr;

std::string PathOf(const std::string& file) { return HAPTOMETER_FIXTURES "/scope_csv/" + file; }

// what the generator put into row k
double First(std::size_t k) { return (static_cast<double>(k % 16) - 8) / 4; }
double Second(std::size_t k) { return -static_cast<double>(k % 5) / 2; }

struct Layout {
  std::string file;
  std::string format;
  std::vector<std::string> channels;  // of voltages; the second signal where there are two
  double rate_hz = 0;
  double start_s = 0;
  std::size_t rows = 64;
  double rate_tolerance = 1e-9;  // printed times and steps in decimal
  // what must be found beside the layout, with its numbers
  std::optional<std::pair<FindingKind, std::string>> found{};
};

void PrintTo(const Layout& layout, std::ostream* out) { *out << layout.file; }

class ScopeLayout : public ::testing::TestWithParam<Layout> {};

TEST_P(ScopeLayout, IsReadAsItsMakerMeansIt) {
  const Layout& wanted = GetParam();
  const auto recording = ReadRecording(PathOf(wanted.file));
  ASSERT_TRUE(recording) << recording.error().Text();
  const Record& record = recording->record;
  EXPECT_EQ(record.metadata.fields.at("table.format"), wanted.format);
  const Findings& findings = recording->report.findings;
  EXPECT_THAT(NumbersOf(findings, FindingKind::kFormatFound),
              HasSubstr("format=" + wanted.format + " title="));
  if (wanted.found) {
    EXPECT_TRUE(findings.Has(wanted.found->first));
    EXPECT_THAT(NumbersOf(findings, wanted.found->first), HasSubstr(wanted.found->second));
  }
  EXPECT_EQ(record.rows, wanted.rows);
  EXPECT_TRUE(record.raw_times_s.empty()) << "not on a grid";
  ASSERT_EQ(record.stretches.size(), 1);
  EXPECT_REL(record.stretches[0].rate_hz, wanted.rate_hz, wanted.rate_tolerance, "see Layout");
  EXPECT_ABS(record.stretches[0].start_s, wanted.start_s, 0.1 / wanted.rate_hz,
             "a tenth of a period, of times with five digits");
  ASSERT_EQ(record.channels.size(), wanted.channels.size());
  for (std::size_t c = 0; c < record.channels.size(); ++c) {
    const Channel& channel = record.channels[c];
    EXPECT_EQ(channel.name, wanted.channels[c]);
    EXPECT_EQ(channel.role, ChannelRole::kVoltage);
    EXPECT_EQ(channel.unit, "V");
    const bool is_second = c == 1 || wanted.channels == std::vector<std::string>{"CH2"};
    for (std::size_t k = 0; k < record.rows; ++k) {
      if (!IsMeasurement(channel.statuses[k])) continue;
      ASSERT_DOUBLE_EQ(channel.values[k], is_second ? Second(k) : First(k)) << "row " << k;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, ScopeLayout,
    ::testing::Values(
        Layout{"tektronix_tds.csv", "tektronix-tds", {"CH1"}, 25000, -9.6e-4},
        Layout{"tektronix_tds_excel.csv", "tektronix-tds", {"CH1"}, 25000, -9.6e-4},
        // five digits: the sample interval is the only word on the rate
        Layout{"tektronix_dpo.csv", "tektronix-dpo", {"CH1", "CH2"}, 2.5e8, -2e-4, 300},
        Layout{"tektronix_mso.csv", "tektronix-mso", {"REF7"}, 2.5e10, -24.16015625 * 4e-11},
        Layout{"rigol_sequence.csv", "rigol-sequence", {"CH1", "CH2"}, 2.5e7, -1.2e-3},
        Layout{.file = "rigol_sequence_from_22.csv",
               .format = "rigol-sequence",
               .channels = {"CH2"},
               .rate_hz = 5e5,
               .start_s = -1.4e-3 + 22 * 2e-6,
               .found = {{FindingKind::kRowsBeginAt, "first=22 earlier_s=4.4e-05"}}},
        // times are rounded to 32-bit floats
        Layout{"rigol_seconds.csv", "rigol-seconds", {"CH1", "CH2"}, 5e5, -6e-4, 64, 1e-6},
        Layout{"rigol_volts.csv", "rigol-volts", {"CH 1", "CH 2"}, 1e5, -0.004688},
        Layout{"rigol_ds1204.csv", "rigol-ds1204", {"CH2", "CH4"}, 2.5e5, -1.6384e-2},
        Layout{"rigol_ultrascope.csv", "rigol-ultrascope", {"CH 1", "CH 2"}, 5e8, 0},
        Layout{"keysight_infiniivision.csv", "keysight-infiniivision", {"1", "4"}, 5000, -0.1},
        Layout{"keysight_infiniium.csv", "keysight-infiniium", {"channel_1"}, 2e9, -1.6e-8},
        Layout{"keysight_infiniium_values.csv", "keysight-infiniium", {"channel_1"}, 2e9, -1.6e-8},
        // "Horizontal Units,us" is about the scale: the times are seconds
        Layout{"siglent_interval.csv", "siglent", {"CH1"}, 5e5, 0},
        Layout{"siglent_rate.csv", "siglent", {"Value"}, 1e8, -3.2e-7},
        Layout{"siglent_source.csv", "siglent", {"CH1"}, 1e9, -3.5e-7},
        Layout{.file = "siglent_values.csv",
               .format = "siglent",
               .channels = {"CH1"},
               .rate_hz = 1e8,
               .found = {{FindingKind::kStartAssumed, ""}}},
        Layout{.file = "lecroy.csv",
               .format = "lecroy",
               .channels = {"Ampl"},
               .rate_hz = 5e7,
               .start_s = -5e-6,
               .found = {{FindingKind::kValueUnitAssumed, "title=LeCroy unit=V"}}},
        Layout{"picoscope.csv", "picoscope", {"Channel A", "Channel B"}, 1e6, -1e-4},
        Layout{"picoscope_german.csv", "picoscope", {"Kanal A"}, 1e9, -1e-7},
        Layout{"picoscope_latin1.csv", "picoscope", {"Kanal A"}, 1e9, -1e-7},
        Layout{"picoscope_utf16.csv", "picoscope", {"Kanal A"}, 1e9, -1e-7},
        Layout{"digilent.csv", "digilent", {"Channel 1", "Channel 2"}, 1e5, -3.2e-4},
        Layout{"hantek.csv", "hantek", {"CH1", "CH2"}, 5e4, 0},
        Layout{"openhantek.csv", "openhantek", {"CH1"}, 1e5, 0},
        Layout{"rohde_schwarz.csv", "rohde-schwarz", {"C1"}, 1e4, -0.6},
        Layout{"batronix.csv", "rohde-schwarz", {"CH1"}, 1e6, 0},
        Layout{.file = "ni_pxi.csv",
               .format = "ni-pxi",
               .channels = {"Channel 0 (PXI1Slot5/0)", "Channel 1 (PXI1Slot5/1)"},
               .rate_hz = 1 / 1.5e-7,
               .start_s = 0.0336875851235834,
               .found = {{FindingKind::kValueUnitAssumed, "title=NI PXI unit=V"}}},
        // times of the wall's clock, over midnight; whole microseconds
        Layout{.file = "ni_elvis.csv",
               .format = "ni-elvis",
               .channels = {"V_S", "V_C"},
               .rate_hz = 4e5,
               .found = {{FindingKind::kChannelsApart, "apart_s="}}},
        Layout{.file = "five_digits.csv",
               .format = "plain",
               .channels = {"CH1", "CH2"},
               .rate_hz = 1 / 1.5e-8,
               .start_s = -0.003,
               .rows = 4000,
               .rate_tolerance = 2e-4,
               .found = {{FindingKind::kTimesRebuilt, " rows=4000"}}},
        Layout{.file = "excel.csv",
               .format = "plain",
               .channels = {"CH1", "CH2"},
               .rate_hz = 1000,
               .start_s = -0.1,
               .rows = 400,
               .rate_tolerance = 1e-3}),
    [](const auto& layout) { return layout.param.file.substr(0, layout.param.file.find('.')); });

TEST(ScopeCsv, ClipTokensAreNoMeasurements) {
  const auto recording = ReadRecording(PathOf("clipped.csv"));
  ASSERT_TRUE(recording) << recording.error().Text();
  const Channel& channel = recording->record.channels.at(0);
  using enum SampleStatus;
  const std::vector<SampleStatus> wanted{kOk, kOk, kOk, kOver, kInvalid, kClipped, kUnder, kOver};
  EXPECT_EQ(std::vector(channel.statuses.begin(), channel.statuses.begin() + 8), wanted);
  EXPECT_TRUE(std::isnan(channel.values[3]));
  EXPECT_EQ(channel.values[8], First(8));
  const auto pico = ReadRecording(PathOf("picoscope.csv"));
  ASSERT_TRUE(pico) << pico.error().Text();
  EXPECT_EQ(pico->record.channels.at(0).statuses.at(7), kOver);
  EXPECT_EQ(pico->record.channels[0].statuses.at(8), kUnder);
}

TEST(ScopeCsv, ChannelsThatBeginApartAreFound) {
  const auto recording = ReadRecording(PathOf("ni_elvis.csv"));
  ASSERT_TRUE(recording) << recording.error().Text();
  for (const Finding& found : recording->report.findings.list()) {
    if (found.kind != FindingKind::kChannelsApart) continue;
    EXPECT_ABS(std::get<double>(found.numbers.at(0).value), 1e-6, 2e-11, "times of a day");
  }
}

TEST(ScopeCsv, SegmentsLieWhereTheFileSays) {
  const auto recording = ReadRecording(PathOf("lecroy_segments.csv"));
  ASSERT_TRUE(recording) << recording.error().Text();
  const Record& record = recording->record;
  ASSERT_EQ(record.stretches.size(), 3);
  EXPECT_EQ(record.stretches[2].first_row, 128);
  EXPECT_ABS(record.stretches[2].start_s, 0.5 - 5e-6, 1e-12, "printed digits");
  const auto second = ReadRecording(PathOf("lecroy_segments.csv"), {.segment = 2});
  ASSERT_TRUE(second) << second.error().Text();
  EXPECT_EQ(second->record.rows, 64);
  EXPECT_EQ(second->record.channels.at(0).values.at(3), First(3));
  EXPECT_ABS(second->record.stretches.at(0).start_s, -5e-6, 1e-12, "its own time");
  const auto none = ReadRecording(PathOf("lecroy_segments.csv"), {.segment = 4});
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().Text(), HasSubstr("has 3 segments"));
}

TEST(ScopeCsv, TransitionsAreNoSamples) {
  const auto recording = ReadRecording(PathOf("saleae_digital.csv"));
  ASSERT_TRUE(recording) << recording.error().Text();
  EXPECT_TRUE(recording->report.findings.Has(FindingKind::kTransitionsOnly));
  EXPECT_EQ(recording->record.raw_times_s.size(), 5) << "an uneven time base stays as it is";
  EXPECT_EQ(recording->record.channels.at(1).statuses.at(0), SampleStatus::kInvalid);
  EXPECT_EQ(recording->record.Find(ChannelRole::kVoltage), nullptr);
  const auto analog = ReadRecording(PathOf("saleae.csv"));
  ASSERT_TRUE(analog) << analog.error().Text();
  EXPECT_EQ(analog->record.channels.at(1).name, "Coil");
  EXPECT_EQ(analog->record.channels[1].values.at(3), Second(3));
}

TEST(ScopeCsv, ChannelsAreChosenByName) {
  for (const char* name : {"Channel B", "channel b", "ChannelB"}) {
    const auto recording = ReadRecording(PathOf("picoscope.csv"), {.channel = name});
    ASSERT_TRUE(recording) << recording.error().Text();
    ASSERT_EQ(recording->record.channels.size(), 1) << name;
    EXPECT_EQ(recording->record.channels[0].values.at(3), Second(3));
  }
  const auto other = ReadRecording(PathOf("picoscope.csv"), {.channel = "CH9"});
  ASSERT_FALSE(other);
  EXPECT_THAT(other.error().Text(),
              HasSubstr("has no channel called 'CH9' (its channels: Channel A, Channel B)"));
}

TEST(ScopeCsv, LabviewFilesWithAndWithoutAHeader) {
  const auto whole = ReadRecording(PathOf("labview.lvm"));
  ASSERT_TRUE(whole) << whole.error().Text();
  EXPECT_EQ(whole->record.channels.at(0).role, ChannelRole::kDisplacement);
  EXPECT_DOUBLE_EQ(whole->record.channels[0].values.at(3), First(3) * 1e-3);
  const auto bare = ReadRecording(PathOf("labview_bare.lvm"), {.rate_hz = 1e4, .scale_v = 2.0});
  ASSERT_TRUE(bare) << bare.error().Text();
  EXPECT_EQ(bare->record.channels.at(0).role, ChannelRole::kVoltage);
  EXPECT_DOUBLE_EQ(bare->record.channels[0].values.at(3), First(3) * 2);
  EXPECT_EQ(bare->record.stretches.at(0).rate_hz, 1e4);
  const auto nothing_said = ReadRecording(PathOf("labview_bare.lvm"));
  ASSERT_FALSE(nothing_said);
  EXPECT_THAT(nothing_said.error().Text(),
              HasSubstr("holds one column, without a name and without times; give <rate>"));
}

TEST(ScopeCsv, AToolsTableWithARowNumber) {
  const auto silent = ReadRecording(PathOf("hantek_tool.tsv"));
  ASSERT_FALSE(silent);
  EXPECT_THAT(silent.error().Text(), HasSubstr("in s there are 1 rows per second, in ms 1000"));
  // the rate says which unit it is
  const auto recording = ReadRecording(PathOf("hantek_tool.tsv"), {.rate_hz = 1e6});
  ASSERT_TRUE(recording) << recording.error().Text();
  EXPECT_EQ(recording->record.channels.size(), 2) << "the row's number is no channel";
  EXPECT_REL(recording->record.stretches.at(0).rate_hz, 1e6, 1e-9, "printed times");
}

TEST(ScopeCsv, TheFormatCanBeSaid) {
  const auto plain = ReadRecording(PathOf("siglent_source.csv"), {.format = TableFormat::kPlain});
  ASSERT_TRUE(plain) << plain.error().Text();
  EXPECT_EQ(plain->record.metadata.fields.at("table.format"), "plain");
  const auto wrong =
      ReadRecording(PathOf("siglent_source.csv"), {.format = TableFormat::kTektronixTds});
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().Text(), HasSubstr("is not a table of <format> tektronix-tds"));
}

TEST(ScopeCsv, ATextWithoutLinesIsNoTable) {
  for (const std::string_view text : {"", "\n", "\r", ";", "Source,CH1,,1"}) {
    const auto read = ParseCsv(text, "empty", {.format = TableFormat::kTektronixTds});
    EXPECT_FALSE(read) << text;
  }
}

}  // namespace
}  // namespace haptometer::trial
