"""A study file makes the layouts it says, or is refused with one line that names file, line and key."""

import re
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from alloc import AllocError
from alloc.reach.zonotope import zonotope
from alloc.vehicle.file import build_vehicle, find_file, read_document
from bench.commands.layouts import command
from bench.fleet import cluster
from bench.layouts.measure import measure, numbers
from bench.layouts.report import vehicle_file
from bench.layouts.run import check_constraints, count_layouts
from bench.layouts.space import poses
from bench.layouts.spaces import single_layout
from bench.layouts.study import read_study
from tests.layout_studies import HEAVY, PLANAR, compiled
from tests.vehicle_files import GOOD

ASKED = "demands: {n: 16}"
ROS = "force.x,force.y,torque.z\n10,20,3\n"
"""A demand in columns that are named as ROS names them."""


def refusal(folder: Path, text: str) -> str:
    """The one line with which a study is refused."""
    path = folder / "study.yaml"
    with pytest.raises(AllocError) as refused:
        checked(folder, text)
    message = str(refused.value)
    assert "\n" not in message
    return message.removeprefix(f"{path}: ")


def checked(folder: Path, text: str) -> None:
    """Read a study and try its constraints."""
    space, _ = compiled(folder, text)
    check_constraints(space, read_study(folder / "study.yaml").keys, 4096)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (
            "azimuth_deg: {from: 10",
            "azimut_deg: {from: 10",
            "line 3: groups.bow: unknown key 'azimut_deg'; the keys are",
        ),
        ("from: 10, to: 80", "from: 10, till: 80", "unknown key 'till'; the keys are from, to, steps"),
        ("demands:", "demand:", "line 5: unknown key 'demand'; the keys are base, groups"),
        ("base: ukwial\n", "", "key 'base' is missing"),
        ("bow:", '"bow\\e[2J":', r"line 2: groups: 'bow\x1b[2J' can't be shown; give names of printable"),
        (
            "from: 10, to: 80",
            "from: 80, to: 10",
            "line 3: groups.bow.azimuth_deg: the span from 80 to 10 is empty",
        ),
        ("[0.5, 1, 2]", "[]", "line 4: groups.stern.size: the list is empty"),
        ("[0.5, 1, 2]", "[0, 1, 2]", "line 4: groups.stern.size: 0 is no size"),
        ("[0.5, 1, 2]", "large", "line 4: groups.stern.size: got text, expected "),
        (
            "thrusters: [0, 1]",
            "thrusters: [0, 1.5]",
            "line 3: groups.bow.thrusters[1]: got a number, expected ",
        ),
        ("base: ukwial", "base: yellow", "line 1: base: no vehicle 'yellow'; there are bluerov2"),
        ("base: ukwial", "base: cross.yaml", "line 1: base: cross has T, but no poses that could vary"),
        ("thrusters: [0, 1]", "thrusters: [0, 7]", "there is no thruster 7; count from 0 to 3"),
        (
            "thrusters: [2, 3]",
            "thrusters: [1, 3]",
            "line 4: groups.stern.thrusters: thruster 1 is named twice",
        ),
        ("thrusters: [0, 1]", "like: 0, thrusters: [0, 1]", "groups.bow: give either"),
        ("thrusters: [0, 1]", "mirror: [xz], thrusters: [0, 1]", "groups.bow: 'mirror' and 'count' make new"),
        (ASKED, "  more: {like: 0, count: 40}", "groups: up to 44 thrusters in 3 degrees of freedom"),
        (ASKED, "demands: {n: 0}", "line 5: demands.n: 0 is out of range"),
        (ASKED, "demands: {n: few}", "line 5: demands.n: got text, expected a whole number; docs/layouts"),
        (ASKED, "demands: {scale: [1, 0, 1]}", "line 5: demands.scale: give one number above 0"),
        (ASKED, "demands: {frame: ned}", "line 5: demands.frame: "),
        (ASKED, "demands: {columns: depth=z}", "demands: columns: 'depth=z': expected DOF=COLUMN"),
        (ASKED, "demands: {frame: flu}", "line 5: demands: frame, columns and scale are of logs"),
        (
            ASKED,
            "demands: {set: ros.csv, frame: flu, scale: [1, 2]}",
            "scale: has 2 factors, expected one, or",
        ),
        (ASKED, "demands: {set: odd.csv}", "'yaw' among fx, fy, c; columns: 'yaw=NAME [Nm]'"),
        (ASKED, "demands: {set: magic}", "line 5: demands.set: no demand set 'magic'"),
        (
            ASKED,
            "dof: [surge, sway, yaw, heave]",
            "base: dof: planar thrusters move surge, sway and yaw only, not heave",
        ),
        (ASKED, "dof: [up]", "dof: give different names out of surge"),
        (ASKED, "sampling: grid", "groups.bow.x: a grid takes 'steps' of a span"),
        (ASKED, "constraints: {box: {x: [1, 0]}}", "constraints.box.x: is empty"),
        (
            ASKED,
            "constraints: {box: {x: [0.5, 0.6]}}",
            "constraints.box.x: none of the first 4,096 layouts is left (box.x 4,096); loosen",
        ),
        (
            ASKED,
            "constraints: {distance: 2}",
            "constraints.distance: none of the first 4,096 layouts is left",
        ),
    ],
)
def test_a_study_that_makes_no_sense_is_refused_with_its_key(
    old: str, new: str, says: str, tmp_path: Path
) -> None:
    assert old in PLANAR
    (tmp_path / "cross.yaml").write_text(GOOD)
    (tmp_path / "ros.csv").write_text(ROS)
    (tmp_path / "odd.csv").write_text("fx,fy,c\n1,2,3\n")
    assert says in refusal(tmp_path, PLANAR.replace(old, new))


