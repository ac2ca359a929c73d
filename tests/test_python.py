"""From Python: recordings as functions with typed results, certificates of one's own gait, open step functions."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import serpenoid as sp
from blind.campaign import make
from blind.folder import write
from serpenoid.cli.main import main
from serpenoid.compare.calibrate import calibrate
from serpenoid.compare.study import compare_campaign
from serpenoid.effects.active import ActiveEffect
from serpenoid.errors import InputError
from serpenoid.gaits.table import TableGait
from serpenoid.measure.load import load_campaign
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.status import Status

PROBLEMS = Path(__file__).parents[1] / "problems"
REFERENCE = PROBLEMS / "reference.toml"
PNG = b"\x89PNG"


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two gaits, nothing hidden."""
    folder = tmp_path_factory.mktemp("python") / "healthy"
    c = make(2026, [], "healthy")
    write(dataclasses.replace(c, trials=[t for t in c.trials if t.name.endswith("-a-1")][:2]), folder)
    return folder


def test_recordings_are_read_fitted_and_compared_with_short_results_and_pictures(campaign: Path) -> None:
    measured = sp.measure(campaign)
    assert len(measured.campaign.trials) == 2
    compared = sp.compare(campaign, anisotropy_ratio=0.1865)
    assert compared.origin.startswith("as stated; K = ")
    assert compared.study.displacement["Exp"].shape == compared.study.displacement["Resim"].shape
    for result in (measured, compared):
        assert len(repr(result)) < 200
        picture = result._repr_png_()
        assert picture is not None
        assert picture.startswith(PNG)


def test_a_fit_from_python_finds_the_hidden_ratio(campaign: Path) -> None:
    fitted = sp.fit(campaign)
    assert fitted.calibration.names == ("anisotropy_ratio",)
    assert repr(fitted).startswith("<Fitted anisotropy_ratio 0.")


def test_the_verbs_rooms_are_modules_and_functions_at_once() -> None:
    import serpenoid.diagnose
    import serpenoid.measure.campaign

    assert callable(sp.diagnose)
    assert sp.measure.campaign.load_campaign_file is serpenoid.measure.campaign.load_campaign_file
    with pytest.raises(InputError, match="no-such"):
        sp.diagnose("no-such-campaign")


def test_results_of_the_optimiser_print_in_a_line() -> None:
    simulated = sp.simulate(sp.load(REFERENCE))
    assert repr(simulated) == "<Simulation reference: solved, 51 poses, 0.452306 body lengths>"


def test_ones_own_gait_is_certified_by_the_same_checks_as_an_optimum() -> None:
    problem = sp.load(REFERENCE)
    simulated = sp.simulate(problem)
    table, poses = simulated.table, simulated.trajectory.poses
    found = sp.certify_table(problem, table, poses[1:])
    assert found.status is Status.SOLVED
    assert found.resimulation_error == 0.0  # the same root finder on the same table
    assert sp.certify_table(problem, table).resimulation_error is None
    astray = poses + np.linspace(0, 1e-6, len(poses))[:, None]
    assert sp.certify_table(problem, table, astray).status is Status.RESIMULATION_DISAGREES
    limited = sp.load(REFERENCE, set=["body.joint_limit_deg=10"])
    assert sp.certify_table(limited, table).status is Status.INFEASIBLE
    assert sp.certify_table(problem, table[::12]).status is Status.MESH_TOO_COARSE
    with pytest.raises(InputError, match="Transposed"):
        sp.certify_table(problem, table.T)


def test_step_functions_of_an_extended_model_are_refused_not_the_baselines() -> None:
    model = sp.load(REFERENCE).model
    found = sp.step_functions(model)
    assert set(found) == {"shape", "step_energy", "step_momentum", "step"}
    worn = dataclasses.replace(model, effects=(ActiveEffect(name="worn_wheel", place=3, seizure=0.5),))
    with pytest.raises(InputError, match="worn_wheel"):
        sp.step_functions(worn)


WORN = ActiveEffect(name="worn_wheel", place=3, seizure=0.5)
WEAK = ActiveEffect(name="gain_loss", place=3, loss=0.5)


@pytest.mark.parametrize("effect", [WORN, WEAK], ids=["medium", "actuation"])
def test_no_door_gives_the_baseline_for_a_model_with_effects(effect: ActiveEffect, virtual_machine: None) -> None:
    """Simulation, batch and certificate of a table all tell one displacement, and it is not the baseline's."""
    plain = sp.load(REFERENCE, set=["task.steps=20"])
    extended = plain.model_copy(update={"effects": (effect,)})
    table = sp.simulate(plain).table
    found = [
        sp.simulate(extended).trajectory.displacement,
        sp.simulate_joint_angles(extended.model, table).displacement,
        float(sp.simulate_batch(extended.model, table[None]).displacement[0]),
        sp.certify_table(extended, table).trajectory.displacement,
    ]
    np.testing.assert_allclose(found, found[0], rtol=1e-9)  # one motion, by ways that round differently
    assert abs(found[0] / sp.simulate(plain).trajectory.displacement - 1) > 0.01


