"""How often something is said to act in some trials alone, on floors that only differ from trial to trial.

    PYTHONPATH=src python benchmarks/changed_trials.py [DRAWS]

Drawn pairs of repeats, no campaigns: one cause has another size in every trial (SD over what one window tells of it;
0: windows' noise alone), twenty are tried, whose derivatives are alike by half. Gaits tell of a cause unlike: SD of the
logarithm of its derivatives. Pairs are of two rounds of all gaits, or at random. Stated: 1 %, a third of it each of
what begins, grows, and goes again.
"""

from __future__ import annotations

import sys

import numpy as np

from serpenoid.diagnose.residuals.in_some_trials import Cause, Differ, divided

WINDOWS, CAUSES = 60, 20
PAIRS, UNLIKE, SIZES = (3, 6, 12), (0.0, 0.7, 1.5), (0.0, 0.3, 8.0)


def alarm(rng: np.random.Generator, count: int, unlike: float, size: float, rounds: bool) -> bool:
    """Whether it is said of one drawn campaign with so many pairs."""
    order = np.arange(2 * count) if rounds else rng.permutation(2 * count)
    pairs = [tuple(sorted((int(order[p]), int(order[p + count])))) for p in range(count)]
    scale = np.exp(rng.normal(0, unlike, (count, 1, 1)))
    shared, own = rng.normal(size=(count, WINDOWS, 1)), rng.normal(size=(count, WINDOWS, CAUSES))
    slopes = np.sqrt(0.5) * (shared + own) * scale
    theta = rng.normal(0, size, 2 * count)
    left = [slopes[p, :, 0] * (theta[b] - theta[a]) + rng.normal(size=WINDOWS) for p, (a, b) in enumerate(pairs)]
    causes = [
        Cause(
            f"cause {i}", 0, np.array([s[:, [i]].T @ s[:, [i]] for s in slopes]),
            np.array([s[:, [i]].T @ d for s, d in zip(slopes, left, strict=True)]),
        )
        for i in range(CAUSES)
    ]  # fmt: skip
    differ = Differ(np.array([d @ d for d in left]), np.full(count, float(WINDOWS)))
    return divided(differ, causes, pairs, [f"trial {n}" for n in range(2 * count)]) is not None


def main() -> None:
    draws = int(sys.argv[1]) if len(sys.argv) > 1 else 400
    rng = np.random.default_rng(0)
    sys.stdout.write(f"| pairs | gaits unlike by | size | two rounds | at random |\n{'| --- ' * 5}|\n")
    for count in PAIRS:
        for unlike in UNLIKE:
            for size in SIZES:
                each = [sum(alarm(rng, count, unlike, size, r) for _ in range(draws)) for r in (True, False)]
                shares = " | ".join(f"{100 * n / draws:.1f} %" for n in each)
                sys.stdout.write(f"| {count} | {unlike:g} | {size:g} | {shares} |\n")


if __name__ == "__main__":
    main()
