#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "dsp/spectrum/electrical.h"
#include "sim/scene/scene.h"
#include "tools/document/document.h"

namespace haptometer::dsp {
struct BandNumbers;
}

/// What trials say of the quantities that are compared with a scene.
namespace haptometer::tools {

/// What is compared, where both sides have it.
enum class Compared : std::uint8_t { kRms, kTone, kRise, kCurrent, kPower, kPhase };
inline constexpr std::size_t kComparedCount = 6;
/// One value a quantity, by Compared, SI.
template <typename T>
using OfCompared = std::array<std::optional<T>, kComparedCount>;

/// The key of a quantity; the RMS is that of the sensor's target.
[[nodiscard]] document::Key KeyOf(Compared quantity, sim::SensorTarget target);

/// The numbers of an analysis that answers; those without an uncertainty are compared with nothing.
[[nodiscard]] OfCompared<dsp::Estimate> NumbersOf(const dsp::BandNumbers& numbers);

/// Means over those repeats that have the quantity, with
///
///   u^2 = s^2 / n + mean of u_i^2,
///
/// s their standard deviation: calibration and other causes that are common to all do not average
/// out, and what is statistical in u_i counts twice, which is to the safe side.
[[nodiscard]] OfCompared<dsp::Estimate> MeanOf(std::span<const OfCompared<dsp::Estimate>> repeats);

/// Quantities of which the largest repeat is more than twice the smallest, by more than the
/// expanded uncertainty of their difference (k = 2). Their mean has u >= a third of itself from two
/// of them, so that it agrees with nearly everything: such trials are no repeats. Repeats scatter
/// beyond their own uncertainties, which are of noise alone, as a sensor is put in its place again;
/// that is no reason. A phase has no ratio.
[[nodiscard]] std::vector<Compared> ScatteredOf(std::span<const OfCompared<dsp::Estimate>> repeats);

/// What repeats of one measurement say.
struct MeasuredNumbers {
  OfCompared<dsp::Estimate> numbers{};
  std::vector<std::string> files{};             ///< of the trials
  std::vector<document::DataSource> sources{};  ///< of their data
  std::vector<std::string> doubts{};            ///< of their analyses, in words
  /// Subject, condition and the like of each recording; nothing of documents.
  std::vector<std::map<std::string, std::string>> labels{};
  std::vector<Compared> scattered{};  ///< as ScatteredOf() the repeats
  /// Narrowest band that the RMS are of.
  double lower_hz = 0, upper_hz = std::numeric_limits<double>::infinity();
  /// How numbers of another band are had.
  std::string_view other_band =
      "analyze the trial with another --band, and give what --json prints";
  bool is_calibrated = true;         ///< each u holds the laser's calibration
  bool has_electrical_gain = false;  ///< gain or skew of voltage and current is stated
};

/// Reads trials, which are analysed as `analyze` does without options, and documents of
/// `analyze --json`.
///
/// Errors: as trial::OpenRows and dsp::AnalyzeBand; Cause::kCannotAnswer for a trial whose analysis
/// is no answer, with its first reason, and for a document of another kind.
[[nodiscard]] Result<MeasuredNumbers> ReadMeasured(std::span<const std::string> paths);

/// Adds to each of `measured` that has the quantity, as root of the sum of squares, what
/// `--uncertainty` words state: "current_rms_a=1%" of the value, "phase_rad=0.01" in SI. Errors
/// (Cause::kUsage), naming --uncertainty: no '=', a key that is given twice or not compared, no
/// number above 0; Cause::kCannotAnswer for a quantity that none has.
[[nodiscard]] Result<void> AddUncertainties(const std::vector<std::string>& words,
                                            sim::SensorTarget target,
                                            std::span<MeasuredNumbers> measured);

}  // namespace haptometer::tools
