"""Mutations of a valid file: of its bytes, of its values, of its structure. Everything follows from three numbers.

where: a place in the file, as a share of it; what: which hostile piece is put there.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

NUMBER = re.compile(rb"(?<![A-Za-z_0-9.])[+-]?\d+\.?\d*(?:[eE][+-]?\d+)?(?![A-Za-z_0-9.])")
WORD = re.compile(rb'"[^"\n]*"')
# what no table may take for a number
NEVER_NUMBERS = [
    b"inf",
    b"-inf",
    b"infinity",
    b"1e999",
    b"1_000",
    "\uff11\uff12".encode(),
    b"0x10",
    b"1,5",
    b"--1",
    b"1e",
]
LARGE = [b"1e308", b"-1e308", b"1e15", b"1000000000", b"-1", b"0", b"99999999999999999999999999", b"1e-320"]
OTHER_TYPES = [b'"5"', b"true", b"[]", b"{}", b"null", b"1979-05-27", b"[" * 5000, b'{"a":' * 5000, b"9" * 5000, b""]
NAMES = [
    b"x/../../../PWNED", b"../PWNED", b"/tmp/PWNED", b"a\\u0000b", b"x\\n#error", b"<script>alert(1)</script>",
    b"{{data}}", b"$\\\\frac{1}$", b"@TABLE@", b"CON", b".", b"..", b"", b"x" * 5000, b"-rf", b"=1+1", b"\\ud83d",
    "\u202e\u2028".encode(),
]  # fmt: skip
PIECES = [
    b"\x00",
    b"\xff\xfe",
    b"\xef\xbb\xbf",
    b"\r",
    b"\n\n",
    b'"',
    b"'''",
    b",",
    b"[",
    b"]]",
    b"=",
    b"#",
    b"\x1b[31m",
]


@dataclass(frozen=True)
class Mutant:
    """A changed file; never_a_number: a number of the original has become what is none."""

    data: bytes
    how: str
    never_a_number: bool = False


def _number(data: bytes, where: float, what: int, pieces: list[bytes], how: str) -> Mutant:
    found = list(NUMBER.finditer(data))
    if not found:
        return Mutant(data, how)
    m = found[int(where * len(found))]
    piece = pieces[what % len(pieces)]
    return Mutant(data[: m.start()] + piece + data[m.end() :], f"{how} {piece[:20]!r}", pieces is NEVER_NUMBERS)


def _never(data: bytes, where: float, what: int) -> Mutant:
    return _number(data, where, what, NEVER_NUMBERS, "number becomes")


def _large(data: bytes, where: float, what: int) -> Mutant:
    return _number(data, where, what, LARGE, "number becomes")


def _type(data: bytes, where: float, what: int) -> Mutant:
    return _number(data, where, what, OTHER_TYPES, "number becomes")


def _name(data: bytes, where: float, what: int) -> Mutant:
    found = list(WORD.finditer(data))
    if not found:
        return _type(data, where, what)
    m, piece = found[int(where * len(found))], NAMES[what % len(NAMES)]
    return Mutant(data[: m.start() + 1] + piece + data[m.end() - 1 :], f"word becomes {piece[:30]!r}")


def _flip(data: bytes, where: float, what: int) -> Mutant:
    k = int(where * len(data))
    return Mutant(data[:k] + bytes([data[k] ^ (1 << what % 8)]) + data[k + 1 :], f"bit of byte {k}")


def _cut(data: bytes, where: float, _what: int) -> Mutant:
    k = int(where * len(data))
    return Mutant(data[:k], f"cut at byte {k}")


def _insert(data: bytes, where: float, what: int) -> Mutant:
    k, piece = int(where * len(data)), PIECES[what % len(PIECES)]
    return Mutant(data[:k] + piece + data[k:], f"{piece!r} at byte {k}")


def _remove(data: bytes, where: float, what: int) -> Mutant:
    k, n = int(where * len(data)), 1 + what % 40
    return Mutant(data[:k] + data[k + n :], f"{n} bytes missing at {k}")


def _line(change: Callable[[list[bytes], int, int], list[bytes]], how: str) -> Callable[[bytes, float, int], Mutant]:
    def apply(data: bytes, where: float, what: int) -> Mutant:
        lines = data.splitlines(keepends=True)
        k = int(where * len(lines))
        return Mutant(b"".join(change(lines, k, what)), f"{how} {k + 1}")

    return apply


def _swapped(lines: list[bytes], k: int, what: int) -> list[bytes]:
    other = what % len(lines)
    moved = list(lines)
    moved[k], moved[other] = lines[other], lines[k]
    return moved


def _cell(lines: list[bytes], k: int, what: int) -> list[bytes]:
    cells = lines[k].split(b",")
    cells[what % len(cells)] = b""
    return [*lines[:k], b",".join(cells), *lines[k + 1 :]]


KINDS: dict[str, Callable[[bytes, float, int], Mutant]] = {
    "flip": _flip,
    "cut": _cut,
    "insert": _insert,
    "remove": _remove,
    "never": _never,
    "large": _large,
    "type": _type,
    "name": _name,
    "without": _line(lambda lines, k, _: lines[:k] + lines[k + 1 :], "without line"),
    "twice": _line(lambda lines, k, _: [*lines[: k + 1], *lines[k:]], "twice line"),
    "swapped": _line(_swapped, "another place for line"),
    "emptied": _line(_cell, "an empty cell in line"),
}


def mutate(data: bytes, kind: str, where: float, what: int) -> Mutant:
    """One mutation; where in [0, 1)."""
    return KINDS[kind](data, min(where, 1 - 1e-9), what) if data else Mutant(data, "empty")
