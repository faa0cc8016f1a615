"""Offers of a plug-in beyond the contract (two stages, a bound on steps) are recorded where it has them."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from bench.__main__ import cli
from bench.harness.inputs import plugin_contenders
from bench.harness.plan import RunSettings
from bench.record import Cell, read

PLUGIN = """
from alloc.closed_forms.inverse import generalized_inverse
from alloc.methods.pinv import FORMULATION, build as pinv

class Allocator:
    formulation, limited, tolerance = FORMULATION, False, 1e-9

    def __init__(self, vehicle):
        self.G, self.whole = generalized_inverse(vehicle), pinv(vehicle)
        {offer}

    def __call__(self, tau):
        return self.whole(tau)

def build(vehicle):
    return Allocator(vehicle)
"""
OFFERS = {
    "nothing": "",
    "both": "self.pose, self.solve, self.worst_case_steps = lambda tau: (2 * tau,), self.G.dot, 7",
    "neither": "self.solve, self.worst_case_steps = self.G.dot, None",  # half of two stages, and no bound
}


@pytest.fixture(scope="module")
def cells(tmp_path_factory: pytest.TempPathFactory, bare_runs: None) -> dict[str, Cell]:
    """The cell of each plug-in, by its name."""
    folder = tmp_path_factory.mktemp("offers")
    for name, offer in OFFERS.items():
        (folder / f"{name}.py").write_text(PLUGIN.format(offer=offer))
    plugins = [f"--plugin={folder / name}.py" for name in OFFERS]
    tiny = ["--vehicle=ukwial", "--demands=inactive", "--n=4", "--budget-ms=1", "--repeats=1"]
    run = CliRunner().invoke(cli, ["run", *plugins, *tiny, f"--out={folder}"], standalone_mode=False)
    assert run.return_value == 0, run.output
    return {cell.key.method.replace("-", "_"): cell for cell in read(folder).cells}


@pytest.mark.parametrize("name", OFFERS)
def test_the_second_stage_is_timed_alone_where_a_method_has_both_stages(
    cells: dict[str, Cell], name: str
) -> None:
    assert cells[name].status == "ok", cells[name].reason
    assert bool(cells[name].binding_batches) == (name == "both")


@pytest.mark.parametrize("name", OFFERS)
def test_a_bound_on_steps_is_recorded_where_a_method_has_one(cells: dict[str, Cell], name: str) -> None:
    assert cells[name].worst_case_steps == (7 if name == "both" else None)


def test_what_goes_wrong_with_a_plug_in_is_said_as_a_run_begins_with_its_line(tmp_path: Path) -> None:
    """The run goes on: other methods are measured, and the plug-in's own rows say the same."""
    (tmp_path / "sound.py").write_text("def build(vehicle):\n    return lambda tau: vehicle.f_max\n")
    (tmp_path / "breaks.py").write_text("def build(vehicle):\n\n    return lambda tau: vehicle.thrust\n")
    (tmp_path / "short.py").write_text("def build(vehicle):\n    return lambda tau: [1, 2]\n")
    plugins = tuple(str(tmp_path / f"{name}.py") for name in ("sound", "breaks", "short"))
    settings = RunSettings(demands=(), vehicles=("ukwial",), plugins=plugins)
    sound, breaks, short = (contender.trouble for contender in plugin_contenders(settings))
    assert sound == ""
    assert "breaks.py, on ukwial: failed: line 3: AttributeError: 'Vehicle' object has no attr" in breaks
    assert "short.py, on ukwial: failed: PluginError: the function gave an array of shape (2,)" in short
