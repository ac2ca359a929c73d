"""How independent of one another are a law's errors in one gait: in its directions, and in its phases?

python benchmarks/independent_errors.py KEY NUMBER CHANGE ... > results/benchmarks/independent_errors.md

Robots of tests/arena/any_robot.py, one change each, diagnosed beside the healthy robot. With d the difference in
-2 ln likelihood of a mean between the answer and another single change: the variance over gaits of the sum of d, over
the sum of the variances of its parts. 1: parts are independent; as many as there are parts: they are one number.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from arena.any_robot import draw, hidden_of, play  # noqa: E402
from arena.hidden import Hidden  # noqa: E402
from arena.study import diagnosed  # noqa: E402
from serpenoid.body import Floats  # noqa: E402
from serpenoid.diagnose.inference.doubt.explanations import singles  # noqa: E402
from serpenoid.diagnose.inference.search.discrepancy import surprises  # noqa: E402
from serpenoid.diagnose.reference import reference_of  # noqa: E402

DIRECTIONS, WINDOWS = 3, 8  # of a mean; of a cycle


def inflated(apart: Floats, labels: np.ndarray, part: np.ndarray) -> float:
    """Variance over gaits of the sum over that of parts; part (K,): which one a mean belongs to."""
    gaits, parts = sorted(set(labels)), sorted(set(part))
    sums = np.array([[apart[(labels == g) & (part == p)].sum() for p in parts] for g in gaits])
    return float(sums.sum(axis=1).var(ddof=1) / sums.var(axis=0, ddof=1).sum())


def main() -> None:
    cases = np.reshape(sys.argv[1:], (-1, 3))
    head = "robot", "change", "gaits", "other changes", "directions (3)", "quarters (4)", "directions and halves (6)"
    sys.stdout.write(f"| {' | '.join(head)} |\n{'| --- ' * len(head)}|\n")
    for key, number, change in cases:
        with tempfile.TemporaryDirectory() as folder:
            sys.stdout.write(_row(str(key), int(number), str(change), Path(folder)) + "\n")
            sys.stdout.flush()


def _row(key: str, number: int, change: str, work: Path) -> str:
    drawn = draw(key, number)
    then = play(work, drawn, "healthy", key, Hidden())
    model = work / str(drawn.seed) / "robot.toml"
    healthy, _ = diagnosed(then / "campaign", None, then / "diagnosis", model)
    now = play(work, drawn, change, key, hidden_of(drawn)[change])
    found, _ = diagnosed(now / "campaign", reference_of(healthy), now / "diagnosis", model)
    chosen = found.motion.selection
    motion, best = chosen.motion, chosen.best
    own, labels = surprises(motion, best)
    direction = np.arange(len(own)) % DIRECTIONS
    window = np.concatenate([np.arange((labels == g).sum()) // DIRECTIONS % WINDOWS for g in dict.fromkeys(labels)])
    several = {"directions": direction, "quarters": window // 2, "halves": direction + DIRECTIONS * (window // 4)}
    mine = {e.key for e in best.effects}
    rivals = [t.fit for t in singles(motion, chosen.null.model) if {e.key for e in t.fit.effects} != mine]
    apart = [surprises(motion, f)[0] - own for f in rivals]
    ratios = [np.mean([inflated(d, labels, part) for d in apart]) for part in several.values()]
    numbers = " | ".join(f"{x:.2f}" for x in ratios)
    return f"| {key}, {number} | {change} | {len(set(labels))} | {len(rivals)} | {numbers} |"


if __name__ == "__main__":
    main()
