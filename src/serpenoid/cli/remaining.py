"""A column of the progress bar: how long the rest takes if it goes on as so far, or as the work itself says."""

from __future__ import annotations

from rich.progress import ProgressColumn, Task
from rich.text import Text


class RemainingColumn(ProgressColumn):
    """Elapsed time over the finished share of the work; nothing is said before a first unit is done."""

    max_refresh = 0.5

    def render(self, task: Task) -> Text:
        """As `about 0:42 left`."""
        known = task.fields.get("left")
        words = remaining(task.elapsed, task.completed, task.total) if known is None else _words(known())
        return Text("" if task.finished else words, style="progress.remaining")


def remaining(elapsed: float | None, done: float, total: float | None) -> str:
    """Words about the seconds that are left; empty where nothing is known or nothing is left."""
    if not elapsed or not done or total is None or done >= total:
        return ""
    return _words(elapsed * (total - done) / done)


def _words(left: float) -> str:
    seconds = round(left)
    return f"about {seconds // 60}:{seconds % 60:02d} left"
