#include "tools/acquire/advise.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <tuple>

#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/protocol/wire.h"
#include "base/band.h"
#include "base/error.h"
#include "dsp/analysis/decision_limits.h"
#include "dsp/filter/transient.h"
#include "dsp/readings/digitisation.h"
#include "trial/sensor_head.h"

namespace haptometer::tools {
namespace {

using acquire::FindingKind;
using acquire::SensorAbility;

// the least length that is promised, and what filter transients take at both ends of order 6
constexpr double kLeastPeriods = 40;
constexpr double kTransientPeriods = 12;
// What lies beside the drive is known as from a record of this length: bins of a part, 128, over
// 2.08 c = 4.16 times the width about a drive (dsp/analysis/band_noise.cc, BeyondNoise)
constexpr double kBesideS = 128 / (4.16 * 2 * dsp::kDriveReachHz);
// Where the drive and its harmonics cover more of the band than this, nothing beside them tells its
// noise
constexpr double kMostCovered = 0.8;
// an image below this part of the drive's amplitude adds 5e-5 to the RMS
constexpr double kLeastImage = 0.01;
// an output that is held is described to `acquire` as a mean of so many samples
constexpr int kHeldSamples = 100;

double Sinc(double x) {
  return x == 0 ? 1 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
}

bool IsAnalog(const SensorAbility& sensor) {
  return sensor.limit == acquire::RateLimit::kAmplifierSampling;
}

// share of the band that lies as near to the drive and its harmonics as to be taken for them
double ShareOfDrive(const RouteQuestion& question) {
  double width_hz = 0;
  for (int order = 1; order * question.drive_hz - dsp::kDriveReachHz < question.upper_hz; ++order) {
    const double from_hz =
        std::max(order * question.drive_hz - dsp::kDriveReachHz, question.lower_hz);
    const double to_hz =
        std::min(order * question.drive_hz + dsp::kDriveReachHz, question.upper_hz);
    width_hz += std::max(0.0, to_hz - from_hz);
  }
  return std::min(1.0, width_hz / (question.upper_hz - question.lower_hz));
}

// a sensor that is asked this question, and what the two come to
struct Considered {
  const RouteQuestion& question;
  const SensorAbility& sensor;
  Route route;
  acquire::NoiseInBand noise{};  // referred to the motion, of record_s still unknown
  bool noise_is_known = true;
  // relative standard uncertainties that no length changes
  double steps = 0;
  double ends = 0;
  double edges_s = 0;  // over the window's length: of the drive's edges

