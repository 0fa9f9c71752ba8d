// Written by limited_reference.py; do not edit.
// clang-format off
#pragma once

#include "sim/tuning/adapter_objective.h"

namespace haptometer::tests {

/// The largest objective with which the mover travels no further than a limit; 0 keeps
/// what the thesis's problem has.
struct LimitedCase {
  sim::Objective objective;
  double limit_m;
  double amplitude_v, frequency_hz;
  double skin_stiffness, skin_damping;
  double least_skin_side_mass_kg;
  double best;
};
inline constexpr LimitedCase kLimitedCases[] = {
    {sim::Objective::kSkinRms, 5e-05, 0, 0, 0, 0, 0, 6.4121707882e-05},
    {sim::Objective::kSkinRms, 0.0001, 0, 0, 0, 0, 0, 8.9953187797e-05},
    {sim::Objective::kSkinRms, 0.0002, 0, 0, 0, 0, 0, 1.2398227751e-04},
    {sim::Objective::kSkinRms, 0.0003, 0, 0, 0, 0, 0, 1.4740351892e-04},
    {sim::Objective::kSkinRms, 0.0004, 0, 0, 0, 0, 0, 1.6482179306e-04},
    {sim::Objective::kSkinRms, 0.0005, 0, 0, 0, 0, 0, 1.7801720613e-04},
    {sim::Objective::kSkinRms, 0.0006, 0, 0, 0, 0, 0, 1.8788551498e-04},
    {sim::Objective::kSkinRms, 0.0007, 0, 0, 0, 0, 0, 1.9493459768e-04},
    {sim::Objective::kSkinRms, 0.0008, 0, 0, 0, 0, 0, 1.9946465928e-04},
    {sim::Objective::kSkinRms, 0.001, 0, 0, 0, 0, 0, 2.0188526002e-04},
    {sim::Objective::kStimulus, 0.0001, 0, 0, 0, 0, 0, 3.0275186512e-03},
    {sim::Objective::kStimulus, 0.0003, 0, 0, 0, 0, 0, 4.9561060890e-03},
    {sim::Objective::kStimulus, 0.0005, 0, 0, 0, 0, 0, 5.9844469986e-03},
    {sim::Objective::kSkinPower, 0.0001, 0, 0, 0, 0, 0, 1.2294985148e-02},
    {sim::Objective::kSkinPower, 0.0003, 0, 0, 0, 0, 0, 3.2895992243e-02},
    {sim::Objective::kSkinPower, 0.0006, 0, 0, 0, 0, 0, 5.3409262619e-02},
    {sim::Objective::kSkinRms, 0.0003, 3, 0, 0, 0, 0, 1.0681032368e-04},
    {sim::Objective::kSkinRms, 0.0009, 9, 0, 0, 0, 0, 3.2043097103e-04},
    {sim::Objective::kSkinRms, 0.0005, 0, 60, 0, 0, 0, 4.5604870896e-05},
    {sim::Objective::kSkinRms, 0.0006, 0, 140, 0, 0, 0, 2.2871108099e-04},
    {sim::Objective::kSkinRms, 0.0001, 0, 400, 0, 0, 0, 6.6089933869e-05},
    {sim::Objective::kSkinRms, 0.0003, 0, 0, 1500, 2, 0, 9.0676877307e-05},
    {sim::Objective::kSkinPower, 0.0004, 0, 0, 1500, 2, 0, 4.1078752299e-02},
    {sim::Objective::kSkinRms, 0.00045, 0, 0, 0, 0, 0.008, 1.1902538820e-04},
};

}  // namespace haptometer::tests
