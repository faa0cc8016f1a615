"""SDF and URDF as Debian's libsdformat reads them: poses, axes and masses of generated files of each version."""
# ruff: noqa: E501 - an XML element stays on its line

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from alloc import AllocError
from bench.inputs.formats import sdf as reader
from bench.inputs.formats import urdf
from bench.inputs.imported import ImportOptions, import_vehicle
from tests.readers import written

pytest.importorskip("defusedxml", reason="needs the extra urdf")
pytest.importorskip("urdf_parser_py", reason="needs the extra urdf")

LONG = pytest.mark.long
VERSIONS = ("1.4", "1.5", "1.6", "1.7", "1.8", "1.9")
PROBE = r"""
#include <iostream>
#include <sdf/Joint.hh>
#include <sdf/JointAxis.hh>
#include <sdf/Link.hh>
#include <sdf/Model.hh>
#include <sdf/Root.hh>
using ignition::math::Pose3d;
using ignition::math::Vector3d;
static void say(const Vector3d &v) { std::cout << ' ' << v.X() << ' ' << v.Y() << ' ' << v.Z(); }
static void show(const sdf::Model &model, const Pose3d &frame) {
  for (uint64_t i = 0; i < model.LinkCount(); i++) {
    Pose3d pose;
    if (!model.LinkByIndex(i)->SemanticPose().Resolve(pose, "__model__").empty()) std::cout << "error\n";
    const auto inertial = model.LinkByIndex(i)->Inertial();
    std::cout << "link " << inertial.MassMatrix().Mass();
    say((frame * pose * inertial.Pose()).Pos());
    std::cout << '\n';
  }
  for (uint64_t i = 0; i < model.JointCount(); i++) {
    const auto *joint = model.JointByIndex(i);
    Pose3d pose;
    Vector3d axis;
    if (!joint->SemanticPose().Resolve(pose, "__model__").empty()) std::cout << "error\n";
    if (!joint->Axis(0) || !joint->Axis(0)->ResolveXyz(axis, "__model__").empty()) continue;
    std::cout << "joint";
    say((frame * pose).Pos());
    say(frame.Rot() * axis);
    std::cout << '\n';
  }
  for (uint64_t i = 0; i < model.ModelCount(); i++) {
    Pose3d pose;
    if (!model.ModelByIndex(i)->SemanticPose().Resolve(pose, "__model__").empty()) std::cout << "error\n";
    show(*model.ModelByIndex(i), frame * pose);
  }
}
int main(int, char **files) {
  std::cout.precision(15);
  while (*++files) {
    sdf::Root root;
    const auto errors = root.Load(*files);
    std::cout << "file " << *files << '\n';
    if (!errors.empty() || !root.Model()) std::cout << "error\n";
    else show(*root.Model(), Pose3d());
  }
}
"""
POSE = "<pose>0.2 0.1 0.3 0.4 0.5 0.6</pose>"
OTHER = '<link name="k"><pose>0 0 1 0 0.3 1</pose></link>'
POD = '<model name="pod"><pose>1 0 0 0 0 1</pose><link name="q"><pose>0 0 1 0 1 0</pose></link>{}</model>'


def sdf(version: str, body: str) -> str:
    base = '<link name="b"><inertial><mass>3</mass></inertial></link>'
    return f'<sdf version="{version}"><model name="m">{base}{body}</model></sdf>'


def thruster(pose: str = POSE, axis: str = "<xyz>1 2 3</xyz>", at: str = "", parent: str = "b") -> str:
    """A link and the joint that carries it."""
    return (
        f'<link name="t">{pose}</link><joint name="thruster" type="continuous"><parent>{parent}</parent>'
        f"<child>t</child>{at}<axis>{axis}</axis></joint>"
    )


def flagged(flag: str, xyz: str = "<xyz>1 2 3</xyz>") -> str:
    return thruster(axis=f"{xyz}<use_parent_model_frame>{flag}</use_parent_model_frame>")


