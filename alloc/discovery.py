"""The catalogue: all methods, what is missing to build some of them, and ``build`` by name."""

import re
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache, partial
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from alloc.allocation import Allocator, FloatArray
from alloc.errors import NotApplicable, NotInstalled, PluginError, UnknownName, unknown
from alloc.files.modules import check_for, modules, names
from alloc.files.modules import module as named_module
from alloc.foreign import COMMAND, is_command, is_compiled, runs_apart
from alloc.formulations import Family, find_formulation, nearly
from alloc.live.azimuths import AzimuthAllocator
from alloc.live.plain import ANY_DISTANCE, EXACT, Plain, check_declared
from alloc.vehicle import Vehicle
from alloc.vehicle.azimuth import refuse_azimuths

if TYPE_CHECKING:  # What makes C is a third of all modules, and most programs make none.
    from alloc.c import Package
    from alloc.methods import Variant
    from alloc.program import Faults, Scalar, Where


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One method as the catalogue shows it.

    Attributes
    ----------
    name : e.g. ``pinv``, ``qp/osqp``, ``nullspace@native``; ``find`` alone reads its parts
    formulation : name of the formulation whose right answer the method gives
    family : kind of method; reports show a family together
    solver : the QP solver that the method calls, empty for none
    foreign : whether calls run code that is not Python's: a solver's binding, or compiled C
    twin : for generated C, the method in Python whose answers it must give; empty for others
    starts, levels : what ``build`` takes as ``start=`` and ``level=``; ("-",) where there is no choice
    azimuths : whether the method takes vehicles with thrusters that turn
    summary : one line on what the method does
    named_only : whether a run leaves it out unless it is named
    missing : empty where the method can be built, else how to get what it needs
    prepare : function (vehicle, start=…, level=…) that returns the allocator: ``build`` of the module
    idle_call : function (vehicle) that returns a function which does nothing and is called as the allocator
        of somebody's library or program is; None for all else
    """

    name: str
    formulation: str = ""
    family: Family = Family.PRACTICE
    solver: str = ""
    foreign: bool = False
    twin: str = ""
    starts: tuple[str, ...] = ("-",)
    levels: tuple[str, ...] = ("-",)
    azimuths: bool = False
    summary: str = ""
    named_only: bool = False
    missing: str = ""
    prepare: Callable[..., Allocator]
    idle_call: Callable[[Vehicle], Callable[..., object]] | None = None


@cache
def catalogue() -> tuple[Entry, ...]:
    """All methods that the modules of ``alloc.methods`` offer, sorted by name; imports no solver."""
    entries = (entry for module in modules("alloc.methods").values() for entry in _entries(module))
    return tuple(sorted(entries, key=lambda entry: entry.name))


def build(name: str, vehicle: Vehicle, *, start: str = "", level: str = "") -> Allocator:
    """Prepare the method of that name, or in that file, for one vehicle.

    ``start`` (cold, reused, warm) and ``level`` (default, tight) choose among what the method's
    Entry offers; left empty, the method's own choice holds. Raises UnknownName, NotInstalled (with
    the remedy), or NotApplicable where the method does not cover the vehicle.
    """
    return prepare(find(name), vehicle, start=start, level=level)


def prepare(entry: Entry, vehicle: Vehicle, *, start: str = "", level: str = "") -> Allocator:
    """Prepare the method of an Entry, from the catalogue or a plug-in; raises as ``build`` does."""
    if entry.missing:
        raise NotInstalled(f"{entry.name}: {entry.missing}")
    if not entry.azimuths:
        refuse_azimuths(vehicle.azimuths, entry.name, "it knows thrusters along a line")
    options: dict[str, Any] = {}
    for key, value, offered in (("start", start, entry.starts), ("level", level, entry.levels)):
        if value and value != "-":
            if value not in offered:
                raise UnknownName(f"{entry.name} has no {key} '{value}'; it has {', '.join(offered)}")
            options[key] = value
    if not vehicle.azimuths:
        return entry.prepare(vehicle, **options)
    try:
        compiled = entry.name if entry.twin else ""
        return AzimuthAllocator(partial(entry.prepare, **options), vehicle, compiled)
    except NotApplicable as error:
        if place := vehicle.azimuths[0].place:
            raise NotApplicable(f"{place}: {error}") from error
        raise


def find(name: str) -> Entry:
    """The catalogue's entry of that name, else the user's method of that name; raises UnknownName.

    The file that a name points to is asked first, so that no other is imported for most names.
    """

    def named(entries: Iterable[Entry]) -> Entry | None:
        return next((entry for entry in entries if entry.name == name), None)

    if entry := named(entries_at(name)) or named(catalogue()):
        return entry
    if is_plugin(name):
        return load_plugin(name)
    raise unknown_method(name, (entry.name for entry in catalogue()))


def unknown_method(name: str, known: Iterable[str]) -> UnknownName:
    """The error for a method's name that is none of the known ones, nor a file."""
    if Path(name).is_dir():
        return UnknownName(f"{name}: is a folder, no method; name a library, a program or a Python file")
    return unknown("method", name, known)


