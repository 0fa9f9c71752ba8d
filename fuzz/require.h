#pragma once

#include <cstdlib>

namespace haptometer::fuzz {

/// What must hold for every input; the fuzzer keeps the input for which it does not.
inline void Require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace haptometer::fuzz
