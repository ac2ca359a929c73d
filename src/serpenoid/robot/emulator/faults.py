"""Faults to rehearse: `KIND[:SERVO]@SECONDS[=VALUE]`, seconds counted from when torque is first switched on."""

from __future__ import annotations

import re
from dataclasses import dataclass

from serpenoid.errors import InputError

# kind -> (needs a servo, default value, what happens)
KINDS: dict[str, tuple[bool, float, str]] = {
    "silent": (True, 0.0, "the servo obeys but no longer answers"),
    "deaf": (True, 0.0, "the servo neither hears nor answers; its watchdog alone stops it"),
    "reset": (True, 0.0, "the servo loses power for a moment: RAM and torque are gone, no error is left"),
    "stuck": (True, 0.0, "the shaft turns no faster than this many rpm: 0 is blocked"),
    "crc": (True, 1.0, "this share of the servo's answers has a wrong checksum"),
    "delay": (True, 0.1, "the servo answers this many seconds late"),
    "overheat": (True, 90.0, "the servo's temperature jumps to this many degrees"),
    "voltage": (False, 9.0, "the battery falls to this many volts"),
    "unplug": (False, 1e9, "the cable is out for this many seconds"),
    "noise": (False, 0.5, "this share of all answers has one random byte changed"),
}
_FORM = re.compile(r"(?P<kind>[a-z]+)(:(?P<servo>\d+))?@(?P<at>[\d.]+)(=(?P<value>[\d.]+))?")


@dataclass(frozen=True)
class Fault:
    kind: str
    at: float
    servo: int | None
    value: float

    def active(self, elapsed: float | None) -> bool:
        """`elapsed`: seconds since torque was first on, None before."""
        return elapsed is not None and elapsed >= self.at


def parse_fault(text: str) -> Fault:
    match = _FORM.fullmatch(text)
    if match is None or match["kind"] not in KINDS:
        raise InputError(f"--fault {text}: write KIND[:SERVO]@SECONDS[=VALUE], KIND one of {', '.join(KINDS)}.")
    needs_servo, default, _ = KINDS[match["kind"]]
    if needs_servo != bool(match["servo"]):
        example = f"{match['kind']}:4@1.5" if needs_servo else f"{match['kind']}@1.5"
        raise InputError(
            f"--fault {text}: `{match['kind']}` {'needs a' if needs_servo else 'takes no'} servo: {example}."
        )
    try:
        at, value = float(match["at"]), float(match["value"] or default)
    except ValueError:
        raise InputError(f"--fault {text}: seconds and value are numbers.") from None
    return Fault(match["kind"], at, int(match["servo"]) if match["servo"] else None, value)