def generate(
    vehicle: Vehicle,
    method: str,
    *,
    scalar: "Scalar" = "double",
    limits: "Where" = "fixed",
    faults: "Faults | bool" = "one",
    esc: bool = False,
    monitor: FloatArray | None = None,
    lasting: float | None = None,
    cap: bool = False,
    package: "Package | None" = None,
    maintainer: str = "",
) -> dict[str, str]:
    """The C99 of a method for one vehicle, as ``thrustbench codegen`` writes it: {file name: text}.

    Header, source, a self-test, and a page on how to call it.

    Parameters
    ----------
    vehicle : whose numbers stand in the C
    method : a method that can be C, by its own name or its name in the catalogue: ``scaled`` is
        ``scaled@native``
    scalar : ``double`` or ``float``, the type of all numbers
    limits : ``fixed`` where the C holds the vehicle's own, ``call`` where f_min and f_max are arguments
    faults : ``none``, or any ``one`` thruster off, in code for each, or ``all`` these in one function and a
        table, which takes less flash; False and True are ``none`` and ``one``
    esc : whether there is also the way to the commands of the ESCs, ``<name>_esc.c``
    monitor : (k,) noise of a measured wrench [N, N m], for a function that accuses thrusters,
        ``<name>_monitor.c``; None for none
    lasting : calls after which that noise has 1 / e of itself left; None for those of half a second at 50 Hz
    cap : whether there is also the same under a cap on current, ``<name>_cap.c``
    package : the build system whose package it shall be, ``cmake``, ``ros2``, ``platformio``, ``arduino`` or
        ``zephyr``: then all lies in a folder with the function's name
    maintainer : ``NAME <MAIL>`` for ROS 2's package.xml, which has a placeholder without

    Raises UnknownName for a method that can't be C, NotApplicable where it does not cover the vehicle,
    VehicleError where it has no ESCs, or no currents, and these are asked for.
    """
    from alloc import c
    from alloc.methods import recipe

    known: Faults = faults if isinstance(faults, str) else "one" if faults else "none"
    target = c.Target(
        vehicle=vehicle, method=recipe(_in_c(method)), scalar=scalar, limits=limits, faults=known
    )
    files = c.generate(target)
    if esc:
        files |= c.to_escs(target) | {f"test/{target.name}_esc_test.c": c.esc_selftest(target)}
    if monitor is not None:
        known_noise = monitor, c.LASTING if lasting is None else lasting
        files |= c.monitor(target, *known_noise)
        files |= {f"test/{target.name}_monitor_test.c": c.monitor_selftest(target, *known_noise)}
    if cap:
        files |= c.capped(target, package) | {f"test/{target.name}_cap_test.c": c.cap_selftest(target)}
    # Several functions may share a folder.
    files |= {f"{target.name}.md": c.page(target, esc=esc, monitor=monitor is not None, cap=cap)}
    about = f"Thrust allocation for {c.in_comment(vehicle.name)} by {target.method.name}"
    return c.packaged(package, target.name, files, about, maintainer) if package else files


