#include "acquire/transport/latency_timer.h"

#include <fmt/core.h>

#include <filesystem>
#include <fstream>

namespace haptometer::acquire {
namespace {

constexpr MonotonicNs kNsPerMs = 1'000'000;

// below SYSFS, for a port that is called ttyUSB0
std::string TimerPath(const std::string& path) {
  return fmt::format("/bus/usb-serial/devices/{}/latency_timer",
                     std::filesystem::path(path).filename().string());
}

}  // namespace

std::optional<MonotonicNs> LatencyTimerNs(const std::string& path, const std::string& sysfs) {
  constexpr int kMostMs = 255;  // the timer has 8 bits
  int ms = 0;
  if (!(std::ifstream(sysfs + TimerPath(path)) >> ms) || ms < 0 || ms > kMostMs) {
    return std::nullopt;
  }
  return ms * kNsPerMs;
}

void AddLatencyTimer(std::optional<MonotonicNs> latency_ns, trial::Metadata& metadata) {
  if (!latency_ns) return;
  metadata.fields[std::string(kLatencyTimerField)] =
      fmt::format("{:g}", SecondsFromNs(*latency_ns));
}

std::string LatencyWords(std::optional<MonotonicNs> latency_ns, bool is_low) {
  if (latency_ns) return fmt::format(", latency timer {} ms", *latency_ns / kNsPerMs);
  return is_low ? ", low latency" : "";
}

double PolledRateHz(MonotonicNs period_ns, MonotonicNs latency_ns) {
  return 1 / SecondsFromNs(period_ns + latency_ns);
}

std::string LatencyRemark(const std::string& path, MonotonicNs latency_ns, MonotonicNs period_ns) {
  if (latency_ns <= kNsPerMs) return {};
  return fmt::format(
      "the adapter keeps short replies for {} ms: {:.1f} readings/s at most instead of {:.1f}; set "
      "1 ms with: echo 1 | sudo tee /sys{}, or for good with the udev rule "
      "ACTION==\"add\", SUBSYSTEM==\"usb-serial\", DRIVER==\"ftdi_sio\", "
      "ATTR{{latency_timer}}=\"1\"",
      latency_ns / kNsPerMs, PolledRateHz(period_ns, latency_ns), PolledRateHz(period_ns, kNsPerMs),
      TimerPath(path));
}

}  // namespace haptometer::acquire
