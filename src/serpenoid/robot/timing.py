"""How well the schedule was kept: lateness of every row against its deadline; and what would make rows late."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field

import numpy as np


@contextmanager
def older_objects_left_alone() -> Iterator[None]:
    """Garbage is looked for among younger objects alone: a program that holds millions is held up by 0.3 s each time
    that Python looks through all of them, longer than a servo may go without a word."""
    frozen = gc.get_freeze_count()
    gc.freeze()
    try:
        yield
    finally:
        if not frozen:
            gc.unfreeze()


@contextmanager
def before_other_programs() -> Iterator[None]:
    """This program has its turn before all others, where the system lets it ask for that: a bus does not wait."""
    usual = None
    with suppress(OSError, AttributeError):  # a user without that right, or another system: as any other program
        usual = os.sched_getscheduler(0), os.sched_getparam(0)
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    try:
        yield
    finally:
        if usual is not None:
            with suppress(OSError):
                os.sched_setscheduler(0, *usual)


@dataclass
class RowTiming:
    """Collects lateness [s]; a row is missed if it leaves later than `allowed` after its deadline."""

    allowed: float
    lateness: list[float] = field(default_factory=list)

    def note(self, late: float) -> None:
        self.lateness.append(late)

    def summary(self) -> dict[str, float | int | None]:
        """Milliseconds; None before the first row."""
        if not self.lateness:
            return {"rows": 0, "late_median_ms": None, "late_p99_ms": None, "late_worst_ms": None, "missed": 0}
        late = np.array(self.lateness) * 1000
        return {
            "rows": len(late),
            "late_median_ms": round(float(np.median(late)), 3),
            "late_p99_ms": round(float(np.percentile(late, 99)), 3),
            "late_worst_ms": round(float(late.max()), 3),
            "missed": int((late > self.allowed * 1000).sum()),
        }

    def sentence(self) -> str:
        numbers = self.summary()
        if not numbers["rows"]:
            return "no rows were sent"
        late = [f"{numbers[f'late_{which}_ms']} ms" for which in ("median", "p99", "worst")]
        return (
            f"{numbers['rows']} rows sent; late by {late[0]} (median), {late[1]} (99th percentile), {late[2]} (worst); "
            f"{numbers['missed']} missed their deadline by more than {self.allowed * 1000:.1f} ms"
        )
