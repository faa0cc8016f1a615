"""Products of shares and thrusts: sums of them, and how large these can be.

A value is a sum of factors times atoms: entries of tau, each perhaps times shares. What rounding adds is an
unknown of its own, so that it cancels where the value does.

For attainable demands and shares together there is a linear program over their products. A product of shares
times thrusts f counts as a vector of its own, as does the product itself. Of these it is known that each
share lies between 0 and 1, each thrust within its limits, and what is added: a fact is a form that is never
negative. More than the true set satisfies this, so what is largest here is no smaller there.
"""

from collections.abc import Iterable
from itertools import chain, combinations
from math import inf

import numpy as np
from scipy.sparse import csc_matrix

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.program import Node
from alloc.solvers.highs import silent_binding
from bench.proof.source import NotRead

Shares = frozenset[Node]
"""Shares that are multiplied with each other, by node; none for 1."""
Atom = tuple[Shares, int]
"""Shares times an entry of tau, times 1 where that is ``ONE``, or times what rounding adds where less."""
Form = dict[Atom, float]
"""Factors of atoms, the sum of which a value is."""
ONE = -1
NOTHING: Shares = frozenset()


def constant(value: float) -> Form:
    """A number."""
    return {(NOTHING, ONE): value}


def total(*terms: tuple[float, Form]) -> Form:
    """The sum of forms, each times a factor."""
    found: Form = {}
    for factor, form in terms:
        for atom, each in form.items():
            found[atom] = found.get(atom, 0.0) + factor * each
    return {atom: each for atom, each in found.items() if each}


def exact(form: Form) -> Form:
    """A form without what rounding adds."""
    return {atom: factor for atom, factor in form.items() if atom[1] >= ONE}


def multiplied(a: Form, b: Form) -> Form:
    """The product of a form without tau and one that holds none of its shares.

    What rounding adds to the first one is left out.
    """
    found: Form = {}
    for (some, _), x in exact(a).items():
        for (others, j), y in b.items():
            atom = some | others, j
            found[atom] = found.get(atom, 0.0) + x * y
    return found


def times(form: Form, share: Node) -> Form:
    """A form times a share that it does not hold."""
    return {(shares | {share}, j): factor for (shares, j), factor in form.items()}


def with_share(form: Form, share: Node) -> Form:
    """The terms that hold a share."""
    return {atom: factor for atom, factor in form.items() if share in atom[0]}


def where_one(form: Form, share: Node) -> Form:
    """A form where a share is 1."""
    return total(*((factor, {(shares - {share}, j): 1.0}) for (shares, j), factor in form.items()))


def product_shares(form: Form) -> Shares:
    """All shares of a form."""
    return NOTHING.union(*(shares for shares, _ in form))


def has_tau(form: Form) -> bool:
    """True if tau stands in a form."""
    return any(j > ONE for _, j in form)


MODELS = 64
"""Of how many lists of facts a model is kept."""
ROUNDED = 1e-15
"""What rounding may add to a certificate, relative to its parts."""
WIDER = 1e-9
"""By how much a bound is widened, relative to its size, for rounding in the certificate."""


