"""Units as files and people have them: `m/s`, `s2/m`, `1`, a digit being a power."""

from __future__ import annotations


def times_speed(unit: str, power: int) -> str:
    """The unit of a quantity in `unit` times a speed to the power of `power`."""
    powers = {"m": power, "s": -power}
    for i, part in enumerate(unit.split("/")):
        if part != "1":
            powers[part[0]] += int(part[1:] or 1) * (1 if i == 0 else -1)
    over, under = ([f"{u}{abs(n) if abs(n) > 1 else ''}" for u, n in powers.items() if n * s > 0] for s in (1, -1))
    return "/".join(["".join(over) or "1", *under])
