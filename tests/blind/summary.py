"""What a study's rows add up to: proportions with Wilson intervals, success against S, confusion, misses."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from blind.score import confusion, wilson

STRENGTH_EDGES = (0.0, 1.0, 3.0, 6.0, 12.0, np.inf)
Row = Mapping[str, Any]


def share(rows: Sequence[Row], good: Callable[[Row], bool]) -> dict[str, Any]:
    """How many of the rows are good, with the 95 % Wilson interval."""
    n = sum(bool(good(r)) for r in rows)
    return {
        "good": n,
        "of": len(rows),
        "share": n / len(rows) if rows else None,
        "interval": list(wilson(n, len(rows))),
    }


def _right(row: Row) -> bool:
    return row["outcome"] == "right"


def _weakest(row: Row) -> float:
    return float(min(row.get("strengths") or [np.inf]))


def _by_strength(rows: Sequence[Row]) -> list[dict[str, Any]]:
    bins = []
    for low, high in zip(STRENGTH_EDGES[:-1], STRENGTH_EDGES[1:], strict=True):
        inside = [r for r in rows if low <= _weakest(r) < high]
        named = share(inside, lambda r: set(r.get("hidden", [])) <= set(r.get("group", [])))
        bins.append(
            {
                "from": low,
                "to": None if np.isinf(high) else high,
                "right": share(inside, _right),
                "truth_in_group": named,
            }
        )
    return bins


def _pairs(rows: Sequence[Row]) -> list[tuple[str, str]]:
    pairs = []
    for r in rows:
        chosen = [c.split("@")[0] for c in r.get("chosen", [])] or [r.get("verdict", "failed")]
        hidden = [h.split("@")[0] for h in r.get("hidden", [])] or ["nothing"]
        pairs += [(h, h if h in chosen else " + ".join(chosen)) for h in hidden]
    return pairs


def _follow_up(rows: Sequence[Row]) -> dict[str, Any]:
    asked = [r for r in rows if r.get("truth_before")]
    result = {}
    for label in ("proposed", "random"):
        done = [r for r in asked if f"group_{label}" in r]
        result[label] = share(done, lambda r, k=label: r[f"truth_{k}"] and r[f"group_{k}"] < r["group_before"])  # type: ignore[misc]
    return result


def summarise(kind: str, rows: Sequence[Row]) -> dict[str, Any]:
    """The study in one dictionary; `scored` leaves out effects of strength 1 to 3."""
    scored = [r for r in rows if r["outcome"] != "unscored"]
    answered = [r for r in rows if r["outcome"] != "failed"]
    intervals = [{"outcome": "right" if inside else "wrong"} for r in rows for inside in r.get("covered", {}).values()]
    held_out = [r for r in answered if r.get("held_out_over_floor") is not None and _right(r)]
    seconds = [r["seconds"] for r in rows]
    summary: dict[str, Any] = {
        "kind": kind,
        "campaigns": len(rows),
        "right": share(scored, _right),
        "right_where_required": share([r for r in scored if 3 <= _weakest(r) < np.inf], _right),
        "failed": sum(r["outcome"] == "failed" for r in rows),
        "by_strength": _by_strength(rows),
        "intervals_cover": share(intervals, _right),
        "held_out_within_1.2_floors": share(held_out, lambda r: r["held_out_over_floor"] <= 1.2),
        "mean_group_size": float(np.mean([len(r["group"]) for r in answered])) if answered else None,
        "seconds_median": float(np.median(seconds)) if seconds else None,
        "seconds_longest": max(seconds, default=None),
        "confusion": confusion(_pairs(rows)),
        "misses": [r for r in rows if r["outcome"] in ("wrong", "missed", "false alarm", "false doubt", "failed")],
    }
    return summary | ({"after_experiment": _follow_up(rows)} if kind == "followup" else {})
