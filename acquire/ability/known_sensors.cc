#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "acquire/ability/capability.h"
#include "acquire/protocol/keyence/dl_en1.h"
#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/protocol/stream_line.h"
#include "acquire/protocol/wire.h"
#include "acquire/sensor/modbus/sensor_profile.h"
#include "trial/sensor_head.h"

namespace haptometer::acquire {
namespace {

// an IL-030 whose readings are means of `averages` raw samples
SensorAbility Il030(double sampling_s, int averages) {
  const trial::SensorHead head = trial::Il030();
  return {.sampling_s = sampling_s,
          .averages = averages,
          .resolution_m = head.resolution_m,
          .noise_rms_m = head.noise_rms_m / std::sqrt(averages),
          .range_min_m = head.range_min_m,
          .range_max_m = head.range_max_m};
}

// the unit's factory settings, 1 ms and 16 averages
SensorAbility FactoryIl030() {
  const trial::SensorHead head = trial::Il030();
  return Il030(head.sampling_s, head.averages);
}

SensorAbility DlRs1a(int baud) {
  const MonotonicNs poll_ns = dl_rs1a::PollPeriodNs(baud, 1);
  const MonotonicNs refresh_ns = dl_rs1a::RefreshNs(1);
  SensorAbility sensor = FactoryIl030();
  sensor.name = fmt::format("IL-030 through a DL-RS1A, {} baud", baud);
  sensor.option = fmt::format("--sensor keyence-il --baud {}", baud);
  sensor.rate_hz = 1 / SecondsFromNs(std::max(poll_ns, refresh_ns));
  sensor.limit = poll_ns > refresh_ns ? "the wire" : "the unit's refresh";
  return sensor;
}

// Keyence, DL-EN1 User's Manual (633GB): processing 7.8 ms with one amplifier
SensorAbility DlEn1() {
  SensorAbility sensor = FactoryIl030();
  sensor.name = "IL-030 through a DL-EN1";
  sensor.option = "--sensor keyence-en1";
  sensor.rate_hz = 1 / SecondsFromNs(dl_en1::RefreshNs(1));
  sensor.limit = "the unit's processing";
  return sensor;
}

// one exchange is `M1` CR and `M1,+01.2345` CR; what the controller adds is not stated
SensorAbility LkG() {
  constexpr int kBaud = 115200;
  constexpr std::size_t kExchangeBytes = 3 + 12;
  return {.name = "LK-G asked over RS-232C, at an assumed 115200 baud",
          .option = "--sensor keyence-lkg --baud 115200",
          .rate_hz = 1 / SecondsFromNs(WireTimeNs(kExchangeBytes, kBaud)),
          .limit = "the wire alone",
          .resolution_m = 1e-7};
}

SensorAbility Stream(int baud) {
  const StreamFormat format;
  return {.name = fmt::format("lines of 9 characters that come unasked, {} baud", baud),
          .option = fmt::format("--sensor stream --baud {}", baud),
          .rate_hz = MostLinesPerSecond(format, baud),
          .limit = "the wire",
          .resolution_m = MetresPerCount(format)};
}

SensorAbility Modbus(const SensorProfile& profile) {
  return {.name = fmt::format("{} {}, Modbus", profile.maker, profile.model),
          .option = "--sensor modbus --profile " + profile.name,
          .rate_hz = HighestRateHz(profile),
          .limit = "the wire and the sensor",
          .resolution_m = profile.resolution_m,
          .noise_rms_m = profile.noise_rms_m,
          .range_min_m = profile.range_min_m,
          .range_max_m = profile.range_max_m};
}

// the amplifier renews its output with each raw sample; steps are those of the DAQ's converter
SensorAbility AnalogOutput(double sampling_s, int averages) {
  SensorAbility sensor = Il030(sampling_s, averages);
  sensor.name = fmt::format("IL-030, analog output and a DAQ, {:g} ms, {} average{}",
                            1e3 * sampling_s, averages, averages == 1 ? "" : "s");
  sensor.option = "--sensor pipe --calibration FILE";
  sensor.rate_hz = 1 / sampling_s;
  sensor.limit = "the amplifier's sampling";
  sensor.resolution_m.reset();
  return sensor;
}

}  // namespace

std::vector<SensorAbility> KnownSensors() {
  constexpr double kFastest_s = 0.33e-3;  // data 132, code 1
  std::vector<SensorAbility> sensors{AnalogOutput(kFastest_s, 1), AnalogOutput(kFastest_s, 4),
                                     AnalogOutput(1e-3, 16), DlEn1(), LkG()};
  for (const int baud : dl_rs1a::kBauds) sensors.push_back(DlRs1a(baud));
  for (const int baud : {9600, 115200, 230400, 460800, 921600}) sensors.push_back(Stream(baud));
  for (const SensorProfile& profile : BuiltInProfiles()) sensors.push_back(Modbus(profile));
  return sensors;
}

}  // namespace haptometer::acquire