def test_a_thruster_that_is_no_image_of_its_leader_is_refused(tmp_path: Path) -> None:
    crooked = find_file("ukwial").read_text(encoding="utf-8").replace("-29, 151", "-35, 151")
    (tmp_path / "crooked.yaml").write_text(crooked, encoding="utf-8")
    message = refusal(tmp_path, PLANAR.replace("base: ukwial", "base: crooked.yaml"))
    assert "groups.bow.thrusters: thruster 1 of the base is no mirror image of thruster 0" in message


@pytest.mark.parametrize("text", [PLANAR, HEAVY])
def test_with_the_base_s_own_numbers_a_layout_is_the_base(text: str, tmp_path: Path) -> None:
    space, base = compiled(tmp_path, text)
    own = {"x": 0, "y": 1, "z": 2, "azimuth_deg": 3, "cant_deg": 4}
    (keys,) = (read_document(find_file(space.name)).keys,)
    values = []
    for parameter in space.parameters:
        group, _, key = parameter.name.partition(".")
        leader = {"bow": 0, "stern": 2, "across": 0, "upright": 4}.get(group)
        values.append(own_number(keys, leader, own[key]) if key in own and leader is not None else 1.0)
        if group == "center_of_mass":
            values[-1] = 0.0
    (one,) = poses(space, np.array(values)[:, None])
    np.testing.assert_allclose(one.layouts(space.dof).T, single_layout(base).T, atol=1e-9)
    np.testing.assert_array_equal(one.f_max[:, 0], base.f_max)


def test_thrusters_of_a_group_keep_their_own_limits_and_weights(tmp_path: Path) -> None:
    uneven = find_file("ukwial").read_text(encoding="utf-8")
    uneven = re.sub(r"^f_min:.*$", "f_min: [-10, -20, -30, -40]", uneven, flags=re.MULTILINE)
    uneven = re.sub(r"^f_max:.*$", "f_max: [50, 60, 70, 80]", uneven, flags=re.MULTILINE)
    (tmp_path / "uneven.yaml").write_text(uneven + "weights: [1, 2, 3, 4]\n", encoding="utf-8")
    text = PLANAR.replace("base: ukwial", "base: uneven.yaml").replace("bow:", "bow: {like: 3}\n  fore:")
    space, _ = compiled(tmp_path, text)
    sizes = [2.0 if parameter.name == "stern.size" else parameter.low for parameter in space.parameters]
    (one,) = poses(space, np.array(sizes)[:, None])
    np.testing.assert_array_equal(one.f_min[:, 0], [-10, -20, -60, -80, -40])
    np.testing.assert_array_equal(one.f_max[:, 0], [50, 60, 140, 160, 80])
    np.testing.assert_array_equal(one.weights[:, 0], [1, 2, 3, 4, 4])


def test_a_reference_length_is_the_base_s_mean_arm_unless_the_study_names_one(tmp_path: Path) -> None:
    """A moment counts as the force that makes it at that arm, in every study and layout alike."""
    space, base = compiled(tmp_path, HEAVY)
    file = read_document(find_file("bluerov2-heavy")).keys
    arms = np.array([thruster.position for thruster in file.thrusters]) - np.array(file.center_of_mass)
    own = np.sqrt((arms**2).sum(axis=1).mean())
    assert space.reference_length == pytest.approx(own)
    asked, _ = compiled(tmp_path, HEAVY + "reference_length: 0.5\n")
    np.testing.assert_array_equal(asked.scale, [1, 1, 1, 0.5, 0.5, 0.5])
    z = zonotope(base)
    for each in (space, asked):
        newtons = z.facets / z.scale * each.scale  # normals of wrenches in newtons
        expected = (z.support / np.linalg.norm(newtons, axis=1)).min()
        columns = numbers(single_layout(base), each.dof, each.taus, each.scale, each.volume)[1]
        np.testing.assert_allclose(columns["any_direction_N"], expected, rtol=1e-9)


