#include "trial/hdf5_id.h"

#include <hdf5.h>

namespace haptometer::trial {

void PrepareHdf5() {
  // heeded by the first call alone
  H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

}  // namespace haptometer::trial
