"""Panels of a document by matplotlib."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.pyplot
from matplotlib.axes import Axes
from matplotlib.figure import Figure


def _colour(rgb: int) -> str:
    return f"#{rgb:06x}"


def _draw_series(axes: Axes, series: Mapping[str, Any]) -> None:
    x, y, colour = series["x"], series["y"], _colour(series["rgb"])
    label = series["title"] or None
    if series["is_box"]:
        axes.bar(x, y, color=colour, label=label)
    elif len(series["y_error"]) > 0:
        axes.errorbar(x, y, series["y_error"], fmt="o", color=colour, label=label)
    else:
        form = "-" if series["is_line"] else "o"
        axes.plot(x, y, form, color=colour, linewidth=series["width"], markersize=3, label=label)


def _draw_panel(axes: Axes, panel: Mapping[str, Any]) -> None:
    for title, rgb, intervals in panel["shades"]:
        for number, (begin, end) in enumerate(intervals):
            axes.axvspan(begin, end, color=_colour(rgb), alpha=0.3, label=title if title and number == 0 else None)
    for series in panel["series"]:
        _draw_series(axes, series)
    axes.set(title=panel["title"], xlabel=panel["x_label"], ylabel=panel["y_label"],
             xscale="log" if panel["x_is_log"] else "linear", yscale="log" if panel["y_is_log"] else "linear")
    if panel["ticks"]:
        axes.set_xticks([x for x, _ in panel["ticks"]], [name for _, name in panel["ticks"]])
    for ends, limit in ((panel["x_range"], axes.set_xlim), (panel["y_range"], axes.set_ylim)):
        if ends[0] < ends[1]:
            limit(*ends)
    if panel["equal_axes"]:
        axes.set_aspect("equal")
    if axes.get_legend_handles_labels()[1]:
        axes.legend(fontsize="small")


def draw(panels: Sequence[Mapping[str, Any]]) -> Figure:
    """A figure with the panels one below the other."""
    if not panels:
        raise ValueError("the answer has no panels: the verb has none, or was called with panels=False")
    figure = matplotlib.pyplot.figure(figsize=(8, 3 * len(panels)), layout="constrained")
    for number, panel in enumerate(panels):
        _draw_panel(figure.add_subplot(len(panels), 1, number + 1), panel)
    # the caller has it; a notebook would draw it a second time
    matplotlib.pyplot.close(figure)
    return figure
