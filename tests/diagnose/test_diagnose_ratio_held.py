"""Beside a reference: eps as it was, or another one, which has its price; rivals that gaits do not agree to exclude."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from serpenoid.diagnose.diagnose import verdict
from serpenoid.diagnose.inference.doubt.groups import as_another_ratio, groups
from serpenoid.diagnose.inference.doubt.law_doubt import of_gaits
from serpenoid.diagnose.inference.fits.finding import Rival
from serpenoid.diagnose.inference.fits.medium import TO_THE_END, fit, fit_eps
from serpenoid.diagnose.inference.search import ratio_held
from serpenoid.diagnose.inference.search.discrepancy import by_gait, information_criterion, worse
from serpenoid.diagnose.inference.search.ratio_held import as_it_was_or_another, held
from serpenoid.diagnose.report.verdicts import meaning
from serpenoid.diagnose.stages.motion import choose_motion
from serpenoid.diagnose.stages.motion.choose_motion import or_instead
from serpenoid.diagnose.stages.motion.other_explanations import instead
from serpenoid.effects.active import ActiveEffect
from serpenoid.wording import ANY_RATIO

Diagnosed = tuple[Any, dict[str, Any], Any]


def beside(found: Any, ratio: float) -> Any:
    """A selection as if a reference had said what eps was."""
    return replace(found, motion=replace(found.motion, ratio=ratio))


def test_fits_leave_a_ratio_that_is_held_where_it_was(diagnosed: Diagnosed) -> None:
    found = diagnosed[0].motion.selection
    eps = 1.3 * found.best.model.medium.anisotropy_ratio
    model = replace(found.null.model, medium=found.null.model.medium.with_ratio(eps))
    motion, null = held(replace(found.motion, ratio=eps), model)
    assert null.model.medium.anisotropy_ratio == eps
    again = fit(motion, model, list(found.best.effects), np.array([eps, *found.best.coordinates[1:]]), TO_THE_END)
    free = fit_eps(replace(motion, ratio_held=False), model)
    assert again.coordinates[0] == eps
    assert again.chi2 < null.chi2
    assert again.coordinates[1] != found.best.coordinates[1]  # the wheel makes up for a part of it
    assert free.model.medium.anisotropy_ratio != eps
    moved, spread = of_gaits(motion, again)
    assert moved[0] == eps
    assert spread[0] == 0.0
    assert np.isfinite(spread).all()
    assert spread[1] > 0


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> Any:
    """What is taken of an answer with eps held and one with eps free, by what each leaves in each gait."""

    def taken(
        same: list[float], another: list[float], *, names: tuple[str, str] = ("wheel", "wheel"), wrong: bool = True
    ) -> str:
        def selection(name: str, gaits: list[float], is_held: bool) -> Any:
            effects = (SimpleNamespace(key=(name, 1)),) if name else ()
            evidence, every = SimpleNamespace(count=np.array([9.0])), np.outer(gaits, np.ones(3))
            fitted = SimpleNamespace(effects=effects, evidence=evidence, gaits=every, predictions=None)
            motion = SimpleNamespace(ratio_held=is_held, unrepeated=False)
            return SimpleNamespace(best=fitted, motion=motion)

        monkeypatch.setattr(ratio_held, "_worth_asking", lambda found: True)
        monkeypatch.setattr(ratio_held, "replace", lambda motion, **_: motion)
        monkeypatch.setattr(ratio_held, "fit_guided", lambda motion, best, steps: best)
        monkeypatch.setattr(ratio_held, "_criterion", lambda motion, best: float(best.gaits.sum()))
        monkeypatch.setattr(ratio_held, "by_gait", lambda motion, best: best.gaits)
        monkeypatch.setattr(ratio_held, "discrepancy", lambda motion, predictions: 0.0)
        as_was, free = selection(names[0], same, True), selection(names[1], another, False)
        return "same" if as_it_was_or_another(as_was, lambda: free, wrong) is as_was else "another"

    return taken


def test_another_ratio_has_to_be_likelier(asked: Any) -> None:
    assert asked([10.0, 12.0, 11.0], [10.0, 12.0, 12.0]) == "same"
    assert asked([10.0, 12.0, 11.0], [1.0, 2.0, 1.0]) == "another"


def test_where_the_law_is_wrong_gaits_must_agree_that_another_ratio_is_needed_too(
    asked: Any,
) -> None:
    some, others = [10.0, 60.0, 9.0], [31.0, 10.0, 32.0]
    assert asked(some, others) == "same"
    assert asked(some, others, wrong=False) == "another"
    assert asked(some, others, names=("wheel", "patch")) == "another"
    assert asked(some, others, names=("", "patch")) == "another"


def test_a_rival_is_excluded_if_gaits_and_directions_agree_that_it_is_worse() -> None:
    best = np.zeros((2, 3))
    assert worse(np.array([[5.0, 6.0, 5.5], [4.5, 5.0, 7.0]]), best)
    assert not worse(np.array([[40.0, -6.0, 3.0], [-1.0, 2.0, -3.0]]), best)
    assert not worse(np.array([[50.0, 51.0, 52.0]]), best[:1])  # one gait tells nothing of what others would say


def test_gaits_and_directions_share_the_criterion(diagnosed: Diagnosed) -> None:
    found = diagnosed[0].motion.selection
    gaits = by_gait(found.motion, found.best)
    assert gaits.shape == (len(set(found.motion.labels)), 3)
    assert gaits.sum() == pytest.approx(information_criterion(found.motion, found.best), rel=1e-6)


def test_where_the_law_may_be_wrong_gaits_say_what_could_stand_in_a_names_place(diagnosed: Diagnosed) -> None:
    """The law is right here, and gaits agree: nothing is as likely as the hidden load, nor is another eps."""
    own = diagnosed[0].motion.selection
    found = beside(own, own.best.model.medium.anisotropy_ratio)
    assert groups(found, wrong=True) == groups(own)
    assert as_another_ratio(found) == []  # eps was free
    assert as_another_ratio(replace(found, motion=replace(found.motion, ratio_held=True))) == []
    unlike = replace(found, best=found.null, bases=())
    assert groups(unlike, wrong=True) == ()


def test_what_another_explanation_of_the_reference_names_is_a_rival_where_gaits_leave_it_open(
    diagnosed: Diagnosed,
) -> None:
    found = diagnosed[0].motion.selection
    (named,) = found.best.effects
    other = replace(found.best.model, effects=(ActiveEffect.typical(named.name, named.place + 1),))
    first = replace(found, best=replace(found.best, model=other))
    assert instead(found, None) == ()
    assert instead(found, found) == ()
    (rival,) = instead(found, first)
    assert rival.effect.key == (named.name, named.place + 1)
    assert rival.instead_of.key == named.key
    assert rival.separation < 1e-9  # the same predictions
    stage = or_instead(diagnosed[0].motion.stage, (rival,))
    assert rival in stage.rivals
    assert [n.stand_in for n in stage.named] == [True]
    assert or_instead(diagnosed[0].motion.stage, ()) == diagnosed[0].motion.stage


def test_names_that_may_change_nothing_take_their_rivals_along(diagnosed: Diagnosed) -> None:
    stage = diagnosed[0].motion.stage
    (named,) = stage.named
    rival = Rival(ActiveEffect.typical(named.effect.name, 1), named.effect, 0.5)
    with_rival = replace(stage, rivals=(rival,))
    assert with_rival.naming(stage.named).rivals == (rival,)
    open_ends = {name: (None, None) for name in named.intervals}
    unsure = replace(named, stand_in=True, intervals=open_ends)
    weak = with_rival.naming([unsure])
    assert weak.named == ()
    assert weak.rivals == ()
    assert weak.undetected[-1] == unsure


def test_a_name_that_another_ratio_may_replace_is_marked_and_explains_nothing(
    diagnosed: Diagnosed, monkeypatch: pytest.MonkeyPatch
) -> None:
    found, said, _ = diagnosed
    selection = found.motion.selection
    alone = replace(selection, motion=replace(selection.motion, ratio=0.2, ratio_held=True))
    monkeypatch.setattr(choose_motion, "as_another_ratio", lambda chosen: list(chosen.best.effects))
    stage = choose_motion.finding(alone, inadequate=True).stage
    (named,) = stage.named
    assert named.stand_in
    assert stage.words == (f"{named.effect.called}: {ANY_RATIO}",)
    record = said | {"verdict": verdict([stage]), "residual_pattern": [f"motion: {w}" for w in stage.words]}
    assert record["verdict"] == "partly explained"
    assert meaning(record) == "what is named accounts for everything beyond the noise, and so does another cause"
