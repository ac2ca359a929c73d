"""The README's second picture: a sticky patch of the floor, hidden in a synthetic campaign, before and after diagnosis.

PYTHONPATH=tests python docs/images/make_diagnosis.py
"""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from blind.campaign import make
from blind.catalogue import Effect
from blind.folder import write

HERE = Path(__file__).parent
PATCH = {"strength": 0.3, "x": 0.2, "y": -0.05, "radius": 0.15}

with tempfile.TemporaryDirectory() as temporary:
    folder, out = Path(temporary) / "campaign", Path(temporary) / "diagnosis"
    write(make(2026, [Effect("friction_patch", None, PATCH)], "campaign"), folder)
    model = str(HERE.parents[1] / "problems" / "snake10.toml")
    command = [sys.executable, "-m", "serpenoid", "diagnose", str(folder), "--model", model, "--out", str(out)]
    subprocess.run(command, check=True)
    shutil.copy(out / "on-floor.png", HERE / "diagnosis.png")
    found = json.loads((out / "diagnosis.json").read_text())["effects"]
    sys.stdout.write(f"hidden: {PATCH}\nfound: {json.dumps(found, indent=1)}\n")
