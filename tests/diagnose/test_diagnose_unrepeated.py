"""Where nothing was played twice, chance is what is left: first-order scores are in units of the model's own error."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from blind.campaign import make
from blind.catalogue import Effect
from blind.folder import write
from blind.random_protocols import draw_protocol
from serpenoid.diagnose.campaign import diagnose_campaign

SEED = 166611063688274
HIDDEN = (
    Effect("rolling_resistance", None, {"crossover_speed": 0.44655}),
    Effect("wheel_mount", None, {"share": -0.6711}),
)


def test_a_law_that_first_order_scores_do_not_show_is_found_without_repeats(tmp_path: Path) -> None:
    """Two trials of one cycle each; the wheels' mount, named alone, left held-out paths astray by 41 noise levels."""
    protocol = draw_protocol(SEED)
    settings = tuple(replace(s, plan=replace(s.plan, cycles=1)) for s in protocol.settings)
    write(make(SEED, HIDDEN, "once", protocol=replace(protocol, plays=1, settings=settings)), tmp_path)
    _, found = diagnose_campaign(tmp_path, None)
    assert {n.effect.name for n in found.named} == {e.name for e in HIDDEN}
    for named in found.named:
        (parameter,) = named.effect.parameters
        true = next(e for e in HIDDEN if e.name == named.effect.name).parameters[parameter]
        low, high = named.intervals[parameter]
        assert low is not None
        assert high is not None
        assert low < true < high
