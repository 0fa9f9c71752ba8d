"""Recordings as arrays."""
from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy
from numpy.typing import ArrayLike, NDArray

from haptometer import _native
from haptometer.answer import error_of

if TYPE_CHECKING:
    import pandas

PREFIXED = {"mm", "um", "\u00b5m", "nm", "cm", "mV", "uV", "mA", "uA", "in", "mil"}
STATUSES = ("ok", "repeated", "over", "under", "invalid", "device_error", "late", "clipped", "bad_frame")


@dataclass(frozen=True)
class Segment:
    """Rows that follow each other at one rate: row first_row + i is at start_s + i / rate_hz."""

    first_row: int
    rows: int
    start_s: float
    rate_hz: float
    time_uncertainty_s: float


@dataclass(frozen=True, eq=False)
class Channel:
    """One measured quantity over time.

    Attributes
    ----------
    name : str
        As the source calls it.
    role : str
        "displacement", "voltage", "current", "trigger" or "other".
    unit : str
        SI unit; empty where it is not known.
    values : ndarray of float64, shape (rows,)
        A view that cannot be written; NaN where there is no measurement.
    status : ndarray of uint8, shape (rows,)
        A view of the numbers of `haptometer.STATUSES`: 0 "ok", 1 "repeated"; others are no measurement.
    range : (float, float)
        Ends of the sensor's range, in `unit`.
    resolution : float
        One step of the source, in `unit`; 0 where it is not known.
    """

    name: str
    role: str
    unit: str
    values: NDArray[numpy.float64]
    status: NDArray[numpy.uint8]
    range: tuple[float, float]
    resolution: float


