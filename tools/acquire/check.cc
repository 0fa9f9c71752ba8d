#include "tools/acquire/check.h"

#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <string_view>
#include <utility>

#include "base/band.h"
#include "dsp/analysis/band_analysis.h"
#include "tools/acquire/recording.h"
#include "tools/acquire/recording_document.h"
#include "tools/cli/terminal.h"
#include "tools/document/keys.h"
#include "trial/byte_io.h"
#include "trial/trial_reader.h"
#include "trial/trial_writer.h"

namespace haptometer::tools {
namespace {

// duration of a check without --duration
constexpr MonotonicNs kDefaultDurationNs = 10 * kNsPerS;

// the command line without the options of this check, for the remedies that build on it: with or
// without its band
std::string CommandOf(const std::vector<std::string>& words, bool has_band) {
  std::vector<std::string> kept;
  for (std::size_t word = 0; word < words.size(); ++word) {
    const std::string_view name = std::string_view(words[word]).substr(0, words[word].find('='));
    if (name == "--check" || name == "--json" || name == "--all") continue;
    // options with a value: --band=X is one word, --band X two
    if ((name == "--band" && !has_band) || name == "--report") {
      if (name.size() < words[word].size()) continue;
      ++word;  // and its value
      continue;
    }
    kept.push_back(words[word]);
  }
  return cli::CommandLine(kept);
}

// the bytes of a trial in memory, in place of a file
class StringSink final : public trial::ByteSink {
 public:
  explicit StringSink(std::string& bytes) : bytes_(bytes) {}
  [[nodiscard]] Result<std::size_t> WriteSome(std::span<const std::byte> bytes) override {
    bytes_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return bytes.size();
  }
  [[nodiscard]] Result<void> Sync() override { return {}; }

 private:
  std::string& bytes_;
};

// a recording that was never on a disk
struct MemoryTrial {
  acquire::RecordingSummary summary;
  trial::Record record;
};

// runs `sensor` (started) into a trial in memory; some 20 bytes a reading, twice
Result<MemoryTrial> RecordInMemory(acquire::Sensor& sensor, Clock& clock,
                                   const std::atomic<bool>& stop,
                                   const acquire::RecordingLimits& limits) {
  std::string bytes;
  HAPTOMETER_LET(auto writer, trial::TrialWriter::CreateIn(std::make_unique<StringSink>(bytes),
                                                           "memory", sensor.header(), {}, clock));
  acquire::SingleTrial sink(writer);
  HAPTOMETER_LET(const auto summary, acquire::Record(sensor, sink, clock, stop, limits));
  // read back as a file would be, so that times are fitted in the same way
  HAPTOMETER_LET(auto recording,
                 trial::ReadRecordFrom(trial::MakeMemorySource(std::move(bytes)), "memory"));
  return MemoryTrial{summary, std::move(recording.record)};
}

using document::Section;

constexpr std::string_view MarkOf(Verdict verdict) {
  if (verdict == Verdict::kFix) return "FIX";
  return verdict == Verdict::kOk ? "ok" : "?";
}

// a line for the finding, behind mark and point, and below it one for the remedy
Section ItemSection(const CheckItem& item) {
  Section section;
  section.Add(document::kName, item.name);
  section.Add(document::kVerdict, Name(item.verdict));
  section.Add({"finding"}, item.finding).label =
      fmt::format("{:<4} {}", MarkOf(item.verdict), item.name);
  section.Add({"remedy", "            ->"}, document::TextOrNotKnown(item.remedy));
  return section;
}

Section GainsSection(const std::vector<ToneGain>& gains) {
  Section list{.name = "averaging_gains",
               .heading = "gain of the sensor's averaging",
               .shape = Section::Shape::kTable,
               .detail = document::Detail::kAll,
               .is_known = !gains.empty()};
  for (const ToneGain& tone : gains) {
    Section& row = list.sections.emplace_back();
    row.Add(document::kFrequency, tone.frequency_hz);
    row.Add(document::kGain, tone.gain).resolution = 1e-4;
  }
  return list;
}

// what the list is made from
Section NumbersSection(const CheckFindings& findings, const dsp::BandPass& band) {
  const acquire::RecordingSummary& summary = findings.summary;
  Section section{.heading = "numbers", .detail = document::Detail::kAll};
  section.Add(document::kReadings, summary.readings);
  section.Add(kBadKey, summary.bad());
  section.Add(kRepeatedKey, summary.repeated());
  section.Add(document::kGaps, summary.gaps);
  section.Add(document::kDuration, findings.duration_s);
  section.Add(document::kNewReadings, findings.fresh_rate_hz);
  // f_s / 2.56 from new readings only: repeated ones hold no information
  section.Add(document::kObservableUpper, HighestObservableHz(findings.fresh_rate_hz));
  section.Add(kJitterKey, summary.interval_sd_s);
  section.Add(document::kTimeUncertainty, findings.time_uncertainty_s);
  // lengths are rounded to a tenth of the sensor's step
  const auto add_length = [&](const document::Key& key, std::optional<double> length_m) {
    section.Add(key, length_m).resolution = findings.resolution_m / 10;
  };
  add_length({"level_m", "mean", document::kMetre}, findings.level_m);
  add_length({"least_m", "least", document::kMetre}, findings.least_m);
  add_length({"greatest_m", "greatest", document::kMetre}, findings.greatest_m);
  add_length({document::kNoiseRms.name, "noise in the band (RMS)", document::kMetre},
             findings.noise_m);
  // smallest RMS that may be reported to 10 % and to 1 %
  add_length(document::kSmallestRms10, SmallestRmsOf(findings, band, 0.1));
  add_length(document::kSmallestRms1, SmallestRmsOf(findings, band, 0.01));
  section.Add({document::kToneFrequency.name, "strongest tone", document::kHertz},
              findings.tone_hz);
  add_length({"tone_rms_m", "its RMS", document::kMetre}, findings.tone_rms_m);
  return section;
}

using acquire::Outcome;

// duration of the mean, s
constexpr double kTareS = 1;
// longest wait: for the next row of a uniform source, for the whole mean of others
constexpr MonotonicNs kPatienceNs = 3 * kNsPerS;

// running mean of the measurements, and whether it covers the second before the recording
class TareMean {
 public:
  TareMean(const trial::TrialHeader& header, std::size_t channel, MonotonicNs begin_ns)
      : header_(header),
        channel_(channel),
        begin_ns_(begin_ns),
        patient_until_ns_(Later(begin_ns)) {}

