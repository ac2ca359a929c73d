"""Solve the family of optimal gaits over the dissipation coefficient c; Pareto front and cost of transport.

    serpenoid sweep problems/snake10.toml --c 0:2.5:26
    serpenoid sweep problems/gait-a.toml problems/gait-b.toml problems/gait-c.toml --c 0:2.5:26 --jobs 2

`--c first:last:count` or a comma-separated list. Every optimum that the starts find at either end is continued to the
other with warm starts; the best answer is taken at every c. Solved points are kept: the same command goes on where it
was killed. A point that fails is recorded with its reason in sweep.csv, and the sweep goes on (exit code 1 at the end).

Each point is the optimum with `task.steps` rows; with more rows the optimum may be another gait. A family over c can
have kinks that come from the mesh. `--refine` solves every point again with more steps until the error of its
displacement is below 0.1 %.

`--beside FILE` simulates the gait of another problem file (the mean beat that `measure` writes of an animal, say) and
says how far the best gaits go for as much dissipation, and what they dissipate to go as far. What `--set` and `--model`
say of the body and its medium acts on it, too.

The cost of transport is (p_idle + dissipation) / displacement, with p_idle the idle energy per cycle in units of the
normalised dissipation; with [power] in the problem file also in SI.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from serpenoid.cli import options
from serpenoid.cli.claim import claim, sign
from serpenoid.cli.log import settle
from serpenoid.cli.starts import left_in
from serpenoid.wording import counted, percent

if TYPE_CHECKING:
    from serpenoid.problem import Problem
    from serpenoid.studies.beside import Beside


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `sweep`."""
    parser.add_argument("problems", nargs="+", metavar="PROBLEM", help="problem file(s)")
    options.add_model(parser)
    options.add_set(parser)
    parser.add_argument("--c", default="0:2.5:26", metavar="A:B:N", help="values of c (default 0:2.5:26)")
    parser.add_argument(
        "--starts",
        type=options.positive,
        default=4,
        metavar="N",
        help="random starts at the first and at the last c (default 4: every optimum they find is followed through all "
        "values, so that few do; with more a rarer branch may be found)",
    )
    parser.add_argument("--seed", type=options.seed, default=0, help="seed of the random gaits (default 0)")
    parser.add_argument("--no-polish", action="store_true", help="leave out the derivative-free check of every point")
    parser.add_argument(
        "--refine", action="store_true", help="solve every point again with more steps, until it is good to 0.1 %%"
    )
    parser.add_argument(
        "--beside", metavar="FILE", help="problem file of the same body whose gait is compared with these"
    )
    options.add_workers(parser, "problems")
    options.add_output(parser, "results/<problem>/sweep-<hash>")


MOST_VALUES = 10_000


def parse_values(text: str) -> list[float]:
    """`a:b:n` or `x,y,z` as numbers, each of them once; InputError with the rule."""
    import math

    from serpenoid.errors import InputError
    from serpenoid.problem import MOST_C

    try:
        if ":" in text:
            first, last, count = text.split(":")
            n = int(count)
            if n > MOST_VALUES:
                raise InputError(f"--c {text}: must be at most {MOST_VALUES} values, got {n}.")
            values = [float(first) + i * (float(last) - float(first)) / max(n - 1, 1) for i in range(n)]
        else:
            values = [float(part) for part in text.split(",")]
    except InputError:
        raise
    except ValueError:
        values = []
    if not values or not all(math.isfinite(v) and 0 <= v <= MOST_C for v in values):
        raise InputError(
            f"--c {text}: write first:last:count or a list like 0,0.5,1, all of them from 0 to {MOST_C:g}."
        )
    return list(dict.fromkeys(round(v, 12) for v in values))


def run(args: argparse.Namespace) -> int:
    """Sweep every problem, write, report."""
    from serpenoid.errors import InputError
    from serpenoid.optimise.weights import check_weights
    from serpenoid.problem import load

    values = parse_values(args.c)
    problems = [load(path, args.set, args.model) for path in args.problems]
    for problem in problems:
        check_weights(problem, values)
        options.warn_of_problem(problem)
    beside = _beside(args, problems)
    folders = [_folder(args, problem, values) for problem in problems]
    if len(set(folders)) < len(folders):
        raise InputError("two of the problem files would write to the same folder: name each once, or rename one.")
    settle(folders)
    sign(args)
    args.kept_if_stopped = lambda: left_in(folders, "point")
    if args.cluster is None and (len(problems) == 1 or args.jobs <= 1):
        summaries = []
        for problem, folder in zip(problems, folders, strict=True):
            with options.progress_bar(args, f"{problem.name}", (2 + args.refine) * len(values)) as advance:
                summaries.append(sweep_one(problem, values, folder, vars(args), advance, beside))
            if not summaries[-1]["complete"]:
                break
    else:
        summaries = _in_parallel(args, problems, values, folders, beside)
    options.report(
        args, summaries, [line for summary in summaries for line in _lines(summary, args.starts, args.refine)]
    )
    for folder in folders:
        options.open_page(args, folder)
    if not all(s["complete"] for s in summaries):
        options.complain(f"stopped. {left_in(folders, 'point')}")
        return 130
    return 1 if any(s["failed"] for s in summaries) else 0


def _beside(args: argparse.Namespace, problems: list[Problem]) -> Beside | None:
    """The gait of `--beside`, simulated before the work begins."""
    from serpenoid.errors import InputError

    if args.beside is None:
        return None
    if len(problems) > 1:
        raise InputError("--beside: is compared with the gaits of one problem. Sweep the others without it.")
    from serpenoid.studies.beside import beside_of

    return beside_of(problems[0], args.beside, args.set, args.model)


