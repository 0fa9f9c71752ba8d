#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "dsp/statistics/distributions.h"
#include "tools/reproduce/thesis_model.h"

namespace haptometer::tools {

/// One quantity through the measurement chain: simulated, sensed, analysed, compared.
struct ChainRow {
  std::string key;                 ///< "stream-adapter-rms"
  std::string sensor;              ///< how it was set
  std::string scene;               ///< "direct", "cone", "adapter", "adapter from rest"
  std::string quantity;            ///< "RMS", "tone's amplitude", "tone's frequency", "readings"
  std::string_view unit;           ///< "m", "Hz", ""
  std::optional<double> truth{};   ///< of the exact solution, SI; nothing: there is none to give
  std::optional<double> answer{};  ///< of the analysis; nothing: it does not answer
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

}  // namespace haptometer::tools
