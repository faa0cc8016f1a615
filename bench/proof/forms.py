"""Numbers of a program as sums of products, and how far rounding may take them from these.

A product is one of numbers that are not looked into (atoms), named by their nodes; no node is the number 1.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import frexp

from alloc.kernels.tolerance import DOUBLE, SINGLE
from alloc.program import Node, Program, Scalar

Product = tuple[Node, ...]
ONE: Product = ()
UNIT: dict[Scalar, float] = {"double": DOUBLE, "float": SINGLE}
"""Rounding of a number, relative to its size [-]."""
TINIEST: dict[Scalar, float] = {"double": 2.0**-1074, "float": 2.0**-149}
"""The smallest subnormal number, half of which a product or quotient may lose."""


@dataclass(frozen=True)
class Form:
    """A number that differs from a sum of products by no more than another sum of their sizes.

    Attributes
    ----------
    terms : the factor of each product
    error : the factor, not negative, of each product's size
    """

    terms: Mapping[Product, float] = field(default_factory=dict)
    error: Mapping[Product, float] = field(default_factory=dict)

    def __add__(self, other: "Form") -> "Form":
        return total((1.0, self), (1.0, other))

    def __sub__(self, other: "Form") -> "Form":
        return total((1.0, self), (-1.0, other))

    def __mul__(self, other: "Form") -> "Form":
        terms, error = dict[Product, float](), dict[Product, float]()
        for into, some, others in (
            (terms, self.terms, other.terms),
            (error, self.error, other.size),
            (error, self.size, other.error),
        ):
            for a, x in some.items():
                for b, y in others.items():
                    into[tuple(sorted(a + b))] = into.get(tuple(sorted(a + b)), 0.0) + x * y
        return Form(terms, error)

    @property
    def size(self) -> dict[Product, float]:
        """The factors of products' sizes that bound the number."""
        return {m: abs(self.terms.get(m, 0.0)) + self.error.get(m, 0.0) for m in self.products}

    @property
    def products(self) -> set[Product]:
        """All products, those of errors too."""
        return {*self.terms, *self.error}

    @property
    def constant(self) -> float:
        """The factor of the number 1."""
        return self.terms.get(ONE, 0.0)

    def wider(self, by: float) -> "Form":
        """The same with an error that is larger by a share of the number's size."""
        error = {m: self.error.get(m, 0.0) + by * size for m, size in self.size.items()}
        return Form(self.terms, error)


def total(*parts: tuple[float, Form]) -> Form:
    """The sum of forms, each times a factor."""
    terms, error = dict[Product, float](), dict[Product, float]()
    for factor, form in parts:
        for m, value in form.terms.items():
            terms[m] = terms.get(m, 0.0) + factor * value
        for m, value in form.error.items():
            error[m] = error.get(m, 0.0) + abs(factor) * value
    return Form({m: value for m, value in terms.items() if value}, error)


def atom(node: Node) -> Form:
    """A number that is not looked into."""
    return Form({(node,): 1.0})


def number(value: float) -> Form:
    """A known number."""
    return Form({ONE: value} if value else {})


class Forms:
    """The forms of a program's numbers where some conditions are known, so that choices are."""

    def __init__(
        self, program: Program, scalar: Scalar, truths: Mapping[Node, bool], known: Mapping[Node, Form]
    ) -> None:
        """Forms of ``known`` nodes stand for what these nodes calculate."""
        self._nodes, self._truths, self._known = program.nodes, truths, dict(known)
        self.unit, self._tiniest = UNIT[scalar], TINIEST[scalar]

    def form(self, node: Node) -> Form:
        """The form of a number."""
        if node not in self._known:
            self._known[node] = self._made(node)
        return self._known[node]

    def _made(self, node: Node) -> Form:
        match self._nodes[node]:
            case ("const", value):
                return number(value)
            case ("add", a, b):
                return self.sum(self.form(a), self.form(b), 1.0)
            case ("sub", a, b):
                return self.sum(self.form(a), self.form(b), -1.0)
            case ("neg", a):
                return total((-1.0, self.form(a)))
            case ("mul", a, b):
                return self.product(self.form(a), self.form(b))
            case ("choose", condition, a, b) if condition in self._truths:
                return self.form(a if self._truths[condition] else b)
        return atom(node)

    def sum(self, a: Form, b: Form, sign: float) -> Form:
        """a + sign b, rounded; beside zero nothing is."""
        made = total((1.0, a), (sign, b))
        return made.wider(self.unit) if a.products and b.products else made

    def product(self, a: Form, b: Form) -> Form:
        """a b, rounded; by a power of two only what is tiny is."""
        made = a * b
        exact = any(x.products <= {ONE} and not x.error and abs(frexp(x.constant)[0]) == 0.5 for x in (a, b))
        return total((1.0, made if exact else made.wider(self.unit)), (1.0, Form({}, {ONE: self._tiniest})))
