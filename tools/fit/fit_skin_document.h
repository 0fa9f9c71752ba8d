#pragma once

#include <string>
#include <vector>

#include "base/error.h"
#include "fit/skin/skin_areas.h"
#include "fit/skin/skin_fit.h"

namespace haptometer::tools {

/// The answer of fit-skin for people.
[[nodiscard]] std::string FitSkinText(const std::vector<fit::SkinFit>& contacts,
                                      const fit::SkinAreas& areas, const std::string& actuator);

/// The same as one JSON document (docs/reference/fit-skin.md); what is not determined is null.
[[nodiscard]] std::string FitSkinJson(const std::vector<fit::SkinFit>& contacts,
                                      const fit::SkinAreas& areas, const std::string& actuator,
                                      const std::vector<Error>& left_out);

/// Amplitudes with the model and what it leaves, two panels a contact, and Ks over the area where a
/// law was fitted.
/// Errors: see plot::DrawPanels.
[[nodiscard]] Result<void> PlotFitSkin(const std::string& path,
                                       const std::vector<fit::SkinFit>& contacts,
                                       const fit::SkinAreas& areas);

}  // namespace haptometer::tools
