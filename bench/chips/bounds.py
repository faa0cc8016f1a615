"""The most instructions that a compiled kernel can take, and the least that an exact method must.

A disassembly is a graph: an instruction leads to the next one, to where it jumps, or out. Straight code has
no cycle, so its longest way is found in one pass; a loop counts all its instructions as often as it may go
round. Where a way through the graph can't be taken this is too much; never too little.
"""

import re
from collections.abc import Callable
from graphlib import TopologicalSorter

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from alloc import NotApplicable, Vehicle
from alloc.discovery import find
from alloc.formulations import Family, find_formulation
from alloc.reach.edge import edge
from bench.chips.image import Image
from bench.chips.instructions import Disassembled, lines
from bench.chips.kernels import Kernel
from bench.chips.toolchain import run

RETURNS = re.compile(r"ret\w* |bx lr|(pop|ldmia)(\.w)? .*\bpc\}|ldr(\.w)? pc, \[sp\]")
"""Instructions that return: mnemonic and operands; loading the program counter is Thumb's other way."""
ALWAYS = {"b", "b.n", "b.w", "jmp"}
TABLE = {"tbb", "tbh", "br", "notrack"}
CALLS = {"bl", "blx", "blr", "call", "callq"}
CONDITION = r"(eq|ne|cs|cc|hs|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le)"
SOME = re.compile(rf"b\.?{CONDITION}(\.[nw])?$|cbn?z$|tbn?z$|j\w+$")
JUMP = re.compile(r"\t([bj][\w.]*|cbn?z|tbn?z|callq?)\s")
LIBRARY = ("memcpy", "memset")
"""Functions that compilers call to fill an array of a number for each thruster."""
WORD = 8
"""Bytes of such a number: these loops go over bytes, if not over more at a time."""
CONDITIONAL_RETURN = re.compile(rf"(bx|pop|ldmia){CONDITION}(\.w)?$")


class Unbounded(Exception):
    """A loop or a call whose length is not known; the message names it."""


def disassembled(image: Image) -> str:
    """Disassembly of a kernel, and of all functions that it calls or jumps into."""
    printed: dict[str, str] = {}
    waiting = [image.kernel.entry]
    command = [f"{image.processor.tools}objdump", "-d", "--no-show-raw-insn"]
    while waiting:
        name = waiting.pop()
        if name not in printed:
            printed[name] = run([*command, f"--disassemble={name}", str(image.path)])
            lines = (line for line in printed[name].splitlines() if JUMP.search(line))
            waiting += {
                found for line in lines for found in re.findall(r"<([^>+]+)(?:\+0x[0-9a-f]+)?>$", line)
            }
    return "\n".join(printed.values())


def bound(image: Image, k: int, n: int) -> int:
    """Most instructions of any call to the kernel of an image, for a vehicle of k axes and n thrusters.

    Raises Unbounded where a call's length is not known.
    """
    # All loops go over axes or thrusters, and look once more to end.
    return longest(disassembled(image), image.entry, max(k, n) + 1)


def longest(disassembly: str, entry: int, rounds: int) -> int:
    """Most instructions of any call to ``entry``, if no loop goes round more often than ``rounds``.

    Raises Unbounded where a call's length is not known.
    """
    code = {one.address: one for one in lines(disassembly) if one.mnemonic[0] != "."}
    found: dict[int, int] = {}
    begun: set[int] = set()

    def length(entry: int) -> int:
        if entry not in code:
            raise Unbounded(f"a call to {entry:#x}, where no code is")
        if entry not in found:
            if entry in begun:
                raise Unbounded(f"{code[entry].function} calls itself")
            begun.add(entry)
            most = rounds * WORD if code[entry].function in LIBRARY else rounds
            found.update(_longest(code, entry, most, length))
        return found[entry]

    return length(entry)


def _successors(code: dict[int, Disassembled], entry: int) -> dict[int, list[int]]:
    """All instructions that follow each one that the entry leads to; none behind a return."""
    direct = {at: _next(instruction) for at, instruction in code.items()}
    reached: dict[int, list[int]] = {}
    waiting = [entry]
    while waiting:
        at = waiting.pop()
        if at in reached or at not in code:
            continue
        leads = direct[at]
        reached[at] = _table_targets(code, direct, code[at].function) if leads is None else leads
        waiting += reached[at]
    return reached


