"""Markers that stand elsewhere on the body in each trial, as where one peels off, put back where all trials have them.

Poses are those of chains laid over markers, so a marker that is off moves the path by its share.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.geometry import register, turn
from serpenoid.measure.shapes.links import marker_angles


def put_back(recordings: Sequence[Recording], seen: Observation, alone: Sequence[Observation]) -> tuple[Recording, ...]:
    """Recordings whose markers stand as `seen` has them in all trials, of trials by themselves as `alone` has each; as
    they are where that bends joints or stretches films, which is not of the markers."""
    if not alone or any(_shapes(one) != _shapes(seen) for one in alone):
        return tuple(recordings)
    return tuple(_put_back(r, seen, one) for r, one in zip(recordings, alone, strict=True))


def _put_back(r: Recording, seen: Observation, own: Observation) -> Recording:
    markers = seen.unstretched(r.markers)
    angles = seen.angles(r.angles, seen.begun(r.angles, marker_angles(r.body, markers)))
    shown, wanted = (model.seen(r.body, angles) for model in (own, seen))
    heading = register(shown, markers)[0][:, None, 2]
    moved = np.where(np.isfinite(heading)[..., None], turn(np.nan_to_num(heading), shown - wanted), 0.0)
    return replace(r, markers=seen.stretched(markers - moved))


def _shapes(model: Observation) -> tuple[float, ...]:
    """What a model says of joints and of films, not of markers on the body."""
    return (*model.zeros.tolist(), *model.gaps.tolist(), model.scale, *np.asarray(model.axes).ravel().tolist())
