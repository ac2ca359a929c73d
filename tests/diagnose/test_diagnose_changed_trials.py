"""What acts in some trials of a campaign alone: found by what repeats differ by, and named by those trials."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, Campaign, make
from blind.catalogue import Effect
from blind.folder import write
from blind.protocol import Protocol, usual, with_joints
from serpenoid.cli.main import main
from serpenoid.diagnose import changed_trials as changed_trials_file
from serpenoid.diagnose.changed_trials import in_any_trial, mending_growth, sides
from serpenoid.diagnose.data.windows.tracks import NoPath
from serpenoid.diagnose.inference.fits.finding import Divided, Named, Stage
from serpenoid.diagnose.report.sentences import changed_trials
from serpenoid.diagnose.residuals.in_some_trials import Cause, Differ
from serpenoid.diagnose.residuals.in_some_trials import divided as divided_or_hint
from serpenoid.effects.active import ActiveEffect

GAITS = 6
PAIRS = [(g, g + GAITS) for g in range(GAITS)]
WORN = Effect("worn_wheel", 6, {"seizure": 0.6})


def divided(*of: Any) -> Divided | None:
    """Without hints."""
    found = divided_or_hint(*of)
    return None if found is None or found.hint else found


def told(
    theta: Sequence[float] | np.ndarray,
    rng: np.random.Generator,
    pairs: Sequence[tuple[int, int]] = PAIRS,
    sign: int = 0,
    by: Callable[..., Divided | None] = divided,
) -> Divided | None:
    """Of trials in which the first of three causes acts by so much, with chance in 40 windows of every pair."""
    slopes = rng.normal(size=(len(pairs), 40, 3)) * rng.uniform(0.5, 2, (len(pairs), 1, 1))
    differences = [slopes[p, :, 0] * (theta[b] - theta[a]) + rng.normal(size=40) for p, (a, b) in enumerate(pairs)]
    causes = [
        Cause(
            name, sign, np.array([s[:, [i]].T @ s[:, [i]] for s in slopes]),
            np.array([s[:, [i]].T @ d for s, d in zip(slopes, differences, strict=True)]),
        )
        for i, name in enumerate(["`one`", "`two`", "`three`"])
    ]  # fmt: skip
    differ = Differ(np.array([(d**2).sum() for d in differences]), np.full(len(pairs), 40.0))
    return by(differ, causes, pairs, [f"t{i}" for i in range(len(theta))])


def test_what_began_amid_the_campaign_is_told_with_its_trials() -> None:
    """Gaits 4 to 6 were played twice after it began, gaits 1 to 3 once."""
    theta = np.r_[np.zeros(3), np.full(9, 8.0)]
    found = told(theta, np.random.default_rng(1))
    assert found is not None
    assert not found.perhaps
    assert found.others == ("t0", "t1", "t2")
    assert found.changed == tuple(f"t{i}" for i in range(3, 12))
    assert "(to first order `one`) by which `t0`, `t1` and `t2` differ from the other trials" in found.words


def test_between_two_rounds_growth_looks_like_a_beginning() -> None:
    found = told(np.r_[np.zeros(6), np.full(6, 8.0)], np.random.default_rng(2))
    assert found is not None
    assert found.perhaps
    assert found.changed == tuple(f"t{i}" for i in range(6, 12))
    assert found.words.endswith("or which grows from trial to trial")


def test_what_grows_from_trial_to_trial_is_told_where_pairs_are_unlike() -> None:
    pairs = [(0, 1), (2, 6), (3, 11), (4, 5), (7, 10), (8, 9)]
    found = told(np.linspace(0, 20, 12), np.random.default_rng(3), pairs)
    assert found is not None
    assert not found.changed
    assert "grows from trial to trial" in found.words


def test_what_grows_from_round_to_round_is_told_and_the_last_round_is_held_against_the_first() -> None:
    pairs = [(g + r, g + r + 4) for g in range(4) for r in (0, 4)]
    found = told(np.linspace(0, 12, 12), np.random.default_rng(9), pairs)
    assert found is not None
    assert found.perhaps
    assert found.words.endswith("(to first order `one`) that grows from trial to trial")
    assert found.changed == ("t8", "t9", "t10", "t11")
    assert found.others == ("t0", "t1", "t2", "t3")
    assert found.grows == pytest.approx(1.5 / 8)  # of what the last four differ from the first four by


def test_less_than_most_that_is_no_chance_is_a_hint_alone() -> None:
    """Windows of which noise is more than half: twelve pairs agree on the cause, and it is a third of their squares."""
    pairs = [(g, g + 12) for g in range(12)]
    theta, rng = np.r_[np.zeros(12), np.full(12, 0.6)], np.random.default_rng(11)
    found = told(theta, rng, pairs, by=divided_or_hint)
    assert told(theta, rng, pairs) is None
    assert found is not None
    assert found.hint
    assert not found.changed
    assert "(to first order `one`) by which " in found.words


def test_what_differs_from_repeat_to_repeat_gait_by_gait_is_no_growth() -> None:
    """Each gait's second and third repeat differ by as much from the one before: it may begin anew with every gait."""
    pairs = [(g + r, g + r + 1) for g in range(0, 12, 3) for r in (0, 1)]
    assert told(np.tile([0.0, 6.0, 12.0], 4), np.random.default_rng(10), pairs) is None


