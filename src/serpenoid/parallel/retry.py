"""How often work that lost its worker is begun again: a task that kills whoever runs it must not do so for ever."""

from __future__ import annotations

from serpenoid.errors import InputError

RETRIES = 3


class Lost(Exception):
    """A worker died before its task was done."""


def ruled_out(losses: int, why: str) -> int:
    """One loss more; InputError after RETRIES."""
    if losses >= RETRIES:
        raise InputError(f"workers were killed {losses + 1} times ({why}). Too little memory? Use fewer at a time.")
    return losses + 1