def own_number(keys: object, leader: int, place: int) -> float:
    """x, y, z, azimuth or cant of a thruster as the vehicle file has it, planar or not."""
    planar, thrusters = getattr(keys, "planar", None), getattr(keys, "thrusters", None)
    if planar is not None:
        phi = np.radians(planar.phi_deg[leader])
        x, y = planar.d[leader] * np.cos(phi), planar.d[leader] * np.sin(phi)
        return float((x, y, 0.0, planar.alpha_deg[leader], 0.0)[place])
    e = thrusters[leader].direction
    azimuth, cant = np.degrees(np.arctan2(e[1], e[0])), np.degrees(np.arcsin(e[2]))
    return float((*thrusters[leader].position, azimuth, cant)[place])


def test_a_thruster_mounted_the_other_way_round_moves_with_its_leader(tmp_path: Path) -> None:
    """Thruster 1 of this base pushes against the mirror image of thruster 0, and keeps doing so."""
    reversed_ = find_file("ukwial").read_text(encoding="utf-8").replace("[29, -29,", "[29, 151,")
    (tmp_path / "reversed.yaml").write_text(reversed_, encoding="utf-8")
    space, base = compiled(tmp_path, PLANAR.replace("base: ukwial", "base: reversed.yaml"))
    names = [parameter.name for parameter in space.parameters]
    values = np.array(
        [[{"bow.azimuth_deg": 29.0, "stern.azimuth_deg": 151.0}.get(name, 0.3)] for name in names]
    )
    (one,) = poses(space, values)
    np.testing.assert_allclose(one.direction[1, :, 0], -one.direction[0, :, 0] * [1, -1, 1], atol=1e-12)
    np.testing.assert_allclose(one.layouts(space.dof).T[:2, :2, 0], base.T[:2, :2], atol=1e-9)


def test_layouts_that_break_a_constraint_have_no_row_and_are_counted(tmp_path: Path) -> None:
    space, _ = compiled(tmp_path, PLANAR.replace("demands:", "constraints: {box: {x: [-1, 0.25]}}\ndemands:"))
    x = np.linspace(0.1, 0.4, 31)
    values = np.array(
        [x if p.name == "bow.x" else np.full(31, p.at(np.array(0.5))) for p in space.parameters]
    )
    found = measure(space, values)
    assert found.places.tolist() == np.flatnonzero(x <= 0.25).tolist()
    assert found.refused == {"box.x": 31 - len(found.places)}
    assert len(found.columns["authority"]) == len(found.places)


