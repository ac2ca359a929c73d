"""Servos of a known largest speed that follow rows which are held, by how often and how well their log tells of them.

    PYTHONPATH=src:tests python benchmarks/held_rows.py [MAX_SPEED]

Prints the stage of servos of each campaign: what is named, with its interval. Logs say with labels, with commands alone
or with positions alone what was played.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from blind.protocol import usual
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.stages.actuation.choose_actuation import choose_actuation
from serpenoid.diagnose.stages.actuation.choose_set_points import plays

HERTZ, SEEDS, SETTINGS = (20.0, 40.0), (11, 12, 13), 4
LABELS = ("phase", "cycle", "step")
LEFT_OUT = {"nothing": (), "labels": LABELS, "labels and commands": (*LABELS, "command")}


def leave_out(folder: Path, columns: tuple[str, ...]) -> None:
    """Columns of every servo log that begin so."""
    for file in folder.rglob("servo.csv"):
        rows = [row.split(",") for row in file.read_text().splitlines()]
        kept = [i for i, name in enumerate(rows[0]) if not name.startswith(columns)] if columns else range(len(rows[0]))
        file.write_text("\n".join(",".join(row[i] for i in kept) for row in rows) + "\n")


def main() -> None:
    speed = float(sys.argv[1]) if len(sys.argv) > 1 else 6.0
    hidden = Effect("speed_saturation", None, {"max_speed": speed})
    for hertz in HERTZ:
        for seed in SEEDS:
            protocol = usual(seed, COMBINATIONS[:SETTINGS])
            tools = replace(protocol.instruments, log_hertz=hertz)
            campaign = make(seed, [hidden], protocol=replace(protocol, held=True, instruments=tools))
            for said, columns in LEFT_OUT.items():
                with tempfile.TemporaryDirectory() as temporary:
                    write(campaign, Path(temporary))
                    leave_out(Path(temporary), columns)
                    stage = choose_actuation(plays(read_recordings(temporary)[1]))
                names = [f"{n.effect.called} {n.effect.parameters} {n.intervals}" for n in stage.named]
                found = "; ".join(names) or "nothing named"
                sys.stdout.write(f"{hertz:.0f} Hz, seed {seed}, without {said}: {found}\n")
                sys.stdout.flush()


if __name__ == "__main__":
    main()
