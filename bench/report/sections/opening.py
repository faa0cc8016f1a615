"""Report section: what to take, in a sentence a vehicle, and how sure that is."""

from bench.record.schema import machine_name
from bench.report.pictures import picture
from bench.report.verdict import cut_logs, loop_of, sure, usual, whose_rate
from bench.results.rows import Run
from bench.results.text import plain


def section(run: Run, drawn: frozenset[str]) -> str:
    """The verdicts at the usual control rate, the machine's noise, and the picture of both sides."""
    said = usual(run)
    if not said:
        return ""
    name = machine_name(run.record.header.machine)
    cut = "".join(f" {sentence}" for sentence in cut_logs(run, plain))
    return "\n".join(
        [
            "\n".join(f"- {plain(sentence)}" for sentence in [*said, *whose_rate(run)]) + "\n",
            f"How sure: {plain(name)} was {plain(sure(run))} Another rate than {loop_of(run).rate_hz:g} Hz:"
            f" `thrustbench size DIR --rate HZ`.{cut}\n",
            picture("overview.svg", "what a call costs, and what is lost without limits", drawn),
        ]
    )
