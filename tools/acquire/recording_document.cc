#include "tools/acquire/recording_document.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/protocol/wire.h"
#include "acquire/sensor/stream_sensor.h"
#include "base/band.h"
#include "base/input_file.h"
#include "tools/cli/shared_options.h"
#include "trial/import/table/table_cells.h"
#include "trial/trial_reader.h"

namespace haptometer::tools {
namespace {

using acquire::RecordingSummary;
using document::Key;
using document::Section;
using document::TextOrNotKnown;
using document::Value;
using trial::SampleStatus;

// --- findings ---

// what is reported of a fitted time base, and of the file's name
enum class RecordingFinding : std::uint8_t { kTimesStraightened, kLatencyUnknown, kNamedAsTable };

document::Sentence SentenceOf(RecordingFinding kind) {
  using enum RecordingFinding;
  static constexpr document::KindSentence<RecordingFinding> kSentences[] = {
      {kTimesStraightened, "times-straightened",
       "the times of arrival are fitted to a uniform clock; standard uncertainty of a time "
       "{time_uncertainty_s}"},
      {kLatencyUnknown, "latency-unknown",
       "all times have one constant delay of at least {latency_at_least_s}, whose value is not "
       "known"},
      {kNamedAsTable, "named-as-table",
       "the file is a trial, though its name ends in {ending}; haptometer trial export FILE -o "
       "OUT.csv makes a table of it (.h5, .npy, .wav, .mat: a file of that format)"},
  };
  return document::SentenceIn(kSentences, kind);
}

// standard uncertainty of a time, and where the sensor has one the lower limit of its latency
Findings<RecordingFinding> FindingsOf(const TimeBaseReview& review,
                                      const trial::Metadata& metadata) {
  Findings<RecordingFinding> findings;
  findings.Note(RecordingFinding::kTimesStraightened,
                {{"time_uncertainty_s", review.uncertainty_s}});
  const auto latency = metadata.fields.find(std::string(trial::kLatencyField));
  if (latency == metadata.fields.end()) return findings;
  if (const auto latency_s = trial::ReadNumber(latency->second)) {
    findings.Note(RecordingFinding::kLatencyUnknown, {{"latency_at_least_s", *latency_s}});
  }
  return findings;
}

// a trial whose name ends as that of a file that `trial export` writes, or of another table
Findings<RecordingFinding> NameFindings(const std::string& file) {
  constexpr std::array<std::string_view, 8> kEndings{".csv", ".txt", ".tsv", ".npy",
                                                     ".mat", ".wav", ".h5",  ".hdf5"};
  const std::string ending = trial::LowerCase(std::filesystem::path(file).extension().string());
  Findings<RecordingFinding> findings;
  if (std::ranges::find(kEndings, ending) != kEndings.end()) {
    findings.Note(RecordingFinding::kNamedAsTable, {{"ending", ending}});
  }
  return findings;
}

// --- a recording ---

// "12500 readings in 2.500 s, after 1.500 s of waiting for the trigger"
std::string CountAndLength(const RecordingSummary& summary, std::optional<double> duration_s) {
  std::string words =
      fmt::format("{} reading{}", summary.readings, summary.readings == 1 ? "" : "s");
  // one reading has no length
  if (!duration_s) return words;
  words += fmt::format(" in {:.3f} s", *duration_s);
  // the time up to the last row, without the n - 1 intervals of the rows
  const double waited_s =
      summary.elapsed_s - static_cast<double>(summary.readings - 1) / *summary.rate_hz;
  constexpr double kShortest = 0.5e-3;  // shown as 0.001 s
  if (summary.triggers == 0 || waited_s < kShortest) return words;
  return words + fmt::format(", after {:.3f} s of waiting for {}", waited_s,
                             summary.triggers == 1 ? "the trigger" : "triggers");
}

// the counts by status, and in words "1 late, 2 bad_frame"
Section BadByKind(const RecordingSummary& summary, std::string& words) {
  Section kinds{.name = "bad_by_kind"};
  for (std::size_t status = 0; status < summary.statuses.size(); ++status) {
    const auto kind = static_cast<SampleStatus>(status);
    if (IsMeasurement(kind)) continue;
    const std::string_view name = Name(kind);
    const std::uint64_t count = summary.statuses[status];
    kinds.Add({name}, count);
    if (count > 0) words += fmt::format("{}{} {}", words.empty() ? "" : ", ", count, name);
  }
  return kinds;
}

// shown in text where it is not 0
void AddRare(Section& section, const Key& key, std::uint64_t count) {
  document::Item& item = section.Add(key, count);
  if (count == 0) item.label.clear();
}

// rows beyond which reading the trial back would take 100 MB
constexpr std::uint64_t kMostRows = 1'000'000;

// --- serial ports ---

using acquire::PortInfo;

// fastest baud of a DL-RS1A
constexpr int kFastestBaud = 38400;

Section PortSection(const PortInfo& port) {
  std::optional<double> latency_s, rate_hz;
  Section section{.heading = port.path};
  if (port.latency_ns) {
    // the rate of a DL-RS1A with one amplifier behind this adapter: latency adds to the poll period
    const MonotonicNs period_ns = acquire::dl_rs1a::PollPeriodNs(kFastestBaud, 1);
    latency_s = SecondsFromNs(*port.latency_ns);
    rate_hz = acquire::PolledRateHz(period_ns, *port.latency_ns);
    document::AddFindings(section, acquire::LatencyCostOf(port.path, *port.latency_ns, period_ns));
  }
  std::string usb;
  if (port.usb_vendor && port.usb_product) {
    usb = fmt::format("{:04x}:{:04x} {}", *port.usb_vendor, *port.usb_product, port.usb_serial);
  }
  section.Add(document::kPort, port.path);
  section.Add({"by_id", "by id"}, TextOrNotKnown(port.by_id));
  section.Add({"description", "description"}, TextOrNotKnown(port.description));
  section.Add({"driver", "driver"}, TextOrNotKnown(port.driver));
  // a port on the main board has no USB adapter and none of these entries
  if (port.by_id.empty() && port.description.empty() && port.driver.empty()) {
    section.Add({"", "adapter"}, "none is known");
  }
  section.Add({"", "USB"}, TextOrNotKnown(usb));
  section.Add({"usb_vendor"}, port.usb_vendor);
  section.Add({"usb_product"}, port.usb_product);
  section.Add({"usb_serial"}, TextOrNotKnown(port.usb_serial));
  section.Add({document::kLatency.name, "latency timer", document::kSecond}, latency_s);
  section.Add({"dl_rs1a_38400_baud_rate_hz", "fastest DL-RS1A", document::kHertz}, rate_hz)
      .resolution = 0.1;
  section.Add({"in_use_by", "in use by"}, TextOrNotKnown(port.held_by));
  return section;
}

// --- known sensors ---

using acquire::Capability;
using acquire::CapabilityQuestion;

// what limits the sensor's sampling rate, in words
std::string_view TextOf(acquire::RateLimit limit) {
  // in the order of the enumerators
  static constexpr std::array<std::string_view, 6> kNames{
      "the wire",           "the wire alone",        "the wire and the sensor",
      "the unit's refresh", "the unit's processing", "the amplifier's sampling"};
  return kNames[static_cast<std::size_t>(limit)];
}

Section CapabilitySection(const Capability& capability) {
  const acquire::SensorAbility& sensor = capability.sensor;
  Section section{.heading =
                      fmt::format("{}: {}", capability.can_answer ? "yes" : "cannot", sensor.name)};
  section.Add(document::kName, sensor.name);
  section.Add({"can_answer"}, capability.can_answer);
  // the reason names the limit, which only the sensor has
  acquire::Finding reason = capability.reason;
  reason.numbers.emplace_back("limit", std::string(TextOf(sensor.limit)));
  section.Add({"reason", "because"}, document::WordsOf(reason));
  std::string options;
  for (const auto& [setting, value] : sensor.settings) {
    options += fmt::format("{}--{} {}", options.empty() ? "" : " ", setting, value);
  }
  section.Add({"option", "acquire with"}, options);
  section.Add(document::kRate, sensor.rate_hz).label.clear();
  section.Add({document::kHighestObservable.name}, capability.highest_hz);
  section.Add({"gain_at_lower"}, capability.gain_lower);
  section.Add({"gain_at_upper"}, capability.gain_upper);
  section.Add({"resolution_m"}, sensor.resolution_m);
  section.Add(document::kNoiseRms, sensor.noise_rms_m);
  section.Add({"noise_in_band_m"}, capability.noise_in_band_m);
  section.Add({document::kSmallestRms10.name}, capability.smallest_rms_10_percent_m);
  section.Add({document::kSmallestRms1.name}, capability.smallest_rms_1_percent_m);
  section.Add({"range_min_m"}, sensor.range_min_m);
  section.Add({"range_max_m"}, sensor.range_max_m);
  return section;
}

}  // namespace

std::optional<TimeBaseReview> ReviewTimeBase(const std::string& file, trial::Timing timing,
                                             const RecordingSummary& summary) {
  // arrival times alone are fitted: other timings have their times from a clock or a poll
  if (file.empty() || timing != trial::Timing::kArrival) return std::nullopt;
  if (summary.readings == 0 || summary.readings > kMostRows) return std::nullopt;
  // read back: the fit of the whole record separates single lost lines from jitter
  const auto recording = trial::ReadRecord(file);
  ForgetInput(file);
  if (!recording || recording->record.stretches.empty()) return std::nullopt;
  TimeBaseReview review;
  // a record of n segments has n - 1 gaps
  review.gaps = recording->record.stretches.size() - 1;
  for (const trial::Stretch& stretch : recording->record.stretches) {
    review.uncertainty_s = std::max(review.uncertainty_s, stretch.time_uncertainty_s);
  }
  for (const trial::Finding& finding : recording->report.findings.list()) {
    if (finding.kind == trial::FindingKind::kNumbersRefuted) review.doubts.Add(finding);
  }
  return review;
}

document::Document RecordingDocument(const std::string& file, const trial::Metadata& metadata,
                                     const RecordingSummary& summary,
                                     const std::optional<TimeBaseReview>& time_base,
                                     const acquire::Findings& found) {
  std::optional<double> duration_s, observable_hz, uncertainty_s;
  if (summary.rate_hz) {
    // length of what is recorded, without waits and absences
    duration_s = static_cast<double>(summary.readings) / *summary.rate_hz;
    // f_s / 2.56, the highest frequency that the rate can observe
    observable_hz = HighestObservableHz(*summary.rate_hz);
  }
  document::Document document{.verb = "acquire",
                              .title = fmt::format("{}: {}", file.empty() ? "nothing kept" : file,
                                                   CountAndLength(summary, duration_s))};
  Section& root = document.root;
  root.sources = trial::SourcesOf(metadata, {.closed = !summary.interrupted});
  if (time_base) uncertainty_s = time_base->uncertainty_s;
  std::string bad_words;
  // counts by status, then the sensor's findings, of which without --all doubts alone are shown
  root.sections = {BadByKind(summary, bad_words), {.detail = document::Detail::kAll}};
  acquire::Findings doubts, others;
  for (const acquire::Finding& finding : found.list()) {
    (finding.severity == Severity::kDoubt ? doubts : others).Add(finding);
  }
  document::AddFindings(root, doubts);
  document::AddFindings(root.sections.back(), others);

  // the summary in text; keys without a label stand in JSON alone
  root.Add(document::kFile, TextOrNotKnown(file));
  root.Add(document::kSensor, metadata.sensor);
  root.Add(document::kSource, metadata.source);
  root.Add({document::kReadings.name}, summary.readings);
  root.Add(document::kRate, summary.rate_hz).resolution = 0.1;
  root.Add(kJitterKey, summary.interval_sd_s).resolution = 1e-6;
  root.Add(document::kHighestObservable, observable_hz).note = "rate / 2.56";
  root.Add(kBadKey, summary.bad()).note = bad_words;
  root.Add(kRepeatedKey, summary.repeated());
  root.Add({"distinct"}, summary.distinct());
  root.Add(document::kGaps, summary.gaps);
  AddRare(root, kLostKey, summary.lost);
  AddRare(root, kReconnectsKey, summary.reconnects);
  AddRare(root, {"triggers", "triggers"}, summary.triggers);
  AddRare(root, {"discarded_bytes", "bytes that formed no reading"}, summary.discarded_bytes);
  root.Add({document::kDuration.name}, duration_s);
  root.Add({"elapsed_s"}, summary.elapsed_s);
  root.Add({"connection_lost"}, summary.connection_lost);
  root.Add({"interrupted"}, summary.interrupted);
  root.Add({document::kTimeUncertainty.name}, uncertainty_s);
  if (time_base) {
    document::AddFindings(root, time_base->doubts);
    document::AddFindings(root, FindingsOf(*time_base, metadata));
  }
  document::AddFindings(root, NameFindings(file));
  return document;
}

std::string ProgressLine(const RecordingSummary& summary) {
  return fmt::format("{:.1f} s  {} readings  {}", summary.elapsed_s, summary.readings,
                     summary.rate_hz ? fmt::format("{:.1f}/s", *summary.rate_hz) : "rate unknown");
}

document::Document PortsDocument(const std::vector<PortInfo>& ports) {
  document::Document document{
      .verb = "acquire",
      .title = ports.empty()
                   ? "no serial port is there: plug the sensor's adapter in"
                   : fmt::format("{} serial port{}", ports.size(), ports.size() == 1 ? "" : "s")};
  document.root.sections = {
      ListOf({.name = "ports", .shape = Section::Shape::kArray}, ports, PortSection)};
  return document;
}

Result<CapabilityQuestion> ReadCapabilityQuestion(const std::string& band,
                                                  std::optional<double> resolution_m) {
  HAPTOMETER_LET(const auto read, cli::ParseBand(band));
  // LOWER below UPPER; 0 Hz is permitted as the lower corner here
  if (!(read.lower_hz >= 0 && read.lower_hz < read.upper_hz)) {
    return Usage("--band", fmt::format("'{}' does not rise", band), "write it as 20-500Hz");
  }
  CapabilityQuestion question{.lower_hz = read.lower_hz, .upper_hz = read.upper_hz};
  if (resolution_m) question.resolution_m = *resolution_m;
  return question;
}

document::Document SensorsDocument(const CapabilityQuestion& question) {
  document::Document document{
      .verb = "acquire",
      .title = fmt::format("{:g}-{:g} Hz in steps of {:g} um, records of {:g} s", question.lower_hz,
                           question.upper_hz, 1e6 * question.resolution_m, question.record_s)};
  Section& root = document.root;
  root.Add({"band_hz"}, document::Range{question.lower_hz, question.upper_hz});
  root.Add({"wanted_resolution_m"}, question.resolution_m);
  root.Add({"record_s"}, question.record_s);
  root.sections = {ListOf({.name = document::kSensors.name, .shape = Section::Shape::kArray},
                          Judge(acquire::KnownSensors(), question), CapabilitySection)};
  return document;
}

}  // namespace haptometer::tools
