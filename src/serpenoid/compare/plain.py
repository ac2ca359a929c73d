"""What fits and comparisons do not know: effects."""

from __future__ import annotations

from serpenoid.errors import InputError
from serpenoid.model import Model


def refuse_effects(model: Model) -> None:
    """InputError where a model has effects: measured shapes on the frames' own times are laid beside the baseline."""
    if model.effects:
        names = ", ".join(dict.fromkeys(effect.name for effect in model.effects))
        raise InputError(
            f"[[effects]]: `fit`, `compare` and `reproduce` know the baseline alone, and this model has effects "
            f"({names}). Leave them out; `diagnose` takes them into account."
        )
