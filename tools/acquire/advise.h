#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquire/capability.h"
#include "acquire/findings.h"
#include "acquire/reading_noise.h"
#include "base/band.h"
#include "dsp/statistics/distributions.h"

namespace haptometer::tools {

/// What an accuracy is half of the interval of: 95 %, normal.
inline constexpr double kRouteCoverage = dsp::kNormalCritical;

/// What is to be measured, before anything is wired: the RMS of a drive in a band.
struct RouteQuestion {
  double lower_hz = kDefaultLowerHz;  ///< > 0
  double upper_hz = kDefaultUpperHz;  ///< > lower_hz
  double drive_hz = 225;              ///< within the band
  double rms_m = 10e-6;               ///< expected, > 0
  /// Half of the 95 % interval that `analyze` prints, as a part of the RMS; above 0, below 1.
  double accuracy = 0.01;
  /// Relative standard uncertainty of the sensor's gain, >= 0; empty: not counted.
  std::optional<double> calibration{};
  /// RMS of one reading's white noise, for sensors whose makers state none; >= 0.
  std::optional<double> noise_rms_m{};
  /// Of a DAQ behind an analog output, > 0; empty: the lowest one that folds nothing.
  std::optional<double> daq_rate_hz{};
};

/// What sets the length of a route's record, or keeps it from answering.
enum class RouteLimit : std::uint8_t {
  kWire,      ///< or the unit behind it: too few readings
  kSampling,  ///< of the amplifier or the DAQ: too few readings
  kNoise,
  kSteps,
  kAveraging,
  kAge,
  kCalibration,
  kFilterEnds,
  kShortestWindow,  ///< 40 periods of the lower corner are the least that is promised
};

/// A way from motion to a number.
struct Route {
  std::string name;
  /// Options of `acquire`, in their order: {"sensor", "keyence-il"}, {"baud", "38400"}.
  std::vector<std::pair<std::string, std::string>> settings;
  bool answers = false;
  acquire::Finding reason{};         ///< why, or why not
  std::optional<double> record_s{};  ///< needed, filter transients included; to 0.1 s, up
  /// Whether a record without drive, as long, is needed for `analyze --floor`: the drive and its
  /// harmonics cover the band, so that nothing beside them tells its noise.
  bool needs_floor = false;
  /// From motion to the reading, at least: middle of what is averaged and held, mean age, wire.
  double latency_s = 0;
  double gain = 1;  ///< of averaging and hold at the drive; `analyze` divides it out
  RouteLimit limited_by = RouteLimit::kNoise;
  /// Half interval of `analyze` at record_s.
  std::optional<double> predicted_relative_uncertainty{};
  /// Half interval that no length improves, `unseen` included.
  std::optional<double> floor{};
  double unseen = 0;  ///< relative error of the RMS from a polled reading's age: in no interval
  double rate_hz = 0;
  std::vector<acquire::FoldedImage> images{};  ///< of an analog output: in the band, 1 % or more
  std::optional<double> better_daq_rate_hz{};  ///< that folds none, where there are images
};

/// All routes that this program knows, each polled one in the averaging that needs the shortest
/// record: those that answer first, by the length of their records, then by latency.
///
/// The half interval h of a record whose filtered part lasts T:
///
///   (h / k)^2 = (a + T/Tn + 2 q) / (4 B T q^2) + sum of u_i^2,   k = 1.96,
///
/// with q = rms^2 / (S B), S = NoiseDensity() at the drive over the gain's square, B the band's
/// width, and the u_i of converter steps, filter's ends and calibration, which no length changes.
/// The drive's edges add abs(sin(4 pi f / f_lower)) / (4 pi f T) / sqrt(6), which decides the
/// shortest windows alone. `analyze` knows the noise from beside the drive: only what lies within 8
/// Hz of it and of its harmonics is not told from it, a = that share of B, and it is known as from
/// a record of Tn = 1.92 s / a (dsp/analysis/band_noise.h, BeyondNoise). T follows by
/// RecordLength() from h^2 = accuracy^2 - unseen^2; filter transients take 12 periods of the lower
/// corner more.
///
/// A polled value of age 0 to w reduces the RMS by 1 - sin(pi f w) / (pi f w). An analog output is
/// held for a sampling period: with n averages its gain is sin(pi f n T) / (pi f n T).
/// Errors: none; the question is as its members say. Cost: below 1 ms.
[[nodiscard]] std::vector<Route> AdviseRoutes(const RouteQuestion& question);

}  // namespace haptometer::tools
