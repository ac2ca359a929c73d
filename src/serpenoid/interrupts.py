"""Ctrl-C as the command line noted it: a KeyboardInterrupt can get lost in a library's callback, this note cannot."""

from __future__ import annotations

noted: list[int] = []  # numbers of the signals since the command began; only `cli.main` writes it
