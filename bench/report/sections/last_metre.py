"""Report section: what is lost between thrusts and thrusters, for vehicles whose file has ``esc``."""

from bench.record import LastMetre
from bench.report.pictures import picture
from bench.results.rows import Run
from bench.results.text import percent, plain, table, three

INTRODUCTION = """## What the last metre costs

No ESC takes newtons. Each line is a way from thrusts to commands; thrusters make what the vehicle's curve
says. *Missed* is the share of a small demand (so much of what is attainable in its direction) that they do
not make, median and 95 %. *By steps alone* is what the wire's resolution explains of the median: better takes
finer steps. In flight the vehicle keeps station in a current: what is missed, each axis over the length of
its row of T times the largest limit, how far off it is, and how often a thruster starts, stops or turns
round. The linear map knows no curve: neutral is 0 N, the ends are the limits.
"""


def section(run: Run, drawn: frozenset[str]) -> str:
    """A table and a picture for each vehicle with ESCs."""
    parts = []
    for capability in run.record.capabilities:
        if capability.last_metre:
            name = capability.vehicle
            alt = f"{name}: share of small demands that is missed, by the way from thrusts to commands"
            parts += [
                f"### {plain(name)}\n",
                picture(f"last-metre-{name}.svg", alt, drawn),
                _table(capability.last_metre),
            ]
    return "\n".join([INTRODUCTION, *parts]) if parts else ""


def _table(ways: list[LastMetre]) -> str:
    headers = [
        "way",
        *(f"{percent(share)}: missed, 95 %" for share in ways[0].share),
        "in flight: missed",
        "off [m]",
        "starts and turns [1/s]",
    ]
    rows = [
        [
            each.way,
            *(
                f"{percent(p50)}, {percent(p95)}"
                for p50, p95 in zip(each.error_p50, each.error_p95, strict=True)
            ),
            percent(each.missed),
            three(each.off_m),
            three(each.turns_hz),
        ]
        for each in ways
    ]
    steps = ["by steps alone", *(percent(step) for step in ways[-1].step_p50), "", "", ""]
    return table(headers, [*rows, steps])