def test_what_may_mend_a_cause_that_grows_is_a_stand_in() -> None:
    def of(name: str, place: int | None, strength: float, low: float) -> Named:
        effect = ActiveEffect.neutral(name, place)
        return Named(effect, {p.name: (low, 1.0) for p in effect.effect.parameters}, strength)

    every = (of("worn_wheel", 4, 10.0, 0.4), of("rolling_resistance", None, 3.0, 0.2), of("toe", None, 2.0, -0.1))
    mended, kept = (mending_growth(Stage("motion", every), most) for most in (10 / 3, 0.0))
    assert [(n.effect.name, n.stand_in) for n in mended.named] == [("worn_wheel", False), ("rolling_resistance", True)]
    assert [n.effect.name for n in mended.undetected] == ["toe"]  # it may change nothing
    assert kept.named == every


def test_a_value_that_may_be_that_of_any_trial_has_an_interval_over_all_of_them() -> None:
    """0.276, with trials within a quarter of their mean to either side: the smallest is told, or the largest."""
    wheel = ActiveEffect.of("worn_wheel", 4, seizure=0.276)
    (resting,) = (p.resting for p in wheel.effect.parameters)
    low, high = in_any_trial(Named(wheel, {"seizure": (0.276, 0.276)}, 10.0), 0.25).intervals["seizure"]
    (p,) = wheel.effect.parameters
    x = p.coordinate(0.276) - resting
    assert (low, high) == pytest.approx([p.value(resting + x * 0.75 / 1.25), p.value(resting + x * 1.25 / 0.75)])
    left = Named(ActiveEffect.of("forward_backward_asymmetry", asymmetry=-0.2), {"asymmetry": (-0.25, -0.15)}, 10.0)
    low, high = in_any_trial(left, 0.25).intervals["asymmetry"]
    assert low is not None
    assert high is not None
    assert low < -0.25 * 1.25 / 0.75 + 0.05 < -0.15 < high < 0
    lag = Named(ActiveEffect.of("servo_lag", lag=0.1), {"lag": (0.09, 0.11)}, 10.0)
    assert in_any_trial(lag, 0.25) == lag
    assert in_any_trial(left, 0.0) == left
    unbounded = in_any_trial(Named(wheel, {"seizure": (0.2, 0.3)}, 10.0), 1.0).intervals["seizure"]
    assert unbounded[0] is not None
    assert unbounded[0] <= 0.2


@pytest.mark.parametrize("differ", [{}, {"may_differ_by": None}, {"may_differ_by": 0.25}])
def test_how_much_it_may_grow_is_said_where_it_may(differ: dict[str, float | None]) -> None:
    answer = {"verdict": "explained", "effects": [], **differ}
    said = changed_trials(
        {"changed_trials": {"diagnosis": answer, "trials": ["b"], "others": ["a"]}, "reference": None}
    )
    assert said[:2] == ["`b`, diagnosed beside the others: explained", "no effect named"]
    assert [s.partition(":")[2] for s in said[2:]] == [
        f" {1 - x:.2g} to {1 + x:.2g} times its mean in these, told of one of them" for x in differ.values() if x
    ]


