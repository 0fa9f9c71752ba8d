#include "tools/reproduce/reproduction_figures.h"

#include <utility>

#include "tools/study/linearity_result.h"
#include "tools/study/matching_result.h"
#include "tools/study/study_result.h"

namespace haptometer::tools {
namespace {

std::vector<plot::Panel> Generated(std::vector<plot::Panel> panels) {
  for (plot::Panel& panel : panels) panel.title = "generated, not measured: " + panel.title;
  return panels;
}

}  // namespace

std::vector<ThesisFigure> FiguresOf(const Reproduction& reproduction) {
  std::vector<ThesisFigure> figures = ModelFigures(reproduction.model);
  const GeneratedStudy& study = reproduction.study;
  figures.push_back({"figure-3.3",
                     "(3.3) RMS displacement, IA#1 beside the stock LRA and IA#2 beside the small "
                     "contact; generated trials",
                     Generated(StudyPanels(study.trials))});
  figures.push_back({"figure-3.4",
                     "(3.4) Voltages matched by perception, in each condition; generated settings",
                     Generated(MatchingPanels(study.matching))});
  figures.push_back({"figure-3.5",
                     "(3.5) RMS displacement of IA#1 against the drive; simulated and analysed",
                     Generated(LinearityPanels(study.linearity))});
  return figures;
}

}  // namespace haptometer::tools