class Trial:
    """A recording in memory: channels over rows on a clean time base. `read` and `Trial.from_arrays` make it.

    Examples
    --------
    >>> trial = Trial.from_arrays([0.0, 1e-6, 0.0, -1e-6], rate=1000.0, labels={"subject": "3"})
    >>> trial["displacement"].values.max()
    1e-06
    """

    def __init__(self, record: _native.Record, path: str | None = None, is_plain: bool = True) -> None:
        self._record = record
        self.path = None if path is None else os.path.abspath(path)
        # what the file was when it was read; None where a verb would read it otherwise
        self._file = _state(self.path) if is_plain else None

    def is_as_read(self) -> bool:
        """Whether a verb finds in the file what is here."""
        return self._file is not None and self._file == _state(self.path)

    @classmethod
    def from_arrays(cls, values: ArrayLike | Mapping[str, ArrayLike], rate: float, unit: str | Sequence[str] = "m",
                    labels: Mapping[str, str] | None = None) -> Trial:
        """A trial of samples at one rate.

        Parameters
        ----------
        values : array_like, shape (rows,), or mapping of names to them
            Samples; those that are masked or not finite count as not measured. One array is the displacement.
        rate : float
            Samples per second, Hz.
        unit : str or sequence of str
            SI unit of each channel; "m" is a displacement, "V" a voltage, "A" a current.
        labels : mapping, optional
            Labels such as subject and condition.

        Raises
        ------
        ValueError
            Arrays of different lengths, more or fewer units than channels, a unit that is no SI unit, a rate that is
            not above 0.
        """
        channels = dict(values) if isinstance(values, Mapping) else {"displacement": values}
        units = [unit] * len(channels) if isinstance(unit, str) else list(unit)
        arrays = [doubles(array) for array in channels.values()]
        if len(units) != len(arrays):
            raise ValueError(f"{len(arrays)} channels have {len(units)} units")
        if len({array.shape for array in arrays}) != 1 or arrays[0].ndim != 1 or arrays[0].size == 0:
            raise ValueError("channels are to be arrays of one dimension and one length, which is not 0")
        if wrong := PREFIXED & set(units):
            raise ValueError(f"units are SI units: convert from {', '.join(sorted(wrong))}")
        _check_rate(rate)
        said = {str(name): str(label) for name, label in (labels or {}).items()}
        return cls(native(_native.make_record, list(zip(channels, units, arrays)), float(rate), said))

    def __len__(self) -> int:
        return self._record.rows

    def __repr__(self) -> str:
        channels = ", ".join(f"{channel.name} ({channel.unit})" for channel in self._channels.values())
        return f"Trial({self.path or 'in memory'}: {len(self)} rows of {channels})"

    @cached_property
    def _channels(self) -> dict[str, Channel]:
        made: dict[str, Channel] = {}
        for number in range(self._record.channels):
            raw = self._record.channel(number)
            name = raw["name"] if raw["name"] not in made else f"{raw['name']}_{number + 1}"
            made[name] = Channel(raw["name"], raw["role"], raw["unit"], raw["values"], raw["statuses"],
                                        raw["range"], raw["resolution"])
        return made

    def __getitem__(self, name: str) -> Channel:
        if name in self._channels:
            return self._channels[name]
        for channel in self._channels.values():
            if channel.role == name:
                return channel
        raise KeyError(f"no channel {name}; there are {', '.join(self._channels)}")

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels; of a name that stands twice the second has its number behind it."""
        return tuple(self._channels)

    @cached_property
    def time(self) -> NDArray[numpy.float64]:
        """Time of each row on the clean time base, s, shape (rows,)."""
        times: NDArray[numpy.float64] = self._record.times()
        times.setflags(write=False)
        return times

    @property
    def segments(self) -> tuple[Segment, ...]:
        """Rows without a gap between them."""
        return tuple(Segment(*segment) for segment in self._record.segments())

    @property
    def timing(self) -> str:
        """Where times come from: "uniform" (clocked), "arrival" or "polled"."""
        return self._record.timing

    @property
    def labels(self) -> dict[str, str]:
        """Labels as they were given last."""
        return self._record.labels

    @property
    def metadata(self) -> dict[str, Any]:
        """What the recording says of itself: source, sensor, head, drive, notes, ..."""
        return self._record.metadata

    def to_pandas(self) -> pandas.DataFrame:
        """A frame with a column for each channel over the time in seconds."""
        import pandas

        columns = {name: channel.values for name, channel in self._channels.items()}
        return pandas.DataFrame(columns, index=pandas.Index(self.time, name="time_s"))

    def save(self, path: str | os.PathLike[str], overwrite: bool = False) -> None:
        """Writes it as a trial.bin at one rate, whose time begins at 0; `overwrite` replaces an older one.

        Raises
        ------
        ValueError
            There are gaps: such a trial is exported by `trial_export`.
        UsageError, HaptometerError
            The file exists, or cannot be written.
        """
        if len(self.segments) != 1:
            raise ValueError(f"{len(self.segments)} segments; a trial with gaps is exported from its file by trial_export")
        native(_native.save, self._record, os.fspath(path), overwrite)


def native(function: Any, *words: Any) -> Any:
    """Calls the module; its errors become exceptions of this package."""
    try:
        return function(*words)
    except _native.NativeError as error:
        raise error_of(*error.args) from None


def doubles(given: ArrayLike) -> NDArray[numpy.float64]:
    """float64 in the order of memory; NaN where it is masked."""
    masked: Any = numpy.ma
    made: NDArray[numpy.float64] = numpy.ascontiguousarray(masked.filled(masked.asarray(given, numpy.float64), numpy.nan))
    return made


def _check_rate(rate: float) -> None:
    if not (rate > 0 and numpy.isfinite(rate)):
        raise ValueError(f"the rate is to be above 0, not {rate!r}")


def _state(path: str | None) -> tuple[int, ...] | None:
    """What tells whether a file was changed."""
    if path is None or not os.path.exists(path):
        return None
    stat = os.stat(path)
    return stat.st_dev, stat.st_ino, stat.st_size, stat.st_mtime_ns


def path_of(given: Any) -> str:
    """A path for the module."""
    path = os.fsdecode(given)
    if "\0" in path:
        raise ValueError(f"{path!r} has a null character")
    if path == "-":
        raise ValueError("- stands for the streams of a command; give a file")
    return f"./{path}" if path.startswith("-") else path


def read(path: str | os.PathLike[str], columns: str | Sequence[str] = (), rate: float | None = None) -> Trial:
    """Reads a recording of any kind that `analyze` reads: trial.bin, CSV, HDF5, NPY, MAT, WAV, LabVIEW .lvm.

    Parameters
    ----------
    path : path
        The file; `FILE.h5/NAME` where an HDF5 holds several.
    columns : sequence of str, optional
        Names of a table's columns from the left, such as "time_s", "displacement_mm"; "-" leaves one out.
    rate : float, optional
        Rows per second of a table without times, Hz.

    Returns
    -------
    Trial
        Its arrays are views of the memory that was read into: nothing is copied.

    Raises
    ------
    CannotAnswerError
        The file is missing, or no recording.
    ValueError
        The rate is not above 0.
    """
    if rate is not None:
        _check_rate(rate)
    name = path_of(path)
    named = columns.split(",") if isinstance(columns, str) else list(columns)
    record = native(_native.read, name, named, rate)
    return Trial(record, name, is_plain=not named and rate is None)
