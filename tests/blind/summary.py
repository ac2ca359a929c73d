"""What a study's rows add up to: proportions with Wilson intervals, success against S, confusion, misses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from blind.catalogue import CATALOGUE
from blind.score import confusion, wilson

ODDS_EDGES = (0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97, 1.0 + 1e-9)
STRENGTH_EDGES = (0.0, 1.0, 3.0, 6.0, 12.0, np.inf)
HELD_OUT, SECONDS = 1.2, 15.0  # targets: floors, seconds of processor time
LIKELY = 1.96  # deviations: 95 % of predictions by one who knows the law stray by less
Row = Mapping[str, Any]


def share(rows: Sequence[Row], good: Callable[[Row], bool]) -> dict[str, Any]:
    """How many of the rows are good, with the 95 % Wilson interval."""
    n = sum(bool(good(r)) for r in rows)
    part = n / len(rows) if rows else None
    return {"good": n, "of": len(rows), "share": part, "interval": list(wilson(n, len(rows)))}


def quantiles(values: Sequence[float]) -> dict[str, float] | None:
    """Median, 90 and 95 percent, and the largest; None without values."""
    if not values:
        return None
    names = {"median": 50, "90 %": 90, "95 %": 95, "largest": 100}
    return {name: float(np.percentile(values, q)) for name, q in names.items()}


def _right(row: Row) -> bool:
    return row["outcome"] == "right"


def _as_far_as_told(row: Row) -> bool:
    """Whether held-out paths are within the target of what the other gaits tell one who knows the law; older tables say
    only how much is expected to be left open."""
    if "held_out_known_m" in row:
        known = float(row["held_out_known_m"]) / float(row["noise_level_m"])
        return bool(row["held_out_over_floor"] <= HELD_OUT * max(known, 1.0))
    left_open = LIKELY * float(row["left_open_m"]) / float(row["noise_level_m"])
    return bool(row["held_out_over_floor"] <= np.hypot(HELD_OUT, left_open))


def _weakest(row: Row) -> float:
    return float(min(row.get("strengths") or [np.inf]))


def _by_strength(rows: Sequence[Row]) -> list[dict[str, Any]]:
    bins = []
    for low, high in zip(STRENGTH_EDGES[:-1], STRENGTH_EDGES[1:], strict=True):
        inside = [r for r in rows if low <= _weakest(r) < high]
        entry = {"from": low, "to": None if np.isinf(high) else high, "right": share(inside, _right)}
        named = share(inside, lambda r: set(r.get("hidden", [])) <= set(r.get("group", [])))
        bins.append(entry | {"truth_in_group": named, "mean_group_size": _mean_group([r for r in inside if _named(r)])})
    return bins


def _named(row: Row) -> bool:
    return bool(row.get("chosen"))


def _mean_group(rows: Sequence[Row]) -> float | None:
    """Members for each effect that was named (1: no alternative)."""
    return float(np.mean([len(r["group"]) / len(r["chosen"]) for r in rows])) if rows else None


def _pairs(rows: Sequence[Row]) -> list[tuple[str, str]]:
    pairs = []
    for r in rows:
        chosen = [c.split("@")[0] for c in r.get("chosen", [])] or [r.get("verdict", "failed")]
        hidden = [h.split("@")[0] for h in r.get("hidden", [])] or ["nothing"]
        pairs += [(h, h if h in chosen else " + ".join(chosen)) for h in hidden]
    return pairs


def _follow_up(rows: Sequence[Row]) -> dict[str, Any]:
    """Of the cases with a group: truth in it, and after each experiment a smaller group with the truth still in it.

    A diagnosis that fails the second time, or a proposal that was never made, counts against the experiment.
    """
    groups = [r for r in rows if r.get("group_before", 0) > 1]
    asked = [r for r in groups if r["truth_before"]]

    def after(label: str) -> dict[str, Any]:
        def sharper(r: Row) -> bool:
            return bool(r.get(f"truth_{label}")) and r[f"group_{label}"] < r["group_before"]

        return share(asked, sharper) | {"truth_kept": share(asked, lambda r: bool(r.get(f"truth_{label}")))}

    return {
        "groups": len(groups),
        "mean_size": float(np.mean([r["group_before"] for r in groups])) if groups else None,
        "truth_in_group": share(groups, lambda r: r["truth_before"]),
        "proposed": after("proposed"),
        "random": after("random"),
        "cases": [_case(r) for r in groups],
    }


def _case(row: Row) -> dict[str, Any]:
    keys = ("identity", "truth", "strengths", "group", "members_proposed", "members_random")
    return {k: row.get(k) for k in keys}


def calibration(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Stated odds of names against how often they are true: bins of the probability, found frequency and its interval.

    What is hidden too weakly to be seen (S < 1) is left out, and so are rows whose answers are not scored.
    """
    pairs = [
        (p, name in r.get("hidden", []))
        for r in rows
        if r["outcome"] != "unscored" and set(r.get("hidden", [])) <= set(_inside(r))
        for name, p in (r.get("odds") or {}).items()
    ]
    bins = []
    for low, high in zip(ODDS_EDGES[:-1], ODDS_EDGES[1:], strict=True):
        inside = [true for p, true in pairs if low <= p < high]
        if inside:
            stated = float(np.mean([p for p, _ in pairs if low <= p < high]))
            bins.append({"stated": stated, **share([{"true": t} for t in inside], lambda r: r["true"])})
    return bins


