"""What the softening of dry friction costs: displacement, turn and work against the limit without softening.

    python benchmarks/softening.py > results/benchmarks/softening.md

The limit is simulated with a share of 1e-5: the last column says how far it is from being one.
"""

import sys

import numpy as np

from serpenoid import load, simulate

SHARES = (0.1, 0.03, 0.01, 0.003, 0.001, 0.0001)
LIMIT = 1e-5
GAITS = {
    "reference": ("problems/reference.toml", ()),
    "reference, eps 0.5": ("problems/reference.toml", ("medium.anisotropy_ratio=0.5",)),
    "reference, eps 0.9": ("problems/reference.toml", ("medium.anisotropy_ratio=0.9",)),
    "gait A": ("problems/gait-a.toml", ()),
    "a gait that turns (y_c = 3, xi = 0.7)": ("problems/reference.toml", ("gait.y_c=3.0", "gait.xi=0.7")),
    "small strokes (a = 1)": ("problems/reference.toml", ("gait.a=1.0",)),
    "a wave and a half, 40 joints": ("problems/reference.toml", ("gait.xi=1.5", "body.vertices=42")),
    "a stroke back and forth (sigma = 0.2)": ("problems/reference.toml", ("gait.sigma=0.2",)),
}


def motion(path: str, changes: tuple[str, ...], share: float) -> np.ndarray:
    """Displacement [body lengths], turn [rad], work of a cycle."""
    problem = load(path, set=["medium.law='coulomb'", f"medium.softening={share}", *changes])
    found = simulate(problem).trajectory
    assert found.status.ok, found.status
    return np.array([found.displacement, found.heading_change, found.dissipation])


def main() -> None:
    write = sys.stdout.write
    write(
        "# Softening of dry friction\n\nWhat a share changes beside one of 1e-5, of a cycle: displacement [body "
        "lengths], in brackets its part of the\ndisplacement. The last two lines: the most that a turn and the work "
        "change in any of them. `python benchmarks/softening.py`.\n\n"
    )
    write("| gait, all by dry friction | displacement | " + " | ".join(f"{s:g}" for s in SHARES) + " |\n")
    write("| :-- | --: |" + " --: |" * len(SHARES) + "\n")
    others = []
    for name, (path, changes) in GAITS.items():
        limit = motion(path, changes, LIMIT)
        off = np.array([motion(path, changes, s) for s in SHARES]) - limit
        others.append(np.abs(off[:, 1:] / [1.0, limit[2]]))
        cells = [f"{d:+.1e} ({100 * abs(d) / limit[0]:.2g} %)" for d in off[:, 0]]
        write(f"| {name} | {limit[0]:.4f} | " + " | ".join(cells) + " |\n")
    turn, work = np.array(others).max(0).T
    write("| largest change of a turn [rad] | | " + " | ".join(f"{t:.1e}" for t in turn) + " |\n")
    write("| largest change of the work | | " + " | ".join(f"{100 * w:.2g} %" for w in work) + " |\n")


if __name__ == "__main__":
    main()
