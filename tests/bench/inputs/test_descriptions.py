"""URDF and SDF: trees of our own with matrices that are known, and what is refused."""
# ruff: noqa: E501 - an XML element stays on its line

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from alloc import AllocError, load_vehicle
from alloc.vehicle.geometry import DOF, pose_matrix
from bench.inputs.description import exact_angle
from bench.inputs.imported import ImportOptions, import_vehicle
from tests.foreign_vehicles import imported, vehicle_of
from tests.mutations import damaged

pytest.importorskip("defusedxml", reason="needs the extra urdf")
pytest.importorskip("urdf_parser_py", reason="needs the extra urdf")

LIMITS = ImportOptions(f_min=-29.0, f_max=37.0)
S = float(np.sqrt(0.5))
POSITIONS = np.array(
    [[0.2, 0.1, 0], [0.2, -0.1, 0], [-0.2, 0.1, 0], [-0.2, -0.1, 0], [0, 0.15, 0.05], [0, -0.15, 0.05]]
)
DIRECTIONS = np.array([[S, -S, 0], [S, S, 0], [S, S, 0], [S, -S, 0], [0, 0, 1], [0, 0, 1]])
YAWS = (-45, 45, 45, -45)
CENTER = np.array([0.04, 0.0, -0.02])
"""Six thrusters in flu: four across, two that push up; and their centre of mass."""
T = pose_matrix(POSITIONS, DIRECTIONS, CENTER)


def urdf(name: str = "thruster{i}_joint", extra: str = "") -> str:
    """The six thrusters: the first four hang on a frame that is turned about, the others push along z."""
    parts = [
        '<?xml version="1.0"?><robot name="six"><link name="world"/>',
        '<joint name="fix" type="fixed"><parent link="world"/><child link="base_link"/>'
        '<origin xyz="5 6 7" rpy="0.1 0.2 0.3"/></joint>',
        '<link name="base_link"><visual><geometry><mesh filename="package://no/such.dae"/></geometry></visual>'
        '<inertial><origin xyz="0 0 -0.03"/><mass value="8"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0"'
        ' izz="1"/></inertial></link>',
        '<link name="rack"><inertial><origin xyz="-0.1 0 0.02"/><mass value="2"/><inertia ixx="1" ixy="0" ixz="0"'
        ' iyy="1" iyz="0" izz="1"/></inertial></link>',
        '<joint name="rack_mount" type="fixed"><parent link="base_link"/><child link="rack"/>'
        '<origin xyz="0.1 0 0" rpy="0 0 3.141592653589793"/></joint>',
    ]
    for i, (position, yaw) in enumerate(zip(POSITIONS[:4], YAWS, strict=True)):
        x, y, z = np.diag([-1, -1, 1]) @ (position - [0.1, 0, 0])
        parts.append(
            f'<link name="blade{i}"/><joint name="{name.format(i=i)}" type="continuous"><parent link="rack"/>'
            f'<child link="blade{i}"/><origin xyz="{x} {y} {z}" rpy="0 0 {np.radians(yaw + 180)}"/>'
            '<axis xyz="2 0 0"/></joint>'
        )
    for i, (x, y, z) in enumerate(POSITIONS[4:], 4):
        parts.append(
            f'<link name="blade{i}"/><joint name="{name.format(i=i)}" type="continuous"><parent link="base_link"/>'
            f'<child link="blade{i}"/><origin xyz="{x} {y} {z}" rpy="0 -1.5707963267948966 0"/>'
            '<axis xyz="1 0 0"/></joint>'
        )
    return "".join(parts) + extra + "</robot>"


def plugins(limits: str, joint: str = "thruster{i}_joint") -> str:
    return "".join(
        '<plugin filename="gz-sim-thruster-system" name="gz::sim::systems::Thruster">'
        f"<joint_name>{joint.format(i=i)}</joint_name>{limits}</plugin>"
        for i in range(6)
    )


