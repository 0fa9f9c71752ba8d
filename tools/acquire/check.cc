#include "tools/acquire/check.h"

#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "dsp/analysis/band_analysis.h"
#include "tools/acquire/acquire.h"
#include "tools/acquire/check_list.h"
#include "tools/cli/json.h"
#include "tools/cli/terminal.h"
#include "trial/byte_io.h"
#include "trial/record.h"
#include "trial/trial_reader.h"
#include "trial/trial_writer.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "acquire";
constexpr MonotonicNs kUsualDurationNs = 10 * kNsPerS;

// the command line without what asks for this check, for the next one
std::string CommandOf(const std::vector<std::string>& words) {
  std::vector<std::string> kept;
  for (std::size_t word = 0; word < words.size(); ++word) {
    if (words[word] == "--check" || words[word] == "--json") continue;
    if (words[word].starts_with("--band=")) continue;
    if (words[word] == "--band") {
      ++word;  // and its value
      continue;
    }
    kept.push_back(words[word]);
  }
  return cli::CommandLine(kept);
}

}  // namespace

int RunSensorCheck(const cli::Options& options, const AcquireOptions& wanted,
                   const dsp::BandPass& band, const std::vector<std::string>& words,
                   acquire::Sensor& sensor, Clock& clock) {
  if (!trial::DisplacementChannel(sensor.header())) {
    return cli::ReportError(kVerb, {Cause::kCannotAnswer, PortName(wanted.sensor),
                                    "has no displacement channel in metres to check",
                                    "give the calibration of its voltage"});
  }
  acquire::RecordingLimits limits;
  limits.duration_ns = wanted.recording.duration_s
                           ? NsFromSeconds(wanted.recording.duration_s->value)
                           : kUsualDurationNs;
  const auto trial = RecordInMemory(sensor, clock, cli::Interrupted(), limits);
  if (!trial) return cli::ReportError(kVerb, trial.error());
  CheckQuestion question{.band = band, .command = CommandOf(words), .smallest_rms_m = {}};
  if (wanted.smallest_rms_m) question.smallest_rms_m = wanted.smallest_rms_m->value;
  const CheckFindings findings = FindingsOf(trial->record, trial->summary, band);
  const std::vector<CheckItem> items = CheckList(sensor.header(), findings, question);
  cli::Print(options.json() ? CheckJson(sensor.header(), findings, question, items)
                            : CheckText(items));
  return cli::InterruptedStatus(IsReady(items) ? 0 : ExitStatus(Cause::kCannotAnswer));
}

namespace {

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

}  // namespace

Result<MemoryTrial> RecordInMemory(acquire::Sensor& sensor, Clock& clock,
                                   const std::atomic<bool>& stop,
                                   const acquire::RecordingLimits& limits) {
  std::string bytes;
  auto writer = trial::TrialWriter::CreateIn(std::make_unique<StringSink>(bytes), "memory",
                                             sensor.header(), {}, clock);
  if (!writer) return std::unexpected(writer.error());
  acquire::SingleTrial sink(*writer);
  const auto summary = acquire::Record(sensor, sink, clock, stop, limits);
  if (!summary) return std::unexpected(summary.error());
  auto recording = trial::ReadRecordFrom(trial::MakeMemorySource(std::move(bytes)), "memory");
  if (!recording) return std::unexpected(recording.error());
  return MemoryTrial{*summary, std::move(recording->record)};
}

namespace {

using nlohmann::ordered_json;

std::string_view Mark(Verdict verdict) {
  switch (verdict) {
    case Verdict::kOk:
      return "ok";
    case Verdict::kFix:
      return "FIX";
    case Verdict::kUnknown:
      return "?";
  }
  return "";
}

ordered_json ItemJson(const CheckItem& item) {
  return {{"name", item.name},
          {"verdict", Name(item.verdict)},
          {"finding", item.finding},
          {"remedy", cli::TextOrNull(item.remedy)}};
}

}  // namespace

