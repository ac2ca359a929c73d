"""A cure knows its witness: which of joint table, servo log and markers stands against the two others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from serpenoid.body import Body
from serpenoid.measure.consistency.blame import certain
from serpenoid.measure.consistency.check import check
from serpenoid.measure.consistency.claim import Claim, outline
from serpenoid.measure.consistency.hypotheses import TABLE_AND_LOG
from serpenoid.measure.consistency.rivals import ODDS, Rival, _doubts
from serpenoid.measure.consistency.signals import Signal
from serpenoid.measure.schedule import Schedule
from serpenoid.measure.shapes.links import chain_vertices

MIDDLES = [0, 1, 3, 5, 7, 9, 11, 12]  # of six links: their markers show no joint's angle
CURES = {
    "signs": {"table": "flip the signs of `joint_table`", "log": "flip the signs of the servo log",
              "markers": "check `up_axis`"},
    "order": {"table": "reverse the columns of `joint_table`", "log": "reverse the columns of the servo log",
              "markers": "`markers` run from tail to head"},
    "ends": {"table": "`joint_table` and flip their signs", "log": "the servo log and flip their signs",
             "markers": "`markers` run from tail to head: reverse them (or"},
    "joint": {"table": "sign of `joint_2` in `joint_table`", "log": "sign of `joint_2` in the servo log"},
}  # fmt: skip
CHANGES = {
    "signs": lambda angles: -angles,
    "order": lambda angles: angles[:, ::-1],
    "ends": lambda angles: -angles[:, ::-1],
    "joint": lambda angles: angles * np.where(np.arange(angles.shape[1]) == 1, -1, 1),
}


def claim(change, wrong: str, sources: str, seed: int) -> Claim:
    """A trial of a random gait, one of its sources changed."""
    rng, phase = np.random.default_rng(seed), 2 * np.pi * np.arange(40)[:, None] / 40
    rows = 0.5 * np.cos(phase + rng.uniform(0, 6, 5)) + 0.15 * np.cos(2 * phase + rng.uniform(0, 6, 5))
    rows = rows + rng.uniform(-0.2, 0.2, 5)
    played = Schedule(rows, 3.0, 2, 1.0)
    told = Schedule(change(rows), 3.0, 2, 1.0) if wrong == "table" else played
    time = np.arange(-0.5, played.end_s + 0.5, 1 / 50)
    angles = played.commanded(time)
    seen, read = angles + rng.normal(0, 0.01, angles.shape), angles + rng.normal(0, 0.002, angles.shape)
    film = Signal(time + 7, change(seen) if wrong == "markers" else seen) if "m" in sources else None
    log = Signal(time + 90, change(read) if wrong == "log" else read) if "l" in sources else None
    bends = outline(ROBOT, time + 7, marked(seen, rng)) if "o" in sources else None
    return Claim("t", "gait", told, cameras=film, servos=log, outline=bends)


ROBOT = Body(vertices=13, joints=(2, 4, 6, 8, 10), edge_lengths=tuple(0.05 + 0.005 * (k // 2) for k in range(12)))


def marked(angles: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Vertices (F, N, 2) on film, those in the middles of links and at the ends of the body."""
    whole = chain_vertices(ROBOT, np.zeros((len(angles), 3)), angles)
    shown = np.full_like(whole, np.nan)
    shown[:, MIDDLES] = whole[:, MIDDLES] + rng.normal(0, 0.0005, whole[:, MIDDLES].shape)
    return shown


BLAMED = [
    ("lm", "table", ["table"]),
    ("lm", "log", ["log"]),
    ("lm", "markers", ["markers"]),
    ("l", "table", ["table", "log"]),  # nobody knows which
    ("m", "table", ["table", "markers"]),
    ("lo", "table", ["table"]),  # a film that shows no joint's angle knows all the same
    ("lo", "log", ["log"]),
]
# always: what is wrong in markers, and of the rest every pair of sources and every change
ALWAYS = [("joint", "lm", "table"), ("joint", "lo", "log"), ("signs", "lm", "table"), ("order", "lm", "log"),
          ("order", "l", "table"), ("ends", "m", "table"), ("ends", "lo", "table"), ("ends", "lo", "log")]  # fmt: skip
CASES = [
    pytest.param(kind, *case, marks=[] if quick else pytest.mark.slow, id=f"{kind}-{case[0]}-{case[1]}")
    for kind in CURES
    for case in BLAMED
    if not (kind == "joint" and case[1] == "markers")  # one joint's sign is not wrong in markers
    for quick in [case[1] == "markers" or (kind, *case[:2]) in ALWAYS]
]