def sdf(body: str = "", limits: str = "<max_thrust_cmd>37</max_thrust_cmd>") -> str:
    """The same six, with poses that refer to each other in each way that SDF has."""
    parts = [
        '<?xml version="1.0"?><sdf version="1.9"><world name="w"><model name="six"><pose>9 8 7 1 1 1</pose>'
        '<link name="base_link"><pose>0 0 0 1.57 0 0</pose><inertial><pose>0 -0.0300 0 0 0 0</pose><mass>8</mass>'
        "</inertial></link>",
        '<frame name="rack"><pose degrees="true">0.1 0 0 0 0 180</pose></frame>',
        '<link name="ballast"><pose relative_to="rack">-0.1 0 0.02 0 0 0</pose><inertial><mass>2</mass></inertial></link>',
    ]
    for i, (position, yaw) in enumerate(zip(POSITIONS[:4], YAWS, strict=True)):
        x, y, z = np.diag([-1, -1, 1]) @ (position - [0.1, 0, 0])
        parts.append(
            f'<link name="blade{i}"><pose relative_to="rack" degrees="true">{x} {y} {z} 0 0 {yaw + 180}</pose>'
            "<inertial><mass>0</mass></inertial></link>"
            f'<joint name="thruster{i}_joint" type="revolute"><parent>base_link</parent><child>blade{i}</child>'
            "<axis><xyz>1 0 0</xyz></axis></joint>"
        )
    for i, (x, y, z) in enumerate(POSITIONS[4:], 4):
        half = np.sin(np.pi / 4)
        parts.append(
            f'<link name="blade{i}"><pose rotation_format="quat_xyzw">{x} {y} {z}  0 {-half} 0 {half}</pose>'
            "<inertial><mass>0</mass></inertial></link>"
            f'<joint name="thruster{i}_joint" type="revolute"><parent>base_link</parent><child>blade{i}</child>'
            + (
                '<axis><xyz expressed_in="__model__">0 0 3</xyz></axis>'
                if i == 4
                else "<axis><xyz>1 0 0</xyz></axis>"
            )
            + "</joint>"
        )
    return "".join(parts) + plugins(limits) + body + "</model></world></sdf>"


def check(tmp_path: Path, text: str, name: str, options: ImportOptions | None = LIMITS) -> None:
    """The imported vehicle has the six thrusters' matrix."""
    keys = imported(tmp_path, text, options, name)
    vehicle = vehicle_of(keys, tmp_path)
    assert vehicle.frame == "flu"
    rows = [DOF.index(axis) for axis in vehicle.dof]
    np.testing.assert_allclose(vehicle.T, T[rows], rtol=0, atol=1e-14)  # sums of three products
    assert (vehicle.f_min[0], vehicle.f_max[0]) in ((-29, 37), (-37, 37))


def test_a_rounded_right_angle_is_a_right_angle_and_said(tmp_path: Path) -> None:
    """With 1.5708 heave pushed ahead with 4e-6, and after a failure no heave was exactly possible."""
    text = urdf().replace("-1.5707963267948966", "-1.5708").replace("3.141592653589793", "3.14")
    check(tmp_path, text, "six.urdf")
    notes = " ".join(imported(tmp_path, text, LIMITS, "six.urdf").notes)
    assert "Angles of -1.5708, 3.14 rad are taken for the multiples of 15 degrees that they round" in notes
    assert "Angles" not in " ".join(imported(tmp_path, urdf(), LIMITS, "exact.urdf").notes)


@given(st.integers(-48, 48), st.integers(3, 14))
def test_an_angle_is_what_it_rounds_or_cuts_off(steps: int, decimals: int) -> None:
    exact = steps * np.pi / 12
    cut = np.trunc(exact * 10**decimals) / 10**decimals
    for written in (round(exact, decimals), cut):
        assert exact_angle(written) == pytest.approx(exact, rel=1e-15, abs=0)  # a product's last digit