def _inside(row: Row) -> list[str]:
    """Hidden effects that the catalogue has."""
    return [h for h in row.get("hidden", []) if h.split("@")[0] in CATALOGUE]


def _uncovered(rows: Sequence[Row]) -> dict[str, int]:
    """How often each parameter's interval missed the truth."""
    return dict(Counter(name for r in rows for name, inside in r.get("covered", {}).items() if not inside))


def summarise(kind: str, rows: Sequence[Row]) -> dict[str, Any]:
    """The study in one dictionary; `scored` leaves out effects of strength 1 to 3."""
    scored = [r for r in rows if r["outcome"] != "unscored"]
    named = [r for r in rows if _named(r)]
    intervals = [{"outcome": "right" if inside else "wrong"} for r in rows for inside in r.get("covered", {}).values()]
    held_out = [r for r in named if r.get("held_out_over_floor") is not None and _right(r)]
    seconds = [float(r["processor_s"] if "processor_s" in r else r["seconds"]) for r in rows]
    summary: dict[str, Any] = {
        "kind": kind,
        "campaigns": len(rows),
        "right": share(scored, _right),
        "right_where_required": share([r for r in scored if 3 <= _weakest(r) < np.inf], _right),
        "outcomes": dict(Counter(r["outcome"] for r in rows)),
        "verdicts": dict(Counter(r.get("verdict", "failed") for r in rows)),
        "by_strength": _by_strength(rows),
        "intervals_cover": share(intervals, _right) | {"missed": _uncovered(rows)},
        "held_out_within_1.2_floors": share(held_out, lambda r: r["held_out_over_floor"] <= HELD_OUT),
        "held_out_as_far_as_told": share([r for r in held_out if "left_open_m" in r], _as_far_as_told),
        "held_out_over_floor": quantiles([float(r["held_out_over_floor"]) for r in held_out]),
        "mean_group_size": _mean_group(named),
        "group_sizes": dict(sorted(Counter(str(len(r["group"])) for r in named).items())),
        "seconds": quantiles(seconds),
        "odds": calibration(rows),
        "confusion": confusion(_pairs(rows)),
        "misses": [r for r in rows if r["outcome"] not in ("right", "unscored")],
    }
    return summary | ({"after_experiment": _follow_up(rows)} if kind == "followup" else {})
