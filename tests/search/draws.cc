#include "tests/search/draws.h"

#include <fmt/core.h>
#include <rapidcheck.h>

#include <cstdlib>

namespace haptometer::search {
namespace {

// 0 to kSteps, of any size of the case
rc::Gen<int> Steps(int most) {
  return rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, most + 1));
}

constexpr int kSteps = 1000;

template <typename Value>
Value Noted(const std::string& name, Value value) {
  DrawsOfCase() += fmt::format("  {} = {}\n", name, value);
  return value;
}

// a number that a person can type
double FourDigits(double value) {
  return std::strtod(fmt::format("{:.4g}", value).c_str(), nullptr);
}

}  // namespace

std::string& DrawsOfCase() {
  static std::string draws;
  return draws;
}

double Decades(const std::string& name, double low, double high) {
  const auto number = [=](int step) {
    return FourDigits(low * std::pow(high / low, static_cast<double>(step) / kSteps));
  };
  return Noted(name, *rc::gen::map(Steps(kSteps), number).as(name));
}

double Even(const std::string& name, double low, double high) {
  const auto number = [=](int step) { return FourDigits(low + (high - low) * step / kSteps); };
  return Noted(name, *rc::gen::map(Steps(kSteps), number).as(name));
}

int Whole(const std::string& name, int low, int high) {
  return Noted(name,
               *rc::gen::map(Steps(high - low), [low](int step) { return low + step; }).as(name));
}

bool Flag(const std::string& name) {
  return Noted(name, *rc::gen::map(Steps(1), [](int step) { return step == 1; }).as(name));
}

void Hold(std::string_view what, double deviation, double bar) {
  // deviations of cases that hold show how near the bar is
  static const bool is_shown = std::getenv("HAPTOMETER_SHOW_RESIDUALS") != nullptr;
  if (is_shown) fmt::print(stderr, "{}: {:.3g} of {:.3g}\n", what, deviation, bar);
  if (std::abs(deviation) <= bar) return;
  RC_FAIL(fmt::format("{}: deviation {:.6g}, bar {:.6g}", what, deviation, bar));
}

void Require(std::string_view what, bool is_so) {
  if (!is_so) RC_FAIL(fmt::format("not so: {}", what));
}

}  // namespace haptometer::search
