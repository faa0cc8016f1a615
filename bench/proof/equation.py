"""The equation of an answer, from the comparisons that let it leave: T f is the wrench that is promised.

Thrusts that leave are y = min(max(p, low), high), or T y is compared with tau. What holds where a call is
answered bounds how far y lies from p; T p is the wrench up to rounding, as sums of products show. Products
are bounded in turn by the thrusts that leave, since these determine them: G tau + N z has as many unknowns as
there are thrusts. So the miss has a bound by |f| alone, for all tau and all limits.
"""

from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np

from alloc import NotApplicable, Status, Vehicle
from alloc.allocation import FloatArray
from alloc.formulations import Part, find_formulation
from alloc.kernels.tolerance import WRENCH_ERROR
from alloc.kernels.walk import EDGE
from alloc.methods import recipe
from alloc.program import Node, Program
from alloc.reach.edge import start
from alloc.reach.way import step_maps
from bench.chips.toolchain import ToolError
from bench.proof.comparisons import Comparisons, Fact
from bench.proof.forms import ONE, UNIT, Form, Product, atom, number, total
from bench.proof.mixture import demand_forms, programs_of_parts
from bench.proof.proof import Claim, Miss, unproved
from bench.proof.source import ANSWERED, NotRead, Subject
from bench.proof.symbolic import programs

EQUATION = (
    "An answer makes its wrench: T f is τ (SOLVED), or what the shares say, but for what SOLVED may miss and"
    " rounding; for all τ and limits with which no operation overflows and no thrust need be drawn in."
)
OVERFLOW = "SOLVED means so where operations overflow, too: what is compared keeps NaN and infinity."
STRONG = " Of weak directions, left out of T and τ, nothing is said."
MIXED = (
    " Where a direction counts in part f and its miss are mixtures, of answers that each make their wrench."
)
BY = "the comparisons that let an answer leave (bench/proof/equation.py)"
WIDER = 1.05
"""Times what SOLVED may miss, what an answer may beside rounding: numbers of the comparison are rounded."""
MANY = 16.0
"""Times (k + n)^2, how many roundings of |T| |f| a wrench may miss besides."""
FARTHEST = 2.0
"""A departure is at most so many times as large as any thrust within the limits: it is the limit nearest to
zero, and as far again."""
CONTRACTS = 0.99
"""Largest spectral radius with which bounds of products by each other end."""
NOTHING = 1e-3
"""An axis that all thrusters push by less than this share of its scale counts as pushed by so much [-]."""
RATIO = 1e3
"""Times its error, a factor that says something of its product."""
INDEPENDENT = 1e-9
"""Singular value, relative to the largest, below which facts leave a product open [-]."""


class Sides(NamedTuple):
    """Facts that bound the misses of one answer.

    Attributes
    ----------
    targets : of each axis the wrench that is made less the one that is promised
    facts : what is known to be small
    sizes : what else bounds products
    parts : factors between 0 and 1
    drops : whether a maximum was trusted to have no operand that is NaN
    lacking : part of the wrench that is missed besides
    """

    targets: list[Form]
    facts: list[Fact]
    sizes: list[Fact]
    parts: frozenset[Node]
    drops: bool
    lacking: float = 0.0


def equation_claims(of: Subject) -> tuple[list[Claim], list[Miss]]:
    """The claims on the equation, without and with overflow, and the bounds of each fault."""
    try:
        return program_claims(programs(of), of)
    except (NotRead, ToolError) as error:
        return [unproved(EQUATION, [str(error)])], []


