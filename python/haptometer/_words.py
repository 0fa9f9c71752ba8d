"""Calls of verbs: Python values become the words of a command line."""
from __future__ import annotations

import os
import pathlib
import tempfile
import warnings
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, TypeVar, Union

from haptometer import _native
from haptometer.answer import Answer, Sweep, error_of
from haptometer.quantity import Quantity
from haptometer.scene import Scene
from haptometer.trial import Trial

Path = Union[str, "os.PathLike[str]"]
File = Union[Path, Trial, Scene]
Files = Union[File, Sequence[File]]
Number = Union[float, Quantity, str]
Pair = Union[str, tuple[float, float]]
Values = Union[str, float, Quantity, Iterable[float]]
Texts = Union[str, Sequence[str]]
AnswerType = TypeVar("AnswerType", bound=Answer)


@dataclass(frozen=True)
class Option:
    """An option of a command and what it is given.

    name: "--drop-height". unit: of its numbers. between: what stands between the two numbers of a pair. ending: what
    stands behind a pair. is_list: several values at a time.
    """

    name: str
    given: Any
    unit: str = ""
    between: str = ":"
    ending: str = ""
    is_list: bool = False


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
        """The path of a file; a trial or scene in memory is written first."""
        if isinstance(given, Trial):
            if given.path is not None:
                return self.file(given.path)
            path = self.new_file("arrays.bin")
            given.save(path)
            return path
        if isinstance(given, Scene):
            if given.path is not None:
                return self.file(given.path)
            path = self.new_file("scene.toml")
            pathlib.Path(path).write_text(given.text, encoding="utf-8")
            return path
        path = os.fspath(given)
        return f"./{path}" if path.startswith("-") else path

    def word(self, given: Any, option: Option) -> str:
        """One value."""
        if isinstance(given, (Trial, Scene, os.PathLike)):
            return self.file(given)
        if isinstance(given, Quantity):
            uncertainty = f"+-{given.u!r}" if given.u else ""
            return f"{float(given)!r}{uncertainty}{option.unit}"
        if isinstance(given, tuple):
            return option.between.join(_number(one, option.unit) for one in given) + option.ending
        if isinstance(given, str):
            return given
        if isinstance(given, Iterable):
            return ",".join(_number(one, "") for one in given)
        return _number(given, option.unit)

    def of(self, option: Option) -> list[str]:
        """The words of an option; none where nothing is given."""
        given = option.given
        if given is None or given is False:
            return []
        if given is True:
            return [option.name]
        if isinstance(given, Mapping):
            return [word for key, one in given.items() for word in self._pair(key, one, option)]
        if option.is_list:
            return [option.name, *self.files(given)]
        if isinstance(given, list):
            return [f"{option.name}={self.word(one, option)}" for one in given]
        return [f"{option.name}={self.word(given, option)}"]

    def _pair(self, key: Any, given: Any, option: Option) -> list[str]:
        """{33.0: files} is `--load 33.0ohm files`, {"subject": "3"} is `--label subject=3`."""
        if option.is_list:
            first = key if isinstance(key, str) else f"{float(key)!r}{option.unit}"
            return [option.name, first, *self.files(given)]
        return [f"{option.name}={key}={self.word(given, option)}"]

    def files(self, given: Any) -> list[str]:
        """One file or several."""
        some = given if isinstance(given, (list, tuple)) else [given]
        return [self.file(one) for one in some]


def _number(given: Any, unit: str) -> str:
    if isinstance(given, str):
        return given
    # numpy's numbers and bools too; int stays whole, for counts
    number = given.item() if hasattr(given, "item") else given
    return f"{number!r}{unit}"


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
    """Calls a verb with positional arguments, of which None is left out, and options."""
    with Words() as words:
        said = list(verb)
        for one in files:
            said += [] if one is None else words.files(one)
        for option in options:
            said += words.of(option)
        return answer(kind, said, panels)


def call_sweep(verb: Sequence[str], files: Sequence[Any], options: Sequence[Option], panels: bool) -> Sweep:
    """Calls `sweep`, whose table is read; without `output` it is written nowhere else."""
    with Words() as words:
        said = list(verb)
        for one in files:
            said += [] if one is None else words.files(one)
        path = next((words.file(option.given) for option in options
                     if option.name == "--output" and option.given is not None), None)
        table = path or words.new_file("sweep.csv")
        for option in options:
            said += [] if option.name == "--output" else words.of(option)
        said.append(f"--output={table}")
        made = answer(Sweep, said, panels)
        text = pathlib.Path(table).read_text(encoding="utf-8")
        return Sweep(made.answered, made.findings, made.root, made._made, text)