  void Add(const acquire::Reading& reading, MonotonicNs now_ns) {
    const trial::Sample& sample = reading.samples[channel_];
    const bool is_measurement = IsMeasurement(sample.status);
    if (is_measurement) {
      ++count_;
      const double value = ValueOf(header_.channels[channel_], sample);
      // running mean m_n = m_(n-1) + (x_n - m_(n-1)) / n
      mean_ += (value - mean_) / static_cast<double>(count_);
    }
    if (is_uniform()) {
      // uniform source: rows may come in bursts, so their number measures the second, not the clock
      is_over_ = static_cast<double>(reading.index + 1) >= kTareS * header_.rate_hz;
      patient_until_ns_ = Later(now_ns);
    } else {
      // polled: ends behind a measurement, when no request is outstanding that Begin() could mix up
      is_over_ = is_measurement && now_ns - begin_ns_ >= NsFromSeconds(kTareS);
    }
  }

  [[nodiscard]] bool is_over() const { return is_over_; }
  [[nodiscard]] bool IsPatient(MonotonicNs now_ns) const { return now_ns < patient_until_ns_; }

  [[nodiscard]] Result<double> Mean(const std::string& name) const {
    // less than a second of rows is no second before the recording
    if (is_uniform() && !is_over_) {
      return CannotAnswer(name,
                          "sent less than a second of readings and then stopped during --tare",
                          "check that the source continues, or leave --tare out");
    }
    if (count_ > 0) return mean_;
    return CannotAnswer(name, "gave no measurement to tare by",
                        "check that the laser is on and meets its target within the range");
  }

 private:
  [[nodiscard]] bool is_uniform() const { return header_.timing == trial::Timing::kUniform; }
  static MonotonicNs Later(MonotonicNs now_ns) { return now_ns + kPatienceNs; }

