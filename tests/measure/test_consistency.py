"""A campaign that contradicts its data is never believed; physics that damages a robot is no contradiction."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from rehearsal import ROOT, of_links, serpenoid_table, snake
from serpenoid.compare.rehearse import Laboratory, write_campaign
from serpenoid.errors import InputError
from serpenoid.files.writing import write_csv
from serpenoid.measure.campaign import load_campaign_file
from serpenoid.measure.consistency.check import Verdict, check
from serpenoid.measure.consistency.claim import Claim
from serpenoid.measure.consistency.claims import check_files, contradictions
from serpenoid.measure.consistency.films import films_of
from serpenoid.measure.consistency.geometry import marker_faults
from serpenoid.measure.consistency.hypotheses import rounded
from serpenoid.measure.consistency.layout import layout
from serpenoid.measure.consistency.match import course_of, match, match_at
from serpenoid.measure.consistency.rivals import ODDS
from serpenoid.measure.consistency.signals import Signal, sample
from serpenoid.measure.formats.motive import read_motive
from serpenoid.measure.load import load_campaign
from serpenoid.measure.schedule import Schedule
from serpenoid.measure.trial_files import read_files
from serpenoid.measure.write import write_motive

TABLES = {
    "gait-1": serpenoid_table(40), "gait-2": serpenoid_table(40, a=4.0, xi=1.3),
    "gait-3": serpenoid_table(40, a=5.0, xi=0.8, turn=1.5),
}  # fmt: skip


@pytest.fixture(scope="module")
def valid(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("valid")
    lab = Laboratory(frames_per_second=30.0, lag_s=0.05)
    write_campaign(folder, snake(), TABLES, lab, 1, 0, cycle_duration_s=2.0, cycles=2, pause_s=1.0)
    return folder


def text(old: str, new: str) -> Callable[[Path], None]:
    """An edit of campaign.toml, at its first place."""

    def edit(folder: Path) -> None:
        path = folder / "campaign.toml"
        assert old in path.read_text()
        path.write_text(path.read_text().replace(old, new, 1))

    return edit


def trade(folder: Path, name: str) -> None:
    """The files of this name of two trials in each other's place."""
    one, other = (folder / trial / name for trial in ("gait-1-1", "gait-2-1"))
    kept = one.read_bytes()
    one.write_bytes(other.read_bytes())
    other.write_bytes(kept)


def without_logs(folder: Path) -> None:
    path = folder / "campaign.toml"
    path.write_text("\n".join(row for row in path.read_text().splitlines() if not row.startswith("servo_log")))


def table(change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Path], None]:
    """All joint tables changed, as one who mixed up the wiring would."""

    def edit(folder: Path) -> None:
        for name, rows in TABLES.items():
            header = [f"joint_{j}" for j in range(1, rows.shape[1] + 1)]
            write_csv(folder / "gaits" / f"{name}.csv", header, change(rows).tolist())

    return edit


def markers(change: Callable[[list[str]], list[str]]) -> Callable[[Path], None]:
    """`markers` of [motion] in another order."""

    def edit(folder: Path) -> None:
        path = folder / "campaign.toml"
        names = [f'"Snake:vertex_{k}"' for k in range(12)]
        old, new = ", ".join(names), ", ".join(change(names))
        path.write_text(path.read_text().replace(old, new))

    return edit


def exchanged(order: list, i: int, j: int) -> list:
    new = list(order)
    new[i], new[j] = new[j], new[i]
    return new


def flipped(rows: np.ndarray) -> np.ndarray:
    changed = rows.copy()
    changed[:, 3] *= -1
    return changed


def swapped(rows: np.ndarray) -> np.ndarray:
    return rows[:, exchanged(list(range(10)), 2, 6)]