@given(st.floats(-10, 10))
def test_any_other_angle_stays_as_it_is(angle: float) -> None:
    away = abs(angle - round(angle / (np.pi / 12)) * np.pi / 12)
    few = round(angle, 2) == angle  # 1.57 too stands for a right angle, which is 8e-4 off
    assert exact_angle(angle) == angle or away <= (5e-3 if few else 1e-3)


def test_a_urdf_gives_the_matrix_of_its_tree_about_the_centre_of_mass_of_all_links(tmp_path: Path) -> None:
    check(tmp_path, urdf(), "six.urdf")
    keys = imported(tmp_path, urdf(), LIMITS, "six.urdf")
    assert [thruster.name for thruster in keys.thrusters or ()] == [f"thruster{i}" for i in range(6)]
    np.testing.assert_allclose(keys.center_of_mass, CENTER, atol=1e-12)
    notes = " ".join(keys.notes)
    assert "centre of mass is that of all links, 10 kg" in notes
    assert "The frame is that of base_link, flu" in notes


def test_an_sdf_gives_the_same_matrix_by_any_way_of_saying_a_pose(tmp_path: Path) -> None:
    check(tmp_path, sdf(), "six.sdf", None)


def test_a_link_of_an_sdf_that_says_no_mass_weighs_1_kg(tmp_path: Path) -> None:
    """Five propellers of 1 kg on a hull of 11 kg were taken for nothing."""
    bare = sdf().replace("<inertial><mass>0</mass></inertial>", "")
    center = (10 * CENTER + POSITIONS.sum(axis=0)) / 16
    found = imported(tmp_path, bare, None, "six.sdf").center_of_mass
    np.testing.assert_allclose(found, center, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("joint", "names"), [("u1{i}_joint", ()), ("+{i}", tuple(f"thruster +{i}" for i in range(6)))]
)
def test_joints_that_would_be_another_thruster_s_number_make_a_vehicle(
    tmp_path: Path, joint: str, names: tuple[str, ...]
) -> None:
    options = replace(LIMITS, thruster=r"[u+]\d.*")
    keys = imported(tmp_path, urdf(joint), options, name="six.urdf")
    assert vehicle_of(keys, tmp_path).names == names
    assert any("u10 is thruster 0" in note for note in keys.notes) == (not names)


def test_names_are_a_pattern_where_the_usual_ones_are_not_there(tmp_path: Path) -> None:
    text = urdf("prop_{i}")
    with pytest.raises(AllocError, match="names none of fix, base_link, rack_mount"):
        imported(tmp_path, text, LIMITS, "six.urdf")
    options = ImportOptions(f_min=-29.0, f_max=37.0, thruster="prop_.*")
    check(tmp_path, text, "six.urdf", options)
    two = ImportOptions(f_min=-29.0, f_max=37.0, thruster="blade[45]")  # links
    assert len(imported(tmp_path, text, two, "six.urdf").thrusters or ()) == 2
    with pytest.raises(AllocError, match="no pattern"):
        imported(tmp_path, text, ImportOptions(thruster="("), "six.urdf")
    with pytest.raises(AllocError, match="--thruster is for URDF and SDF"):
        imported(tmp_path, "1,0\n0,1\n", ImportOptions(thruster="a", dof=("surge", "sway")), "T.csv")


