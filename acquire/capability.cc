#include "acquire/capability.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "acquire/protocol/keyence/dl_en1.h"
#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/protocol/stream_line.h"
#include "acquire/protocol/wire.h"
#include "acquire/sensor/modbus_profile.h"
#include "base/band.h"
#include "base/error.h"
#include "base/mapped.h"
#include "trial/sensor_head.h"

namespace haptometer::acquire {

double SmallestRms(const NoiseInBand& noise, double relative) {
  HAPTOMETER_CHECK(noise.rms_m > 0 && noise.bandwidth_hz > 0, "{} m in {} Hz", noise.rms_m,
                   noise.bandwidth_hz);
  HAPTOMETER_CHECK(noise.record_s > 0 && noise.noise_record_s > 0, "{} s, {} s", noise.record_s,
                   noise.noise_record_s);
  HAPTOMETER_CHECK(relative > 0, "relative = {}", relative);
  // variances of two mean squares of noise, in units of that over the record
  const double noise_parts = noise.own_share + noise.record_s / noise.noise_record_s;
  // positive root q = rms^2 / noise^2 of relative^2 = (a + T/Tn + 2 q) / (4 B T q^2)
  const double s = 4 * noise.bandwidth_hz * noise.record_s * relative * relative;
  const double q = (1 + std::sqrt(1 + noise_parts * s)) / s;
  return noise.rms_m * std::sqrt(q);
}

double RelativeUncertaintyOf(const NoiseInBand& noise, double rms_m) {
  HAPTOMETER_CHECK(rms_m > 0 && noise.record_s > 0, "{} m in {} s", rms_m, noise.record_s);
  const double q = std::pow(rms_m / noise.rms_m, 2);
  const double parts = noise.own_share + noise.record_s / noise.noise_record_s + 2 * q;
  return std::sqrt(parts / (4 * noise.bandwidth_hz * noise.record_s)) / q;
}

std::optional<double> RecordLength(const NoiseInBand& noise, double rms_m, double relative) {
  HAPTOMETER_CHECK(rms_m > 0 && relative > 0, "{} m to {}", rms_m, relative);
  const double q = std::pow(rms_m / noise.rms_m, 2);
  // what each second of the record adds to 1 / u^2, less what the noise's own record lacks
  const double gained =
      4 * noise.bandwidth_hz * std::pow(q * relative, 2) - 1 / noise.noise_record_s;
  if (!(gained > 0)) return std::nullopt;
  return (noise.own_share + 2 * q) / gained;
}

namespace {

// a rate that is enough by the arithmetic is not refused for its rounding
constexpr double kRounding = 1e-9;

// gain of the averaging, a moving mean of `averages` raw samples, at a frequency
double GainAt(const SensorAbility& sensor, double frequency_hz) {
  if (sensor.averages == 1 || frequency_hz == 0) return 1;
  return trial::AveragingGain(frequency_hz, sensor.sampling_s, sensor.averages);
}

// white noise over 0 to half the rate: what of it lies in the band, and how wide that part is
void AddNoise(const CapabilityQuestion& question, Capability* capability) {
  const SensorAbility& sensor = capability->sensor;
  const double half_rate_hz = 0.5 * sensor.rate_hz;
  const double bandwidth_hz = std::min(question.upper_hz, half_rate_hz) - question.lower_hz;
  if (!sensor.noise_rms_m || bandwidth_hz <= 0) return;
  // band RMS = RMS * sqrt(bandwidth / (rate / 2))
  const double rms_m = *sensor.noise_rms_m * std::sqrt(bandwidth_hz / half_rate_hz);
  capability->noise_in_band_m = rms_m;
  if (!(rms_m > 0)) return;
  // the noise record is assumed as long as the record itself
  const NoiseInBand noise{.rms_m = rms_m,
                          .bandwidth_hz = bandwidth_hz,
                          .record_s = question.record_s,
                          .noise_record_s = question.record_s};
  capability->smallest_rms_10_percent_m = SmallestRms(noise, 0.1);
  capability->smallest_rms_1_percent_m = SmallestRms(noise, 0.01);
}

// why it cannot answer; nothing where it can
std::optional<Finding> Obstacle(const Capability& capability, const CapabilityQuestion& question) {
  const SensorAbility& sensor = capability.sensor;
  if (!Observes(sensor.rate_hz, question.upper_hz)) {
    return Finding{.kind = FindingKind::kRateTooLow,
                   .numbers = {{"rate_hz", sensor.rate_hz},
                               {"observable_hz", capability.highest_hz},
                               {"asked_hz", question.upper_hz},
                               {"needed_hz", NeededRateHz(question.upper_hz)}}};
  }
  if (capability.gain_upper < kLeastGain) {
    return Finding{.kind = FindingKind::kAveragingTooLong,
                   .numbers = {{"averages", sensor.averages},
                               {"sampling_s", sensor.sampling_s},
                               {"gain", capability.gain_upper},
                               {"asked_hz", question.upper_hz}}};
  }
  if (sensor.resolution_m && *sensor.resolution_m > question.resolution_m * (1 + kRounding)) {
    return Finding{
        .kind = FindingKind::kStepsTooLarge,
        .numbers = {{"step_m", *sensor.resolution_m}, {"wanted_m", question.resolution_m}}};
  }
  return std::nullopt;
}

// the finding where nothing prevents an answer, with the smallest RMS where the noise is known
Finding Praise(const Capability& capability, const CapabilityQuestion& question) {
  Finding reason{.kind = FindingKind::kCanAnswer,
                 .numbers = {{"rate_hz", capability.sensor.rate_hz},
                             {"observable_hz", capability.highest_hz}}};
  if (capability.smallest_rms_10_percent_m) {
    reason.numbers.emplace_back("noise_m", *capability.noise_in_band_m);
    reason.numbers.emplace_back("smallest_m", *capability.smallest_rms_10_percent_m);
    reason.numbers.emplace_back("record_s", question.record_s);
  }
  return reason;
}

}  // namespace

Capability Judge(const SensorAbility& sensor, const CapabilityQuestion& question) {
  HAPTOMETER_CHECK(question.lower_hz >= 0 && question.lower_hz < question.upper_hz, "{} to {} Hz",
                   question.lower_hz, question.upper_hz);
  HAPTOMETER_CHECK(sensor.rate_hz > 0, "{}: rate_hz = {}", sensor.name, sensor.rate_hz);
  Capability capability{.sensor = sensor};
  // what the sensor can measure, then whether that is sufficient
  capability.highest_hz = HighestObservableHz(sensor.rate_hz);
  capability.gain_lower = GainAt(sensor, question.lower_hz);
  capability.gain_upper = GainAt(sensor, question.upper_hz);
  AddNoise(question, &capability);
  const auto obstacle = Obstacle(capability, question);
  capability.can_answer = !obstacle;
  capability.reason = obstacle.value_or(Praise(capability, question));
  return capability;
}

std::vector<Capability> Judge(const std::vector<SensorAbility>& sensors,
                              const CapabilityQuestion& question) {
  auto capabilities = Mapped<Capability>(
      sensors, [&](const SensorAbility& sensor) { return Judge(sensor, question); });
  // sensors that can answer first, then by highest observable frequency
  std::ranges::sort(capabilities, [](const Capability& a, const Capability& b) {
    return std::tuple(!a.can_answer, -a.highest_hz, a.sensor.name) <
           std::tuple(!b.can_answer, -b.highest_hz, b.sensor.name);
  });
  return capabilities;
}

namespace {

// an IL-030 whose readings are means of `averages` raw samples
SensorAbility Il030(double sampling_s, int averages) {
  const trial::SensorHead head = trial::Il030();
  return {.sampling_s = sampling_s,
          .averages = averages,
          .resolution_m = head.resolution_m,
          // a mean of n samples of white noise: standard deviation / sqrt(n)
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
  sensor.settings = {{"sensor", "keyence-il"}, {"baud", std::to_string(baud)}};
  // new readings come at the slower of poll and refresh of the unit's buffer
  sensor.rate_hz = 1 / SecondsFromNs(std::max(poll_ns, refresh_ns));
  sensor.limit = poll_ns > refresh_ns ? RateLimit::kWire : RateLimit::kUnitRefresh;
  sensor.is_polled = true;
  sensor.wire_s = SecondsFromNs(poll_ns);
  sensor.refresh_s = SecondsFromNs(refresh_ns);
  return sensor;
}

// Keyence, DL-EN1 User's Manual (633GB): processing 7.8 ms with one amplifier
SensorAbility DlEn1() {
  SensorAbility sensor = FactoryIl030();
  sensor.name = "IL-030 through a DL-EN1";
  sensor.settings = {{"sensor", "keyence-en1"}};
  sensor.rate_hz = 1 / SecondsFromNs(dl_en1::RefreshNs(1));
  sensor.limit = RateLimit::kUnitProcessing;
  sensor.is_polled = true;
  sensor.refresh_s = 1 / sensor.rate_hz;
  return sensor;
}

// one exchange is `M1` CR and `M1,+01.2345` CR; what the controller adds is not stated
SensorAbility LkG() {
  constexpr int kBaud = 115200;
  constexpr std::size_t kExchangeBytes = 3 + 12;
  const double exchange_s = SecondsFromNs(WireTimeNs(kExchangeBytes, kBaud));
  return {.name = "LK-G asked over RS-232C, at an assumed 115200 baud",
          .settings = {{"sensor", "keyence-lkg"}, {"baud", "115200"}},
          .rate_hz = 1 / exchange_s,
          .limit = RateLimit::kWireAlone,
          .resolution_m = 1e-7,
          .is_polled = true,
          .wire_s = exchange_s};
}

SensorAbility Stream(int baud) {
  const StreamFormat format;
  return {.name = fmt::format("lines of 9 characters sent without request, {} baud", baud),
          .settings = {{"sensor", "stream"}, {"baud", std::to_string(baud)}},
          .rate_hz = MostLinesPerSecond(format, baud),
          .limit = RateLimit::kWire,
          .resolution_m = MetresPerCount(format),
          .wire_s = 1 / MostLinesPerSecond(format, baud)};
}

SensorAbility Modbus(const SensorProfile& profile) {
  return {.name = fmt::format("{} {}, Modbus", profile.maker, profile.model),
          .settings = {{"sensor", "modbus"}, {"profile", profile.name}},
          .rate_hz = HighestRateHz(profile),
          .limit = RateLimit::kWireAndSensor,
          .resolution_m = profile.resolution_m,
          .noise_rms_m = profile.noise_rms_m,
          .range_min_m = profile.range_min_m,
          .range_max_m = profile.range_max_m,
          .is_polled = true,
          .wire_s = 1 / HighestRateHz(profile),
          .refresh_s = profile.fastest_rate_hz ? 1 / *profile.fastest_rate_hz : 0};
}

}  // namespace

// the amplifier renews its output with each raw sample; steps are those of the DAQ's converter
SensorAbility AnalogOutput(double sampling_s, int averages) {
  SensorAbility sensor = Il030(sampling_s, averages);
  sensor.name = fmt::format("IL-030, analog output and a DAQ, {:g} ms, {} average{}",
                            1e3 * sampling_s, averages, averages == 1 ? "" : "s");
  sensor.settings = {{"sensor", "pipe"}, {"calibration", "FILE"}};
  sensor.rate_hz = 1 / sampling_s;
  sensor.limit = RateLimit::kAmplifierSampling;
  sensor.resolution_m.reset();
  return sensor;
}

std::vector<SensorAbility> KnownSensors() {
  constexpr double kFastest_s = dl_rs1a::kSamplings_s.front();
  std::vector<SensorAbility> sensors{AnalogOutput(kFastest_s, 1), AnalogOutput(kFastest_s, 4),
                                     AnalogOutput(1e-3, 16), DlEn1(), LkG()};
  for (const int baud : dl_rs1a::kBauds) sensors.push_back(DlRs1a(baud));
  for (const int baud : {9600, 115200, 230400, 460800, 921600}) sensors.push_back(Stream(baud));
  for (const SensorProfile& profile : BuiltInProfiles()) sensors.push_back(Modbus(profile));
  return sensors;
}

}  // namespace haptometer::acquire
