"""Values that are linear in tau, each term perhaps times shares: sums of factors times atoms.

What rounding adds to a value is an unknown of its own, so that it cancels where the value does.
"""

from alloc.program import Node

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


def shares_of(form: Form) -> Shares:
    """All shares of a form."""
    return NOTHING.union(*(shares for shares, _ in form))


def has_tau(form: Form) -> bool:
    """True if tau stands in a form."""
    return any(j > ONE for _, j in form)
