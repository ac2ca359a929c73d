"""TOML files as validated, frozen values: a misspelt key or a bad number is refused with its place in the file."""

from __future__ import annotations

import difflib
import re
import tomllib
import unicodedata
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, TypeVar, cast, get_args, get_origin

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    StringConstraints,
    ValidationError,
)
from pydantic_core import CoreSchema
from pydantic_core.core_schema import no_info_before_validator_function

from serpenoid.errors import InputError
from serpenoid.files.inputs import read_text, refuse_depth
from serpenoid.files.kinds import mistaken


# A word from a file that becomes part of a file's name, a figure's title or a comment: no separator, no control
# character, no markup of HTML, of mathematics or of a programming language. Short enough for every file system.
def plain_name(name: str) -> str:
    """The name; raises ValueError with the rule where it breaks it."""
    letters = all(c.isalnum() or unicodedata.category(c)[0] == "M" or c in NAME_SIGNS for c in name)
    if not letters or len(name) > NAME_LENGTH or not name[:1].isalnum() or name[-1] in " .":
        rule = f"must be letters, digits, spaces and {NAME_SIGNS.strip()}, at most {NAME_LENGTH}"
        raise ValueError(f"{rule}, beginning with a letter or digit")
    return name


def _path(text: str) -> str:
    if not text.isprintable():
        raise ValueError(f"is no path: {BACKSLASH}")
    if not text.strip():
        raise ValueError("must name a file; leave it out where there is none")
    return text


def _printable(text: str) -> str:
    if not text.isprintable() or len(text) > LINE_LENGTH:
        raise ValueError(f"must be one line of at most {LINE_LENGTH} printable characters")
    return text


LINE_LENGTH = 200
BACKSLASH = "A backslash begins an escape in TOML: write paths with `/`."
CURES = (
    (re.compile(r"\\"), BACKSLASH),
    (re.compile(r"=\s*[+-]?[0-9]+,[0-9]+\s*(#.*)?$"), "Write a point before decimals."),
    (re.compile("[\u2018-\u201f]"), 'Write straight quotes (").'),
    (re.compile(r"(^|[\s=\[,+-])\.[0-9]"), "Write a 0 before a point that begins a number."),
)
NAME_SIGNS, NAME_LENGTH = " _.,+=()-", 60
Name = Annotated[str, AfterValidator(plain_name)]
Line = Annotated[str, AfterValidator(_printable)]  # for people: titles, comments of files
FilePath = Annotated[str, AfterValidator(_path)]
Duration = Annotated[float, Field(ge=1e-6, le=1e6)]  # of a cycle [s]
Text = Annotated[str, StringConstraints(max_length=20_000)]


def _strict(part: Any) -> None:
    """Make the leaves of a core schema strict."""
    if isinstance(part, dict):
        if part.get("type") in ("int", "float", "str", "bool"):
            part["strict"] = True
        numbers = part.get("type") == "literal" and not all(isinstance(word, str) for word in part["expected"])
        if numbers:  # Python takes `true` for 1
            literal = dict(part)
            part.clear()
            part.update(no_info_before_validator_function(_same_type(literal["expected"]), cast(CoreSchema, literal)))
            return
        for key, below in part.items():
            if key not in ("metadata", "serialization", "default"):
                _strict(below)
    elif isinstance(part, list | tuple):
        for below in part:
            _strict(below)


def _same_type(expected: list[Any]) -> Callable[[Any], Any]:
    """Refuse `true` where a number is wanted, and 1 where a boolean is."""
    kinds = {type(value) for value in expected}

    def check(value: Any) -> Any:
        if isinstance(value, bool) != (bool in kinds) and isinstance(value, bool | int):
            raise ValueError(f"must be {' or '.join(map(str, expected))}")
        return value

    return check


