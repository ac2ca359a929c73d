"""The paper's evaluation from start to figures: gaits found, played in the arena, compared, put beside what it printed.

Even et al. (2024), Sec. V: twelve random gaits and the same twelve improved, each within +-30 % of its own parameters;
three trials of three cycles; performance ratios Exp/Sim, Exp/Resim, Sim/Resim with anisotropy ratio 0.1865.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from serpenoid.arena.protocol import PlayedGait, PlayedRobot, Protocol, Start
from serpenoid.arena.robot import robot_of
from serpenoid.body import Floats
from serpenoid.files.inputs import read_json
from serpenoid.files.writing import write_json, write_text
from serpenoid.problem import Problem
from serpenoid.studies.gait_set import write_gait_set
from serpenoid.table_file import read_table, write_table

if TYPE_CHECKING:
    from serpenoid.compare.ratios import RatioStatistics

# what the paper prints: mean and SD of the quotients without the diagonal; s = sqrt(ln mean)
PAPER = {"Exp/Sim": (1.0410, 0.2974), "Exp/Resim": (1.0609, 0.3718), "Sim/Resim": (1.0932, 0.4801)}
PAPER_S = {"Exp/Sim": 0.2005, "Exp/Resim": 0.243, "Sim/Resim": 0.299}
WITHIN = 0.3
HEADINGS_DEG = (0.0, 120.0, 240.0)
Progress = Callable[[int, str], None]


def gait_tables(folder: Path, problem: Problem, count: int, seed: int, progress: Progress) -> dict[str, Floats]:
    """Joint tables of the random and improved gaits; those of an earlier run in `folder` are taken up again."""
    names = [f"{kind}-{number:02d}" for kind in ("random", "improved") for number in range(1, count + 1)]
    options = {"count": count, "seed": seed, "within": WITHIN, "problem": problem.hash}
    receipt = folder / "options.json"
    if not (receipt.is_file() and read_json(receipt) == options):
        _find_gaits(folder, problem, count, seed, progress)
        write_json(receipt, options)
    return {name: read_table(folder / "tables" / f"{name}.csv") for name in names}


def _find_gaits(folder: Path, problem: Problem, count: int, seed: int, progress: Progress) -> None:
    from serpenoid.errors import StopRequested
    from serpenoid.optimise.solve import improve

    pairs = improve(problem, count, WITHIN, seed, lambda done: progress(done, "improved"))
    if len(pairs) < count:
        raise StopRequested("The gaits were not all found; run the same command to begin again.")
    write_gait_set(folder, problem, pairs, {"within": WITHIN, "seed": seed})
    for number, pair in enumerate(pairs, 1):
        write_table(folder / "tables" / f"random-{number:02d}.csv", pair.table)
        write_table(folder / "tables" / f"improved-{number:02d}.csv", pair.solution.table)


def paper_protocol(problem: Problem, names: list[str], trials: int, seed: int) -> Protocol:
    """Three cycles of five seconds with two-second pauses on the problem's body; each trial starts another way."""
    return Protocol(
        name="the paper's protocol in the arena",
        description="Random gaits and the same improved, three cycles with pauses, repeated from three headings.",
        seed=seed,
        trials=trials,
        gait=tuple(PlayedGait(name=name, joint_table=f"gaits/{name}.csv") for name in names),
        start=Start(headings_deg=HEADINGS_DEG),
        robot=PlayedRobot.model_validate(robot_of(problem.body)),
    )


def beside_the_paper(ratios: tuple[RatioStatistics, ...]) -> list[dict[str, Any]]:
    """One record per pair of classes: what the arena gave, what the paper printed."""
    from serpenoid.compare.records import plain

    return [
        {
            "pair": found.pair,
            "mean": found.mean,
            "std": found.std,
            "s": found.s,
            "s_interval": list(found.s_interval),
            "bias": found.bias,
            "rank_correlation": plain(found.rank_correlation),
            "paper_mean": PAPER[found.pair][0],
            "paper_std": PAPER[found.pair][1],
            "paper_s": PAPER_S[found.pair],
        }
        for found in ratios
    ]


def write_beside(folder: Path, rows: list[dict[str, Any]]) -> None:
    """`beside-the-paper.json` and `.md`."""
    write_json(folder / "beside-the-paper.json", rows)
    head = ["| pair | mean | paper | SD | paper | s | paper | bias | rank correlation |", "| --- " * 9 + "|"]
    lines = [
        f"| {r['pair']} | {r['mean']:.4f} | {r['paper_mean']:.4f} | {r['std']:.4f} | {r['paper_std']:.4f} "
        f"| {r['s']:.4f} | {r['paper_s']:.4f} | {r['bias']:.3f} | {_cell(r['rank_correlation'])} |"
        for r in rows
    ]
    write_text(folder / "beside-the-paper.md", "\n".join([*head, *lines]) + "\n")


def _cell(value: float | None) -> str:
    """A rank correlation needs three gaits."""
    return "" if value is None else f"{value:.3f}"
