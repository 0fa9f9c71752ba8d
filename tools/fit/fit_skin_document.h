#pragma once

#include <string>
#include <vector>

#include "base/error.h"
#include "fit/skin/skin_areas.h"
#include "fit/skin/skin_fit.h"
#include "tools/document/document.h"

namespace haptometer::tools {

/// Everything that fit-skin answers.
struct FitSkinAnswer {
  std::string actuator;  ///< its name
  std::vector<fit::SkinFit> contacts{};
  fit::SkinAreas areas{};
  std::vector<Error> left_out{};  ///< tables and contacts that cannot be fitted
};

/// The answer as a document (docs/reference/fit-skin.md): the skin under each contact, and over the
/// area. Its figures are the amplitudes with the model and what it leaves, two panels a contact,
/// and Ks over the area where a law was fitted.
[[nodiscard]] document::Document FitSkinDocument(const FitSkinAnswer& answer);

}  // namespace haptometer::tools
