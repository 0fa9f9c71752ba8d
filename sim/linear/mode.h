#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace haptometer::sim {

/// A guard that is zero by construction at the beginning of a mode, and so is no event there.
struct Departure {
  std::size_t guard = 0;
  /// How many of g, g', g'' ... vanish: 1 after an impact (g = 0, g' > 0), 2 where a contact was
  /// left with equal speeds, 3 where it was left with equal accelerations.
  std::size_t order = 1;
};

/// An impact whose bounces die out; see PiecewiseLinearSystem.
struct Bounce {
  double restitution = 0;    ///< e in [0, 1]: speed after over speed before
  double rest_height = 0;    ///< bounces lower than this are at rest (unit of the guard), > 0
  std::size_t rest_via = 0;  ///< the transition into the mode at rest
};

/// What happens when a guard falls below zero: x_after = map x + shift, in the mode's coordinates.
struct Transition {
  std::string_view name;  ///< "impact up", "landing"
  std::size_t mode = 0;   ///< the mode after
  Eigen::MatrixXd map;    ///< (n after, n before)
  Eigen::VectorXd shift;  ///< (n after)
  std::optional<Departure> departure{};
  std::optional<Bounce> bounce{};
};

/// What acts from outside, u = [v, xg, vg]: the terminal voltage, the position of the finger under
/// the skin and its rate.
inline constexpr Eigen::Index kVoltage = 0;
inline constexpr Eigen::Index kFinger = 1;
inline constexpr Eigen::Index kFingerRate = 2;
inline constexpr Eigen::Index kInputs = 3;

/// A mode holds while row x + feed u + offset >= 0, a gap or a contact force.
struct Guard {
  Eigen::RowVectorXd row;  ///< (n)
  double offset = 0;
  std::size_t transition = 0;
  Eigen::RowVectorXd feed{};  ///< (kInputs); empty: none
};

/// A number whose largest and least values are wanted, between outputs too: row x + feed u +
/// offset.
struct WatchedNumber {
  Eigen::RowVectorXd row;  ///< (n)
  double offset = 0;
  Eigen::RowVectorXd feed{};  ///< (kInputs); empty: none
};

/// The least and the largest value of a number.
struct ValueRange {
  double least = HUGE_VAL;
  double largest = -HUGE_VAL;

  void Include(double value) {
    if (value < least) least = value;
    if (value > largest) largest = value;
  }
  void Include(const ValueRange& other) {
    Include(other.least);
    Include(other.largest);
  }
  [[nodiscard]] double LargestMagnitude() const {
    return std::abs(largest) > std::abs(least) ? std::abs(largest) : std::abs(least);
  }
};

/// x' = A x + b v + finger [xg, vg]; a constant force is a state that stays 1.
///
/// Modes may have coordinates of their own (and their own n): a stiff contact is described by its
/// penetration, not by the difference of two positions.
struct Mode {
  std::string_view name;
  Eigen::MatrixXd a;          ///< (n, n)
  Eigen::VectorXd b;          ///< (n)
  Eigen::MatrixXd positions;  ///< (outputs, n): what is handed out; empty: x itself
  std::vector<Guard> guards{};
  std::vector<WatchedNumber> watched{};  ///< in all modes of a system the same ones, or none
  /// (n, n) symmetric: stored energy x' S x in J; or of [x, u], as below.
  Eigen::MatrixXd stored_j;
  /// (n): the current in A is current_row x + current_per_volt v, and v times it the power in
  Eigen::RowVectorXd current_row;
  double current_per_volt = 0;
  Eigen::MatrixXd a_rest{};  ///< as LinearModel's; empty: none
  Eigen::VectorXd b_rest{};
  Eigen::MatrixXd finger{};  ///< (n, 2), or empty: the finger's motion reaches nothing
  /// (n + kInputs) of [x, u]: the force that the skin's foot feels, so that -vg times it is the
  /// power that the finger's motion puts in; empty: none.
  Eigen::RowVectorXd finger_force_row{};
  /// For each of the system's dissipating elements, the power x' D x in W: (n, n) symmetric, or
  /// empty where it rests. (n + kInputs, n + kInputs): of [x, u] in place of x.
  std::vector<Eigen::MatrixXd> dissipating{};

  /// (n, kInputs): what u does to x'.
  [[nodiscard]] Eigen::MatrixXd Inputs() const {
    Eigen::MatrixXd inputs = Eigen::MatrixXd::Zero(a.rows(), kInputs);
    inputs.col(kVoltage) = b;
    if (finger.size() > 0) inputs.rightCols(2) = finger;
    return inputs;
  }
};

/// Linear motions that follow each other: the exact model of play, stops and breaking contact.
///
/// The rule of accumulation (Zeno): an impact that leaves with the speed u = g' > 0 under the
/// acceleration g'' = -a < 0 begins flights of 2u/a, 2ue/a, 2ue^2/a ..., which are over after
///
///     T = 2 u / (a (1 - e)).
///
/// Once their height u^2/2a is below `rest_height` and a changes by less than a thousandth within
/// T, they are not played one by one: the bodies are at rest against each other (Bounce::rest_via),
/// and that event carries the time of the impact + T. Exact for constant a; otherwise the height
/// stands for the error in position, T/1000 for that in time.
struct PiecewiseLinearSystem {
  std::vector<Mode> modes;
  std::vector<Transition> transitions;
  std::vector<std::string_view> dissipating_elements;  ///< names, in the order of the modes' forms
  /// Rows over the modes' positions whose squares are to be integrated beside the energies.
  std::vector<Eigen::RowVectorXd> squared_rows{};
};

}  // namespace haptometer::sim
