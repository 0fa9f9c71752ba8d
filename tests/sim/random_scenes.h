#pragma once

#include <cstdint>
#include <random>
#include <string>

#include "sim/scene/scene.h"

namespace haptometer::tests {

/// Scenes with effects over the whole range of every key, as the text that a user would write.
///
/// Half of the scenes have bodies such as are built, half have mover, spring and coil drawn evenly
/// over all decades (1e-9 to 1e9) and the rest within two decades of them, some of these four, one
/// in sixteen of all every key by itself. The drive lies within a decade of the mover's own
/// frequency, and its amplitude lets it travel by anything from a nanometre to a metre. Half of the
/// gaps and preloads lie within a factor of two of what the linear motion reaches, the other
/// constants where they bend the motion by 1e-14 to 10 of itself; all of them are held to the
/// ranges that the reader takes. What is impossible is left to the reader.
class RandomScenes {
 public:
  explicit RandomScenes(std::uint64_t seed) : engine_(seed) {}

  /// The next scene; its text may be refused by the reader.
  [[nodiscard]] std::string Next();

 private:
  // evenly over the decades
  double Between(double low, double high);
  double Whole() { return Between(1e-9, 1e9); }
  double Bend() { return Between(1e-14, 10); }
  double WholeOrNone() { return OneOf(6) ? 0 : Whole(); }
  double NearOrFar(double value) {
    return value * (OneOf(2) ? Between(0.5, 2) : Between(0.1, 100));
  }
  bool OneOf(std::uint64_t n) { return engine_() % n == 0; }

  void DrawBodies(sim::Scene& scene);
  void DrawWildBodies(sim::Scene& scene);
  void DrawRelatedBodies(sim::Scene& scene);
  bool DrawDrive(sim::Scene& scene);
  std::string EffectTables(const sim::Scene& scene);
  std::string RunTable(const sim::Scene& scene);
  std::string Stops(double travel_m);
  std::string Gravity(const sim::Scene& scene);
  std::string Wish(const std::string& name);

  std::mt19937_64 engine_;
  // what the linear motion comes to
  double travel_m_ = 0, skin_force_n_ = 0, skin_m_ = 0, heat_j_ = 0;
  std::string wishes_;
};

}  // namespace haptometer::tests
