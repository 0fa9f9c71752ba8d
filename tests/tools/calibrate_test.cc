// calibrate from tables of pairs: numbers, file, comparison, refusals.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "tests/residual.h"
#include "tests/temporary_files.h"
#include "tests/tools/captured.h"
#include "tools/calibrate/calibration_answer.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

Outcome Calibrate(std::vector<std::string> words) {
  return Captured(RunCalibrate, "calibrate", words);
}

class Calibration : public tests::TemporaryFiles {
 protected:
  // 21 points of `gain` m/V from -4 to 4 mm, with 1 mV of noise
  std::string Pairs(const std::string& name, double gain = 1e-3, unsigned seed = 1,
                    const std::string& more = {}) const {
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> noise(0, 1e-3);
    std::string text = "displacement_mm,voltage_v\n";
    for (int i = 0; i <= 20; ++i) {
      const double mm = -4 + 0.4 * i;
      text += fmt::format("{:.4f},{:.6f}\n", mm, 1e-3 * (mm - 0.5) / gain + noise(engine));
    }
    return File(name, text + more);
  }
};

TEST_F(Calibration, PairsGiveGainOffsetAndTheirUncertainties) {
  const auto outcome = Calibrate({Pairs("p.csv"), "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json document = json::parse(outcome.out);
  const double u = document.at("gain_standard_uncertainty_m_per_v");
  EXPECT_ABS(document.at("gain_m_per_v").get<double>(), 1e-3, 4 * u, "four standard uncertainties");
  // u = b^2 sigma / sqrt(Syy), Syy = 0.16 mm^2 * 770 for 21 levels; s of 19 degrees of freedom
  EXPECT_REL(u, 1e-6 * 1e-3 / std::sqrt(0.16e-6 * 770), 0.5, "three standard deviations of s");
  EXPECT_ABS(document.at("offset_m").get<double>(), 0.5e-3, 4e-6 / std::sqrt(21), "noise of 1 um");
  EXPECT_EQ(document.at("points"), 21);
  EXPECT_LT(document.at("nonlinearity_m").get<double>(), 4e-6);
  EXPECT_TRUE(document.at("hysteresis_m").is_null());
  EXPECT_TRUE(document.at("daq_gain").is_null());
  EXPECT_TRUE(document.at("comparison").is_null());
  EXPECT_EQ(document.at("calibration_points").size(), 21U);
}

TEST_F(Calibration, TheFileHoldsTheLineAndItsEvidence) {
  const std::string file = directory_ / "c.toml";
  ASSERT_EQ(Calibrate({Pairs("p.csv", 1e-3, 2), "--daq-range", "-10V:10V", "--averaging", "4",
                       "--sampling", "0.33ms", "-o", file})
                .status,
            0);
  const trial::ChannelFormat format{.name = "displacement",
                                    .role = trial::ChannelRole::kDisplacement};
  const auto read = trial::ReadCalibrationFile(file, {&format, 1});
  ASSERT_TRUE(read) << read.error().Text();
  const auto document = json::parse(Calibrate({Pairs("p.csv", 1e-3, 2), "--json"}).out);
  const trial::ChannelCalibration& line = read->channels.at("displacement");
  EXPECT_EQ(line.scale, document.at("gain_m_per_v"));
  EXPECT_EQ(line.offset, document.at("offset_m"));
  EXPECT_EQ(line.scale_uncertainty, document.at("gain_standard_uncertainty_m_per_v"));
  EXPECT_EQ(line.covariance, document.at("gain_offset_covariance_m2_per_v"));
  EXPECT_EQ(line.gain_uncertainty, document.at("gain_relative_standard_uncertainty"));
  EXPECT_EQ(line.degrees_of_freedom, 19);
  EXPECT_EQ(line.limits.rail_min, -10);
  EXPECT_EQ(read->averaging.averages, 4);
  EXPECT_EQ(read->averaging.sampling_s, 0.33e-3);
  EXPECT_EQ(read->date.size(), 10U);
  EXPECT_THAT(read->provenance.at("input_1"), HasSubstr("SHA-256"));
  EXPECT_THAT(read->provenance.at("command"), HasSubstr("--averaging 4"));
  // it is replaced only where that is said
  EXPECT_EQ(Calibrate({Pairs("p.csv"), "-o", file}).status, 2);
  EXPECT_EQ(Calibrate({Pairs("p.csv"), "-o", file, "--overwrite"}).status, 0);
}

TEST_F(Calibration, TheFileOfPointsWhoseOffsetOrHysteresisIsRoundingCanBeRead) {
  const trial::ChannelFormat format{.name = "displacement",
                                    .role = trial::ChannelRole::kDisplacement};
  const std::string file = directory_ / "c.toml";
  // hysteresis of 2e-19 m, and offsets, uncertainties and covariances of rounding
  for (const char* rows : {"-4,-4.001\n-2,-2.0\n0,0.001\n2,2.002\n4,3.999\n2,2.001\n0,0\n",
                           "-3,-3\n-1,-1\n0.1,0.1\n1,1\n3,3\n", "0,0\n1,3\n2,6\n3,9\n"}) {
    const std::string pairs = File("p.csv", std::string("displacement_mm,voltage_v\n") + rows);
    ASSERT_EQ(Calibrate({pairs, "-o", file, "--overwrite"}).status, 0) << rows;
    const auto read = trial::ReadCalibrationFile(file, {&format, 1});
    EXPECT_TRUE(read) << read.error().Text();
  }
}

TEST_F(Calibration, CheckSaysWhetherTodaysLineAgrees) {
  const std::string file = directory_ / "c.toml";
  ASSERT_EQ(Calibrate({Pairs("p.csv", 1e-3, 3), "-o", file}).status, 0);
  const auto same = Calibrate({Pairs("q.csv", 1e-3, 4), "--check", file, "--json"});
  EXPECT_EQ(same.status, 0) << same.out;
  EXPECT_TRUE(json::parse(same.out).at("comparison").at("agrees").get<bool>());
  // 0.1 % is ten standard uncertainties
  const auto other = Calibrate({Pairs("q.csv", 1.001e-3, 4), "--check", file, "--json"});
  EXPECT_EQ(other.status, 3);
  const json check = json::parse(other.out).at("comparison");
  EXPECT_FALSE(check.at("agrees").get<bool>());
  EXPECT_GT(check.at("gain_normalized_error").get<double>(), 1);
  EXPECT_THAT(Calibrate({Pairs("q.csv", 1.001e-3, 4), "--check", file}).out,
              HasSubstr("doubt: " + file + ": its gain is no longer valid"));
  // one that states no uncertainty cannot be compared with
  const std::string bare = File("bare.toml", "[displacement]\nscale_m_per_v = 1e-3\n");
  const auto refused = Calibrate({Pairs("q.csv"), "--check", bare});
  EXPECT_EQ(refused.status, 3);
  EXPECT_THAT(refused.err, HasSubstr("states no uncertainty of its gain"));
}

TEST_F(Calibration, PointsWithoutScatterAreComparedWhereTheyCanBe) {
  const std::string file = directory_ / "c.toml";
  const std::string exact = File("e.csv", "displacement_mm,voltage_v\n0,0\n1,1\n2,2\n3,3\n");
  ASSERT_EQ(Calibrate({exact, "-o", file}).status, 0);
  EXPECT_EQ(Calibrate({exact, "--check", file}).status, 0);
  // no uncertainty on either side explains a difference, and none of it is infinite
  const std::string other = File("o.csv", "displacement_mm,voltage_v\n0,0\n2,1\n4,2\n6,3\n");
  const auto outcome = Calibrate({other, "--check", file, "--json"});
  EXPECT_EQ(outcome.status, 3);
  const json check = json::parse(outcome.out).at("comparison");
  EXPECT_TRUE(check.at("gain_normalized_error").is_null());
  EXPECT_TRUE(check.at("agrees").is_null());
  EXPECT_THAT(outcome.out, HasSubstr("neither its points nor today's scatter"));
  // one that is stated does
  EXPECT_EQ(
      json::parse(Calibrate({other, "--check", file, "--voltage-uncertainty", "1mV", "--json"}).out)
          .at("comparison")
          .at("agrees"),
      false);
}

// of the same rig |E_n| > 1 in one of 20 comparisons at most (k = 2: 4.6 %)
TEST_F(Calibration, FalseAlarmsOfCheckAreAsStated) {
  int alarms = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const auto then = ReadPairs(Pairs("p.csv", 1e-3, 2 * seed + 1), {}, {}, {});
    const auto now = ReadPairs(Pairs("q.csv", 1e-3, 2 * seed + 2), {}, {}, {});
    ASSERT_TRUE(then && now);
    const auto answer_then = AnswerOf(*then);
    const auto answer_now = AnswerOf(*now);
    ASSERT_TRUE(answer_then && answer_now);
    const std::string file = File("c.toml", CalibrationText(*answer_then, {.utc = "2026-03-01T"}));
    const auto check = CheckAgainst(file, *answer_now);
    ASSERT_TRUE(check) << check.error().Text();
    alarms += std::abs(check->gain_error.value()) > 1 ? 1 : 0;
  }
  // 4.6 % of 200 is 9, standard deviation 3; Student's t in both makes it fewer
  EXPECT_LT(alarms, 21);
  EXPECT_GT(alarms, 0);
}

TEST_F(Calibration, StatedUncertaintiesAreUsed) {
  const std::string table = File("u.csv",
                                 "displacement_um,voltage_mv,displacement_standard_uncertainty_um,"
                                 "voltage_standard_uncertainty_mv\n"
                                 "0,1,0.5,1\n1000,1000,0.5,1\n2000,2001,0.5,1\n3000,2999,0.5,2\n");
  const auto document = json::parse(Calibrate({table, "--json"}).out);
  EXPECT_ABS(document.at("gain_coverage_factor").get<double>(), 1.96, 1e-4, "normal");
  // SciPy 1.10.1, scipy.odr.ODR(RealData(v, y, sx, sy), unilinear), y in mm
  EXPECT_REL(document.at("gain_m_per_v").get<double>(), 1.0002907061e-3, 1e-8,
             "where the search of ODR stops");
  const auto of_options = Calibrate({Pairs("p.csv"), "--voltage-uncertainty", "1mV",
                                     "--displacement-uncertainty", "0.1um", "--json"});
  EXPECT_ABS(json::parse(of_options.out).at("gain_coverage_factor").get<double>(), 1.96, 1e-4,
             "normal");
  // noise of ten times what is stated is seen
  const auto beyond = Calibrate({Pairs("p.csv"), "--voltage-uncertainty", "0.1mV"});
  EXPECT_THAT(beyond.out, HasSubstr("times as far as their stated uncertainties explain"));
  // the reference's own scale is in the gain
  const auto scale = Calibrate({Pairs("p.csv"), "--reference-uncertainty", "0.5%", "--json"});
  EXPECT_ABS(json::parse(scale.out).at("gain_relative_standard_uncertainty").get<double>(), 5e-3,
             1e-5, "the points add 0.01 %");
}

TEST_F(Calibration, TheErrorLevelAndRailsAreNamedAndLeftOut) {
  const auto outcome = Calibrate({Pairs("p.csv", 1e-3, 1, "4.4,5.498\n"), "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(json::parse(outcome.out).at("points"), 21);
  EXPECT_THAT(outcome.out, HasSubstr("+5.5 V is the error level of the amplifier's output"));
  EXPECT_THAT(outcome.out, HasSubstr("line 23 excluded"));
  const auto railed = Calibrate({Pairs("p.csv"), "--daq-range", "-4V:10V"});
  EXPECT_THAT(railed.out, HasSubstr("at the end of the DAQ's range"));
  // an output that goes beyond has no error level at 5.5 V
  const auto wide = Calibrate({Pairs("p.csv", 5e-4), "--json"});
  EXPECT_EQ(json::parse(wide.out).at("points"), 21);
}

TEST_F(Calibration, AReadingAtTheErrorLevelIsKeptWhereItFits) {
  // 0.5 mm off at 0 V, so that 6 mm is 5.5 V
  const auto kept = Calibrate({Pairs("p.csv", 1e-3, 1, "6.0,5.501\n"), "--json"});
  EXPECT_EQ(json::parse(kept.out).at("points"), 22);
  EXPECT_TRUE(json::parse(kept.out).at("bad_above_v").is_null());
  // of several all must fit
  const auto one = Calibrate({Pairs("p.csv", 1e-3, 1, "6.0,5.501\n5.2,5.5\n"), "--json"});
  EXPECT_EQ(json::parse(one.out).at("points"), 21);
  // without enough others it is the error level
  const auto few = Calibrate({File("f.csv", "displacement_mm,voltage_v\n0,0\n1,1\n5.5,5.5\n")});
  EXPECT_EQ(few.status, 3);
  EXPECT_THAT(few.err, HasSubstr("2 points"));
}

TEST_F(Calibration, TheFileStatesTheErrorLevelWhereNoPointLiesAbove) {
  const trial::ChannelFormat format{.name = "displacement",
                                    .role = trial::ChannelRole::kDisplacement};
  const std::string file = directory_ / "c.toml";
  const auto bad_above = [&](const std::string& pairs) {
    EXPECT_EQ(Calibrate({pairs, "-o", file, "--overwrite"}).status, 0);
    return trial::ReadCalibrationFile(file, {&format, 1})
        ->channels.at("displacement")
        .limits.bad_above;
  };
  EXPECT_EQ(bad_above(Pairs("p.csv")), 5.25);
  // an output of 0 to 10 V has no error level at 5.5 V
  EXPECT_EQ(bad_above(Pairs("p.csv", 5e-4)), std::numeric_limits<double>::infinity());
}

TEST_F(Calibration, MillivoltsAsVoltsAreDoubted) {
  const auto said = [&](const std::string& text) {
    return Calibrate({File("u.csv", text), "-o", directory_ / "u.toml", "--overwrite"}).out;
  };
  EXPECT_THAT(said("displacement_mm,voltage_v\n-3,-3000\n0,1\n3,3001\n"),
              HasSubstr("doubt: the input reaches 3001 V, more than an analog output gives: is the "
                        "column in mV? Name it voltage_mv"));
  EXPECT_THAT(said("displacement_mm,voltage_mv\n-3,-3\n0,0.001\n3,3.001\n"),
              HasSubstr("doubt: the input reaches 3.001 mV only"));
  EXPECT_THAT(said("displacement_mm,voltage_mv\n-3,-3000\n0,1\n3,3001\n"),
              Not(HasSubstr("the input reaches")));
}

TEST_F(Calibration, ATypingErrorIsNamedWithItsLine) {
  const std::string pairs =
      File("t.csv",
           "displacement_mm,voltage_v\n# up\n-4,-4.0041\n-2,-2.0012\n0,-0.0008\n1,10.0\n"
           "2,2.0009\n4,4.0031\n2,2.002\n0,0.0005\n-2,-2.0003\n-4,-4.0035\n");
  const auto outcome = Calibrate({pairs});
  EXPECT_THAT(
      outcome.out,
      ContainsRegex("doubt: line 6 of the table lies -8.99.* mm from the line of the others"));
  EXPECT_THAT(outcome.out, ContainsRegex("with it and 999\\.[0-9]+ um/V without it"));
  const auto refused = Calibrate({pairs, "-o", directory_ / "t.toml"});
  EXPECT_EQ(refused.status, 3);
  EXPECT_THAT(refused.err, HasSubstr("correct line 6 of the table, far from the others"));
}

TEST_F(Calibration, TablesOfSpreadsheetsAreRead) {
  const auto of = [&](const std::string& text) {
    const auto outcome = Calibrate({File("s.csv", text), "--json"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return json::parse(outcome.out).at("gain_m_per_v").get<double>();
  };
  const double gain = of("displacement_mm,voltage_v\n-4,-4.004\n0,0.001\n2.5,2.502\n4,4.003\n");
  EXPECT_EQ(of("displacement_mm;voltage_v\r\n-4;-4,004\r\n0;0,001\r\n2,5;2,502\r\n4;4,003\r\n"),
            gain);
  EXPECT_EQ(of("\xef\xbb\xbf"
               "displacement_mm\tvoltage_v\n-4\t-4.004\n0\t0.001\n2,5\t2.502\n"
               "4\t4.003\n"),
            gain);
}

// "1.234,5" is no number; "1.000" beside a comma may be a thousand
// as analyze reads them: by the unit
TEST_F(Calibration, ColumnsOfOtherLanguagesAreKnownByTheirUnits) {
  const std::string rows = "-1,0;-1,02\n0,0;0,01\n1,0;0,99\n2,0;2,01\n";
  std::string numbered;
  for (int i = 1; i <= 4; ++i)
    numbered += fmt::format("{};{};{:.2f}\n", i, i - 2, i - 2 + 0.01 * (i % 2));
  std::ranges::replace(numbered, '.', ',');
  const auto gain = [&](const std::string& text) {
    const auto outcome = Calibrate({File("p.csv", text), "--json"});
    EXPECT_EQ(outcome.status, 0) << text << outcome.err;
    return json::parse(outcome.out).at("gain_m_per_v").get<double>();
  };
  const double expected = gain("displacement_mm;voltage_v\n" + rows);
  for (const char* names : {"Weg (mm);Spannung (V)", "Abstand [mm];U / V",
                            "d\u00e9placement/mm;tension (V)", "x/mm;Ausgang in V"}) {
    EXPECT_EQ(gain(names + ("\n" + rows)), expected) << names;
  }
  EXPECT_REL(gain("Weg (\u00b5m);Spannung (mV)\n" + rows), expected, 1e-12, "factors of both");
  // commas within quotes are decimal ones, but where they may group thousands
  std::string quoted = "\"Weg (mm)\",\"Spannung (V)\"\n";
  for (const char* pair : {"-1,0;-1,02", "0,0;0,01", "1,0;0,99", "2,0;2,01"}) {
    const std::string both = pair;
    const std::size_t at = both.find(';');
    quoted += fmt::format("\"{}\",\"{}\"\n", both.substr(0, at), both.substr(at + 1));
  }
  EXPECT_EQ(gain(quoted), expected);
  EXPECT_EQ(Calibrate({File("g.csv", quoted + "\"3,000\",\"3,01\"\n")}).status, 3);
  EXPECT_REL(gain("Nr;Weg (mm);Spannung (V)\n" + numbered), 1e-3, 0.01, "rounded pairs");
  for (const auto& [text, what] :
       {std::pair("Weg (mm);Lage (mm);U (V)\n1;1;1\n2;2;2\n3;3;3\n", "has both"),
        {"displacement_mm;u (um);voltage_v\n1;1;1\n2;1;2\n3;1;3\n",
         "'u (um)', which is none of pairs"},
        {"Weg (mm);Druck (bar)\n1;1\n2;2\n3;3\n", "'Druck (bar)', which is none of pairs"},
        {"Weg (mm);Zeit (s)\n1;1\n2;2\n3;3\n", "'Zeit (s)', which is none of pairs"}}) {
    const auto refused = Calibrate({File("q.csv", text)});
    EXPECT_EQ(refused.status, 3) << text;
    EXPECT_THAT(refused.err, HasSubstr(what));
  }
}

TEST_F(Calibration, APointBesideDecimalCommasIsRefused) {
  const auto refused = [&](const std::string& rows, const std::string& said) {
    const auto outcome =
        Calibrate({File("t.csv", "displacement_um;voltage_v\n-500;-0,5\n0;0,001\n" + rows)});
    EXPECT_EQ(outcome.status, 3) << rows << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr(said)) << rows;
  };
  refused("1.000;1,002\n2.000;2,003\n",
          "t.csv:4: displacement_um '1.000' has a point beside decimal commas, which may "
          "separate thousands; write numbers without");
  refused("1.234,5;1,234\n2000;2,003\n", "'1.234,5' has a point beside decimal commas");
  refused("1000,5;1.002\n2000;2,003\n", "voltage_v '1.002' has a point beside decimal commas");
  // no thousands: a digit too many, or a leading 0
  EXPECT_EQ(Calibrate({File("t.csv",
                            "displacement_um;voltage_v\n-500.25;-0,5\n0.500;0,001\n"
                            "500.000;0,502\n")})
                .status,
            0);
}

TEST_F(Calibration, TwoTypingErrorsAreNamedWithTheirLines) {
  const std::string pairs = File("t.csv",
                                 "displacement_mm,voltage_v\n-4,-4.0041\n-2,-2.0012\n0,-0.0008\n"
                                 "1,10.0\n2,2.0009\n3,9.0\n4,4.0031\n");
  const auto outcome = Calibrate({pairs});
  EXPECT_THAT(outcome.out, ContainsRegex("doubt: line 5 of the table lies -8.99.* mm"));
  EXPECT_THAT(outcome.out, ContainsRegex("doubt: line 7 of the table lies -5.99.* mm"));
  EXPECT_THAT(outcome.out,
              ContainsRegex("with the 2 such points and 999\\.[0-9]+ um/V without them"));
  EXPECT_THAT(outcome.out, Not(HasSubstr("the points lie on a curve")));
  const auto refused = Calibrate({pairs, "-o", directory_ / "t.toml"});
  EXPECT_THAT(refused.err,
              HasSubstr("correct line 5 of the table, line 7 of the table, far from the others"));
}

TEST_F(Calibration, TheReportShowsTheResiduals) {
  const std::string page = directory_ / "c.html";
  ASSERT_EQ(Calibrate({Pairs("p.csv"), "--report", page}).status, 0);
  std::ifstream in(page);
  const std::string html((std::istreambuf_iterator<char>(in)), {});
  EXPECT_THAT(html, AllOf(HasSubstr("<svg"), HasSubstr("residuals of the calibration")));
}

TEST_F(Calibration, RefusesInOneLine) {
  const auto refused = [&](const std::string& text, const std::string& said) {
    const auto outcome = Calibrate({File("bad.csv", text)});
    EXPECT_EQ(outcome.status, 3) << text;
    EXPECT_THAT(outcome.err, HasSubstr(said));
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
  };
  refused("displacement_mm,voltage_v\n0,0\n1,1\n", "2 points");
  refused("displacement_mm,voltage_v\n0,1\n1,1\n2,1\n", "are the same");
  refused("displacement,voltage\n0,1\n1,1\n2,1\n", "is it displacement_m?");
  refused("displacement_mm,voltage_v,displacement_um\n0,0,0\n1,1,1\n2,2,2\n", "has both");
  refused("displacement_mm,voltage_v,voltage_v\n0,0,0\n1,1,1\n2,2,2\n", "two columns voltage_v");
  refused("time_s,displacement_mm\n0,0\n1,1\n2,2\n", "none of pairs");
  refused("displacement_mm\n0\n1\n2\n", "has no voltage with its unit");
  refused("displacement_mm,voltage_v\n0,0\n1,x\n2,2\n", "bad.csv:3: voltage_v 'x' is not a number");
  refused("displacement_mm,voltage_v,voltage_standard_uncertainty_mv\n0,0,1\n1,1,-1\n2,2,1\n",
          "standard uncertainty below 0");
  refused("displacement_mm,voltage_v,voltage_standard_uncertainty_mv\n0,0,1\n1,1,0\n2,2,1\n",
          "is stated to be exact");
  refused("displacement_mm,voltage_v\n0,1\n1,0\n2,1\n", "no straight line");
  const auto binary = Calibrate({std::string(HAPTOMETER_FIXTURES) + "/recorded_trial.bin"});
  EXPECT_EQ(binary.status, 3);
  EXPECT_THAT(binary.err, HasSubstr("is no table"));
  // a scatter that is no calibration
  const auto vague = Calibrate({File("v.csv", "displacement_mm,voltage_v\n0,0\n1,3\n2,1\n3,4\n"),
                                "-o", directory_ / "v.toml"});
  EXPECT_EQ(vague.status, 3);
  EXPECT_THAT(vague.err, ContainsRegex("uncertain by .* %: no calibration is written"));
}

TEST_F(Calibration, OptionsThatContradictAreRefused) {
  const std::string pairs = Pairs("p.csv");
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {},
           {pairs, "--reference", "x"},
           {pairs, pairs},
           {pairs, "--input", "pipe:x"},
           {"--reference", "x"},
           {"--reference", "x", "--input", "file"},
           {"--reference", "x", "--input", "pipe:y", "--voltage-uncertainty", "1mV"},
           {pairs, "--averaging", "4"},
           {pairs, "--averaging", "0"},
           {pairs, "--daq-range", "5V:5V"},
           {pairs, "--reference-uncertainty", "2"}}) {
    EXPECT_EQ(Calibrate(words).status, 2) << fmt::format("{}", words.size());
  }
}

}  // namespace
}  // namespace haptometer::tools
