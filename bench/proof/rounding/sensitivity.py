"""How far rounding moves values that have shares as factors, against the same values in real numbers.

Let what rounding adds grow from zero to what it is, so that shares move from what they are in real numbers to
what was calculated. On that way a share p = k / max(k, step / slack, ...) is 1, or it is held by one slack,
p step = k slack. In the first case it does not move; in the second its relative rate is no more than
e / slack, e the rate of the slack and of step / k together. So a form moves by no more than the largest rate
of any attainable demand with any shares that there can be beside it.
"""

from collections.abc import Callable
from math import inf
from typing import NamedTuple

from alloc.program import Node
from bench.proof.rounding.products import (
    NOTHING,
    ONE,
    Form,
    ProductSet,
    Shares,
    constant,
    exact,
    product_shares,
    times,
    total,
    where_one,
    with_share,
)
from bench.proof.source import NotRead

Facts = tuple[Form, ...]
"""Forms that are never negative."""
SMALL = 0.01
"""By how much of itself rounding may move a slack at most."""
MINOR = 0.2
"""What moves a share by less than this, relative to what moves it most, is not looked at more closely."""
NEAR = 4.0
"""A slack of no more than so many times the least one is looked at by itself."""
PART = 0.05
"""Of what rounding adds together, what adds less than this is not looked at more closely."""
COLLINEAR = 1e-12
"""Forms are multiples of each other up to this, relative to their size."""


class Gauge(NamedTuple):
    """Gauge that may hold a share below 1.

    Attributes
    ----------
    step, slack : forms
    tiny : step of this size or less may count as zero
    """

    step: Form
    slack: Form
    tiny: float


class ActiveGauge(NamedTuple):
    """A gauge that holds its share for some demand.

    Attributes
    ----------
    step, slack : the gauge's
    least : no more than the least slack under these facts
    rate : how far slack and step / k move, together
    facts : that it holds the share, and perhaps how large the slack is
    """

    step: Form
    slack: Form
    least: float
    rate: float
    facts: Facts


