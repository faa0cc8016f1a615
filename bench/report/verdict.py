"""Advice which method to take, in words, and how sure that is on this machine."""

from collections.abc import Callable, Sequence
from itertools import groupby

from alloc.vehicle.geometry import unit
from bench.record import Capability
from bench.results.emulated import IN_WORDS
from bench.results.rows import Run
from bench.results.size import Fit, Loop, Size, best_of_each, possible_first, possible_second, second_size
from bench.results.sizing import find_pauses, sizes
from bench.results.text import cut_note, number_range, percent, three

USUAL = Loop(rate_hz=100.0, budget=0.1)
"""The loop that reports open with: an autopilot's usual rate, a tenth of its period for allocation."""
JITTER = 0.01
"""Share by which the rates of logs that were meant to have one differ, since their clocks do."""
NOISY_SHARE = 0.1
"""Share of disturbed rows above which a machine is called noisy."""


def opening_loop(*runs: Run) -> Loop:
    """The loop that a report opens with: at the rate of the log that a user brought, else ``USUAL``."""
    rate_hz = log_rate_hz(*runs)
    return USUAL if rate_hz is None else Loop(rate_hz, USUAL.budget)


def log_rate_hz(*runs: Run) -> float | None:
    """The rate of the log that a user brought [Hz], the fastest of several; None without one."""
    return max((rate for *_, rate in _rates(runs)), default=None)


def rate_note(*runs: Run) -> list[str]:
    """A sentence on the log whose rate is taken, where others have another; else none."""
    rates, taken = _rates(runs), log_rate_hz(*runs)
    fastest = [f"{log} of {vehicle}" for log, vehicle, rate in rates if rate == taken]
    slower = [
        f"{log} of {vehicle} has {rate:g} Hz"
        for log, vehicle, rate in rates
        if taken is not None and rate < (1 - JITTER) * taken
    ]
    if not slower:
        return []
    return [f"The rate is that of the fastest log, {fastest[0]}, for every vehicle. {'. '.join(slower)}."]


def _rates(runs: Sequence[Run]) -> list[tuple[str, str, float]]:
    """Log, vehicle and rate [Hz] of each log with a rate that a user brought, sorted."""
    problems = [p for run in runs for p in run.record.problems if p.given]
    # Times are rounded: 50 Hz, not 50.00000001.
    return sorted({(p.demands, p.vehicle, float(f"{p.rate_hz:.6g}")) for p in problems if p.rate_hz})


def verdicts(sized: Sequence[Size], loop: Loop, where: str = "") -> list[str]:
    """A line for each vehicle, or several with the same: what to take, why, and what would do too.

    ``sized`` has the one to take first, as ``sizes`` sorts it; ``where`` names the machines, if need be.
    """
    alike: dict[str, list[str]] = {}
    for vehicle, own in groupby(sized, key=lambda size: size.vehicle):
        alike.setdefault(verdict(list(own), loop), []).append(vehicle)
    return [f"{', '.join(names)} at {loop.rate_hz:g} Hz{where}: {said}" for said, names in alike.items()]


def verdict(own: Sequence[Size], loop: Loop) -> str:
    """Method to take on one vehicle, without the vehicle's name."""
    first = own[0]
    if first.fit > Fit.MAY_FIT:
        times = [size.p50_us for size in own if size.p50_us is not None and size.fit == Fit.DOES_NOT_FIT]
        why = (
            f"the fastest median is {percent(min(times) / loop.period_us)} of the period"
            if times
            else "none has a time that counts"
        )
        return f"nothing here fits {percent(loop.limit_share)} of the period; {why}."
    part = f"; {first.part}" if first.part else ""
    if first.refused >= 1:
        return f"nothing to take{part}. {spoken_name(first)} refuses {first.refusal}."
    sentences = [f"take {spoken_name(first)}; {_worth(first, own)}{part}"]
    share = f"It takes {_small((first.p50_us or 0.0) / loop.period_us)} of the period"
    if first.fit == Fit.WITHOUT_TAIL:
        share += f", its tail not shown to fit ({first.reason})"
    if first.fit == Fit.MAY_FIT:
        share += f", which may fit ({first.reason})"
    sentences.append(share)
    if first.unlimited:
        sentences.append("It knows no limits")
    if first.refusal:
        sentences.append(f"It refuses {first.refusal}")
    if not first.exact:
        sentences.append(_why_not_exact(own))
    if refusing := _refusing(first, own):
        sentences.append(f"{spoken_name(refusing)} refuses {refusing.refusal}")
    if first.freedom == 0:
        sentences.append("No spare thruster: each wrench has one solution")
    if rival := possible_first(own, loop):
        sentences.append(f"Not decided by so few: {spoken_name(rival)} may come first")
    if other := second_size(own):
        text = f"{spoken_name(other)} would do too"
        if not rival and (instead := possible_second(own, loop)):
            text += f", or {spoken_name(instead)}: not decided by so few"
        sentences.append(text)
    return f"{'. '.join(sentences)}."


