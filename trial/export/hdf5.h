#pragma once

#include <memory>
#include <string>

#include "base/error.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {

/// An HDF5 file that takes trials, a group each. Lossless: times, values and statuses keep their
/// bits, header and events stay as JSON, and of a trial.bin also what the source sent (group
/// `raw`). trial/import/hdf5.h reads it back. docs/formats.md names the objects.
///
/// One thread at a time in the whole program: libhdf5 has a global state.
class Hdf5Writer {
 public:
  /// Makes the file at `path`, replacing one that is there. Errors (Cause::kFailed): it cannot be
  /// made.
  [[nodiscard]] static Result<Hdf5Writer> Create(const std::string& path);

  Hdf5Writer(Hdf5Writer&&) noexcept;
  Hdf5Writer& operator=(Hdf5Writer&&) noexcept;
  ~Hdf5Writer();

  /// Adds `recording` as the group `name`, which may hold no '/' and must be new. `raw`: a reader
  /// at the beginning of the trial.bin that it comes from, or nullptr.
  /// Errors (Cause::kFailed): the disk is full; (Cause::kCannotAnswer): `raw` cannot be read, or
  /// has fewer rows than `recording`. Memory: one column of `recording`, or of `raw` one chunk.
  [[nodiscard]] Result<void> Add(const std::string& name, const Recording& recording,
                                 TrialReader* raw);

  /// Writes what waits and closes the file. Errors (Cause::kFailed): the disk is full.
  [[nodiscard]] Result<void> Close();

 private:
  struct State;
  explicit Hdf5Writer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace haptometer::trial