def sweep_one(
    problem: Problem,
    values: list[float],
    folder: Path,
    settings: dict,
    advance: Any = None,
    beside: Beside | None = None,
) -> dict:
    """One problem's sweep with its folder; returns the summary."""
    from serpenoid.studies.sweep import sweep
    from serpenoid.studies.sweep_results import write_sweep

    polish = not settings["no_polish"]
    result = sweep(problem, values, settings["starts"], settings["seed"], folder, polish, advance, settings["refine"])
    return write_sweep(folder, result, not settings["no_figures"], beside)


def _in_parallel(
    args: argparse.Namespace, problems: list, values: list[float], folders: list[Path], beside: Beside | None
) -> list[dict]:
    from serpenoid.parallel import results

    settings = {key: getattr(args, key) for key in ("starts", "seed", "no_polish", "no_figures", "refine")}
    tasks = [(p, values, f.resolve(), settings, None, beside) for p, f in zip(problems, folders, strict=True)]
    summaries = []
    with options.progress_bar(args, "problems", len(problems)) as advance:
        for _, summary in results(sweep_one, tasks, options.workers(args)):
            summaries.append(summary)
            advance(len(summaries), summary["problem"])
    return sorted(summaries, key=lambda s: s["problem"])


def _folder(args: argparse.Namespace, problem: Problem, values: list[float]) -> Path:
    from serpenoid.results import default_folder

    key = [values, args.starts, args.seed, args.no_polish, *(["refined"] if args.refine else [])]
    if args.out and len(args.problems) > 1:
        options.check_writable(Path(args.out))
        return claim(args, Path(args.out) / problem.name, problem.hash, *key)
    folder = Path(args.out) if args.out else default_folder(problem, "sweep", *key)
    options.check_writable(folder)
    return claim(args, folder, problem.hash, *key)


def _lines(summary: dict, starts: int, refined: bool) -> list[str]:
    missing = f", {summary['not_reached']} not reached" if summary["not_reached"] else ""
    kept = f" ({summary['kept_from_an_earlier_run']} kept from an earlier run)" * bool(
        summary["kept_from_an_earlier_run"]
    )
    went = summary["displacement"]
    solved = f"{counted(summary['solved'], 'point')} solved"
    window = summary["idle_for_minimum_between_1_and_2"]
    return [
        f"{summary['problem']}: {solved}{kept}, {summary['failed']} failed{missing}",
        *_failures(summary["failures"]),
        *([f"  displacement {went[0]:.4f} .. {went[1]:.4f} body lengths"] if went else []),
        *([_transport(window)] if went and (window or summary["complete"]) else []),
        *beside_lines(summary.get("beside")),
        *(f"  {line}, at the least c" for line in summary["limits"]),
        *_mesh_lines(summary["mesh"], refined, summary["complete"]),
        *([_branches(starts)] if summary["solved"] else []),
        f"  written to {summary['folder']}",
    ]


def _branches(starts: int) -> str:
    return f"  either end began from {counted(starts, 'random gait')}; more (--starts) may find a better branch"


def beside_lines(beside: dict[str, Any] | None) -> list[str]:
    """How near a gait of the user's own is to the best."""
    if beside is None:
        return []
    went, spent, most, least = (
        beside[key] for key in ("displacement", "dissipation", "most_displacement", "least_dissipation")
    )
    said = f"  {beside['gait']} goes {went:.4f} for a dissipation of {spent:.4f}"
    if most is None and least is None:
        return [f"{said}: outside of what these gaits spend and go; widen --c"]
    far = (
        [] if most is None else [f"the best of these go {most:.4f} for as much: it goes {percent(went / most)} of that"]
    )
    much = [] if least is None else [f"they go as far for {least:.4f}"]
    return [f"{said}; {'; '.join(far + much)}"]


def _failures(failures: list[dict[str, Any]]) -> list[str]:
    """The first that failed, with its reason."""
    if not failures:
        return []
    more = f" ({len(failures) - 1} more: sweep.csv)" * (len(failures) > 1)
    return [f"  failed at c = {failures[0]['c']:g}: {failures[0]['message']}{more}"]


def _mesh_lines(mesh: dict[str, Any] | None, refined: bool, complete: bool) -> list[str]:
    """How far the number of steps counts in the family."""
    if mesh is None:
        return []
    least, most = mesh["steps"]
    steps = f"{least}" if least == most else f"{least} to {most}"
    said = f"  mesh: {steps} steps; with many steps the same gaits go as far within {percent(mesh['largest_error'])}"
    if not mesh["coarse"]:
        return [said]
    if refined:
        points = counted(mesh["coarse"], "point")
        return [f"{said}; {points} {'could not be' if complete else 'not yet'} refined to 0.1 %"]
    return [f"{said}, but other gaits may then be better, and kinks vanish: --refine, or --set task.steps={4 * most}"]


def _transport(window: list[float] | None) -> str:
    if window is None:
        return (
            "  cost of transport: for which idle energy c = 1 to 2 is best is not told: that takes --c from 1 or less "
            "to 2 or more, with a value in between, and gaits that move there"
        )
    idle = f"{window[0]:.3f} .. {window[1]:.3f}"
    return f"  cost of transport is least between c = 1 and 2 for an idle energy of {idle} a cycle (units of T * E)"
