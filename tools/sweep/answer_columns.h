#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "tools/simulate/scene_answer.h"

namespace haptometer::tools {

/// A number of a scene's answer as a column of a sweep's table.
struct AnswerColumn {
  /// as `simulate --json` has it, with "run_" before what stands under `run`
  std::string_view name;
  std::optional<double> (*value)(const SceneAnswer& answer);  ///< empty: not in this answer
};

/// All columns of answers, in the order of the table: the one place that lists them.
[[nodiscard]] std::span<const AnswerColumn> AnswerColumns();

/// What a row says although its point is answered; empty: nothing.
[[nodiscard]] std::string AnswerRemark(const SceneAnswer& answer);

}  // namespace haptometer::tools
