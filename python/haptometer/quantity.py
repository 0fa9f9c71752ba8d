"""Values with their uncertainty."""
from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Quantity:
    """A value in its SI unit, with what is known of it.

    Attributes
    ----------
    value : float
        The estimate, in `unit`.
    u : float or None
        Standard uncertainty, all causes together; None where it is not stated.
    interval : (float, float) or None
        Coverage interval of 95 %.
    unit : str
        SI unit; empty for a number.
    label : str
        What a text calls it.
    at_most : float or None
        Upper bound of 95 %, where the value is not determined.
    note : str
        What a text says behind the value.
    """

    value: float | None
    u: float | None = None
    interval: tuple[float, float] | None = None
    unit: str = ""
    label: str = ""
    at_most: float | None = None
    note: str = ""

    def __float__(self) -> float:
        if self.value is None:
            raise TypeError(f"{self.label or 'the quantity'} is not determined")
        return self.value

    def __str__(self) -> str:
        if self.value is None:
            return f"at most {self.at_most!r} {self.unit}".rstrip()
        uncertainty = "" if self.u is None else f" +- {self.u:.2g}"
        return f"{self.value!r}{uncertainty} {self.unit}".rstrip()


def value(number: float, u: float = 0.0) -> Quantity:
    """A number in SI units with its standard uncertainty, for a parameter that takes one.

    Examples
    --------
    >>> value(1.42e-3, u=1e-5).u
    1e-05
    """
    return Quantity(float(number), float(u))
