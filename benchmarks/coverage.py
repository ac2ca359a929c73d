"""Does the 95 % interval cover the truth? 200 recordings of one known motion, written to Motive CSV and read back.

    PYTHONPATH=src python benchmarks/coverage.py [SEEDS]
    PYTHONPATH=src python benchmarks/coverage.py 40 without-lengths    # cameras alone; prints only

Each seed: the model's own motion (snake10, a = 6, eps = 0.1865, a cycle in 5 s at 120 frames a second), 0.2 mm marker
noise, 5 % of all marker positions hidden, written as a Motive export, read, aligned, fitted; once with the
cameras alone and once with the servo log (rounded to ticks, 50 Hz, its own clock) beside it. Target: 90 to 98 %.
Writes results/benchmarks/coverage.json.
"""

from __future__ import annotations

import re
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from serpenoid.compare.calibrate import estimate
from serpenoid.compare.lengths import others_of
from serpenoid.compare.rehearse import Laboratory, write_campaign
from serpenoid.compare.segments import trial_segments
from serpenoid.files.writing import provenance, write_json
from serpenoid.measure.load import load_campaign
from serpenoid.model import Model
from serpenoid.problem import load
from serpenoid.simulation.problem import gait_table

ROOT = Path(__file__).resolve().parents[1]
NAMES = ("anisotropy_ratio",)


def one(seed: int, model: Model, table: np.ndarray, servo: bool, lengths: bool = True) -> tuple[float, float, float]:
    """Estimate, standard error and noise scale of one recording."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_campaign(folder, model, {"g": table}, Laboratory(), 1, 1000 * seed, cycles=1, pause_s=1.0)
        if not servo:
            text = (folder / "campaign.toml").read_text()
            (folder / "campaign.toml").write_text(text.replace('servo_log = "g-1/servo.csv"\n', ""))
        if not lengths:
            text = (folder / "campaign.toml").read_text()
            (folder / "campaign.toml").write_text(re.sub(r"edge_lengths = .*\n", "", text))
        campaign = load_campaign(folder)
        start = Model(campaign.body, model.medium.model_copy(update={"anisotropy_ratio": 0.3}))
        others = others_of(campaign, start)(None)
    found = estimate(start, trial_segments(campaign.trials[0]), NAMES, others)
    return float(found.values[0]), float(found.sd[0]), found.noise_scale


def summary(rows: np.ndarray, truth: float) -> dict[str, float]:
    """Coverage with its own standard error, bias in standard errors, scatter against the stated standard error."""
    z = (rows[:, 0] - truth) / rows[:, 1]
    covered = float((np.abs(z) <= 1.959964).mean())
    return {
        "seeds": len(rows), "covered": covered, "covered_sd": float(np.sqrt(covered * (1 - covered) / len(rows))),
        "mean": float(rows[:, 0].mean()), "scatter": float(rows[:, 0].std(ddof=1)),
        "stated_sd": float(rows[:, 1].mean()),
        "bias_in_sd": float(z.mean()), "noise_scale": float(rows[:, 2].mean()),
    }  # fmt: skip


def main() -> None:
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    problem = load(ROOT / "problems" / "snake10.toml", ["gait.a=6.0"])
    model, table, truth = problem.model, gait_table(problem), problem.medium.anisotropy_ratio
    if "without-lengths" in sys.argv:
        rows = np.array([one(seed, model, table, False, lengths=False) for seed in range(seeds)])
        sys.stdout.write(f"cameras alone, lengths estimated: {summary(rows, truth)}\n")
        return
    record = {"truth": truth, "marker_sd_mm": 0.2, "hidden_share": 0.05, "command": "python benchmarks/coverage.py"}
    for servo in (False, True):
        begin = time.perf_counter()
        rows = np.array([one(seed, model, table, servo) for seed in range(seeds)])
        found = summary(rows, truth) | {"seconds": time.perf_counter() - begin}
        record["with_servo_log" if servo else "cameras_alone"] = found
        sys.stdout.write(f"{'with servo log' if servo else 'cameras alone'}: {found}\n")
        sys.stdout.flush()
    write_json(ROOT / "results" / "benchmarks" / "coverage.json", record | {"provenance": provenance()})


if __name__ == "__main__":
    main()
