#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "acquire/capability.h"
#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/transport/port_list.h"
#include "base/band.h"
#include "base/text.h"
#include "dsp/analysis/band_analysis.h"
#include "tools/acquire/check.h"
#include "tools/document/findings_dsp.h"
#include "trial/import/table/table_cells.h"
#include "trial/sensor_head.h"

namespace haptometer::tools {
namespace {

// measured, least_m, greatest_m and longest_hold (largest run of equal values) of the measurements
void FindValues(const trial::Channel& channel, CheckFindings& findings) {
  std::size_t hold = 0;
  std::optional<double> last;
  for (std::size_t row = 0; row < channel.values.size(); ++row) {
    if (!trial::IsMeasurement(channel.statuses[row])) continue;
    const double value = channel.values[row];
    hold = last == value ? hold + 1 : 1;
    last = value;
    ++findings.measured;
    findings.longest_hold = std::max(findings.longest_hold, hold);
    findings.least_m = std::min(findings.least_m.value_or(value), value);
    findings.greatest_m = std::max(findings.greatest_m.value_or(value), value);
  }
}

using trial::SampleStatus;

constexpr double kMmPerM = 1e3;
constexpr double kUmPerM = 1e6;
// resonances of the actuators, Hz
constexpr std::array kResonances_hz = {175.0, 225.0};
// limits of CheckList(): gain of averaging, shares of repeated, bad and held readings
constexpr double kLeastToneGain = 0.9;
constexpr double kMostRepeated = 0.1;
constexpr double kMostBad = 1e-3;
constexpr double kMostHeld = 0.5;
constexpr std::size_t kLeastForHeld = 20;        // rows below which equal values mean nothing
constexpr double kTimeUncertaintyPeriods = 0.1;  // as AnalyzeBand has it
constexpr int kHighPassCode = 14;                // data 133 of an IL amplifier
constexpr int kDifferenceCode = 13;

CheckItem Ok(std::string finding) { return {{}, Verdict::kOk, std::move(finding), {}}; }
CheckItem Fix(std::string finding, std::string remedy) {
  return {{}, Verdict::kFix, std::move(finding), std::move(remedy)};
}
CheckItem Unknown(std::string finding) { return {{}, Verdict::kUnknown, std::move(finding), {}}; }

// what the points of the list are derived from
struct Context {
  const trial::TrialHeader& header;
  const CheckFindings& findings;
  const CheckQuestion& question;

