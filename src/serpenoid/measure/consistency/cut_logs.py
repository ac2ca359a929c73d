"""A servo log that is cut where the motion repeats: its clock is then known but for whole cycles."""

from __future__ import annotations

from serpenoid.measure.clock import as_likely, find_offset, is_cut
from serpenoid.measure.consistency.claim import Claim, same_joints
from serpenoid.measure.servo_alignment import MIN_CORRELATION
from serpenoid.wording import counted

NAMED = 3  # offsets at most


def unsure_by_cycles(claim: Claim) -> str | None:
    """What to say of a trial whose log is laid as well a cycle earlier or later; None: of no other."""
    cameras, servos, schedule = claim.cameras, claim.servos, claim.schedule
    if cameras is None or servos is None or not same_joints(cameras, servos):
        return None
    period_s = cameras.period_s or (None if schedule is None else schedule.period_s)
    log_s, read = servos.time_s[servos.known], servos.values[servos.known]
    if period_s is None or not is_cut(cameras.time_s, cameras.values, log_s, read):
        return None
    found = find_offset(cameras.time_s, cameras.values, log_s, read)
    if found is None or found.correlation < MIN_CORRELATION:
        return None
    others = as_likely(found, period_s, cameras.time_s, cameras.values, log_s, read)
    if not others:
        return None
    shown = ", ".join(f"{one:+.3f} s" for one in others[:NAMED])
    more = f" and {counted(len(others) - NAMED, 'other')}" if len(others) > NAMED else ""
    return (
        f"its servo log is cut where the motion repeats: its clock is laid by {found.offset_s:+.3f} s, and "
        f"{shown}{more} would do as well, so it may be whole cycles off. Give the whole log, or leave `servo_log` "
        "out of this trial"
    )