@pytest.mark.parametrize("effect", [WORN, WEAK], ids=["medium", "actuation"])
def test_fits_and_comparisons_refuse_a_model_with_effects(effect: ActiveEffect, campaign: Path) -> None:
    read = load_campaign(campaign)
    model = Model(read.body, Medium(anisotropy_ratio=0.2), (effect,))
    with pytest.raises(InputError, match=f"know the baseline alone.*{effect.name}"):
        compare_campaign(read, model)
    with pytest.raises(InputError, match=f"know the baseline alone.*{effect.name}"):
        calibrate(read, model, ("anisotropy_ratio",))


def test_what_changes_the_recording_alone_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = tmp_path / "model.toml"
    model.write_text('[medium]\nanisotropy_ratio = 0.2\n[[effects]]\nname = "length_scale"\nerror = 0.1\n')
    words = ["simulate", str(REFERENCE), "--model", str(model), "--out", str(tmp_path / "out"), "--no-figures"]
    assert main(words) == 0
    assert "`length_scale` changes what cameras record, not how the body moves" in capsys.readouterr().out


@pytest.mark.parametrize("family", ["ellipse", "table"])
def test_vertices_of_an_opened_nlp_are_those_of_the_simulation(family: str) -> None:
    problem = sp.load(REFERENCE, ["task.steps=12"])
    simulated = sp.simulate(problem)
    gait = problem.gait if family == "ellipse" else TableGait.from_angles(simulated.table[:12])
    nlp = sp.gait_nlp(problem, gait)
    values = problem.gait.parameters if family == "ellipse" else simulated.table[:12].ravel()
    x = np.concatenate([simulated.trajectory.poses[1:].ravel(), values])
    p = np.concatenate([[0.0], problem.model.parameters])
    asked = ca.Function("asked", [nlp.variables, nlp.parameters], [nlp.vertices, nlp.head])
    vertices, head = (value.full() for value in asked(x, p))
    first = simulated.trajectory.poses[0]
    np.testing.assert_array_equal(first, 0.0)
    expected = simulated.trajectory.vertices
    np.testing.assert_allclose(vertices.T.reshape(expected.shape), expected, atol=1e-12)
    np.testing.assert_allclose(head[:, 0], expected[-1, -1], atol=1e-12)
    assert len(repr(nlp)) < 100
    assert len(repr(problem)) < 100


def own_gap(of: sp.Criteria) -> None:
    of.subject_to(of.displacement, 0.1, 0.5)


@pytest.mark.parametrize(
    ("name", "add", "customise"),
    [
        ("snake10", ["task.c=1.0", "task.cycle_duration_s=5"], None),
        ("snake10", ["task.constraints.heading_change_rad=0.5"], own_gap),
        ("reach", [], None),
        ("disc-obstacle", [], None),
        ("sidewinding", [], None),
        ("transport", [], None),
    ],
)
def test_the_numbers_of_an_opened_nlp_fit_its_symbols_and_its_start_meets_the_equations(
    name: str, add: list[str], customise: object
) -> None:
    problem = sp.load(PROBLEMS / f"{name}.toml", ["task.steps=24", *add])
    asked = {"problem": problem, "path_rows": 24, "customise": customise}
    nlp, numbers = sp.gait_nlp(**asked, portable=True), sp.nlp_arguments(**asked)
    functions, motion = nlp.functions(), nlp.constraint_counts[0]
    value = functions["g"](numbers["x0"], numbers["p"]).full()[:, 0]
    assert len(numbers["lbx"]) == len(numbers["ubx"]) == len(numbers["x0"]) == nlp.variables.numel()
    assert len(numbers["lbg"]) == len(numbers["ubg"]) == len(value) == sum(nlp.constraint_counts)
    assert (numbers["lbg"][:motion] == 0).all()
    assert (numbers["ubg"][:motion] == 0).all()
    np.testing.assert_allclose(value[:motion], 0.0, atol=1e-9)


