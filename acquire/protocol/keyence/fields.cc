#include "acquire/protocol/keyence/fields.h"

namespace haptometer::acquire {

Fields::Fields(std::string_view line) {
  while (size_ < kMost) {
    const std::size_t comma = line.find(',');
    fields_[size_++] = line.substr(0, comma);
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
  too_many_ = true;
}

}  // namespace haptometer::acquire
