#include "tools/simulate/drive_text.h"

#include <fmt/core.h>

namespace haptometer::tools {
namespace {

// the tones one after the other
std::string DriveTonesText(const sim::Drive& drive) {
  std::string text = "tones of ";
  for (std::size_t k = 0; k < drive.tones.size(); ++k) {
    const bool is_last = k + 1 == drive.tones.size();
    if (k > 0) text += is_last ? " and " : ", ";
    text += fmt::format("{:g} V at {:g} Hz", drive.tones[k].amplitude, drive.tones[k].frequency_hz);
  }
  return text;
}

std::string KindPlays(const sim::Drive& drive) {
  const std::string when =
      fmt::format("from {:g} to {:g} s", drive.start_s, sim::EndOfDriveS(drive));
  switch (drive.kind) {
    case sim::DriveKind::kSine:
      return fmt::format("{:g} V at {:g} Hz", drive.amplitude_v, drive.frequency_hz);
    case sim::DriveKind::kTones:
      return DriveTonesText(drive);
    case sim::DriveKind::kBurst:
      return fmt::format("a burst of {:g} V at {:g} Hz {}", drive.amplitude_v, drive.frequency_hz,
                         when);
    case sim::DriveKind::kChirp:
      return fmt::format("a chirp of {:g} V, {:g} to {:g} Hz {}", drive.amplitude_v,
                         drive.frequency_hz, drive.end_frequency_hz, when);
    case sim::DriveKind::kPulse:
      return fmt::format("a pulse of {:g} V {}", drive.amplitude_v, when);
    case sim::DriveKind::kSamples:
      return fmt::format("{} voltages at {:g} Hz, up to {:g} V", drive.samples->voltages_v.size(),
                         drive.samples->rate_hz, sim::LargestVoltageV(drive));
  }
  return {};
}

std::string WhatItPlays(const sim::Drive& drive) {
  if (drive.offset_v == 0) return KindPlays(drive);
  return fmt::format("{} on an offset of {:g} V", KindPlays(drive), drive.offset_v);
}

}  // namespace

std::string DriveText(const sim::Drive& drive) {
  if (drive.source_resistance_ohm == 0) return WhatItPlays(drive);
  return fmt::format("{} through {:g} ohm", WhatItPlays(drive), drive.source_resistance_ohm);
}

std::string KindText(sim::DriveKind kind) {
  const bool is_plural = kind == sim::DriveKind::kTones || kind == sim::DriveKind::kSamples;
  return fmt::format("{}{}", is_plural ? "" : "a ", Name(kind));
}

}  // namespace haptometer::tools