def test_the_opened_nlp_in_a_plain_solver_has_the_optimum_that_is_certified_here() -> None:
    problem = sp.load(PROBLEMS / "snake10.toml", ["task.c=1.0"])
    asked = {"problem": problem, "path_rows": problem.task.steps}
    nlp, numbers = sp.gait_nlp(**asked, portable=True), sp.nlp_arguments(**asked)
    functions, (x, p) = nlp.functions(), (nlp.variables, nlp.parameters)
    derivatives = {name: functions[name] for name in ("grad_f", "jac_g", "hess_lag")}
    quiet = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes", "ipopt.mu_strategy": "adaptive"}
    stated = {"x": x, "p": p, "f": functions["f"](x, p), "g": functions["g"](x, p)}
    found = ca.nlpsol("mine", "ipopt", stated, quiet | derivatives)(**numbers)
    assert float(found["f"]) == pytest.approx(sp.solve(problem, starts=1).best.cost, abs=1e-6)


def test_more_rows_than_a_cycle_has_are_refused() -> None:
    for opened in (sp.gait_nlp, sp.nlp_arguments):
        with pytest.raises(InputError, match="`path_rows` must be at most 50, the steps of a cycle, got 51"):
            opened(PROBLEMS / "snake10.toml", path_rows=51)
        with pytest.raises(InputError, match="`path_rows` must be a whole number, 0 or more, got -1"):
            opened(PROBLEMS / "snake10.toml", path_rows=-1)


def test_a_robust_problem_is_not_opened_as_if_it_had_one_model() -> None:
    for opened in (sp.gait_nlp, sp.nlp_arguments):
        with pytest.raises(InputError, match=r"\[task.robust\] asks for several models"):
            opened(PROBLEMS / "robust.toml")


def test_a_gait_beyond_the_limits_is_told_by_how_much() -> None:
    problem = sp.load(PROBLEMS / "snake10.toml")
    table = sp.simulate(problem).table
    words = sp.certify_table(problem, table * (np.radians(61) / np.abs(table).max())).summary()
    assert "exceed the problem's limits by 1.7e-02 rad" in words


SMALL = ["task.steps=20", "body.vertices=5", "task.c=0.5"]


def test_a_problem_may_be_named_by_its_file_wherever_it_is_taken() -> None:
    assert sp.simulate(REFERENCE).trajectory.displacement == sp.simulate(sp.load(REFERENCE)).trajectory.displacement
    with pytest.raises(InputError, match=r"nowhere\.toml: no such file"):
        sp.solve("nowhere.toml")
    assert len(repr(sp.gait_nlp(str(REFERENCE)))) < 200


PROBLEM = sp.load(PROBLEMS / "reference-optimum.toml", set=SMALL)
MISUSE = {
    "set is a word": (lambda: sp.load(REFERENCE, set="task.c=1"), r"`set` must be a list .* got 'task\.c=1'"),
    "set is a dict": (lambda: sp.load(REFERENCE, set={"task.c": 1}), r"`set` must be a list"),
    "set has a number": (lambda: sp.load(REFERENCE, set=[1]), r"`set` must be a list"),
    "loaded twice": (lambda: sp.load(PROBLEM), r"takes the path of a file, got Problem\. Is it read already"),
    "no problem": (lambda: sp.solve(None), r"`problem` must be what sp\.load\(path\) gives, .* got NoneType"),
    "starts in part": (lambda: sp.solve(PROBLEM, starts=1.5), r"`starts` must be a whole number, 1 or more, got 1\.5"),
    "starts in words": (lambda: sp.solve(PROBLEM, starts="3"), r"`starts` must be .* got '3'"),
    "a gait for starts": (lambda: sp.solve(PROBLEM, PROBLEM.gait), r"`starts` must be .* got EllipseGait"),
    "seed below zero": (lambda: sp.solve(PROBLEM, seed=-1), r"`seed` must be a whole number, 0 or more, got -1"),
    "parameters for a gait": (lambda: sp.solve_from(PROBLEM, np.ones(6)), r"`gait` must be a gait, .* got ndarray"),
    "improve a gait": (lambda: sp.improve(PROBLEM, PROBLEM.gait), r"`count` must be .* solve_from\(problem, gait\)"),
    "improve none": (lambda: sp.improve(PROBLEM, 0), r"`count` must be a whole number, 1 or more, got 0"),
    "improve too far": (lambda: sp.improve(PROBLEM, 1, 2), r"`fraction` \(--within\) must be in"),
    "no c": (lambda: sp.sweep(PROBLEM, []), r"`values` must be one c or more"),
    "c below zero": (lambda: sp.sweep(PROBLEM, [-1.0]), r"`values` must be .* none of them negative .*, got \[-1\.0\]"),
    "c beyond all": (lambda: sp.sweep(PROBLEM, [1e9]), r"`values` must be .* above 1e\+06, got \[1000000000\.0\]"),
    "starts of a sweep": (lambda: sp.sweep(PROBLEM, [0.5], starts=1.5), r"`starts` must be"),
    "a problem for a model": (
        lambda: sp.simulate_joint_angles(PROBLEM, np.zeros((5, 3))), r"got Problem\. Of a problem: problem\.model"),
    "a file for a folder": (lambda: sp.solve(PROBLEM, folder=REFERENCE), r"`folder` .*toml is a file, not a folder"),
    "below a file": (lambda: sp.sweep(PROBLEM, [0.5], folder=REFERENCE / "x"), r"`folder` .*toml is a file, not a"),
    "no folder": (lambda: sp.solve(PROBLEM, folder=3), r"`folder` must be a path, got int"),
    "steps of a problem": (lambda: sp.step_functions(PROBLEM), r"`model` must be a Model, got Problem"),
    "a motion to write": (lambda: sp.write_simulation("x", sp.simulate(PROBLEM).trajectory), r"must be a Simulation"),
    "starts to write": (lambda: sp.write_solution("x", sp.solve(PROBLEM, starts=1)), r"Of many starts .* found\.best"),
}  # fmt: skip


