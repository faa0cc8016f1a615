"""Check that C is the program that it was printed from: read back, and compared node by node."""

from alloc.program import OWN, Graph, Node, Program, at_fault, operands
from bench.chips.toolchain import ToolError
from bench.proof.proof import Claim, unproved
from bench.proof.source import NotRead, Subject
from bench.proof.symbolic import programs

TRANSLATED = (
    "The C is the program that it was printed from: the same operations on the same operands, the same"
    " returns. What loops over data make is opaque here; their text is the one that is printed."
)


def translated(of: Subject) -> Claim:
    """Claim that the C of a subject does what its method's program says, for every fault."""
    shared = of.target.programs
    made = {
        fault: at_fault(program, fault) if program.faults else program for fault, program in shared.items()
    }
    try:
        read = programs(of)
    except (NotRead, ToolError) as reason:
        return unproved(TRANSLATED, [str(reason)])
    words = [] if made.keys() == read.keys() else [f"faults {sorted(read)}, not {sorted(made)}"]
    for fault in made.keys() & read.keys():
        if text := difference(made[fault], read[fault]):
            words.append(f"fault {fault}: {text}")
    for loop in shared[-1].loops.values():
        if loop.text.replace(OWN, f"{of.name}_") not in of.source:
            words.append(f"the loop {loop.name}: its text is another one")
    if words:
        return unproved(TRANSLATED, words)
    count = sum(len(program.nodes) for program in made.values())
    return Claim(claim=TRANSLATED, verdict="shown", by="the C, read back", words=[f"{count} operations"])


def difference(made: Program, read: Program) -> str:
    """Difference of two programs, in words; empty where there is none."""
    graph = Graph()
    first, second = _Plain(graph, made), _Plain(graph, read)
    if made.outputs.keys() != read.outputs.keys():
        return "other outputs"
    if len(made.exits) != len(read.exits):
        return f"{len(read.exits)} returns from within, not {len(made.exits)}"
    for i, ((a, status), (b, other)) in enumerate(zip(made.exits, read.exits, strict=True)):
        if status != other or first.node(a) != second.node(b):
            return f"return {i} from within"
    for place in sorted(made.outputs):
        if first.node(made.outputs[place]) != second.node(read.outputs[place]):
            return f"{place[0]}[{place[1]}]"
    return "" if first.node(made.status) == second.node(read.status) else "the status"


class _Plain:
    """Nodes of a program in a form that has one way to say a thing: what C spells out is spelled out."""

    def __init__(self, graph: Graph, program: Program) -> None:
        self.graph, self.program = graph, program
        self._known: dict[Node, Node] = {}
        self._opaque = 0

    def node(self, at: Node) -> Node:
        """The plain node; needs of it are looked at without recursion, for programs are deep."""
        waiting = [at]
        while waiting:
            node = waiting[-1]
            operation = self.program.nodes[node]  # a loop's operands are not looked at, it is opaque
            needed = [
                each for each in operands(operation) if each not in self._known and operation[0] != "loop"
            ]
            if needed:
                waiting += reversed(needed)
            else:
                waiting.pop()
                if node not in self._known:
                    self._known[node] = self._made(operation)
        return self._known[at]

    def _made(self, operation: tuple[object, ...]) -> Node:
        add, nodes = self.graph.add, self.graph.nodes
        match operation:
            case ("const", float() | int() as value):
                return add("const", float(value))
            case ("input", *_):
                return add(*operation)
            case ("again", int(inner)):
                return self._known[inner]
            case ("finite", str(array), int(start), int(count)):
                held = add("const", 1.0)
                for i in range(start, start + count):
                    entry = add("input", array, i)
                    held = add("and", held, add("eq", add("sub", entry, entry), add("const", 0.0)))
                return held
            case ("loop" | "unknown", *_):
                self._opaque += 1
                return add("unknown", self._opaque)
            case ("neg", int(a)) if nodes[self._known[a]][0] == "const":
                return add("const", -nodes[self._known[a]][1])
            case ("and", int(a), int(b)):
                return self._all(self._known[a], self._known[b])
            case ("choose", int(c), int(a), int(b)):
                condition, then, other = (self._known[each] for each in (c, a, b))
                if nodes[condition] == ("lt", then, other):
                    return add("min", then, other)
                if nodes[condition] == ("gt", then, other):
                    return add("max", then, other)
                return add("choose", condition, then, other)
            case (str(kind), *needed):
                return add(kind, *(self._known[each] for each in needed if isinstance(each, int)))
        raise AssertionError(operation)

    def _all(self, held: Node, more: Node) -> Node:
        """Both conditions; of a row of conditions it does not matter how they are bracketed."""
        match self.graph.nodes[more]:
            case ("and", a, b):
                return self.graph.add("and", self._all(held, a), b)
        return self.graph.add("and", held, more)
