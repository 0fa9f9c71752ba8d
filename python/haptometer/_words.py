"""Calls of verbs: Python values become the words of a command line."""
from __future__ import annotations

import numbers
import os
import pathlib
import tempfile
import warnings
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, TypeVar, Union

import numpy

from haptometer import _native
from haptometer.answer import Answer, Sweep, error_of
from haptometer.quantity import Quantity
from haptometer.scene import Scene
from haptometer.trial import Trial, path_of

Path = Union[str, "os.PathLike[str]"]
File = Union[Path, Trial, Scene]
Files = Union[File, Iterable[File]]
Number = Union[float, Quantity, str]
Pair = Union[str, tuple[float, float], Sequence[float]]
Values = Union[str, float, Quantity, Iterable[float]]
Texts = Union[str, Sequence[Union[str, tuple[str, str]]]]
Labels = Union[str, Sequence[str], Mapping[str, str]]
AnswerType = TypeVar("AnswerType", bound=Answer)


@dataclass(frozen=True)
class Option:
    """An option of a command and what it is given.

    name: "--drop-height". unit: of its numbers. between: what stands between the two numbers of a pair. ending: what
    stands behind a pair. is_list: several values at a time. is_repeated: may be given several times. is_flag: True
    stands for the option alone. is_pair: takes two numbers.
    """

    name: str
    given: Any
    unit: str = ""
    between: str = ":"
    ending: str = ""
    is_list: bool = False
    is_repeated: bool = False
    is_flag: bool = False
    is_pair: bool = False


class Text(str):
    """A positional argument that is no file."""


def texts(given: Any) -> list[Text]:
    """Positional arguments that are no files: a text, several, or {"subject": "3"} for subject=3."""
    if given is None:
        return []
    if isinstance(given, Mapping):
        return [Text(f"{key}={one}") for key, one in given.items()]
    return [Text(given)] if isinstance(given, str) else [Text(one) for one in given]


def on_disk(given: Any) -> Any:
    """A file that the verb changes."""
    if isinstance(given, (Trial, Scene)):
        raise TypeError("this changes a file: give its path")
    return given


class Words:
    """The words of one call; files that it writes for it live as long as it does."""

    def __init__(self) -> None:
        self._stack = ExitStack()
        self._folder: pathlib.Path | None = None
        self._files = 0

    def __enter__(self) -> Words:
        return self

    def __exit__(self, *error: object) -> None:
        self._stack.close()

    def new_file(self, name: str) -> str:
        """A path in a folder of its own, which is removed behind the call."""
        if self._folder is None:
            self._folder = pathlib.Path(self._stack.enter_context(tempfile.TemporaryDirectory(prefix="haptometer-")))
        self._files += 1
        folder = self._folder / str(self._files)
        folder.mkdir()
        return str(folder / name)

    def file(self, given: Any) -> str:
        """The path of a file; a trial or scene that is not in a file as it is here is written first."""
        if isinstance(given, Text):
            return given
        if isinstance(given, Trial):
            if given.path is not None and given.is_as_read():
                return given.path
            path = self.new_file(os.path.basename(given.path or "arrays") + ".bin")
            given.save(path)
            return path
        if isinstance(given, Scene):
            if given.path is not None and given.is_as_read():
                return given.path
            path = self.new_file("scene.toml")
            pathlib.Path(path).write_text(given.text_elsewhere(), encoding="utf-8")
            return path
        if not isinstance(given, (str, bytes, os.PathLike)):
            raise TypeError(f"a file is a path, a Trial or a Scene, not {type(given).__name__}")
        return path_of(given)

    def files(self, given: Any) -> list[str]:
        """One file or several."""
        if isinstance(given, (str, bytes, os.PathLike, Trial, Scene)) or not isinstance(given, Iterable):
            return [self.file(given)]
        return [self.file(one) for one in given]

    def word(self, given: Any, option: Option) -> str:
        """One value."""
        if isinstance(given, (Trial, Scene, os.PathLike)):
            return self.file(given)
        if isinstance(given, Quantity):
            return _quantity(given, option)
        if isinstance(given, str):
            return path_of(given) if given == "-" else given
        if _is_array(given):
            if option.is_pair or isinstance(given, tuple):
                return option.between.join(_number(one, option) for one in given) + option.ending
            return ",".join(_number(one, option, has_unit=False) for one in given)
        return _number(given, option)

    def of(self, option: Option) -> list[str]:
        """The words of an option; none where nothing is given."""
        given = option.given
        if given is None or (option.is_flag and given is False):
            return []
        if option.is_flag and given is True:
            return [option.name]
        if _is_bool(given):
            raise TypeError(f"{option.name} takes a value, not {given}")
        if isinstance(given, Mapping):
            return [word for key, one in given.items() for word in self._pair(key, one, option)]
        if option.is_list:
            return [option.name, *_some(option, self.files(given))]
        if option.is_repeated and _is_array(given):
            return [f"{option.name}={self.word(one, option)}" for one in given]
        word = self.word(given, option)
        if not word:
            raise ValueError(f"{option.name}: nothing is given; None leaves it out")
        return [f"{option.name}={word}"]

    def _pair(self, key: Any, given: Any, option: Option) -> list[str]:
        """{33.0: files} is `--load 33.0ohm files`, {"subject": "3"} is `--label subject=3`."""
        if option.is_list:
            return [option.name, self.word(key, option), *_some(option, self.files(given))]
        word = self.word(given, Option(option.name, given))
        if not isinstance(key, str) or "=" in key or not key or not word:
            raise ValueError(f"{option.name}: {key!r}: {given!r} is no key with a value")
        return [f"{option.name}={key}={word}"]