READ = {
    "plain": thruster(),
    "flag": flagged("1"),
    "flag, True": flagged(" True "),
    "flag, tRue": flagged("tRue"),
    "flag, 0": flagged("0"),
    "flag and expressed_in": OTHER + flagged("1", '<xyz expressed_in="k">1 2 3</xyz>'),
    "expressed_in": OTHER + thruster(axis='<xyz expressed_in="k">1 2 3</xyz>'),
    "expressed_in the model": thruster(axis='<xyz expressed_in="__model__">1 2 3</xyz>'),
    "relative_to": OTHER + thruster(POSE.replace("<pose", '<pose relative_to="k"')),
    "frame": OTHER + thruster(POSE.replace("<pose", '<pose frame="k"')),
    "frame and relative_to": OTHER + thruster(POSE.replace("<pose", '<pose frame="k" relative_to="b"')),
    "pose of the joint": OTHER + thruster(at='<pose relative_to="k">0.1 0.2 0.3 0.1 0.2 0.3</pose>'),
    "frame of the joint": OTHER + thruster(at='<pose frame="k">0.1 0.2 0.3 0.1 0.2 0.3</pose>'),
    "frame of a mass": OTHER + '<link name="l"><inertial><pose frame="k">1 2 3 0 0 0</pose></inertial></link>' + thruster(),
    "<frame>": OTHER + '<frame name="f" attached_to="k"><pose>0 1 0 1 0 0</pose></frame>' + thruster(POSE.replace("<pose", '<pose relative_to="f"')),
    "degrees": thruster('<pose degrees=" True ">0.2 0.1 0.3 40 50 60</pose>'),
    "quaternion": thruster('<pose rotation_format="quat_xyzw">0.2 0.1 0.3 0.1 0.2 0.3 0.9</pose>'),
    "mass without inertia": OTHER.replace("</link>", "<inertial><mass>2</mass></inertial></link>") + thruster(),
    "nested": POD.format(thruster(parent="q")),
    "nested, flag": POD.format(flagged("1").replace("<parent>b", "<parent>q")),
    "in a nested frame": POD.format("") + thruster(POSE.replace("<pose", '<pose relative_to="pod::q"')),
    "attached to a nested link": POD.format("") + '<frame name="f" attached_to="pod::q"/>' + thruster(POSE.replace("<pose", '<pose relative_to="f"')),
}  # fmt: skip
"""Bodies that libsdformat and the reader both read."""
REFUSED = {
    "placement_frame": POD.replace('name="pod"', 'name="pod" placement_frame="q"').format("") + thruster(),
    "name twice": OTHER + OTHER + thruster(),
    "name of a joint and a link": OTHER + '<joint name="k" type="fixed"><parent>b</parent><child>k</child></joint>' + thruster(),
    "quaternion in degrees": thruster('<pose rotation_format="quat_xyzw" degrees="1">0 0 0 0 0 0 1</pose>'),
    "quaternion, w first": thruster('<pose rotation_format="quat_wxyz">0 0 0 0 0 0</pose>'),
    "of the world": thruster(POSE.replace("<pose", '<pose relative_to="world"')),
    "no such frame": thruster(axis='<xyz expressed_in="nowhere">1 2 3</xyz><use_parent_model_frame>0</use_parent_model_frame>'),
}  # fmt: skip


@pytest.mark.parametrize("body", REFUSED.values(), ids=REFUSED)
def test_what_is_not_read_as_sdformat_means_it_is_refused_in_one_line(tmp_path: Path, body: str) -> None:
    (tmp_path / "m.sdf").write_text(sdf("1.9", body))
    with pytest.raises(AllocError, match=r"^\S+m\.sdf: [^\n]+$"):
        import_vehicle(tmp_path / "m.sdf", options=ImportOptions(f_min=-1, f_max=1))


@pytest.mark.parametrize("version", ["", "1.0", "2.0", "1.6.1", "1.x"])
def test_a_version_that_says_no_meaning_is_refused(tmp_path: Path, version: str) -> None:
    (tmp_path / "m.sdf").write_text(sdf(version, thruster()))
    with pytest.raises(AllocError, match=rf"<sdf version='{version}'>: expected 1\.2 or later"):
        import_vehicle(tmp_path / "m.sdf")


def test_what_sdf_1_7_ignores_and_adds_is_said(tmp_path: Path) -> None:
    """A propeller that pushed half astern and half down was imported as level."""
    (tmp_path / "m.sdf").write_text(sdf("1.7", flagged("1").replace("<pose>", '<pose frame="b">')))
    notes = import_vehicle(tmp_path / "m.sdf", options=ImportOptions(f_min=-1, f_max=1, dof=("surge",))).notes
    assert "SDF 1.7 knows no use_parent_model_frame: sdformat ignores it, of thruster." in notes
    assert "SDF 1.7 knows no frame= of a pose: sdformat ignores it, of t." in notes
    assert "Links without a mass weigh 1 kg, as in sdformat: t." in notes


