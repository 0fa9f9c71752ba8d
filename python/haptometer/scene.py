"""Scenes of actuator, adapter and skin."""
from __future__ import annotations

import json
import numbers
import os
import pathlib
import re
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
        self.path = os.path.abspath(path)
        self.text = pathlib.Path(path).read_text(encoding="utf-8")
        self._folder = os.path.dirname(self.path)

    def set(self, key: str, value: float | Quantity | str | bool | list[Any]) -> Scene:
        """The scene with another value.

        Parameters
        ----------
        key : str
            Table and key, such as "skin.stiffness_n_per_m"; a table that is not there is made.
        value : float, str, bool or list
            In SI units, or a text with a unit. Whether the scene is possible is asked when it is simulated.

        Raises
        ------
        ValueError
            No such key can be in a scene.
        TypeError
            No such value can be in a scene, as one with an uncertainty.
        """
        if not re.fullmatch(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*", key):
            raise ValueError(f"{key!r} is no key of a scene; write it as skin.stiffness_n_per_m")
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

    def is_as_read(self) -> bool:
        """Whether the file still has this text."""
        try:
            return self.path is not None and pathlib.Path(self.path).read_text(encoding="utf-8") == self.text
        except OSError:
            return False

    def text_elsewhere(self) -> str:
        """The text with paths that do not depend on the folder that it stands in."""
        text: str = native(_native.changed_scene, self.text, self._folder, "")
        return text

    def __repr__(self) -> str:
        return f"Scene({self.path or 'changed'})"


def _toml(value: Any) -> str:
    """A value as TOML writes it."""
    value = value.item() if hasattr(value, "item") and getattr(value, "ndim", 1) == 0 else value
    if isinstance(value, Quantity):
        if value.u:
            raise TypeError("a scene has no uncertainties; compare takes them by input={key: value}")
        return repr(float(value))
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value), ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(one) for one in value) + "]"
    if isinstance(value, numbers.Integral):
        return repr(int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    raise TypeError(f"a scene has no {type(value).__name__}; give a number, text, bool or list")
