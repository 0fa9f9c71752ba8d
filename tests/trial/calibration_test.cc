// Volts of an analog output to metres: files, limits, and what is kept in a trial.
#include "trial/calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "tests/residual.h"
#include "tests/temporary_files.h"

namespace haptometer::trial {
namespace {

using ::testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

const std::array<ChannelFormat, 2> kChannels{
    {{.name = "displacement", .role = ChannelRole::kDisplacement},
     {.name = "voltage", .role = ChannelRole::kVoltage}}};

Calibration Read(std::string_view text) {
  auto calibration = ReadCalibrationText(text, "il030.toml", kChannels);
  EXPECT_TRUE(calibration) << calibration.error().Text();
  return calibration ? std::move(*calibration) : Calibration{};
}

std::string ErrorOf(std::string_view text) {
  const auto calibration = ReadCalibrationText(text, "il030.toml", kChannels);
  return calibration ? "no error" : calibration.error().Text();
}

TEST(CalibrationFile, TwoPointsAreALine) {
  const Calibration calibration = Read(
      "[displacement]\n"
      "first = { voltage_v = -5, displacement_m = '-5mm' }\n"
      "second = { voltage_v = '5V', displacement_m = 4e-3 }\n");
  const ChannelCalibration& channel = calibration.channels.at("displacement");
  // slope 9 mm / 10 V, and -5 mm at -5 V
  EXPECT_REL(channel.scale, 0.9e-3, 1e-15, "a difference and a quotient");
  EXPECT_REL(channel.offset, -0.5e-3, 1e-14, "a difference of like numbers");
  EXPECT_EQ(calibration.name, "il030.toml");
}

// docs/reference/formats.md: a scale of 1 may be omitted
TEST(CalibrationFile, WhatIsMeasuredInItsOwnUnitNeedsNoScale) {
  const Calibration calibration = Read("[voltage]\noffset_v = 0.5\n");
  EXPECT_EQ(calibration.channels.at("voltage").scale, 1);
  EXPECT_EQ(calibration.channels.at("voltage").offset, 0.5);
  EXPECT_EQ(Read("[voltage]\n").channels.at("voltage").offset, 0);
}

// where one uncertainty is not stated, there is no covariance
TEST(CalibrationFile, ACovarianceNeedsBothUncertainties) {
  const std::string line = "[displacement]\nscale_m_per_v = 0.001\n";
  const std::string covariance = "scale_offset_covariance_m2_per_v = 1e-30\n";
  for (const char* one :
       {"scale_standard_uncertainty_m_per_v = 1\n", "offset_standard_uncertainty_m = 1\n"}) {
    EXPECT_THAT(ErrorOf(line + one + covariance), HasSubstr("more than the product")) << one;
  }
}

// both numbers of a pair are volts, so the input has a key of its own
TEST(CalibrationFile, TwoPointsOfAVoltageAreALine) {
  const Calibration calibration = Read(
      "[voltage]\nfirst = { input_v = 1, voltage_v = 3 }\n"
      "second = { input_v = 2, voltage_v = 14 }\n");
  const ChannelCalibration& channel = calibration.channels.at("voltage");
  EXPECT_EQ(channel.scale, 11);
  EXPECT_EQ(channel.offset, -8);
  EXPECT_EQ(channel.input_unit, "V");
}

TEST(CalibrationFile, AnUncertaintyOfTheGainIsKept) {
  const Calibration calibration = Read(
      "[displacement]\nscale_m_per_v = 1e-3\nrelative_standard_uncertainty = 0.004\n"
      "[voltage]\nscale_v_per_v = 11\n");
  EXPECT_EQ(calibration.channels.at("displacement").gain_uncertainty, 0.004);
  Metadata metadata;
  metadata.fields = CalibrationFields(calibration);
  EXPECT_EQ(GainUncertaintyOf(metadata, "displacement").value(), 0.004);
  EXPECT_EQ(GainUncertaintyOf(metadata, "voltage").value(), std::nullopt);
  EXPECT_THAT(ErrorOf("[displacement]\nscale_m_per_v = 1e-3\nrelative_standard_uncertainty = 0\n"),
              HasSubstr("is not above 0 and at most 0.2"));
}

TEST(ParseGainUncertainty, IsAShareOrPercent) {
  EXPECT_EQ(ParseGainUncertainty("0.5%", "here").value(), 0.005);
  EXPECT_EQ(ParseGainUncertainty("0.005", "here").value(), 0.005);
  for (const char* text : {"", "%", "0", "-1%", "100%", "2", "nan", "0.5um"}) {
    EXPECT_FALSE(ParseGainUncertainty(text, "here")) << text;
  }
  EXPECT_EQ(ParseGainUncertainty("2um", "here").error().Text(),
            "here: '2um' has a unit, and is a share of the gain; write a share, as 0.5% or 0.005");
  EXPECT_EQ(ParseGainUncertainty("0,02%", "here").error().Text(),
            "here: '0,02' has a decimal comma; write a point: 0.02");
}

TEST(CalibrationFile, EveryKeyArrives) {
  const Calibration calibration = Read(
      "name = 'IL-030, rig 2'\ndate = '2026-02-11'\nnotes = 'gauge blocks'\n"
      "[displacement]\nscale_m_per_v = 1e-3\noffset_m = '0.1mm'\nbad_above_v = 5.25\n"
      "bad_below_v = -5.25\ndaq_min_v = -10\ndaq_max_v = 10\nv_per_count = 3.0517578125e-4\n"
      "v_at_zero_count = '2mV'\nrange_min_m = '-5mm'\nrange_max_m = '5mm'\n"
      "[voltage]\nscale_v_per_v = 11\n");
  EXPECT_EQ(calibration.name, "IL-030, rig 2");
  EXPECT_EQ(calibration.date, "2026-02-11");
  EXPECT_EQ(calibration.notes, "gauge blocks");
  const ChannelCalibration& channel = calibration.channels.at("displacement");
  EXPECT_EQ(channel.scale, 1e-3);
  EXPECT_REL(channel.offset, 1e-4, 3e-16, "one rounding of the unit's factor");
  EXPECT_EQ(channel.limits.bad_above, 5.25);
  EXPECT_EQ(channel.limits.bad_below, -5.25);
  EXPECT_EQ(channel.limits.rail_min, -10);
  EXPECT_EQ(channel.limits.rail_max, 10);
  EXPECT_EQ(channel.input_per_count, 3.0517578125e-4);
  EXPECT_EQ(channel.input_at_zero_count, 2e-3);
  EXPECT_EQ(*channel.range_max, 5e-3);
  // a divider of 11 before the converter; what is measured in its own unit has no offset here
  EXPECT_EQ(calibration.channels.at("voltage").scale, 11);
  EXPECT_EQ(calibration.channels.at("voltage").offset, 0);
}

TEST(CalibrationFile, CurrentLoopsHaveAnErrorLevelBelow) {
  // 4 to 20 mA over 10 mm; the amplifier puts out 3.00 mA for an error
  const Calibration calibration = Read(
      "[displacement]\ninput = 'current'\n"
      "first = { current_a = '4mA', displacement_m = '-5mm' }\n"
      "second = { current_a = '20mA', displacement_m = '5mm' }\nbad_below_a = '3.5mA'\n");
  const ChannelCalibration& channel = calibration.channels.at("displacement");
  EXPECT_EQ(channel.input_unit, "A");
  EXPECT_REL(channel.scale, 10e-3 / 16e-3, 1e-15, "differences of exact numbers");
  EXPECT_EQ(StatusOf(channel.limits, 3.00e-3), SampleStatus::kInvalid);
  EXPECT_EQ(StatusOf(channel.limits, 4.00e-3), SampleStatus::kOk);
}

TEST(CalibrationFile, AChannelOfCurrentIsInAmperes) {
  const std::array<ChannelFormat, 1> current{{{.name = "coil", .role = ChannelRole::kCurrent}}};
  const auto line = [&](const std::string& text) {
    const auto read = ReadCalibrationText("[coil]\n" + text, "f", current);
    EXPECT_TRUE(read) << text << ": " << (read ? "" : read.error().Text());
    return read ? read->channels.at("coil") : ChannelCalibration{};
  };
  const auto shunt = line("scale_a_per_v = 0.5\noffset_a = '250mA'\nrange_min_a = -3\n");
  EXPECT_EQ(shunt.scale, 0.5);
  EXPECT_EQ(shunt.offset, 0.25);
  EXPECT_EQ(shunt.input_unit, "V");
  EXPECT_EQ(shunt.range_min, -3);
  const std::string second = "second = { voltage_v = 3, current_a = 10 }\n";
  const auto points = line("first = { voltage_v = 1, current_a = 2 }\n" + second);
  EXPECT_EQ(points.scale, 4);
  EXPECT_EQ(points.offset, -2);
  // measured in its own unit: no scale is needed, and the input of a point has a key of its own
  EXPECT_EQ(line("input = 'current'\noffset_a = 0.5\n").scale, 1);
  const std::string ampere = "input = 'current'\nfirst = { input_a = 1, current_a = 2 }\n";
  EXPECT_EQ(line(ampere + "second = { input_a = 2, current_a = 5 }\n").scale, 3);
  EXPECT_FALSE(ReadCalibrationText("[coil]\n", "f", current)) << "amperes of volts need a scale";
}

TEST(CalibrationFile, ALineIsStatedOnceAndWhole) {
  const std::string first = "first = { voltage_v = 1, displacement_m = 2 }\n";
  const std::string second = "second = { voltage_v = 2, displacement_m = 5 }\n";
  const auto error = [](const std::string& keys) { return ErrorOf("[displacement]\n" + keys); };
  EXPECT_EQ(error(first + second), "no error");
  EXPECT_THAT(error("offset_m = 0\n" + first + second), HasSubstr("offset_m: is given twice"));
  EXPECT_THAT(error("scale_m_per_v = 1\n" + first + second),
              HasSubstr("scale_m_per_v: is given twice"));
  EXPECT_THAT(error(second), HasSubstr("first: is missing"));
  EXPECT_THAT(error(first), HasSubstr("second: is missing"));
  for (const char* same :
       {"{ voltage_v = 2, displacement_m = 2 }", "{ voltage_v = 1, displacement_m = 5 }",
        "{ voltage_v = 1, displacement_m = 2 }"}) {
    EXPECT_THAT(error(first + "second = " + same + "\n"), HasSubstr("second: does not differ"));
  }
}

// one end alone is no range
TEST(CalibrationFile, OneEndOfARangeIsKept) {
  const std::string line = "[displacement]\nscale_m_per_v = 2\n";
  for (const char* end : {"calibrated_min_v = 4\n", "calibrated_max_v = -4\n"}) {
    Metadata metadata;
    metadata.fields = CalibrationFields(Read(line + end));
    EXPECT_FALSE(CalibratedRangeOf(metadata, "displacement")) << end;
    EXPECT_FALSE(metadata.fields.contains("calibration.displacement.calibrated_least")) << end;
  }
  // the sensor's own, in metres, counts before what the limits give
  const std::string limits = line + "bad_below_v = -1\nbad_above_v = 3\noffset_m = 0.5\n";
  const auto range = [&](const std::string& ends) {
    ChannelFormat channel{.name = "displacement"};
    std::ignore = Calibrate(Read(limits + ends).channels.at("displacement"), 1, 0, &channel);
    return std::pair(channel.range_min, channel.range_max);
  };
  EXPECT_EQ(range("range_min_m = 9\n"), std::pair(9.0, 6.5));
  EXPECT_EQ(range("range_max_m = -9\n"), std::pair(-1.5, -9.0));
  EXPECT_EQ(range("range_min_m = -7\nrange_max_m = 8\n"), std::pair(-7.0, 8.0));
}

TEST(CalibrationFile, RefusesWhatCannotBeMeant) {
  EXPECT_THAT(ErrorOf("[displacement]\n"), HasSubstr("scale_m_per_v: is missing"));
  EXPECT_THAT(ErrorOf("[displacement]\nscale_m_per_v = 0\n"), HasSubstr("must not be 0"));
  EXPECT_THAT(ErrorOf("[displacement]\nscale_m_per_v = 1e-3\noffset_m = nan\n"),
              HasSubstr("offset_m"));
  EXPECT_THAT(ErrorOf("[displacement]\nscale_m_per_V = 1e-3\n"),
              HasSubstr("key scale_m_per_V is not known; did you mean scale_m_per_v?"));
  EXPECT_THAT(ErrorOf("[displacement]\nscale_m_per_v = 1\nbad_above_v = 1\nbad_below_v = 2\n"),
              HasSubstr("bad_below_v: is not below bad_above"));
  EXPECT_THAT(ErrorOf("[displacement]\nscale_m_per_v = 1\ndaq_max_v = 1\ndaq_min_v = 2\n"),
              HasSubstr("daq_min_v: is not below daq_max"));
  EXPECT_THAT(ErrorOf("[displacement]\nscale_m_per_v = 1\nv_per_count = -1\n"),
              HasSubstr("v_per_count: must be greater than 0"));
  EXPECT_THAT(ErrorOf("[displacment]\nscale_m_per_v = 1\n"),
              HasSubstr("key displacment is not known; did you mean displacement?"));
  EXPECT_THAT(ErrorOf("name = 'x'\n"), HasSubstr("calibrates none of the channels"));
  EXPECT_THAT(ErrorOf("moving_mass_kg = 1.4e-3\n"),
              HasSubstr("is an actuator, and no calibration"));
}

TEST(CalibrationFile, ATriggerHasNothingToBeCalibrated) {
  const std::array<ChannelFormat, 1> trigger{{{.name = "trigger", .role = ChannelRole::kTrigger}}};
  EXPECT_THAT(ReadCalibrationText("[trigger]\n", "f", trigger).error().Text(),
              HasSubstr("a channel of role trigger has no unit"));
  const std::array<ChannelFormat, 1> other{{{.name = "force", .role = ChannelRole::kOther}}};
  EXPECT_THAT(ReadCalibrationText("[force]\n", "f", other).error().Text(),
              HasSubstr("a channel of role other has no unit"));
}

TEST(CalibrationLimits, StatusesAtTheEdges) {
  const RawLimits limits{.rail_min = -10, .rail_max = 10, .bad_below = -5.25, .bad_above = 5.25};
  EXPECT_EQ(StatusOf(limits, 5.25), SampleStatus::kOk);
  EXPECT_EQ(StatusOf(limits, std::nextafter(5.25, 6)), SampleStatus::kInvalid);
  EXPECT_EQ(StatusOf(limits, 5.5), SampleStatus::kInvalid);  // the IL's error level
  EXPECT_EQ(StatusOf(limits, -5.26), SampleStatus::kInvalid);
  EXPECT_EQ(StatusOf(limits, 10), SampleStatus::kClipped);
  EXPECT_EQ(StatusOf(limits, -11), SampleStatus::kClipped);
  EXPECT_EQ(StatusOf(limits, std::nan("")), SampleStatus::kInvalid);
  EXPECT_EQ(StatusOf(limits, kInfinity), SampleStatus::kInvalid);
  EXPECT_EQ(StatusOf({}, 1e300), SampleStatus::kOk);
}

TEST(CalibrationLimits, CountsOfASixteenBitConverter) {
  const Calibration calibration = Read(
      "[displacement]\nscale_m_per_v = -1e-3\noffset_m = 1e-3\ndaq_min_v = -10\ndaq_max_v = 10\n"
      "v_per_count = 3.0517578125e-4\nbad_above_v = 5.25\n");
  ChannelFormat channel{.name = "displacement", .encoding = Encoding::kI32};
  const RawLimits limits =
      Calibrate(calibration.channels.at("displacement"), 3.0517578125e-4, 0, &channel);
  // 20 V / 2^16 a count: 16384 counts are 5 V, which is 1 mm - 5 mm
  EXPECT_REL(16384 * channel.scale + channel.offset, -4e-3, 1e-15, "two roundings");
  EXPECT_REL(channel.resolution, 20.0 / 65536 * 1e-3, 1e-15, "one product");
  EXPECT_EQ(StatusOf(limits, 32767), SampleStatus::kClipped);
  EXPECT_EQ(StatusOf(limits, -32768), SampleStatus::kClipped);
  EXPECT_EQ(StatusOf(limits, -32767), SampleStatus::kOk);
  EXPECT_EQ(StatusOf(limits, 18022), SampleStatus::kInvalid);  // 5.5 V
  EXPECT_EQ(StatusOf(limits, 17203), SampleStatus::kOk);       // 5.25 V = 17203.2 counts
  // a falling line turns the ends round: 5.25 V is -4.25 mm, -10 V is 11 mm
  EXPECT_REL(channel.range_min, -4.25e-3, 1e-15, "two roundings");
  EXPECT_REL(channel.range_max, 11e-3, 1e-15, "two roundings");
}

TEST(CalibrationLimits, MillivoltsAreVolts) {
  const Calibration calibration = Read("[displacement]\nscale_m_per_v = 2e-3\nbad_above_v = 5\n");
  ChannelFormat channel{.name = "displacement"};
  const RawLimits limits = Calibrate(calibration.channels.at("displacement"), 1e-3, 0, &channel);
  EXPECT_REL(channel.scale, 2e-6, 1e-15, "one product");
  EXPECT_EQ(StatusOf(limits, 4999), SampleStatus::kOk);
  EXPECT_EQ(StatusOf(limits, 5001), SampleStatus::kInvalid);
  EXPECT_EQ(channel.range_min, -kInfinity);
}

TEST(CalibrationFields, SayWhatWasUsed) {
  const auto fields = CalibrationFields(
      Read("name = 'rig 2'\ndate = '2026-02-11'\n[displacement]\nscale_m_per_v = 0.001\n"
           "bad_above_v = 5.25\ndaq_min_v = -10\ndaq_max_v = 10\n"));
  EXPECT_EQ(fields.at("calibration"), "rig 2");
  EXPECT_EQ(fields.at("calibration.date"), "2026-02-11");
  EXPECT_FALSE(fields.contains("calibration.notes"));
  const auto noted = CalibrationFields(Read("notes = 'gauge blocks'\n[voltage]\n"));
  EXPECT_EQ(noted.at("calibration.notes"), "gauge blocks");
  EXPECT_FALSE(noted.contains("calibration.date"));
  EXPECT_EQ(noted.at("calibration.voltage"), "voltage = 1 per V x input + 0");
  EXPECT_EQ(fields.at("calibration.displacement"),
            "displacement = 0.001 per V x input + 0; measures up to 5.25 V; DAQ -10 to 10 V");
}

TEST(CalibrationFields, HoldHowTheLineWasFound) {
  const Calibration calibration = Read(
      "averages = 16\nsampling_s = '1ms'\n[displacement]\nscale_m_per_v = 0.001\n"
      "scale_standard_uncertainty_m_per_v = 2e-6\noffset_standard_uncertainty_m = 3e-6\n"
      "scale_offset_covariance_m2_per_v = -4e-12\ndegrees_of_freedom = 5\nnonlinearity_m = 7e-6\n"
      "calibrated_min_v = -4\ncalibrated_max_v = 4\n[provenance]\nutc = '2026-03-01T12:00:00Z'\n");
  const ChannelCalibration& channel = calibration.channels.at("displacement");
  EXPECT_EQ(channel.scale_uncertainty, 2e-6);
  EXPECT_EQ(channel.offset_uncertainty, 3e-6);
  EXPECT_EQ(channel.covariance, -4e-12);
  EXPECT_EQ(channel.degrees_of_freedom, 5);
  EXPECT_EQ(channel.calibrated_max, 4);
  const auto fields = CalibrationFields(calibration);
  EXPECT_EQ(fields.at("calibration.displacement.scale_standard_uncertainty_m_per_v"), "2e-06");
  EXPECT_EQ(fields.at("calibration.displacement.nonlinearity_m"), "7e-06");
  EXPECT_EQ(fields.at("calibration.provenance.utc"), "2026-03-01T12:00:00Z");
  Metadata metadata;
  metadata.fields = fields;
  // 1 mm/V over +-4 V
  EXPECT_EQ(CalibratedRangeOf(metadata, "displacement")->least, -4e-3);
  EXPECT_EQ(CalibratedRangeOf(metadata, "displacement")->most, 4e-3);
  EXPECT_FALSE(CalibratedRangeOf(metadata, "voltage"));
  for (const char* end : {"least", "most"}) {
    Metadata edited = metadata;
    const std::string key = std::string("calibration.displacement.calibrated_") + end;
    edited.fields[key] = "none";
    EXPECT_FALSE(CalibratedRangeOf(edited, "displacement")) << end;
    edited.fields.erase(key);
    EXPECT_FALSE(CalibratedRangeOf(edited, "displacement")) << end;
  }
  StateAveraging(calibration.averaging, &metadata);
  EXPECT_EQ(metadata.averages, 16);
  EXPECT_EQ(metadata.sampling_s, 1e-3);
}

TEST(CalibrationFile, RefusesEvidenceThatCannotBe) {
  const std::string line = "[displacement]\nscale_m_per_v = 0.001\n";
  EXPECT_THAT(ErrorOf(line + "scale_standard_uncertainty_m_per_v = -1\n"), HasSubstr("is below 0"));
  EXPECT_THAT(ErrorOf(line + "scale_offset_covariance_m2_per_v = 1e-12\n"),
              HasSubstr("more than the product"));
  EXPECT_THAT(ErrorOf(line + "degrees_of_freedom = 0\n"), HasSubstr("is not 1 to 1e6"));
  EXPECT_THAT(ErrorOf(line + "calibrated_min_v = 4\ncalibrated_max_v = 4\n"),
              HasSubstr("is not below calibrated_max"));
  EXPECT_THAT(ErrorOf("averages = 4\n" + line), HasSubstr("sampling_s: is missing"));
  EXPECT_THAT(ErrorOf("averages = 0\n" + line), HasSubstr("is not 1 to 1e6"));
}

// each limit on both sides
TEST(CalibrationFile, EvidenceHasTheStatedLimits) {
  const std::string line = "[displacement]\nscale_m_per_v = 0.001\n";
  const std::string sizes =
      line + "scale_standard_uncertainty_m_per_v = 2e-6\noffset_standard_uncertainty_m = 3e-6\n";
  for (const std::string& text :
       {line + "degrees_of_freedom = 1\n", line + "degrees_of_freedom = 1e6\n",
        line + "relative_standard_uncertainty = 0.2\n",
        line + "relative_standard_uncertainty = 1e-9\n",
        sizes + "scale_offset_covariance_m2_per_v = 6e-12\n",
        sizes + "scale_offset_covariance_m2_per_v = -6e-12\n",
        line + "scale_standard_uncertainty_m_per_v = 0\n", line + "hysteresis_m = -1e-6\n",
        "averages = 1\n" + line, "averages = 1000000\nsampling_s = 1e-12\n" + line}) {
    EXPECT_EQ(ErrorOf(text), "no error") << text;
  }
  for (const std::string& text :
       {line + "degrees_of_freedom = 0.99\n", line + "degrees_of_freedom = 1.01e6\n",
        line + "relative_standard_uncertainty = 0.201\n",
        line + "relative_standard_uncertainty = -0.1\n",
        sizes + "scale_offset_covariance_m2_per_v = 6.01e-12\n",
        sizes + "scale_offset_covariance_m2_per_v = -6.01e-12\n", line + "nonlinearity_m = -1e-6\n",
        line + "offset_standard_uncertainty_m = -1e-6\n",
        "averages = 1000001\nsampling_s = 1e-3\n" + line, "averages = 2\n" + line,
        "sampling_s = 0\n" + line}) {
    EXPECT_NE(ErrorOf(text), "no error") << text;
  }
}

TEST(CalibrationFile, HasItsRangesInOrder) {
  const std::string line = "[displacement]\nscale_m_per_v = 0.001\n";
  for (const char* names : {"calibrated_min_v calibrated_max_v", "range_min_m range_max_m",
                            "bad_below_v bad_above_v", "daq_min_v daq_max_v"}) {
    const std::string both(names);
    const auto blank = both.find(' ');
    const auto with = [&](const char* low, const char* high) {
      return line + both.substr(0, blank) + " = " + low + "\n" + both.substr(blank + 1) + " = " +
             high + "\n";
    };
    EXPECT_EQ(ErrorOf(with("1", "1.01")), "no error") << names;
    EXPECT_THAT(ErrorOf(with("1", "1")), HasSubstr("is not below")) << names;
  }
}

TEST(ParseGainUncertainty, IsAtMostTwentyPercent) {
  for (const char* text : {"0.2", "20%", "1e-6"}) {
    EXPECT_TRUE(ParseGainUncertainty(text, "here")) << text;
  }
  for (const char* text : {"0.201", "20.1%"}) {
    EXPECT_FALSE(ParseGainUncertainty(text, "here")) << text;
  }
}

// counts of 1 mV of which 0 stands for 0.5 V: 10 V are 9500 counts, and the highest count is one
// step below
TEST(CalibrationLimits, CountsFromAnotherZero) {
  const Calibration calibration = Read(
      "[displacement]\nscale_m_per_v = 2e-3\noffset_m = 1e-3\ndaq_min_v = -10\ndaq_max_v = 10\n"
      "bad_below_v = -5\nbad_above_v = 5\n");
  const ChannelCalibration& line = calibration.channels.at("displacement");
  ChannelFormat counts{.name = "displacement", .encoding = Encoding::kI32};
  const RawLimits limits = Calibrate(line, 1e-3, 0.5, &counts);
  EXPECT_REL(counts.offset, 2e-3, 1e-15, "2 mm/V of 0.5 V, and 1 mm");
  EXPECT_REL(counts.scale, 2e-6, 1e-15, "one product");
  EXPECT_REL(limits.rail_max, 9499, 1e-15, "two roundings");
  EXPECT_REL(limits.rail_min, -10'500, 1e-15, "two roundings");
  EXPECT_REL(limits.bad_above, 4500, 1e-15, "two roundings");
  EXPECT_REL(limits.bad_below, -5500, 1e-15, "two roundings");
  EXPECT_REL(counts.range_max, 11e-3, 1e-15, "5 V");
  EXPECT_REL(counts.range_min, -9e-3, 1e-15, "-5 V");
  // numbers that are no counts reach the rail itself, and have the resolution that they had
  ChannelFormat volts{.name = "displacement", .resolution = 0.25};
  EXPECT_REL(Calibrate(line, 1e-3, 0.5, &volts).rail_max, 9500, 1e-15, "two roundings");
  EXPECT_EQ(volts.resolution, 0.25);
}

TEST(CalibrationFields, OfAFallingLineHaveTheRangeInItsOrder) {
  const auto fields = CalibrationFields(
      Read("[displacement]\nscale_m_per_v = -0.5\noffset_m = 0.25\nhysteresis_m = -0.125\n"
           "calibrated_min_v = -4\ncalibrated_max_v = 2\nbad_below_v = -5.25\n"));
  Metadata metadata;
  metadata.fields = fields;
  EXPECT_EQ(CalibratedRangeOf(metadata, "displacement")->least, -0.75);
  EXPECT_EQ(CalibratedRangeOf(metadata, "displacement")->most, 2.25);
  EXPECT_EQ(fields.at("calibration.displacement.hysteresis_m"), "-0.125");
  EXPECT_EQ(fields.at("calibration.displacement"),
            "displacement = -0.5 per V x input + 0.25; measures from -5.25 V");
  // what was edited to a range of no width is none
  metadata.fields["calibration.displacement.calibrated_least"] = "2.25";
  EXPECT_FALSE(CalibratedRangeOf(metadata, "displacement"));
}

// a table of volts becomes a displacement, with the statuses of the limits
class CalibratedRecord : public tests::TemporaryFiles {
 protected:
  static Record Volts(std::vector<std::string> names) {
    Record record;
    record.rows = 4;
    for (std::string& name : names) {
      record.channels.push_back({.name = std::move(name),
                                 .role = ChannelRole::kVoltage,
                                 .unit = "V",
                                 .values = {0, 2, 5.5, 10},
                                 .statuses = std::vector<SampleStatus>(4)});
    }
    return record;
  }
  Findings findings_;
  const std::string file_ =
      "averages = 1\n[displacement]\nscale_m_per_v = 0.001\noffset_m = 1e-4\n"
      "relative_standard_uncertainty = 0.002\nbad_above_v = 5.25\n"
      "daq_max_v = 10\n";
};

TEST_F(CalibratedRecord, ItsOnlyVoltageIsTheDisplacement) {
  Record record = Volts({"CH1"});
  const auto done = CalibrateRecord(File("c.toml", file_), "t.csv", &record, &findings_);
  ASSERT_TRUE(done) << done.error().Text();
  const Channel& channel = record.channels[0];
  EXPECT_EQ(channel.name, "displacement");
  EXPECT_EQ(channel.role, ChannelRole::kDisplacement);
  EXPECT_EQ(channel.unit, "m");
  EXPECT_REL(channel.range_max, 5.35e-3, 1e-15, "5.25 V");
  EXPECT_EQ(channel.range_min, -kInfinity);
  EXPECT_DOUBLE_EQ(channel.values[1], 2.1e-3);
  EXPECT_EQ(channel.statuses[2], SampleStatus::kInvalid);
  EXPECT_TRUE(std::isnan(channel.values[2]));
  EXPECT_EQ(channel.statuses[3], SampleStatus::kClipped);
  EXPECT_EQ(record.metadata.averages, 1);
  EXPECT_EQ(*GainUncertaintyOf(record.metadata, "displacement"), 0.002);
  EXPECT_TRUE(findings_.list().empty());
}

// the drive's voltage became the displacement where the sensor's column had no unit
TEST_F(CalibratedRecord, AVoltageBesideAChannelWithoutUnitIsNotTaken) {
  Record record = Volts({"laser", "voltage"});
  record.channels[0].role = ChannelRole::kOther;
  record.channels[0].unit = "";
  const std::string path = File("c.toml", file_);
  const auto done = CalibrateRecord(path, "t.csv", &record, &findings_);
  ASSERT_FALSE(done);
  EXPECT_THAT(done.error().Text(), HasSubstr("which voltage it is of: laser, voltage"));
  // a current is none, and which of several it is of is noted
  record.channels[0].role = ChannelRole::kCurrent;
  record.channels[0].unit = "A";
  ASSERT_TRUE(CalibrateRecord(path, "t.csv", &record, &findings_));
  EXPECT_EQ(record.channels[1].role, ChannelRole::kDisplacement);
  ASSERT_TRUE(findings_.Has(FindingKind::kCalibrationOf));
  EXPECT_EQ(std::get<std::string>(findings_.list()[0].numbers[0].value), "voltage");
}

TEST_F(CalibratedRecord, MillivoltsReadAsVoltsAreDoubted) {
  Record record = Volts({"CH1"});
  record.channels[0].values = {-3000, 0, 3000, 2000};
  ASSERT_TRUE(CalibrateRecord(File("c.toml", file_), "t.csv", &record, &findings_));
  ASSERT_TRUE(findings_.Has(FindingKind::kInputTooLarge));
  EXPECT_EQ(std::get<double>(findings_.list()[0].numbers[0].value), 3000);
}

// 10 V and 5 %
TEST_F(CalibratedRecord, InputsOrRangesAboveTenAndAHalfVoltsAreDoubted) {
  const std::string line = "[displacement]\nscale_m_per_v = 0.001\n";
  for (const double most_v : {10.5, 10.51}) {
    Record record = Volts({"CH1"});
    record.channels[0].values = {0, 1, -most_v, 2};
    Findings of_input;
    ASSERT_TRUE(CalibrateRecord(File("c.toml", line), "t.csv", &record, &of_input));
    EXPECT_EQ(of_input.Has(FindingKind::kInputTooLarge), most_v > 10.5) << most_v;
    for (const auto& [low, high] : {std::pair{-most_v, 1.0}, std::pair{-1.0, most_v}}) {
      const std::string range = line + "calibrated_min_v = " + std::to_string(low) +
                                "\ncalibrated_max_v = " + std::to_string(high) + "\n";
      Record other = Volts({"CH1"});
      Findings of_range;
      ASSERT_TRUE(CalibrateRecord(File("r.toml", range), "t.csv", &other, &of_range));
      EXPECT_EQ(of_range.Has(FindingKind::kInputTooLarge), most_v > 10.5) << low << " " << high;
    }
  }
}

TEST_F(CalibratedRecord, WithoutAnyReadingItIsRefusedOnlyAboveTenAndAHalfVolts) {
  const std::string path = File("c.toml", file_);
  for (const double volts : {10.5, 10.51}) {
    Record record = Volts({"CH1"});
    record.channels[0].values = {volts, volts, volts, volts};
    const auto done = CalibrateRecord(path, "t.csv", &record, &findings_);
    EXPECT_EQ(done.has_value(), volts == 10.5);
    if (done) continue;
    EXPECT_EQ(done.error().cause, Cause::kCannotAnswer);
    EXPECT_THAT(done.error().what, HasSubstr("reaches 10.51 V"));
  }
}

TEST_F(CalibratedRecord, ItsResolutionIsThatOfTheVoltsTimesTheScale) {
  Record record = Volts({"CH1"});
  record.channels[0].resolution = 0.5;
  const std::string path = File("c.toml", "[displacement]\nscale_m_per_v = -0.25\n");
  ASSERT_TRUE(CalibrateRecord(path, "t.csv", &record, &findings_));
  EXPECT_EQ(record.channels[0].resolution, 0.125);
}

TEST_F(CalibratedRecord, PairsInMillivoltsReadAsVoltsAreDoubted) {
  Record record = Volts({"CH1"});
  const std::string file = file_ + "calibrated_min_v = -4003\ncalibrated_max_v = 4003\n";
  ASSERT_TRUE(CalibrateRecord(File("c.toml", file), "t.csv", &record, &findings_));
  ASSERT_TRUE(findings_.Has(FindingKind::kInputTooLarge));
  EXPECT_EQ(std::get<double>(findings_.list()[0].numbers[0].value), 4003);
}

// what is no measurement stays what it is, and counts for nothing
TEST_F(CalibratedRecord, ABadValueKeepsItsStatus) {
  Record record = Volts({"CH1"});
  Channel& channel = record.channels[0];
  channel.values = {std::nan(""), 20, kInfinity, 2};
  channel.statuses[1] = SampleStatus::kLate;
  channel.statuses[3] = SampleStatus::kRepeated;
  const std::string path = File("c.toml", "[displacement]\nscale_m_per_v = 0.5\n");
  ASSERT_TRUE(CalibrateRecord(path, "t.csv", &record, &findings_));
  EXPECT_EQ(channel.statuses, (std::vector{SampleStatus::kInvalid, SampleStatus::kLate,
                                           SampleStatus::kInvalid, SampleStatus::kRepeated}));
  EXPECT_TRUE(std::isnan(channel.values[0]) && std::isnan(channel.values[2]));
  EXPECT_EQ(channel.values[3], 1);
  EXPECT_TRUE(findings_.list().empty()) << "neither 20 V nor infinity is an input";
}

// what a table states of the averaging counts before the calibration's
TEST_F(CalibratedRecord, KeepsTheAveragingThatTheTableStates) {
  const std::string path =
      File("c.toml", "averages = 16\nsampling_s = 2\n[displacement]\nscale_m_per_v = 0.001\n");
  const auto kept = [&](std::optional<int> averages, std::optional<double> sampling_s) {
    Record record = Volts({"CH1"});
    record.metadata.averages = averages;
    record.metadata.sampling_s = sampling_s;
    EXPECT_TRUE(CalibrateRecord(path, "t.csv", &record, &findings_));
    return std::pair(record.metadata.averages, record.metadata.sampling_s);
  };
  EXPECT_EQ(kept(4, {}), std::pair(std::optional(4), std::optional<double>()));
  EXPECT_EQ(kept({}, 0.5), std::pair(std::optional<int>(), std::optional(0.5)));
  EXPECT_EQ(kept({}, {}), std::pair(std::optional(16), std::optional(2.0)));
}

TEST_F(CalibratedRecord, AnotherUnitThanVoltsIsRefused) {
  const std::string path = File("a.toml", "[displacement]\ninput = 'current'\nscale_m_per_a = 1\n");
  Record record = Volts({"sensor"});
  EXPECT_EQ(CalibrateRecord(path, "t.csv", &record, &findings_).error().Text(),
            path + ": is of a current; give one of volts");
  record.channels[0].unit = "A";
  EXPECT_THAT(CalibrateRecord(File("c.toml", file_), "t.csv", &record, &findings_).error().Text(),
              HasSubstr("t.csv has its sensor in A"));
  // none is stated
  record.channels[0].unit = "";
  record.channels[0].role = ChannelRole::kOther;
  EXPECT_TRUE(CalibrateRecord(File("c.toml", file_), "t.csv", &record, &findings_));
}

TEST_F(CalibratedRecord, SensorNamesItAmongSeveral) {
  const std::string path = File("c.toml", file_);
  Record record = Volts({"CH1", "sensor"});
  ASSERT_TRUE(CalibrateRecord(path, "t.csv", &record, &findings_));
  EXPECT_EQ(record.channels[1].role, ChannelRole::kDisplacement);
  EXPECT_EQ(record.channels[0].role, ChannelRole::kVoltage);
  // one is there now: a second is not made of it
  EXPECT_THAT(CalibrateRecord(path, "t.csv", &record, &findings_).error().Text(),
              HasSubstr("has a displacement already"));
  Record several = Volts({"CH1", "CH2"});
  EXPECT_THAT(CalibrateRecord(path, "t.csv", &several, &findings_).error().Text(),
              HasSubstr("does not state which voltage it is of: "));
  Record none = Volts({});
  EXPECT_THAT(CalibrateRecord(path, "t.csv", &none, &findings_).error().Text(),
              HasSubstr("has no voltage"));
}

}  // namespace
}  // namespace haptometer::trial
