#pragma once

#include "base/toml.h"
#include "sim/effects.h"

namespace haptometer::sim {

/// Reads [effects] and the tables of its constants ([gravity], [travel_stops], [stiffening],
/// [coil_heating]; preload_n and contact in [skin], which may be null) out of a scene;
/// docs/notation.md lists the keys. [tremor] is looked for, not read.
///
/// `effects = "auto"` in place of the table asks about every effect whose constants are stated.
/// An effect that is asked for without its constants is an error. Errors show in the root's
/// Finish().
[[nodiscard]] Effects ReadEffects(TomlTable& root, TomlTable* skin);

}  // namespace haptometer::sim
