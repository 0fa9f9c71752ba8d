#include "tools/acquire/open_keyence.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "acquire/protocol/keyence/dl_en1.h"
#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/sensor/keyence/il_settings.h"
#include "acquire/sensor/keyence/keyence_il.h"
#include "acquire/sensor/keyence/keyence_lkg.h"
#include "acquire/transport/open_port.h"
#include "tools/acquire/sensor_kind.h"

namespace haptometer::tools {
namespace {

using acquire::Sensor;

constexpr int kDefaultBaud = 9600;

bool IsLkg(const SensorOptions& wanted) { return IsSensor(wanted.sensor, SensorType::kKeyenceLkg); }
bool IsEn1(const SensorOptions& wanted) { return IsSensor(wanted.sensor, SensorType::kKeyenceEn1); }

int BaudOf(const SensorOptions& wanted) {
  return static_cast<int>(wanted.baud.value_or(kDefaultBaud));
}

std::optional<double> RateOf(const SensorOptions& wanted) {
  return wanted.rate_hz ? std::optional(wanted.rate_hz->value) : std::nullopt;
}

std::optional<MonotonicNs> RefreshOf(const SensorOptions& wanted) {
  return wanted.refresh_s ? std::optional(NsFromSeconds(wanted.refresh_s->value)) : std::nullopt;
}

std::optional<int> DecimalsOf(const SensorOptions& wanted) {
  return wanted.decimals ? std::optional(static_cast<int>(*wanted.decimals)) : std::nullopt;
}

Result<std::vector<acquire::il_setting::Write>> WritesOf(const SensorOptions& wanted) {
  std::vector<acquire::il_setting::Write> writes;
  for (const std::string& text : wanted.settings) {
    const auto parsed = acquire::il_setting::Parse(text);
    if (!parsed) return std::unexpected(parsed.error());
    writes.insert(writes.end(), parsed->begin(), parsed->end());
  }
  return writes;
}

Result<std::unique_ptr<Sensor>> OpenIl(const SensorOptions& wanted, Clock& clock) {
  const bool is_en1 = IsEn1(wanted);
  const auto writes = WritesOf(wanted);
  if (!writes) return std::unexpected(writes.error());
  // a bare host has the unit's own port
  std::error_code error;
  const bool is_host = is_en1 && !std::filesystem::exists(wanted.port, error);
  const std::string name = is_host ? acquire::dl_en1::WithPort(wanted.port) : wanted.port;
  auto port = acquire::OpenPort(name, BaudOf(wanted));
  if (!port) return std::unexpected(port.error());
  acquire::KeyenceIlSetup setup{
      .baud = BaudOf(wanted),
      .refresh_ns = RefreshOf(wanted),
      .unit = is_en1 ? acquire::IlUnit::kDlEn1 : acquire::IlUnit::kDlRs1a,
      .command = wanted.command == "ms" ? acquire::dl::Command::kMs : acquire::dl::Command::kM0,
      .rate_hz = RateOf(wanted),
      .writes = *writes,
      .device_zero = wanted.device_zero,
      .decimals = DecimalsOf(wanted)};
  return std::make_unique<acquire::KeyenceIl>(std::move(*port), std::move(setup), clock);
}

Result<std::unique_ptr<Sensor>> OpenLkg(const SensorOptions& wanted, Clock& clock) {
  using acquire::lkg::Command;
  auto port = acquire::OpenPort(wanted.port, BaudOf(wanted));
  if (!port) return std::unexpected(port.error());
  const Command command = wanted.command == "m0"   ? Command::kM0
                          : wanted.command == "m2" ? Command::kM2
                                                   : Command::kM1;
  const acquire::KeyenceLkgSetup setup{.baud = BaudOf(wanted),
                                       .command = command,
                                       .rate_hz = RateOf(wanted),
                                       .refresh_ns = RefreshOf(wanted),
                                       .decimals = DecimalsOf(wanted)};
  return std::make_unique<acquire::KeyenceLkg>(std::move(*port), setup, clock);
}

Result<void> CheckCommand(const SensorOptions& wanted) {
  if (wanted.command.empty() || wanted.command == "m0") return {};
  const bool is_ms = wanted.command == "ms";
  if (IsLkg(wanted) && is_ms) {
    return Usage("--command", "ms is a command of the IL series",
                 "use m1, m2 or m0 (both outputs)");
  }
  if (!IsLkg(wanted) && !is_ms) {
    return Usage("--command", wanted.command + " is a command of the LK-G series",
                 "use m0, or ms to record the outputs too");
  }
  return {};
}

}  // namespace

Result<void> CheckKeyence(const SensorOptions& wanted, const SensorKind& kind) {
  if (!kind.is_il && !wanted.settings.empty()) {
    return Usage("--set", "is for the amplifiers of the IL series", "leave it out");
  }
  if (!kind.is_il && wanted.device_zero) {
    return Usage("--device-zero", "is for the amplifiers of the IL series", "leave it out");
  }
  if (wanted.decimals && !IsEn1(wanted) && !IsLkg(wanted)) {
    return Usage("--decimals", "is for keyence-en1 and keyence-lkg: others send the point",
                 "leave it out");
  }
  if (!kind.is_keyence) {
    if (wanted.command.empty()) return {};
    return Usage("--command", "is for keyence-en1, keyence-il and keyence-lkg", "leave it out");
  }
  const auto& bauds = acquire::dl_rs1a::kBauds;
  if (kind.type == SensorType::kKeyenceIl &&
      std::ranges::find(bauds, BaudOf(wanted)) == bauds.end()) {
    return Usage("--baud", fmt::format("a DL-RS1A has no {} baud", BaudOf(wanted)),
                 "use 2400, 4800, 9600, 19200 or 38400");
  }
  if (auto writes = WritesOf(wanted); !writes) return std::unexpected(writes.error());
  return CheckCommand(wanted);
}

Result<std::unique_ptr<Sensor>> OpenKeyence(const SensorOptions& wanted, Clock& clock) {
  return IsLkg(wanted) ? OpenLkg(wanted, clock) : OpenIl(wanted, clock);
}

}  // namespace haptometer::tools
