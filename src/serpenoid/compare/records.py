"""What the verbs write: numbers as JSON and CSV, without NaN, with where they come from."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from serpenoid.compare.calibrate import Calibration, Estimate
from serpenoid.compare.ratios import RatioStatistics
from serpenoid.compare.three import Comparison
from serpenoid.measure.load import Campaign
from serpenoid.measure.trial import Trial
from serpenoid.measure.usage import usage

PARTS, MEASURES = ("whole", "actuation", "motion"), ("forward", "left", "turn", "path_rms")
EPS = "anisotropy_ratio"
COMPARISON_HEADER = (
    "trial", "gait", "cycle", "exp", "resim", "resim_sd", "resim_bias", "sim",
    *(f"{part}_{what}" for part in PARTS for what in MEASURES),
)  # fmt: skip


def plain(value: Any) -> Any:
    """Arrays to lists, NaN and infinity to None, at any depth."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value


def trial_record(trial: Trial) -> dict[str, Any]:
    """What is in a trial, what is missing, and how good it is."""
    motion, servo = trial.motion, trial.servo
    record: dict[str, Any] = {
        "trial": trial.name, "gait": trial.gait, "notes": list(trial.notes),
        "schedule_start": trial.start_source,
        "has": {"motion": motion is not None, "servo_log": trial.servo_log is not None,
                "power_log": trial.power_log is not None,
                "joint_table": trial.schedule is not None},
    }  # fmt: skip
    if trial.schedule is not None and trial.start_source != "none":
        record["schedule_start_s"] = trial.schedule.start_s
    if motion is not None:
        metres = trial.metres or float("nan")
        record |= {
            "frames": len(motion.time_s), "duration_s": motion.time_s[-1] - motion.time_s[0],
            "frames_per_second": 1 / float(np.median(np.diff(motion.time_s))),
            "hidden_share": motion.hidden_share, "marker_sd_body_lengths": motion.marker_sd,
            "marker_sd_mm": 1000 * metres * motion.marker_sd,
            "interpolated_frames": int(motion.interpolated.sum()),
            "long_gaps": [
                {"first": g.first, "last": g.last, "duration_s": g.duration_s} for g in motion.gaps if not g.short
            ],
            "jumps": [vars(jump) for jump in motion.jumps],
            "relabelled": [{"marker": name, "vertex": vertex} for name, vertex in motion.relabelled],
            "unused_markers": list(motion.unused),
            "used_s": usage(trial).used_s, "dropped_s": usage(trial).dropped_s, "pieces": usage(trial).pieces,
            "passages": [{**vars(p), "displacement_body_lengths": trial.displacement(p)} for p in trial.passages],
        }  # fmt: skip
    found = motion.beat if motion is not None and trial.schedule is None else None
    if found is not None:
        record["gait"] = {
            "period_s": found.period_s, "period_sd_s": found.spread_s, "frequency_hz": 1 / found.period_s,
            "amplitude_rad": found.amplitude_rad,
            "waves_from_head_to_tail": found.waves,
        }  # fmt: skip
    if servo is not None:
        record["servo"] = {
            "clock_offset_s": servo.offset.offset_s, "correlation": servo.offset.correlation, "sd_rad": servo.sd,
            "joint_zero_rad": servo.joint_zero,
        }  # fmt: skip
    return plain(record)


def campaign_record(campaign: Campaign) -> dict[str, Any]:
    """The campaign's body and every trial."""
    body = campaign.body
    return plain(
        {
            "campaign": campaign.file.name,
            "source": campaign.file.source,
            "lengths_estimated": campaign.lengths_estimated,
            "edge_lengths": body.edges_m,
            "length": body.total_length_m,
            "weights": body.vertex_weights,
            "trials": [trial_record(trial) for trial in campaign.trials],
        }  # fmt: skip
    )


def estimate_record(estimate: Estimate) -> dict[str, Any]:
    """Numbers and what is known of them; none in place of those that the data do not determine."""
    return plain(
        {
            "values": dict(zip(estimate.names, estimate.told, strict=True)),
            "sd": dict(zip(estimate.names, estimate.sd, strict=True)),
            "interval_95": dict(zip(estimate.names, estimate.interval, strict=True)),
            "robust_sd": dict(zip(estimate.names, estimate.robust_sd, strict=True)),
            "trials_half_interval_95": dict(zip(estimate.names, estimate.spread_half, strict=True)),
            "correlation": estimate.correlation,
            "noise_scale": estimate.noise_scale,
            "autocorrelation": estimate.autocorrelation,
            "warnings": list(estimate.warnings),
        }  # fmt: skip
    )


def best_rms_told(calibration: Calibration) -> bool:
    """Whether eps is determined, or was not asked: of data that do not tell it the least RMS is one of noise."""
    together = calibration.together
    return all(known for name, known in zip(together.names, together.determined, strict=True) if name == EPS)


def calibration_record(calibration: Calibration, dissipation: str) -> dict[str, Any]:
    """Joint, mean over trials, and every trial; a fitted eps holds for one kind of dissipation element only."""
    names, told = calibration.names, calibration.together.determined
    drag = best_rms_told(calibration)
    return plain(
        {
            "dissipation": dissipation,
            "together": estimate_record(calibration.together),
            "trials_mean": dict(zip(names, np.where(told, calibration.mean, np.nan), strict=True)),
            "trials_spread": dict(zip(names, calibration.spread, strict=True)),
            "trials_mean_interval_95": dict(zip(names, calibration.mean_interval, strict=True)),
            "best_rms_mean": calibration.mean_best_rms if drag else None,
            "best_rms_spread": calibration.spread_best_rms,
            "profile": calibration.profile,
            "trials": [
                {
                    "trial": f.trial,
                    "gait": f.gait,
                    "best_rms_eps": f.best_rms_eps if drag else None,
                    "rms_body_lengths": f.rms,
                    "best_rms_at_bound": f.at_bound,
                    **estimate_record(f.estimate),
                }
                for f in calibration.trials
            ],
        }  # fmt: skip
    )


def comparison_row(c: Comparison) -> list[Any]:
    """One line of comparison.csv; empty where there was nothing commanded."""
    row: list[Any] = [c.trial, c.gait, c.cycle, c.exp.displacement, c.resim.displacement, c.resim_sd, c.resim_bias]
    row.append(c.sim.displacement if c.sim is not None else "")
    for part in PARTS:
        error = c.error(part)
        row += [error.get(key, "") for key in MEASURES]
    return row


def ratio_record(s: RatioStatistics) -> dict[str, Any]:
    return plain(
        {
            "pair": s.pair,
            "mean": s.mean,
            "std": s.std,
            "bias": s.bias,
            "bias_interval_95": s.bias_interval,
            "s": s.s,
            "s_interval_95": s.s_interval,
            "rank_correlation": s.rank_correlation,
            "wrong_pairs": s.wrong_pairs,
            "pairs": s.pair_count,
            "mean_if_log_normal": float(np.exp(s.s**2)),
        }  # fmt: skip
    )