MILLIMETRES = "edge_lengths = [41.8, " + ", ".join(["83.6"] * 9) + ", 41.8]"
TWO_SECONDS = r"set `cycle_duration_s = (2|2\.0.|1\.9.)`"  # to a frame
FAULTS = {
    "cycle duration halved": (text("cycle_duration_s = 2.0", "cycle_duration_s = 1.0"), TWO_SECONDS),
    "cycle duration doubled": (text("cycle_duration_s = 2.0", "cycle_duration_s = 4.0"), TWO_SECONDS),
    "fewer cycles": (text("cycles = 2", "cycles = 1"), "show 2 cycles, and `cycles` says 1.*set `cycles = 2`"),
    "a pause that was none": (text("pause_s = 1.0", "pause_s = 0.0"), "set `pause_s = (1|0.9|1.0)"),
    "another table": (text('"gaits/gait-1.csv"', '"gaits/gait-3.csv"'), "follow `gait-1`, not `gait-3`"),
    "played backwards": (table(lambda rows: np.concatenate([rows[:1], rows[:0:-1]])), "played backwards"),
    "rows in reverse order": (table(lambda rows: rows[::-1]), "played backwards"),
    "all signs": (table(lambda rows: -rows), "all signs flipped"),
    "one sign": (table(flipped), "turn `joint_4` the other way"),
    "joint order": (table(lambda rows: rows[:, ::-1]), "joints in reversed order"),
    "two joints exchanged": (table(swapped), "`joint_3` and `joint_7` exchanged"),
    "shifted in time": (table(lambda rows: np.roll(rows, 12, axis=0)), "begin near row (10|13)"),
    "up axis": (text('up_axis = "y"', 'up_axis = "x"'), 'set `up_axis = "y"`'),
    "markers exchanged": (markers(lambda names: exchanged(names, 4, 7)), "`Snake:vertex_7` and `Snake:vertex_4`"),
    "neighbours exchanged": (markers(lambda names: exchanged(names, 4, 5)), "exchanged along the body"),
    "tail for head": (markers(lambda names: names[::-1]), "head and tail exchanged"),
    "one edge": (text("[0.0418, 0.0836", "[41.8, 0.0836"), "`Snake:vertex_0` and `Snake:vertex_1` 0.041"),
    "body in millimetres": (text("BODY", MILLIMETRES), "is the file in m, \\[body\\] in mm"),
}  # fmt: skip
MARKERS = {
    "up axis",
    "markers exchanged",
    "neighbours exchanged",
    "one edge",
    "body in millimetres",
}  # judged before any log


# the signs, and the joints, of all are turned round one by one in other tests; rows in reverse order are a gait that is
# played backwards but for a row; another table is told with logs and without, of the rest most in one of the two ways
TWICE = {
    ("all signs", False),
    ("joint order", False),
    ("rows in reverse order", False),
    ("rows in reverse order", True),
    ("tail for head", False),
    ("played backwards", False),
    ("shifted in time", False),
    ("one sign", False),
    ("cycle duration halved", False),
    ("cycle duration doubled", True),
    ("fewer cycles", True),
    ("a pause that was none", True),
    ("two joints exchanged", True),
}
TRIED = [
    pytest.param(fault, logs, marks=pytest.mark.slow if (fault, logs) in TWICE else [])
    for fault in FAULTS
    for logs in (True, False)
    if logs or fault not in MARKERS
]


@pytest.mark.parametrize(("fault", "logs"), TRIED)
def test_a_contradiction_is_refused_with_its_cure(valid, tmp_path, fault, logs):
    folder = tmp_path / "campaign"
    shutil.copytree(valid, folder)
    edit, cure = FAULTS[fault]
    if fault == "body in millimetres":
        row = next(r for r in (folder / "campaign.toml").read_text().splitlines() if r.startswith("edge_lengths"))
        edit = text(row, MILLIMETRES)
    edit(folder)
    if not logs:
        without_logs(folder)
    with pytest.raises(InputError, match=cure) as refusal:
        load_campaign(folder)
    assert "nothing is computed from it" in str(refusal.value)
    touched = 1 if re.search("duration|pause|another table|fewer cycles", fault) else 3
    accused = re.findall(r"`(gait-\d-1)`[,:]", str(refusal.value))
    assert len(accused) == len(set(accused)) == touched  # no trial is accused that agrees with its data


