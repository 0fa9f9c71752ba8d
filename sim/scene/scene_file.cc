#include "sim/scene/scene_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "sim/effective_scene.h"

namespace haptometer::sim {

void RefuseUnlessReal(TomlTable& table, std::string_view key, double value) {
  if (value < kSmallest || value > kLargest) {
    table.Refuse(key,
                 fmt::format("{:g} is outside {:g} to {:g}, where all scenes lie", value, kSmallest,
                             kLargest),
                 "check its unit");
  }
}

double Positive(TomlTable& table, std::string_view key, Dimension dimension) {
  const double value = table.Require(key, dimension);
  if (!(value > 0)) table.Refuse(key, "must be greater than 0", "check its sign");
  RefuseUnlessReal(table, key, value);
  return value;
}

double NotNegative(TomlTable& table, std::string_view key, Dimension dimension) {
  const double value = table.Require(key, dimension);
  if (value < 0) table.Refuse(key, "must not be negative", "check its sign");
  if (value != 0) RefuseUnlessReal(table, key, value);
  return value;
}

double Signed(TomlTable& table, std::string_view key, Dimension dimension) {
  const double value = table.Number(key, dimension).value_or(0);
  if (value != 0) RefuseUnlessReal(table, key, std::abs(value));
  return value;
}

double NotNegativeOr(TomlTable& table, std::string_view key, Dimension dimension, double absent) {
  return table.Has(key) ? NotNegative(table, key, dimension) : absent;
}

void RefuseKeysOfOtherKinds(TomlTable& table, std::span<const KeyOfKinds> keys,
                            std::string_view kind) {
  const std::string quoted = fmt::format("\"{}\"", kind);
  for (const auto& [key, kinds] : keys) {
    if (kinds.contains(quoted) || !table.Has(key)) continue;
    table.Refuse(key, fmt::format("belongs to kind = {}, and kind is {}", kinds, quoted),
                 "remove it, or change kind");
  }
}

namespace {

constexpr long long kMostAverages = 65536;

// a relative path in a scene begins at the scene's folder
std::string Beside(const std::string& scene_path, const std::string& path) {
  return (std::filesystem::path(scene_path).parent_path() / path).string();
}

// [actuator]: a built-in by model, a file, or the seven constants
Result<StatedActuator> ReadActuatorTable(TomlTable& table, const std::string& scene_path) {
  const auto model = table.Choice("model", {"thesis-c10-100"});
  const auto file = table.Text("file");
  if (!table.Has("model") && !table.Has("file")) return ReadActuator(table);
  // a model excludes a file, and either excludes the seven constants
  const std::string_view other = table.Has("model") ? "model" : "file";
  const auto refuse = [&](std::string_view key) {
    if (!table.Has(key) || key == other) return;
    table.Refuse(key, fmt::format("cannot be combined with {}", other), "give one or the other");
  };
  std::ranges::for_each(kActuatorKeys, refuse);
  refuse("file");
  HAPTOMETER_TRY(table.Finish());
  return FindActuator(model ? *model : Beside(scene_path, *file));
}

// limits of an actuator's numbers, also of one from a file; inductance and damping may be 0
void RefuseUnrealActuator(TomlTable& table, const Actuator& actuator) {
  for (std::size_t k = 0; k < kActuatorKeys.size(); ++k) {
    const double number = actuator.*kActuatorNumbers[k];
    const bool may_be_0 =
        kActuatorKeys[k] == "damping_n_s_per_m" || kActuatorKeys[k] == "inductance_h";
    if (number != 0 || !may_be_0) RefuseUnlessReal(table, kActuatorKeys[k], number);
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
  const double area_m2 = table.Require("contact_area_m2", Dimension::kArea);
  if (!(area_m2 >= kSkinAreaMinM2 && area_m2 <= kSkinAreaMaxM2)) {
    table.Refuse("contact_area_m2", "is outside the law's 1e-6 to 100e-6 m2",
                 "give stiffness_n_per_m and damping_n_s_per_m instead");
  }
  const auto law = table.Choice("law", {"power"});
  if (!table.Has("law")) table.Refuse("law", "is missing", "write law = \"power\"");
  const auto range = table.Choice("range", {"text", "table"});
  if (!table.Has("range")) {
    table.Refuse("range", "is missing", "\"text\" (600-2000 N/m) or \"table\" (600-1200 N/m)");
  }
  for (const std::string_view key : {"stiffness_n_per_m", "damping_n_s_per_m"}) {
    if (table.Has(key)) {
      table.Refuse(key, "cannot be combined with contact_area_m2", "give one or the other");
    }
  }
  if (!table.Finish() || !law || !range) return {};
  return SkinUnderArea(area_m2, *range == "text" ? SkinRange::kText : SkinRange::kTable);
}

Skin ReadSkin(TomlTable& table) {
  if (table.Has("contact_area_m2")) return ReadSkinUnderArea(table);
  for (const std::string_view key : {"law", "range"}) {
    if (table.Has(key)) table.Refuse(key, "needs contact_area_m2", "add it or remove this");
  }
  return {.stiffness_n_per_m = NotNegative(table, "stiffness_n_per_m", Dimension::kStiffness),
          .damping_n_s_per_m = NotNegative(table, "damping_n_s_per_m", Dimension::kDamping)};
}

// the state at t = 0; of a held case only the mover's
void ReadStart(TomlTable& table, Scene& scene) {
  InitialState& initial = scene.initial;
  const auto length = [&](std::string_view key) { return Signed(table, key, Dimension::kLength); };
  const auto speed = [&](std::string_view key) { return Signed(table, key, Dimension::kNone); };
  initial.mover_m = length("mover_m");
  // added to the speed that a drop's impact gives the mover
  initial.mover_m_per_s += speed("mover_m_per_s");
  initial.case_m = length("case_m");
  initial.case_m_per_s = speed("case_m_per_s");
  initial.skin_m = length("skin_m");
  initial.skin_m_per_s = speed("skin_m_per_s");
  initial.current_a = Signed(table, "current_a", Dimension::kNone);
  for (const std::string_view key : {"case_m", "case_m_per_s"}) {
    if (!scene.grip.holds || !table.Has(key)) continue;
    table.Refuse(key, "applies to a moving case, and [mounting] holds it", "remove one of the two");
  }
  for (const std::string_view key : {"skin_m", "skin_m_per_s"}) {
    if (scene.adapter || !table.Has(key)) continue;
    table.Refuse(key, "needs an [adapter]: without one the case is on the skin",
                 "give case_m and case_m_per_s");
  }
  // a steady motion has its own state at t = 0
  if (scene.start != Start::kSteady) return;
  table.Refuse("mover_m", "cannot be combined with start = \"steady\" in [run]",
               "remove one of the two");
}

// no motion can begin beyond a stop
void RefuseStartBeyondStops(TomlTable& root, const Scene& scene) {
  TomlTable* table = root.Table("start");
  if (table == nullptr || scene.effects[Effect::kTravelStops] == Wish::kOff) return;
  const TravelStops& stops = *scene.effects.travel_stops;
  const bool gravity = scene.effects[Effect::kGravity] != Wish::kOff;
  // a stated position counts from where the mover rests, a gap from the unloaded spring
  const double sag_m = MoverSag(scene, gravity, scene.effects[Effect::kStiffening] != Wish::kOff);
  const double travel_m = scene.initial.mover_m - scene.initial.case_m + sag_m;
  if (travel_m <= stops.gap_up_m && -travel_m <= stops.gap_down_m) return;
  table->Refuse(
      "mover_m",
      fmt::format("puts the mover {:.4g} um from where its spring is unloaded, beyond a stop",
                  travel_m * 1e6),
      "it is measured from where the mover rests");
}

// a current is a state of a coil with inductance only
void RefuseCurrentWithoutInductance(TomlTable& root, const Scene& scene) {
  TomlTable* table = root.Table("start");
  if (table == nullptr || !table->Has("current_a")) return;
  const bool is_off = scene.effects[Effect::kInductance] == Wish::kOff;
  if (!is_off && scene.actuator.inductance_h > 0) return;
  table->Refuse("current_a",
                is_off ? "needs an inductance, which [effects] turns off"
                       : "needs an inductance, and inductance_h is 0",
                "remove it: the current follows the voltage at once");
}

// an adapter on a held case would not move, and a skin under it would not be pressed
void RefuseBesideHeldCase(TomlTable& root, TomlTable& skin, const Scene& scene) {
  if (!scene.grip.holds) return;
  if (scene.adapter) {
    root.Table("mounting")
        ->Refuse("kind", "holds the case, and an adapter would not move",
                 "remove [adapter], or hold the case by a grip");
  }
  if (scene.effects[Effect::kContactLoss] != Wish::kOff) {
    skin.Refuse("preload_n", "presses on a skin that a held case does not move",
                "leave contact_loss out");
  }
}

void ReadDemand(TomlTable& table, Scene& scene) {
  if (table.Has("tolerance")) {
    scene.tolerance = table.Require("tolerance", Dimension::kNone);
    if (!(scene.tolerance >= kLeastTolerance && scene.tolerance < 1)) {
      table.Refuse("tolerance", fmt::format("is not {:g} or more and below 1", kLeastTolerance),
                   "it is relative: 1e-3 asks for three digits");
    }
  }
  const std::vector<std::string> names(kAskedQuantityNames.begin(), kAskedQuantityNames.end());
  if (const auto quantity = table.Choice("quantity", names)) {
    scene.quantity =
        static_cast<AskedQuantity>(std::ranges::find(names, *quantity) - names.begin());
  }
}

void ReadRun(TomlTable* table, Scene& scene) {
  if (table == nullptr) return;
  ReadDemand(*table, scene);
  if (table->Has("duration_s")) {
    scene.duration_s = Positive(*table, "duration_s", Dimension::kTime);
    if (*scene.duration_s > kLongestRunS) {
      table->Refuse("duration_s", fmt::format("is longer than {:g} s", kLongestRunS),
                    "leave it out for the steady state");
    }
  }
  const auto start = table->Choice("start", {"rest", "steady"});
  if (!start) return;
  scene.start = *start == "rest" ? Start::kRest : Start::kSteady;
  // a drive that ends has no steady motion
  if (*scene.start == Start::kRest || IsLasting(scene.drive)) return;
  table->Refuse("start",
                fmt::format("\"steady\" applies to continuous drives, and kind = \"{}\" ends",
                            Name(scene.drive.kind)),
                "write start = \"rest\"");
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
  // samples from one reading to the next; a whole number, so that readings fall on samples
  const double samples_a_reading = 1 / (sensor.rate_hz * head.sampling_s);
  if (!(samples_a_reading > 0.5) ||
      std::abs(samples_a_reading - std::round(samples_a_reading)) > 1e-9 * samples_a_reading) {
    table.Refuse(
        "rate_hz",
        fmt::format("is not 1/sampling_s = {:g} Hz divided by a whole number", 1 / head.sampling_s),
        "change one of the two");
  }
  if (const auto averages = table.Integer("averages")) {
    if (*averages < 1 || *averages > kMostAverages) {
      table.Refuse("averages", fmt::format("is not 1 to {}", kMostAverages), "check it");
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
    table->Refuse("kind", "is missing", "\"ideal\", \"il-030\" or \"stream\"");
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
    if (*seed < 0) table->Refuse("seed", "must not be negative", "check its sign");
    sensor.seed = static_cast<std::uint64_t>(*seed);
  }
  return sensor;
}

// weight or a preload may lift the bodies off the skin before anything moves
void RefuseImpossibleRest(TomlTable& actuator, TomlTable& skin, const Scene& scene) {
  if (scene.mover_preload_n != 0 && !IsHeldInPlace(scene)) {
    actuator.Refuse("preload_n", "pushes bodies that nothing holds in their place",
                    "give [skin] a stiffness, or hold the case in [mounting]");
  }
  const bool breaks = scene.effects[Effect::kContactLoss] != Wish::kOff;
  if (breaks && scene.skin.stiffness_n_per_m == 0 && scene.skin.damping_n_s_per_m == 0) {
    skin.Refuse("preload_n", "presses on a skin without stiffness and damping",
                "give it one of them");
  }
  const bool gravity = scene.effects[Effect::kGravity] != Wish::kOff;
  if (!breaks || !(gravity || scene.mover_preload_n != 0)) return;
  if (scene.grip.stiffness_n_per_m > 0) {
    skin.Refuse(
        "preload_n",
        fmt::format("is given with {} and a grip, which carries part of {}",
                    gravity ? "gravity" : "the mover's preload", gravity ? "the weight" : "it"),
        gravity ? "leave gravity out and give the whole preload" : "leave one of the two out");
  }
  // N, positive towards the skin
  const double press_n = PressOnSkin(scene, gravity);
  if (!(scene.effects.contact_loss->preload_n + press_n > 0)) {
    skin.Refuse("preload_n",
                scene.mover_preload_n == 0
                    ? fmt::format("does not carry the bodies' {:.3g} N of weight", -press_n)
                    : fmt::format("does not carry the {:.3g} N that pull the bodies", -press_n),
                "they would fall off the skin");
  }
}

}  // namespace

Result<Scene> ReadSceneText(std::string_view text, const std::string& where) {
  HAPTOMETER_LET(auto root, TomlTable::ParseText(text, where));
  if (root.Has("moving_mass_kg")) {
    return Usage(where, "is an actuator, and no scene",
                 fmt::format("name it in a scene, in its table [actuator]: file = \"{}\"", where));
  }
  TomlTable* actuator_table = root.Table("actuator");
  TomlTable* skin_table = root.Table("skin");
  TomlTable* drive_table = root.Table("drive");

  Scene scene;
  Result<StatedActuator> stated = StatedActuator{};
  if (actuator_table != nullptr) {
    scene.mover_preload_n = Signed(*actuator_table, "preload_n", Dimension::kNone);
    stated = ReadActuatorTable(*actuator_table, where);
  }
  scene.adapter = ReadAdapter(root.Table("adapter"));
  scene.effects = ReadEffects(root, skin_table);
  if (skin_table != nullptr) scene.skin = ReadSkin(*skin_table);
  if (drive_table != nullptr) scene.drive = ReadDrive(*drive_table, where);
  ReadRun(root.Table("run"), scene);
  scene.sensor = ReadSensor(root.Table("sensor"));
  const Mounting mounting = ReadMounting(root.Table("mounting"));
  scene.grip = mounting.grip;
  // a drop begins with the impact's speed; [start] adds to it
  scene.initial.mover_m_per_s = mounting.blow_m_per_s;
  if (TomlTable* start = root.Table("start")) ReadStart(*start, scene);
  if (TomlTable* tremor = root.Table("tremor")) scene.finger = ReadFingerMotion(*tremor);

  // a misspelt key explains a missing table, so missing tables are reported last
  HAPTOMETER_TRY(root.Finish());
  for (const std::string_view key : {"actuator", "skin", "drive"}) {
    if (!root.Has(key)) {
      return Usage(where, fmt::format("has no [{}]", key),
                   "add that table (docs/reference/scene.md)");
    }
  }

  // an actuator's file has reported its own errors; its numbers have the same limits
  if (!stated) return std::unexpected(stated.error());
  HAPTOMETER_LET(scene.actuator, Complete(*stated));
  scene.actuator_covariance = RelativeCovariance(*stated);
  RefuseUnrealActuator(*actuator_table, scene.actuator);
  // checks across tables, once each table is complete
  RefuseBesideHeldCase(root, *skin_table, scene);
  RefuseImpossibleRest(*actuator_table, *skin_table, scene);
  RefuseStartBeyondStops(root, scene);
  RefuseCurrentWithoutInductance(root, scene);
  HAPTOMETER_TRY(root.Finish());
  return scene;
}

Result<Scene> ReadSceneFile(const std::string& path) {
  HAPTOMETER_LET(const auto text, ReadInputFile(path, 1ULL << 20));
  return ReadSceneText(text, path);
}

}  // namespace haptometer::sim
