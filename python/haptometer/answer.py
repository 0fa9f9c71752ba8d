"""What verbs answer: documents of quantities, tables and findings."""
from __future__ import annotations

import html
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from haptometer import _native
from haptometer.quantity import Quantity

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure


class HaptometerError(Exception):
    """The command failed; the text is what it prints. `status` is its exit status."""

    def __init__(self, text: str, status: int = 1) -> None:
        super().__init__(text)
        self.status = status


class UsageError(HaptometerError, ValueError):
    """The question is put wrongly: a parameter, a unit, a key of a file."""


class CannotAnswerError(HaptometerError):
    """The file does not hold the answer, or is not there."""


def error_of(status: int, text: str) -> HaptometerError:
    """The exception of an exit status."""
    kind = {2: UsageError, 3: CannotAnswerError}.get(status, HaptometerError)
    return kind(text.strip() or f"exit status {status}", status)


@dataclass(frozen=True)
class Finding:
    """A refusal (why there is no answer), a doubt (why it may be wrong) or a note (what was assumed).

    Attributes
    ----------
    kind : str
        Its name: "few-readings".
    severity : str
        "refusal", "doubt" or "note".
    text : str
        One sentence.
    subject : str
        File, channel or record; empty: the whole.
    numbers : dict
        The numbers in the sentence, in SI units.
    """

    kind: str
    severity: str
    text: str
    subject: str = ""
    numbers: Mapping[str, Any] = field(default_factory=dict)


class Section(Mapping[str, Any]):
    """A part of a document under the names of the JSON: `section.band_rms_m` or `section["band_rms_m"]`.

    Numbers are Quantity, counts int; a part is a Section, a table a tuple of them. None: not determined.
    """

    def __init__(self, content: Mapping[str, Any]) -> None:
        self._content = dict(content)

    def __getitem__(self, name: str) -> Any:
        return self._content[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._content)

    def __len__(self) -> int:
        return len(self._content)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        if name not in self._content:
            raise AttributeError(f"no {name}; there are {', '.join(self._content)}")
        return self._content[name]

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._content]

    def __repr__(self) -> str:
        return "Section(" + ", ".join(f"{name}={_short(part)}" for name, part in self.items()) + ")"


def _short(part: Any) -> str:
    if isinstance(part, Section):
        return "Section(...)"
    if isinstance(part, tuple) and part and isinstance(part[0], Section):
        return f"<table of {len(part)} rows>"
    return str(part) if isinstance(part, Quantity) else repr(part)


def _item(raw: Mapping[str, Any]) -> Any:
    known = raw["value"]
    if known is None and raw["at_most"] is None:
        return None
    if known is not None and type(known) is not float:
        return known
    return Quantity(known, raw["u"], raw["interval"], raw["unit"], raw["label"], raw["at_most"], raw["note"])


def _content(raw: Mapping[str, Any]) -> dict[str, Any]:
    """What a section holds; a part without a name belongs to the section around it."""
    content = {item["name"]: _item(item) for item in raw["items"]}
    for part in raw["sections"]:
        name = part["name"]
        if part["is_list"] and not name:
            continue  # of a text alone
        if part["is_list"]:
            rows = tuple(Section(_content(row)) for row in part["sections"])
            content[name] = (content.get(name) or ()) + rows if part["is_known"] else None
        elif name:
            content[name] = Section(_content(part)) if part["is_known"] else None
        else:
            content |= _content(part)
    return content


def _cells(row: Mapping[str, Any], before: str = "") -> dict[str, Any]:
    """The fields of a row of a table; those of a part within it behind the part's name."""
    cells: dict[str, Any] = {}
    for name, part in row.items():
        if isinstance(part, Quantity):
            cells[before + name] = part.value
            if part.u is not None:
                cells[f"{before}{name}_u"] = part.u
        elif isinstance(part, Section):
            cells |= _cells(part, f"{before}{name}.")
        elif not (isinstance(part, tuple) and part and isinstance(part[0], Section)):
            cells[before + name] = part
    return cells


