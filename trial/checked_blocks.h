#pragma once

#include <cstdint>

#include "base/error.h"
#include "trial/byte_source.h"

namespace haptometer::trial {

/// Up to which byte blocks follow each other from `offset` on, each with a sound head and a sound
/// payload: the end of the file, or where the first damaged block begins.
///
/// The payloads' CRCs are computed on `threads` threads. Errors: as ByteSource::ReadAt. Memory: a
/// payload a thread, 16 B a block.
[[nodiscard]] Result<std::uint64_t> SoundUntil(const ByteSource& source, std::uint64_t offset,
                                               int threads);

}  // namespace haptometer::trial