def program_claims(found: Mapping[int, Program], of: Subject) -> tuple[list[Claim], list[Miss]]:
    """The same of programs that were read, by fault."""
    words, rows, trusting = list[str](), list[Miss](), list[str]()
    for fault, program in found.items():
        try:
            sides, row = _bounds(program, fault, of)
        except (NotRead, NotApplicable) as reason:
            words.append(f"fault {fault}: {reason}")
            continue
        rows.append(row)
        if any(each.drops for each in sides):
            trusting.append(f"fault {fault}: what is compared may have lost NaN")
        if not row.promise <= WIDER:
            words.append(f"fault {fault}: {row.promise:.3g} times what SOLVED may miss")
        if not row.roundings <= MANY * (of.vehicle.k + of.vehicle.n) ** 2:
            words.append(f"fault {fault}: {row.roundings:.3g} roundings of T f")
    way = find_formulation(recipe(of.kernel).formulation).way
    weak = way is not None and any(of.target.with_fault(fault).weak_left.any() for fault in found)
    mixed = find_formulation(recipe(of.kernel).formulation).mixes
    several = any(mixed(of.target.with_fault(fault)) for fault in found)
    equation = EQUATION + STRONG * weak + MIXED * several
    if words:
        claims = [unproved(equation, words)]
    else:
        promise, roundings = max(each.promise for each in rows), max(each.roundings for each in rows)
        least = f"at most {promise:.2g} of what SOLVED may miss, and {roundings:.0f} roundings of |T| |f|"
        claims = [Claim(claim=equation, verdict="shown", by=BY, words=[least])]
    optimal = find_formulation(recipe(of.kernel).formulation).optimal_for(of.vehicle)
    if of.limited and not of.levels and not optimal:  # a rule, which compares T f with tau
        lacking = words or trusting
        beyond = Claim(claim=OVERFLOW, verdict="shown", by=BY)
        claims.append(unproved(OVERFLOW, lacking) if lacking else beyond)
    return claims, rows


def _bounds(program: Program, fault: int, of: Subject) -> tuple[list[Sides], Miss]:
    """Facts on T f and the bounds that they give; of a mixture those of its parts, mixed."""
    whole, formulation = of.target.with_fault(fault), find_formulation(recipe(of.kernel).formulation)
    if not program.size("share"):
        sides = _sides(program, fault, of)
        return sides, miss_bounds(sides, fault, of, program)
    parts, solved, found, rows = formulation.parts(whole), _condition_of_solved(program), [], []
    for part, own in zip(parts, programs_of_parts(program, parts, of.scalar), strict=True):
        sides = _by_shares(own, part, solved, of, fault)
        found += sides
        rows.append(miss_bounds(sides, fault, of, own, part.vehicle))
    weights = -np.diff([*(part.w for part in parts), 0.0])
    sums = weights @ [[row.promise, row.roundings, row.of_tau] for row in rows]
    promise, roundings, of_tau = sums.tolist()
    return found, Miss(fault=fault, promise=promise, roundings=roundings, of_tau=of_tau)


def _sides(program: Program, fault: int, of: Subject) -> list[Sides]:
    """Facts on T f, and where its wrench is another than tau, those on the difference."""
    nodes, vehicle = program.nodes, recipe(of.kernel).subject(of.target.with_fault(fault))
    tau, solved = demand_forms(program, vehicle.k), _condition_of_solved(program)
    off = {program.outputs["f", fault]: Form()} if fault >= 0 else {}  # zero, by the claim on limits
    bounds = Comparisons(program, of.scalar, off, *solved)
    single = {*program.outputs.values(), *(i for i, operation in enumerate(nodes) if operation[0] == "input")}
    sums = [each for each in bounds.sizes if each[0] not in single]
    facts = [Fact(bounds.forms.form(node), bound) for node, bound, _ in sums]
    facts += _cuts(program, bounds, {m for fact in facts for m in fact.form.terms}) if of.limited else []
    shares = [i for i, operation in enumerate(nodes) if operation[0] == "div" and bounds.least(i) > 0.0]
    lacking = 0.0
    for share in shares:  # next to one: what it lacks of that is missed of what is made within limits
        if not _is_part(program, share) or of.limits == "call":
            raise NotRead("a share that may be above 1, or of other limits than the vehicle's")
        lacking = 1.0 / bounds.least(share) - 1.0
        tau = [atom(share) * each for each in tau]
    drops = bounds.drops or any(each for *_, each in sums)
    missed, outputs = _miss_forms(program, bounds, vehicle, tau), _outputs(program, bounds, vehicle.n)
    return [Sides(missed, facts, outputs, frozenset(shares), drops, lacking)]


def _condition_of_solved(program: Program) -> list[Node]:
    """The condition of SOLVED, if there is one; raises NotRead where answers leave in other ways."""
    if any(status in ANSWERED for _, status in program.exits):
        raise NotRead("an answer is returned early")
    solved, partial = ("const", float(Status.SOLVED)), ("const", float(Status.PARTIAL))
    match program.nodes[program.status]:
        case ("const", _):
            return []
        case ("choose", condition, a, b) if (program.nodes[a], program.nodes[b]) == (solved, partial):
            return [condition]
    raise NotRead("a status that is no choice between SOLVED and PARTIAL")