@pytest.mark.parametrize(("kind", "sources", "wrong", "blamed"), CASES)
def test_the_source_that_stands_against_both_others_is_blamed(kind, sources, wrong, blamed):
    found = check([claim(CHANGES[kind], wrong, sources, 5)], {}).contradictions
    assert found
    said = [one.cure.replace(TABLE_AND_LOG, "both") for one in found]
    for source, cure in CURES[kind].items():
        assert all((cure in words) is (source in blamed) for words in said), said
    assert all(("both" in words) is (wrong == "markers") for words in said), said  # they may count alike another way
    third = {("table", True): "the film sides with the servo log", ("log", True): "the film sides with the joint table"}
    sides = third.get((wrong, len(sources) == 2), "")  # of three witnesses two agree
    assert all((sides in one.words) and ("sides" in one.words) is bool(sides) for one in found), found
    assert all("joint table" in one.words for one in found if kind == "joint" and "l" in sources), found


def rival(trial: str, kind: str, lead: float) -> Rival:
    everywhere = kind == "ends"
    explained = 0.99 if lead > ODDS + 2 else 0.2
    return Rival(trial, "the log", kind, f"follow `{trial}` {kind}", kind, lead, -2.0, everywhere, explained,
                 ("table", "log"), {})  # fmt: skip


@pytest.mark.parametrize(
    ("leads", "said"),
    [
        ({"g1": (3232, 3241), "g2": (2776, -1000)}, {"g1": "reversed", "g2": "reversed"}),  # not so in every trial
        ({"g1": (3232, 3241), "g2": (-500, 2776)}, {"g1": "ends", "g2": "ends"}),
        ({"g1": (3240, 3241)}, {"g1": "ends; or reversed"}),  # one gait cannot tell
        ({"g1": (3000, -200), "g2": (-100, 2776)}, {"g1": "reversed", "g2": "ends"}),  # two faults
    ],
)
def test_what_is_said_agrees_over_the_gaits(leads, said):
    rivals = [
        rival(g, kind, lead) for g, pair in leads.items() for kind, lead in zip(("reversed", "ends"), pair, strict=True)
    ]
    assert {one.trial: one.cure for one in certain(rivals)} == said


def test_a_doubt_has_the_cures_of_what_was_compared():
    sure = rival("g1", "ends", 50.0)
    cures = {"table": "turn the table", "log": "turn the log", "markers": "turn the markers"}
    ((_, said),) = _doubts([replace(sure, cures=cures)], [])
    assert said.endswith("else: turn the table; or turn the log")


@pytest.mark.parametrize(
    ("wrong", "cure"), [("table", "name `b` in `joint_table`"), ("log", "own file in `servo_log`")]
)
def test_the_film_says_whether_the_table_or_the_log_is_of_a_gait_that_resembles_the_other(wrong, cure):
    rng, phase = np.random.default_rng(3), 2 * np.pi * np.arange(40)[:, None] / 40
    first = 0.5 * np.cos(phase + np.arange(5))
    tables = {"a": first, "b": first + 0.25 * np.cos(2 * phase + rng.uniform(0, 6, 5))}  # they correlate by 0.9
    own, other = (Schedule(table, 3.0, 2, 1.0) for table in tables.values())
    time = np.arange(-0.5, own.end_s + 0.5, 1 / 50)
    filmed = (other if wrong == "table" else own).commanded(time)
    seen, read = filmed + rng.normal(0, 0.005, filmed.shape), other.commanded(time)
    log = {"servos": Signal(time, read + rng.normal(0, 0.002, read.shape)), "commands": Signal(time, read)}
    healthy = own.commanded(time)
    shown = Signal(time, healthy + rng.normal(0, 0.005, healthy.shape))
    right = Claim("t1", "a", own, shown, Signal(time, healthy), Signal(time, healthy))
    trial = Claim("t2", "a", own, cameras=Signal(time, seen), **log)
    (found,) = check([right, trial], tables).contradictions
    assert found.trial == "t2"
    assert cure in found.cure


def test_two_joints_that_are_exchanged_in_the_log_of_one_trial_are_told_of_that_trial():
    trials = [replace(claim(lambda a: a, "", "lm", seed), trial=f"t{seed}") for seed in (5, 6, 7)]
    assert check(trials, {}).contradictions == ()
    log = trials[1].servos
    wrong = replace(trials[1], servos=Signal(log.time_s, log.values[:, [0, 2, 1, 3, 4]]))
    found = check([trials[0], wrong, trials[2]], {}).contradictions
    assert {one.trial for one in found} == {"t6"}
    assert all("exchange `joint_2` and `joint_3` in this trial" in one.cure for one in found), found


@pytest.mark.parametrize("exchanged", [True, False])
@pytest.mark.parametrize(("late", "reach"), [(0.04, 1.0), (0.15, 0.8)])  # or a weak servo
def test_readings_that_come_before_the_commands_are_the_commands(exchanged, late, reach):
    trial = claim(lambda a: a, "", "lm", 5)
    time = trial.servos.time_s
    told = trial.schedule.commanded(time - 90)
    read = reach * trial.schedule.commanded(time - 90 - late) + np.random.default_rng(1).normal(0, 0.002, told.shape)
    first, second = (told, read) if exchanged else (read, told)
    found = check([replace(trial, servos=Signal(time, first), commands=Signal(time, second))], {}).contradictions
    assert [one.kind for one in found] == ["exchanged"] * exchanged
    assert all("are `command` and `position` exchanged" in one.cure for one in found)
