#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "dsp/statistics/distributions.h"
#include "tools/document/document.h"
#include "tools/plot/gnuplot.h"
#include "tools/reproduce/study_rows.h"
#include "tools/reproduce/thesis_model.h"
#include "tools/reproduce/thesis_numbers.h"

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
/// its factory setting, which is too slow for the band. Errors: as sim::SimulateRecord's analysis;
/// no room for the trial.bin.
[[nodiscard]] Result<std::vector<ChainRow>> RunChain(const ThesisModel& model);

/// The thesis, computed anew.
struct Reproduction {
  ThesisModel model;
  GeneratedStudy study;
  std::vector<ThesisRow> rows;                 ///< one for each of ThesisNumbers(), in their order
  std::optional<std::vector<ChainRow>> chain;  ///< where it was asked for
};

/// Computes every row of ThesisNumbers() with the rooms as they are: nothing of it is stored.
///
/// Cost: some 2 s, most of it the analysis of 96 generated trials. Errors: as RunGeneratedStudy and
/// RunChain.
[[nodiscard]] Result<Reproduction> Reproduce(const ThesisModel& model, bool with_chain);

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

/// The rows, a table for each group, with the causes of each below; the chain; the figures.
/// `files`: those that the verb writes.
[[nodiscard]] document::Document ReproductionDocument(const Reproduction& reproduction,
                                                      const std::vector<ThesisFigure>& figures,
                                                      const std::vector<std::string>& files);

}  // namespace haptometer::tools
