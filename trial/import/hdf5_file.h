#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "base/error.h"
#include "trial/hdf5_id.h"

namespace haptometer::trial {

/// An HDF5 file that is read: every object of it is opened here, and every read is admitted here.
///
/// A recording is one file. Links to other files are not followed, and datasets whose numbers lie
/// in other files (external storage, virtual datasets) are refused before such a file is opened.
class Hdf5File {
 public:
  /// Errors (Cause::kCannotAnswer): no HDF5 file, or a damaged one.
  [[nodiscard]] static Result<Hdf5File> Open(const std::string& path);

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] const Hdf5Id& root() const { return root_; }
  /// "FILE.h5/group/dataset" of an open object, for messages.
  [[nodiscard]] std::string PathOf(const Hdf5Id& object) const;

  /// The object `name` of the group `place`, of any kind; not ok() where there is none.
  /// Errors (Cause::kCannotAnswer): it, or its numbers, lie in another file.
  [[nodiscard]] Result<Hdf5Id> Open(const Hdf5Id& place, const std::string& name) const;

  /// Whether `rows` rows of `width` numbers of `dataset` may be read into memory. Those that are
  /// admitted add up: they are no more than kMostNumbers (trial/import/exported_trial.h), or than
  /// the file has bytes, where these are more.
  /// Errors (Cause::kCannotAnswer): too many, or of a dataset of which the file holds next to
  /// nothing, as of one that was made and never written.
  [[nodiscard]] Result<void> Admit(const Hdf5Id& dataset, std::uint64_t rows, std::uint64_t width);

 private:
  Hdf5File(std::string path, Hdf5Id file, Hdf5Id root);

  std::string path_;
  Hdf5Id file_;
  Hdf5Id root_;
  Hdf5Id links_;  // how links are followed: within the file
  /// whether the last object lay behind a link to another file; libhdf5 keeps its address
  std::unique_ptr<bool> has_left_;
  std::uint64_t numbers_left_ = 0;
};

}  // namespace haptometer::trial
