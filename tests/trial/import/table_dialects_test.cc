// Tables as further programs write them, each made here with numbers of its own.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/findings.h"
#include "tests/residual.h"
#include "trial/import/readers.h"

namespace haptometer::trial {
namespace {

using tests::NumbersOf;

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::size_t kRows = 300;

// what the two channels hold: an offset and a wave
double First(std::size_t i) { return 1.25 + 0.5 * std::sin(0.3 * static_cast<double>(i)); }
double Second(std::size_t i) { return -0.75 + 0.25 * std::cos(0.2 * static_cast<double>(i)); }
double Time(std::size_t i) { return -0.012 + static_cast<double>(i) * 8e-5; }

using Row = std::function<std::string(std::size_t)>;

std::string Rows(const Row& row) {
  std::string text;
  for (std::size_t i = 0; i < kRows; ++i) text += row(i) + "\n";
  return text;
}

struct Dialect {
  const char* name;
  std::string text;
  std::vector<std::string> channels;
  double start_s = -0.012;
  std::vector<std::string> columns{};
  std::optional<double> rate_hz{};
};

void PrintTo(const Dialect& dialect, std::ostream* out) { *out << dialect.name; }

class Dialects : public ::testing::TestWithParam<Dialect> {};

void ExpectValues(const Record& record, const Dialect& dialect) {
  ASSERT_EQ(record.rows, kRows);
  EXPECT_TRUE(record.raw_times_s.empty()) << "not on a grid";
  ASSERT_EQ(record.stretches.size(), 1);
  EXPECT_REL(record.stretches[0].rate_hz, 12'500, 1e-6, "printed digits");
  EXPECT_ABS(record.stretches[0].start_s, dialect.start_s, 1e-7, "printed digits");
  ASSERT_EQ(record.channels.size(), dialect.channels.size());
  for (std::size_t c = 0; c < record.channels.size(); ++c) {
    EXPECT_EQ(record.channels[c].name, dialect.channels[c]);
    EXPECT_EQ(record.channels[c].role, ChannelRole::kVoltage);
    for (std::size_t i = 0; i < kRows; ++i) {
      ASSERT_NEAR(record.channels[c].values[i], c == 0 ? First(i) : Second(i), 1e-6) << "row " << i;
    }
  }
}

TEST_P(Dialects, IsReadAsItIsMeant) {
  const Dialect& dialect = GetParam();
  const ImportOptions options{.columns = dialect.columns, .rate_hz = dialect.rate_hz};
  const auto record = ParseCsv(dialect.text, "f.csv", options);
  ASSERT_TRUE(record) << record.error().Text();
  ExpectValues(*record, dialect);
}

// the same behind a byte-order mark, with CR LF
TEST_P(Dialects, AreReadWithAByteOrderMarkAndCrLf) {
  const Dialect& dialect = GetParam();
  std::string text = "\xef\xbb\xbf";
  for (const char c : dialect.text) text += c == '\n' ? "\r\n" : std::string(1, c);
  const ImportOptions options{.columns = dialect.columns, .rate_hz = dialect.rate_hz};
  const auto record = ParseCsv(text, "f.csv", options);
  ASSERT_TRUE(record) << record.error().Text();
  ExpectValues(*record, dialect);
}

// the same as UTF-16, as Windows programs write it
TEST_P(Dialects, AreReadAsUtf16) {
  const Dialect& dialect = GetParam();
  std::string text = "\xff\xfe";
  for (const char c : dialect.text) {
    if (static_cast<unsigned char>(c) > 0x7e) GTEST_SKIP() << "not of ASCII alone";
    text += c;
    text += '\0';
  }
  const ImportOptions options{.columns = dialect.columns, .rate_hz = dialect.rate_hz};
  const auto record = ParseCsv(text, "f.csv", options);
  ASSERT_TRUE(record) << record.error().Text();
  ExpectValues(*record, dialect);
}

std::string WithCommas(std::string text) {
  std::ranges::replace(text, '.', ',');
  return text;
}

const Row kBlanks = [](auto i) {
  return fmt::format("{:.18e} {:.18e} {:.18e}", Time(i), First(i), Second(i));
};
const Row kValues = [](auto i) { return fmt::format("{:.6e},{:.6e},", First(i), Second(i)); };

INSTANTIATE_TEST_SUITE_P(
    All, Dialects,
    ::testing::Values(
        // numpy.savetxt with its defaults
        Dialect{.name = "numpy_savetxt",
                .text = Rows(kBlanks),
                .channels = {"voltage", "voltage_2"},
                .columns = {"time_s", "voltage_v", "voltage_2_v"}},
        Dialect{.name = "numpy_savetxt_with_a_header",
                .text = "# made by a script\n# time_s voltage_v voltage_2_v\n" + Rows(kBlanks),
                .channels = {"voltage", "voltage_2"}},
        Dialect{
            .name = "numpy_savetxt_without_times",
            .text = Rows([](auto i) { return fmt::format("{:.9e} {:.9e}", First(i), Second(i)); }),
            .channels = {"voltage", "voltage_2"},
            .start_s = 0,
            .columns = {"voltage_v", "voltage_2_v"},
            .rate_hz = 12'500},
        Dialect{.name = "commas_under_a_comment",
                .text = "# Time (s),CH1 (V),CH2 (V)\n" + Rows([](auto i) {
                          return fmt::format("{:.9e},{:.9e},{:.9e}", Time(i), First(i), Second(i));
                        }),
                .channels = {"CH1", "CH2"}},
        Dialect{.name = "aligned_with_blanks",
                .text = "   Time (s)    CH 1 (V)    CH 2 (V)\n" + Rows([](auto i) {
                          return fmt::format("  {:12.7f}   {:12.8f}  {:12.8f}  ", Time(i), First(i),
                                             Second(i));
                        }),
                .channels = {"CH 1", "CH 2"}},
        Dialect{.name = "names_and_units_of_one_word",
                .text = "t a b\ns V V\n" + Rows([](auto i) {
                          return fmt::format(" {:.7f} {:.8f}  {:.8f}", Time(i), First(i),
                                             Second(i));
                        }),
                .channels = {"a", "b"}},
        Dialect{.name = "blanks_and_decimal_commas",
                .text = "Time[s] A[V] B[V]\n" + WithCommas(Rows([](auto i) {
                          return fmt::format("{:.7f} {:.8f} {:.8f}", Time(i), First(i), Second(i));
                        })),
                .channels = {"A", "B"}},
        Dialect{.name = "tabs_and_blanks",
                .text = "Time (s)\tA (V)\tB (V)\n" + Rows([](auto i) {
                          return fmt::format("{:.7f}\t {:.8f} \t{:.8f}", Time(i), First(i),
                                             Second(i));
                        }),
                .channels = {"A", "B"}},
        // a line of empty cells between units and numbers
        Dialect{
            .name = "picoscope_semicolons",
            .text = "Time;Channel A;Channel B\n(ms);(V);(mV)\n;;\n" + WithCommas(Rows([](auto i) {
                      return fmt::format("{:.7f};{:.8f};{:.5f}", 1e3 * Time(i), First(i),
                                         1e3 * Second(i));
                    })),
            .channels = {"Channel A", "Channel B"}},
        Dialect{.name = "rigol_without_numbers",
                .text = "CH1,CH2,Start,Increment,\nVolt,Volt,-1.2e-2,8e-5\n" + Rows(kValues),
                .channels = {"CH1", "CH2"}},
        Dialect{.name = "rigol_with_numbers_in_volt",
                .text = "X,CH1,CH4,Start,Increment\nCounter,VOLT,VOLT,-1.2E-2,8.0E-5\n" +
                        Rows([](auto i) { return fmt::format("{},{}", i, kValues(i)); }),
                .channels = {"CH1", "CH4"}},
        Dialect{.name = "rigol_of_one_line",
                .text = "CH1V,CH2V,t0 =-1.200000e-02s, tInc = 8.000000e-05,\n" + Rows(kValues),
                .channels = {"CH1", "CH2"}},
        Dialect{.name = "saleae_analog",
                .text = "Time [s],Channel 0,Coil\n" + Rows([](auto i) {
                          return fmt::format("{:.9f},{:.7f},{:.7f}", Time(i), First(i), Second(i));
                        }),
                .channels = {"Channel 0", "Coil"}},
        // the unit of TIME follows from the stated interval
        Dialect{.name = "tektronix_tbs",
                .text = "Model,TBS2074\nFirmware Version,1.30\n\nPoint Format,Y,\nHorizontal "
                        "Units,S,\nHorizontal Scale,0.002,\nSample Interval,8e-05,\nRecord "
                        "Length,300,\nVertical Units,V,V,\nLabel,,\nTIME,CH1,CH2\n" +
                        Rows([](auto i) {
                          return fmt::format("{:.4e},{:.7f},{:.7f}", Time(i), First(i), Second(i));
                        }),
                .channels = {"CH1", "CH2"}},
        Dialect{
            .name = "yokogawa",
            .text = "\"TraceName\",\"CH1\",\"CH2\"\n\"BlockSize\",300,300\n\"VUnit\",\"V\",\"V\"\n"
                    "\"HResolution\",8.0E-05,8.0E-05\n\"HOffset\",-0.012,-0.012\n" +
                    Rows([](auto i) { return fmt::format("{:.7f},{:.7f}", First(i), Second(i)); }),
            .channels = {"CH1", "CH2"}},
        Dialect{
            .name = "owon",
            .text = "Channel      : CH1\nTime interval     : 80.0000uS\n\nindex,CH1_Voltage(mV)\n" +
                    Rows([](auto i) { return fmt::format("{},{:.4f}", i, 1e3 * First(i)); }),
            .channels = {"CH1_Voltage"},
            .start_s = 0},
        Dialect{.name = "windaq",
                .text = "Relative Time (s),\"Coil (V)\",\"Ref (V)\"\n" + Rows([](auto i) {
                          return fmt::format("{:.6f},{:.7f},{:.7f}", Time(i), First(i), Second(i));
                        }),
                .channels = {"Coil", "Ref"}},
        Dialect{.name = "scopy",
                .text = ";Scopy version,1.3\n;Exported on,Mon\n;Device,M2K\n;Nr of samples,300\n"
                        ";Sample rate,12500\n;Tool,Oscilloscope\n;Additional Information,\n"
                        "Sample,Time(S),CH1(V),CH2(V)\n" +
                        Rows([](auto i) {
                          return fmt::format("{},{:.7f},{:.7f},{:.7f}", i, Time(i), First(i),
                                             Second(i));
                        }),
                .channels = {"CH1", "CH2"}}),
    [](const auto& dialect) { return dialect.param.name; });

Record Parsed(std::string_view text, const ImportOptions& options = {},
              Findings* findings = nullptr) {
  auto record = ParseCsv(text, "f.csv", options, findings);
  EXPECT_TRUE(record) << record.error().Text();
  return record ? std::move(*record) : Record{};
}

std::string ErrorOf(std::string_view text, const ImportOptions& options = {}) {
  const auto record = ParseCsv(text, "f.csv", options);
  return record ? "was read" : record.error().Text();
}

TEST(TableDialects, WhatSeparatesCellsIsSaid) {
  EXPECT_THAT(ErrorOf(Rows(kBlanks)),
              HasSubstr("no line names its 3 columns (separated by blanks)"));
  EXPECT_THAT(ErrorOf(Rows(kBlanks), {.columns = {"time_s", "voltage_v"}}),
              HasSubstr("names 2 columns where f.csv has 3, separated by blanks"));
  Findings findings;
  (void)Parsed(Rows(kBlanks), {.columns = {"time_s", "voltage_v", "-"}}, &findings);
  EXPECT_EQ(NumbersOf(findings, FindingKind::kFormatFound),
            "format=plain title=plain table channels=voltage [V] separator=blanks");
}

TEST(TableDialects, ARowOfAnotherWidthBetweenBlanksIsNamed) {
  const std::string text = "0 1 2\n1 1 2\n2 1\n3 1 2\n";
  EXPECT_THAT(ErrorOf(text, {.columns = {"time_s", "voltage_v", "voltage_2_v"}}),
              HasSubstr("line 3: has 2 cells where the columns are 3"));
  EXPECT_EQ(Parsed("0 nan 2\n1 1 2\n", {.columns = {"time_s", "voltage_v", "-"}})
                .channels.at(0)
                .statuses.at(0),
            SampleStatus::kInvalid);
}

TEST(TableDialects, WordsAboveNumbersAreNoNumbers) {
  const Record record = Parsed("Probe 10 of 12\nTime (s),CH1 (V)\n0,1\n1,2\n");
  EXPECT_THAT(record.metadata.notes, ElementsAre("Probe 10 of 12"));
}

TEST(TableDialects, SaleaeTellsAnalogFromDigital) {
  Findings findings;
  const Record analog = Parsed("Time [s],Channel 0\n0.0,0.125\n0.5,-0.25\n1.0,1\n", {}, &findings);
  EXPECT_EQ(analog.channels.at(0).role, ChannelRole::kVoltage);
  EXPECT_EQ(NumbersOf(findings, FindingKind::kValueUnitAssumed), "title=Saleae Logic 2 unit=V");
  EXPECT_FALSE(findings.Has(FindingKind::kTransitionsOnly));
  findings = {};
  const Record digital = Parsed("Time [s],D0\n0.0,0\n0.31,1\n0.4,0\n", {}, &findings);
  EXPECT_EQ(digital.channels.at(0).role, ChannelRole::kOther);
  EXPECT_TRUE(findings.Has(FindingKind::kTransitionsOnly));
}

TEST(TableDialects, ATimeInBracketsBesideOtherUnitsIsNoLogicAnalyser) {
  const Record record =
      Parsed("Time [s],Laser [mm],Temperature\n0.0,1.5,20\n0.5,1.6,21\n1.0,1.4,22\n");
  ASSERT_EQ(record.channels.size(), 2U);
  EXPECT_EQ(record.channels[0].role, ChannelRole::kDisplacement);
  EXPECT_EQ(record.channels[1].role, ChannelRole::kOther);
  // in brackets of the other kind, and a name with an index
  EXPECT_EQ(Parsed("Time [s],Laser (mm),Temperature\n0.0,1.5,20\n0.5,1.6,21\n1.0,1.4,22\n")
                .channels.at(1)
                .role,
            ChannelRole::kOther);
  EXPECT_EQ(
      Parsed("Time [s],A0,CS[1]\n0.0,1.5,2.5\n0.5,1.6,2.4\n1.0,1.4,2.5\n").channels.at(1).role,
      ChannelRole::kVoltage);
}

// the unit that a name states is not the volt, beside a channel of a logic analyser too
TEST(TableDialects, AStatedUnitIsNotReplacedByVolts) {
  for (const char* name : {"Force [N]", "Acceleration (m/s^2)", "Laser mm", "Laser_mm",
                           "Laser [mm] (raw)", "Position [raw]"}) {
    for (const char* beside : {"", "Channel 0,"}) {
      const Record record = Parsed(fmt::format("Time [s],{}{}\n0.0,1.5,{}\n0.5,1.6,{}\n", beside,
                                               name, *beside ? "2.5" : "", *beside ? "2.4" : ""));
      EXPECT_NE(record.channels.back().role, ChannelRole::kVoltage) << beside << name;
    }
  }
}

// pandas without names
TEST(TableDialects, NumbersOfColumnsAreNoReading) {
  const Record indexed = Parsed(",0,1\n0,0.0001,30.1\n1,0.0002,30.2\n2,0.0003,30.1\n",
                                {.columns = {"-", "time_s", "displacement_mm"}});
  ASSERT_EQ(indexed.rows, 3U);
  EXPECT_REL(indexed.channels[0].values[0], 30.1e-3, 1e-12, "rounding");
  const Record single =
      Parsed("0\n30.1\n30.2\n30.1\n", {.columns = {"displacement_mm"}, .rate_hz = 1e4});
  EXPECT_EQ(single.rows, 3U);
  // whole numbers, and values beside those of the line, may be readings
  EXPECT_EQ(
      Parsed("0,1\n0.0001,0.9999\n0.0002,0.9996\n", {.columns = {"time_s", "displacement_mm"}})
          .rows,
      3U);
  EXPECT_EQ(Parsed("0,1\n1,3\n2,5\n", {.columns = {"time_s", "displacement_mm"}}).rows, 3U);
  EXPECT_EQ(Parsed("0\n0.1\n0.2\n", {.columns = {"displacement_mm"}, .rate_hz = 1e4}).rows, 3U);
}

TEST(TableDialects, ATorqueIsNoDisplacement) {
  const Record record =
      Parsed("Time (s),Torque (Nm),Laser (mm)\n0.0,1.5,20\n0.5,1.6,21\n1.0,1.4,22\n");
  ASSERT_EQ(record.channels.size(), 2U);
  EXPECT_EQ(record.channels[0].role, ChannelRole::kOther);
  EXPECT_EQ(record.channels[1].role, ChannelRole::kDisplacement);
}

TEST(TableDialects, AFrequencyIsLeftOutAndNoColumnBehindIt) {
  const Record record = Parsed(
      "Time (s),Laser (mm),Frequency (Hz),Drive (V)\n0.0,1.5,50,1\n0.5,1.6,50,2\n1.0,1.4,50,1\n");
  ASSERT_EQ(record.channels.size(), 2U);
  EXPECT_EQ(record.channels[0].role, ChannelRole::kDisplacement);
  EXPECT_EQ(record.channels[1].role, ChannelRole::kVoltage);
}

// a month with an e, and a date with points, say nothing of the time's digits
TEST(TableDialects, AGapShowsBehindAnyDate) {
  for (const std::string date : {"06-Dec-2024", "06-Jan-2024", "06.05.2024"}) {
    std::string text = "Time;Laser (mm)\n";
    for (int i = 0; i < 300; ++i) {
      if (i >= 150 && i < 160) continue;
      // one time stands twice, and one of its rows is left out
      const double time_s = (i == 5 ? 4 : i) * 0.01;
      text += fmt::format("{} 12:00:{:06.3f};{:.3f}\n", date, time_s, 1.5 + 0.1 * (i % 7));
    }
    const Record record = Parsed(text);
    const bool is_seen = std::ranges::any_of(
        record.stretches, [](const Stretch& stretch) { return stretch.first_row == 149; });
    EXPECT_TRUE(is_seen) << date;
    EXPECT_REL(record.stretches[0].rate_hz, 100, 1e-3, "printed digits");
  }
}

TEST(TableDialects, AChannelIsNamedAsTheHeaderPrintsIt) {
  const std::string own = "time_s,displacement_mm,voltage_v,voltage_2_v\n0,1,2,3\n1,4,5,6\n";
  for (const char* name : {"voltage_v", "Voltage_V", "voltage"}) {
    const Record record = Parsed(own, {.channel = name});
    ASSERT_EQ(record.channels.size(), 1) << name;
    EXPECT_EQ(record.channels[0].values.at(0), 2);
  }
  EXPECT_EQ(Parsed(own, {.channel = "displacement_mm"}).channels.at(0).values.at(1), 4e-3);
  const std::string scope = "Time (s),CH1 (V),CH2 (V)\n0,1,2\n1,3,4\n";
  EXPECT_EQ(Parsed(scope, {.channel = "CH2 (V)"}).channels.at(0).values.at(1), 4);
  EXPECT_EQ(Parsed(scope, {.channel = "CH2"}).channels.at(0).values.at(1), 4);
}

TEST(TableDialects, AChosenChannelKeepsWhatIsSaidOfIt) {
  const std::string text =
      "# channel.1.name = Laser\n# channel.1.range_max = 0.25\n# channel.2.name = Coil\n"
      "# channel.2.range_max = 10\ntime_s,displacement_m,voltage_v,status_1,status_2\n"
      "0,0.1,2,ok,repeated\n1,,3,late,ok\n";
  const Record record = Parsed(text, {.channel = "Coil"});
  ASSERT_EQ(record.channels.size(), 1);
  EXPECT_EQ(record.channels[0].name, "Coil");
  EXPECT_EQ(record.channels[0].range_max, 10);
  EXPECT_EQ(record.channels[0].statuses,
            (std::vector<SampleStatus>{SampleStatus::kRepeated, SampleStatus::kOk}));
}

TEST(TableDialects, AClockOfTheWallWithItsDateInIsoForm) {
  const Record record = Parsed(
      "Time,Coil (V)\n2024-05-06T23:59:59.500Z,1\n2024-05-07T00:00:00.000Z,2\n"
      "2024-05-07T00:00:00.500Z,3\n");
  EXPECT_REL(record.stretches.at(0).rate_hz, 2, 1e-9, "printed times");
  EXPECT_TRUE(record.raw_times_s.empty());
}

TEST(TableDialects, ARateThatIsSaidIsKept) {
  EXPECT_EQ(Parsed("Time,CH1 (V)\n0,1\n1,2\n", {.rate_hz = 1000.0}).metadata.nominal_rate_hz, 1000);
}

// --- names, units and rows that do without them --------------------------------------------------

TEST(TableDialects, RowsMayEndInSeparatorsAndLackWhatIsLeftOut) {
  const std::string head = "Time (s),CH1 (V)\n0,1\n1,2\n";
  EXPECT_EQ(Parsed(head + "2,3,\n3,4,,\n").rows, 4U);
  EXPECT_THAT(ErrorOf(head + "2,3,4\n"), HasSubstr("line 4: has 3 cells where the columns are 2"));
  EXPECT_EQ(Parsed(head + ",\n2,3\n").rows, 3U) << "a row of empty cells between times";
  const std::string rows = "0,1,7\n1,2,8\n2,3\n";
  EXPECT_EQ(Parsed(rows, {.columns = {"time_s", "voltage_v", "-"}}).rows, 3U);
  EXPECT_THAT(ErrorOf(rows, {.columns = {"time_s", "voltage_v", "a"}}),
              HasSubstr("line 3: has 2 cells where the columns are 3"));
  // a column without content needs no name
  EXPECT_EQ(Parsed("0,1,\n1,2,\n", {.columns = {"time_s", "voltage_v"}}).rows, 2U);
  EXPECT_THAT(ErrorOf("0,1,\n1,2,3\n", {.columns = {"time_s", "voltage_v"}}),
              HasSubstr("names 2 columns where f.csv has 3"));
  EXPECT_THAT(ErrorOf("Time (s),CH1 (V)\n0,1,\n1,2,3\n"), HasSubstr("no line names its 3 columns"));
  EXPECT_EQ(ErrorOf("0,1,2\n1,3,4\n", {.columns = {"time_s", "voltage_v", "status_2"}}),
            "f.csv: 'status_2' is about a channel that is not there");
  EXPECT_EQ(Parsed(",A (V),B (V)\n,1,2\n,3,4\n", {.rate_hz = 1.0}).channels.size(), 2U);
}

TEST(TableDialects, ANumberInAColumnThatIsLeftOutMayGroupThousands) {
  const Record record = Parsed("0;1;1,234\n1;2;1,235\n", {.columns = {"time_s", "voltage_v", "-"}});
  EXPECT_EQ(record.channels.at(0).values.at(1), 2);
}

TEST(TableDialects, ANumberThatIsNoneByItsOwnWordIsInvalid) {
  const Record record = Parsed("Time (s),CH1 (V)\n0,1\n1,nan(ind)\n2,-inf\n");
  EXPECT_EQ(
      record.channels.at(0).statuses,
      (std::vector<SampleStatus>{SampleStatus::kOk, SampleStatus::kInvalid, SampleStatus::kUnder}));
}

TEST(TableDialects, BracketsAndUnderscoresWithinANameStay) {
  const Record record =
      Parsed("Time (s),CH(1) top,t_x,(mV),Level/dB,A [mm\n0,1,2,3,4,5\n1,2,3,4,5,6\n");
  std::vector<std::string> names;
  for (const Channel& channel : record.channels) names.push_back(channel.name);
  EXPECT_THAT(names, ElementsAre("CH(1) top", "t_x", "(mV)", "Level/dB", "A [mm"));
  EXPECT_EQ(record.channels[1].role, ChannelRole::kOther);
  EXPECT_EQ(record.channels[2].role, ChannelRole::kVoltage);
  EXPECT_REL(record.channels[2].values[0], 3e-3, 1e-15, "one product");
  EXPECT_EQ(record.channels[4].role, ChannelRole::kOther) << "no bracket closes";
}

TEST(TableDialects, AStatedUnitIsOfValuesWithoutOne) {
  const auto unit = [](const char* stated, const char* name) {
    return Parsed(fmt::format("Vertical Units,{}\nTime (s),{}\n0,1\n1,2\n", stated, name))
        .channels.at(0)
        .unit;
  };
  EXPECT_EQ(unit("mV", "A"), "V");
  EXPECT_EQ(unit("furlong", "A"), "");
  EXPECT_EQ(unit("mV", "trigger"), "") << "a trigger has no unit";
}

TEST(TableDialects, ColumnsWithoutNamesAreRefusedByTheirNumber) {
  EXPECT_EQ(ErrorOf("0,1\n0.5,2\n"),
            "f.csv: no line names its 2 columns: the first may be a time (2 rows per second in s, "
            "2000 in ms) or a channel like the others; give <columns> time_s,voltage_v, or "
            "<columns> voltage_v,voltage_2_v with <rate>");
  // a first column that does not grow is no time
  for (const char* rows : {"0.5,1\n0,2\n", "0,1\n0,2\n"}) {
    EXPECT_EQ(ErrorOf(rows),
              "f.csv: no line names its 2 columns; put a line such as time_s,displacement_m above "
              "the numbers (time_s,voltage_v for a coil), or give <columns>");
  }
  EXPECT_THAT(ErrorOf("1\n2\n3\n"),
              HasSubstr("holds one column, without a name and without times"));
  // two cells for a name between semicolons are no halves of a number
  EXPECT_THAT(ErrorOf("a;b\n0;1;1;5\n1;2;1;6\n"), HasSubstr("no line names its 4 columns"));
}

TEST(TableDialects, OneColumnBesideAClockNeedsNoName) {
  const Record record = Parsed("Sample Interval,1e-3\n1\n2\n3\n");
  EXPECT_EQ(record.channels.at(0).name, "channel_1");
  EXPECT_EQ(record.stretches.at(0).rate_hz, 1000);
  // Hantek's blocks have a clock of their own, which this text lacks
  EXPECT_THAT(ErrorOf("1\n2\n3\n", {.format = TableFormat::kHantek}),
              HasSubstr("no column is a time and no line above states the sample interval"));
  const ImportOptions infiniium{.format = TableFormat::kKeysightInfiniium};
  EXPECT_EQ(Parsed("0,1\n0.5,2\n", infiniium).stretches.at(0).rate_hz, 2);
  EXPECT_EQ(Parsed("0,1\n0.5,2\n", infiniium).channels.at(0).unit, "V");
  EXPECT_THAT(ErrorOf("0,1,2\n0.5,2,3\n", infiniium), HasSubstr("no line names its 3 columns"));
}

TEST(TableDialects, TracesAreAsManyAsColumns) {
  const auto text = [](const char* names) {
    return fmt::format("TraceName,{}\nHResolution,0.25,0.25\nHUnit,s,s\n\n1,2\n3,4\n", names);
  };
  EXPECT_EQ(Parsed(text("CH1,CH2")).channels.at(1).name, "CH2");
  EXPECT_EQ(Parsed(text("CH1,CH2")).stretches.at(0).rate_hz, 4);
  for (const char* names : {"CH1", "CH1,CH2,CH3"}) {
    EXPECT_THAT(ErrorOf(text(names)), HasSubstr("no line names its 2 columns")) << names;
  }
}

// a DPO states the unit of its times; an MSO's are in s
TEST(TableDialects, TimesOfTektronixHaveTheUnitOfTheirAxis) {
  const auto text = [](const char* keys) {
    return fmt::format("Model,DPO4104\nWaveform Type,ANALOG\n{}\nTIME,CH1 (V)\n0,1\n1,2\n", keys);
  };
  EXPECT_EQ(Parsed(text("Horizontal Units,ms")).stretches.at(0).rate_hz, 1000);
  EXPECT_EQ(Parsed(text("Zero Index,0")).stretches.at(0).rate_hz, 1);
  for (const char* keys : {"Probe,10", "Horizontal Units,V", "Zero Index,0\nHorizontal Units,V"}) {
    EXPECT_THAT(ErrorOf(text(keys)), HasSubstr("column 'TIME' does not state its unit")) << keys;
  }
}

TEST(TableDialects, WordsAboveNamesAndUnitsAreNotes) {
  for (const char* head : {"Time (s),A (V)\n", "Time,A\n(s),(V)\n"}) {
    const Record record = Parsed(std::string("some words\n") + head + "0,1\n1,2\n");
    EXPECT_EQ(record.channels.at(0).name, "A");
    EXPECT_THAT(record.metadata.notes, ElementsAre("some words")) << head;
  }
}

// "value" stands for a unit beside one of time alone
TEST(TableDialects, NamesBelowWordsAreNoUnits) {
  EXPECT_EQ(Parsed("some,words\nSecond,Laser\n0,1\n1,2\n").channels.at(0).name, "Laser");
  EXPECT_EQ(Parsed("Source,Laser\nSecond,Value\n0,1\n1,2\n").channels.at(0).name, "Laser");
  const Record record = Parsed("some,words\nLaser,Value\n0,1\n1,2\n", {.rate_hz = 1.0});
  ASSERT_EQ(record.channels.size(), 2U);
  EXPECT_EQ(record.channels[1].name, "Value");
}

TEST(TableDialects, AUnitThatIsPrintedBeatsTheRate) {
  EXPECT_THAT(ErrorOf("Time (ms),A (V)\n0,1\n1,2\n", {.rate_hz = 1e6}),
              HasSubstr("its times give 1000 rows per second and <rate> gives 1e+06 Hz"));
}

// 100 000 segments are the most; the row that would begin another is named
TEST(TableDialects, TimesThatFallInEveryRowAreNoSegments) {
  std::string text = "Time (s),CH1 (V)\n";
  for (int i = 100'003; i > 0; --i) text += std::to_string(i) + ",0\n";
  EXPECT_THAT(ErrorOf(text), HasSubstr("f.csv: line 100002: time 3 s does not grow"));
}

TEST(TableDialects, StatusesInRowsOfNumbersAreOfTheirChannel) {
  const Record record =
      Parsed("0,1,over\n1,2,invalid\n2,3,ok\n", {.columns = {"time_s", "voltage_v", "status_1"}});
  EXPECT_EQ(
      record.channels.at(0).statuses,
      (std::vector<SampleStatus>{SampleStatus::kOver, SampleStatus::kInvalid, SampleStatus::kOk}));
  EXPECT_EQ(record.channels[0].values.at(2), 3);
}

}  // namespace
}  // namespace haptometer::trial
