#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <string_view>

#include "sim/linear/mode.h"
#include "sim/scene/scene.h"

namespace haptometer::sim {

/// What dissipates in a scene, in the order of a scene's ledger.
enum class SceneElement : std::size_t { kCoil, kMover, kAdapter, kSkin, kStop, kSource, kGrip };
inline constexpr std::array<std::string_view, 7> kSceneElements{
    "coil", "mover's damper", "adapter", "skin", "stops", "source", "grip"};

/// The linear scene as a mode: x, a, b as in LinearModel, no guards, with its energies.
///
///   stored = L i^2/2 + Mv vv^2/2 + Mc1 va^2/2 + Ma2 vs^2/2
///          + Kv (xv - xa)^2/2 + Ka (xa - xs)^2/2 + Ks (xs - xg)^2/2 + Kg xa^2/2
///   dissipated: R i^2, Bv (vv - va)^2, Ba (va - vs)^2, Bs (vs - vg)^2, the source's, Bg va^2
///   put in by the finger: -vg (Ks (xs - xg) + Bs (vs - vg))
///
/// (without an adapter: s is a, and the adapter's terms are absent; without inductance i is that of
/// LinearModel). Positions count from static
/// equilibrium, where gravity and preload are balanced and do not appear.
[[nodiscard]] Mode SceneMode(const Scene& scene);

/// The mass that moves with the case: Mc + Ma1, Mc without an adapter; infinite where it is held.
[[nodiscard]] double CaseSideMass(const Scene& scene);

/// The mass that the skin carries: Ma2, or the case's without an adapter.
[[nodiscard]] double ContactMass(const Scene& scene);

/// The mode with a last state that is always 1; its own states come first, unchanged.
[[nodiscard]] Mode WithConstant(const Mode& mode);

/// A form of x (n, n) or of [x, u] as one of y, x = from y, and of u where it was: (n, m) `from`.
[[nodiscard]] Eigen::MatrixXd FormIn(const Eigen::MatrixXd& form, const Eigen::MatrixXd& from);
/// The same of a row.
[[nodiscard]] Eigen::RowVectorXd RowIn(const Eigen::RowVectorXd& row, const Eigen::MatrixXd& from);

}  // namespace haptometer::sim