  [[nodiscard]] double calibration() const { return question.calibration.value_or(0); }
  [[nodiscard]] double fixed() const { return std::hypot(steps, ends, calibration()); }
};

// rate of the readings, with what an analog output's images do at it
void AddRate(Considered& of) {
  const SensorAbility& sensor = of.sensor;
  of.route.rate_hz = sensor.rate_hz;
  if (!IsAnalog(sensor)) return;
  const RouteQuestion& question = of.question;
  acquire::HeldOutput held{.sampling_s = sensor.sampling_s,
                           .frequency_hz = question.drive_hz,
                           .daq_rate_hz = question.daq_rate_hz.value_or(0)};
  // a rate at least as high as the amplifier's loses none of its samples
  const double least_hz = std::max(sensor.rate_hz, NeededRateHz(question.upper_hz));
  const double unfolded_hz =
      acquire::UnfoldedRateHz(held, question.lower_hz, question.upper_hz, kLeastImage, least_hz);
  if (!question.daq_rate_hz) held.daq_rate_hz = unfolded_hz;
  of.route.rate_hz = held.daq_rate_hz;
  of.route.images = acquire::ImagesInBand(held, question.lower_hz, question.upper_hz, kLeastImage);
  if (!of.route.images.empty()) of.route.better_daq_rate_hz = unfolded_hz;
}

// of averaging, and of the hold behind it
double GainAt(const SensorAbility& sensor, double frequency_hz) {
  if (IsAnalog(sensor)) return std::abs(Sinc(frequency_hz * sensor.averages * sensor.sampling_s));
  if (sensor.averages == 1) return 1;
  return trial::AveragingGain(frequency_hz, sensor.sampling_s, sensor.averages);
}

// gain at the drive, latency, and what the age of a polled value takes off
void AddTimes(Considered& of) {
  const SensorAbility& sensor = of.sensor;
  const double drive_hz = of.question.drive_hz;
  Route& route = of.route;
  route.gain = GainAt(sensor, drive_hz);
  if (IsAnalog(sensor)) {
    route.latency_s = 0.5 * sensor.averages * sensor.sampling_s;
    return;
  }
  route.latency_s =
      0.5 * (sensor.averages - 1) * sensor.sampling_s + 0.5 * sensor.refresh_s + sensor.wire_s;
  if (sensor.is_polled) route.unseen = 1 - std::abs(Sinc(drive_hz * sensor.refresh_s));
}

// noise and steps, referred to the motion by the gain at the drive
void AddNoise(Considered& of) {
  const auto& [question, sensor] = std::tie(of.question, of.sensor);
  const double width_hz = question.upper_hz - question.lower_hz;
  const auto noise_m = sensor.noise_rms_m ? sensor.noise_rms_m : question.noise_rms_m;
  of.noise_is_known = noise_m.has_value();
  const double step_m = sensor.resolution_m.value_or(0);
  const double span_s = sensor.averages * sensor.sampling_s;
  const double density =
      acquire::NoiseDensity({of.route.rate_hz, noise_m.value_or(0), span_s}, question.drive_hz) +
      step_m * step_m / 6 / of.route.rate_hz;  // step^2 / 12 over half the rate
  const double share = ShareOfDrive(question);
  of.route.needs_floor = share > kMostCovered;
  of.noise = {.rms_m = std::sqrt(density * width_hz) / of.route.gain,
              .bandwidth_hz = width_hz,
              .record_s = 1,
              .noise_record_s = kBesideS / share,
              .own_share = share};
  // a floor's record as long: its noise scatters as much again
  if (of.route.needs_floor) {
    of.noise.noise_record_s = std::numeric_limits<double>::infinity();
    of.noise.own_share = 2;
  }
  // half widths of rectangles, as parts of the RMS as measured; noise raises that over the motion's
  const double measured_m = of.route.gain * question.rms_m;
  const double raised = 1 + std::pow(of.noise.rms_m / question.rms_m, 2);
  // noise that analyze does not see beside the drive does not count as smoothing the steps
  const double smoothing_m = of.route.needs_floor ? 0 : noise_m.value_or(0);
  of.steps = dsp::QuantisationBound(step_m, measured_m * std::numbers::sqrt2, smoothing_m,
                                    static_cast<int>(question.upper_hz / question.drive_hz)) /
             measured_m * std::sqrt(raised) / std::numbers::sqrt3;
  of.ends = dsp::kSettledError * raised / std::numbers::sqrt3;
  // a window shorter by a period of the lower corner at each end holds no whole periods: its mean
  // square is off by sin(w t) / (w T) times the cosine of a phase, the RMS by half of that
  const double turn = 2 * std::numbers::pi * question.drive_hz;
  of.edges_s = std::abs(std::sin(2 * turn / question.lower_hz)) / (2 * turn) / std::sqrt(6);
}

// what keeps it from answering at any length, before accuracy is asked for
std::optional<acquire::Finding> ObstacleOf(Considered& of) {
  const auto& [question, sensor, route] = std::tie(of.question, of.sensor, of.route);
  const double new_hz = std::min(sensor.rate_hz, route.rate_hz);
  if (!Observes(new_hz, question.upper_hz)) {
    of.route.limited_by = IsAnalog(sensor) ? RouteLimit::kSampling : RouteLimit::kWire;
    return acquire::Finding{.kind = FindingKind::kRateTooLow,
                            .numbers = {{"rate_hz", new_hz},
                                        {"observable_hz", HighestObservableHz(new_hz)},
                                        {"asked_hz", question.upper_hz},
                                        {"needed_hz", NeededRateHz(question.upper_hz)}}};
  }
  const double gain_at_upper = GainAt(sensor, question.upper_hz);
  if (gain_at_upper < acquire::kLeastGain) {
    of.route.limited_by = RouteLimit::kAveraging;
    return acquire::Finding{.kind = FindingKind::kAveragingTooLong,
                            .numbers = {{"averages", sensor.averages},
                                        {"sampling_s", sensor.sampling_s},
                                        {"gain", gain_at_upper},
                                        {"asked_hz", question.upper_hz}}};
  }
  // anywhere between request and reply: sqrt((reply - request)^2 / 12), as trial/time_base.h
  const double time_s = sensor.is_polled ? sensor.wire_s / std::sqrt(12) : 0;
  const double limit_s = dsp::kTimeUncertaintyPeriods / question.upper_hz;
  if (time_s >= limit_s) {
    of.route.limited_by = RouteLimit::kAge;
    return acquire::Finding{
        .kind = FindingKind::kReadingsTooOld,
        .numbers = {
            {"uncertainty_s", time_s}, {"upper_hz", question.upper_hz}, {"limit_s", limit_s}}};
  }
  return std::nullopt;
}

// the largest of the standard uncertainties, with that of the noise
RouteLimit LargestPart(const Considered& of, double noise) {
  const std::array<std::pair<double, RouteLimit>, 5> parts{
      {{noise, RouteLimit::kNoise},
       {of.steps, RouteLimit::kSteps},
       {of.ends, RouteLimit::kFilterEnds},
       {of.calibration(), RouteLimit::kCalibration},
       {of.route.unseen / kRouteCoverage, RouteLimit::kAge}}};
  return std::ranges::max_element(parts, {}, [](const auto& part) { return part.first; })->second;
}

// of the noise after an endless record
double EndlessNoise(const acquire::NoiseInBand& noise, double rms_m) {
  const double q = std::pow(rms_m / noise.rms_m, 2);
  return 1 / std::sqrt(4 * noise.bandwidth_hz * noise.noise_record_s) / q;
}

// The filtered length at which noise and edges together have the relative variance `left`; nothing
// where the noise alone never has. The edges' part is taken at the length for the noise, which is
// shorter, and is given half of the variance at most.
std::optional<double> WindowFor(const Considered& of, double left) {
  const auto for_noise = [&](double variance) -> std::optional<double> {
    if (!(of.noise.rms_m > 0)) return 0;
    return acquire::RecordLength(of.noise, of.question.rms_m, std::sqrt(variance));
  };
  const auto first_s = for_noise(left);
  if (!first_s) return std::nullopt;
  const double window_s = std::max(*first_s, kLeastPeriods / of.question.lower_hz);
  const double edges = std::pow(of.edges_s / window_s, 2);
  if (edges <= 0.5 * left) return for_noise(left - edges);
  const auto half_s = for_noise(0.5 * left);
  if (!half_s) return std::nullopt;
  return std::max(*half_s, of.edges_s / std::sqrt(0.5 * left));
}

// the length for the accuracy, with the interval at it; or the floor that is above it
void AddLength(Considered& of) {
  const RouteQuestion& question = of.question;
  Route& route = of.route;
  const double endless = of.noise.rms_m > 0 ? EndlessNoise(of.noise, question.rms_m) : 0;
  route.floor = std::hypot(kRouteCoverage * std::hypot(of.fixed(), endless), route.unseen);
  // what is left for what a length improves
  const double left =
      (std::pow(question.accuracy, 2) - std::pow(route.unseen, 2)) / std::pow(kRouteCoverage, 2) -
      std::pow(of.fixed(), 2);
  const std::optional<double> window_s = left > 0 ? WindowFor(of, left) : std::nullopt;
  if (!window_s) {
    route.limited_by = LargestPart(of, endless);
    route.reason = {.kind = FindingKind::kFloorTooHigh,
                    .numbers = {{"half_interval", *route.floor}, {"accuracy", question.accuracy}}};
    return;
  }
  // at least the shortest window; transients at both ends; to 0.1 s, up
  const double transient_s = kTransientPeriods / question.lower_hz;
  const double least_s = kLeastPeriods / question.lower_hz;
  const double record_s = std::ceil(10 * (std::max(*window_s, least_s) + transient_s)) / 10;
  of.noise.record_s = record_s - transient_s;
  const double noise =
      of.noise.rms_m > 0 ? acquire::RelativeUncertaintyOf(of.noise, question.rms_m) : 0;
  route.answers = true;
  route.limited_by = *window_s < least_s ? RouteLimit::kShortestWindow : LargestPart(of, noise);
  route.record_s = record_s;
  route.predicted_relative_uncertainty =
      kRouteCoverage * std::hypot(noise, of.fixed(), of.edges_s / of.noise.record_s);
  route.reason = {.kind = FindingKind::kRouteAnswers,
                  .numbers = {{"record_s", record_s},
                              {"half_interval", *route.predicted_relative_uncertainty}}};
}

// without the noise there is no length
void AddAnswer(Considered& of) {
  AddLength(of);
  if (of.noise_is_known || !of.route.answers) return;
  of.route.record_s.reset();
  of.route.predicted_relative_uncertainty.reset();
  of.route.limited_by = RouteLimit::kNoise;
  of.route.reason = {.kind = FindingKind::kNoiseNotStated};
}

// what an output that is held is to `acquire`: samples of the DAQ, and a mean of many
void AddPipeSettings(Considered& of) {
  const double part_s = of.sensor.averages * of.sensor.sampling_s / kHeldSamples;
  of.route.settings = {{"sensor", "pipe"},
                       {"format", "f64"},
                       {"rate", fmt::format("{:g}Hz", of.route.rate_hz)},
                       {"channels", "displacement:V"},
                       {"calibration", "FILE"},
                       {"averaging", std::to_string(kHeldSamples)},
                       {"sampling", fmt::format("{:g}ms", 1e3 * part_s)}};
}

Route RouteOf(const SensorAbility& sensor, const RouteQuestion& question) {
  Considered of{.question = question, .sensor = sensor, .route = {}};
  of.route.name = sensor.name;
  of.route.settings = sensor.settings;
  AddRate(of);
  AddTimes(of);
  AddNoise(of);
  if (IsAnalog(sensor)) AddPipeSettings(of);
  if (auto obstacle = ObstacleOf(of)) {
    of.route.reason = *std::move(obstacle);
  } else {
    AddAnswer(of);
  }
  return std::move(of.route);
}

// those that answer first, then shorter records (unknown ones last), then latency, then name
bool IsBefore(const Route& a, const Route& b) {
  const auto key = [](const Route& route) {
    return std::tuple(!route.answers, !route.record_s, route.record_s.value_or(0),
                      route.answers ? route.latency_s : -route.rate_hz,
                      std::string_view(route.name));
  };
  return key(a) < key(b);
}

// the averagings that an IL amplifier is set to, as sensors of their own
std::vector<SensorAbility> Averagings(const SensorAbility& polled) {
  std::vector<SensorAbility> all;
  for (const double sampling_s : std::span(acquire::dl_rs1a::kSamplings_s).first(2)) {
    for (const int averages : {1, 2, 4, 8, 16, 32, 64}) {
      SensorAbility sensor = polled;
      sensor.sampling_s = sampling_s;
      sensor.averages = averages;
      sensor.noise_rms_m = trial::Il030().noise_rms_m / std::sqrt(averages);
      sensor.settings.emplace_back("set", fmt::format("sampling={:g}ms", 1e3 * sampling_s));
      sensor.settings.emplace_back("set", fmt::format("averaging={}", averages));
      all.push_back(std::move(sensor));
    }
  }
  return all;
}

Route BestOf(const std::vector<SensorAbility>& sensors, const RouteQuestion& question) {
  std::vector<Route> routes;
  routes.reserve(sensors.size());
  for (const SensorAbility& sensor : sensors) routes.push_back(RouteOf(sensor, question));
  return *std::ranges::min_element(routes, IsBefore);
}

}  // namespace

std::vector<Route> AdviseRoutes(const RouteQuestion& question) {
  HAPTOMETER_CHECK(question.lower_hz > 0 && question.lower_hz <= question.drive_hz &&
                       question.drive_hz <= question.upper_hz &&
                       question.lower_hz < question.upper_hz,
                   "{} Hz in {} to {} Hz", question.drive_hz, question.lower_hz, question.upper_hz);
  HAPTOMETER_CHECK(question.rms_m > 0 && question.accuracy > 0, "{} m to {}", question.rms_m,
                   question.accuracy);
  std::vector<Route> routes;
  for (const SensorAbility& sensor : acquire::KnownSensors()) {
    if (IsAnalog(sensor)) continue;
    const bool is_il = sensor.averages > 1;
    routes.push_back(is_il ? BestOf(Averagings(sensor), question) : RouteOf(sensor, question));
  }
  // the analog output in all of the averagings that leave anything of a vibration
  for (const int averages : {1, 2, 4, 8, 16}) {
    routes.push_back(
        RouteOf(acquire::AnalogOutput(acquire::dl_rs1a::kSamplings_s.front(), averages), question));
  }
  routes.push_back(RouteOf(acquire::AnalogOutput(1e-3, 16), question));
  std::ranges::sort(routes, IsBefore);
  return routes;
}

}  // namespace haptometer::tools