@pytest.mark.parametrize("name", MISUSE)
def test_misuse_is_refused_in_words(name: str) -> None:
    call, said = MISUSE[name]
    with pytest.raises(InputError, match=said):
        call()


def test_results_are_equal_where_all_their_numbers_are() -> None:
    one, again, other = (sp.simulate(sp.load(REFERENCE, set=[f"task.steps={steps}"])) for steps in (20, 20, 21))
    assert one == again
    assert one != other
    assert one.trajectory != one
    lost = [sp.simulate_joint_angles(PROBLEM.model, np.full((4, 3), np.nan)) for _ in range(2)]
    assert lost[0] == lost[1]
    found = [sp.solve(PROBLEM, starts=1).best for _ in range(2)]
    assert found[0] == dataclasses.replace(found[1], seconds=found[0].seconds, timing=found[0].timing)


def test_a_sweep_says_that_its_optimum_may_be_local_where_one_start_led_to_it() -> None:
    assert "solved from 1 start (more may find a better optimum)" in repr(sp.sweep(PROBLEM, [0.5], starts=1))
    assert "solved from 2 starts, c = 0.5" in repr(sp.sweep(PROBLEM, [0.5], starts=2))


def test_what_is_printed_is_short() -> None:
    rows = [[0.1] * 3] * 20
    table = sp.load(REFERENCE, set=[*SMALL, f"gait={{family='table',angles={rows}}}"])
    for printed in (PROBLEM, table, table.gait, sp.sweep(PROBLEM, [0.5], starts=1), sp.improve(PROBLEM, 1)[0]):
        assert len(str(printed)) < 200
        assert len(repr(printed)) < 200
    assert str(PROBLEM) == "<Problem reference-optimum: 5 vertices, ellipse gait, 20 steps>"
    assert repr(PROBLEM.gait).startswith("EllipseGait(family='ellipse', sigma=")


def test_a_simulation_that_failed_is_written_with_its_reason_and_no_numbers(tmp_path: Path) -> None:
    simulated = sp.simulate(sp.load(PROBLEMS / "snake10.toml"))
    table = simulated.table.copy()
    table[3, 2] = np.nan
    failed = sp.simulate_joint_angles(simulated.problem.model, table)
    record = sp.write_simulation(
        tmp_path, dataclasses.replace(simulated, table=table, trajectory=failed), figures=False
    )
    assert record["status"] == "bad_shape"
    unknown = ("displacement_body_lengths", "dissipation", "cost_of_transport", "lighthill_efficiency")
    assert [record[key] for key in unknown] == [None] * 4


@pytest.mark.parametrize(
    "verb", [sp.measure, sp.fit, sp.compare, sp.diagnose], ids=["measure", "fit", "compare", "diagnose"]
)
@pytest.mark.parametrize("given", [None, 3, b"camp", ["camp"]], ids=lambda given: type(given).__name__)
def test_what_is_no_path_of_a_campaign_is_refused_in_words(verb: Callable[..., object], given: object) -> None:
    with pytest.raises(InputError, match=f"`campaign` must be the path of a campaign's folder.*{type(given).__name__}"):
        verb(given)


def test_equal_searches_are_equal_whatever_time_they_took() -> None:
    one, other = (sp.solve(PROBLEM, starts=1, seed=0) for _ in range(2))
    assert one == other
    assert one != sp.solve(sp.load(PROBLEMS / "reference-optimum.toml", set=[*SMALL, "task.c=0.7"]), starts=1, seed=0)