class Sensitivity:
    """Shares, what may hold them, and how far rounding moves what they are a factor of."""

    def __init__(self, products: ProductSet) -> None:
        """No share is known yet."""
        self._products = products
        self._halves: list[float] = []
        self._of: list[tuple[Form, Callable[[float], float]] | None] = []
        self._active: dict[Node, list[ActiveGauge]] = {}
        self._keep: dict[Node, float] = {}
        self._relative: dict[Node, float] = {}
        self._known: dict[object, float] = {}

    def added(self, most: float, of: Form | None = None, half: Callable[[float], float] = float) -> Form:
        """Rounding error added to a value, a new unknown of no more than this size.

        Where the value has a form, ``half`` is what rounding adds to one of a given size.
        """
        self._halves.append(most)
        self._of.append((of, half) if of else None)
        return {(NOTHING, ONE - len(self._halves)): 1.0}

    def local(self, form: Form, holds: Facts = ()) -> float:
        """Largest rounding error of a form, its shares as they were calculated."""
        parts = [(ONE - 1 - j, abs(factor)) for (_, j), factor in form.items() if j < ONE]
        found = sum(factor * self._halves[number] for number, factor in parts)
        if holds:
            for number, factor in parts:
                if factor * self._halves[number] > PART * found:
                    found -= factor * (self._halves[number] - self._half(number, holds))
        return found

    def _half(self, number: int, holds: Facts) -> float:
        of, most = self._of[number], self._halves[number]
        if of is None:
            return most
        key = number, tuple(map(_key, holds))
        if key not in self._known:
            form, half = of
            size = self._size(exact(form), constant(1.0), 1.0, [*holds]) + self.local(form)
            self._known[key] = min(most, half(size)) if size < inf else most
        return self._known[key]

    def add(self, share: Node, keep: float, gauges: list[Gauge], relative: float) -> None:
        """A share, with its own relative rounding; raises NotRead where a slack may be used up."""
        self._keep[share], self._relative[share] = keep, 1.02 * relative
        facts, held = [], []
        for step, slack, _ in gauges:
            least, local = self._products.least(slack), self.local(slack) + self.local(step) / keep
            if not local < SMALL * least:
                raise NotRead("a division by what may be zero")
            pushed, moved = times(exact(step), share), constant(keep * local)
            facts.append(total((keep * (1.0 + 2.0 * relative), exact(slack)), (-1.0, pushed), (1.0, moved)))
            holds = total((1.0, pushed), (-keep * (1.0 - 2.0 * relative), exact(slack)), (1.0, moved))
            held.append((least, holds))
        for fact in facts:
            self._products.add(fact)
        rates = [self._rate(step, slack, keep, ()) for step, slack, _ in gauges]
        worst = max((rate / least for rate, (least, *_) in zip(rates, held, strict=True)), default=0.0)
        self._active[share] = []
        for (step, slack, tiny), rate, (least, holds) in zip(gauges, rates, held, strict=True):
            # What rounding may move must be small beside the slack that is kept.
            beside = tiny + rate * keep
            if 2.0 * beside > keep * least or beside > SMALL * least:
                raise NotRead("a slack that rounding may use up")
            if self._products.most(holds) < 0.0:
                continue
            if rate / least < MINOR * worst:
                self._active[share].append(_active(step, slack, least, rate, (holds,)))
                continue
            edge = constant(NEAR * least)
            far = holds, total((1.0, exact(slack)), (-1.0, edge))
            near = holds, total((1.0, edge), (-1.0, exact(slack)))
            self._active[share].append(_active(step, slack, NEAR * least, rate, far))
            self._active[share].append(_active(step, slack, least, self._rate(step, slack, keep, near), near))

    def _rate(self, step: Form, slack: Form, keep: float, holds: Facts) -> float:
        return self.most(slack, holds, closely=True) + self.most(step, holds, closely=True) / keep

    def most(self, form: Form, holds: Facts = (), given: Shares = NOTHING, closely: bool = False) -> float:
        """How far a form moves at most, with a further fact; shares that are given do not move."""
        moving = product_shares(form) - given
        if not moving:
            return self.local(form, holds if closely else ())
        key = _key(form), tuple(map(_key, holds)), given, closely
        if key not in self._known:
            self._known[key] = self._most(form, max(moving), holds, given, closely)
        return self._known[key]

    def _most(self, form: Form, share: Node, holds: Facts, given: Shares, closely: bool) -> float:
        facts, keep = [*holds], self._keep[share]
        moves = with_share(form, share)
        rest = total((1.0, form), (-1.0, moves))
        found = self.most(where_one(form, share), holds, given, closely)
        size = self._size(exact(moves), constant(1.0), 1.0, facts)
        own, others = self._relative[share] * size, None
        for each in sorted(self._active[share], key=lambda each: -each.rate / each.least):
            if self._roughly(form, given) <= found:
                break
            factor, left = _factor(moves, times(each.step, share))
            if factor:
                same = total((1.0, rest), (factor * keep, each.slack))
                rate = (
                    self.local(left, holds if closely else ())
                    + self._products.size(exact(left)) * each.rate / each.least
                )
                if rate + own + self._roughly(same, given) > found:
                    rate += self.most(same, holds, given, closely)
            else:
                if others is None:
                    others = self.most(form, holds, given | {share}, closely)
                rate = others
                if others + own + size * each.rate / each.least > found:
                    rate += self._under(each, keep, holds if closely else ()) * self._size(
                        exact(moves), each.slack, each.least, [*facts, *each.facts]
                    )
            found = max(found, rate + own)
        return found

    def _under(self, held: ActiveGauge, keep: float, holds: Facts) -> float:
        """The rate under further facts."""
        if not holds:
            return held.rate
        rate = self._rate(held.step, held.slack, keep, (*holds, *held.facts))
        return min(held.rate, rate / (1.0 - rate / held.least))

    def _roughly(self, form: Form, given: Shares) -> float:
        """No less than ``most``, without a linear program."""
        found = self.local(form)
        for share in product_shares(form) - given:
            rate = max((each.rate / each.least for each in self._active[share]), default=0.0)
            found += (rate + self._relative[share]) * self._products.size(exact(with_share(form, share)))
        return found

    def _size(self, form: Form, over: Form, least: float, facts: list[Form]) -> float:
        opposite = total((-1.0, form))
        return max(0.0, *(self._products.ratio(each, exact(over), least, facts) for each in (form, opposite)))


def _active(step: Form, slack: Form, least: float, rate: float, facts: Facts) -> ActiveGauge:
    return ActiveGauge(step, slack, least, rate / (1.0 - rate / least), facts)


def _key(form: Form) -> object:
    return frozenset(form.items())


def _factor(form: Form, unit: Form) -> tuple[float, Form]:
    """Ratio of a form to another one but for rounding, and the rest; 0 where it is no multiple."""
    largest = max(exact(unit), key=lambda atom: abs(unit[atom]))
    factor = form.get(largest, 0.0) / unit[largest]
    left = total((1.0, form), (-factor, unit))
    size = COLLINEAR * max(map(abs, form.values()))
    same = all(abs(each) <= size for each in exact(left).values())
    return (factor, left) if same else (0.0, form)