std::string CheckText(const std::vector<CheckItem>& items) {
  std::string text;
  for (const CheckItem& item : items) {
    text += fmt::format("  {:<4} {:<10} {}\n", Mark(item.verdict), item.name, item.finding);
    if (!item.remedy.empty()) text += fmt::format("{:17}-> {}\n", "", item.remedy);
  }
  const auto fixes = std::ranges::count(items, Verdict::kFix, &CheckItem::verdict);
  return text + (fixes == 0 ? "ready\n" : fmt::format("not ready: {} to fix\n", fixes));
}

std::string CheckJson(const trial::TrialHeader& header, const CheckFindings& findings,
                      const CheckQuestion& question, const std::vector<CheckItem>& items) {
  ordered_json list = ordered_json::array();
  for (const CheckItem& item : items) list.push_back(ItemJson(item));
  ordered_json gains = ordered_json::array();
  for (const ToneGain& tone : AveragingGains(header.metadata, question.band)) {
    gains.push_back({{"frequency_hz", tone.frequency_hz}, {"gain", tone.gain}});
  }
  const acquire::RecordingSummary& summary = findings.summary;
  const ordered_json document{
      {"ready", IsReady(items)},
      {"sensor", header.metadata.sensor},
      {"source", header.metadata.source},
      {"band", {{"lower_hz", question.band.lower_hz}, {"upper_hz", question.band.upper_hz}}},
      {"items", list},
      {"readings", summary.readings},
      {"bad", summary.bad()},
      {"repeated", summary.repeated()},
      {"gaps", summary.gaps},
      {"duration_s", findings.duration_s},
      {"new_readings_per_s", findings.fresh_rate_hz},
      {"observable_upper_hz", findings.fresh_rate_hz / dsp::kLeastRatePerUpperCorner},
      {"jitter_s", cli::NumberOrNull(summary.interval_sd_s)},
      {"time_uncertainty_s", findings.time_uncertainty_s},
      {"level_m", cli::NumberOrNull(findings.level_m)},
      {"least_m", cli::NumberOrNull(findings.least_m)},
      {"greatest_m", cli::NumberOrNull(findings.greatest_m)},
      {"averaging_gains", gains.empty() ? ordered_json(nullptr) : gains},
      {"noise_rms_m", cli::NumberOrNull(findings.noise_m)},
      {"smallest_rms_10_percent_m", cli::NumberOrNull(SmallestRmsOf(findings, question.band, 0.1))},
      {"smallest_rms_1_percent_m", cli::NumberOrNull(SmallestRmsOf(findings, question.band, 0.01))},
      {"tone_frequency_hz", cli::NumberOrNull(findings.tone_hz)},
      {"tone_rms_m", cli::NumberOrNull(findings.tone_rms_m)}};
  return cli::JsonText(document);
}

using acquire::Outcome;

namespace {

constexpr double kTareS = 1;
constexpr MonotonicNs kPatienceNs = 3 * kNsPerS;

// the mean so far, and whether it is enough
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
      mean_ += (value - mean_) / static_cast<double>(count_);
    }
    if (is_uniform()) {
      // its rows come when they like, but each is a part of the second; nothing is asked for
      is_over_ = static_cast<double>(reading.index + 1) >= kTareS * header_.rate_hz;
      patient_until_ns_ = Later(now_ns);
    } else {
      // behind an answer nothing is outstanding that a new beginning could mistake for its own
      is_over_ = is_measurement && now_ns - begin_ns_ >= NsFromSeconds(kTareS);
    }
  }

  [[nodiscard]] bool is_over() const { return is_over_; }
  [[nodiscard]] bool IsPatient(MonotonicNs now_ns) const { return now_ns < patient_until_ns_; }

  [[nodiscard]] Result<double> Mean(const std::string& name) const {
    if (is_uniform() && !is_over_) {
      return CannotAnswer(name, "sent less than a second of readings and fell silent during --tare",
                          "check that the source goes on, or leave --tare out");
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
      // the second before the recording cannot be made up for, so nothing is waited for
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