def test_a_group_moves_as_mirror_images_and_may_be_absent_or_more(tmp_path: Path) -> None:
    text = """\
base: ukwial
groups:
  bow: {thrusters: [0, 1], azimuth_deg: [20, 40], present: [true, false]}
  ring: {like: 0, count: [3, 4], x: 0.5, y: 0, azimuth_deg: 90}
  pair: {like: 2, mirror: [xz], size: 2}
sampling: grid
demands: {n: 4}
"""
    space, base = compiled(tmp_path, text)
    assert [p.name for p in space.parameters] == ["bow.azimuth_deg", "bow.present", "ring.count"]
    found = {len(group.position): group for group in poses(space, np.array([[40.0] * 2, [1, 0], [3, 4]]))}
    assert sorted(found) == [2 + 4 + 2, 2 + 3 + 2 + 2]
    whole = found[9]
    bow = whole.direction[:2, :, 0]
    np.testing.assert_allclose(bow[0], [np.cos(np.radians(40)), np.sin(np.radians(40)), 0])
    np.testing.assert_allclose(bow[1], bow[0] * [1, -1, 1])
    np.testing.assert_allclose(whole.position[1, :, 0], whole.position[0, :, 0] * [1, -1, 1])
    ring, pushing = whole.position[4:7, :, 0], whole.direction[4:7, :, 0]
    np.testing.assert_allclose(np.linalg.norm(ring, axis=1), 0.5)
    np.testing.assert_allclose(ring.sum(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.cross(ring, pushing)[:, 2], 0.5)  # each pushes along the circle
    np.testing.assert_allclose(whole.f_max[7:, 0], 2 * base.f_max[2])


@pytest.mark.parametrize("stern", ["stern: {thrusters: [3, 2], size: [1, 2]}", "stern: {thrusters: [2, 3]}"])
def test_thrusters_are_numbered_as_in_the_base_and_new_ones_come_last(stern: str, tmp_path: Path) -> None:
    """The groups of a study may name them in another order, too: worst_thruster is such a number."""
    text = f"""\
base: ukwial
groups:
  extra: {{like: 0, mirror: [xz], present: [false, true], x: 0.5}}
  {stern}
  bow: {{thrusters: [0, 1], present: [true, false]}}
"""
    space, base = compiled(tmp_path, text)
    values = np.array(list(product(*(parameter.choices for parameter in space.parameters)))).T
    for group in poses(space, values):
        for i, at in enumerate(group.which):
            setting = dict(zip((p.name for p in space.parameters), values[:, at], strict=True))
            own = [0, 1, 2, 3] if setting["bow.present"] else [2, 3]
            made = group.layouts(space.dof).T[..., i]
            np.testing.assert_allclose(made[:, : len(own)], base.T[:, own], atol=1e-9)
            assert made.shape[1] == len(own) + 2 * setting["extra.present"]
            size = np.where(np.array(own) < 2, 1, setting.get("stern.size", 1))
            np.testing.assert_allclose(group.f_max[: len(own), i], size * base.f_max[own])


def test_a_layout_s_vehicle_file_makes_the_layout(tmp_path: Path) -> None:
    space, _ = compiled(tmp_path, HEAVY)
    values = np.array([[120.0], [-10.0], [30.0], [75.0], [0.01]])
    row = {p.name: float(v) for p, v in zip(space.parameters, values[:, 0], strict=True)}
    told = {"round": 0, "layout": 7, "authority": 1.0, "authority_after_one": 0.2, "worst_thruster": 3}
    keys = vehicle_file(space, {**row, **told})
    (one,) = poses(space, values)
    np.testing.assert_allclose(build_vehicle(keys).T, one.layouts(space.dof).T[..., 0], atol=1e-15)
    assert keys.name == "bluerov2-heavy-0-7"
    assert keys.notes[2:] == ["Not taken over from bluerov2-heavy: slew, volts, esc, priority."]
    assert not any(getattr(keys, key) for key in ("slew", "volts", "esc", "priority"))


def test_names_that_become_another_thruster_s_number_are_left_out_of_a_layout(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(
        find_file("ukwial").read_text(encoding="utf-8") + "\nnames: [f0, f1, f2, aft]\n", encoding="utf-8"
    )
    text = "base: mine.yaml\ngroups: {first: {thrusters: [f0], present: [false, true]}}\ndemands: {n: 8}\n"
    space, _ = compiled(tmp_path, text)
    told = {"round": 0, "layout": 3, "authority": 1, "authority_after_one": 1, "worst_thruster": 0}
    whole, less = (vehicle_file(space, {**told, "first.present": there}) for there in (1.0, 0.0))
    assert build_vehicle(whole).names == ("f0", "f1", "f2", "aft")
    assert build_vehicle(less).names == ("", "", "aft")
    assert [note for note in (*whole.notes, *less.notes) if "Names" in note] == [
        "Names that are other thrusters' numbers are left out: f1 is thruster 0, f2 is thruster 1."
    ]


def test_a_grid_has_its_own_number(tmp_path: Path) -> None:
    text = PLANAR.replace("to: 80", "to: 80, steps: 3").replace("to: 0.4", "to: 0.4, steps: 4")
    text = text.replace("to: 170", "to: 170, steps: 2") + "sampling: grid\n"
    space, _ = compiled(tmp_path, text)
    document = read_study(tmp_path / "study.yaml")
    assert count_layouts(document, space, None) == 3 * 4 * 2 * 3
    with pytest.raises(AllocError, match="--n 5: a grid has all its 72 layouts"):
        count_layouts(document, space, 5)


def test_layouts_keep_their_base_s_frame_and_thrusters_go_by_name(tmp_path: Path) -> None:
    text = (
        "base: subjugator8\ngroups: {front: {thrusters: [FLV, FRV], x: {from: 0.1, to: 0.2}}}\n"
        "demands: {n: 8}\n"
    )
    space, base = compiled(tmp_path, text)
    assert space.frame == base.frame == "flu"
    told = {"round": 0, "layout": 3, "authority": 1, "authority_after_one": 1, "worst_thruster": 0}
    keys = vehicle_file(space, {**told, "front.x": 0.15})
    assert keys.frame == "flu"
    made = build_vehicle(keys)
    kept = [np.allclose(column, own) for column, own in zip(made.T.T, base.T.T, strict=True)]
    assert kept == [name not in ("FLV", "FRV") for name in base.names]
    assert made.names == base.names
    assert f"the worst failure, of {base.names[0]}." in " ".join(keys.notes)
    assert "no thruster 'FLX'; did you mean" in refusal(tmp_path, text.replace("FLV", "FLX"))


@pytest.mark.parametrize(
    ("keys", "wrench"),
    [
        ("frame: frd", [10, 20, 3]),
        ("frame: flu", [10, -20, -3]),
        ("frame: frd, scale: 2", [20, 40, 6]),
        ("frame: frd, scale: [1, 2, 3]", [10, 40, 9]),
        ("frame: frd, columns: 'surge=force.y,sway=force.x'", [20, 10, 3]),
    ],
)
def test_a_study_s_log_is_read_as_its_keys_say_and_says_how(
    keys: str, wrench: list[float], tmp_path: Path
) -> None:
    (tmp_path / "ros.csv").write_text(ROS)
    text = PLANAR.replace("{n: 16}", "{set: ros.csv, n: 16" + f", {keys}}}")
    space, _ = compiled(tmp_path, text)
    assert space.taus.tolist() == [wrench]
    surge, sway = ("force.y", "force.x") if "columns" in keys else ("force.x", "force.y")
    assert space.notes[0].startswith(f"ros.csv: surge from '{surge}' [N]; sway from '{sway}' [N]; yaw")
    assert "--" not in " ".join(space.notes), "a remedy is a key here, and no option"


@pytest.mark.parametrize(
    ("log", "rate"), [("t,surge,sway,yaw\n0,1,2,3\n0.02,1,2,3\n", 50.0), ("surge,sway,yaw\n1,2,3\n", None)]
)
def test_a_study_knows_the_rate_of_its_log(log: str, rate: float | None, tmp_path: Path) -> None:
    """Its demands.csv had no times: a run on the best layouts judged them at another rate."""
    (tmp_path / "log.csv").write_text(log)
    space, _ = compiled(tmp_path, PLANAR.replace("{n: 16}", "{set: log.csv, n: 16}"))
    assert space.rate_hz == (rate and pytest.approx(rate))


def test_limits_in_a_study_s_log_are_said_to_be_left_out(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("surge,sway,yaw,f0_max\n10,20,3,5\n")
    space, _ = compiled(tmp_path, PLANAR.replace("{n: 16}", "{set: log.csv}"))
    left_out = "log: limits by voltage or of single demands are left out: layouts keep to f_min, f_max"
    assert space.notes[-1] == left_out
    (tmp_path / "log.csv").write_text("surge,sway,heave,roll,pitch,yaw,vbat\n10,20,3,0,0,0,14\n")
    space, _ = compiled(tmp_path, HEAVY.replace("{n: 32}", "{set: log.csv}"))
    assert "columns: 'volts=NAME [V]'" in space.notes[-2], "what this asks for would change nothing here"
    assert space.notes[-1] == left_out


def test_a_study_says_how_much_of_its_log_is_asked(tmp_path: Path) -> None:
    """Shares that layouts served of the first 256 demands were read as shares of the whole log."""
    (tmp_path / "log.csv").write_text("surge,sway,yaw\n" + "10,20,3\n" * 7)
    space, _ = compiled(tmp_path, PLANAR.replace("{n: 16}", "{set: log.csv, n: 5}"))
    assert space.notes[-1] == "Of log's 7 demands only the first 5 were asked; n: asks more."
    space, _ = compiled(tmp_path, PLANAR.replace("{n: 16}", "{set: log.csv, n: 7}"))
    assert not any("asked" in line for line in space.notes)


def test_the_command_says_how_a_log_was_understood(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed", reason="needs the extra layouts")
    pytest.importorskip("pyarrow", reason="needs the extra layouts")
    monkeypatch.setattr(cluster, "CONNECT_S", 0.1)
    (tmp_path / "ros.csv").write_text(ROS)
    compiled(tmp_path, PLANAR.replace("{n: 16}", "{set: ros.csv, frame: flu}"))
    nobody = ("--scheduler", "tcp://127.0.0.1:9")  # it is said before there are workers
    done = CliRunner().invoke(
        command, [str(tmp_path / "study.yaml"), "--out", str(tmp_path / "out"), *nobody]
    )
    assert isinstance(done.exception, cluster.ClusterError)
    (line,) = done.output.splitlines()
    assert line.startswith("ros.csv: surge from 'force.x' [N]; sway from")
    assert "frame flu (frame:), turned" in line
