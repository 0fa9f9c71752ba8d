#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <string_view>

/// What the properties of the search draw and how they judge. A number that is drawn stands with
/// its name in the counterexample.
namespace haptometer::search {

/// What references compute in: 64 bits.
using Real = long double;
[[nodiscard]] constexpr Real Long(double value) { return static_cast<Real>(value); }

/// From `low` to `high`, evenly over the decades, with four digits; shrinks towards `low`.
[[nodiscard]] double Decades(const std::string& name, double low, double high);
/// From `low` to `high`, evenly, with four digits; shrinks towards `low`.
[[nodiscard]] double Even(const std::string& name, double low, double high);
/// From `low` up to and with `high`; shrinks towards `low`.
[[nodiscard]] int Whole(const std::string& name, int low, int high);
/// Shrinks towards false.
[[nodiscard]] bool Flag(const std::string& name);

/// What the running case has drawn, a line each; whoever begins a case clears it.
[[nodiscard]] std::string& DrawsOfCase();

/// Fails the case where `deviation` is above `bar`, or no number.
void Hold(std::string_view what, double deviation, double bar);
/// Fails the case where `is_so` is false.
void Require(std::string_view what, bool is_so);

/// Independent normal numbers of deviation 1, from a seed that is drawn.
class Noise {
 public:
  explicit Noise(int seed) : engine_(static_cast<std::uint64_t>(seed)) {}
  double operator()() {  // Box and Muller
    const double radius = std::sqrt(-2 * std::log(Uniform()));
    return radius * std::cos(2 * std::numbers::pi * Uniform());
  }
  /// Below `count`, which is above 0.
  std::size_t Below(std::size_t count) { return engine_() % count; }

 private:
  // above 0 and up to 1
  double Uniform() { return (static_cast<double>(engine_() >> 11U) + 1) * 0x1p-53; }
  std::mt19937_64 engine_;
};

/// Rounded to whole steps; as it is where `step` is 0.
[[nodiscard]] inline double Stepped(double value, double step) {
  return step > 0 ? step * std::round(value / step) : value;
}

/// The properties, one case each: draws it and fails it by Hold or Require. False where the product
/// refused or doubted what was asked, so that nothing was compared.
bool FilterCase();
bool SceneCase();
bool RecordCase();
bool DropCase();
bool WireCase();

}  // namespace haptometer::search
