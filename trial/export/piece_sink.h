#pragma once

#include <functional>
#include <string_view>

#include "base/error.h"

namespace haptometer::trial {

/// Takes the next piece of an export, text or bytes; an error ends the export.
using PieceSink = std::function<Result<void>(std::string_view)>;

}  // namespace haptometer::trial