def test_what_goes_again_acts_between_two_moments() -> None:
    pairs = [(0, 3), (1, 6), (2, 9), (4, 7), (5, 10), (8, 11), (3, 5), (6, 8)]
    theta = np.where((np.arange(12) >= 4) & (np.arange(12) < 8), 8.0, 0.0)
    found = told(theta, np.random.default_rng(4), pairs)
    assert found is not None
    assert found.changed == ("t5", "t6")  # t4 and t7 are a pair: nothing tells on which side they are
    assert found.others == tuple(f"t{i}" for i in (0, 1, 2, 3, 8, 9, 10, 11))


def test_what_was_there_and_is_mended_acts_in_the_first_trials() -> None:
    """A wheel cannot be less than healthy: what repeats show is that of the trials before."""
    theta = np.r_[np.full(6, 8.0), np.zeros(6)]
    free, bound = (told(theta, np.random.default_rng(5), sign=sign) for sign in (0, 1))
    assert free is not None
    assert bound is not None
    assert free.changed == bound.others == tuple(f"t{i}" for i in range(6, 12))
    assert free.others == bound.changed == tuple(f"t{i}" for i in range(6))


def test_what_acts_amid_the_second_round_is_not_what_does_not_act_amid_the_first() -> None:
    """Of a wheel both say the same of every pair; it is the shorter story that it was healthy before and after."""
    theta = np.where((np.arange(12) >= 8) & (np.arange(12) < 10), 8.0, 0.0)
    found = told(theta, np.random.default_rng(8), sign=1)
    assert found is not None
    assert found.changed == ("t8", "t9")


def test_a_cause_of_another_size_in_each_trial_has_no_moment() -> None:
    """Weather: in each trial another floor. False alarms are the stated one in a hundred: a third of it each of what
    begins, grows, and goes again."""
    rng = np.random.default_rng(6)
    alarms = sum(told(rng.normal(0, 8, 12), rng) is not None for _ in range(400))
    assert alarms <= 10  # 4 expected; more in one run of three hundred


def test_chance_alone_has_none() -> None:
    rng = np.random.default_rng(7)
    assert sum(told(np.zeros(12), rng) is not None for _ in range(200)) == 0
    assert (
        sum(told(np.zeros(12), rng, by=divided_or_hint) is not None for _ in range(400)) <= 10
    )  # as above: 4 expected