@dataclass(frozen=True)
class Answer:
    """What a verb answers. Its parts are attributes under the names of the JSON.

    Attributes
    ----------
    answered : bool
        Whether there is an answer; a refusal is among the findings otherwise.
    findings : tuple of Finding
        Refusals, doubts and notes.
    root : Section
        The document's parts.
    """

    answered: bool
    findings: tuple[Finding, ...]
    root: Section
    _made: _native.Answer = field(repr=False, compare=False)

    @classmethod
    def _of(cls, made: _native.Answer) -> Answer:
        found = json.loads(made.json).get("findings", [])
        findings = tuple(Finding(**(one | {"subject": one["subject"] or ""})) for one in found)
        return cls(made.status == 0, findings, cls._root(Section(_content(made.root()))), made)

    @classmethod
    def _root(cls, document: Section) -> Section:
        return document

    @property
    def reasons(self) -> tuple[str, ...]:
        """Why there is no answer: the sentences of the refusals."""
        return tuple(finding.text for finding in self.findings if finding.severity == "refusal")

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self.root, name)

    def __getitem__(self, name: str) -> Any:
        return self.root[name]

    def __contains__(self, name: object) -> bool:
        return name in self.root

    def __iter__(self) -> Iterator[str]:
        return iter(self.root)

    def __len__(self) -> int:
        return len(self.root)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.root]

    def to_dict(self) -> dict[str, Any]:
        """The JSON of the command without its time and command line, which are of this call."""
        document: dict[str, Any] = json.loads(self._made.json)
        for name in ("utc", "command"):
            document.get("provenance", {}).pop(name, None)
        return document

    def to_pandas(self, table: str | None = None) -> pandas.DataFrame:
        """A table of the document as a frame, in SI units.

        Parameters
        ----------
        table : str, optional
            The table's name; default the first one. A document without a table is a frame of its quantities.

        Raises
        ------
        KeyError
            There is no such table.
        """
        import pandas

        tables = {name: part for name, part in self.root.items()
                  if isinstance(part, tuple) and part and isinstance(part[0], Section)}
        if table is None and not tables:
            rows = {name: vars(part) for name, part in self.root.items() if isinstance(part, Quantity)}
            return pandas.DataFrame.from_dict(rows, orient="index")
        name = next(iter(tables)) if table is None else table
        return pandas.DataFrame([_cells(row) for row in tables[name]])

    def plot(self) -> Figure:
        """Draws the document's panels by matplotlib, one below the other.

        Raises
        ------
        ValueError
            The document has no panels: the verb has none, or was called with `panels=False`.
        """
        from haptometer._plot import draw

        return draw(self._made.panels())

    def __str__(self) -> str:
        return self._made.text()

    def _repr_html_(self) -> str:
        page = html.escape(self._made.html())
        return f'<iframe srcdoc="{page}" style="width:100%;height:40em;border:0"></iframe>'


@dataclass(frozen=True)
class Analysis(Answer):
    """What `analyze` answers of one trial; its parts are those of the trial."""

    @classmethod
    def _of(cls, made: _native.Answer) -> Answer:
        # what the command prints as an error of the file; a refusal of its data prints none
        if made.status != 0 and made.errors:
            raise error_of(made.status, made.errors)
        return super()._of(made)

    @classmethod
    def _root(cls, document: Section) -> Section:
        trials: tuple[Section, ...] = document["trials"]
        if len(trials) != 1:
            raise UsageError(f"analyze takes one recording, not {len(trials)}; analyze_many takes several", 2)
        return trials[0]

    @property
    def rms(self) -> Quantity | None:
        """Vibration: RMS displacement within the band, m; None: not determined."""
        found: Quantity | None = self.root.get("band_rms_m")
        return found

    @property
    def tone_frequency(self) -> Quantity | None:
        """Frequency of the strongest tone, Hz; None: not determined."""
        found: Quantity | None = self.root.get("tone_frequency_hz")
        return found

    @property
    def tone_amplitude(self) -> Quantity | None:
        """Amplitude of the strongest tone, m; None: not determined."""
        found: Quantity | None = self.root.get("tone_amplitude_m")
        return found


@dataclass(frozen=True)
class Fit(Answer):
    """What `fit_lra` and `fit_impedance` answer."""

    def _constant(self, name: str) -> Quantity | None:
        found: Quantity | None = self.root["parameters"].get(name)
        return found

    @property
    def kv(self) -> Quantity | None:
        """Stiffness Kv, N/m; None: not determined."""
        return self._constant("Kv")

    @property
    def bv(self) -> Quantity | None:
        """Damping Bv, N s/m; None: not determined."""
        return self._constant("Bv")

    @property
    def km(self) -> Quantity | None:
        """Force constant Km, N/A; None: not determined."""
        return self._constant("Km")


@dataclass(frozen=True)
class Simulation(Answer):
    """What `simulate` answers."""

    @property
    def skin_rms(self) -> Quantity | None:
        """RMS displacement of the skin, m."""
        found: Quantity | None = self.root.get("skin_rms_m")
        return found


@dataclass(frozen=True)
class Sweep(Answer):
    """What `sweep` answers, with its table.

    Attributes
    ----------
    table_text : str
        The table as the command writes it: comments, header, a row for each point.
    """

    table_text: str = field(default="", repr=False, compare=False)

    def to_pandas(self, table: str | None = None) -> pandas.DataFrame:
        """The table with a row for each point, or a part of the document by its name."""
        if table is not None:
            return super().to_pandas(table)
        import io

        import pandas

        return pandas.read_csv(io.StringIO(self.table_text), comment="#", float_precision="round_trip")
