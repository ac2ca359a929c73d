"""Say what is in a results folder, in words, and name its pictures.

serpenoid show results/snake10/solve-1a2b3c4d
serpenoid show results/foam/diagnosis-1a2b3c4d --open
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from serpenoid.cli import options
from serpenoid.cli.claim import REQUEST, is_unfinished, stopped_verb
from serpenoid.cli.goals import dissipation_name, goal_lines, in_cycles
from serpenoid.cli.starts import bound_lines, certificate_line, note_lines, starts_lines
from serpenoid.cli.sweep import beside_lines
from serpenoid.files.alone import LOCK, is_held
from serpenoid.files.inputs import RECORDING_BYTES, csv_rows, read_text
from serpenoid.files.writing import UNFINISHED
from serpenoid.media import DEFAULT, LAWS
from serpenoid.wording import counted

STOPPED = "was stopped before it ended: run it again with the same --out. What it kept is not computed again."
AT_WORK = "a serpenoid command is at work in this folder"
CUT_SHORT = (
    "files may be missing, or of an earlier run: the command that writes them has not ended, or was stopped (by hand, "
    "or by a full disk). Run it again with the same --out."
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `show`."""
    parser.add_argument("folder", metavar="RESULTS", help="a folder that any other verb wrote, or a campaign")
    options.add_output(parser)
    options.add_open(parser)


def run(args: argparse.Namespace) -> int:
    """Read, report."""
    from serpenoid.errors import InputError
    from serpenoid.results import read_record

    folder = Path(args.folder)
    if folder.is_file():
        raise InputError(f"{folder}: is a file; `show` takes a results folder or a campaign.{_taken_by(folder)}")
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder. Each command names the folder that it wrote.")
    name = next((name for name in RECORDS if (folder / name).exists()), None)
    if name is None and not (folder / "campaign.toml").exists():
        if is_held(folder):
            raise InputError(f"{folder}: holds no answer yet: {AT_WORK}. Ask again when it has ended.")
        if (folder / REQUEST).exists():
            raise InputError(f"{folder}: holds no answer yet: {stopped_verb(folder)} {STOPPED}")
        raise InputError(f"{folder}: holds no results: none of {', '.join(RECORDS)}, campaign.toml.{_others(folder)}")
    try:
        record = read_record(folder, name) if name else {}
        lines = RECORDS[name](folder, record) if name else _campaign_lines(folder)
    except InputError as error:
        file = str(folder / (name or "campaign.toml"))
        raise InputError(str(error) if file in str(error) else f"{file}: {error}") from None
    except (LookupError, ArithmeticError, TypeError, ValueError, OSError, AttributeError) as error:
        raise InputError(
            f"{folder / (name or 'campaign.toml')}: is not a record of this version ({error!r})."
        ) from None
    if is_held(folder):
        lines = [f"unfinished        {AT_WORK}: files may be missing, or of an earlier run", *lines]
    elif is_unfinished(folder):
        lines = [f"unfinished        {CUT_SHORT}", *lines]
    pictures = _named(folder, ".png", ".svg", ".gif")
    files = [f"files             {', '.join(_files(folder))}", *_reports(folder), *_pictures(pictures, name)]
    options.report(args, record, [*lines, *files])
    options.open_page(args, folder)
    return 0


def _others(folder: Path) -> str:
    """What else may have been meant: a folder within, or TOML files here."""
    telling = (*RECORDS, REQUEST, LOCK)
    within = sorted(path for path in folder.iterdir() if any((path / name).exists() for name in telling))
    if within:
        return f" Name a folder within: {', '.join(map(str, within[:8]))}{', ...' if len(within) > 8 else ''}."
    files = sorted(path.name for path in folder.glob("*.toml"))
    few = ", ".join(files[:3]) + (", ..." if len(files) > 3 else "")
    return f" Name a folder within{f', or `serpenoid measure` one of {few}' if files else ''}?"


def _taken_by(path: Path) -> str:
    """Which verb takes this file, if it is one of the package's."""
    from serpenoid.errors import InputError
    from serpenoid.files.kinds import TAKEN_BY, kind_of
    from serpenoid.files.schema import read_toml

    try:
        kind = kind_of(read_toml(path))
    except InputError:
        return ""
    return "" if kind is None else f" It is a {kind} file: {TAKEN_BY[kind]}."


