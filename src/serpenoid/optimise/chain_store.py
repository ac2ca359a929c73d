"""Solved points on disk, of a continuation or many starts, so that what was interrupted does not solve them again."""

from __future__ import annotations

import hashlib
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.files.inputs import read_bytes
from serpenoid.files.writing import CHAIN, atomic, short_hash
from serpenoid.optimise.clear.clearance import Clearance
from serpenoid.optimise.clear.watch import Watch, Watched
from serpenoid.optimise.ipopt import Outcome, Point
from serpenoid.optimise.program.prepared import Carried
from serpenoid.optimise.solver import Answer, GaitSolver
from serpenoid.status import Status

STATIONARY = 1e-8  # what a certificate asks for


@dataclass(frozen=True)
class ChainStore:
    """Primal-dual points `<chain>-<c>.npz` in a folder."""

    folder: Path
    chain: str

    def save(self, c: float, answer: Answer) -> None:
        """Write one point, whole or not at all."""
        p, carried = answer.outcome.point, answer.carried
        rows, watch = np.array(carried.rows, int), np.array(carried.watch.points, float)
        stream = io.BytesIO()
        np.savez(
            stream, x=p.x, lam_x=p.lam_x, lam_g=p.lam_g, rows=rows, watch=watch, margin=carried.margin,
            iterations=answer.iterations, seconds=answer.seconds, said=np.array(answer.outcome.ipopt_status),
        )  # fmt: skip
        content = stream.getvalue()
        with atomic(self._path(c)) as target:
            target.write_bytes(hashlib.sha256(content).digest() + content)

    def load(self, c: float, solver: GaitSolver) -> Answer | None:
        """The stored answer with its residuals evaluated afresh, or None where there is none for this problem."""
        try:
            with np.load(io.BytesIO(_whole(read_bytes(self._path(c))))) as data:
                point = Point(data["x"], data["lam_x"], data["lam_g"])
                watch = Watch(tuple(Watched(a, int(t), b, int(v), int(k)) for a, t, b, v, k in data["watch"].tolist()))
                carried = Carried(tuple(data["rows"].tolist()), watch, float(data["margin"]))
                iterations = int(data["iterations"])
                seconds, said = float(data["seconds"]), str(data["said"])
        except (InputError, KeyError, ValueError):
            return None
        bounds = solver.bounds(carried)
        if point.x.shape != bounds.lbx.shape or point.lam_g.shape != bounds.lbg.shape:
            return None  # of another table, whose rows may not be here
        _, ipopt = solver.prepared(carried)
        parameters = solver.parameters(c, carried.rows)
        residuals = ipopt.residuals(point, parameters, bounds)
        if not residuals.largest <= STATIONARY:
            return None  # an answer, but to another problem
        objective = float(ipopt.functions["f"](point.x, parameters))
        outcome = Outcome(Status.SOLVED, said, point, objective, residuals, iterations, {"total": seconds})
        q = point.x[-solver.family.size :]
        return Answer(outcome, q, iterations, seconds, carried, _clearance(solver, q), kept=True)

    def _path(self, c: float) -> Path:
        return self.folder / f"{self.chain}-{c!r}.npz"


def store_of(folder: str | Path | None, start: Floats) -> ChainStore | None:
    """Where the answer from one start is kept: beside those of the others, named by the start itself."""
    return None if folder is None else ChainStore(Path(folder) / CHAIN, f"start-{short_hash(start.tolist())}")


def _clearance(solver: GaitSolver, q: Floats) -> Clearance | None:
    """What is proven of obstacles, as when the answer was found."""
    if not solver.obstacles.gaps:
        return None
    table = solver.table(q)
    return solver.obstacles.clearance(solver.simulate(q).poses, table)


def _whole(stored: bytes) -> bytes:
    """What was stored, if it is what was written; ValueError for a damaged file."""
    digest, content = stored[:32], stored[32:]
    if hashlib.sha256(content).digest() != digest:
        raise ValueError("damaged")
    return content
