"""Faults planted in the starters in C++ and Rust are named, and right variants of them are not accused."""

import subprocess
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from alloc import build, load_vehicle
from alloc.allocation import FloatArray
from alloc.c.compiled import missing
from bench.demands import labelled
from bench.harness.conduct import misconduct
from bench.judging.faults import first_wrong
from bench.judging.question import read_promises
from tests.compilers import needs

pytestmark = [pytest.mark.long, pytest.mark.skipif(bool(missing()), reason=missing() or "-")]
FOREIGN = Path(__file__).parents[3] / "alloc" / "foreign"
STARTERS = {"cpp": "cpp/my_allocator.cpp", "rust": "rust/src/lib.rs"}
COMPILERS = {
    "cpp": ("g++", "-std=c++11", "-w", "-shared", "-fPIC", f"-I{FOREIGN}"),
    "rust": ("rustc", "--edition=2021", "--crate-type=cdylib", "-Awarnings"),
}
UNMET, BEYOND, NOT_FINITE, OFF, EARLIER = (
    "SOLVED, but the wrench is not met",
    "a limit is violated",
    "NaN or infinity although",
    "a thrust on a thruster that is off",
    "depends on earlier calls",
)
CPP_SUM = "output.f[i] = std::min(std::max(f, f_min[i]), f_max[i]);"
RUST_SUM = "f[i] = wanted.max(f_min[i]).min(f_max[i]);"
Fragments = Mapping[str, tuple[str, str, str]]
FAULTS: Mapping[str, Fragments] = {
    "cpp": {
        "sign": ("f += G_[i][j]", "f -= G_[i][j]", UNMET),
        "one_axis_less": (
            "j < G_[i].size(); j++) {\n                f +=",
            "j < 2; j++) {\n                f +=",
            UNMET,
        ),
        "never_partial": ("status = TBA_PARTIAL;", "status = TBA_SOLVED;", UNMET),
        "limits_of_the_vehicle": ("input.f_max != nullptr ?", "false ?", BEYOND),
        "no_upper_limit": (CPP_SUM, "output.f[i] = std::max(f, f_min[i]);", BEYOND),
        "not_a_number": (CPP_SUM, f"{CPP_SUM} if (f > 0) output.f[i] = (f - f) / 0 * 0;", NOT_FINITE),
        "one_in_400": (CPP_SUM, f"{CPP_SUM} static int n; if (n++ % 397 == 0) output.f[i] = 0;", EARLIER),
        "stale": (CPP_SUM, f"static tba_real last; {CPP_SUM} std::swap(last, output.f[i]);", EARLIER),
        "remembers": (CPP_SUM, f"static int n; {CPP_SUM} output.f[i] += 1e-9 * (n++ % 13);", EARLIER),
    },
    "rust": {
        "sign": ("let wanted = dot", "let wanted = -dot", UNMET),
        "mirrored": (RUST_SUM, "let n = f.len(); f[n - 1 - i] = wanted.max(f_min[i]).min(f_max[i]);", BEYOND),
        "never_partial": ("status = PARTIAL;", "status = SOLVED;", UNMET),
        "limits_of_the_vehicle": ("limits(input.f_max,", "limits(null(),", BEYOND),
        "no_lower_limit": (RUST_SUM, "f[i] = wanted.min(f_max[i]);", BEYOND),
        "not_a_number": (RUST_SUM, f"{RUST_SUM} if wanted > 0.0 {{ f[i] = f64::NAN; }}", NOT_FINITE),
        "remembers": (
            RUST_SUM,
            f"{RUST_SUM} static N: std::sync::atomic::AtomicUsize = std::sync::atomic::AtomicUsize::new(0);"
            " f[i] += 1e-9 * (N.fetch_add(1, std::sync::atomic::Ordering::Relaxed) % 13) as f64;",
            EARLIER,
        ),
    },
}
RIGHT: Mapping[str, Fragments] = {
    "cpp": {
        "as_it_is": ("TBA_SOLVED", "TBA_SOLVED", ""),
        "written_twice": (CPP_SUM, f"output.f[i] = 0; {CPP_SUM}", ""),
        "allocates": (CPP_SUM, f"delete[] new double[9]; {CPP_SUM}", ""),
        "negated_twice": ("f += G_[i][j]", "f -= -G_[i][j]", ""),
        "scratch": (CPP_SUM, f"static tba_real scratch; scratch = f; {CPP_SUM}", ""),
        "counts_calls": (CPP_SUM, f"static int n; n++; {CPP_SUM}", ""),
        "other_order": (CPP_SUM, "output.f[i] = std::max(std::min(f, f_max[i]), f_min[i]);", ""),
    },
    "rust": {
        "as_it_is": ("SOLVED", "SOLVED", ""),
        "written_twice": (RUST_SUM, f"f[i] = 0.0; {RUST_SUM}", ""),
        "allocates": (RUST_SUM, f"drop(vec![0u8; 99]); {RUST_SUM}", ""),
        "negated_twice": ("let wanted = dot(&self.g[i], tau)", "let wanted = -(-dot(&self.g[i], tau))", ""),
        "collects": (RUST_SUM, f"let n: Vec<f64> = f.to_vec(); drop(n); {RUST_SUM}", ""),
        "clamps": (RUST_SUM, "f[i] = wanted.min(f_max[i]).max(f_min[i]);", ""),
        "sums_backwards": ("a.iter().zip(b).map", "a.iter().zip(b).rev().map", ""),
    },
}


def verdict(library: Path) -> str:
    """Words on what is wrong about a library's answers, with all thrusters and with one off; may be empty."""
    whole = load_vehicle("ukwial")
    said = []
    for vehicle in (whole, whole.with_fault(2)):
        taus, low, high = demands(vehicle.n, vehicle.wrench_scale, vehicle.f_max)
        allocate = build(str(library), vehicle)
        answers = [allocate(*call) for call in zip(taus, low, high, strict=True)]
        said.append(first_wrong(vehicle, taus, low, high, answers, **read_promises(allocate)))
        said += misconduct(
            allocate, [list(taus), list(low), list(high)], answers, labelled("demands", vehicle, taus)
        )
    return "; ".join(filter(None, said))


def demands(n: int, scale: FloatArray, widest: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Small and large demands (N, k), with lower and upper limits (N, n) of their own."""
    rng = np.random.default_rng(5)
    taus = rng.normal(size=(300, len(scale))) * scale * rng.choice([0.05, 1.0], size=(300, 1))
    low, high = (widest * rng.uniform(0.3, 1.0, size=(300, n)) for _ in range(2))
    return taus, -low * (widest > 0), high


@pytest.mark.parametrize("language", STARTERS)
def test_each_planted_fault_is_named_and_no_right_variant_is_accused(language: str, tmp_path: Path) -> None:
    needs(COMPILERS[language][0])
    source = (FOREIGN / "starters" / STARTERS[language]).read_text(encoding="utf-8")
    otherwise = {}
    for name, (old, new, says) in {**FAULTS[language], **RIGHT[language]}.items():
        assert old in source, name
        file = tmp_path / f"{name}{Path(STARTERS[language]).suffix}"
        file.write_text(source.replace(old, new), encoding="utf-8")
        made = tmp_path / f"{name}.so"
        built = subprocess.run(
            [*COMPILERS[language], str(file), "-o", str(made)], capture_output=True, text=True, check=False
        )
        assert built.returncode == 0, built.stderr[-2000:]
        found = verdict(made)
        if says not in found or bool(says) != bool(found):
            otherwise[name] = found
    assert otherwise == {}