def _next(instruction: Disassembled) -> list[int] | None:
    """Target of an instruction; None for a jump by a table."""
    mnemonic, operands = instruction.mnemonic, instruction.operands
    after = [] if instruction.last else [instruction.following]
    target = re.search(r"([0-9a-f]+) <", operands) or re.search(r"(?:^|, )([0-9a-f]+)$", operands)
    if mnemonic in TABLE or (mnemonic == "jmp" and "*" in operands):
        return None
    if mnemonic in ALWAYS and target:
        return [int(target[1], 16)]
    if re.match(r"(bx r|\w+(\.w)? pc,)", f"{mnemonic} {operands}") and "[sp]" not in operands:
        return None
    if CONDITIONAL_RETURN.match(mnemonic):
        return after
    if RETURNS.match(f"{mnemonic} {operands}"):
        return []
    if SOME.match(mnemonic) and target:
        return [*after, int(target[1], 16)]
    return after


def _table_targets(
    code: dict[int, Disassembled], direct: dict[int, list[int] | None], function: str
) -> list[int]:
    """Targets of a table: addresses that nothing else in the function leads to."""
    own = {at for at, instruction in code.items() if instruction.function == function}
    padding = {at for at in own if code[at].mnemonic.startswith("nop")}
    led = {to for at, leads in direct.items() for to in leads or [] if at not in padding}
    return sorted(own - led - padding - {min(own)})


def _longest(
    code: dict[int, Disassembled], entry: int, rounds: int, length: Callable[[int], int]
) -> dict[int, int]:
    graph = _successors(code, entry)

    def cost(at: int) -> int:
        if code[at].mnemonic not in CALLS:
            return 1
        target = re.search(r"([0-9a-f]+) <", code[at].operands)
        if not target:
            raise Unbounded(f"a call by pointer in {code[at].function}")
        return 1 + length(int(target[1], 16))

    best: dict[int, int] = {}
    for component in _components(graph):  # what a component leads to comes before it
        inside = set(component)
        out = max(
            (best[to] for at in component for to in graph[at] if to in best and to not in inside), default=0
        )
        total = _rounds(graph, inside, rounds, cost) + out
        best |= dict.fromkeys(component, total)
    return best


def _rounds(graph: dict[int, list[int]], inside: set[int], rounds: int, cost: Callable[[int], int]) -> int:
    """Most instructions in a component: of a loop all its rounds, of a loop in a loop those of each."""
    only = next(iter(inside))
    if len(inside) == 1 and only not in graph[only]:
        return cost(only)
    entered = {to for at, leads in graph.items() if at not in inside for to in leads if to in inside}
    head = min(entered or inside)
    round_ = {at: [to for to in graph[at] if to in inside and to != head] for at in inside}
    best: dict[int, int] = {}
    for component in _components(round_):
        after = max((best[to] for at in component for to in round_[at] if to in best), default=0)
        best |= dict.fromkeys(component, _rounds(round_, set(component), rounds, cost) + after)
    return rounds * max(best.values())


def _components(graph: dict[int, list[int]]) -> list[list[int]]:
    """Strongly connected components, each after all that it leads to."""
    at = {address: i for i, address in enumerate(graph)}
    edges = [(at[address], at[to]) for address, leads in graph.items() for to in leads if to in at]
    size, ends = len(graph), np.array(edges, dtype=np.intp).reshape(-1, 2).T
    ties = csr_array((np.ones(len(edges)), (ends[0], ends[1])), shape=(size, size))
    count, component = connected_components(ties, connection="strong")
    leads_to: dict[int, set[int]] = {i: set() for i in range(count)}
    for one, other in component[ends].T.tolist():
        if one != other:
            leads_to[one].add(other)
    members: list[list[int]] = [[] for _ in range(count)]
    for address, i in zip(graph, component.tolist(), strict=True):
        members[i].append(address)
    return [members[i] for i in TopologicalSorter(leads_to).static_order()]


def least_instructions(kernel: Kernel, vehicle: Vehicle) -> int | None:
    """Instructions that none may leave out: reads, writes, a comparison a facet; None if not exact.

    Every input is read (k, with limits of the call 2 n more), every thrust of a working thruster written,
    and made by an operation of its own. Of each pair of opposite facets of the attainable set it must be
    known whether the demand lies beyond: one comparison, and an operation that makes what is compared unless
    it is an input. A method that finds its facets in a table of regions would compare fewer; none here does.
    """
    if find_formulation(find(kernel.twin).formulation).family is not Family.EXACT:
        return None
    try:
        normals = edge(vehicle).normals
    except NotApplicable:  # the vehicle has too many facets to find them
        return None
    n = len(vehicle.working)
    made = np.count_nonzero(np.count_nonzero(normals, axis=1) > 1)
    return int(kernel.width + 2 * n + len(normals) + made)
