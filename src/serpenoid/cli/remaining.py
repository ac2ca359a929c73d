"""A column of the progress bar: how long the rest takes if it goes on as it did so far."""

from __future__ import annotations

from rich.progress import ProgressColumn, Task
from rich.text import Text


class RemainingColumn(ProgressColumn):
    """Elapsed time over the finished share of the work; nothing is said before a first unit is done."""

    max_refresh = 0.5

    def render(self, task: Task) -> Text:
        """As `about 0:42 left`."""
        return Text(remaining(task.elapsed, task.completed, task.total), style="progress.remaining")


def remaining(elapsed: float | None, done: float, total: float | None) -> str:
    """Words about the seconds that are left; empty where nothing is known or nothing is left."""
    if not elapsed or not done or total is None or done >= total:
        return ""
    seconds = round(elapsed * (total - done) / done)
    return f"about {seconds // 60}:{seconds % 60:02d} left"
