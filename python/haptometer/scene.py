"""Scenes of actuator, adapter and skin."""
from __future__ import annotations

import json
import os
import pathlib
from typing import TYPE_CHECKING, Any

from haptometer import _native
from haptometer.quantity import Quantity
from haptometer.trial import Trial, native

if TYPE_CHECKING:
    from haptometer.answer import Simulation, Sweep


class Scene:
    """A scene, docs/reference/scene.md; it does not change: `set` gives another one.

    Parameters
    ----------
    path : path
        A scene.toml.

    Examples
    --------
    >>> scene = Scene("scene.toml").set("drive.frequency_hz", 225)   # doctest: +SKIP
    >>> scene.simulate().skin_rms                                    # doctest: +SKIP
    """

    path: str | None
    text: str
    _folder: str

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = os.fspath(path)
        self.text = pathlib.Path(path).read_text(encoding="utf-8")
        self._folder = os.path.abspath(os.path.dirname(self.path))

    def set(self, key: str, value: float | Quantity | str | bool | list[Any]) -> Scene:
        """The scene with another value.

        Parameters
        ----------
        key : str
            Table and key, such as "skin.stiffness_n_per_m"; a table that is not there is made.
        value : float, str, bool or list
            In SI units, or a text with a unit. Whether the scene is possible is asked when it is simulated.
        """
        change = f"{key} = {_toml(value)}\n"
        changed = Scene.__new__(Scene)
        changed.path = None
        changed.text = native(_native.changed_scene, self.text, self._folder, change)
        changed._folder = self._folder
        return changed

    def simulate(self, **options: Any) -> Simulation:
        """`haptometer.simulate` of this scene."""
        from haptometer import verbs

        return verbs.simulate(self, **options)

    def sweep(self, vary: Any, **options: Any) -> Sweep:
        """`haptometer.sweep` of this scene."""
        from haptometer import verbs

        return verbs.sweep(self, vary=vary, **options)

    def waveforms(self, duration: float, rate: float | None = None) -> Trial:
        """The exact motion over time.

        Parameters
        ----------
        duration : float
            Length of the run, s.
        rate : float, optional
            Rows per second, Hz; default 64 in the shortest period.

        Returns
        -------
        Trial
            Channels displacement, voltage, current, mover_m, case_m, skin_m, force_n, ...
        """
        from haptometer import verbs
        from haptometer._words import Words

        with Words() as words:
            path = words.new_file("waveforms.bin")
            verbs.simulate(self, duration=duration, rate=rate, waveforms=path, panels=False)
            made: Trial = Trial(native(_native.read, path, [], None))
        return made

    def __repr__(self) -> str:
        return f"Scene({self.path or 'changed'})"


def _toml(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(one) for one in value) + "]"
    number = float(value)
    return repr(int(number)) if isinstance(value, int) else repr(number)
