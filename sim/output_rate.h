#pragma once

#include <optional>

#include "sim/scene.h"

namespace haptometer::sim {

/// How often a second a scene's motion is looked at, so that peaks between two looks can be told
/// (hermite.h: to 1e-10 where nothing happens between them).
///
///   sine                 64 f; with a duration whole multiples of that, at least 16 times the
///                        scene's highest own frequency, which may ring (to 1e-7)
///   tones, burst         64 times the highest of the drive's, the finger's and the scene's own
///                        frequencies
///   pulse                64 times the highest of the scene's and the finger's
///   chirp, samples       the same, rounded up to whole multiples of their cubics' or lines' rate:
///                        pieces that end between outputs cost some ten times as much
///
/// The scene's own: Im p / 2 pi of the poles that ring, up to 1e5 Hz. At least 1000 Hz where
/// nothing has a frequency. Cost: Poles().
[[nodiscard]] double OutputRateHz(const Scene& scene);

/// Steps that a run of `duration_s` > 0 takes: its outputs.
[[nodiscard]] double StepsOfRun(const Scene& scene, double duration_s);

/// The most of them: 1e8 of a sine, some half a minute; 1e7 of another drive, all of whose outputs
/// are kept.
[[nodiscard]] double MostSteps(const Scene& scene);

/// How long the undriven linear scene needs until its slowest motion has fallen to a thousandth:
/// ln 1000 / min |Re p|. Nothing where a motion never dies away.
[[nodiscard]] std::optional<double> RingDownS(const Scene& scene);

}  // namespace haptometer::sim