def _by_shares(program: Program, of_part: Part, solved: list[Node], of: Subject, fault: int) -> list[Sides]:
    """The same of an answer with shares, where thrusts did not have to be drawn in."""
    nodes, vehicle, tau = program.nodes, of_part.vehicle, demand_forms(program, of_part.vehicle.k)
    shares, drawn = [program.outputs["share", level] for level in range(program.size("share"))], set[Node]()
    outer = [nodes[each] for each in shares]
    if all(kind == "choose" and nodes[operands[0]][0] == "gt" for kind, *operands in outer):
        drawn, inner = {each[1] for each in outer}, [each[3] for each in outer]
    else:
        inner = shares
    parts = [_part(program, each, EDGE[of.scalar]) for each in inner]
    starts, zeros = _departures(program, vehicle.n) if of.limits == "call" else ({}, [])
    known = {node: atom(node) for node in (*parts, *starts.values())} | dict.fromkeys(zeros, Form())
    known |= {program.outputs["f", fault]: Form()} if fault >= 0 else {}  # by the claim on limits
    bounds = Comparisons(program, of.scalar, known, missing=drawn)
    begin = {i: number(x) for i, x in enumerate(start(vehicle.f_min, vehicle.f_max).tolist())}
    if of.limits == "call":
        begin = {i: atom(node) for i, node in starts.items()}
    maps = step_maps(vehicle, of_part.way.levels)
    w = [total(*((T[i], x) for i, x in begin.items() if T[i])) for T in vehicle.TP.tolist()]
    reached = _way_end(w, tau, maps, [atom(part) for part in parts])
    departures = [Fact(atom(node), row=i, weight=FARTHEST) for i, node in starts.items()]
    sizes = [*_outputs(program, bounds, vehicle.n), *departures]
    end = Comparisons(program, of.scalar, {}, *solved)
    if not all(end.least(each) >= 1.0 for each in shares):
        raise NotRead("SOLVED is not shown to mean that all shares are 1")
    facts = [Fact(end.forms.form(node), bound) for node, bound, _ in end.sizes]
    whole = _way_end(w, tau, maps, [number(1.0)] * len(parts))
    lost = [all_of - wanted for all_of, wanted in zip(whole, tau, strict=True)]
    made = _miss_forms(program, bounds, vehicle, reached)
    found = [Sides(made, _cuts(program, bounds), sizes, frozenset(parts), bounds.drops)]
    if any(each.terms for each in lost) and vehicle.rank == of.target.with_fault(fault).rank:
        found.append(Sides(lost, facts, departures, frozenset(), False))
    return found


def _way_end(w: list[Form], tau: list[Form], maps: FloatArray, parts: list[Form]) -> list[Form]:
    """The wrench behind all levels, from w: each goes a part of D (tau - w)."""
    for part, D in zip(parts, maps, strict=True):
        ahead = [goal - here for goal, here in zip(tau, w, strict=True)]
        steps = [total(*((x, ahead[j]) for j, x in enumerate(row) if x)) for row in D.tolist()]
        w = [here + part * step for here, step in zip(w, steps, strict=True)]
    return w


def _part(program: Program, share: Node, edge: float) -> Node:
    """The part of its step that a level goes, k / max(…, k), of a share that is 1 where that is nearly so."""
    nodes = program.nodes
    match nodes[share]:
        case ("choose", condition, part, one) if nodes[one] == ("const", 1.0) and nodes[part][0] == "div":
            compared, a, b = nodes[condition]
            nearly = nodes[b][0] == "const" and 1.0 - nodes[b][1] <= WIDER * edge
            if (compared, a) == ("lt", part) and nearly and _is_part(program, part):
                return int(part)
    raise NotRead("a share that is no part of a step, rounded")


def _is_part(program: Program, share: Node) -> bool:
    """True for k / max(…, k), which is at most 1: a maximum has its last operand where another is NaN."""
    nodes = program.nodes
    _, above, last = nodes[share]
    while nodes[last][0] == "max":
        last = nodes[last][2]
    return bool(nodes[above][0] == "const" and nodes[above] == nodes[last])


