#include "tools/verbs.h"

#include <array>

namespace haptometer::tools {
namespace {

// in the order of the work: record, inspect, analyse; then verbs without hardware
constexpr auto kVerbs = std::to_array<Verb>({
    {"acquire", "Record a sensor's readings into a trial", RunAcquire},
    {"calibrate", "Determine the gain of an analog output, with its uncertainty", RunCalibrate},
    {"session", "Plan and record the trials of a study, with a verdict after each", RunSession},
    {"trial", "Show, label, plot and export recordings", RunTrial},
    {"analyze", "Determine the band-limited RMS displacement of a recording", RunAnalyze},
    {"study", "Compare conditions over subjects; matched voltages; linearity", RunStudy},
    {"fit-lra", "Fit an actuator's constants to its ring-downs after a drop", RunFitLra},
    {"fit-impedance", "Fit an actuator's constants to an impedance sweep", RunFitImpedance},
    {"fit-adapter", "Fit an adapter's spring and damper to its ring-down after a tap",
     RunFitAdapter},
    {"plan-drop-test", "Plan the load, recorder and number of drops of a drop test",
     RunPlanDropTest},
    {"fit-skin", "Fit the skin's constants under a contact to drive sweeps", RunFitSkin},
    {"simulate", "Solve a scene: motion, current and power", RunSimulate},
    {"sweep", "Simulate a scene over any of its keys, as a table", RunSweep},
    {"tune", "Find the adapter that moves the skin most, with a proved bound", RunTune},
    {"compare", "Compare trials with a scene, and explain a difference", RunCompare},
    {"campaign", "Divide long work into chunks for Slurm or GNU parallel", RunCampaign},
    {"cost", "Show what an accuracy costs, measured and simulated", RunCost},
    {"reproduce", "Recompute the thesis's numbers and figures and compare", RunReproduce},
    {"emulate", "Play a scene or a trial as an emulated sensor", RunEmulate},
});

}  // namespace

std::span<const Verb> Verbs() { return kVerbs; }

}  // namespace haptometer::tools
