#pragma once

#include <span>
#include <string_view>

namespace haptometer::tools {

/// One function a verb, each in the file of its name. `argv[0]` is the verb; the return value is
/// the program's exit status (docs/reference/common.md).
int RunAcquire(int argc, const char* const* argv);
int RunAnalyze(int argc, const char* const* argv);
int RunCalibrate(int argc, const char* const* argv);
int RunCampaign(int argc, const char* const* argv);
int RunCompare(int argc, const char* const* argv);
int RunCost(int argc, const char* const* argv);
int RunEmulate(int argc, const char* const* argv);
int RunFitAdapter(int argc, const char* const* argv);
int RunFitImpedance(int argc, const char* const* argv);
int RunFitLra(int argc, const char* const* argv);
int RunFitSkin(int argc, const char* const* argv);
int RunPlanDropTest(int argc, const char* const* argv);
int RunReproduce(int argc, const char* const* argv);
int RunSession(int argc, const char* const* argv);
int RunSimulate(int argc, const char* const* argv);
int RunStudy(int argc, const char* const* argv);
int RunSweep(int argc, const char* const* argv);
int RunTrial(int argc, const char* const* argv);
int RunTune(int argc, const char* const* argv);

struct Verb {
  std::string_view name;
  std::string_view summary;
  int (*run)(int argc, const char* const* argv);
};

/// All, in the order of the work.
[[nodiscard]] std::span<const Verb> Verbs();

}  // namespace haptometer::tools
