#pragma once

#include <functional>
#include <optional>

namespace haptometer::tools {

/// Where `function` is largest between `low` and `high`: the best of 1000 even places, then golden
/// section between its neighbours, to 1e-9 of the range.
[[nodiscard]] double LargestAt(const std::function<double(double)>& function, double low,
                               double high);

/// The last place before `high` where `function` passes through 0, sought in 1000 even steps from
/// `high` down and halved to the last digit; nothing where it keeps its sign.
[[nodiscard]] std::optional<double> CrossingOf(const std::function<double(double)>& function,
                                               double low, double high);

}  // namespace haptometer::tools