class Record(BaseModel):
    """Base of everything that is read from a file: frozen, no unknown keys, no NaN or infinity, strict types.

    Strict are numbers, words and booleans alone; TOML's lists are taken for tuples.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    file_kind: ClassVar[str | None] = None  # of a record that is a whole file: what such files are called

    @classmethod
    def __get_pydantic_core_schema__(cls, source: type[BaseModel], handler: GetCoreSchemaHandler) -> CoreSchema:
        found = handler(source)
        _strict(found)
        return found

    def __eq__(self, other: object) -> bool:
        """Field by field: values kept beside them (cached properties, arrays among them) are no part of it."""
        if type(self) is not type(other):
            return NotImplemented
        return all(getattr(self, name) == getattr(other, name) for name in type(self).model_fields)


R = TypeVar("R", bound=Record)
CLOSE = 3 / 4  # of the letters: one wrong in a word of four
MEANT = {"file": "path"}  # words for the same thing, too unlike to be found by their letters
NO_SECTION = ("model_type", "model_attributes_type")  # pydantic's words for something else in a section's place
TINY = 1e-6  # a bound below it means: more than nothing
VALUE_BEGINS = ("[", "{", '"', "'")
MOST_FAULTS, SHOWN = 20, 100  # of one file; characters of a wrong value


def read_toml(path: str | Path, wanted: str | None = None) -> dict[str, Any]:
    """Parse a TOML file; raise InputError with the line and column of a syntax error.

    wanted: the kind of file that belongs here, for the message about one that is no TOML at all.
    """
    try:
        data = tomllib.loads(read_text(path))
    except InputError:
        raise
    except RecursionError:
        raise InputError(f"{path}: not valid TOML: nested too deeply.") from None
    except ValueError as error:  # also a number of thousands of digits
        other = mistaken(path, wanted) if wanted else None
        said = str(error).partition("; use sys.")[0]  # what a programmer would do
        raise InputError(other or f"{path}: not valid TOML: {said}.{_cure(said, read_text(path))}") from None
    refuse_depth(data, path)
    return data


def _cure(said: str, text: str) -> str:
    """What to write instead, where the line that a parser complains of shows it."""
    at = re.search(r"at line ([0-9]+)", said)
    line = text.split("\n")[int(at[1]) - 1 :][:1] if at else []
    return next((f" {cure}" for form, cure in CURES for _ in filter(form.search, line)), "")


def validate(schema: type[R], data: dict[str, Any], source: str) -> R:
    """Build `schema` from parsed `data`; every fault is named `source: [section] key: rule, got value`.

    Types are strict: `"5"` is no number, `true` no place.
    """
    try:
        return schema.model_validate(data)
    except ValidationError as error:
        other = mistaken(source, schema.file_kind, data) if schema.file_kind else None
        if other is not None:
            raise InputError(other) from None
        found = error.errors()
        # a list whose entries are faulty counts as empty: that is no second fault
        above = {fault["loc"][:depth] for fault in found for depth in range(1, len(fault["loc"]))}
        found = [fault for fault in found if fault["type"] != "too_short" or fault["loc"] not in above]
        faults = [f"{source}: {_describe(schema, fault)}" for fault in found[:MOST_FAULTS]]
        rest = [f"{source}: and {len(found) - MOST_FAULTS} more."] if len(found) > MOST_FAULTS else []
        raise InputError("\n".join([*faults, *rest])) from None


def load(schema: type[R], path: str | Path) -> R:
    """Read and validate one TOML file as `schema`."""
    return validate(schema, read_toml(path, schema.file_kind), str(path))


def override(data: dict[str, Any], assignments: list[str]) -> dict[str, Any]:
    """Apply `section.key=value` assignments (values in TOML syntax; bare words are strings) to a copy of `data`."""
    result = _copy(data)
    for assignment in assignments:
        key, equals, text = assignment.partition("=")
        *sections, last = key.strip().split(".")
        if not equals or not all((*sections, last)):
            raise InputError(f"--set {assignment}: write it as section.key=value.")
        table = result
        for section in sections:
            table = table.setdefault(section, {})
            if not isinstance(table, dict):
                raise InputError(f"--set {assignment}: `{section}` is not a section.")
        table[last] = _parse_value(text.strip(), f"--set {_shown(assignment)}")
    return result


def _parse_value(text: str, source: str) -> Any:
    """A value of TOML; a bare word, which is none, is a string, but what begins as a list, a section or a string is no
    bare word."""
    line = f"value = {text}"
    try:
        data = tomllib.loads(line)
    except RecursionError:
        raise InputError(f"{source}: is nested too deeply.") from None
    except ValueError as error:
        if text[:1] not in VALUE_BEGINS:
            return text
        said = str(error)
        raise InputError(f"{source}: not valid TOML: {said.partition(' (at ')[0]}.{_cure(said, line)}") from None
    if len(data) > 1:
        raise InputError(f"{source}: holds several assignments. Give each with a --set of its own.")
    refuse_depth(data["value"], "--set")
    return data["value"]


def _shown(text: str) -> str:
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}..."


def _copy(data: Any) -> Any:
    return {key: _copy(value) for key, value in data.items()} if isinstance(data, dict) else data


def _describe(schema: type[BaseModel], fault: Any) -> str:
    where = _without_tags(schema, fault["loc"])
    place = _place(where, isinstance(fault["input"], dict) or fault["type"] in NO_SECTION)
    if fault["type"] == "extra_forbidden":
        return f"{place}: unknown key.{_suggest(schema, fault['loc'])}"
    if fault["type"] == "missing":
        return f"{_heading(schema, fault['loc']) or place}: is required and not there."
    if fault["type"] in ("union_tag_invalid", "union_tag_not_found"):
        return f"{_section(where)} {_tag_fault(fault['ctx'])}"
    shown = "" if isinstance(fault["input"], dict) else f", got {_short(fault['input'])}"
    if fault["type"] in NO_SECTION:
        return f"{place}: must be a section, {_section(where, numbered=False)} and its keys below it{shown}."
    if fault["type"] == "too_short":
        least = fault["ctx"]["min_length"]
        return f"{place}: needs {least} {'entry' if least == 1 else 'entries'} or more{shown}."
    if fault["type"] == "too_long":
        return f"{place}: takes {fault['ctx']['max_length']} entries at most, got {len(fault['input'])}."
    message = fault["msg"].removeprefix("Value error, ").removesuffix(".").replace("a valid tuple", "a list")
    if fault["type"] == "greater_than_equal" and fault["input"] <= 0 < fault["ctx"]["ge"] < TINY:
        message = "must be above 0"  # what keeps sums and ratios finite is no rule to tell of a sign
    if not place:
        return f"{message}."
    rule, _, remedy = message.partition("; ")
    end = "" if remedy.endswith("?") else "."
    return f"{place}: {rule}{shown}.{f' {remedy[0].upper()}{remedy[1:]}{end}' if remedy else ''}"


def _place(where: Sequence[str | int], is_section: bool) -> str:
    """A location as people write and count it: `[[joint]] 2 sign`, `[body] edge_lengths, entry 3`."""
    if not where:
        return ""
    *above, last = where
    if isinstance(last, str):
        # keys within an entry of several are counted from it: they may stand in braces there
        entry = max((i for i, part in enumerate(above) if isinstance(part, int)), default=len(above) - 1) + 1
        return f"{_section(above[:entry])} {'.'.join(map(str, [*above[entry:], last]))}" if above else last
    return _section(where) if is_section else f"{_place(above, is_section=False)}, entry {last + 1}"


def _section(where: Sequence[str | int], numbered: bool = True) -> str:
    """A section's own heading, with its number, from 1, where it is one of several."""
    name, number = ".".join(part for part in where if isinstance(part, str)), where[-1]
    if isinstance(number, str):
        return f"[{name}]"
    return f"[[{name}]] {number + 1}" if numbered else f"[[{name}]]"