def test_a_servo_log_of_another_trial_is_recognised(valid, tmp_path):
    shutil.copytree(valid, tmp_path / "c")
    text('servo_log = "gait-2-1/servo.csv"', 'servo_log = "gait-1-1/servo.csv"')(tmp_path / "c")
    with pytest.raises(InputError, match="trial `gait-2-1`: the servo log's commands follow `gait-1`, not `gait-2`"):
        load_campaign(tmp_path / "c")


def test_two_logs_exchanged_accuse_the_logs_and_not_the_tables(valid, tmp_path):
    shutil.copytree(valid, tmp_path / "c")
    trade(tmp_path / "c", "servo.csv")
    with pytest.raises(InputError, match="name the trial's own file in `servo_log`") as refusal:
        load_campaign(tmp_path / "c")
    assert "in `joint_table`" not in str(refusal.value)
    assert "in `motion`" not in str(refusal.value)


def test_table_and_log_that_count_joints_from_the_head_may_be_what_is_wrong(valid, tmp_path):
    shutil.copytree(valid, tmp_path / "c")
    table(lambda rows: rows[:, ::-1])(tmp_path / "c")
    for log in (tmp_path / "c").glob("*/servo.csv"):
        header, *rows = [line.split(",") for line in log.read_text().splitlines()]
        order = [int(name.split("_")[1]) if "_" in name and name != "t_s" else None for name in header]
        place = {name: i for i, name in enumerate(header)}
        joints = max(j for j in order if j)
        turned = [
            place[f"{name.split('_')[0]}_{joints + 1 - j}"] if j else i
            for i, (name, j) in enumerate(zip(header, order, strict=True))
        ]
        log.write_text("\n".join(",".join(row) for row in [header, *([r[i] for i in turned] for r in rows)]) + "\n")
    with pytest.raises(InputError, match="joints in reversed order") as refusal:
        load_campaign(tmp_path / "c")
    assert "reverse the columns of `joint_table` and the servo log" in str(refusal.value)


def test_two_films_exchanged_accuse_the_films_and_not_the_logs(valid, tmp_path):
    shutil.copytree(valid, tmp_path / "c")
    trade(tmp_path / "c", "motion.csv")
    with pytest.raises(InputError, match="follow the servo log of trial `gait-2-1`, not their own") as refusal:
        load_campaign(tmp_path / "c")
    assert "are the recordings of two trials exchanged? Name each trial's own in `motion`" in str(refusal.value)
    assert "`servo_log`" not in str(refusal.value)


@pytest.mark.slow
def test_shapes_of_no_gait_of_the_campaign_are_refused(valid, tmp_path):
    shutil.copytree(valid, tmp_path / "c")
    without_logs(tmp_path / "c")
    rng = np.random.default_rng(3)
    other = 0.5 * np.cos(2 * np.pi * np.arange(40)[:, None] / 40 * 3 + rng.uniform(0, 6, 10))
    write_csv(tmp_path / "c/gaits/gait-1.csv", [f"joint_{j}" for j in range(1, 11)], other.tolist())
    with pytest.raises(InputError, match="trial `gait-1-1`: .*(do not follow|neither)"):
        load_campaign(tmp_path / "c")


def test_the_same_recording_under_two_names_is_refused(valid, tmp_path):
    shutil.copytree(valid, tmp_path / "c")
    shutil.copy(tmp_path / "c/gait-1-1/motion.csv", tmp_path / "c/gait-3-1/motion.csv")
    with pytest.raises(
        InputError, match="trial `gait-3-1`: its recording is that of trial `gait-1-1`.*each its part by `from_s`"
    ):
        load_campaign(tmp_path / "c")


