"""Answers of several ways that one program mixes, each as a program of its own (``Formulation.parts``)."""

from collections.abc import Sequence
from dataclasses import replace

from alloc.formulations import Part
from alloc.program import Node, Program, Scalar
from bench.proof.forms import UNIT, Form, atom
from bench.proof.source import NotRead

ROUNDED = 8.0
"""Roundings by which a constant w may differ from the w of the mixture."""


def programs_of_parts(program: Program, parts: Sequence[Part], scalar: Scalar) -> list[Program]:
    """Programs with the thrusts and shares of each part for outputs, in the order of ``parts``.

    An output is x_0 + w_1 (x_1 - x_0) + w_2 (x_2 - x_1) …, of thrusts moved onto limits; raises NotRead for
    anything else.
    """
    if len(parts) == 1:
        return [program]
    each: list[dict[tuple[str, int], Node]] = [{} for _ in parts]
    ws = [part.w for part in parts[1:]]
    for (array, i), node in program.outputs.items():
        if program.nodes[node][0] == "const":  # of a thruster that is off
            found = [node] * len(parts)
        else:
            found = _mixed(program, _unclipped(program, node) if array == "f" else node, ws, scalar)
        for own, part, x in zip(each, parts, found, strict=True):
            own[array, part.level_indices[i] if array == "share" else i] = x
    return [replace(program, outputs=outputs) for outputs in each]


def _unclipped(program: Program, node: Node) -> Node:
    """The thrust that is moved onto limits by min(max(x, low), high)."""
    match program.nodes[node]:
        case ("min", inner, _) if program.nodes[inner][0] == "max":
            return int(program.nodes[inner][1])
    return node


def _mixed(program: Program, node: Node, ws: Sequence[float], scalar: Scalar) -> list[Node]:
    """The nodes x_0, x_1 … of x_0 + w_1 (x_1 - x_0) + w_2 (x_2 - x_1) …."""
    nodes, steps = program.nodes, list[tuple[Node, Node]]()
    for w in reversed(ws):
        match nodes[node]:
            case ("add", before, moved) if nodes[moved][0] == "mul":
                factor, step = sorted(nodes[moved][1:], key=lambda each: nodes[each][0] != "const")
            case _:
                raise NotRead("an output that is no mixture of answers")
        if nodes[factor][0] != "const" or not abs(nodes[factor][1] - w) <= ROUNDED * UNIT[scalar]:
            raise NotRead(f"answers that are mixed by another share than {w:.6g}")
        if nodes[step][0] != "sub":
            raise NotRead("an output that is no mixture of answers")
        steps.append((nodes[step][2], nodes[step][1]))
        node = before
    chain = [node, *(after for _, after in reversed(steps))]
    if any(before != past for (before, _), past in zip(reversed(steps), chain, strict=False)):
        raise NotRead("answers that are mixed with others than the one before")
    return chain


def demand_forms(program: Program, k: int) -> list[Form]:
    """The demand (k,), 0 of entries that nothing reads."""
    entries, nodes = [("input", "tau", j) for j in range(k)], program.nodes
    return [atom(nodes.index(entry)) if entry in nodes else Form() for entry in entries]