def _worth(first: Size, own: Sequence[Size]) -> str:
    """Worth of the chosen method's answers."""
    exactness = "exact" if first.exact else "not exact"
    answers_all = not first.refusal and not first.gap and any(size.gap for size in own)
    return f"{exactness}, answers every demand" if answers_all else exactness


def _refusing(first: Size, own: Sequence[Size]) -> Size | None:
    """An exact-or-refuse method whose refusals are of demands that can't be met.

    None where another such method answers all that the first does: who refuses more has given up.
    """
    picky = [size for size in own if size.picky]
    more = all((size.gap, size.refused) > (first.gap, first.refused) for size in picky)
    return picky[0] if picky and more else None


def spoken_name(size: Size) -> str:
    """A method as one says its name: generated C by its twin's."""
    call = " with --limits call" if size.moving else ""  # of codegen: the limits of each call are arguments
    return f"{size.twin} as generated C{call}" if size.twin else size.label


def trust_note(run: Run) -> str:
    """Trust that the machine allows: how much of the run it disturbed, and how long it paused."""
    word = "noisy" if run.disturbed > NOISY_SHARE * len(run.measured) else "quiet"
    text = f"{word}: {run.disturbed} of {len(run.measured)} rows disturbed"
    if run.by_driver:
        scalar = run.form["scalar"]
        text = f"timed by its driver in {IN_WORDS.get(scalar, f'{scalar} precision')},"
        text += " which can't see what else ran there"
    if run.disturbances:
        text += f" ({', '.join(what for what, _ in run.disturbances.most_common())})"
    if run.by_driver and (lost := run.record.header.settings.get("missing")):
        more = f" and {len(lost) - 1} more" if len(lost) > 1 else ""
        text += f". Its log is not whole: left out are {lost[0]}{more}"
    seen = find_pauses(run)
    if seen.excess:
        longest = three(seen.excess[-1][0] / 1000)
        text += f". Fixed work paused for up to {longest} µs, so slowest calls within that are the machine's"
    return f"{text}."


def cut_log_notes(run: Run, write: Callable[[str], str] = str) -> list[str]:
    """A sentence for each log that was not asked whole; ``write`` makes a name harmless where it stands."""
    logs = (p for p in run.record.problems if p.left_out and p.given)
    return sorted({cut_note(write(p.demands), p.n_demands, p.left_out) for p in logs})


def opening_sizes(run: Run) -> list[Size]:
    """Best size of each method at ``opening_loop``, without degraded vehicles and a study's."""
    return [size for size in best_of_each(sizes(run, opening_loop(run))) if size.vehicle in run.vehicles]


def first_methods(sized: Sequence[Size]) -> dict[str, str]:
    """Method to take first by vehicle."""
    return {size.vehicle: size.method for size in reversed(sized)}


def usual_verdicts(run: Run) -> list[str]:
    """Verdicts on ``opening_sizes``."""
    return verdicts(opening_sizes(run), opening_loop(run))