def _in_c(method: str) -> str:
    """The method whose program a method is: ``scaled`` of ``scaled@native``, and of itself."""
    return next((entry.twin for entry in catalogue() if entry.name == method and entry.twin), method)


def is_plugin(name: str) -> bool:
    """True if a method's name is a user's file or command, and none of the catalogue."""
    return is_command(name) or Path(name).is_file()


def load_plugin(name: Path | str) -> Entry:
    """The method in a file, named after it, or behind a command.

    The file is Python, a shared library with ``alloc.foreign``'s C interface, or a program with its line
    protocol, which a command, ``exec:COMMAND``, speaks too. ``alloc.methods`` says what a Python file may
    hold. Its ``build`` returns an allocator, or a plain function tau -> f, whose status ``alloc.live.plain``
    works out.
    Raises PluginError where the file can't be loaded, has no ``build``, or declares what there is not.
    """
    path = Path(name)
    module, loaded = _foreign(name), set[str]()
    if module is None:
        module, loaded = _imported(path)
    check_declared(path, module)
    _refuse_method(path, getattr(module, "FORMULATION", None) or "")
    if hasattr(module, "variants"):
        raise PluginError(
            f"{path}: has variants(), which files in alloc/methods may; give each method a file"
        )
    used = {value.__name__ for value in vars(module).values() if isinstance(value, ModuleType)}
    if shadowed := _shadowed(path, used | loaded):
        raise PluginError(f"{path}: {shadowed}; rename the file beside the plug-in, or uninstall the other")
    entry = _entry(plugin_name(name), module)
    return replace(entry, prepare=partial(_built, path, module))


def _foreign(name: Path | str) -> ModuleType | None:
    """A command, a program or a shared library as a module; None for any other file."""
    path = Path(name)
    if runs_apart(name):
        from alloc.foreign import program

        return program.plugin(str(name), program.words(name))
    if not is_compiled(path):
        return None
    from alloc.foreign.bind import plugin  # with all that makes C

    return plugin(path, _own_rule(plugin_name(path)))


def _imported(path: Path) -> tuple[ModuleType, set[str]]:
    """A Python file as a module, and the names of the packages that it imported; raises PluginError."""
    spec = spec_from_file_location(f"thrustbench_plugin_{path.stem}", path)
    if spec is None or spec.loader is None or not path.is_file():
        raise PluginError(
            f"{path}: is neither a Python file with build(vehicle) in it nor a library with a C interface"
        )
    if (folder := str(path.resolve().parent)) not in sys.path:
        sys.path.append(folder)  # for modules beside it; last, so that none takes another's place
    known = set(sys.modules)
    try:
        module = module_from_spec(spec)
        sys.modules[spec.name] = module  # dataclasses and pickle look up the module of a class here
        spec.loader.exec_module(module)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # SystemExit too: a file that calls sys.exit must not end this process
        sys.modules.pop(spec.name, None)
        remedy = "mend it"
        if isinstance(error, ImportError):
            remedy += ", or put the folder of that module on sys.path in it"
        raise PluginError(f"{path}: can't be imported ({type(error).__name__}: {error}); {remedy}") from error
    return module, {name.partition(".")[0] for name in set(sys.modules) - known} - sys.stdlib_module_names


def _refuse_method(path: Path, formulation: str) -> None:
    """Raise PluginError where a file declares a method in place of a formulation, as ``nullspace``.

    Taken for a rule of its own, the plug-in would be held to no optimum.
    """
    for entry in catalogue():
        if entry.name == formulation and entry.formulation != formulation:
            raise PluginError(
                f"{path}: {formulation!r} is a method, whose formulation is {entry.formulation!r};"
                " write that, or give a rule of your own another name"
            )


def _shadowed(path: Path, names: Iterable[str]) -> str:
    """In words, a module that a plug-in uses in place of the file of that name beside it; empty for none.

    The plug-in's folder is searched last, where a script's is first; this package is the one that runs.
    """
    for top in sorted({name.partition(".")[0] for name in names} - {"alloc"}):
        beside = [path.parent / f"{top}.py", path.parent / top / "__init__.py"]
        used = getattr(sys.modules.get(top), "__file__", None)
        if used is None or not any(file.is_file() for file in beside):
            continue
        if not any(file.is_file() and file.samefile(used) for file in beside):
            return f"'{top}' came from {used}, and not from the file beside it"
    return ""


