"""Media: one file per dissipation law, each a potential of an element's squared slip."""

from serpenoid.media.base import Law
from serpenoid.media.coulomb import COULOMB
from serpenoid.media.viscous import VISCOUS

__all__ = ["COULOMB", "LAWS", "VISCOUS", "Law"]

LAWS: dict[str, Law] = {law.name: law for law in (VISCOUS, COULOMB)}
