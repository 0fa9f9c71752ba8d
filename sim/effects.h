#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "sim/coil_heating.h"
#include "sim/contact_loss.h"
#include "sim/stiffening_spring.h"
#include "sim/travel_stops.h"

namespace haptometer::sim {

/// What a scene may call for beyond rigid bodies on linear springs under a steady voltage.
enum class Effect : std::uint8_t {
  kInductance,   ///< the coil's; without it the current follows the voltage at once
  kGravity,      ///< along the axis; moves the mover towards a stop, adds weight to the preload
  kTravelStops,  ///< the mover's travel in its case ends
  kStiffening,   ///< the mover's spring hardens with travel
  kContactLoss,  ///< the skin pushes, it never pulls
  kTremor,       ///< the finger moves by itself
  kCoilHeating,  ///< the coil's resistance rises with the power in it
};

/// As the keys of [effects] are called, in the order of Effect.
inline constexpr std::array<std::string_view, 7> kEffectNames{
    "inductance",   "gravity", "travel_stops", "stiffening",
    "contact_loss", "tremor",  "coil_heating"};

/// A choice of effects; bit by Effect.
using EffectSet = std::bitset<kEffectNames.size()>;

/// The effect's place in an EffectSet and in kEffectNames.
[[nodiscard]] constexpr std::size_t PlaceOf(Effect effect) {
  return static_cast<std::size_t>(effect);
}

/// What a scene says about an effect.
enum class Wish : std::uint8_t {
  kOff,
  kOn,
  kAuto,  ///< on only where it changes the asked quantity by more than the tolerance
};

/// The scene's effects and their constants, which may be stated for effects that are off.
struct Effects {
  std::array<Wish, kEffectNames.size()> wishes{Wish::kOn};
  double gravity_m_per_s2 = 9.80665;  ///< along the axis, towards the skin positive
  /// Gaps count from where the mover rests without gravity.
  std::optional<TravelStops> travel_stops{};
  /// The preload without the bodies' weight, which gravity adds.
  std::optional<ContactLoss> contact_loss{};
  std::optional<StiffeningSpring> stiffening{};  ///< without sag, which gravity adds
  std::optional<CoilHeating> coil_heating{};

  [[nodiscard]] Wish& operator[](Effect effect) { return wishes[PlaceOf(effect)]; }
  [[nodiscard]] Wish operator[](Effect effect) const { return wishes[PlaceOf(effect)]; }
  /// Whether the scene says anything but "the coil has its inductance, nothing else".
  [[nodiscard]] bool Asked() const { return wishes != Effects{}.wishes; }
};

}  // namespace haptometer::sim
