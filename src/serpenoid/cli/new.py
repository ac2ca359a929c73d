"""Write a commented file to begin with: it runs as it is. On a terminal a few questions are asked; options answer them.

    serpenoid new problem my-robot.toml
    serpenoid new robot servos.toml --problem my-robot.toml
    serpenoid new protocol protocol.toml --problem my-robot.toml      # for the virtual laboratory
    serpenoid new campaign my-campaign --problem my-robot.toml        # then: serpenoid campaign add ...
    serpenoid new campaign my-worm --film worm.csv --format sleap --kind crawler --frames-per-second 30

--yes asks nothing and takes the defaults. No file is overwritten.
"""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from serpenoid.cli import options
from serpenoid.cli.target import target
from serpenoid.errors import InputError
from serpenoid.files.alone import alone
from serpenoid.wording import counted

if TYPE_CHECKING:
    from serpenoid.scaffold import Question


def configure(parser: argparse.ArgumentParser) -> None:
    """KIND, FILE and an option per question."""
    from serpenoid.scaffold import TEMPLATES

    kinds = parser.add_subparsers(dest="file", metavar="KIND", required=True)
    for kind, template in TEMPLATES.items():
        sub = kinds.add_parser(kind, help=f"a {kind} file", description=f"Write a {kind} file.")
        what = "folder to write into, or the file in it" if kind == "campaign" else "file to write"
        words = f"the {what} (default {template.default_path})"
        sub.add_argument("path", nargs="?", type=target, metavar="FILE", help=words)
        sub.add_argument("--out", type=target, metavar="FILE", help="the same, as other verbs have it")
        for question in template.questions:
            sub.add_argument(f"--{question.name}", metavar=question.name.upper(), help=question.help)
        sub.add_argument("--yes", action="store_true", help="ask nothing: the defaults, where no option answers")


def run(args: argparse.Namespace) -> int:
    """Ask, write, say what to try."""
    from serpenoid.scaffold import TEMPLATES

    template = TEMPLATES[args.file]
    if args.path is not None and args.out is not None:
        raise InputError(f"FILE and --out name the same, got {args.path} and {args.out}. Leave one of them out.")
    path = args.path or args.out or Path(template.default_path)
    if args.file == "campaign" and path.suffix != ".toml":
        path = path / "campaign.toml"
    _check_name(path.absolute().parent.name if args.file == "campaign" else path.stem)
    _refuse_existing(path)
    options.check_writable(path.parent)
    talks = not args.yes and sys.stdin is not None and sys.stdin.isatty() and sys.stderr.isatty()
    if not (talks or args.yes) and any(getattr(args, q.name.replace("-", "_")) is None for q in template.questions):
        options.complain("this is no terminal, so nothing is asked: options answer, and the rest has its defaults.")
    answers: dict[str, Any] = {}
    assumed: dict[str, str] = {}
    for question in template.questions:
        given = getattr(args, question.name.replace("-", "_"))
        said, idle = bool(answers.get(question.unless)), bool(question.only) and not answers.get(question.only)
        if said and given is not None:
            raise InputError(f"--{question.name}: --{question.unless} {question.refused}")
        if idle and given is not None:
            raise InputError(f"--{question.name}: is for --{question.only} alone. Give that, too.")
        if given is None and question.passed_over(answers):
            answers[question.name] = None
            continue
        default = "" if given is not None else question.default_for(answers)
        wanted = given is None and not said and not idle
        if wanted and talks:
            answers[question.name] = _ask(question, default)
            continue
        answers[question.name] = question.value(default if given is None else given)
        if wanted and default:
            assumed[f"--{question.name} {default}"] = question.key
    with alone(path.parent, f"{path}: another serpenoid command writes in its folder. Wait for its end."):
        _refuse_existing(path)  # of one that was as quick
        first = template.write(path, answers)
    written = path.read_text(encoding="utf-8")
    told = [option for option, key in assumed.items() if f"\n{key}" in written]
    unsaid = [f"Assumed, as nobody said: {', '.join(told)}."] if told else []
    sys.stdout.write("\n".join([str(path), *unsaid, *_length(args.file, path), f"Begin: {first}", ""]))
    return 0


def _length(kind: str, path: Path) -> list[str]:
    """How long the body of a problem or campaign is: where a unit was mistaken, this number shows it."""
    from serpenoid.files.schema import read_toml, validate

    if kind not in ("problem", "campaign"):
        return []
    from serpenoid.body import Body

    body = validate(Body, read_toml(path)["body"], str(path))
    if body.is_animal and body.edge_lengths is None and body.length_m is None:
        return []
    odd = [f"warning: {said}" for said in body.odd_units]
    return [f"The body is {body.total_length_m:.4g} m long, {counted(body.joint_count, 'joint')}.", *odd]


def _refuse_existing(path: Path) -> None:
    if path.exists():
        raise InputError(f"{path}: is there already. Name another file.")


def _check_name(name: str) -> None:
    """It stands in the file: nothing may end a string or a comment there."""
    if re.fullmatch(r"[\w .+-]+", name) is None or "\n" in name:
        raise InputError(f"FILE: a name is made of letters, digits, spaces and `_ . + -`, got {name!r}.")


def _ask(question: Question, default: str) -> Any:
    """Until the answer can be read; Enter takes the default."""
    while True:
        sys.stderr.write(f"{question.text}{f' [{default}]' if default else ''}: ")
        sys.stderr.flush()
        line = sys.stdin.readline()
        if not line:
            raise InputError("the questions were not answered to the end. --yes takes the defaults.")
        try:
            return question.value(line.strip() or default)
        except InputError as error:
            options.complain(str(error))
