#include "tools/acquire/recording_document.h"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/protocol/wire.h"
#include "acquire/sensor/stream_sensor.h"
#include "acquire/transport/port_list.h"
#include "base/text.h"
#include "tools/cli/json.h"
#include "tools/cli/shared_options.h"
#include "trial/trial_reader.h"

namespace haptometer::tools {
namespace {

using acquire::RecordingSummary;
using nlohmann::ordered_json;
using trial::SampleStatus;

bool IsBad(std::size_t status) { return !IsMeasurement(static_cast<SampleStatus>(status)); }

// " (1 late, 2 bad_frame)", or nothing where nothing is bad
std::string BadByKind(const RecordingSummary& summary) {
  std::string kinds;
  for (std::size_t status = 0; status < summary.statuses.size(); ++status) {
    if (!IsBad(status) || summary.statuses[status] == 0) continue;
    kinds += fmt::format("{}{} {}", kinds.empty() ? "" : ", ", summary.statuses[status],
                         Name(static_cast<SampleStatus>(status)));
  }
  return kinds.empty() ? kinds : " (" + kinds + ")";
}

std::string Rate(const RecordingSummary& summary) {
  return summary.rate_hz ? fmt::format("{:.1f}/s", *summary.rate_hz) : "rate unknown";
}

}  // namespace

std::string SummaryLine(const std::string& file, const RecordingSummary& summary) {
  std::string line =
      fmt::format("{}: {} readings in {:.3f} s ({}", file.empty() ? "nothing kept" : file,
                  summary.readings, summary.elapsed_s, Rate(summary));
  if (summary.interval_sd_s)
    line += fmt::format(", jitter {:.3f} ms", *summary.interval_sd_s * 1e3);
  line += fmt::format("), {} bad{}, {} repeated, {} gaps", summary.bad(), BadByKind(summary),
                      summary.repeated(), summary.gaps);
  if (summary.lost > 0) line += fmt::format(", {} lost to a slow disk", summary.lost);
  if (summary.reconnects > 0) line += fmt::format(", {} reconnections", summary.reconnects);
  if (summary.triggers > 0) line += fmt::format(", {} triggers", summary.triggers);
  if (summary.interrupted) line += ", interrupted before its end";
  if (summary.discarded_bytes > 0) {
    line += fmt::format(", {} bytes formed no reading", summary.discarded_bytes);
  }
  return line;
}

std::string ProgressLine(const RecordingSummary& summary) {
  return fmt::format("{:.1f} s  {} readings  {}", summary.elapsed_s, summary.readings,
                     Rate(summary));
}

std::string SummaryJson(const std::string& file, const trial::Metadata& metadata,
                        const RecordingSummary& summary,
                        const std::optional<TimeBaseReview>& time_base) {
  ordered_json kinds = ordered_json::object();
  for (std::size_t status = 0; status < summary.statuses.size(); ++status) {
    if (IsBad(status)) kinds[Name(static_cast<SampleStatus>(status))] = summary.statuses[status];
  }
  std::optional<double> observable_hz;
  if (summary.rate_hz) observable_hz = acquire::HighestObservableHz(*summary.rate_hz);
  std::optional<double> uncertainty_s;
  if (time_base) uncertainty_s = time_base->uncertainty_s;
  const ordered_json document{{"file", cli::TextOrNull(file)},
                              {"sensor", metadata.sensor},
                              {"source", metadata.source},
                              {"readings", summary.readings},
                              {"bad", summary.bad()},
                              {"bad_by_kind", kinds},
                              {"repeated", summary.repeated()},
                              {"distinct", summary.distinct()},
                              {"gaps", summary.gaps},
                              {"lost", summary.lost},
                              {"reconnects", summary.reconnects},
                              {"triggers", summary.triggers},
                              {"discarded_bytes", summary.discarded_bytes},
                              {"elapsed_s", summary.elapsed_s},
                              {"rate_hz", cli::NumberOrNull(summary.rate_hz)},
                              {"jitter_s", cli::NumberOrNull(summary.interval_sd_s)},
                              {"highest_observable_hz", cli::NumberOrNull(observable_hz)},
                              {"connection_lost", summary.connection_lost},
                              {"interrupted", summary.interrupted},
                              {"time_uncertainty_s", cli::NumberOrNull(uncertainty_s)}};
  return cli::JsonText(document);
}

namespace {

constexpr std::uint64_t kMostRows = 1'000'000;

}  // namespace

std::optional<TimeBaseReview> ReviewTimeBase(const std::string& file, trial::Timing timing,
                                             const acquire::RecordingSummary& summary) {
  if (file.empty() || timing != trial::Timing::kArrival) return std::nullopt;
  if (summary.readings == 0 || summary.readings > kMostRows) return std::nullopt;
  const auto recording = trial::ReadRecord(file);
  if (!recording || recording->record.stretches.empty()) return std::nullopt;
  TimeBaseReview review;
  review.gaps = recording->record.stretches.size() - 1;
  for (const trial::Stretch& stretch : recording->record.stretches) {
    review.uncertainty_s = std::max(review.uncertainty_s, stretch.time_uncertainty_s);
  }
  return review;
}

std::string TimeBaseRemark(const TimeBaseReview& review, const trial::Metadata& metadata) {
  std::string remark =
      fmt::format("times are straightened, true to {:.2g} ms", review.uncertainty_s * 1e3);
  const auto latency = metadata.fields.find(std::string(acquire::kLatencyField));
  if (latency != metadata.fields.end()) {
    remark +=
        fmt::format("; all are late by one unknown latency of at least {} s", latency->second);
  }
  return remark;
}

namespace {

using acquire::PortInfo;
using nlohmann::ordered_json;

constexpr int kFastestBaud = 38400;

// what the fastest DL-RS1A gives behind this adapter
std::optional<double> FastestPollHz(const PortInfo& port) {
  if (!port.latency_ns) return std::nullopt;
  return acquire::PolledRateHz(acquire::dl_rs1a::PollPeriodNs(kFastestBaud, 1), *port.latency_ns);
}

std::string Line(std::string_view what, const std::string& text) {
  return text.empty() ? "" : fmt::format("  {:<12}{}\n", what, Printable(text));
}

std::string PortText(const PortInfo& port) {
  std::string text = Printable(port.path) + "\n";
  text += Line("by id", port.by_id);
  text += Line("description", port.description);
  text += Line("driver", port.driver);
  if (port.usb_vendor && port.usb_product) {
    text += Line("USB", fmt::format("{:04x}:{:04x} {}", *port.usb_vendor, *port.usb_product,
                                    port.usb_serial));
  }
  if (port.latency_ns) {
    const MonotonicNs period_ns = acquire::dl_rs1a::PollPeriodNs(kFastestBaud, 1);
    text += Line("latency", fmt::format("{} ms", *port.latency_ns / 1'000'000));
    text += Line("", acquire::LatencyRemark(port.path, *port.latency_ns, period_ns));
  }
  return text + Line("in use by", port.held_by);
}

}  // namespace

std::string PortListText(const std::vector<PortInfo>& ports) {
  if (ports.empty()) return "no serial port is there: plug the sensor's adapter in\n";
  std::string text;
  for (const PortInfo& port : ports) text += PortText(port);
  return text;
}

std::string PortListJson(const std::vector<PortInfo>& ports) {
  ordered_json list = ordered_json::array();
  for (const PortInfo& port : ports) {
    std::optional<double> latency_s;
    if (port.latency_ns) latency_s = SecondsFromNs(*port.latency_ns);
    list.push_back({{"port", port.path},
                    {"by_id", cli::TextOrNull(port.by_id)},
                    {"description", cli::TextOrNull(port.description)},
                    {"driver", cli::TextOrNull(port.driver)},
                    {"usb_vendor", cli::CountOrNull(port.usb_vendor)},
                    {"usb_product", cli::CountOrNull(port.usb_product)},
                    {"usb_serial", cli::TextOrNull(port.usb_serial)},
                    {"latency_s", cli::NumberOrNull(latency_s)},
                    {"dl_rs1a_38400_baud_rate_hz", cli::NumberOrNull(FastestPollHz(port))},
                    {"in_use_by", cli::TextOrNull(port.held_by)}});
  }
  return cli::JsonText({{"ports", list}});
}

namespace {

using acquire::Capability;
using acquire::CapabilityQuestion;
using nlohmann::ordered_json;

ordered_json ToJson(const Capability& capability) {
  const acquire::SensorAbility& sensor = capability.sensor;
  return {{"name", sensor.name},
          {"option", sensor.option},
          {"can_answer", capability.can_answer},
          {"reason", capability.reason},
          {"rate_hz", sensor.rate_hz},
          {"highest_observable_hz", capability.highest_hz},
          {"gain_at_lower", capability.gain_lower},
          {"gain_at_upper", capability.gain_upper},
          {"resolution_m", cli::NumberOrNull(sensor.resolution_m)},
          {"noise_rms_m", cli::NumberOrNull(sensor.noise_rms_m)},
          {"noise_in_band_m", cli::NumberOrNull(capability.noise_in_band_m)},
          {"smallest_rms_10_percent_m", cli::NumberOrNull(capability.smallest_rms_10_percent_m)},
          {"smallest_rms_1_percent_m", cli::NumberOrNull(capability.smallest_rms_1_percent_m)},
          {"range_min_m", cli::NumberOrNull(sensor.range_min_m)},
          {"range_max_m", cli::NumberOrNull(sensor.range_max_m)}};
}

}  // namespace

Result<CapabilityQuestion> ReadCapabilityQuestion(const std::string& band,
                                                  const std::optional<Quantity>& resolution_m) {
  const auto read = cli::ParseBand(band);
  if (!read) return std::unexpected(read.error());
  if (!(read->lower_hz >= 0 && read->lower_hz < read->upper_hz)) {
    return Usage("--band", fmt::format("'{}' does not rise", band), "write it as 20-500Hz");
  }
  CapabilityQuestion question{.lower_hz = read->lower_hz, .upper_hz = read->upper_hz};
  if (resolution_m) question.resolution_m = resolution_m->value;
  if (!(question.resolution_m > 0)) {
    return Usage("--resolution", "must be above 0", "write e.g. 1um");
  }
  return question;
}

std::string SensorListText(const CapabilityQuestion& question) {
  std::string text = fmt::format("{:g}-{:g} Hz in steps of {:g} um:\n", question.lower_hz,
                                 question.upper_hz, 1e6 * question.resolution_m);
  for (const Capability& capability : Judge(acquire::KnownSensors(), question)) {
    text +=
        fmt::format("{:<7} {}\n        {}\n        {}\n", capability.can_answer ? "yes" : "cannot",
                    capability.sensor.name, capability.reason, capability.sensor.option);
  }
  return text;
}

std::string SensorListJson(const CapabilityQuestion& question) {
  ordered_json sensors = ordered_json::array();
  for (const Capability& capability : Judge(acquire::KnownSensors(), question)) {
    sensors.push_back(ToJson(capability));
  }
  const ordered_json document{{"band_hz", {question.lower_hz, question.upper_hz}},
                              {"wanted_resolution_m", question.resolution_m},
                              {"record_s", question.record_s},
                              {"sensors", sensors}};
  return cli::JsonText(document);
}

}  // namespace haptometer::tools
