"""The report: one file that needs no other, the verdict first; its figures, labelled."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from serpenoid.diagnose.diagnose import Diagnosis
from serpenoid.diagnose.maps import windows
from serpenoid.diagnose.report import write_pages
from serpenoid.plot import diagnosis, diagnosis_ladder, diagnosis_maps

ORDER = ["Before and after", "Evidence", "Ranking", "Residual maps: shape", "Residual maps: motion", "Alternatives"]


@pytest.fixture(scope="module")
def report(diagnosed: tuple[Diagnosis, dict[str, Any], Path]) -> tuple[str, list[str]]:
    """The page and the names of its figures, with some joint table as the next experiment."""
    d, record, out = diagnosed
    names = diagnosis.draw_all(out, d, np.zeros((20, 10)))
    write_pages(out, record)
    return (out / "report.html").read_text(encoding="utf-8"), names


def test_the_report_needs_no_other_file(report: tuple[str, list[str]]) -> None:
    page, names = report
    sources = re.findall(r'(?:src|href)\s*=\s*"([^"]*)"', page)
    assert len(sources) == len(names)
    assert all(s.startswith("data:image/svg+xml;base64,") for s in sources)
    assert not re.search(r"url\(|@import|<link", page)


def test_the_verdict_comes_first_and_everything_else_in_order(report: tuple[str, list[str]]) -> None:
    page = report[0]
    text = re.sub(r"<[^>]+>", " ", page)
    assert text.index("snake10, two: explained") < text.index("load at vertex 2") < text.index("Before and after")
    assert "gain_loss at joint 3" in text
    headings = re.findall(r"<h2>([^<]*)</h2>", page)
    places = [next(i for i, h in enumerate(headings) if h.startswith(name)) for name in ORDER]
    assert places == sorted(places)


def test_a_report_without_figures_still_reads(
    diagnosed: tuple[Diagnosis, dict[str, Any], Path], tmp_path: Path
) -> None:
    write_pages(tmp_path, diagnosed[1])
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "<img" not in page
    assert "load at vertex 2" in page


def test_all_axes_are_labelled_with_units(diagnosed: tuple[Diagnosis, dict[str, Any], Path]) -> None:
    d = diagnosed[0]
    found = d.motion.selection
    w = windows(found.motion, found.null.predictions, found.best.predictions)
    parts = [s for s in d.ladder if s.error.name in diagnosis.PARTS]
    figures = [
        diagnosis.paths_figure(d),
        diagnosis_ladder.ladder_figure(d.ladder),
        *(diagnosis_ladder.parts_figure(s) for s in parts),
        diagnosis_maps.body_figure(w, True, found.scores),
        diagnosis_maps.floor_figure(w, True),
    ]
    unlike = {"joint", "vertex", "vertex (0 = tail)", "chi squared on held-out gaits", "RMS over chance", ""}
    for fig in figures:
        shown = [ax for ax in fig.axes if ax.axison]
        labels = {text for ax in shown for text in (ax.get_xlabel(), ax.get_ylabel())}
        assert all(ax.get_ylabel() for ax in shown)
        assert all(re.search(r"\[.+\]$", text) for text in labels - unlike), labels
    grid = diagnosis_maps.residuals_figure(w, True).axes
    assert [ax.get_ylabel() for ax in grid[::3]] == ["forward [mm/s]", "to the left [mm/s]", "turning left [°/s]"]
    assert all(ax.get_xlabel() for ax in grid[6:])
