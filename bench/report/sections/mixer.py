"""Report section on a vehicle's own mixer: its share of what thrusters can do, and where it costs most."""

from bench.record import Capability, MixerCost
from bench.results.rows import Run
from bench.results.text import drop_rounding, percent, plain, rarity, table, wrench_text

MIXER = """## Your autopilot, and the exact answer

ArduSub's factors contain neither positions nor limits; PX4 computes its own from positions, and axes give way
one by one. Where a file has `esc`, outputs of ArduSub push by its curve, unless `thrust: linear` leaves it to
loops. `thrustbench check --autopilot key` lists the reasons; docs/autopilot.md has remedies.
"""


def mixer(run: Run, drawn: frozenset[str]) -> str:
    """A sentence and a table for each vehicle with an autopilot; empty without one."""
    parts = [
        part
        for capability in run.capabilities
        if capability.mixer is not None
        for part in _vehicle(capability, capability.mixer)
    ]
    return "\n".join([MIXER, *parts]) if parts else ""


def _vehicle(capability: Capability, cost: MixerCost) -> list[str]:
    whole = cost.exact_served == cost.n_demands
    exact = (
        f"all {cost.n_demands:,} that were drawn" if whole else percent(cost.exact_served / cost.n_demands)
    )
    return [
        f"{plain(capability.vehicle)}: your autopilot ({plain(cost.frame)}) delivers"
        f" {percent(cost.served / cost.n_demands)} of what your thrusters can do within 1 %. It misses"
        f" {percent(drop_rounding(cost.missed_p50))} of a demand's wrench in the median."
        f" The exact answer (`{cost.exact}`) delivers {exact}. Of {cost.n_demands:,} demands drawn evenly the"
        f" autopilot costs most as follows; {rarity(cost.n_demands)} of all such demands cost more:\n",
        table(
            ["asked", f"{cost.method} makes", "missing"],
            [
                [wrench_text(capability.dof, asked), wrench_text(capability.dof, made), percent(missed)]
                for asked, made, missed in zip(cost.demands, cost.wrenches, cost.missed, strict=True)
            ],
        ),
        *_moves(cost),
    ]


def _body(cost: MixerCost) -> str:
    """The body that is moved, in words."""
    if cost.own_inertia:
        return "this vehicle's inertia and a BlueROV2 Heavy's damping, weight and buoyancy"
    return "a BlueROV2 Heavy's body, for want of 'inertia' in the file,"


def _moves(cost: MixerCost) -> list[str]:
    if not cost.moves:
        return []
    return [
        f"Moves of {cost.move_m:g} m from rest, simulated with {_body(cost)} in still water while a"
        " controller holds the other axes: distance off the line, and turn, of the worse way:\n",
        table(
            [
                "move",
                *(
                    f"{method}, {what}"
                    for what in ("off [m]", "turn [°]")
                    for method in (cost.method, cost.exact)
                ),
            ],
            [
                [one.axis, *(f"{off:.3f}" for off in one.off_m), *(f"{turn:.1f}" for turn in one.turned_deg)]
                for one in cost.moves
            ],
        ),
    ]
