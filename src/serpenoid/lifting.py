"""What cannot be asked where parts of the body are lifted (`[lift]`), told before the work."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.gaits import EllipseBounds, EllipseGait, Gait, GaitBounds
from serpenoid.gaits.fourier import FourierBounds, FourierGait
from serpenoid.gaits.lifted import Lift
from serpenoid.model import Model
from serpenoid.objectives import Demand, Term

PHASES = 24  # at which the steepest wave is looked for


def fault(lift: Lift, gait: Gait, model: Model, bounds: GaitBounds, goals: Sequence[Term | Demand]) -> str | None:
    """What does not go together with lifting, in words; None: nothing."""
    if not isinstance(gait, EllipseGait | FourierGait) or (isinstance(gait, FourierGait) and len(gait.xi) > 1):
        return "parts are lifted beside a wave of bending; [gait] must be an ellipse, or `fourier` with one `xi`."
    if model.only_in_the_plane is not None:
        return model.only_in_the_plane
    flat = next((goal for goal in goals if goal.flat), None)
    if flat is not None:
        return f"`{flat.kind}` cannot be asked in space: {flat.flat}; leave one of the two out."
    if not _steepest(lift, model, bounds) < 1:
        return (
            f"`height`: edges are too short to rise by {lift.height:g} body lengths in a wave; lower `height`, "
            "`sharpness` or the upper bound of `xi`."
        )
    return None


def flat_only(lift: Lift | None, name: str) -> None:
    """Refuse a problem of this name where its robot would have to play yaw and pitch."""
    if lift is not None:
        raise InputError(f"{name}: [lift]: robots and arenas play one angle a joint; leave [lift] out.")


def _steepest(lift: Lift, model: Model, bounds: GaitBounds) -> float:
    """The steepest rise of a link in the shortest wave: an edge cannot rise by more than its length."""
    xi = bounds.xi[1] if isinstance(bounds, EllipseBounds | FourierBounds) else EllipseBounds().xi[1]
    s: Floats = np.concatenate([[0.0], np.cumsum(model.body.edges)])[[0, *model.structure.joints, -1]]
    crests = np.cos(2 * np.pi * (xi * s + np.arange(PHASES)[:, None] / PHASES))
    rises = [np.diff(lift.contact(crests + bias)) / np.diff(s) for bias in lift.bias]
    return float(lift.height * np.abs(rises).max())
