"""The virtual laboratory: the paper's robot on rolling wheels, filmed and logged, written as a campaign.

It shares no mechanics with the rest of the package (rigid bodies, contacts and motors are MuJoCo's), so what the
package's model gets wrong about it is a genuine model error. This folder is the only one that imports mujoco.
"""

from __future__ import annotations

from types import ModuleType

from serpenoid.errors import InputError


def mujoco_module() -> ModuleType:
    """The mujoco package, or an error that says how to get it."""
    try:
        import mujoco
    except ImportError:
        raise InputError(
            "the arena needs the package `mujoco`, which is missing: pip install mujoco (as the extra `arena` does)."
        ) from None
    return mujoco
