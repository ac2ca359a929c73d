"""What the study's diagnoses are worth in use: both optimal gaits played on the changed robot.

    python -m arena.use --out results/blind/arena/in-use --work results/arena-study NAME ...

After `arena.study`, in whose work folder the diagnoses are. One row of in-use.csv a change, a page in README.md.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from arena.hidden import HIDDEN
from arena.study import MODEL, Study
from blind import table
from blind.study import commit
from serpenoid.cli.main import main as serpenoid
from serpenoid.files.writing import write_text

TABLE = "in-use.csv"
HEAD = """# Gain in use

`python -m arena.use`, after `python -m arena.study`: `serpenoid arena use` on the changed robots of the study. The gait
that is optimal under the baseline (the healthy robot's extended model, eps calibrated on the changed robot's campaign)
and the one that is optimal under the model that the diagnosis wrote, both played with the change in the robot. Body
lengths a cycle, mean and SD over trials; in brackets what the gait's own model promised.

| hidden | trials | baseline's gait | extended model's gait | gain, 95 % |
| --- | --- | --- | --- | --- |
"""


def main() -> None:
    p = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    p.add_argument("names", nargs="+", choices=sorted(HIDDEN), metavar="NAME")
    p.add_argument("--out", type=Path, default=Path("results/blind/arena/in-use"))
    p.add_argument("--work", type=Path, default=Path("results/arena-study"))
    p.add_argument("--trials", type=int, default=6)
    a = p.parse_args()
    a.out.mkdir(parents=True, exist_ok=True)
    for name in a.names:
        rows = table.read(a.out / TABLE)[1]
        if any(row["name"] == name for row in rows):
            continue
        folder = Study(a.work).folder(name)
        options = ["--problem", str(MODEL), "--trials", str(a.trials), "--jobs", "1"]
        if serpenoid(["arena", "use", str(folder / "diagnosis"), str(folder / "protocol.toml"), *options]) == 0:
            found = json.loads((folder / "diagnosis" / "in-use" / "in-use.json").read_text())
            above = {"command": f"python -m arena.use --out {a.out}", "commit": commit(), "key": Study.key}
            table.write(a.out / TABLE, above, [*rows, {"name": name, **found}])
    lines = {row["name"]: _line(row) for row in table.read(a.out / TABLE)[1]}
    write_text(a.out / "README.md", HEAD + "".join(lines[n] for n in HIDDEN if n in lines))


def _line(r: dict[str, Any]) -> str:
    gaits = (r["baseline"], r["extended"])
    cells = [f"{g['mean']:.3f} +- {g['sd']:.3f} ({g['promised']:.3f})" for g in gaits]
    low, high = r["gain_interval"]
    gain = f"{r['gain']:+.3f}, {low:+.3f} .. {high:+.3f}"
    return f"| {r['name']} | {len(gaits[0]['trials'])} | {cells[0]} | {cells[1]} | {gain} |\n"


if __name__ == "__main__":
    main()
