#include <fmt/core.h>

#include <array>
#include <limits>
#include <optional>
#include <string_view>

#include "sim/scene/scene_file.h"

namespace haptometer::sim {
namespace {

constexpr double kLeastCubic = 1;
constexpr double kMostCubic = 1e15;

void ReadGravity(TomlTable* table, Effects& effects) {
  if (table == nullptr) return;
  const auto value = table->Number("acceleration_m_per_s2", Dimension::kNone);
  if (!value) return;
  if (*value == 0) table->Refuse("acceleration_m_per_s2", "is 0", "leave gravity out");
  RefuseUnlessReal(*table, "acceleration_m_per_s2", *value < 0 ? -*value : *value);
  effects.gravity_m_per_s2 = *value;
}

void ReadGaps(TomlTable& table, TravelStops& stops) {
  const bool both = table.Has("gap_m");
  for (const std::string_view key : {"gap_up_m", "gap_down_m"}) {
    if (both && table.Has(key)) {
      table.Refuse(key, "cannot be combined with gap_m", "give one or the other");
    }
  }
  if (both) stops.gap_up_m = stops.gap_down_m = Positive(table, "gap_m", Dimension::kLength);
  if (both) return;
  if (table.Has("gap_up_m")) stops.gap_up_m = Positive(table, "gap_up_m", Dimension::kLength);
  if (table.Has("gap_down_m")) stops.gap_down_m = Positive(table, "gap_down_m", Dimension::kLength);
  if (table.Has("gap_up_m") || table.Has("gap_down_m")) return;
  table.Refuse("gap_m", "is missing", "give gap_m, or gap_up_m, gap_down_m or both");
}

// compliant with a stiffness, rigid without
std::optional<TravelStops> ReadTravelStops(TomlTable* table) {
  if (table == nullptr) return std::nullopt;
  TravelStops stops;
  ReadGaps(*table, stops);
  if (table->Has("stiffness_n_per_m")) {
    stops.stiffness_n_per_m = table->Require("stiffness_n_per_m", Dimension::kStiffness);
    if (!(stops.stiffness_n_per_m >= 1 && stops.stiffness_n_per_m <= 1e11)) {
      table->Refuse("stiffness_n_per_m", "is not 1 to 1e11 N/m",
                    "leave it out for a rigid stop, with restitution");
    }
    stops.damping_n_s_per_m = NotNegativeOr(*table, "damping_n_s_per_m", Dimension::kDamping, 0);
    if (table->Has("restitution")) {
      table->Refuse("restitution", "applies to rigid stops, which have no stiffness_n_per_m",
                    "give one or the other");
    }
    return stops;
  }
  if (table->Has("damping_n_s_per_m")) {
    table->Refuse("damping_n_s_per_m", "needs stiffness_n_per_m",
                  "a rigid stop has restitution instead");
  }
  stops.restitution = table->Require("restitution", Dimension::kNone);
  if (!(stops.restitution >= 0 && stops.restitution <= 1)) {
    table->Refuse("restitution", "is not 0 to 1", "speed after over speed before the impact");
  }
  return stops;
}

// limits of K3: below a cubic term has no effect, above it acts as a stop
std::optional<StiffeningSpring> ReadStiffening(TomlTable* table) {
  if (table == nullptr) return std::nullopt;
  const double cubic = table->Require("cubic_n_per_m3", Dimension::kNone);
  if (!(cubic >= kLeastCubic && cubic <= kMostCubic)) {
    table->Refuse("cubic_n_per_m3", "is not 1 to 1e15 N/m^3",
                  "the spring pulls stiffness_n_per_m d + cubic_n_per_m3 d^3");
  }
  return StiffeningSpring{.cubic_n_per_m3 = cubic};
}

// without thermal_resistance_k_per_w no heat leaves
std::optional<CoilHeating> ReadCoilHeating(TomlTable* table) {
  if (table == nullptr) return std::nullopt;
  CoilHeating heating;
  heating.heat_capacity_j_per_k = Positive(*table, "heat_capacity_j_per_k", Dimension::kNone);
  heating.thermal_resistance_k_per_w = std::numeric_limits<double>::infinity();
  if (table->Has("thermal_resistance_k_per_w")) {
    heating.thermal_resistance_k_per_w =
        Positive(*table, "thermal_resistance_k_per_w", Dimension::kNone);
  }
  heating.resistance_per_k =
      NotNegativeOr(*table, "resistance_per_k", Dimension::kNone, CoilHeating::kCopperPerK);
  if (heating.resistance_per_k > 1) {
    table->Refuse("resistance_per_k", "is more than 1 per K", "copper has 3.93e-3");
  }
  return heating;
}

// absent: the inductance is on, all other effects are off
Wish WishOf(TomlTable& table, std::string_view key) {
  switch (table.KindOf(key)) {
    case TomlKind::kAbsent:
      return key == kEffectNames[PlaceOf(Effect::kInductance)] ? Wish::kOn : Wish::kOff;
    case TomlKind::kText:
      return table.Choice(key, {"auto"}) ? Wish::kAuto : Wish::kOff;
    case TomlKind::kTable:
      table.Refuse(key, "is a table", fmt::format("its constants stand in [{}]", key));
      return Wish::kOff;
    default:
      return table.Flag(key).value_or(false) ? Wish::kOn : Wish::kOff;
  }
}

// contact = "unilateral" in [skin] is the same as contact_loss = true in [effects]
void ReadContact(TomlTable* skin, TomlTable* table, Effects& effects) {
  if (skin == nullptr) return;
  if (skin->Has("preload_n")) {
    effects.contact_loss = ContactLoss{Positive(*skin, "preload_n", Dimension::kNone)};
  }
  const auto contact = skin->Choice("contact", {"bilateral", "unilateral"});
  if (!contact) return;
  const bool unilateral = *contact == "unilateral";
  Wish& wish = effects[Effect::kContactLoss];
  const bool said = table != nullptr && table->Has("contact_loss");
  if (said && unilateral != (wish != Wish::kOff)) {
    skin->Refuse("contact", fmt::format("\"{}\" contradicts contact_loss in [effects]", *contact),
                 "remove one of the two");
  }
  if (!said && unilateral) wish = Wish::kOn;
  if (!said && !unilateral) wish = Wish::kOff;
}

void ReadWishes(TomlTable& root, TomlTable* skin, Effects& effects) {
  TomlTable* table = nullptr;
  if (root.KindOf("effects") == TomlKind::kText) {
    if (root.Choice("effects", {"auto"})) effects.wishes.fill(Wish::kAuto);
  } else {
    table = root.Table("effects");
    for (std::size_t k = 0; table != nullptr && k < kEffectNames.size(); ++k) {
      effects.wishes[k] = WishOf(*table, kEffectNames[k]);
    }
  }
  ReadContact(skin, table, effects);
}

// where the constants of an effect stand
struct Constants {
  Effect effect;
  std::string_view where;
};

// an effect without constants cannot be requested; `effects = "auto"` ignores it
void RefuseMissingConstants(TomlTable& root, TomlTable* skin, Effects& effects) {
  const bool all = root.KindOf("effects") == TomlKind::kText;
  static constexpr std::array<Constants, 6> kNeeds{
      {{Effect::kGravity, "[gravity]"},
       {Effect::kTravelStops, "[travel_stops] with gap_m"},
       {Effect::kStiffening, "[stiffening] with cubic_n_per_m3"},
       {Effect::kContactLoss, "preload_n in [skin]"},
       {Effect::kTremor, "[tremor] with amplitude_m and frequency_hz"},
       {Effect::kCoilHeating, "[coil_heating] with heat_capacity_j_per_k"}}};
  for (const Constants& need : kNeeds) {
    Wish& wish = effects[need.effect];
    // gravity that is named has a default
    const bool has_default = need.effect == Effect::kGravity && !all;
    if (effects.stated[PlaceOf(need.effect)] || has_default || wish == Wish::kOff) continue;
    const std::string_view name = kEffectNames[PlaceOf(need.effect)];
    // contact = "unilateral" requests the effect independently of `effects`
    if (!all || wish == Wish::kOn) {
      TomlTable* table = all ? nullptr : root.Table("effects");
      const bool by_skin = table == nullptr || !table->Has(name);
      (by_skin ? *skin : *table)
          .Refuse(by_skin ? "contact" : name, fmt::format("needs {}", need.where),
                  "docs/reference/scene.md lists the constants");
    }
    wish = Wish::kOff;
  }
}

}  // namespace

Effects ReadEffects(TomlTable& root, TomlTable* skin) {
  Effects effects;
  ReadGravity(root.Table("gravity"), effects);
  effects.travel_stops = ReadTravelStops(root.Table("travel_stops"));
  effects.stiffening = ReadStiffening(root.Table("stiffening"));
  effects.coil_heating = ReadCoilHeating(root.Table("coil_heating"));
  ReadWishes(root, skin, effects);
  effects.stated[PlaceOf(Effect::kGravity)] = root.Has("gravity");
  effects.stated[PlaceOf(Effect::kTravelStops)] = effects.travel_stops.has_value();
  effects.stated[PlaceOf(Effect::kStiffening)] = effects.stiffening.has_value();
  effects.stated[PlaceOf(Effect::kContactLoss)] = effects.contact_loss.has_value();
  effects.stated[PlaceOf(Effect::kTremor)] = root.Has("tremor");
  effects.stated[PlaceOf(Effect::kCoilHeating)] = effects.coil_heating.has_value();
  RefuseMissingConstants(root, skin, effects);
  return effects;
}

}  // namespace haptometer::sim
