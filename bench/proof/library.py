"""libthrustbench, everything that can be shown of it: for all vehicles that it has room for.

Any calls are asked in any order, with any bits in their arguments.
Between calls an allocator is nothing but numbers and indices. Three analyses begin with any numbers and any
indices that lie within their arrays: calls that answer, functions that prepare, and the search for facets,
which stands apart since it would take minutes among them. Those that write an allocator must leave such
indices behind. It has room for one direction that counts in part: two allocators.

Numbers are volatile in the C that is analysed: each read gives any bits, more than any call can see. EVA 25
needs that: under ``-lib-entry`` numbers of globals are finite to it, and where a comparison leaves an entry
of an array nothing but NaN it takes what follows for unreachable.
"""

import re
import shutil
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from hashlib import sha256
from os import cpu_count
from pathlib import Path

from alloc import Vehicle, library
from alloc.library import calls
from alloc.program import Scalar
from bench.harness import machine
from bench.proof import tools
from bench.proof.proof import ASSUMPTIONS, Claim, Proof, unproved
from bench.proof.safety import eva
from bench.proof.safety.harness import MAIN

FACETS_IN = "tb_facets.c"
INDICES = {
    "k": (0, "TB_K_MAX"), "n": (0, "TB_N_MAX"), "m": (-1, "TB_N_MAX"), "rank": (0, "TB_K_MAX"),
    "blocks": (0, "TB_N_MAX"), "facets": (-1, "TB_FACETS_MAX"), "levels": (0, "TB_K_MAX"),
    "parts": (0, "ROOM"),
}  # fmt: skip
TABLES = {
    "level[i]": ("TB_K_MAX", "TB_K_MAX - 1"), "at[i]": ("TB_N_MAX", "TB_N_MAX - 1"),
    "d[i]": ("TB_N_MAX", "TB_N_MAX"), "begin[i]": ("TB_N_MAX + 1", "TB_N_MAX"),
    "astern[i]": ("TB_N_MAX", "TB_N_MAX"), "facet[i].end": ("TB_FACETS_MAX", "TB_ENTRIES_MAX"),
    "of[i]": ("TB_ENTRIES_MAX", "2 * TB_N_MAX - 1"),
}  # fmt: skip
"""Indices of an allocator, with the least and the most; tables of indices from 0, with length and most."""

NO_ERROR = (
    "{0}: no run-time error: no access outside of an array, no overflow of an integer, no shift too far, for"
    " all bits of the arguments, whatever stands in memory that was never written."
)
STATUS = "The status of each call is one that the header names."
KEPT = "What prepares an allocator leaves indices that lie within its arrays, so that any call may follow."
PREPARING = ("tb_prepare", "tb_without", "tb_strong", "tb_levels")
ANSWERS = (
    "On random vehicles, failures and demands thrusts lie inside the limits, SOLVED makes tau, shares make"
    " what they say, and NaN is refused."
)
DEFINED = "No decision of these calls depends on memory that was never written."


def prove_library(
    scalar: Scalar = "double", vehicle: Vehicle | None = None, say: Callable[[str], None] = lambda _: None
) -> tuple[Proof, dict[str, str]]:
    """The proof of the library with room for a vehicle (None: its usual room), and the C that it is about.

    Raises NotInstalled where Frama-C is missing. ``say`` is told what is looked at next.
    """
    begin = time.perf_counter()
    n_max, k_max = library.room(vehicle)
    made = library.files(scalar, n_max, k_max)
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        say("memory, status and indices, a minute or more")
        shown = library_claims(made, n_max, Path(folder))
        numbers = list[Claim]()
        if all(claim.verdict == "shown" for claim in shown):  # C that may write anywhere is not run
            say("answers on random vehicles")
            test = library.selftest()
            answers, memory = _tried({**made, **test}, Path(folder) / "tried")
            shown.append(answers)
            numbers.append(memory)
    proof = Proof(
        vehicle=f"every vehicle of up to {n_max} thrusters and {k_max} axes",
        method="The library",
        scalar=scalar,
        limits="call",
        function=library.NAME,
        files=sorted(made),
        sha256=sha256("".join(made[name] for name in sorted(made)).encode()).hexdigest(),
        thrustbench=machine.commit(),
        tools={"frama-c": tools.version("frama-c")},
        assumptions=ASSUMPTIONS,
        claims=shown,
        numbers=numbers,
        seconds=round(time.perf_counter() - begin, 1),
    )
    return proof, made


