#include "tools/acquire/scene_sensor.h"

#include <cmath>
#include <cstdint>
#include <utility>

#include "base/text.h"
#include "sim/sensor_model.h"
#include "tools/played_scene.h"
#include "tools/simulated_channel.h"
#include "trial/sensor_head.h"

namespace haptometer::tools {
namespace {

class SceneSensor final : public acquire::Sensor {
 public:
  SceneSensor(const sim::Scene& scene, const std::string& path)
      : sensor_(*scene.sensor),
        motion_(sim::SensedMotion(scene)),
        rows_(static_cast<std::int64_t>(std::floor(scene.duration_s.value_or(sim::kLongestRunS) *
                                                   sensor_.rate_hz * (1 + 1e-12)))) {
    // one row tells what the others are
    trial::Record record = sim::SimulateRecord(scene, 1 / sensor_.rate_hz);
    header_.timing = trial::Timing::kUniform;
    header_.rate_hz = sensor_.rate_hz;
    header_.channels = {FormatOf(record.channels.front())};
    header_.metadata = std::move(record.metadata);
    header_.metadata.fields["scene"] = Printable(path);
  }

  Result<void> Start(const std::atomic<bool>& /*stop*/) override { return {}; }
  const trial::TrialHeader& header() const override { return header_; }
  std::vector<std::string> Remarks() const override { return remarks; }
  MonotonicNs Begin() override {
    next_ = 0;
    return 0;
  }
  acquire::Outcome Next(acquire::Reading& reading) override {
    if (next_ >= rows_) return acquire::Outcome::kEnd;
    const trial::HeadReading read = trial::ReadingAt(
        sensor_.head, motion_, next_ * sim::SamplesPerReading(sensor_), sensor_.seed);
    reading.index = next_++;
    // as a trial of `simulate`: no number beside what is no measurement
    const double value_m = trial::IsMeasurement(read.status) ? read.value_m : std::nan("");
    reading.samples.assign(1, {RawOf(header_.channels.front(), value_m), read.status});
    return acquire::Outcome::kReading;
  }
  std::uint64_t discarded_bytes() const override { return 0; }

  std::vector<std::string> remarks;

 private:
  sim::Sensor sensor_;
  trial::Displacement motion_;
  std::int64_t rows_;
  std::int64_t next_ = 0;
  trial::TrialHeader header_;
};

}  // namespace

Result<std::unique_ptr<acquire::Sensor>> OpenScene(const std::string& path) {
  auto scene = ReadPlayedScene(path);
  if (!scene) return std::unexpected(scene.error());
  const bool is_ideal = !scene->sensor;
  if (is_ideal) scene->sensor = sim::IdealSensor();
  if (scene->duration_s && *scene->duration_s * scene->sensor->rate_hz < 1) {
    return CannotAnswer(path, "is shorter than one reading of its sensor",
                        "give [run] a longer duration_s");
  }
  auto sensor = std::make_unique<SceneSensor>(*scene, path);
  if (is_ideal) {
    sensor->remarks.emplace_back("no [sensor]: an ideal one on the skin at 10 kHz is assumed");
  }
  return sensor;
}

}  // namespace haptometer::tools