def _why_not_exact(own: Sequence[Size]) -> str:
    refusing = [size for size in own if size.exact and size.refused and size.fit <= Fit.MAY_FIT]
    if refusing:
        return f"{spoken_name(refusing[0])} is exact but refuses some demands"
    late = [size for size in own if size.exact and size.fit == Fit.DOES_NOT_FIT]
    return f"{late[0].label} is exact but too slow" if late else "No exact method was measured"


def _small(share: float) -> str:
    return "under 0.01 %" if share < 1e-4 else percent(share)


def weak_words(run: Run, vehicle: str) -> str:
    """Directions of a vehicle that are weak or count in part: ``pitch (0.5 % left)``; empty without any."""
    problem = run.problems.get(vehicle)
    return " and ".join(problem.weak) if problem else ""


def way_in_notes(run: Run) -> list[str]:
    """A sentence for each library or program of a user's: the part of a call's time that is the way to it."""
    times: dict[str, list[float]] = {}
    for row in run.rows:
        if row.way_in_p50_us is not None:
            times.setdefault(row.method, []).append(row.way_in_p50_us)
    return [f"{name}: the way in takes {number_range(own)} µs of a call." for name, own in times.items()]


SETS_OF_RANK = ("a point", "a line", "a plane")
"""Names of attainable sets of rank 0, 1 and 2."""


def name_of_state(capability: Capability, fault: int | None) -> str:
    """The thruster that is off, by its name where it has one; ``none`` for the whole vehicle."""
    if fault is None:
        return "none"
    return (capability.names[fault] if fault < len(capability.names) else "") or str(fault)


def flat_sets(capability: Capability) -> list[tuple[str, str]]:
    """Attainable sets of fewer dimensions than the vehicle has axes, and when: ``without thruster 2``.

    Both are in words; the latter is empty where no thruster need be off.
    """
    states = {a.fault: a.rank for a in capability.authority}
    found = []
    for rank in sorted({rank for rank in states.values() if rank < len(capability.dof)}):
        off = [fault for fault, own in states.items() if own == rank]
        names = " or ".join(name_of_state(capability, fault) for fault in off)
        which = "any one thruster" if len(off) == len(states) - 1 > 1 else f"thruster {names}"
        what = SETS_OF_RANK[rank] if rank < len(SETS_OF_RANK) else f"a set of {rank} dimensions"
        found.append((what, "" if None in off else f"without {which}"))
    return found


def rank_notes(run: Run) -> list[str]:
    """A sentence for each vehicle and rank below its number of axes: of what shares served are shares."""
    known = [(name, capability) for name in run.vehicles if (capability := run.capability(name))]
    return [
        f"{name}: {f'shares served {when}'.rstrip()} are shares of {what}: no more can be pushed."
        for name, capability in known
        for what, when in flat_sets(capability)
    ]


def weak_notes(run: Run) -> list[str]:
    """A sentence for each vehicle with weak directions: which, and the costliest axis by method."""
    notes = []
    for vehicle in run.vehicles:
        words, capability = weak_words(run, vehicle), run.capability(vehicle)
        if not words:
            continue
        note = f"{vehicle}: weak: {words}"
        if capability and capability.weak_costs:
            worst = min(capability.weak_costs, key=lambda cost: cost.hard_most / cost.demand)
            each = ". ".join(f"{method} {worst.words(method, unit(worst.axis))}" for method in worst.wrench)
            note += f". Of {worst.axis} {worst.demand:.3g} {unit(worst.axis)}: {each}"
        notes.append(f"{note}.")
    return notes


def fuse_notes(run: Run) -> list[str]:
    """A sentence for each vehicle with a cap: the share of the largest that each way to keep it delivers."""
    notes = []
    for vehicle in run.vehicles:
        capability = run.capability(vehicle)
        if capability is None or (cost := capability.fuse) is None:
            continue
        each = "; ".join(f"{way.way} {percent(way.share_p50)}" for way in cost.ways[1:])
        notes.append(
            f"{vehicle}: the cap leaves {three(cost.amps)} A of {three(cost.most)} A. Delivered, over the"
            f" largest share there is, medians: {each}."
        )
    return notes