def _some(option: Option, words: list[str]) -> list[str]:
    if not words:
        raise ValueError(f"{option.name}: no file is given; None leaves it out")
    return words


def _is_bool(given: Any) -> bool:
    return isinstance(given, (bool, numpy.bool_))


def _is_array(given: Any) -> bool:
    return isinstance(given, Iterable) and getattr(given, "ndim", 1) > 0 and not isinstance(given, (str, bytes))


def _quantity(given: Quantity, option: Option) -> str:
    if given.unit and option.unit and given.unit != option.unit:
        raise ValueError(f"{option.name} is in {option.unit}, not in {given.unit}")
    uncertainty = f"+-{given.u!r}" if given.u else ""
    return f"{float(given)!r}{uncertainty}{option.unit}"


def _number(given: Any, option: Option, has_unit: bool = True) -> str:
    """A number as it is typed, with every digit; int stays whole, for counts."""
    if isinstance(given, str):
        return given
    if isinstance(given, Quantity):
        return repr(float(given))
    number = given.item() if isinstance(given, (numpy.generic, numpy.ndarray)) else given
    if _is_bool(number) or not isinstance(number, numbers.Real):
        raise TypeError(f"{option.name} takes numbers and texts, not {type(given).__name__}")
    number = int(number) if isinstance(number, numbers.Integral) else float(number)
    # an exponent's sign would be taken for what stands between a pair
    digits = numpy.format_float_positional(number, trim="0") if option.between == "-" else repr(number)
    return digits + (option.unit if has_unit else "")


def _said(words: Words, verb: Sequence[str], files: Sequence[Any], options: Sequence[Option]) -> list[str]:
    """The words of a call: positional arguments, of which None is left out, and options."""
    said = list(verb)
    for one in files:
        said += [] if one is None else words.files(one)
    for option in options:
        said += words.of(option)
    return said


def answer(kind: type[AnswerType], words: Sequence[str], panels: bool) -> AnswerType:
    """What the command answers.

    Raises
    ------
    HaptometerError
        The command has no answer to show; the text is what it prints.
    KeyboardInterrupt
        Ctrl-C ended it.
    """
    made = _native.call(list(words), panels)
    if not made.has_document or made.status not in (0, 3):
        raise error_of(made.status, made.errors)
    answered = kind._of(made)
    for line in made.errors.splitlines():
        warnings.warn(line, stacklevel=4)
    return answered  # type: ignore[return-value]


def call(kind: type[AnswerType], verb: Sequence[str], files: Sequence[Any], options: Sequence[Option],
         panels: bool) -> AnswerType:
    """Calls a verb."""
    with Words() as words:
        return answer(kind, _said(words, [*verb, "--json"], files, options), panels)


def call_writer(verb: Sequence[str], files: Sequence[Any], options: Sequence[Option]) -> None:
    """Calls a verb that writes a file and has no other answer."""
    with Words() as words:
        made = _native.call(_said(words, verb, files, options), False)
        if made.status != 0:
            raise error_of(made.status, made.errors)


def call_sweep(verb: Sequence[str], files: Sequence[Any], options: Sequence[Option], panels: bool) -> Sweep:
    """Calls `sweep`, whose table is read; without `output` it is written nowhere else."""
    with Words() as words:
        given = next(option.given for option in options if option.name == "--output")
        table = words.new_file("sweep.csv") if given is None else words.file(given)
        others = [option for option in options if option.name != "--output"]
        said = _said(words, [*verb, "--json"], files, [*others, Option("--output", table)])
        made = answer(Sweep, said, panels)
        text = pathlib.Path(table).read_text(encoding="utf-8")
        return Sweep(made.answered, made.findings, made.root, made._made, text)