class ProductSet:
    """All products of shares and thrusts that there may be.

    ``wider`` is by how much demands may leave the attainable set, relative to its size.
    """

    def __init__(self, vehicle: Vehicle, wider: float) -> None:
        """No fact is known yet."""
        self._unit = vehicle.f_scale
        self._TP = vehicle.TP * self._unit
        low, high = vehicle.f_min / self._unit, vehicle.f_max / self._unit
        rows = np.flatnonzero(high > low)
        more = np.where(high > low, wider, 0.0)
        self._low, self._high, self._working = low - more, high + more, rows
        self._facts: list[Form] = []
        self._ratios: dict[object, float] = {}
        self._models: dict[object, _Model] = {}

    def add(self, fact: Form) -> None:
        """This form is never negative."""
        self._facts.append(fact)

    def size(self, form: Form) -> float:
        """No less than the size of a form, its terms taken one by one."""
        most = np.abs(self._TP) @ np.maximum(np.abs(self._low), np.abs(self._high))
        return sum(abs(factor) * (1.0 if j == ONE else float(most[j])) for (_, j), factor in form.items())

    def least(self, form: Form) -> float:
        """No more than the least value of a form, without what rounding adds."""
        return -self.most({atom: -each for atom, each in exact(form).items()})

    def most(self, form: Form, facts: list[Form] | None = None) -> float:
        """No less than the largest value of a form, with further facts."""
        return self.ratio(form, constant(1.0), 1.0, facts)

    def ratio(self, form: Form, over: Form, least: float, facts: list[Form] | None = None) -> float:
        """No less than the largest value of a form over another one, which is at least ``least`` > 0.

        With y the products, homogeneous since 1 is one of them, it is max form . y where over . y = 1 and
        A y >= 0. Whatever the solver answers, its multipliers z >= 0 show that
        form . y <= bound * over . y + r . |y|, r what is left of bound * over - form - z A.
        """
        more = facts or []
        key = len(self._facts), tuple(frozenset(each.items()) for each in (form, over, *more))
        if key not in self._ratios:
            self._ratios[key] = self._ratio(form, over, least, more)
        return self._ratios[key]

    def _ratio(self, form: Form, over: Form, least: float, more: list[Form]) -> float:
        known = [*self._facts, *more]
        sets = _closed(shares for each in (form, over, *known) for shares, _ in each)
        columns = {shares: at * (len(self._low) + 1) for at, shares in enumerate(sets)}
        key = tuple(sets), len(self._facts), tuple(frozenset(each.items()) for each in more)
        if key not in self._models:
            rows = [self._row(each, columns) for each in known]
            A = np.vstack([*self._limits(sets, columns), *(row / np.abs(row).max() for row in rows)])
            self._models = dict(list(self._models.items())[-MODELS:]) | {key: _Model(A)}
        objective, below = self._row(form, columns), self._row(over, columns)
        model = self._models[key]
        solved = model.largest(objective, below)
        if solved is None:
            # No demand satisfies these facts where the last is negative whenever the others hold.
            return -inf if more and self.most(more[-1], more[:-1]) < 0.0 else inf
        bound, z = solved
        left = np.abs(bound * below - objective - z @ model.A)
        left += ROUNDED * (abs(bound) * np.abs(below) + z @ np.abs(model.A))
        most = np.tile([*np.maximum(np.abs(self._low), np.abs(self._high)), 1.0], len(sets))
        return bound + float(left @ most) / least + WIDER * abs(bound)

    def _limits(self, sets: list[Shares], columns: dict[Shares, int]) -> list[FloatArray]:
        """Rows of: shares from 0 to 1, and thrusts within limits, also times each product of s and 1 - s."""
        n, rows = len(self._low), []
        largest = [each for each in sets if not any(each < other for other in sets)]
        for shares in largest:
            for inner in _subsets(shares):
                signs = [(shares - inner | more, (-1.0) ** len(more)) for more in _subsets(inner)]
                product = np.zeros((2 * n + 1, (n + 1) * len(sets)))
                for each, sign in signs:
                    at = columns[each]
                    i = np.arange(n)
                    product[i, at + i], product[i, at + n] = sign, -sign * self._low
                    product[n + i, at + i], product[n + i, at + n] = -sign, sign * self._high
                    product[2 * n, at + n] = sign
                rows.append(product)
        return rows

    def _row(self, form: Form, columns: dict[Shares, int]) -> FloatArray:
        n = len(self._low)
        row = np.zeros((n + 1) * len(columns))
        for (shares, j), factor in form.items():
            at = columns[shares]
            if j == ONE:
                row[at + n] += factor
            else:
                row[at : at + n] += factor * self._TP[j]
        return row


class _Model:
    """HiGHS with rows A y >= 0, kept from call to call, so that it begins where it ended."""

    def __init__(self, A: FloatArray) -> None:
        """One row more, for what is held at 1."""
        try:
            highspy = silent_binding()
        except ImportError:
            raise NotRead("needs highspy: pip install 'thrustbench[prove]'") from None
        self.A, (m, n) = A, A.shape
        self._highs = highspy.Highs()
        for name, value in (("output_flag", False), ("threads", 1), ("presolve", "off")):
            self._highs.setOptionValue(name, value)
        lp, matrix = highspy.HighsLp(), csc_matrix(np.vstack([A, np.ones(n)]))
        lp.num_col_, lp.num_row_ = n, m + 1
        lp.col_cost_, lp.col_lower_, lp.col_upper_ = np.zeros(n), np.full(n, -inf), np.full(n, inf)
        lp.row_lower_ = np.array([*np.zeros(m), 1.0])
        lp.row_upper_ = np.array([*np.full(m, inf), 1.0])
        lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
        lp.a_matrix_.num_row_, lp.a_matrix_.num_col_ = m + 1, n
        lp.a_matrix_.start_, lp.a_matrix_.index_ = matrix.indptr, matrix.indices
        lp.a_matrix_.value_ = matrix.data
        self._highs.passModel(lp)
        self._optimal = highspy.HighsModelStatus.kOptimal
        self._columns = np.arange(n, dtype=np.int32)

    def largest(self, objective: FloatArray, below: FloatArray) -> tuple[float, FloatArray] | None:
        """The largest objective . y where below . y = 1, and its multipliers >= 0 of A; None without one."""
        m, n = self.A.shape
        self._highs.changeColsCost(n, self._columns, -objective)
        for j in range(n):
            self._highs.changeCoeff(m, j, float(below[j]))
        self._highs.run()
        if self._highs.getModelStatus() != self._optimal:
            return None
        duals = np.array(self._highs.getSolution().row_dual)
        return -self._highs.getInfo().objective_function_value, np.maximum(duals[:m], 0.0)


def _subsets(shares: Shares) -> list[Shares]:
    ordered = sorted(shares)
    return [
        frozenset(each)
        for each in chain.from_iterable(combinations(ordered, size) for size in range(len(ordered) + 1))
    ]


def _closed(some: Iterable[Shares]) -> list[Shares]:
    """These products, and those of fewer of their shares."""
    found = {NOTHING}
    for shares in set(some):
        found.update(_subsets(shares))
    return sorted(found, key=lambda each: (len(each), sorted(each)))