@pytest.mark.parametrize(
    ("limits", "f_min", "f_max"),
    [
        ("<max_thrust_cmd>37</max_thrust_cmd>", -37, 37),
        ("<max_thrust_cmd>37</max_thrust_cmd><min_thrust_cmd>-21</min_thrust_cmd>", -21, 37),
        # 0.02 x 1000 x 0.1^4 (200 / 2 pi)^2 = 2.0264 N
        (
            "<use_angvel_cmd>true</use_angvel_cmd><thrust_coefficient>0.02</thrust_coefficient>"
            "<fluid_density>1000</fluid_density><propeller_diameter>0.1</propeller_diameter>"
            "<max_thrust_cmd>200</max_thrust_cmd><min_thrust_cmd>-100</min_thrust_cmd>",
            -0.50661,
            2.02642,
        ),
        (
            "<use_angvel_cmd>1</use_angvel_cmd><thrust_coefficient>-0.02</thrust_coefficient>"
            "<fluid_density>1000</fluid_density><propeller_diameter>0.1</propeller_diameter>"
            "<max_thrust_cmd>200</max_thrust_cmd><min_thrust_cmd>-100</min_thrust_cmd>",
            -2.02642,
            0.50661,
        ),
    ],
)
def test_the_thruster_plug_in_gives_the_limits(
    tmp_path: Path, limits: str, f_min: float, f_max: float
) -> None:
    for text, name in (
        (urdf(extra=f"<gazebo>{plugins(limits)}</gazebo>"), "six.urdf"),
        (sdf(limits=limits), "six.sdf"),
    ):
        keys = imported(tmp_path, text, None, name)
        assert keys.f_min == pytest.approx(f_min, rel=1e-5)
        assert keys.f_max == pytest.approx(f_max, rel=1e-5)
        assumed = "It has no min_thrust_cmd: as much astern as ahead is assumed." in keys.notes
        assert assumed == ("min_thrust_cmd" not in limits)


def test_a_nested_model_has_its_own_names(tmp_path: Path) -> None:
    nested = (
        '<model name="pod"><pose>0 0 0.1 0 0 0</pose><link name="blade"><pose>0 0 0.2 0 0 0</pose></link>'
        '<frame name="tilt"><pose relative_to="blade">0 0 0 0 0 1.5707963267948966</pose></frame>'
        '<joint name="prop" type="continuous"><child>blade</child>'
        '<axis><xyz expressed_in="tilt">1 0 0</xyz></axis></joint></model>'
    )
    options = ImportOptions(f_min=-1.5, f_max=1.7, thruster="pod::prop", dof=("sway",))
    (thruster,) = imported(tmp_path, sdf(nested), options, "six.sdf").thrusters or ()
    assert thruster.position == pytest.approx((0, 0, 0.3))
    assert thruster.direction == pytest.approx((0, 1, 0), abs=1e-12)


def test_the_vehicle_of_a_world_is_the_model_that_has_thrusters(tmp_path: Path) -> None:
    """The first model was taken, which in most worlds is the ground."""
    ground = '<model name="ground"><static>true</static><link name="floor"/></model>'
    hatch = ground.replace(
        "</model>", '<joint name="hatch" type="fixed"><child>floor</child></joint></model>'
    )
    ship = ground.replace("ground", "ship").replace(
        "</model>", '<joint name="propeller" type="revolute"><child>floor</child></joint></model>'
    )  # no plug-in drives it: scenery
    for others in (ground, hatch, ship):
        check(tmp_path, sdf().replace("<model ", f"{others}<model ", 1), "six.sdf", None)
    second = sdf().partition('<world name="w">')[2].replace("</world></sdf>", "").replace('"six"', '"seven"')
    with pytest.raises(AllocError, match=r"six\.sdf: models six, seven have thrusters; keep one of them in"):
        imported(tmp_path, sdf().replace("</world>", f"{second}</world>"), None, "six.sdf")


