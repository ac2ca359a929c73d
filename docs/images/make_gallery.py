"""The gallery's pictures: each is what one command of the package draws.

python docs/images/make_gallery.py
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
PROBLEMS = HERE.parents[1] / "problems"
PICTURES = {  # name -> the command, and the picture that is taken
    "obstacle.png": (["solve", str(PROBLEMS / "disc-obstacle.toml"), "--starts", "2"], "motion.png"),
    "lighthill.png": (["solve", str(PROBLEMS / "lighthill.toml"), "--starts", "1"], "motion.png"),
    "family.png": (["sweep", str(PROBLEMS / "snake10.toml"), "--c", "0:2.5:11"], "family.png"),
    "lamprey.png": (["measure", str(PROBLEMS / "campaigns" / "lamprey.toml")], "trial-*.png"),
    "lamprey-compared.png": (["compare", str(PROBLEMS / "campaigns" / "lamprey.toml")], "compare-*.png"),
}

for name, (words, picture) in PICTURES.items():
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([sys.executable, "-m", "serpenoid", *words, "--out", out, "--quiet"], check=True)
        shutil.copy(next(Path(out).glob(picture)), HERE / name)
