"""Arithmetic on values of which range and rounding error are known."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import floor, frexp, log2

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.program import Scalar
from bench.proof.rounding.products import (
    ONE,
    Form,
    ProductSet,
    constant,
    has_tau,
    multiplied,
    product_shares,
    total,
)
from bench.proof.rounding.sensitivity import Sensitivity
from bench.proof.source import NotRead

DIGITS: dict[Scalar, int] = {"double": 53, "float": 24}
TINIEST: dict[Scalar, float] = {"double": 2.0**-1075, "float": 2.0**-150}
"""Half of the smallest subnormal number, which a product may lose."""
WIDER: dict[Scalar, float] = {"double": 1e-13, "float": 1e-6}
"""By how much ranges are widened, relative to their size: for demands that rounding takes out of the
attainable set, and for rounding in this analysis itself."""

ALTERNATIVES = 64
"""A minimum of more values than this is bounded as a whole, no longer value by value."""


@dataclass(frozen=True)
class Value:
    """One value of a program.

    Attributes
    ----------
    low, high : range of the exact value
    error : how far the calculated value may be from it; where it has a form with shares, from what the form
        gives with the shares as they were calculated
    form : the sum that it is; None where it is no such sum
    own : what its own rounding adds, in its form; ``ONE`` where it is not rounded
    among : values with a form, of which minimum and maximum choose it; none where they are not known
    least : whether it is the least of them
    """

    low: float
    high: float
    error: float
    form: Form | None = None
    own: int = ONE
    among: "tuple[Value, ...]" = ()
    least: bool = True

    @property
    def size(self) -> float:
        """Largest size of the exact value."""
        return max(abs(self.low), abs(self.high))


class Arithmetic:
    """Operations on values, over all attainable demands of a vehicle."""

    def __init__(self, vehicle: Vehicle, scalar: Scalar) -> None:
        """No share is known yet."""
        self._vehicle, self._scalar = vehicle, scalar
        self._products = ProductSet(vehicle, WIDER[scalar])
        self._sensitivity = Sensitivity(self._products)

    def _plain(self, value: Value) -> Value:
        """A value without its form, with all of its error."""
        if value.form is not None:
            return Value(value.low, value.high, self._error(value))
        if value.among:  # minimum and maximum move by no more than what they choose from
            return Value(value.low, value.high, max(map(self._error, value.among)))
        return value

    def _error(self, value: Value) -> float:
        assert value.form is not None
        return self._sensitivity.most(value.form)

    def _linear(self, form: Form, own: int = ONE) -> Value:
        low = high = 0.0
        for inner in {each for each, _ in form}:
            along = np.array([form.get((inner, j), 0.0) for j in range(self._vehicle.k)])
            ends, one = _support(self._vehicle, along), form.get((inner, ONE), 0.0)
            wider = WIDER[self._scalar] * max(abs(ends[0]), abs(ends[1]))
            some = (ends[0] + one - wider, ends[1] + one + wider)
            low += min(some[0], 0.0) if inner else some[0]
            high += max(some[1], 0.0) if inner else some[1]
        return Value(low, high, self._sensitivity.local(form), form, own)

    def _half(self, most: float) -> float:
        """Largest rounding error of a value of this size."""
        half = 2.0 ** (floor(log2(most)) - DIGITS[self._scalar]) if most > 0 else 0.0
        return half + TINIEST[self._scalar]

    def _rounded(self, value: Value, more: float = 0.0) -> Value:
        """A value with its rounding, and with a further error."""
        added = self._half(value.size + value.error + more)
        if value.form is None:
            return replace(value, error=value.error + added + more)
        form = value.form | (self._sensitivity.added(more) if more else {})
        own = self._sensitivity.added(added, form, self._half)
        ((_, at),) = own
        return replace(value, error=value.error + added + more, form=form | own, own=at)

    def _sum(self, a: Value, b: Value, sign: float) -> Value:
        if a.form is not None and b.form is not None:
            made = self._linear(total((1.0, a.form), (sign, b.form)))
        else:
            if pairs := self._pairs(a, b, sign):
                return pairs
            a, b = self._plain(a), self._plain(b)
            ends = sorted((sign * b.low, sign * b.high))
            made = Value(a.low + ends[0], a.high + ends[1], a.error + b.error)
        zeros = [each.low == each.high == 0.0 and not each.error for each in (a, b)]
        return made if any(zeros) else self._rounded(made)

    def _pairs(self, a: Value, b: Value, sign: float) -> Value | None:
        """A sum of minima or maxima as the choice among the sums of their values: rounding keeps order."""
        some, others = among(a), among(b)
        if not 1 <= len(some) * len(others) <= ALTERNATIVES:
            return None
        found = tuple(self._sum(x, y, sign) for x in some for y in others)
        ends = sorted((sign * b.low, sign * b.high))
        least = a.least and (b.least if sign > 0 else len(others) == 1)
        return Value(a.low + ends[0], a.high + ends[1], 0.0, among=found, least=least)

    def _add(self, a: Value, b: Value) -> Value:
        return self._sum(a, b, 1.0)

    def _sub(self, a: Value, b: Value) -> Value:
        return self._sum(a, b, -1.0)

    def _neg(self, a: Value) -> Value:
        form = None if a.form is None else total((-1.0, a.form))
        if form is None and a.among:
            found = tuple(map(self._neg, a.among))
            return Value(-a.high, -a.low, 0.0, among=found, least=len(found) == 1)
        return Value(-a.high, -a.low, a.error, form, a.own)

    def _abs(self, a: Value) -> Value:
        """The larger of a value and its opposite."""
        return replace(self._max(a, self._neg(a)), low=max(0.0, a.low, -a.high))

    def _min(self, a: Value, b: Value) -> Value:
        return self._one_of(a, b, min, a.least and b.least)

    def _max(self, a: Value, b: Value) -> Value:
        return self._one_of(a, b, max, least=False)

    def _one_of(self, a: Value, b: Value, choose: Callable[[float, float], float], least: bool) -> Value:
        low, high = choose(a.low, b.low), choose(a.high, b.high)
        some, others = among(a), among(b)
        if some and others and len(some) + len(others) <= ALTERNATIVES:
            found = {id(each): each for each in (*some, *others)}.values()
            return Value(low, high, 0.0, among=tuple(found), least=least)
        return Value(low, high, max(self._plain(a).error, self._plain(b).error))

    def _mul(self, a: Value, b: Value) -> Value:
        doubled = any(each.low == each.high and abs(frexp(each.low)[0]) == 0.5 for each in (a, b))
        if a.form is not None and b.form is not None and not product_shares(a.form) & product_shares(b.form):
            if has_tau(a.form):
                a, b = b, a
            if a.form is not None and b.form is not None and not has_tau(a.form):
                value = self._linear(multiplied(a.form, b.form))
                if doubled and not a.error:
                    return replace(value, own=b.own)
                return self._rounded(value, a.error * (b.size + b.error))
        if doubled and (a.among or b.among):
            return self._scaled(*((a, b.low) if a.among else (b, a.low)))
        a, b = self._plain(a), self._plain(b)
        error = a.error * b.size + b.error * a.size + a.error * b.error
        corners = [x * y for x in (a.low, a.high) for y in (b.low, b.high)]
        value = Value(min(corners), max(corners), error)
        return value if doubled else self._rounded(value)  # a power of two rounds nothing but what is tiny

    def _scaled(self, value: Value, factor: float) -> Value:
        """A value times a power of two: each value that it may be is multiplied, without rounding."""
        by = self._linear(constant(factor))
        found = tuple(self._mul(each, by) for each in value.among)
        low, high = sorted((factor * value.low, factor * value.high))
        return Value(low, high, 0.0, among=found, least=value.least and factor > 0.0)

    def _div(self, a: Value, b: Value) -> Value:
        least = min(abs(b.low), abs(b.high)) if b.low > 0 or b.high < 0 else 0.0
        if least <= (error := self._plain(b).error):
            raise NotRead("a division by what may be zero")
        if a.form is not None and b.low == b.high:
            value = self._linear(total((1.0 / b.low, a.form)))
            return self._rounded(value, (value.size + value.error) * error / (least - error))
        a = self._plain(a)
        corners = [x / y for x in (a.low, a.high) for y in (b.low, b.high)]
        size = max(abs(each) for each in corners)
        return self._rounded(Value(min(corners), max(corners), (a.error + size * error) / (least - error)))


def among(value: Value) -> tuple[Value, ...]:
    """The values with a form of which a value is one; none where they are not known."""
    return value.among if value.form is None else (value,)


def _support(vehicle: Vehicle, along: FloatArray) -> tuple[float, float]:
    """Least and largest along . tau over all attainable tau."""
    push = along @ vehicle.TP
    ends = np.sort([push * vehicle.f_min, push * vehicle.f_max], axis=0)
    return float(ends[0].sum()), float(ends[1].sum())