  // the remedy's command: the user's own with one more option
  [[nodiscard]] std::string Again(std::string_view option) const {
    return fmt::format("{} {} --check", question.command, option);
  }
  // a whole number as the amplifier sends it: "14", "+00014"; empty where the field is absent
  [[nodiscard]] std::optional<int> Field(const std::string& key) const {
    const auto found = header.metadata.fields.find(key);
    if (found == header.metadata.fields.end()) return std::nullopt;
    std::string_view text = found->second;
    if (text.starts_with('+')) text.remove_prefix(1);
    return NumberFrom<int>(text);
  }
};

// a lost connection comes first: it needs a remedy even where readings exist
CheckItem CheckSensorAnswers(const Context& c) {
  const trial::Metadata& metadata = c.header.metadata;
  const std::string identity =
      fmt::format("{}{}{}, {}", metadata.sensor, metadata.head.empty() ? "" : " ", metadata.head,
                  metadata.source);
  if (c.findings.summary.connection_lost) {
    return Fix(fmt::format("the connection was lost after {} readings: {}",
                           c.findings.summary.readings, identity),
               "check power and cable, then " + c.question.command + " --check");
  }
  if (c.findings.summary.readings > 0) return Ok(identity);
  return Fix("no reading came from " + identity,
             "check power and cable, then " + c.question.command + " --check");
}

// the amplifier's value is 0 at the head's reference distance: linear from -half_m to half_m
CheckItem CheckDistance(const Context& c) {
  const CheckFindings& f = c.findings;
  if (!f.level_m) {
    return Fix("no reading was a measurement",
               "put the target within the head's range, and see that the laser is on");
  }
  const auto* head = acquire::dl_rs1a::FindHead(c.header.metadata.head);
  if (head == nullptr || head->linear_half_range_mm == 0) {
    return Unknown(
        fmt::format("value {:.4f} mm; the head's linear range is not known", *f.level_m * kMmPerM));
  }
  const double half_m = head->linear_half_range_mm / kMmPerM;
  std::string where = fmt::format(
      "value {:.3f} mm, {:.3f} to {:.3f} mm; linear within +-{:g} mm of "
      "{:g} mm",
      *f.level_m * kMmPerM, *f.least_m * kMmPerM, *f.greatest_m * kMmPerM,
      head->linear_half_range_mm, head->reference_mm);
  if (*f.least_m >= -half_m && *f.greatest_m <= half_m) return Ok(std::move(where));
  return Fix(std::move(where),
             fmt::format("move the head by {:.2f} mm, until the amplifier shows about 0",
                         std::abs(*f.level_m) * kMmPerM));
}

// a hold function other than `sample` (such as peak) does not return the present displacement
CheckItem CheckHold(const Context& c) {
  const std::string& hold = c.header.metadata.hold;
  if (hold.empty()) return Unknown("the sensor does not report it");
  if (hold == "sample") return Ok("sample: each reading is the displacement");
  return Fix(hold + ": readings are not the displacement now", c.Again("--set hold=sample"));
}

// data 133 holds filter and averaging as one code: 13 difference count, 14 high-pass
CheckItem CheckHighPass(const Context& c) {
  // no code: the sensor is no IL amplifier, or its settings could not be read
  const std::optional<int> code = c.Field("keyence_data_133");
  if (!code) return Unknown("the sensor does not report it");
  if (*code == kDifferenceCode) {
    return Fix("off, but the difference-count filter is on: small steps are suppressed",
               c.Again("--set averaging=1"));
  }
  if (*code != kHighPassCode) return Ok("off");
  return Fix("on: slow motion is removed", c.Again("--set high-pass=off"));
}

// gain |sin(pi f n T) / (n sin(pi f T))| at the corners (limit -3 dB) and at resonances (10 %)
CheckItem CheckAveraging(const Context& c) {
  const std::vector<ToneGain> gains = AveragingGains(c.header.metadata, c.question.band);
  if (gains.empty()) return Unknown("the sensor does not report it");
  const dsp::BandPass& band = c.question.band;
  std::string arrives;
  bool is_enough = true;
  for (const ToneGain& tone : gains) {
    arrives += fmt::format("{}{:.3f} of {:g} Hz", arrives.empty() ? "" : ", ", tone.gain,
                           tone.frequency_hz);
    // the band-pass itself has -3 dB at a corner, so averaging may have as much there
    const bool is_corner = tone.frequency_hz == band.lower_hz || tone.frequency_hz == band.upper_hz;
    if (tone.gain < (is_corner ? 1 / std::numbers::sqrt2 : kLeastToneGain)) is_enough = false;
  }
  const trial::Metadata& metadata = c.header.metadata;
  std::string finding = fmt::format(
      "{} {}: {}", *metadata.averages,
      metadata.sampling_s ? fmt::format("readings of {:g} ms", *metadata.sampling_s * kMmPerM)
                          : std::string("reading"),
      arrives);
  if (is_enough) return Ok(std::move(finding));
  // remedy: the largest number of averages, by halving, whose gain is at least 0.9 everywhere
  int averages = *metadata.averages;
  trial::Metadata fewer = metadata;
  const auto passes = [&] {
    fewer.averages = averages;
    return std::ranges::all_of(AveragingGains(fewer, band),
                               [](const ToneGain& tone) { return tone.gain >= kLeastToneGain; });
  };
  while (averages > 1 && !passes()) averages /= 2;
  return Fix(std::move(finding), c.Again(fmt::format("--set averaging={}", averages)));
}

// new readings per second f_s against the band: f_s / 2.56 is the highest observable frequency
CheckItem CheckRate(const Context& c) {
  const CheckFindings& f = c.findings;
  const double upper_hz = c.question.band.upper_hz;
  const double observable_hz = HighestObservableHz(f.fresh_rate_hz);
  std::string finding =
      fmt::format("{:.6g} new readings/s show up to {:.6g} Hz (rate / 2.56); {:g} Hz needs {:.6g}",
                  f.fresh_rate_hz, observable_hz, upper_hz, NeededRateHz(upper_hz));
  if (Observes(f.fresh_rate_hz, upper_hz)) return Ok(std::move(finding));
  std::string remedy =
      "record the analog output with a DAQ (acquire --sensor pipe), or a head that sends faster";
  // rounded down to whole Hz, so that the proposed band is observable
  const double less_hz = std::floor(observable_hz);
  if (less_hz > c.question.band.lower_hz) {
    remedy += fmt::format("; or ask for less: {} --band {:g}-{:.0f}Hz --check",
                          c.question.command_of_other_band, c.question.band.lower_hz, less_hz);
  }
  return Fix(std::move(finding), std::move(remedy));
}

// smallest RMS that may be reported to 10 % and 1 %, from this record's noise in the band
CheckItem CheckNoise(const Context& c) {
  const auto tenth = SmallestRmsOf(c.findings, c.question.band, 0.1);
  const auto hundredth = SmallestRmsOf(c.findings, c.question.band, 0.01);
  if (!tenth || !hundredth) {
    return Fix("not known in the band: " + c.findings.no_noise_because,
               "correct what is listed above, then " + c.question.command + " --check");
  }
  std::string finding = fmt::format(
      "{:.3g} um RMS in {:g}-{:g} Hz: an RMS from {:.3g} um on may be reported to 10 %, "
      "from {:.3g} um on to 1 %",
      *c.findings.noise_m * kUmPerM, c.question.band.lower_hz, c.question.band.upper_hz,
      *tenth * kUmPerM, *hundredth * kUmPerM);
  // a tone at rest is reported beside the noise that excludes it
  if (c.findings.tone_hz) {
    finding += fmt::format("; {:.3g} um RMS at {:.5g} Hz are present and not included",
                           *c.findings.tone_rms_m * kUmPerM, *c.findings.tone_hz);
  }
  // without --smallest-rms each noise is ok: the finding states what can be reported
  const auto wanted_m = c.question.smallest_rms_m;
  if (!wanted_m || *tenth <= *wanted_m) return Ok(std::move(finding));
  finding += fmt::format("; {:.3g} um are required", *wanted_m * kUmPerM);
  return Fix(std::move(finding),
             "use a white, diffuse target, keep head and target still, or take a better head: "
             "acquire --list-sensors");
}

// a held value (one value in over half of the readings) is checked before the share of repetitions
CheckItem CheckRepeated(const Context& c) {
  const CheckFindings& f = c.findings;
  const auto readings = static_cast<double>(f.summary.readings);
  // share of repeated readings; 1 in the divisor for a record without readings
  const double share = static_cast<double>(f.summary.repeated()) / std::max(readings, 1.0);
  std::string finding = fmt::format("{:.1f} % of the readings are repeated", share * 100);
  if (f.measured >= kLeastForHeld &&
      static_cast<double>(f.longest_hold) > kMostHeld * static_cast<double>(f.measured)) {
    return Fix(fmt::format("one value stood for {} of {} readings", f.longest_hold, f.measured),
               "touch the target: if the value stays, the amplifier holds it (timing input, alarm "
               "setting 'clamp', key HOLD)");
  }
  if (share <= kMostRepeated) return Ok(std::move(finding));
  return Fix(std::move(finding),
             "connect fewer amplifiers or switch calculation off, so that the unit refreshes "
             "faster; new readings alone count for the rate");
}

// what to do about readings of the most frequent bad status
std::string RemedyOfBad(SampleStatus status) {
  switch (status) {
    case SampleStatus::kOver:
    case SampleStatus::kUnder:
    case SampleStatus::kInvalid:
      return "put the target within the range, perpendicular, and shield it from light";
    case SampleStatus::kClipped:
      return "widen the DAQ's range";
    case SampleStatus::kDeviceError:
      return "read the amplifier's display, and switch it off and on";
    default:
      return "shorten or shield the cable, or set sensor and --baud to a lower speed";
  }
}

CheckItem CheckBad(const Context& c) {
  const acquire::RecordingSummary& s = c.findings.summary;
  const double share =
      static_cast<double>(s.bad()) / std::max(static_cast<double>(s.readings), 1.0);
  std::size_t worst = 0;
  std::uint64_t most = 0;
  // the most frequent status that is no measurement determines the remedy
  for (std::size_t status = 0; status < s.statuses.size(); ++status) {
    if (IsMeasurement(static_cast<SampleStatus>(status)) || s.statuses[status] <= most) continue;
    worst = status;
    most = s.statuses[status];
  }
  std::string finding = fmt::format("{} of {} readings", s.bad(), s.readings);
  if (most > 0) finding += fmt::format(", most of them {}", Name(static_cast<SampleStatus>(worst)));
  if (share <= kMostBad) return Ok(std::move(finding));
  return Fix(std::move(finding), RemedyOfBad(static_cast<SampleStatus>(worst)));
}

// the sampling times: gaps, then of polled sensors the standard uncertainty of a time
CheckItem CheckClock(const Context& c) {
  const CheckFindings& f = c.findings;
  std::string finding = fmt::format(
      "jitter {:.3g} ms, {} gaps, standard uncertainty of a reading's time {:.3g} ms",
      f.summary.interval_sd_s.value_or(0) * 1e3, f.summary.gaps, f.time_uncertainty_s * 1e3);
  if (f.summary.gaps > 0) {
    return Fix(std::move(finding),
               "use a port of the computer itself, without a hub, and a "
               "machine that has time");
  }
  // limit 0.1 / f_upper: a tenth of a period at the upper corner
  const double limit_s = kTimeUncertaintyPeriods / c.question.band.upper_hz;
  if (c.header.timing != trial::Timing::kPolled || f.time_uncertainty_s < limit_s) {
    return Ok(std::move(finding));
  }
  finding += fmt::format("; {:g} Hz needs {:.3g} ms", c.question.band.upper_hz, limit_s * 1e3);
  return Fix(std::move(finding),
             "use a sensor that samples on a clock of its own: a stream, or "
             "the analog output and a DAQ (acquire --sensor pipe)");
}

// a USB adapter may keep a short reply until its latency timer runs out (FTDI: 16 ms by default)
CheckItem CheckLatency(const Context& c) {
  constexpr double kFineMs = 1;
  const auto& fields = c.header.metadata.fields;
  const auto found = fields.find(std::string(acquire::kLatencyTimerField));
  const auto timer_s =
      found == fields.end() ? std::optional<double>() : trial::ReadNumber(found->second);
  if (!timer_s) return Ok("no adapter with a latency timer");
  const double timer_ms = *timer_s * 1e3;
  if (timer_ms <= kFineMs) return Ok(fmt::format("the adapter's timer is {:g} ms", timer_ms));
  return Fix(fmt::format("the adapter may keep a reply for {:g} ms", timer_ms),
             "echo 1 | sudo tee /sys/bus/usb-serial/devices/ttyUSB*/latency_timer");
}

}  // namespace

CheckFindings FindingsOf(const trial::Record& record, const acquire::RecordingSummary& summary,
                         const dsp::BandPass& band) {
  CheckFindings findings{.summary = summary};
  const auto number = trial::DisplacementChannel(record);
  HAPTOMETER_CHECK(number, "a record without displacement");
  const trial::Channel& channel = record.channels[*number];
  findings.resolution_m = channel.resolution;
  FindValues(channel, findings);
  // the worst segment's standard uncertainty of a time
  for (const trial::Stretch& stretch : record.stretches) {
    findings.time_uncertainty_s = std::max(findings.time_uncertainty_s, stretch.time_uncertainty_s);
  }
  // band RMS, tone and residual noise over the whole record
  dsp::BandQuestion question;
  question.band = band;
  question.choice = dsp::WindowChoice::kAll;  // at rest: no drive is looked for
  question.keep_filtered = false;
  const auto analysis = dsp::AnalyzeBand(record, question);
  if (!analysis) {
    // an analysis that ends with an error: the values found so far remain
    findings.no_noise_because = analysis.error().what;
    return findings;
  }
  findings.duration_s = analysis->record.duration_s;
  findings.fresh_rate_hz = analysis->record.fresh_rate_hz;
  findings.level_m = analysis->record.offset_m;
  // a refusal with its reason; numbers may be present all the same
  if (!analysis->answered) findings.no_noise_because = document::RefusalOf(analysis->findings);
  if (!analysis->numbers) return findings;
  // noise is the residual: band RMS without the strongest tone
  findings.noise_m = analysis->numbers->residual_rms_m;
  if (analysis->numbers->tone) {
    findings.tone_hz = analysis->numbers->tone->fit.frequency_hz;
    // RMS of a sine: amplitude / sqrt(2)
    findings.tone_rms_m = analysis->numbers->tone->fit.amplitude / std::numbers::sqrt2;
  }
  return findings;
}

std::string_view Name(Verdict verdict) {
  constexpr std::array<std::string_view, 3> kNames{"ok", "fix", "unknown"};
  return kNames.at(static_cast<std::size_t>(verdict));
}

std::vector<ToneGain> AveragingGains(const trial::Metadata& metadata, const dsp::BandPass& band) {
  const bool is_plain = metadata.averages == 1;  // a mean of one reading has gain 1 at any period
  if (!metadata.averages || (!metadata.sampling_s && !is_plain)) return {};
  std::vector<double> frequencies{band.lower_hz};
  for (const double tone_hz : kResonances_hz) {
    if (tone_hz > band.lower_hz && tone_hz < band.upper_hz) frequencies.push_back(tone_hz);
  }
  // in order of frequency: lower corner, resonances within the band, upper corner
  frequencies.push_back(band.upper_hz);
  std::vector<ToneGain> gains;
  for (const double frequency_hz : frequencies) {
    const double gain =
        is_plain ? 1 : trial::AveragingGain(frequency_hz, *metadata.sampling_s, *metadata.averages);
    gains.push_back({frequency_hz, gain});
  }
  return gains;
}

std::optional<double> SmallestRmsOf(const CheckFindings& findings, const dsp::BandPass& band,
                                    double relative) {
  if (!findings.noise_m || !(findings.duration_s > 0)) return std::nullopt;
  const double bandwidth_hz = band.upper_hz - band.lower_hz;
  // rounding noise q / sqrt(12) spread over f_s / 2, its part in the band B: q sqrt(B / (6 f_s))
  const double rounding_m =
      findings.resolution_m * std::sqrt(bandwidth_hz / (6 * findings.fresh_rate_hz));
  const double noise_m = std::max(*findings.noise_m, rounding_m);
  if (!(noise_m > 0)) return std::nullopt;
  return acquire::SmallestRms({.rms_m = noise_m,
                               .bandwidth_hz = bandwidth_hz,
                               .record_s = findings.duration_s,
                               .noise_record_s = findings.duration_s},
                              relative);
}

std::vector<CheckItem> CheckList(const trial::TrialHeader& header, const CheckFindings& findings,
                                 const CheckQuestion& question) {
  struct Point {
    std::string_view name;
    CheckItem (*check)(const Context&);
  };
  constexpr std::array kPoints = {Point{"sensor", CheckSensorAnswers},
                                  Point{"distance", CheckDistance},
                                  Point{"hold", CheckHold},
                                  Point{"high-pass", CheckHighPass},
                                  Point{"averaging", CheckAveraging},
                                  Point{"rate", CheckRate},
                                  Point{"noise", CheckNoise},
                                  Point{"repeated", CheckRepeated},
                                  Point{"bad", CheckBad},
                                  Point{"clock", CheckClock},
                                  Point{"latency", CheckLatency}};
  const Context context{header, findings, question};
  std::vector<CheckItem> items;
  for (const Point& point : kPoints) {
    items.push_back(point.check(context));
    items.back().name = point.name;
  }
  return items;
}

bool IsReady(const std::vector<CheckItem>& items) {
  return std::ranges::none_of(items,
                              [](const CheckItem& item) { return item.verdict == Verdict::kFix; });
}

}  // namespace haptometer::tools
