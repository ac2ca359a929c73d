"""Figures of a diagnosis, drawn in a process beside it as soon as what they show is known, and its report at last."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from serpenoid.body import Floats
    from serpenoid.diagnose.diagnose import Diagnosis
    from serpenoid.diagnose.inference.search.select import Selection
    from serpenoid.diagnose.stages.ladder import Step
    from serpenoid.parallel import Beside


class Pictures:
    """What goes into `folder`; artist: the process that draws, None: nothing is drawn and no report written."""

    def __init__(self, folder: Path, artist: Beside | None) -> None:
        self._folder, self._artist = folder, artist
        self._awaited: list[Callable[[], object]] = []

    def of_shapes(self, steps: Sequence[Step]) -> None:
        """Begin those that the ladder's first steps tell, before the motion is judged."""
        self._ask(_shapes, steps)

    def of_motion(self, found: Selection) -> None:
        """Begin those that the search for effects alone tells."""
        self._ask(_motion, found)

    def of_rest(self, found: Diagnosis) -> None:
        """Begin those that need the whole diagnosis."""
        self._ask(_rest, found)

    def in_report(self, found: Diagnosis, record: dict[str, Any]) -> None:
        """Begin the next experiment's, wait for all, and write the report that shows them."""
        if self._artist is None:
            return
        from serpenoid.diagnose.report.animate import animated
        from serpenoid.diagnose.report.pages import write_pages
        from serpenoid.table_file import read_table

        proposed = record["next_experiment"]
        if proposed:
            self._ask(_experiment, read_table(self._folder / proposed["joint_table"]))
        write_pages(self._folder, record, animated(found), self._wait)

    def of_changed(self, found: Diagnosis, record: dict[str, Any]) -> None:
        """All of trials in which something acts alone, if there are any, and their report."""
        if found.changed is None:
            return
        own, told = Pictures(self._folder / record["changed_trials"]["folder"], self._artist), found.changed.found
        own.of_shapes(told.ladder)
        own.of_motion(told.motion.selection)
        own.of_rest(told)
        own.in_report(told, record["changed_trials"]["diagnosis"])

    def _ask(self, draw: Callable[[Path, Any], object], what: object) -> None:
        if self._artist is not None:
            self._awaited.append(self._artist.ask(draw, self._folder, what))

    def _wait(self) -> None:
        for drawn in self._awaited:
            drawn()


def prepare() -> None:
    """What drawing needs takes as long to import as a stage takes to judge, and the first figure longer than others."""
    import serpenoid.plot.diagnosis  # noqa: F401
    from serpenoid.plot.both import rehearse

    rehearse()


def _shapes(folder: Path, steps: Sequence[Step]) -> None:
    from serpenoid.plot.diagnosis import draw_shapes

    draw_shapes(folder, steps)


def _motion(folder: Path, found: Selection) -> None:
    from serpenoid.plot.diagnosis import draw_motion

    draw_motion(folder, found)


def _rest(folder: Path, found: Diagnosis) -> None:
    from serpenoid.plot.diagnosis import draw_rest

    draw_rest(folder, found)


def _experiment(folder: Path, table: Floats) -> None:
    from serpenoid.plot.diagnosis import draw_experiment

    draw_experiment(folder, table)
