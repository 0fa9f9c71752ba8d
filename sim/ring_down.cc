#include "sim/ring_down.h"

namespace haptometer::sim {

template class RingDown<double>;

}  // namespace haptometer::sim
