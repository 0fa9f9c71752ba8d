#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/recorder/recorder.h"
#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "base/error.h"
#include "dsp/filter/butterworth.h"
#include "tools/acquire/recording.h"
#include "tools/document/document.h"
#include "trial/record.h"
#include "trial/trial_format.h"

namespace haptometer::tools {

/// What a trial recording of some seconds says of a sensor; what it cannot say is empty.
struct CheckFindings {
  acquire::RecordingSummary summary{};
  std::size_t measured = 0;  ///< rows with a measurement of the first displacement channel
  double duration_s = 0;
  double fresh_rate_hz = 0;         ///< new readings a second: without those handed out again
  std::optional<double> level_m{};  ///< mean
  std::optional<double> least_m{};
  std::optional<double> greatest_m{};
  double resolution_m = 0;          ///< one step; 0 where unknown
  std::size_t longest_hold = 0;     ///< most measurements in a row with one value
  double time_uncertainty_s = 0;    ///< of a reading; the largest of all stretches
  std::optional<double> noise_m{};  ///< RMS in the band without its strongest tone
  std::optional<double> tone_hz{};  ///< the strongest in the band, where one stands out
  std::optional<double> tone_rms_m{};
  std::string no_noise_because{};  ///< why noise_m is empty
};

/// Works them out. `record` has a displacement channel in metres. Cost: that of AnalyzeBand.
[[nodiscard]] CheckFindings FindingsOf(const trial::Record& record,
                                       const acquire::RecordingSummary& summary,
                                       const dsp::BandPass& band);

/// What came of one point of a check.
enum class Verdict : std::uint8_t {
  kOk,
  kFix,      ///< not ready: the remedy says what to do
  kUnknown,  ///< the sensor does not say; nothing speaks against it
};

/// "ok", "fix", "unknown".
[[nodiscard]] std::string_view Name(Verdict verdict);

/// One point of a check.
struct CheckItem {
  std::string name;  ///< "distance"
  Verdict verdict = Verdict::kUnknown;
  std::string finding;  ///< "30.12 mm from the head, linear from 25 to 35 mm"
  std::string remedy;   ///< kFix: the command, or what to do by hand; else ""
};

/// What readiness is asked for.
struct CheckQuestion {
  dsp::BandPass band;
  std::string command;  ///< how acquire was called, without --check: "acquire --port /dev/ttyUSB0"
  std::string command_of_other_band;     ///< the same without --band
  std::optional<double> smallest_rms_m;  ///< must be reported to 10 %; empty: whatever is possible
};

/// What averaging leaves of a tone.
struct ToneGain {
  double frequency_hz = 0;
  double gain = 1;
};

/// The sensor's own averaging at the band's corners and at 175 and 225 Hz (the resonances of the
/// actuators), as far as these lie within: |sin(pi f n T) / (n sin(pi f T))|. Empty where the
/// sensor does not say how it averages.
[[nodiscard]] std::vector<ToneGain> AveragingGains(const trial::Metadata& metadata,
                                                   const dsp::BandPass& band);

/// The smallest RMS that may be reported to `relative` (acquire/capability.h) from a
/// record as long as this one, with the noise of this one subtracted; nothing where the noise in
/// the band is not known. Noise below what rounding to steps makes, step / sqrt(12) over rate / 2,
/// counts as that.
[[nodiscard]] std::optional<double> SmallestRmsOf(const CheckFindings& findings,
                                                  const dsp::BandPass& band, double relative);

/// The whole list, always the same points in the same order: sensor, distance, hold, high-pass,
/// averaging, rate, noise, repeated, bad, clock, latency. Pure.
///
/// kFix where: no reading came, or the connection was lost; a value lies outside the head's linear
/// range (data sheet of the heads; others unknown); the amplifier holds; its high-pass or
/// difference filter is on; averaging takes more than 10 % at 175 or 225 Hz or 3 dB at a corner;
/// fewer than 2.56 new readings a period of the upper corner; the noise cannot be told, or is too
/// large for question.smallest_rms_m; over 10 % of the readings are repeated, or one value stood
/// for half of them; over 0.1 % are bad; a gap; a polled reading's time is uncertain by a tenth of
/// the upper corner's period; an adapter's latency timer is above 1 ms.
[[nodiscard]] std::vector<CheckItem> CheckList(const trial::TrialHeader& header,
                                               const CheckFindings& findings,
                                               const CheckQuestion& question);

/// Whether no point is kFix.
[[nodiscard]] bool IsReady(const std::vector<CheckItem>& items);

/// acquire --check: records `sensor` (started) for 10 s or the asked duration in memory and prints
/// the list of what is ok and what to fix, with remedies that build on the command
/// line. Returns the program's exit status: 0 ready, 3 not.
[[nodiscard]] Result<int> RunSensorCheck(const AcquireOptions& wanted, const dsp::BandPass& band,
                                         int argc, const char* const* argv, acquire::Sensor& sensor,
                                         Clock& clock);

/// The list with what it is made from.
[[nodiscard]] document::Document CheckDocument(const trial::TrialHeader& header,
                                               const CheckFindings& findings,
                                               const CheckQuestion& question,
                                               const std::vector<CheckItem>& items);

/// The mean of the first displacement channel over the second before the recording, in m; values
/// that are no measurements do not count. The counts of a recording are not touched by it.
///
/// `sensor` is started and has not begun; it is left where Sensor::Begin may be called again, with
/// nothing outstanding. Of a uniform source the second is its own (rate_hz rows, whenever they
/// come, waited for up to 3 s each), of others the clock's, and 3 s where measurements are missing.
/// Returns early when `stop` is set. `name` stands in errors (Cause::kCannotAnswer: no such
/// channel, no measurement came, the source ended or fell silent; Cause::kFailed: the connection
/// was lost, whether or not it would be waited for in a recording).
[[nodiscard]] Result<double> MeasureTare(acquire::Sensor& sensor, Clock& clock,
                                         const std::atomic<bool>& stop, const std::string& name);

}  // namespace haptometer::tools