  const trial::TrialHeader& header_;
  std::size_t channel_;
  MonotonicNs begin_ns_;
  MonotonicNs patient_until_ns_;
  std::size_t count_ = 0;
  double mean_ = 0;
  bool is_over_ = false;
};

}  // namespace

Result<int> RunSensorCheck(const AcquireOptions& wanted, const dsp::BandPass& band, int argc,
                           const char* const* argv, acquire::Sensor& sensor, Clock& clock) {
  // the check is of displacement in metres: volts without calibration have none
  if (!trial::DisplacementChannel(sensor.header())) {
    return CannotAnswer(PortName(wanted.sensor), "has no displacement channel in metres to check",
                        "give the calibration of its voltage");
  }
  acquire::RecordingLimits limits;
  limits.duration_ns = wanted.recording.duration_s ? NsFromSeconds(*wanted.recording.duration_s)
                                                   : kDefaultDurationNs;
  // a trial in memory has the time base of a recording
  HAPTOMETER_LET(const auto trial, RecordInMemory(sensor, clock, cli::Interrupted(), limits));
  const CheckQuestion question{.band = band,
                               .command = CommandOf({argv, argv + argc}, true),
                               .command_of_other_band = CommandOf({argv, argv + argc}, false),
                               .smallest_rms_m = wanted.smallest_rms_m};
  const CheckFindings findings = FindingsOf(trial.record, trial.summary, band);
  const std::vector<CheckItem> items = CheckList(sensor.header(), findings, question);
  const int status = document::Present(CheckDocument(sensor.header(), findings, question, items),
                                       wanted.outputs, argc, argv);
  // 0 ready, 3 not; an error of the output or an interruption overrides 0
  const int verdict = IsReady(items) ? 0 : ExitStatus(Cause::kCannotAnswer);
  return cli::InterruptedStatus(cli::WorseStatus(status, verdict));
}

document::Document CheckDocument(const trial::TrialHeader& header, const CheckFindings& findings,
                                 const CheckQuestion& question,
                                 const std::vector<CheckItem>& items) {
  const auto fixes = std::ranges::count(items, Verdict::kFix, &CheckItem::verdict);
  document::Document document{
      .verb = "acquire",
      .title = fixes == 0 ? "ready" : fmt::format("not ready: {} to fix", fixes)};
  Section& root = document.root;
  root.sources = trial::SourcesOf(header.metadata, {.closed = !findings.summary.interrupted});
  root.Add({"ready"}, fixes == 0);
  root.Add({document::kSensor.name}, header.metadata.sensor);
  root.Add({document::kSource.name}, header.metadata.source);
  Section band{.name = document::kBand.name};
  band.Add(document::kLowerHz, question.band.lower_hz);
  band.Add(document::kUpperHz, question.band.upper_hz);
  root.sections = {std::move(band),
                   ListOf({.name = "items", .shape = Section::Shape::kArray}, items, ItemSection),
                   NumbersSection(findings, question.band),
                   GainsSection(AveragingGains(header.metadata, question.band))};
  return document;
}

Result<double> MeasureTare(acquire::Sensor& sensor, Clock& clock, const std::atomic<bool>& stop,
                           const std::string& name) {
  const auto channel = trial::DisplacementChannel(sensor.header());
  if (!channel) return CannotAnswer(name, "has no displacement to tare", "leave --tare out");
  acquire::Reading reading;
  (void)sensor.Begin();
  TareMean tare(sensor.header(), *channel, clock.Now());
  while (!stop.load() && !tare.is_over() && tare.IsPatient(clock.Now())) {
    const Outcome outcome = sensor.Next(reading);
    if (outcome == Outcome::kGone || outcome == Outcome::kAway) {
      // the second before the recording is lost with the connection: no reconnection is waited for
      return Failed(name, "the connection was lost during --tare",
                    "check cable and power, and start again");
    }
    if (outcome == Outcome::kEnd) {
      return CannotAnswer(name, "ended during --tare, which takes its first second",
                          "give it more than that, or leave --tare out");
    }
    if (outcome == Outcome::kReading) tare.Add(reading, clock.Now());
  }
  if (stop.load()) return Failed(name, "was not recorded: interrupted during --tare");
  return tare.Mean(name);
}

}  // namespace haptometer::tools