def _tag_fault(context: dict[str, Any]) -> str:
    """The key that says which of several forms a section has is missing, or is none of them."""
    tag = context["discriminator"].strip("'")
    if "tag" not in context:
        return f"{tag}: is required and not there."
    known = context["expected_tags"].replace("'", "`")
    return f"{tag}: must be one of {known}, got {_short(context['tag'])}."


def _short(value: Any) -> str:
    return _shown(repr(value))


def _suggest(schema: type[BaseModel], location: tuple[Any, ...]) -> str:
    """The closest known keys beside an unknown one, found by walking the schema down to its section."""
    for _, below in _walk(schema, location[:-1]):
        schema = below
    known = list(schema.model_fields)
    if (meant := MEANT.get(str(location[-1]))) in known:
        return f" Did you mean `{meant}`?"
    close = _close(str(location[-1]), known)
    return f" Did you mean `{close}`?" if close is not None else f" Known keys: {', '.join(known)}."


def _heading(schema: type[BaseModel], location: tuple[Any, ...]) -> str:
    """How a section that is missing from the top of a file begins there; empty of a key."""
    if len(location) != 1 or not _models(annotation := schema.model_fields[location[0]].annotation):
        return ""
    return f"[[{location[0]}]]" if get_origin(annotation) in (tuple, list) else f"[{location[0]}]"


def _close(word: str, known: list[str]) -> str | None:
    """The likeliest of the known words: one that is mistyped, or of which this is a part."""
    alike = difflib.get_close_matches(word, known, n=len(known))
    mistyped = difflib.get_close_matches(word, alike, n=1, cutoff=CLOSE)
    return next(iter(mistyped), next((other for other in alike if word in other or other in word), None))


def _without_tags(schema: type[BaseModel], location: tuple[Any, ...]) -> list[Any]:
    """A location as it stands in the file: without the tag that pydantic adds to a section with several forms."""
    return [part for part, _ in _walk(schema, location) if part is not None]


def _walk(schema: type[BaseModel], location: tuple[Any, ...]) -> Iterator[tuple[Any, type[BaseModel]]]:
    """(part or None for a tag, schema below it) along a location."""
    forms: list[type[BaseModel]] = []
    for part in location:
        if isinstance(part, int):  # an entry of a list
            yield part, schema
            continue
        tagged = [form for form in forms if part in _tags(form)]
        if tagged:
            schema, forms = tagged[0], []
            yield None, schema
            continue
        field = schema.model_fields.get(str(part))
        forms = _models(field.annotation) if field is not None else []
        schema = forms[0] if forms else schema
        yield part, schema


def _tags(form: type[BaseModel]) -> tuple[Any, ...]:
    """The word that says which of several forms a section has: its `family`, or its `kind`."""
    tag = form.model_fields.get("family") or form.model_fields.get("kind")
    return get_args(tag.annotation) if tag is not None else ()


def _models(annotation: Any) -> list[type[BaseModel]]:
    """All records in an annotation, in order: of a union, of the entries of a list."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [form for part in get_args(annotation) for form in _models(part)]