@pytest.mark.parametrize(
    ("version", "flag", "along"),
    [
        ("1.4", "", (1, 0, 0)),
        ("1.5", "", (0, 1, 0)),
        ("1.6", "<use_parent_model_frame>1</use_parent_model_frame>", (1, 0, 0)),
        ("1.6", "<use_parent_model_frame>true</use_parent_model_frame>", (1, 0, 0)),
        ("1.6", "<use_parent_model_frame>0</use_parent_model_frame>", (0, 1, 0)),
        ("1.4", "<use_parent_model_frame>0</use_parent_model_frame>", (0, 1, 0)),
        ("1.7", "<use_parent_model_frame>1</use_parent_model_frame>", (0, 1, 0)),
        ("1.9", "<use_parent_model_frame>1</use_parent_model_frame>", (0, 1, 0)),
        ("1.10", "", (0, 1, 0)),
    ],
)
def test_an_axis_is_in_the_frame_that_the_format_s_version_and_its_flag_say(
    tmp_path: Path, version: str, flag: str, along: tuple[float, ...]
) -> None:
    """Thrusts ahead became thrusts to the side: the flag was not read, nor that old formats need none."""
    text = (
        f'<sdf version="{version}"><model name="m"><link name="b"/>'
        '<link name="t"><pose>0 0.2 0 0 0 1.5707963267948966</pose></link>'
        '<joint name="thruster" type="revolute"><parent>b</parent><child>t</child>'
        f"<axis><xyz>1 0 0</xyz>{flag}</axis></joint></model></sdf>"
    )
    options = ImportOptions(f_min=-1.5, f_max=1.7, dof=("surge",) if along[0] else ("sway",))
    (thruster,) = imported(tmp_path, text, options, "old.sdf").thrusters or ()
    assert thruster.direction == pytest.approx(along, abs=1e-12)


def test_a_pose_of_format_1_6_is_in_the_frame_it_names(tmp_path: Path) -> None:
    """It was taken from the model, and the thruster stood in another place."""
    text = sdf().replace('version="1.9"', 'version="1.6"').replace("relative_to=", "frame=")
    check(tmp_path, text, "six.sdf", None)
    with pytest.raises(AllocError, match="frame 'rick' is named but not there"):
        imported(tmp_path, text.replace('frame="rack"', 'frame="rick"'), None, "six.sdf")


BOMB = (
    '<!DOCTYPE lolz [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;&a;">]><robot name="&b;"><link name="l"/></robot>'
)
OUTSIDE = '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="r"><link name="&x;"/></robot>'


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("r.urdf", BOMB, "take out <!DOCTYPE> and entities"),
        ("r.urdf", OUTSIDE, "take out <!DOCTYPE> and entities"),
        ("r.sdf", OUTSIDE.replace("robot", "sdf"), "take out <!DOCTYPE> and entities"),
        ("r.urdf", "<robot name='r'><link", "line 1: not XML"),
        ("r.urdf", "<robot>" + "<a>" * 200 + "</a>" * 200 + "</robot>", "nested deeper"),
        ("r.urdf", "<robot name='r'/>", "holds no link"),
        (
            "r.urdf.xacro",
            "<robot name='r' xmlns:xacro='http://ros.org/wiki/xacro'><xacro:include filename='a'/></robot>",
            "r.urdf.xacro > r.urdf",
        ),
        ("r.urdf", "<robot name='r'><link name='${name}'/></robot>", "r.urdf > r-expanded.urdf"),
        (
            "r.urdf",
            urdf().replace('parent link="rack"', 'parent link="rick"'),
            "names link 'rick', which is not there",
        ),
        ("r.urdf", urdf().replace('child link="blade1"', 'child link="blade0"'), "hangs on two joints"),
        ("r.urdf", urdf().replace('xyz="2 0 0"', 'xyz="0 0 0"'), "has no direction"),
        ("r.urdf", urdf().replace('xyz="2 0 0"', 'xyz="a b c"'), "not a URDF that ROS's parser reads"),
        ("r.urdf", urdf(), "no limits in it; give --f-min and --f-max"),
        (
            "r.urdf",
            urdf(extra=f"<gazebo>{plugins('', 'x{i}')}</gazebo>"),
            "names joint 'x0', which is not there",
        ),
        ("r.sdf", "<sdf/>", "holds no <model>"),
        (
            "r.sdf",
            sdf().replace('relative_to="rack"', 'relative_to="rick"'),
            "frame 'rick' is named but not there",
        ),
        (
            "r.sdf",
            sdf().replace('name="rack"><pose', 'name="rack"><pose relative_to="rack"'),
            "refers to itself",
        ),
        (
            "r.sdf",
            sdf(limits="<max_thrust_cmd>much</max_thrust_cmd>"),
            "max_thrust_cmd: got 'much', expected 1 finite numbers",
        ),
        ("r.sdf", sdf().replace("<xyz>1 0 0</xyz>", "<xyz>0 0 0</xyz>"), "has no direction; give x y z"),
        ("r.sdf", sdf().replace("1.57 0 0</pose>", "1.57</pose>"), "pose of base_link: got"),
        ("r.sdf", sdf().replace("<mass>8", "<mass>nan"), "mass of base_link: got 'nan'"),
    ],
)
def test_what_is_no_description_is_refused_in_one_line_that_names_file_and_place(
    tmp_path: Path, name: str, text: str, says: str
) -> None:
    with pytest.raises(AllocError) as refused:
        imported(tmp_path, text, None, name)
    message = str(refused.value)
    assert says in message
    assert str(tmp_path) in message
    assert "\n" not in message


