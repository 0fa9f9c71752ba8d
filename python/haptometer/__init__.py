"""Vibration of tactile actuators by laser: read, analyse, identify, simulate.

The functions of verbs (`analyze`, `fit_lra`, `simulate`, ...) do what the commands do and answer with the same
documents; parameters are the commands' options. Numbers are in SI units.
"""
from haptometer import verbs
from haptometer.answer import (Analysis, Answer, CannotAnswerError, Finding, Fit, HaptometerError, Section, Simulation,
                               Sweep, UsageError)
from haptometer.quantity import Quantity, value
from haptometer.scene import Scene
from haptometer.signals import SineFit, Spectrum, bandpass, sine_fit, welch
from haptometer.trial import STATUSES, Channel, Segment, Trial, read
from haptometer.verbs import *  # noqa: F403

__all__ = ["Analysis", "Answer", "CannotAnswerError", "Channel", "Finding", "Fit", "HaptometerError", "Quantity",
           "STATUSES", "Scene", "Section", "Segment", "Simulation", "SineFit", "Spectrum", "Sweep", "Trial",
           "UsageError", "bandpass", "read", "sine_fit", "value", "welch", *verbs.__all__]
