"""What is added to criteria, checked where it is added: CasADi finds out later, in words about its own types."""

from __future__ import annotations

from collections.abc import Callable, Set
from typing import Any

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError

COMPARED = {ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_NOT, ca.OP_AND, ca.OP_OR}
HOW = "Build it of the symbols of sp.Criteria with casadi's functions (ca.sin, not math.sin; ca.if_else, not if)."


def expression(value: Any, where: str, known: Set[int]) -> ca.SX:
    """`value` as an expression of the known symbols (hashes of their elements); InputError where it is none."""
    try:
        found = ca.SX(value)
    except (NotImplementedError, TypeError):
        raise InputError(f"{where}: takes an expression, got {_kind(value)}. {HOW}") from None
    foreign = [symbol.name() for symbol in ca.symvar(found) if symbol.element_hash() not in known]
    if foreign:
        raise InputError(f"{where}: `{foreign[0]}` is no symbol of these criteria. {HOW}")
    truths = [e for e in ca.vertsplit(ca.vec(ca.densify(found))) if e.op() in COMPARED]
    if truths:
        raise InputError(
            f"{where}: `{str(truths[0])[:60]}` is a comparison, 0 or 1 without a slope, which asks nothing of a gait. "
            "Give what is compared as an expression: subject_to(expression, lower, upper)."
        )
    if found.is_constant() and np.isnan(ca.evalf(found).full()).any():
        raise InputError(f"{where}: is not a number (NaN), whatever the gait. {HOW}")
    return found


def scalar(value: Any, where: str, known: Set[int]) -> ca.SX:
    """An expression that is one number."""
    found = expression(value, where, known)
    if not found.is_scalar():
        raise InputError(f"{where}: takes one number, got {found.size1()} x {found.size2()}. Sum them, or square them?")
    return found


def interval(lower: Any, upper: Any, size: int) -> tuple[Floats, Floats]:
    """Bounds of `size` numbers, each of them given once or for every number."""
    ends = []
    for name, given in (("lower", lower), ("upper", upper)):
        try:
            end = np.asarray(given, float).ravel()
        except (TypeError, ValueError):
            raise InputError(f"subject_to: `{name}` must be numbers, got {_kind(given)}.") from None
        if end.size not in (1, size):
            raise InputError(f"subject_to: `{name}` must be one number or {size}, one for each, got {end.size}.")
        ends.append(np.broadcast_to(end, size))
    if not (ends[0] <= ends[1]).all():
        raise InputError(f"subject_to: needs lower <= upper, got {lower} and {upper}. Exchanged, or NaN?")
    return ends[0], ends[1]


def gaps(given: Callable[[ca.SX], ca.SX]) -> None:
    """InputError unless it gives as many numbers for every point, made of the point alone."""

    def column(points: ca.SX) -> ca.SX:
        return expression(given(points), "keep_clear", {element.element_hash() for element in ca.symvar(points)})

    places = ca.SX.sym("places", 2, 2)
    one, two = column(places[:, 0]).numel(), column(places).numel()
    if two != 2 * one:
        raise InputError(f"keep_clear: must give as many gaps for every point, got {one} for one and {two} for two.")


def _kind(value: Any) -> str:
    kind = type(value).__name__
    return f"casadi.{kind}" if type(value).__module__.startswith("casadi") else kind
