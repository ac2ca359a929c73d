"""The README's picture: the optimal gait of the snake robot at c = 1.

python docs/images/make.py
"""

from pathlib import Path

import serpenoid as sp
from serpenoid.plot.hero import hero

HERE = Path(__file__).parent
best = sp.solve(sp.load(HERE.parents[1] / "problems" / "snake10.toml", set=["task.c=1.0"])).best
hero(best).savefig(HERE / "hero.png", dpi=150)
