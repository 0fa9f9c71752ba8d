#include "sim/scene_file.h"

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>

#include "base/input_file.h"
#include "base/toml_table.h"

namespace haptometer::sim {

namespace {

constexpr std::string_view kThisVersion =
    "is not simulated: this version simulates linear scenes with a sine drive and bilateral "
    "contact";

// Values between which every actuator, adapter and skin of this kind lies; beyond them the
// arithmetic, not the mechanics, would be under test.
constexpr double kSmallest = 1e-9;
constexpr double kLargest = 1e9;
constexpr double kLongestRunS = 1e6;
constexpr long long kMostAverages = 65536;

void RefuseUnlessReal(TomlTable& table, std::string_view key, double value) {
  if (value < kSmallest || value > kLargest) {
    table.Refuse(key, fmt::format("{:g} is outside {:g} to {:g}, in which every real scene lies",
                                  value, kSmallest, kLargest));
  }
}

double Positive(TomlTable& table, std::string_view key, Dimension dimension) {
  const double value = table.Require(key, dimension);
  if (!(value > 0)) table.Refuse(key, "must be greater than 0");
  RefuseUnlessReal(table, key, value);
  return value;
}

double NotNegative(TomlTable& table, std::string_view key, Dimension dimension) {
  const double value = table.Require(key, dimension);
  if (value < 0) table.Refuse(key, "must not be negative");
  if (value != 0) RefuseUnlessReal(table, key, value);
  return value;
}

double NotNegativeOr(TomlTable& table, std::string_view key, Dimension dimension, double absent) {
  return table.Has(key) ? NotNegative(table, key, dimension) : absent;
}

// keys of the format that this version cannot honour
void RefuseAll(TomlTable& table, std::initializer_list<std::string_view> keys) {
  for (const std::string_view key : keys) {
    if (table.Has(key)) table.Refuse(key, std::string(kThisVersion));
  }
}

// where a relative path in the scene leads: beside the scene
std::string Beside(const std::string& scene_path, const std::string& path) {
  return (std::filesystem::path(scene_path).parent_path() / path).string();
}

// [actuator]: a built-in by model, a file, or the seven constants
Result<StatedActuator> ReadActuatorTable(TomlTable& table, const std::string& scene_path) {
  const auto model = table.Choice("model", {"thesis-c10-100"});
  const auto file = table.Text("file");
  if (!table.Has("model") && !table.Has("file")) return ReadActuator(table);
  for (const std::string_view key :
       {"moving_mass_kg", "case_mass_kg", "stiffness_n_per_m", "damping_n_s_per_m",
        "force_constant_n_per_a", "resistance_ohm", "inductance_h", "file"}) {
    const bool wanted = key == "file" && !table.Has("model");
    if (table.Has(key) && !wanted) {
      table.Refuse(key, fmt::format("stands beside {}: give one or the other",
                                    table.Has("model") ? "model" : "file"));
    }
  }
  if (auto done = table.Finish(); !done) return std::unexpected(done.error());
  return FindActuator(model ? *model : Beside(scene_path, *file));
}

void RefuseUnrealActuator(TomlTable& table, const Actuator& actuator) {
  RefuseUnlessReal(table, "moving_mass_kg", actuator.moving_mass_kg);
  RefuseUnlessReal(table, "case_mass_kg", actuator.case_mass_kg);
  RefuseUnlessReal(table, "stiffness_n_per_m", actuator.stiffness_n_per_m);
  RefuseUnlessReal(table, "force_constant_n_per_a", actuator.force_constant_n_per_a);
  RefuseUnlessReal(table, "resistance_ohm", actuator.resistance_ohm);
  RefuseUnlessReal(table, "inductance_h", actuator.inductance_h);
  if (actuator.damping_n_s_per_m != 0) {
    RefuseUnlessReal(table, "damping_n_s_per_m", actuator.damping_n_s_per_m);
  }
}

std::optional<Adapter> ReadAdapter(TomlTable* table) {
  if (table == nullptr) return std::nullopt;
  Adapter adapter;
  adapter.motor_side_mass_kg = NotNegative(*table, "motor_side_mass_kg", Dimension::kMass);
  adapter.skin_side_mass_kg = Positive(*table, "skin_side_mass_kg", Dimension::kMass);
  adapter.stiffness_n_per_m = Positive(*table, "stiffness_n_per_m", Dimension::kStiffness);
  adapter.damping_n_s_per_m = NotNegative(*table, "damping_n_s_per_m", Dimension::kDamping);
  return adapter;
}

// skin by the area law; both the law and its range are to be named, because sources differ
Skin ReadSkinUnderArea(TomlTable& table) {
  const double area_m2 = table.Require("contact_area_m2", Dimension::kNone);
  if (!(area_m2 >= kSkinAreaMinM2 && area_m2 <= kSkinAreaMaxM2)) {
    table.Refuse("contact_area_m2", "the law covers 1e-6 to 100e-6 m2");
  }
  const auto law = table.Choice("law", {"power"});
  if (!table.Has("law")) table.Refuse("law", "is missing; the known one is \"power\"");
  const auto range = table.Choice("range", {"text", "table"});
  if (!table.Has("range")) {
    table.Refuse("range", "is missing; \"text\" (600-2000 N/m) or \"table\" (600-1200 N/m)");
  }
  for (const std::string_view key : {"stiffness_n_per_m", "damping_n_s_per_m"}) {
    if (table.Has(key)) table.Refuse(key, "stands beside contact_area_m2: give one or the other");
  }
  if (!table.Finish() || !law || !range) return {};
  return SkinUnderArea(area_m2, *range == "text" ? SkinRange::kText : SkinRange::kTable);
}

Skin ReadSkin(TomlTable& table) {
  if (table.Choice("contact", {"bilateral", "unilateral"}) == "unilateral") {
    table.Refuse("contact", fmt::format("\"unilateral\" {}", kThisVersion));
  }
  RefuseAll(table, {"preload_n"});
  if (table.Has("contact_area_m2")) return ReadSkinUnderArea(table);
  for (const std::string_view key : {"law", "range"}) {
    if (table.Has(key)) table.Refuse(key, "needs contact_area_m2");
  }
  return {.stiffness_n_per_m = NotNegative(table, "stiffness_n_per_m", Dimension::kStiffness),
          .damping_n_s_per_m = NotNegative(table, "damping_n_s_per_m", Dimension::kDamping)};
}

SineDrive ReadDrive(TomlTable& table) {
  const auto kind = table.Text("kind");
  if (!table.Has("kind")) table.Refuse("kind", "is missing; write kind = \"sine\"");
  if (kind && *kind != "sine") {
    table.Refuse("kind", fmt::format("\"{}\" {}", *kind, kThisVersion));
    return {};
  }
  return {.amplitude_v = NotNegative(table, "amplitude_v", Dimension::kVoltage),
          .frequency_hz = Positive(table, "frequency_hz", Dimension::kFrequency)};
}

void ReadRun(TomlTable* table, Scene& scene) {
  if (table == nullptr) return;
  RefuseAll(*table, {"tolerance", "quantity"});
  if (table->Has("duration_s")) {
    scene.duration_s = Positive(*table, "duration_s", Dimension::kTime);
    if (*scene.duration_s > kLongestRunS) {
      table->Refuse("duration_s", fmt::format("is longer than {:g} s", kLongestRunS));
    }
  }
  const auto start = table->Choice("start", {"rest", "steady"});
  const bool rest = start ? *start == "rest" : scene.duration_s.has_value();
  scene.start = rest ? Start::kRest : Start::kSteady;
}

trial::SensorHead HeadOfKind(const std::string& kind) {
  if (kind == "il-030") return trial::Il030();
  if (kind == "stream") return trial::Stream10kHz();
  return IdealSensor().head;
}

// The numbers that a scene may set over those of its kind. An ideal sensor samples when it reads.
void ReadHead(TomlTable& table, const std::string& kind, Sensor& sensor) {
  trial::SensorHead& head = sensor.head;
  const bool given = table.Has("sampling_s");
  if (given) head.sampling_s = Positive(table, "sampling_s", Dimension::kTime);
  if (table.Has("rate_hz")) {
    sensor.rate_hz = Positive(table, "rate_hz", Dimension::kFrequency);
    if (kind == "ideal" && !given) head.sampling_s = 1 / sensor.rate_hz;
  } else {
    sensor.rate_hz = 1 / head.sampling_s;
  }
  const double samples_a_reading = 1 / (sensor.rate_hz * head.sampling_s);
  if (!(samples_a_reading > 0.5) ||
      std::abs(samples_a_reading - std::round(samples_a_reading)) > 1e-9 * samples_a_reading) {
    table.Refuse("rate_hz", fmt::format("must be 1/sampling_s = {:g} Hz divided by a whole number",
                                        1 / head.sampling_s));
  }
  if (const auto averages = table.Integer("averages")) {
    if (*averages < 1 || *averages > kMostAverages) {
      table.Refuse("averages", fmt::format("must be 1 to {}", kMostAverages));
    } else {
      head.averages = static_cast<int>(*averages);
    }
  }
  head.resolution_m = NotNegativeOr(table, "resolution_m", Dimension::kLength, head.resolution_m);
  head.noise_rms_m = NotNegativeOr(table, "noise_rms_m", Dimension::kLength, head.noise_rms_m);
  if (table.Has("range_m")) {
    head.range_max_m = Positive(table, "range_m", Dimension::kLength);
    head.range_min_m = -head.range_max_m;
  }
}

std::optional<Sensor> ReadSensor(TomlTable* table) {
  if (table == nullptr) return std::nullopt;
  const auto kind = table->Choice("kind", {"ideal", "il-030", "stream"});
  if (!table->Has("kind")) {
    table->Refuse("kind", "is missing; \"ideal\", \"il-030\" or \"stream\"");
  }
  Sensor sensor;
  sensor.head = HeadOfKind(kind.value_or("ideal"));
  ReadHead(*table, kind.value_or("ideal"), sensor);
  const auto target = table->Choice("target", {"skin", "case", "mover"});
  sensor.target = target == "case"    ? SensorTarget::kCase
                  : target == "mover" ? SensorTarget::kMover
                                      : SensorTarget::kSkin;
  sensor.latency_s = NotNegativeOr(*table, "latency_s", Dimension::kTime, 0);
  if (const auto seed = table->Integer("seed")) {
    if (*seed < 0) table->Refuse("seed", "must not be negative");
    sensor.seed = static_cast<std::uint64_t>(*seed);
  }
  return sensor;
}

// an effect that is off is what this version simulates, and so is the coil's inductance
void ReadEffects(TomlTable& root) {
  if (root.KindOf("effects") == TomlKind::kText) {
    root.Refuse("effects", fmt::format("\"auto\" {}", kThisVersion));
    return;
  }
  TomlTable* effects = root.Table("effects");
  if (effects == nullptr) return;
  for (const std::string_view key : {"gravity", "travel_stops", "stiffening", "contact_loss",
                                     "tremor", "coil_heating", "inductance"}) {
    const TomlKind kind = effects->KindOf(key);
    if (kind == TomlKind::kAbsent) continue;
    const bool simulated = key == "inductance";
    if (kind == TomlKind::kFlag && effects->Flag(key) == simulated) continue;
    effects->Refuse(key, simulated ? "stays on in this version: write true or leave it out"
                                   : std::string(kThisVersion));
  }
}

// a table that every scene needs; an empty one stands in, so that reading goes on to Finish()
TomlTable* RequireTable(TomlTable& root, std::string_view key) {
  if (!root.Has(key)) root.Refuse(key, fmt::format("is missing; add a table [{}]", key));
  return root.Table(key);
}

}  // namespace

Result<Scene> ReadSceneText(std::string_view text, const std::string& where) {
  auto root = TomlTable::ParseText(text, where);
  if (!root) return std::unexpected(root.error());
  TomlTable* actuator_table = RequireTable(*root, "actuator");
  TomlTable* skin_table = RequireTable(*root, "skin");
  TomlTable* drive_table = RequireTable(*root, "drive");
  RefuseAll(*root, {"mounting"});

  Scene scene;
  scene.adapter = ReadAdapter(root->Table("adapter"));
  if (skin_table != nullptr) scene.skin = ReadSkin(*skin_table);
  if (drive_table != nullptr) scene.drive = ReadDrive(*drive_table);
  ReadRun(root->Table("run"), scene);
  scene.sensor = ReadSensor(root->Table("sensor"));
  ReadEffects(*root);

  // the actuator last: it may lie in a file of its own, which speaks for itself
  Result<StatedActuator> stated = StatedActuator{};
  if (actuator_table != nullptr) stated = ReadActuatorTable(*actuator_table, where);
  if (auto done = root->Finish(); !done) return std::unexpected(done.error());
  if (!stated) return std::unexpected(stated.error());
  const auto actuator = Complete(*stated);
  if (!actuator) return std::unexpected(actuator.error());
  RefuseUnrealActuator(*actuator_table, *actuator);
  if (auto done = root->Finish(); !done) return std::unexpected(done.error());
  scene.actuator = *actuator;
  return scene;
}

Result<Scene> ReadSceneFile(const std::string& path) {
  const auto text = ReadInputFile(path, 1ULL << 20);
  if (!text) return std::unexpected(text.error());
  return ReadSceneText(*text, path);
}

}  // namespace haptometer::sim
