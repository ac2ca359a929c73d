"""What is said of the extended model: where it is unreliable, and which trial would tell more."""

from __future__ import annotations

from serpenoid.diagnose.inference.fits.held_out import fails
from serpenoid.diagnose.report.sentences import SETTLED
from serpenoid.diagnose.report.words import Record, few, in_sample, shown, title, unseen


def no_experiment(record: Record) -> str:
    """Why none is proposed."""
    if record["alternatives"]:
        return "none: no gait that was tried is expected to exclude one of the explanations"
    if record["verdict"] in SETTLED:
        return "none needed: no two explanations are left to tell apart"
    if record["drag_ratio"]:
        return "none: nothing commands an animal"
    return "none: there are no two explanations to tell apart, and what is left has none"


def start(pose: Record) -> str:
    """Where the next experiment begins."""
    x, y = (round(pose[k], 2) + 0.0 for k in ("x_m", "y_m"))  # -0.00 is 0.00
    return f"x = {x:.2f} m, y = {y:.2f} m, heading {shown(pose['heading_rad'], 'rad')}"


def experiment(record: Record) -> list[str]:
    """What to play next, and what it tells apart; of an animal nothing."""
    plan = record["next_experiment"]
    if plan is None:
        return [no_experiment(record)] if record["drag_ratio"] is None else []
    return [
        f"play {plan['joint_table']}, {plan['cycle_duration_s']:.2f} s per cycle, from {start(plan['start_pose'])}",
        f"to tell what is named apart from {few([title(e) for e in plan['tells_apart']])}",
    ]


def held_out(record: Record) -> list[str]:
    """How well paths are predicted without and with what was found, and what limits that."""
    rms, unit = record["gain"]["path_rms_m"], record["length_unit"]
    before, after, noise = (shown(x, unit) for x in (rms["before"], rms["after"], record["noise_level_m"]))
    better = "" if rms["before"] == rms["after"] else f" -> {after} by the extended model"
    said = [f"path RMS {before}{better} (noise level {noise})"]
    if record.get("only_predicts"):  # not in older answers
        said += [f"it holds what only predicts, and is no name: {few([title(e) for e in record['only_predicts']])}"]
    if in_sample(record):
        return [*said, "of one trial nothing can be held out"]
    return said + left_open(record) + unreliable(record)


def left_open(record: Record) -> list[str]:
    """How far held-out paths are expected to stray for want of other gaits that tell, where that is more than noise."""
    if record["left_open_m"] <= record["noise_level_m"]:
        return []
    size = _open_length(record) or "a larger error"
    of = f" of {few(gaits)}: play more of that kind" if (gaits := _open_gaits(record)) else ""
    return [f"{size} is expected, as the other {unseen(record)} tell too little{of}"]


def _open_length(record: Record) -> str:
    """What others leave open; empty where first order makes it more than held-out paths are off by."""
    rms, open_m = record["gain"]["path_rms_m"], record["left_open_m"]
    return shown(open_m, record["length_unit"]) if open_m <= max(rms["before"], rms["after"]) else ""


def unreliable(record: Record) -> list[str]:
    """Where what is named makes held-out paths stray farther, by more than noise and what other gaits leave open."""
    rms = record["gain"]["path_rms_m"]
    strays = fails(rms["before"], rms["after"], record["noise_level_m"], record["left_open_m"])
    if not record["effects"] or not strays:
        return []
    return [f"what is named does not carry over to other {unseen(record)}: do not rely on it without more trials"]


def _open_gaits(record: Record) -> list[str]:
    """Gaits of which the others leave more open than noise, where that is more than noise in all."""
    if record["left_open_m"] <= record["noise_level_m"]:
        return []
    return [name for name, open_m in record["left_open_by_gait_m"].items() if open_m > record["noise_level_m"]]
