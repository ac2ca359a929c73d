"""Numbers in words: units that people use, digits that an interval deserves, effects below detection."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest

from blind.protocol import usual
from serpenoid.body import Body
from serpenoid.diagnose.data.used import parameter_unit
from serpenoid.diagnose.inference.search.names import Refused
from serpenoid.diagnose.report.before import already, already_in_short, reference
from serpenoid.diagnose.report.cards import cards
from serpenoid.diagnose.report.drag import drag_ratio, ratio
from serpenoid.diagnose.report.next_trial import unreliable
from serpenoid.diagnose.report.pages import _beside, write_pages
from serpenoid.diagnose.report.sentences import chance, in_short, left, rows, stage_line, undetected, within_chance
from serpenoid.diagnose.report.summary import _ideas, lines
from serpenoid.diagnose.report.verdicts import inadequacy, meaning
from serpenoid.diagnose.report.words import (
    few,
    foremost,
    in_sample,
    own_place,
    parameter,
    sentence,
    shown,
    times,
    title,
    unseen,
)
from serpenoid.diagnose.stages.motion.choose_motion import finding
from serpenoid.diagnose.stages.motion.left_over import refusals
from serpenoid.diagnose.stages.motion.values_of_motion import ratio_interval
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.catalogue import find
from serpenoid.model import Model

ORDER = ("verdict", "cause", "held-out", "left", "next experiment", "Details", "motion", "seconds")


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.00197, "m", "1.97 mm"),
        (-0.0015, "m/s", "-1.5 mm/s"),
        (2.39e-6, "m", "2.39 \N{MICRO SIGN}m"),
        (0.129, "bl", "0.129 body lengths"),
        (0.1, "rad", "5.73°"),
        (-0.006032, "m/rad", "-6.03 mm/rad"),
        (0.4, "1", "0.4"),
        (0.05, "s", "0.05 s"),
        (-4449.7, "1", "-4450"),
        (None, "m/s", "unbounded"),
    ],
)
def test_numbers_stand_in_the_units_people_use(value: float | None, unit: str, text: str) -> None:
    assert shown(value, unit) == text


def test_digits_tell_the_ends_of_an_interval_apart() -> None:
    assert parameter({"value": 0.15, "interval": [0.14992, 0.15006], "unit": "1"}) == "0.15 (95 %: 0.14992 .. 0.15006)"
    assert parameter({"value": 0.5, "interval": [0.3, None], "unit": "m/s"}) == "500 mm/s (95 %: 300 mm/s .. unbounded)"
    one_unit = {"value": -6.95e-6, "interval": [-7.25e-5, 5.86e-5], "unit": "m"}
    assert parameter(one_unit) == "-0.00695 mm (95 %: -0.0725 mm .. 0.0586 mm)"
    bound = {"value": 1.0, "interval": [0.8, 1.0], "unit": "1", "at_bound": True}
    assert parameter(bound).endswith("at its bound)")


def test_places_are_joints_or_vertices() -> None:
    assert title({"name": "gain_loss", "place": 4}) == "gain_loss at joint 4"
    assert title({"name": "load", "place": 0}) == "load at vertex 0"
    assert title({"name": "toe", "place": None}) == "toe"


@pytest.mark.parametrize(
    ("name", "place", "middles", "own"),
    [
        ("marker_offset", 6, True, "vertex 3 of the campaign's body"),
        ("load", 7, True, "the middle of edge 3 of the campaign's body"),
        ("load", 7, False, ""),
        ("gain_loss", 6, True, ""),  # joints keep their numbers
        ("toe", None, True, ""),
    ],
)
def test_places_are_told_in_the_numbers_of_the_campaigns_own_body(
    name: str, place: int | None, middles: bool, own: str
) -> None:
    assert own_place({"name": name, "place": place}, {"middles": middles}) == own


def test_an_effect_too_weak_to_name_is_told_of_with_its_strength(diagnosed: tuple[Any, dict[str, Any], Any]) -> None:
    trace = {"name": "friction_patch", "site": "medium", "place": None, "parameters": {}, "strength_over_noise": 1.44}
    trace["in_extended_model"] = False
    record = diagnosed[1] | {"verdict": "unexplained", "effects": [], "below_detection": [trace]}
    assert undetected(record) == ["friction_patch (1.4 times the noise)"]
    assert "below detection   friction_patch (1.4 times the noise)" in lines(record)
    told = [text for card in cards(record) for text in card.sentences]
    assert any(text.startswith("Below detection: friction_patch (1.4 times the noise)") for text in told)
    kept = record | {"below_detection": [trace | {"in_extended_model": True}]}
    assert undetected(kept) == ["friction_patch (1.4 times the noise, in the extended model)"]
    lag = {"value": 0.038, "interval": [-0.0324, 0.1084], "unit": "s"}
    strong = record | {"below_detection": [trace | {"name": "servo_lag", "parameters": {"lag": lag}}]}
    said = "servo_lag (1.4 times the noise, lag 0.038 s (95 %: -0.0324 s .. 0.108 s))"
    assert undetected(strong) == [said]
    unasked = {"value": 0.512, "interval": [None, None], "unit": "1"}  # of what windows show no interval is made
    drag = record | {"below_detection": [trace | {"name": "power_law_drag", "parameters": {"exponent": unasked}}]}
    assert undetected(drag) == ["power_law_drag (1.4 times the noise, exponent 0.512)"]


def test_nothing_beside_a_reference_says_that_nothing_changed_and_not_that_the_model_is_right() -> None:
    repeated = {"verdict": "nothing", "reference": None, "noise_from": "trials"}
    assert "has changed" in meaning(repeated | {"reference": {"campaign": "healthy"}})
    assert "drag alone explains" in meaning(repeated | {"law": {"name": "viscous"}})
    worn = {"name": "worn_wheel", "place": 2, "strength_over_noise": 0.9, "in_extended_model": True}
    weak = worn | {"parameters": {"seizure": {"value": 0.343, "unit": "1"}}}
    said = meaning(repeated | {"law": {"name": "viscous"}, "below_detection": [weak]})
    assert "drag alone explains the path within its noise; what windows show besides" in said
    assert "what windows show besides moves the path by less than its noise: worn_wheel at vertex 2" in said
    assert "(0.9 times the noise, seizure 0.343, in the extended model)" in said
    assert "dry friction alone explains" in meaning(repeated | {"law": {"name": "coulomb"}})
    given = {"law": {"name": "quadratic"}, "baseline": {"effects": [{"name": "inertia"}, {"name": "servo_lag"}]}}
    assert "quadratic drag with inertia, servo_lag explains" in meaning(repeated | given)


@pytest.mark.parametrize("verdict", ["nothing", "explained"])
def test_a_verdict_says_that_a_cause_may_hide_in_chance_that_is_no_noise_of_the_markers(verdict: str) -> None:
    record = {
        "verdict": verdict,
        "reference": None,
        "noise_from": "trials",
        "law": {"name": "viscous"},
        "effects": [{}],
    }
    assert "hides in it" in meaning(record | {"noise_over_markers": 12.0})
    assert "hides" not in meaning(record | {"noise_over_markers": 1.1}) + meaning(record | {"noise_over_markers": None})


def test_repeats_that_differ_far_more_than_in_the_reference_are_told_where_nothing_has_changed() -> None:
    record = {"verdict": "nothing", "noise_from": "trials", "noise_level_m": 0.0248}
    said = meaning(record | {"reference": {"noise_level_m": 0.00507}, "noise_over_markers": 31.0})
    assert said.startswith("nothing has changed since the reference")
    assert "hides in it" in said
    assert "repeats differ by 4.9 times as much as in the reference" in said
    assert "in the reference:" not in meaning(record | {"reference": {"noise_level_m": 0.01}})
    then = {"noise_level_m": 0.00507, "noise_over_markers": 28.0}
    said = meaning(record | {"reference": then, "noise_over_markers": 31.0})
    assert "repeats differ" not in said
    assert "4.9 times as much counts as noise as in the reference, though repeats are as alike" in said
    assert "repeats differ" in meaning(record | {"reference": then, "noise_over_markers": 131.0})


def test_what_repeats_differ_by_stands_beside_the_noise_of_the_markers() -> None:
    said, hides = chance({"noise_over_markers": 79.6, "noise_from": "trials"})
    assert said == "repeats differ by 80 times the markers' noise"
    assert "counts as noise, and hides what is smaller" in hides
    assert chance({"noise_over_markers": None}) == []
    (left,) = chance({"noise_over_markers": 9.46, "noise_from": "residuals"})  # nothing was played twice
    assert left == "what the model leaves is 9.5 times the markers' noise"


def test_k_of_dry_friction_is_not_told_as_one_of_drag() -> None:
    record = {"drag_ratio": {"value": 2.719, "interval": [2.718, 2.72]}, "law": {"name": "coulomb"}, "effects": []}
    assert "if dry friction is all there is" in drag_ratio(record)
    assert "if drag is all there is" in drag_ratio(record | {"law": {"name": "viscous"}})
    assert "frame by frame" in drag_ratio(record)
    by_windows = {"drag_ratio": record["drag_ratio"] | {"by_frames": False}}  # type: ignore[operator]
    assert drag_ratio(record | by_windows) == "2.719 (95 %: 2.718 .. 2.72) if dry friction is all there is"


def test_where_drag_leaves_nothing_the_k_that_dry_friction_would_have_is_told() -> None:
    """At small slip angles its forces of 1 to K are those of drag of 1 to K^2, so no window asks which law it is."""
    law = {"name": "viscous", "open": True, "rivals": {}}
    record = {"drag_ratio": {"value": 81.0, "interval": [70.0, 104.0]}, "law": law, "effects": []}
    assert "is all there is; about 9, its root, if dry friction is" in drag_ratio(record)
    for other in ({"open": False}, {"name": "coulomb"}, {"rivals": {"coulomb": "misses windows by more"}}):
        assert "root" not in drag_ratio(record | {"law": law | other})


def test_k_beside_what_is_named_is_that_of_the_ratio_on_the_same_screen() -> None:
    record = {"drag_ratio": {"value": 2.361, "interval": [2.35, 2.373]}, "law": {"name": "viscous"}, "effects": [1]}
    said = drag_ratio(record | {"anisotropy_ratio": {"after": 0.5, "interval": [0.4, 0.8]}})
    assert said == "2 (95 %: 1.25 .. 2.5) beside what is named; 2.361 if drag were all there is"


def test_it_is_told_how_rows_were_taken_and_who_said_so() -> None:
    assert rows({"rows_held": True, "rows_from": "readings"}) == [
        "each held until the next is due (what servos read fits this best)"
    ]
    assert "the log's commands" in rows({"rows_held": False, "rows_from": "commands"})[0]
    assert "are goals" in rows({"rows_held": False, "rows_from": "goals"})[0]
    assert "the reference" in rows({"rows_held": True, "rows_from": "reference"})[0]
    assert "what markers show" in rows({"rows_held": True, "rows_from": "markers"})[0]  # no servo log
    assert not rows({"rows_held": False, "rows_from": None})  # of an animal
    *_, unsaid = rows({"rows_held": True, "rows_from": "readings", "lag_untold": True})
    assert "a lag is known only as far as rows are taken" in unsaid


def test_the_stage_of_the_whole_says_what_it_is_of() -> None:
    size = {"unit": "m", "before": 7e-3, "after": 7e-3, "noise_level": 2e-4}
    assert "not judged" in stage_line({"stage": "whole"} | size)
    assert stage_line({"stage": "motion"} | size).endswith("(35 times the noise)")
    doubtful = stage_line({"stage": "actuation", "doubt": size["noise_level"]} | size)
    assert "is how far any change may move what the reference's model of the servos missed (35 times" in doubtful
    assert "it grows" not in stage_line({"stage": "whole"} | size)
    assert "it grows" in stage_line({"stage": "whole"} | size | {"after": 9e-3})


@pytest.mark.parametrize(
    ("ratio", "pattern", "noise_from", "told"),
    [(1.4, [], "trials", True), (1.14, [], "trials", False), (1.4, ["motion: a"], "trials", False),
     (1.4, ["actuation: a"], "trials", True), (1.4, [], "residuals", False)],
)  # fmt: skip
def test_an_error_above_the_noise_that_is_taken_for_chance_says_why(
    ratio: float, pattern: list[str], noise_from: str, told: bool
) -> None:
    size = {"unit": "m", "before": 7e-3, "after": ratio * 1e-3, "noise_level": 1e-3}
    record = {"residual_pattern": pattern, "noise_from": noise_from}
    assert ("what repeats share of it" in within_chance(size | {"stage": "motion"}, record)) == told
    assert not within_chance(size | {"stage": "whole"}, record)


@pytest.mark.parametrize(("after", "effects", "told"), [(9e-3, 1, True), (9e-3, 0, False), (8.2e-3, 1, False)])
def test_names_that_do_not_carry_over_to_other_gaits_are_told(after: float, effects: int, told: bool) -> None:
    gain = {"path_rms_m": {"before": 8e-3, "after": after}}
    record = {"effects": [{}] * effects, "gain": gain, "noise_level_m": 1e-3, "left_open_m": 2e-3, "drag_ratio": None}
    assert bool(unreliable(record)) == told


@pytest.mark.parametrize("verdict", ["nothing", "explained"])
def test_where_nothing_was_played_twice_nobody_is_told_that_the_rest_is_chance(verdict: str) -> None:
    assert "nobody can tell" in meaning(
        {"verdict": verdict, "reference": None, "noise_from": "residuals", "effects": [{}]}
    )


def test_of_a_reference_it_is_told_what_may_be_a_stand_in_and_that_another_law_fits_better() -> None:
    load = {"name": "load", "place": 3, "stand_in": True}
    earlier = {
        "campaign": "healthy",
        "verdict": "partly explained",
        "effects": [load],
        "residual_pattern": ["motion: a"],
    }
    law = {"law": {"name": "viscous", "rivals": {"coulomb": "dry friction misses less"}, "drag_at": ""}}
    said = reference({"reference": earlier | law, "effects": []})
    assert said[:2] == ["healthy was partly explained", "perhaps stand-ins: load at vertex 3"]
    assert said[2] == "dry friction misses less"
    assert 'law = "coulomb"' in said[3]
    assert (
        already({"reference": earlier}) == ["it already showed: motion: a"] == already_in_short({"reference": earlier})
    )


def test_what_the_reference_left_is_one_line_on_the_screen_and_whole_in_the_report(
    diagnosed: tuple[Any, dict[str, Any], Any], tmp_path: Path
) -> None:
    left = ["motion: a", "motion: b", "actuation: c"]
    law = {"name": "viscous", "rivals": {}, "drag_at": ""}
    eps = {"anisotropy_ratio": diagnosed[1]["anisotropy_ratio"]}
    earlier = {"campaign": "calm", "verdict": "unexplained", "effects": [], "residual_pattern": left, "law": law} | eps
    record = diagnosed[1] | {"reference": earlier}
    (short,) = [text for text in lines(record) if "what was left there" in text]
    assert "3 sentences" in short
    assert not any("it already showed" in text for text in lines(record))
    write_pages(tmp_path, record)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert all(f"<p>It already showed: {x}.</p>" in page for x in left)


@pytest.mark.parametrize("reference", [True, False])
def test_a_verdict_of_nothing_reads_as_a_finding_on_the_screen(
    diagnosed: tuple[Any, dict[str, Any], Any], reference: bool
) -> None:
    law = {"name": "viscous", "rivals": {}, "drag_at": ""}
    earlier = {"campaign": "calm", "verdict": "nothing", "effects": [], "residual_pattern": [], "law": law}
    earlier |= {"anisotropy_ratio": diagnosed[1]["anisotropy_ratio"]}
    record = diagnosed[1] | {"verdict": "nothing", "effects": [], "reference": earlier if reference else None}
    (said,) = [text for text in lines(record) if text.startswith("verdict")]
    assert said.startswith("verdict           nothing found: ")


def test_links_that_are_one_edge_are_one_line_on_the_screen_and_whole_in_the_report(
    diagnosed: tuple[Any, dict[str, Any], Any],
) -> None:
    note = Body(vertices=12, kind="swimming robot").whole_links
    assert note is not None
    record = diagnosed[1] | {"remarks": [note, "another"]}
    said = lines(record)
    noted = said[[text[:4] for text in said].index("note") :]
    assert len("".join(noted[:-1])) < 0.8 * len(note)
    assert "`remarks` in diagnosis.json" in noted[-2]
    assert noted[-1].strip() == "another"
    assert sentence(note) in _beside(record)


@pytest.mark.parametrize(("named", "told"), [([], "floor"), (["inertia"], "floor: load at vertex 5")])
def test_what_was_tried_for_the_error_of_a_reference_is_told_to_be_no_finding(named: list[str], told: str) -> None:
    inertia = {"name": "inertia", "place": None, "parameters": {}}
    guess = {"effects": [inertia, {"name": "load", "place": 5, "parameters": {}}], "anisotropy_ratio": 0.3}
    known = [inertia | {"stand_in": False} for _ in named]
    law = {"name": "viscous", "rivals": {}, "drag_at": ""}
    earlier = {"campaign": "calm", "verdict": "unexplained", "effects": known, "law": law}
    record = {"reference": earlier | {"anisotropy_ratio": {"after": 0.2}}, "effects": [], "baseline": guess}
    *_, model, guessed = reference(record)
    assert model == "that model: anisotropy ratio 0.3, inertia, load at vertex 5"
    assert guessed == f"no findings, only stand-ins for the law of its {told}"
    assert not any("no findings" in text for text in reference(record | {"baseline": guess | {"effects": []}}))


def test_what_is_named_in_the_reference_and_again_has_its_earlier_value_beside_it() -> None:
    drift = {
        "name": "frame_drift", "place": None, "stand_in": False,
        "parameters": {"velocity_x": {"value": 0.0153, "interval": [0.0138, 0.0161], "unit": "m/s"}},
    }  # fmt: skip
    toe = {"name": "toe", "place": None, "stand_in": False, "parameters": {}}
    earlier = {"campaign": "calm", "verdict": "explained", "effects": [drift, toe], "residual_pattern": []}
    law = {"name": "viscous", "rivals": {}, "drag_at": ""}
    said = reference({"reference": earlier | {"law": law}, "effects": [drift]})
    assert said[1:] == [
        "frame_drift was there already: velocity_x 15.3 mm/s (95 %: 13.8 mm/s .. 16.1 mm/s)",
        "its value now is the whole of it, not what was added since",
    ]


def test_of_what_is_named_beside_a_guess_about_the_reference_the_guess_is_told() -> None:
    share = {"share": {"value": 0.57, "interval": [0.19, 0.82], "unit": "1"}}
    load = {"name": "load", "place": 5, "stand_in": False, "parameters": share}
    law = {"name": "viscous", "rivals": {}, "drag_at": ""}
    eps = {"after": 0.2}
    earlier = {"campaign": "calm", "verdict": "unexplained", "effects": [], "residual_pattern": [], "law": law}
    guess = {"effects": [{"name": "load", "place": 5, "parameters": {"share": 0.1}}], "anisotropy_ratio": 0.2}
    record = {"reference": earlier | {"anisotropy_ratio": eps}, "effects": [load], "baseline": guess}
    assert reference(record)[1:] == [
        "load at vertex 5 may have been there already, too weak to be named: share 0.1",
        "its value now is the whole of it, not what was added since: an interval that holds 0 means that it may be "
        "gone",
    ]


def test_the_calibration_is_told_of_beside_the_reference() -> None:
    eps = {"anisotropy_ratio": {"before": 0.02871, "after": 0.0226, "interval": [0.021, 0.024], "at_bound": False}}
    earlier = {"campaign": "healthy", "anisotropy_ratio": {"before": 0.1, "after": 0.0195}}
    said = ratio(eps | {"reference": earlier, "effects": [{}]})
    assert said == "0.0226 (95 %: 0.021 .. 0.024); 0.02871 with nothing named; 0.0195 in the reference"
    assert "0.024) fitted beside what is below detection; 0.02871 fitted alone" in ratio(
        eps | {"reference": None, "effects": []}
    )
    alone = {"anisotropy_ratio": eps["anisotropy_ratio"] | {"before": 0.0226}, "reference": None, "effects": []}
    assert ratio(alone) == "0.0226 (95 %: 0.021 .. 0.024)"
    answer = {"value": 0.0243, "interval": [0.023, 0.03075]}
    told = earlier | {"anisotropy_ratio": earlier["anisotropy_ratio"] | {"answer": answer}}
    said = ratio(eps | {"reference": told, "effects": []})
    assert said.endswith(
        "0.0195 in the model that predicts the reference best; its answer was 0.0243 (0.023 .. 0.03075)"
    )
    alike = {"answer": {"value": 0.01953, "interval": [0.019, 0.02]}}
    told = earlier | {"anisotropy_ratio": earlier["anisotropy_ratio"] | alike}
    assert ratio(eps | {"reference": told, "effects": []}).endswith("0.0195 in the reference")
    open_below = {"anisotropy_ratio": eps["anisotropy_ratio"] | {"interval": [0.005, 0.1]}}
    assert "begins at the bound" in ratio(open_below | {"reference": None, "effects": []})
    stuck = {"anisotropy_ratio": eps["anisotropy_ratio"] | {"at_bound": True}}
    assert ratio(stuck | {"reference": None, "effects": []}).endswith("a warning that the law is another")


def test_where_names_may_be_stand_ins_the_models_inadequacy_comes_before_them_and_no_part_is_to_be_replaced(
    diagnosed: tuple[Any, dict[str, Any], Any],
) -> None:
    record = diagnosed[1]
    assert not any(e["stand_in"] for e in record["effects"])
    assert any("What to do" in text for text in cards(record)[1].sentences)
    doubtful = record | {"discrepancy_m": 0.0031, "effects": [e | {"stand_in": True} for e in record["effects"]]}
    said = [text for text in lines(doubtful) if text.startswith(("verdict", "caution", "cause"))]
    assert said[0].startswith("verdict")
    assert said[1].startswith("caution           the model is off by 3.1 mm a window")
    assert not any("what to do" in text for text in lines(doubtful))
    verdict, cause, _ = cards(doubtful)
    assert verdict.sentences[1].startswith("The model is off by 3.1 mm a window")
    assert not any("What to do" in text for text in cause.sentences)
    settled = doubtful | {"discrepancy_m": 0.0}
    assert any(text.startswith("caution           stand-ins do less than paths are off by") for text in lines(settled))
    beside = inadequacy(settled | {"reference": {"campaign": "before"}})
    assert beside[0].startswith("the reference follows a law that the catalogue lacks")
    assert all(f"{title(e)} ({times(e['strength_over_noise'])}), perhaps a stand-in" in "\n".join(lines(doubtful))
               for e in record["effects"])  # fmt: skip


@pytest.mark.parametrize(
    ("name", "site", "told"),
    [("frame_drift", "observation", False), ("position_jumps", "observation", False),
     ("loose_joint", "actuation", False), ("marker_offset", "observation", True)],
)  # fmt: skip
def test_a_stand_in_for_how_the_frame_moves_is_none_of_what_markers_show_beside_servos(
    diagnosed: tuple[Any, dict[str, Any], Any], name: str, site: str, told: bool
) -> None:
    """Drift and jumps of the frame are seen on the stage of motion, where markers and servos may agree to the noise."""
    effect = {"name": name, "site": site, "place": None, "stand_in": True}
    said = inadequacy(diagnosed[1] | {"discrepancy_m": 0.0031, "effects": [effect]})
    assert any("what markers show beside the servos" in text for text in said) == told
    assert any("off by 3.1 mm" in text for text in said) == (site == "observation" and not told)


def test_what_is_left_is_told_with_its_stage_and_whether_it_matters(
    diagnosed: tuple[Any, dict[str, Any], Any], tmp_path: Path
) -> None:
    record = diagnosed[1] | {"verdict": "unexplained", "residual_pattern": ["motion: a", "actuation: b"]}
    assert left(record)[0].startswith("enough to matter: actuation ")
    assert left(record)[1:] == ["motion: a", "actuation: b"]
    write_pages(tmp_path, record)
    assert "<p>Motion: a.</p>" in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert left(record | {"verdict": "nothing"})[0].startswith("nothing that matters")
    assert left(record | {"verdict": "nothing", "noise_from": "residuals"})[0].startswith("nobody can tell")


def test_of_long_lists_the_first_are_told_and_how_many_more_there_are() -> None:
    assert few(["a", "b", "c", "d"]) == "a, b, c, d"  # never that there is one more
    assert few(["a", "b", "c", "d", "e"]) == "a, b, c, and 2 more in diagnosis.json"
    refused = "motion: not named, as a wrong effect could take away as much: "
    assert in_short(f"{refused}a (9%), b (8%), c (7%), d (6%), e (5%)").endswith("c (7%), and 2 more in diagnosis.json")
    assert in_short("motion: what is left repeats: a, b, c, d, e") == "motion: what is left repeats: a, b, c, d, e"


def test_all_causes_are_told_and_of_stand_ins_the_strongest(diagnosed: tuple[Any, dict[str, Any], Any]) -> None:
    load = {"name": "load", "site": "medium", "parameters": {}}
    effects = [load | {"place": n, "stand_in": n > 0, "strength_over_noise": n} for n in range(7)]
    record = diagnosed[1] | {"effects": effects, "alternatives": []}
    assert [e["place"] for e in foremost(record)] == [0, 6, 5, 4]
    said = lines(record)
    assert sum(text.startswith("cause") for text in said) == 4
    assert any(text.endswith("and 3 more stand-ins in diagnosis.json") for text in said)


def test_the_answer_says_what_decides_before_its_details_in_short_lines(
    diagnosed: tuple[Any, dict[str, Any], Any],
) -> None:
    said = lines(diagnosed[1])
    order = [said.index(next(text for text in said if text.startswith(label))) for label in ORDER]
    assert order == sorted(order)
    assert max(map(len, said)) < 120


@pytest.mark.parametrize(
    ("text", "said"),
    [("length_scale is off", "length_scale is off."), ("load at vertex 3 is", "load at vertex 3 is."),
     ("the SD is 3", "The SD is 3."), ("is it?", "Is it?")],
)  # fmt: skip
def test_a_sentence_has_a_capital_but_a_name_has_none(text: str, said: str) -> None:
    assert sentence(text) == said


def test_the_interval_of_the_anisotropy_ratio_holds_the_true_one_and_is_narrow(
    diagnosed: tuple[Any, dict[str, Any], Any],
) -> None:
    eps = diagnosed[1]["anisotropy_ratio"]
    low, high = eps["interval"]
    assert low < usual(7).eps < high  # the seed of the campaign
    assert low < eps["after"] < high < 1.05 * low  # what eight trials tell: 2 %


@pytest.mark.parametrize("earlier", [None, 0.2])
def test_beside_names_that_may_be_stand_ins_the_anisotropy_ratio_is_known_no_better_than_with_and_without_them(
    diagnosed: tuple[Any, dict[str, Any], Any], earlier: float | None
) -> None:
    found = diagnosed[0].motion
    selection = replace(found.selection, motion=replace(found.selection.motion, ratio=earlier))
    doubtful = replace(found.stage, named=tuple(replace(n, stand_in=True) for n in found.stage.named))
    sure, unsure = ratio_interval(selection, found.stage), ratio_interval(selection, doubtful)
    assert unsure[0] <= sure[0] < sure[1] <= unsure[1]
    assert unsure[0] < found.selection.null.model.medium.anisotropy_ratio < unsure[1]
    assert not sure[0] < found.selection.null.model.medium.anisotropy_ratio < sure[1]  # the load has a part of it


def test_about_a_law_that_is_known_to_be_another_names_may_be_stand_ins_though_chance_is_all_that_is_left(
    diagnosed: tuple[Any, dict[str, Any], Any],
) -> None:
    found = diagnosed[0].motion
    assert found.stage.discrepancy_m == 0
    again = finding(found.selection, inadequate=True).stage.named
    assert [n.effect.key for n in again] == [n.effect.key for n in found.stage.named]
    assert all(n.stand_in for n in again)


def test_about_a_law_that_is_known_to_be_another_intervals_hold_what_gaits_and_explanations_disagree_about(
    diagnosed: tuple[Any, dict[str, Any], Any],
) -> None:
    found = diagnosed[0].motion.selection
    usual = diagnosed[0].motion.stage.named[0].intervals
    wide = finding(found, inadequate=True).stage.named[0].intervals
    other = replace(found.settled, model=shifted(found.settled.model))
    wider = finding(found, inadequate=True, beside=((found.motion, other, 1.0),)).stage.named[0].intervals
    for name, (low, high) in usual.items():
        assert wider[name][0] < wide[name][0] <= low < high <= wide[name][1] < wider[name][1]
    unlikely = finding(found, inadequate=True, beside=((found.motion, other, 1e-6),)).stage.named[0].intervals
    assert unlikely == {name: pytest.approx(ends, rel=1e-3) for name, ends in wide.items()}


def shifted(model: Model) -> Model:
    """With effects a tenth larger."""
    larger = [e.with_coordinates([1.1 * c for c in e.coordinates[:-1]]) for e in model.effects]
    return Model(model.body, model.medium, tuple(larger))


def test_what_is_not_named_is_said_in_one_sentence_what_takes_away_most_first() -> None:
    def refused(name: str, place: int | None, share: float, beyond: bool = False) -> Refused:
        return Refused(ActiveEffect.neutral(name, place), share, cast("Any", None), beyond)

    slope, twice = refused("slope", None, 0.93), refused("load", 3, 0.2)
    said = refusals([refused("load", 3, 0.05), twice, slope, refused("toe", None, 0.001)])
    assert said == (
        "not named, as a wrong effect could take away as much: slope (93% of what is left), load at vertex 3 (20%)",
    )
    (alone,) = refusals([refused("toe", None, 0.4, beyond=True)])
    assert alone == "not named, as it is pushed beyond its bound: toe (40% of what is left)"


@pytest.mark.parametrize(
    ("name", "law", "length", "unit"),
    [
        ("slope", "viscous", "m", "m/s"),
        ("slope", "viscous", "bl", "bl/s"),
        ("slope", "coulomb", "m", "1"),
        ("inertia", "coulomb", "bl", "s2/bl"),
        ("slope", "quadratic", "bl", "bl2/s2"),
        ("inertia", "quadratic", "m", "m"),
        ("friction_gradient", "coulomb", "bl", "1/bl"),
    ],
)
def test_parameters_are_in_units_of_the_law_and_of_the_recordings_lengths(
    name: str, law: str, length: str, unit: str
) -> None:
    assert parameter_unit(find(name).parameters[0], law, length) == unit


@pytest.mark.parametrize(
    ("held_out", "said"), [("gaits", "gaits"), ("settings", "settings"), ("trials", "trials"), ("nothing", "trials")]
)
def test_what_is_held_out_is_said_as_it_is(held_out: str, said: str) -> None:
    record = {"held_out": held_out, "drag_ratio": None}
    assert unseen(record) == said
    assert in_sample(record) == (held_out == "nothing")
    assert unseen({"drag_ratio": None}) == "gaits"  # of an older answer
    assert unseen({"drag_ratio": (8.0, 7.9, 8.1)}) == "parts"


def test_ideas_are_lines_of_their_own_and_brackets_are_not_cut() -> None:
    aside = "(what `vertices` says; a link (the last; or first) left out. Or joints)"
    assert _ideas(f"one {aside}; two. Three?") == [f"one {aside};", "two.", "Three?"]