def test_the_servo_log_of_a_repeat_is_told_unless_both_are_parts_of_one_film(valid, tmp_path):
    folder = tmp_path / "c"
    shutil.copytree(valid, folder)
    shutil.copytree(folder / "gait-1-1", folder / "again")
    own = (folder / "campaign.toml").read_text()
    (trial,) = [part for part in own.split("[[trial]]") if 'name = "gait-1-1"' in part]
    again = "[[trial]]" + trial.replace('name = "gait-1-1"', 'name = "again"').replace('"gait-1-1/', '"again/')
    film = folder / "again/motion.csv"
    tracks = read_motive(film)
    rng = np.random.default_rng(2)
    write_motive(film, tracks.time_s, tracks.floor + rng.normal(0, 1e-3, tracks.floor.shape), list(tracks.names))
    (folder / "campaign.toml").write_text(own + "\n" + again)
    said = {(name, words.partition(". ")[0]) for name, words in leads(folder).remarks}
    assert said == {
        ("again", f"its {log} log is that of trial `gait-1-1`, number by number") for log in ("servo", "power")
    }
    (folder / "campaign.toml").write_text(
        own.replace(trial, trial.rstrip() + "\nto_s = 7.0\n\n")
        + f"\n[[trial]]{trial.rstrip()}\nfrom_s = 0.5\n".replace('name = "gait-1-1"', 'name = "again"')
    )
    assert leads(folder).remarks == ()


def test_markers_that_a_tracker_confuses_half_way_are_named_with_the_time(valid, tmp_path):
    shutil.copytree(valid, tmp_path / "c")
    without_logs(tmp_path / "c")
    path = tmp_path / "c/gait-1-1/motion.csv"
    tracks = read_motive(path)
    half = len(tracks.time_s) // 2
    floor = tracks.floor.copy()
    floor[half:, [4, 5]] = floor[half:, [5, 4]]
    write_motive(path, tracks.time_s, floor, list(tracks.names))
    with pytest.raises(InputError, match="`gait-1-1`: .*vertex_4` and `.*vertex_5` exchanged between"):
        load_campaign(tmp_path / "c")


@pytest.mark.parametrize(("size", "frames", "moves"), [(0.0, 300, False), (0.0, 40, False), (0.05, 12, True)])
def test_a_robot_that_stands_still_shows_no_motion_however_noisy_its_markers(size, frames, moves):
    noise = np.random.default_rng(0).normal(size=(frames, 3)) * 0.01
    wave = size * np.sin(2 * np.pi * np.arange(frames) / 12)  # twelve frames a cycle: the slowest film that is used
    assert Signal(np.arange(frames) / 10, noise + wave[:, None]).moves is moves


def test_a_contradiction_that_is_believed_is_said_in_the_trial(valid, tmp_path):
    shutil.copytree(valid, tmp_path / "c")
    text('"gaits/gait-1.csv"', '"gaits/gait-3.csv"\nbelieve = true')(tmp_path / "c")
    trial = load_campaign(tmp_path / "c").trials[0]
    assert any("believed against its data: the servo log's commands follow `gait-1`" in note for note in trial.notes)
    assert [c.kind for c in contradictions(tmp_path / "c")] == ["table"]


def test_the_valid_campaign_agrees_with_itself(valid):
    assert all(trial.notes == () for trial in load_campaign(valid).trials)
    assert contradictions(valid) == ()


def leads(folder: Path) -> Verdict:
    file, place = load_campaign_file(folder)
    body, read = read_files(file, place)
    return check_files(file, place, body, read, films_of(file, body, read))