def test_what_is_included_is_not_fetched_but_said(tmp_path: Path) -> None:
    text = sdf("<include><uri>https://fuel.example/models/arm</uri></include>")
    assert any(
        "https://fuel.example/models/arm" in note for note in imported(tmp_path, text, None, "six.sdf").notes
    )


@pytest.mark.parametrize("name", ["six.urdf", "six.sdf"])
def test_a_damaged_description_is_read_or_refused_in_one_line(tmp_path: Path, name: str) -> None:
    rng = np.random.default_rng(11)
    limits = "<max_thrust_cmd>37</max_thrust_cmd>"
    good = sdf() if name.endswith("sdf") else urdf(extra=f"<gazebo>{plugins(limits)}</gazebo>")
    messages = []
    for _ in range(150):
        (tmp_path / name).write_bytes(damaged(good.encode(), rng))
        try:
            import_vehicle(tmp_path / name)
        except AllocError as error:
            messages.append(str(error))
    assert len(messages) > 50
    assert [message for message in messages if "\n" in message or str(tmp_path) not in message] == []


def test_the_published_joints_of_a_bluerov2_give_the_shipped_vehicle(tmp_path: Path) -> None:
    """Poses and axes of CentraleNantesROV/bluerov2 @bce97d6, bluerov2_description/urdf/thrusters.xacro."""
    joints = (
        ("0.1355 -0.1 -0.0725", (0, 0, 45), 1),
        ("0.1355 0.1 -0.0725", (0, 0, -45), 1),
        ("-0.1475 -0.1 -0.0725", (0, 0, 135), -1),
        ("-0.1475 0.1 -0.0725", (0, 0, -135), -1),
        ("0.0025 -0.1105 -0.005", (0, -90, 0), 1),
        ("0.0025 0.1105 -0.005", (0, -90, 0), -1),
    )
    text = "<robot name='bluerov2'><link name='base_link'/>" + "".join(
        f"<link name='thruster{i}'/><joint name='thr{i}' type='continuous'><parent link='base_link'/>"
        f"<child link='thruster{i}'/><origin xyz='{xyz}' rpy='{' '.join(map(str, np.radians(rpy)))}'/>"
        f"<axis xyz='{sign} 0 0'/></joint>"
        for i, (xyz, rpy, sign) in enumerate(joints)
    )
    limits = ImportOptions(f_min=-40, f_max=40)
    vehicle = vehicle_of(imported(tmp_path, text + "</robot>", limits, "bluerov2.urdf"), tmp_path)
    shipped = load_vehicle("bluerov2")
    assert (vehicle.frame, vehicle.dof) == (shipped.frame, shipped.dof)
    np.testing.assert_allclose(vehicle.T, shipped.T, rtol=0, atol=1e-9)
