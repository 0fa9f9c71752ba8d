#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "fit/calibration/calibration_fit.h"
#include "tools/calibrate/reference_points.h"
#include "tools/document/document.h"
#include "trial/calibration.h"

namespace haptometer::tools {

/// Points of a calibration as they were given or measured.
struct CalibrationPoints {
  std::vector<fit::LinePoint> points;  ///< x: input in V, y: displacement in m
  std::vector<std::size_t> lines{};    ///< of each in its table; empty without one
  fit::Scatter scatter = fit::Scatter::kFromResiduals;
  std::vector<std::size_t> error_level{};  ///< lines excluded: the output stood at +5.5 V, off
                                           ///< the line of the others
  std::vector<std::size_t> at_rail{};      ///< lines excluded: the DAQ's range ended there
  // of an amplifier that is its own reference
  std::vector<fit::LinePoint> analog{};      ///< x: input in V, y: what the amplifier puts out
  std::optional<ReferencePoints> windows{};  ///< how they were collected
  std::size_t wanted = 0;                    ///< points asked for
  trial::Metadata reference{};               ///< of the amplifier
};

/// Reads the table of docs/reference/calibrate.md. `input_uncertainty_v`,
/// `displacement_uncertainty_m`: of rows that do not state theirs. Errors (Cause::kCannotAnswer):
/// no such table, a column twice or without a unit, an uncertainty below 0; Cause::kUsage: one
/// stated by option and column.
[[nodiscard]] Result<CalibrationPoints> ReadPairs(const std::string& path,
                                                  std::optional<double> input_uncertainty_v,
                                                  std::optional<double> displacement_uncertainty_m,
                                                  const trial::RawLimits& rails);

/// The points of CollectPoints, of which each quantity has one noise: that of its means, pooled.
/// `reference`: of the amplifier. Errors (Cause::kCannotAnswer): fewer than 3, with the reason.
[[nodiscard]] Result<CalibrationPoints> PointsOf(ReferencePoints found,
                                                 const trial::Metadata& reference,
                                                 std::size_t wanted);

/// Whether today's line agrees with that of a file.
struct CalibrationCheck {
  std::string file;
  trial::ChannelCalibration stated;
  std::optional<double> gain_error{};  ///< E_n of the gain (fit::NormalizedError)
  /// Today's line less the file's in the middle of today's points, in m, and its E_n; nothing where
  /// the file states no uncertainty of its offset.
  double shift_m = 0;
  std::optional<double> shift_error{};

  /// Whether |E_n| of the gain is 1 at most; nothing where it is not determined.
  [[nodiscard]] std::optional<bool> Agrees() const {
    return gain_error ? std::optional(std::abs(*gain_error) <= 1) : std::nullopt;
  }
};

/// What calibrate answers.
struct CalibrationAnswer {
  CalibrationPoints measured;
  fit::CalibrationFit fit;                 ///< metres over volts
  std::optional<fit::CalibrationFit> daq;  ///< volts of the amplifier over those of the DAQ
  double scale_uncertainty = 0;            ///< relative, of the reference: common to all points
  trial::RawLimits limits;
  trial::Averaging averaging;
  std::optional<CalibrationCheck> check;

  /// Relative standard uncertainty of the gain, all causes.
  [[nodiscard]] double RelativeUncertainty() const;
  /// The input above which the file says that there is no reading: 5.25 V, where no point lies
  /// above, as the error level of a +-5 V output is 5.5 V; else nothing.
  [[nodiscard]] std::optional<double> BadAboveV() const;
  /// "line 7 of the table", or "point 3" where there is none.
  [[nodiscard]] std::string NameOf(std::size_t point) const;
};

/// Fits the points. Errors: as fit::FitCalibration.
[[nodiscard]] Result<CalibrationAnswer> AnswerOf(CalibrationPoints points);

/// Compares the answer with the table [displacement] of a calibration file. Errors: the file's;
/// Cause::kCannotAnswer where it states no uncertainty.
[[nodiscard]] Result<CalibrationCheck> CheckAgainst(const std::string& path,
                                                    const CalibrationAnswer& answer);

/// The calibration file of the answer (docs/reference/formats.md), made as `provenance` says.
[[nodiscard]] std::string CalibrationText(const CalibrationAnswer& answer,
                                          const document::Provenance& provenance);

/// The answer in text, JSON and HTML; `path`: of the points, or the port.
[[nodiscard]] document::Document CalibrationDocument(const CalibrationAnswer& answer,
                                                     const std::string& path);

}  // namespace haptometer::tools
