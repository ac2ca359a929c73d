"""A diagnosis as plain values: `diagnosis.json`, but for the next experiment."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from serpenoid.compare.complaints import beyond_water
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import over_markers
from serpenoid.diagnose.data.noise.paths import total
from serpenoid.diagnose.data.noise.repeats import chance_from
from serpenoid.diagnose.data.recordings.recording import Recording, held_as_all_told, held_out_by
from serpenoid.diagnose.data.used import about_cameras, length_unit, parameter_unit, remarks, used
from serpenoid.diagnose.diagnose import Diagnosis
from serpenoid.diagnose.inference.fits.bounds import LEAST_EPS, MOST_EPS, ratio_at_bound
from serpenoid.diagnose.inference.fits.finding import Named
from serpenoid.diagnose.inference.fits.held_out import left_open, of_each_gait
from serpenoid.diagnose.residuals.gain import gain_record
from serpenoid.diagnose.residuals.maps import residual_maps
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.motion.values_of_motion import ratio_interval
from serpenoid.effects.active import ActiveEffect

SCORES = 20  # the best candidates, in the record
MISTAKEN = 0.01  # of a cycle: clocks of instruments differ by less
OTHER_CYCLES = (
    "cycles do not last as long as `cycle_duration_s` says (the last note has both): mend it, or the film's frame rate"
)
BOUNDS_IN = "campaign.toml (or in the file of --model, if that has a [medium])"


def _named(n: Named, law: str, length: str) -> dict[str, Any]:
    """An effect, its parameters in units of the medium's law and of the recordings' lengths."""
    said = n.record()
    for p in n.effect.effect.parameters:
        said["parameters"][p.name]["unit"] = parameter_unit(p, law, length)
    return said


def plain(effect: ActiveEffect) -> dict[str, Any]:
    """An effect with its values, of which no interval is told."""
    return {"name": effect.name, "place": effect.place, "parameters": dict(effect.parameters)}


def _scored(scores: Sequence[tuple[str, int | None, float]]) -> list[tuple[str, int | None, float]]:
    """Of scores, largest first, the first twenty and the first of every effect."""
    first = {name: i for i, (name, _, _) in reversed(list(enumerate(scores)))}
    return [score for i, score in enumerate(scores) if i < SCORES or first[score[0]] == i]


def _rows(recordings: Sequence[Recording], baseline: Baseline) -> dict[str, Any]:
    """Whether the tables' rows are held, and who says so: the logs' commands, which may be goals, a reference, or what
    servos follow best. One player plays all trials: what the commands of one say, those of others that are no clear
    word do not take back."""
    held = any(r.schedule.held for r in recordings)
    told = held_as_all_told(recordings) == {held}
    before = baseline.rows_held(recordings) is not None
    shown = "readings" if any(r.by_servos for r in recordings) else "markers"
    who = "commands" if told else "reference" if before else shown
    who = "goals" if any(r.goals for r in recordings) else who
    source = who if recordings else None
    untold = any(r.lag_untold for r in recordings) and not told and not (before and baseline.rows_said)
    return {"rows_held": held, "rows_from": source, "lag_untold": untold}


def _other_cycles(d: Diagnosis) -> list[str]:
    """That cycles do not last as long as the campaign says, where shapes are not as told: it may be behind that."""
    read = [r for r in _read(d.motion.selection.motion) if r.asked_cycle_s]
    off = max((abs(r.schedule.cycle_duration_s / (r.asked_cycle_s or 1.0) - 1) for r in read), default=0.0)
    return [OTHER_CYCLES] if off > MISTAKEN and not all(stage.settled for stage in d.stages[:2]) else []


def _held_out(d: Diagnosis) -> str:
    """What is predicted by fits to the others."""
    motion = d.motion.selection.motion
    if len(set(motion.labels)) == 1:
        return "nothing"
    return held_out_by(_read(motion)) if d.drag_ratio is None else "parts"


def _read(motion: Motion) -> list[Recording]:
    """The recordings of a robot; of an animal none."""
    return [t.recording for t in motion.tracks if isinstance(t.recording, Recording)]


def _ratio_interval(d: Diagnosis) -> tuple[float, float]:
    """95 % of eps; of an animal that drag alone moves, over both ways to tell it: windows of smoothed points, and frame
    by frame (`drag_ratio`), which noise of close points shifts less. Beside a reference eps is that of its model, which
    may be as far from the truth as the earlier answer says."""
    limits = d.motion.selection.settled.model.medium.limits(LEAST_EPS, MOST_EPS)
    ends = np.multiply(ratio_interval(d.motion.selection, d.motion.stage), d.baseline.ratio_doubt)
    low, high = np.clip(ends, *limits).tolist()
    if d.drag_ratio is None or d.named:
        return low, high
    return min(low, 1 / d.drag_ratio.high), max(high, 1 / d.drag_ratio.low)


def record(d: Diagnosis) -> dict[str, Any]:
    """diagnosis.json, but for the next experiment."""
    found, extended = d.motion.selection, {e.key for e in d.model.effects}
    usage, length = used(found.motion.tracks), length_unit(found.motion.tracks)
    law, taken, rivals = found.best.model.medium.law, d.motion.stage.law_taken, d.motion.stage.laws
    open_m = left_open(found.motion, d.extension)
    cameras = about_cameras(found.motion.tracks)
    known = bool(np.any(d.seen.axes))  # and taken off: nothing is left so
    return {
        "verdict": d.verdict,
        "length_unit": length,
        "effects": [_named(n, law, length) for n in d.named],
        "alternatives": [r.record() for r in d.rivals],
        "below_detection": [
            _named(n, law, length) | {"in_extended_model": n.effect.key in extended}
            for stage in d.stages
            for n in stage.undetected
        ],
        "anisotropy_ratio": {
            "before": found.null.model.medium.anisotropy_ratio, "after": found.settled.model.medium.anisotropy_ratio,
            "interval": list(_ratio_interval(d)), "at_bound": ratio_at_bound(found.settled.model),
            "change": d.ratio_change and d.ratio_change.record(),
        },
        "baseline": {
            "effects": [plain(e) for e in d.baseline.known],
            "anisotropy_ratio": d.baseline.model.medium.anisotropy_ratio,
        },
        "law": {
            "name": law, "taken": taken or None, "rivals": rivals, "drag_at": d.motion.stage.drag_at,
            "open": d.baseline.law_open,
        },
        "discrepancy_m": d.motion.stage.discrepancy_m,
        "parts_differ_by": d.motion.stage.unlike or None,
        "may_differ_by": d.grows or None,
        "hiding": d.motion.stage.hiding or None,
        "beyond_water": beyond_water(found.settled.model, _ratio_interval(d)[1], BOUNDS_IN),
        "drag_ratio": d.drag_ratio and {
            "value": d.drag_ratio.told, "interval": [d.drag_ratio.low, d.drag_ratio.high],
            "by_frames": d.drag_ratio.by_frames,
        },
        "gain": gain_record(d.before, d.after),
        "held_out": _held_out(d),
        "left_open_m": total(open_m), "left_open_by_gait_m": of_each_gait(found.motion, open_m),
        "noise_level_m": found.noise_level_m,
        "noise_from": chance_from(found.motion.tracks),
        "noise_over_markers": over_markers(found.motion),
        **_rows(_read(found.motion), d.baseline),
        "left": {stage.name: None if stage.skipped else stage.left for stage in d.stages},
        "skipped": {stage.name: stage.skipped for stage in d.stages if stage.skipped},
        "untestable": {name: why for stage in d.stages for name, why in stage.untestable.items()},
        "residual_pattern": list(d.words),
        "mend_first": [*(() if known else cameras), *(s.mend for s in d.stages if s.mend), *_other_cycles(d)],
        "used_s": usage.used_s,
        "dropped_s": usage.dropped_s,
        "remarks": [*d.baseline.remarks, *remarks(found.motion.tracks), *(cameras if known else ())],
        "ladder": [step.record() for step in d.ladder],
        "residual_maps": residual_maps(found.motion, found.null.predictions, found.best.predictions),
        "next_experiment": None,
        "scores": [{"name": n, "place": p, "held_out_gain": s} for n, p, s in _scored(found.scores)],
    }  # fmt: skip