def _lines(folder: Path, record: dict[str, Any]) -> list[str]:
    body, gait = record["body"], record["gait"]
    law = LAWS[record.get("law", DEFAULT)]  # not in older records
    robust = record.get("robust", {})
    joints = counted(len(body["joints"]), "joint")
    together = in_cycles(record["cycles"]) * (record["cycles"] > 1)
    lines = [
        f"{record['kind']}: {record['status']}"
        + ("" if record["message"] == record["status"] else f" ({record['message']})"),
        f"problem           {record['provenance']['problem']}, written {record['provenance']['written']}",
        f"body              {body['vertices']} vertices, {joints}, {body['length_m']:.4g} m",
        *note_lines(record.get("body_note")),
        f"medium            anisotropy ratio {record['anisotropy_ratio']:g} at each {record['dissipation_at']}"
        + ("" if law.name == DEFAULT else f", {law.title}"),
        *(f"effect            {_effect(effect)}" for effect in record.get("effects", [])),
        f"gait              {', '.join(_gait(gait))}",
        *bound_lines(record.get("at_bounds", [])),
        f"displacement      {_short(record['displacement_body_lengths'])} body lengths{in_cycles(record['cycles'])}"
        + (f" {robust['headline']}" if "headline" in robust else ""),
        f"heading change    {_turn(record)} rad{together}",
        f"{dissipation_name(law.name)}{_short(record['dissipation'])}{together}",
        *goal_lines(record),
        *_cases(robust),
        *_floor(record),
        *note_lines(record.get("note")),
    ]
    if record["kind"] == "optimum":
        residuals, gain = list(record["kkt"].values()), record["polishing_gain"]
        kkt = "not a number" if None in residuals else f"{max(residuals):.1e}"
        moved = record["resimulation_error"]
        lines += [
            f"cost              {_short(record['cost'])} at c = {record['c']:g}",
            certificate_line(
                kkt, None if moved is None else _short(moved), "not tried" if gain is None else _short(gain)
            ),
            f"mesh              {_mesh(record['mesh'])}",
        ]
    return lines + (starts_lines(record) if record.get("multi_start") else [])


def _gait(gait: dict[str, Any]) -> list[str]:
    """Names and numbers; of a lifted gait those of its bending first."""
    bend = _gait(gait["bend"]) if "bend" in gait else []
    return bend + [f"{name} {_short(value)}" for name, value in gait.items() if name not in ("family", "bend", "lift")]


def _cases(robust: dict[str, Any]) -> list[str]:
    """A line for every case that a robust gait serves."""
    went = "displacement_body_lengths"
    return [
        f"{case['case']:18}objective {_short(case['objective'])}, {_short(case[went])} body lengths"
        for case in robust.get("cases", [])
    ]


def _floor(record: dict[str, Any]) -> list[str]:
    """Of a body that is lifted."""
    from serpenoid.trajectory import floor_words

    if "standing" not in record:
        return []
    return [f"on the floor      {floor_words(record['sideways_deg'], record['tilt_rad'], record['standing'])}"]


def _turn(record: dict[str, Any]) -> str:
    turn = record["heading_change_rad"]
    return "unknown" if turn is None else options.signed(turn)


def _mesh(mesh: dict[str, Any]) -> str:
    if mesh["displacement_error"] is None:
        return "a finer one could not be simulated"
    limit, error = mesh["extrapolated_displacement_body_lengths"], mesh["displacement_error"]
    said = f"the same gait with many steps: {limit:.6f} body lengths; error of {mesh['steps'][0]} steps {error:.1e}"
    turn, spent = mesh.get("extrapolated_turn_rad"), mesh.get("dissipation_error")  # not in older records
    said += f"; turn {turn:.6f} rad, error {mesh['turn_error_rad']:.1e}" if turn else ""
    return said if spent is None else f"{said}; dissipation {mesh['extrapolated_dissipation']:.6f}, error {spent:.1e}"


def _set_lines(_folder: Path, record: dict[str, Any]) -> list[str]:
    return [f"gait {g['gait']}: {g['random']:.4f} -> {g['improved']:.4f} ({g['status']})" for g in record["gaits"]]


def _sweep_lines(folder: Path, record: dict[str, Any]) -> list[str]:
    head, *cells = csv_rows(read_text(folder / "sweep.csv"), folder / "sweep.csv")
    rows = [dict(zip(head, row, strict=True)) for row in cells]
    lines = [f"sweep of {record['problem']}: {counted(record['solved'], 'point')} solved, {record['failed']} failed"]
    lines.append(f"{'c':>8}{'displacement':>14}{'dissipation':>13}{'cost':>11}")
    for row in rows:
        if row["status"] != "solved":
            lines.append(f"{float(row['c']):8.3f}  {row['message']}")
            continue
        numbers = [float(row[key]) for key in ("c", "displacement_body_lengths", "dissipation", "cost")]
        lines.append(f"{numbers[0]:8.3f}{numbers[1]:14.6f}{numbers[2]:13.6f}{numbers[3]:11.6f}")
    return lines + [line.strip() for line in beside_lines(record.get("beside"))]


