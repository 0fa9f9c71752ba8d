#include "trial/trial_format.h"

#include <array>

#include "base/check.h"

namespace haptometer::trial {

std::string_view Name(Encoding encoding) {
  constexpr std::array<std::string_view, 3> kNames{"i32", "f32", "f64"};
  return kNames.at(static_cast<std::size_t>(encoding));
}

std::size_t BytesOf(Encoding encoding) { return encoding == Encoding::kF64 ? 8 : 4; }

std::string_view Name(Timing timing) {
  constexpr std::array<std::string_view, 3> kNames{"uniform", "arrival", "polled"};
  return kNames.at(static_cast<std::size_t>(timing));
}

std::string_view Name(EventKind kind) {
  constexpr std::array<std::string_view, 5> kNames{"gap", "reconnect", "remark", "labels",
                                                   "time_base"};
  return kNames.at(static_cast<std::size_t>(kind));
}

double RawValue::Number(Encoding encoding) const {
  const auto low = static_cast<std::uint32_t>(bits_);
  switch (encoding) {
    case Encoding::kI32:
      return std::bit_cast<std::int32_t>(low);
    case Encoding::kF32:
      return static_cast<double>(std::bit_cast<float>(low));
    case Encoding::kF64:
      return std::bit_cast<double>(bits_);
  }
  HAPTOMETER_CHECK(false, "encoding {}", static_cast<int>(encoding));
}

}  // namespace haptometer::trial