def damaged(angles: np.ndarray, kind: str, rng: np.random.Generator) -> np.ndarray:
    """What wear does to joint angles (R, m) over time."""
    moved, joints = angles.copy(), angles.shape[1]
    if kind == "stuck joints":
        moved[:, rng.choice(joints, max(1, joints // 4), replace=False)] = 0.2
    elif kind == "weak servos":
        moved *= rng.uniform(0.4, 0.8)
    elif kind == "wrong zeros":
        moved += rng.normal(0, 0.15, joints)
    elif kind == "slow servos":
        reach = rng.uniform(0.4, 0.7) * np.abs(np.diff(angles, axis=0)).max()
        for row in range(1, len(moved)):
            moved[row] = moved[row - 1] + np.clip(moved[row] - moved[row - 1], -reach, reach)
    elif kind == "play":
        for row in range(1, len(moved)):
            moved[row] = np.clip(moved[row - 1], moved[row] - 0.08, moved[row] + 0.08)
    return moved


@pytest.mark.parametrize("kind", ["healthy", "stuck joints", "weak servos", "wrong zeros", "slow servos", "play"])
@pytest.mark.parametrize("joints", [1, *(pytest.param(n, marks=pytest.mark.slow) for n in (3, 8)), 20])
def test_a_damaged_robot_is_no_contradiction(kind, joints):
    """Over sizes, frame rates, marker noise, damage; the shapes alone, without any log."""
    for seed in range(1 if joints in (1, 20) else 2):
        rng = np.random.default_rng([seed, joints])
        tables = {f"gait-{k}": varied(rng, joints) for k in range(5)}
        rate, noise = rng.choice([25.0, 60.0, 250.0]), rng.choice([0.002, 0.01, 0.04])
        schedule = Schedule(tables["gait-0"], rng.uniform(1, 4), int(rng.integers(1, 4)), float(rng.choice([0, 1.0])))
        time = np.arange(-0.5, schedule.end_s + 0.5, 1 / rate)
        angles = damaged(schedule.commanded(time), kind, rng)
        angles += rng.normal(0, noise, angles.shape)
        found = check([Claim("t", "gait-0", schedule, cameras=Signal(time + 7.0, angles))], tables)
        assert found.contradictions == (), found.contradictions


def varied(rng: np.random.Generator, joints: int) -> np.ndarray:
    wave = np.exp(1j * rng.uniform(0, 2 * np.pi)) * np.exp(2j * np.pi * rng.uniform(0.5, 1.5) * np.arange(joints) / 10)
    phase = np.exp(2j * np.pi * np.arange(40)[:, None] / 40)
    return rng.uniform(0.3, 0.8) * np.real(phase * wave) + rng.uniform(-0.2, 0.2, joints)


def test_one_joint_cannot_tell_a_half_cycle_from_a_flipped_sign():
    """A sine with its sign flipped is a sine half a cycle later: nothing may be concluded."""
    rows = 0.6 * np.sin(2 * np.pi * np.arange(40) / 40)[:, None]
    schedule = Schedule(rows, 2.0, 3, 0.0)
    time = np.arange(0.3, 5.9, 1 / 50)
    signal = Signal(time, -schedule.commanded(time))
    assert check([Claim("t", "sine", schedule, cameras=signal)], {"sine": rows}).contradictions == ()


@pytest.mark.parametrize("pause", [0.0, 0.8, 4.0])
def test_the_period_of_a_signal_includes_its_pause(pause):
    schedule = Schedule(serpenoid_table(40), 1.7, 4, pause)
    time = np.arange(0, schedule.end_s, 1 / 60)
    found = Signal(time, schedule.commanded(time)).period_s
    assert found == pytest.approx(1.7 + pause, abs=0.02)  # a frame


@pytest.mark.parametrize(("rest", "pause"), [(0.0, 0.0), (1.0, 0.0), (2.0, 0.5), (5.0, 0.0), (5.0, 8.0)])
@pytest.mark.parametrize("cycles", [2, 3, 6])
def test_rest_before_and_after_does_not_draw_the_period(rest, pause, cycles):
    schedule = Schedule(serpenoid_table(40), 1.7, cycles, pause)
    time = np.arange(-rest, schedule.end_s + rest, 1 / 60)
    shown = schedule.commanded(time)
    noise = np.random.default_rng(2).normal(0, 1e-3, shown.shape)
    assert Signal(time, shown + noise).period_s == pytest.approx(1.7 + pause, abs=0.02)  # a frame
    assert Signal(time, shown + noise).repeats_s == pytest.approx(1.7 + pause, abs=0.005)


@pytest.mark.parametrize("holes", [0.0, 0.1])
@pytest.mark.parametrize("joints", [2, 5])
def test_two_cycles_whose_pauses_rest_far_out_repeat(joints, holes):
    """A pause at a wave's crest is far from the mean, and no motion; rows in holes are missing at every delay."""
    rng = np.random.default_rng(joints)
    phase = 2 * np.pi * (np.arange(40)[:, None] / 40 - np.arange(joints) / joints)
    schedule = Schedule(0.9 * np.cos(phase), 2.5, 2, 1.0)
    found = []
    for _ in range(20):
        time = np.arange(-1.0, schedule.end_s + 0.5, 1 / 30)
        values = schedule.commanded(time) + rng.normal(0, 0.005, (len(time), joints))
        for begin in rng.choice(len(time) - 6, round(holes * len(time) / 6), replace=False):
            values[begin : begin + 6] = np.nan
        found.append(Signal(time, values).period_s)
    assert sum(one is not None for one in found) >= 18  # with the least overlap of two cycles, holes may hide it
    assert all(one is None or abs(one - 3.5) < 0.04 for one in found)  # a frame


def test_a_cycle_and_a_third_have_no_period():
    schedule = Schedule(serpenoid_table(40), 4.0, 2, 0.0)
    time = np.arange(0, 5.3, 1 / 30)
    assert Signal(time, schedule.commanded(time)).period_s is None


def tracked(count: int) -> np.ndarray:
    """Points (F, N, 2) of an animal with a travelling bend, without lengths."""
    time, s = np.arange(80)[:, None] / 20, np.linspace(0, 1, count)
    angle = 0.6 * np.sin(2 * np.pi * (time - s[:-1]))
    edge = np.stack([np.cos(angle), np.sin(angle)], axis=2) / (count - 1)
    return np.concatenate([np.zeros((80, 1, 2)), np.cumsum(edge, axis=1)], axis=1) + 0.2 * time[..., None]


@pytest.mark.parametrize("count", [5, 8, 20])
def test_an_animal_without_lengths_shows_which_points_are_exchanged(count):
    points = tracked(count)
    names = [f"p{k}" for k in range(count)]
    assert [f for f in marker_faults(layout(points, None), names, None) if f.gain > ODDS] == []
    order = exchanged(list(range(count)), 1, 2)
    found = marker_faults(layout(points[:, order], None), names, None)
    assert found[0].gain > ODDS
    assert "`p1` and `p2`" in found[0].words


@pytest.mark.parametrize("known", [True, False], ids=["lengths given", "no lengths"])
@pytest.mark.parametrize("k", [0, 3, 7])
def test_one_column_in_another_unit_is_told_by_its_name(k, known):
    points, edges = tracked(8), of_links(np.full(7, 1 / 7)) if known else None
    points[:, k, 0] *= 1000
    found = marker_faults(layout(points + 0.01, edges), list("abcdefgh"), None)
    assert found[0].gain > ODDS
    assert f"`{'abcdefgh'[k]}` where it cannot be" in found[0].words


def test_a_marker_that_is_badly_placed_is_not_said_to_be_elsewhere():
    points = tracked(8)
    points[:, 3, 0] += 0.9 / 7
    found = marker_faults(layout(points, of_links(np.full(7, 1 / 7))), list("abcdefgh"), None)
    assert "elsewhere" not in [fault.kind for fault in found]


def test_a_body_of_three_points_says_nothing_about_its_order():
    points = tracked(3)[:, [1, 0, 2]]
    assert all(f.gain < ODDS for f in marker_faults(layout(points, None), list("abc"), None))


def test_the_lampreys_beat_is_found_in_spite_of_bad_frames():
    motion = load_campaign(ROOT / "problems/campaigns/lamprey.toml").trials[0].motion
    found = Signal(motion.time_s, motion.joint_angles).period_s
    assert found == pytest.approx(1 / 3.8, abs=0.02)  # 3.8 Hz is known from outside; a frame


@pytest.mark.parametrize("rate", [0.994, 1.006])
def test_two_repeats_of_a_gait_do_not_accuse_one_another_of_the_wrong_log(rate):
    """One recording's clock and the other's log run at `rate`: either log fits either recording, and is no rival."""
    schedule = Schedule(serpenoid_table(40), 2.0, 8, 0.0)
    time = np.arange(0, schedule.end_s, 1 / 60)
    angles = schedule.commanded(time)
    rng = np.random.default_rng(4)

    def claim(trial: str, filmed: np.ndarray, logged: np.ndarray) -> Claim:
        seen, read = (angles + 0.002 * rng.standard_normal(angles.shape) for _ in range(2))
        return Claim(trial, "gait-1", schedule, cameras=Signal(filmed, seen), servos=Signal(logged, read))

    claims = [claim("first", time / rate, time), claim("second", time, time * rate)]
    verdict = check(claims, {"gait-1": serpenoid_table(40)})
    assert verdict.contradictions == ()
    assert not [r for r in verdict.rivals if r.kind == "log"]


@pytest.mark.parametrize("rate", [0.5, 1.0, 1.2, 2.0])
def test_a_film_at_another_frame_rate_than_its_log_is_told_as_such(rate):
    """At half the frames a second a film moves for longer than its log runs: it is no log that ended too soon."""
    schedule = Schedule(serpenoid_table(40), 3.0, 2, 0.5)
    time = np.arange(-1.0, schedule.end_s + 1.0, 1 / 60)
    angles = schedule.commanded(np.clip(time, 0.0, schedule.end_s))
    seen, read = (angles + 0.002 * np.random.default_rng(k).standard_normal(angles.shape) for k in range(2))
    claims = [Claim("one", "gait-1", schedule, cameras=Signal(rate * time, seen), servos=Signal(time, read))]
    found = check(claims, {"gait-1": serpenoid_table(40)}).contradictions
    told = [c for c in found if c.cure.startswith("check the frame rate of the recording")]
    assert bool(told) == bool(found) == (rate != 1.0)
    assert not [c for c in found if "another trial" in c.cure]


@pytest.mark.parametrize("joints", [3, 30, 90])
def test_rates_of_a_clock_are_tried_whatever_the_number_of_joints(joints):
    """All at once, some at once, one by one: each is laid as it is alone, but for what lies between its starts."""
    rows = np.arange(40)[:, None] / 40 + np.arange(joints) / joints
    played = Schedule(0.4 * np.sin(2 * np.pi * rows), 2.0, 8, 0.0)
    time = np.arange(-1.0, 17.0, 1 / 60)
    noise = 0.005 * np.random.default_rng(6).standard_normal((len(time), joints))
    grid = sample(Signal(time, played.commanded(time / 1.01) + noise), 0.05)
    found = match(grid, course_of(played))
    assert found.rate == pytest.approx(1.01, abs=3e-4)
    alone = match_at(grid, course_of(played), found.rate)
    assert found.evidence >= alone.evidence
    assert abs(found.start_s - alone.start_s) <= grid.step_s
    assert abs(found.start_s) < grid.step_s / 10  # the truth lies between two starts


@pytest.mark.parametrize("played_s", [1.0, 1.27])
@pytest.mark.parametrize("pause_s", [0.0, 0.5])
def test_a_wrong_duration_is_told_by_the_right_one(played_s, pause_s):
    """Commands are exact: a start between two of the grid was made up for by 0.7 % of the duration, and clocks that
    were let run 6 % slow hid one that is 9 % too long."""
    rows = serpenoid_table(40)
    played = Schedule(rows, played_s, 3, pause_s, 0.613)
    time = np.arange(0.0, played.end_s + 1.0, 0.02)
    promised = Schedule(rows, 1.09 * played_s, 3, pause_s)
    claim = Claim("one", "gait-1", promised, commands=Signal(time, played.commanded(time)))
    (found,) = check([claim], {"gait-1": rows}).contradictions
    said = re.fullmatch(
        r"set `cycle_duration_s = ([\d.]+)`|check the frame rate.*`cycle_duration_s = ([\d.]+)`.*", found.cure
    )
    assert said, found.cure
    assert float(said[1] or said[2]) == pytest.approx(played_s, abs=0.0011 * played_s)


@pytest.mark.parametrize("factor", [0.5, 1.0, pytest.param(2.0, marks=pytest.mark.slow)])
def test_the_duration_of_a_single_cycle_is_told_by_how_long_the_body_moves(factor):
    """Nothing repeats in a trial of one cycle, so no period is seen."""
    played = Schedule(serpenoid_table(40), 2.0, 1, 0.0)
    time = np.arange(-1.0, 3.5, 1 / 60)
    angles = played.commanded(np.clip(time, 0.0, played.end_s))
    seen = Signal(time, angles + 0.005 * np.random.default_rng(5).standard_normal(angles.shape))
    promised = Schedule(played.table, factor * 2.0, 1, 0.0)
    assert seen.period_s is None
    found = check([Claim("one", "gait-1", promised, cameras=seen)], {"gait-1": played.table}).contradictions
    assert [one.kind for one in found] == ([] if factor == 1.0 else ["duration"])
    for one in found:
        assert float(re.findall(r"a cycle of ([0-9.]+) s", one.words)[0]) == pytest.approx(2.0, rel=0.02)


@pytest.mark.parametrize("cycles", [1, 3])
@pytest.mark.parametrize(
    ("many", "runs", "cure"),
    [
        (1e3, "1000", "are its times milliseconds? Set `time_unit`, or give seconds."),
        (1e6, "1000000", "are its times microseconds? Set `time_unit`, or give seconds."),
        (1e9, "1000000000", "are its times nanoseconds? Set `time_unit`, or give seconds."),
        (1e-3, "0.001", "its times were read as milliseconds: are they seconds? Set `time_unit`."),
        (1e-6, "0.000001", "its times were read as microseconds: are they seconds? Set `time_unit`."),
        (1e-5, "0.00001", "are its times in seconds (`time_unit`), and those of this motion alone (`from_s`, `to_s`)?"),
    ],
)
def test_times_in_another_unit_are_told_before_anything_is_laid_over_anything(many, runs, cure, cycles):
    played = Schedule(serpenoid_table(40), 2.0, cycles, 1.0)
    time = np.arange(-1.0, played.end_s + 1.0, 1 / 60)
    angles = played.commanded(np.clip(time, 0.0, played.end_s))
    seen, logged = Signal(time, angles), Signal(many * (time + (1.7e9 if many > 1 else 0)), angles)  # since 1970
    verdict = check([Claim("one", "gait-1", played, cameras=seen, servos=logged)], {"gait-1": played.table})
    assert [one.said for one in verdict.contradictions] == [
        f"the servo log's positions run {runs} times as long as the schedule. Remedy: {cure}"
    ]
    assert verdict.rivals == ()


def test_a_schedule_in_another_unit_is_asked_about_where_log_and_film_agree() -> None:
    """`cycle_duration_s` in milliseconds: no time unit of two recordings need be wrong."""
    played = Schedule(serpenoid_table(40), 2.0, 2, 1.0)
    time = np.arange(-1.0, played.end_s + 1.0, 1 / 60)
    seen = Signal(time, played.commanded(np.clip(time, 0.0, played.end_s)))
    told = Schedule(played.table, 2000.0, 2, 1.0)
    verdict = check([Claim("one", "gait-1", told, cameras=seen, servos=seen)], {"gait-1": played.table})
    assert len(verdict.contradictions) == 2
    for one in verdict.contradictions:
        assert "Remedy: is `cycle_duration_s = 2000` in seconds? Log and film agree; or " in one.said


@pytest.mark.parametrize(("number", "words"), [(1000.0, "1000"), (1.0e6, "1000000"), (1.6667, "1.67"), (5.0, "5")])
def test_numbers_have_three_digits_and_no_power_of_ten(number: float, words: str) -> None:
    assert rounded(number) == words


def test_logs_of_two_trials_of_other_durations_that_are_exchanged_are_told_as_such():
    """One file each, and not a cycle's duration and a table."""
    told = {
        name: Schedule(table, seconds, 2, 0.5)
        for (name, table), seconds in zip(TABLES.items(), (2.0, 3.0, 1.5), strict=True)
    }

    def log(schedule):
        time = np.arange(-0.5, schedule.whole_s, 1 / 30)
        return Signal(time, schedule.commanded(time))

    seen = dict(zip(told, (told["gait-2"], told["gait-1"], told["gait-3"]), strict=True))
    claims = [Claim(f"{n}-1", n, told[n], None, log(seen[n]), log(seen[n])) for n in told]
    found = {c.trial: c for c in check(claims, TABLES).contradictions}
    assert set(found) == {"gait-1-1", "gait-2-1"}
    assert "follow what trial `gait-2-1` was told, not their own" in found["gait-1-1"].words
    assert all("exchanged? Name each trial's own in `servo_log`" in c.cure for c in found.values())
