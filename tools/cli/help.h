#pragma once

#include <deque>
#include <string>

#include "base/error.h"
#include "tools/cli/options.h"

/// What the program says of the options of a verb.
namespace haptometer::cli {

/// The line of an option in --help: "Side of the fingerpad [above 0; default 15 mm]".
[[nodiscard]] std::string HelpOf(const Option& option);

/// A number in SI units as people say it: "15 mm".
[[nodiscard]] std::string NumberText(double value, Dimension dimension);

/// "above 0", "from 1 to 60", "at most 1 V"; empty without bounds.
[[nodiscard]] std::string BoundsText(const Option& option);

/// `number` of an option within its bounds. Errors (Cause::kUsage): outside; `text` as it was
/// typed.
[[nodiscard]] Result<void> CheckBounds(const Option& option, double number,
                                       const std::string& text);

/// One JSON object: name, summary and examples of the verb, and `options`, each with name, kind,
/// placeholder, unit, least, most, above and below (whether `least` and `most` themselves are
/// refused), choices, default, rare (shown by --help-all alone) and text. What is not known is
/// null. The options that are alike in all verbs are left out.
[[nodiscard]] std::string DescriptionOf(const VerbText& verb, const std::deque<Option>& options);

}  // namespace haptometer::cli
