#pragma once

#include <cstdint>
#include <string>
#include <utility>

namespace haptometer::trial {

/// Before anything else of libhdf5 is called, each time a file is opened or made: its errors are
/// reported by this program, not by libhdf5 on stderr, and it closes nothing by itself when the
/// program ends. All is closed with its Hdf5Id; what could not be, of a full disk, would be closed
/// once more, which ended the program by a signal (1.10.8).
void PrepareHdf5();

/// An open object of libhdf5 (file, group, dataset, space, type), closed with it. hid_t is an
/// int64_t and herr_t an int, so that this header does not need hdf5.h.
class Hdf5Id {
 public:
  using CloseFunction = int (*)(std::int64_t);

  Hdf5Id(std::int64_t id, CloseFunction close_function) : id_(id), close_(close_function) {}
  Hdf5Id(Hdf5Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Id& operator=(Hdf5Id&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Hdf5Id() { Close(); }
  Hdf5Id(const Hdf5Id&) = delete;
  Hdf5Id& operator=(const Hdf5Id&) = delete;

  [[nodiscard]] bool ok() const { return id_ >= 0; }
  [[nodiscard]] std::int64_t id() const { return id_; }
  /// Closes it now; false where that fails, as it does when a file's last bytes find no room.
  bool Close() { return id_ < 0 || close_(std::exchange(id_, -1)) >= 0; }

 private:
  std::int64_t id_;
  CloseFunction close_;
};

}  // namespace haptometer::trial
