#include "fit/row_reduction.h"

#include <Eigen/QR>
#include <algorithm>

namespace haptometer::fit {
namespace {

using Position = Eigen::Index;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr Position kStretch = 128;

class Reduction {
 public:
  Reduction(const LinearRows& rows, const std::vector<std::size_t>& used)
      : whole_(rows.derivatives.data(), std::ssize(rows.residuals),
               static_cast<Position>(rows.columns)),
        residuals_(rows.residuals.data(), std::ssize(rows.residuals)),
        columns_(used.rbegin(), used.rend()),
        triangle_(Eigen::MatrixXd::Zero(count() + 1, count() + 1)) {
    for (Position row = 0; row < residuals_.size(); row += kStretch) {
      TakeIn(row, std::min(kStretch, residuals_.size() - row));
    }
  }

  [[nodiscard]] std::vector<double> reduced() const {
    RowMajor reduced(count() + 1, count() + 1);
    reduced.leftCols(count()) = triangle_.leftCols(count()).rowwise().reverse();
    reduced.col(count()) = triangle_.col(count());
    return {reduced.data(), reduced.data() + reduced.size()};
  }

 private:
  [[nodiscard]] Position count() const { return std::ssize(columns_); }

  // of the triangle's column `k`, over some rows
  [[nodiscard]] auto Rows(Position k, Position row, Position taken) const {
    return whole_.col(static_cast<Position>(columns_[static_cast<std::size_t>(k)]))
        .segment(row, taken);
  }

  // the triangle's columns that rows and what they meet in the triangle are not 0 in
  [[nodiscard]] std::vector<Position> Touched(Position row, Position taken) const {
    std::vector<Position> touched;
    std::vector<bool> meets(columns_.size(), false);
    for (Position k = 0; k < count(); ++k) {
      const auto at = static_cast<std::size_t>(k);
      if (!meets[at] && (Rows(k, row, taken).array() == 0).all()) continue;
      touched.push_back(k);
      for (Position further = k + 1; further < count(); ++further) {
        if (triangle_(k, further) != 0) meets[static_cast<std::size_t>(further)] = true;
      }
    }
    touched.push_back(count());
    return touched;
  }

  void TakeIn(Position row, Position taken) {
    const auto touched = Touched(row, taken);
    const Position width = std::ssize(touched);
    Eigen::MatrixXd work(width + taken, width);
    Position kept = 0;
    for (const Position k : touched) {
      if ((triangle_.row(k).array() == 0).all()) continue;
      work.row(kept++) = triangle_(k, touched);
    }
    for (Position k = 0; k + 1 < width; ++k) {
      work.col(k).segment(kept, taken) = Rows(touched[static_cast<std::size_t>(k)], row, taken);
    }
    work.col(width - 1).segment(kept, taken) = residuals_.segment(row, taken);
    Eigen::Ref<Eigen::MatrixXd> filled = work.topRows(kept + taken);
    const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(filled);
    for (Position k = 0; k < width; ++k) {
      const Position to = touched[static_cast<std::size_t>(k)];
      triangle_.row(to).setZero();
      if (k >= kept + taken) continue;
      for (Position further = k; further < width; ++further) {
        triangle_(to, touched[static_cast<std::size_t>(further)]) = work(k, further);
      }
    }
  }

  Eigen::Map<const RowMajor> whole_;
  Eigen::Map<const Eigen::VectorXd> residuals_;
  std::vector<std::size_t> columns_;  // in the triangle's order
  Eigen::MatrixXd triangle_;
};

}  // namespace

std::vector<double> ReduceRows(const LinearRows& rows, const std::vector<std::size_t>& used) {
  return Reduction(rows, used).reduced();
}

}  // namespace haptometer::fit