def _departures(program: Program, n: int) -> tuple[dict[int, Node], list[Node]]:
    """Departures z + min(max(z, t), -t), z = min(max(0, f_min), f_max); those that limits make zero."""
    nodes, found, zeros = program.nodes, dict[int, Node](), list[Node]()

    def cut(node: Node) -> tuple[Node, Node, Node] | None:
        match nodes[node]:
            case ("min", inner, high) if nodes[inner][0] == "max":
                return nodes[inner][1], nodes[inner][2], high
        return None

    zero = ("const", 0.0)
    for node, operation in enumerate(nodes):
        near, moved = (cut(each) for each in operation[1:]) if operation[0] == "add" else (None, None)
        if not near or not moved or moved[0] != operation[1] or nodes[moved[2]] != ("neg", moved[1]):
            continue
        middle, *ends = (nodes[each] for each in near)
        for i in range(n):
            if middle == zero and ends == [("input", "f_min", i), ("input", "f_max", i)]:
                found[i] = node
        zeros += [node] if middle == zero and ends == [zero, zero] else []
    return found, zeros


def _miss_forms(program: Program, bounds: Comparisons, vehicle: Vehicle, wrench: list[Form]) -> list[Form]:
    """T f - wrench by axis."""
    f = [bounds.forms.form(program.outputs["f", i]) for i in range(vehicle.n)]
    made = [total(*((x, each) for x, each in zip(row, f, strict=True) if x)) for row in vehicle.TP.tolist()]
    return [each - goal for each, goal in zip(made, wrench, strict=True)]


def _cuts(program: Program, bounds: Comparisons, compared: Collection[Product] = ()) -> list[Fact]:
    """Bounds on what moves thrusts that are not ``compared`` onto limits; raises NotRead where none is."""
    facts = list[Fact]()
    for (array, i), node in program.outputs.items():
        if array != "f" or program.nodes[node][0] == "const":
            continue
        terms = bounds.forms.form(node).terms
        if terms.keys() <= {*compared} and compared:
            continue
        found = bounds.cut(node)
        if found is None and terms:
            raise NotRead(f"f[{i}] is not shown to be moved onto a limit by no more than it may")
        if found is not None:
            facts.append(found)
    return facts


def _outputs(program: Program, bounds: Comparisons, n: int) -> list[Fact]:
    """The thrusts that leave, which bound what they are made of."""
    forms = [bounds.forms.form(program.outputs["f", i]) for i in range(n)]
    return [Fact(form, row=i) for i, form in enumerate(forms) if form.terms]


def miss_bounds(
    sides: list[Sides], fault: int, of: Subject, program: Program, part: Vehicle | None = None
) -> Miss:
    """The bounds of a fault's misses, or of a part's; raises NotRead where there is none."""
    vehicle = part or recipe(of.kernel).subject(of.target.with_fault(fault))
    far, scale, unit = np.maximum(-of.vehicle.f_min, of.vehicle.f_max), vehicle.wrench_scale, UNIT[of.scalar]
    rounded = unit * np.maximum(np.abs(vehicle.TP) @ far, NOTHING * scale)
    promise = roundings = of_tau = 0.0
    for each in sides:
        fixed, by_f, by_tau = _misses(each, program, vehicle)
        made = np.abs(vehicle.TP) @ np.maximum(-vehicle.f_min, vehicle.f_max) + fixed + by_f @ far
        promise += float(((fixed + each.lacking * made) / scale).max()) / WRENCH_ERROR[of.scalar]
        roundings += float((by_f @ far / rounded).max())
        of_tau += float((by_tau @ scale / (unit * scale)).max())
    return Miss(fault=fault, promise=promise, roundings=roundings, of_tau=of_tau)


