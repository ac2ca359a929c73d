"""What to write for the columns of a table, by their names; or whose file it is, by its first cell."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from serpenoid.measure.cells import column_letter, listed
from serpenoid.measure.formats.matlab import OF_IDTRACKER

OWN_NAMES = (
    'Own names: `columns = { time = "Time (s)", x = "M*_x", y = "M*_y" }` in [motion], `*` where the numbers of the '
    "points stand, tail first (docs/your-csv.md)."
)
OF_SEVERAL = f" Are these points along one body? {OF_IDTRACKER}"
FIRST_CELLS = {
    "scorer": "deeplabcut", "track": "sleap", "Format Version": "motive", "Trajectories": "vicon", "Devices": "vicon",
    "Model Outputs": "vicon", "Joints": "vicon", "Segments": "vicon",
    "NO_OF_FRAMES": "qualisys", "FILE_VERSION": "qualisys", "PathFileType": "trc",
}  # fmt: skip
LONGEST = 200  # characters of a name that is said again
UP = str.maketrans("xX", "yY")
DIGITS = re.compile(r"[0-9]+")
POINTS = [re.compile(word, re.IGNORECASE) for word in ("point", "track", "child|marker|part|node", r"\bt?id\b")]
FRAME = re.compile(r"frame(?!_id)|slice|fnum", re.IGNORECASE)
CLOCK = re.compile(r"time|stamp|\bt\b|_t\b|[0-9]s\b", re.IGNORECASE)


def advice(header: list[str]) -> str:
    """The `columns` of [motion] for a file with this header."""
    if header[0] in FIRST_CELLS:
        return f'That is how another kind of file begins: `format = "{FIRST_CELLS[header[0]]}"` in [motion].'
    if '"' in "".join(header) or max(map(len, header)) > LONGEST or len(set(header)) < len(header):
        return OWN_NAMES
    pairs = [(name, up) for name in header if (up := _partner(name, header))]
    forms = Counter(form for pair in pairs for form in _numbered(*pair))
    numbered = next((form for form, count in forms.items() if count > 1), None)
    alone = [pair for pair in pairs if not any(forms[form] > 1 for form in _numbered(*pair))]
    if numbered and not alone:
        return _wide(header, *numbered, "points tail first", [cell for pair in pairs for cell in pair])
    if len(pairs) == 1 and (len(pairs[0][0]) == 1 or any(form.search(name) for form in POINTS for name in header)):
        return _long(header, *pairs[0])
    words = Counter(_worded(*pair) for pair in pairs)
    form, count = words.most_common(1)[0] if words else (None, 0)
    if form is None or count < 2:
        return OWN_NAMES
    order = "points in the file's order, or in that of `markers`"
    return _wide(header, *form, order, [cell for pair in pairs for cell in pair])


def doubled(header: Sequence[str], same: Mapping[str, Sequence[int]]) -> str:
    """What to do where one numbered point of several has its columns twice; empty where none has.

    same: the columns of names that the file has more than once.
    """
    bare = [next((name for name, places in same.items() if c in places), own) for c, own in enumerate(header)]
    across = [name for name in dict.fromkeys(bare) if _partner(name, bare)]
    forms = Counter(form for name in across for form in _numbered(name, str(_partner(name, bare))))
    form = max(forms, key=lambda f: forms[f], default=None)
    if form is None or forms[form] < 2:
        return ""
    points = sorted((name for name in across if form in _numbered(name, str(_partner(name, bare)))), key=_number)
    pairs = [points, [str(_partner(name, bare)) for name in points]]
    twice = [name for name in pairs[0] + pairs[1] if name in same]
    if not twice or len(twice) == 2 * len(points):  # in a table that is there twice `*` can stand for the numbers
        return ""
    x, y = (", ".join(f'"{name} 1"' if name in same else f'"{name}"' for name in names) for names in pairs)
    columns = listed(map(column_letter, same[twice[0]]))
    clock = _clock(header, [name for name, own in zip(header, bare, strict=True) if own in pairs[0] + pairs[1]])
    time = "" if clock is None else f'{"frame" if FRAME.search(clock) else "time"} = "{clock}", '
    return (
        f"`{twice[0]}` is the name of columns {columns}. Take out what is not meant, or list what is, tail first: "
        f"`columns = {{ {time}x = [{x}], y = [{y}] }}` in [motion], where `{twice[0]} 1` is column "
        f"{column_letter(same[twice[0]][0])}."
    )


def _number(name: str) -> list[int]:
    return [int(found) for found in DIGITS.findall(name)]


def _partner(name: str, header: Sequence[str]) -> str | None:
    """The column of y that belongs to one of x: of the same name but for this letter, where no other touches it."""
    for place in (m.start() for m in re.finditer(r"(?<![^\W\d_])[xX](?![^\W\d_])", name)):
        up = name[:place] + name[place].translate(UP) + name[place + 1 :]
        if up in header:
            return up
    return None


def _numbered(across: str, up: str) -> Iterator[tuple[str, str]]:
    """Both names with `*` in place of each of their numbers."""
    for found in DIGITS.finditer(across):
        yield across[: found.start()] + "*" + across[found.end() :], up[: found.start()] + "*" + up[found.end() :]


def _worded(across: str, up: str) -> tuple[str, str]:
    """Both names with `*` in place of what stands before or behind the letter that differs, without marks there."""
    place = next(k for k in range(len(across)) if across[k] != up[k])
    begin, end = across[:place], across[place + 1 :]
    if len(begin) < len(end):
        mark = end[: len(end) - len(end.lstrip(" _./:-"))]
        return f"{across[: place + 1]}{mark}*", f"{up[: place + 1]}{mark}*"
    mark = begin[len(begin.rstrip(" _./:-")) :]
    return f"*{mark}{across[place:]}", f"*{mark}{up[place:]}"


def _clock(header: Sequence[str], points: Sequence[str]) -> str | None:
    """The column of times or frames, beside those of points."""
    clock = next((name for name in header if name not in points and (CLOCK.search(name) or FRAME.search(name))), None)
    return header[0] if clock is None and header[0] not in points else clock


def _wide(header: Sequence[str], x: str, y: str, order: str, points: Sequence[str]) -> str:
    several = OF_SEVERAL if {x.casefold(), y.casefold()} == {"x*", "y*"} else ""
    clock = _clock(header, points)
    if clock is None:
        return (
            f'Own names: `columns = {{ x = "{x}", y = "{y}" }}` and `frames_per_second` in [motion], as the file '
            f"has no column of times and each row is the next frame; {order}, units as `length_unit` "
            f"(docs/your-csv.md).{several}"
        )
    counts = FRAME.search(clock) is not None
    other = "`time` for `frame` where these are times" if counts else "`frame` for `time` where frames are counted"
    return (
        f'Own names: `columns = {{ {"frame" if counts else "time"} = "{clock}", x = "{x}", y = "{y}" }}` in [motion], '
        f"{other}; {order}, units as `length_unit` and `time_unit` (docs/your-csv.md).{several}"
    )


def _long(header: Sequence[str], x: str, y: str) -> str:
    """Of a table with one column of x."""
    others = [name for name in header if name not in (x, y, "")]
    point = next((name for form in POINTS for name in others if form.search(name)), "")
    others = [name for name in others if name != point]
    frame = next((name for name in others if FRAME.search(name)), None)
    clock = frame or next((name for name in others if CLOCK.search(name)), "t")
    role = "frame" if frame else "time"
    more = (
        "points are numbered or named along the body"
        if point
        else "no column says which point of the body a row is: rows of a frame must follow each other along it"
    )
    which = f'point = "{point}", ' if point else ""
    return (
        f'Has it a row for each frame and point? Then `format = "long"`, `columns = {{ {role} = "{clock}", '
        f'{which}x = "{x}", y = "{y}" }}` and `length_unit` in [motion]; {more} (docs/your-csv.md).'
    )