def _tried(files: Mapping[str, str], folder: Path) -> tuple[Claim, Claim]:
    """Output of the self-test, and of Valgrind while it runs."""
    passed, said = tools.tried(files, folder)
    if not passed:
        return unproved(ANSWERS, said), unproved(DEFINED, ["the self-test fails"])
    answers = Claim(claim=ANSWERS, verdict="tested", by="the self-test", words=said[:1])
    if not shutil.which("valgrind"):
        return answers, unproved(DEFINED, ["needs valgrind: apt-get install valgrind"])
    watched = tools.run(["sh", "-c", "valgrind -q --error-exitcode=9 ./tried && echo passed"], folder).split(
        "\n"
    )
    if "passed" not in watched:
        return answers, unproved(DEFINED, watched)
    return answers, Claim(claim=DEFINED, verdict="tested", by="Valgrind, the self-test", words=watched[:1])


def library_claims(made: Mapping[str, str], n_max: int, folder: Path) -> list[Claim]:
    """The claims about this C (``alloc.library.files``); raises NotInstalled without Frama-C."""
    tools.need("frama-c")
    unroll = ("-eva-min-loop-unroll", str(n_max + 1))
    asked = {
        "answers": (_answers(), unroll),
        "prepares": (_prepares(), unroll),
        "facets": (_facets(), ("-eva-auto-loop-unroll", str(n_max + 1))),
    }
    with ThreadPoolExecutor(cpu_count()) as pool:
        made_of = pool.map(lambda name: _analysis(made, name, *asked[name], folder), asked)
        found = dict(zip(asked, made_of, strict=True))
    shown = [
        eva.claim(NO_ERROR.format(who), found[name], *found[name].alarms("status", "kept"))
        for name, who in (
            ("answers", ", ".join(f"tb_{method}" for method in calls())),
            ("prepares", ", ".join(PREPARING)),
            ("facets", "the search for facets"),
        )
    ]
    kept = [eva.claim(KEPT, found[name], "kept") for name in ("prepares", "facets")]
    worst = max(kept, key=lambda claim: claim.verdict == "not shown")
    return [*shown, eva.claim(STATUS, found["answers"], "status"), worst]


ANY_MEMORY = ("-lib-entry", "-eva-initialized-locals")
"""Memory holds any integers: an allocator, arguments, and what a function has not yet written."""
LOCAL = re.compile(r"^ +(?:const )?(?:tb_real|struct) [^();]*;", re.MULTILINE)


def _analysis(
    made: Mapping[str, str], name: str, main: str, options: tuple[str, ...], folder: Path
) -> eva.Analysis:
    place = folder / name
    place.mkdir()
    sources = [each for each in made if each.endswith(".c") and (name, each) != ("prepares", FACETS_IN)]
    made = {file: _volatile(text) for file, text in made.items()}
    included = "".join(f'#include "{source}"\n' for source in sorted(sources))
    return eva.analyse({**made, MAIN: included + main}, place, options=(*eva.ALWAYS, *ANY_MEMORY, *options))


def _volatile(text: str) -> str:
    """The C with volatile numbers, and locals that begin with any bits: EVA would ask who wrote them."""
    text = re.sub(r"typedef (?=\w+ tb_real;)", r"\g<0>volatile ", text)
    parts = re.split(r"(struct \w+ \{[^}]*\};)", text)
    for i, part in enumerate(parts):
        if i % 2:
            name = part.split()[1]
            parts[i] = f"{part} extern volatile struct {name} any_{name};"
        else:
            parts[i] = LOCAL.sub(_begun, part)
    return "".join(parts)


