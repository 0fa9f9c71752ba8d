#include "tools/acquire/list_ports.h"

#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/transport/port_list.h"
#include "base/text.h"
#include "tools/cli/json.h"

namespace haptometer::tools {
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

}  // namespace haptometer::tools
