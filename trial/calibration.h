#pragma once

#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/error.h"
#include "trial/findings.h"
#include "trial/record.h"
#include "trial/trial_format.h"

/// What the analog output of a sensor means, as sampled by a DAQ: volts or amperes to metres.
namespace haptometer::trial {

/// A sensor whose gain has a larger relative standard uncertainty is not calibrated.
inline constexpr double kLargestGainUncertainty = 0.2;

/// Numbers that are no measurements, in the unit in which the numbers come.
struct RawLimits {
  double rail_min = -std::numeric_limits<double>::infinity();   ///< at or below: kClipped
  double rail_max = std::numeric_limits<double>::infinity();    ///< at or above: kClipped
  double bad_below = -std::numeric_limits<double>::infinity();  ///< below: kInvalid
  double bad_above = std::numeric_limits<double>::infinity();   ///< above: kInvalid
};

/// What `number` is by its limits: kInvalid where it is not finite, else kClipped at a rail of the
/// converter, else kInvalid beyond what the sensor puts out when it measures, else kOk.
[[nodiscard]] SampleStatus StatusOf(const RawLimits& limits, double number);

/// One channel of a DAQ: value = input * scale + offset, input = count * input_per_count +
/// input_at_zero_count where counts come.
struct ChannelCalibration {
  std::string input_unit = "V";  ///< of what the DAQ measures: "V" or "A"
  double scale = 1;              ///< in the channel's unit per input unit; finite, not 0
  double offset = 0;             ///< in the channel's unit; finite
  /// Relative standard uncertainty of the slope, linearity included; nothing where it is not
  /// stated.
  std::optional<double> gain_uncertainty;
  std::optional<double> scale_uncertainty;   ///< standard uncertainty, of scale alone
  std::optional<double> offset_uncertainty;  ///< standard uncertainty, of offset
  double covariance = 0;                     ///< of scale and offset
  std::optional<int> degrees_of_freedom;     ///< of these; nothing: many
  std::optional<double> calibrated_min;      ///< the line was measured from here to here, in the
  std::optional<double> calibrated_max;      ///< input unit
  /// The numbers above and further ones of how the line was found, by key, as the file states them.
  std::map<std::string, double> stated;
  std::optional<double> input_per_count;  ///< > 0; needed for counts only
  double input_at_zero_count = 0;         ///< in the input unit
  RawLimits limits;                       ///< in the input unit
  std::optional<double> range_min;        ///< of the sensor, in the channel's unit
  std::optional<double> range_max;
};

/// How a sensor averages, where its user states it.
struct Averaging {
  std::optional<int> averages{};       ///< raw samples in a reading, 1 to 1e6
  std::optional<double> sampling_s{};  ///< their period; > 0, needed for more than one
};

/// Puts what is stated into `metadata`.
void StateAveraging(const Averaging& averaging, Metadata* metadata);

/// What a calibration file says (docs/reference/formats.md).
struct Calibration {
  std::string name;
  std::string date;
  std::string notes;
  Averaging averaging;                            ///< of the sensor
  std::map<std::string, std::string> provenance;  ///< how the file was made, by the user's own keys
  std::map<std::string, ChannelCalibration> channels;  ///< by channel name
};

/// Reads a calibration file for `channels`, of which name and role count: a table a channel.
///
/// Strict: an unknown key, or a table that is none of the channels, is an error.
/// Errors: the file's (base/input_file.h); Cause::kUsage for keys and values, a slope that is
/// missing or 0, limits in the wrong order, a file that calibrates none of the channels.
[[nodiscard]] Result<Calibration> ReadCalibrationFile(const std::string& path,
                                                      std::span<const ChannelFormat> channels);

/// The same from text; `where` stands for the file's path in errors.
[[nodiscard]] Result<Calibration> ReadCalibrationText(std::string_view text,
                                                      const std::string& where,
                                                      std::span<const ChannelFormat> channels);

/// Copies `calibration` into `channel`: scale, offset and range, for raw values of which one is
/// `input_per_raw` (> 0) input units and 0 is `input_at_zero_raw`. Returns the limits of the raw
/// values. A converter's highest count stands for one step less than its rail, so with
/// Encoding::kI32 the upper rail lies one count lower, and the resolution is one count.
[[nodiscard]] RawLimits Calibrate(const ChannelCalibration& calibration, double input_per_raw,
                                  double input_at_zero_raw, ChannelFormat* channel);

/// What of it is kept in a trial's metadata.fields: `calibration`, `calibration.date`, `.notes`, a
/// sentence a channel, `calibration.CHANNEL`, where it is stated
/// `calibration.CHANNEL.relative_standard_uncertainty`, all of ChannelCalibration::stated and the
/// calibrated range as `calibration.CHANNEL.calibrated_least` and `calibrated_most` in the
/// channel's unit, and `calibration.provenance.KEY`.
[[nodiscard]] std::map<std::string, std::string> CalibrationFields(const Calibration& calibration);

/// Values of a channel from `least` to `most`, in its unit.
struct ValueRange {
  double least = 0;
  double most = 0;
};

/// The range in which the line of `channel` was measured, as CalibrationFields kept it; nothing
/// where it is not stated.
[[nodiscard]] std::optional<ValueRange> CalibratedRangeOf(const Metadata& metadata,
                                                          const std::string& channel);

/// More volts than an analog output gives (+-10 V, and 5 %): then the numbers are in another unit.
inline constexpr double kMostOutputV = 10.5;

/// Turns the volts of a foreign table, `where`, into the displacement of the calibration file
/// `path`, table [displacement]: of the channel called "sensor", else of its only voltage where no
/// other channel lacks a unit. Rails and limits give statuses; the file's fields and averaging go
/// into the metadata, where the table does not state an averaging itself.
///
/// `findings` gets kCalibrationOf where there are several channels, and kInputTooLarge where input
/// or range exceeds kMostOutputV. Errors: the file's; Cause::kUsage: a displacement is there
/// already, no channel or several could be meant, an input or a channel of another unit than V;
/// Cause::kCannotAnswer: an input beyond kMostOutputV has no reading by the limits.
[[nodiscard]] Result<void> CalibrateRecord(const std::string& path, const std::string& where,
                                           Record* record, Findings* findings);

/// A relative standard uncertainty of a gain: "0.005" or "0.5%". Errors (Cause::kUsage), at
/// `where`: not a number, or not above 0 and at most 0.2.
[[nodiscard]] Result<double> ParseGainUncertainty(std::string_view text, std::string_view where);

/// The relative standard uncertainty of the gain of `channel` that CalibrationFields kept; nothing
/// where none was stated. Errors: as ParseGainUncertainty.
[[nodiscard]] Result<std::optional<double>> GainUncertaintyOf(const Metadata& metadata,
                                                              const std::string& channel);

}  // namespace haptometer::trial
