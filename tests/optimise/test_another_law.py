"""One more law is one value: a law that only these tests know is read, simulated, optimised and told of."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from oracle import power_laws
from serpenoid import load, media
from serpenoid.cli.main import main
from serpenoid.effects.catalogue import find
from serpenoid.errors import InputError
from serpenoid.media import LAWS, Law
from serpenoid.optimise.solve import solve
from serpenoid.simulation import simulate_joint_angles
from serpenoid.status import Status
from specimens import PROBLEMS, problem, random_table

CUBIC = Law(
    name="cubic",
    words="cubic drag",
    title="cubic drag",
    degree=4,
    potential=lambda q, softening: q**2 / 4,
    multiplier=lambda q, softening: q,
)
SET = ('medium.law="cubic"', "medium.anisotropy_ratio=0.4")


@pytest.fixture(autouse=True)
def _there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(LAWS, "cubic", CUBIC)


def test_a_problem_file_names_it_and_its_hash_holds_the_law_and_nothing_that_the_law_does_not_know() -> None:
    read = load(PROBLEMS / "reference.toml", set=list(SET))
    assert read.model.law is CUBIC
    assert read.hash == problem("reference", *SET, "medium.softening=0.5").hash
    assert read.hash != problem("reference", SET[1]).hash
    with pytest.raises(InputError, match="or 'cubic', got 'kubic'"):
        problem("reference", 'medium.law="kubic"')
    with pytest.raises(InputError, match="with cubic drag ask for transport"):
        problem("lighthill", *SET)


def test_its_motion_is_that_of_plain_minimisation() -> None:
    model = problem("reference", *SET).model
    table = random_table(model, np.random.default_rng(1), 8)
    run = power_laws.simulate(table, model.body.edges, model.body.vertex_weights, 0.4, degree=4)
    motion = simulate_joint_angles(model, table)
    assert motion.status.ok
    np.testing.assert_allclose(motion.poses, run.poses, atol=1e-4)  # what the plain search leaves of an E of 1e-8
    assert motion.energy_raw == pytest.approx(run.energies.sum(), rel=1e-4)
    assert motion.dissipation == pytest.approx(8**3 * motion.energy_raw)


def test_an_optimum_under_it_is_certified_and_plain_minimisation_confirms_it() -> None:
    s = solve(problem("reference-optimum", *SET, "task.steps=40", "task.c=0.5"), starts=1, seed=1).best
    assert s.status is Status.SOLVED
    assert s.residuals.largest <= 1e-8
    assert s.polishing_gain is not None
    assert s.polishing_gain < 1e-6
    body = s.problem.body
    run = power_laws.simulate(s.table, body.edges, body.vertex_weights, 0.4, degree=4)
    assert s.trajectory.displacement == pytest.approx(run.displacement, abs=5e-4)
    assert s.trajectory.energy_raw == pytest.approx(run.energies.sum(), rel=2e-3)


def test_what_is_said_of_it_is_its_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = [word for value in (*SET, "task.steps=20") for word in ("--set", value)]
    assert main(["simulate", str(PROBLEMS / "reference.toml"), *words, "--no-figures", "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "dissipation T^3*E" in said
    assert "softening" not in said
    (tmp_path / "summary.txt").unlink()
    assert main(["show", str(tmp_path)]) == 0
    assert "at each vertex, cubic drag" in capsys.readouterr().out


def test_units_are_those_of_its_degree() -> None:
    units = {name: find(name).parameters[0].unit_in(CUBIC) for name in ("slope", "inertia", "load")}
    assert units == {"slope": "m3/s3", "inertia": "m2/s", "load": "1"}
    assert not find("dry_friction").acts_in("cubic")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"multiplier": lambda q, s: q / 2},
            "`multiplier` must be twice the slope of `potential` .*got 0.35 where that is 0.7",
        ),
        ({"potential": lambda q, s: q**2}, "`multiplier` must be twice the slope of `potential`"),
        ({"multiplier": lambda q, s: -q}, "`multiplier` must be above 0, or it drives, got -0.7"),
        ({"multiplier": lambda q, s: None}, "`multiplier` gives NoneType, no number. Does it lack a `return`"),
        (
            {"degree": 3},
            "`degree` must be that of `potential` .*got 3: twice the slip makes 4 of `multiplier` and not 2",
        ),
        ({"degree": 0}, "`degree`, .*, must be above 0, got 0"),
        ({"slip": "weighted"}, "`slip` must be one of weighed, parts, plain, got 'weighted'"),
        ({"softened": True}, "`softened` must say .*, got True: `multiplier` does not depend on it"),
    ],
)
def test_a_law_that_contradicts_itself_is_refused(change: dict[str, Any], said: str) -> None:
    """Each was simulated with one of two formulas that do not agree, without a word."""
    with pytest.raises(InputError, match=f"law `cubic`: {said}"):
        replace(CUBIC, **change)


def test_a_law_of_another_name_than_its_file_takes_no_other_ones_place(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(media.viscous, "LAW", replace(CUBIC, name="quadratic"))
    with pytest.raises(
        InputError, match=r"media\.viscous: `name` of its LAW must be that of the file, got `quadratic`"
    ):
        media._listed()
