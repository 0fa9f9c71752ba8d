#pragma once

#include <string>
#include <vector>

#include "tools/plot/gnuplot.h"
#include "tools/reproduce/reproduce.h"

namespace haptometer::tools {

/// A figure of the thesis, drawn anew.
struct ThesisFigure {
  std::string name;     ///< "figure-2.3"
  std::string caption;  ///< what it shows, and of what
  std::vector<plot::Panel> panels;
};

/// Figures 2.2 to 2.7 of the model.
[[nodiscard]] std::vector<ThesisFigure> ModelFigures(const ThesisModel& model);

/// All: those of the model, and 3.3 to 3.5 of the generated study.
[[nodiscard]] std::vector<ThesisFigure> FiguresOf(const Reproduction& reproduction);

}  // namespace haptometer::tools
