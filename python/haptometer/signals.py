"""Filter, spectrum and sine fit of arrays."""
from __future__ import annotations

import math
import os
from dataclasses import dataclass

import numpy
from numpy.typing import ArrayLike, NDArray

from haptometer import _native
from haptometer.quantity import Quantity
from haptometer.trial import doubles, native


def _samples(x: ArrayLike, rate: float) -> NDArray[numpy.float64]:
    """One-dimensional, finite samples at a rate above 0; masked ones are not."""
    samples = doubles(x)
    if samples.ndim != 1:
        raise ValueError(f"the samples are to have one dimension, not {samples.ndim}")
    # a sum is finite where all are, but for the largest numbers that there are
    if not math.isfinite(numpy.add.reduce(samples)) and not numpy.isfinite(samples).all():
        raise ValueError("some samples are not finite: leave them out, or interpolate; analyze does so for trials")
    if not (rate > 0 and math.isfinite(rate)):
        raise ValueError(f"the rate is to be above 0, not {rate!r}")
    return samples


def _check_band(band: tuple[float, float], rate: float) -> None:
    low, high = band
    if not 0 < low < high < rate / 2:
        raise ValueError(f"the band {low!r} to {high!r} Hz is not above 0, in order and below half the rate of {rate!r} Hz")


def bandpass(x: ArrayLike, rate: float, band: tuple[float, float] = _native.DEFAULT_BAND, order: int = 6,
             corner: str = "whole", threads: int | None = None) -> NDArray[numpy.float64]:
    """Zero-phase Butterworth band-pass: forward, then backward.

    Parameters
    ----------
    x : array_like, shape (samples,)
        Samples, all finite.
    rate : float
        Samples per second, Hz.
    band : (float, float)
        Corners, Hz.
    order : int
        1 to 8.
    corner : {"whole", "each"}
        Whether both passes together, or each of them, have -3 dB at the corners.
    threads : int, optional
        Threads, which change no digit; default the number of cores.

    Returns
    -------
    ndarray of float64, shape (samples,)
        In the unit of `x`. Beyond its ends the signal is continued oddly.

    Raises
    ------
    ValueError
        `x` has more than one dimension or a value that is not finite; no such band-pass, rate or corner; a band so
        narrow that its filter rings for more than 33 million samples (UsageError).
    """
    if corner not in ("whole", "each"):
        raise ValueError(f'corner is to be "whole" or "each", not {corner!r}')
    used = os.cpu_count() or 1 if threads is None else threads
    if not 1 <= used <= 1024:
        raise ValueError(f"threads are to be 1 to 1024, not {threads}")
    _check_band(band, rate)
    filtered: NDArray[numpy.float64] = native(_native.bandpass, _samples(x, rate), rate, band, order, corner == "each", used)
    return filtered


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Welch's averaged spectrum.

    Attributes
    ----------
    frequency_hz : ndarray, shape (bins,)
    density : ndarray, shape (bins,)
        One-sided power spectral density, unit^2/Hz.
    resolution_hz, noise_bandwidth_hz : float
        Spacing of bins, and equivalent noise bandwidth of the window.
    segments : int
    degrees_of_freedom : float
        Of a bin's power.
    lower_factor, upper_factor : float
        Times these a bin's density becomes the ends of its 95 % interval.
    """

    frequency_hz: NDArray[numpy.float64]
    density: NDArray[numpy.float64]
    resolution_hz: float
    noise_bandwidth_hz: float
    segments: int
    degrees_of_freedom: float
    lower_factor: float
    upper_factor: float


def welch(x: ArrayLike, rate: float, segment_size: int | None = None, window: str = "hann", overlap: float = 0.5,
          detrend: bool = True) -> Spectrum:
    """Power spectral density by Welch's method.

    Parameters
    ----------
    x : array_like, shape (samples,)
    rate : float
        Samples per second, Hz.
    segment_size : int, optional
        Samples of a segment; default one second, or all where there are fewer.
    window : {"hann", "hamming", "blackman-harris", "flat-top", "rectangular"}
    overlap : float
        Share of a segment that the next one repeats, 0 to below 1.
    detrend : bool
        Whether each segment's mean is taken off.

    Raises
    ------
    UsageError
        A segment longer than the signal, an overlap out of its range, a value that is not finite.
    ValueError
        No such window.
    """
    shapes = _native.Window.__members__
    if window not in shapes:
        raise ValueError(f"window is to be one of {', '.join(shapes)}, not {window!r}")
    samples = _samples(x, rate)
    size = min(samples.size, max(2, round(rate))) if segment_size is None else segment_size
    raw = native(_native.welch, samples, rate, size, shapes[window], overlap, detrend)
    return Spectrum(numpy.arange(len(raw["density"])) * raw["resolution_hz"], **raw)


@dataclass(frozen=True)
class SineFit:
    """A sine amplitude cos(2 pi frequency t + phase) in a signal, t from its first sample.

    Attributes
    ----------
    frequency, amplitude, phase : Quantity
        Hz, the signal's unit, rad, each with its standard uncertainty.
    offset, residual_rms : float
        Mean, and RMS of what the sine and the drift leave, in the signal's unit.
    degrees_of_freedom : float
    """

    frequency: Quantity
    amplitude: Quantity
    phase: Quantity
    offset: float
    residual_rms: float
    degrees_of_freedom: float


def sine_fit(x: ArrayLike, rate: float, frequency: float | None = None, band: tuple[float, float] = _native.DEFAULT_BAND,
             noise_bandwidth: float = 0.0) -> SineFit | None:
    """Fits a sine by least squares (IEEE Std 1057).

    Parameters
    ----------
    x : array_like, shape (samples,)
    rate : float
        Samples per second, Hz.
    frequency : float, optional
        Where it is known, Hz; default the strongest tone within the band is looked for and its frequency fitted.
    band : (float, float)
        Where a tone is looked for, Hz.
    noise_bandwidth : float
        One-sided bandwidth of the noise, Hz; 0: white up to half the rate.

    Returns
    -------
    SineFit or None
        None: there is no tone, or the fit did not converge.

    Raises
    ------
    ValueError
        `x` has more than one dimension or a value that is not finite; the rate, the band, the frequency (above 0 and
        below half the rate) or the bandwidth of the noise (0 to half the rate) is impossible.
    """
    samples = _samples(x, rate)
    if not 0 <= noise_bandwidth <= rate / 2:
        raise ValueError(f"the noise's bandwidth is to be 0 to half the rate, not {noise_bandwidth!r} Hz")
    if frequency is None:
        _check_band(band, rate)
        raw = native(_native.strongest_tone, samples, rate, band, noise_bandwidth)
    else:
        if not 0 < frequency < rate / 2:
            raise ValueError(f"the frequency is to be above 0 and below half the rate, not {frequency!r} Hz")
        raw = native(_native.sine_fit_at, samples, rate, frequency, noise_bandwidth, 0)
    if raw is None or not raw["converged"]:
        return None
    return SineFit(Quantity(raw["frequency_hz"], raw["frequency_uncertainty_hz"], unit="Hz"),
                   Quantity(raw["amplitude"], raw["amplitude_uncertainty"]),
                   Quantity(raw["phase_rad"], raw["phase_uncertainty_rad"], unit="rad"), raw["offset"],
                   raw["residual_rms"], raw["degrees_of_freedom"])