@pytest.mark.parametrize("any_gait", [False, True])
def test_sides_with_no_gait_in_common_are_two_where_no_gait_makes_them(
    any_gait: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []

    def as_it_was(changed: Any, others: Any, known: Any, say: Any) -> None:
        asked.extend(r.name for r in changed)
        raise NoPath("enough is known")

    monkeypatch.setattr(changed_trials_file, "_as_it_was", as_it_was)
    trials: list[Any] = [SimpleNamespace(name=g, setting=(g, 1.0)) for g in "ab"]
    whole: Any = SimpleNamespace(divided=Divided("clocks", ("a",), ("b",), any_gait=any_gait))
    known: Any = SimpleNamespace(ratio=None)
    assert changed_trials_file.changed_trials(trials, known, whole, lambda text: None) is None
    assert asked == ["a"] * any_gait


def test_a_repeat_of_which_nothing_is_told_is_on_the_side_of_its_setting() -> None:
    trials: list[Any] = [SimpleNamespace(name=f"{g}{r}", setting=(g, 1.0)) for g in "abc" for r in (1, 2, 3)]
    changed, others = sides(trials, Divided("", changed=("a1", "b2"), others=("b1", "c3")))
    assert [r.name for r in changed] == ["a1", "a2", "a3", "b2"]
    assert [r.name for r in others] == ["b1", "c1", "c2", "c3"]  # b3 may be either


def diagnosed(campaign: Path, out: Path, *options: str) -> dict[str, Any]:
    assert main(["diagnose", str(campaign), "--out", str(out), "--no-figures", "--quiet", *options]) == 0
    said: dict[str, Any] = json.loads((out / "diagnosis.json").read_text())
    return said


def protocol(combinations: int) -> Protocol:
    """Of a snake of six joints."""
    return with_joints(usual(63, COMBINATIONS[:combinations]), 6)


def changed_in_the_last_round(hidden: Effect, combinations: int) -> Campaign:
    """Round by round; the effect acts in the last one alone."""
    few = protocol(combinations)
    healthy, changed = (make(63, effects, "now", protocol=few, chance=(1,)) for effects in ([], [hidden]))
    names = [t.name for t in healthy.trials]
    last = {max(n for n in names if n.rpartition("-")[0] == of) for of in {n.rpartition("-")[0] for n in names}}
    pairs = zip(healthy.trials, changed.trials, strict=True)
    trials = [new if new.name in last else old for old, new in pairs]
    ordered = tuple(sorted(trials, key=lambda t: t.name.rpartition("-")[2]))
    return Campaign(healthy.identity, healthy.seed, healthy.protocol, (), healthy.world, ordered)


@pytest.mark.slow
@pytest.mark.parametrize("beside", ["the others", "the reference"])
def test_a_wheel_that_seizes_amid_the_campaign_is_named(tmp_path: Path, beside: str) -> None:
    """What it does is many times what repeats differ by else, so it is no chance; the trials in which it is seized are
    told, and by themselves name it, its place and its size."""
    gaits = 2 if beside == "the reference" else 4
    write(changed_in_the_last_round(WORN, gaits), tmp_path / "now")
    options: list[str] = []
    if beside == "the reference":
        write(make(63, [], "then", protocol=protocol(gaits)), tmp_path / "then")
        options = ["--reference", str(tmp_path / "then")]
    said = diagnosed(tmp_path / "now", tmp_path / "out", *options)
    assert said["verdict"] == "unexplained"
    changed = said["changed_trials"]
    last = sorted(changed["trials"])
    assert {name.rpartition("-")[2] for name in last} == {max(n.rpartition("-")[2] for n in last)}
    assert not {n.rpartition("-")[2] for n in last} & {n.rpartition("-")[2] for n in changed["others"]}
    answer = changed["diagnosis"]
    assert answer["verdict"] == "explained"
    (found,) = answer["effects"]
    assert (found["name"], found["place"], found["stand_in"]) == ("worn_wheel", 6, False)
    low, high = found["parameters"]["seizure"]["interval"]
    assert low < WORN.parameters["seizure"] < high
    own = json.loads((tmp_path / "out" / changed["folder"] / "diagnosis.json").read_text())
    assert own["effects"] == answer["effects"]


def wearing(gaits: int) -> Campaign:
    """Gait by gait; a wheel is seized by a little more in each trial."""
    few = protocol(gaits)
    count = len(make(64, [], "now", protocol=few, chance=(1,)).trials)
    worn = [Effect("worn_wheel", 5, {"seizure": 0.9 * i / (count - 1)}) for i in range(count)]
    every = [make(64, [effect], "now", protocol=few, chance=(1,)) for effect in worn]
    names = sorted(t.name for t in every[0].trials)
    trials = tuple(next(t for t in c.trials if t.name == name) for name, c in zip(names, every, strict=True))
    healthy = every[0]
    return Campaign(healthy.identity, healthy.seed, healthy.protocol, (), healthy.world, trials)


def begun_in(hidden: Effect, gaits: int, trials: Callable[[list[str]], set[str]], by_gait: bool) -> Campaign:
    """An effect acts in some trials, by name; round by round or gait by gait."""
    few = protocol(gaits)
    healthy, changed = (make(63, effects, "now", protocol=few, chance=(1,)) for effects in ([], [hidden]))
    order = sorted((t.name for t in healthy.trials), key=lambda n: n if by_gait else n.rpartition("-")[::-1])
    acts = trials(order)
    of = {t.name: t for t in healthy.trials} | {t.name: t for t in changed.trials if t.name in acts}
    return Campaign(healthy.identity, healthy.seed, healthy.protocol, (), healthy.world, tuple(of[n] for n in order))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("hidden", "gaits", "first", "by_gait"),
    [
        (Effect("forward_backward_asymmetry", None, {"asymmetry": -0.4}), 4, 5, False),
        (Effect("left_right_asymmetry", None, {"asymmetry": -0.2}), 5, 8, True),  # no repeat shows it
        (Effect("servo_delay", None, {"delay": 0.05}), 3, 4, False),
    ],
)
def test_what_begins_is_told_with_its_trials_and_its_value(
    hidden: Effect, gaits: int, first: int, by_gait: bool, tmp_path: Path
) -> None:
    campaign = begun_in(hidden, gaits, lambda order: set(order[first:]), by_gait)
    write(campaign, tmp_path / "now")
    said = diagnosed(tmp_path / "now", tmp_path / "out")
    changed = said["changed_trials"]
    assert set(changed["trials"]) == {t.name for t in campaign.trials[first:]}
    assert changed["diagnosis"]["verdict"] == "explained"
    (found,) = changed["diagnosis"]["effects"]
    assert found["name"] == hidden.name
    ((name, true),) = hidden.parameters.items()
    low, high = found["parameters"][name]["interval"]
    assert low < true < high


