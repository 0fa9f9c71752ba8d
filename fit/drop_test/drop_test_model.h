#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/error.h"
#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/impulse_record.h"
#include "fit/drop_test/prepared_record.h"
#include "fit/drop_test/ring_down_problem.h"
#include "fit/identifiability.h"

namespace haptometer::fit {

/// Standard gravity in m/s^2 (exact by convention, 3rd CGPM 1901).
inline constexpr double kGravityMPerS2 = 9.80665;

/// One number that the fit takes from outside, and the records that it concerns.
struct DropTestInput {
  enum class Kind : std::uint8_t {
    kMovingMass,
    kCaseMass,
    kResistance,
    kInductance,
    kLoad,
    kHeight,
    kRebound,
    kContact,  ///< what the blow's length leaves of the speed
    kReleaseCurrent,
    kAddedMass,
    kVoltageScale,
    kTimeScale,
  };
  Kind kind = Kind::kMovingMass;
  std::string name;
  std::string unit;
  Quantity quantity;
  std::vector<std::size_t> records;  ///< of what is said of records
};

/// The records of a drop test with their start values and everything that is given, as a
/// least-squares problem whose given numbers can be changed one at a time.
struct DropTestModel {
  std::vector<PreparedRecord> records;
  std::vector<CaseCondition> conditions;
  std::vector<DropTestInput> inputs;
  bool knows_mass = false;        ///< M of the problem is given
  bool knows_resistance = false;  ///< R is given, or no record has a finite load
  bool knows_heights = false;     ///< some record has a drop height
  bool all_free = false;          ///< M is the reduced mass
  Findings findings;              ///< what is assumed
  Loss loss = Loss::kSquares;
};

/// Collects what is given of prepared records.
///
/// Errors (Cause::kCannotAnswer): see FitDropTest.
[[nodiscard]] Result<DropTestModel> MakeDropTestModel(std::vector<PreparedRecord> records,
                                                      const ActuatorKnowns& knowns);

/// The problem with the samples of each record's part; the noise is that of the start's fit.
[[nodiscard]] RingDownProblem MakeProblem(const DropTestModel& model);

/// Writes the inputs into the problem (loads, mass ratios, added masses, inductance, released
/// currents, the impact speeds where `use_heights`, the recorders' scales) and into the point's
/// given components (mass, resistance).
void ApplyInputs(const std::vector<DropTestInput>& inputs, const DropTestModel& model,
                 bool use_heights, RingDownProblem* problem, RingDownPoint* point);

/// Applies the inputs to the problem and gives start values: Kv and the total damping from the
/// poles, Km from the released currents, the heights or the line of damping over 1/(R + RL): Km^2 =
/// M d(2 decay)/d(1/(R+RL)), 1 N/A where none speaks. A mass that is not given follows from the
/// added ones, 1/w^2 = (M + dM)/Kv being a line over dM; 1 kg where nothing tells.
[[nodiscard]] RingDownPoint StartPoint(const DropTestModel& model, bool use_heights,
                                       RingDownProblem* problem);

/// Which parameters are unknown in principle, over the Jacobian's columns.
[[nodiscard]] std::vector<bool> UnknownColumns(const DropTestModel& model,
                                               const RingDownProblem& problem);

}  // namespace haptometer::fit