PROMISES = ("formulation", "limited", "tolerance")
"""Promises of an allocator, to which its answers are held."""


def _built(path: Path, module: ModuleType, vehicle: Vehicle, **options: Any) -> Allocator:
    """Allocator from a plug-in's build; raises PluginError if build returned anything else."""
    made = module.build(vehicle, **options)
    if not callable(made):
        raise PluginError(
            f"{path}: build(vehicle) gave {type(made).__name__}; return a function tau -> f, or an allocator"
        )
    lacking = [promise for promise in PROMISES if not hasattr(made, promise)]
    if not lacking:
        allocator: Allocator = made
        return allocator
    if len(lacking) < len(PROMISES):  # taken for a plain function, it would be held to nothing that it says
        raise PluginError(f"{path}: what build(vehicle) gave has no {' and no '.join(lacking)}; add it")
    declared = getattr(module, "FORMULATION", "")
    return Plain(
        made,
        vehicle,
        declared or _own_rule(plugin_name(path)),
        getattr(module, "LIMITED", bool(declared) and find_formulation(declared).limited),
        float(getattr(module, "TOLERANCE", EXACT if declared else ANY_DISTANCE)),
    )


def _own_rule(name: str) -> str:
    """Formulation of a file that declares none: the file's name, unless a formulation's name is close to it.

    A file ``scale`` is held to no optimum, and misspells no ``scaled`` either.
    """
    return f"own-{name}" if nearly(name) else name


def entries_at(name: str) -> Iterator[Entry]:
    """Entries of the file that holds a method of such a name: ``clip``, ``qp/daqp``, ``clip@native``."""
    stem, _, suffix = name.partition("@")
    file = suffix or stem.partition("/")[0]
    if file in names("alloc.methods"):
        yield from _entries(named_module("alloc.methods", file))


def _entries(module: ModuleType) -> Iterator[Entry]:
    check_for(module, "build")
    if hasattr(module, "variants"):
        for name, variant in module.variants().items():
            yield _entry(name, module, variant)
    else:
        check_for(module, "FORMULATION")
        yield _entry(_hyphened(module.__name__.rpartition(".")[2]), module)


def plugin_name(name: Path | str) -> str:
    """The name of a user's method: a_b.py holds a-b, and ``exec:ssh host ./mine`` is ssh-host-mine."""
    if is_command(name):
        return "-".join(re.findall(r"[\w@][\w.@]*", str(name).removeprefix(COMMAND)))
    return _hyphened(Path(name).stem)


def _hyphened(file: str) -> str:
    return file.replace("_", "-")


def _entry(name: str, module: ModuleType, variant: "Variant | None" = None) -> Entry:
    formulation: str = getattr(module, "FORMULATION", "")
    if variant and variant.formulation:
        formulation = variant.formulation
    summary = next(iter((module.__doc__ or "").strip().splitlines()), "")
    return Entry(
        name=name,
        formulation=formulation,
        family=getattr(module, "FAMILY", find_formulation(formulation).family),
        solver=variant.solver if variant else "",
        foreign=getattr(module, "FOREIGN", False),
        twin=variant.twin if variant else "",
        starts=variant.starts if variant else tuple(getattr(module, "STARTS", ("-",))),
        levels=variant.levels if variant else tuple(getattr(module, "LEVELS", ("-",))),
        summary=variant.summary if variant else getattr(module, "SUMMARY", summary),
        azimuths=variant.azimuths
        if variant and variant.azimuths is not None
        else getattr(module, "AZIMUTHS", False),
        named_only=variant.named_only if variant else getattr(module, "NAMED_ONLY", False),
        missing=variant.missing if variant else "",
        prepare=partial(module.build, variant.key) if variant else module.build,
        idle_call=getattr(module, "idle_call", None),
    )