@pytest.fixture(scope="module")
def probe(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A program that prints links, joints and masses in the model's frame."""
    if shutil.which("g++") is None or shutil.which("pkg-config") is None:
        pytest.skip("g++ and pkg-config build a program with libsdformat (Debian: libsdformat-dev)")
    flags = subprocess.run(["pkg-config", "--cflags", "--libs", "sdformat12"], capture_output=True, text=True)
    if flags.returncode:
        pytest.skip("libsdformat 12 (Debian: apt install libsdformat-dev) reads SDF")
    folder = tmp_path_factory.mktemp("probe")
    (folder / "probe.cc").write_text(PROBE)
    program = folder / "probe"
    subprocess.run(
        ["g++", "-std=c++17", folder / "probe.cc", "-o", program, *flags.stdout.split()],
        check=True,
        timeout=240,
    )
    return program


def theirs(program: Path, file: Path) -> list[tuple[str, list[float]]]:
    """Lines of the program: ``link`` with mass and centre, ``joint`` with place and axis, or ``error``."""
    run = subprocess.run([program, file], capture_output=True, text=True, check=True, timeout=60)
    words = [line.split() for line in run.stdout.splitlines()[1:]]
    return [(kind, list(map(float, values))) for kind, *values in words]


@LONG
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("body", READ.values(), ids=READ)
def test_each_version_is_read_as_libsdformat_reads_it(
    tmp_path: Path, probe: Path, body: str, version: str
) -> None:
    file = written(tmp_path / "m.sdf", sdf(version, body))
    found = theirs(probe, file)
    assert [kind for kind, _ in found if kind == "error"] == []
    draft = reader.read(file)
    (joint,) = [values for kind, values in found if kind == "joint"]
    assert draft.positions is not None
    assert draft.directions is not None
    assert draft.center_of_mass is not None
    np.testing.assert_allclose(draft.positions, [joint[:3]], rtol=0, atol=1e-12)
    axis = np.divide(joint[3:], np.linalg.norm(joint[3:]))
    np.testing.assert_allclose(draft.directions, [axis], rtol=0, atol=1e-12)
    links = np.array([values for kind, values in found if kind == "link"])
    center = links[:, 0] @ links[:, 1:] / links[:, 0].sum()
    np.testing.assert_allclose(draft.center_of_mass, center, rtol=0, atol=1e-12)


INERTIA = '<inertial><mass value="{}"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'


def link_and_joint(name: str, parent: str, mass: str, kind: str = "continuous") -> str:
    """A link of a URDF and the joint that carries it."""
    inertial = INERTIA.format(mass) if mass else ""
    return (
        f'<link name="{name}">{inertial}</link><joint name="{name}_joint" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{name}"/><origin xyz="0.2 0.1 0"/><axis xyz="1 0 0"/></joint>'
    )


URDF = {
    "mass": link_and_joint("thruster", "base", "0.1"),
    "no inertial": link_and_joint("thruster", "base", ""),
    "no mass": link_and_joint("thruster", "base", "0"),
    "on a bracket without": link_and_joint("bracket", "base", "", "fixed")
    + link_and_joint("thruster", "bracket", "0.1"),
    "on a bracket with": link_and_joint("bracket", "base", "1", "fixed")
    + link_and_joint("thruster", "bracket", "0.1"),
    "with a fixed hub": link_and_joint("thruster", "base", "")
    + link_and_joint("hub", "thruster", "0.1", "fixed"),
    "with a turning hub": link_and_joint("thruster", "base", "") + link_and_joint("hub", "thruster", "0.1"),
}


@LONG
@pytest.mark.parametrize("body", URDF.values(), ids=URDF)
def test_a_thruster_that_sdformat_leaves_out_of_a_urdf_is_said(
    tmp_path: Path, probe: Path, body: str
) -> None:
    file = tmp_path / "m.urdf"
    file.write_text(f'<robot name="r"><link name="base">{INERTIA.format(8)}</link>{body}</robot>')
    notes = urdf.read(file).assumptions
    said = any("gz does not have these thrusters" in note and "thruster_joint" in note for note in notes)
    assert said == (not [kind for kind, _ in theirs(probe, file) if kind == "joint"])