def _begun(found: re.Match[str]) -> str:
    """A declaration of locals in which all have a value; of numbers none counts."""
    text = re.sub(r"struct (\w+) (\w+);", r"struct \1 \2 = any_\1;", found[0])
    return re.sub(r"((?:tb_real|,) [a-zA-Z]\w*(?:\[[^]]*\])*)(?=[,;])", r"\1 = {0}", text)


def _every(statement: str, names: Iterable[str]) -> str:
    """The statement for these indices, whose place, least and most stand in braces."""
    lines = []
    for name in names:
        if name in INDICES:
            low, high = INDICES[name]
            lines += [f"    {statement.format(f'a[{p}].{name}', low, high)}" for p in range(2)]
        else:
            size, high = TABLES[name]
            each = [f"        {statement.format(f'a[{p}].{name}', 0, high)}" for p in range(2)]
            lines += [
                f"    /*@ loop unroll {size}; */\n    for (int i = 0; i < {size}; i++) {{",
                *each,
                "    }",
            ]
    return "\n".join(lines) + "\n"


ALL = (*INDICES, *TABLES)
ANY = _every("{0} = between({1}, {2});", ALL)
HELD = _every("/*@ assert kept: {1} <= {0} <= {2}; */", ALL)
HEAD = """
extern volatile int any;
extern volatile unsigned long any_mask;
#define ROOM 1
struct tb_allocator a[1 + ROOM];
tb_real tau[TB_K_MAX], f_min[TB_N_MAX], f_max[TB_N_MAX], f[TB_N_MAX], share[TB_K_MAX];
tb_real T[TB_K_MAX * TB_N_MAX], H[TB_N_MAX * TB_N_MAX], readiness[TB_N_MAX];
tb_real poses[6 * TB_N_MAX];
int level[TB_K_MAX], axis[TB_K_MAX];

static int between(int least, int most)
{
    const int x = any;
    return x < least || x > most ? least : x;
}
"""


def _main(body: str, before: str = "") -> str:
    return f"{HEAD}{before}\nint main(void)\n{{\n    int status = 0;\n{ANY}{body}    return status;\n}}\n"


def _answers() -> str:
    cases = "\n".join(
        f"    case {i}: status = tb_{method}(a, tau, low, high, f{', share' * shares}); break;"
        for i, (method, shares) in enumerate(calls().items())
    )
    return _main(f"""\
    const tb_real *low = any ? f_min : NULL, *high = any ? f_max : NULL;
    switch (any) {{
{cases}
    default: break;
    }}
    /*@ assert status: -3 <= status <= 3; */
""")


def _prepares() -> str:
    """Facets are any that the analysis beside this one finds them to be."""
    facets = f"""
void tb_find_facets(struct tb_allocator *made, tb_real doubt)
{{
    (void)made;
    (void)doubt;
{HELD}{_every("{0} = between({1}, {2});", ("facets", "facet[i].end", "of[i]"))}}}
"""
    given = ", ".join(f"any ? {name} : NULL" for name in ("T", "H", "readiness", "f_min", "f_max"))
    return _main(
        f"""\
    const struct tb_survey survey = {{any ? T : NULL, any ? poses : NULL, any ? axis : NULL,
                                     tau[0], tau[0], tau[0], tau[0], between(-1, ROOM)}};
    switch (any) {{
    case 0: status = tb_prepare(a, any, any, {given}); break;
    case 1: status = tb_without(a, any_mask); break;
    case 2: status = tb_strong(a, any_mask, any ? &survey : NULL); break;
    default: status = tb_levels(a, level);
    }}
{HELD}""",
        facets,
    )


def _facets() -> str:
    """Bounds of loops that go over facets are told, or intervals would grow past them."""
    told = '    /*@ widen_hints global:"all", TB_FACETS_MAX, TB_ENTRIES_MAX, TB_N_MAX, 2 * TB_N_MAX; */\n'
    return _main(f"{told}    tb_find_facets(a, tau[0]);\n{HELD}")
