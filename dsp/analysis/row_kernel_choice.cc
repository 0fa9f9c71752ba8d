#include "base/error.h"
#include "dsp/analysis/row_kernel.h"
#include "dsp/filter/lane_cascade.h"

namespace haptometer::dsp {

const RowKernel& WidestRowKernel() {
  switch (WidestInstructionSet()) {
    case InstructionSet::kBaseline:
      return kRowKernelBaseline;
    case InstructionSet::kAvx2:
      return kRowKernelAvx2;
    case InstructionSet::kAvx512:
      return kRowKernelAvx512;
  }
  HAPTOMETER_CHECK(false, "instruction set {}", static_cast<int>(WidestInstructionSet()));
}

}  // namespace haptometer::dsp
