"""What all films of a campaign show of the lengths that it states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from serpenoid.body import Body
from serpenoid.measure.campaign import CampaignFile
from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.blame import Contradiction
from serpenoid.measure.consistency.lengths import Shown, wrong_edge
from serpenoid.measure.trial_files import Files, ever_seen, stated_between


@dataclass(frozen=True)
class Films:
    """Trials whose films have a scale, and what they show of stated lengths: see `beside_film`."""

    trials: tuple[str, ...]
    shown: tuple[Shown, Floats, list[str], bool]


def films_of(file: CampaignFile, body: Body, read: Sequence[Files]) -> Films | None:
    """None where nothing is stated, or nothing seen."""
    if body.is_animal or not file.lengths_given:
        return None
    films = {
        f.entry.name: f for f in read if f.tracks is not None and f.tracks.scale_known and f.keys.length_unit != "bl"
    }
    marked = {name: f.labelled.vertices for name, f in films.items() if f.labelled is not None}
    if not marked:
        return None
    shown = sorted({k for points in marked.values() for k in ever_seen(points).tolist()})
    stated = stated_between(shown, body.edges_m, body)
    names, seen = next(iter(films.values())).names(body), [points[:, shown] for points in marked.values()]
    labels = [names[k] for k in shown]
    return Films(tuple(marked), (Shown.of(seen, stated), stated, labels, len(shown) == body.vertices))


def wrong_edges(films: Films | None) -> list[Contradiction]:
    """One link that all films together show of another length."""
    found = None if films is None else wrong_edge(*films.shown)
    if films is None or found is None:
        return []
    words, cure, gain = found
    return [Contradiction(trial, "length", words, cure, gain) for trial in films.trials]
