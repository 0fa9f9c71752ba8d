#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "dsp/statistics/distributions.h"
#include "tools/document/document.h"
#include "tools/plot/gnuplot.h"
#include "tools/plot/script.h"
#include "tools/reproduce/thesis_model.h"
#include "tools/reproduce/thesis_numbers.h"
#include "tools/study/linearity.h"
#include "tools/study/matching.h"
#include "tools/study/study_table.h"
#include "trial/record.h"

namespace haptometer::tools {

/// One quantity through the measurement chain: simulated, sensed, analysed, compared.
struct ChainRow {
  std::string key;                 ///< "stream-adapter-rms"
  std::string sensor;              ///< how it was set
  std::string scene;               ///< "direct", "cone", "adapter", "adapter from rest"
  std::string quantity;            ///< "RMS", "tone's amplitude", "tone's frequency"
  document::Unit unit;             ///< m or Hz
  std::optional<double> truth{};   ///< of the exact solution, SI; nothing: there is none to give
  std::optional<double> answer{};  ///< of the analysis; nothing: it does not answer
  std::optional<double> standard_uncertainty{};
  std::optional<dsp::Interval> interval{};  ///< 95 %, as the analysis states it
  std::string remark{};

  /// Whether the interval holds the truth; where there is no truth to give, whether the analysis
  /// gave none; without an interval, whether the two are the same to the last bit.
  [[nodiscard]] bool holds() const;
};

/// Scene -> sensor model -> record -> analysis, for the three contacts of Table 2.3 in the steady
/// state under the 10 kHz stream and under an IL-030 at its fastest, with a drive-off record of
/// each as noise floor; then the adapter from rest, the same through a trial.bin, and an IL-030 at
/// its factory setting, which is too slow for the band. Errors: as sim::SimulateRecord's analysis.
[[nodiscard]] Result<std::vector<ChainRow>> RunChain(const ThesisModel& model);

/// The experiments of chapter 3, run by the study code on data that this program makes; the
/// thesis's own were never published.
struct GeneratedStudy {
  StudyResult trials;         ///< 8 subjects x 4 conditions x 3 trials, Figure 3.3
  MatchingResult matching;    ///< Figure 3.4
  LinearityResult linearity;  ///< Figure 3.5
};

/// Makes and analyses all three. Truths: the controls move as the model has them, the prototypes by
/// the thesis's factors more; matched voltages are equal at 1 V, and lower from 2 V on, so that
/// their mean over the levels is the thesis's. Trials go through trial.bin, in memory.
/// Errors: as the study's parts.
[[nodiscard]] Result<GeneratedStudy> RunGeneratedStudy(const ThesisModel& model);

/// The rows that it answers.
[[nodiscard]] std::vector<ThesisRow> StudyRows(const GeneratedStudy& study);

/// A trial.bin of the record that exists in memory only; it is read at its path. Errors: as
/// WriteSimulatedTrialIn.
[[nodiscard]] Result<std::unique_ptr<plot::MemoryFile>> TrialInMemory(const trial::Record& record);

/// The thesis, computed anew.
struct Reproduction {
  ThesisModel model;
  GeneratedStudy study;
  std::vector<ThesisRow> rows;                 ///< one for each of ThesisNumbers(), in their order
  std::optional<std::vector<ChainRow>> chain;  ///< where it was asked for
};

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
