// A calibration's text: whatever it says, it is read or refused, and a channel that it calibrates
// has a slope and limits.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "fuzz/require.h"
#include "fuzz/seeds.h"
#include "trial/calibration.h"

namespace {

constexpr std::array<std::string_view, 2> kSeeds{
    "name = \"IL-030\"\ndate = \"2026-01-02\"\n[displacement]\nscale_m_per_v = 1e-3\noffset_m = "
    "\"-5mm\"\nbad_below_v = -5.1\nbad_above_v = 5.1\nvolt_per_count = 3e-4\nrange_min_m = "
    "-5e-3\n",
    "[displacement]\nfirst = { voltage_v = -5, displacement_m = \"-5mm\" }\nsecond = { voltage_v = "
    "5, displacement_m = \"5mm\" }\n[current]\nscale_a_per_v = \"0.1\"\ndaq_min_v = -10\ndaq_max_v "
    "= 10\n"};

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned random) {
  return haptometer::fuzz::MutateFromSeeds(kSeeds, 0, {data, max_size}, size, random);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptometer;
  using fuzz::Require;
  std::vector<trial::ChannelFormat> formats(3);
  formats[0].name = "displacement";
  formats[0].role = trial::ChannelRole::kDisplacement;
  formats[1].name = "current";
  formats[1].role = trial::ChannelRole::kCurrent;
  formats[2].name = "trigger";
  formats[2].role = trial::ChannelRole::kTrigger;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto calibration = trial::ReadCalibrationText(text, "c.toml", formats);
  if (!calibration) {
    Require(!calibration.error().Text().empty());
    return 0;
  }
  Require(!calibration->channels.empty());
  for (const auto& [name, channel] : calibration->channels) {
    Require(std::isfinite(channel.scale) && channel.scale != 0 && std::isfinite(channel.offset));
    trial::ChannelFormat format = formats[0];
    const trial::RawLimits limits =
        trial::Calibrate(channel, channel.input_per_count.value_or(1), 0, &format);
    Require(std::isfinite(format.scale) && !std::isnan(limits.rail_min));
  }
  Require(!trial::CalibrationFields(*calibration).empty());
  return 0;
}