@pytest.mark.slow
def test_gaits_that_a_law_gets_wrong_are_no_beginning(tmp_path: Path) -> None:
    """Gait by gait, and the same law acts in all trials: what is not in the catalogue divides none of them."""
    few = protocol(5)
    law = [Effect("rolling_resistance", None, {"crossover_speed": 0.05})]
    write(make(63, law, "now", protocol=few, chance=(1,)), tmp_path / "now")
    said = diagnosed(tmp_path / "now", tmp_path / "out", "--without=rolling_resistance")
    assert said["changed_trials"] is None


def test_a_cause_that_went_again_is_told_by_what_pairs_agree_about() -> None:
    """Windows are noisy, so that what is left of all squares tells the two less apart than pairs do."""
    pairs = [(g, g + 5) for g in range(5)] + [(g + 5, g + 10) for g in range(5)]
    theta = np.r_[np.zeros(6), np.full(8, 1.5), 0.0]
    found = told(theta, np.random.default_rng(5), pairs)
    assert found is not None
    assert set(found.others) == {"t0", "t1", "t2", "t3", "t4", "t5", "t14"}


@pytest.mark.slow
def test_what_grows_gait_by_gait_leaves_no_unmarked_name(tmp_path: Path) -> None:
    """Of another place or law, that is: all trials are as if another law acted in all of them."""
    write(wearing(3), tmp_path / "now")
    said = diagnosed(tmp_path / "now", tmp_path / "out")
    assert said["verdict"] not in ("nothing", "explained")
    assert all(e["stand_in"] for e in said["effects"] if e["site"] == "medium")
    assert any(
        "grows from trial to trial (to first order `worn_wheel at vertex 5`)" in w for w in said["residual_pattern"]
    )


@pytest.mark.slow
def test_the_screen_says_which_trials_and_what_of_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(changed_in_the_last_round(Effect("zero_offset", 4, {"offset": 0.1}), 2), tmp_path / "now")
    assert main(["diagnose", str(tmp_path / "now"), "--out", str(tmp_path / "out"), "--no-figures"]) == 0
    screen = capsys.readouterr().out
    said = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    changed = said["changed_trials"]
    assert {name.rpartition("-")[2] for name in changed["trials"]} == {"2"}
    assert {name.rpartition("-")[2] for name in changed["others"]} == {"1"}
    (found,) = changed["diagnosis"]["effects"]
    assert (found["name"], found["place"], found["stand_in"]) == ("zero_offset", 4, False)
    low, high = found["parameters"]["offset"]["interval"]
    assert low < 0.1 < high
    own = json.loads((tmp_path / "out" / changed["folder"] / "diagnosis.json").read_text())
    assert own["effects"] == changed["diagnosis"]["effects"]
    assert "something acts in some of the trials alone" in screen
    assert "zero_offset at joint 4" in screen.partition("Changed trials: ")[2].partition("Details")[0]