def _misses(sides: Sides, program: Program, vehicle: Vehicle) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(k,) bounds of the targets, what they grow by with each |f_i|, (k, n), and each |tau_j|, (k, k)."""
    n, k = vehicle.n, vehicle.k
    facts = [fact for fact in sides.facts if _tells(fact.form)]
    forms = [*sides.targets, *(fact.form for fact in facts)]
    asked = {m for form in forms for m in form.products if m != ONE}
    rows = [*facts, *sides.sizes]
    columns = {
        m: j for j, m in enumerate(sorted(asked | {m for row in rows for m in row.form.products} - {ONE}))
    }
    rows += _products(columns, sides)
    R, error = (
        _matrix([row.form.terms for row in rows], columns),
        _matrix([row.form.error for row in rows], columns),
    )
    if _leaves_a_gap(R):  # a direction is lost: what tau asks along it is known from tau only
        entries = {("input", "tau", j): n + j for j in range(k)}
        for m in columns:
            left = [node for node in m if node not in sides.parts]
            if len(left) == 1 and program.nodes[left[0]] in entries:
                rows.append(Fact(Form({m: 1.0}), row=entries[program.nodes[left[0]]]))
        R = _matrix([row.form.terms for row in rows], columns)
        error = _matrix([row.form.error for row in rows], columns)
        if _leaves_a_gap(R):
            raise NotRead("products that the thrusts do not determine")
    fixed = np.array([row.bound + row.form.size.get(ONE, 0.0) for row in rows])
    grows = np.zeros((len(rows), n + k))
    for at, row in enumerate(rows):
        if row.row is not None:
            grows[at, row.row] = row.weight
    # |products| <= P (fixed + grows |f| + error |products|)
    width = np.abs(R).max(axis=0)
    length = np.abs(R / width).max(axis=1)
    P = np.abs(np.linalg.pinv(R / width / length[:, None])) / length / width[:, None]
    again = (P @ error) * (width[:, None] / width)
    if not np.abs(np.linalg.eigvals(again)).max(initial=0.0) < CONTRACTS:
        raise NotRead("rounding of products that bounds of each other do not end")
    again = np.linalg.inv(np.eye(len(columns)) - P @ error)
    most, most_by = again @ P @ fixed, again @ P @ grows
    count = len(facts)
    found = []
    for target in sides.targets:
        (along,) = _matrix([target.terms], columns)
        by = np.linalg.lstsq((R / width / length[:, None])[:count].T, along / width, rcond=INDEPENDENT)[0]
        by = by / length[:count]
        left = np.abs(along - by @ R[:count]) + np.abs(by) @ error[:count]
        left += _matrix([target.error], columns)[0]
        constant = target.constant - sum(x * row.form.constant for x, row in zip(by, rows, strict=False))
        own = sum(
            abs(x) * (row.bound + row.form.error.get(ONE, 0.0)) for x, row in zip(by, rows, strict=False)
        )
        own += target.error.get(ONE, 0.0)
        found.append((abs(constant) + own + left @ most, left @ most_by))
    grown = np.array([each for _, each in found])
    return np.array([each for each, _ in found]), grown[:, :n], grown[:, n:]


def _tells(form: Form) -> bool:
    """True if a form is not all rounding."""
    return any(abs(value) > RATIO * form.error.get(m, 0.0) for m, value in form.terms.items() if m != ONE)


def _matrix(rows: list[Mapping[Product, float]], columns: Mapping[Product, int]) -> FloatArray:
    found = np.zeros((len(rows), len(columns)))
    for at, row in enumerate(rows):
        for m, value in row.items():
            if m != ONE:
                found[at, columns[m]] = value
    return found


def _leaves_a_gap(R: FloatArray) -> bool:
    """True if some combination of products is in no row."""
    if not R.size or not np.abs(R).max(axis=0).all():
        return bool(R.shape[1])
    even = R / np.abs(R).max(axis=0)
    even = even / np.abs(even).max(axis=1, keepdims=True)
    sigma = np.linalg.svd(even, compute_uv=False)
    return bool(len(sigma) < R.shape[1] or sigma[R.shape[1] - 1] <= INDEPENDENT * sigma[0])


def _products(columns: Mapping[Product, int], sides: Sides) -> list[Fact]:
    """Bounds of products with parts, which are at most 1, from those of what they are parts of."""
    alone = {m: fact for fact in sides.sizes for m in fact.form.terms}
    found = list[Fact]()
    for m in columns:
        left = tuple(node for node in m if node not in sides.parts)
        if len(left) < len(m) and not left:
            found.append(Fact(Form({m: 1.0}), 1.0))
        elif len(left) < len(m) and left in alone:
            found.append(alone[left]._replace(form=Form({m: 1.0})))
    return found