def _diagnosis_lines(_folder: Path, record: dict[str, Any]) -> list[str]:
    from serpenoid.diagnose.report.summary import lines

    return [f"diagnosis of {record['campaign']}, written {record['provenance']['written']}", *lines(record)]


def _in_use_lines(_folder: Path, record: dict[str, Any]) -> list[str]:
    from serpenoid.studies.in_use import lines

    return lines(record)


OFF = "serpenoid robot off --robot FILE --port PORT"


def _play_lines(folder: Path, record: dict[str, Any]) -> list[str]:
    played = (
        f"{counted(record['cycles'], 'cycle')} of {record['cycle_duration_s']:g} s, pauses of {record['pause_s']:g} s"
    )
    off = "torque is off on every servo" if record["torque_off"] else f"TORQUE MAY STILL BE ON: {OFF}"
    return [
        f"played on {record['robot']}: {record['status']} ({record['reason']})",
        played,
        *_reached(folder, record),
        off,
    ]


def _reached(folder: Path, record: dict[str, Any]) -> list[str]:
    """Where the servo log of a trial that was not played to its end breaks off; its last row may be cut."""
    log = folder / "servo.csv"
    if record["status"] in ("done", "strayed") or not log.exists():
        return []
    rows = [line.split(",") for line in read_text(log, RECORDING_BYTES).splitlines()]
    whole = [dict(zip(rows[0], row, strict=True)) for row in rows[1:] if len(row) == len(rows[0])]
    last = whole[-1] if whole else {"phase": "approach"}
    if last["phase"] == "approach":
        return ["it ended before the first row was reached"]
    return [f"it ended in cycle {int(last['cycle']) + 1} of {record['cycles']}, after step {last['step']}"]


def _campaign_lines(folder: Path) -> list[str]:
    from serpenoid.measure.campaign import load_campaign_file

    file, _ = load_campaign_file(folder)
    trials = [" ".join([f"  {trial.name}", *([f" {trial.gait}"] if trial.gait else [])]) for trial in file.trial]
    return [f"campaign {file.name}: {counted(len(file.trial), 'trial')}", *trials]


def _as_said(folder: Path, _record: dict[str, Any]) -> list[str]:
    """What the verb said when it wrote the folder."""
    from serpenoid.errors import InputError

    if not (folder / options.SUMMARY).exists():
        raise InputError(f"no {options.SUMMARY} beside it: {stopped_verb(folder)} {STOPPED}")
    return read_text(folder / options.SUMMARY).splitlines()


RECORDS: dict[str, Callable[[Path, dict[str, Any]], list[str]]] = {
    "sweep.json": _sweep_lines,
    "set.json": _set_lines,
    "solution.json": _lines,
    "diagnosis.json": _diagnosis_lines,
    "in-use.json": _in_use_lines,
    "play.json": _play_lines,
    "compare.json": _as_said,
    "fit.json": _as_said,
    "campaign.json": _as_said,
    "ladder.json": _as_said,
}


def _files(folder: Path) -> list[str]:
    return _named(folder, ".json", ".csv", ".toml") or ["none"]


def _named(folder: Path, *endings: str) -> list[str]:
    """Its files with these endings, but those that a process was writing when it was killed."""
    return sorted(p.name for p in folder.iterdir() if p.suffix in endings and not p.name.startswith(UNFINISHED))


def _reports(folder: Path) -> list[str]:
    return [f"report            {path}" for path in sorted(folder.glob("[!.]*.html"))]


def _pictures(names: list[str], record: str | None) -> list[str]:
    """Of results; a campaign, which has no record, is none."""
    if not names and not record:
        return []
    return [f"pictures          {', '.join(names)}"] if names else ["pictures          none"]


def _effect(record: dict[str, Any]) -> str:
    where = "" if record["place"] is None else f" at {record['place']}"
    return f"{record['name']}{where}: {', '.join(f'{k} {_short(v)}' for k, v in record['parameters'].items())}"


def _short(value: Any) -> str:
    if isinstance(value, bool):
        raise TypeError(f"{value} is no number")
    return f"{value:.6g}" if isinstance(value, float) else str(value)
